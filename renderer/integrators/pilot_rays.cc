// SPDX-License-Identifier: Apache-2.0
// Rays that find out, before a picture is made, what most of its rays will meet.

#include "renderer/base/parallel.h"
#include "renderer/base/statistics.h"
#include "renderer/integrators/world.h"

namespace patina {
namespace {

STAT_COUNTER("Rays/fired ahead to see what is met", pilotRays);

constexpr int64_t kSamplesPerPath = 256;  // a camera ray of these, with its reflections
constexpr int64_t kMostPaths = 1 << 15;
constexpr int kReflections = 3;

}  // namespace

// What is met is the same for any number of threads: paths are numbered, and none depends on another.
void World::settle(const PixelRect& pixels, bool reflections) {
  if (geometry_->units().empty() || pixels.empty()) return;
  const PhaseTimer timer("Rays ahead");
  const int64_t width = pixels.x1 - pixels.x0, height = pixels.y1 - pixels.y0;
  const int64_t paths =
      std::min(std::max<int64_t>(width * height * samplesPerPixel_ / kSamplesPerPath, 1), kMostPaths);
  constexpr int64_t kBatch = 1024;
  parallelFor(int64_t{0}, (paths + kBatch - 1) / kBatch, [&](int64_t batch) {
    constexpr uint64_t kStream = 0x70696c6f74;
    const auto first = static_cast<uint32_t>(batch * kBatch),
               end = static_cast<uint32_t>(std::min(paths, (batch + 1) * kBatch));
    std::vector<Ray> rays;
    for (uint32_t k = first; k < end; ++k) {
      const V2f at = sobol2(k, hashOf(kStream, frameSeed_));
      const RasterCamera::Ray ray =
          camera_.ray(static_cast<float>(pixels.x0) + at.x * static_cast<float>(width),
                      static_cast<float>(pixels.y0) + at.y * static_cast<float>(height),
                      sobol2(k, hashOf(kStream + 1, frameSeed_)));
      if (ray.tNear <= ray.tFar) rays.push_back({ray.origin, ray.direction, ray.tNear, ray.tFar, kCameraRay});
    }
    std::vector<Hit> hits;
    for (int bounce = 0; !rays.empty(); ++bounce) {
      hits.resize(rays.size());
      accel_->intersect(rays, hits);
      pilotRays += static_cast<int64_t>(rays.size());
      if (!reflections || bounce == kReflections || interrupted()) break;
      std::vector<Ray> next;
      for (size_t i = 0; i < rays.size(); ++i) {
        const Hit& hit = hits[i];
        if (!hit.valid()) continue;
        const Facet facet = geometry_->facet(hit.placement, hit.face, hit.u, hit.v);
        const V3f up = facet.N.dot(rays[i].direction) > 0 ? -facet.N : facet.N;
        const V2f u =
            sobol2(first + static_cast<uint32_t>(i), hashOf(kStream + 2, static_cast<uint64_t>(bounce)));
        const V3f direction = Frame(up).toWorld(sampleCosineHemisphere(u));
        next.push_back({leave(facet, direction), direction, 0, kInfinity, kDiffuseRay});
      }
      rays.swap(next);
    }
  });
  accel_->settle();
}

}  // namespace patina
