// SPDX-License-Identifier: Apache-2.0
// The normal of a parametric surface, with its limit where the derivatives are degenerate.
#pragma once

#include "renderer/base/math.h"

namespace patina {

/// The unit vector along du x dv at (u, v) of the unit square. Where the derivatives vanish or are parallel
/// (poles, collapsed edges), the limit from the inside of the square: `crossAt(u, v)` gives du x dv of other
/// points, and two of them are extrapolated. (0, 0, 1) if the surface has no normal there either.
template <typename CrossAt>
V3d limitNormal(const V3d& du, const V3d& dv, double u, double v, const CrossAt& crossAt) {
  const auto unit = [](const V3d& n) {
    const double scale = std::max({std::abs(n.x), std::abs(n.y), std::abs(n.z)});
    if (!(scale > 0)) return V3d(0);
    const V3d scaled = n / scale;
    return scaled / std::sqrt(scaled.dot(scaled));
  };
  const V3d n = du.cross(dv);
  const double larger = std::max(du.length2(), dv.length2());
  constexpr double kDegenerate = 1e-9;  // of the sine times the ratio of the lengths
  if (n.length2() > kDegenerate * kDegenerate * larger * larger) return unit(n);
  constexpr double kStep = 1.0 / 1024;
  for (double h = 2 * kStep; h < 1; h *= 16) {
    const V3d far = unit(crossAt(u + h * (0.5 - u), v + h * (0.5 - v)));
    const V3d near = unit(crossAt(u + h / 2 * (0.5 - u), v + h / 2 * (0.5 - v)));
    if (near.length2() > 0.5 && far.length2() > 0.5) return unit(near * 2.0 - far);
  }
  const V3d plain = unit(n);
  return plain.length2() > 0.5 ? plain : V3d(0, 0, 1);
}

}  // namespace patina
