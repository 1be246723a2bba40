// SPDX-License-Identifier: Apache-2.0
// Blobby: the size of its cells, evaluation, primitive variables.
#include "renderer/geometry/blobby_surface.h"

#include <fmt/format.h>

#include <algorithm>

#include "renderer/geometry/primvar.h"

namespace patina {
namespace {

/// Cubes that the surface may pass through for each pixel of the picture, or kFewCells: about seven triangles
/// each. A surface that reaches far beyond a narrow view would be made of millions that nobody sees one by
/// one.
constexpr double kCellsPerPixel = 8;
constexpr double kFewCells = double{1 << 16};

constexpr double kLeastCell = 0.25;  // pixels

/// Edge of the lattice's cubes, object space. A chord of length c of a circle of radius r leaves it by c^2 /
/// 8r: with c = sqrt(r) pixels that is an eighth of a pixel, and triangles are smaller than cubes. At least
/// four cubes go across a field's own surface, unless they would be less than a quarter of a pixel. Fields
/// that are thinner than half of such a cube would be found by chance alone: they ask for nothing.
struct Wanted {
  double cell;
  double area;  ///< about that of the surfaces, if fields did not lie in one another
};
Wanted wantedCell(const std::vector<BlobbyField::Detail>& details, const Viewpoint& view) {
  Wanted result{std::numeric_limits<double>::infinity(), 0};
  for (const BlobbyField::Detail& detail : details) {
    const double perUnit =
        static_cast<double>(view.pixelsPerUnit(V3f(detail.center), static_cast<float>(detail.reach)));
    double wanted = detail.radius / 6;
    if (perUnit > 0 && std::isfinite(perUnit)) {
      const double pixels = detail.radius * perUnit;
      if (2 * pixels < 0.5 * kLeastCell) continue;
      wanted = std::max(std::min(std::sqrt(pixels), 0.5 * pixels), kLeastCell) / perUnit;
    }
    result.cell = std::min(result.cell, wanted);
    result.area += detail.area;
  }
  return result;
}

/// The mesh, with larger cells than wanted where those would be too many. Returns their size; 0: there is no
/// size at which it is not too much work.
double meshWithin(const BlobbyField& field, const Wanted& wanted, bool wantWeights,
                  const BlobbyMeshLimits& limits, BlobbyMesh& mesh) {
  double largest = 0;
  for (const Range& axis : field.support().axis) largest = std::max(largest, axis.high - axis.low);
  constexpr double kLeastCells = 4;  // across all of it, however small it is seen
  double cell = std::clamp(wanted.cell, largest / 1e6, largest / kLeastCells);
  const auto most = static_cast<double>(limits.cells);
  if (2 * wanted.area > most * cell * cell) {
    // A coarse mesh tells how much surface there is.
    const double coarse = std::max(cell, std::sqrt(2 * wanted.area / (most / 16)));
    if (meshBlobby(field, coarse, false, limits, mesh) == BlobbyMeshStatus::Done)
      cell = std::max(cell, coarse * std::sqrt(static_cast<double>(mesh.cells) / (0.9 * most)));
    else
      cell = std::max(cell, 2 * coarse);
  }
  while (cell <= largest) {
    const BlobbyMeshStatus status = meshBlobby(field, cell, wantWeights, limits, mesh);
    if (status == BlobbyMeshStatus::Done) return cell;
    cell *= status == BlobbyMeshStatus::TooManyCells ? 1.5 : 3;
  }
  return 0;
}

bool isPerField(const PrimVar& variable) {
  return variable.storage != StorageClass::Constant && variable.storage != StorageClass::Uniform &&
         !variable.floats.empty();
}

}  // namespace

std::unique_ptr<BlobbySurface> BlobbySurface::make(const Blobby& blobby, const Primitive& primitive,
                                                   const Viewpoint& view, ErrorHandler& errors,
                                                   const BlobbyMeshLimits& given) {
  BlobbyMeshLimits limits = given;
  if (view.pixelCount > 0)
    limits.cells = std::min(
        limits.cells,
        static_cast<size_t>(std::max(kFewCells, kCellsPerPixel * static_cast<double>(view.pixelCount))));
  const auto report = [&](Severity severity, RiError code, const std::string& text) {
    errors.report(severity, code, primitive.where, text);
    return nullptr;
  };
  size_t spoiled = 0;
  const BlobbyField field(blobby, spoiled);
  if (spoiled > 0)
    report(Severity::Warning, RiError::Math,
           fmt::format("Blobby: {} of its fields count as 0: they have a matrix without an inverse, a radius "
                       "that is not more than 0, or numbers beyond 1e18",
                       spoiled));
  const std::vector<BlobbyField::Detail> details = field.details();
  const char* const kNothing = "Blobby is left out: its field is nowhere on the threshold of a surface";
  if (details.empty()) return report(Severity::Warning, RiError::BadArgument, kNothing);

  std::unique_ptr<BlobbySurface> s(new BlobbySurface);
  const bool wantWeights = std::ranges::any_of(primitive.variables, isPerField);
  const Wanted wanted = wantedCell(details, view);
  const double cell = meshWithin(field, wanted, wantWeights, limits, s->mesh_);
  if (cell == 0)
    return report(Severity::Error, RiError::LimitCheck,
                  "Blobby is left out: too many of its fields lie in one another");
  if (s->mesh_.triangles.empty()) return report(Severity::Warning, RiError::BadArgument, kNothing);
  if (cell > 1.01 * wanted.cell)
    report(Severity::Warning, RiError::LimitCheck,
           fmt::format(
               "Blobby: its facets are {:.2g} times as large as the picture asks for; those would be too "
               "many, or too much work",
               cell / wanted.cell));

  for (const BlobbyMesh::Vertex& vertex : s->mesh_.vertices) s->bound_.extendBy(vertex.P);
  BlobbyMesh& mesh = s->mesh_;
  mesh.vertices.shrink_to_fit();
  mesh.triangles.shrink_to_fit();
  mesh.weights.shrink_to_fit();
  mesh.weightStart.shrink_to_fit();
  s->memory_ = sizeof(BlobbySurface) + mesh.vertices.size() * sizeof(BlobbyMesh::Vertex) +
               mesh.triangles.size() * sizeof(mesh.triangles[0]) + mesh.weights.size() * sizeof(LeafWeight) +
               mesh.weightStart.size() * sizeof(uint32_t);
  return s;
}

void BlobbySurface::corners(uint32_t face, V3f out[4]) const {
  for (size_t k = 0; k < 3; ++k) out[k] = mesh_.vertices[mesh_.triangles[face][k]].P;
}

SurfacePoint BlobbySurface::evaluate(uint32_t face, float u, float v) const {
  const BlobbyMesh::Vertex* c[3];
  for (size_t k = 0; k < 3; ++k) c[k] = &mesh_.vertices[mesh_.triangles[face][k]];
  const auto x = static_cast<double>(u), y = static_cast<double>(v), w = (1 - x) - y;
  const V3d p[3] = {V3d(c[0]->P), V3d(c[1]->P), V3d(c[2]->P)};
  const V3d n = V3d(c[0]->N) * w + V3d(c[1]->N) * x + V3d(c[2]->N) * y;
  const double length = n.length();
  return {V3f(p[0] * w + p[1] * x + p[2] * y), length > 1e-6 ? V3f(n / length) : c[0]->N, V3f(p[1] - p[0]),
          V3f(p[2] - p[0])};
}

void BlobbySurface::interpolate(const PrimVar& variable, uint32_t face, float u, float v, float* out) const {
  if (!isPerField(variable) || mesh_.weightStart.empty()) return copyValue(variable, 0, out);
  const auto x = static_cast<double>(u), y = static_cast<double>(v);
  const double corner[3] = {(1 - x) - y, x, y};
  const auto components = static_cast<size_t>(variable.components);
  const size_t count = variable.floats.size() / components;
  std::fill_n(out, components, 0.0f);
  for (size_t k = 0; k < 3; ++k) {
    const uint32_t vertex = mesh_.triangles[face][k];
    for (uint32_t w = mesh_.weightStart[vertex]; w < mesh_.weightStart[vertex + 1]; ++w) {
      const LeafWeight& share = mesh_.weights[w];
      if (share.leaf >= count) continue;  // the request gives fewer values than it has fields
      const double weight = corner[k] * static_cast<double>(share.weight);
      for (size_t c = 0; c < components; ++c)
        out[c] +=
            static_cast<float>(weight * static_cast<double>(variable.floats[share.leaf * components + c]));
    }
  }
}

V2f BlobbySurface::surfaceParameters(uint32_t face, float u, float v) const {
  const V3f p = evaluate(face, u, v).P;
  return {p.x, p.y};
}

V2f BlobbySurface::parameterScale(uint32_t face) const {
  V3f p[4];
  corners(face, p);
  const V3f du = p[1] - p[0], dv = p[2] - p[0];
  return {std::hypot(du.x, du.y), std::hypot(dv.x, dv.y)};
}

}  // namespace patina
