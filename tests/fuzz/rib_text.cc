// SPDX-License-Identifier: Apache-2.0
// Any bytes as a RIB file: ASCII, binary, gzip.
#include "tests/fuzz/round_trip.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  patina::fuzz::roundTrip({reinterpret_cast<const char*>(data), size});
  return 0;
}
