// SPDX-License-Identifier: Apache-2.0
// Baking surfels from patches, bounce by bounce.
#include "renderer/integrators/baked_points.h"

#include "renderer/base/parallel.h"
#include "renderer/base/statistics.h"

namespace patina {
namespace {

STAT_COUNTER("Points/surfels", surfelCount);
STAT_COUNTER("Points/surfels refused: no area, or not finite", refusedCount);
STAT_COUNTER("Points/surfels shaded", shadedCount);
STAT_COUNTER("Points/bounces baked", bounceCount);
STAT_COUNTER("Points/rasters drawn", rasterCount);
STAT_COUNTER("Points/rasters not drawn again for another bounce", reusedCount);
STAT_COUNTER("Points/nodes looked at", lookedCount);
STAT_TIME("Time of threads/rasters of surfels", rasterTime);

/// Bytes for a surfel: of the octree, up to 360 as seen, and of its piece and radiances while it is baked.
constexpr size_t kBytesOfSurfel = 600;
/// Of a pixel of the picture, or in all at least: surfaces that reach far beyond a small picture would have a
/// thousand times as many, each looked around from, and their pieces would be smaller than what it shows.
constexpr float kSurfelsOfPixel = 16, kFewSurfels = 16384;
constexpr size_t kBatch = 1024;
/// Receivers see nothing that is nearer than so many times the error of their place.
constexpr float kErrors = 16;
/// Of irradiance that is interpolated while baking: Ward's error, and contrast. cornell's picture is the same
/// with 0.1, and takes 1.6 times as long.
constexpr float kRoughness = 0.4f;
/// Bounces end when all that are left would add less than this part of the radiance: that much is estimated.
constexpr double kRest = 0.01;

/// Of a bent piece, whose middle is `bulge` away from the plane of its corners: its disc, half as far away,
/// grows to where it meets those of its neighbours, and its area to that of the arc. With c half the length
/// of a chord and b the bulge of a circle's arc above it, tangents b / 2 below its top meet about b^2 / c
/// beyond the chord's ends, and the arc is longer by 2/3 (b / c)^2. Of what is not bent but rough, no more
/// than kMostBent.
void closeGaps(float bulge, Surfel& s) {
  constexpr float kMostBent = 0.05f;
  const float half = std::max(std::min(s.halfU, s.radius), std::min(s.halfV, s.radius));
  if (!(half > 0)) return;
  const float bent = std::min(bulge * bulge / (half * half), kMostBent), more = bent * half;
  s.halfU += more, s.halfV += more, s.radius += 1.5f * more, s.triangle *= 1 + 2 * bent;
  s.area *= 1 + 2.0f / 3 * bent;
}

}  // namespace

BakedPoints::~BakedPoints() = default;

/// By placement: whether its pieces enclose a volume, and on which side of them that is. Normals of what is
/// closed cancel each other, and away from the middle they point out, or all in.
void BakedPoints::findInnerSides(const std::vector<Piece>& pieces, size_t placements,
                                 std::vector<Surfel>& surfels) {
  struct Sums {
    V3d normal{0, 0, 0}, middle{0, 0, 0};
    double area = 0, flux = 0;
  };
  std::vector<Sums> sums(placements);
  for (size_t k = 0; k < pieces.size(); ++k) {
    Sums& s = sums[pieces[k].placement];
    const double area = surfels[k].area;
    s.normal += V3d(surfels[k].N) * area, s.middle += V3d(surfels[k].P) * area, s.area += area;
  }
  for (size_t k = 0; k < pieces.size(); ++k) {
    Sums& s = sums[pieces[k].placement];
    const V3d away = V3d(surfels[k].P) - s.middle / s.area;
    s.flux += away.dot(V3d(surfels[k].N)) * static_cast<double>(surfels[k].area);
  }
  innerOf_.assign(placements, Surfel::Inner::None);
  constexpr double kCancelled = 0.02, kVolume = 0.02;  // of a ball's flux 0.28 of the area's power of 3/2
  for (size_t k = 0; k < pieces.size(); ++k) {
    const Sums& s = sums[pieces[k].placement];
    if (!(s.area > 0) || s.normal.length() > kCancelled * s.area) continue;
    if (std::abs(s.flux) < kVolume * std::pow(s.area, 1.5)) continue;
    surfels[k].inner = s.flux > 0 ? Surfel::Inner::Back : Surfel::Inner::Front;
    surfels[k].owner = pieces[k].placement, innerOf_[pieces[k].placement] = surfels[k].inner;
  }
}

BakedPoints::BakedPoints(const World& world, const RadiosityEngine::Settings& like, const Settings& settings)
    : world_(world), settings_(settings) {
  const PhaseTimer timer("Baking of points");
  const auto placements = static_cast<uint32_t>(world.geometry().placements().size());
  // Each is looked around from, as pixels are.
  const auto worth =
      static_cast<size_t>(std::max(kSurfelsOfPixel * world.camera().pixelCount(), kFewSurfels));
  const size_t room = std::clamp<size_t>(settings.bytes / kBytesOfSurfel, 64, worth);
  int most = 1;  // that any object allows
  for (const Attributes& attributes : world.scene().attributes)
    most = std::max(most, attributes.maxDiffuseDepth);
  const int bounces = settings.bounces > 0 ? std::min(settings.bounces, most) : most;
  size_t micropolygons = 0;
  std::vector<Piece> pieces = collectAll(room, bounces > 2 ? room / 2 : room, micropolygons);
  const size_t count = pieces.size();
  std::erase_if(pieces, [](const Piece& p) { return !(p.area > 0) || !std::isfinite(p.area); });

  std::vector<Surfel> surfels(pieces.size());
  std::vector<Rgb> front(pieces.size()), back(pieces.size());
  parallelFor(size_t{0}, pieces.size(), [&](size_t k) {
    const Piece& p = pieces[k];
    const ShadingPoint point = pointOf(p, true);
    Surfel& s = surfels[k];
    // Between the surface and the plane of the corners: so that bent pieces hide as much as there is, neither
    // what tangents cut off nor what chords leave out.
    // Its normal is the corners', too, not that of the facet in its middle, which may be turned by degrees.
    const bool isTurned = p.N.dot(point.Ng) < 0;
    s.P = (point.P + p.P) / 2, s.N = isTurned ? -p.N : p.N;
    s.area = p.area, s.radius = p.radius, s.hasBack = p.hasBack;
    if (p.isMany) s.P = p.surfelP, s.N = p.surfelN, s.thickness = p.thickness;
    s.U = p.U;
    s.halfU = p.halfU, s.halfV = p.halfV, s.triangle = p.triangle;
    if (isTurned) s.triangle.z = -s.triangle.z;
    if (!p.isMany) closeGaps((point.P - p.P).length(), s);
  });
  findInnerSides(pieces, placements, surfels);
  RadiosityEngine::Settings first;
  first.cached = false, first.indirect = false, first.rays = like.rays;
  bake(RadiosityEngine(world, first), {0, false}, pieces, front, back);
  for (size_t k = 0; k < pieces.size(); ++k) surfels[k].front = front[k], surfels[k].back = back[k];
  tree_ = std::make_unique<PointTree>(std::move(surfels));
  surfelCount += static_cast<int64_t>(tree_->surfels().size());
  refusedCount += static_cast<int64_t>(tree_->refused() + count - pieces.size());

  const auto hand = [&] {  // in the tree's order
    std::vector<Rgb> f(tree_->surfels().size()), b(f.size());
    for (size_t k = 0; k < pieces.size(); ++k)
      if (const uint32_t at = tree_->places()[k]; at != PointTree::kRefused)
        f[at] = front[k], b[at] = back[k];
    tree_->setRadiance(f, b);
  };
  RadiosityEngine::Settings next = like;
  next.points = this;
  // What gathers average over may be rougher than the picture.
  next.irradianceError = next.irradianceContrast = kRoughness;
  std::vector<Rgb> frontBefore, backBefore;
  V3d gained(0), gainedBefore(0);
  bool isStable = false;
  // A raster of a bounce sees what that of the one before saw, in another light.
  const size_t held = pieces.size() * kBytesOfSurfel;
  if (bounces > 2) views_ = std::make_unique<SurfelViews>(settings.bytes - std::min(held, settings.bytes));
  if (bounces > 1) findAlone(RadiosityEngine(world, next), pieces);
  if (bounces > 1) findClusters(pieces, placements);
  for (int bounce = 1; bounce < bounces && !world.interrupted(); ++bounce) {
    frontBefore = front, backBefore = back;
    // Irradiance is interpolated in patches: an engine has it of one bounce.
    ++bounceCount;
    if (bounce > 1) gatherClusters(pieces, {bounce, isStable}, front, back);
    bake(RadiosityEngine(world, next), {bounce, isStable}, pieces, front, back);
    const auto shines = [](const Rgb& f, const Rgb& b) { return std::pair(!isBlack(f), !isBlack(b)); };
    isStable = true;
    for (size_t k = 0; k < pieces.size() && isStable; ++k)
      isStable = shines(front[k], back[k]) == shines(frontBefore[k], backBefore[k]);
    if (settings.bounces == 0) {
      V3d sum(0);
      gainedBefore = gained, gained = V3d(0);
      for (size_t k = 0; k < pieces.size(); ++k) {
        // Not by area: pieces are as large as they look, but for a plain that reaches to the horizon.
        sum += V3d(front[k] + back[k]);
        gained += V3d(front[k] - frontBefore[k] + back[k] - backBefore[k]);
      }
      if (bounce > 1 && addRest(pieces, bounce, bounces - 1, sum, gained, gainedBefore, frontBefore,
                                backBefore, front, back))
        bounce = bounces;
    }
    hand();
  }
  isBaked_ = true;
  clusters_ = {};
  if (views_)
    setStatistic("Memory/views of points while baking MB", static_cast<double>(views_->memory()) / 1048576);
  views_ = {};
  setStatistic("Memory/points MB", static_cast<double>(tree_->memory()) / 1048576);
  setStatistic(
      "Points/micropolygons along a surfel",
      std::sqrt(static_cast<double>(micropolygons) / static_cast<double>(std::max<size_t>(count, 1))));
}

ShadingPoint BakedPoints::pointOf(const Piece& piece, bool front) const {
  return world_.shading().at(piece.placement, piece.face, piece.u, piece.v, front, piece.size);
}

uint64_t BakedPoints::seedOf(const Piece& piece, bool front) const {
  return hashOf(world_.geometry().placements()[piece.placement].seed, piece.face,
                uint64_t{floatBits(piece.u)} << 32 | floatBits(piece.v), front) ^
         world_.frameSeed();
}

VertexWeights BakedPoints::around(const Piece& piece) const {
  const Patch& patch = world_.geometry().patches()[piece.patch];
  const V2f local = patch.toLocal(piece.u, piece.v);
  return patch.locate(Level::Fine, local.x, local.y);
}

void BakedPoints::findAlone(const RadiosityEngine& engine, std::vector<Piece>& pieces) const {
  parallelFor(size_t{0}, (pieces.size() + kBatch - 1) / kBatch, [&](size_t batch) {
    std::vector<RadiosityEngine::Cell> cells;
    std::vector<bool*> to;
    for (size_t k = batch * kBatch; k < std::min(pieces.size(), (batch + 1) * kBatch); ++k) {
      Piece& p = pieces[k];
      if (p.patch == kNone) continue;
      for (const bool side : {true, false}) {
        if (!side && !p.hasBack) continue;
        cells.push_back({p.patch, side, around(p), nullptr});
        to.push_back(&p.isAlone[side ? 0 : 1]);
      }
    }
    std::vector<uint8_t> separated(cells.size());
    engine.separated(cells, separated);
    for (size_t k = 0; k < cells.size(); ++k) *to[k] = separated[k] != 0;
  });
}

/// What bounces after `bounce`, up to `last`, would add, each of them as much less than the one before as the
/// last: once that is little. Sums over pieces, by channel; false: it is not.
bool BakedPoints::addRest(const std::vector<Piece>& pieces, int bounce, int last, const V3d& sum,
                          const V3d& gained, const V3d& gainedBefore, const std::vector<Rgb>& frontBefore,
                          const std::vector<Rgb>& backBefore, std::vector<Rgb>& front,
                          std::vector<Rgb>& back) const {
  std::array<double, 3> ratio;
  const auto restOf = [](double r, int n) { return r * (1 - std::pow(r, n)) / (1 - r); };
  for (int c = 0; c < 3; ++c) {
    constexpr double kMostRatio = 0.99;
    ratio[static_cast<size_t>(c)] =
        gainedBefore[c] > 0 ? std::clamp(gained[c] / gainedBefore[c], 0.0, kMostRatio) : 0;
    if (restOf(ratio[static_cast<size_t>(c)], last - bounce) * gained[c] > kRest * sum[c]) return false;
  }
  for (size_t k = 0; k < pieces.size(); ++k) {
    // Objects that allow fewer bounces have theirs.
    const int left = std::min(last, world_.attributesOf(pieces[k].placement).maxDiffuseDepth) - bounce;
    for (int c = 0; c < 3; ++c) {
      const auto part = static_cast<float>(restOf(ratio[static_cast<size_t>(c)], std::max(left, 0)));
      front[k][c] += (front[k][c] - frontBefore[k][c]) * part;
      back[k][c] += (back[k][c] - backBefore[k][c]) * part;
    }
  }
  return true;
}

/// Radiance of both sides. The same for any number of threads: pieces are shaded in batches of fixed ones.
void BakedPoints::bake(const RadiosityEngine& engine, const Bounce& bounce, const std::vector<Piece>& pieces,
                       std::vector<Rgb>& front, std::vector<Rgb>& back) const {
  parallelFor(size_t{0}, (pieces.size() + kBatch - 1) / kBatch, [&](size_t batch) {
    if (world_.interrupted()) return;
    const size_t begin = batch * kBatch, end = std::min(pieces.size(), begin + kBatch);
    std::vector<RadiosityEngine::Request> requests;
    std::vector<RadiosityEngine::Spot> spots;
    std::vector<std::pair<size_t, bool>> of;
    std::vector<Rgb> radiance;
    std::vector<RadiosityEngine::Irradiance> indirect;
    const auto shade = [&] {
      radiance.resize(requests.size());
      for (size_t k = 0; k < indirect.size(); ++k) requests[k].indirect = &indirect[k];
      // As deep as what gathers meet: with as many rays to lights as the finest vertices there get.
      engine.shade(requests, 1, Purpose::Vertex, radiance, spots);
      shadedCount += static_cast<int64_t>(requests.size());
      for (size_t i = 0; i < of.size(); ++i) (of[i].second ? front : back)[of[i].first] = radiance[i];
      requests.clear(), spots.clear(), of.clear(), indirect.clear();
    };
    enum class How : uint8_t { Interpolated, ByItself, Shared };
    for (const How how : {How::Interpolated, How::ByItself, How::Shared}) {
      for (size_t k = begin; k < end; ++k)
        for (const bool side : {true, false}) {
          const Piece& p = pieces[k];
          const How its = p.patch == kNone          ? How::Shared
                          : p.isAlone[side ? 0 : 1] ? How::ByItself
                                                    : How::Interpolated;
          if ((!side && !p.hasBack) || how != its) continue;
          const ShadingPoint point = pointOf(p, side);
          const uint64_t seed = seedOf(p, side);
          const int bounces = engine.bouncesAt(p.placement);
          const Rgb& before = side ? front[k] : back[k];
          if (bounce.number > bounces || (bounce.onlyLit && isBlack(before))) continue;
          requests.push_back({point, seed, bounces});
          of.emplace_back(k, side);
          if (bounce.number > 0 && p.patch == kNone) {
            // Light from behind comes through as on the other side, seen from there.
            const auto known = [&](bool inFront) {
              const uint32_t c = p.cluster[inFront ? 0 : 1];
              return c == kNone ? Rgb(0) : clusters_[c].at(inFront ? p.N : -p.N);
            };
            indirect.push_back({known(side), known(!side)});
          }
          if (how != How::Interpolated || !engine.cache()) continue;
          spots.push_back({p.patch, side, RadiosityEngine::keptBounces(bounces), around(p)});
        }
      shade();
    }
  });
}

PointRaster::Estimate BakedPoints::irradiance(const ShadingPoint& point, bool behind, uint64_t seed,
                                              bool withSurfels) const {
  const TimeShare share(rasterTime);
  const V3f N = behind ? -point.N : point.N;
  const auto bits = [](const V3f& v) { return hashOf(floatBits(v.x), floatBits(v.y), floatBits(v.z)); };
  const uint64_t key = hashOf(seed, bits(point.P), bits(N), withSurfels, point.placement);
  if (const SurfelView* known = views_ ? views_->find(key) : nullptr) {
    ++reusedCount;
    return {known->irradiance(*tree_), known->covered, known->inverseDistance, known->nearest};
  }
  // One for baking and one for the picture.
  thread_local std::array<std::unique_ptr<PointRaster>, 2> rasters;
  thread_local std::array<PointRaster::Settings, 2> made;
  const size_t which = isBaked_ ? 1 : 0;
  PointRaster::Settings wanted = settings_.raster;
  if (!isBaked_) wanted.resolution = std::max(PointOptions::kLeastResolution, wanted.resolution * 3 / 8 * 2);
  std::unique_ptr<PointRaster>& raster = rasters[which];
  if (!raster || made[which].resolution != wanted.resolution ||
      made[which].maxSolidAngle != wanted.maxSolidAngle) {
    raster = std::make_unique<PointRaster>(wanted);
    made[which] = wanted;
  }
  ++rasterCount;
  const Lights& lights = world_.lights();
  const LightList& list = world_.lightsOf(point.placement);
  const PointRaster::Environment sky = [&](std::span<const V3f> directions, std::span<Rgb> out) {
    const std::vector<V3f> from(directions.size(), point.P);
    std::vector<Rgb> radiance(directions.size());
    std::vector<float> pdf(directions.size());
    for (const uint32_t light : lights.infinite()) {
      if (!lights.isSmooth(light) || !list.sees(light)) continue;
      lights.evaluate(light, from, directions, radiance, pdf);
      for (size_t k = 0; k < out.size(); ++k) out[k] += radiance[k];
    }
  };
  const float turn = toUnit(static_cast<uint32_t>(hashOf(seed, behind) >> 32));
  thread_local SurfelView view;
  // Delayed archives bring placements that were not there while baking.
  const Surfel::Inner inner =
      point.placement < innerOf_.size() ? innerOf_[point.placement] : Surfel::Inner::None;
  const bool isOutside = inner == (point.front != behind ? Surfel::Inner::Back : Surfel::Inner::Front);
  const PointRaster::Estimate seen = raster->gather(
      *tree_, point.P, N, turn, kErrors * point.error, list.smooth ? sky : PointRaster::Environment(),
      withSurfels, isOutside ? point.placement : Surfel::kNobody, views_ ? &view : nullptr);
  lookedCount += seen.looked;
  if (views_) views_->keep(key, view);
  return seen;
}

}  // namespace patina
