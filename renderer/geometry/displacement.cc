// SPDX-License-Identifier: Apache-2.0
// Displacement: tile by tile through the shader, then one place for every shared vertex.
#include "renderer/geometry/displacement.h"

#include <cstring>
#include <limits>
#include <numeric>

#include "renderer/base/statistics.h"

namespace patina {
namespace {

STAT_COUNTER("Displacement/vertices", vertexCount);

constexpr float kSharedCosine =
    0.966f;                           // normals that differ by less than 15 degrees are of one smooth surface
constexpr float kFoldCosine = -0.9f;  // those of the two sides of a sheet are not
constexpr size_t kCompared = 256;     // vertices in one place that are compared pair by pair

/// A vertex on a side of a tile.
struct SideVertex {
  V3f base;  ///< undisplaced: the same bits for all that share it
  uint32_t vertex;
};

bool before(const SideVertex& a, const SideVertex& b) {
  const int order = std::memcmp(&a.base, &b.base, sizeof(V3f));
  return order != 0 ? order < 0 : a.vertex < b.vertex;
}

/// Vertices on sides that the side itself has (the others will repeat these).
std::vector<SideVertex> sideVertices(const SurfaceRates& rates, std::span<const uint32_t> first,
                                     std::span<const V3f> base) {
  std::vector<SideVertex> all;
  for (size_t tile = 0; tile < rates.tiles.size(); ++tile) {
    const TileRates& r = rates.tiles[tile];
    const uint32_t row = r.cellsU() + 1, last = row * r.cellsV();
    const auto add = [&](uint32_t level, uint32_t side, uint32_t begin, uint32_t step, uint32_t from) {
      const uint32_t cells = 1u << level, stride = 1u << (level - side);
      for (uint32_t k = from * stride; k + from * stride <= cells; k += stride) {
        const uint32_t vertex = first[tile] + begin + k * step;
        all.push_back({base[vertex] + V3f(0.0f), vertex});  // -0 and 0 are one place
      }
    };
    add(r.u, r.side[0], 0, 1, 0);
    add(r.u, r.side[1], last, 1, 0);
    add(r.v, r.side[2], 0, row, 1);  // without the corners
    add(r.v, r.side[3], row - 1, row, 1);
  }
  std::sort(all.begin(), all.end(), before);
  return all;
}

/// Numbers vertices of one place by the parts of the surface that they belong to: two are of one part when
/// their normals agree to `cosine`, or both agree with others that do.
void findParts(std::span<const SideVertex> place, std::span<const V3f> normals, float cosine,
               std::vector<uint32_t>& part) {
  part.resize(place.size());
  if (place.size() > kCompared) {
    std::fill(part.begin(), part.end(), 0);
    return;
  }
  std::iota(part.begin(), part.end(), 0);
  for (size_t i = 1; i < place.size(); ++i)
    for (size_t j = 0; j < i; ++j) {
      if (part[i] == part[j] || normals[place[i].vertex].dot(normals[place[j].vertex]) < cosine) continue;
      const uint32_t from = std::max(part[i], part[j]), to = std::min(part[i], part[j]);
      for (size_t k = 0; k <= i; ++k)
        if (part[k] == from) part[k] = to;
    }
}

/// visit(first, end) for each run of vertices in one place.
template <class Visit>
void forEachPlace(std::span<const SideVertex> sides, Visit visit) {
  for (size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
    while (end < sides.size() && std::memcmp(&sides[begin].base, &sides[end].base, sizeof(V3f)) == 0) ++end;
    if (end - begin > 1) visit(sides.subspan(begin, end - begin));
  }
}

/// Replaces values of vertices in one place by their mean, part by part.
template <class Finish>
void shareValues(std::span<const SideVertex> sides, std::span<const V3f> normals, float cosine,
                 std::span<V3f> values, Finish finish) {
  std::vector<uint32_t> part;
  forEachPlace(sides, [&](std::span<const SideVertex> place) {
    findParts(place, normals, cosine, part);
    for (uint32_t p = 0; p < place.size(); ++p) {
      V3d sum(0, 0, 0);
      size_t count = 0;
      for (size_t k = 0; k < place.size(); ++k)
        if (part[k] == p) sum += V3d(values[place[k].vertex]), ++count;
      if (count < 2) continue;
      const V3f mean = finish(sum, count);
      for (size_t k = 0; k < place.size(); ++k)
        if (part[k] == p) values[place[k].vertex] = mean;
    }
  });
}

/// Sums of the cross products of the facets around each vertex of a tile.
void addFacetNormals(const TileRates& r, const V3f* P, V3f* N) {
  const size_t row = r.cellsU() + 1;
  std::fill(N, N + r.vertices(), V3f(0, 0, 0));
  for (uint32_t j = 0; j < r.cellsV(); ++j)
    for (uint32_t i = 0; i < r.cellsU(); ++i) {
      const size_t k = j * row + i;
      // Of a facet's two triangles together: the cross product of its diagonals.
      const V3f cross = (P[k + row + 1] - P[k]).cross(P[k + row] - P[k + 1]);
      N[k] += cross, N[k + 1] += cross, N[k + row] += cross, N[k + row + 1] += cross;
    }
}

}  // namespace

uint32_t packNormal(const V3f& n) {
  const float sum = std::abs(n.x) + std::abs(n.y) + std::abs(n.z);
  float x = n.x / sum, y = n.y / sum;
  if (n.z < 0) {
    const float folded = (1 - std::abs(y)) * std::copysign(1.0f, x);
    y = (1 - std::abs(x)) * std::copysign(1.0f, y);
    x = folded;
  }
  const auto snorm = [](float c) {
    return static_cast<uint32_t>(
        static_cast<uint16_t>(static_cast<int16_t>(std::lround(std::clamp(c, -1.0f, 1.0f) * 32767))));
  };
  return snorm(x) | snorm(y) << 16;
}

V3f unpackNormal(uint32_t packed) {
  const auto value = [](uint32_t bits) {
    return static_cast<float>(static_cast<int16_t>(static_cast<uint16_t>(bits))) / 32767;
  };
  float x = value(packed & 0xffffu), y = value(packed >> 16);
  const float z = 1 - std::abs(x) - std::abs(y);
  if (z < 0) {
    const float unfolded = (1 - std::abs(y)) * std::copysign(1.0f, x);
    y = (1 - std::abs(x)) * std::copysign(1.0f, y);
    x = unfolded;
  }
  return V3f(x, y, z).normalized();
}

DisplacementResult displaceFacets(const Surface& surface, const Primitive& primitive,
                                  const Attributes& attributes, const M44f& toWorld, bool isReversed,
                                  const Displacer& displacer, const SurfaceRates& rates,
                                  std::span<const uint32_t> allFirst, std::span<V3f> vertices) {
  // From here on vertices are counted from the surface's first.
  vertices = vertices.subspan(allFirst[0]);
  std::vector<uint32_t> first(allFirst.begin(), allFirst.end());
  for (uint32_t& index : first) index -= allFirst[0];
  const std::vector<SideVertex> sides = sideVertices(rates, first, vertices);
  const M44f toObject = toWorld.inverse();
  const float outside = isReversed ? -1.0f : 1.0f;
  const PrimVar* given = findVariable(primitive, "N");
  if (given && given->components != 3) given = nullptr;

  // The shader, once for each vertex; Ng is kept to tell creases from smooth places.
  std::vector<V3f> base(vertices.size()), normals(vertices.size());
  DisplacementResult result;
  std::vector<V2f> uv;
  std::vector<SurfacePoint> points;
  std::vector<V3f> Ng, N, dPdu, dPdv, shaded(vertices.size());
  std::vector<float> footprint;
  bool hasNormals = false;
  for (uint32_t tile = 0; tile < rates.tiles.size(); ++tile) {
    const TileRates& r = rates.tiles[tile];
    const uint32_t face = rates.faceOf(tile), row = r.cellsU() + 1;
    const FaceShape shape = surface.faceShape(face);
    const auto n = static_cast<uint32_t>(r.vertices());
    uv.clear();
    for (uint32_t k = 0; k < n; ++k)
      uv.push_back(tileToFace(rates, shape, tile,
                              {static_cast<float>(k % row) / static_cast<float>(r.cellsU()),
                               static_cast<float>(k / row) / static_cast<float>(r.cellsV())}));
    points.resize(n), Ng.resize(n), N.resize(n), dPdu.resize(n), dPdv.resize(n), footprint.resize(n);
    surface.evaluateMany(face, uv, points);
    const std::span<V3f> P = vertices.subspan(first[tile], n);
    const float steps = static_cast<float>(rates.tilesAlong());
    for (uint32_t k = 0; k < n; ++k) {
      base[first[tile] + k] = P[k] = transformPoint(P[k], toWorld);
      Ng[k] = normalizedOr(transformNormal(points[k].N, toObject), V3f(0, 0, 1)) * outside;
      N[k] = Ng[k];
      if (given) {
        surface.interpolate(*given, face, uv[k].x, uv[k].y, &N[k].x);
        N[k] = normalizedOr(transformNormal(N[k], toObject), Ng[k]);
        if (N[k].dot(Ng[k]) < 0) N[k] = -N[k];
      }
      dPdu[k] = transformVector(points[k].dPdu, toWorld), dPdv[k] = transformVector(points[k].dPdv, toWorld);
      footprint[k] = std::max(dPdu[k].length() / (steps * static_cast<float>(r.cellsU())),
                              dPdv[k].length() / (steps * static_cast<float>(r.cellsV())));
      normals[first[tile] + k] = N[k];
    }
    hasNormals |= displacer.displace(
        {surface, primitive, attributes, toWorld, face, uv, Ng, dPdu, dPdv, footprint, P, N});
    std::copy(N.begin(), N.end(), shaded.begin() + first[tile]);
  }
  vertexCount += static_cast<int64_t>(vertices.size());

  shareValues(sides, normals, kFoldCosine, vertices,
              [](const V3d& sum, size_t count) { return V3f(sum / static_cast<double>(count)); });
  for (size_t k = 0; k < vertices.size(); ++k)
    result.moved = std::max(result.moved, (vertices[k] - base[k]).length());
  thinSides(rates, std::span<const uint32_t>(first), vertices);

  // One that bends normals does something, too, where it leaves vertices in their places.
  if (hasNormals) result.moved = std::max(result.moved, std::numeric_limits<float>::min());
  // Normals: the shader's, or those of the facets; a smooth normal of flat faces keeps its turn against them.
  if (!hasNormals)
    for (uint32_t tile = 0; tile < rates.tiles.size(); ++tile)
      addFacetNormals(rates.tiles[tile], &vertices[first[tile]], &shaded[first[tile]]);
  shareValues(sides, normals, kSharedCosine, shaded, [](const V3d& sum, size_t) { return V3f(sum); });
  if (!hasNormals && surface.isFlat() && (given || surface.hasSmoothNormals())) {
    const float turned = (toWorld.determinant() < 0 ? -1.0f : 1.0f) * outside;
    for (uint32_t tile = 0; tile < rates.tiles.size(); ++tile) {
      const uint32_t face = rates.faceOf(tile);
      V3f c[4];
      surface.corners(face, c);
      for (V3f& p : c) p = transformPoint(p, toWorld);
      const V3f flat = normalizedOr((c[1] - c[0]).cross(c[2] - c[0]), V3f(0, 0, 0)) * turned;
      for (size_t k = first[tile]; k < first[tile] + rates.tiles[tile].vertices(); ++k) {
        const V3f facet = normalizedOr(shaded[k], flat * turned) * turned;
        shaded[k] = facet + normals[k] - flat;
      }
    }
  }
  thinSides(rates, std::span<const uint32_t>(first), std::span(shaded));
  result.normals.reserve(vertices.size());
  for (size_t k = 0; k < vertices.size(); ++k)
    result.normals.push_back(packNormal(normalizedOr(shaded[k], normals[k])));
  return result;
}

}  // namespace patina
