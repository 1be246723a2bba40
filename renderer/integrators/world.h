// SPDX-License-Identifier: Apache-2.0
// Everything that integrators ask about a frame: geometry, rays, shaders and lights, built from a scene.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "renderer/accel/accel.h"
#include "renderer/base/sampling.h"
#include "renderer/film/film.h"
#include "renderer/integrators/light_list.h"
#include "renderer/integrators/render.h"
#include "renderer/shading/bsdf.h"
#include "renderer/shading/displacement_shading.h"
#include "renderer/shading/lights.h"
#include "renderer/shading/plugin_loader.h"
#include "renderer/shading/shader_host.h"
#include "renderer/shading/surface_shading.h"
#include "renderer/shading/texture_service.h"

namespace patina {

class OpacityCache;

/// The width per length of a ray to a light, one of `rays` that share the light: the root of its share of the
/// solid angle. Rays to lights without a size keep their width.
inline float raySpread(const LightSample& to, int rays) {
  constexpr float kHemisphere = 2.5f;  // root of 2 pi
  return to.delta ? 0 : std::min(1 / std::sqrt(to.pdf * static_cast<float>(rays)), kHemisphere);
}

class World final : private GeometryListener {
 public:
  /// Loads shaders, builds geometry and acceleration structures. Throws std::runtime_error when nothing can
  /// be rendered.
  World(const Scene& scene, const RenderSettings& settings, ErrorHandler& errors);
  ~World() override;

  const Scene& scene() const { return scene_; }
  const RenderSettings& settings() const { return settings_; }
  const RasterCamera& camera() const { return camera_; }
  const Geometry& geometry() const { return *geometry_; }
  const Accel& accel() const { return *accel_; }
  const SurfaceShading& shading() const { return *shading_; }
  const Lights& lights() const { return *lights_; }
  const Attributes& attributesOf(uint32_t placement) const {
    return geometry_->attributes(geometry_->placements()[placement]);
  }
  /// The shader of a placement's Atmosphere; nullptr: it is seen through clear air. [any thread]
  const ShaderInstance* atmosphereOf(uint32_t placement) const {
    const uint32_t shader = attributesOf(placement).atmosphere;
    return shader == kNone ? nullptr : airShaders_[shader];
  }
  /// The lights that illuminate a placement.
  const LightList& lightsOf(uint32_t placement) const { return lightLists_[lightListOf_[placement]]; }

  /// Fires a few of the rays that a picture of these pixels is going to need, with diffuse reflections if
  /// asked for, so that what they meet can settle (Accel::settle): less than a hundredth of all its rays.
  /// Before anyone traces. [main]
  void settle(const PixelRect& pixels, bool reflections);

  bool interrupted() const { return settings_.interrupted && settings_.interrupted(); }

  /// A ray from a facet to a sample of a light; `time`: see rayTime().
  struct ShadowRay {
    Facet from;
    const LightSample* to;
    uint32_t light;  ///< says whether it casts shadows at all
    float time;
    // What the ray stands for, for the opacity cache: its width where it leaves, and what it gains per
    // length.
    float width = 0, spread = 0;
  };
  /// Share of light that passes from each facet to its target, or without end along its direction when the
  /// distance is infinite: 0 or 1 among opaque surfaces, and more where the light's shadows have a colour.
  /// Without a cache every surface is asked at the very point that a ray meets. [any thread]
  void transmittance(std::span<const ShadowRay> rays, std::span<Rgb> shares,
                     const OpacityCache* cache = nullptr) const;

  /// Lets rays go on through what they have met, which is not opaque, for the rays that `which` names.
  /// shares[k] is multiplied by what which[k] meets lets pass, and the ray's origin moved behind that, unless
  /// next to nothing is left: then the share is black. widths[i] is how wide ray i is at its hit. [any
  /// thread]
  void letPass(std::span<Ray> rays, std::span<const Hit> hits, std::span<const uint32_t> which,
               std::span<const float> widths, const OpacityCache* cache, std::span<Rgb> shares) const;

  /// Whether diffuse rays see lobes: see RenderSettings::caustics.
  bool caustics() const { return settings_.caustics.value_or(scene_.options.caustics); }

  /// Whether camera rays have a time: something moves, or the camera does.
  bool moves() const { return geometry_->moves() || camera_.moves(); }
  /// The time (see Ray) of a ray that is not the camera's and leaves `placement`. It is the opening of the
  /// shutter, where surfaces are shaded, unless some primitive is to be seen in motion by all rays
  /// (Attribute "trace" "samplemotion"): then it is drawn from `seed`. Rays from what moves itself always
  /// leave at the opening: later it would stand in their way.
  float rayTime(uint32_t placement, uint64_t seed) const {
    if (!geometry_->samplesMotion() || geometry_->placements()[placement].moves) return 0;
    constexpr uint64_t kTimeStream = 0x74696d65;
    return toUnit(static_cast<uint32_t>(hashOf(seed, kTimeStream) >> 32));
  }
  /// What is shaded where a camera ray met a surface: of one that moves the same point at the opening of the
  /// shutter, looked at from where the camera is then. `point` is that of the hit.
  ShadingPoint seenAt(ShadingPoint point) const;

  /// The points where rays met something, for the hits that `which` names: see SurfaceShading::at().
  /// `rayOf(k)`: the direction, unit, and the width of ray k there. [any thread]
  template <class RayOf>
  void pointsAt(std::span<const Hit> hits, std::span<const uint32_t> which, RayOf rayOf,
                std::vector<ShadingPoint>& points) const {
    thread_local std::vector<uint32_t> order;
    order.resize(which.size());
    for (uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    geometry_->orderByUnit(order, [&](uint32_t i) { return hits[which[i]].placement; });
    points.resize(which.size());
    for (const uint32_t i : order) {
      const std::pair<V3f, float> ray = rayOf(which[i]);
      points[i] = shading_->at(hits[which[i]], ray.first, ray.second);
    }
  }

  /// Sum of Cl of the ambient lights at each point, multiplied by the points' ambient terms, added to
  /// `radiance`.
  void addAmbient(std::span<const ShadingPoint> points, std::span<const SurfaceTerms> terms,
                  std::span<Rgb> radiance) const;

  int samplesPerPixel() const { return samplesPerPixel_; }  ///< at most
  /// What every seed of random numbers is combined with (exclusive or): a hash of RenderSettings::seed, 0 for
  /// seed 0.
  uint64_t frameSeed() const { return frameSeed_; }
  /// The command that makes pixels again, [x0, x1) x [y0, y1) of the raster.
  std::string replayCommand(int x0, int y0, int x1, int y1) const;
  /// Hands the messages of shaders to the error handler.
  void summarize(ErrorHandler& errors);

 private:
  std::unique_ptr<ShaderInstance> makeShader(const ShaderBinding& binding, const char* role,
                                             ShaderHost& host);
  void traceShadows(std::span<const ShadowRay> rays, std::span<Rgb> shares, const OpacityCache* cache) const;
  void begin(GeometryPart& part) override;
  void end(const GeometryPart& part) override;
  std::string howToReplay(const V3f& at) const;
  void addLightLists(const GeometryPart& part);
  void loadShaders();

  const Scene& scene_;
  const RenderSettings& settings_;
  ErrorHandler& errors_;
  RasterCamera camera_;
  std::unique_ptr<TextureService> textures_;
  std::vector<std::unique_ptr<ShaderHost>> hosts_;  ///< of the scene, then of delayed archives
  std::map<const GeometryPart*, ShaderHost*> hostOf_;
  std::unique_ptr<PluginLoader> loader_;
  std::vector<std::unique_ptr<ShaderInstance>> shaders_;
  std::vector<const ShaderInstance*> shaderPointers_;
  std::unique_ptr<DisplacementShading> displacement_;
  StableVector<const ShaderInstance*> airShaders_;  ///< by shader: nullptr where it is no atmosphere
  std::vector<bool> tried_;                         ///< by shader: was to be loaded
  std::unique_ptr<Geometry> geometry_;
  std::unique_ptr<Accel> accel_;
  std::unique_ptr<SurfaceShading> shading_;
  std::unique_ptr<Lights> lights_;
  std::map<std::vector<uint32_t>, uint32_t> knownLists_;  ///< lights to index of lightLists_
  StableVector<LightList> lightLists_;
  StableVector<uint32_t> lightListOf_;  ///< by placement
  int samplesPerPixel_;
  uint64_t frameSeed_;
};

}  // namespace patina
