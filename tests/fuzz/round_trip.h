// SPDX-License-Identifier: Apache-2.0
// What must hold of any input: it is read without harm, and what was understood of it can be written and read
// again.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include "rib/parser.h"
#include "rib/writer.h"

namespace patina::fuzz {

struct Written {
  std::string text;
  uint64_t errors = 0;
};

inline Written rewrite(std::string_view rib, RibEncoding encoding) {
  Written written;
  // Blocks that the file leaves open are left open by what is written: all other errors must be gone.
  ErrorHandler errors(
      [&](Severity severity, std::string_view message) {
        written.errors +=
            severity >= Severity::Error && message.find(": nesting: ") == std::string_view::npos;
      },
      {.repeat = 1000});
  errors.setShowLines(true);
  {
    RibWriter writer(
        [&](std::string_view piece) {
          written.text += piece;
          return true;
        },
        {.encoding = encoding});
    ParserLimits limits;
    limits.inputBytes = limits.inflateFreely = uint64_t{1} << 22;
    RibParser parser(writer, errors, limits);
    parser.parseMemory(rib, "fuzz");
  }
  return written;
}

inline void check(bool holds, const char* what, std::string_view a, std::string_view b) {
  if (holds) return;
  std::fprintf(stderr, "%s\n--- first\n%.*s\n--- second\n%.*s\n", what, static_cast<int>(a.size()), a.data(),
               static_cast<int>(b.size()), b.data());
  std::abort();
}

inline void roundTrip(std::string_view rib) {
  const Written first = rewrite(rib, RibEncoding::Ascii);
  const Written again = rewrite(first.text, RibEncoding::Ascii);
  check(again.errors == 0, "what was written has errors", first.text, again.text);
  check(again.text == first.text, "the text is not the same when it is read again", first.text, again.text);
  const Written binary = rewrite(first.text, RibEncoding::Binary);
  const Written back = rewrite(binary.text, RibEncoding::Ascii);
  check(back.errors == 0, "binary RIB has errors", first.text, back.text);
  check(back.text == first.text, "the text is not the same through binary", first.text, back.text);
}

}  // namespace patina::fuzz
