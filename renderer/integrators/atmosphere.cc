// SPDX-License-Identifier: Apache-2.0
// Batches of segments of camera rays through atmosphere shaders.
#include "renderer/integrators/atmosphere.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "renderer/base/statistics.h"

namespace patina {
namespace {

STAT_COUNTER("Atmosphere/segments", segmentCount);

constexpr size_t kBlock = PATINA_LANES;

PatinaPlane varying(const float* data) { return {data, 1, 0}; }
PatinaPlane3 varying3(const float (&data)[3][kBlock]) {
  return {varying(data[0]), varying(data[1]), varying(data[2])};
}

/// RI's depth() of a point in camera space.
float depthOf(const Camera& camera, const V3f& P) {
  const double range = static_cast<double>(camera.farPlane) - static_cast<double>(camera.nearPlane);
  const double depth = (static_cast<double>(P.z) - static_cast<double>(camera.nearPlane)) / range;
  return static_cast<float>(std::clamp(depth, -1e30, 1e30));
}

bool isUsable(const Air& air) {
  for (int c = 0; c < 3; ++c)
    if (!(air.transmittance[c] >= 0 && air.transmittance[c] <= 1 && air.radiance[c] >= 0 &&
          air.radiance[c] < 1e30f))
      return false;
  return true;
}

/// At most kBlock segments of one shader.
void callShader(const World& world, const ShaderInstance& shader, std::span<const AirSegment> segments,
                std::span<const uint32_t> which, std::span<Air> air) {
  alignas(64) float origin[3][kBlock] = {}, direction[3][kBlock] = {}, length[kBlock] = {};
  alignas(64) float depthOrigin[kBlock] = {}, depth[kBlock] = {}, seen[3][kBlock], added[3][kBlock] = {};
  std::fill(&seen[0][0], &seen[0][0] + 3 * kBlock, 1.0f);
  for (size_t i = 0; i < which.size(); ++i) {
    const AirSegment& segment = segments[which[i]];
    const V3f &o = segment.ray->origin, &d = segment.ray->direction;
    const V3f end = o + d * segment.hit->t;
    const float norm = d.length();
    for (int c = 0; c < 3; ++c) origin[c][i] = o[c], direction[c][i] = d[c] / norm;
    length[i] = segment.hit->t * norm;
    depth[i] = depthOf(world.scene().camera, world.camera().toCamera(end));
    depthOrigin[i] = segment.fromEye ? -PATINA_INFINITE_DISTANCE
                                     : depthOf(world.scene().camera, world.camera().toCamera(o));
  }
  const PatinaAtmosphereIn in{sizeof(PatinaAtmosphereIn),
                              static_cast<uint32_t>(which.size()),
                              static_cast<uint32_t>(kBlock),
                              0,
                              varying3(origin),
                              varying3(direction),
                              varying(length),
                              varying(depthOrigin),
                              varying(depth)};
  PatinaAtmosphereOut out{
      sizeof(PatinaAtmosphereOut), 0, {seen[0], seen[1], seen[2]}, {added[0], added[1], added[2]}};
  const bool failed = shader.atmosphere(in, out) != PATINA_OK;
  segmentCount += static_cast<int64_t>(which.size());
  uint64_t bad = 0;
  V3f at;
  for (size_t i = 0; i < which.size(); ++i) {
    const Air made{{seen[0][i], seen[1][i], seen[2][i]}, {added[0][i], added[1][i], added[2][i]}};
    if (!failed && isUsable(made)) {
      air[which[i]] = made;
      continue;
    }
    if (bad++ == 0) at = V3f(origin[0][i], origin[1][i], origin[2][i]);
  }
  if (bad)
    shader.fault(ShaderHost::kBadView, bad, at, [&] {
      return std::string("its atmosphere is not a transmittance in [0,1] and a radiance");
    });
}

}  // namespace

void airOf(const World& world, std::span<const AirSegment> segments, std::span<Air> air) {
  thread_local std::vector<std::pair<const ShaderInstance*, uint32_t>> order;
  order.clear();
  for (uint32_t i = 0; i < segments.size(); ++i) {
    air[i] = Air{};
    if (const ShaderInstance* shader = world.atmosphereOf(segments[i].hit->placement))
      order.emplace_back(shader, i);
  }
  // Shaders one after the other; which comes first changes nothing.
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return std::less<>()(a.first, b.first); });
  std::vector<uint32_t> block;
  for (size_t k = 0; k < order.size(); ++k) {
    block.push_back(order[k].second);
    if (block.size() < kBlock && k + 1 < order.size() && order[k + 1].first == order[k].first) continue;
    callShader(world, *order[k].first, segments, block, air);
    block.clear();
  }
}

}  // namespace patina
