// SPDX-License-Identifier: Apache-2.0
// Parse calls: open the input, keep the depth, run a session over it.
#include "rib/parser.h"

#include <fmt/format.h>

#include "rib/input_files.h"
#include "rib/session.h"

namespace patina {

RibParser::RibParser(RibHandler& handler, ErrorHandler& errors, const ParserLimits& limits)
    : handler_(handler), errors_(errors), limits_(limits) {}

RibParser::~RibParser() = default;

bool RibParser::parseFile(const std::string& path) {
  Source source;
  const bool complete = source.openFile(path, limits_, errors_);
  noteInputText(path, source.text());
  return run(source.text(), {internFileName(path == "-" ? "<stdin>" : path), 1, 1}, nullptr) && complete;
}

bool RibParser::parseDescriptor(int descriptor, std::string_view name) {
  Source source;
  const Location start{internFileName(name), 1, 1};
  const bool complete = source.readDescriptor(descriptor, {start.file}, limits_, errors_);
  return run(source.text(), start, nullptr) && complete;
}

bool RibParser::parseMemory(std::string_view text, std::string_view name) {
  Source source;
  const Location start{internFileName(name), 1, 1};
  const bool complete = source.viewMemory(text, {start.file}, limits_, errors_);
  noteInputText(name, source.text());
  return run(source.text(), start, nullptr) && complete;
}

bool RibParser::parseArchive(const InlineArchive& archive) {
  // A copy of the tables: what the block defines stays in it, so that it means the same each time.
  auto tables = archive.tables ? std::make_shared<EncodingTables>(*archive.tables) : nullptr;
  const std::shared_ptr<const std::string> text = archive.text;
  return run(*text, archive.start, std::move(tables));
}

bool RibParser::run(std::string_view text, const Location& start, std::shared_ptr<EncodingTables> tables) {
  if (depth_ >= limits_.depth) {
    errors_.report(Severity::Error, RiError::LimitCheck, start,
                   fmt::format("archives are nested more than {} deep", limits_.depth));
    return false;
  }
  struct Deeper {
    int& depth;
    explicit Deeper(int& d) : depth(d) { ++depth; }
    ~Deeper() { --depth; }
  };
  const auto level = static_cast<size_t>(depth_);
  const Deeper deeper(depth_);
  if (pools_.size() <= level) pools_.push_back(std::make_unique<ValuePool>());
  return ParseSession(*this, *pools_[level], text, start, std::move(tables)).run();
}

bool RibParser::firstTime(std::string_view name) {
  constexpr size_t kRemembered = 4096;
  return remembered_.size() < kRemembered && remembered_.emplace(name).second;
}

}  // namespace patina
