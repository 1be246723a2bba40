// SPDX-License-Identifier: Apache-2.0
// Camera samples: how they start, and how they end on the film.
#include "renderer/integrators/integrator.h"

namespace patina {
namespace {

// Purposes of random numbers.
enum Dimension : uint32_t { kPixel, kLens, kTime };

}  // namespace

CameraSample cameraSample(const World& world, int x, int y, uint32_t sample) {
  const uint64_t frame = world.frameSeed();
  const V2f offset = sobol2(sample, pixelSeed(frame, x, y, kPixel));
  const V2f lens = sobol2(sample, pixelSeed(frame, x, y, kLens));
  CameraSample s;
  s.x = static_cast<float>(x) + offset.x, s.y = static_cast<float>(y) + offset.y;
  // A large raster coordinate may round up to the next pixel.
  if (s.x >= static_cast<float>(x + 1)) s.x = std::nextafter(static_cast<float>(x + 1), 0.0f);
  if (s.y >= static_cast<float>(y + 1)) s.y = std::nextafter(static_cast<float>(y + 1), 0.0f);
  const float time = world.moves() ? sobol1(sample, pixelSeed(frame, x, y, kTime)) : 0;
  s.camera = world.camera().ray(s.x, s.y, lens, time);
  s.ray = Ray{s.camera.origin, s.camera.direction, s.camera.tNear, s.camera.tFar, kCameraRay, time};
  return s;
}

void addSample(FilmTile& tile, const V2f& raster, const Seen& seen) {
  const Rgb& c = seen.radiance;
  const float values[kChannels] = {c.x, c.y, c.z, seen.alpha, seen.alpha > 0 ? seen.depth : kFarDepth};
  if (tile.addSample(raster.x, raster.y, values)) return;
  const float black[kChannels] = {0, 0, 0, 0, kFarDepth};
  tile.addSample(raster.x, raster.y, black);
}

}  // namespace patina
