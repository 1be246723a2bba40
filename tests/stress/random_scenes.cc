// SPDX-License-Identifier: Apache-2.0
// Renders random scenes in every mode, and judges what comes of each: no crash, no hang, nothing that is not
// finite, an exit status that is true; and where light is sane, radiosity and distribution show what path
// shows. By hand:
//
//   stress_random_scenes --count 100 --compare --report report.md
//   stress_random_scenes --first 17 --count 1 --keep folder     # the scene and its pictures
//   stress_random_scenes --patina build/debug/bin/patina --count 100 --seconds 300
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "renderer/film/image.h"
#include "tests/stress/judged_render.h"
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
  int count = 20, seeds = 4, samples = 256;
  double bias = 0.05;
  bool compare = false;
  std::vector<std::string> modes = {"radiosity", "distribution", "path", "points", "direct"};
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

/// How far a mode is from path mode: of blocks of 8 x 8 pixels, the one that is furthest beyond chance.
struct Agreement {
  double excess =
      0;  ///< |difference| minus what the bias bound allows, over the standard error; <= limit is good
  double difference = 0, reference = 0, standardError = 0;
  double pictureBias = 0;   ///< relative, of the whole picture's mean
  double pictureError = 0;  ///< one standard error of that
};

using Blocks = std::vector<std::vector<double>>;  // [seed][block and channel]

Agreement agreement(const Blocks& mode, const Blocks& path, double bias) {
  const auto columnOf = [](const Blocks& blocks, size_t k) {
    std::vector<double> values;
    for (const auto& seed : blocks) values.push_back(seed[k]);
    return bench::summarize(values);
  };
  const auto meansOf = [](const Blocks& blocks) {
    std::vector<double> values;
    for (const auto& seed : blocks) {
      double sum = 0;
      for (const double v : seed) sum += v;
      values.push_back(sum / static_cast<double>(seed.size()));
    }
    return bench::summarize(values);
  };
  const bench::Summary a = meansOf(mode), b = meansOf(path);
  Agreement worst;
  worst.excess = -1e30;
  if (b.mean > 0) {
    worst.pictureBias = a.mean / b.mean - 1;
    worst.pictureError = std::hypot(a.standardError(), b.standardError()) / b.mean;
  }
  for (size_t k = 0; k < path[0].size(); ++k) {
    const bench::Summary m = columnOf(mode, k), p = columnOf(path, k);
    const double error = std::hypot(m.standardError(), p.standardError()) + 1e-6 * std::abs(b.mean) + 1e-12;
    // Dark blocks beside bright ones: a part of the picture's mean is allowed, too.
    const double allowed = bias * std::abs(p.mean) + 0.2 * bias * std::abs(b.mean);
    const double excess = (std::abs(m.mean - p.mean) - allowed) / error;
    if (excess > worst.excess) {
      worst.excess = excess, worst.difference = m.mean - p.mean;
      worst.reference = p.mean, worst.standardError = error;
    }
  }
  return worst;
}

struct Row {
  uint64_t number = 0;
  RandomScene scene;
  std::vector<std::string> wrong;
  double seconds = 0;
  bool refusedSamples = false;
  std::map<std::string, Agreement> agreements;
  double worstExcess() const {
    double worst = -1e30;
    for (const auto& [mode, a] : agreements) worst = std::max(worst, a.excess);
    return worst;
  }
};

/// Standard errors that one comparison may be beyond its bias: Student's t of 2 (seeds - 1) degrees of
/// freedom for a significance of 1e-3 over all `comparisons` (Sidak).
double limitOf(const Settings& settings, size_t comparisons) {
  const double p = bench::sidak(1e-3, std::max<size_t>(comparisons, 1));
  double low = 0, high = 1e4;
  for (int k = 0; k < 100; ++k) {
    const double middle = (low + high) / 2;
    (bench::studentTails(middle, 2.0 * (settings.seeds - 1)) > p ? low : high) = middle;
  }
  return high;
}

Row run(const Settings& settings, uint64_t number, const std::vector<LibraryShader>& shaders) {
  Row row;
  row.number = number, row.scene = makeRandomScene(number, shaders);
  const fs::path rib = settings.render.work / fmt::format("scene{}.rib", number);
  std::ofstream(rib, std::ios::binary) << row.scene.rib;
  for (const std::string& mode : settings.modes) {
    const Judged judged = judgedRender(settings.render, rib, mode, {"--rays", "16", "--samples", "2"});
    if (!judged.wrong.empty()) row.wrong.push_back(mode + ": " + judged.wrong);
    row.refusedSamples |= judged.said.find("camera samples were not finite") != std::string::npos;
    row.seconds = std::max(row.seconds, judged.seconds);
  }
  if (!settings.compare || !row.scene.comparable || !row.wrong.empty()) return row;
  std::map<std::string, Blocks> blocks;
  for (const std::string mode : {"path", "radiosity", "distribution"})
    for (int seed = 0; seed < settings.seeds; ++seed) {
      const int samples = mode == "path" ? 8 * settings.samples : settings.samples;
      const Judged judged = judgedRender(
          settings.render, rib, mode,
          {"--rays", "16", "--samples", std::to_string(samples), "--seed", std::to_string(seed + 1)});
      if (!judged.wrong.empty()) row.wrong.push_back(mode + ", many samples: " + judged.wrong);
      if (judged.picture.channels < 3) return row;
      ImageData rgb{judged.picture.width, judged.picture.height, 3, {"R", "G", "B"}, false, {}};
      for (int y = 0; y < rgb.height; ++y)
        for (int x = 0; x < rgb.width; ++x)
          rgb.pixels.insert(rgb.pixels.end(), judged.picture.pixel(x, y), judged.picture.pixel(x, y) + 3);
      blocks[mode].push_back(bench::blockMeans(rgb, 8));
    }
  for (const char* mode : {"radiosity", "distribution"})
    row.agreements[mode] = agreement(blocks[mode], blocks["path"], settings.bias);
  return row;
}

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  settings.render.patina = fs::read_symlink("/proc/self/exe").parent_path() / "patina";
  CLI::App app("Random scenes with nasty ingredients, in every mode.");
  std::string patina, keep, report;
  app.add_option("--patina", patina, "The program, with patina-shader beside it");
  app.add_option("--first", settings.first, "Number of the first scene");
  app.add_option("--count", settings.count, "Scenes");
  app.add_option("--modes", settings.modes, "Modes")->delimiter(',');
  app.add_option("--seconds", settings.render.seconds, "Limit of one render");
  app.add_flag("--compare", settings.compare,
               "Compare radiosity and distribution with path where light is sane");
  app.add_option("--seeds", settings.seeds, "Pictures of each mode to compare");
  app.add_option("--samples", settings.samples,
                 "Samples per pixel to compare; path takes eight times as many");
  app.add_option("--bias", settings.bias, "Relative bias that is allowed");
  app.add_option("--keep", keep, "Folder that scenes and pictures are left in");
  app.add_option("--report", report, "Markdown file for the results");
  CLI11_PARSE(app, argc, argv);
  if (!patina.empty()) settings.render.patina = fs::absolute(patina);
  settings.shaders = settings.render.patina.parent_path() / "../lib/patina/shaders";
  std::string pattern = (fs::temp_directory_path() / "patina-random-XXXXXX").string();
  settings.render.work = keep.empty() ? fs::path(mkdtemp(pattern.data())) : fs::absolute(keep);
  fs::create_directories(settings.render.work);
  int bad = 0;
  try {
    const std::vector<LibraryShader> shaders = library(settings);
    std::vector<Row> rows;
    size_t compared = 0;
    for (int k = 0; k < settings.count; ++k) {
      Row& row = rows.emplace_back(run(settings, settings.first + static_cast<uint64_t>(k), shaders));
      compared += !row.agreements.empty();
      std::string line = fmt::format("{:4} {:6.2f} s {}", row.number, row.seconds,
                                     row.refusedSamples ? "[samples refused] " : "");
      for (const auto& [mode, a] : row.agreements)
        line += fmt::format("{} {:+.2f} % +- {:.2f} %, block at {:.1f}; ", mode, 100 * a.pictureBias,
                            100 * a.pictureError, a.excess);
      for (const std::string& w : row.wrong) line += "WRONG " + w + "; ";
      std::cout << line << std::endl;
    }
    // Two modes, four blocks of three channels each.
    const double limit = limitOf(settings, compared * 24);
    std::ofstream out(report.empty() ? "/dev/null" : report);
    out << "| scene | ingredients | slowest mode, s | radiosity against path | distribution against path | "
           "|\n"
           "| ---: | --- | ---: | --- | --- | --- |\n";
    int disagree = 0;
    const Row* worst = nullptr;
    for (const Row& row : rows) {
      const bool differs = row.worstExcess() > limit;
      disagree += differs, bad += !row.wrong.empty();
      if (!row.agreements.empty() && (!worst || row.worstExcess() > worst->worstExcess())) worst = &row;
      std::string what;
      for (const std::string& i : row.scene.ingredients) what += (what.empty() ? "" : ", ") + i;
      const auto cell = [&](const char* mode) {
        const auto found = row.agreements.find(mode);
        if (found == row.agreements.end())
          return std::string(row.scene.comparable ? "" : "light is not sane");
        const Agreement& a = found->second;
        return fmt::format("{:+.2f} % ± {:.2f} %", 100 * a.pictureBias, 100 * a.pictureError);
      };
      std::string verdict = differs ? "**differs**" : "";
      for (const std::string& w : row.wrong) verdict += " **" + w + "**";
      out << fmt::format("| {} | {} | {:.2f} | {} | {} | {} |\n", row.number, what, row.seconds,
                         cell("radiosity"), cell("distribution"), verdict);
    }
    const std::string summary = fmt::format(
                                    "{} scenes: {} wrong; {} compared with path mode, {} differ by more than "
                                    "{:g} % and {:.1f} standard "
                                    "errors in a block",
                                    rows.size(), bad, compared, disagree, 100 * settings.bias, limit) +
                                (worst ? fmt::format(" (the worst: {})", worst->number) : "");
    std::cout << summary << "\n";
    out << "\n" << summary << ".\n";
    bad += disagree;
  } catch (const std::exception& problem) {
    std::cerr << problem.what() << "\n";
    bad = 1;
  }
  if (keep.empty()) fs::remove_all(settings.render.work);
  return bad > 0;
}
