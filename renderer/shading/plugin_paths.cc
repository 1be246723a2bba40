// SPDX-License-Identifier: Apache-2.0
// Search paths in RI syntax, and the folders of this build or installation.
#include <algorithm>
#include <filesystem>

#include "renderer/shading/plugin_loader.h"

#ifndef PATINA_INSTALL_LIBDIR
#define PATINA_INSTALL_LIBDIR "lib"
#endif

namespace patina {
namespace {

void addOnce(std::vector<std::string>& list, std::string item) {
  while (item.size() > 1 && item.back() == '/') item.pop_back();
  if (!item.empty() && std::find(list.begin(), list.end(), item) == list.end())
    list.push_back(std::move(item));
}

}  // namespace

std::vector<std::string> splitSearchPath(std::string_view path, std::span<const std::string> defaults) {
  std::vector<std::string> folders;
  while (!path.empty()) {
    const size_t end = std::min(path.find(':'), path.size());
    const std::string_view item = path.substr(0, end);
    path.remove_prefix(std::min(end + 1, path.size()));
    if (item == "&" || item == "@")
      for (const std::string& folder : defaults) addOnce(folders, folder);
    else
      addOnce(folders, std::string(item));
  }
  return folders;
}

std::vector<std::string> installFolders(std::string_view kind) {
  std::error_code failed;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", failed);
  if (failed) return {};
  const std::filesystem::path root = program.parent_path().parent_path();
  std::vector<std::string> folders;
  for (const char* library : {"lib", PATINA_INSTALL_LIBDIR}) {
    const std::filesystem::path folder = root / library / "patina" / kind;
    if (std::filesystem::is_directory(folder, failed)) addOnce(folders, folder.string());
  }
  return folders;
}

}  // namespace patina
