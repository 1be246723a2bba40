// SPDX-License-Identifier: Apache-2.0
// Boxes around transformed boxes and around meshes.
#include "renderer/geometry/bounds.h"

#include "renderer/geometry/primvar.h"

namespace patina {

Box3f transformed(const Box3f& box, const M44f& m) {
  Box3f result;
  for (int corner = 0; corner < 8; ++corner)
    result.extendBy(transformPoint({corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                                    corner & 4 ? box.max.z : box.min.z},
                                   m));
  return result;
}

Box3f padded(const Box3f& box) {
  const float pad = 1e-6f * std::max(maxAbsComponent(box.min), maxAbsComponent(box.max));
  return {box.min - V3f(pad), box.max + V3f(pad)};
}

Box3f meshBound(const Primitive& primitive) {
  Box3f box;
  const auto* polygons = std::get_if<PolygonMesh>(&primitive.shape);
  const auto* subdivision = std::get_if<SubdivisionMesh>(&primitive.shape);
  if (!subdivision && (!polygons || polygons->vertsPerLoop.size() <= kFewFaces)) return box;
  if (const auto points = findPoints(primitive))
    for (size_t k = 0; k < points->size(); ++k)
      if (const V3f p = (*points)[k]; usable(p)) box.extendBy(p);
  return box;
}

}  // namespace patina
