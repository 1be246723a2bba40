// SPDX-License-Identifier: Apache-2.0
// Hashing, Owen-scrambled Sobol points and the warps from the unit square that integrators use.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "renderer/base/math.h"

namespace patina {

// ---- Hashing: a random number is a function of what it is for, never of when or where it is drawn
// ----------------

/// Finaliser of MurmurHash3 with the constants of Stafford's "Mix13".
constexpr uint64_t mixBits(uint64_t v) {
  v ^= v >> 30;
  v *= 0xbf58476d1ce4e5b9u;
  v ^= v >> 27;
  v *= 0x94d049bb133111ebu;
  return v ^ (v >> 31);
}

template <class... Parts>
constexpr uint64_t hashOf(Parts... parts) {
  uint64_t h = 0x9e3779b97f4a7c15u;
  ((h = mixBits(h ^ (static_cast<uint64_t>(parts) + 0x9e3779b97f4a7c15u + (h << 6)))), ...);
  return h;
}

/// The bits of a float with -0 and 0 made equal, for hashing.
inline uint32_t floatBits(float f) { return std::bit_cast<uint32_t>(f == 0 ? 0.0f : f); }

/// Uniform in [0, 1) from the upper bits of a hash.
constexpr float toUnit(uint32_t bits) { return static_cast<float>(bits >> 8) * 0x1p-24f; }

// ---- Sobol points
// ------------------------------------------------------------------------------------------------

constexpr uint32_t reverseBits(uint32_t v) {
  v = __builtin_bswap32(v);
  v = ((v & 0x0f0f0f0fu) << 4) | ((v >> 4) & 0x0f0f0f0fu);
  v = ((v & 0x33333333u) << 2) | ((v >> 2) & 0x33333333u);
  return ((v & 0x55555555u) << 1) | ((v >> 1) & 0x55555555u);
}

/// Nested uniform (Owen) scrambling of a bit-reversed fraction (Burley, "Practical Hash-based Owen
/// Scrambling", JCGT 2020; multipliers after Vegdahl's improvement).
constexpr uint32_t owenScrambleReversed(uint32_t v, uint32_t seed) {
  v ^= v * 0x3d20adeau;
  v += seed;
  v *= (seed >> 16) | 1u;
  v ^= v * 0x05526c56u;
  v ^= v * 0x53a22864u;
  return v;
}
constexpr uint32_t owenScramble(uint32_t v, uint32_t seed) {
  return reverseBits(owenScrambleReversed(reverseBits(v), seed));
}

namespace detail {
/// Sobol's second dimension by bytes of the index: its matrix is linear, so the bytes' parts combine by
/// exclusive or.
inline constexpr auto kSobolSecond = [] {
  std::array<std::array<uint32_t, 256>, 4> table{};
  uint32_t column = 1u << 31;  // of the generator matrix (Kollig and Keller 2002)
  for (uint32_t bit = 0; bit < 32; ++bit, column ^= column >> 1)
    for (uint32_t byte = 0; byte < 256; ++byte)
      if (byte >> (bit & 7) & 1) table[bit / 8][byte] ^= column;
  return table;
}();
}  // namespace detail

/// Second dimension of Sobol's sequence for index `n`; the first is reverseBits(n).
constexpr uint32_t sobolSecond(uint32_t n) {
  return detail::kSobolSecond[0][n & 255] ^ detail::kSobolSecond[1][n >> 8 & 255] ^
         detail::kSobolSecond[2][n >> 16 & 255] ^ detail::kSobolSecond[3][n >> 24];
}

/// Point `index` of a two-dimensional Sobol sequence, Owen-scrambled and with shuffled order by `seed`:
/// sequences of different seeds are independent, so dimensions beyond two are padded with them (PBR 4th ed.
/// section 8.7.2).
inline V2f sobol2(uint32_t index, uint64_t seed) {
  const uint32_t shuffled = owenScramble(index, static_cast<uint32_t>(seed));
  const uint64_t h = mixBits(seed ^ 0x5851f42d4c957f2du);
  return {toUnit(owenScramble(reverseBits(shuffled), static_cast<uint32_t>(h))),
          toUnit(owenScramble(sobolSecond(shuffled), static_cast<uint32_t>(h >> 32)))};
}

/// One-dimensional companion of sobol2.
inline float sobol1(uint32_t index, uint64_t seed) {
  const uint32_t shuffled = owenScramble(index, static_cast<uint32_t>(seed));
  return toUnit(owenScramble(reverseBits(shuffled), static_cast<uint32_t>(seed >> 32)));
}

// ---- Warps
// -------------------------------------------------------------------------------------------------------

/// Concentric map from the unit square to the unit disc (Shirley and Chiu 1997).
inline V2f sampleDisk(const V2f& u) {
  const float x = 2 * u.x - 1, y = 2 * u.y - 1;
  if (x == 0 && y == 0) return {0, 0};
  float r, theta;
  if (std::abs(x) > std::abs(y)) {
    r = x;
    theta = (kPi / 4) * (y / x);
  } else {
    r = y;
    theta = kPi / 2 - (kPi / 4) * (x / y);
  }
  return {r * std::cos(theta), r * std::sin(theta)};
}

/// Direction about +z with density cos(theta)/pi per solid angle.
inline V3f sampleCosineHemisphere(const V2f& u) {
  const V2f d = sampleDisk(u);
  return {d.x, d.y, std::sqrt(std::max(0.0f, 1 - d.x * d.x - d.y * d.y))};
}

/// Barycentric weights (of corners 1 and 2) uniform in area (Heitz 2019, "A Low-Distortion Map Between
/// Triangle and Square").
inline V2f sampleTriangle(const V2f& u) {
  float b0 = u.x / 2, b1 = u.y / 2;
  const float offset = b1 - b0;
  if (offset > 0)
    b1 += offset;
  else
    b0 -= offset;
  return {b0, b1};
}

/// Power heuristic with exponent 2 for one sample from each of two densities.
inline float misWeight(float pdf, float otherPdf) {
  if (std::isinf(pdf)) return 1;
  const float a = pdf * pdf, b = otherPdf * otherPdf;
  return a > 0 ? a / (a + b) : 0;
}

}  // namespace patina
