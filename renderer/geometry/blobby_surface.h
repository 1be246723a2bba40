// SPDX-License-Identifier: Apache-2.0
// Blobby: the mesh of an implicit surface, as fine as the picture needs.
#pragma once

#include <memory>

#include "renderer/geometry/blobby_mesh.h"
#include "renderer/geometry/surface.h"

namespace patina {

/// Triangles with the normals of the field at their vertices, between which they are interpolated: shading is
/// smooth, and dPdu and dPdv are those of the triangle. The outside is where the field is less.
///
/// Varying and vertex values belong to fields. At a vertex each field has the share that
/// BlobbyField::weights() gives it; triangles interpolate between their vertices. Uniform values belong to
/// the whole, and surface parameters are object x, y, as on polygons.
class BlobbySurface final : public Surface {
 public:
  /// nullptr with a warning when the field has no surface, with an error when it can't be meshed. Where the
  /// picture is small its cells are fewer than `limits` allow.
  static std::unique_ptr<BlobbySurface> make(const Blobby& blobby, const Primitive& primitive,
                                             const Viewpoint& view, ErrorHandler& errors,
                                             const BlobbyMeshLimits& limits = {});

  uint32_t faceCount() const override { return static_cast<uint32_t>(mesh_.triangles.size()); }
  FaceShape faceShape(uint32_t) const override { return FaceShape::Triangle; }
  bool isFlat() const override { return true; }
  bool hasSmoothNormals() const override { return true; }
  void corners(uint32_t face, V3f out[4]) const override;
  SurfacePoint evaluate(uint32_t face, float u, float v) const override;
  void interpolate(const PrimVar& variable, uint32_t face, float u, float v, float* out) const override;
  uint32_t uniformIndex(uint32_t) const override { return 0; }
  V2f surfaceParameters(uint32_t face, float u, float v) const override;
  V2f parameterScale(uint32_t face) const override;
  Box3f bound() const override { return bound_; }

  const BlobbyMesh& mesh() const { return mesh_; }

 private:
  BlobbySurface() = default;
  BlobbyMesh mesh_;
  Box3f bound_;
};

}  // namespace patina
