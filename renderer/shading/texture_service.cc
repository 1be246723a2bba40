// SPDX-License-Identifier: Apache-2.0
// Finds texture files, loads the module that reads them with the first, and maps directions to texture
// coordinates.
#include "renderer/shading/texture_service.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <utility>

#include "renderer/base/statistics.h"
#include "renderer/shading/plugin_loader.h"
#include "renderer/shading/texture_module.h"

/// An open texture. Immutable.
struct PatinaTexture {
  const PatinaTextureModule* module;
  void* system;
  void* handle;
  uint32_t width, height, channels;
  std::string name;
  patina::Location where;
  patina::ErrorHandler* errors;
};

namespace patina {
namespace {

STAT_COUNTER("Textures/texture systems started", systemsStarted);
STAT_COUNTER("Textures/files opened", texturesOpened);
STAT_COUNTER("Textures/files missing", texturesMissing);
STAT_COUNTER("Textures/look-ups", textureLookups);

constexpr float kPi = std::numbers::pi_v<float>;

// Suffixes of other renderers' texture files, and of the pictures that such files are made from.
constexpr std::string_view kMade[] = {".tx", ".tex", ".txr", ".tdl", ".ptx"};
constexpr std::string_view kSources[] = {".tif", ".tiff", ".exr", ".png", ".jpg", ".hdr"};

bool isFile(const std::string& path) {
  std::error_code failed;
  return std::filesystem::is_regular_file(path, failed);
}

// Where a texture of that name may be, best first.
std::vector<std::string> candidatesOf(std::string_view name, const std::vector<std::string>& folders) {
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

PatinaStatus lookUp(PatinaTexture* texture, uint32_t count, const PatinaTextureLookup& in, PatinaOut3 color,
                    float* alpha) {
  if (!texture) {
    for (float* plane : {color.x, color.y, color.z, alpha})
      if (plane) std::fill(plane, plane + count, 1.0f);
    return PATINA_OK;
  }
  textureLookups += count;
  std::array<char, 512> error{};
  if (texture->module->lookup(texture->system, texture->handle, texture->channels, count, &in, color, alpha,
                              error.data(), error.size()))
    return PATINA_OK;
  texture->errors->reportOnce(Severity::Error, RiError::BadFile, texture->where, "texture " + texture->name,
                              fmt::format("texture \"{}\" cannot be read: {}", texture->name, error.data()));
  return PATINA_ERROR_RESOURCE;
}

}  // namespace

TextureService::TextureService(std::vector<std::string> folders, std::map<std::string, std::string> made,
                               size_t budget, ErrorHandler& errors)
    : folders_(std::move(folders)), made_(std::move(made)), budget_(budget), errors_(errors) {}

TextureService::~TextureService() {
  if (system_) module_->destroy(system_);
}

void TextureService::loadModule(const Location& where) {
  if (std::exchange(triedModule_, true)) return;
  std::vector<std::string> folders;
  if (const char* variable = std::getenv("PATINA_MODULE_PATH")) folders = splitSearchPath(variable, {});
  for (std::string& folder : installFolders("modules")) folders.push_back(std::move(folder));
  std::string tried;
  for (const std::string& folder : folders) {
    const std::string path = folder + "/patina_texture.so";
    void* library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    const char* reason = library ? nullptr : dlerror();
    const auto* module =
        library ? static_cast<const PatinaTextureModule*>(dlsym(library, PATINA_TEXTURE_MODULE_SYMBOL))
                : nullptr;
    if (module && module->version == PATINA_TEXTURE_MODULE_VERSION && (system_ = module->create(budget_))) {
      module_ = module;
      ++systemsStarted;
      return;
    }
    tried += fmt::format("\n  {}: {}", path, reason ? reason : "not a texture module of this version");
  }
  errors_.report(Severity::Error, RiError::System, where,
                 "textures cannot be read: no texture module; tried:" + tried);
}

std::unique_ptr<PatinaTexture> TextureService::find(std::string_view name, const Location& where) {
  std::string tried;
  std::vector<std::string> folders = folders_;
  if (where.file) folders.push_back(std::filesystem::path(*where.file).parent_path().string());
  if (folders.size() > folders_.size() && folders.back().empty()) folders.pop_back();
  std::vector<std::string> candidates = candidatesOf(name, folders);
  if (const auto made = made_.find(std::string(name)); made != made_.end()) {
    const std::vector<std::string> pictures = candidatesOf(made->second, folders);
    candidates.insert(candidates.begin(), pictures.begin(), pictures.end());
  }
  for (const std::string& path : candidates) {
    if (!isFile(path)) {
      tried += fmt::format("\n  {}: no such file", path);
      continue;
    }
    loadModule(where);
    if (!module_) return nullptr;
    std::array<char, 512> error{};
    auto texture = std::make_unique<PatinaTexture>();
    texture->module = module_;
    texture->system = system_;
    texture->handle = module_->open(system_, path.c_str(), &texture->width, &texture->height,
                                    &texture->channels, error.data(), error.size());
    texture->name = name;
    texture->where = where;
    texture->errors = &errors_;
    if (texture->handle) {
      ++texturesOpened;
      return texture;
    }
    tried += fmt::format("\n  {}: {}", path, error.data());
  }
  ++texturesMissing;
  errors_.report(Severity::Error, RiError::NoFile, where,
                 fmt::format("texture \"{}\" is not found, it reads 1; tried:{}", name, tried));
  return nullptr;
}

PatinaTexture* TextureService::open(std::string_view name, const Location& where) {
  const std::lock_guard lock(mutex_);
  auto known = textures_.find(name);
  if (known == textures_.end()) known = textures_.emplace(std::string(name), find(name, where)).first;
  return known->second.get();
}

uint64_t TextureService::cachedBytes() const { return module_ ? module_->bytes(system_) : 0; }

PatinaStatus TextureService::texture(PatinaTexture* texture, uint32_t count, PatinaPlane s, PatinaPlane t,
                                     PatinaPlane width, PatinaOut3 color, float* alpha) {
  return lookUp(texture, count, {s, t, width, width, 1}, color, alpha);
}

PatinaStatus TextureService::environment(PatinaTexture* texture, uint32_t count, PatinaPlane3 direction,
                                         PatinaPlane width, PatinaOut3 color) {
  PatinaStatus status = PATINA_OK;
  for (uint32_t start = 0; start < count; start += PATINA_LANES) {
    float s[PATINA_LANES], t[PATINA_LANES], widthS[PATINA_LANES], widthT[PATINA_LANES];
    const uint32_t lanes = std::min(PATINA_LANES, count - start);
    for (uint32_t i = 0; i < lanes; ++i) {
      const auto at = [&](const PatinaPlane& p) { return p.data ? p.data[(start + i) * p.stride] : 0.0f; };
      const float x = at(direction.x), y = at(direction.y), z = at(direction.z);
      const float around = std::hypot(x, y);
      const float sine = around / std::max(std::hypot(around, z), 1e-30f);
      s[i] = 0.5f + std::atan2(y, x) / (2 * kPi);
      t[i] = std::atan2(around, z) / kPi;
      widthS[i] = std::min(1.0f, at(width) / (2 * kPi * std::max(sine, 1e-4f)));
      widthT[i] = at(width) / kPi;
    }
    const auto varying = [](const float* data) { return PatinaPlane{data, 1, 0}; };
    const PatinaStatus result =
        lookUp(texture, lanes, {varying(s), varying(t), varying(widthS), varying(widthT), 0},
               {color.x + start, color.y + start, color.z + start}, nullptr);
    if (result != PATINA_OK) status = result;
  }
  return status;
}

PatinaStatus TextureService::size(const PatinaTexture* texture, uint32_t* width, uint32_t* height,
                                  uint32_t* channels) {
  if (width) *width = texture ? texture->width : 1;
  if (height) *height = texture ? texture->height : 1;
  if (channels) *channels = texture ? texture->channels : 1;
  return texture ? PATINA_OK : PATINA_ERROR_RESOURCE;
}

}  // namespace patina
