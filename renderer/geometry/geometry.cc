// SPDX-License-Identifier: Apache-2.0
// From the primitives of a scene to placed surfaces, facets and patches.
#include "renderer/geometry/geometry.h"

#include <tbb/parallel_for.h>

#include "renderer/base/statistics.h"

namespace patina {
namespace {

STAT_COUNTER("Geometry/primitives", primitiveCount);
STAT_COUNTER("Geometry/faces", faceCount);
STAT_COUNTER("Geometry/facets of curved surfaces", facetCount);
STAT_COUNTER("Geometry/patches", patchCount);
STAT_COUNTER("Geometry/instances", instanceCount);

bool invertible(const M44d& m) {
  const double d = m.determinant();
  return std::isfinite(d) && d != 0;
}

Placement makePlacement(uint32_t traced, uint32_t attributes, uint32_t instance, const M44d& objectToWorld,
                        const M44d& toMesh, bool reversed) {
  Placement p{};
  p.traced = traced, p.attributes = attributes, p.instance = instance;
  p.objectToWorld = M44f(objectToWorld), p.worldToObject = M44f(objectToWorld.inverse());
  p.normalSign = reversed ? -1.0f : 1.0f;
  p.facetSign = objectToWorld.determinant() < 0 ? -p.normalSign : p.normalSign;
  p.meshSign = toMesh.determinant() < 0 ? -p.normalSign : p.normalSign;
  return p;
}

}  // namespace

void Geometry::build(const Primitive& primitive, const M44d& toMesh, uint32_t group, const RasterCamera& camera,
                     ErrorHandler& errors) {
  if (!invertible(toMesh)) {
    errors.report(Severity::Error, RiError::Math, primitive.where,
                  "the transformation of this primitive is singular");
    return;
  }
  // Instances share their object's surfaces: what turns to the eye does so from the object's own place.
  const M44d inverse = toMesh.inverse();
  Viewpoint view;
  view.perspective = camera.perspective();
  view.eye = V3f(V3d(camera.eye()) * inverse);
  view.direction = normalizedOr(transformVector(camera.viewDirection(), M44f(inverse)), V3f(0, 0, 1));
  auto surface = makeSurface(primitive, errors, view);
  if (!surface || surface->faceCount() == 0) return;
  ++primitiveCount;
  faceCount += surface->faceCount();
  traced_.push_back({&primitive, std::move(surface), M44f(toMesh), 0, {}, group});
}

Geometry::Geometry(const Scene& scene, const RasterCamera& camera, ErrorHandler& errors) : scene_(scene) {
  // Surfaces: those of the world first, then object by object.
  for (const Primitive& primitive : scene.primitives) {
    const Attributes& attributes = scene.attributes[primitive.attributes];
    if (attributes.visibility == 0 && attributes.areaLight == kNone) continue;
    build(primitive, primitive.objectToWorld, kNone, camera, errors);
  }
  const auto worldCount = static_cast<uint32_t>(traced_.size());
  std::vector<bool> used(scene.objects.size(), false);
  for (const Instance& instance : scene.instances) used[instance.object] = true;
  for (uint32_t object = 0; object < scene.objects.size(); ++object) {
    const auto first = static_cast<uint32_t>(traced_.size());
    if (used[object])
      for (const Primitive& primitive : scene.objects[object].primitives)
        build(primitive, primitive.objectToWorld, object, camera, errors);
    groups_.emplace_back(first, static_cast<uint32_t>(traced_.size()));
  }

  // Placements.
  for (uint32_t k = 0; k < worldCount; ++k) {
    const Primitive& primitive = *traced_[k].primitive;
    placements_.push_back(makePlacement(k, primitive.attributes, kNone, primitive.objectToWorld,
                                        primitive.objectToWorld, primitive.reversed));
  }
  for (const Instance& instance : scene.instances) {
    if (!invertible(instance.objectToWorld)) {
      errors.report(Severity::Error, RiError::Math, instance.where,
                    "the transformation of this instance is singular");
      continue;
    }
    const auto [first, end] = groups_[instance.object];
    if (first == end) continue;
    ++instanceCount;
    const auto index = static_cast<uint32_t>(instances_.size());
    instances_.push_back({instance.object, static_cast<uint32_t>(placements_.size()),
                          scene.attributes[instance.attributes].visibility, M44f(instance.objectToWorld),
                          M44f(instance.objectToWorld.inverse())});
    for (uint32_t k = first; k < end; ++k) {
      const Primitive& primitive = *traced_[k].primitive;
      const uint32_t attributes = primitive.attributes == kNone ? instance.attributes : primitive.attributes;
      placements_.push_back(makePlacement(k, attributes, index,
                                          primitive.objectToWorld * instance.objectToWorld,
                                          primitive.objectToWorld, primitive.reversed != instance.reversed));
    }
  }

  // Facets of curved surfaces: as fine as the most demanding of their placements asks.
  std::vector<DiceInput> dice;
  dice.reserve(placements_.size());
  for (const Placement& p : placements_)
    dice.push_back({traced_[p.traced].surface.get(), p.objectToWorld, attributes(p).shadingRate});
  {
    PhaseTimer timer("Tessellate");
    std::vector<uint32_t> cells(placements_.size(), 0);
    tbb::parallel_for(size_t{0}, placements_.size(), [&](size_t k) {
      if (!dice[k].surface->isFlat()) cells[k] = traceCells(camera, dice[k]);
    });
    for (size_t k = 0; k < placements_.size(); ++k) {
      TracedSurface& traced = traced_[placements_[k].traced];
      traced.cells = std::max(traced.cells, cells[k]);
    }
    tbb::parallel_for(size_t{0}, traced_.size(), [&](size_t k) {
      TracedSurface& traced = traced_[k];
      if (traced.cells == 0) return;
      const size_t row = traced.cells + 1;
      traced.grid.resize(row * row * traced.surface->faceCount());
      traced.surface->tessellate(traced.cells, traced.grid);
      for (V3f& p : traced.grid) p = transformPoint(p, traced.toMesh);
      facetCount += static_cast<int64_t>(traced.cells) * traced.cells * traced.surface->faceCount();
    });
  }
  {
    PhaseTimer timer("Dice");
    patches_ = std::make_unique<PatchTable>(camera, dice);
    patchCount += static_cast<int64_t>(patches_->size());
    if (patches_->limited())
      errors.report(Severity::Warning, RiError::LimitCheck, {},
                    "too many micropolygons: some patches stay coarser than ShadingRate asks");
  }
  for (const Placement& p : placements_) {
    const Box3f box = surface(p).bound();
    for (int corner = 0; corner < 8; ++corner)
      bound_.extendBy(transformPoint({corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                                      corner & 4 ? box.max.z : box.min.z},
                                     p.objectToWorld));
  }
  size_t bytes = patches_->memory();
  for (const TracedSurface& traced : traced_)
    bytes += traced.grid.size() * sizeof(V3f) + traced.surface->memory();
  setStatistic("Memory/geometry MB", static_cast<double>(bytes) / 1048576);
}

void Geometry::facetCorners(uint32_t placement, uint32_t face, float u, float v, V3f out[3],
                            V2f& weights) const {
  const TracedSurface& traced = traced_[placements_[placement].traced];
  V3f quad[4];
  if (traced.cells == 0) {
    traced.surface->corners(face, quad);
    const bool triangle = traced.surface->faceShape(face) == FaceShape::Triangle;
    for (int k = 0; k < (triangle ? 3 : 4); ++k) quad[k] = transformPoint(quad[k], traced.toMesh);
    if (triangle) u = std::min(u, 1 - v);
  } else {
    const uint32_t row = traced.cells + 1;
    const float x = u * static_cast<float>(traced.cells), y = v * static_cast<float>(traced.cells);
    const uint32_t i = std::min(static_cast<uint32_t>(std::max(x, 0.0f)), traced.cells - 1);
    const uint32_t j = std::min(static_cast<uint32_t>(std::max(y, 0.0f)), traced.cells - 1);
    const V3f* corner = &traced.grid[size_t{face} * row * row + size_t{j} * row + i];
    quad[0] = corner[0], quad[1] = corner[1], quad[2] = corner[row], quad[3] = corner[row + 1];
    u = x - static_cast<float>(i), v = y - static_cast<float>(j);
  }
  const bool first = u + v <= 1;
  out[0] = first ? quad[0] : quad[3];
  out[1] = first ? quad[1] : quad[2];
  out[2] = first ? quad[2] : quad[1];
  weights = first ? V2f(u, v) : V2f(1 - u, 1 - v);
}

Facet Geometry::facet(uint32_t placement, uint32_t face, float u, float v) const {
  const Placement& p = placements_[placement];
  V3f c[3];
  V2f w;
  facetCorners(placement, face, u, v, c, w);
  float magnitude = 0;
  if (p.instance != kNone) {
    const M44f& m = instances_[p.instance].meshToWorld;
    for (V3f& corner : c) corner = transformPoint(corner, m);
    // The ray is taken to mesh space and the point back: cancellation is bounded by the terms of the sum.
    const V3f local = transformPoint(c[0], instances_[p.instance].worldToMesh);
    magnitude = maxAbsComponent({m[3][0], m[3][1], m[3][2]}) + maxAbsComponent(transformVector(local, m));
  }
  const V3f e1 = c[1] - c[0], e2 = c[2] - c[0];
  Facet facet;
  facet.P = c[0] * (1 - w.x - w.y) + c[1] * w.x + c[2] * w.y;
  facet.N = normalizedOr(e1.cross(e2), V3f(0, 0, 0)) * p.facetSign;
  // Facets without area (poles, collapsed edges) take the normal of the smooth surface.
  if (facet.N.length2() == 0)
    facet.N =
        normalizedOr(transformNormal(surface(p).evaluate(face, u, v).N, p.worldToObject), V3f(0, 0, 1)) *
        p.normalSign;
  // Interpolation is good to a few roundings of the corners; the plane that a traversal kernel meets, to a
  // few of the corners' distance from the ray's origin, which the facet's extent stands for when origins lie
  // on facets.
  magnitude = std::max(magnitude, maxAbsComponent(facet.P)) + maxAbsComponent(e1) + maxAbsComponent(e2);
  facet.error = roundingBound(16) * magnitude;
  return facet;
}

}  // namespace patina
