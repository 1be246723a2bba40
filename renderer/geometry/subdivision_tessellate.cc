// SPDX-License-Identifier: Apache-2.0
// Tessellation of subdivision surfaces: every face's grid, then vertices and edges given one value each.
#include <array>

#include "renderer/geometry/facet_rates.h"
#include "renderer/geometry/subdivision_limit.h"

namespace patina {
namespace {

using PointDescriptor = OpenSubdiv::Bfr::Surface<double>::PointDescriptor;

/// Vertices of the grids of all faces, by face.
struct Grids {
  const SurfaceRates& rates;
  std::span<const uint32_t> first;
  std::span<V3f> vertices;

  /// Grid point (i, j); the last column or row with kLast.
  static constexpr uint32_t kLast = 0xffffffffu;
  V3f& at(uint32_t face, uint32_t i, uint32_t j) const {
    const TileRates& r = rates.tiles[face];
    return vertices[first[face] + size_t{std::min(j, r.cellsV())} * (r.cellsU() + 1) +
                    std::min(i, r.cellsU())];
  }
  uint32_t cellsAlong(uint32_t face, uint32_t side) const { return 1u << rates.tiles[face].side[side]; }
  /// Point k of those that the side itself has.
  V3f& onSide(uint32_t face, uint32_t side, uint32_t k) const {
    const TileRates& r = rates.tiles[face];
    const uint32_t at_ = k << ((side < 2 ? r.u : r.v) - r.side[side]);
    switch (side) {
      case 0:
        return at(face, at_, 0);
      case 1:
        return at(face, at_, kLast);
      case 2:
        return at(face, 0, at_);
      default:
        return at(face, kLast, at_);
    }
  }
};

/// Of a quad: the side that its edge e is, and whether it runs the same way.
constexpr std::array<uint32_t, 4> kSideOfEdge{0, 3, 1, 2};
constexpr std::array<bool, 4> kAlongEdge{true, true, false, false};

}  // namespace

void SubdivisionSurface::evaluateGrid(uint32_t face, std::span<const double> u, std::span<const double> v,
                                      std::span<V3f> out) const {
  const SubdivisionFace f = faceAt(face);
  const Prepared& prepared = prepare(f.base, kPositions);
  auto next = out.begin();
  for (const double y : v) {
    if (prepared.cubic) {
      std::array<V3d, 4> c;
      for (size_t i = 0; i < 4; ++i) {
        const std::array<V3d, 16>& g = prepared.power;
        c[i] = ((g[12 + i] * y + g[8 + i]) * y + g[4 + i]) * y + g[i];
      }
      for (const double x : u) *next++ = V3f(((c[3] * x + c[2]) * x + c[1]) * x + c[0]);
      continue;
    }
    for (const double x : u) {
      V3d P;
      prepared.surface.Evaluate(place(prepared.surface, f, x, y).uv, prepared.points.data(),
                                PointDescriptor(3), P.getValue());
      *next++ = V3f(P);
    }
  }
}

Surface::Side SubdivisionSurface::sideOf(uint32_t face, uint32_t side) const {
  const SubdivisionFace f = faceAt(face);
  const auto level = refiner().GetLevel(0);
  const auto edges = level.GetFaceEdges(static_cast<int>(f.base));
  if (f.part == SubdivisionFace::kWhole)
    for (int e = 0; e < 4; ++e)
      if (kSideOfEdge[static_cast<size_t>(e)] == side) return {static_cast<uint32_t>(edges[e]), false};
  // Part k has vertex k at (0, 0); its u runs to the middle of edge k, its v to that of the edge before. From
  // there lines, numbered behind the edges, run to the middle of the base face.
  const auto size = static_cast<uint32_t>(edges.size()), before = (f.part + size - 1) % size;
  const auto lines = static_cast<uint32_t>(level.GetNumEdges());
  switch (side) {
    case 0:
      return {static_cast<uint32_t>(edges[static_cast<int>(f.part)]), true};
    case 2:
      return {static_cast<uint32_t>(edges[static_cast<int>(before)]), true};
    case 3:
      return {lines + face, false};
    default:
      return {lines + face - f.part + before, false};
  }
}

void SubdivisionSurface::weld(const SurfaceRates& rates, std::span<const uint32_t> first,
                              std::span<V3f> vertices) const {
  const Grids grids{rates, first, vertices};
  const auto level = refiner().GetLevel(0);
  std::vector<uint32_t> firstFace(static_cast<size_t>(level.GetNumFaces()), kNone);
  for (uint32_t face = faceCount(); face-- > 0;) firstFace[faceAt(face).base] = face;
  const auto isWhole = [&](uint32_t base) { return faceAt(firstFace[base]).part == SubdivisionFace::kWhole; };

  // A vertex belongs to the first face that has it.
  std::vector<V3f> vertexPoint(static_cast<size_t>(level.GetNumVertices()));
  std::vector<bool> seen(vertexPoint.size());
  for (uint32_t base = 0; base < firstFace.size(); ++base) {
    if (firstFace[base] == kNone) continue;
    const auto corners = level.GetFaceVertices(static_cast<int>(base));
    for (uint32_t k = 0; k < static_cast<uint32_t>(corners.size()); ++k) {
      V3f& point = isWhole(base) ? grids.at(firstFace[base], k == 1 || k == 2 ? Grids::kLast : 0,
                                            k >= 2 ? Grids::kLast : 0)
                                 : grids.at(firstFace[base] + k, 0, 0);
      const auto v = static_cast<size_t>(corners[static_cast<int>(k)]);
      if (!seen[v]) seen[v] = true, vertexPoint[v] = point;
      point = vertexPoint[v];
    }
  }

  // Calls f(k, point) for the points of a base face along an edge, k from 0 on in the edge's direction; the
  // middle of an edge is a point of two parts.
  const auto forEachPoint = [&](uint32_t base, int edge, const auto& f) {
    const auto edges = level.GetFaceEdges(static_cast<int>(base));
    const auto corners = level.GetFaceVertices(static_cast<int>(base));
    const int from = level.GetEdgeVertices(edge)[0];
    const auto size = static_cast<uint32_t>(edges.size());
    const uint32_t face = firstFace[base];
    for (uint32_t e = 0; e < size; ++e) {
      if (edges[static_cast<int>(e)] != edge) continue;
      const bool forward = corners[static_cast<int>(e)] == from;
      if (isWhole(base)) {
        const uint32_t n = grids.cellsAlong(face, kSideOfEdge[e]);
        for (uint32_t k = 0; k <= n; ++k)
          f(forward ? k : n - k, grids.onSide(face, kSideOfEdge[e], kAlongEdge[e] ? k : n - k));
        continue;
      }
      const uint32_t half = grids.cellsAlong(face + e, 0), next = face + (e + 1) % size;
      for (uint32_t k = 0; k <= half; ++k) {
        f(forward ? k : 2 * half - k, grids.onSide(face + e, 0, k));
        f(forward ? 2 * half - k : k, grids.onSide(next, 2, k));
      }
    }
  };
  // Faces at an edge get the points of one of them.
  std::vector<V3f> line;
  for (int edge = 0; edge < level.GetNumEdges(); ++edge) {
    const auto faces = level.GetEdgeFaces(edge);
    const auto ends = level.GetEdgeVertices(edge);
    line.clear();
    for (int base : faces) {
      if (firstFace[static_cast<size_t>(base)] == kNone) continue;
      const bool source = line.empty();
      forEachPoint(static_cast<uint32_t>(base), edge, [&](uint32_t k, V3f& point) {
        if (!source) {
          point = line[k];
          return;
        }
        if (k >= line.size()) line.resize(k + size_t{1});
        line[k] = point;
      });
      if (!source) continue;
      line.front() = vertexPoint[static_cast<size_t>(ends[0])];
      line.back() = vertexPoint[static_cast<size_t>(ends[1])];
      forEachPoint(static_cast<uint32_t>(base), edge, [&](uint32_t k, V3f& point) { point = line[k]; });
    }
  }

  // Within a base face the parts meet along lines from the middles of the edges to its centre.
  for (uint32_t base = 0; base < firstFace.size(); ++base) {
    const uint32_t face = firstFace[base];
    if (face == kNone || isWhole(base)) continue;
    const auto size = static_cast<uint32_t>(baseSize(base));
    for (uint32_t k = 1; k < size; ++k)
      grids.at(face + k, Grids::kLast, Grids::kLast) = grids.at(face, Grids::kLast, Grids::kLast);
    for (uint32_t k = 0; k < size; ++k) {
      const uint32_t n = grids.cellsAlong(face + k, 3);
      for (uint32_t j = 1; j < n; ++j)
        grids.onSide(face + (k + 1) % size, 1, j) = grids.onSide(face + k, 3, j);
    }
  }
}

}  // namespace patina
