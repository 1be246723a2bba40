// SPDX-License-Identifier: Apache-2.0
// The pixel filters of RI 3.2: how much a sample counts for a pixel, by its offset from the pixel's centre.
#pragma once

#include <optional>
#include <string_view>

namespace patina {

// A filter's support is a rectangle of `xWidth` by `yWidth` pixels around a pixel's centre, closed at its
// left and top and open at its right and bottom, so that a box of one pixel gives every sample to exactly one
// pixel. The weights are RI's own and not normalised: a pixel is divided by the sum of its weights.
struct PixelFilter {
  enum class Kind { Box, Triangle, CatmullRom, Sinc, Gaussian };

  Kind kind = Kind::Gaussian;
  float xWidth = 2;  // pixels
  float yWidth = 2;

  // Weight of a sample at (dx, dy) pixels from the centre; 0 outside the support.
  // box 1; triangle (1-|2dx/xw|)(1-|2dy/yw|); catmull-rom: of the radius, as RI 3.2 has it, whatever the
  // widths; sinc: sin(pi d)/(pi d) in each axis, windowed by cos(pi d/width); gaussian
  // exp(-2((2dx/xw)^2+(2dy/yw)^2)).
  float weight(float dx, float dy) const;

  // All filters but catmull-rom are products of one factor per axis: weight(dx, dy) is that of dx and xWidth
  // times that of dy and yWidth.
  bool separable() const { return kind != Kind::CatmullRom; }
  float axisWeight(float d, float width) const;

  // RI's filter name, e.g. "catmull-rom"; nullopt for an unknown one.
  static std::optional<Kind> fromName(std::string_view name);
};

}  // namespace patina
