// SPDX-License-Identifier: Apache-2.0
#include "renderer/base/sampling_batch.h"

#include "renderer/base/sampling.h"

namespace patina {
namespace {

/// The second dimension's generator matrix on reversed bits: Pascal's triangle modulo 2, which is the fifth
/// Kronecker power of ((1, 1), (0, 1)).
inline uint32_t pascal(uint32_t v) {
  v ^= v >> 1 & 0x55555555u;
  v ^= v >> 2 & 0x33333333u;
  v ^= v >> 4 & 0x0f0f0f0fu;
  v ^= v >> 8 & 0x00ff00ffu;
  v ^= v >> 16;
  return v;
}

/// Fractions of sobol2(first + k, seed), as toUnit() takes them: as sobol2 has it, without the pairs of
/// reversals that cancel each other.
template <size_t kCount>
void sobolBits(uint32_t first, uint64_t seed, std::array<uint32_t, kCount>& u,
               std::array<uint32_t, kCount>& v) {
  const auto order = static_cast<uint32_t>(seed);
  const uint64_t h = mixBits(seed ^ 0x5851f42d4c957f2du);
  const auto seedU = static_cast<uint32_t>(h), seedV = static_cast<uint32_t>(h >> 32);
  for (uint32_t k = 0; k < kCount; ++k) {
    const uint32_t shuffled = reverseBits(owenScrambleReversed(reverseBits(first + k), order));
    u[k] = reverseBits(owenScrambleReversed(shuffled, seedU));
    v[k] = reverseBits(owenScrambleReversed(pascal(shuffled), seedV));
  }
}

// Sine and cosine for |x| <= pi / 4: Taylor's series, cut where the next term is below half a unit in the
// last place (pi/4^11 / 11! and pi/4^10 / 10!).
inline float sineOfSmall(float x) {
  const float s = x * x;
  return x + x * s * (-1.0f / 6 + s * (1.0f / 120 + s * (-1.0f / 5040 + s * (1.0f / 362880))));
}
inline float cosineOfSmall(float x) {
  const float s = x * x;
  return 1 + s * (-0.5f + s * (1.0f / 24 + s * (-1.0f / 720 + s * (1.0f / 40320))));
}

}  // namespace

void sobolPoints(uint32_t first, uint64_t seed, std::span<V2f> out) {
  constexpr size_t kTogether = 8;
  size_t done = 0;
  for (; done + kTogether <= out.size(); done += kTogether) {
    std::array<uint32_t, kTogether> u, v;
    sobolBits(first + static_cast<uint32_t>(done), seed, u, v);
    for (size_t k = 0; k < kTogether; ++k) out[done + k] = {toUnit(u[k]), toUnit(v[k])};
  }
  for (; done < out.size(); ++done) out[done] = sobol2(first + static_cast<uint32_t>(done), seed);
}

void CosineDirections::sample(uint32_t first, uint64_t seed, uint32_t wanted) {
  constexpr uint32_t kFew = 4;
  wanted <= kFew ? fill<kFew>(first, seed) : fill<kCount>(first, seed);
}

template <uint32_t kLanes>
void CosineDirections::fill(uint32_t first, uint64_t seed) {
  std::array<uint32_t, kLanes> u, v;
  sobolBits(first, seed, u, v);
  for (uint32_t k = 0; k < kLanes; ++k) {
    // The concentric map, with the two kinds of sectors mirrored on each other.
    const float a = 2 * toUnit(u[k]) - 1, b = 2 * toUnit(v[k]) - 1;
    const bool flat = std::abs(a) > std::abs(b);
    const float r = flat ? a : b, other = flat ? b : a;
    const float angle = kPi / 4 * (other / (r == 0 ? 1 : r));
    const float along = r * cosineOfSmall(angle), across = r * sineOfSmall(angle);
    x[k] = flat ? along : across;
    y[k] = flat ? across : along;
    z[k] = std::sqrt(std::max(0.0f, 1 - r * r));
  }
}

}  // namespace patina
