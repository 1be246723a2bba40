// SPDX-License-Identifier: Apache-2.0
// Camera samples: how they start, and how they end on the film.
#include "renderer/integrators/integrator.h"

#include <atomic>

namespace patina {
namespace {

// Purposes of random numbers.
enum Dimension : uint32_t { kPixel, kLens, kTime };

constexpr uint64_t kNoPixel = ~uint64_t{0};
std::atomic<uint64_t> refusedPixel = kNoPixel;  // row << 32 | column, each from -2^31 on
constexpr int64_t kOffset = int64_t{1} << 31;

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
  const auto column = static_cast<uint64_t>(static_cast<int64_t>(std::floor(raster.x)) + kOffset);
  const auto row = static_cast<uint64_t>(static_cast<int64_t>(std::floor(raster.y)) + kOffset);
  const uint64_t pixel = row << 32 | column;
  for (uint64_t least = refusedPixel.load(std::memory_order_relaxed); pixel < least;)
    if (refusedPixel.compare_exchange_weak(least, pixel, std::memory_order_relaxed)) break;
  const float black[kChannels] = {0, 0, 0, 0, kFarDepth};
  tile.addSample(raster.x, raster.y, black);
}

std::optional<std::pair<int, int>> takeRefusedPixel() {
  const uint64_t pixel = refusedPixel.exchange(kNoPixel);
  if (pixel == kNoPixel) return std::nullopt;
  const auto coordinate = [](uint64_t bits) {
    return static_cast<int>(static_cast<int64_t>(bits & 0xffffffffu) - kOffset);
  };
  return std::pair(coordinate(pixel), coordinate(pixel >> 32));
}

}  // namespace patina
