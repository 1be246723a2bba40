// SPDX-License-Identifier: Apache-2.0
// Light that reaches the camera's points by way of their lobes, from lights that are sampled.
#include "renderer/integrators/radiosity_integrator.h"

namespace patina {
namespace {

// Up to so many delta lights all shine on the lobes of a point. Of more, lights are picked as any others.
constexpr int kMostDeltas = 16;
constexpr int kPicks = 4;  // in place of all delta lights

}  // namespace

int RadiosityIntegrator::picksOf(const LightList& list) { return list.deltas > kMostDeltas ? kPicks : 1; }

/// Whether a specular ray may leave a point: see proceed().
bool RadiosityIntegrator::followsLobes(const Walk& walk, uint32_t placement) const {
  const int most = world_.attributesOf(placement).maxSpecularDepth;
  return !world_.settings().classic && most > 0 && walk.specularDepth < walk.maxSpecular;
}

/// Smooth skies, which are found by specular rays alone, by way of lobes that send none: a direction of the
/// lobe for each point. Mirrors show nothing there.
void RadiosityIntegrator::skyDirect(Wave& wave) const {
  const Lights& lights = world_.lights();
  if (world_.settings().classic) return;
  thread_local std::vector<std::pair<uint32_t, Rgb>> contributions;
  thread_local std::vector<V3f> from, directions;
  thread_local std::vector<Rgb> radiance, visible;
  thread_local std::vector<float> pdf;
  thread_local std::vector<LightSample> samples;
  thread_local std::vector<World::ShadowRay> shadowRays;
  for (const uint32_t light : lights.infinite()) {
    if (!lights.isSmooth(light)) continue;
    contributions.clear(), from.clear(), directions.clear(), shadowRays.clear();
    for (uint32_t i = 0; i < wave.points.size(); ++i) {
      const ShadingPoint& point = wave.points[i];
      const Walk& walk = wave.walks[wave.active[i]];
      if (followsLobes(walk, point.placement) || !world_.lightsOf(point.placement).sees(light)) continue;
      const SurfaceTerms& terms = wave.shaded.terms[i];
      const Bsdf bsdf(point, terms, wave.shaded.lobesOf(terms));
      if (!bsdf.scattersSmoothly(false)) continue;
      const BsdfSample s = bsdf.sampleSpecular(sobol1(walk.sample, hashOf(walk.seed(kLobe), 1)),
                                               sobol2(walk.sample, walk.seed(kDirection)));
      if (!(s.pdf > 0) || s.delta || isBlack(s.weight)) continue;
      contributions.emplace_back(i, s.weight);
      from.push_back(point.P), directions.push_back(s.direction);
    }
    const size_t n = contributions.size();
    if (n == 0) continue;
    radiance.resize(n), pdf.resize(n), visible.resize(n), samples.resize(n);
    lights.evaluate(light, from, directions, radiance, pdf);
    for (size_t k = 0; k < n; ++k) {
      const ShadingPoint& point = wave.points[contributions[k].first];
      const Walk& walk = wave.walks[wave.active[contributions[k].first]];
      samples[k].direction = directions[k];
      const float time = world_.rayTime(point.placement, hashOf(walk.seed(kTime), walk.sample, light));
      shadowRays.push_back({point.facet(), &samples[k], light, time});
    }
    world_.transmittance(shadowRays, visible);
    for (size_t k = 0; k < n; ++k)
      wave.direct[contributions[k].first] += contributions[k].second * radiance[k] * visible[k];
  }
}

/// Direct light by way of lobes: delta lights all, of the others one per point; of many a few.
void RadiosityIntegrator::specularDirect(Wave& wave) const {
  const size_t n = wave.points.size();
  const Lights& lights = world_.lights();
  wave.direct.assign(n, Rgb(0, 0, 0));
  struct Picked {
    uint32_t point;
    float chance;     // the number of times that it is expected to be picked
    uint32_t number;  // of the pick
  };
  thread_local std::vector<std::vector<Picked>> byLight;
  byLight.resize(lights.count());
  for (auto& list : byLight) list.clear();
  for (uint32_t i = 0; i < n; ++i) {
    const LightList& list = world_.lightsOf(wave.points[i].placement);
    if (list.sampled.empty()) continue;
    const SurfaceTerms& terms = wave.shaded.terms[i];
    const Bsdf bsdf(wave.points[i], terms, wave.shaded.lobesOf(terms));
    if (!bsdf.scattersSmoothly(false)) continue;
    const Walk& walk = wave.walks[wave.active[i]];
    const int picks = picksOf(list);
    if (picks == 1)
      for (const uint32_t light : list.sampled)
        if (lights.isDelta(light)) byLight[light].push_back({i, 1, 0});
    const float u = sobol1(walk.sample, walk.seed(kLightChoice)), count = static_cast<float>(picks);
    const LightReceiver at = bsdf.receiver();
    for (int k = 0; k < picks; ++k) {
      const LightTree::Pick pick =
          list.pick(at, std::min((u + static_cast<float>(k)) / count, kOneMinusEpsilon));
      if (picks == 1 && lights.isDelta(pick.light)) continue;
      byLight[pick.light].push_back({i, count * pick.chance, static_cast<uint32_t>(k)});
    }
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
    for (const auto& [i, chance, number] : byLight[light]) {
      const Walk& walk = wave.walks[wave.active[i]];
      positions.push_back(wave.points[i].P);
      const uint64_t seed = walk.seed(kLightPoint);
      random.push_back(sobol2(walk.sample, number ? hashOf(seed, number) : seed));
    }
    samples.resize(positions.size());
    lights.sample(light, positions, random, samples);
    for (size_t k = 0; k < samples.size(); ++k) {
      const LightSample& s = samples[k];
      if (s.pdf == 0) continue;
      const auto [i, chance, number] = byLight[light][k];
      const SurfaceTerms& terms = wave.shaded.terms[i];
      const Bsdf bsdf(wave.points[i], terms, wave.shaded.lobesOf(terms));
      const Bsdf::Value value = bsdf.evaluateSpecular(s.direction);
      if (isBlack(value.f)) continue;
      const float pdf = s.pdf * chance;
      // Where no specular ray follows there is no other estimate to share with.
      const Walk& walk = wave.walks[wave.active[i]];
      const bool shares = !s.delta && followsLobes(walk, wave.points[i].placement);
      const float weight = shares ? misWeight(pdf, value.pdf) : 1;
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

}  // namespace patina
