// SPDX-License-Identifier: Apache-2.0
// Cones of directions.
#include "renderer/shading/light_bounds.h"

namespace patina {

LightCone LightCone::merged(const LightCone& a, const LightCone& b) {
  const LightCone &wide = a.spread >= b.spread ? a : b, &narrow = a.spread >= b.spread ? b : a;
  LightCone all = wide;
  all.beyond = std::max(a.beyond, b.beyond);
  const V3d from(wide.axis), to(narrow.axis);
  const double cosine = from.dot(to), sine = from.cross(to).length();
  // The arc tangent keeps its digits where the axes are nearly the same.
  const double between = std::atan2(sine, cosine);
  if (std::min(between + static_cast<double>(narrow.spread), std::numbers::pi) <=
      static_cast<double>(wide.spread))
    return all;
  const double spread = (between + static_cast<double>(wide.spread) + static_cast<double>(narrow.spread)) / 2;
  // Without a plane to turn in the axis stays: a little too wide, or, of opposite axes, the whole sphere.
  if (!(spread < std::numbers::pi) || !(sine > 1e-6)) {
    const float reach = static_cast<float>(between) + narrow.spread;
    all.spread = spread < std::numbers::pi ? std::min(std::max(reach, wide.spread) * 1.00001f, kPi) : kPi;
    return all;
  }
  // The axis turns towards the narrow cone's until the wide cone just touches the edge.
  const double turn = spread - static_cast<double>(wide.spread);
  const V3d axis = (from * std::sin(between - turn) + to * std::sin(turn)) / sine;
  all.axis = normalizedOr(V3f(axis), wide.axis);
  all.spread = std::min(static_cast<float>(spread) * 1.00001f, kPi);
  return all;
}

double LightCone::measure() const {
  const auto o = static_cast<double>(spread);
  const double w = std::min(o + static_cast<double>(beyond), std::numbers::pi);
  return 2 * std::numbers::pi * (1 - std::cos(o)) +
         std::numbers::pi / 2 *
             (2 * w * std::sin(o) - std::cos(o - 2 * w) - 2 * o * std::sin(o) + std::cos(o));
}

}  // namespace patina
