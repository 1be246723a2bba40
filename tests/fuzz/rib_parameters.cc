// SPDX-License-Identifier: Apache-2.0
// Parameter lists: the input up to the first line end is a declaration; the rest are the parameters of
// requests.
#include "rib/params.h"
#include "tests/fuzz/round_trip.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace patina;
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  const size_t end = std::min(input.find('\n'), input.size());
  const std::string_view first = input.substr(0, end), rest = input.substr(std::min(end + 1, input.size()));
  // What a declaration is written as means the same.
  if (const auto declaration = parseDeclaration(first)) {
    const std::string text = toString(*declaration);
    const auto again = parseDeclaration(text);
    fuzz::check(again && toString(*again) == text, "a declaration changes when it is written", first, text);
  }
  std::string rib = "Declare \"name\" \"";
  for (const char c : first)
    if (c != '"' && c != '\\') rib += c;
  rib += "\"\nSurface \"plastic\" \"name\" [1 2 3] ";
  rib += rest;
  rib += "\nPolygon \"P\" [0 0 0 1 0 0 1 1 0] ";
  rib += rest;
  fuzz::roundTrip(rib);
  return 0;
}
