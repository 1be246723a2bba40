// SPDX-License-Identifier: Apache-2.0
// Primitives that move: their state at the time steps of the shutter.
#pragma once

#include <memory>
#include <vector>

#include "renderer/geometry/surface.h"
#include "renderer/scene/scene.h"

namespace patina {

/// A primitive whose facets move against each other, or against the mesh space that they are traced in: it is
/// posed at segments + 1 time steps at equal distances over the shutter, with straight paths in between.
struct PosedPrimitive {
  const Primitive* primitive;
  double open, close;
  uint32_t segments;
  bool placeMoves;  ///< in its mesh space

  double time(uint32_t step) const {
    return open + (close - open) * static_cast<double>(step) / static_cast<double>(segments);
  }
  Primitive at(uint32_t step) const;  ///< with its shape at that step
};

/// Time steps for a primitive that is traced in the space of `toMesh` (or, if `placeMoves`, in that of its
/// own movement's target) between two times. `bound`: primitive space, at the opening. 0: it does not change.
uint32_t poseSegments(const Primitive& primitive, double open, double close, bool placeMoves,
                      const Box3f& bound);

/// Polygons at another time step: the faces of the opening between other points. Views `base`.
class PosedPolygons final : public Surface {
 public:
  PosedPolygons(const Surface& base, Primitive posed);

  uint32_t faceCount() const override { return base_.faceCount(); }
  FaceShape faceShape(uint32_t face) const override { return base_.faceShape(face); }
  bool isFlat() const override { return true; }
  void corners(uint32_t face, V3f out[4]) const override;
  SurfacePoint evaluate(uint32_t face, float u, float v) const override;
  void interpolate(const PrimVar& variable, uint32_t face, float u, float v, float* out) const override {
    base_.interpolate(variable, face, u, v, out);
  }
  uint32_t uniformIndex(uint32_t face) const override { return base_.uniformIndex(face); }
  V2f surfaceParameters(uint32_t face, float u, float v) const override {
    return base_.surfaceParameters(face, u, v);
  }
  V2f parameterScale(uint32_t face) const override { return base_.parameterScale(face); }
  Box3f bound() const override;

 private:
  const Surface& base_;
  const Primitive posed_;
  const PrimVar* points_;
};

/// A surface that owns the primitive that it views.
struct PosedSurface {
  std::unique_ptr<const Primitive> primitive;
  std::unique_ptr<const Surface> surface;
};

}  // namespace patina
