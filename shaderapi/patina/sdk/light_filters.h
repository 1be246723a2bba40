// SPDX-License-Identifier: Apache-2.0
// What stands in the way of a light: filters that shaders of lights multiply their radiance by.
#pragma once

#include "parameters.h"

namespace patina::sdk {

/// A ramp over the distance from the light: `near` up to the distance `begin`, `far` from `end` on, and
/// between them in proportion. Without an `end` above 0 it filters nothing. Lights with a ramp do not fall
/// off with the square of the distance: they must not say Prepare::lightFrom().
struct DistanceRamp {
  float begin = 0, end = 0;  ///< world units
  Color near{1}, far{0};

  DistanceRamp() = default;
  /// By the parameters of a light that has FilterParameters.
  template <class P>
  explicit DistanceRamp(const P& p)
      : begin(p.rampbegin), end(p.rampend), near(p.rampbegincolor), far(p.rampendcolor) {}

  PATINA_INLINE bool filters() const { return end > 0; }
  PATINA_INLINE Color operator()(float distance) const {
    const float length = end - begin;
    // A step where it has no length.
    const float t = length > 0 ? clamp((distance - begin) / length, 0, 1) : distance < end ? 0.0f : 1.0f;
    return filters() ? mix(near, far, t) : Color(1);
  }
  /// The largest factor in each channel.
  PATINA_INLINE Color most() const {
    const Color m(std::max(near.r, far.r), std::max(near.g, far.g), std::max(near.b, far.b));
    return filters() ? m : Color(1);
  }
};

/// What lights without extent have in common: their Parameters derive from it, and their description has
/// `filterParameters<Parameters>()`.
struct FilterParameters {
  Color shadowcolor = 0;
  float rampbegin = 0, rampend = 0;
  Color rampbegincolor = 1, rampendcolor = 0;
};
template <class P>
constexpr auto filterParameters() {
  const auto own = []<class T>(const char* name, T FilterParameters::*member, const char* doc, Range range) {
    return uniform(name, static_cast<T P::*>(member), doc, range);
  };
  return std::tuple{
      own("shadowcolor", &FilterParameters::shadowcolor,
          "share of the light that gets into its shadows; the renderer sees to it", kUnitRange),
      own("rampbegin", &FilterParameters::rampbegin,
          "where a ramp over the distance begins, which the light is multiplied by", kPositive),
      own("rampend", &FilterParameters::rampend, "where it ends, world units; 0 = no ramp", kPositive),
      own("rampbegincolor", &FilterParameters::rampbegincolor, "the factor up to rampbegin", kPositive),
      own("rampendcolor", &FilterParameters::rampendcolor, "the factor from rampend on", kPositive)};
}

}  // namespace patina::sdk
