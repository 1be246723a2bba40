// SPDX-License-Identifier: Apache-2.0
// References: given, kept from before, or rendered in path mode.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "renderer/film/exr.h"
#include "tools/patina-bench/render.h"
#include "tools/patina-bench/schedule.h"

namespace patina::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Seeds of references are far from those of what is measured, which begin at 1.
constexpr int kFirstSeed = 1'000'000;
constexpr int kPilotSamples = 16;

ImageData renderPath(const Build& build, const Scene& scene, const RenderOptions& options, int samples,
                     int k) {
  Run run;
  run.scene = scene.name, run.mode = "path", run.setting = "reference", run.build = build.name;
  run.repeat = k, run.seed = kFirstSeed + k, run.threads = options.threads;
  run.args = scene.args;
  run.args.insert(run.args.end(), {"--samples", std::to_string(samples)});
  RenderOptions unhurried = options;
  unhurried.timeoutSeconds = 0;
  ImageData picture = render(build, scene, unhurried, run);
  if (!run.failure.empty())
    throw std::runtime_error(fmt::format("reference of {}: {}", scene.name, run.failure));
  fs::remove(pictureOf(run, options.folder));
  return picture;
}

// A power of two, for even samples, that leaves time for all pictures.
int samplesFor(const Build& build, const Scene& scene, const RenderOptions& options,
               const ReferenceOptions& wanted) {
  const Budget pilot(0);
  renderPath(build, scene, options, kPilotSamples, wanted.seeds);
  const double each = (wanted.seconds - pilot.elapsed()) / wanted.seeds;
  int samples = kPilotSamples;
  while (samples * 2 <= wanted.samples && pilot.elapsed() * samples * 2 / kPilotSamples <= each) samples *= 2;
  return std::min(samples, wanted.samples);
}

std::optional<Reference> findKept(const fs::path& file, double seconds) {
  fs::path numbers = file;
  numbers.replace_extension(".json");
  if (!fs::exists(file) || !fs::exists(numbers)) return std::nullopt;
  try {
    const json j = json::parse(readFile(numbers));
    // Half the time makes twice the noise: not worth to be made again for less.
    if (j.value("seconds", 0.0) < seconds / 2) return std::nullopt;
    return Reference{
        {"path", file.string(), j.at("samples"), j.at("seeds"), j.at("relMse"), j.value("seconds", 0.0)},
        loadPicture(file)};
  } catch (const json::exception& problem) {
    throw std::runtime_error(numbers.string() + ": " + problem.what());
  }
}

void keep(const Reference& made) {
  const fs::path file = made.info.file;
  fs::path numbers = file;
  numbers.replace_extension(".json");
  ExrSettings exr;
  exr.fullWidth = made.picture.width, exr.fullHeight = made.picture.height;
  if (const std::string problem = writeExr(file.string(), made.picture, exr); !problem.empty())
    throw std::runtime_error(problem);
  const json j = {{"relMse", made.info.relMse},
                  {"samples", made.info.samples},
                  {"seeds", made.info.seeds},
                  {"seconds", made.info.seconds}};
  writeText(numbers, j.dump(1) + "\n");
}

}  // namespace

Reference averageOf(std::span<const ImageData> pictures) {
  Reference r;
  r.picture = pictures[0];
  r.info.seeds = static_cast<int>(pictures.size());
  const auto n = static_cast<double>(pictures.size());
  const size_t values = r.picture.pixels.size();
  for (const ImageData& p : pictures)
    if (p.pixels.size() != values) throw std::runtime_error("pictures of a reference differ in size");
  for (size_t i = 0; i < values; ++i) {
    double mean = 0, squares = 0;
    for (const ImageData& p : pictures) mean += static_cast<double>(p.pixels[i]) / n;
    for (const ImageData& p : pictures) squares += std::pow(static_cast<double>(p.pixels[i]) - mean, 2);
    r.picture.pixels[i] = static_cast<float>(mean);
    if (n > 1) r.info.relMse += squares / (n - 1) / n * relMseWeight(mean) / static_cast<double>(values);
  }
  return r;
}

Reference findReference(const Build& build, const Scene& scene, const RenderOptions& options,
                        const ReferenceOptions& wanted) {
  if (!scene.reference.empty())
    return {{"given", scene.reference.string(), 0, 0, scene.referenceRelMse, 0},
            loadPicture(scene.reference)};
  fs::create_directories(wanted.cache);
  const auto fileOf = [&](const std::string& numbers) {
    return wanted.cache / fmt::format("{}-{:016x}.exr", safe(scene.name), hashBytes(numbers, scene.hash));
  };
  // One of all samples is as good as any time can make it.
  const fs::path full = fileOf(fmt::format("{} {}", wanted.samples, wanted.seeds)), quick = fileOf("in time");
  if (std::optional<Reference> kept = findKept(full, 0)) return *kept;
  const bool limited = wanted.seconds > 0;
  if (limited)
    if (std::optional<Reference> kept = findKept(quick, wanted.keep ? 0 : wanted.seconds)) return *kept;

  const Budget budget(wanted.seconds);
  const int samples = limited ? samplesFor(build, scene, options, wanted) : wanted.samples;
  std::vector<ImageData> pictures;
  double longest = 0;
  const auto goesOn = [&] {
    const int done = static_cast<int>(pictures.size());
    if (done < wanted.seeds) return true;
    return limited && done * samples < wanted.seeds * wanted.samples && budget.left() > longest;
  };
  while (goesOn()) {
    const double start = budget.elapsed();
    pictures.push_back(renderPath(build, scene, options, samples, static_cast<int>(pictures.size())));
    longest = std::max(longest, budget.elapsed() - start);
  }
  Reference made = averageOf(pictures);
  made.info = {"path",           (limited ? quick : full).string(),
               samples,          static_cast<int>(pictures.size()),
               made.info.relMse, limited ? budget.elapsed() : 0};
  keep(made);
  return made;
}

}  // namespace patina::bench
