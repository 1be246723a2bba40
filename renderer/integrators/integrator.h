// SPDX-License-Identifier: Apache-2.0
// What every mode is: a way to fill the tiles of a film from a world.
#pragma once

#include <memory>
#include <optional>
#include <string_view>

#include "renderer/base/sampling.h"
#include "renderer/integrators/world.h"

namespace patina {

/// Channels of the film, in this order.
enum FilmChannelIndex { kRed, kGreen, kBlue, kAlpha, kDepth, kChannels };

/// Of the samples of a pixel, which are numbered: those from `first` on, before `end`.
struct SampleRange {
  uint32_t first, end;
};

/// What a tile's first samples have found out that its later ones may use: of the integrator that made it.
class TileMemory {
 public:
  virtual ~TileMemory() = default;
};

/// Renders tiles. Immutable but for caches whose content never changes a value, so that the picture does not
/// depend on the order of tiles or on threads.
class Integrator {
 public:
  virtual ~Integrator() = default;
  /// Gives the tile these samples for each of its samplePixels(). `memory`: of this tile, nullptr where all
  /// samples are asked for at once. [any thread]
  virtual void render(FilmTile& tile, SampleRange samples, TileMemory* memory) const = 0;
  /// The memory of a tile whose samples are asked for in parts; nullptr: none is of use. [any thread]
  virtual std::unique_ptr<TileMemory> remember() const { return nullptr; }
  /// Counts what can be counted only at the end. [main]
  virtual void finish() const {}
};

std::unique_ptr<Integrator> makePathIntegrator(const World& world);
/// `cached`: mode radiosity; else mode distribution. `indirect` false: mode direct.
std::unique_ptr<Integrator> makeRadiosityIntegrator(const World& world, bool cached, bool indirect);
/// Bakes points; see BakedPoints.
std::unique_ptr<Integrator> makePointsIntegrator(const World& world);

/// What a camera sample has seen.
struct Seen {
  Rgb radiance{0, 0, 0};
  float alpha = 0;
  float depth = kFarDepth;
};
/// Adds a sample of the film's channels. One that is not finite is counted as refused, and as black.
void addSample(FilmTile& tile, const V2f& raster, const Seen& seen);

/// The first pixel, in the order of rows, of samples that were refused since the last call. [main]
std::optional<std::pair<int, int>> takeRefusedPixel();

/// The camera ray of a sample of a pixel: the same in every mode.
struct CameraSample {
  float x, y;  ///< raster
  Ray ray;
  RasterCamera::Ray camera;
};
CameraSample cameraSample(const World& world, int pixelX, int pixelY, uint32_t sample);

/// Seed of a pixel's random numbers for one purpose. `frame`: World::frameSeed().
inline uint64_t pixelSeed(uint64_t frame, int x, int y, uint32_t purpose) {
  return hashOf(static_cast<uint32_t>(x), static_cast<uint32_t>(y), purpose) ^ frame;
}

}  // namespace patina
