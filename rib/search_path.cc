// SPDX-License-Identifier: Apache-2.0
// RI's search paths.
#include "rib/search_path.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>

#include "rib/sandbox.h"

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

/// `text` with the variables of the environment put in; nullopt: one of them is not set.
std::optional<std::string> withVariables(std::string_view text) {
  std::string result;
  while (!text.empty()) {
    const size_t dollar = std::min(text.find('$'), text.size());
    result += text.substr(0, dollar);
    text.remove_prefix(dollar);
    if (text.empty()) break;
    text.remove_prefix(1);
    const bool braces = text.starts_with('{');
    if (braces) text.remove_prefix(1);
    const auto isNamed = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; };
    const auto length = static_cast<size_t>(std::ranges::find_if_not(text, isNamed) - text.begin());
    if (length == 0 ||
        (braces && !text.substr(length).starts_with('}'))) {  // no variable: what it looks like
      result += braces ? "${" : "$";
      continue;
    }
    const char* const value = std::getenv(std::string(text.substr(0, length)).c_str());
    if (!value) return std::nullopt;
    result += value;
    text.remove_prefix(length + (braces ? 1 : 0));
  }
  return result;
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
    } else if (element.find('$') != std::string_view::npos) {
      if (const auto expanded = withVariables(element)) forEachElement(*expanded, add);
    } else if (element != "&") {
      add(element);
    }
  });
  return folders;
}

std::optional<std::string> findFile(std::string_view name, const std::vector<std::string>& folders,
                                    std::vector<std::string>& tried) {
  const auto look = [&](const fs::path& path) -> std::optional<std::string> {
    const fs::path twin =
        path.extension() == ".gz" ? path.parent_path() / path.stem() : fs::path(path.string() + ".gz");
    for (const fs::path& each : {path, twin}) {
      std::error_code ignored;
      const std::string problem = readProblem(each.string());
      if (each == path) tried.push_back(path.string() + (problem.empty() ? "" : " (" + problem + ")"));
      if (problem.empty() && fs::is_regular_file(each, ignored)) return each.string();
    }
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
