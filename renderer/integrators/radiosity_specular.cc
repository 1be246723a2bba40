// SPDX-License-Identifier: Apache-2.0
// What diffuse rays see in surfaces with lobes; and the statistics of the cache.
#include <fmt/format.h>

#include "renderer/base/statistics.h"
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
  kTimeStream
};

}  // namespace

/// Light that lobes and view-dependent emission of `point` send back along its I: an unbiased walk of one ray
/// per hit, to the first surface without lobes or the specular depth limit. Lights are sampled once per hit.
Rgb RadiosityEngine::specularTail(const ShadingPoint& first, uint64_t seed, int depth, float footprint,
                                  int nesting) const {
  Rgb radiance(0, 0, 0), throughput(1, 1, 1);
  ShadingPoint point = first;
  ShadedPoints& shaded = workspace(nesting).specular;
  int most = 1 << 20;
  ++continuations;
  for (int bounce = 0;; ++bounce) {
    most = std::min(most, bounce + world_.attributesOf(point.placement).maxSpecularDepth);
    world_.shading().shade({&point, 1}, ShadingParts::RadiosityAndView, shaded);
    const SurfaceTerms terms = shaded.terms[0];
    const std::vector<Lobe> lobes(shaded.lobesOf(terms).begin(), shaded.lobesOf(terms).end());
    radiance += throughput * terms.viewEmission;
    if (lobes.empty()) return radiance;
    const Bsdf bsdf(point, terms, lobes);
    const LightList& list = world_.lightsOf(point.placement);
    const Lights& lights = world_.lights();
    if (!list.sampled.empty() && bsdf.scattersSmoothly(false)) {
      const float u = toUnit(
          static_cast<uint32_t>(hashOf(seed, kLightChoiceStream, static_cast<uint32_t>(bounce)) >> 32));
      const LightList::Pick pick = list.pick(u);
      LightSample s;
      const V2f random = sobol2(0, hashOf(seed, kLightPointStream, static_cast<uint32_t>(bounce)));
      lights.sample(pick.light, {&point.P, 1}, {&random, 1}, {&s, 1});
      if (s.pdf > 0) {
        const Bsdf::Value value = bsdf.evaluateSpecular(s.direction);
        if (!isBlack(value.f)) {
          const float pdf = s.pdf * pick.chance, weight = s.delta ? 1 : misWeight(pdf, value.pdf);
          const float time = world_.rayTime(
              point.placement, hashOf(seed, kLightPointStream, static_cast<uint32_t>(bounce), 1));
          radiance += throughput * value.f * s.radiance *
                      world_.transmittance(point.facet(), s, pick.light, time) * (weight / pdf);
        }
      }
    }
    if (bounce >= most) return radiance;
    const float choice =
        toUnit(static_cast<uint32_t>(hashOf(seed, kLobeStream, static_cast<uint32_t>(bounce)) >> 32));
    const BsdfSample s =
        bsdf.sampleSpecular(choice, sobol2(0, hashOf(seed, kDirectionStream, static_cast<uint32_t>(bounce))));
    if (!(s.pdf > 0) || isBlack(s.weight)) return radiance;
    throughput *= s.weight;
    const float time =
        world_.rayTime(point.placement, hashOf(seed, kTimeStream, static_cast<uint32_t>(bounce)));
    const Ray ray{leave(point.facet(), s.direction), s.direction, 0, kInfinity, kSpecularRay, time};
    const Hit hit = world_.accel().intersect(ray);
    const auto lightWeight = [&](uint32_t light, float pdf) {
      return s.delta ? 1 : list.weightOfMet(light, s.pdf, pdf);
    };
    if (!hit.valid()) {
      for (const uint32_t light : lights.infinite()) {
        if (!list.sees(light)) continue;
        Rgb sky;
        float pdf;
        lights.evaluate(light, {&point.P, 1}, {&s.direction, 1}, {&sky, 1}, {&pdf, 1});
        radiance += throughput * sky * lightWeight(light, pdf);
      }
      return radiance;
    }
    footprint += hit.t * std::max(s.alpha, 0.05f);
    const ShadingPoint next = world_.shading().at(hit, s.direction, footprint);
    const uint32_t light = world_.attributesOf(hit.placement).areaLight;
    if (light != kNone && list.sees(light)) {
      const V2f uv = world_.geometry()
                         .surface(world_.geometry().placements()[hit.placement])
                         .surfaceParameters(hit.face, hit.u, hit.v);
      radiance += throughput * lights.emitted(light, next, -s.direction, uv) *
                  lightWeight(light, lights.areaPdf(light, point.P, next));
    }
    if (world_.shading().shaderOf(hit.placement).active(PATINA_ENTRY_RADIOSITY)) {
      Rgb b;
      if (!cachedRadiance(hit, footprint, depth, nesting, b)) {
        const Request request{next, hashOf(seed, kNextStream, static_cast<uint32_t>(bounce))};
        shadeNested({&request, 1}, depth, Purpose::Ray, {&b, 1}, nesting + 1);
      }
      radiance += throughput * b;
    }
    if (!world_.shading().shaderOf(hit.placement).active(PATINA_ENTRY_VIEW)) return radiance;
    point = next;
  }
}

CacheStatistics& cacheStatistics(Level level, int depth) {
  static const std::vector<std::unique_ptr<CacheStatistics>> all = [] {
    std::vector<std::unique_ptr<CacheStatistics>> made;
    for (const char* name : {"coarse", "medium", "fine"})
      for (int d = 0; d <= RadiosityEngine::kCachedDepths; ++d) {
        const std::string path = fmt::format("Radiosity cache/{}/depth {}/", name, d);
        made.push_back(std::make_unique<CacheStatistics>(CacheStatistics{
            StatCounter(path + "look-ups"), StatCounter(path + "hits"), StatCounter(path + "misses")}));
      }
    return made;
  }();
  return *all[static_cast<size_t>(level) * (RadiosityEngine::kCachedDepths + 1) + static_cast<size_t>(depth)];
}

void RadiosityEngine::report() const {
  if (!cache_) return;
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
}

}  // namespace patina
