// SPDX-License-Identifier: Apache-2.0
// Where a ray has met a very large facet.
#pragma once

#include "renderer/integrators/world.h"

namespace patina {

/// Gives `point`, which was made of `hit`, the place along the ray where that knows it better. A facet's own
/// parameters are floats, and say where in the facet the point is to 6e-8 of the facet's size: half a
/// millimetre on a ground of ten kilometres. The ray knows it to a few roundings of its origin and of its
/// length (PBR 4th ed. section 6.8), but for its distance from the facet's plane, which the projection takes
/// out. What differs by less than the ray's own error stays as it is, and so does what is met through an
/// instance or moves.
inline void placeAlongRay(ShadingPoint& point, const World& world, const Ray& ray, const Hit& hit) {
  const Placement& placement = world.geometry().placements()[point.placement];
  if (placement.instance != kNone || placement.moves) return;
  const V3f met = ray.origin + ray.direction * hit.t, off = met - point.P;
  const float error =
      roundingBound(16) * (maxAbsComponent(ray.origin) + hit.t * maxAbsComponent(ray.direction));
  const V3f along = off - point.Ng * point.Ng.dot(off);
  if (maxAbsComponent(along) > error && isFinite(along)) point.P += along;
}

}  // namespace patina
