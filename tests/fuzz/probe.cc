// SPDX-License-Identifier: Apache-2.0
// Asks whether the compiler has libFuzzer.
#include <cstddef>
#include <cstdint>
extern "C" int LLVMFuzzerTestOneInput(const uint8_t*, size_t) { return 0; }
