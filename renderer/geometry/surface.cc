// SPDX-License-Identifier: Apache-2.0
// Surfaces of primitives: the common parts and the choice of the kind.
#include "renderer/geometry/surface.h"

#include "renderer/geometry/blobby_surface.h"
#include "renderer/geometry/curves_surface.h"
#include "renderer/geometry/nurbs_surface.h"
#include "renderer/geometry/parametric_mesh_surface.h"
#include "renderer/geometry/points_surface.h"
#include "renderer/geometry/polygon_surface.h"
#include "renderer/geometry/quadric_surface.h"
#include "renderer/geometry/subdivision_surface.h"
#include "renderer/scene/value_count.h"

namespace patina {
namespace {

template <class... Visitors>
struct Overloaded : Visitors... {
  using Visitors::operator()...;
};

}  // namespace

void Surface::evaluateGrid(uint32_t face, std::span<const double> u, std::span<const double> v,
                           std::span<V3f> out) const {
  thread_local std::vector<V2f> uv;
  thread_local std::vector<SurfacePoint> points;
  uv.clear();
  for (const double y : v)
    for (const double x : u) uv.emplace_back(static_cast<float>(x), static_cast<float>(y));
  points.resize(uv.size());
  evaluateMany(face, uv, points);
  for (size_t i = 0; i < points.size(); ++i) out[i] = points[i].P;
}

std::unique_ptr<Surface> makeSurface(const Primitive& primitive, ErrorHandler& errors,
                                     const Viewpoint& view) {
  return std::visit(
      Overloaded{
          [&](const PolygonMesh& mesh) -> std::unique_ptr<Surface> {
            return PolygonSurface::make({mesh.loopsPerFace, mesh.vertsPerLoop, mesh.vertices, mesh.sides},
                                        primitive, errors);
          },
          [&](const Quadric& quadric) -> std::unique_ptr<Surface> {
            return QuadricSurface::make(quadric, primitive, errors);
          },
          [&](const ParametricMesh& mesh) -> std::unique_ptr<Surface> {
            return ParametricMeshSurface::make(mesh, primitive, errors);
          },
          [&](const CurveSet& curves) -> std::unique_ptr<Surface> {
            return CurvesSurface::make(curves, primitive, view, errors);
          },
          [&](const NurbsPatch& patch) -> std::unique_ptr<Surface> {
            return NurbsSurface::make(patch, primitive, errors);
          },
          [&](const PointSet& points) -> std::unique_ptr<Surface> {
            return PointsSurface::make(points, primitive, errors);
          },
          [&](const Blobby& blobby) -> std::unique_ptr<Surface> {
            return BlobbySurface::make(blobby, primitive, view, errors);
          },
          [&](const SubdivisionMesh& mesh) { return makeSubdivisionSurface(mesh, primitive, errors); }},
      primitive.shape);
}

const PrimVar* findVariable(const Primitive& primitive, std::string_view name) {
  for (const PrimVar& variable : primitive.variables)
    if (variable.name == name) return &variable;
  return nullptr;
}

size_t valueCount(const Shape& shape, size_t vertexCount, StorageClass storage) {
  return valueCounts(shape, vertexCount).of(storage);
}

}  // namespace patina
