// SPDX-License-Identifier: Apache-2.0
// Passes over buckets.
#include "renderer/integrators/passes.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <optional>
#include <utility>

#include "renderer/base/statistics.h"
#include "renderer/shading/work_place.h"

namespace patina {
namespace {

STAT_TIME("Time of threads/everything else", otherTime);
STAT_COUNTER("Adaptive sampling/pixels", adaptivePixels);
STAT_COUNTER("Adaptive sampling/with all samples", fullPixels);

using Clock = std::chrono::steady_clock;

/// Showing a picture may take at most this share of the time.
constexpr double kShowShare = 0.1;

double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// A tile between passes.
struct OpenTile {
  std::optional<FilmTile> tile;  ///< none before its first samples, and when it is finished
  std::unique_ptr<TileMemory> memory;
};

/// Shows pictures while they are made, and sees to it that this is not too often.
class Showing {
 public:
  Showing(const Film& film, const RenderSettings& settings) : film_(film), settings_(settings) {}

  void offer(std::span<const OpenTile> open) {
    if (!std::exchange(offered_, true))
      setStatistic("Passes/seconds to the first picture", secondsSince(start_));
    if (!settings_.show || (count_ > 0 && secondsSince(shown_) < wait_)) return;
    const Clock::time_point start = Clock::now();
    std::vector<const FilmTile*> tiles;
    for (const OpenTile& place : open)
      if (place.tile) tiles.push_back(&*place.tile);
    settings_.show(*film_.preview(tiles));
    ++count_;
    shown_ = Clock::now();
    if (settings_.showSeconds > 0) wait_ = std::max(settings_.showSeconds, secondsSince(start) / kShowShare);
  }
  int count() const { return count_; }

 private:
  const Film& film_;
  const RenderSettings& settings_;
  const Clock::time_point start_ = Clock::now();
  Clock::time_point shown_;
  double wait_ = 0;
  bool offered_ = false;
  int count_ = 0;
};

}  // namespace

SamplePlan samplePlan(const Options& options, const RenderSettings& settings) {
  constexpr int kFewest = 4;  // a variance of fewer says little
  SamplePlan plan;
  plan.most = std::max(1, settings.samples     ? *settings.samples
                          : options.maxSamples ? *options.maxSamples
                                               : options.pixelSamplesX * options.pixelSamplesY);
  plan.least = plan.most;
  if (!(options.pixelVariance > 0)) return plan;
  const auto root = static_cast<int>(std::lround(std::sqrt(plan.most)));
  plan.least =
      std::min(plan.most, options.minSamples ? std::max(*options.minSamples, 2) : std::max(root, kFewest));
  plan.white = 1 / std::max(options.exposureGain, 1e-6f);
  plan.variance = options.pixelVariance * plan.white * plan.white;
  return plan;
}

std::vector<SampleRange> passesOf(int samplesPerPixel, bool progressive) {
  const auto all = static_cast<uint32_t>(std::max(samplesPerPixel, 1));
  std::vector<SampleRange> passes;
  for (uint32_t first = 0; first < all; first = passes.back().end)
    passes.push_back({first, progressive ? std::min(all, std::max(1u, 2 * first)) : all});
  return passes;
}

namespace {

/// Gives a tile what its pixels want beyond the samples that all have.
void goOn(FilmTile& tile, const SamplePlan& plan, const World& world, const Integrator& integrator,
          TileMemory* memory) {
  const PixelRect& pixels = tile.samplePixels();
  int wanting = pixels.width() * pixels.height();
  adaptivePixels += wanting;
  for (int first = plan.least; first < plan.most && !world.interrupted();) {
    wanting = tile.keepWanting(plan.variance, plan.white);
    if (wanting == 0) return;
    const int end = static_cast<int>(std::min<int64_t>(plan.most, int64_t{first} + std::max(first / 2, 1)));
    integrator.render(tile, {static_cast<uint32_t>(first), static_cast<uint32_t>(end)}, memory);
    first = end;
  }
  fullPixels += wanting;
}

}  // namespace

void renderPasses(Film& film, const World& world, const Integrator& integrator, const SamplePlan& plan,
                  bool progressive) {
  const RenderSettings& settings = world.settings();
  const std::vector<SampleRange> passes = passesOf(plan.least, progressive);
  const int count = film.tileCount();
  std::vector<OpenTile> open(passes.size() > 1 ? static_cast<size_t>(count) : 0);
  Showing showing(film, settings);
  std::mutex progressMutex;
  for (const SampleRange& pass : passes) {
    const bool isLast = pass.end == passes.back().end;
    std::atomic<int> done{0};
    const auto render = [&](int k) {
      OpenTile none;
      OpenTile& place = open.empty() ? none : open[static_cast<size_t>(k)];
      if (!place.tile) {
        place.tile = film.begin(k);
        if (!isLast || plan.isAdaptive()) place.memory = integrator.remember();
      }
      const PixelRect& pixels = place.tile->samplePixels();
      const TimeShare share(otherTime);
      const WorkPlaceScope scope({pixels.x0, pixels.y0, pixels.x1, pixels.y1});
      integrator.render(*place.tile, pass, place.memory.get());
      if (isLast) {
        if (plan.isAdaptive()) goOn(*place.tile, plan, world, integrator, place.memory.get());
        film.finish(std::move(*place.tile));
        place.tile.reset(), place.memory.reset();
      }
      const int finished = ++done;
      if (settings.progress) {
        const double part = static_cast<double>(finished) / count;
        std::lock_guard lock(progressMutex);
        settings.progress((pass.first + part * (pass.end - pass.first)) / passes.back().end);
      }
    };
    tbb::parallel_for(
        tbb::blocked_range<int>(0, count, 1),
        [&](const tbb::blocked_range<int>& range) {
          for (int k = range.begin(); k < range.end() && !world.interrupted(); ++k) render(k);
        },
        tbb::simple_partitioner());
    if (world.interrupted()) break;
    if (!isLast) showing.offer(open);
  }
  // After an interruption tiles are still open, or wait for their neighbours.
  for (OpenTile& place : open)
    if (place.tile) film.finish(std::move(*place.tile));
  film.flush();
  if (passes.size() > 1) {
    setStatistic("Passes/passes", static_cast<double>(passes.size()));
    setStatistic("Passes/pictures shown on the way", showing.count());
  }
}

}  // namespace patina
