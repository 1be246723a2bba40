// SPDX-License-Identifier: Apache-2.0
// The lights of a frame: sampling them in batches through their shaders, and what rays that meet them see.
#pragma once

#include <memory>
#include <vector>

#include "renderer/shading/emitters.h"
#include "renderer/shading/light_bounds.h"
#include "renderer/shading/shader_instance.h"
#include "renderer/shading/shading_point.h"

namespace patina {

class Planes;

/// Light from one direction. A surface with BRDF f receives f * radiance * cos / pdf.
struct LightSample {
  V3f direction{0, 0, 1};  ///< unit, towards the light
  Rgb radiance{0, 0, 0};   ///< of a delta light: pi * Cl, that is irradiance of a facing surface, with pdf 1
  float pdf = 0;           ///< per solid angle; 0 = no light
  bool delta = false;      ///< no BSDF sample can find it
  V3f target{0, 0, 0};     ///< the point of the light, moved off its surface, when `distance` is finite
  float distance = kInfinity;
};

class Lights {
 public:
  /// `shaders[k]` belongs to Scene::shaders[k]. [main]
  Lights(const Geometry& geometry, std::span<const ShaderInstance* const> shaders);
  ~Lights();

  size_t count() const { return lights_.size(); }
  PatinaLightKind kind(uint32_t light) const { return lights_[light].kind; }
  bool castsShadows(uint32_t light) const { return lights_[light].castsShadows; }
  /// Radiance that hardly depends on direction: found better by sampling the surface's lobes than by sampling
  /// the light.
  bool isSmooth(uint32_t light) const { return lights_[light].smooth; }
  /// A sky that is sampled, as it is brighter here than there, and that rays of surfaces meet as well.
  bool isShared(uint32_t light) const {
    const Entry& e = lights_[light];
    return e.kind == PATINA_LIGHT_INFINITE && !e.smooth && e.castsShadows;
  }
  bool isDelta(uint32_t light) const { return lights_[light].kind == PATINA_LIGHT_DELTA; }
  /// The share of its light that gets into its shadows, 0 to 1: what its shader's uniform parameter
  /// "shadowcolor" is, if there is one. Black of all but delta lights: rays find the others as well.
  const Rgb& shadowColor(uint32_t light) const { return lights_[light].shadowColor; }
  bool hasShadowColors() const { return hasShadowColors_; }  ///< that are not black
  bool twoSided(uint32_t light) const { return lights_[light].twoSided; }
  bool seenByCamera(uint32_t light) const { return lights_[light].cameraVisible; }
  float power(uint32_t light) const { return lights_[light].power; }
  /// Where its light comes from and goes to, for a LightTree.
  LightBounds bounds(uint32_t light) const;
  /// Lights of kind INFINITE, ascending.
  std::span<const uint32_t> infinite() const { return infinite_; }

  /// One sample for each point. [any thread]
  void sample(uint32_t light, std::span<const V3f> points, std::span<const V2f> random,
              std::span<LightSample> out) const;
  /// RI's Cl of an ambient light at each point.
  void ambient(uint32_t light, std::span<const V3f> points, std::span<Rgb> out) const;
  /// Radiance of an infinite light from directions, and the density with which sample() picks them.
  void evaluate(uint32_t light, std::span<const V3f> points, std::span<const V3f> directions,
                std::span<Rgb> radiance, std::span<float> pdf) const;
  /// Radiance that a point of an area light sends in unit `direction`.
  Rgb emitted(uint32_t light, const ShadingPoint& point, const V3f& direction, const V2f& surfaceUv) const;
  /// Density with which sample() picks, from `from`, a point met on the light's surface.
  float areaPdf(uint32_t light, const V3f& from, const ShadingPoint& onLight) const;

 private:
  struct Statistics;
  class Checked;
  struct Entry {
    const ShaderInstance* shader = nullptr;
    PatinaLightKind kind = PATINA_LIGHT_NONE;
    bool castsShadows = true, smooth = false, twoSided = false, cameraVisible = false;
    float power = 1;
    Rgb shadowColor{0, 0, 0};
    float scale = 1;  ///< of an area light's radiance: PATINA_TRAIT_PER_AREA
    std::unique_ptr<Emitters> emitters;
    std::unique_ptr<Statistics> statistics;
  };
  PatinaStatus call(const Entry& light, const PatinaLightIn& in, Planes& planes, PatinaLightOut& out) const;

  std::vector<Entry> lights_;
  std::vector<uint32_t> infinite_;
  bool hasShadowColors_ = false;
};

}  // namespace patina
