// SPDX-License-Identifier: Apache-2.0
// What is asked of facets: their corners, points and normals, and how well those are known.
#include "renderer/geometry/geometry.h"

namespace patina {

/// Of the error that a facet's magnitude allows: what is left of it where the facet lies exactly across an
/// axis.
constexpr float kLeastError = 1e-3f;

V2f Geometry::insideFacet(uint32_t placement, uint32_t face, float u, float v) const {
  constexpr float kInset = 0.2f;  // the least barycentric weight
  const uint32_t index = placements_[placement].traced;
  const TracedSurface& traced = traced_[index];
  const FaceShape shape = surface(index).faceShape(face);
  TessellationCache::Reader reader(*tessellations_);
  const Tessellation& tessellation = reader.get(traced.unit);
  const Tessellation::Member& member = tessellation.members[traced.member];
  if (!member.rates) return {u, v};
  const FacetPlace at = locateFacet(*member.rates, shape, face, {u, v});
  const TileRates& r = member.rates->tiles[at.tile];
  const V3f* const grid = &tessellation.vertices[tessellation.first[member.firstTile + at.tile]];
  const auto cells = Imath::V2i(static_cast<int>(r.cellsU()), static_cast<int>(r.cellsV()));
  const auto spans = [&](const Imath::V2i& cell, bool first) {
    const V3f* const corner = grid + static_cast<uint32_t>(cell.y) * at.row + static_cast<uint32_t>(cell.x);
    const V3f& P = corner[first ? 0 : at.row + 1];
    return hasArea(corner[1] - P, corner[at.row] - P);
  };
  // The facet of (u, v), or the nearest one in the tile if that has collapsed, as many at thinned sides have.
  Imath::V2i cell(static_cast<int>(at.vertex % at.row), static_cast<int>(at.vertex / at.row));
  const V2f wanted = V2f(cell) + at.uv;  // in cells
  bool first = at.uv.x + at.uv.y <= 1;
  if (!spans(cell, first)) {
    const Imath::V2i center = cell;
    float least = kInfinity;
    for (int ring = 0; least == kInfinity; ++ring) {
      if (ring > std::max(cells.x, cells.y)) return {u, v};
      for (int j = std::max(center.y - ring, 0); j <= std::min(center.y + ring, cells.y - 1); ++j)
        for (int i = std::max(center.x - ring, 0); i <= std::min(center.x + ring, cells.x - 1); ++i)
          for (const bool lower : {true, false}) {
            const V2f middle = V2f(Imath::V2i(i, j)) + V2f(lower ? 1.0f / 3 : 2.0f / 3);
            if (const float distance = (middle - wanted).length2(); distance < least && spans({i, j}, lower))
              least = distance, cell = {i, j}, first = lower;
          }
    }
  }
  const V2f local = wanted - V2f(cell);
  float x = std::clamp(first ? local.x : 1 - local.x, kInset, 1.0f),
        y = std::clamp(first ? local.y : 1 - local.y, kInset, 1.0f);
  if (const float sum = x + y + std::max(1 - x - y, kInset); sum > 1) x /= sum, y /= sum;
  const float column = static_cast<float>(cell.x) + (first ? x : 1 - x),
              row = static_cast<float>(cell.y) + (first ? y : 1 - y);
  const V2f met(column / static_cast<float>(r.cellsU()), row / static_cast<float>(r.cellsV()));
  return tileToFace(*member.rates, shape, at.tile, gridToTile(r, met));
}

Geometry::DisplacedPoint Geometry::displacedPoint(uint32_t placement, uint32_t face, float u, float v) const {
  const Placement& p = placements_[placement];
  const TracedSurface& traced = traced_[p.traced];
  const FaceShape shape = surface(p.traced).faceShape(face);
  DisplacedPoint point{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  TessellationCache::Reader reader(*tessellations_);
  const Tessellation& tessellation = reader.get(traced.unit);
  const Tessellation::Member& member = tessellation.members[traced.member];
  if (!member.rates) return point;
  const FacetPlace at = locateFacet(*member.rates, shape, face, {u, v});
  const uint32_t vertex = tessellation.first[member.firstTile + at.tile] + at.vertex;
  const V3f* P = &tessellation.vertices[vertex];
  const uint32_t* N =
      &tessellation.normals[member.firstNormal + vertex - tessellation.first[member.firstTile]];
  const TileRates& r = member.rates->tiles[at.tile];
  const uint32_t column = at.vertex % at.row, row = at.vertex / at.row;
  V3f alongS, alongT;  // for a facet's step in (s, t)
  if (r.touchesThinned(column, row)) {
    // One triangle: its corners stand where the side has vertices.
    bool first;
    const V2f w = at.weights(first);
    const uint32_t corner[3] = {first ? 0 : at.row + 1, first ? 1 : at.row, first ? at.row : 1};
    V2f place[3];
    for (int k = 0; k < 3; ++k) place[k] = r.standsAt(column + corner[k] % at.row, row + corner[k] / at.row);
    point.N = unpackNormal(N[corner[0]]) * (1 - w.x - w.y) + unpackNormal(N[corner[1]]) * w.x +
              unpackNormal(N[corner[2]]) * w.y;
    const V2f d1 = place[1] - place[0], d2 = place[2] - place[0];
    const V3f e1 = P[corner[1]] - P[corner[0]], e2 = P[corner[2]] - P[corner[0]];
    const float area = d1.x * d2.y - d1.y * d2.x;
    alongS = area > 0 ? (e1 * d2.y - e2 * d1.y) / area : P[1] - P[0];
    alongT = area > 0 ? (e2 * d1.x - e1 * d2.x) / area : P[at.row] - P[0];
  } else {
    const auto [x, y] = at.uv;
    point.N = unpackNormal(N[0]) * ((1 - x) * (1 - y)) + unpackNormal(N[1]) * (x * (1 - y)) +
              unpackNormal(N[at.row]) * ((1 - x) * y) + unpackNormal(N[at.row + 1]) * (x * y);
    alongS = (P[1] - P[0]) * (1 - y) + (P[at.row + 1] - P[at.row]) * y;
    alongT = (P[at.row] - P[0]) * (1 - x) + (P[at.row + 1] - P[1]) * x;
  }
  const auto along = static_cast<float>(member.rates->tilesAlong());
  point.dPdu = alongS * (along * static_cast<float>(r.cellsU()));
  point.dPdv = alongT * (along * static_cast<float>(r.cellsV()));
  if (shape == FaceShape::Triangle) {
    const float rest = std::max(1 - v, 1e-3f);  // see gridToFace(): s = u / (1 - v)
    point.dPdu /= rest;
    point.dPdv += point.dPdu * (u / rest);
  }
  if (p.instance != kNone) {
    const PlacedInstance& instance = instances_[p.instance];
    point.N = transformNormal(point.N, instance.worldToMesh);
    point.dPdu = transformVector(point.dPdu, instance.meshToWorld);
    point.dPdv = transformVector(point.dPdv, instance.meshToWorld);
  }
  point.N = normalizedOr(point.N, V3f(0, 0, 0));
  return point;
}

void Geometry::facetCorners(uint32_t placement, uint32_t face, float u, float v, V3f out[3],
                            V2f& weights) const {
  const uint32_t index = placements_[placement].traced;
  const TracedSurface& traced = traced_[index];
  const Surface& made = surface(index);
  V3f quad[4];
  bool found = false;
  if (isTessellated(index)) {
    TessellationCache::Reader reader(*tessellations_);
    const Tessellation& tessellation = reader.get(traced.unit);
    const Tessellation::Member& member = tessellation.members[traced.member];
    if (member.rates) {
      const FacetPlace at = locateFacet(*member.rates, made.faceShape(face), face, {u, v});
      const V3f* corner = &tessellation.vertices[tessellation.first[member.firstTile + at.tile] + at.vertex];
      quad[0] = corner[0], quad[1] = corner[1], quad[2] = corner[at.row], quad[3] = corner[at.row + 1];
      u = at.uv.x, v = at.uv.y;
      found = true;
    }
  }
  if (!found) {
    made.corners(face, quad);
    const bool triangle = made.faceShape(face) == FaceShape::Triangle;
    for (int k = 0; k < (triangle ? 3 : 4); ++k) quad[k] = transformPoint(quad[k], traced.toMesh);
    if (triangle) u = std::min(u, 1 - v);
  }
  const bool first = u + v <= 1;  // see FacetPlace::weights
  out[0] = first ? quad[0] : quad[3];
  out[1] = first ? quad[1] : quad[2];
  out[2] = first ? quad[2] : quad[1];
  weights = first ? V2f(u, v) : V2f(1 - u, 1 - v);
}

void Geometry::forEachFacet(uint32_t placement, const std::function<void(const FacetQuad&)>& visit) const {
  const Placement& p = placements_[placement];
  const TracedSurface& traced = traced_[p.traced];
  const Surface& made = surface(p.traced);
  FacetQuad quad;
  if (!isTessellated(p.traced)) {
    for (quad.face = 0; quad.face < made.faceCount(); ++quad.face) {
      quad.isTriangle = made.faceShape(quad.face) == FaceShape::Triangle;
      made.corners(quad.face, quad.P);
      for (int k = 0; k < (quad.isTriangle ? 3 : 4); ++k) {
        quad.uv[k] = V2f(static_cast<float>(k % 2), static_cast<float>(k / 2));
        quad.P[k] = transformPoint(quad.P[k], p.objectToWorld);
      }
      quad.error = facetError(p, quad.P[0], quad.P[1] - quad.P[0], quad.P[2] - quad.P[0]);
      visit(quad);
    }
    return;
  }
  quad.isTriangle = false;
  TessellationCache::Reader reader(*tessellations_);
  const Tessellation& tessellation = reader.get(traced.unit);
  const Tessellation::Member& member = tessellation.members[traced.member];
  if (!member.rates) return;
  for (uint32_t tile = 0; tile < member.rates->tiles.size(); ++tile) {
    const TileRates& r = member.rates->tiles[tile];
    quad.face = member.rates->faceOf(tile);
    const FaceShape shape = made.faceShape(quad.face);
    const auto [column, row] = member.rates->placeOf(tile);
    const float size = 1 / static_cast<float>(member.rates->tilesAlong());
    const V3f* grid = &tessellation.vertices[tessellation.first[member.firstTile + tile]];
    for (uint32_t j = 0; j < r.cellsV(); ++j)
      for (uint32_t i = 0; i < r.cellsU(); ++i) {
        for (uint32_t k = 0; k < 4; ++k) {
          const uint32_t x = i + k % 2, y = j + k / 2;
          const V2f at = r.standsAt(x, y);
          quad.uv[k] =
              gridToFace(shape, {(static_cast<float>(column) + at.x / static_cast<float>(r.cellsU())) * size,
                                 (static_cast<float>(row) + at.y / static_cast<float>(r.cellsV())) * size});
          V3f point = grid[y * (r.cellsU() + 1) + x];
          if (p.instance != kNone) point = transformPoint(point, instances_[p.instance].meshToWorld);
          quad.P[k] = point;
        }
        quad.error = facetError(p, quad.P[0], quad.P[1] - quad.P[0], quad.P[2] - quad.P[0]);
        visit(quad);
      }
  }
}

// Interpolation is good to a few roundings of the corners; the plane that a traversal kernel meets, to a few
// of the corners' distance from the ray's origin, which the facet's extent stands for when origins lie on
// facets. Only what goes along the normal counts, component by component: a ground plane of a thousand units
// is as exact across as its height is.
float Geometry::facetError(const Placement& p, const V3f& point, const V3f& edge1, const V3f& edge2) const {
  // Kernels take moving transformations apart and put them together again.
  const float rounding = roundingBound(p.moves ? 64 : 16);
  float magnitude = maxAbsComponent(point);
  if (p.instance != kNone) {
    // The ray is taken to mesh space and the point back: cancellation is bounded by the terms of the sum.
    const M44f& m = instances_[p.instance].meshToWorld;
    const V3f local = transformPoint(point, instances_[p.instance].worldToMesh);
    magnitude = std::max(
        magnitude, maxAbsComponent({m[3][0], m[3][1], m[3][2]}) + maxAbsComponent(transformVector(local, m)));
  }
  const float largest = magnitude + maxAbsComponent(edge1) + maxAbsComponent(edge2);
  const V3f cross = edge1.cross(edge2);
  const float area = cross.length();
  if (p.instance != kNone || p.moves || !(area > 0)) return rounding * largest;
  float sum = 0;
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const float extent = std::abs(edge1[k]) + std::abs(edge2[k]);
    // By how much the normal's own component may be wrong: the products that it is the difference of.
    const float products = std::abs(edge1[i] * edge2[j]) + std::abs(edge1[j] * edge2[i]);
    sum += std::abs(cross[k]) * (std::abs(point[k]) + extent) + products * extent;
  }
  const float across = sum / area;
  return rounding * (across < largest ? std::max(across, kLeastError * largest) : largest);
}

Facet Geometry::facet(uint32_t placement, uint32_t face, float u, float v) const {
  const Placement& p = placements_[placement];
  V3f c[3];
  V2f w;
  facetCorners(placement, face, u, v, c, w);
  if (p.instance != kNone)
    for (V3f& corner : c) corner = transformPoint(corner, instances_[p.instance].meshToWorld);
  const V3f e1 = c[1] - c[0], e2 = c[2] - c[0];
  Facet facet;
  facet.P = c[0] * (1 - w.x - w.y) + c[1] * w.x + c[2] * w.y;
  if (hasArea(e1, e2))
    facet.N = normalizedOr(e1.cross(e2), V3f(0, 0, 1)) * p.facetSign;
  else  // poles, collapsed edges, cells at thinned sides
    facet.N =
        normalizedOr(transformNormal(surface(p).evaluate(face, u, v).N, p.worldToObject), V3f(0, 0, 1)) *
        p.normalSign;
  facet.error = facetError(p, facet.P, e1, e2);
  return facet;
}

}  // namespace patina
