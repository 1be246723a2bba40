// SPDX-License-Identifier: Apache-2.0
// What diffuse rays see in surfaces with lobes; and the statistics of the cache.
#include <fmt/format.h>

#include <numeric>

#include "renderer/base/statistics.h"
#include "renderer/integrators/met_point.h"
#include "renderer/integrators/radiosity_workspace.h"

namespace patina {
namespace {

STAT_COUNTER("Radiosity/specular continuations", continuations);

enum Stream : uint64_t {
  kLobeStream = 32,
  kDirectionStream,
  kLightChoiceStream,
  kLightPointStream,
  kNextStream,
  kTimeStream,
  kRouletteStream
};

/// What surfaces reflect by way of lobes is followed where that much of it or more is left: of less, a part
/// of the walks, by chance, which then count for all. A sheen of a hundredth would else cost what all the
/// diffuse light costs.
constexpr float kWorthFollowing = 0.25f;

}  // namespace

void RadiosityEngine::followLobes(std::span<Walk> walks, int depth, bool truth, int nesting) const {
  Workspace& w = workspace(nesting);
  const SurfaceShading& shading = world_.shading();
  const Lights& lights = world_.lights();
  continuations += static_cast<int64_t>(walks.size());
  std::vector<uint32_t> active(walks.size());
  std::iota(active.begin(), active.end(), 0u);
  for (uint32_t bounce = 0; !active.empty(); ++bounce) {
    w.layerPoints.clear();
    for (const uint32_t k : active) {
      Walk& walk = walks[k];
      walk.most = std::min(
          walk.most, static_cast<int>(bounce) + world_.attributesOf(walk.point.placement).maxSpecularDepth);
      w.layerPoints.push_back(walk.point);
    }
    shading.shade(w.layerPoints, ShadingParts::RadiosityAndView, w.specular);
    // A direction each, and who goes on.
    w.lobeSamples.assign(active.size(), {});
    w.lit.clear();
    for (uint32_t i = 0; i < active.size(); ++i) {
      Walk& walk = walks[active[i]];
      const SurfaceTerms& terms = w.specular.terms[i];
      walk.radiance += walk.throughput * terms.viewEmission;
      if (terms.lobeCount == 0) continue;
      const Bsdf bsdf(walk.point, terms, w.specular.lobesOf(terms));
      const float choice = toUnit(static_cast<uint32_t>(hashOf(walk.seed, kLobeStream, bounce) >> 32));
      BsdfSample& s = w.lobeSamples[i];
      s = bsdf.sampleSpecular(choice, sobol2(0, hashOf(walk.seed, kDirectionStream, bounce)));
      const float left = maxComponent(walk.throughput * s.weight);
      if (s.pdf > 0 && left < kWorthFollowing) {
        const float survive = left / kWorthFollowing;
        if (toUnit(static_cast<uint32_t>(hashOf(walk.seed, kRouletteStream, bounce) >> 32)) >= survive) {
          s.pdf = 0;
          continue;
        }
        walk.throughput /= survive;
      }
      w.lit.push_back(i);
    }
    lightLobes(walks, active, bounce, truth, w);
    skyOnLastLobes(walks, active, bounce, truth, w);
    w.walkRays.clear(), w.walkOf.clear();
    for (const uint32_t i : w.lit) {
      Walk& walk = walks[active[i]];
      if (static_cast<int>(bounce) >= walk.most) continue;
      const BsdfSample& s = w.lobeSamples[i];
      if (!(s.pdf > 0) || isBlack(s.weight)) continue;
      const SurfaceTerms& terms = w.specular.terms[i];
      const Bsdf bsdf(walk.point, terms, w.specular.lobesOf(terms));
      walk.throughput *= s.weight;
      walk.pdf = s.pdf, walk.delta = s.delta, walk.alpha = s.alpha;
      walk.from = bsdf.receiver();
      const float time = world_.rayTime(walk.point.placement, hashOf(walk.seed, kTimeStream, bounce));
      w.walkRays.push_back(
          {leave(walk.point.facet(), s.direction), s.direction, 0, kInfinity, kSpecularRay, time});
      w.walkOf.push_back(active[i]);
    }
    w.walkHits.resize(w.walkRays.size());
    world_.accel().intersect(w.walkRays, w.walkHits);
    w.picked.clear(), w.missOf.clear(), w.missFrom.clear(), w.missDirection.clear();
    for (uint32_t j = 0; j < w.walkOf.size(); ++j) {
      Walk& walk = walks[w.walkOf[j]];
      if (w.walkHits[j].valid()) {
        walk.footprint += w.walkHits[j].t * std::max(walk.alpha, 0.05f);
        w.picked.push_back(j);
        continue;
      }
      w.missOf.push_back(j);
      w.missFrom.push_back(walk.point.P), w.missDirection.push_back(w.walkRays[j].direction);
    }
    w.missRadiance.resize(w.missOf.size()), w.missPdf.resize(w.missOf.size());
    for (const uint32_t light : lights.infinite()) {
      if (w.missOf.empty()) break;
      lights.evaluate(light, w.missFrom, w.missDirection, w.missRadiance, w.missPdf);
      for (size_t i = 0; i < w.missOf.size(); ++i) {
        Walk& walk = walks[w.walkOf[w.missOf[i]]];
        const LightList& list = world_.lightsOf(walk.point.placement);
        if (!walk.delta && !list.sees(light)) continue;  // mirrors show all there is
        const float weight = walk.delta ? 1 : list.weightOfMet(walk.from, light, walk.pdf, w.missPdf[i]);
        walk.radiance += walk.throughput * w.missRadiance[i] * weight;
      }
    }
    world_.pointsAt(
        w.walkHits, w.picked,
        [&](uint32_t j) { return std::pair(w.walkRays[j].direction, walks[w.walkOf[j]].footprint); },
        w.walkPoints);
    for (size_t i = 0; i < w.picked.size(); ++i)
      placeAlongRay(w.walkPoints[i], world_, w.walkRays[w.picked[i]], w.walkHits[w.picked[i]]);
    w.lookups.clear();
    for (uint32_t i = 0; i < w.picked.size(); ++i) {
      const uint32_t j = w.picked[i];
      Walk& walk = walks[w.walkOf[j]];
      const ShadingPoint& next = w.walkPoints[i];
      const Hit& hit = w.walkHits[j];
      const LightList& list = world_.lightsOf(walk.point.placement);
      const uint32_t light = world_.attributesOf(hit.placement).areaLight;
      if (light != kNone && (walk.delta || list.sees(light))) {
        const V2f uv = world_.geometry()
                           .surface(world_.geometry().placements()[hit.placement])
                           .surfaceParameters(hit.face, hit.u, hit.v);
        const float weight = walk.delta ? 1
                                        : list.weightOfMet(walk.from, light, walk.pdf,
                                                           lights.areaPdf(light, walk.from.P, next));
        walk.radiance += walk.throughput * lights.emitted(light, next, -w.walkRays[j].direction, uv) * weight;
      }
      if (shading.shaderOf(hit.placement).active(PATINA_ENTRY_RADIOSITY))
        w.lookups.push_back({&hit, bouncesAt(hit.placement, walk.bounces), walk.footprint, i});
    }
    lookUp(w.lookups, depth, nesting);
    w.walkRequests.clear();
    for (Lookup& lookup : w.lookups) {
      Walk& walk = walks[w.walkOf[w.picked[lookup.user]]];
      if (truth) correct(lookup, settings_.residual, hashOf(walk.seed, kNextStream, bounce));
      if (lookup.found) walk.radiance += walk.throughput * lookup.radiance * (1 - lookup.truth);
      if (lookup.truth > 0)
        w.walkRequests.push_back(
            {w.walkPoints[lookup.user], hashOf(walk.seed, kNextStream, bounce), lookup.bounces});
    }
    if (!w.walkRequests.empty()) {
      w.walkRadiance.resize(w.walkRequests.size());
      shadeNested(w.walkRequests, depth, truth ? Purpose::Truth : Purpose::Ray, w.walkRadiance, nesting + 1);
      size_t request = 0;
      for (const Lookup& lookup : w.lookups) {
        if (lookup.truth == 0) continue;
        Walk& walk = walks[w.walkOf[w.picked[lookup.user]]];
        walk.radiance += walk.throughput * w.walkRadiance[request++] * lookup.truth;
      }
    }
    active.clear();
    for (size_t i = 0; i < w.picked.size(); ++i) {
      const uint32_t k = w.walkOf[w.picked[i]];
      if (!shading.shaderOf(w.walkPoints[i].placement).active(PATINA_ENTRY_VIEW)) continue;
      walks[k].point = w.walkPoints[i];
      walks[k].bounces = bouncesAt(walks[k].point.placement, walks[k].bounces);
      active.push_back(k);
    }
  }
}

/// Smooth skies, which are found by specular rays alone, by way of lobes that send none, in the directions of
/// w.lobeSamples. Mirrors show nothing there.
void RadiosityEngine::skyOnLastLobes(std::span<Walk> walks, std::span<const uint32_t> which, uint32_t bounce,
                                     bool truth, Workspace& w) const {
  const Lights& lights = world_.lights();
  for (const uint32_t light : lights.infinite()) {
    if (!lights.isSmooth(light)) continue;
    w.vertexOf.clear(), w.missFrom.clear(), w.missDirection.clear(), w.shadowRays.clear();
    for (const uint32_t i : w.lit) {
      const Walk& walk = walks[which[i]];
      const BsdfSample& s = w.lobeSamples[i];
      if (static_cast<int>(bounce) < walk.most || !(s.pdf > 0) || s.delta || isBlack(s.weight) ||
          !world_.lightsOf(walk.point.placement).sees(light))
        continue;
      w.vertexOf.push_back(i);
      w.missFrom.push_back(walk.point.P), w.missDirection.push_back(s.direction);
    }
    const size_t n = w.vertexOf.size();
    if (n == 0) continue;
    w.missRadiance.resize(n), w.missPdf.resize(n), w.visible.resize(n), w.lightSamples.resize(n);
    lights.evaluate(light, w.missFrom, w.missDirection, w.missRadiance, w.missPdf);
    for (size_t k = 0; k < n; ++k) {
      const Walk& walk = walks[which[w.vertexOf[k]]];
      w.lightSamples[k] = {w.missDirection[k]};
      const float time = world_.rayTime(walk.point.placement, hashOf(walk.seed, kTimeStream, bounce));
      w.shadowRays.push_back({walk.point.facet(), &w.lightSamples[k], light, time, walk.point.footprint, 0});
    }
    world_.transmittance(w.shadowRays, w.visible, truth ? nullptr : opacityCache_.get());
    for (size_t k = 0; k < n; ++k) {
      const uint32_t i = w.vertexOf[k];
      Walk& walk = walks[which[i]];
      walk.radiance += walk.throughput * w.lobeSamples[i].weight * w.missRadiance[k] * w.visible[k];
    }
  }
}

/// Lights by way of the lobes in w.specular: one sample of one light for each walk of w.lit.
void RadiosityEngine::lightLobes(std::span<Walk> walks, std::span<const uint32_t> which, uint32_t bounce,
                                 bool truth, Workspace& w) const {
  const Lights& lights = world_.lights();
  w.lightOfLobe.clear(), w.positions.clear(), w.random.clear();
  for (const uint32_t i : w.lit) {
    const Walk& walk = walks[which[i]];
    const SurfaceTerms& terms = w.specular.terms[i];
    const LightList& list = world_.lightsOf(walk.point.placement);
    if (list.sampled.empty()) continue;
    const Bsdf bsdf(walk.point, terms, w.specular.lobesOf(terms));
    if (!bsdf.scattersSmoothly(false)) continue;
    const float u = toUnit(static_cast<uint32_t>(hashOf(walk.seed, kLightChoiceStream, bounce) >> 32));
    const LightTree::Pick pick = list.pick(bsdf.receiver(), u);
    w.lightOfLobe.push_back({pick.light, i, pick.chance});
  }
  // A call for each light.
  std::stable_sort(w.lightOfLobe.begin(), w.lightOfLobe.end(),
                   [](const auto& a, const auto& b) { return a.light < b.light; });
  for (const Workspace::LightOfLobe& of : w.lightOfLobe) {
    const Walk& walk = walks[which[of.walk]];
    w.positions.push_back(walk.point.P);
    w.random.push_back(sobol2(0, hashOf(walk.seed, kLightPointStream, bounce)));
  }
  const size_t count = w.lightOfLobe.size();
  w.lightSamples.resize(count);
  for (size_t first = 0, end = 0; first < count; first = end) {
    const uint32_t light = w.lightOfLobe[first].light;
    while (end < count && w.lightOfLobe[end].light == light) ++end;
    lights.sample(light, std::span(w.positions).subspan(first, end - first),
                  std::span(w.random).subspan(first, end - first),
                  std::span(w.lightSamples).subspan(first, end - first));
  }
  w.shadowRays.clear(), w.values.clear(), w.vertexOf.clear();
  for (uint32_t k = 0; k < count; ++k) {
    const LightSample& s = w.lightSamples[k];
    if (!(s.pdf > 0)) continue;
    const auto& [light, i, chance] = w.lightOfLobe[k];
    const Walk& walk = walks[which[i]];
    const SurfaceTerms& terms = w.specular.terms[i];
    const Bsdf bsdf(walk.point, terms, w.specular.lobesOf(terms));
    const Bsdf::Value value = bsdf.evaluateSpecular(s.direction);
    if (isBlack(value.f)) continue;
    const float time = world_.rayTime(walk.point.placement, hashOf(walk.seed, kLightPointStream, bounce, 1));
    w.shadowRays.push_back({walk.point.facet(), &s, light, time, walk.point.footprint, raySpread(s, 1)});
    w.values.push_back(value), w.vertexOf.push_back(k);
  }
  w.visible.resize(w.shadowRays.size());
  world_.transmittance(w.shadowRays, w.visible, truth ? nullptr : opacityCache_.get());
  for (size_t k = 0; k < w.shadowRays.size(); ++k) {
    const LightSample& s = *w.shadowRays[k].to;
    const auto& [light, i, chance] = w.lightOfLobe[w.vertexOf[k]];
    Walk& walk = walks[which[i]];
    const float pdf = s.pdf * chance;
    const bool shares = !s.delta && static_cast<int>(bounce) < walk.most;  // else no lobe is followed
    const float weight = shares ? misWeight(pdf, w.values[k].pdf) : 1;
    walk.radiance += walk.throughput * w.values[k].f * s.radiance * w.visible[k] * (weight / pdf);
  }
}

CacheStatistics& cacheStatistics(Level level, int depth) {
  static const std::vector<std::unique_ptr<CacheStatistics>> all = [] {
    std::vector<std::unique_ptr<CacheStatistics>> made;
    for (const char* name : {"coarse", "medium", "fine"})
      for (int d = 0; d <= RadiosityEngine::kCachedDepths + 1; ++d) {
        const std::string path = d > RadiosityEngine::kCachedDepths
                                     ? fmt::format("Irradiance cache/{}/", name)
                                     : fmt::format("Radiosity cache/{}/depth {}/", name, d);
        made.push_back(std::make_unique<CacheStatistics>(CacheStatistics{
            StatCounter(path + "look-ups"), StatCounter(path + "hits"), StatCounter(path + "misses")}));
      }
    return made;
  }();
  return *all[static_cast<size_t>(level) * (RadiosityEngine::kCachedDepths + 2) + static_cast<size_t>(depth)];
}

void RadiosityEngine::Residuals::report() const {
  for (int d = 0; d <= kCachedDepths; ++d) {
    const Depth& all = depths[static_cast<size_t>(d)];
    if (all.count < 2 || all.cached <= 0) continue;
    const double mean = all.residual / all.count, variance = all.squares / all.count - mean * mean;
    const double scale = all.count / all.cached;
    const std::string path = fmt::format("Radiosity cache/residual at depth {}/", d);
    setStatistic(path + "look-ups corrected", all.count);
    setStatistic(path + "mean, relative", mean * scale);
    setStatistic(path + "mean's standard error, relative", std::sqrt(variance / all.count) * scale);
    setStatistic(path + "standard deviation, relative", std::sqrt(variance) * scale);
  }
}

void RadiosityEngine::report() const {
  if (!cache_) return;
  opacityCache_->report();
  const CacheSurvey::Totals values = survey_.totals();
  setStatistic("Radiosity cache/values/made, about", values.made);
  setStatistic("Radiosity cache/values/made again, about", values.again);
  setStatistic("Radiosity cache/values/made and never asked for, about", values.unwanted);
  for (int k = 0; k < kLevels; ++k) {
    const auto level = static_cast<Level>(k);
    const std::string path = fmt::format("Radiosity cache/{}/", k == 0   ? "coarse"
                                                                : k == 1 ? "medium"
                                                                         : "fine");
    setStatistic(path + "slots", static_cast<double>(cache_->slots(level)));
    setStatistic(path + "bytes per slot", static_cast<double>(cache_->bytesPerSlot(level)));
    for (int depth = 0; depth <= kCachedDepths; ++depth) {
      const PatchCache::Use use = cache_->use(level, depth);
      const std::string at = fmt::format("{}depth {}/", path, depth);
      setStatistic(at + "entries", static_cast<double>(use.entries));
      setStatistic(at + "bytes", static_cast<double>(use.bytes));
      setStatistic(at + "evictions", static_cast<double>(use.evictions));
    }
  }
  setStatistic("Radiosity cache/bytes reserved", static_cast<double>(cache_->capacity()));
  residual_.report();
  setStatistic("Radiosity cache/bytes in memory", static_cast<double>(cache_->resident()));
}

}  // namespace patina
