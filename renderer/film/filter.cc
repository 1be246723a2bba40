// SPDX-License-Identifier: Apache-2.0
// The pixel filters' formulas (RI 3.2, appendix E).
#include "renderer/film/filter.h"

#include <cmath>
#include <numbers>

namespace patina {

namespace {

// The spline as RI prints it: twice the usual one, which the normalisation takes out again.
float catmullRom(float r) {
  if (r >= 2) return 0;
  return r < 1 ? (3 * r - 5) * r * r + 2 : ((5 - r) * r - 8) * r + 4;
}

}  // namespace

float PixelFilter::axisWeight(float d, float width) const {
  const float u = 2 * d / width;  // -1..1 over the support
  if (u < -1 || u >= 1) return 0;
  switch (kind) {
    case Kind::Triangle:
      return 1 - std::abs(u);
    case Kind::Gaussian:
      return std::exp(-2 * u * u);
    case Kind::Sinc: {
      const float x = std::numbers::pi_v<float> * d;
      return (std::abs(x) < 1e-4f ? 1 : std::sin(x) / x) * std::cos(x / width);
    }
    default:
      return 1;
  }
}

float PixelFilter::weight(float dx, float dy) const {
  const float product = axisWeight(dx, xWidth) * axisWeight(dy, yWidth);
  return separable() ? product : product * catmullRom(std::sqrt(dx * dx + dy * dy));
}

std::optional<PixelFilter::Kind> PixelFilter::fromName(std::string_view name) {
  if (name == "box") return Kind::Box;
  if (name == "triangle") return Kind::Triangle;
  if (name == "catmull-rom") return Kind::CatmullRom;
  if (name == "sinc") return Kind::Sinc;
  if (name == "gaussian") return Kind::Gaussian;
  return std::nullopt;
}

}  // namespace patina
