// SPDX-License-Identifier: Apache-2.0
// Curves: ribbons and tubes of a given width along linear or cubic curves.
#pragma once

#include <memory>

#include "renderer/geometry/dual.h"
#include "renderer/geometry/parametric_mesh_surface.h"

namespace patina {

/// One quad face per segment; u runs across the curve from 0 to 1, v along the segment.
///
/// With a normal "N" a curve is a ribbon that lies across N. Without one it is a ribbon that turns its flat
/// side to the eye or, where CurveSet::round asks for it, a tube: circles of the width as diameter around the
/// curve, open at both ends, u once around with its seam at u = 0 and 1 (the same points, bit for bit), the
/// outside outside. Tubes do not depend on the eye: their frames are rotation minimising (Wang, Juettler,
/// Zheng and Liu, "Computation of Rotation Minimizing Frames", ACM TOG 27(1), 2008), begin with an arbitrary
/// angle and, on periodic curves, share what they lack after a turn evenly among the segments.
///
/// Where two segments meet at an angle, ribbons and tubes are mitred: both end in the plane that halves it,
/// at half the width from the curve, so that the segments of a curve agree bit for bit on their common edge.
///
/// Widths are diameters in object space: "width" of any class or "constantwidth", 1 where neither is given;
/// negative ones count as 0. Varying values belong to segment ends, uniform ones to curves, vertex ones to
/// control points (RI 3.2, section 5.7). With "hpoint Pw" of positive weights the curves are rational.
class CurvesSurface final : public Surface {
 public:
  static std::unique_ptr<CurvesSurface> make(const CurveSet& curves, const Primitive& primitive,
                                             const Viewpoint& view, ErrorHandler& errors);

  uint32_t faceCount() const override { return faces_; }
  FaceShape faceShape(uint32_t) const override { return FaceShape::Quad; }
  bool isFlat() const override { return false; }
  void corners(uint32_t face, V3f out[4]) const override;
  SurfacePoint evaluate(uint32_t face, float u, float v) const override;
  void evaluateMany(uint32_t face, std::span<const V2f> uv, std::span<SurfacePoint> out) const override;
  void interpolate(const PrimVar& variable, uint32_t face, float u, float v, float* out) const override;
  uint32_t uniformIndex(uint32_t face) const override { return curveOf(face); }
  V2f surfaceParameters(uint32_t face, float u, float v) const override;
  V2f parameterScale(uint32_t face) const override;
  Box3f bound() const override { return bound_; }

 private:
  /// Where a curve begins; its end is where the next one begins.
  struct Curve {
    uint32_t firstPoint, firstSegment;
  };
  /// Of tubes, for each end of a segment (in the order of varying values): the angle of the frame there to a
  /// fixed one around the tangent, and by how much the segment that begins there twists. Radians.
  struct Turn {
    float angle, twist;
  };
  /// A segment by its numbers.
  struct Place {
    uint32_t curve, firstPoint, pointCount;
    uint32_t index, count;  ///< of the segment in the curve, of segments in the curve
  };
  /// A segment with the directions of its ends, which it shares with its neighbours.
  struct Segment {
    Place place;
    V3d direction[2];
    V3d lean[2];  ///< direction less the segment's own tangent
    double scale;
  };
  /// The cross-section at v, with derivatives by v.
  struct Section {
    DualV3 P, direction;
    Dual width;
    DualV3 across, up;  ///< ribbons: `across`; tubes: the axes of the circle
    double scale;       ///< of the segment's size
  };
  struct Jet {
    V3d P, d1, d2;
  };

  uint32_t curveOf(uint32_t face) const { return curveOf_.empty() ? face : curveOf_[face]; }
  Place placeOf(uint32_t face) const;
  uint32_t point(const Place& place, uint32_t k) const {
    return place.firstPoint + (place.index * step_ + k) % place.pointCount;
  }
  uint32_t varying(const Place& place, uint32_t end) const;
  Dual blend(const PrimVar& variable, const Place& place, double v, size_t component) const;
  Box3f computeBound() const;

  // curve_frames.cc
  Jet jet(const Place& place, double v) const;
  double sizeOf(const Place& place) const;
  DualV3 tangent(const Place& place, double v) const;
  V3d endDirection(const Place& place, uint32_t end) const;
  Segment open(const Place& place) const;
  DualV3 direction(const Segment& segment, double v) const;
  V3d carry(const Segment& segment, V3d axis, double v, V3d& at) const;
  Section section(const Segment& segment, double v) const;
  void makeTurns();
  void makeTurns(uint32_t curve);

  SurfacePoint pointOn(const Section& section, double u) const;

  std::vector<Curve> curves_;      ///< and the end of the last one
  std::vector<uint32_t> curveOf_;  ///< by segment; empty when each curve has one
  std::vector<Turn> turns_;        ///< of tubes
  uint32_t faces_ = 0;
  SplineBasis basis_;
  uint32_t step_ = 1;
  bool periodic_ = false, round_ = false, rational_ = false;
  const float* points_ = nullptr;  ///< 3 or, rational, 4 floats each
  const PrimVar* width_ = nullptr;
  const PrimVar* normal_ = nullptr;
  Viewpoint view_;
  Box3f bound_;
};

}  // namespace patina
