// SPDX-License-Identifier: Apache-2.0
// What ReadArchive names: files by search path, inline archives by name, neither of them within itself.
#pragma once

#include <atomic>
#include <map>
#include <memory>
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
      : parser_(parser), errors_(errors), mostReads_(mostReads), reads_(std::make_shared<Reads>(0)) {}

  /// The files that are being read, outermost first.
  struct Open {
    std::string path, canonical;
    bool operator==(const Open&) const = default;
  };
  using Chain = std::vector<Open>;

  /// For what is read later, on behalf of a request in `chain`: knows the inline archives of `outer`, which
  /// must outlive this and not change, and counts towards the same limit. [any thread, if `parser` is its
  /// own]
  Archives(RibParser& parser, ErrorHandler& errors, const Archives& outer, Chain chain)
      : parser_(parser),
        errors_(errors),
        mostReads_(outer.mostReads_),
        reads_(outer.reads_),
        outer_(&outer),
        chain_(std::move(chain)) {}

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

  const Chain& chain() const { return chain_; }
  uint64_t bytesRead() const { return bytes_; }  ///< of all archives, as they lie in their files

 private:
  using Reads = std::atomic<size_t>;
  const InlineArchive* recorded(std::string_view name) const;
  std::vector<std::string> folders(std::string_view searchPath, const Location& at) const;

  RibParser& parser_;
  ErrorHandler& errors_;
  size_t mostReads_;
  std::shared_ptr<Reads> reads_;
  const Archives* outer_ = nullptr;
  uint64_t bytes_ = 0;
  std::map<std::string, InlineArchive, std::less<>> inline_;
  Chain chain_;
};

}  // namespace patina
