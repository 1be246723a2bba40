// SPDX-License-Identifier: Apache-2.0
// Steps, pulses and checks, averaged in closed form over the footprint (a box of edge `width` around x):
// after Apodaca & Gritz, "Advanced RenderMan" (2000), section 11.3. A width of 0 is the function itself.
#pragma once

#include "math.h"

namespace patina::sdk {

/// x minus the largest whole number below: 0 to 1.
PATINA_INLINE float fraction(float x) {
  const auto i = static_cast<float>(static_cast<int32_t>(x));
  return x - (i > x ? i - 1 : i);
}

/// 0 below `edge`, 1 above.
PATINA_INLINE constexpr float filteredStep(float edge, float x, float width) {
  return clamp((x - edge) / std::max(width, 1e-30f) + 0.5f, 0, 1);
}

/// 1 between the edges, 0 outside.
PATINA_INLINE constexpr float filteredPulse(float low, float high, float x, float width) {
  return filteredStep(low, x, width) - filteredStep(high, x, width);
}

/// The integral of smoothstep(low, high, .) up to x; low < high.
PATINA_INLINE constexpr float smoothstepIntegral(float low, float high, float x) {
  const float t = clamp((x - low) / (high - low), 0, 1);
  return (high - low) * (t * t * t * (1 - 0.5f * t)) + std::max(x - high, 0.0f);
}

/// smoothstep(low, high, x); low < high.
PATINA_INLINE constexpr float filteredSmoothstep(float low, float high, float x, float width) {
  // Differences of the integral over less than a hundredth of the ramp would be rounding errors.
  const float least = 0.01f * (high - low), w = std::max(width, least);
  const float mean =
      (smoothstepIntegral(low, high, x + 0.5f * w) - smoothstepIntegral(low, high, x - 0.5f * w)) / w;
  return width < least ? smoothstep(low, high, x) : mean;
}

/// Pulses without end: 1 from each whole number on for `duty` (0 to 1), then 0. Mean duty.
PATINA_INLINE float filteredPulseTrain(float duty, float x, float width) {
  const float w = std::max(width, 1e-5f);
  const float from = fraction(x - 0.5f * w), to = from + w;
  const auto whole = to - fraction(to);
  return clamp((whole * duty + std::min(to - whole, duty) - std::min(from, duty)) / w, 0, 1);
}

/// A checkerboard whose squares have edge 1/2: 1 in the square from (0, 0), period 1 along both. Mean 0.5.
PATINA_INLINE float filteredChecker(float s, float t, float width) {
  // Of a product the mean over a square is the product of means.
  const float a = 2 * filteredPulseTrain(0.5f, s, width) - 1, b = 2 * filteredPulseTrain(0.5f, t, width) - 1;
  return 0.5f + 0.5f * a * b;
}

}  // namespace patina::sdk
