// SPDX-License-Identifier: Apache-2.0
// RI's search paths.
#include "renderer/scene/search_path.h"

#include <algorithm>
#include <filesystem>

namespace patina {
namespace {

namespace fs = std::filesystem;

template <class Visit>
void forEachElement(std::string_view path, Visit visit) {
  while (!path.empty()) {
    const size_t end = std::min(path.find(':'), path.size());
    if (end > 0) visit(path.substr(0, end));
    path.remove_prefix(std::min(end + 1, path.size()));
  }
}

}  // namespace

std::string expandSearchPath(std::string_view path, std::string_view previous) {
  std::string expanded;
  forEachElement(path, [&](std::string_view element) {
    if (element == "&") element = previous;
    if (element.empty()) return;
    if (!expanded.empty()) expanded += ':';
    expanded += element;
  });
  return expanded;
}

std::vector<std::string> searchFolders(std::string_view path, const std::vector<std::string>& standard) {
  std::vector<std::string> folders;
  const auto add = [&](std::string_view folder) {
    if (!folder.empty() && std::ranges::find(folders, folder) == folders.end()) folders.emplace_back(folder);
  };
  forEachElement(path, [&](std::string_view element) {
    if (element == "@") {
      std::ranges::for_each(standard, add);
    } else if (element != "&") {
      add(element);
    }
  });
  return folders;
}

std::optional<std::string> findFile(std::string_view name, const std::vector<std::string>& folders,
                                    std::vector<std::string>& tried) {
  const auto look = [&](const fs::path& path) -> std::optional<std::string> {
    std::error_code ignored;
    tried.push_back(path.string());
    if (fs::is_regular_file(path, ignored)) return path.string();
    const fs::path twin =
        path.extension() == ".gz" ? path.parent_path() / path.stem() : fs::path(path.string() + ".gz");
    if (fs::is_regular_file(twin, ignored)) return twin.string();
    return std::nullopt;
  };
  if (name.empty() || name.find('\0') != std::string_view::npos) return std::nullopt;
  if (fs::path(name).is_absolute()) return look(fs::path(name));
  for (const std::string& folder : folders) {
    if (auto found = look(fs::path(folder) / name)) return found;
  }
  return std::nullopt;
}

std::string canonicalPath(const std::string& path) {
  std::error_code failed;
  const fs::path canonical = fs::weakly_canonical(path, failed);
  return failed ? path : canonical.string();
}

}  // namespace patina
