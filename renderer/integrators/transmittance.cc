// SPDX-License-Identifier: Apache-2.0
// Visibility, and what surfaces that are not opaque let pass.
#include "renderer/base/statistics.h"
#include "renderer/integrators/opacity_cache.h"
#include "renderer/integrators/world.h"

namespace patina {
namespace {

STAT_COUNTER("Shading/opacity look-ups", opacityLookups);
constexpr int kMostLayers = 4096;     // surfaces that a shadow ray passes before it gives up
constexpr float kLeastShare = 1e-4f;  // what lets less pass counts as opaque

}  // namespace

void World::letPass(std::span<Ray> rays, std::span<const Hit> hits, std::span<const uint32_t> which,
                    std::span<const float> widths, const OpacityCache* cache, std::span<Rgb> shares) const {
  struct Scratch {
    std::vector<OpacityCache::Lookup> lookups;
    std::vector<uint32_t> known, shaded, hitOf, goingOn;  // of `which`; of hits; of `which`
    std::vector<Rgb> opacities;
    std::vector<ShadingPoint> points;
    std::vector<uint32_t> pointOf;
    ShadedPoints terms;
  };
  thread_local Scratch w;
  opacityLookups += static_cast<int64_t>(which.size());
  w.opacities.resize(which.size());
  w.lookups.clear(), w.known.clear(), w.shaded.clear(), w.hitOf.clear();
  for (uint32_t k = 0; k < which.size(); ++k) {
    const Hit& hit = hits[which[k]];
    if (!shading_->isOpacityShaded(hit.placement))
      w.known.push_back(k);
    else if (cache)
      w.lookups.push_back({&hit, widths[which[k]], k, false, Rgb(0, 0, 0)});
    else
      w.shaded.push_back(k);
  }
  if (!w.lookups.empty()) cache->lookUp(w.lookups);
  for (const OpacityCache::Lookup& lookup : w.lookups)
    if (lookup.found)
      w.opacities[lookup.user] = lookup.opacity;
    else
      w.shaded.push_back(lookup.user);
  // What the cache has no value for; and what is known without the shader, for which a place will do.
  for (const uint32_t k : w.shaded) w.hitOf.push_back(which[k]);
  pointsAt(
      hits, w.hitOf, [&](uint32_t i) { return std::pair(rays[i].direction, widths[i]); }, w.points);
  w.pointOf.assign(which.size(), kNone);
  for (uint32_t j = 0; j < w.shaded.size(); ++j) w.pointOf[w.shaded[j]] = j;
  for (const uint32_t k : w.known) {
    const Hit& hit = hits[which[k]];
    ShadingPoint& point = w.points.emplace_back();
    point.placement = hit.placement, point.face = hit.face, point.u = hit.u, point.v = hit.v;
    w.shaded.push_back(k);
  }
  shading_->shade(w.points, ShadingParts::Opacity, w.terms);
  for (size_t j = 0; j < w.shaded.size(); ++j) w.opacities[w.shaded[j]] = w.terms.terms[j].opacity;

  w.goingOn.clear();
  for (uint32_t k = 0; k < which.size(); ++k) {
    for (int c = 0; c < 3; ++c) shares[k][c] *= std::clamp(1 - w.opacities[k][c], 0.0f, 1.0f);
    if (maxComponent(shares[k]) < kLeastShare)
      shares[k] = Rgb(0, 0, 0);
    else
      w.goingOn.push_back(k);
  }
  geometry_->orderByUnit(w.goingOn, [&](uint32_t k) { return hits[which[k]].placement; });
  for (const uint32_t k : w.goingOn) {
    Ray& ray = rays[which[k]];
    const Hit& hit = hits[which[k]];
    const uint32_t point = w.pointOf[k];
    ray.origin = goOn(
        ray, hit,
        point == kNone ? geometry_->facet(hit.placement, hit.face, hit.u, hit.v) : w.points[point].facet());
  }
}

void World::transmittance(std::span<const ShadowRay> wanted, std::span<Rgb> shares,
                          const OpacityCache* cache) const {
  traceShadows(wanted, shares, cache);
  if (!lights_->hasShadowColors()) return;
  for (size_t k = 0; k < wanted.size(); ++k)
    shares[k] += (Rgb(1, 1, 1) - shares[k]) * lights_->shadowColor(wanted[k].light);
}

void World::traceShadows(std::span<const ShadowRay> wanted, std::span<Rgb> shares,
                         const OpacityCache* cache) const {
  struct Scratch {
    std::vector<Ray> rays;
    std::vector<uint32_t> rayOf, which;  // the shadow ray of a ray; of rays
    std::vector<uint8_t> occluded;
    std::vector<Hit> hits;
    std::vector<float> widths;
    std::vector<Rgb> passed;  // by `which`
  };
  thread_local Scratch w;
  w.rays.clear(), w.rayOf.clear();
  for (uint32_t k = 0; k < wanted.size(); ++k) {
    const auto& [from, to, light, time, width, spread] = wanted[k];
    shares[k] = Rgb(1, 1, 1);
    if (settings_.classic || !lights_->castsShadows(light)) continue;
    Ray ray;
    ray.mask = kTransmissionRay, ray.time = time;
    ray.origin = leave(from, to->direction);
    if (std::isinf(to->distance)) {
      ray.direction = to->direction;
    } else {
      ray.direction = to->target - ray.origin;
      ray.tFar = 1 - 4 * kMachineEpsilon;
    }
    w.rays.push_back(ray), w.rayOf.push_back(k);
  }
  if (shading_->allOpaque()) {
    w.occluded.resize(w.rays.size());
    accel_->occluded(w.rays, w.occluded);
    // One of the rays may have been the first to meet a delayed archive, with something transparent in it.
    if (shading_->allOpaque()) {
      for (size_t i = 0; i < w.rays.size(); ++i)
        if (w.occluded[i]) shares[w.rayOf[i]] = Rgb(0, 0, 0);
      return;
    }
  }
  w.widths.clear();
  for (const uint32_t k : w.rayOf) w.widths.push_back(cache ? wanted[k].width : 0);
  for (int layer = 0; !w.rays.empty(); ++layer) {
    w.hits.resize(w.rays.size());
    accel_->intersect(w.rays, w.hits);
    w.which.clear(), w.passed.clear();
    for (uint32_t i = 0; i < w.rays.size(); ++i) {
      const uint32_t k = w.rayOf[i];
      if (!w.hits[i].valid()) continue;
      if (layer >= kMostLayers || shading_->isOpaque(w.hits[i].placement)) {
        shares[k] = Rgb(0, 0, 0);
        continue;
      }
      if (cache && wanted[k].spread > 0)
        w.widths[i] += wanted[k].spread * w.hits[i].t * w.rays[i].direction.length();
      w.which.push_back(i), w.passed.push_back(shares[k]);
    }
    letPass(w.rays, w.hits, w.which, w.widths, cache, w.passed);
    size_t kept = 0;
    for (size_t j = 0; j < w.which.size(); ++j) {
      const uint32_t i = w.which[j], k = w.rayOf[i];
      shares[k] = w.passed[j];
      if (isBlack(shares[k])) continue;
      Ray ray = w.rays[i];
      if (!std::isinf(wanted[k].to->distance)) ray.direction = wanted[k].to->target - ray.origin;
      w.rays[kept] = ray;
      w.widths[kept] = w.widths[i];
      w.rayOf[kept++] = k;
    }
    w.rays.resize(kept), w.rayOf.resize(kept), w.widths.resize(kept);
  }
}

}  // namespace patina
