// SPDX-License-Identifier: Apache-2.0
// Modes radiosity, distribution and direct: distribution ray tracing from the camera. View-independent light
// is computed at micropolygon vertices and shared by all samples (PixelSamples do not multiply it); lobes are
// evaluated at each hit.
#include <unordered_map>

#include "renderer/base/statistics.h"
#include "renderer/integrators/integrator.h"
#include "renderer/integrators/radiosity_engine.h"

namespace patina {
namespace {

STAT_COUNTER("Camera/samples", sampleCount);
STAT_COUNTER("Camera/hits shaded", hitCount);
STAT_COUNTER("Camera/vertices asked for", vertexCount);

constexpr size_t kWave = 16384;  // camera samples in work at a time
constexpr int kMostSteps = 512;  // layers and specular bounces of a sample

enum Dimension : uint32_t {
  kLobe = 0x1000,
  kDirection = 0x2000,
  kLightChoice = 0x3000,
  kLightPoint = 0x4000,
  kPoint = 0x5000,
  kTime = 0x6000
};

/// A camera sample on its way through transparent layers and specular surfaces.
struct Walk {
  uint32_t slot = 0;
  uint32_t sample = 0;
  uint64_t frame = 0;  // World::frameSeed()
  int x = 0, y = 0;
  Ray ray;
  Rgb throughput{1, 1, 1};
  float footprint = 0, spread = 0;
  V3f from{0, 0, 0};
  float pdf = 0;  // of a specular direction; 0 = camera ray or delta lobe
  uint32_t receiver = kNone;
  bool sampledLights = false;
  int specularDepth = 0, maxSpecular = 1 << 20;
  int bounces = RadiosityEngine::kManyBounces;  // diffuse ones that may still follow
  uint32_t step = 0;
  float roughness = 0;  // the largest on the way
  uint64_t seed(uint32_t dimension) const { return pixelSeed(frame, x, y, dimension + step); }
};

struct Result {
  Rgb radiance{0, 0, 0};
  Rgb seen{0, 0, 0};  // opacity
  float depth = kFarDepth;
  bool matte = false;
};

uint64_t keyOf(const RadiosityEngine::Vertex& v) {
  return uint64_t{v.patch} << 17 | uint64_t{v.front} << 16 | uint64_t{v.bounces} << 12 | v.index;
}

/// The vertices of a tile that is rendered in parts, where no cache keeps them: B by keyOf().
struct TileVertices final : TileMemory {
  std::unordered_map<uint64_t, Rgb> radiance;
};

class RadiosityIntegrator final : public Integrator {
 public:
  RadiosityIntegrator(const World& world, const RadiosityEngine::Settings& settings)
      : world_(world), engine_(world, settings), cached_(settings.cached) {}
  void render(FilmTile& tile, SampleRange samples, TileMemory* memory) const override;
  std::unique_ptr<TileMemory> remember() const override {
    return cached_ ? nullptr : std::make_unique<TileVertices>();
  }
  void finish() const override { engine_.report(); }

 private:
  struct Wave {
    std::vector<Walk> walks, next;
    std::vector<Result> results;
    std::vector<V2f> positions;
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    std::vector<uint32_t> active;  // indices of walks that hit something
    std::vector<ShadingPoint> points;
    std::vector<Rgb> radiosity, direct;
    ShadedPoints shaded;
    // Vertices
    std::unordered_map<uint64_t, uint32_t> known;
    std::unordered_map<uint64_t, uint32_t> cellOf;  // index of cells
    std::vector<RadiosityEngine::Cell> cells;
    std::vector<uint64_t> cellKeys;
    std::vector<uint8_t> separated;                      // by cell
    std::vector<std::pair<uint32_t, uint32_t>> inCells;  // points, and their cells
    std::vector<RadiosityEngine::Vertex> vertices;
    TileVertices* kept = nullptr;
    std::vector<Rgb> values;
    std::vector<VertexWeights> around;
    std::vector<uint32_t> byHit;  // points that are shaded at the hit
    // Groups of small faces and their sides, and parts of pixels: the point that is shaded there and the
    // chance that chose it; and the points that share its value.
    std::unordered_map<uint64_t, std::pair<uint64_t, uint32_t>> met;
    struct Shares {
      uint32_t point;
      uint64_t key;
      bool part;  // of a pixel
    };
    std::vector<Shares> sharing;
    std::vector<uint32_t> parts;               // points that are shaded for a part of a pixel
    std::unordered_map<uint64_t, Rgb> inCell;  // B that parts of pixels share in all waves of a tile
    std::vector<RadiosityEngine::Request> requests;
  };
  void step(Wave& wave) const;
  void missed(Wave& wave, const Walk& walk) const;
  void viewIndependent(Wave& wave) const;
  void vertexValues(Wave& wave) const;
  void specularDirect(Wave& wave) const;
  bool proceed(Wave& wave, size_t i, Walk& walk) const;

  const World& world_;
  RadiosityEngine engine_;
  bool cached_;
};

void RadiosityIntegrator::render(FilmTile& tile, SampleRange samples, TileMemory* memory) const {
  const PixelRect& pixels = tile.samplePixels();
  const size_t pixelCount = static_cast<size_t>(pixels.width()) * static_cast<size_t>(pixels.height());
  const auto perWave =
      static_cast<uint32_t>(std::clamp<size_t>(kWave / std::max<size_t>(pixelCount, 1), 1, samples.end));
  thread_local Wave wave;
  wave.inCell.clear();
  wave.kept = static_cast<TileVertices*>(memory);
  for (uint32_t first = samples.first; first < samples.end && !world_.interrupted(); first += perWave) {
    const uint32_t end = std::min(samples.end, first + perWave);
    wave.walks.clear(), wave.positions.clear();
    wave.results.assign(pixelCount * (end - first), Result{});
    for (int y = pixels.y0; y < pixels.y1; ++y)
      for (int x = pixels.x0; x < pixels.x1; ++x)
        for (uint32_t s = first; s < end; ++s) {
          const CameraSample camera = cameraSample(world_, x, y, s);
          Walk walk{};
          walk.slot = static_cast<uint32_t>(wave.walks.size());
          walk.sample = s, walk.frame = world_.frameSeed(), walk.x = x, walk.y = y;
          walk.ray = camera.ray;
          walk.throughput = Rgb(1, 1, 1);
          walk.footprint = camera.camera.footprintAtOrigin, walk.spread = camera.camera.footprintSpread;
          walk.receiver = kNone, walk.maxSpecular = 1 << 20;
          wave.results[walk.slot].depth = camera.camera.depthPerT;
          wave.walks.push_back(walk);
          wave.positions.emplace_back(camera.x, camera.y);
        }
    sampleCount += static_cast<int64_t>(wave.walks.size());
    while (!wave.walks.empty()) step(wave);
    for (size_t k = 0; k < wave.positions.size(); ++k) {
      const Result& r = wave.results[k];
      const float alpha = std::clamp((r.seen.x + r.seen.y + r.seen.z) / 3, 0.0f, 1.0f);
      addSample(tile, wave.positions[k], {r.radiance, alpha, r.depth});
    }
  }
}

void RadiosityIntegrator::step(Wave& wave) const {
  const size_t n = wave.walks.size();
  wave.rays.resize(n), wave.hits.resize(n);
  for (size_t k = 0; k < n; ++k) wave.rays[k] = wave.walks[k].ray;
  if (wave.walks[0].receiver == kNone && wave.walks[0].step == 0)
    world_.accel().intersectMany(wave.rays, wave.hits);
  else
    world_.accel().intersect(wave.rays, wave.hits);

  wave.active.clear(), wave.points.clear();
  for (uint32_t k = 0; k < n; ++k) {
    Walk& walk = wave.walks[k];
    const Hit& hit = wave.hits[k];
    if (!hit.valid()) {
      missed(wave, walk);
      continue;
    }
    walk.footprint += walk.spread * hit.t;
    walk.bounces = engine_.bouncesAt(hit.placement, walk.bounces);
    wave.active.push_back(k);
  }
  world_.pointsAt(
      wave.hits, wave.active,
      [&](uint32_t k) { return std::pair(wave.walks[k].ray.direction, wave.walks[k].footprint); },
      wave.points);
  for (size_t i = 0; i < wave.points.size(); ++i) {
    const Walk& walk = wave.walks[wave.active[i]];
    const Hit& hit = wave.hits[wave.active[i]];
    ShadingPoint& point = wave.points[i];
    if (walk.receiver == kNone) point = world_.seenAt(point);
    Result& result = wave.results[walk.slot];
    if (walk.receiver == kNone && isBlack(result.seen))
      result.depth = result.depth < kFarDepth ? result.depth * hit.t : result.depth;
    const uint32_t light = world_.attributesOf(hit.placement).areaLight;
    if (light != kNone && (walk.pdf == 0 || world_.lightsOf(walk.receiver).sees(light))) {
      const V2f uv = world_.geometry()
                         .surface(world_.geometry().placements()[hit.placement])
                         .surfaceParameters(hit.face, hit.u, hit.v);
      float weight = 1;
      if (walk.pdf > 0 && walk.sampledLights)
        weight = world_.lightsOf(walk.receiver)
                     .weightOfMet(light, walk.pdf, world_.lights().areaPdf(light, walk.from, point));
      result.radiance +=
          walk.throughput * world_.lights().emitted(light, point, -walk.ray.direction, uv) * weight;
    }
  }
  hitCount += static_cast<int64_t>(wave.points.size());
  viewIndependent(wave);
  // What depends on the view, and opacity, is shaded at the hits that have any.
  const auto needsShading = [&](const ShadingPoint& p) {
    return world_.shading().shaderOf(p.placement).active(PATINA_ENTRY_VIEW) ||
           !world_.shading().isOpaque(p.placement);
  };
  wave.next.clear();
  std::vector<Rgb>& radiosity = wave.radiosity;
  size_t kept = 0;
  for (size_t i = 0; i < wave.points.size(); ++i) {
    Walk& walk = wave.walks[wave.active[i]];
    Result& result = wave.results[walk.slot];
    result.radiance += walk.throughput * radiosity[i];
    if (!needsShading(wave.points[i])) {
      if (walk.receiver == kNone) {
        result.seen += walk.throughput;
        if (world_.attributesOf(wave.points[i].placement).matte) result.radiance = result.seen = Rgb(0, 0, 0);
      }
      continue;
    }
    wave.points[kept] = wave.points[i];
    wave.active[kept++] = wave.active[i];
  }
  wave.points.resize(kept), wave.active.resize(kept);
  if (kept > 0) {
    world_.shading().shade(wave.points, ShadingParts::RadiosityAndView, wave.shaded);
    specularDirect(wave);
    for (size_t i = 0; i < kept; ++i) {
      Walk walk = wave.walks[wave.active[i]];
      if (proceed(wave, i, walk)) wave.next.push_back(walk);
    }
  }
  wave.walks.swap(wave.next);
}

void RadiosityIntegrator::missed(Wave& wave, const Walk& walk) const {
  const Lights& lights = world_.lights();
  Result& result = wave.results[walk.slot];
  for (const uint32_t light : lights.infinite()) {
    const bool camera = walk.receiver == kNone;
    if (camera ? !lights.seenByCamera(light) : walk.pdf > 0 && !world_.lightsOf(walk.receiver).sees(light))
      continue;
    Rgb radiance;
    float pdf;
    lights.evaluate(light, {&walk.ray.origin, 1}, {&walk.ray.direction, 1}, {&radiance, 1}, {&pdf, 1});
    float weight = 1;
    if (walk.pdf > 0 && walk.sampledLights)
      weight = world_.lightsOf(walk.receiver).weightOfMet(light, walk.pdf, pdf);
    result.radiance += walk.throughput * radiance * weight;
    if (camera && !isBlack(radiance)) result.seen += walk.throughput;
  }
}

/// B at every point: interpolated between vertices, or sampled at the hit where a patch has none that are
/// near enough.
void RadiosityIntegrator::viewIndependent(Wave& wave) const {
  const PatchTable& patches = world_.geometry().patches();
  const size_t n = wave.points.size();
  wave.radiosity.assign(n, Rgb(0, 0, 0));
  wave.around.resize(n);
  wave.known.clear(), wave.cellOf.clear(), wave.cells.clear(), wave.cellKeys.clear(), wave.inCells.clear(),
      wave.vertices.clear(), wave.byHit.clear();
  wave.met.clear(), wave.sharing.clear(), wave.parts.clear();
  const auto seedOf = [&](uint32_t i) {
    const Walk& walk = wave.walks[wave.active[i]];
    return hashOf(walk.seed(kPoint), walk.sample);
  };
  // Of the points of one key that this wave meets, one by chance stands for the others.
  const auto share = [&](uint32_t i, uint64_t key, bool part) {
    const uint64_t chance = seedOf(i);
    const auto [found, isNew] = wave.met.try_emplace(key, chance, i);
    if (chance < found->second.first) found->second = {chance, i};
    wave.sharing.push_back({i, key, part});
  };
  for (uint32_t i = 0; i < n; ++i) {
    const ShadingPoint& p = wave.points[i];
    const ShaderInstance& shader = world_.shading().shaderOf(p.placement);
    wave.around[i].count = 0;
    if (!shader.active(PATINA_ENTRY_RADIOSITY)) continue;
    const uint32_t index = patches.find(p.placement, p.face, p.u, p.v);
    const Patch& patch = patches[index];
    // Micropolygons that the camera sees are as long as they look: a floor's far part has long ones.
    constexpr float kLeastCosine = 1.0f / 32;
    const float seen =
        wave.walks[wave.active[i]].receiver == kNone ? std::max(std::abs(p.I.dot(p.Ng)), kLeastCosine) : 1;
    if (world_.settings().shadeAtHits || shader.has(PATINA_TRAIT_NOT_CACHEABLE) ||
        patch.spacing * seen >
            4 * std::max(p.footprint, 1e-30f) * std::sqrt(world_.attributesOf(p.placement).shadingRate)) {
      wave.byHit.push_back(i);
      continue;
    }
    // What is seen of a group of small faces is not what it is on average: the hollows of a rough surface
    // hide, and slopes count by how they are turned.
    if (patch.group > 0) {
      share(i, uint64_t{index} << 1 | uint64_t{p.front}, false);
      continue;
    }
    const V2f local = patch.toLocal(p.u, p.v);
    VertexWeights& around = wave.around[i] = patch.locate(Level::Fine, local.x, local.y);
    // The upper triangle of one square begins at the vertex that the lower one of another begins at.
    const bool upper = around.index[1] < around.index[0];
    const uint64_t cell =
        uint64_t{index} << 17 | uint64_t{p.front} << 16 | uint64_t{upper} << 15 | around.index[0];
    const auto [at, isNewCell] = wave.cellOf.try_emplace(cell, static_cast<uint32_t>(wave.cells.size()));
    if (isNewCell) wave.cells.push_back({index, p.front, around, &p}), wave.cellKeys.push_back(cell);
    wave.inCells.emplace_back(i, at->second);
  }
  wave.separated.resize(wave.cells.size());
  engine_.separated(wave.cells, wave.separated);
  for (const auto& [i, at] : wave.inCells) {
    VertexWeights& around = wave.around[i];
    if (wave.separated[at]) {
      around.count = 0;
      const Walk& walk = wave.walks[wave.active[i]];
      // Its vertices say nothing of what is between them: some points of it are shaded in each pixel, and
      // shared by all the pixel's samples.
      const uint64_t key = hashOf(wave.cellKeys[at], walk.x, walk.y, walk.sample % RayBudget::kParts,
                                  RadiosityEngine::keptBounces(walk.bounces));
      if (const auto known = wave.inCell.find(key); known != wave.inCell.end())
        wave.radiosity[i] = known->second;
      else
        share(i, key, true);
      continue;
    }
    const uint32_t index = wave.cells[at].patch;
    const bool front = wave.cells[at].front;
    const uint8_t bounces = RadiosityEngine::keptBounces(wave.walks[wave.active[i]].bounces);
    for (int k = 0; k < around.count; ++k) {
      const RadiosityEngine::Vertex v{index, front, static_cast<uint16_t>(around.index[k]), bounces};
      const auto [found, isNew] =
          wave.known.try_emplace(keyOf(v), static_cast<uint32_t>(wave.vertices.size()));
      if (isNew) wave.vertices.push_back(v);
      around.index[k] = found->second;
    }
  }
  vertexCount += static_cast<int64_t>(wave.vertices.size());
  vertexValues(wave);
  for (size_t i = 0; i < n; ++i)
    for (int k = 0; k < wave.around[i].count; ++k)
      wave.radiosity[i] += wave.values[wave.around[i].index[k]] * wave.around[i].weight[k];
  for (const auto& [i, key, part] : wave.sharing)
    if (wave.met.at(key).second == i) (part ? wave.parts : wave.byHit).push_back(i);

  const bool unbiased = world_.settings().unbiased;
  const auto shadeThem = [&](std::span<const uint32_t> which, Purpose purpose) {
    if (which.empty()) return;
    wave.requests.clear();
    for (const uint32_t i : which) {
      const Walk& walk = wave.walks[wave.active[i]];
      wave.requests.push_back({wave.points[i], unbiased ? walk.seed(kPoint) : seedOf(i), walk.bounces,
                               unbiased ? walk.sample : 0});
    }
    wave.values.resize(wave.requests.size());
    engine_.shade(wave.requests, 0, purpose, wave.values);
    for (size_t k = 0; k < which.size(); ++k) wave.radiosity[which[k]] = wave.values[k];
  };
  shadeThem(wave.byHit, unbiased ? Purpose::Sample : Purpose::Vertex);
  shadeThem(wave.parts, Purpose::Part);
  for (const auto& [i, key, part] : wave.sharing) {
    wave.radiosity[i] = wave.radiosity[wave.met.at(key).second];
    if (part) wave.inCell.emplace(key, wave.radiosity[i]);
  }
}

/// B at the wave's vertices.
void RadiosityIntegrator::vertexValues(Wave& wave) const {
  wave.values.resize(wave.vertices.size());
  if (!wave.kept) return engine_.vertices(wave.vertices, wave.values);
  thread_local std::vector<RadiosityEngine::Vertex> missing;
  thread_local std::vector<uint32_t> places;
  thread_local std::vector<Rgb> made;
  missing.clear(), places.clear();
  auto& kept = wave.kept->radiance;
  for (uint32_t k = 0; k < wave.vertices.size(); ++k) {
    const auto found = kept.find(keyOf(wave.vertices[k]));
    if (found != kept.end())
      wave.values[k] = found->second;
    else
      missing.push_back(wave.vertices[k]), places.push_back(k);
  }
  made.resize(missing.size());
  engine_.vertices(missing, made);
  for (size_t i = 0; i < made.size(); ++i) {
    wave.values[places[i]] = made[i];
    kept.emplace(keyOf(missing[i]), made[i]);
  }
}

/// Direct light by way of lobes: delta lights all, of the others one per point.
void RadiosityIntegrator::specularDirect(Wave& wave) const {
  const size_t n = wave.points.size();
  const Lights& lights = world_.lights();
  wave.direct.assign(n, Rgb(0, 0, 0));
  thread_local std::vector<std::vector<std::pair<uint32_t, float>>> byLight;
  byLight.resize(lights.count());
  for (auto& list : byLight) list.clear();
  for (uint32_t i = 0; i < n; ++i) {
    const LightList& list = world_.lightsOf(wave.points[i].placement);
    if (list.sampled.empty()) continue;
    const SurfaceTerms& terms = wave.shaded.terms[i];
    const Bsdf bsdf(wave.points[i], terms, wave.shaded.lobesOf(terms));
    if (!bsdf.scattersSmoothly(false)) continue;
    const Walk& walk = wave.walks[wave.active[i]];
    for (const uint32_t light : list.sampled)
      if (lights.isDelta(light)) byLight[light].emplace_back(i, 1.0f);
    const LightList::Pick pick = list.pick(sobol1(walk.sample, walk.seed(kLightChoice)));
    if (!lights.isDelta(pick.light)) byLight[pick.light].emplace_back(i, pick.chance);
  }
  thread_local std::vector<V3f> positions;
  thread_local std::vector<V2f> random;
  thread_local std::vector<LightSample> samples;
  thread_local std::vector<World::ShadowRay> shadowRays;
  thread_local std::vector<std::pair<uint32_t, Rgb>> contributions;
  thread_local std::vector<Rgb> visible;
  for (uint32_t light = 0; light < byLight.size(); ++light) {
    if (byLight[light].empty()) continue;
    positions.clear(), random.clear(), shadowRays.clear(), contributions.clear();
    for (const auto& [i, chance] : byLight[light]) {
      const Walk& walk = wave.walks[wave.active[i]];
      positions.push_back(wave.points[i].P);
      random.push_back(sobol2(walk.sample, walk.seed(kLightPoint)));
    }
    samples.resize(positions.size());
    lights.sample(light, positions, random, samples);
    for (size_t k = 0; k < samples.size(); ++k) {
      const LightSample& s = samples[k];
      if (s.pdf == 0) continue;
      const auto [i, chance] = byLight[light][k];
      const SurfaceTerms& terms = wave.shaded.terms[i];
      const Bsdf bsdf(wave.points[i], terms, wave.shaded.lobesOf(terms));
      const Bsdf::Value value = bsdf.evaluateSpecular(s.direction);
      if (isBlack(value.f)) continue;
      const float pdf = s.pdf * chance;
      // Without specular rays (classic) there is no other estimate to share with.
      const float weight = s.delta || world_.settings().classic ? 1 : misWeight(pdf, value.pdf);
      const Walk& walk = wave.walks[wave.active[i]];
      const uint64_t seed = hashOf(walk.seed(kTime), walk.sample, light);
      const float time = world_.rayTime(wave.points[i].placement, seed);
      shadowRays.push_back(
          {wave.points[i].facet(), &s, light, time, wave.points[i].footprint, raySpread(s, 1)});
      contributions.emplace_back(i, value.f * s.radiance * (weight / pdf));
    }
    visible.resize(shadowRays.size());
    world_.transmittance(shadowRays, visible, engine_.opacityCache());
    for (size_t k = 0; k < visible.size(); ++k)
      wave.direct[contributions[k].first] += contributions[k].second * visible[k];
  }
}

bool RadiosityIntegrator::proceed(Wave& wave, size_t i, Walk& walk) const {
  const ShadingPoint& point = wave.points[i];
  const SurfaceTerms& terms = wave.shaded.terms[i];
  Result& result = wave.results[walk.slot];
  const Attributes& attributes = world_.attributesOf(point.placement);
  const bool opaque = world_.shading().isOpaque(point.placement);
  Rgb opacity(1, 1, 1);
  if (!opaque)
    for (int c = 0; c < 3; ++c) opacity[c] = std::clamp(terms.opacity[c], 0.0f, 1.0f);
  result.radiance += walk.throughput * wave.direct[i];
  result.radiance += walk.throughput * terms.viewEmission;
  if (walk.receiver == kNone) {
    result.seen += walk.throughput * opacity;
    if (attributes.matte) {
      result.radiance = Rgb(0, 0, 0), result.seen = Rgb(0, 0, 0);
      return false;
    }
  }
  if (++walk.step > kMostSteps) return false;

  const Rgb passed = Rgb(1, 1, 1) - opacity;
  const Bsdf bsdf(point, terms, wave.shaded.lobesOf(terms));
  const bool specular = bsdf.hasLobes() && !world_.settings().classic;
  // Both a lobe and what lies behind: one of them is followed, by chance.
  const float through = opaque ? 0 : (passed.x + passed.y + passed.z) / 3;
  const float u = sobol1(walk.sample, walk.seed(kLobe));
  if (through > 0 && (!specular || u < through)) {
    walk.throughput *= specular ? passed / through : passed;
    if (maxComponent(walk.throughput) < 1e-4f) return false;
    const Hit& met = wave.hits[wave.active[i]];
    walk.ray.origin = goOn(walk.ray, met, point.facet());
    walk.ray.tNear = 0, walk.ray.tFar -= met.t;  // the far plane stays where it is
    return true;
  }
  if (!specular) return false;
  walk.maxSpecular = std::min(walk.maxSpecular, walk.specularDepth + attributes.maxSpecularDepth);
  if (walk.specularDepth++ >= walk.maxSpecular) return false;
  const float choice = std::clamp((u - through) / (1 - through), 0.0f, kOneMinusEpsilon);
  const BsdfSample s = bsdf.sampleSpecular(choice, sobol2(walk.sample, walk.seed(kDirection)));
  if (!(s.pdf > 0) || isBlack(s.weight)) return false;
  walk.throughput *= s.weight / (1 - through);
  walk.pdf = s.delta ? 0 : s.pdf;
  walk.sampledLights = !world_.lightsOf(point.placement).sampled.empty() && bsdf.scattersSmoothly(false);
  walk.receiver = point.placement;
  walk.from = point.P;
  walk.roughness = std::max(walk.roughness, s.alpha);
  walk.spread = std::max(walk.spread, s.alpha);
  const float time = world_.rayTime(point.placement, hashOf(walk.seed(kTime), walk.sample));
  walk.ray = Ray{leave(point.facet(), s.direction), s.direction, 0, kInfinity, kSpecularRay, time};
  return true;
}

}  // namespace

std::unique_ptr<Integrator> makeRadiosityIntegrator(const World& world, bool cached, bool indirect) {
  const RenderSettings& render = world.settings();
  RadiosityEngine::Settings settings;
  settings.cached = cached || !indirect;  // vertices are shared in direct light, too
  settings.indirect = indirect && !render.classic;
  settings.rays.diffuse0 = std::clamp(render.rays.value_or(128), 1, 1 << 16);
  settings.rays.light0 = std::clamp(render.lightSamples.value_or(16), 1, 1 << 16);
  settings.rays.samples = world.samplesPerPixel();
  // Of a truth's own look-ups a quarter is corrected in turn.
  if (render.unbiased) settings.residual = 0.25f;
  const double bytes = render.cacheMemoryMb ? *render.cacheMemoryMb * 1048576
                                            : world.scene().options.radiosityCacheKb * 1024.0;
  settings.opacityBytes = static_cast<size_t>(std::max(world.scene().options.opacityCacheKb, 0)) * 1024;
  settings.cacheBytes = static_cast<size_t>(std::clamp(bytes, 0.0, 1e13));
  return std::make_unique<RadiosityIntegrator>(world, settings);
}

}  // namespace patina
