// SPDX-License-Identifier: Apache-2.0
// Renders random scenes in every mode, and judges what comes of each: no crash, no hang, nothing that is not
// finite, an exit status that is true; and where light is sane, radiosity and distribution show what path
// shows. By hand:
//
//   stress_random_scenes --count 100 --compare --jobs 2 --resume scenes.jsonl --report report.md
//   stress_random_scenes --first 17 --count 1 --keep folder     # the scene and its pictures
//   stress_random_scenes --patina build/debug/bin/patina --count 100 --seconds 300
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/stress/judged_render.h"
#include "tests/stress/random_report.h"
#include "tests/stress/random_scene.h"
#include "tools/patina-bench/child.h"
#include "tools/patina-bench/statistics.h"

namespace fs = std::filesystem;
using namespace patina;
using namespace patina::stress;
using bench::ChildUsage;

namespace {

struct Settings {
  RenderSettings render;
  fs::path shaders;
  uint64_t first = 0;
  int count = 20, jobs = 1;
  bool compare = false, saneLight = false, keep = false;
  ComparisonSettings comparison;
  std::vector<std::string> modes = {"radiosity", "distribution", "path", "points", "direct"};
  std::vector<std::string> compared = {"radiosity", "distribution"};

  /// What rows of a run may not differ in.
  nlohmann::json asJson() const {
    return {{"modes", modes},
            {"compare", compare ? compared : std::vector<std::string>()},
            {"sane light", saneLight},
            {"seconds", render.seconds},
            {"bias", comparison.bias},
            {"noise", comparison.noise},
            {"pictures", comparison.pictures},
            {"comparison seconds", comparison.seconds}};
  }
};

std::vector<LibraryShader> library(const Settings& settings) {
  std::vector<fs::path> plugins;
  for (const auto& entry : fs::directory_iterator(settings.shaders)) plugins.push_back(entry.path());
  std::ranges::sort(plugins);
  std::vector<LibraryShader> all;
  for (const fs::path& plugin : plugins) {
    const std::string log = settings.render.work / "plugin.json";
    const ChildUsage usage = bench::runChild(
        {settings.render.patina.parent_path() / "patina-shader", "--json", plugin}, {"", log, 60});
    if (!usage.failure.empty()) throw std::runtime_error(plugin.string() + ": " + usage.failure);
    for (const auto& shader : nlohmann::json::parse(contentsOf(log))) {
      LibraryShader& s = all.emplace_back(shader["shader"]);
      for (const auto& p : shader["parameters"])
        if (p["array_length"] == 0)
          s.parameters.push_back({p["name"], p["type"],
                                  p["minimum"].is_number() ? p["minimum"].get<double>() : NAN,
                                  p["maximum"].is_number() ? p["maximum"].get<double>() : NAN});
    }
  }
  return all;
}

/// Pictures to compare with have no more pixels than these; those that have fewer than usual take more
/// samples.
constexpr int kMostPixels = 512, kUsualPixels = 256;

Comparison compared(const RenderSettings& render, const Settings& settings, const fs::path& rib,
                    const ImageData& seen, Row& row) {
  std::vector<std::string> always;
  if (settings.jobs > 1) always = {"--threads", "1"};
  const int pixels = seen.width * seen.height;
  const double more = std::max(1.0, static_cast<double>(kUsualPixels) / pixels);
  if (pixels > kMostPixels) {
    const auto fewer = [&](int edge) { return std::max(1, edge * kMostPixels / pixels); };
    always.insert(always.end(),
                  {"--res", fmt::format("{}x{}", seen.height == 1 ? fewer(seen.width) : seen.width,
                                        seen.height == 1 ? 1 : fewer(seen.height))});
  }
  const RenderBlocks blocksOf = [&](const std::string& mode, double effort, int seed,
                                    double seconds) -> std::optional<std::vector<double>> {
    const auto count = [](double x, double most = 65536) {
      return std::to_string(std::lround(std::min(x, most)));
    };
    std::vector<std::string> arguments = always;
    arguments.insert(arguments.end(), {"--seed", std::to_string(seed)});
    if (mode == "path")
      arguments.insert(arguments.end(), {"--samples", count(64 * effort * more, 1 << 24)});
    else
      arguments.insert(arguments.end(), {"--samples", count(16 * effort * more), "--rays", count(32 * effort),
                                         "--light-samples", count(16 * effort, 1024)});
    RenderSettings limited = render;
    limited.seconds = seconds;
    const Judged judged = judgedRender(limited, rib, mode, arguments);
    if (judged.isOutOfTime) return {};
    if (!judged.wrong.empty()) row.wrong.push_back(mode + ", to be compared: " + judged.wrong);
    if (judged.picture.channels < 3) return {};
    ImageData rgb{judged.picture.width, judged.picture.height, 3, {"R", "G", "B"}, false, {}};
    for (int y = 0; y < rgb.height; ++y)
      for (int x = 0; x < rgb.width; ++x)
        rgb.pixels.insert(rgb.pixels.end(), judged.picture.pixel(x, y), judged.picture.pixel(x, y) + 3);
    return bench::blockMeans(rgb, 8);
  };
  return compareModes(settings.compared, blocksOf, settings.comparison);
}

Row run(const Settings& settings, uint64_t number, const std::vector<LibraryShader>& shaders) {
  Row row;
  const RandomScene scene =
      makeRandomScene(number, shaders, settings.saneLight ? RandomLight::Sane : RandomLight::Any);
  row.number = number, row.ingredients = scene.ingredients, row.isComparable = scene.comparable;
  RenderSettings render = settings.render;
  render.work /= fmt::format("scene{}", number);
  fs::create_directories(render.work);
  const fs::path rib = render.work / fmt::format("scene{}.rib", number);
  std::ofstream(rib, std::ios::binary) << scene.rib;
  ImageData seen;
  for (const std::string& mode : settings.modes) {
    std::vector<std::string> arguments = {"--rays", "16", "--samples", "2"};
    if (settings.jobs > 1) arguments.insert(arguments.end(), {"--threads", "1"});
    const Judged judged = judgedRender(render, rib, mode, arguments);
    if (!judged.wrong.empty()) row.wrong.push_back(mode + ": " + judged.wrong);
    row.areSamplesRefused |= judged.said.find("camera samples were not finite") != std::string::npos;
    row.seconds[mode] = judged.seconds;
    if (judged.picture.channels >= 3) seen = judged.picture;
  }
  if (settings.compare && row.isComparable && seen.width > 0)
    row.comparison = compared(render, settings, rib, seen, row);
  if (!settings.keep) fs::remove_all(render.work);
  return row;
}

/// Rows that a file has from runs before, the first line of which says how they were made.
std::vector<Row> rowsOf(const fs::path& file, const Settings& settings) {
  std::vector<Row> rows;
  std::ifstream in(file);
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    const nlohmann::json json = nlohmann::json::parse(line, nullptr, false);
    if (number == 1 && json != settings.asJson())
      throw std::runtime_error(file.string() + ": its scenes were rendered with other settings: " + line);
    if (number == 1) continue;
    if (json.is_discarded())
      throw std::runtime_error(fmt::format("{}:{}: not a line of JSON", file.string(), number));
    rows.push_back(rowOf(json));
  }
  return rows;
}

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  settings.render.patina = fs::read_symlink("/proc/self/exe").parent_path() / "patina";
  CLI::App app("Random scenes with nasty ingredients, in every mode.");
  std::string patina, keep, report, resume;
  ComparisonSettings& comparison = settings.comparison;
  app.add_option("--patina", patina, "The program, with patina-shader beside it");
  app.add_option("--first", settings.first, "Number of the first scene");
  app.add_option("--count", settings.count, "Scenes");
  app.add_option("--modes", settings.modes, "Modes")->delimiter(',');
  app.add_option("--seconds", settings.render.seconds, "Limit of one render");
  app.add_option("--jobs", settings.jobs, "Scenes at a time, each by one thread if there are several")
      ->check(CLI::Range(1, 256));
  app.add_flag("--compare", settings.compare, "Compare modes with path where light is sane");
  app.add_flag("--sane-light", settings.saneLight, "Scenes of which all are lit and can be compared");
  app.add_option("--compared", settings.compared, "Modes that are compared")->delimiter(',');
  app.add_option("--pictures", comparison.pictures, "Pictures of each mode to compare")
      ->check(CLI::Range(4, 1000));
  app.add_option("--bias", comparison.bias, "Relative bias that is allowed");
  app.add_option("--noise", comparison.noise, "Standard error to compare at, in terms of the bias");
  app.add_option("--comparison-seconds", comparison.seconds, "Limit of one scene's comparison");
  app.add_option("--keep", keep, "Folder that scenes and pictures are left in");
  app.add_option("--report", report, "Markdown file for the results");
  app.add_option("--resume", resume,
                 "File of results: scenes in it are not rendered again, others are added");
  CLI11_PARSE(app, argc, argv);
  if (!patina.empty()) settings.render.patina = fs::absolute(patina);
  settings.shaders = settings.render.patina.parent_path() / "../lib/patina/shaders";
  settings.keep = !keep.empty();
  std::string pattern = (fs::temp_directory_path() / "patina-random-XXXXXX").string();
  settings.render.work = settings.keep ? fs::absolute(keep) : fs::path(mkdtemp(pattern.data()));
  fs::create_directories(settings.render.work);
  int status = 0;
  try {
    std::vector<Row> rows = rowsOf(resume, settings);
    std::ofstream state(resume.empty() ? "/dev/null" : resume, std::ios::app);
    if (!state) throw std::runtime_error(resume + " cannot be written");
    if (rows.empty() && (resume.empty() || fs::file_size(resume) == 0))
      state << settings.asJson() << std::endl;
    std::vector<uint64_t> numbers;
    for (uint64_t k = settings.first; k < settings.first + static_cast<uint64_t>(settings.count); ++k)
      if (std::ranges::find(rows, k, &Row::number) == rows.end()) numbers.push_back(k);
    const std::vector<LibraryShader> shaders = library(settings);
    std::atomic<size_t> next = 0;
    std::mutex mutex;
    std::string problem;
    const auto work = [&] {
      for (size_t k; (k = next++) < numbers.size();) {
        try {
          const Row row = run(settings, numbers[k], shaders);
          const std::scoped_lock lock(mutex);
          state << asJson(row) << std::endl;
          std::cout << asLine(row) << std::endl;
          rows.push_back(row);
        } catch (const std::exception& what) {
          const std::scoped_lock lock(mutex);
          problem = what.what(), next = numbers.size();
        }
      }
    };
    std::vector<std::thread> threads;
    for (int k = 1; k < settings.jobs; ++k) threads.emplace_back(work);
    work();
    for (std::thread& thread : threads) thread.join();
    if (!problem.empty()) throw std::runtime_error(problem);
    std::ranges::sort(rows, {}, &Row::number);
    if (!settings.compare) settings.compared.clear();
    const Summary summary = summaryOf(rows, settings.compared, comparison.bias);
    std::cout << summary.text << "\n";
    if (!report.empty()) std::ofstream(report) << summary.table << "\n" << summary.text << "\n";
    status = summary.bad > 0;
  } catch (const std::exception& problem) {
    std::cerr << problem.what() << "\n";
    status = 1;
  }
  if (!settings.keep) fs::remove_all(settings.render.work);
  return status;
}
