// SPDX-License-Identifier: Apache-2.0
// Indirect light and the sky: many gathers' rays at a time.
#include "renderer/base/sampling_batch.h"
#include "renderer/base/statistics.h"
#include "renderer/integrators/baked_points.h"
#include "renderer/integrators/met_point.h"
#include "renderer/integrators/radiosity_workspace.h"

namespace patina {
namespace {

STAT_COUNTER("Radiosity/points shaded at hits", hitPoints);
STAT_COUNTER("Radiosity/gather rays", gatherRays);
STAT_COUNTER("Radiosity/gather rays ended by chance behind layers", layerEnds);

// Random numbers at a point.
enum Stream : uint64_t {
  kGatherStream = 1,
  kBackGatherStream,
  kRouletteStream,
  kChildStream,
  kPassStream,
  kTakeStream
};

constexpr int kRouletteDepth = RadiosityEngine::kCachedDepths;
constexpr uint32_t kMostLayers = 256;  // surfaces that a ray passes before it gives up
constexpr float kWorthFollowing = 0.25f;

}  // namespace

template <class Directs>
void RadiosityEngine::Residuals::add(const Directs& directs, std::span<const Rgb> truths, int depth) {
  Depth sum;
  for (size_t k = 0; k < directs.size(); ++k) {
    const Rgb& cached = directs[k].cached;
    if (cached.x < 0) continue;
    const double c = (cached.x + cached.y + cached.z) / 3, t = (truths[k].x + truths[k].y + truths[k].z) / 3;
    sum.count += 1, sum.cached += c, sum.residual += t - c, sum.squares += (t - c) * (t - c);
  }
  if (sum.count == 0) return;
  const std::scoped_lock lock(mutex);
  Depth& all = depths[static_cast<size_t>(std::min(depth, kCachedDepths))];
  all.count += sum.count, all.cached += sum.cached, all.residual += sum.residual, all.squares += sum.squares;
}

void RadiosityEngine::addIndirect(std::span<const Request> requests, int depth, Purpose purpose, Workspace& w,
                                  int nesting, std::span<const Spot> spots) const {
  if (world_.settings().classic) return;
  w.senders.clear(), w.irradianceWanted.clear(), w.irradianceSlot.clear();
  // E = integral of L cos over the hemisphere; with density cos/pi a ray's weight is pi / count.
  const int count = settings_.rays.diffuse(depth, purpose);
  const int spread = isRay(purpose) ? 4 : settings_.rays.diffuse(depth, Purpose::Vertex);
  const float residual = purpose == Purpose::Sample ? 1 / static_cast<float>(count) : settings_.residual;
  const bool truth = settings_.residual > 0 && (purpose == Purpose::Sample || purpose == Purpose::Truth);
  for (uint32_t i = 0; i < requests.size(); ++i) {
    if (requests[i].indirect) {
      w.indirect[i] = *requests[i].indirect;
      continue;
    }
    const SurfaceTerms& terms = w.shaded.terms[i];
    const int bounces = settings_.indirect ? requests[i].bounces : 0;
    if (bounces <= 0 && !world_.lightsOf(w.points[i].placement).smooth) continue;
    float roulette = 1;
    if (bounces > 0 && isRay(purpose) && depth > kRouletteDepth) {
      const float survive = std::clamp(
          std::max(maxComponent(terms.reflectance), maxComponent(terms.transmittance)), 0.05f, 0.95f);
      if (toUnit(static_cast<uint32_t>(hashOf(requests[i].seed, kRouletteStream) >> 32)) >= survive) continue;
      roulette = 1 / survive;
    }
    for (const bool behind : {false, true}) {
      if (isBlack(behind ? terms.transmittance : terms.reflectance)) continue;
      if (spots.empty()) {
        w.senders.push_back({i, behind, residual, static_cast<int>(requests[i].sample) * count, count, spread,
                             kPi * roulette / static_cast<float>(count)});
        continue;
      }
      // What is behind one side is in front of the other.
      const Spot& spot = spots[i];
      for (int k = 0; k < spot.around.count; ++k) {
        w.irradianceWanted.push_back(
            {spot.patch, spot.front != behind, static_cast<uint16_t>(spot.around.index[k]), spot.bounces});
        w.irradianceSlot.push_back({2 * i + (behind ? 1u : 0u), spot.around.weight[k]});
      }
    }
  }
  if (spots.empty()) {
    gather(requests, depth, truth, w, nesting);
    for (const Workspace::Sender& sender : w.senders) {
      Irradiance& to = w.indirect[sender.request];
      (sender.behind ? to.back : to.front) += sender.received;
    }
    return;
  }
  w.irradianceFound.resize(w.irradianceWanted.size());
  irradiance(w.irradianceWanted, w.irradianceFound, nesting);
  for (size_t k = 0; k < w.irradianceSlot.size(); ++k) {
    const auto [slot, weight] = w.irradianceSlot[k];
    Irradiance& to = w.indirect[slot / 2];
    (slot & 1u ? to.back : to.front) += w.irradianceFound[k] * weight;
  }
}

/// The irradiance of lights that are sampled, in front of points: a few shadow rays to each.
void RadiosityEngine::estimateDirect(std::span<const Request> requests, Workspace& w) const {
  prepare(requests, w);
  addDirect(requests, 1, Purpose::FineVertex, w);
  for (size_t i = 0; i < requests.size(); ++i) w.gathered[i].direct = maxComponent(w.front[i]);
  w.front.assign(requests.size(), Rgb(0, 0, 0));
}

void RadiosityEngine::gatherFront(std::span<const Request> requests, std::span<const float> shares,
                                  Workspace& w, int nesting) const {
  w.points.clear();
  for (const Request& request : requests) w.points.push_back(request.point);
  w.front.assign(requests.size(), Rgb(0, 0, 0));
  w.distances.assign(requests.size(), {});
  if (settings_.points) {
    for (size_t i = 0; i < requests.size(); ++i) {
      const ShadingPoint& point = w.points[i];
      const bool lit = settings_.indirect && requests[i].bounces > 0;
      if (!lit && !world_.lightsOf(point.placement).smooth) continue;
      const PointRaster::Estimate seen = settings_.points->irradiance(point, false, requests[i].seed, lit);
      w.front[i] = seen.irradiance;
      w.distances[i].inverse = seen.inverseDistance, w.distances[i].nearest = seen.nearest;
    }
    return;
  }
  w.gathered.assign(requests.size(), {});
  estimateDirect(requests, w);
  w.measures = true;
  const int nominal = settings_.rays.diffuse(0, Purpose::Vertex);
  // Quarters of few rays say nothing of how good they are.
  constexpr int kFewRays = 64;
  // A pixel is never left to fewer, however many vertices it has.
  constexpr int kLeastRays = 32;
  for (size_t i = 0; i < requests.size(); ++i) {
    Workspace::Gathered& g = w.gathered[i];
    const float share = shares[i];
    int rays = nominal;
    while (rays >= 2 * kLeastRays && static_cast<float>(rays) > static_cast<float>(nominal) * share)
      rays /= 2;
    g.share = static_cast<float>(rays) / static_cast<float>(nominal);
    g.next = rays < kFewRays ? rays : rays / 2;
    g.most = rays < kFewRays ? rays : 4 * g.next;
  }
  // Twice as many rays in each round, for those whose quarters do not agree yet.
  for (;;) {
    w.senders.clear();
    for (uint32_t i = 0; i < requests.size(); ++i) {
      Workspace::Gathered& g = w.gathered[i];
      if (g.done) continue;
      if ((!settings_.indirect || requests[i].bounces <= 0) &&
          !world_.lightsOf(requests[i].point.placement).smooth) {
        g.done = true;
        continue;
      }
      const int parts = g.rays == 0 ? 4 : 2, add = g.next - g.rays;
      for (int k = 0; k < parts; ++k) {
        const int first = add * k / parts, end = add * (k + 1) / parts;
        w.senders.push_back({i, false, 0, g.rays + first, end - first, nominal, 1});
      }
    }
    if (w.senders.empty()) break;
    gather(requests, 0, false, w, nesting);
    for (size_t k = 0; k < w.senders.size();) {
      const uint32_t i = w.senders[k].request;
      Workspace::Gathered& g = w.gathered[i];
      std::array<Rgb, 4>& q = g.quarters;
      if (g.rays > 0) q[0] += q[1], q[1] = q[2] + q[3];
      for (size_t part = g.rays > 0 ? 2 : 0; part < 4; ++part) q[part] = w.senders[k++].received;
      g.rays = g.next;
      g.next = std::min(2 * g.rays, g.most);
      const auto rays = static_cast<float>(g.rays);
      const Rgb sum = q[0] + q[1] + q[2] + q[3];
      // The variance of the mean from that between the quarters.
      float variance = 0;
      for (int c = 0; c < 3; ++c) {
        float squares = 0;
        for (size_t part = 0; part < 4; ++part)
          squares += (q[part][c] - sum[c] / 4) * (q[part][c] - sum[c] / 4);
        variance = std::max(variance, squares / 3 * 4);
      }
      const float light = maxComponent(sum) + std::min(g.direct * rays / kPi, kRelief * maxComponent(sum));
      const float tolerated = settings_.gatherError * light;
      g.done = g.rays >= g.most || variance * g.share <= tolerated * tolerated;
      if (!g.done) continue;
      w.front[i] = sum * (kPi / rays);
      w.distances[i].noise = std::sqrt(variance) * (kPi / rays);
      w.distances[i].direct = g.direct;
    }
  }
  w.measures = false;
  for (size_t i = 0; i < requests.size(); ++i) {
    // Ward's estimate, and the mean over the light in place of that over directions: where most of those are
    // empty, the gradient is that of the little that is there.
    Workspace::Distances& d = w.distances[i];
    const auto rays = static_cast<float>(std::max(w.gathered[i].rays, 1));
    const float light = maxComponent(w.front[i]) * rays * kInvPi;
    d.inverse = std::max(d.inverse / rays, light > 0 ? d.lit / light : 0);
  }
}

/// In place of rays: each sender receives what its rays would, all in all.
void RadiosityEngine::lookAtPoints(std::span<const Request> requests, Workspace& w) const {
  for (Workspace::Sender& sender : w.senders) {
    const Request& request = requests[sender.request];
    const bool lit = settings_.indirect && request.bounces > 0;
    const Rgb irradiance =
        settings_.points
            ->irradiance(w.points[sender.request], sender.behind, hashOf(request.seed, request.sample), lit)
            .irradiance;
    sender.received = irradiance * (sender.weight * static_cast<float>(sender.count) * kInvPi);
  }
}

void RadiosityEngine::gather(std::span<const Request> requests, int depth, bool truth, Workspace& w,
                             int nesting) const {
  if (settings_.points) {
    lookAtPoints(requests, w);
    return;
  }
  const Lights& lights = world_.lights();
  w.missed.clear(), w.direct.clear(), w.rays.clear(), w.gather.clear(), w.inverseMet.clear();
  const size_t batch = raysAtOnce();
  uint32_t number = 0;
  for (uint32_t slot = 0; slot < w.senders.size(); ++slot) {
    Workspace::Sender& sender = w.senders[slot];
    sender.received = Rgb(0, 0, 0);
    const uint32_t i = sender.request;
    const bool behind = sender.behind;
    const ShadingPoint& point = w.points[i];
    const Frame frame(behind ? -point.N : point.N);
    const uint64_t seed = hashOf(requests[i].seed, behind ? kBackGatherStream : kGatherStream);
    gatherRays += sender.count;
    const V3f up = behind ? -point.Ng : point.Ng, origin = leave(point.facet(), up);
    GatherRay ray;
    ray.weight = sender.weight, ray.residual = sender.residual;
    ray.slot = slot;
    ray.bounces = settings_.indirect ? requests[i].bounces : 0;
    const uint64_t child = hashOf(seed, kChildStream);
    CosineDirections local;
    for (int k = sender.first, lane = 0; k < sender.first + sender.count; ++k, ++lane) {
      lane %= static_cast<int>(CosineDirections::kCount);
      if (lane == 0)
        local.sample(static_cast<uint32_t>(k), seed, static_cast<uint32_t>(sender.first + sender.count - k));
      const auto at = static_cast<size_t>(lane);
      const V3f direction = foldDirection(frame.toWorld({local.x[at], local.y[at], local.z[at]}), up);
      ray.spread = std::sqrt(kPi / (static_cast<float>(sender.spread) * std::max(local.z[at], 0.05f)));
      ray.seed = mixBits(child ^ static_cast<uint32_t>(k));
      ray.number = number++;
      w.rays.push_back(
          {origin, direction, 0, kInfinity, kDiffuseRay, world_.rayTime(point.placement, ray.seed)});
      w.gather.push_back(ray);
      if (w.rays.size() >= batch) trace(depth, truth, w, nesting);
    }
  }
  trace(depth, truth, w, nesting);
  // However rays were put into batches, what they found is added in the order of rays.
  const auto byNumber = [](const auto& a, const auto& b) { return a.number < b.number; };
  const auto irradiance = [&](uint32_t slot) -> Rgb& { return w.senders[slot].received; };
  if (!std::is_sorted(w.missed.begin(), w.missed.end(), byNumber))
    std::stable_sort(w.missed.begin(), w.missed.end(), byNumber);
  w.missFrom.clear(), w.missDirection.clear();
  for (const Workspace::Missed& m : w.missed)
    w.missFrom.push_back(m.from), w.missDirection.push_back(m.direction);
  // Light from the sky, a light at a time.
  for (const uint32_t light : lights.infinite()) {
    const bool shared = lights.isShared(light);
    if (w.missed.empty() || !(shared || lights.isSmooth(light))) continue;
    w.missRadiance.resize(w.missed.size()), w.missPdf.resize(w.missed.size());
    lights.evaluate(light, w.missFrom, w.missDirection, w.missRadiance, w.missPdf);
    for (size_t k = 0; k < w.missed.size(); ++k) {
      const Workspace::Sender& sender = w.senders[w.missed[k].slot];
      const ShadingPoint& point = w.points[sender.request];
      if (!world_.lightsOf(point.placement).sees(light)) continue;
      float part = 1;
      if (shared) {
        if (!sharesSkies(requests[sender.request])) continue;
        const float side = sender.behind ? -1.0f : 1.0f;
        part = skyPart(foldedCosine(w.missed[k].direction, point.N * side, point.Ng * side), w.missPdf[k]);
      }
      irradiance(w.missed[k].slot) += w.missRadiance[k] * w.missed[k].weight * part;
    }
  }
  // Hits that the cache has no place for.
  if (w.direct.empty()) return;
  if (!std::is_sorted(w.direct.begin(), w.direct.end(), byNumber))
    std::stable_sort(w.direct.begin(), w.direct.end(), byNumber);
  hitPoints += static_cast<int64_t>(w.direct.size());
  w.directRequests.clear();
  for (const Workspace::Direct& d : w.direct) w.directRequests.push_back(d.request);
  w.directRadiance.resize(w.direct.size());
  const Purpose atHits = truth                                         ? Purpose::Truth
                         : settings_.fullHits && depth < kCachedDepths ? Purpose::FineVertex
                                                                       : Purpose::Ray;
  shadeNested(w.directRequests, depth + 1, atHits, w.directRadiance, nesting + 1);
  for (size_t k = 0; k < w.direct.size(); ++k) {
    const Workspace::Direct& d = w.direct[k];
    const Rgb light = w.directRadiance[k] * d.weight;
    irradiance(d.slot) += light;
    if (w.measures)
      w.distances[w.senders[d.slot].request].lit += maxComponent(light) * w.inverseMet[d.number];
  }
  if (truth) residual_.add(w.direct, w.directRadiance, depth + 1);
}

/// Rays go on through what they have met and is not opaque, into nextRays, and it is said how much the values
/// of what they have met count.
///
/// At depth 0 a ray takes all layers' values, and goes on for certain until kWorthFollowing is left of it. Of
/// deeper rays each stands for a small part of a value. They would branch at every layer, as would the rays
/// that those values need: hence they go on by the chance that light does, and of thin layers they take the
/// values of some alone. That chance does not go down with the opacity of the place: what is looked up was
/// made for all of a micropolygon, holes included.
void RadiosityEngine::passOn(int depth, bool truth, uint32_t layer, Workspace& w) const {
  w.nextRays.clear(), w.nextGather.clear();
  if (w.passing.empty()) return;
  w.beyond = w.rays;
  w.widths.resize(w.rays.size()), w.passed.clear();
  for (const uint32_t k : w.passing) {
    w.widths[k] = w.gather[k].spread * w.gather[k].travelled;
    w.passed.push_back(w.gather[k].share);
  }
  world_.letPass(w.beyond, w.hits, w.passing, w.widths, truth ? nullptr : opacityCache_.get(), w.passed);
  for (size_t i = 0; i < w.passing.size(); ++i) {
    GatherRay& ray = w.gather[w.passing[i]];
    const auto chanceHolds = [&](Stream stream, float chance) {
      return chance >= 1 || toUnit(static_cast<uint32_t>(hashOf(ray.seed, stream, layer) >> 32)) < chance;
    };
    const float left = maxComponent(w.passed[i]);
    const float chance = std::min(left / (depth > 0 ? maxComponent(ray.share) : kWorthFollowing), 1.0f);
    if (chanceHolds(kPassStream, chance)) {
      w.nextRays.push_back(w.beyond[w.passing[i]]);
      w.nextGather.push_back(ray);
      w.nextGather.back().share = w.passed[i] / chance;
    } else if (chance > 0) {
      ++layerEnds;
    }
    if (depth == 0) continue;
    const float take = std::max(1 - chance, kWorthFollowing);
    ray.taken = chanceHolds(kTakeStream, take) ? 1 / take : 0;
  }
}

void RadiosityEngine::trace(int depth, bool truth, Workspace& w, int nesting) const {
  if (w.rays.empty()) return;
  const uint32_t first = w.gather[0].number;
  w.found.assign(w.rays.size(), Rgb(0, 0, 0)), w.slot.clear();
  for (const GatherRay& ray : w.gather) w.slot.push_back(ray.slot);
  if (w.measures) w.inverseMet.resize(first + w.rays.size(), 0.0f);
  const SurfaceShading& shading = world_.shading();
  const bool caustics = world_.caustics();
  for (uint32_t layer = 0; layer < kMostLayers && !w.rays.empty(); ++layer) {
    const size_t n = w.rays.size();
    w.hits.resize(n);
    world_.accel().intersect(w.rays, w.hits);
    w.lookups.clear(), w.withPoints.clear(), w.passing.clear(), w.met.clear();
    std::vector<uint32_t>& lobes = w.which;
    lobes.clear();
    w.pointOf.assign(n, kNone);
    for (uint32_t k = 0; k < n; ++k) {
      GatherRay& ray = w.gather[k];
      const Hit& hit = w.hits[k];
      if (!hit.valid()) {
        w.missed.push_back(
            {ray.number, ray.slot, w.rays[k].origin, w.rays[k].direction, ray.share * ray.weight});
        continue;
      }
      if (w.measures && layer == 0) {
        Workspace::Distances& d = w.distances[w.senders[ray.slot].request];
        d.inverse += 1 / hit.t, d.nearest = std::min(d.nearest, hit.t);
        w.inverseMet[ray.number] = 1 / hit.t;
      }
      const bool opaque = shading.isOpaque(hit.placement);
      if (ray.bounces <= 0 && opaque) continue;
      ray.travelled += hit.t, ray.taken = 1;
      w.met.push_back(k);
      if (!opaque) w.passing.push_back(k);
    }
    passOn(depth, truth, layer, w);
    for (const uint32_t k : w.met) {
      const GatherRay& ray = w.gather[k];
      const Hit& hit = w.hits[k];
      if (ray.bounces <= 0 || ray.taken == 0) continue;
      const ShaderInstance& shader = shading.shaderOf(hit.placement);
      if (shader.active(PATINA_ENTRY_RADIOSITY))
        w.lookups.push_back({&hit, bouncesAt(hit.placement, ray.bounces - 1), ray.spread * ray.travelled, k});
      if (caustics && shader.active(PATINA_ENTRY_VIEW)) lobes.push_back(k);
    }
    lookUp(w.lookups, depth + 1, nesting);
    const auto needPoint = [&](uint32_t k) {
      if (w.pointOf[k] != kNone) return;
      w.pointOf[k] = static_cast<uint32_t>(w.withPoints.size());
      w.withPoints.push_back(k);
    };
    for (Lookup& lookup : w.lookups) {
      const GatherRay& ray = w.gather[lookup.user];
      if (truth) correct(lookup, ray.residual, ray.seed);
      if (lookup.found)
        w.found[ray.number - first] +=
            lookup.radiance * (ray.share * (ray.weight * ray.taken * (1 - lookup.truth)));
      if (lookup.truth > 0) needPoint(lookup.user);
    }
    std::for_each(lobes.begin(), lobes.end(), needPoint);
    world_.pointsAt(
        w.hits, w.withPoints,
        [&](uint32_t k) {
          return std::pair(w.rays[k].direction, w.gather[k].spread * w.gather[k].travelled);
        },
        w.hitPoints);
    for (size_t i = 0; i < w.withPoints.size(); ++i)
      placeAlongRay(w.hitPoints[i], world_, w.rays[w.withPoints[i]], w.hits[w.withPoints[i]]);
    const auto pointAt = [&](uint32_t k) -> const ShadingPoint& { return w.hitPoints[w.pointOf[k]]; };
    for (const Lookup& lookup : w.lookups) {
      if (lookup.truth == 0) continue;
      const GatherRay& ray = w.gather[lookup.user];
      w.direct.push_back({ray.number,
                          ray.slot,
                          ray.share * (ray.weight * ray.taken * lookup.truth),
                          {pointAt(lookup.user), ray.seed, lookup.bounces},
                          lookup.found ? lookup.radiance : Rgb(-1, -1, -1)});
    }
    if (!lobes.empty()) {
      w.walks.clear();
      for (const uint32_t k : lobes) {
        Walk& walk = w.walks.emplace_back();
        walk.point = pointAt(k), walk.seed = hashOf(w.gather[k].seed, layer);
        walk.footprint = walk.point.footprint, walk.user = k;
        walk.bounces = bouncesAt(walk.point.placement, w.gather[k].bounces - 1);
      }
      followLobes(w.walks, depth + 1, truth, nesting);
      for (const Walk& walk : w.walks) {
        const GatherRay& ray = w.gather[walk.user];
        w.found[ray.number - first] += walk.radiance * (ray.share * (ray.weight * ray.taken));
      }
    }
    w.rays.swap(w.nextRays), w.gather.swap(w.nextGather);
  }
  w.rays.clear(), w.gather.clear();
  for (size_t k = 0; k < w.found.size(); ++k) {
    Workspace::Sender& sender = w.senders[w.slot[k]];
    sender.received += w.found[k];
    if (w.measures) w.distances[sender.request].lit += maxComponent(w.found[k]) * w.inverseMet[first + k];
  }
}

}  // namespace patina
