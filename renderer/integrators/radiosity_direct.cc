// SPDX-License-Identifier: Apache-2.0
// Direct light: lights are sampled without shadows, all of a few, of many those that are picked from their
// hierarchy; where that makes more samples than shadow rays are worth, those are traced that promise most
// (resampled importance sampling after Talbot et al. 2005, with systematic selection): the number of shadow
// rays depends on the depth, and hardly on the number of lights.
#include <algorithm>

#include "renderer/base/sampling_batch.h"
#include "renderer/base/statistics.h"
#include "renderer/integrators/radiosity_workspace.h"

namespace patina {
namespace {

STAT_COUNTER("Radiosity/light samples", lightSampleCount);
STAT_COUNTER("Radiosity/light samples that got no shadow ray", passedOver);

// Random numbers at a point.
enum Stream : uint64_t { kTimeStream = 5, kSelectStream = 6, kPickStream = 7, kLightStream = 16 };

/// So many times the samples of one light are spread over all lights when there are more.
constexpr int kLightsWorth = 4;
/// Lights that are tried for a shadow ray: twice as many as there are such rays, but no more than this. A
/// light that is tried costs as much as a ray. Of more lights, so many are picked for each point.
constexpr uint32_t kMostCandidates = 64;
/// Of more than kLightsWorth lights, so many are picked for a point that one ray met.
constexpr uint32_t kRayCandidates = 2;
/// Points are lit together up to so many, and up to so many samples of a light.
constexpr size_t kPointsAtOnce = 1024, kSamplesAtOnce = size_t{1} << 20;

}  // namespace

void RadiosityEngine::addDirect(std::span<const Request> requests, int depth, Purpose purpose,
                                Workspace& w) const {
  const auto samples = static_cast<size_t>(settings_.rays.light(depth, purpose));
  const size_t batch = std::clamp<size_t>(kSamplesAtOnce / samples, 1, kPointsAtOnce);
  for (size_t first = 0; first < requests.size(); first += batch)
    addDirect(requests, first, std::min(first + batch, requests.size()), depth, purpose, w);
}

void RadiosityEngine::addDirect(std::span<const Request> requests, size_t first, size_t end, int depth,
                                Purpose purpose, Workspace& w) const {
  const Lights& lights = world_.lights();
  const int wanted = settings_.rays.light(depth, purpose), most = kLightsWorth * wanted;
  // Rays make many points, of which each does with few.
  const auto candidates =
      isRay(purpose) ? kRayCandidates : std::min(static_cast<uint32_t>(2 * most), kMostCandidates);
  const size_t all = isRay(purpose) ? static_cast<size_t>(kLightsWorth) : candidates;
  w.lightOf.clear();
  for (auto i = static_cast<uint32_t>(first); i < end; ++i) {
    const SurfaceTerms& terms = w.shaded.terms[i];
    if (isBlack(terms.reflectance) && isBlack(terms.transmittance)) continue;
    const LightList& list = world_.lightsOf(w.points[i].placement);
    const size_t n = list.sampled.size();
    if (n <= all) {
      // Of each area light fewer samples, when there are many.
      const auto areas = static_cast<int>(n) - list.deltas;
      const auto count = static_cast<uint32_t>(std::clamp(most / std::max(areas, 1), 1, wanted));
      for (const uint32_t light : list.sampled) {
        const uint32_t own = takesOneSample(light) ? 1 : count;
        w.lightOf.push_back({light, i, own, own, 1.0f});
      }
      continue;
    }
    const uint64_t seed = hashOf(requests[i].seed, kPickStream);
    const LightReceiver at{w.points[i].P, w.points[i].Ng, !isBlack(terms.transmittance)};
    list.pickMany(at, candidates, sobol1(static_cast<uint32_t>(requests[i].sample), seed), w.lightPicks);
    for (const LightTree::Picks& picks : w.lightPicks) {
      const auto count = takesOneSample(picks.light) ? 1u : picks.count;
      w.lightOf.push_back(
          {picks.light, i, count, candidates,
           static_cast<float>(picks.count) / (picks.chance * static_cast<float>(candidates))});
    }
  }
  std::stable_sort(w.lightOf.begin(), w.lightOf.end(),
                   [](const auto& a, const auto& b) { return a.light < b.light; });
  // What each light would give without shadows.
  w.lightSamples.clear(), w.shadowed.clear();
  w.promised.assign(end - first, {});
  for (size_t begin = 0, next = 0; begin < w.lightOf.size(); begin = next) {
    const uint32_t light = w.lightOf[begin].light;
    const bool shared = lights.isShared(light);
    w.positions.clear(), w.random.clear();
    for (next = begin; next < w.lightOf.size() && w.lightOf[next].light == light; ++next) {
      const Workspace::LightOf& of = w.lightOf[next];
      const Request& request = requests[of.request];
      const size_t sofar = w.random.size();
      w.positions.resize(sofar + of.count, w.points[of.request].P), w.random.resize(sofar + of.count);
      sobolPoints(request.sample * of.stride, hashOf(request.seed, kLightStream, light),
                  std::span(w.random).subspan(sofar));
    }
    const size_t offset = w.lightSamples.size();
    w.lightSamples.resize(offset + w.positions.size());
    lights.sample(light, w.positions, w.random, std::span(w.lightSamples).subspan(offset));
    lightSampleCount += static_cast<int64_t>(w.positions.size());
    size_t at = offset;
    for (size_t entry = begin; entry < next; ++entry) {
      const auto [ignored, i, count, stride, share] = w.lightOf[entry];
      const ShadingPoint& point = w.points[i];
      const SurfaceTerms& terms = w.shaded.terms[i];
      for (uint32_t k = 0; k < count; ++k, ++at) {
        const LightSample& s = w.lightSamples[at];
        if (s.pdf == 0) continue;
        const bool above = s.direction.dot(point.Ng) > 0;
        const Rgb& scattered = above ? terms.reflectance : terms.transmittance;
        if (isBlack(scattered)) continue;
        const float side = above ? 1.0f : -1.0f;
        const float cosine = s.delta ? s.direction.dot(point.N) * side
                                     : foldedCosine(s.direction, point.N * side, point.Ng * side);
        if (!(cosine > 0)) continue;
        float weight = cosine * share / (s.pdf * static_cast<float>(count));
        if (shared && sharesSkies(requests[i])) weight *= 1 - skyPart(cosine, s.pdf);
        const float promise = weight * maxComponent(s.radiance * scattered);
        w.shadowed.push_back({i, static_cast<uint32_t>(at), light, k, above, weight, promise});
        Workspace::Promised& sum = w.promised[i - first];
        sum.all += promise, ++sum.count;
      }
    }
  }
  const bool truth = settings_.residual > 0 && (purpose == Purpose::Sample || purpose == Purpose::Truth);
  // How many rays share a light, as far as their width goes: points nearby have rays of their own.
  const int sharing = isRay(purpose) ? kLightsWorth : settings_.rays.light(depth, Purpose::Vertex);
  const bool moves = world_.geometry().samplesMotion();
  // Which of them get a shadow ray.
  w.shadowRays.clear();
  size_t kept = 0;
  for (Workspace::Shadowed s : w.shadowed) {
    Workspace::Promised& sum = w.promised[s.request - first];
    if (sum.count > most) {
      if (sum.reached == 0)
        sum.offset = toUnit(static_cast<uint32_t>(
            hashOf(requests[s.request].seed, kSelectStream, requests[s.request].sample) >> 32));
      const float chance = sum.all > 0 ? std::min(1.0f, static_cast<float>(most) * s.promise / sum.all) : 0;
      const float before = std::floor(sum.reached + sum.offset);
      sum.reached += chance;
      if (chance < 1 && !(std::floor(sum.reached + sum.offset) > before)) {
        ++passedOver;
        continue;
      }
      s.weight /= chance;
    }
    const Request& request = requests[s.request];
    const float time =
        moves ? world_.rayTime(w.points[s.request].placement,
                               hashOf(request.seed, kTimeStream, s.light, s.number + request.sample))
              : 0;
    w.shadowRays.push_back({w.points[s.request].facet(), &w.lightSamples[s.sample], s.light, time,
                            w.points[s.request].footprint, raySpread(w.lightSamples[s.sample], sharing)});
    w.shadowed[kept++] = s;
  }
  w.shadowed.resize(kept);
  w.visible.resize(kept);
  world_.transmittance(w.shadowRays, w.visible, truth ? nullptr : opacityCache_.get());
  for (size_t k = 0; k < kept; ++k) {
    const Workspace::Shadowed& s = w.shadowed[k];
    (s.above ? w.front : w.back)[s.request] += w.lightSamples[s.sample].radiance * w.visible[k] * s.weight;
  }
}

}  // namespace patina
