// SPDX-License-Identifier: Apache-2.0
// Points: a ball around each point, made of the six faces of a cube drawn onto it.
#pragma once

#include <memory>
#include <vector>

#include "renderer/geometry/primvar.h"
#include "renderer/geometry/surface.h"

namespace patina {

/// Face f belongs to point f / 6. Its u and v are angles of a quarter turn about two axes (the equiangular
/// cubed sphere of C. Ronchi, R. Iacono, P. S. Paolucci, "The Cubed Sphere", J. Comput. Phys. 124, 1996,
/// section 2.1), so that micropolygons of a face differ in area by a factor of 1.4 at most. Edges are equal
/// bit for bit in the faces that share them. N points away from the point.
///
/// Diameters are "width" (one per point) or "constantwidth", 1 where neither is given, in object space.
/// Varying and vertex values belong to points, uniform ones to the whole (RI 3.2, section 5.5). A point has
/// no surface parameters: they are (0, 0).
class PointsSurface final : public Surface {
 public:
  /// nullptr with an error when no point is left; points without a positive width are left out with a
  /// warning.
  static std::unique_ptr<PointsSurface> make(const PointSet& points, const Primitive& primitive,
                                             ErrorHandler& errors);

  uint32_t faceCount() const override { return 6 * count_; }
  FaceShape faceShape(uint32_t) const override { return FaceShape::Quad; }
  bool isFlat() const override { return false; }
  void corners(uint32_t face, V3f out[4]) const override;
  SurfacePoint evaluate(uint32_t face, float u, float v) const override;
  void interpolate(const PrimVar& variable, uint32_t face, float u, float v, float* out) const override;
  uint32_t uniformIndex(uint32_t) const override { return 0; }
  V2f surfaceParameters(uint32_t, float, float) const override { return {0, 0}; }
  V2f parameterScale(uint32_t) const override { return {0, 0}; }
  Box3f bound() const override { return bound_; }
  void evaluateGrid(uint32_t face, std::span<const double> u, std::span<const double> v,
                    std::span<V3f> out) const override;

 private:
  PointsSurface() = default;
  uint32_t pointOf(uint32_t face) const { return kept_.empty() ? face / 6 : kept_[face / 6]; }
  double radius(uint32_t point) const {
    return static_cast<double>(widths_.empty() ? constantWidth_ : widths_[point]) / 2;
  }

  PointView points_;
  std::span<const float> widths_;  ///< of each point; empty: all have constantWidth_
  float constantWidth_ = 1;
  uint32_t count_ = 0;          ///< points that are drawn
  std::vector<uint32_t> kept_;  ///< their indices; empty: all points are drawn
  Box3f bound_;
};

}  // namespace patina
