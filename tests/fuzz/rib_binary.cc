// SPDX-License-Identifier: Apache-2.0
// Binary RIB behind a head that defines a code for every request and for the usual strings, so that most
// bytes mean something.
#include "rib/binary_codes.h"
#include "rib/requests.h"
#include "tests/fuzz/round_trip.h"

namespace {

std::string head() {
  using namespace patina::binary_code;
  std::string text;
  const auto string = [&](std::string_view s) {
    text += static_cast<char>(kString);
    text += static_cast<char>(s.size());
    text += s;
  };
  int code = 0;
  for (const patina::RibRequest& request : patina::ribRequests()) {
    text += static_cast<char>(kDefineRequest);
    text += static_cast<char>(code++);
    string(request.name);
  }
  code = 0;
  for (const char* s : {"P",
                        "st",
                        "N",
                        "Cs",
                        "Os",
                        "constantwidth",
                        "bilinear",
                        "bicubic",
                        "nonperiodic",
                        "periodic",
                        "catmull-clark",
                        "linear",
                        "cubic",
                        "bezier",
                        "b-spline",
                        "uniform float x",
                        "facevarying color[2] y",
                        "string z",
                        "int i",
                        "reference color c",
                        "crease",
                        "hole",
                        "a.rib",
                        "plastic"}) {
    text += static_cast<char>(kDefineString);
    text += static_cast<char>(code++);
    string(s);
  }
  return text;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const std::string kHead = head();
  patina::fuzz::roundTrip(kHead + std::string(reinterpret_cast<const char*>(data), size));
  return 0;
}
