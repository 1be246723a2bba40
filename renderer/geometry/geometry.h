// SPDX-License-Identifier: Apache-2.0
// All geometry of a frame: the surface of every primitive, its facets for tracing, and where each is placed.
#pragma once

#include <memory>
#include <vector>

#include "renderer/geometry/patches.h"
#include "renderer/geometry/surface.h"

namespace patina {

/// A surface as it is traced. Flat surfaces are traced by their faces and keep no vertices here.
struct TracedSurface {
  const Primitive* primitive = nullptr;
  std::unique_ptr<Surface> surface;
  M44f toMesh;         ///< primitive space to mesh space: world space, or the object's space inside an object
  uint32_t cells = 0;  ///< facets along u and v of each face; 0 = flat
  std::vector<V3f> grid;   ///< mesh space; face f at f * (cells+1)^2, rows along u
  uint32_t group = kNone;  ///< the object that it belongs to; kNone = the world
};

/// A primitive at its place in the world; instances of an object have one for each primitive of it.
struct Placement {
  uint32_t traced;                    ///< index of Geometry::traced
  uint32_t attributes;                ///< index of Scene::attributes
  uint32_t instance;                  ///< index of Geometry::instances; kNone = the world
  M44f objectToWorld, worldToObject;  ///< primitive space
  float normalSign;                   ///< -1: the outside is opposite to dPdu x dPdv of primitive space
  float facetSign;   ///< the same for the cross product of edges taken in world space
  float meshSign;    ///< the same for the cross product taken in mesh space, brought to world space as a normal
};

struct PlacedInstance {
  uint32_t object;
  uint32_t firstPlacement;
  uint32_t visibility;  ///< RayMask
  M44f meshToWorld, worldToMesh;
};

/// The point of a facet that a ray met, in world space.
struct Facet {
  V3f P;
  V3f N;        ///< unit, outside
  float error;  ///< bound on the distance between P and the plane that rays meet, world units
};

class Geometry {
 public:
  /// Builds, places, tessellates and dices everything in `scene` that some ray may meet. Errors are reported
  /// per primitive and leave it out. `scene` must outlive the geometry.
  Geometry(const Scene& scene, const RasterCamera& camera, ErrorHandler& errors);

  const Scene& scene() const { return scene_; }
  const std::vector<TracedSurface>& traced() const { return traced_; }
  const std::vector<Placement>& placements() const { return placements_; }
  const std::vector<PlacedInstance>& instances() const { return instances_; }
  const PatchTable& patches() const { return *patches_; }
  /// First traced surface of an object's group; groups are contiguous, in the order of Scene::objects.
  std::pair<uint32_t, uint32_t> groupRange(uint32_t object) const { return groups_[object]; }
  const Box3f& bound() const { return bound_; }  ///< world space

  const Surface& surface(const Placement& p) const { return *traced_[p.traced].surface; }
  const Attributes& attributes(const Placement& p) const { return scene_.attributes[p.attributes]; }

  Facet facet(uint32_t placement, uint32_t face, float u, float v) const;
  /// Corners of the two triangles of a facet cell are those of Embree: (00, 10, 01) and (11, 01, 10).
  void facetCorners(uint32_t placement, uint32_t face, float u, float v, V3f out[3], V2f& weights) const;

 private:
  void build(const Primitive& primitive, const M44d& toMesh, uint32_t group, const RasterCamera& camera,
             ErrorHandler& errors);

  const Scene& scene_;
  std::vector<TracedSurface> traced_;
  std::vector<Placement> placements_;
  std::vector<PlacedInstance> instances_;
  std::vector<std::pair<uint32_t, uint32_t>> groups_;
  std::unique_ptr<PatchTable> patches_;
  Box3f bound_;
};

}  // namespace patina
