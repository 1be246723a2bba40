// SPDX-License-Identifier: Apache-2.0
// Archives, procedurals that are archives, and conditional RIB.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "renderer/scene/condition.h"
#include "renderer/scene/scene_builder.h"
#include "renderer/scene/search_path.h"

namespace patina {

// ---- Archives ---------------------------------------------------------------------------------------------

std::vector<std::string> SceneBuilder::archiveFolders(const Location& at) const {
  // Last of all the places that every file may mean: beside the file that asks, beside the first one, and
  // here.
  const auto folderOf = [](const std::string& file) {
    const std::string folder = std::filesystem::path(file).parent_path().string();
    return folder.empty() ? std::string(".") : folder;
  };
  std::vector<std::string> standard;
  if (at.file) standard.push_back(folderOf(*at.file));
  if (!archiveChain_.empty()) standard.push_back(folderOf(archiveChain_.front().path));
  standard.emplace_back(".");

  std::string path = settings_.archivePath;
  for (const std::string_view kind : {"archive", "resource"}) {
    const auto option = options_.searchPaths.find(std::string(kind));
    if (option != options_.searchPaths.end()) path.append(":").append(option->second);
  }
  return searchFolders(path + ":@", standard);
}

bool SceneBuilder::readArchiveFile(std::string_view name, const Location& at) {
  if (++archivesRead_ > settings_.archiveReads) {
    error(RiError::LimitCheck, at, fmt::format("more than {} archives read", settings_.archiveReads),
          "archive reads");
    return false;
  }
  const auto recorded = inlineArchives_.find(name);
  std::string path;
  if (recorded != inlineArchives_.end()) {
    path = fmt::format("ArchiveBegin \"{}\"", name);
  } else {
    std::vector<std::string> tried;
    const auto found = findFile(name, archiveFolders(at), tried);
    if (!found) {
      error(RiError::NoFile, at,
            fmt::format("archive \"{}\" is not found; tried: {}", name, fmt::join(tried, ", ")),
            fmt::format("archive {}", name));
      return false;
    }
    path = *found;
  }

  OpenArchive opened{path, canonicalPath(path)};
  if (std::ranges::find(archiveChain_, opened.canonical, &OpenArchive::canonical) != archiveChain_.end()) {
    std::string chain;
    for (const OpenArchive& open : archiveChain_) chain += open.path + " -> ";
    error(RiError::BadFile, at, fmt::format("archive \"{}\" would read itself: {}{}", name, chain, path),
          fmt::format("archive loop {}", name));
    return false;
  }
  archiveChain_.push_back(std::move(opened));
  bool read = false;
  if (recorded != inlineArchives_.end()) {
    const InlineArchive archive = recorded->second;  // the archive may record another one of its name
    read = parser_.parseArchive(archive);
  } else {
    read = parser_.parseFile(path);
  }
  archiveChain_.pop_back();
  return read;
}

void SceneBuilder::readArchive(std::string_view name, const ParamList& params, const Location& at) {
  for (const Param& param : params) param.used = true;
  readArchiveFile(name, at);
}

bool SceneBuilder::archiveBegin(std::string_view, const ParamList& params, const Location&) {
  for (const Param& param : params) param.used = true;
  return true;
}

void SceneBuilder::archive(std::string_view name, InlineArchive archive, const Location&) {
  inlineArchives_.insert_or_assign(std::string(name), std::move(archive));
}

void SceneBuilder::procedural(std::string_view kind, Strings args, const Bounds6&, const Location& at) {
  if (kind != "DelayedReadArchive" || args.empty())
    return unhandled(fmt::format("Procedural \"{}\"", kind), at);
  if (laterMotionSample()) return;
  if (!open(BlockKind::Attribute, at)) return;
  const size_t depth = blocks_.depth();
  readArchiveFile(args.front(), at);
  // Blocks that the archive left open end with it; one that it closed too many is its own mistake.
  if (blocks_.depth() >= depth) {
    while (blocks_.depth() > depth) closeTop(at);
    close(BlockKind::Attribute, at);
  }
}

// ---- Conditions -------------------------------------------------------------------------------------------

void SceneBuilder::setUserValues(std::string_view kind, std::string_view name, const ParamList& params) {
  if (name != "user") return;
  constexpr size_t kMostValues = 100000;
  for (const Param& param : params) {
    if (userValues_.size() >= kMostValues) return;
    std::string value;
    if (!param.strings.empty()) {
      value = param.strings.front();
    } else if (!param.ints.empty()) {
      value = std::to_string(param.ints.front());
    } else if (!param.floats.empty()) {
      value = fmt::format("{}", param.floats.front());
    }
    userValues_[fmt::format("user:{}", param.name())] = value;
    userValues_[fmt::format("{}:user:{}", kind, param.name())] = value;
  }
}

std::optional<bool> SceneBuilder::evaluate(std::string_view condition, const Location& at) {
  const auto value = evaluateCondition(condition, [&](std::string_view name) -> std::optional<std::string> {
    if (name == "Frame" || name == "frame") return std::to_string(scene_.frame);
    const auto known = userValues_.find(name);
    return known == userValues_.end() ? std::nullopt : std::optional(known->second);
  });
  if (!value) {
    error(RiError::SyntaxError, at,
          fmt::format("condition \"{}\" is not understood: its branch is skipped", condition));
  }
  return value;
}

Branch SceneBuilder::ifBegin(std::string_view condition, const ParamList& params, const Location& at) {
  for (const Param& param : params) param.used = true;
  return evaluate(condition, at).value_or(false) ? Branch::Take : Branch::Skip;
}

Branch SceneBuilder::elseIf(std::string_view condition, const ParamList& params, const Location& at) {
  return ifBegin(condition, params, at);
}

Branch SceneBuilder::else_(const Location&) { return Branch::Take; }

}  // namespace patina
