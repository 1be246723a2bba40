// SPDX-License-Identifier: Apache-2.0
// Transforms between coordinate systems for kernels; Prepare::transform makes them.
#pragma once

#include "math.h"

namespace patina::sdk {

/// An affine map of one coordinate system to another: made in `prepare`, kept as a member, used by kernels.
class Matrix {
 public:
  Matrix() = default;
  /// Row vectors, as everywhere in the ABI: p' = p M, translation in the last row.
  explicit Matrix(const float* m)
      : x_(m[0], m[1], m[2]), y_(m[4], m[5], m[6]), z_(m[8], m[9], m[10]), origin_(m[12], m[13], m[14]) {
    const float determinant = dot(x_, cross(y_, z_)), side = determinant < 0 ? -1.0f : 1.0f;
    normalX_ = cross(y_, z_) * side, normalY_ = cross(z_, x_) * side, normalZ_ = cross(x_, y_) * side;
    scale_ = std::cbrt(std::abs(determinant));
  }

  PATINA_INLINE Vector point(const Vector& p) const { return vector(p) + origin_; }
  PATINA_INLINE Vector vector(const Vector& v) const { return x_ * v.x + y_ * v.y + z_ * v.z; }
  /// By the inverse transpose: stays perpendicular to what it was. Not of unit length; not turned inside out
  /// by mirroring.
  PATINA_INLINE Vector normal(const Vector& n) const {
    return normalX_ * n.x + normalY_ * n.y + normalZ_ * n.z;
  }
  /// How much lengths grow, averaged over directions by the volume: what a footprint is multiplied by.
  float scale() const { return scale_; }

 private:
  Vector x_{1, 0, 0}, y_{0, 1, 0}, z_{0, 0, 1}, origin_;           // images of the axes and of the origin
  Vector normalX_{1, 0, 0}, normalY_{0, 1, 0}, normalZ_{0, 0, 1};  // the matrix of cofactors
  float scale_ = 1;
};

}  // namespace patina::sdk
