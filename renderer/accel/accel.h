// SPDX-License-Identifier: Apache-2.0
// Rays against the geometry of a frame. The only room that knows Embree.
#pragma once

#include <memory>
#include <span>

#include "renderer/geometry/geometry.h"

namespace patina {

/// A ray in world space. `direction` need not be unit length; `t` counts in its lengths.
struct Ray {
  V3f origin{0, 0, 0}, direction{0, 0, 1};
  float tNear = 0, tFar = kInfinity;
  uint32_t mask = kCameraRay;  ///< RayMask bit of its kind
  float time = 0;              ///< 0 to 1, from the opening of the shutter to its closing
};

/// Where a ray met a surface first; placement == kNone: nowhere.
struct Hit {
  float t = kInfinity;
  uint32_t placement = kNone;
  uint32_t face = 0;
  float u = 0, v = 0;  ///< of the face
  bool front = true;   ///< the outside was met
  /// Where the ray leaves what it met behind, in units of t: of placements that move, which were met
  /// elsewhere than where they are shaded. 0 for all others: see leave().
  float beyond = 0;
  bool valid() const { return placement != kNone; }
};

class Accel {
 public:
  /// Builds Embree's scenes on all threads. `geometry` must outlive the accelerator.
  explicit Accel(const Geometry& geometry);
  ~Accel();

  /// Moves the units that rays have met so far from structures of their own into that of the scene, the
  /// smallest first, as far as half of the budget of facets goes: rays take a fifth to two fifths less time
  /// there. They are never dropped then. What moves, solids and delayed archives stay as they are. Nobody may
  /// trace meanwhile. Among surfaces in exactly the same place another one may be met than before. [main]
  void settle();

  Hit intersect(const Ray& ray) const;  ///< [any thread]
  bool occluded(const Ray& ray) const;  ///< [any thread] anything between tNear and tFar
  /// Many rays, each by itself: the same as one call for each. Where facets go and come back for want of
  /// memory, a batch has each unit made once; so batches had better be large. hits.size() == rays.size().
  /// [any thread]
  void intersect(std::span<const Ray> rays, std::span<Hit> hits) const;
  void occluded(std::span<const Ray> rays,
                std::span<uint8_t> occluded) const;  ///< likewise; 1 = met something
  /// Rays in groups of sixteen; pays for coherent ones. [any thread]
  void intersectMany(std::span<const Ray> rays, std::span<Hit> hits) const;

 private:
  struct Scenes;
  std::unique_ptr<Scenes> scenes_;
};

/// The origin of a ray that leaves a facet: moved off its plane, to the side of `direction`, by the bound on
/// the error of both, and no further (PBR 4th ed. section 6.8.6).
V3f leave(const Facet& facet, const V3f& direction);

/// The origin of a ray that goes on behind what it has met. `facet` is that of the hit.
inline V3f goOn(const Ray& ray, const Hit& hit, const Facet& facet) {
  return hit.beyond > 0 ? ray.origin + ray.direction * hit.beyond : leave(facet, ray.direction);
}

}  // namespace patina
