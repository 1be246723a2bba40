// SPDX-License-Identifier: Apache-2.0
// How finely surfaces are cut into facets for tracing: rates by tile, agreed on where tiles meet.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "renderer/geometry/raster_camera.h"
#include "renderer/geometry/surface.h"

namespace patina {

/// Sides of a tile of a face: v = 0, v = 1, u = 0, u = 1.
inline constexpr uint32_t kTileSides = 4;

/// Facets along a tile, as powers of two: within it, and along its sides. A side has never more than the tile
/// in its direction; where it has less, the tile's vertices repeat the side's.
struct TileRates {
  uint8_t u = 0, v = 0;
  std::array<uint8_t, kTileSides> side{};
  uint8_t points = 0;  ///< a bit for each side that is a point, like those at poles

  uint32_t cellsU() const { return 1u << u; }
  uint32_t cellsV() const { return 1u << v; }
  size_t vertices() const { return size_t{cellsU() + 1} * (cellsV() + 1); }

  /// Whether vertices along side k stand elsewhere than their parameters are.
  bool isThinned(uint32_t k) const { return side[k] < (k < 2 ? u : v) && !(points >> k & 1); }
  /// Whether the facet in column i and row j has such vertices.
  bool touchesThinned(uint32_t i, uint32_t j) const {
    return (j == 0 && isThinned(0)) || (j + 1 == cellsV() && isThinned(1)) || (i == 0 && isThinned(2)) ||
           (i + 1 == cellsU() && isThinned(3));
  }
  /// Where the vertex in column i and row j stands, after thinSides(): (s, t), in facets of the tile.
  V2f standsAt(uint32_t i, uint32_t j) const;
};

/// The rates of a surface. Each face is cut into 2^tiling x 2^tiling tiles, numbered along u, face by face.
/// Wherever two tiles meet their sides have the same rate, which is found from the side alone: no
/// T-junctions.
struct SurfaceRates {
  uint32_t tiling = 0;
  std::vector<TileRates> tiles;
  bool limited = false;  ///< coarser than wanted: the surface would have too many facets

  uint32_t tilesAlong() const { return 1u << tiling; }
  uint32_t faceOf(uint32_t tile) const { return tile >> (2 * tiling); }
  /// Column and row of a tile in its face.
  std::array<uint32_t, 2> placeOf(uint32_t tile) const {
    const uint32_t mask = tilesAlong() - 1;
    return {tile & mask, tile >> tiling & mask};
  }
  size_t memory() const { return sizeof(*this) + tiles.capacity() * sizeof(TileRates); }
};

/// Grids of facets are square in (s, t); faces that are triangles are covered by grids whose last row is the
/// corner (0, 1).
inline V2f gridToFace(FaceShape shape, const V2f& st) {
  return shape == FaceShape::Quad ? st : V2f(st.x * (1 - st.y), st.y);
}
inline V2f faceToGrid(FaceShape shape, const V2f& uv) {
  return shape == FaceShape::Quad || uv.y >= 1 ? uv : V2f(std::min(uv.x / (1 - uv.y), 1.0f), uv.y);
}

/// A facet of a tessellated surface: which it is, and where in it.
struct FacetPlace {
  uint32_t tile;
  uint32_t vertex;  ///< its first, of those of the tile; the others are vertex + 1, + row, + row + 1
  uint32_t row;     ///< vertices in a row of the tile
  V2f uv;           ///< in the facet, as rays meet it: weights of the corners of one of its triangles

  /// Of the second and the third corner of the triangle that has the place: vertices 0, 1, row with `first`,
  /// else row + 1, row, 1.
  V2f weights(bool& first) const;
};
/// The facet of a face that stands over (u, v). Along thinned sides facets fan out from the side's vertices.
FacetPlace locateFacet(const SurfaceRates& rates, FaceShape shape, uint32_t face, const V2f& uv);

/// From a tile's (s, t) to the face's (u, v).
inline V2f tileToFace(const SurfaceRates& rates, FaceShape shape, uint32_t tile, const V2f& st) {
  const auto [column, row] = rates.placeOf(tile);
  const float size = 1 / static_cast<float>(rates.tilesAlong());
  return gridToFace(shape,
                    {(static_cast<float>(column) + st.x) * size, (static_cast<float>(row) + st.y) * size});
}

/// From a hit on a tile's grid, where rays take vertices to be at even distances, to (s, t) of the tile: the
/// same but along thinned sides, whose vertices stand elsewhere.
V2f gridToTile(const TileRates& rates, const V2f& st);

/// Whether two edges of a triangle span an area that is more than rounding. Where multiplications are fused
/// the cross product of equal edges, of which cells at thinned sides have many, is not zero: it points
/// anywhere.
inline bool hasArea(const V3f& edge1, const V3f& edge2) {
  return maxAbsComponent(edge1.cross(edge2)) >
         roundingBound(8) * maxAbsComponent(edge1) * maxAbsComponent(edge2);
}

/// A point of a flat face's straight side, between its corners: the same bits from every face that has the
/// side.
V3f pointOnSide(const V3f& from, const V3f& to, double share);

/// Rates for a surface that stands where `objectToWorld` says (the place where it is seen largest decides):
/// facets stay within about an eightieth of a pixel of the surface and turn little where they are wider than
/// a pixel. With `shadingRate`, for displacement, they also are micropolygons of that area in pixels; then
/// flat surfaces have rates, too.
SurfaceRates traceRates(const RasterCamera& camera, const Surface& surface,
                        std::span<const M44f> objectToWorld, std::optional<float> shadingRate = {});

/// 2^level facets along u and v of each face, and more where sides would not agree.
SurfaceRates uniformRates(const Surface& surface, uint8_t level);

/// Appends the vertices of all tiles, tile after tile, rows along u, in object space, and to `first` the
/// index of each tile's first vertex. Vertices on a side that tiles share have the same bits in all of them,
/// but sides with a smaller rate than their tile are not yet thinned out (thinSides). Throws
/// std::length_error when 32 bits do not count them.
void tessellate(const Surface& surface, const SurfaceRates& rates, std::vector<uint32_t>& first,
                std::vector<V3f>& vertices);

/// Lets the vertices along sides repeat those of the side's own rate.
template <class T>
void thinSides(const SurfaceRates& rates, std::span<const uint32_t> first, std::span<T> vertices) {
  for (size_t tile = 0; tile < rates.tiles.size(); ++tile) {
    const TileRates& r = rates.tiles[tile];
    T* const grid = &vertices[first[tile]];
    const size_t row = r.cellsU() + 1, last = row * r.cellsV();
    const auto thin = [&](uint32_t level, uint32_t side, size_t begin, size_t step) {
      if (side >= level) return;
      // What is repeated, multiples of 1 << shift, repeats itself.
      const uint32_t cells = 1u << level, shift = level - side, half = 1u << (shift - 1);
      for (uint32_t i = 1; i < cells; ++i)
        grid[begin + i * step] = grid[begin + ((i + half) >> shift << shift) * step];
    };
    thin(r.u, r.side[0], 0, 1);
    thin(r.u, r.side[1], last, 1);
    thin(r.v, r.side[2], 0, row);
    thin(r.v, r.side[3], row - 1, row);
  }
}

}  // namespace patina
