// SPDX-License-Identifier: Apache-2.0
// Direct light, the gather, and the radiosity of points.
#include "renderer/integrators/radiosity_engine.h"

#include <array>

#include "renderer/base/statistics.h"
#include "renderer/integrators/radiosity_workspace.h"

namespace patina {
namespace {

STAT_COUNTER("Radiosity/points shaded from the cache's vertices", vertexPoints);
STAT_COUNTER("Radiosity/points shaded at hits", hitPoints);
STAT_COUNTER("Radiosity/gather rays", gatherRays);

// Random numbers at a point.
enum Stream : uint64_t {
  kGatherStream = 1,
  kBackGatherStream,
  kRouletteStream,
  kChildStream,
  kTimeStream,
  kLightStream = 16
};

constexpr int kFineShare = 8;
constexpr int kRouletteDepth = RadiosityEngine::kCachedDepths;

}  // namespace

int RayBudget::diffuse(int depth, Purpose purpose) const {
  if (purpose == Purpose::Ray) return 1;
  if (depth == 0) return diffuse0;
  const int whole = std::max(depth == 1 ? 4 : 2, diffuse0 >> (depth == 1 ? 3 : depth == 2 ? 4 : 5));
  return purpose == Purpose::Vertex ? whole : std::max(1, whole / kFineShare);
}

int RayBudget::light(int depth, Purpose purpose) const {
  if (purpose == Purpose::Ray) return 1;
  if (depth == 0) return light0;
  const int whole = std::max(1, light0 >> (depth == 1 ? 2 : 3));
  return purpose == Purpose::Vertex ? whole : std::max(1, whole / kFineShare);
}

RadiosityEngine::RadiosityEngine(const World& world, const Settings& settings)
    : world_(world), settings_(settings) {
  if (settings.cached) cache_ = std::make_unique<PatchCache>(settings.cacheBytes);
}

RadiosityEngine::Workspace& RadiosityEngine::workspace(int nesting) const {
  thread_local std::vector<std::unique_ptr<Workspace>> workspaces;
  while (workspaces.size() <= static_cast<size_t>(nesting))
    workspaces.push_back(std::make_unique<Workspace>());
  return *workspaces[static_cast<size_t>(nesting)];
}

void RadiosityEngine::shade(std::span<const Request> requests, int depth, Purpose purpose,
                            std::span<Rgb> out) const {
  hitPoints += static_cast<int64_t>(requests.size());
  shadeNested(requests, depth, purpose, out, 0);
}

void RadiosityEngine::shadeNested(std::span<const Request> requests, int depth, Purpose purpose,
                                  std::span<Rgb> out, int nesting) const {
  Workspace& w = workspace(nesting);
  w.points.clear();
  for (const Request& request : requests) w.points.push_back(request.point);
  world_.shading().shade(w.points, ShadingParts::Radiosity, w.shaded);
  w.front.assign(requests.size(), Rgb(0, 0, 0));
  w.back.assign(requests.size(), Rgb(0, 0, 0));
  w.extra.assign(requests.size(), Rgb(0, 0, 0));
  world_.addAmbient(w.points, w.shaded.terms, w.extra);
  addDirect(requests, depth, purpose, w);
  addIndirect(requests, depth, purpose, w, nesting);
  for (size_t i = 0; i < requests.size(); ++i) {
    const SurfaceTerms& terms = w.shaded.terms[i];
    out[i] = terms.emission + w.extra[i] +
             (terms.reflectance * w.front[i] + terms.transmittance * w.back[i]) * kInvPi;
  }
}

void RadiosityEngine::addDirect(std::span<const Request> requests, int depth, Purpose purpose,
                                Workspace& w) const {
  const Lights& lights = world_.lights();
  for (uint32_t light = 0; light < lights.count(); ++light) {
    w.which.clear();
    for (uint32_t i = 0; i < requests.size(); ++i) {
      const SurfaceTerms& terms = w.shaded.terms[i];
      if (isBlack(terms.reflectance) && isBlack(terms.transmittance)) continue;
      const std::vector<uint32_t>& sampled = world_.lightsOf(w.points[i].placement).sampled;
      if (std::binary_search(sampled.begin(), sampled.end(), light)) w.which.push_back(i);
    }
    if (w.which.empty()) continue;
    // Shadows that are blurred by motion are sampled over time.
    const bool one = lights.isDelta(light) && !world_.geometry().samplesMotion();
    const int count = one ? 1 : settings_.rays.light(depth, purpose);
    w.positions.clear(), w.random.clear();
    for (const uint32_t i : w.which)
      for (int k = 0; k < count; ++k) {
        w.positions.push_back(w.points[i].P);
        w.random.push_back(sobol2(static_cast<uint32_t>(k), hashOf(requests[i].seed, kLightStream, light)));
      }
    w.lightSamples.resize(w.positions.size());
    lights.sample(light, w.positions, w.random, w.lightSamples);
    const float weight = 1 / static_cast<float>(count);
    for (size_t k = 0; k < w.lightSamples.size(); ++k) {
      const LightSample& s = w.lightSamples[k];
      if (s.pdf == 0) continue;
      const uint32_t i = w.which[k / static_cast<size_t>(count)];
      const ShadingPoint& point = w.points[i];
      const SurfaceTerms& terms = w.shaded.terms[i];
      const bool above = s.direction.dot(point.Ng) > 0;
      if (isBlack(above ? terms.reflectance : terms.transmittance)) continue;
      const float side = above ? 1.0f : -1.0f;
      const float cosine = s.delta ? s.direction.dot(point.N) * side
                                   : foldedCosine(s.direction, point.N * side, point.Ng * side);
      if (!(cosine > 0)) continue;
      const uint64_t seed = hashOf(requests[i].seed, kTimeStream, light, k % static_cast<size_t>(count));
      const Rgb visible =
          world_.transmittance(point.facet(), s, light, world_.rayTime(point.placement, seed));
      (above ? w.front : w.back)[i] += s.radiance * visible * (cosine * weight / s.pdf);
    }
  }
}

void RadiosityEngine::addIndirect(std::span<const Request> requests, int depth, Purpose purpose, Workspace& w,
                                  int nesting) const {
  if (world_.settings().classic) return;
  const Lights& lights = world_.lights();
  w.missFrom.clear(), w.missDirection.clear(), w.missOf.clear(), w.missWeight.clear();
  w.direct.clear(), w.directOf.clear(), w.directWeight.clear();
  for (uint32_t i = 0; i < requests.size(); ++i) {
    const ShadingPoint& point = w.points[i];
    const SurfaceTerms& terms = w.shaded.terms[i];
    const LightList& list = world_.lightsOf(point.placement);
    const bool bounce = settings_.indirect && depth < world_.attributesOf(point.placement).maxDiffuseDepth;
    if (!bounce && !list.smooth) continue;
    float roulette = 1;
    if (bounce && purpose == Purpose::Ray && depth > kRouletteDepth) {
      const float survive = std::clamp(
          std::max(maxComponent(terms.reflectance), maxComponent(terms.transmittance)), 0.05f, 0.95f);
      if (toUnit(static_cast<uint32_t>(hashOf(requests[i].seed, kRouletteStream) >> 32)) >= survive) continue;
      roulette = 1 / survive;
    }
    const int count = settings_.rays.diffuse(depth, purpose);
    const int spread = purpose == Purpose::Ray ? 4 : settings_.rays.diffuse(depth, Purpose::Vertex);
    for (const bool behind : {false, true}) {
      if (isBlack(behind ? terms.transmittance : terms.reflectance)) continue;
      const Frame frame(behind ? -point.N : point.N);
      const uint64_t seed = hashOf(requests[i].seed, behind ? kBackGatherStream : kGatherStream);
      // E = integral of L cos over the hemisphere; with density cos/pi a ray's weight is pi / count.
      const float weight = kPi * roulette / static_cast<float>(count);
      const uint32_t slot = 2 * i + (behind ? 1u : 0u);
      gatherRays += count;
      const V3f up = behind ? -point.Ng : point.Ng, origin = leave(point.facet(), up);
      for (int k = 0; k < count; ++k) {
        const V3f local = sampleCosineHemisphere(sobol2(static_cast<uint32_t>(k), seed));
        const V3f direction = foldDirection(frame.toWorld(local), up);
        const float solidAngle = kPi / (static_cast<float>(spread) * std::max(local.z, 0.05f));
        const uint64_t child = hashOf(seed, kChildStream, static_cast<uint32_t>(k));
        follow(GatherRay{origin, direction, std::sqrt(solidAngle), weight, slot, child,
                         world_.rayTime(point.placement, child)},
               bounce, depth, w, nesting);
      }
    }
  }
  // Light from the sky, a light at a time.
  const auto irradiance = [&](uint32_t slot) -> Rgb& { return (slot & 1u ? w.back : w.front)[slot / 2]; };
  for (const uint32_t light : lights.infinite()) {
    if (w.missFrom.empty() || !lights.isSmooth(light)) continue;
    w.missRadiance.resize(w.missFrom.size()), w.missPdf.resize(w.missFrom.size());
    lights.evaluate(light, w.missFrom, w.missDirection, w.missRadiance, w.missPdf);
    for (size_t k = 0; k < w.missOf.size(); ++k)
      if (world_.lightsOf(w.points[w.missOf[k] / 2].placement).sees(light))
        irradiance(w.missOf[k]) += w.missRadiance[k] * w.missWeight[k];
  }
  // Hits that the cache has no place for.
  if (w.direct.empty()) return;
  hitPoints += static_cast<int64_t>(w.direct.size());
  w.directRadiance.resize(w.direct.size());
  shadeNested(w.direct, depth + 1, Purpose::Ray, w.directRadiance, nesting + 1);
  for (size_t k = 0; k < w.direct.size(); ++k)
    irradiance(w.directOf[k]) += w.directRadiance[k] * w.directWeight[k];
}

/// One gather ray: adds what it finds to the workspace, at once where the cache knows it, else to a list.
void RadiosityEngine::follow(GatherRay ray, bool bounce, int depth, Workspace& w, int nesting) const {
  constexpr int kMostLayers = 256;
  Rgb share(1, 1, 1);
  float travelled = 0;
  for (int layer = 0; layer < kMostLayers; ++layer) {
    const Ray traced{ray.origin, ray.direction, 0, kInfinity, kDiffuseRay, ray.time};
    const Hit hit = world_.accel().intersect(traced);
    const Rgb weight = share * ray.weight;
    if (!hit.valid()) {
      w.missFrom.push_back(ray.origin), w.missDirection.push_back(ray.direction);
      w.missOf.push_back(ray.slot), w.missWeight.push_back(weight);
      return;
    }
    const bool opaque = world_.shading().isOpaque(hit.placement);
    if (!bounce && opaque) return;
    travelled += hit.t;
    const float footprint = ray.spread * travelled;
    const ShaderInstance& shader = world_.shading().shaderOf(hit.placement);
    const bool radiosity = shader.active(PATINA_ENTRY_RADIOSITY);
    const bool view = bounce && shader.active(PATINA_ENTRY_VIEW);
    if (bounce && radiosity) {
      Rgb radiance;
      if (cachedRadiance(hit, footprint, depth + 1, nesting, radiance)) {
        (ray.slot & 1u ? w.back : w.front)[ray.slot / 2] += radiance * weight;
      } else {
        w.direct.push_back({world_.shading().at(hit, ray.direction, footprint), ray.seed});
        w.directOf.push_back(ray.slot), w.directWeight.push_back(weight);
      }
    }
    if (opaque && !view) return;
    const ShadingPoint point = world_.shading().at(hit, ray.direction, footprint);
    if (view) {
      const Rgb specular =
          specularTail(point, hashOf(ray.seed, static_cast<uint32_t>(layer)), depth + 1, footprint, nesting);
      (ray.slot & 1u ? w.back : w.front)[ray.slot / 2] += specular * weight;
    }
    if (opaque) return;
    world_.shading().shade({&point, 1}, ShadingParts::Radiosity, w.layer);
    for (int c = 0; c < 3; ++c) share[c] *= std::clamp(1 - w.layer.terms[0].opacity[c], 0.0f, 1.0f);
    if (maxComponent(share) < 1e-4f) return;
    ray.origin = goOn(traced, hit, point.facet());
  }
}

RadiosityEngine::Request RadiosityEngine::vertexRequest(uint32_t index, bool front, Level level,
                                                        uint32_t vertex, int depth) const {
  const Patch& patch = world_.geometry().patches()[index];
  V2f uv = patch.toFace(patch.vertexPosition(level, vertex));
  // Neighbouring patches share vertices, and so they share random numbers.
  const uint64_t seed =
      hashOf(patch.placement, patch.face, uint64_t{floatBits(uv.x)} << 32 | floatBits(uv.y), front, depth);
  // A vertex on the rim of its face may lie in a corner, where half of its rays would start inside the other
  // wall: it is moved inwards by a part of a micropolygon.
  constexpr float kInset = 0.3f;
  if (patch.cellsU > 0) {
    const float du = kInset * std::abs(patch.du) / static_cast<float>(patch.cellsU);
    const float dv = kInset * std::abs(patch.dv) / static_cast<float>(patch.cellsV);
    if (patch.shape == FaceShape::Quad) {
      uv = {std::clamp(uv.x, du, 1 - du), std::clamp(uv.y, dv, 1 - dv)};
    } else {
      V3f b(1 - uv.x - uv.y, uv.x, uv.y);
      for (int k = 0; k < 3; ++k) b[k] = std::max(b[k], du);
      const float sum = b.x + b.y + b.z;
      uv = {b.y / sum, b.z / sum};
    }
  }
  return {world_.shading().at(patch.placement, patch.face, uv.x, uv.y, front, patch.spacingAt(level)), seed};
}

bool RadiosityEngine::blocked(const ShadingPoint& a, const ShadingPoint& b) const {
  // Just above the surface, and above the dust on it.
  constexpr float kLift = 0.02f;
  const float lift = kLift * (b.P - a.P).length();
  const V3f from = a.P + a.Ng * (lift + a.error), to = b.P + b.Ng * (lift + b.error);
  const Hit hit = world_.accel().intersect({from, to - from, 0, 1, kDiffuseRay});
  if (!hit.valid()) return false;
  // The chord of a curved surface runs inside of it.
  return hit.placement != a.placement ||
         world_.geometry().surface(world_.geometry().placements()[a.placement]).isFlat();
}

bool RadiosityEngine::separated(uint32_t patch, bool front, const VertexWeights& around) const {
  if (around.count < 3) return false;
  ShadingPoint p[4];
  for (int k = 0; k < around.count; ++k)
    p[k] = vertexRequest(patch, front, Level::Fine, around.index[k], 0).point;
  if (around.count == 4) return blocked(p[0], p[3]) || blocked(p[1], p[2]);
  return blocked(p[0], p[1]) || blocked(p[0], p[2]) || blocked(p[1], p[2]);
}

void RadiosityEngine::fill(uint32_t index, bool front, Level level, int depth, int nesting,
                           std::vector<uint64_t>& codes) const {
  Workspace& w = workspace(nesting);
  const Patch& patch = world_.geometry().patches()[index];
  const uint32_t count = patch.vertexCount(level);
  w.fillRequests.clear();
  for (uint32_t k = 0; k < count; ++k) w.fillRequests.push_back(vertexRequest(index, front, level, k, depth));
  codes.assign(count, 0);
  if (count > 1) {
    // Cells that something stands in are left to the finer level, or to shading at the hit.
    patch.forEachDiagonal(level, [&](uint32_t a, uint32_t b) {
      if (blocked(w.fillRequests[a].point, w.fillRequests[b].point))
        codes[a] = codes[b] = PackedRgb::kMissing;
    });
    uint32_t kept = 0;
    for (uint32_t k = 0; k < count; ++k)
      if (codes[k] != PackedRgb::kMissing) w.fillRequests[kept++] = w.fillRequests[k];
    w.fillRequests.resize(kept);
  }
  w.fillRadiance.resize(w.fillRequests.size());
  vertexPoints += static_cast<int64_t>(w.fillRequests.size());
  // The finest groups of faces are like fine vertices: many are met, and each of them seldom.
  const Purpose purpose = patch.group == 1 ? Purpose::FineVertex : Purpose::Vertex;
  if (!w.fillRequests.empty()) shadeNested(w.fillRequests, depth, purpose, w.fillRadiance, nesting + 1);
  for (uint32_t k = 0, made = 0; k < count; ++k)
    if (codes[k] != PackedRgb::kMissing) codes[k] = PackedRgb::pack(w.fillRadiance[made++]);
}

void RadiosityEngine::fineVertices(uint32_t index, bool front, const VertexWeights& around, int depth,
                                   int nesting, uint64_t codes[4]) const {
  CacheStatistics& statistics = cacheStatistics(Level::Fine, depth);
  ++statistics.lookups;
  uint32_t inBlock[4];
  const uint8_t block = world_.geometry().patches()[index].blockOf(around, inBlock);
  const CacheKey key{index, front, static_cast<uint8_t>(depth), block};
  const auto count = static_cast<size_t>(around.count);
  if (!cache_->find(key, Level::Fine, {inBlock, count}, codes))
    std::fill(codes, codes + count, PackedRgb::kMissing);
  Workspace& w = workspace(nesting);
  w.fillRequests.clear();
  std::array<size_t, 4> missing;
  for (size_t k = 0; k < count; ++k)
    if (codes[k] == PackedRgb::kMissing) {
      missing[w.fillRequests.size()] = k;
      w.fillRequests.push_back(vertexRequest(index, front, Level::Fine, around.index[k], depth));
    }
  const size_t made = w.fillRequests.size();
  if (made == 0) {
    ++statistics.hits;
    return;
  }
  ++statistics.misses;
  vertexPoints += static_cast<int64_t>(made);
  w.fillRadiance.resize(made);
  shadeNested(w.fillRequests, depth, Purpose::FineVertex, w.fillRadiance, nesting + 1);
  std::array<uint64_t, kMaxBlockVertices> kept;
  kept.fill(PackedRgb::kMissing);
  for (size_t k = 0; k < made; ++k)
    kept[inBlock[missing[k]]] = codes[missing[k]] = PackedRgb::pack(w.fillRadiance[k]);
  cache_->store(key, Level::Fine, kept);
}

bool RadiosityEngine::cachedRadiance(const Hit& hit, float footprint, int depth, int nesting,
                                     Rgb& out) const {
  if (!cache_ || depth > kCachedDepths) return false;
  const PatchTable& patches = world_.geometry().patches();
  uint32_t index = patches.find(hit.placement, hit.face, hit.u, hit.v);
  if (world_.shading().shaderOf(hit.placement).has(PATINA_TRAIT_NOT_CACHEABLE)) return false;
  // The coarsest level whose vertices lie as close as the ray is wide, and closer than the ray is long.
  Level level = Level::Coarse;
  const float widest = std::min(footprint * settings_.levelScale, hit.t);
  // Groups of faces have one value each: their levels are the groups that they are in.
  if (patches[index].group > 0)
    for (uint32_t next = patches.coarser(index); next != kNone && patches[next].spacing <= widest;
         next = patches.coarser(index))
      index = next;
  const Patch& patch = patches[index];
  if (patch.spacing > widest) return false;
  // The finest groups are so many that a ray seldom finds one that another has made: they pay only where
  // their values save further bounces.
  if (patch.group == 1 && depth >= world_.attributesOf(hit.placement).maxDiffuseDepth) return false;
  while (patch.spacingAt(level) > widest) level = static_cast<Level>(static_cast<int>(level) + 1);
  const V2f local = patch.toLocal(hit.u, hit.v);
  const CacheKey key{index, hit.front, static_cast<uint8_t>(depth)};
  for (;; level = static_cast<Level>(static_cast<int>(level) + 1)) {
    const Level stored = patch.canonical(level);
    const VertexWeights around = patch.locate(stored, local.x, local.y);
    std::array<uint64_t, 4> codes;
    if (stored == Level::Fine) {
      fineVertices(index, hit.front, around, depth, nesting, codes.data());
    } else {
      CacheStatistics& statistics = cacheStatistics(stored, depth);
      ++statistics.lookups;
      const std::span<const uint32_t> wanted(around.index, static_cast<size_t>(around.count));
      if (cache_->find(key, stored, wanted, codes.data())) {
        ++statistics.hits;
      } else {
        ++statistics.misses;
        std::vector<uint64_t>& all = workspace(nesting).fillCodes;
        fill(index, hit.front, stored, depth, nesting, all);
        cache_->store(key, stored, all);
        for (size_t k = 0; k < wanted.size(); ++k) codes[k] = all[wanted[k]];
      }
    }
    bool whole = true;
    for (int k = 0; k < around.count; ++k) whole &= codes[static_cast<size_t>(k)] != PackedRgb::kMissing;
    if (!whole) {  // something stands in the cell
      if (level == Level::Fine) return false;
      continue;
    }
    out = Rgb(0, 0, 0);
    for (int k = 0; k < around.count; ++k)
      out += PackedRgb::unpack(codes[static_cast<size_t>(k)]) * around.weight[k];
    return true;
  }
}

void RadiosityEngine::vertices(std::span<const Vertex> wanted, std::span<Rgb> out) const {
  Workspace& w = workspace(0);
  w.fillRequests.clear();
  w.vertexOf.clear();
  for (uint32_t k = 0; k < wanted.size(); ++k) {
    const Vertex& v = wanted[k];
    if (cache_) {
      CacheStatistics& statistics = cacheStatistics(Level::Fine, 0);
      ++statistics.lookups;
      const BlockVertex at = world_.geometry().patches()[v.patch].blockOf(v.index);
      const uint32_t index = at.index;
      uint64_t code;
      if (cache_->find({v.patch, v.front, 0, at.block}, Level::Fine, {&index, 1}, &code) &&
          code != PackedRgb::kMissing) {
        ++statistics.hits;
        out[k] = PackedRgb::unpack(code);
        continue;
      }
      ++statistics.misses;
    }
    w.fillRequests.push_back(vertexRequest(v.patch, v.front, Level::Fine, v.index, 0));
    w.vertexOf.push_back(k);
  }
  vertexPoints += static_cast<int64_t>(w.fillRequests.size());
  w.fillRadiance.resize(w.fillRequests.size());
  constexpr size_t kBatch = 512;
  for (size_t first = 0; first < w.fillRequests.size(); first += kBatch) {
    const size_t n = std::min(kBatch, w.fillRequests.size() - first);
    shadeNested(std::span(w.fillRequests).subspan(first, n), 0, Purpose::Vertex,
                std::span(w.fillRadiance).subspan(first, n), 1);
  }
  // A value is what its code says, whether it was found or made.
  w.fillCodes.clear();
  for (size_t k = 0; k < w.vertexOf.size(); ++k) {
    w.fillCodes.push_back(PackedRgb::pack(w.fillRadiance[k]));
    out[w.vertexOf[k]] = PackedRgb::unpack(w.fillCodes.back());
  }
  if (!cache_) return;
  // Kept by block, with the vertices that were not asked for marked as missing.
  w.blocks.clear();
  for (const uint32_t k : w.vertexOf)
    w.blocks.push_back(world_.geometry().patches()[wanted[k].patch].blockOf(wanted[k].index));
  w.order.resize(w.vertexOf.size());
  for (uint32_t k = 0; k < w.order.size(); ++k) w.order[k] = k;
  const auto keyOf = [&](uint32_t k) {
    const Vertex& v = wanted[w.vertexOf[k]];
    return uint64_t{v.patch} << 5 | uint64_t{v.front} << 4 | w.blocks[k].block;
  };
  std::sort(w.order.begin(), w.order.end(), [&](uint32_t a, uint32_t b) { return keyOf(a) < keyOf(b); });
  std::array<uint64_t, kMaxBlockVertices> codes;
  for (size_t begin = 0; begin < w.order.size();) {
    const uint32_t first = w.order[begin];
    const Vertex& v = wanted[w.vertexOf[first]];
    codes.fill(PackedRgb::kMissing);
    size_t end = begin;
    for (; end < w.order.size() && keyOf(w.order[end]) == keyOf(first); ++end)
      codes[w.blocks[w.order[end]].index] = w.fillCodes[w.order[end]];
    cache_->store({v.patch, v.front, 0, w.blocks[first].block}, Level::Fine, codes);
    begin = end;
  }
}

}  // namespace patina
