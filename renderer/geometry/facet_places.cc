// SPDX-License-Identifier: Apache-2.0
// Which facet of a tessellated surface has which parameters, also along sides with fewer facets than their
// tile.
#include <algorithm>
#include <cmath>

#include "renderer/geometry/facet_rates.h"

namespace patina {
namespace {

uint32_t cellOf(float x, uint32_t cells) {
  return std::min(static_cast<uint32_t>(std::max(x, 0.0f)), cells - 1);
}

/// The facet's triangle at its first corner, or that at its last one: corners in cells of the tile, in the
/// order that traversal gives weights to.
struct Triangle {
  V2f a, b, c;

  Triangle(const TileRates& r, uint32_t i, uint32_t j, bool first)
      : a(first ? r.standsAt(i, j) : r.standsAt(i + 1, j + 1)),
        b(first ? r.standsAt(i + 1, j) : r.standsAt(i, j + 1)),
        c(first ? r.standsAt(i, j + 1) : r.standsAt(i + 1, j)) {}

  /// Weights of b and c; false where the triangle has collapsed.
  bool weights(const V2f& p, V2f& w) const {
    const V2f e1 = b - a, e2 = c - a, d = p - a;
    const float area = e1.x * e2.y - e1.y * e2.x;
    if (!(area > 0)) return false;
    w = V2f(d.x * e2.y - d.y * e2.x, e1.x * d.y - e1.y * d.x) / area;
    return true;
  }
};

}  // namespace

V2f TileRates::standsAt(uint32_t i, uint32_t j) const {
  const auto moved = [](uint32_t k, uint32_t level, uint32_t sideLevel) {
    const uint32_t shift = level - sideLevel;
    return (k + (1u << (shift - 1))) >> shift << shift;
  };
  const bool atU = i == 0 || i == cellsU(), atV = j == 0 || j == cellsV();
  if (atV && !atU && isThinned(j ? 1 : 0)) i = moved(i, u, side[j ? 1 : 0]);
  if (atU && !atV && isThinned(i ? 3 : 2)) j = moved(j, v, side[i ? 3 : 2]);
  return {static_cast<float>(i), static_cast<float>(j)};
}

V2f gridToTile(const TileRates& r, const V2f& st) {
  const auto columns = static_cast<float>(r.cellsU()), rows = static_cast<float>(r.cellsV());
  const float x = st.x * columns, y = st.y * rows;
  const uint32_t i = cellOf(x, r.cellsU()), j = cellOf(y, r.cellsV());
  if (!r.touchesThinned(i, j)) return st;
  const V2f local(x - static_cast<float>(i), y - static_cast<float>(j));
  const bool first = local.x + local.y <= 1;
  const Triangle t(r, i, j, first);
  const V2f w = first ? local : V2f(1) - local;
  const V2f p = t.a * (1 - w.x - w.y) + t.b * w.x + t.c * w.y;
  return {p.x / columns, p.y / rows};
}

V2f FacetPlace::weights(bool& first) const {
  first = uv.x + uv.y <= 1;
  return first ? uv : V2f(1) - uv;
}

FacetPlace locateFacet(const SurfaceRates& rates, FaceShape shape, uint32_t face, const V2f& uv) {
  const V2f st = faceToGrid(shape, uv);
  const uint32_t along = rates.tilesAlong();
  const float x = st.x * static_cast<float>(along), y = st.y * static_cast<float>(along);
  const uint32_t column = cellOf(x, along), row = cellOf(y, along);
  FacetPlace at;
  at.tile = (((face << rates.tiling) + row) << rates.tiling) + column;
  const TileRates& r = rates.tiles[at.tile];
  const V2f place((x - static_cast<float>(column)) * static_cast<float>(r.cellsU()),
                  (y - static_cast<float>(row)) * static_cast<float>(r.cellsV()));
  uint32_t i = cellOf(place.x, r.cellsU()), j = cellOf(place.y, r.cellsV());
  at.row = r.cellsU() + 1;
  at.uv = place - V2f(static_cast<float>(i), static_cast<float>(j));
  if (r.touchesThinned(i, j)) {
    // Facets along the side reach as far as its vertices have moved. Of those the one that has the point
    // farthest inside: rounding may leave it just outside of all.
    float most = -kInfinity;
    const uint32_t column0 = i, row0 = j;
    const auto look = [&](uint32_t k, uint32_t l) {
      for (const bool first : {true, false}) {
        V2f w;
        if (!Triangle(r, k, l, first).weights(place, w)) continue;
        const float inside = std::min({w.x, w.y, 1 - w.x - w.y});
        if (inside <= most) continue;
        most = inside, i = k, j = l;
        // Onto the triangle, so that its local coordinates are on its side of the diagonal.
        w = {std::max(w.x, 0.0f), std::max(w.y, 0.0f)};
        if (const float sum = w.x + w.y; sum > 1) w /= sum;
        at.uv = first ? w : V2f(1) - w;
      }
    };
    const auto lookAlong = [&](uint32_t k, bool alongU) {
      const uint32_t level = alongU ? r.u : r.v, cells = 1u << level, center = alongU ? column0 : row0;
      const uint32_t reach = (1u << (level - r.side[k])) / 2 + 1;
      for (uint32_t c = center - std::min(center, reach); c <= std::min(center + reach, cells - 1); ++c)
        alongU ? look(c, row0) : look(column0, c);
    };
    if (row0 == 0 && r.isThinned(0)) lookAlong(0, true);
    if (row0 + 1 == r.cellsV() && r.isThinned(1)) lookAlong(1, true);
    if (column0 == 0 && r.isThinned(2)) lookAlong(2, false);
    if (column0 + 1 == r.cellsU() && r.isThinned(3)) lookAlong(3, false);
  }
  at.vertex = j * at.row + i;
  return at;
}

}  // namespace patina
