// SPDX-License-Identifier: Apache-2.0
// Curves: ribbons of a given width along linear or cubic curves.
#pragma once

#include <memory>

#include "renderer/geometry/parametric_mesh_surface.h"

namespace patina {

/// One quad face per segment; u runs across the ribbon from 0 to 1, v along the segment. Without a normal "N"
/// the ribbon turns its flat side to the eye; with one it lies across it. Widths are in object space: "width"
/// (varying or vertex) or "constantwidth", 1 where neither is given. Varying values belong to segment ends,
/// uniform ones to curves, vertex ones to control points (RI 3.2, section 5.7).
class CurvesSurface final : public Surface {
 public:
  static std::unique_ptr<CurvesSurface> make(const CurveSet& curves, const Primitive& primitive,
                                             const Viewpoint& view, ErrorHandler& errors);

  uint32_t faceCount() const override { return static_cast<uint32_t>(segments_.size()); }
  FaceShape faceShape(uint32_t) const override { return FaceShape::Quad; }
  bool isFlat() const override { return false; }
  void corners(uint32_t face, V3f out[4]) const override;
  SurfacePoint evaluate(uint32_t face, float u, float v) const override;
  void interpolate(const PrimVar& variable, uint32_t face, float u, float v, float* out) const override;
  uint32_t uniformIndex(uint32_t face) const override { return segments_[face].curve; }
  V2f surfaceParameters(uint32_t face, float u, float v) const override;
  V2f parameterScale(uint32_t face) const override {
    return {1, 1 / static_cast<float>(segments_[face].inCurve)};
  }
  Box3f bound() const override { return bound_; }

 private:
  struct Segment {
    uint32_t curve;
    uint32_t firstPoint;    ///< of the curve
    uint32_t pointCount;    ///< of the curve
    uint32_t firstVarying;  ///< of the curve
    uint32_t inCurve;       ///< segments of the curve
    uint32_t index;         ///< within the curve
  };
  struct Line {
    V3d P, tangent;
    float width;
    V3f normal;
  };
  Line line(const Segment& segment, float v) const;
  void weigh(const PrimVar& variable, const Segment& segment, float v, float* out) const;
  uint32_t point(const Segment& segment, uint32_t k) const {
    return segment.firstPoint + (segment.index * step_ + k) % segment.pointCount;
  }

  std::vector<Segment> segments_;
  SplineBasis basis_;
  uint32_t step_ = 1;
  bool periodic_ = false;
  PointView points_;
  const PrimVar* width_ = nullptr;
  const PrimVar* normal_ = nullptr;
  float constantWidth_ = 1;
  Viewpoint view_;
  Box3f bound_;
};

}  // namespace patina
