// SPDX-License-Identifier: Apache-2.0
// Finds texture files, loads the module that reads them with the first, and maps directions to texture
// coordinates.
#include "renderer/shading/texture_service.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <utility>

#include "renderer/base/statistics.h"
#include "renderer/shading/texture_file.h"
#include "renderer/shading/texture_loader.h"
#include "renderer/shading/texture_module.h"
#include "rib/input_files.h"
#include "rib/sandbox.h"

namespace patina {
namespace {

STAT_COUNTER("Textures/texture systems started", systemsStarted);
STAT_COUNTER("Textures/files opened", texturesOpened);
STAT_COUNTER("Textures/files missing", texturesMissing);

constexpr float kPi = std::numbers::pi_v<float>;

bool isFile(const std::string& path) {
  std::error_code failed;
  return std::filesystem::is_regular_file(path, failed);
}

void fillWithOne(uint32_t count, PatinaOut3 color, float* alpha) {
  for (float* plane : {color.x, color.y, color.z, alpha})
    if (plane) std::fill(plane, plane + count, 1.0f);
}

/// Has to do with more than one file: a name with <UDIM>, <u>, %(UDIM)d ...
bool mayBePattern(std::string_view name) {
  return name.find('<') != std::string_view::npos || name.find("%(") != std::string_view::npos;
}

}  // namespace

TextureService::TextureService(std::vector<std::string> folders, std::map<std::string, std::string> made,
                               size_t budget, ErrorHandler& errors, TextureColors colors)
    : folders_(std::move(folders)),
      made_(std::move(made)),
      budget_(budget),
      errors_(errors),
      colors_(std::move(colors)) {}

TextureService::~TextureService() {
  if (system_) module_->destroy(system_);
}

void TextureService::loadModule(const Location& where) {
  if (std::exchange(triedModule_, true)) return;
  std::string tried;
  const PatinaTextureModule* const module = loadTextureModule(tried);
  if (module) {
    const std::string config = colors_.asInFile ? std::string() : colors_.ocioConfig;
    std::array<char, 1024> error{};
    system_ = module->create(budget_, config.c_str(), error.data(), error.size());
    if (system_) module_ = module, ++systemsStarted;
    if (error[0])
      errors_.report(Severity::Error, RiError::BadFile, colors_.where,
                     fmt::format("OpenColorIO configuration {} cannot be used: {}", config, error.data()));
    if (module_) return noteInputFile(config);
    tried = "\n  OpenImageIO gives no texture system";
  }
  errors_.report(Severity::Error, RiError::System, where,
                 "textures cannot be read: no texture module; tried:" + tried);
}

/// Fills `texture` with the files of `pattern`; false, and a reason: there are none that can be read.
bool TextureService::openTiles(PatinaTexture& texture, const std::string& pattern, Values values,
                               std::string& error) {
  struct Found {
    uint32_t column, row;
    std::string path;
  };
  std::vector<Found> found;
  std::array<char, 512> reason{};
  const auto sink = [](void* to, uint32_t column, uint32_t row, const char* path) {
    static_cast<std::vector<Found>*>(to)->push_back({column, row, path});
  };
  if (!module_->tiles(system_, pattern.c_str(), sink, &found, reason.data(), reason.size())) {
    error = reason.data();
    return false;
  }
  std::erase_if(found, [](const Found& tile) { return !readProblem(tile.path).empty(); });  // links
  for (const Found& tile : found) {
    texture.columns = std::max(texture.columns, tile.column + 1);
    texture.rows = std::max(texture.rows, tile.row + 1);
  }
  texture.tiles.resize(size_t(texture.columns) * texture.rows);
  bool any = false;
  for (const Found& tile : found) {
    PatinaTextureInfo& info = texture.tiles[size_t(tile.row) * texture.columns + tile.column];
    if (module_->open(system_, tile.path.c_str(), values == kData || colors_.asInFile, &info, reason.data(),
                      reason.size())) {
      if (!std::exchange(any, true)) texture.file = info;
      noteInputFile(tile.path);
      ++texturesOpened;
    } else {
      errors_.report(Severity::Error, RiError::BadFile, texture.where,
                     fmt::format("tile {} of texture \"{}\" cannot be read: {}", tile.path, texture.name,
                                 reason.data()));
    }
  }
  if (!any) error = "no such files";
  return any;
}

std::unique_ptr<PatinaTexture> TextureService::find(std::string_view name, const Location& where,
                                                    Values values) {
  std::string tried;
  std::vector<std::string> folders = folders_;
  if (where.file) folders.push_back(std::filesystem::path(*where.file).parent_path().string());
  if (folders.size() > folders_.size() && folders.back().empty()) folders.pop_back();
  std::vector<std::string> candidates = textureCandidates(name, folders);
  if (const auto made = made_.find(std::string(name)); made != made_.end()) {
    const std::vector<std::string> pictures = textureCandidates(made->second, folders);
    candidates.insert(candidates.begin(), pictures.begin(), pictures.end());
  }
  for (const std::string& path : candidates) {
    if (const std::string problem = readProblem(path); !problem.empty()) {
      tried += fmt::format("\n  {}: {}", path, problem);
      continue;
    }
    const bool isOne = isFile(path);
    if (!isOne && !mayBePattern(path)) {
      tried += fmt::format("\n  {}: no such file", path);
      continue;
    }
    loadModule(where);
    if (!module_) return nullptr;
    auto texture = std::make_unique<PatinaTexture>();
    texture->module = module_;
    texture->system = system_;
    texture->name = name;
    texture->where = where;
    if (!isOne) {
      std::string error;
      if (openTiles(*texture, path, values, error)) return texture;
      tried += fmt::format("\n  {}: {}", path, error);
      continue;
    }
    std::array<char, 512> error{};
    if (module_->open(system_, path.c_str(), values == kData || colors_.asInFile, &texture->file,
                      error.data(), error.size())) {
      ++texturesOpened;
      noteInputFile(path);
      return texture;
    }
    tried += fmt::format("\n  {}: {}", path, error.data());
  }
  ++texturesMissing;
  errors_.report(Severity::Error, RiError::NoFile, where,
                 fmt::format("texture \"{}\" is not found, it reads 1; tried:{}", name, tried));
  return nullptr;
}

PatinaTexture* TextureService::open(std::string_view name, const Location& where, Values values) {
  const std::lock_guard lock(mutex_);
  const std::pair key(std::string(name), values);
  auto known = textures_.find(key);
  if (known == textures_.end()) {
    const auto twin = textures_.find({key.first, values == kColors ? kData : kColors});
    const bool isMissing = twin != textures_.end() && !twin->second;  // which has been reported
    known = textures_.emplace(key, isMissing ? nullptr : find(name, where, values)).first;
  }
  return known->second.get();
}

void TextureService::summarize() {
  const std::lock_guard lock(mutex_);
  for (const auto& [key, texture] : textures_) {
    if (!texture) continue;
    const std::scoped_lock counts(texture->mutex);
    if (const uint64_t failed = texture->failed.exchange(0))
      errors_.report(Severity::Error, RiError::BadFile, texture->where,
                     fmt::format("texture \"{}\" cannot be read, {} look-ups read 1: {}", texture->name,
                                 failed, texture->reason));
    if (texture->missing.empty()) continue;
    std::string places;
    uint64_t count = std::exchange(texture->missingElsewhere, 0);
    if (count) places = fmt::format(", elsewhere ({})", count);
    constexpr size_t kMostNamed = 8;
    size_t named = 0;
    for (const auto& [place, lookups] : texture->missing) {
      if (++named <= kMostNamed)
        places += fmt::format(", column {} row {} ({})", place.first, place.second, lookups);
      count += lookups;
    }
    if (named > kMostNamed) places += fmt::format(" and {} more", named - kMostNamed);
    errors_.report(Severity::Error, RiError::NoFile, texture->where,
                   fmt::format("texture \"{}\" lacks tiles, {} look-ups read 1: {}", texture->name, count,
                               places.substr(2)));
    texture->missing.clear();
  }
}

uint64_t TextureService::cachedBytes() const { return module_ ? module_->bytes(system_) : 0; }

PatinaStatus TextureService::texture(PatinaTexture* texture, uint32_t count, PatinaPlane s, PatinaPlane t,
                                     PatinaPlane width, PatinaOut3 color, float* alpha) {
  if (!texture) {
    fillWithOne(count, color, alpha);
    return PATINA_OK;
  }
  if (!texture->tiles.empty()) return lookUpTiles(*texture, count, s, t, width, color, alpha);
  return lookUpFile(*texture, texture->file, count, {s, t, width, width, PATINA_WRAP_FILE, PATINA_WRAP_FILE},
                    color, alpha);
}

PatinaStatus TextureService::environment(PatinaTexture* texture, uint32_t count, PatinaPlane3 direction,
                                         PatinaPlane width, PatinaOut3 color) {
  if (!texture) {
    fillWithOne(count, color, nullptr);
    return PATINA_OK;
  }
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
    const PatinaStatus result = lookUpFile(
        *texture, texture->file, lanes,
        {varying(s), varying(t), varying(widthS), varying(widthT), PATINA_WRAP_PERIODIC, PATINA_WRAP_CLAMP},
        {color.x + start, color.y + start, color.z + start}, nullptr);
    if (result != PATINA_OK) status = result;
  }
  return status;
}

PatinaStatus TextureService::size(const PatinaTexture* texture, uint32_t* width, uint32_t* height,
                                  uint32_t* channels) {
  if (width) *width = texture ? texture->file.width : 1;
  if (height) *height = texture ? texture->file.height : 1;
  if (channels) *channels = texture ? texture->file.channels : 1;
  return texture ? PATINA_OK : PATINA_ERROR_RESOURCE;
}

}  // namespace patina
