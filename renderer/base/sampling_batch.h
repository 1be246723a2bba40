// SPDX-License-Identifier: Apache-2.0
// Many sample points at a time, in loops that compile to vector code.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "renderer/base/math.h"

namespace patina {

/// Sets `out` to sobol2(first + k, seed).
void sobolPoints(uint32_t first, uint64_t seed, std::span<V2f> out);

/// Directions about +z with density cos(theta)/pi per solid angle, by coordinate.
struct CosineDirections {
  static constexpr uint32_t kCount = 16;
  std::array<float, kCount> x, y, z;
  /// Sets the first `wanted`, at least, to sampleCosineHemisphere(sobol2(first + k, seed)), but for rounding.
  /// They do not depend on how many are wanted.
  void sample(uint32_t first, uint64_t seed, uint32_t wanted = kCount);

 private:
  template <uint32_t kLanes>
  void fill(uint32_t first, uint64_t seed);
};

}  // namespace patina
