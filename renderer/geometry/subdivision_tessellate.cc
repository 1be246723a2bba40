// SPDX-License-Identifier: Apache-2.0
// Tessellation of subdivision surfaces: every face's grid, then vertices and edges given one value each.
#include <array>

#include "renderer/geometry/subdivision_limit.h"

namespace patina {
namespace {

using PointDescriptor = OpenSubdiv::Bfr::Surface<double>::PointDescriptor;

/// The index of grid point (i, j) of a face.
size_t gridIndex(uint32_t face, uint32_t i, uint32_t j, uint32_t cells) {
  const size_t side = cells + 1;
  return face * side * side + j * side + i;
}

}  // namespace

void SubdivisionSurface::evaluateGrid(uint32_t face, uint32_t cells, std::span<V3f> out) const {
  const SubdivisionFace f = faceAt(face);
  const Prepared& prepared = prepare(f.base, kPositions);
  const double step = 1.0 / cells;
  V3f* next = &out[gridIndex(face, 0, 0, cells)];
  for (uint32_t j = 0; j <= cells; ++j) {
    const double v = j * step;
    if (prepared.cubic) {
      std::array<V3d, 4> c;
      for (size_t i = 0; i < 4; ++i) {
        const std::array<V3d, 16>& g = prepared.power;
        c[i] = ((g[12 + i] * v + g[8 + i]) * v + g[4 + i]) * v + g[i];
      }
      for (uint32_t i = 0; i <= cells; ++i) {
        const double u = i * step;
        *next++ = V3f(((c[3] * u + c[2]) * u + c[1]) * u + c[0]);
      }
      continue;
    }
    for (uint32_t i = 0; i <= cells; ++i) {
      V3d P;
      prepared.surface.Evaluate(place(prepared.surface, f, i * step, v).uv, prepared.points.data(),
                                PointDescriptor(3), P.getValue());
      *next++ = V3f(P);
    }
  }
}

void SubdivisionSurface::tessellate(uint32_t cells, std::span<V3f> out) const {
  for (uint32_t face = 0; face < faceCount(); ++face) evaluateGrid(face, cells, out);
  weld(cells, out);
}

void SubdivisionSurface::weld(uint32_t cells, std::span<V3f> out) const {
  const auto level = refiner().GetLevel(0);
  std::vector<uint32_t> firstFace(static_cast<size_t>(level.GetNumFaces()), kNone);
  for (uint32_t face = faceCount(); face-- > 0;) firstFace[faceAt(face).base] = face;

  // A vertex belongs to the first face that has it.
  std::vector<V3f> vertexPoint(static_cast<size_t>(level.GetNumVertices()));
  std::vector<bool> seen(vertexPoint.size());
  for (uint32_t base = 0; base < firstFace.size(); ++base) {
    if (firstFace[base] == kNone) continue;
    const auto vertices = level.GetFaceVertices(static_cast<int>(base));
    const bool whole = faceAt(firstFace[base]).part == SubdivisionFace::kWhole;
    for (uint32_t k = 0; k < static_cast<uint32_t>(vertices.size()); ++k) {
      const size_t index =
          whole ? gridIndex(firstFace[base], k == 1 || k == 2 ? cells : 0, k >= 2 ? cells : 0, cells)
                : gridIndex(firstFace[base] + k, 0, 0, cells);
      const auto v = static_cast<size_t>(vertices[static_cast<int>(k)]);
      if (!seen[v]) seen[v] = true, vertexPoint[v] = out[index];
      out[index] = vertexPoint[v];
    }
  }
  std::vector<V3f> line;
  for (int edge = 0; edge < level.GetNumEdges(); ++edge)
    weldEdge(edge, cells, firstFace, vertexPoint, line, out);

  // Within a base face the parts meet along lines from the middles of the edges to its centre.
  for (uint32_t base = 0; base < firstFace.size(); ++base) {
    const uint32_t first = firstFace[base];
    if (first == kNone || faceAt(first).part == SubdivisionFace::kWhole) continue;
    const auto size = static_cast<uint32_t>(baseSize(base));
    for (uint32_t k = 1; k < size; ++k)
      out[gridIndex(first + k, cells, cells, cells)] = out[gridIndex(first, cells, cells, cells)];
    for (uint32_t k = 0; k < size; ++k)
      for (uint32_t j = 1; j < cells; ++j)
        out[gridIndex(first + (k + 1) % size, j, cells, cells)] = out[gridIndex(first + k, cells, j, cells)];
  }
}

/// Gives all faces at an edge the points of one of them. A quad has `cells` micropolygons along it, the parts
/// of another face twice as many: where both meet, the finer side repeats points of the coarser one.
void SubdivisionSurface::weldEdge(int edge, uint32_t cells, std::span<const uint32_t> firstFace,
                                  std::span<const V3f> vertexPoint, std::vector<V3f>& line,
                                  std::span<V3f> out) const {
  const auto level = refiner().GetLevel(0);
  const auto faces = level.GetEdgeFaces(edge);
  const auto ends = level.GetEdgeVertices(edge);
  const auto isWhole = [&](int base) {
    return faceAt(firstFace[static_cast<size_t>(base)]).part == SubdivisionFace::kWhole;
  };
  int source = -1;
  for (int base : faces) {
    if (firstFace[static_cast<size_t>(base)] == kNone) continue;
    if (source < 0 || (isWhole(base) && !isWhole(source))) source = base;
  }
  if (source < 0) return;
  const uint32_t count = isWhole(source) ? cells : 2 * cells;

  // Calls f(k, point) for the points of a base face along the edge, k from 0 to n in the edge's direction;
  // the middle of an edge is a point of two parts.
  const auto forEachPoint = [&](int base, const auto& f) {
    const auto edges = level.GetFaceEdges(base);
    const auto vertices = level.GetFaceVertices(base);
    const auto size = static_cast<uint32_t>(edges.size());
    const uint32_t first = firstFace[static_cast<size_t>(base)];
    for (uint32_t e = 0; e < size; ++e) {
      if (edges[static_cast<int>(e)] != edge) continue;
      const bool forward = vertices[static_cast<int>(e)] == ends[0];
      const uint32_t n = isWhole(base) ? cells : 2 * cells;
      for (uint32_t along = 0; along <= n; ++along) {
        const uint32_t k = forward ? along : n - along;
        if (isWhole(base)) {
          const std::array<std::array<uint32_t, 2>, 4> ij{
              {{along, 0}, {cells, along}, {cells - along, cells}, {0, cells - along}}};
          f(k, out[gridIndex(first, ij[e][0], ij[e][1], cells)]);
          continue;
        }
        if (along <= cells) f(k, out[gridIndex(first + e, along, 0, cells)]);
        if (along >= cells) f(k, out[gridIndex(first + (e + 1) % size, 0, 2 * cells - along, cells)]);
      }
    }
  };
  line.resize(count + 1);
  forEachPoint(source, [&](uint32_t k, const V3f& point) { line[k] = point; });
  line.front() = vertexPoint[static_cast<size_t>(ends[0])];
  line.back() = vertexPoint[static_cast<size_t>(ends[1])];
  for (int base : faces) {
    if (firstFace[static_cast<size_t>(base)] == kNone) continue;
    const bool repeat = count == cells && !isWhole(base);
    forEachPoint(base, [&](uint32_t k, V3f& point) { point = line[repeat ? k / 2 : k]; });
  }
}

}  // namespace patina
