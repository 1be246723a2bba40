// SPDX-License-Identifier: Apache-2.0
// Checks of the knots that NuPatch and TrimCurve give.
#pragma once

#include <optional>
#include <string>

#include "renderer/scene/scene.h"

namespace patina {

struct SplineProblem {
  RiError code;
  std::string text;
};

/// Cuts [min, max] back to [knots[order-1], knots[count]], where the spline is defined. False if nothing of
/// it lies there, or the knots are too few to say. `cut` becomes true when something was cut off.
bool cutToDomain(SplineKnots& spline, bool& cut);

/// What keeps the spline from being evaluated in its [min, max]; nullopt if nothing does: the order is from 2
/// to kMaxSplineOrder, the numbers of control points and knots agree, knots are finite and do not fall, none
/// comes more often than the order says, and min < max lie where the spline is defined.
std::optional<SplineProblem> splineProblem(const SplineKnots& spline);

/// Weights outside of these bounds would carry points out of the range of float.
inline constexpr float kSmallestWeight = 1e-18f, kLargestWeight = 1e18f;
inline bool usableWeight(float w) { return w >= kSmallestWeight && w <= kLargestWeight; }

}  // namespace patina
