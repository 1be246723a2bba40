// SPDX-License-Identifier: Apache-2.0
// Scratch memory of the radiosity engine: one workspace per thread and nesting of fills.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "renderer/base/statistics.h"
#include "renderer/integrators/radiosity_engine.h"

namespace patina {

struct RadiosityEngine::GatherRay {
  V3f origin, direction;
  float spread;   ///< width gained per length
  float weight;   ///< of its radiance in the irradiance of `slot`
  uint32_t slot;  ///< twice the request's index, plus one behind the surface
  uint64_t seed;
  float time;  ///< see Ray
};

struct RadiosityEngine::Workspace {
  // shadeNested
  std::vector<ShadingPoint> points;
  ShadedPoints shaded;
  std::vector<Rgb> front, back, extra;  // irradiance; ambient light
  // addDirect
  std::vector<uint32_t> which;
  std::vector<V3f> positions;
  std::vector<V2f> random;
  std::vector<LightSample> lightSamples;
  // addIndirect
  std::vector<V3f> missFrom, missDirection;
  std::vector<uint32_t> missOf;
  std::vector<Rgb> missWeight, missRadiance;
  std::vector<float> missPdf;
  std::vector<Request> direct;
  std::vector<uint32_t> directOf;
  std::vector<Rgb> directWeight, directRadiance;
  ShadedPoints layer;
  // fill, vertices
  std::vector<Request> fillRequests;
  std::vector<Rgb> fillRadiance;
  std::vector<uint64_t> fillCodes;
  std::vector<uint32_t> vertexOf, order;
  std::vector<BlockVertex> blocks;
  // specularTail
  ShadedPoints specular;
};

struct CacheStatistics {
  StatCounter lookups, hits, misses;
};
CacheStatistics& cacheStatistics(Level level, int depth);

}  // namespace patina
