// SPDX-License-Identifier: Apache-2.0
// Whether the surfaces of a solid's leaf are closed, and which way they face.
#include <algorithm>

#include "renderer/base/sampling.h"
#include "renderer/geometry/solids.h"

namespace patina {
namespace {

struct Triangle {
  V3d corner, edge1, edge2;
  uint32_t surface;
  double outward;  ///< -1: the outside is opposite to edge1 x edge2
};

struct LineCrossing {
  double t;
  uint32_t surface;
  bool entering;
};

constexpr uint32_t kMostCells = 16;           // along a face of a curved surface
constexpr size_t kWantedTriangles = 1 << 15;  // of a leaf of few faces
constexpr size_t kWork = 20'000'000;          // lines times triangles
constexpr double kExceptions = 0.02;          // lines that may say otherwise

void addTriangles(const LeafSurface& from, uint32_t index, uint32_t cells, std::vector<Triangle>& out) {
  const Surface& surface = *from.surface;
  const M44d toMesh(from.toMesh);
  const double outward = (toMesh.determinant() < 0) != from.reversed ? -1 : 1;
  const auto add = [&](const V3d& a, const V3d& b, const V3d& c) {
    out.push_back({a, b - a, c - a, index, outward});
  };
  if (surface.isFlat()) cells = 1;
  const uint32_t side = cells + 1;
  std::vector<V2f> uv;
  for (uint32_t j = 0; j < side; ++j)
    for (uint32_t i = 0; i < side; ++i)
      uv.emplace_back(static_cast<float>(i) / static_cast<float>(cells),
                      static_cast<float>(j) / static_cast<float>(cells));
  std::vector<SurfacePoint> points(uv.size());
  std::vector<V3d> grid(uv.size());
  for (uint32_t face = 0; face < surface.faceCount(); ++face) {
    if (surface.isFlat()) {
      V3f c[4];
      surface.corners(face, c);
      const bool quad = surface.faceShape(face) == FaceShape::Quad;
      for (size_t k = 0; k < (quad ? 4 : 3); ++k) grid[k] = V3d(c[k]) * toMesh;
      add(grid[0], grid[1], grid[2]);
      if (quad) add(grid[3], grid[2], grid[1]);
      continue;
    }
    surface.evaluateMany(face, uv, points);
    for (size_t k = 0; k < points.size(); ++k) grid[k] = V3d(points[k].P) * toMesh;
    for (uint32_t j = 0; j < cells; ++j)
      for (uint32_t i = 0; i < cells; ++i) {
        const size_t k = size_t{j} * side + i;
        const V2f middle = (uv[k] + uv[k + side + 1]) * 0.5f;
        if (surface.hasHoles() && surface.isHole(face, middle.x, middle.y)) continue;
        add(grid[k], grid[k + 1], grid[k + side]);
        add(grid[k + side + 1], grid[k + side], grid[k + 1]);
      }
  }
}

/// Moeller and Trumbore 1997, for both directions of a line.
bool cross(const Triangle& triangle, const V3d& origin, const V3d& direction, double& t) {
  const V3d p = direction.cross(triangle.edge2);
  const double determinant = triangle.edge1.dot(p);
  if (determinant == 0) return false;
  const V3d s = origin - triangle.corner;
  const double u = s.dot(p) / determinant;
  if (!(u >= 0 && u <= 1)) return false;
  const V3d q = s.cross(triangle.edge1);
  const double v = direction.dot(q) / determinant;
  if (!(v >= 0 && u + v <= 1)) return false;
  t = triangle.edge2.dot(q) / determinant;
  return std::isfinite(t);
}

/// Whether depths along a line, one more at each way in, begin and end at 0 and keep to one sign; how deep.
bool nests(std::span<const LineCrossing> line, int sign, int& deepest) {
  int depth = 0;
  for (const LineCrossing& crossing : line) {
    depth += crossing.entering ? sign : -sign;
    if (depth < 0) return false;
    deepest = std::max(deepest, depth);
  }
  return depth == 0;
}

}  // namespace

LeafReport examineLeaf(std::span<const LeafSurface> surfaces) {
  LeafReport report;
  report.turned.assign(surfaces.size(), false);
  size_t faces = 0;
  for (const LeafSurface& s : surfaces) faces += s.surface->isFlat() ? 0 : s.surface->faceCount();
  uint32_t cells = kMostCells;
  while (cells > 2 && faces * 2 * cells * cells > kWantedTriangles) cells /= 2;
  std::vector<Triangle> triangles;
  for (uint32_t k = 0; k < surfaces.size(); ++k) addTriangles(surfaces[k], k, cells, triangles);

  // Lines through points that are spread evenly over the surfaces, in all directions.
  std::vector<double> area;
  double sum = 0;
  for (const Triangle& triangle : triangles)
    area.push_back(sum += triangle.edge1.cross(triangle.edge2).length());
  if (!(sum > 0) || !std::isfinite(sum)) {
    report.closed = false;
    return report;
  }
  const size_t lines = std::clamp<size_t>(kWork / triangles.size(), 16, 256);
  const auto exceptions = static_cast<size_t>(kExceptions * static_cast<double>(lines));
  std::vector<std::vector<LineCrossing>> crossings;
  size_t odd = 0;
  for (uint32_t line = 0; line < lines; ++line) {
    const V2f where = sobol2(line, 1), on = sobol2(line, 2), towards = sobol2(line, 3);
    const auto found = std::upper_bound(area.begin(), area.end(), sum * static_cast<double>(where.x));
    const Triangle& through =
        triangles[std::min(static_cast<size_t>(found - area.begin()), triangles.size() - 1)];
    const V2f b = sampleTriangle(on);
    const V3d origin =
        through.corner + through.edge1 * static_cast<double>(b.x) + through.edge2 * static_cast<double>(b.y);
    const double z = 1 - 2 * static_cast<double>(towards.x), r = std::sqrt(std::max(0.0, 1 - z * z));
    const double phi = 2 * std::numbers::pi * static_cast<double>(towards.y);
    const V3d direction(r * std::cos(phi), r * std::sin(phi), z);
    std::vector<LineCrossing> met;
    for (const Triangle& triangle : triangles)
      if (double t; cross(triangle, origin, direction, t))
        met.push_back({t, triangle.surface,
                       triangle.edge1.cross(triangle.edge2).dot(direction) * triangle.outward < 0});
    if (met.size() % 2 != 0) {
      ++odd;
      continue;
    }
    std::sort(met.begin(), met.end(), [](const LineCrossing& a, const LineCrossing& c) { return a.t < c.t; });
    crossings.push_back(std::move(met));
  }
  report.closed = odd <= exceptions;
  if (!report.closed) return report;

  // Do the surfaces agree on an outside, be it the inside?
  const auto consistent = [&](int sign) {
    size_t wrong = 0, nested = 0;
    for (const auto& line : crossings) {
      int deepest = 0;
      wrong += !nests(line, sign, deepest);
      nested += deepest > 1;
    }
    report.rule = nested > exceptions ? SolidTree::Rule::Winding : SolidTree::Rule::Facing;
    return wrong <= exceptions;
  };
  if (consistent(1)) return report;
  if (consistent(-1)) {
    report.turned.assign(surfaces.size(), true);
    return report;
  }
  // Each is turned as most lines have it.
  std::vector<int> wrong(surfaces.size(), 0);
  for (const auto& line : crossings)
    for (size_t k = 0; k < line.size(); ++k)
      wrong[line[k].surface] += line[k].entering == (k % 2 == 0) ? -1 : 1;
  for (size_t k = 0; k < surfaces.size(); ++k) report.turned[k] = wrong[k] > 0;
  for (auto& line : crossings)
    for (LineCrossing& crossing : line) crossing.entering ^= report.turned[crossing.surface];
  if (!consistent(1) || report.rule != SolidTree::Rule::Facing) report.rule = SolidTree::Rule::Parity;
  return report;
}

}  // namespace patina
