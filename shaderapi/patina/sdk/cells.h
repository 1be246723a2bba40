// SPDX-License-Identifier: Apache-2.0
// Random numbers that are constant within cells: of the integer lattice, and of the points nearest to
// (Worley).
//
//   cellnoise(x)  cellnoise(x, y)  cellnoise(p)  cellnoise(p, time)    RSL's: 0 to 1, the same in a unit cell
//   vcellnoise(...), ccellnoise(...)                                   vector and colour of such numbers
//   worley(x, y), worley(p)                                            distances to points, one in each unit
//   cell
//
// What is random by cell jumps at the cells' edges. A pattern fades it to its mean (0.5 of cellnoise) where
// the footprint nears the cells' size, as `cellLeft` does.
#pragma once

#include "noise.h"

namespace patina::sdk {

namespace detail {
PATINA_INLINE uint32_t cellBits(uint32_t salt, float x) {
  return latticeBits(wholeOf(inReach(x)), 0, 0, salt);
}
PATINA_INLINE uint32_t cellBits(uint32_t salt, float x, float y) {
  return latticeBits(wholeOf(inReach(x)), wholeOf(inReach(y)), 0, salt);
}
PATINA_INLINE uint32_t cellBits(uint32_t salt, const Vector& point) {
  const Vector p = inReach(point);
  return latticeBits(wholeOf(p.x), wholeOf(p.y), wholeOf(p.z), salt);
}
PATINA_INLINE uint32_t cellBits(uint32_t salt, const Vector& p, float w) {
  return cellBits(salt ^ fourthOf(wholeOf(inReach(w))), p);
}
}  // namespace detail

/// Uniform in 0 to 1 (1 excluded), mean 0.5, one value in each cell from whole numbers to the next.
template <class... At>
PATINA_INLINE float cellnoise(const At&... at) {
  return detail::unitOf(detail::cellBits(0, at...));
}
/// Three of them; x is cellnoise of the same variables.
template <class... At>
PATINA_INLINE Vector vcellnoise(const At&... at) {
  return {cellnoise(at...), detail::unitOf(detail::cellBits(detail::kSalts[1], at...)),
          detail::unitOf(detail::cellBits(detail::kSalts[2], at...))};
}
template <class... At>
PATINA_INLINE Color ccellnoise(const At&... at) {
  const Vector v = vcellnoise(at...);
  return {v.x, v.y, v.z};
}

/// The part of what is random by unit cell that is left for a region of edge `width`: 1 below a quarter of a
/// cell, nothing above one and a half.
PATINA_INLINE float cellLeft(float width) { return 1 - smoothstep(0.25f, 1.5f, width); }

/// Of the points that lie scattered, one in each unit cell. S. Worley, "A Cellular Texture Basis Function",
/// SIGGRAPH 1996, with one point to a cell in place of a random number of them.
struct Worley {
  float f1;       ///< distance to the nearest point
  float f2;       ///< and to the second; f2 - f1 is zero on the walls between the points' regions
  uint32_t cell;  ///< which point is nearest: a random number; see cellRandom()
};

/// The random number k of the region of a Worley cell, uniform in 0 to 1.
PATINA_INLINE float cellRandom(uint32_t cell, int32_t k) {
  return detail::unitOf(detail::latticeBits(k, 0, 0, cell));
}

/// `jitter` scatters the points: 1 all over their cells, 0 not at all. Distances are exact and continuous up
/// to 1.5 - jitter / 2, and cut off there: no point beyond the neighbouring cells is looked for.
PATINA_INLINE Worley worley(float x0, float y0, float jitter = 1) {
  const float px = detail::inReach(x0), py = detail::inReach(y0);
  const int32_t i = detail::wholeOf(px), j = detail::wholeOf(py);
  const float x = px - static_cast<float>(i) - 0.5f, y = py - static_cast<float>(j) - 0.5f;
  float near = 1e30f, next = 1e30f;
  uint32_t cell = 0;
  unrolled<9>([&](auto n) PATINA_INLINE_LAMBDA {
    constexpr int32_t a = n % 3 - 1, b = n / 3 - 1;
    const uint32_t bits = detail::latticeBits(i + a, j + b, 0, 0x1b873593u);
    const auto share = [&](int shift) PATINA_INLINE_LAMBDA {
      return jitter * (static_cast<float>(static_cast<int32_t>(bits >> shift & 0xffffu)) * 0x1p-16f - 0.5f);
    };
    const float dx = static_cast<float>(a) + share(0) - x, dy = static_cast<float>(b) + share(16) - y;
    const float d = dx * dx + dy * dy;
    cell = d < near ? bits : cell;
    next = d < near ? near : d < next ? d : next;
    near = d < near ? d : near;
  });
  const float far = 1.5f - 0.5f * jitter;
  return {std::min(std::sqrt(near), far), std::min(std::sqrt(next), far), cell};
}

PATINA_INLINE Worley worley(const Vector& point, float jitter = 1) {
  const Vector p = detail::inReach(point);
  const int32_t i = detail::wholeOf(p.x), j = detail::wholeOf(p.y), k = detail::wholeOf(p.z);
  const float x = p.x - static_cast<float>(i) - 0.5f, y = p.y - static_cast<float>(j) - 0.5f,
              z = p.z - static_cast<float>(k) - 0.5f;
  float near = 1e30f, next = 1e30f;
  uint32_t cell = 0;
  unrolled<27>([&](auto n) PATINA_INLINE_LAMBDA {
    constexpr int32_t a = n % 3 - 1, b = n / 3 % 3 - 1, c = n / 9 - 1;
    const uint32_t bits = detail::latticeBits(i + a, j + b, k + c, 0x1b873593u);
    const auto share = [&](int shift) PATINA_INLINE_LAMBDA {
      return jitter * (static_cast<float>(static_cast<int32_t>(bits >> shift & 0x3ffu)) * 0x1p-10f - 0.5f);
    };
    const float dx = static_cast<float>(a) + share(0) - x, dy = static_cast<float>(b) + share(10) - y,
                dz = static_cast<float>(c) + share(20) - z;
    const float d = dx * dx + dy * dy + dz * dz;
    cell = d < near ? bits : cell;
    next = d < near ? near : d < next ? d : next;
    near = d < near ? d : near;
  });
  const float far = 1.5f - 0.5f * jitter;
  return {std::min(std::sqrt(near), far), std::min(std::sqrt(next), far), cell};
}

}  // namespace patina::sdk
