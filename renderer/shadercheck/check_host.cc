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

}  // namespace

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

  static const void* extension(void* host, const char* id) {
    static constexpr PatinaLobeRegistry kLobes = {sizeof(PatinaLobeRegistry), 0, addLobe};
    if (!id) self(host).complain("gave extension() NULL");
    return id && std::string_view(id) == PATINA_EXTENSION_CUSTOM_LOBES ? &kLobes : nullptr;
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
