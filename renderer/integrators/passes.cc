// SPDX-License-Identifier: Apache-2.0
// Passes over buckets.
#include "renderer/integrators/passes.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <utility>

#include "renderer/base/parallel.h"
#include "renderer/base/statistics.h"
#include "renderer/shading/work_place.h"

namespace patina {
namespace {

STAT_TIME("Time of threads/everything else", otherTime);
STAT_COUNTER("Adaptive sampling/pixels", adaptivePixels);
STAT_COUNTER("Adaptive sampling/with all samples", fullPixels);
STAT_COUNTER("Checkpoints/written", checkpointCount);
STAT_COUNTER("Checkpoints/bytes written", checkpointBytes);
STAT_COUNTER("Checkpoints/buckets resumed", resumedBuckets);
STAT_COUNTER("Checkpoints/buckets resumed between passes", resumedOpen);
STAT_COUNTER("Checkpoints/samples resumed", resumedSamples);

using Clock = std::chrono::steady_clock;

/// Showing a picture may take at most this share of the time, and so may keeping a checkpoint.
constexpr double kShowShare = 0.1;

double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// A tile between passes.
struct OpenTile {
  std::optional<FilmTile> tile;  ///< none before its first samples, and when it is finished
  std::unique_ptr<TileMemory> memory;
  uint32_t samples = 0;  ///< of each pixel
  bool isCut = false;    ///< by an interruption: pixels have different numbers
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

/// Keeps checkpoints, and sees to it that this is not too often.
class Keeping {
 public:
  Keeping(const Film& film, const RenderSettings& settings) : film_(film), settings_(settings) {}

  bool isDue() const { return settings_.checkpoint && secondsSince(kept_) >= wait_; }  ///< [any thread]

  void keep(std::span<const OpenTile> open) {
    if (!settings_.checkpoint) return;
    const PhaseTimer timer("Writing checkpoints");
    const Clock::time_point start = Clock::now();
    settings_.checkpoint([&](ByteWriter& to) {
      film_.save(to);
      const auto isKept = [](const OpenTile& place) { return place.tile && !place.isCut; };
      to.put(static_cast<uint64_t>(std::ranges::count_if(open, isKept)));
      for (const OpenTile& place : open)
        if (isKept(place)) {
          to.put(int32_t{place.tile->index()}), to.put(place.samples);
          film_.saveTile(*place.tile, to);
        }
      checkpointBytes += static_cast<int64_t>(to.count());
    });
    ++checkpointCount;
    kept_ = Clock::now();
    wait_ = std::max(settings_.checkpointSeconds, secondsSince(start) / kShowShare);
  }

 private:
  const Film& film_;
  const RenderSettings& settings_;
  Clock::time_point kept_ = Clock::now();
  double wait_ = settings_.checkpointSeconds;
};

/// Puts film and tiles where Keeping found them.
void resume(Film& film, std::span<OpenTile> open, std::span<const SampleRange> passes, ByteReader& from) {
  const auto refuse = [] { throw std::runtime_error("the checkpoint does not fit the picture"); };
  uint64_t count = 0;
  if (!film.restore(from) || !from.get(count) || count > open.size()) refuse();
  for (uint64_t k = 0; k < count; ++k) {
    int32_t index = -1;
    uint32_t samples = 0;
    if (!from.get(index) || !from.get(samples) || index < 0 || index >= film.tileCount()) refuse();
    OpenTile& place = open[static_cast<size_t>(index)];
    const bool endsPass = std::ranges::any_of(passes.first(passes.size() - 1),
                                              [&](const SampleRange& pass) { return pass.end == samples; });
    if (place.tile || !film.isOpen(index) || !endsPass) refuse();
    place.tile = film.begin(index), place.samples = samples;
    if (!film.restoreTile(*place.tile, from)) refuse();
    ++resumedOpen;
    const PixelRect& pixels = place.tile->samplePixels();
    resumedSamples += int64_t{pixels.width()} * pixels.height() * samples;
  }
  if (from.remaining() > 0) refuse();
  for (int k = 0; k < film.tileCount(); ++k) resumedBuckets += film.isOpen(k) ? 0 : 1;
  resumedSamples += static_cast<int64_t>(film.sampleCount());
}

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
                  bool progressive, RenderWatch& watch) {
  const RenderSettings& settings = world.settings();
  const std::vector<SampleRange> passes = passesOf(plan.least, progressive);
  const int count = film.tileCount();
  std::vector<OpenTile> open(passes.size() > 1 ? static_cast<size_t>(count) : 0);
  if (settings.resume) resume(film, open, passes, *settings.resume);
  Showing showing(film, settings);
  Keeping keeping(film, settings);
  std::mutex progressMutex, cutMutex;
  std::vector<FilmTile> cut;  // by an interruption, where no tiles are kept open
  for (const SampleRange& pass : passes) {
    const bool isLast = pass.end == passes.back().end;
    const auto isToDo = [&](int k) {
      return film.isOpen(k) && (open.empty() || open[static_cast<size_t>(k)].samples < pass.end);
    };
    std::vector<int> toDo;
    const auto findToDo = [&] {
      toDo.clear();
      for (int k = 0; k < count; ++k)
        if (isToDo(k)) toDo.push_back(k);
    };
    findToDo();
    if (toDo.empty()) continue;  // of what is resumed
    std::atomic<int> done{count - static_cast<int>(toDo.size())};
    const auto render = [&](int k) {
      OpenTile none;
      OpenTile& place = open.empty() ? none : open[static_cast<size_t>(k)];
      if (!place.tile) place.tile = film.begin(k);
      if (!place.memory && (!isLast || plan.isAdaptive())) place.memory = integrator.remember();
      const PixelRect& pixels = place.tile->samplePixels();
      const TimeShare share(otherTime);
      const WorkPlaceScope scope({pixels.x0, pixels.y0, pixels.x1, pixels.y1});
      integrator.render(*place.tile, {place.samples, pass.end}, place.memory.get());
      if (isLast && plan.isAdaptive()) goOn(*place.tile, plan, world, integrator, place.memory.get());
      place.samples = pass.end;
      if (world.interrupted()) {
        place.isCut = true;
        const std::lock_guard lock(cutMutex);
        if (open.empty()) cut.push_back(std::move(*place.tile));
      } else if (isLast) {
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
    for (bool again = true; again && !world.interrupted();) {
      std::atomic<bool> pause{false};
      parallelFor(
          size_t{0}, toDo.size(),
          [&](size_t i) {
            if (world.interrupted() || pause) return;
            render(toDo[i]);
            if (keeping.isDue()) pause = true;
          },
          tbb::simple_partitioner());
      again = pause;
      if (!pause || world.interrupted()) continue;
      keeping.keep(open);
      findToDo();
    }
    if (world.interrupted()) break;
    if (!isLast) showing.offer(open);
  }
  watch.bucketsEnded();
  keeping.keep(open);
  // After an interruption tiles are still open, or wait for their neighbours.
  for (FilmTile& tile : cut) film.finish(std::move(tile));
  for (OpenTile& place : open)
    if (place.tile) film.finish(std::move(*place.tile));
  film.flush();
  if (passes.size() > 1) {
    setStatistic("Passes/passes", static_cast<double>(passes.size()));
    setStatistic("Passes/pictures shown on the way", showing.count());
  }
}

}  // namespace patina
