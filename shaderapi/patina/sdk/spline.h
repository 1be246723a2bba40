// SPDX-License-Identifier: Apache-2.0
// RI's spline: a Catmull-Rom curve through numbers or colours.
#pragma once

#include <array>

#include "math.h"

namespace patina::sdk {

namespace detail {
/// The cardinal function of Catmull-Rom splines: 1 at 0, 0 at other whole numbers, cubic between, 0 beyond 2.
/// (R. Keys, "Cubic Convolution Interpolation", 1981, found the same.)
PATINA_INLINE constexpr float catmullRom(float t) {
  const float x = t < 0 ? -t : t;
  const float inner = (1.5f * x - 2.5f) * x * x + 1;
  const float outer = ((-0.5f * x + 2.5f) * x - 4) * x + 2;
  return x < 1 ? inner : x < 2 ? outer : 0.0f;
}
}  // namespace detail

/// RSL's spline(x, ...): at x = 0 the second value, at x = 1 the last but one, the others evenly between; the
/// first and the last only steer the curve's ends. x is held within 0 to 1. Between knots the curve may
/// overshoot them by up to an eighth of the differences of neighbours. The sum over all values takes the
/// place of a look-up, which vector code has none of: meant for a dozen of them.
template <class T, size_t N>
PATINA_INLINE constexpr T spline(float x, const std::array<T, N>& values) {
  static_assert(N >= 4, "a spline needs four values: two knots, and one beyond each end");
  const float at = 1 + clamp(x, 0, 1) * static_cast<float>(N - 3);
  T sum{};
  unrolled<static_cast<int>(N)>([&](auto k) PATINA_INLINE_LAMBDA {
    sum = sum + values[k] * detail::catmullRom(at - static_cast<float>(k));
  });
  return sum;
}

}  // namespace patina::sdk
