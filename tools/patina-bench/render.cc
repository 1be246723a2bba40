// SPDX-License-Identifier: Apache-2.0
// patina as a child process, its statistics and its pictures.
#include "tools/patina-bench/render.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "renderer/film/exr.h"
#include "tools/patina-bench/child.h"

namespace patina::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Sum of all numbers of a tree of statistics, or of those of one name.
double sumOf(const json& tree, std::string_view name = {}) {
  double sum = 0;
  for (const auto& [key, value] : tree.items()) {
    if (value.is_structured()) {
      sum += sumOf(value, name);
    } else if (value.is_number() && (name.empty() || key == name)) {
      sum += value.get<double>();
    }
  }
  return sum;
}

uint64_t hashOfPixels(const ImageData& picture) {
  return hashBytes(
      {reinterpret_cast<const char*>(picture.pixels.data()), picture.pixels.size() * sizeof(float)});
}

}  // namespace

std::string safe(std::string text) {
  for (char& c : text)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '.' && c != '-' && c != '_') c = '_';
  return text;
}

Build findBuild(const std::string& text) {
  const size_t equals = text.find('=');
  const std::string path = equals == std::string::npos ? text : text.substr(equals + 1);
  Build build{equals == std::string::npos ? path : text.substr(0, equals), fs::weakly_canonical(path), 0};
  if (!fs::is_regular_file(build.program) || access(build.program.c_str(), X_OK) != 0)
    throw std::runtime_error(path + " is not a program");
  build.hash = hashBytes(readFile(build.program));
  return build;
}

Build defaultBuild() {
  return findBuild("patina=" + (fs::read_symlink("/proc/self/exe").parent_path() / "patina").string());
}

fs::path pictureOf(const Run& run, const fs::path& folder) {
  return folder / "pictures" /
         (safe(fmt::format("{}.{}.{}.{}.{}", run.scene, run.mode, run.setting, run.build, run.repeat)) +
          ".exr");
}

ImageData loadPicture(const fs::path& path) {
  std::string error;
  std::optional<ImageData> read = readImage(path.string(), error);
  if (!read) throw std::runtime_error(error);
  if (read->channels < 3) throw std::runtime_error(path.string() + " has fewer than three channels");
  ImageData picture{read->width, read->height, 3, {"R", "G", "B"}, false, {}};
  for (int y = 0; y < read->height; ++y)
    for (int x = 0; x < read->width; ++x)
      for (int c = 0; c < 3; ++c) {
        picture.pixels.push_back(read->pixel(x, y)[c]);
        if (!std::isfinite(picture.pixels.back()))
          throw std::runtime_error(fmt::format("{}: pixel {},{} is not finite", path.string(), x, y));
      }
  return picture;
}

ImageData render(const Build& build, const Scene& scene, const RenderOptions& options, Run& run) {
  const fs::path picture = pictureOf(run, options.folder), base = picture.parent_path() / picture.stem();
  fs::create_directories(picture.parent_path());
  fs::remove(picture);
  const std::string statistics = base.string() + ".json";
  std::vector<std::string> command = {build.program.string(), "--quiet", "--mode", run.mode};
  command.insert(command.end(), run.args.begin(), run.args.end());
  command.insert(command.end(), {"--seed", std::to_string(run.seed), "--threads", std::to_string(run.threads),
                                 "--stats", statistics, "-o", picture.string(), scene.rib.string()});
  const ChildUsage usage =
      runChild(command, {scene.rib.parent_path().string(), base.string() + ".log", options.timeoutSeconds});
  run.wallSeconds = usage.wallSeconds, run.cpuSeconds = usage.cpuSeconds, run.peakMb = usage.peakMb;
  run.failure = usage.failure, run.outOfTime = usage.outOfTime;
  if (!run.failure.empty()) return {};
  try {
    const json tree = json::parse(readFile(statistics));
    if (tree.contains("Rays")) run.rays = sumOf(tree["Rays"]);
    if (tree.contains("Shaders")) run.shaderPoints = sumOf(tree["Shaders"], "points");
    ImageData image = loadPicture(picture);
    run.picture = hashOfPixels(image);
    return image;
  } catch (const std::exception& problem) {
    run.failure = problem.what();
    return {};
  }
}

}  // namespace patina::bench
