// SPDX-License-Identifier: Apache-2.0
// B-spline basis functions over a knot vector.
#pragma once

#include <cstddef>
#include <span>

namespace patina {

/// Splines of a higher order (degree + 1) are refused.
inline constexpr int kMaxSplineOrder = 32;

/// The degree + 1 basis functions that may differ from zero in the knot interval [knots[span],
/// knots[span+1]]: out[k] is function number span - degree + k at t of that interval, which must have a
/// length (Piegl and Tiller, The NURBS Book, 2nd ed., algorithm A2.2). Weights of the recurrence are formed
/// as quotients, so that at a knot of multiplicity degree or more the one function that is left is exactly 1.
inline void splineBasis(std::span<const double> knots, size_t span, size_t degree, double t, double* out) {
  double left[kMaxSplineOrder], right[kMaxSplineOrder];
  out[0] = 1;
  for (size_t j = 1; j <= degree; ++j) {
    left[j - 1] = t - knots[span + 1 - j];
    right[j - 1] = knots[span + j] - t;
    double saved = 0;
    for (size_t r = 0; r < j; ++r) {
      const double whole = right[r] + left[j - 1 - r], value = out[r];
      out[r] = saved + value * (right[r] / whole);
      saved = value * (left[j - 1 - r] / whole);
    }
    out[j] = saved;
  }
}

/// Derivatives of the same functions by t / unit (the NURBS Book, equation 2.7). With `unit` no longer than
/// the interval none of them exceeds the degree, however the knots are scaled.
inline void splineSlopes(std::span<const double> knots, size_t span, size_t degree, double t, double unit,
                         double* out) {
  double lower[kMaxSplineOrder];
  splineBasis(knots, span, degree - 1, t, lower);
  double before = 0;
  for (size_t k = 0; k < degree; ++k) {
    // Function span - degree + 1 + k of one degree less reaches over knots[i] to knots[i + degree].
    const size_t i = span - degree + 1 + k;
    const double share = static_cast<double>(degree) * lower[k] * (unit / (knots[i + degree] - knots[i]));
    out[k] = before - share;
    before = share;
  }
  out[degree] = before;
}

}  // namespace patina
