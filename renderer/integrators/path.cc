// SPDX-License-Identifier: Apache-2.0
// Mode path: unidirectional path tracing with next-event estimation, multiple importance sampling and Russian
// roulette (PBR 4th ed. chapter 13), in waves: all paths of a wave take one step at a time, so that shaders,
// lights and primary rays run in batches.
#include "renderer/base/statistics.h"
#include "renderer/integrators/atmosphere.h"
#include "renderer/integrators/integrator.h"
#include "renderer/integrators/met_point.h"

namespace patina {
namespace {

STAT_COUNTER("Path/paths", pathCount);
STAT_COUNTER("Path/vertices", vertexCount);
STAT_COUNTER("Path/ended at maxdepth", depthEnds);
STAT_COUNTER("Path/ended by Russian roulette", rouletteEnds);

constexpr size_t kWave = 4096;  // paths in work at a time
constexpr int kAnyDepth = 1 << 20;
constexpr int kRouletteDepth = 5;    // bounces that are always taken
constexpr int kMostVertices = 4096;  // even through transparent layers

// Purposes of random numbers; every vertex has its own block.
enum Dimension : uint32_t {
  kVertex = 8,  // those before are the camera's
  kLightChoice = 0,
  kLightPoint,
  kLobe,
  kDirection,
  kRoulette,
  kLayer,
  kTime,
  kPerVertex = 8
};

struct Path {
  uint32_t slot = 0;  // result
  uint32_t sample = 0;
  uint64_t frame = 0;  // World::frameSeed()
  int x = 0, y = 0;
  Ray ray;
  Rgb throughput{1, 1, 1};
  LightReceiver from;          // where the ray left
  float pdf = 0;               // of the ray's direction; 0 = camera or delta lobe: lights count in full
  uint32_t receiver = kNone;   // placement that the ray left
  bool sampledLights = false;  // next-event estimation was done there
  float distance = 0;          // travelled in all, for footprints
  float spread = 0;            // growth of the footprint per length
  float footprint = 0;         // at the ray's origin
  int bounces = 0;             // of both kinds
  int diffuseDepth = 0, specularDepth = 0;  // the latter since the last diffuse one
  int maxDiffuse = kAnyDepth, maxSpecular = kAnyDepth;
  bool lightsOnly = false;  // beyond the last bounce: only lights are still counted
  uint32_t vertex = 0;
  bool transparentSoFar = true;

  uint64_t seed(uint32_t dimension) const {
    return pixelSeed(frame, x, y, kVertex + vertex * kPerVertex + dimension);
  }
};

class PathIntegrator final : public Integrator {
 public:
  explicit PathIntegrator(const World& world) : world_(world) {}
  void render(FilmTile& tile, SampleRange samples, TileMemory* memory) const override;

 private:
  struct Wave {
    std::vector<Path> paths, next;
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    std::vector<Seen> results;
    std::vector<ShadingPoint> points;
    std::vector<uint32_t> pathOf;  // of a point
    ShadedPoints shaded, diffuse;
    std::vector<Rgb> direct;
    std::vector<float> lightChance;
    std::vector<LightSample> lightSamples;
  };
  void step(Wave& wave) const;
  void shade(Wave& wave) const;
  void throughAir(Wave& wave) const;
  void missed(Wave& wave, std::span<const uint32_t> which) const;
  void sampleLights(Wave& wave) const;
  bool scatter(Wave& wave, size_t point, Path& path) const;

  const World& world_;
};

void PathIntegrator::render(FilmTile& tile, SampleRange samples, TileMemory*) const {
  const PixelRect& pixels = tile.samplePixels();
  const size_t pixelCount = static_cast<size_t>(pixels.width()) * static_cast<size_t>(pixels.height());
  thread_local Wave wave;
  const auto perWave =
      static_cast<uint32_t>(std::clamp<size_t>(kWave / std::max<size_t>(pixelCount, 1), 1, samples.end));
  for (uint32_t first = samples.first; first < samples.end && !world_.interrupted(); first += perWave) {
    const uint32_t end = std::min(samples.end, first + perWave);
    wave.paths.clear();
    wave.results.assign(pixelCount * (end - first), Seen{});
    std::vector<V2f> positions;
    for (int y = pixels.y0; y < pixels.y1; ++y)
      for (int x = pixels.x0; x < pixels.x1; ++x)
        for (uint32_t s = first; s < end && tile.wants(x, y); ++s) {
          const CameraSample camera = cameraSample(world_, x, y, s);
          Path path;
          path.slot = static_cast<uint32_t>(wave.paths.size());
          path.sample = s, path.frame = world_.frameSeed(), path.x = x, path.y = y;
          path.ray = camera.ray;
          path.spread = camera.camera.footprintSpread, path.footprint = camera.camera.footprintAtOrigin;
          wave.results[path.slot].depth = camera.camera.depthPerT;  // until the first hit
          wave.paths.push_back(path);
          positions.emplace_back(camera.x, camera.y);
        }
    pathCount += static_cast<int64_t>(wave.paths.size());
    while (!wave.paths.empty()) step(wave);
    for (size_t k = 0; k < positions.size(); ++k) addSample(tile, positions[k], wave.results[k]);
  }
}

void PathIntegrator::step(Wave& wave) const {
  const size_t n = wave.paths.size();
  wave.rays.resize(n), wave.hits.resize(n);
  const bool primary = wave.paths[0].vertex == 0;
  for (size_t k = 0; k < n; ++k) wave.rays[k] = wave.paths[k].ray;
  if (primary)
    world_.accel().intersectMany(wave.rays, wave.hits);
  else
    world_.accel().intersect(wave.rays, wave.hits);
  vertexCount += static_cast<int64_t>(n);

  // Rays that left the scene.
  thread_local std::vector<uint32_t> away;
  away.clear();
  wave.pathOf.clear();
  for (uint32_t k = 0; k < n; ++k) {
    Path& path = wave.paths[k];
    if (!wave.hits[k].valid()) {
      away.push_back(k);
      continue;
    }
    path.distance += wave.hits[k].t;
    path.footprint += path.spread * wave.hits[k].t;
    wave.pathOf.push_back(k);
  }
  world_.pointsAt(
      wave.hits, wave.pathOf,
      [&](uint32_t k) { return std::pair(wave.paths[k].ray.direction, wave.paths[k].footprint); },
      wave.points);
  for (size_t i = 0; i < wave.points.size(); ++i)
    placeAlongRay(wave.points[i], world_, wave.rays[wave.pathOf[i]], wave.hits[wave.pathOf[i]]);
  throughAir(wave);
  size_t kept = 0;
  for (size_t i = 0; i < wave.points.size(); ++i) {
    const uint32_t k = wave.pathOf[i];
    Path& path = wave.paths[k];
    const Hit& hit = wave.hits[k];
    const ShadingPoint point = path.receiver == kNone ? world_.seenAt(wave.points[i]) : wave.points[i];
    // Light from an area light that the ray met.
    const uint32_t light = world_.attributesOf(hit.placement).areaLight;
    if (light != kNone &&
        (path.receiver == kNone || path.pdf == 0 || world_.lightsOf(path.receiver).sees(light))) {
      const V2f uv = world_.geometry()
                         .surface(world_.geometry().placements()[hit.placement])
                         .surfaceParameters(hit.face, hit.u, hit.v);
      const Rgb emitted = world_.lights().emitted(light, point, -path.ray.direction, uv);
      if (!isBlack(emitted)) {
        float weight = 1;
        if (path.pdf > 0 && path.sampledLights)
          weight = world_.lightsOf(path.receiver)
                       .weightOfMet(path.from, light, path.pdf,
                                    world_.lights().areaPdf(light, path.from.P, point));
        wave.results[path.slot].radiance += path.throughput * emitted * weight;
      }
    }
    if (path.vertex == 0) wave.results[path.slot].depth *= hit.t;
    if (path.lightsOnly) {
      // The ray was sent for lights alone, but surfaces that let light pass do not end it.
      if (world_.shading().isOpaque(hit.placement)) continue;
    }
    wave.points[kept] = point;
    wave.pathOf[kept++] = k;
  }
  wave.points.resize(kept), wave.pathOf.resize(kept);
  missed(wave, away);

  shade(wave);
  sampleLights(wave);
  wave.next.clear();
  for (size_t i = 0; i < wave.points.size(); ++i) {
    Path& path = wave.paths[wave.pathOf[i]];
    if (scatter(wave, i, path)) wave.next.push_back(path);
  }
  wave.paths.swap(wave.next);
}

/// Without caustics, what paths meet after a diffuse bounce has no lobes, and is asked for none. Such points
/// come to the end of the wave.
void PathIntegrator::shade(Wave& wave) const {
  const size_t n = wave.points.size();
  size_t seen = n;
  if (!world_.caustics()) {
    seen = 0;
    for (size_t i = 0; i < n; ++i) {
      if (wave.paths[wave.pathOf[i]].diffuseDepth > 0) continue;
      std::swap(wave.points[i], wave.points[seen]), std::swap(wave.pathOf[i], wave.pathOf[seen]);
      ++seen;
    }
  }
  const std::span<const ShadingPoint> points(wave.points);
  world_.shading().shade(points.first(seen), ShadingParts::RadiosityAndView, wave.shaded);
  if (seen == n) return;
  world_.shading().shade(points.subspan(seen), ShadingParts::Radiosity, wave.diffuse);
  wave.shaded.terms.insert(wave.shaded.terms.end(), wave.diffuse.terms.begin(), wave.diffuse.terms.end());
}

/// What lies between the eye and what it sees: RI's Atmosphere.
void PathIntegrator::throughAir(Wave& wave) const {
  thread_local std::vector<AirSegment> segments;
  thread_local std::vector<uint32_t> paths;
  thread_local std::vector<Air> air;
  segments.clear(), paths.clear();
  for (const uint32_t k : wave.pathOf) {
    const Path& path = wave.paths[k];
    if (path.receiver != kNone || !world_.atmosphereOf(wave.hits[k].placement)) continue;
    segments.push_back({&path.ray, &wave.hits[k], path.vertex == 0});
    paths.push_back(k);
  }
  if (segments.empty()) return;
  air.resize(segments.size());
  airOf(world_, segments, air);
  for (size_t i = 0; i < air.size(); ++i) {
    Path& path = wave.paths[paths[i]];
    Seen& result = wave.results[path.slot];
    const Rgb& passed = air[i].transmittance;
    result.radiance += path.throughput * air[i].radiance;
    result.alpha = 1 - (1 - result.alpha) * (passed.x + passed.y + passed.z) / 3;
    path.throughput *= passed;
  }
}

void PathIntegrator::missed(Wave& wave, std::span<const uint32_t> which) const {
  thread_local std::vector<V3f> from, direction;
  thread_local std::vector<uint32_t> paths;
  thread_local std::vector<Rgb> radiance;
  thread_local std::vector<float> pdf;
  for (const uint32_t light : world_.lights().infinite()) {
    from.clear(), direction.clear(), paths.clear();
    for (const uint32_t k : which) {
      const Path& path = wave.paths[k];
      const bool camera = path.receiver == kNone;
      if (camera ? !world_.lights().seenByCamera(light)
                 : path.pdf > 0 && !world_.lightsOf(path.receiver).sees(light))
        continue;
      from.push_back(path.ray.origin), direction.push_back(path.ray.direction), paths.push_back(k);
    }
    if (paths.empty()) continue;
    radiance.resize(paths.size()), pdf.resize(paths.size());
    world_.lights().evaluate(light, from, direction, radiance, pdf);
    for (size_t i = 0; i < paths.size(); ++i) {
      Path& path = wave.paths[paths[i]];
      float weight = 1;
      if (path.pdf > 0 && path.sampledLights)
        weight = world_.lightsOf(path.receiver).weightOfMet(path.from, light, path.pdf, pdf[i]);
      wave.results[path.slot].radiance += path.throughput * radiance[i] * weight;
      if (path.receiver == kNone && !isBlack(radiance[i])) {
        Seen& result = wave.results[path.slot];
        result.alpha = 1, result.depth = kFarDepth;
      }
    }
  }
}

void PathIntegrator::sampleLights(Wave& wave) const {
  const size_t n = wave.points.size();
  wave.direct.assign(n, Rgb(0, 0, 0));
  wave.lightChance.resize(n);
  wave.lightSamples.resize(n);
  world_.addAmbient(wave.points, wave.shaded.terms, wave.direct);
  // Every point picks one of its lights; then each light is sampled for all points that picked it.
  thread_local std::vector<std::vector<uint32_t>> byLight;
  byLight.resize(world_.lights().count());
  for (auto& list : byLight) list.clear();
  for (uint32_t i = 0; i < n; ++i) {
    const Path& path = wave.paths[wave.pathOf[i]];
    if (path.lightsOnly) continue;
    const LightList& list = world_.lightsOf(wave.points[i].placement);
    if (list.sampled.empty()) continue;
    const Bsdf bsdf(wave.points[i], wave.shaded.terms[i], wave.shaded.lobesOf(wave.shaded.terms[i]));
    if (!bsdf.scattersSmoothly(true)) continue;
    const float u = sobol1(path.sample, path.seed(kLightChoice));
    const LightTree::Pick pick = list.pick(bsdf.receiver(), u);
    wave.lightChance[i] = pick.chance;
    byLight[pick.light].push_back(i);
  }
  thread_local std::vector<V3f> positions;
  thread_local std::vector<V2f> random;
  thread_local std::vector<LightSample> samples;
  thread_local std::vector<World::ShadowRay> shadowRays;
  thread_local std::vector<std::pair<uint32_t, Rgb>> contributions;
  thread_local std::vector<Rgb> visible;
  for (uint32_t light = 0; light < byLight.size(); ++light) {
    const auto& which = byLight[light];
    if (which.empty()) continue;
    positions.clear(), random.clear(), shadowRays.clear(), contributions.clear();
    for (const uint32_t i : which) {
      const Path& path = wave.paths[wave.pathOf[i]];
      positions.push_back(wave.points[i].P);
      random.push_back(sobol2(path.sample, path.seed(kLightPoint)));
    }
    samples.resize(which.size());
    world_.lights().sample(light, positions, random, samples);
    for (size_t k = 0; k < which.size(); ++k) {
      const uint32_t i = which[k];
      const LightSample& s = samples[k];
      if (s.pdf == 0) continue;
      const SurfaceTerms& terms = wave.shaded.terms[i];
      const Bsdf bsdf(wave.points[i], terms, wave.shaded.lobesOf(terms));
      const Bsdf::Value value = bsdf.evaluate(s.direction, s.delta);
      if (isBlack(value.f)) continue;
      const float pdf = s.pdf * wave.lightChance[i];
      // Without rays that follow (classic) there is no other estimate to share with.
      const float weight = s.delta || world_.settings().classic ? 1 : misWeight(pdf, value.pdf);
      const Path& path = wave.paths[wave.pathOf[i]];
      const uint64_t seed = hashOf(path.seed(kTime), path.sample, 1);
      const float time = world_.rayTime(wave.points[i].placement, seed);
      shadowRays.push_back({wave.points[i].facet(), &s, light, time});
      contributions.emplace_back(i, value.f * s.radiance * (weight / pdf));
    }
    visible.resize(shadowRays.size());
    world_.transmittance(shadowRays, visible);
    for (size_t k = 0; k < visible.size(); ++k)
      wave.direct[contributions[k].first] += contributions[k].second * visible[k];
  }
}

bool PathIntegrator::scatter(Wave& wave, size_t i, Path& path) const {
  const ShadingPoint& point = wave.points[i];
  const SurfaceTerms& terms = wave.shaded.terms[i];
  Seen& result = wave.results[path.slot];
  const Attributes& attributes = world_.attributesOf(point.placement);
  // Transparency: the path sees the surface, or what is behind it. Terms are premultiplied by opacity.
  if (!world_.shading().isOpaque(point.placement)) {
    const float solid = std::clamp((terms.opacity.x + terms.opacity.y + terms.opacity.z) / 3, 0.0f, 1.0f);
    const float u = sobol1(path.sample, path.seed(kLayer));
    if (path.lightsOnly || u >= solid) {
      const float before = maxComponent(path.throughput);
      for (int c = 0; c < 3; ++c) path.throughput[c] *= std::clamp(1 - terms.opacity[c], 0.0f, 1.0f);
      // What only looks for lights goes on by chance, too: else to the last of however many layers.
      const float chance = path.lightsOnly ? maxComponent(path.throughput) / before : 1 - solid;
      if (isBlack(path.throughput) || (path.lightsOnly && u >= chance) || ++path.vertex > kMostVertices)
        return false;
      path.throughput /= chance;
      path.ray.origin = goOn(path.ray, wave.hits[wave.pathOf[i]], point.facet());
      path.ray.tNear = 0;
      path.ray.tFar -= wave.hits[wave.pathOf[i]].t;  // the far plane of camera rays stays where it is
      return true;
    }
    path.throughput /= solid;
  }
  if (path.lightsOnly) return false;
  if (path.receiver == kNone) result.alpha = 1;
  result.radiance += path.throughput * (terms.emission + terms.viewEmission + wave.direct[i]);
  if (attributes.matte && path.receiver == kNone) {
    result.radiance = Rgb(0, 0, 0), result.alpha = 0;
    return false;
  }

  // Depths: an object may allow fewer bounces from here on, never more (MIN rule of PRMan).
  path.maxDiffuse = std::min(path.maxDiffuse, path.diffuseDepth + attributes.maxDiffuseDepth);
  path.maxSpecular = std::min(path.maxSpecular, path.specularDepth + attributes.maxSpecularDepth);
  if (world_.settings().classic) return false;
  const Bsdf bsdf(point, terms, wave.shaded.lobesOf(terms));
  const BsdfSample s =
      bsdf.sample(sobol1(path.sample, path.seed(kLobe)), sobol2(path.sample, path.seed(kDirection)));
  if (!(s.pdf > 0) || isBlack(s.weight)) return false;
  const LightList& list = world_.lightsOf(point.placement);
  bool last = false;
  if (s.diffuse) {
    last = path.diffuseDepth++ >= path.maxDiffuse;
    // What a diffuse ray meets knows nothing of mirrors that were passed before.
    path.specularDepth = 0, path.maxSpecular = kAnyDepth;
  } else {
    last = path.specularDepth++ >= path.maxSpecular;
  }
  if (last) {
    ++depthEnds;
    // Direct light of this point is still to be completed by its share of the BSDF's samples; a mirror has
    // none.
    if (s.delta || (list.infinite.empty() && list.area.empty())) return false;
  }
  path.lightsOnly = last;
  path.throughput *= s.weight;
  path.sampledLights = !list.sampled.empty() && bsdf.scattersSmoothly(true);
  path.pdf = s.delta ? 0 : s.pdf;
  path.receiver = point.placement;
  path.from = bsdf.receiver();
  path.spread = s.delta ? path.spread : std::max(path.spread, s.diffuse ? 0.3f : s.alpha);
  ++path.vertex;
  if (++path.bounces > kRouletteDepth) {
    // No less than what surfaces reflect, however much that is: else weights would grow from bounce to
    // bounce, and their variance without bound where albedos are above the root of the chance to go on.
    const float survive = std::min(1.0f, std::sqrt(maxComponent(path.throughput)));
    if (sobol1(path.sample, path.seed(kRoulette)) >= survive) {
      ++rouletteEnds;
      return false;
    }
    path.throughput /= survive;
  }
  path.ray = Ray{leave(point.facet(), s.direction),
                 s.direction,
                 0,
                 kInfinity,
                 s.diffuse ? kDiffuseRay : kSpecularRay,
                 world_.rayTime(point.placement, hashOf(path.seed(kTime), path.sample))};
  return true;
}

}  // namespace

std::unique_ptr<Integrator> makePathIntegrator(const World& world) {
  return std::make_unique<PathIntegrator>(world);
}

}  // namespace patina
