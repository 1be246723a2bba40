// SPDX-License-Identifier: Apache-2.0
// Rates of facets: measured on a lattice of points of each tile, sides by themselves.
#include "renderer/geometry/facet_rates.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace patina {
namespace {

constexpr float kTolerance = 0.0125f;                            // pixels between a facet and the surface
constexpr float kTurn = 6.0f * std::numbers::pi_v<float> / 180;  // normals turn no more within a facet
constexpr float kMostTurn = std::numbers::pi_v<float> / 2;       // however small they are
constexpr float kOffScreenFactor = 0.25f;  // facets outside the view are so much coarser (in length)
constexpr float kMargin = 16;              // pixels around the frame that count as seen
constexpr uint8_t kMostLevels = 9;         // 512 facets along a tile
constexpr uint32_t kTileLevels = 5, kMostTiling = 6;  // faces with more than 64 facets are cut into tiles
constexpr uint32_t kFewFaces = 64;                    // measured more densely
constexpr uint32_t kMostTiledFaces = 4096;
constexpr size_t kMostFacets = size_t{1} << 22;  // of one surface
/// Of a displaced surface there are no more facets than these for each micropolygon that the picture has room
/// for, half of which the view needs, for front and back, or kFewFacets: a surface that reaches far beyond a
/// narrow view would be made of millions that nobody sees one by one.
constexpr float kFacetsInPicture = 32;
constexpr float kFewFacets = float{1 << 16};

struct Sphere {
  V3f center;
  float radius;
};
Sphere boundingSphere(const Box3f& box, const M44f& m) {
  Box3f moved;
  for (int c = 0; c < 8; ++c)
    moved.extendBy(transformPoint(
        {c & 1 ? box.max.x : box.min.x, c & 2 ? box.max.y : box.min.y, c & 4 ? box.max.z : box.min.z}, m));
  return {moved.center(), moved.size().length() / 2};
}

/// Facets wanted in the two directions of a tile and along its sides.
struct Wanted {
  float u = 1, v = 1;
  std::array<float, kTileSides> side{1, 1, 1, 1};
  uint8_t points = 0;  ///< see TileRates
};

/// Rounded up to a power of two.
uint8_t levelOf(float cells) {
  uint8_t level = 0;
  while (level < kMostLevels && static_cast<float>(1u << level) < cells) ++level;
  return level;
}

class Meter {
 public:
  Meter(const RasterCamera& camera, const Surface& surface, const M44f& toWorld,
        std::optional<float> shadingRate)
      : camera_(camera), surface_(surface), toWorld_(toWorld) {
    // Micropolygons are rounded to the nearest power of two in ratio, facets up.
    if (shadingRate) perMicropolygon_ = 1 / (std::sqrt(2 * *shadingRate));
  }

  /// Of the part of a face that begins at (s, t) of its grid; `samples` segments each way, an even number.
  Wanted measure(uint32_t face, float s, float t, float size, uint32_t samples);

  float pixels(const V3f& center, float radius) const {  ///< of a unit length there
    const float distance = std::max(camera_.nearestDistance(center, radius), 0.25f * radius);
    const float seen = camera_.mayBeVisible(center, radius, kMargin) ? 1 : kOffScreenFactor;
    return seen * camera_.pixelsPerUnit(std::max(distance, 1e-30f));
  }

 private:
  uint8_t sidesThatArePoints(uint32_t samples) const;
  void measureLine(const SurfacePoint* line, size_t step, uint32_t samples, float& inside,
                   float* alongSide) const;

  const RasterCamera& camera_;
  const Surface& surface_;
  const M44f& toWorld_;
  float perMicropolygon_ = 0;
  std::vector<V2f> uv_;
  std::vector<SurfacePoint> points_;
};

/// Every second point of the line is compared with its neighbours. All that goes into `alongSide` are
/// positions, in formulas that give the same bits when the line is walked the other way.
void Meter::measureLine(const SurfacePoint* line, size_t step, uint32_t samples, float& inside,
                        float* alongSide) const {
  const auto segments = static_cast<float>(samples / 2);
  for (uint32_t k = 0; k + 2 <= samples; k += 2) {
    const SurfacePoint &a = line[k * step], &middle = line[(k + 1) * step], &b = line[(k + 2) * step];
    const V3f chord = b.P - a.P;
    const float length = chord.length();
    const float deviation = (middle.P - (a.P + b.P) * 0.5f).length();
    const float radius = length * 0.5f + deviation;
    const float perUnit = pixels(middle.P, radius);
    if (!std::isfinite(radius * perUnit)) continue;
    // The deviation from the chord falls with the square of the facets.
    float wanted = segments * std::sqrt(deviation * perUnit / kTolerance);
    wanted = std::max(wanted, segments * 2 * radius * perUnit * perMicropolygon_);
    inside = std::max(inside, wanted);
    const auto turned = [&](float cosine) {
      const float angle = std::acos(std::clamp(cosine, -1.0f, 1.0f));
      return segments * std::max(angle / kMostTurn, std::min(angle / kTurn, 2 * radius * perUnit));
    };
    if (radius > 0) inside = std::max(inside, turned(a.N.dot(b.N)));
    if (!alongSide) continue;
    const V3f first = middle.P - a.P, second = b.P - middle.P;
    if (const float lengths = first.length() * second.length(); lengths > 0)
      wanted = std::max(wanted, turned(first.dot(second) / lengths) * 2);
    *alongSide = std::max(*alongSide, wanted);
  }
}

uint8_t Meter::sidesThatArePoints(uint32_t samples) const {
  constexpr float kPoint = 1e-5f;  // of the tile's size
  const size_t row = samples + size_t{1}, last = row * samples;
  const auto& p = points_;
  const float size = std::max((p[last + samples].P - p[0].P).length(), (p[last].P - p[samples].P).length());
  const auto isPoint = [&](size_t begin, size_t step) {
    for (size_t k = 1; k <= samples; ++k)
      if (!((p[begin + k * step].P - p[begin].P).length() <= kPoint * size)) return 0;
    return 1;
  };
  return static_cast<uint8_t>(isPoint(0, 1) | isPoint(last, 1) << 1 | isPoint(0, row) << 2 |
                              isPoint(samples, row) << 3);
}

Wanted Meter::measure(uint32_t face, float s, float t, float size, uint32_t samples) {
  const FaceShape shape = surface_.faceShape(face);
  const uint32_t row = samples + 1;
  uv_.clear();
  for (uint32_t j = 0; j <= samples; ++j)
    for (uint32_t i = 0; i <= samples; ++i)
      uv_.push_back(gridToFace(shape, {s + size * (static_cast<float>(i) / static_cast<float>(samples)),
                                       t + size * (static_cast<float>(j) / static_cast<float>(samples))}));
  points_.resize(uv_.size());
  surface_.evaluateMany(face, uv_, points_);
  if (surface_.isFlat()) {
    // Sides of flat faces are straight; their points are to have the same bits from either face.
    V3f c[4];
    surface_.corners(face, c);
    if (shape == FaceShape::Triangle) c[3] = c[2];
    for (uint32_t k = 0; k <= samples; ++k) {
      const double x = static_cast<double>(size) * k / samples;
      if (t == 0) points_[k].P = pointOnSide(c[0], c[1], static_cast<double>(s) + x);
      if (t + size == 1)
        points_[size_t{samples} * row + k].P = pointOnSide(c[2], c[3], static_cast<double>(s) + x);
      if (s == 0) points_[size_t{k} * row].P = pointOnSide(c[0], c[2], static_cast<double>(t) + x);
      if (s + size == 1)
        points_[size_t{k} * row + samples].P = pointOnSide(c[1], c[3], static_cast<double>(t) + x);
    }
  }
  for (SurfacePoint& p : points_) p.P = transformPoint(p.P, toWorld_);
  Wanted wanted;
  wanted.points = sidesThatArePoints(samples);
  for (uint32_t k = 0; k <= samples; ++k) {
    const bool first = k == 0, last = k == samples;
    measureLine(&points_[size_t{k} * row], 1, samples, wanted.u,
                first  ? &wanted.side[0]
                : last ? &wanted.side[1]
                       : nullptr);
    measureLine(&points_[k], row, samples, wanted.v,
                first  ? &wanted.side[2]
                : last ? &wanted.side[3]
                       : nullptr);
  }
  return wanted;
}

TileRates ratesOf(const Wanted& wanted) {
  TileRates r;
  for (size_t k = 0; k < kTileSides; ++k) r.side[k] = levelOf(wanted.side[k]);
  r.u = std::max({levelOf(wanted.u), r.side[0], r.side[1]});
  r.v = std::max({levelOf(wanted.v), r.side[2], r.side[3]});
  r.points = wanted.points;
  return r;
}

/// Gives all sides of an edge that the surface knows by number the largest of their rates.
void agreeOnEdges(const Surface& surface, SurfaceRates& rates) {
  std::vector<uint8_t> level;
  const auto forEachSide = [&](auto visit) {
    for (uint32_t face = 0; face < surface.faceCount(); ++face)
      for (uint32_t k = 0; k < kTileSides; ++k)
        if (const Surface::Side side = surface.sideOf(face, k); side.edge != kNone)
          visit(rates.tiles[face], k, side);
  };
  forEachSide([&](const TileRates& tile, uint32_t k, const Surface::Side& side) {
    if (side.edge >= level.size()) level.resize(side.edge + size_t{1});
    const auto wanted = static_cast<uint8_t>(tile.side[k] + (side.isHalf ? 1 : 0));
    level[side.edge] = std::max(level[side.edge], wanted);
  });
  forEachSide([&](TileRates& tile, uint32_t k, const Surface::Side& side) {
    tile.side[k] = static_cast<uint8_t>(level[side.edge] - (side.isHalf ? 1 : 0));
    uint8_t& across = k < 2 ? tile.u : tile.v;
    across = std::max(across, tile.side[k]);
  });
}

}  // namespace

V3f pointOnSide(const V3f& from, const V3f& to, double share) {
  if (share <= 0) return from;
  if (share >= 1) return to;
  const auto before = [](const V3f& a, const V3f& b) {
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
  };
  const bool turned = before(to, from);
  const V3d a(turned ? to : from), b(turned ? from : to);
  return V3f(a + (b - a) * (turned ? 1 - share : share));
}

SurfaceRates uniformRates(const Surface& surface, uint8_t level) {
  SurfaceRates rates;
  rates.tiles.assign(surface.faceCount(), TileRates{level, level, {level, level, level, level}});
  agreeOnEdges(surface, rates);
  return rates;
}

SurfaceRates traceRates(const RasterCamera& camera, const Surface& surface,
                        std::span<const M44f> objectToWorld, std::optional<float> shadingRate) {
  size_t largest = 0;
  float widest = -1;
  for (size_t k = 0; objectToWorld.size() > 1 && k < objectToWorld.size(); ++k) {
    const Sphere sphere = boundingSphere(surface.bound(), objectToWorld[k]);
    const float distance =
        std::max(camera.nearestDistance(sphere.center, sphere.radius), 0.25f * sphere.radius);
    const float seen = camera.mayBeVisible(sphere.center, sphere.radius, kMargin) ? 1 : kOffScreenFactor;
    const float size = sphere.radius * seen * camera.pixelsPerUnit(std::max(distance, 1e-30f));
    if (size > widest) widest = size, largest = k;
  }
  Meter meter(camera, surface, objectToWorld[largest], shadingRate);

  SurfaceRates rates;
  const uint32_t faces = surface.faceCount();
  rates.tiles.reserve(faces);
  const bool few = faces < kFewFaces;
  uint8_t finest = 0;
  for (uint32_t face = 0; face < faces; ++face) {
    const TileRates& r = rates.tiles.emplace_back(ratesOf(meter.measure(face, 0, 0, 1, few ? 16 : 4)));
    finest = std::max({finest, r.u, r.v});
  }
  const bool byNumber = faces > 0 && surface.sideOf(0, 0).edge != kNone;
  if (finest > kTileLevels + 1 && faces <= kMostTiledFaces && !byNumber) {
    rates.tiling = std::min(finest - kTileLevels, kMostTiling);
    const uint32_t along = rates.tilesAlong();
    const float size = 1 / static_cast<float>(along);
    rates.tiles.clear();
    rates.tiles.reserve(size_t{faces} * along * along);
    for (uint32_t face = 0; face < faces; ++face)
      for (uint32_t j = 0; j < along; ++j)
        for (uint32_t i = 0; i < along; ++i)
          rates.tiles.push_back(ratesOf(
              meter.measure(face, static_cast<float>(i) * size, static_cast<float>(j) * size, size, 4)));
  }
  if (byNumber) agreeOnEdges(surface, rates);

  // All sides become coarser alike, so that they still agree.
  const auto facets = [&] {
    size_t sum = 0;
    for (const TileRates& r : rates.tiles) sum += size_t{1} << (r.u + r.v);
    return sum;
  };
  size_t most = kMostFacets;
  if (shadingRate)
    most = static_cast<size_t>(std::clamp(kFacetsInPicture * camera.pixelCount() / *shadingRate, kFewFacets,
                                          static_cast<float>(kMostFacets)));
  const size_t limit = std::max(most, 4 * rates.tiles.size());  // next to halves, sides are two facets
  while (facets() > limit) {
    rates.limited = true;
    for (TileRates& r : rates.tiles) {
      const auto coarser = [&](uint8_t& level) {
        if (level > 0) --level;
      };
      coarser(r.u), coarser(r.v);
      for (uint8_t& side : r.side) coarser(side);
    }
    if (byNumber) agreeOnEdges(surface, rates);
  }
  return rates;
}

void tessellate(const Surface& surface, const SurfaceRates& rates, std::vector<uint32_t>& first,
                std::vector<V3f>& vertices) {
  const size_t firstTile = first.size();
  size_t count = vertices.size();
  for (const TileRates& r : rates.tiles) {
    first.push_back(static_cast<uint32_t>(count));
    count += r.vertices();
  }
  if (count > std::numeric_limits<uint32_t>::max()) throw std::length_error("too many facets in one unit");
  vertices.resize(count);
  const std::span<const uint32_t> own = std::span(first).subspan(firstTile);
  std::vector<double> s, t;
  std::vector<V2f> uv;
  std::vector<SurfacePoint> points;
  const double size = 1.0 / rates.tilesAlong();
  for (uint32_t tile = 0; tile < rates.tiles.size(); ++tile) {
    const TileRates& r = rates.tiles[tile];
    const uint32_t face = rates.faceOf(tile);
    const auto [column, row] = rates.placeOf(tile);
    s.clear(), t.clear();
    for (uint32_t i = 0; i <= r.cellsU(); ++i)
      s.push_back((column + static_cast<double>(i) / r.cellsU()) * size);
    for (uint32_t j = 0; j <= r.cellsV(); ++j)
      t.push_back((row + static_cast<double>(j) / r.cellsV()) * size);
    const std::span<V3f> grid = std::span(vertices).subspan(own[tile], r.vertices());
    if (!surface.isFlat()) {
      surface.evaluateGrid(face, s, t, grid);
      continue;
    }
    const FaceShape shape = surface.faceShape(face);
    uv.clear();
    for (const double y : t)
      for (const double x : s)
        uv.push_back(gridToFace(shape, {static_cast<float>(x), static_cast<float>(y)}));
    points.resize(uv.size());
    surface.evaluateMany(face, uv, points);
    V3f c[4];
    surface.corners(face, c);
    if (shape == FaceShape::Triangle) c[3] = c[2];
    for (size_t j = 0; j < t.size(); ++j)
      for (size_t i = 0; i < s.size(); ++i)
        grid[j * s.size() + i] = t[j] == 0   ? pointOnSide(c[0], c[1], s[i])
                                 : t[j] == 1 ? pointOnSide(c[2], c[3], s[i])
                                 : s[i] == 0 ? pointOnSide(c[0], c[2], t[j])
                                 : s[i] == 1 ? pointOnSide(c[1], c[3], t[j])
                                             : points[j * s.size() + i].P;
  }
  surface.weld(rates, own, vertices);
}

}  // namespace patina
