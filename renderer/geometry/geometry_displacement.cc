// SPDX-License-Identifier: Apache-2.0
// Displaced surfaces of a frame: their bounds, known or found out, and whether they keep to them.
#include <fmt/format.h>

#include "renderer/base/statistics.h"
#include "renderer/geometry/geometry.h"

namespace patina {
namespace {

STAT_COUNTER("Displacement/surfaces", displacedCount);
STAT_COUNTER("Displacement/surfaces without a bound", unboundedCount);

constexpr float kSlack = 1.001f;  // a bound may be missed by rounding

float largestStretch(const M44f& m) {
  float most = 0;
  for (int k = 0; k < 3; ++k) {
    V3f axis(0, 0, 0);
    axis[k] = 1;
    most = std::max(most, transformVector(axis, m).length());
  }
  return most * std::sqrt(3.0f);  // no direction is stretched more
}

}  // namespace

/// Finds which surfaces are displaced and how far at most. Those that do not say are displaced now.
void Geometry::boundDisplacements() {
  displacementChecked_ = std::vector<std::atomic<bool>>(traced_.size());
  float farthest = 0;
  size_t unbounded = 0;
  const Primitive* without = nullptr;
  for (uint32_t k = 0; k < traced_.size(); ++k) {
    TracedSurface& traced = traced_[k];
    const Attributes* own = attributes(traced);
    if (!own) continue;
    const auto bound = displacer_->boundOf(*own);
    if (!bound) continue;
    ++displacedCount;
    traced.isDisplaced = true;
    traced.reach = std::max(bound->object * largestStretch(traced.toMesh), bound->world);
    if (traced.reach > 0 && std::isfinite(traced.reach)) continue;
    ++unboundedCount, ++unbounded;
    std::vector<uint32_t> first;
    std::vector<V3f> vertices;
    const SurfaceRates& known = rates(k);
    if (known.tiles.empty()) continue;
    patina::tessellate(surface(k), known, first, vertices);
    traced.reach = displace(k, known, first, vertices).moved * kSlack;
    farthest = std::max(farthest, traced.reach);
    if (!without) without = traced.primitive;
  }
  if (without)
    errors_.report(Severity::Warning, RiError::MissingData, without->where,
                   fmt::format("displaced surfaces without Attribute \"displacementbound\", {} from here on: "
                               "they were displaced at once to find that they move by up to {:.4g}",
                               unbounded, farthest));
}

DisplacementResult Geometry::displace(uint32_t k, const SurfaceRates& known, std::span<const uint32_t> first,
                                      std::span<V3f> vertices) const {
  const TracedSurface& traced = traced_[k];
  return displaceFacets(surface(k), *traced.primitive, *attributes(traced), traced.toMesh, traced.isReversed,
                        *displacer_, known, first.first(known.tiles.size()), vertices);
}

void Geometry::checkDisplacement(uint32_t k, float moved) const {
  const TracedSurface& traced = traced_[k];
  const bool exceeds = moved > traced.reach * kSlack;
  if ((!exceeds && moved > 0) || displacementChecked_[k].exchange(true)) return;
  if (exceeds)
    errors_.report(Severity::Warning, RiError::Range, traced.primitive->where,
                   fmt::format("the displacement of this surface reaches {:.4g}, its displacementbound is "
                               "{:.4g}: rays miss what sticks out",
                               moved, traced.reach));
  else
    errors_.report(Severity::Warning, RiError::Range, traced.primitive->where,
                   "the displacement shader of this surface moves nothing");
}

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
  return tileToFace(*member.rates, shape, at.tile,
                    {column / static_cast<float>(r.cellsU()), row / static_cast<float>(r.cellsV())});
}

}  // namespace patina
