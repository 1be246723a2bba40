// SPDX-License-Identifier: Apache-2.0
// Gradient noise for kernels: no tables, so that compilers make vector code of it.
#pragma once

#include <cstdint>

#include "math.h"

namespace patina::sdk {

namespace detail {

/// Bits of a lattice point, mixed (the finaliser of MurmurHash3).
PATINA_INLINE uint32_t latticeBits(int32_t x, int32_t y, int32_t z) {
  uint32_t h = static_cast<uint32_t>(x) * 0x8da6b343u ^ static_cast<uint32_t>(y) * 0xd8163841u ^
               static_cast<uint32_t>(z) * 0xcb1ab31fu;
  h ^= h >> 16, h *= 0x85ebca6bu, h ^= h >> 13, h *= 0xc2b2ae35u, h ^= h >> 16;
  return h;
}

/// The product of (x, y, z) with one of the twelve gradients of K. Perlin, "Improving Noise", SIGGRAPH 2002.
PATINA_INLINE float gradientTimes(uint32_t bits, float x, float y, float z) {
  const uint32_t h = bits & 15u;
  const float a = h < 8 ? x : y, b = h < 4 ? y : (h == 12 || h == 14) ? x : z;
  return ((h & 1u) ? -a : a) + ((h & 2u) ? -b : b);
}

}  // namespace detail

/// RSL's noise: 0 to 1, smooth, 0.5 on average and at whole numbers. |p| < 2^31.
PATINA_INLINE float noise(const Vector& p) {
  const auto whole = [](float c) {
    const auto i = static_cast<int32_t>(c);
    return static_cast<float>(i) > c ? i - 1 : i;
  };
  const int32_t i = whole(p.x), j = whole(p.y), k = whole(p.z);
  const float x = p.x - static_cast<float>(i), y = p.y - static_cast<float>(j),
              z = p.z - static_cast<float>(k);
  const auto fade = [](float t) { return t * t * t * (t * (t * 6 - 15) + 10); };
  const auto mix = [](float t, float a, float b) { return a + t * (b - a); };
  const auto corner = [&](int32_t a, int32_t b, int32_t c) {
    return detail::gradientTimes(detail::latticeBits(i + a, j + b, k + c), x - static_cast<float>(a),
                                 y - static_cast<float>(b), z - static_cast<float>(c));
  };
  const float u = fade(x), v = fade(y), w = fade(z);
  const float value =
      mix(w, mix(v, mix(u, corner(0, 0, 0), corner(1, 0, 0)), mix(u, corner(0, 1, 0), corner(1, 1, 0))),
          mix(v, mix(u, corner(0, 0, 1), corner(1, 0, 1)), mix(u, corner(0, 1, 1), corner(1, 1, 1))));
  const float half = 0.5f + 0.5f * value;
  return half < 0 ? 0.0f : half > 1 ? 1.0f : half;
}

}  // namespace patina::sdk
