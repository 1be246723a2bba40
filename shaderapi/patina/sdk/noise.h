// SPDX-License-Identifier: Apache-2.0
// Gradient noise of one to four variables for kernels: no tables and no branches, so that compilers make
// vector code of it.
//
// snoise of a float, of two, of a point, or of a point and a time: from -1 to 1, 0 on average and where all
// variables are whole. noise is RSL's, 0.5 + 0.5 * snoise: from 0 to 1, 0.5 on average. vsnoise and vnoise
// are three of them that know nothing of each other.
//
// All have continuous second derivatives and repeat after 2^32; coordinates count up to 2^30, and above
// 2^20 a float's own steps show. Standard deviations of snoise for one to four variables: 0.281, 0.305,
// 0.270, 0.195 (from the integrals of the interpolating polynomial; the tests have them). Noise by itself has
// details as small as half a cell. A pattern fades it out by the footprint: sdk/fractals.h.
#pragma once

#include <cstdint>

#include "math.h"

namespace patina::sdk {

namespace detail {

/// Far away, where floats are more than cells apart, patterns stay what they are at 2^30.
PATINA_INLINE float inReach(float x) { return std::min(std::max(x, -0x1p30f), 0x1p30f); }
PATINA_INLINE Vector inReach(const Vector& p) { return {inReach(p.x), inReach(p.y), inReach(p.z)}; }

/// The largest whole number that is not above x, which is in reach.
PATINA_INLINE int32_t wholeOf(float x) {
  const auto i = static_cast<int32_t>(x);
  return static_cast<float>(i) > x ? i - 1 : i;
}

/// Bits of a lattice point, mixed (the finaliser of MurmurHash3). Each `salt` is another lattice.
PATINA_INLINE uint32_t latticeBits(int32_t x, int32_t y, int32_t z, uint32_t salt = 0) {
  uint32_t h = static_cast<uint32_t>(x) * 0x8da6b343u ^ static_cast<uint32_t>(y) * 0xd8163841u ^
               static_cast<uint32_t>(z) * 0xcb1ab31fu ^ salt;
  h ^= h >> 16, h *= 0x85ebca6bu, h ^= h >> 13, h *= 0xc2b2ae35u, h ^= h >> 16;
  return h;
}
/// What a fourth coordinate adds to the salt.
PATINA_INLINE uint32_t fourthOf(int32_t w) { return static_cast<uint32_t>(w) * 0x9e3779b1u; }

/// Salts of the components of vectors and colours.
inline constexpr uint32_t kSalts[3] = {0, 0x5bd1e995u, 0x27d4eb2fu};

/// 0 to 1, 1 excluded, in steps of 2^-24.
PATINA_INLINE float unitOf(uint32_t bits) {
  return static_cast<float>(static_cast<int32_t>(bits >> 8)) * 0x1p-24f;
}

// Perlin's polynomial with two vanishing derivatives at both ends ("Improving Noise", SIGGRAPH 2002).
PATINA_INLINE float fade(float t) { return t * t * t * (t * (t * 6 - 15) + 10); }
PATINA_INLINE float between(float t, float a, float b) { return a + t * (b - a); }

// The products of a point with the gradient that the bits choose. Their lengths make the middle of a cell,
// where all corners may agree, reach 1.

/// Slopes of all sizes up to 2.
PATINA_INLINE float gradientTimes(uint32_t bits, float x) { return (4 * unitOf(bits) - 2) * x; }

/// Sixteen directions, 22.5 degrees apart and none along an axis; length sqrt(2).
PATINA_INLINE float gradientTimes(uint32_t bits, float x, float y) {
  const float a = (bits & 1u) ? 1.3870399f : 1.1758756f;    // sqrt(2) cos(11.25 degrees), of 33.75
  const float b = (bits & 1u) ? 0.27589938f : 0.78569496f;  // sqrt(2) sin
  const float p = (bits & 2u) ? x : y, q = (bits & 2u) ? y : x;
  return ((bits & 4u) ? -a : a) * p + ((bits & 8u) ? -b : b) * q;
}

/// One of the twelve gradients of K. Perlin, "Improving Noise", SIGGRAPH 2002.
PATINA_INLINE float gradientTimes(uint32_t bits, float x, float y, float z) {
  const uint32_t h = bits & 15u;
  const float a = h < 8 ? x : y, b = h < 4 ? y : (h == 12 || h == 14) ? x : z;
  return ((h & 1u) ? -a : a) + ((h & 2u) ? -b : b);
}

/// One of the 32 directions to the middles of the edges of a hypercube, two thirds as long.
PATINA_INLINE float gradientTimes(uint32_t bits, float x, float y, float z, float w) {
  const uint32_t left = (bits >> 3) & 3u;  // the coordinate that is left out
  const float a = left == 0 ? w : x, b = left == 1 ? w : y, c = left == 2 ? w : z;
  const float sum = ((bits & 1u) ? -a : a) + ((bits & 2u) ? -b : b) + ((bits & 4u) ? -c : c);
  return sum * (2.0f / 3);
}

PATINA_INLINE float gradientNoise(uint32_t salt, float x0) {
  const float px = inReach(x0);
  const int32_t i = wholeOf(px);
  const float x = px - static_cast<float>(i);
  return between(fade(x), gradientTimes(latticeBits(i, 0, 0, salt), x),
                 gradientTimes(latticeBits(i + 1, 0, 0, salt), x - 1));
}

PATINA_INLINE float gradientNoise(uint32_t salt, float x0, float y0) {
  const float px = inReach(x0), py = inReach(y0);
  const int32_t i = wholeOf(px), j = wholeOf(py);
  const float x = px - static_cast<float>(i), y = py - static_cast<float>(j);
  const auto corner = [&](int32_t a, int32_t b) PATINA_INLINE_LAMBDA {
    return gradientTimes(latticeBits(i + a, j + b, 0, salt), x - static_cast<float>(a),
                         y - static_cast<float>(b));
  };
  const float u = fade(x), v = fade(y);
  return between(v, between(u, corner(0, 0), corner(1, 0)), between(u, corner(0, 1), corner(1, 1)));
}

PATINA_INLINE float gradientNoise(uint32_t salt, const Vector& point) {
  const Vector p = inReach(point);
  const int32_t i = wholeOf(p.x), j = wholeOf(p.y), k = wholeOf(p.z);
  const float x = p.x - static_cast<float>(i), y = p.y - static_cast<float>(j),
              z = p.z - static_cast<float>(k);
  const auto corner = [&](int32_t a, int32_t b, int32_t c) PATINA_INLINE_LAMBDA {
    return gradientTimes(latticeBits(i + a, j + b, k + c, salt), x - static_cast<float>(a),
                         y - static_cast<float>(b), z - static_cast<float>(c));
  };
  const float u = fade(x), v = fade(y), w = fade(z);
  return between(
      w,
      between(v, between(u, corner(0, 0, 0), corner(1, 0, 0)), between(u, corner(0, 1, 0), corner(1, 1, 0))),
      between(v, between(u, corner(0, 0, 1), corner(1, 0, 1)), between(u, corner(0, 1, 1), corner(1, 1, 1))));
}

PATINA_INLINE float gradientNoise(uint32_t salt, const Vector& point, float w0) {
  const Vector p = inReach(point);
  const float pw = inReach(w0);
  const int32_t i = wholeOf(p.x), j = wholeOf(p.y), k = wholeOf(p.z), l = wholeOf(pw);
  const float x = p.x - static_cast<float>(i), y = p.y - static_cast<float>(j),
              z = p.z - static_cast<float>(k), w = pw - static_cast<float>(l);
  const float s = fade(x), t = fade(y), u = fade(z), v = fade(w);
  const auto corner = [&](int32_t a, int32_t b, int32_t c, int32_t d) PATINA_INLINE_LAMBDA {
    return gradientTimes(latticeBits(i + a, j + b, k + c, salt ^ fourthOf(l + d)), x - static_cast<float>(a),
                         y - static_cast<float>(b), z - static_cast<float>(c), w - static_cast<float>(d));
  };
  const auto square = [&](int32_t c, int32_t d) PATINA_INLINE_LAMBDA {
    return between(t, between(s, corner(0, 0, c, d), corner(1, 0, c, d)),
                   between(s, corner(0, 1, c, d), corner(1, 1, c, d)));
  };
  return between(v, between(u, square(0, 0), square(1, 0)), between(u, square(0, 1), square(1, 1)));
}

// Where gradients of several corners conspire, noise of three and four variables is a few percent beyond its
// range.
PATINA_INLINE float signedRange(float value) { return value < -1 ? -1.0f : value > 1 ? 1.0f : value; }
PATINA_INLINE float unitRange(float value) {
  const float half = 0.5f + 0.5f * value;
  return half < 0 ? 0.0f : half > 1 ? 1.0f : half;
}

}  // namespace detail

/// -1 to 1, smooth, 0 on average and at whole numbers.
PATINA_INLINE float snoise(float x) { return detail::signedRange(detail::gradientNoise(0, x)); }
PATINA_INLINE float snoise(float x, float y) { return detail::signedRange(detail::gradientNoise(0, x, y)); }
PATINA_INLINE float snoise(const Vector& p) { return detail::signedRange(detail::gradientNoise(0, p)); }
PATINA_INLINE float snoise(const Vector& p, float w) {
  return detail::signedRange(detail::gradientNoise(0, p, w));
}

/// RSL's noise: 0 to 1, smooth, 0.5 on average and at whole numbers.
PATINA_INLINE float noise(float x) { return detail::unitRange(detail::gradientNoise(0, x)); }
PATINA_INLINE float noise(float x, float y) { return detail::unitRange(detail::gradientNoise(0, x, y)); }
PATINA_INLINE float noise(const Vector& p) { return detail::unitRange(detail::gradientNoise(0, p)); }
PATINA_INLINE float noise(const Vector& p, float w) {
  return detail::unitRange(detail::gradientNoise(0, p, w));
}

/// Three noises: x is snoise of the same variables, y and z are of lattices of their own.
template <class... At>
PATINA_INLINE Vector vsnoise(const At&... at) {
  return {detail::signedRange(detail::gradientNoise(detail::kSalts[0], at...)),
          detail::signedRange(detail::gradientNoise(detail::kSalts[1], at...)),
          detail::signedRange(detail::gradientNoise(detail::kSalts[2], at...))};
}
template <class... At>
PATINA_INLINE Vector vnoise(const At&... at) {
  return {detail::unitRange(detail::gradientNoise(detail::kSalts[0], at...)),
          detail::unitRange(detail::gradientNoise(detail::kSalts[1], at...)),
          detail::unitRange(detail::gradientNoise(detail::kSalts[2], at...))};
}

}  // namespace patina::sdk
