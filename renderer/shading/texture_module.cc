// SPDX-License-Identifier: Apache-2.0
// The module that looks textures up: OpenImageIO's TextureSystem behind a table of plain C functions.
#include "renderer/shading/texture_module.h"

#include <OpenImageIO/texture.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <mutex>
#include <vector>

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

void* create(size_t budget) try {
  TextureSystem* system = takeIdle();
  if (!system) system = TextureSystem::create(false);
  if (!system) return nullptr;
  system->attribute("max_memory_MB", std::max(1.0f, static_cast<float>(budget) / (1 << 20)));
  system->attribute("autotile", 64);
  system->attribute("automip", 1);
  system->attribute("accept_untiled", 1);
  system->attribute("accept_unmipped", 1);
  return system;
} catch (const std::exception&) {
  return nullptr;
}

void destroy(void* system) {
  auto* textures = static_cast<TextureSystem*>(system);
  textures->invalidate_all(true);  // files may be others under the same names
  textures->geterror();
  const std::scoped_lock lock(idleMutex);
  idle.push_back(textures);
}

void* open(void* system, const char* path, uint32_t* width, uint32_t* height, uint32_t* channels, char* error,
           size_t errorSize) try {
  auto* textures = static_cast<TextureSystem*>(system);
  TextureSystem::TextureHandle* handle = textures->get_texture_handle(ustring(path));
  int resolution[2] = {0, 0}, channelCount = 0;
  if (handle && textures->good(handle) &&
      textures->get_texture_info(handle, nullptr, 0, ustring("resolution"), TypeDesc(TypeDesc::INT, 2),
                                 resolution) &&
      textures->get_texture_info(handle, nullptr, 0, ustring("channels"), TypeDesc::INT, &channelCount) &&
      resolution[0] > 0 && resolution[1] > 0 && channelCount > 0) {
    *width = static_cast<uint32_t>(resolution[0]);
    *height = static_cast<uint32_t>(resolution[1]);
    *channels = static_cast<uint32_t>(channelCount);
    return handle;
  }
  const std::string reason = textures->geterror();
  say(error, errorSize, reason.empty() ? "it is no image" : reason);
  return nullptr;
} catch (const std::exception& e) {
  say(error, errorSize, e.what());
  return nullptr;
}

float at(const PatinaPlane& plane, uint32_t i) { return plane.data ? plane.data[i * plane.stride] : 0.0f; }

int lookup(void* system, void* texture, uint32_t channels, uint32_t count, const PatinaTextureLookup* in,
           PatinaOut3 color, float* alpha, char* error, size_t errorSize) try {
  auto* textures = static_cast<TextureSystem*>(system);
  auto* handle = static_cast<TextureSystem::TextureHandle*>(texture);
  TextureSystem::Perthread* thread = textures->get_perthread_info();
  // Grey, or grey and alpha, or colour, or colour and alpha.
  const int wanted = static_cast<int>(std::min(channels, 4u));
  bool good = true;
  for (uint32_t i = 0; i < count; ++i) {
    OIIO::TextureOpt options;
    options.swrap = OIIO::TextureOpt::WrapPeriodic;
    options.twrap = in->wrap_t ? OIIO::TextureOpt::WrapPeriodic : OIIO::TextureOpt::WrapClamp;
    options.interpmode = OIIO::TextureOpt::InterpBilinear;  // cubic ones leave the range of the texels
    float texel[4] = {1, 1, 1, 1};
    if (!textures->texture(handle, thread, options, at(in->s, i), at(in->t, i), at(in->width_s, i), 0, 0,
                           at(in->width_t, i), wanted, texel)) {
      good = false;
      std::fill(texel, texel + 4, 1.0f);
    }
    const bool grey = wanted < 3;
    color.x[i] = texel[0];
    color.y[i] = texel[grey ? 0 : 1];
    color.z[i] = texel[grey ? 0 : 2];
    if (alpha) alpha[i] = wanted == 2 ? texel[1] : wanted == 4 ? texel[3] : 1.0f;
  }
  if (!good) say(error, errorSize, textures->geterror());
  return good;
} catch (const std::exception& e) {
  say(error, errorSize, e.what());
  return 0;
}

uint64_t bytes(void* system) {
  OIIO::TypeDesc type(TypeDesc::INT64);
  int64_t used = 0;
  static_cast<TextureSystem*>(system)->getattribute("stat:cache_memory_used", type, &used);
  return static_cast<uint64_t>(std::max<int64_t>(used, 0));
}

}  // namespace

extern "C" __attribute__((visibility("default"))) const PatinaTextureModule patina_texture_module_v1 = {
    PATINA_TEXTURE_MODULE_VERSION, create, destroy, open, lookup, bytes};
