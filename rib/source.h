// SPDX-License-Identifier: Apache-2.0
// The bytes of one RIB input, wherever they come from, and the lines and columns in them.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>

#include "rib/error.h"

namespace patina {

struct ParserLimits;

// All bytes of an input: a mapped file, or memory that a pipe or a gzipped file was read into. Move-only.
class Source {
 public:
  Source() = default;
  Source(Source&& other) noexcept { *this = std::move(other); }
  Source& operator=(Source&& other) noexcept;
  ~Source();

  // Each reports what goes wrong and then returns false; the text then holds what could be read before.
  bool openFile(const std::string& path, const ParserLimits& limits, ErrorHandler& errors);
  bool readDescriptor(int descriptor, const Location& at, const ParserLimits& limits, ErrorHandler& errors);
  bool viewMemory(std::string_view text, const Location& at, const ParserLimits& limits,
                  ErrorHandler& errors);

  std::string_view text() const { return text_; }

 private:
  bool inflateIfGzip(const Location& at, const ParserLimits& limits, ErrorHandler& errors);
  void release();

  std::string_view text_;
  void* mapping_ = nullptr;  // of text_.size() bytes
  char* memory_ = nullptr;   // from malloc
  size_t mappedBytes_ = 0;
};

// Finds the line and column of positions in a text. Positions are asked for in nearly ascending order, so
// counting goes on from the last answer; an earlier position than that is counted from the last mark().
class LineMap {
 public:
  // `start` is the place of the text's first byte.
  LineMap(std::string_view text, const Location& start)
      : file_(start.file),
        end_(text.data() + text.size()),
        mark_{text.data(), start.line ? start.line : 1, start.column ? start.column : 1},
        last_(mark_) {}

  // The place of `p`, not before the mark.
  Location locate(const char* p);
  // Nothing before `p` will be asked for any more.
  Location mark(const char* p) {
    const Location result = locate(p);
    mark_ = last_;
    return result;
  }

 private:
  struct Point {
    const char* p;
    uint32_t line, column;
  };
  const std::string* file_;
  const char* end_;  // of the text
  Point mark_, last_;
};

}  // namespace patina
