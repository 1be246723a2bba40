// SPDX-License-Identifier: Apache-2.0
// The frame: world, film, integrator.
#include "renderer/integrators/render.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <new>
#include <thread>

#include "renderer/base/statistics.h"
#include "renderer/film/scene_film.h"
#include "renderer/integrators/integrator.h"
#include "renderer/integrators/passes.h"

namespace patina {
namespace {

std::unique_ptr<Integrator> makeIntegrator(const World& world, const std::string& mode) {
  if (mode == "path") return makePathIntegrator(world);
  if (mode == "points") return makePointsIntegrator(world);
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
  if (mode != "radiosity" && mode != "distribution" && mode != "path" && mode != "points" && mode != "direct")
    return fail("there is no mode '" + mode +
                "'; known are radiosity, distribution, path, points and direct");

  const int threads = settings.threads > 0
                          ? settings.threads
                          : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<size_t>(threads));
  FilmSettings filmWanted = filmSettings(scene.options, errors);
  SamplePlan plan = samplePlan(scene.options, settings);
  if (plan.isAdaptive()) {
    // What a bucket keeps until it is finished.
    constexpr uint64_t kMostKept = uint64_t{1} << 28;
    const uint64_t bytes = static_cast<uint64_t>(filmWanted.bucketWidth) *
                           static_cast<uint64_t>(filmWanted.bucketHeight) * static_cast<uint64_t>(plan.most) *
                           (filmWanted.channels.size() + 2) * sizeof(float);
    if (bytes > kMostKept) {
      errors.report(
          Severity::Warning, RiError::LimitCheck, {},
          fmt::format("PixelVariance has no effect: of up to {} samples per pixel a bucket would keep "
                      "{} MB (at most {})",
                      plan.most, bytes >> 20, kMostKept >> 20));
      plan.least = plan.most;
    } else {
      filmWanted.adaptiveFrom = plan.least;
    }
  }
  if (const std::string problem = Film::problem(filmWanted); !problem.empty()) return fail(problem);
  PhaseTimer whole("Whole frame");
  std::unique_ptr<Film> film;
  try {
    film = std::make_unique<Film>(filmWanted);
    RenderWatch watch(settings, *film);
    World world(scene, settings, errors);
    world.settle(film->pixels(), mode != "direct");
    const auto integrator = makeIntegrator(world, mode);
    PhaseTimer timer("Render");
    bool progressive = settings.progressive.value_or(scene.options.incremental);
    constexpr uint64_t kMostOpenBytes = uint64_t{16} << 30;
    if (progressive && world.samplesPerPixel() > 1 && film->openBytes() > kMostOpenBytes) {
      errors.report(Severity::Warning, RiError::LimitCheck, {},
                    fmt::format("the picture is not progressive: between passes its buckets would take {} GB "
                                "(at most {})",
                                (film->openBytes() >> 30) + 1, kMostOpenBytes >> 30));
      progressive = false;
    }
    renderPasses(*film, world, *integrator, plan, progressive, watch);
    integrator->finish();
    world.summarize(errors);
    world.geometry().reportMemory();
    if (const auto refused = film->refusedCount())
      errors.report(Severity::Warning, RiError::Math, {}, describeRefused(world, refused));
    setStatistic("Film/camera samples", static_cast<double>(film->sampleCount()));
  } catch (const std::bad_alloc&) {
    errors.report(
        Severity::Severe, RiError::OutOfMemory, {},
        "there is not enough memory for this picture: smaller caches (Option \"limits\", --cache-memory), "
        "a smaller picture or fewer threads take less");
    return nullptr;
  } catch (const std::exception& error) {
    return fail(error.what());
  }
  return film;
}

}  // namespace patina
