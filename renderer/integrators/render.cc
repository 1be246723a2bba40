// SPDX-License-Identifier: Apache-2.0
// The frame: world, film, integrator, and the loop over buckets.
#include "renderer/integrators/render.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <mutex>
#include <thread>

#include "renderer/base/statistics.h"
#include "renderer/film/scene_film.h"
#include "renderer/integrators/integrator.h"
#include "renderer/shading/work_place.h"

namespace patina {
namespace {

STAT_TIME("Time of threads/everything else", otherTime);

std::unique_ptr<Integrator> makeIntegrator(const World& world, const std::string& mode) {
  if (mode == "path") return makePathIntegrator(world);
  if (mode == "direct") return makeRadiosityIntegrator(world, false, false);
  return makeRadiosityIntegrator(world, mode == "radiosity", true);
}

std::string describeRefused(const World& world, uint64_t refused) {
  std::string text = std::to_string(refused) + " camera samples were not finite and count as black";
  if (const auto pixel = takeRefusedPixel())
    text += fmt::format(
        ". The first is in pixel ({}, {}), which this makes again: {}", pixel->first, pixel->second,
        world.replayCommand(pixel->first, pixel->second, pixel->first + 1, pixel->second + 1));
  return text;
}

}  // namespace

std::unique_ptr<Film> renderFrame(const Scene& scene, const RenderSettings& settings, ErrorHandler& errors) {
  const auto fail = [&](const std::string& message) {
    errors.report(Severity::Severe, RiError::Consistency, {}, message);
    return nullptr;
  };
  std::string mode = settings.classic         ? "direct"
                     : !settings.mode.empty() ? settings.mode
                                              : scene.options.mode;
  if (mode.empty()) mode = "radiosity";
  if (mode != "radiosity" && mode != "distribution" && mode != "path" && mode != "direct")
    return fail("there is no mode '" + mode + "'; known are radiosity, distribution, path and direct");

  const int threads = settings.threads > 0
                          ? settings.threads
                          : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<size_t>(threads));
  const FilmSettings filmWanted = filmSettings(scene.options, errors);
  if (const std::string problem = Film::problem(filmWanted); !problem.empty()) return fail(problem);
  PhaseTimer whole("Whole frame");
  auto film = std::make_unique<Film>(filmWanted);
  try {
    World world(scene, settings, errors);
    const auto integrator = makeIntegrator(world, mode);
    PhaseTimer timer("Render");
    std::atomic<int> done{0};
    std::mutex progressMutex;
    const int count = film->tileCount();
    tbb::parallel_for(
        tbb::blocked_range<int>(0, count, 1),
        [&](const tbb::blocked_range<int>& range) {
          for (int k = range.begin(); k < range.end(); ++k) {
            if (settings.interrupted && settings.interrupted()) return;
            const TimeShare share(otherTime);
            FilmTile tile = film->begin(k);
            const PixelRect& pixels = tile.samplePixels();
            const WorkPlaceScope place({pixels.x0, pixels.y0, pixels.x1, pixels.y1});
            integrator->render(tile);
            film->finish(std::move(tile));
            const int finished = ++done;
            if (settings.progress) {
              std::lock_guard lock(progressMutex);
              settings.progress(static_cast<double>(finished) / count);
            }
          }
        },
        tbb::simple_partitioner());
    film->flush();  // after an interruption, finished tiles may still wait for their neighbours
    integrator->finish();
    world.summarize(errors);
    world.geometry().reportMemory();
    if (const auto refused = film->refusedCount())
      errors.report(Severity::Warning, RiError::Math, {}, describeRefused(world, refused));
    setStatistic("Film/camera samples", static_cast<double>(film->sampleCount()));
  } catch (const std::exception& error) {
    return fail(error.what());
  }
  return film;
}

}  // namespace patina
