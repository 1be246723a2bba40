// SPDX-License-Identifier: Apache-2.0
// Baking surfels from patches, bounce by bounce.
#include "renderer/integrators/baked_points.h"

#include <tbb/parallel_for.h>

#include "renderer/base/statistics.h"

namespace patina {
namespace {

STAT_COUNTER("Points/surfels", surfelCount);
STAT_COUNTER("Points/surfels refused: no area, or not finite", refusedCount);
STAT_COUNTER("Points/surfels shaded", shadedCount);
STAT_COUNTER("Points/rasters drawn", rasterCount);
STAT_TIME("Time of threads/rasters of surfels", rasterTime);

/// Bytes of the octree for a surfel, measured (PointTree.MemoryIsCounted), and of what baking needs beside.
constexpr size_t kBytesOfSurfel = 420;
constexpr size_t kBatch = 1024;
/// Receivers see nothing that is nearer than so many times the error of their place.
constexpr float kErrors = 16;

}  // namespace

/// A surfel and where it is on its surface.
struct BakedPoints::Piece {
  uint32_t placement, face;
  float u, v;
  float size;  ///< distance of neighbours
  float area, radius;
  bool hasBack;
  V3f extent;
};

BakedPoints::~BakedPoints() = default;

/// `pieces` null: they are counted only.
void BakedPoints::collect(uint32_t placement, int step, std::vector<Piece>* pieces, size_t& count) const {
  const Geometry& geometry = world_.geometry();
  const Attributes& attributes = world_.attributesOf(placement);
  if ((attributes.visibility & kDiffuseRay) == 0) return;
  const PatchTable& patches = geometry.patches();
  const auto add = [&](uint32_t face, const V2f* corners, int n, float scale) {
    ++count;
    if (!pieces) return;
    V3f P[4];
    V2f middle(0, 0);
    V3f center(0, 0, 0);
    for (int k = 0; k < n; ++k) {
      P[k] = geometry.facet(placement, face, corners[k].x, corners[k].y).P;
      middle += corners[k] / static_cast<float>(n), center += P[k] / static_cast<float>(n);
    }
    const float area =
        (n == 4 ? (P[3] - P[0]).cross(P[2] - P[1]) : (P[1] - P[0]).cross(P[2] - P[0])).length() / 2;
    float radius = 0;
    V3f extent(0, 0, 0);
    for (int k = 0; k < n; ++k) {
      const V3f d = P[k] - center;
      radius = std::max(radius, d.length());
      for (int i = 0; i < 3; ++i) extent[i] = std::max(extent[i], std::abs(d[i]));
    }
    pieces->push_back({placement, face, middle.x, middle.y, std::sqrt(area), area * scale,
                       radius * std::sqrt(scale), !attributes.oneSided, scale > 1 ? V3f(kInfinity) : extent});
  };
  const Surface& surface = geometry.surface(geometry.placements()[placement]);
  const auto [first, patchCount] = patches.patchesOf(placement);
  bool grouped = false;
  for (uint32_t index = first; index < first + patchCount; ++index) {
    const Patch& patch = patches[index];
    if (patch.group > 0) {
      grouped = true;
      continue;
    }
    const int nu = std::max(1, patch.cellsU / step), nv = std::max(1, patch.cellsV / step);
    const auto at = [&](int i, int j) {
      return patch.toFace(
          {static_cast<float>(i) / static_cast<float>(nu), static_cast<float>(j) / static_cast<float>(nv)});
    };
    for (int j = 0; j < nv; ++j)
      for (int i = 0; i < nu; ++i) {
        if (patch.shape == FaceShape::Quad) {
          const V2f corners[4] = {at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)};
          add(patch.face, corners, 4, 1);
        } else if (i + j < nu) {
          const V2f corners[3] = {at(i, j), at(i + 1, j), at(i, j + 1)};
          add(patch.face, corners, 3, 1);
          const V2f others[3] = {at(i + 1, j + 1), at(i, j + 1), at(i + 1, j)};
          if (i + j + 1 < nu) add(patch.face, others, 3, 1);
        }
      }
  }
  if (!grouped) return;
  // Faces smaller than micropolygons have one each; when memory is short some stand for their neighbours.
  const uint32_t every = step >= 16 ? static_cast<uint32_t>(step / 8) : 1;
  uint32_t number = 0;
  for (uint32_t face = 0; face < surface.faceCount(); ++face) {
    const bool quad = surface.faceShape(face) == FaceShape::Quad;
    const float middle = quad ? 0.5f : 1.0f / 3;
    if (patches[patches.find(placement, face, middle, middle)].group == 0) continue;
    if (number++ % every != 0) continue;
    static constexpr V2f kCorners[4] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
    add(face, kCorners, quad ? 4 : 3, static_cast<float>(every));
  }
}

BakedPoints::BakedPoints(const World& world, const RadiosityEngine::Settings& direct,
                         const Settings& settings)
    : world_(world), settings_(settings) {
  const PhaseTimer timer("Baking of points");
  const auto placements = static_cast<uint32_t>(world.geometry().placements().size());
  const size_t room = std::max<size_t>(settings.bytes / kBytesOfSurfel, 64);
  int step = 1;
  for (;; step *= 2) {
    size_t count = 0;
    for (uint32_t k = 0; k < placements; ++k) collect(k, step, nullptr, count);
    constexpr int kCoarsest = 1 << 16;
    if (count <= room || step >= kCoarsest) break;
  }
  std::vector<Piece> pieces;
  size_t count = 0;
  for (uint32_t k = 0; k < placements && !world.interrupted(); ++k) collect(k, step, &pieces, count);
  std::erase_if(pieces, [](const Piece& p) { return !(p.area > 0) || !std::isfinite(p.area); });

  std::vector<Surfel> surfels(pieces.size());
  std::vector<Rgb> front(pieces.size()), back(pieces.size());
  tbb::parallel_for(size_t{0}, pieces.size(), [&](size_t k) {
    const Piece& p = pieces[k];
    const ShadingPoint point = world.shading().at(p.placement, p.face, p.u, p.v, true, p.size);
    Surfel& s = surfels[k];
    s.P = point.P, s.N = point.Ng, s.area = p.area, s.radius = p.radius, s.hasBack = p.hasBack;
    s.extent = p.extent;
  });
  RadiosityEngine::Settings first;
  first.cached = false, first.indirect = false, first.rays = direct.rays;
  bake(RadiosityEngine(world, first), pieces, front, back);
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
  RadiosityEngine::Settings next = first;
  next.indirect = true, next.points = this;
  const RadiosityEngine engine(world, next);
  int most = 1;  // that any object allows
  for (const Attributes& attributes : world.scene().attributes)
    most = std::max(most, attributes.maxDiffuseDepth);
  for (int bounce = 1; bounce < std::min(settings.bounces, most) && !world.interrupted(); ++bounce) {
    bake(engine, pieces, front, back);
    hand();
  }
  setStatistic("Memory/points MB", static_cast<double>(tree_->memory()) / 1048576);
  setStatistic("Points/micropolygons along a surfel", step);
}

/// Radiance of both sides. The same for any number of threads: pieces are shaded in batches of fixed ones.
void BakedPoints::bake(const RadiosityEngine& engine, const std::vector<Piece>& pieces,
                       std::vector<Rgb>& front, std::vector<Rgb>& back) const {
  tbb::parallel_for(size_t{0}, (pieces.size() + kBatch - 1) / kBatch, [&](size_t batch) {
    if (world_.interrupted()) return;
    const size_t begin = batch * kBatch, end = std::min(pieces.size(), begin + kBatch);
    std::vector<RadiosityEngine::Request> requests;
    std::vector<std::pair<size_t, bool>> of;
    for (size_t k = begin; k < end; ++k)
      for (const bool side : {true, false}) {
        const Piece& p = pieces[k];
        if (!side && !p.hasBack) continue;
        const ShadingPoint point = world_.shading().at(p.placement, p.face, p.u, p.v, side, p.size);
        const uint64_t seed = hashOf(world_.geometry().placements()[p.placement].seed, p.face,
                                     uint64_t{floatBits(p.u)} << 32 | floatBits(p.v), side) ^
                              world_.frameSeed();
        requests.push_back({point, seed, engine.bouncesAt(p.placement)});
        of.emplace_back(k, side);
      }
    std::vector<Rgb> radiance(requests.size());
    // As deep as what gathers meet: with as many rays to lights as the finest vertices there get.
    engine.shade(requests, 1, Purpose::Vertex, radiance);
    shadedCount += static_cast<int64_t>(requests.size());
    for (size_t i = 0; i < of.size(); ++i) (of[i].second ? front : back)[of[i].first] = radiance[i];
  });
}

PointRaster::Estimate BakedPoints::irradiance(const ShadingPoint& point, bool behind, uint64_t seed,
                                              bool withSurfels) const {
  const TimeShare share(rasterTime);
  thread_local std::unique_ptr<PointRaster> raster;
  thread_local PointRaster::Settings made;
  if (!raster || made.resolution != settings_.raster.resolution ||
      made.maxSolidAngle != settings_.raster.maxSolidAngle) {
    raster = std::make_unique<PointRaster>(settings_.raster);
    made = settings_.raster;
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
  return raster->gather(*tree_, point.P, behind ? -point.N : point.N, turn, kErrors * point.error,
                        list.smooth ? sky : PointRaster::Environment(), withSurfels);
}

}  // namespace patina
