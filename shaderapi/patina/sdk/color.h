// SPDX-License-Identifier: Apache-2.0
// Conversions of colours. Kernels compute in linear Rec.709; what people pick, and 8-bit pictures, are mostly
// sRGB. luminance() is in math.h.
#pragma once

#include "math.h"

namespace patina::sdk {

/// One channel of sRGB (IEC 61966-2-1) to linear, and back; both 0 to 1.
PATINA_INLINE float srgbToLinear(float v) {
  const float curve = pow((std::max(v, 0.0f) + 0.055f) / 1.055f, 2.4f);
  return v <= 0.04045f ? v / 12.92f : curve;
}
PATINA_INLINE float linearToSrgb(float v) {
  const float curve = 1.055f * pow(std::max(v, 1e-6f), 1 / 2.4f) - 0.055f;
  return v <= 0.0031308f ? v * 12.92f : curve;
}
PATINA_INLINE Color srgbToLinear(const Color& c) {
  return {srgbToLinear(c.r), srgbToLinear(c.g), srgbToLinear(c.b)};
}
PATINA_INLINE Color linearToSrgb(const Color& c) {
  return {linearToSrgb(c.r), linearToSrgb(c.g), linearToSrgb(c.b)};
}

/// CIE XYZ (1931, 2 degrees) to linear Rec.709 with its white D65: Y of white is 1. What lies outside of
/// Rec.709 has channels below zero.
PATINA_INLINE constexpr Color xyzToLinear(const Color& c) {
  return {3.2404542f * c.r - 1.5371385f * c.g - 0.4985314f * c.b,
          -0.9692660f * c.r + 1.8760108f * c.g + 0.0415560f * c.b,
          0.0556434f * c.r - 0.2040259f * c.g + 1.0572252f * c.b};
}

/// Hue (0 to 1 once around: red 0, green 1/3, blue 2/3), saturation and value, as RI's "hsv" has them (A. R.
/// Smith, "Color Gamut Transform Pairs", SIGGRAPH 1978), kept in a Color's r, g and b.
PATINA_INLINE Color hsvToRgb(const Color& hsv) {
  const auto channel = [&](float n) PATINA_INLINE_LAMBDA {
    const float turn = hsv.r + n / 6;
    const auto whole = static_cast<float>(static_cast<int32_t>(turn));
    const float k = 6 * (turn - (whole > turn ? whole - 1 : whole));  // the hue's distance, 0 to 6
    return hsv.b - hsv.b * hsv.g * clamp(std::min(k, 4 - k), 0, 1);
  };
  return {channel(5), channel(3), channel(1)};
}
/// Greys have hue 0; black has saturation 0.
PATINA_INLINE Color rgbToHsv(const Color& c) {
  const float most = std::max(c.r, std::max(c.g, c.b)), least = std::min(c.r, std::min(c.g, c.b));
  const float range = most - least, scale = 1 / std::max(range, 1e-30f);
  const float sixths = c.r == most   ? (c.g - c.b) * scale
                       : c.g == most ? 2 + (c.b - c.r) * scale
                                     : 4 + (c.r - c.g) * scale;
  const float hue = sixths / 6;
  return {hue < 0 ? hue + 1 : hue, range / std::max(most, 1e-30f), most};
}

}  // namespace patina::sdk
