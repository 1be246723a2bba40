// SPDX-License-Identifier: Apache-2.0
// Shoots random rays from inside closed geometry and counts those that get out.
//
//   stress_watertight [-n RAYS] FILE.rib ...        exit status 0 = none got out of any
//
// Each RIB has a world whose geometry is closed around the origin, at least within a distance of 0.05. Rays
// start there, anywhere, in all directions. Where a ray gets out, its origin and direction are printed,
// exactly.
#include <tbb/parallel_for.h>

#include <atomic>
#include <cstdlib>
#include <iostream>
#include <mutex>

#include "renderer/base/sampling.h"
#include "renderer/integrators/world.h"
#include "renderer/scene/scene_builder.h"

namespace {

using namespace patina;

constexpr float kRadius = 0.05f;
constexpr uint64_t kShown = 5;

uint64_t countEscapes(const Scene& scene, uint64_t rays, ErrorHandler& errors) {
  const RenderSettings settings;
  const World world(scene, settings, errors);
  std::atomic<uint64_t> escaped = 0;
  std::mutex output;
  constexpr uint64_t kBatch = 1 << 14;
  tbb::parallel_for(uint64_t{0}, (rays + kBatch - 1) / kBatch, [&](uint64_t batch) {
    for (uint64_t k = batch * kBatch; k < std::min(rays, (batch + 1) * kBatch); ++k) {
      const auto random = [&](uint64_t dimension) {
        return toUnit(static_cast<uint32_t>(hashOf(k, dimension) >> 32));
      };
      const auto onSphere = [](float a, float b) {
        const float z = 1 - 2 * a, r = std::sqrt(std::max(0.0f, 1 - z * z));
        return V3f(r * std::cos(2 * kPi * b), r * std::sin(2 * kPi * b), z);
      };
      Ray ray;
      ray.origin = onSphere(random(0), random(1)) * (kRadius * std::cbrt(random(2)));
      ray.direction = onSphere(random(3), random(4));
      ray.mask = kDiffuseRay;
      if (world.geometry().moves()) ray.mask = kCameraRay, ray.time = random(5);
      if (world.accel().intersect(ray).valid()) continue;
      if (escaped++ >= kShown) continue;
      const std::scoped_lock lock(output);
      std::cout << std::hexfloat << "  from " << ray.origin << " along " << ray.direction << "\n";
    }
  });
  return escaped;
}

}  // namespace

int main(int count, char** arguments) {
  uint64_t rays = 10'000'000;
  bool allClosed = true;
  for (int k = 1; k < count; ++k) {
    const std::string file = arguments[k];
    if (file == "-n" && k + 1 < count) {
      rays = std::strtoull(arguments[++k], nullptr, 10);
      continue;
    }
    bool found = false;
    ErrorHandler errors([](Severity, std::string_view text) { std::cout << text << "\n"; });
    SceneBuilder builder({}, errors, [&](Scene& scene) {
      found = true;
      const uint64_t escaped = countEscapes(scene, rays, errors);
      std::cout << file << ": " << std::dec << escaped << " of " << rays << " rays got out\n";
      allClosed = allClosed && escaped == 0;
    });
    if (!builder.readFile(file) || !found) {
      std::cout << file << ": no world\n";
      allClosed = false;
    }
  }
  return allClosed ? 0 : 1;
}
