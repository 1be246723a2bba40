// SPDX-License-Identifier: Apache-2.0
// View-independent light: B = emission + ambient + rho E(front)/pi + tau E(back)/pi at points and at patch
// vertices, with the multiresolution cache or without it.
//
// Every result is a function of its arguments and of the scene: random numbers are hashed from the place and
// depth that they are for, so that neither threads, nor what happens to be cached, change a bit of it.
#pragma once

#include <memory>
#include <vector>

#include "renderer/base/sampling.h"
#include "renderer/cache/patch_cache.h"
#include "renderer/integrators/world.h"

namespace patina {

/// What a point is shaded for, which says how much it may cost.
enum class Purpose : uint8_t {
  Vertex,      ///< of the camera's micropolygons (depth 0), or of the coarse and medium level of the cache
  FineVertex,  ///< of the cache's fine level: its neighbours are so near that they share the work
  Ray          ///< a part of a larger estimate: one ray of each kind
};

/// How many rays a shading point gets by its diffuse depth.
struct RayBudget {
  int diffuse0 = 128;  ///< gather rays at depth 0
  int light0 = 16;     ///< rays to an area or sky light at depth 0
  int diffuse(int depth, Purpose purpose) const;
  int light(int depth, Purpose purpose) const;
};

class RadiosityEngine {
 public:
  /// Diffuse depths up to this have entries of their own; deeper light is followed by random walks.
  static constexpr int kCachedDepths = 4;

  struct Settings {
    bool cached = true;
    bool indirect = true;
    RayBudget rays;
    size_t cacheBytes = size_t{256} << 20;
    float levelScale = 0.35f;  ///< a level is fine enough when its spacing is at most so many ray footprints
  };
  RadiosityEngine(const World& world, const Settings& settings);

  /// Where random numbers come from: points of equal seed get equal numbers.
  struct Request {
    ShadingPoint point;
    uint64_t seed;
  };

  /// Radiance B that leaves each point, at diffuse depth `depth`, sampled anew.
  /// [any thread]
  void shade(std::span<const Request> requests, int depth, Purpose purpose, std::span<Rgb> out) const;

  /// A vertex of the fine level of a patch, as seen at diffuse depth 0.
  struct Vertex {
    uint32_t patch;
    bool front;
    uint16_t index;
    bool operator==(const Vertex&) const = default;
  };
  /// B at vertices, from the cache or made and kept. [any thread]
  void vertices(std::span<const Vertex> wanted, std::span<Rgb> out) const;

  /// Whether something stands between the vertices around a point, so that interpolating them would carry
  /// light or darkness through it (a vertex inside a box that stands on the patch, or behind a wall). [any
  /// thread]
  bool separated(uint32_t patch, bool front, const VertexWeights& around) const;

  const World& world() const { return world_; }
  const PatchCache* cache() const { return cache_.get(); }
  void report() const;  ///< figures of the cache that are known at the end only [main]

 private:
  struct Workspace;
  struct GatherRay;
  Workspace& workspace(int nesting) const;
  Request vertexRequest(uint32_t patch, bool front, Level level, uint32_t vertex, int depth) const;
  void addDirect(std::span<const Request> requests, int depth, Purpose purpose, Workspace& w) const;
  void addIndirect(std::span<const Request> requests, int depth, Purpose purpose, Workspace& w,
                   int nesting) const;
  void follow(GatherRay ray, bool bounce, int depth, Workspace& w, int nesting) const;
  bool cachedRadiance(const Hit& hit, float footprint, int depth, int nesting, Rgb& out) const;
  bool blocked(const ShadingPoint& a, const ShadingPoint& b) const;
  void fill(uint32_t patch, bool front, Level level, int depth, int nesting,
            std::vector<uint64_t>& codes) const;
  /// Codes of the fine vertices around a point, from the cache or made and kept: vertex by vertex, as few
  /// rays need them, and a miss must not cost a whole patch.
  void fineVertices(uint32_t patch, bool front, const VertexWeights& around, int depth, int nesting,
                    uint64_t codes[4]) const;
  void shadeNested(std::span<const Request> requests, int depth, Purpose purpose, std::span<Rgb> out,
                   int nesting) const;
  Rgb specularTail(const ShadingPoint& point, uint64_t seed, int depth, float footprint, int nesting) const;

  const World& world_;
  Settings settings_;
  std::unique_ptr<PatchCache> cache_;
};

}  // namespace patina
