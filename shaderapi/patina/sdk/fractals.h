// SPDX-License-Identifier: Apache-2.0
// Sums of gradient noise at frequencies that double: fBm and turbulence, filtered by the footprint.
//
// `width` is the edge of the region that the point stands for, in the units of p: of a pattern in shader
// space footprint * Matrix::scale() * frequency. An octave whose cells are not much larger fades to its mean,
// before it could alias: the clamping of Norton, Rockwood & Skolmoski (SIGGRAPH 1982; Apodaca & Gritz,
// "Advanced RenderMan", section 11.3). How fast it fades is the attenuation by averaging over a cube of that
// edge. Octaves are a template's argument: loops whose length is not known would keep kernels from being
// vectorised.
#pragma once

#include "noise.h"

namespace patina::sdk {

/// What is left of noise with cells of size 1, three variables, after averaging over a cube of edge `width`:
/// the part of the average that follows the noise at its middle (by regression), within 0.06.
PATINA_INLINE float noiseLeft(float width) { return 1 - smoothstep(0, 1.9f, width); }
/// The same of |snoise|, whose creases are finer; within 0.03, and nothing from 3 on.
PATINA_INLINE float absNoiseLeft(float width) {
  const float square = width * width, slope = 1 / (1 + 1.2f * square);
  return slope * slope * std::max(1 - square * (1.0f / 9), 0.0f);
}
/// The mean of |snoise| of three variables.
inline constexpr float kMeanAbsNoise = 0.2203f;

/// snoise(p), averaged over a cube of edge `width`. Mean 0, which it becomes at width 1.9.
PATINA_INLINE float filteredSnoise(const Vector& p, float width) { return noiseLeft(width) * snoise(p); }
/// |snoise(p)| likewise; mean kMeanAbsNoise, which it becomes at width 3.
PATINA_INLINE float filteredAbsSnoise(const Vector& p, float width) {
  return mix(kMeanAbsNoise, std::abs(snoise(p)), absNoiseLeft(width));
}

/// The sum of all octaves' amplitudes: what |fbm| and turbulence never exceed.
template <int N>
constexpr float amplitudes(float gain = 0.5f) {
  float sum = 0, amplitude = 1;
  for (int k = 0; k < N; ++k) sum += amplitude, amplitude *= gain;
  return sum;
}

namespace detail {
/// Octave k of lacunarity 2 would have zeros where the one before has them.
PATINA_INLINE Vector octaveAt(const Vector& p, float frequency, int k) {
  const auto shift = static_cast<float>(k);
  return p * frequency + Vector(0.381966f * shift, 0.618034f * shift, 0.236068f * shift);
}
}  // namespace detail

/// Fractional Brownian motion: N octaves of snoise, each `gain` times as strong at `lacunarity` times the
/// frequency of the one before. Mean 0. The difference from the mean of the unfiltered sum over a cube of
/// edge `width` is at most a quarter of the sum's standard deviation (root mean square over space, any
/// width): what no factor on the value in the middle can tell.
template <int N>
PATINA_INLINE float fbm(const Vector& p, float width, float lacunarity = 2, float gain = 0.5f) {
  float sum = 0, frequency = 1, amplitude = 1;
  unrolled<N>([&](auto k) PATINA_INLINE_LAMBDA {
    sum += amplitude * filteredSnoise(detail::octaveAt(p, frequency, k), width * frequency);
    frequency *= lacunarity, amplitude *= gain;
  });
  return sum;
}

/// Perlin's turbulence: the same sum of |snoise|; from 0, with creases. Mean kMeanAbsNoise *
/// amplitudes<N>(gain).
template <int N>
PATINA_INLINE float turbulence(const Vector& p, float width, float lacunarity = 2, float gain = 0.5f) {
  float sum = 0, frequency = 1, amplitude = 1;
  unrolled<N>([&](auto k) PATINA_INLINE_LAMBDA {
    sum += amplitude * filteredAbsSnoise(detail::octaveAt(p, frequency, k), width * frequency);
    frequency *= lacunarity, amplitude *= gain;
  });
  return sum;
}

}  // namespace patina::sdk
