// SPDX-License-Identifier: Apache-2.0
// Host services by formulas; arguments are looked at before they are used.
#include "renderer/shadercheck/check_host.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>
#include <utility>

#include "renderer/base/math.h"
#include "renderer/shading/custom_lobe.h"
#include "renderer/shading/plugin_file.h"

namespace patina::shadercheck {
namespace {

float at(const PatinaPlane& plane, uint32_t i) { return plane.data[size_t(i) * plane.stride]; }
bool isThere(const PatinaOut3& out) { return out.x && out.y && out.z; }

// Smooth, without a seam where s and t wrap around, and in [0, 1]; wide look-ups see the mean.
float pattern(float s, float t, float width, float phase) {
  const float contrast = 1 / (1 + std::max(width, 0.0f) * 8);
  const float wave =
      std::cos(2 * kPi * (s - std::floor(s)) + phase) * std::cos(2 * kPi * (t - std::floor(t)));
  return std::clamp(0.5f + 0.45f * contrast * wave, 0.0f, 1.0f);
}

void store(const PatinaOut3& out, uint32_t i, float s, float t, float width) {
  out.x[i] = pattern(s, t, width, 0), out.y[i] = pattern(s, t, width, 1), out.z[i] = pattern(s, t, width, 2);
}

// How far along a ray a ball of radius 3 about the origin is, from inside and from outside.
float distanceToBall(const V3f& origin, const V3f& direction) {
  const V3d o(origin), d = V3d(direction).normalized();
  const double b = o.dot(d), c = o.dot(o) - 9, discriminant = b * b - c;
  if (!(discriminant >= 0)) return PATINA_INFINITE_DISTANCE;
  const double root = std::sqrt(discriminant), t = -b - root > 0 ? -b - root : -b + root;
  return t > 0 ? static_cast<float>(t) : PATINA_INFINITE_DISTANCE;
}

thread_local HostCall* presentCall = nullptr;

}  // namespace

HostCall::HostCall(PatinaEntry entry_, std::span<const Lane> lanes_)
    : entry(entry_), lanes(lanes_), rays(lanes_.size(), 0) {
  presentCall = this;
}
HostCall::~HostCall() { presentCall = nullptr; }

struct CheckHost::Services {
  static CheckHost& self(void* host) { return *static_cast<CheckHost*>(host); }

  static void report(void* host, PatinaReport severity, int32_t, const char* message) {
    if (static_cast<unsigned>(severity) > unsigned{PATINA_REPORT_ERROR})
      self(host).complain("gave report() a severity that is none");
    if (!message) self(host).complain("gave report() no message");
  }

  static int32_t transform(void* host, const char* from, const char* to, float matrix[16]) {
    CheckHost& s = self(host);
    s.checkPreparing("transform()");
    if (!from || !to || !matrix) {
      s.complain("gave transform() NULL");
      return 0;
    }
    for (int i = 0; i < 16; ++i) matrix[i] = i % 5 == 0 ? 1.0f : 0.0f;
    const auto known = [](std::string_view name) {
      return name == "world" || name == "shader" || name == "object" || name == "camera";
    };
    if (!known(from) || !known(to)) return 0;
    const int away = (std::strcmp(to, "camera") == 0) - (std::strcmp(from, "camera") == 0);
    matrix[14] = static_cast<float>(5 * away);
    return 1;
  }

  static PatinaTexture* openTexture(void* host, const char* name) {
    CheckHost& s = self(host);
    s.checkPreparing("open_texture()");
    if (!name) s.complain("gave open_texture() NULL");
    return name && *name ? s.texture() : nullptr;
  }

  static PatinaStatus texture(void* host, PatinaTexture* texture, uint32_t count, PatinaPlane s,
                              PatinaPlane t, PatinaPlane width, PatinaOut3 color, float* alpha) {
    CheckHost& h = self(host);
    if (!h.checkLookup("texture()", texture, count, {s, t, width}, color)) return PATINA_ERROR_PARAMETER;
    for (uint32_t i = 0; i < count; ++i) {
      const float a = at(s, i), b = at(t, i), w = at(width, i);
      if (texture)
        store(color, i, a, b, w);
      else
        color.x[i] = color.y[i] = color.z[i] = 1;
      if (alpha) alpha[i] = texture ? pattern(a, b, w, 3) : 1;
    }
    return PATINA_OK;
  }

  static PatinaStatus environment(void* host, PatinaTexture* texture, uint32_t count, PatinaPlane3 direction,
                                  PatinaPlane width, PatinaOut3 color) {
    CheckHost& h = self(host);
    if (!h.checkLookup("environment()", texture, count, {direction.x, direction.y, direction.z, width},
                       color))
      return PATINA_ERROR_PARAMETER;
    for (uint32_t i = 0; i < count; ++i) {
      const V3f d(at(direction.x, i), at(direction.y, i), at(direction.z, i));
      if (!texture) {
        color.x[i] = color.y[i] = color.z[i] = 1;
        continue;
      }
      if (isBlack(d)) h.complain("gave environment() a direction of no length");
      const float s = 0.5f + std::atan2(d.y, d.x) / (2 * kPi);
      store(color, i, s, std::atan2(std::hypot(d.x, d.y), d.z) / kPi, at(width, i) / kPi);
    }
    return PATINA_OK;
  }

  static PatinaStatus textureSize(void* host, PatinaTexture* texture, uint32_t* width, uint32_t* height,
                                  uint32_t* channels) {
    CheckHost& h = self(host);
    if (!width || !height || !channels || (texture && texture != h.texture())) {
      h.complain("gave texture_size() NULL, or a texture that was never opened");
      return PATINA_ERROR_PARAMETER;
    }
    *width = 512, *height = 256, *channels = 4;
    return PATINA_OK;
  }

  static uint32_t addLobe(void* host, const PatinaCustomLobe* lobe) {
    CheckHost& s = self(host);
    s.checkPreparing("PatinaLobeRegistry.add()");
    if (const std::string fault = findLobeFault(lobe); !fault.empty()) {
      s.complain(fmt::format("registered a lobe that {}", fault));
      return PATINA_LOBE_NONE;
    }
    if (s.lobes_.size() == PATINA_MAX_LOBES) {
      s.complain(fmt::format("registered more than {} lobes", PATINA_MAX_LOBES));
      return PATINA_LOBE_NONE;
    }
    s.lobes_.push_back(lobe);
    return PATINA_LOBE_CUSTOM + static_cast<uint32_t>(s.lobes_.size()) - 1;
  }

  static PatinaTexture* openData(void* host, const char* name) {
    CheckHost& s = self(host);
    s.checkPreparing("PatinaDataTextures.open()");
    if (!name) s.complain("gave PatinaDataTextures.open() NULL");
    return name && *name ? s.texture() : nullptr;
  }

  static const char* findFile(void* host, const char* name) {
    CheckHost& s = self(host);
    s.checkPreparing("PatinaFiles.find()");
    if (!name) s.complain("gave PatinaFiles.find() NULL");
    return nullptr;
  }

  static void setAtmosphere(void* host, PatinaAtmosphereFunction function) {
    CheckHost& s = self(host);
    s.checkPreparing("PatinaAtmospheres.set()");
    if (!function) s.complain("gave PatinaAtmospheres.set() NULL");
    s.atmosphere_ = function;
  }

  static int32_t getAttribute(void* host, const char* name, uint32_t type, uint32_t, PatinaValue* value) {
    CheckHost& s = self(host);
    s.checkPreparing("PatinaAttributes.get()");
    if (!name || !value || componentsOf(type) == 0)
      s.complain("gave PatinaAttributes.get() NULL, or a type that is none");
    return 0;
  }

  static int32_t bindAttribute(void* host, const char* name, const char* parameter) {
    CheckHost& s = self(host);
    s.checkPreparing("PatinaAttributes.bind()");
    if (!name || !*name || !parameter) s.complain("gave PatinaAttributes.bind() NULL or no name");
    return name && *name && parameter ? 1 : 0;
  }

  static int32_t declareRays(void* host, PatinaEntry entry, uint32_t most) {
    CheckHost& s = self(host);
    s.checkPreparing("PatinaRays.declare()");
    if (entry != PATINA_ENTRY_RADIOSITY && entry != PATINA_ENTRY_VIEW) {
      s.complain("declared rays of an entry point that may trace none");
      return 0;
    }
    if (most > PATINA_MAX_RAYS) {
      s.complain(fmt::format("declared {} rays per point, more than {}", most, PATINA_MAX_RAYS));
      return 0;
    }
    s.rays_[entry] = most;
    return 1;
  }

  static PatinaStatus traceRays(void* host, const PatinaRayIn* in, PatinaRayOut* out) {
    CheckHost& s = self(host);
    const auto refuse = [&](std::string text) {
      s.complain(std::move(text));
      return PATINA_ERROR_PARAMETER;
    };
    HostCall* const call = presentCall;
    if (!call || s.rays_[call->entry] == 0) return refuse("traced rays where it has declared none");
    const auto isThere = [](const PatinaPlane& plane) { return plane.data && plane.stride <= 1; };
    const auto areThere = [&](const PatinaPlane3& p) { return isThere(p.x) && isThere(p.y) && isThere(p.z); };
    if (!in || !out || (!out->distance && !out->occluded) || !in->lane || !areThere(in->direction) ||
        !isThere(in->maximum) || (in->origin.x.data && !areThere(in->origin)))
      return refuse("gave PatinaRays.trace() NULL, or a stride that is neither 0 nor 1");
    for (uint32_t i = 0; i < in->count; ++i) {
      if (out->distance) out->distance[i] = PATINA_INFINITE_DISTANCE;
      if (out->occluded) out->occluded[i] = 0;
      const uint32_t lane = in->lane[i];
      if (lane >= call->lanes.size()) return refuse("traced rays of a point that is not in the batch");
      const float maximum = at(in->maximum, i);
      if (std::isnan(maximum)) return refuse("gave a ray a maximum that is not a number");
      if (maximum <= 0) continue;
      if (++call->rays[lane] > s.rays_[call->entry])
        return refuse(fmt::format("traced more rays for a point than the {} that it has declared",
                                  s.rays_[call->entry]));
      const V3f direction(at(in->direction.x, i), at(in->direction.y, i), at(in->direction.z, i));
      const V3f origin = in->origin.x.data
                             ? V3f(at(in->origin.x, i), at(in->origin.y, i), at(in->origin.z, i))
                             : call->lanes[lane].P;
      if (!isFinite(direction) || isBlack(direction) || !isFinite(origin))
        return refuse("traced a ray that is not finite or has no direction");
      const float distance = distanceToBall(origin, direction);
      if (!(distance <= maximum)) continue;
      if (out->distance) out->distance[i] = distance;
      if (out->occluded) out->occluded[i] = 1;
    }
    return PATINA_OK;
  }

  static const void* extension(void* host, const char* id) {
    static constexpr PatinaLobeRegistry kLobes = {sizeof(PatinaLobeRegistry), 0, addLobe};
    static constexpr PatinaDataTextures kDataTextures = {sizeof(PatinaDataTextures), 0, openData};
    static constexpr PatinaFiles kFiles = {sizeof(PatinaFiles), 0, findFile};
    static constexpr PatinaAttributes kAttributes = {sizeof(PatinaAttributes), 0, getAttribute,
                                                     bindAttribute};
    static constexpr PatinaRays kRays = {sizeof(PatinaRays), 0, declareRays, traceRays};
    static constexpr PatinaAtmospheres kAtmospheres = {sizeof(PatinaAtmospheres), 0, setAtmosphere};
    if (!id) {
      self(host).complain("gave extension() NULL");
      return nullptr;
    }
    const std::string_view wanted = id;
    if (wanted == PATINA_EXTENSION_CUSTOM_LOBES) return &kLobes;
    if (wanted == PATINA_EXTENSION_DATA_TEXTURES) return &kDataTextures;
    if (wanted == PATINA_EXTENSION_FILES) return &kFiles;
    if (wanted == PATINA_EXTENSION_ATTRIBUTES) return &kAttributes;
    if (wanted == PATINA_EXTENSION_RAYS) return &kRays;
    if (wanted == PATINA_EXTENSION_ATMOSPHERE) return &kAtmospheres;
    return nullptr;
  }
};

CheckHost::CheckHost() {
  table_ = {sizeof(PatinaHost), PATINA_ABI_MINOR,      this,
            Services::report,   Services::transform,   Services::openTexture,
            Services::texture,  Services::environment, Services::textureSize,
            Services::extension};
}

uint32_t CheckHost::lobeData() const {
  uint32_t most = 0;
  for (const PatinaCustomLobe* lobe : lobes_) most = std::max(most, lobe->data_count);
  return most;
}

PatinaTexture* CheckHost::texture() { return reinterpret_cast<PatinaTexture*>(&texture_); }

void CheckHost::checkPreparing(const char* service) {
  if (!preparing_) complain(fmt::format("called {} outside of prepare", service));
}

bool CheckHost::checkLookup(const char* service, const PatinaTexture* texture, uint32_t count,
                            std::initializer_list<PatinaPlane> planes, const PatinaOut3& color) {
  if (texture && texture != this->texture()) {
    complain(fmt::format("gave {} a texture that was never opened", service));
    return false;
  }
  for (const PatinaPlane& plane : planes) {
    if (!plane.data || plane.stride > 1 || !isThere(color)) {
      complain(fmt::format("gave {} NULL, or a stride that is neither 0 nor 1", service));
      return false;
    }
    for (uint32_t i = 0; i < count; ++i)
      if (!std::isfinite(at(plane, i))) {
        complain(fmt::format("gave {} a coordinate, direction or width that is not finite", service));
        return false;
      }
  }
  return true;
}

std::vector<std::string> CheckHost::takeComplaints() {
  const std::lock_guard lock(mutex_);
  return std::exchange(complaints_, {});
}

void CheckHost::complain(std::string text) {
  const std::lock_guard lock(mutex_);
  if (std::find(complaints_.begin(), complaints_.end(), text) == complaints_.end())
    complaints_.push_back(std::move(text));
}

}  // namespace patina::shadercheck
