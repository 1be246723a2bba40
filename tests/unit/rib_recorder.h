// SPDX-License-Identifier: Apache-2.0
// A RibHandler that writes each request down as one line of text, for tests to compare.
#pragma once

#include <string>
#include <vector>

#include <fmt/format.h>

#include "rib/every_request.h"
#include "rib/parser.h"

namespace patina::test {

inline std::string text(float v) { return fmt::format("{}", v); }
inline std::string text(int v) { return fmt::format("{}", v); }
inline std::string text(bool v) { return v ? "true" : "false"; }
inline std::string text(std::string_view v) { return fmt::format("\"{}\"", v); }
inline std::string text(Handle v) { return fmt::format("<{}>", v.text); }
template <typename T>
std::string listText(const T& values) {
  std::string result = "[";
  for (const auto& v : values) result += (result.size() > 1 ? " " : "") + text(v);
  return result + "]";
}
inline std::string text(Floats v) { return listText(v); }
inline std::string text(Ints v) { return listText(v); }
inline std::string text(Strings v) { return listText(v); }
template <typename T, size_t N>
std::string text(const std::array<T, N>& v) {
  return listText(v);
}
inline std::string text(const RibBasis& v) { return v.name.empty() ? text(v.matrix) : text(v.name); }
inline std::string text(const SubdivisionTags& v) {
  return fmt::format("tags({}{}{}{}{})", text(v.names), text(v.counts), text(v.ints), text(v.floats),
                     text(v.strings));
}
inline std::string text(const Param& p) {
  std::string values = "[]";
  if (!p.floats.empty()) values = text(p.floats);
  if (!p.ints.empty()) values = text(p.ints);
  if (!p.strings.empty()) values = text(p.strings);
  return fmt::format("{}{}={}", toString(p.declaration), p.declaration.declared ? "" : "?", values);
}
inline std::string text(const ParamList& v) {
  std::string result = "{";
  for (const Param& p : v) result += (result.size() > 1 ? ", " : "") + text(p);
  return result + "}";
}

class Recorder : public EveryRequest<Recorder> {
 public:
  std::vector<std::string> lines;
  std::vector<Location> places;
  bool comments = false;

  bool wantsComments() const override { return comments; }
  void comment(std::string_view t, const Location& at) override { each("#", at, t); }
  void structure(std::string_view t, const Location& at) override { each("##", at, t); }

  template <typename... A>
  void each(std::string_view name, const Location& at, const A&... arguments) {
    std::string line(name);
    ((line += " " + text(arguments)), ...);
    lines.push_back(line);
    places.push_back(at);
  }
};

// Parses `rib` as the file "t.rib" and keeps what came of it.
struct Parsed {
  Recorder recorder;
  std::vector<std::string> messages;
  ErrorHandler errors{[this](Severity, std::string_view m) { messages.emplace_back(m); }};
  bool complete = false;

  explicit Parsed(std::string_view rib, const ParserLimits& limits = {}) {
    complete = RibParser(recorder, errors, limits).parseMemory(rib, "t.rib");
  }
};

using Lines = std::vector<std::string>;
inline Lines requests(std::string_view rib) { return Parsed(rib).recorder.lines; }
inline Lines messages(std::string_view rib) { return Parsed(rib).messages; }

}  // namespace patina::test
