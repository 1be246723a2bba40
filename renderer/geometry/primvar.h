// SPDX-License-Identifier: Apache-2.0
// Reading primitive variables: checked points, single values and weighted sums of values.
#pragma once

#include <optional>
#include <span>

#include "renderer/scene/scene.h"

namespace patina {

/// Coordinates beyond this are treated like infinity: products of them leave the range of float.
inline constexpr float kLargestCoordinate = 1e18f;

inline bool usable(const V3f& p) { return maxAbsComponent(p) <= kLargestCoordinate && isFinite(p); }

/// The points of a primitive, in object space; a view of its variable "P".
class PointView {
 public:
  PointView() = default;
  explicit PointView(std::span<const float> floats) : floats_(floats) {}
  size_t size() const { return floats_.size() / 3; }
  V3f operator[](size_t i) const { return {floats_[3 * i], floats_[3 * i + 1], floats_[3 * i + 2]}; }
  const float* data() const { return floats_.data(); }

 private:
  std::span<const float> floats_;
};

/// The variable "P" if it holds points, else nullopt.
std::optional<PointView> findPoints(const Primitive& primitive);

/// Value number `index` of a variable; zeros where the data hold fewer values (or no floats).
void copyValue(const PrimVar& variable, size_t index, float* out);

/// The sum of weight[i] * value number index[i], in double.
void blendValues(const PrimVar& variable, std::span<const uint32_t> index, std::span<const double> weight,
                 float* out);

}  // namespace patina
