// SPDX-License-Identifier: Apache-2.0
// Modes radiosity, distribution and direct: distribution ray tracing from the camera. View-independent light
// is computed at micropolygon vertices and shared by all samples (PixelSamples do not multiply it); lobes are
// evaluated at each hit.
#include "renderer/base/statistics.h"
#include "renderer/integrators/atmosphere.h"
#include "renderer/integrators/met_point.h"
#include "renderer/integrators/radiosity_integrator.h"

namespace patina {
namespace {

STAT_COUNTER("Camera/samples", sampleCount);
STAT_COUNTER("Camera/hits shaded", hitCount);

constexpr size_t kWave = 16384;  // camera samples in work at a time
constexpr int kMostSteps = 512;  // layers and specular bounces of a sample

}  // namespace

void RadiosityIntegrator::render(FilmTile& tile, SampleRange samples, TileMemory* memory) const {
  const PixelRect& pixels = tile.samplePixels();
  const size_t pixelCount = static_cast<size_t>(pixels.width()) * static_cast<size_t>(pixels.height());
  const auto perWave =
      static_cast<uint32_t>(std::clamp<size_t>(kWave / std::max<size_t>(pixelCount, 1), 1, samples.end));
  thread_local Wave wave;
  wave.inPart.clear(), wave.inGroup.clear();
  thread_local TileVertices ofThisTile;
  ofThisTile.values.clear();
  wave.kept = cached_ ? nullptr : memory ? static_cast<TileVertices*>(memory) : &ofThisTile;
  for (uint32_t first = samples.first; first < samples.end && !world_.interrupted(); first += perWave) {
    const uint32_t end = std::min(samples.end, first + perWave);
    wave.walks.clear(), wave.positions.clear();
    wave.results.assign(pixelCount * (end - first), Result{});
    for (int y = pixels.y0; y < pixels.y1; ++y)
      for (int x = pixels.x0; x < pixels.x1; ++x)
        for (uint32_t s = first; s < end && tile.wants(x, y); ++s) {
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
      const Rgb seen = r.seen + r.air;
      const float alpha = std::clamp((seen.x + seen.y + seen.z) / 3, 0.0f, 1.0f);
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
  for (size_t i = 0; i < wave.points.size(); ++i)
    placeAlongRay(wave.points[i], world_, wave.rays[wave.active[i]], wave.hits[wave.active[i]]);
  throughAir(wave);
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
      if (walk.pdf > 0 && walk.sampledLights) {
        const LightList& list = world_.lightsOf(walk.receiver);
        const float pdf =
            world_.lights().areaPdf(light, walk.from.P, point) * static_cast<float>(picksOf(list));
        weight = list.weightOfMet(walk.from, light, walk.pdf, pdf);
      }
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
        if (world_.attributesOf(wave.points[i].placement).matte)
          result.radiance = result.seen = result.air = Rgb(0, 0, 0);
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
    skyDirect(wave);
    for (size_t i = 0; i < kept; ++i) {
      Walk walk = wave.walks[wave.active[i]];
      if (proceed(wave, i, walk)) wave.next.push_back(walk);
    }
  }
  wave.walks.swap(wave.next);
}

/// What lies between the eye and what it sees: RI's Atmosphere.
void RadiosityIntegrator::throughAir(Wave& wave) const {
  thread_local std::vector<AirSegment> segments;
  thread_local std::vector<uint32_t> walks;
  thread_local std::vector<Air> air;
  segments.clear(), walks.clear();
  for (const uint32_t k : wave.active) {
    const Walk& walk = wave.walks[k];
    if (walk.receiver != kNone || !world_.atmosphereOf(wave.hits[k].placement)) continue;
    segments.push_back({&walk.ray, &wave.hits[k], walk.step == 0});
    walks.push_back(k);
  }
  if (segments.empty()) return;
  air.resize(segments.size());
  airOf(world_, segments, air);
  for (size_t i = 0; i < air.size(); ++i) {
    Walk& walk = wave.walks[walks[i]];
    Result& result = wave.results[walk.slot];
    result.radiance += walk.throughput * air[i].radiance;
    result.air += walk.throughput * (Rgb(1, 1, 1) - air[i].transmittance);
    walk.throughput *= air[i].transmittance;
  }
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
    if (walk.pdf > 0 && walk.sampledLights) {
      const LightList& list = world_.lightsOf(walk.receiver);
      weight = list.weightOfMet(walk.from, light, walk.pdf, pdf * static_cast<float>(picksOf(list)));
    }
    result.radiance += walk.throughput * radiance * weight;
    if (camera && !isBlack(radiance)) result.seen += walk.throughput;
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
      result.radiance = result.seen = result.air = Rgb(0, 0, 0);
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
  if (!specular || !followsLobes(walk, point.placement)) return false;
  walk.maxSpecular = std::min(walk.maxSpecular, walk.specularDepth + attributes.maxSpecularDepth);
  ++walk.specularDepth;
  const float choice = std::clamp((u - through) / (1 - through), 0.0f, kOneMinusEpsilon);
  const BsdfSample s = bsdf.sampleSpecular(choice, sobol2(walk.sample, walk.seed(kDirection)));
  if (!(s.pdf > 0) || isBlack(s.weight)) return false;
  walk.throughput *= s.weight / (1 - through);
  walk.pdf = s.delta ? 0 : s.pdf;
  walk.sampledLights = !world_.lightsOf(point.placement).sampled.empty() && bsdf.scattersSmoothly(false);
  walk.receiver = point.placement;
  walk.from = bsdf.receiver();
  walk.roughness = std::max(walk.roughness, s.alpha);
  walk.spread = std::max(walk.spread, s.alpha);
  const float time = world_.rayTime(point.placement, hashOf(walk.seed(kTime), walk.sample));
  walk.ray = Ray{leave(point.facet(), s.direction), s.direction, 0, kInfinity, kSpecularRay, time};
  return true;
}

namespace {

RadiosityEngine::Settings engineSettings(const World& world, bool cached, bool indirect) {
  const RenderSettings& render = world.settings();
  RadiosityEngine::Settings settings;
  settings.cached = cached || !indirect;  // vertices are shared in direct light, too
  settings.indirect = indirect && !render.classic;
  settings.rays.diffuse0 = std::clamp(render.rays.value_or(128), 1, 1 << 16);
  settings.rays.light0 = std::clamp(render.lightSamples.value_or(16), 1, 1 << 16);
  settings.rays.samples = world.samplesPerPixel();
  settings.fullHits = render.fullHits && !settings.cached;
  settings.levelScale = world.scene().options.levelScale;
  settings.fineScale = world.scene().options.fineScale;
  // Of a truth's own look-ups a quarter is corrected in turn.
  if (render.unbiased) settings.residual = 0.25f;
  const double bytes = render.cacheMemoryMb ? *render.cacheMemoryMb * 1048576
                                            : world.scene().options.radiosityCacheKb * 1024.0;
  settings.opacityBytes = static_cast<size_t>(std::max(world.scene().options.opacityCacheKb, 0)) * 1024;
  settings.cacheBytes = static_cast<size_t>(std::clamp(bytes, 0.0, 1e13));
  return settings;
}

}  // namespace

std::unique_ptr<Integrator> makeRadiosityIntegrator(const World& world, bool cached, bool indirect) {
  return std::make_unique<RadiosityIntegrator>(world, engineSettings(world, cached, indirect));
}

std::unique_ptr<Integrator> makePointsIntegrator(const World& world) {
  RadiosityEngine::Settings settings = engineSettings(world, true, true);
  settings.residual = 0;
  const PointOptions& said = world.scene().options.points;
  const PointOptions& over = world.settings().points;
  BakedPoints::Settings of;
  of.raster.maxSolidAngle = over.maxSolidAngle.value_or(said.maxSolidAngle.value_or(of.raster.maxSolidAngle));
  of.raster.resolution = over.resolution.value_or(said.resolution.value_or(of.raster.resolution));
  of.bounces = over.bounces.value_or(said.bounces.value_or(of.bounces));
  of.surfelSize = over.surfelSize.value_or(said.surfelSize.value_or(of.surfelSize));
  const int kilobytes = over.memoryKb.value_or(said.memoryKb.value_or(static_cast<int>(of.bytes / 1024)));
  of.bytes = static_cast<size_t>(kilobytes) * 1024;
  auto points = std::make_unique<const BakedPoints>(world, settings, of);
  settings.points = points.get();
  return std::make_unique<RadiosityIntegrator>(world, settings, std::move(points));
}

}  // namespace patina
