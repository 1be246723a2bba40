// SPDX-License-Identifier: Apache-2.0
// Where light comes from and goes to at most: what is needed to tell which of many lights matter at a point.
#pragma once

#include "renderer/base/math.h"

namespace patina {

/// A point that is to be lit. World space.
struct LightReceiver {
  V3f P{0, 0, 0};
  V3f normal{0, 0,
             0};  ///< unit, of the facet, on the side that is shaded; zero: light counts from everywhere
  bool bothSides = false;  ///< what comes from behind scatters, too
};

/// Directions of light from one or several lights: within `beyond` of a direction that is within `spread` of
/// the axis. A facet has spread 0 and beyond pi/2; a point light has spread pi. (Conty Estevez and Kulla
/// 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting", section 4.1.)
struct LightCone {
  V3f axis{0, 0, 1};             ///< unit
  float spread = 0, beyond = 0;  ///< radians, in [0, pi]

  static LightCone everywhere() { return {{0, 0, 1}, kPi, kPi / 2}; }
  /// The smallest cone about both, or a little more.
  static LightCone merged(const LightCone& a, const LightCone& b);
  /// What a light of these directions gives off in all, as a multiple of what it sends along its axis: 4 pi
  /// of a point light, pi of a facet (the paper's M_Omega).
  double measure() const;
};

/// All that the choice among lights knows of one. Bounds hold for certain; `power` is a guess.
struct LightBounds {
  Box3f box;  ///< world space. Empty: the light does not fall off with distance, or nobody knows where it is
  LightCone cone = LightCone::everywhere();
  bool twoSided = false;  ///< the same light goes the opposite way
  /// With a box: irradiance, without shadows, of the inside of a sphere of radius 1 about the light, times 4
  /// pi. Without: irradiance of a facet that faces it, from anywhere. 0 = not known.
  float power = 0;

  bool isPlaced() const { return !box.isEmpty(); }
  /// Irradiance of a facet that faces the light, from a distance of 1, where the cone points to.
  double strength() const {
    return isPlaced() ? power / (std::max(cone.measure(), 1e-4) * (twoSided ? 2 : 1)) : power;
  }
};

}  // namespace patina
