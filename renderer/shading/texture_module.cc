// SPDX-License-Identifier: Apache-2.0
// The module that looks textures up: OpenImageIO's TextureSystem behind a table of plain C functions.
#include "renderer/shading/texture_module.h"

#include <OpenImageIO/imagecache.h>
#include <OpenImageIO/texture.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string_view>
#include <vector>

#include "renderer/shading/texture_color_module.h"
#include "renderer/shading/texture_input_module.h"
#include "renderer/shading/texture_make_module.h"

namespace {

using OIIO::TextureSystem;
using OIIO::TypeDesc;
using OIIO::ustring;

void say(char* error, size_t size, const std::string& text) {
  if (size) std::snprintf(error, size, "%s", text.c_str());
}

/// Systems that are not in use. OpenImageIO 2.4 keeps what a thread knows of a cache, its last tiles among
/// it, under the address of the cache, even when that is gone: another one in the same place would be given
/// them. So no system ever ends. What the next user finds has been emptied.
std::mutex idleMutex;
std::vector<TextureSystem*> idle;

TextureSystem* takeIdle() {
  const std::scoped_lock lock(idleMutex);
  if (idle.empty()) return nullptr;
  TextureSystem* system = idle.back();
  idle.pop_back();
  return system;
}

/// What `create` hands out.
struct System {
  TextureSystem* textures = nullptr;
  OCIO_NAMESPACE::ConstConfigRcPtr config;  // null: none
};

void* create(size_t budget, const char* ocioConfig, char* error, size_t errorSize) try {
  auto system = std::make_unique<System>();
  system->textures = takeIdle();
  if (!system->textures) system->textures = TextureSystem::create(false);
  TextureSystem* const textures = system->textures;
  if (!textures) return nullptr;
  textures->attribute("max_memory_MB", std::max(1.0f, static_cast<float>(budget) / (1 << 20)));
  textures->attribute("autotile", 64);
  textures->attribute("automip", 1);
  textures->attribute("accept_untiled", 1);
  textures->attribute("accept_unmipped", 1);
  if (*ocioConfig) {
    try {
      system->config = OCIO_NAMESPACE::Config::CreateFromFile(ocioConfig);
    } catch (const std::exception& e) {
      say(error, errorSize, e.what());
    }
  }
  return system.release();
} catch (const std::exception&) {
  return nullptr;
}

void destroy(void* handle) {
  const std::unique_ptr<System> system(static_cast<System*>(handle));
  TextureSystem* const textures = system->textures;
  textures->invalidate_all(true);  // files may be others under the same names
  textures->geterror();
  const std::scoped_lock lock(idleMutex);
  idle.push_back(textures);
}

int open(void* handle, const char* path, int32_t data, PatinaTextureInfo* info, char* error,
         size_t errorSize) try {
  const auto* system = static_cast<System*>(handle);
  TextureSystem* const textures = system->textures;
  std::string name = path;
  const auto file = OIIO::ImageInput::open(name);
  if (!file) {
    say(error, errorSize, OIIO::geterror());
    return 0;
  }
  if (const std::string problem = patina::textures::sizeProblem(name, file->spec()); !problem.empty()) {
    say(error, errorSize, problem);
    return 0;
  }
  if (const std::string problem = patina::textures::endProblem(*file); !problem.empty()) {
    say(error, errorSize, problem);
    return 0;
  }
  if (!data) {
    if (const auto* conversion = patina::textures::conversionOf(name, file->spec(), system->config)) {
      name = patina::textures::convertedName(name, *conversion);
      const OIIO::ImageSpec config = patina::textures::converterConfig(*conversion);
      textures->imagecache()->add_file(ustring(name), patina::textures::makeConvertingInput, &config, true);
    }
  }
  TextureSystem::TextureHandle* const texture = textures->get_texture_handle(ustring(name));
  int resolution[2] = {0, 0}, channels = 0;
  if (texture && textures->good(texture) &&
      textures->get_texture_info(texture, nullptr, 0, ustring("resolution"), TypeDesc(TypeDesc::INT, 2),
                                 resolution) &&
      textures->get_texture_info(texture, nullptr, 0, ustring("channels"), TypeDesc::INT, &channels) &&
      resolution[0] > 0 && resolution[1] > 0 && channels > 0) {
    const char* wraps = nullptr;
    const bool says =
        textures->get_texture_info(texture, nullptr, 0, ustring("wrapmodes"), TypeDesc::STRING, &wraps);
    textures->geterror();
    *info = {texture, static_cast<uint32_t>(resolution[0]), static_cast<uint32_t>(resolution[1]),
             static_cast<uint32_t>(channels), says && wraps && *wraps};
    return 1;
  }
  const std::string reason = textures->geterror();
  say(error, errorSize, reason.empty() ? "it is no image" : reason);
  return 0;
} catch (const std::exception& e) {
  say(error, errorSize, e.what());
  return 0;
}

/// OpenImageIO makes a table of columns times rows: numbers of more digits than tiles need are kept from it.
bool numbersAreSmall(const std::string& pattern) {
  constexpr int kMostDigits = 3;
  const std::filesystem::path path(pattern);
  const std::string name = path.filename().string();
  if (name.find("UDIM") != std::string::npos) return true;  // four digits, by their definition
  const std::string head = name.substr(0, name.find_first_of("<%"));
  std::error_code failed;
  const std::filesystem::path folder = path.parent_path();
  for (const auto& entry : std::filesystem::directory_iterator(folder.empty() ? "." : folder, failed)) {
    const std::string file = entry.path().filename().string();
    if (!file.starts_with(head)) continue;
    int digits = 0;
    for (size_t i = head.size(); i < file.size(); ++i) {
      digits = file[i] >= '0' && file[i] <= '9' ? digits + 1 : 0;
      if (digits > kMostDigits) return false;
    }
  }
  return true;
}

int tiles(void* handle, const char* pattern, PatinaTileSink sink, void* context, char* error,
          size_t errorSize) try {
  if (!numbersAreSmall(pattern)) {
    say(error, errorSize, "a file of that pattern has a number above 999");
    return 0;
  }
  std::vector<ustring> names;
  int columns = 0, rows = 0;
  static_cast<System*>(handle)->textures->inventory_udim(ustring(pattern), names, columns, rows);
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      if (const ustring& name = names[static_cast<size_t>(row * columns + column)]; !name.empty())
        sink(context, static_cast<uint32_t>(column), static_cast<uint32_t>(row), name.c_str());
  return 1;
} catch (const std::exception& e) {
  say(error, errorSize, e.what());
  return 0;
}

OIIO::TextureOpt::Wrap wrapOf(int32_t wanted, const PatinaTextureInfo& texture) {
  if (wanted == PATINA_WRAP_CLAMP) return OIIO::TextureOpt::WrapClamp;
  return wanted == PATINA_WRAP_FILE && texture.wraps ? OIIO::TextureOpt::WrapDefault
                                                     : OIIO::TextureOpt::WrapPeriodic;
}

float at(const PatinaPlane& plane, uint32_t i) { return plane.data ? plane.data[i * plane.stride] : 0.0f; }

uint32_t lookup(void* handle, const PatinaTextureInfo* texture, uint32_t count, const PatinaTextureLookup* in,
                PatinaOut3 color, float* alpha, char* error, size_t errorSize) try {
  TextureSystem* const textures = static_cast<System*>(handle)->textures;
  auto* const file = static_cast<TextureSystem::TextureHandle*>(texture->handle);
  TextureSystem::Perthread* const thread = textures->get_perthread_info();
  // Grey, or grey and alpha, or colour, or colour and alpha.
  const int wanted = static_cast<int>(std::min(texture->channels, 4u));
  const bool grey = wanted < 3;
  OIIO::TextureOpt options;
  options.swrap = wrapOf(in->wrap_s, *texture);
  options.twrap = wrapOf(in->wrap_t, *texture);
  options.interpmode = OIIO::TextureOpt::InterpBilinear;  // cubic ones leave the range of the texels
  uint32_t failed = 0;
  for (uint32_t i = 0; i < count; ++i) {
    float texel[4] = {1, 1, 1, 1};
    if (!textures->texture(file, thread, options, at(in->s, i), at(in->t, i), at(in->width_s, i), 0, 0,
                           at(in->width_t, i), wanted, texel)) {
      ++failed;
      std::fill(texel, texel + 4, 1.0f);
    }
    color.x[i] = texel[0];
    color.y[i] = texel[grey ? 0 : 1];
    color.z[i] = texel[grey ? 0 : 2];
    if (alpha) alpha[i] = wanted == 2 ? texel[1] : wanted == 4 ? texel[3] : 1.0f;
  }
  if (failed) say(error, errorSize, textures->geterror());
  return failed;
} catch (const std::exception& e) {
  say(error, errorSize, e.what());
  return count;
}

uint64_t bytes(void* handle) {
  OIIO::TypeDesc type(TypeDesc::INT64);
  int64_t used = 0;
  static_cast<System*>(handle)->textures->getattribute("stat:cache_memory_used", type, &used);
  return static_cast<uint64_t>(std::max<int64_t>(used, 0));
}

}  // namespace

extern "C" __attribute__((visibility("default"))) const PatinaTextureModule patina_texture_module_v2 = {
    PATINA_TEXTURE_MODULE_VERSION, create, destroy, open, tiles, lookup, bytes, patina::textures::isPicture,
    patina::textures::make};
