// SPDX-License-Identifier: Apache-2.0
// NuPatch: non-uniform B-spline surfaces, plain or rational, whole or trimmed.
#pragma once

#include <memory>
#include <optional>

#include "renderer/geometry/primvar.h"
#include "renderer/geometry/spline_direction.h"
#include "renderer/geometry/surface.h"

namespace patina {

/// One quad face per pair of knot intervals with a length inside [umin, umax] x [vmin, vmax], row by row
/// along u (Piegl and Tiller, The NURBS Book, 2nd ed., sections 3.4 and 4.4; in double). Neighbouring faces
/// agree bit for bit on their common edge, and so do the two ends of a surface that is closed: by equal
/// control points at clamped ends, or by a spline that ends as it begins (SplineDirection::seam).
///
/// RI 3.2, section 5: u and v of RI run over the knots, umin to umax and vmin to vmax; TextureCoordinates
/// belong to the corners of that range. Segments, which uniform and varying values belong to, are the
/// intervals between all neighbouring knots, those without a length among them: 1 + n - order along a side.
/// Points of weight 0 stand for directions, as in half a circle by three points: they are added to the others
/// as they are, and all is well as long as some weight is left everywhere.
///
/// Vertex values are weighted like the points, with their weights if these are rational; facevarying and
/// facevertex ones are four per segment.
///
/// Trim loops enclose what a line crosses them an odd number of times to get out of. That is cut out
/// while Attribute "trimcurve" "sense" is "inside", the default (so PRMan's table of attributes and Aqsis's
/// manual have it); with "outside" all else is.
class NurbsSurface final : public Surface {
 public:
  static std::unique_ptr<NurbsSurface> make(const NurbsPatch& patch, const Primitive& primitive,
                                            ErrorHandler& errors);

  uint32_t faceCount() const override { return u_.intervals() * v_.intervals(); }
  FaceShape faceShape(uint32_t) const override { return FaceShape::Quad; }
  bool isFlat() const override { return flat_; }
  void corners(uint32_t face, V3f out[4]) const override;
  SurfacePoint evaluate(uint32_t face, float u, float v) const override;
  void interpolate(const PrimVar& variable, uint32_t face, float u, float v, float* out) const override;
  uint32_t uniformIndex(uint32_t face) const override {
    return v_.segment(row(face)) * segmentsU_ + u_.segment(column(face));
  }
  V2f surfaceParameters(uint32_t face, float u, float v) const override;
  V2f textureParameters(uint32_t face, float u, float v) const override;
  V2f parameterScale(uint32_t face) const override;
  Box3f bound() const override { return bound_; }
  bool hasHoles() const override { return trim_ != nullptr; }
  bool isHole(uint32_t face, float u, float v) const override;
  void evaluateGrid(uint32_t face, std::span<const double> u, std::span<const double> v,
                    std::span<V3f> out) const override;

 private:
  using Weights = SplineDirection::Weights;
  struct Hpoint {
    double x, y, z, w;
  };
  using V2d = Imath::V2d;
  struct Jet {
    V3d P, du, dv;
  };

  NurbsSurface() = default;
  uint32_t column(uint32_t face) const { return face % u_.intervals(); }
  uint32_t row(uint32_t face) const { return face / u_.intervals(); }
  Hpoint control(size_t column, size_t row) const;
  Hpoint sum(const Weights& u, const Weights& v) const;
  V3d position(const Weights& u, const Weights& v) const;
  Jet jet(uint32_t face, double u, double v) const;
  void closeSeams();
  bool isParallelogram(uint32_t face) const;
  Box3f computeBound() const;
  /// Parameters of a place without a weight; nullopt: there is none.
  std::optional<V2d> vanishingWeight() const;
  template <class Visit>
  void forEachBezierPoint(uint32_t face, const Visit& visit) const;

  SplineDirection u_, v_;
  size_t nu_ = 0;  ///< control points in a row
  uint32_t segmentsU_ = 0;
  bool rational_ = false, flat_ = false, keepInside_ = false;
  bool infinite_ = false;  ///< some weights are 0
  std::shared_ptr<const TrimRegion> trim_;
  const float* points_ = nullptr;  ///< 3 or, rational, 4 floats each
  Box3f bound_;
};

}  // namespace patina
