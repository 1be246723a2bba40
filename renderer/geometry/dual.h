// SPDX-License-Identifier: Apache-2.0
// Numbers and vectors that carry their derivative by one parameter (forward automatic differentiation).
#pragma once

#include "renderer/base/math.h"

namespace patina {

/// x and its derivative d.
struct Dual {
  double x = 0, d = 0;
};

struct DualV3 {
  V3d x{0}, d{0};
};

inline Dual operator+(const Dual& a, const Dual& b) { return {a.x + b.x, a.d + b.d}; }
inline Dual operator*(const Dual& a, const Dual& b) { return {a.x * b.x, a.d * b.x + a.x * b.d}; }
inline Dual operator/(const Dual& a, const Dual& b) {
  const double q = a.x / b.x;
  return {q, (a.d - q * b.d) / b.x};
}
inline Dual cos(const Dual& a) { return {std::cos(a.x), -std::sin(a.x) * a.d}; }
inline Dual sin(const Dual& a) { return {std::sin(a.x), std::cos(a.x) * a.d}; }

inline DualV3 operator+(const DualV3& a, const DualV3& b) { return {a.x + b.x, a.d + b.d}; }
inline DualV3 operator-(const DualV3& a, const DualV3& b) { return {a.x - b.x, a.d - b.d}; }
inline DualV3 operator*(const DualV3& a, const Dual& s) { return {a.x * s.x, a.d * s.x + a.x * s.d}; }
inline Dual dot(const DualV3& a, const DualV3& b) { return {a.x.dot(b.x), a.d.dot(b.x) + a.x.dot(b.d)}; }
inline DualV3 cross(const DualV3& a, const DualV3& b) {
  return {a.x.cross(b.x), a.d.cross(b.x) + a.x.cross(b.d)};
}
/// The unit vector of one that is not zero.
inline DualV3 unit(const DualV3& a) {
  const double length = std::sqrt(a.x.dot(a.x));
  const V3d n = a.x / length;
  return {n, (a.d - n * n.dot(a.d)) / length};
}

}  // namespace patina
