// SPDX-License-Identifier: Apache-2.0
// Vectors, colours and functions for shader kernels: every one of them compiles to vector code inside a
// kernel.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

// Kernels vectorise only if everything that they call is inlined.
#define PATINA_INLINE __attribute__((always_inline)) inline
#define PATINA_INLINE_LAMBDA __attribute__((always_inline))  // [..](..) PATINA_INLINE_LAMBDA { .. }

// glibc has vector variants of these functions; gcc uses them when told so (without -ffast-math).
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__GLIBC__)
extern "C" {
__attribute__((simd("notinbranch"))) float sinf(float) noexcept;
__attribute__((simd("notinbranch"))) float expf(float) noexcept;
__attribute__((simd("notinbranch"))) float logf(float) noexcept;
__attribute__((simd("notinbranch"))) float powf(float, float) noexcept;
}
#endif

namespace patina::sdk {

inline constexpr float kPi = 3.14159265358979323846f;

struct Vector {
  float x = 0, y = 0, z = 0;
  constexpr Vector() = default;
  constexpr Vector(float x_, float y_, float z_) : x(x_), y(y_), z(z_) {}
};
// For parameters, which are transformed by their kind; in formulas both are vectors.
struct Point : Vector {
  using Vector::Vector;
  constexpr Point() = default;
  constexpr Point(const Vector& v) : Vector(v) {}
};
struct Normal : Vector {
  using Vector::Vector;
  constexpr Normal() = default;
  constexpr Normal(const Vector& v) : Vector(v) {}
};

struct Color {
  float r = 0, g = 0, b = 0;
  constexpr Color() = default;
  constexpr Color(float grey) : r(grey), g(grey), b(grey) {}
  constexpr Color(float r_, float g_, float b_) : r(r_), g(g_), b(b_) {}
};

PATINA_INLINE constexpr Vector operator+(const Vector& a, const Vector& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
PATINA_INLINE constexpr Vector operator-(const Vector& a, const Vector& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
PATINA_INLINE constexpr Vector operator-(const Vector& a) { return {-a.x, -a.y, -a.z}; }
PATINA_INLINE constexpr Vector operator*(const Vector& a, float f) { return {a.x * f, a.y * f, a.z * f}; }
PATINA_INLINE constexpr Vector operator*(float f, const Vector& a) { return a * f; }
PATINA_INLINE constexpr Vector operator/(const Vector& a, float f) { return a * (1 / f); }
PATINA_INLINE constexpr float dot(const Vector& a, const Vector& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
PATINA_INLINE constexpr Vector cross(const Vector& a, const Vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
PATINA_INLINE float length(const Vector& a) { return std::sqrt(dot(a, a)); }
/// Unit length; zero stays zero.
PATINA_INLINE Vector normalize(const Vector& a) { return a * (1 / std::sqrt(std::max(dot(a, a), 1e-37f))); }
/// The direction of a mirror's reflection of `i`, which points at the surface; `n` of unit length.
PATINA_INLINE constexpr Vector reflect(const Vector& i, const Vector& n) { return i - n * (2 * dot(i, n)); }

PATINA_INLINE constexpr Color operator+(const Color& a, const Color& b) {
  return {a.r + b.r, a.g + b.g, a.b + b.b};
}
PATINA_INLINE constexpr Color operator-(const Color& a, const Color& b) {
  return {a.r - b.r, a.g - b.g, a.b - b.b};
}
PATINA_INLINE constexpr Color operator*(const Color& a, const Color& b) {
  return {a.r * b.r, a.g * b.g, a.b * b.b};
}
PATINA_INLINE constexpr Color operator*(const Color& a, float f) { return {a.r * f, a.g * f, a.b * f}; }
PATINA_INLINE constexpr Color operator*(float f, const Color& a) { return a * f; }
PATINA_INLINE constexpr float luminance(const Color& c) {
  return 0.212671f * c.r + 0.715160f * c.g + 0.072169f * c.b;
}
PATINA_INLINE constexpr bool isBlack(const Color& c) { return c.r == 0 && c.g == 0 && c.b == 0; }

PATINA_INLINE constexpr float clamp(float x, float low, float high) {
  return std::min(std::max(x, low), high);
}
PATINA_INLINE constexpr float mix(float a, float b, float t) { return a * (1 - t) + b * t; }
PATINA_INLINE constexpr Color mix(const Color& a, const Color& b, float t) { return a * (1 - t) + b * t; }
PATINA_INLINE constexpr Vector mix(const Vector& a, const Vector& b, float t) { return a * (1 - t) + b * t; }
/// RI's: 0 below `low`, 1 above `high`, a smooth cubic between; a step where they are equal.
PATINA_INLINE constexpr float smoothstep(float low, float high, float x) {
  const float t = clamp((x - low) / std::max(high - low, 1e-30f), 0, 1);
  return t * t * (3 - 2 * t);
}

PATINA_INLINE float sin(float x) { return ::sinf(x); }
// Not cosf: gcc makes one call of a sine and a cosine of the same angle, and has no vector variant of that.
PATINA_INLINE float cos(float x) { return ::sinf(x + kPi / 2); }
PATINA_INLINE float exp(float x) { return ::expf(x); }
PATINA_INLINE float log(float x) { return ::logf(x); }
PATINA_INLINE float pow(float x, float y) { return ::powf(x, y); }
PATINA_INLINE float sqrt(float x) { return std::sqrt(x); }
PATINA_INLINE constexpr float radians(float degrees) { return degrees * (kPi / 180); }

/// f(k) for k = 0 to N - 1, each a std::integral_constant<int, k>, written out: a loop inside of a kernel
/// keeps compilers from making vector code of the loop over points.
template <int N, class F>
PATINA_INLINE constexpr void unrolled(const F& f) {
  [&]<int... K>(std::integer_sequence<int, K...>) PATINA_INLINE_LAMBDA {
    (f(std::integral_constant<int, K>()), ...);
  }
  (std::make_integer_sequence<int, N>());
}

/// Two unit vectors that make a right-handed frame with the unit vector `n`.
struct Frame {
  Vector x, y;
};
PATINA_INLINE Frame frameAround(const Vector& n) {  // Duff et al., JCGT 6(1), 2017
  const float sign = std::copysign(1.0f, n.z);
  const float a = -1 / (sign + n.z);
  const float b = n.x * n.y * a;
  return {{1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}};
}

}  // namespace patina::sdk
