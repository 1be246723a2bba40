// SPDX-License-Identifier: Apache-2.0
// The module's places, and those of texture files.
#include "renderer/shading/texture_loader.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <cstdlib>

#include "renderer/shading/plugin_loader.h"

namespace patina {
namespace {

// Suffixes of other renderers' texture files, and of the pictures that such files are made from.
constexpr std::string_view kMade[] = {".tx", ".tex", ".txr", ".tdl", ".ptx"};
constexpr std::string_view kSources[] = {".tif", ".tiff", ".exr", ".png", ".jpg", ".hdr"};

}  // namespace

const PatinaTextureModule* loadTextureModule(std::string& tried) {
  std::vector<std::string> folders;
  if (const char* variable = std::getenv("PATINA_MODULE_PATH")) folders = splitSearchPath(variable, {});
  for (std::string& folder : installFolders("modules")) folders.push_back(std::move(folder));
  for (const std::string& folder : folders) {
    const std::string path = folder + "/patina_texture.so";
    void* library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    const char* reason = library ? nullptr : dlerror();
    const auto* module =
        library ? static_cast<const PatinaTextureModule*>(dlsym(library, PATINA_TEXTURE_MODULE_SYMBOL))
                : nullptr;
    if (module && module->version == PATINA_TEXTURE_MODULE_VERSION) return module;
    tried += fmt::format("\n  {}: {}", path, reason ? reason : "not a texture module of this version");
  }
  return nullptr;
}

std::vector<std::string> textureCandidates(std::string_view name, const std::vector<std::string>& folders) {
  std::vector<std::string> names{std::string(name)};
  for (const std::string_view made : kMade)
    if (name.ends_with(made)) {
      names.emplace_back(name.substr(0, name.size() - made.size()));  // "wood.tif.tx"
      for (const std::string_view source : kSources) names.push_back(names[1] + std::string(source));
    }
  std::vector<std::string> paths;
  for (const std::string& file : names) {
    const size_t slash = file.find_last_of("/\\");
    if (!file.starts_with('/'))
      for (const std::string& folder : folders) paths.push_back(folder + '/' + file);
    paths.push_back(file);
    if (slash != std::string::npos)
      for (const std::string& folder : folders) paths.push_back(folder + '/' + file.substr(slash + 1));
  }
  return paths;
}

}  // namespace patina
