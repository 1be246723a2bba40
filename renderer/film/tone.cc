// SPDX-License-Identifier: Apache-2.0
// Exposure, sRGB and quantisation of single values.
#include "renderer/film/tone.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace patina {

namespace {

// A 64-bit finaliser (Stafford's mix 13, as in SplitMix64) of pixel and channel, to [-1, 1).
float ditherRandom(int x, int y, int channel) {
  std::uint64_t h = static_cast<std::uint32_t>(x) | static_cast<std::uint64_t>(static_cast<std::uint32_t>(y))
                                                        << 32;
  h ^= static_cast<std::uint64_t>(channel + 1) * 0x9e3779b97f4a7c15ull;
  h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ull;
  h = (h ^ (h >> 27)) * 0x94d049bb133111ebull;
  h ^= h >> 31;
  return static_cast<float>(h >> 40) * 0x1p-23f - 1;
}

}  // namespace

float exposed(float v, float gain, float gamma) {
  v *= gain;
  return gamma == 1 ? v : std::pow(std::max(v, 0.f), 1 / gamma);
}

float srgbEncoded(float linear) {
  if (!(linear > 0)) return 0;
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
}

float quantized(float v, const Quantizer& q, int x, int y, int channel) {
  const float value = std::round(q.one * v + q.dither * ditherRandom(x, y, channel));
  return value > q.min ? std::min(value, q.max) : q.min;
}

}  // namespace patina
