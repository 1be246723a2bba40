// SPDX-License-Identifier: Apache-2.0
// Poses of deforming primitives.
#include "renderer/geometry/motion_geometry.h"

#include <array>

#include "renderer/scene/shape_motion.h"

namespace patina {

Primitive PosedPrimitive::at(uint32_t step) const {
  Primitive posed = *primitive;
  setShape(posed, *primitive->motion, time(step));
  return posed;
}

uint32_t poseSegments(const Primitive& primitive, double open, double close, bool placeMoves,
                      const Box3f& bound) {
  if (!primitive.motion) return 0;
  const PrimitiveMotion& motion = *primitive.motion;
  const bool deforms = deformsWithin(motion, open, close);
  placeMoves = placeMoves && motion.place.movesWithin(open, close);
  if (!deforms && !placeMoves) return 0;
  // Every key of the shape on a step, as far as they are at equal distances.
  const auto keysFit = [&](size_t segments) {
    for (const ShapeKey& key : motion.shapes) {
      const double step = (key.time - open) / (close - open) * static_cast<double>(segments);
      if (key.time > open && key.time < close && std::abs(step - std::round(step)) > 1e-3) return false;
    }
    return true;
  };
  // Straight paths near to those of a movement, in the mean of two steps.
  const auto pathsFit = [&](size_t segments) {
    for (size_t k = 0; k < segments; ++k)
      for (const double s : {0.2113, 0.5, 0.8277}) {
        const auto at = [&](double step) {
          return motion.place.at(open + (close - open) * step / static_cast<double>(segments));
        };
        const auto start = static_cast<double>(k);
        const M44d exact = at(start + s), near = at(start) * (1 - s) + at(start + 1) * s;
        double deviation = 0, size = 0;
        for (unsigned c = 0; c < 8; ++c) {
          const V3d corner(static_cast<double>(c & 1 ? bound.max.x : bound.min.x),
                           static_cast<double>(c & 2 ? bound.max.y : bound.min.y),
                           static_cast<double>(c & 4 ? bound.max.z : bound.min.z));
          deviation = std::max(deviation, (corner * exact - corner * near).length());
          size = std::max(size, ((corner - V3d(bound.min)) * exact - V3d(0) * exact).length());
        }
        if (!(deviation <= size / 4096)) return false;
      }
    return true;
  };
  for (const size_t segments : MotionSteps::kCandidates)
    if ((!deforms || keysFit(segments)) && (!placeMoves || pathsFit(segments)))
      return static_cast<uint32_t>(segments);
  return static_cast<uint32_t>(MotionSteps::kMost);
}

PosedPolygons::PosedPolygons(const Surface& base, Primitive posed)
    : base_(base), posed_(std::move(posed)), points_(findVariable(posed_, "P")) {}

void PosedPolygons::corners(uint32_t face, V3f out[4]) const {
  const int count = faceShape(face) == FaceShape::Quad ? 4 : 3;
  for (int k = 0; k < count; ++k)
    base_.interpolate(*points_, face, static_cast<float>(k & 1), static_cast<float>(k >> 1), &out[k].x);
}

SurfacePoint PosedPolygons::evaluate(uint32_t face, float u, float v) const {
  V3f c[4];
  corners(face, c);
  const bool first = faceShape(face) == FaceShape::Triangle || u + v <= 1;
  const V3f du = first ? c[1] - c[0] : c[3] - c[2], dv = first ? c[2] - c[0] : c[3] - c[1];
  const V3f p = first ? c[0] + du * u + dv * v : c[3] - du * (1 - u) - dv * (1 - v);
  return {p, normalizedOr(du.cross(dv), V3f(0, 0, 1)), du, dv};
}

Box3f PosedPolygons::bound() const {
  Box3f box;
  for (size_t k = 0; k + 2 < points_->floats.size(); k += 3)
    box.extendBy({points_->floats[k], points_->floats[k + 1], points_->floats[k + 2]});
  return box;
}

}  // namespace patina
