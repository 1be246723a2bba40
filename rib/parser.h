// SPDX-License-Identifier: Apache-2.0
// Reads RIB, ASCII or binary or both, plain or gzipped, and calls a RibHandler for each request.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "rib/error.h"
#include "rib/handler.h"
#include "rib/inline_archive.h"
#include "rib/params.h"

namespace patina {

struct ParserLimits {
  uint64_t inputBytes = uint64_t{64} << 30;      // read from one pipe, or inflated from one file
  uint64_t inflateFreely = uint64_t{256} << 20;  // up to here a gzipped file may inflate at any ratio ...
  uint32_t inflateRatio = 300;                   // ... beyond, at most to this many times its size
  int depth = 64;  // parse calls within parse calls (archives that read archives)
};

// A syntax error costs its request, a bad parameter itself; both are reported with their place, and reading
// goes on. Each function below may be called from within a handler's method (ReadArchive): the declarations
// are shared, what Declare adds stays. One thread at a time; different parsers are independent. Each returns
// false if the input could not be read at all or to its end (reported), or errors.aborted() stopped it;
// errors within the text do not make it false.
class RibParser {
 public:
  RibParser(RibHandler& handler, ErrorHandler& errors, const ParserLimits& limits = {});
  ~RibParser();
  RibParser(const RibParser&) = delete;
  RibParser& operator=(const RibParser&) = delete;

  // A file or a named pipe; "-" is standard input. gzip is told by its first bytes. Regular files are
  // memory-mapped.
  bool parseFile(const std::string& path);
  // An open descriptor, read to its end and not closed; `name` is for messages.
  bool parseDescriptor(int descriptor, std::string_view name);
  // `text` must stay unchanged during the call. gzip is told by its first bytes.
  bool parseMemory(std::string_view text, std::string_view name);
  bool parseArchive(const InlineArchive& archive);

  // What names mean; shared by nested calls. A copy may be handed to another parser, which then knows the
  // same names.
  Dictionary& dictionary() { return dictionary_; }
  const Dictionary& dictionary() const { return dictionary_; }

 private:
  friend class ParseSession;
  bool run(std::string_view text, const Location& start, std::shared_ptr<EncodingTables> tables);
  // True once per name: looking for the nearest known name is too slow to be done each time.
  bool firstTime(std::string_view name);

  RibHandler& handler_;
  ErrorHandler& errors_;
  ParserLimits limits_;
  Dictionary dictionary_;
  int depth_ = 0;
  std::unordered_set<std::string> remembered_;
  std::vector<std::unique_ptr<class ValuePool>> pools_;  // one per depth, reused
};

}  // namespace patina
