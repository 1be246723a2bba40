// SPDX-License-Identifier: Apache-2.0
// Finding and reading archives.
#include "rib/archives.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "rib/search_path.h"

namespace patina {
namespace {

std::string folderOf(const std::string& file) {
  const std::string folder = std::filesystem::path(file).parent_path().string();
  return folder.empty() ? std::string(".") : folder;
}

}  // namespace

bool Archives::readMain(const std::string& path) {
  if (path != "-") chain_.push_back({path, canonicalPath(path)});
  const bool read = parser_.parseFile(path);
  chain_.clear();
  return read;
}

void Archives::define(std::string_view name, InlineArchive archive) {
  inline_.insert_or_assign(std::string(name), std::move(archive));
}

std::string Archives::mainFolder() const {
  return chain_.empty() ? std::string(".") : folderOf(chain_.front().path);
}

std::vector<std::string> Archives::folders(std::string_view searchPath, const Location& at) const {
  // Last of all the places that every file may mean.
  std::vector<std::string> standard;
  if (at.file) standard.push_back(folderOf(*at.file));
  standard.push_back(mainFolder());
  standard.emplace_back(".");
  return searchFolders(std::string(searchPath) + ":@", standard);
}

const InlineArchive* Archives::recorded(std::string_view name) const {
  const auto found = inline_.find(name);
  if (found != inline_.end()) return &found->second;
  return outer_ ? outer_->recorded(name) : nullptr;
}

bool Archives::read(std::string_view name, std::string_view searchPath, const Location& at) {
  const auto fail = [&](RiError code, const std::string& message, const std::string& key) {
    errors_.report(Severity::Error, code, at, message, key);
    return false;
  };
  if (++*reads_ > mostReads_)
    return fail(RiError::LimitCheck, fmt::format("more than {} archives read", mostReads_), "archive reads");
  const InlineArchive* const recorded = this->recorded(name);
  std::string path;
  if (recorded) {
    path = fmt::format("ArchiveBegin \"{}\"", name);
  } else {
    std::vector<std::string> tried;
    const auto found = findFile(name, folders(searchPath, at), tried);
    if (!found)
      return fail(RiError::NoFile,
                  fmt::format("archive \"{}\" is not found; tried: {}", name, fmt::join(tried, ", ")),
                  fmt::format("archive {}", name));
    path = *found;
  }

  Open opened{path, canonicalPath(path)};
  if (std::ranges::find(chain_, opened.canonical, &Open::canonical) != chain_.end()) {
    std::string chain;
    for (const Open& open : chain_) chain += open.path + " -> ";
    return fail(RiError::BadFile, fmt::format("archive \"{}\" would read itself: {}{}", name, chain, path),
                fmt::format("archive loop {}", name));
  }
  chain_.push_back(std::move(opened));
  bool read = false;
  if (recorded) {
    const InlineArchive archive = *recorded;  // the archive may record another one of its name
    bytes_ += archive.text->size();
    read = parser_.parseArchive(archive);
  } else {
    std::error_code unknown;
    const auto bytes = std::filesystem::file_size(path, unknown);
    if (!unknown) bytes_ += bytes;
    read = parser_.parseFile(path);
  }
  chain_.pop_back();
  return read;
}

}  // namespace patina
