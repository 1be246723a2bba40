// SPDX-License-Identifier: Apache-2.0
// Polygon meshes as triangles and two-triangle quads that keep nothing but indices.
#pragma once

#include <memory>
#include <vector>

#include "renderer/geometry/primvar.h"
#include "renderer/geometry/surface.h"

namespace patina {

/// Views of a polygon mesh's arrays, which must outlive the surface.
struct PolygonArrays {
  std::span<const int> loopsPerFace;  ///< empty: one loop each
  std::span<const int> vertsPerLoop;
  std::span<const int> vertices;
  int sides = 0;  ///< > 0: vertices of every loop; vertsPerLoop is empty then
  size_t loopCount() const {
    return sides > 0 ? vertices.size() / static_cast<size_t>(sides) : vertsPerLoop.size();
  }
  size_t faceCount() const { return loopsPerFace.empty() ? loopCount() : loopsPerFace.size(); }
  int loopSize(size_t loop) const { return sides > 0 ? sides : vertsPerLoop[loop]; }
};

/// Triangles stay triangles. A four-sided polygon becomes one quad, convex or not, where one of its two
/// diagonals cuts it into triangles that face the same way; the rest is triangulated. N is (P1-P0) x (P2-P0)
/// in the vertices' order: the outside that RI 3.2 asks for (clockwise seen from the outside in left-handed
/// coordinates).
///
/// Positions on an edge are exact to rounding from either side, at parameters that are multiples of 2^-24:
/// neighbouring faces give the same bits.
class PolygonSurface final : public Surface {
 public:
  /// nullptr with an error when no polygon is left; polygons that make no sense are left out with a warning.
  static std::unique_ptr<PolygonSurface> make(const PolygonArrays& arrays, const Primitive& primitive,
                                              ErrorHandler& errors);

  uint32_t faceCount() const override;
  FaceShape faceShape(uint32_t face) const override;
  bool isFlat() const override { return true; }
  void corners(uint32_t face, V3f out[4]) const override;
  PointView sharedPoints() const override { return points_; }
  void cornerPoints(uint32_t face, uint32_t out[4]) const override;
  SurfacePoint evaluate(uint32_t face, float u, float v) const override;
  void interpolate(const PrimVar& variable, uint32_t face, float u, float v, float* out) const override;
  uint32_t uniformIndex(uint32_t face) const override;
  V2f surfaceParameters(uint32_t face, float u, float v) const override;
  V2f parameterScale(uint32_t face) const override;
  Box3f bound() const override { return bound_; }

 private:
  static constexpr uint32_t kQuad = 0xffffffffu;

  /// Indices into PolygonArrays::vertices. A quad: {first corner, kQuad, 0 or 1: which corner is (0,0)}.
  struct Face {
    uint32_t corner[3];
    uint32_t polygon;
  };
  /// The corners in the order of the polygon; count 3 or 4.
  struct Corners {
    uint32_t index[4];
    int count;
  };
  struct Builder;

  PolygonSurface(const PolygonArrays& arrays, PointView points) : arrays_(arrays), points_(points) {}
  Corners cornersOf(uint32_t face) const;
  uint32_t polygonOf(uint32_t face) const {
    return !sides_ ? faces_[face].polygon : kept_.empty() ? face : kept_[face];
  }
  V3f point(uint32_t corner) const { return points_[static_cast<size_t>(arrays_.vertices[corner])]; }

  PolygonArrays arrays_;
  PointView points_;
  uint32_t sides_ = 0;  ///< 3 or 4: every face is one polygon with so many corners and faces_ is empty
  std::vector<uint32_t> kept_;  ///< the polygons of faces, triangles all; empty: face f is polygon f
  std::vector<Face> faces_;
  Box3f bound_;
};

}  // namespace patina
