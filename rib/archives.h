// SPDX-License-Identifier: Apache-2.0
// What ReadArchive names: files by search path, inline archives by name, neither of them within itself.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "rib/parser.h"

namespace patina {

/// Finds archives and has a parser read them. Used from within a handler's methods. One thread.
class Archives {
 public:
  /// `mostReads`: archives read in all, since they may read each other many times over.
  Archives(RibParser& parser, ErrorHandler& errors, size_t mostReads = 1'000'000)
      : parser_(parser), errors_(errors), mostReads_(mostReads) {}

  /// Reads the file that everything begins with ("-" is standard input): it is found where it says, and no
  /// archive may read it again. False as RibParser::parseFile.
  bool readMain(const std::string& path);

  /// Keeps an inline archive; a later one of the same name takes its place.
  void define(std::string_view name, InlineArchive archive);

  /// Reads an inline archive of that name, or a file that is found on `searchPath` (RI's syntax), beside the
  /// file that asks, beside the main file, or here. An archive that is not found, is being read already, or
  /// is one too many is an error at `at`, and false.
  bool read(std::string_view name, std::string_view searchPath, const Location& at);

  /// Where the main file lies: "." for standard input.
  std::string mainFolder() const;

 private:
  struct Open {
    std::string path, canonical;
  };
  std::vector<std::string> folders(std::string_view searchPath, const Location& at) const;

  RibParser& parser_;
  ErrorHandler& errors_;
  size_t mostReads_, reads_ = 0;
  std::map<std::string, InlineArchive, std::less<>> inline_;
  std::vector<Open> chain_;  // being read, outermost first
};

}  // namespace patina
