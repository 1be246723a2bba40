// SPDX-License-Identifier: Apache-2.0
// Radiosity of points and vertices, and their direct light.
#include "renderer/integrators/radiosity_engine.h"

#include <tbb/global_control.h>

#include <numeric>
#include <tuple>

#include "renderer/base/statistics.h"
#include "renderer/integrators/radiosity_workspace.h"

namespace patina {
namespace {

STAT_COUNTER("Radiosity/points shaded from the cache's vertices", vertexPoints);
STAT_COUNTER("Radiosity/points shaded at hits", hitPoints);

/// Vertices of the fine level send an eighth of the rays of those of the coarse level in a large patch.
constexpr int shift(Purpose purpose) {
  return purpose == Purpose::HalfVertex      ? 1
         : purpose == Purpose::QuarterVertex ? 2
         : purpose == Purpose::FineVertex    ? 3
                                             : 0;
}
/// Rays of a truth whose look-ups the cache answers: more of them, corrected less often, cost less for the
/// same variance than one that is always followed.
constexpr int kTruthRays = 4;

}  // namespace

int RayBudget::diffuse(int depth, Purpose purpose) const {
  if (purpose == Purpose::Truth && depth < RadiosityEngine::kCachedDepths) return kTruthRays;
  if (isRay(purpose)) return 1;
  if (purpose == Purpose::Sample) return std::max(1, (diffuse0 + samples / 2) / samples);
  if (purpose == Purpose::Part)
    return std::max(1, diffuse0 * kPartsWorth / std::clamp(samples, kPartsWorth, kParts));
  if (depth == 0) return diffuse0;
  const int whole = std::max(depth == 1 ? 4 : 2, diffuse0 >> (depth == 1 ? 3 : depth == 2 ? 4 : 5));
  return std::max(1, whole >> shift(purpose));
}

int RayBudget::light(int depth, Purpose purpose) const {
  if (isRay(purpose)) return 1;
  if (purpose == Purpose::Sample) return std::max(1, (light0 + samples / 2) / samples);
  if (purpose == Purpose::Part)
    return std::max(1, light0 * kPartsWorth / std::clamp(samples, kPartsWorth, kParts));
  if (depth == 0) return light0;
  const int whole = std::max(1, light0 >> (depth == 1 ? 2 : 3));
  return std::max(1, whole >> shift(purpose));
}

RadiosityEngine::RadiosityEngine(const World& world, const Settings& settings)
    : world_(world), settings_(settings) {
  for (const Attributes& attributes : world.scene().attributes)
    mostBounces_ = std::max(mostBounces_, attributes.maxDiffuseDepth);
  isAlone_ = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism) == 1;
  if (!settings.cached) return;
  cache_ = std::make_unique<PatchCache>(settings.cacheBytes);
  opacityCache_ = std::make_unique<OpacityCache>(world.geometry(), world.shading(), settings.opacityBytes);
}

RadiosityEngine::Workspace& RadiosityEngine::workspace(int nesting) const {
  thread_local std::vector<std::unique_ptr<Workspace>> workspaces;
  while (workspaces.size() <= static_cast<size_t>(nesting))
    workspaces.push_back(std::make_unique<Workspace>());
  return *workspaces[static_cast<size_t>(nesting)];
}

size_t RadiosityEngine::raysAtOnce() const {
  // Enough that few calls of shaders and look-ups are for a handful of points, and little enough for a cache
  // of megabytes. Where facets go and come back a batch has each made once, and so it had better be larger.
  return world_.geometry().tessellations().isTight() ? size_t{1} << 16 : size_t{1} << 12;
}

size_t RadiosityEngine::pointsAtOnce(int raysOfEach) const {
  return std::clamp(raysAtOnce() / static_cast<size_t>(std::max(raysOfEach, 1)), size_t{256}, size_t{8192});
}

void RadiosityEngine::shade(std::span<const Request> requests, int depth, Purpose purpose, std::span<Rgb> out,
                            std::span<const Spot> spots) const {
  hitPoints += static_cast<int64_t>(requests.size());
  const size_t batch = pointsAtOnce(settings_.rays.diffuse(depth, purpose));
  for (size_t first = 0; first < requests.size(); first += batch) {
    const size_t n = std::min(batch, requests.size() - first);
    shadeNested(requests.subspan(first, n), depth, purpose, out.subspan(first, n), 0,
                spots.empty() ? spots : spots.subspan(first, n));
  }
}

void RadiosityEngine::indirect(std::span<const Request> requests, Purpose purpose,
                               std::span<Irradiance> out) const {
  Workspace& w = workspace(0);
  const size_t batch = pointsAtOnce(settings_.rays.diffuse(0, purpose));
  for (size_t first = 0; first < requests.size(); first += batch) {
    const size_t n = std::min(batch, requests.size() - first);
    prepare(requests.subspan(first, n), w);
    addIndirect(requests.subspan(first, n), 0, purpose, w, 0, {});
    std::copy_n(w.indirect.begin(), n, out.begin() + static_cast<std::ptrdiff_t>(first));
  }
}

void RadiosityEngine::prepare(std::span<const Request> requests, Workspace& w) const {
  w.points.clear();
  for (const Request& request : requests) w.points.push_back(request.point);
  world_.shading().shade(w.points, ShadingParts::Radiosity, w.shaded);
  w.front.assign(requests.size(), Rgb(0, 0, 0));
  w.back.assign(requests.size(), Rgb(0, 0, 0));
  w.extra.assign(requests.size(), Rgb(0, 0, 0));
  w.indirect.assign(requests.size(), {});
}

void RadiosityEngine::shadeNested(std::span<const Request> requests, int depth, Purpose purpose,
                                  std::span<Rgb> out, int nesting, std::span<const Spot> spots) const {
  Workspace& w = workspace(nesting);
  prepare(requests, w);
  world_.addAmbient(w.points, w.shaded.terms, w.extra);
  addDirect(requests, depth, purpose, w);
  addIndirect(requests, depth, purpose, w, nesting, spots);
  for (size_t i = 0; i < requests.size(); ++i) {
    const SurfaceTerms& terms = w.shaded.terms[i];
    out[i] = terms.emission + w.extra[i] +
             (terms.reflectance * (w.front[i] + w.indirect[i].front) +
              terms.transmittance * (w.back[i] + w.indirect[i].back)) *
                 kInvPi;
  }
}

ShadingPoint RadiosityEngine::pointAt(uint32_t index, bool front, Level level, V2f uv) const {
  const Patch& patch = world_.geometry().patches()[index];
  return world_.shading().at(patch.placement, patch.face, uv.x, uv.y, front, patch.spacingAt(level));
}

ShadingPoint RadiosityEngine::cornerAt(uint32_t index, bool front, Level level, uint32_t vertex) const {
  const Patch& patch = world_.geometry().patches()[index];
  const V2f uv = patch.toFace(patch.vertexPosition(level, vertex));
  // A vertex on the rim of its face may lie in a corner, where half of its rays would start inside the other
  // wall: it is moved inwards by a part of a micropolygon.
  constexpr float kInset = 0.3f;
  if (patch.cellsU == 0) return pointAt(index, front, level, uv);
  const float du = kInset * std::abs(patch.du) / static_cast<float>(patch.cellsU);
  const float dv = kInset * std::abs(patch.dv) / static_cast<float>(patch.cellsV);
  if (patch.shape == FaceShape::Quad)
    return pointAt(index, front, level, {std::clamp(uv.x, du, 1 - du), std::clamp(uv.y, dv, 1 - dv)});
  V3f b(1 - uv.x - uv.y, uv.x, uv.y);
  for (int k = 0; k < 3; ++k) b[k] = std::max(b[k], du);
  const float sum = b.x + b.y + b.z;
  return pointAt(index, front, level, {b.y / sum, b.z / sum});
}

RadiosityEngine::Request RadiosityEngine::vertexRequest(uint32_t index, bool front, Level level,
                                                        uint32_t vertex, int depth,
                                                        uint8_t keptBounces) const {
  const Patch& patch = world_.geometry().patches()[index];
  const V2f uv = patch.toFace(patch.vertexPosition(level, vertex));
  // Neighbouring patches share vertices, and so they share random numbers.
  const uint64_t seed = hashOf(world_.geometry().placements()[patch.placement].seed, patch.face,
                               uint64_t{floatBits(uv.x)} << 32 | floatBits(uv.y), front, depth) ^
                        world_.frameSeed();
  const int bounces = keptBounces < kMostKept ? keptBounces : std::max(kMostKept, mostBounces_ - depth);
  const bool isCentroid = level != Level::Fine && depth > 0;
  return {isCentroid ? pointAt(index, front, level, patch.toFace(patch.vertexCentroid(level, vertex)))
                     : cornerAt(index, front, level, vertex),
          seed, bounces, 0};
}

void RadiosityEngine::vertices(std::span<const Vertex> wanted, std::span<Rgb> out,
                               std::span<Irradiance> indirect) const {
  Workspace& w = workspace(0);
  if (cache_) {
    w.waiting.clear(), w.vertexOf.clear();
    for (uint32_t k = 0; k < wanted.size(); ++k) {
      const Vertex& v = wanted[k];
      CacheStatistics& statistics = cacheStatistics(Level::Fine, 0);
      ++statistics.lookups;
      const BlockVertex at = world_.geometry().patches()[v.patch].blockOf(v.index);
      const uint32_t index = at.index;
      Waiting x;
      x.patch = v.patch, x.front = v.front, x.level = x.stored = Level::Fine, x.block = at.block;
      x.bounces = v.bounces, x.counted = false;
      x.around.count = 1, x.around.index[0] = v.index, x.inBlock[0] = index;
      survey(x, 0);
      uint64_t code;
      if (cache_->find({v.patch, v.front, 0, at.block, v.bounces}, Level::Fine, {&index, 1}, &code) &&
          code != PackedRgb::kMissing) {
        ++statistics.hits;
        out[k] = PackedRgb::unpack(code);
        continue;
      }
      x.codes.fill(PackedRgb::kMissing);
      w.waiting.push_back(x);
      w.vertexOf.push_back(k);
    }
    make(w.waiting, 0, 0);
    for (size_t i = 0; i < w.waiting.size(); ++i) {
      const uint64_t code = w.waiting[i].codes[0];
      out[w.vertexOf[i]] = code == PackedRgb::kMissing ? Rgb(0, 0, 0) : PackedRgb::unpack(code);
    }
    return;
  }
  w.order.resize(wanted.size());
  std::iota(w.order.begin(), w.order.end(), 0u);
  std::sort(w.order.begin(), w.order.end(), [&](uint32_t a, uint32_t b) {
    const Vertex &x = wanted[a], &y = wanted[b];
    return std::tuple(x.patch, x.front, x.index, x.bounces) <
           std::tuple(y.patch, y.front, y.index, y.bounces);
  });
  const size_t batch = pointsAtOnce(settings_.rays.diffuse(0, Purpose::Vertex));
  for (size_t first = 0; first < w.order.size(); first += batch) {
    const size_t n = std::min(batch, w.order.size() - first);
    w.fillRequests.clear();
    for (size_t i = first; i < first + n; ++i) {
      const Vertex& v = wanted[w.order[i]];
      w.fillRequests.push_back(vertexRequest(v.patch, v.front, Level::Fine, v.index, 0, v.bounces));
    }
    vertexPoints += static_cast<int64_t>(n);
    w.fillRadiance.resize(n);
    shadeNested(w.fillRequests, 0, Purpose::Vertex, w.fillRadiance, 1);
    // Rounded as the cache rounds: a picture without it differs by what the cache does, not by its format.
    for (size_t i = 0; i < n; ++i)
      out[w.order[first + i]] = PackedRgb::unpack(PackedRgb::pack(w.fillRadiance[i]));
    if (indirect.empty()) continue;
    for (size_t i = 0; i < n; ++i) indirect[w.order[first + i]] = workspace(1).indirect[i];
  }
}

}  // namespace patina
