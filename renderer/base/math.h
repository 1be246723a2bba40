// SPDX-License-Identifier: Apache-2.0
// Vectors, matrices, bounds and small numeric helpers. Points are row vectors: p' = p * M, as in RI.
#pragma once

#include <Imath/ImathBox.h>
#include <Imath/ImathMatrix.h>
#include <Imath/ImathVec.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

namespace patina {

using V2f = Imath::V2f;
using V3f = Imath::V3f;
using V3d = Imath::V3d;
using M44f = Imath::M44f;
using M44d = Imath::M44d;
using Box3f = Imath::Box3f;
using Rgb = Imath::V3f;  ///< linear Rec.709

inline constexpr float kPi = std::numbers::pi_v<float>;
inline constexpr float kInvPi = std::numbers::inv_pi_v<float>;
inline constexpr float kInfinity = std::numeric_limits<float>::infinity();
inline constexpr float kMachineEpsilon = std::numeric_limits<float>::epsilon() * 0.5f;
inline constexpr float kOneMinusEpsilon = 0x1.fffffep-1f;

/// Bound on the relative error of n rounded operations (Higham; PBR 3rd ed. section 3.9.1).
constexpr float roundingBound(int n) {
  return static_cast<float>(n) * kMachineEpsilon / (1 - static_cast<float>(n) * kMachineEpsilon);
}

inline float maxComponent(const V3f& v) { return std::max({v.x, v.y, v.z}); }
inline float maxAbsComponent(const V3f& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }
inline float luminance(const Rgb& c) { return 0.212671f * c.x + 0.715160f * c.y + 0.072169f * c.z; }
inline bool isFinite(const V3f& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }
inline bool isBlack(const Rgb& c) { return c.x == 0 && c.y == 0 && c.z == 0; }
inline V3f lerp(float t, const V3f& a, const V3f& b) { return a * (1 - t) + b * t; }
inline float lerp(float t, float a, float b) { return a * (1 - t) + b * t; }

/// Point, vector and normal through an affine matrix. Normals need the inverse of the matrix that moves
/// points.
inline V3f transformPoint(const V3f& p, const M44f& m) {
  return {p.x * m[0][0] + p.y * m[1][0] + p.z * m[2][0] + m[3][0],
          p.x * m[0][1] + p.y * m[1][1] + p.z * m[2][1] + m[3][1],
          p.x * m[0][2] + p.y * m[1][2] + p.z * m[2][2] + m[3][2]};
}
inline V3f transformVector(const V3f& v, const M44f& m) {
  return {v.x * m[0][0] + v.y * m[1][0] + v.z * m[2][0], v.x * m[0][1] + v.y * m[1][1] + v.z * m[2][1],
          v.x * m[0][2] + v.y * m[1][2] + v.z * m[2][2]};
}
inline V3f transformNormal(const V3f& n, const M44f& inverse) {
  return {n.x * inverse[0][0] + n.y * inverse[0][1] + n.z * inverse[0][2],
          n.x * inverse[1][0] + n.y * inverse[1][1] + n.z * inverse[1][2],
          n.x * inverse[2][0] + n.y * inverse[2][1] + n.z * inverse[2][2]};
}

/// The unit vector, or `fallback` where the length is zero or not finite.
inline V3f normalizedOr(const V3f& v, const V3f& fallback) {
  const float scale = maxAbsComponent(v);
  if (!(scale > 0) || !std::isfinite(scale)) return fallback;
  const V3f w = v / scale;
  return w / std::sqrt(w.dot(w));
}

/// An orthonormal basis around a unit vector (Duff et al., "Building an Orthonormal Basis, Revisited", JCGT
/// 2017).
struct Frame {
  V3f x, y, z;
  explicit Frame(const V3f& normal) : z(normal) {
    const float sign = std::copysign(1.0f, z.z);
    const float a = -1 / (sign + z.z);
    const float b = z.x * z.y * a;
    x = V3f(1 + sign * z.x * z.x * a, sign * b, -sign * z.x);
    y = V3f(b, sign + z.y * z.y * a, -z.y);
  }
  V3f toWorld(const V3f& v) const { return x * v.x + y * v.y + z * v.z; }
  V3f toLocal(const V3f& v) const { return {x.dot(v), y.dot(v), z.dot(v)}; }
};

}  // namespace patina
