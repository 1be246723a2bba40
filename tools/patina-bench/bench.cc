// SPDX-License-Identifier: Apache-2.0
// Measuring, comparing, testing agreement: from options to files.
#include "tools/patina-bench/bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "tools/patina-bench/compare.h"
#include "tools/patina-bench/report.h"

namespace patina::bench {
namespace {

namespace fs = std::filesystem;

// Seeds of the second setting of a test of agreement: the first has 1, 2 ...
constexpr int kSecondSeeds = 500'000;

void say(const std::string& text) {
  std::fputs(text.c_str(), stdout);
  std::fflush(stdout);
}

struct Session {
  explicit Session(const BenchOptions& options)
      : folder(fs::absolute(options.output)), render{folder, options.threads, options.timeoutSeconds} {
    for (const std::string& text : options.builds) {
      builds.push_back(findBuild(text));
      for (size_t i = 0; i + 1 < builds.size(); ++i)
        if (builds[i].name == builds.back().name)
          throw std::runtime_error("two programs are named " + builds.back().name + ": give NAME=PATH");
    }
    if (builds.empty()) builds.push_back(defaultBuild());
    fs::create_directories(folder);
  }
  std::vector<Scene> load(const std::vector<std::string>& paths) const {
    std::vector<Scene> scenes;
    for (const std::string& path : paths) {
      scenes.push_back(loadScene(path, folder / "scenes"));
      for (size_t i = 0; i + 1 < scenes.size(); ++i)
        if (scenes[i].name == scenes.back().name)
          throw std::runtime_error("two scenes are named " + scenes.back().name);
    }
    return scenes;
  }
  fs::path folder;
  RenderOptions render;
  std::vector<Build> builds;
};

std::vector<Setting> settingsFrom(const std::string& file) {
  if (file.empty()) return defaultSettings();
  try {
    return parseSettings(nlohmann::json::parse(readFile(file)), file);
  } catch (const nlohmann::json::exception& problem) {
    throw std::runtime_error(file + ": " + problem.what());
  }
}

Run plan(const Session& session, const Scene& scene, const Setting& setting, const Build& build, int repeat) {
  Run run;
  run.scene = scene.name, run.mode = setting.mode, run.setting = setting.name, run.build = build.name;
  run.args = scene.args;
  run.args.insert(run.args.end(), setting.args.begin(), setting.args.end());
  run.repeat = repeat, run.seed = repeat + 1, run.threads = session.render.threads;
  run.sceneHash = scene.hash, run.buildHash = build.hash;
  return run;
}

// A sheet shows the first repeat of every setting whose picture is still there.
void writePictures(const Session& session, const Results& results, const Scene& scene,
                   const ImageData& reference) {
  const std::vector<Point> points = summarizeRuns(results);
  for (const Build& build : session.builds) {
    const std::vector<const Point*> own = pointsOf(points, scene.name, build.name);
    std::string title = scene.name;
    if (session.builds.size() > 1) title += ", " + build.name;
    writeText(session.folder / plotFile(scene.name, build.name), svgPlot(title, own));
    std::vector<std::vector<ImageData>> rows;
    for (const std::string& mode : namesOf(points, &Point::mode)) {
      std::vector<ImageData> row;
      for (const Point* p : own) {
        if (p->mode != mode) continue;
        row.emplace_back();
        if (p->runs.empty()) continue;
        const fs::path file = pictureOf(*p->runs[0], session.folder);
        if (fs::exists(file)) row.back() = loadPicture(file);
      }
      if (!row.empty()) rows.push_back(std::move(row));
    }
    writeSheet(session.folder / sheetFile(scene.name, build.name), reference, rows);
  }
}

// By turns of builds and settings, so that what disturbs the machine for a while disturbs all of them.
void measureScene(const BenchOptions& options, const Session& session, const Scene& scene,
                  const std::vector<Setting>& settings, const ImageData& reference, Results& results) {
  for (int repeat = 0; repeat < options.repeats; ++repeat)
    for (const Setting& setting : settings) {
      if (!isWanted(options.only, scene.name, setting)) continue;
      for (const Build& build : session.builds) {
        Run run = plan(session, scene, setting, build, repeat);
        const auto known = [&](const Run& r) { return r.failure.empty() && r.isSameWork(run); };
        if (std::ranges::any_of(results.runs, known)) continue;
        std::erase_if(results.runs, [&](const Run& r) {
          return r.scene == run.scene && r.mode == run.mode && r.setting == run.setting &&
                 r.build == run.build && r.repeat == repeat;
        });
        say(fmt::format("{}/{}/{} {} #{} ", scene.name, setting.mode, setting.name, build.name, repeat + 1));
        const ImageData picture = render(build, scene, session.render, run);
        if (run.failure.empty()) {
          run.errors = imageErrors(picture, reference);
          say(fmt::format("{:.2f} s, relMSE {:.3g}\n", run.wallSeconds, run.errors.relMse));
        } else {
          say("failed: " + run.failure + "\n");
        }
        results.runs.push_back(std::move(run));
        writeResults(session.folder / "results.json", results);
      }
    }
}

}  // namespace

int measure(const BenchOptions& options) {
  const Session session(options);
  const std::vector<Setting> common = settingsFrom(options.settingsFile);
  const std::vector<Scene> scenes = session.load(options.scenes);
  const fs::path file = session.folder / "results.json";
  ReferenceOptions wanted = options.reference;
  if (wanted.cache.empty()) wanted.cache = session.folder / "references";
  Results results;
  if (options.resume && fs::exists(file)) results = readResults(file);
  size_t matched = 0;
  for (const Scene& scene : scenes) {
    const std::vector<Setting>& settings = scene.settings.empty() ? common : scene.settings;
    if (!isWanted(options.only, scene.name, settings)) continue;
    ++matched;
    if (options.list) {
      for (const Setting& s : settings)
        if (isWanted(options.only, scene.name, s))
          say(fmt::format("{}/{}/{}: {}\n", scene.name, s.mode, s.name,
                          fmt::join(plan(session, scene, s, session.builds[0], 0).args, " ")));
      continue;
    }
    say(fmt::format("{}: reference\n", scene.name));
    const Reference reference = findReference(session.builds[0], scene, session.render, wanted);
    results.references[scene.name] = reference.info;
    measureScene(options, session, scene, settings, reference.picture, results);
    writeResults(file, results);
    writePictures(session, results, scene, reference.picture);
    writeText(session.folder / "report.md", markdownReport(results, options.targets));
  }
  if (matched == 0) throw std::runtime_error("no scene and setting matches --only");
  if (options.list) return 0;
  const std::vector<Point> points = summarizeRuns(results);
  for (size_t k = 1; k < session.builds.size(); ++k) {
    std::vector<Point> before, after;
    for (const Point& p : points) {
      if (p.build == session.builds[0].name) before.push_back(p);
      if (p.build == session.builds[k].name) after.push_back(p);
    }
    const std::string text = fmt::format("# {} -> {}\n\n{}", session.builds[0].name, session.builds[k].name,
                                         describeChanges(compareRuns(before, after)));
    writeText(session.folder / fmt::format("compare{}.md", k), text);
    say("\n" + text);
  }
  say("\n" + (session.folder / "report.md").string() + "\n");
  return std::ranges::any_of(results.runs, [](const Run& r) { return !r.failure.empty(); }) ? 1 : 0;
}

int testAgreement(const BenchOptions& options, const std::string& first, const std::string& second, int seeds,
                  int block) {
  const Session session(options);
  std::vector<Setting> sides;
  for (const std::string& text : {first, second}) {
    std::istringstream in(text);
    Setting side{"", sides.empty() ? "agree1" : "agree2", {}};
    in >> side.mode;
    for (std::string word; in >> word;) side.args.push_back(word);
    if (side.mode.empty() || side.mode.starts_with('-'))
      throw std::runtime_error("expected MODE and its arguments, not \"" + text + "\"");
    sides.push_back(std::move(side));
  }
  std::vector<Agreement> agreements;
  for (const Scene& scene : session.load(options.scenes)) {
    if (!options.only.empty() && !isWanted(options.only, scene.name, sides)) continue;
    std::array<std::vector<std::vector<double>>, 2> means;
    Agreement agreement;
    // By turns, and the pictures of a side are of equal cost.
    for (int k = 0; k < seeds && agreement.failure.empty(); ++k)
      for (size_t side = 0; side < 2 && agreement.failure.empty(); ++side) {
        Run run = plan(session, scene, sides[side], session.builds[0], 0);
        run.seed = static_cast<int>(side) * kSecondSeeds + k + 1;
        const ImageData picture = render(session.builds[0], scene, session.render, run);
        agreement.failure = run.failure;
        if (run.failure.empty()) means[side].push_back(blockMeans(picture, block));
      }
    if (agreement.failure.empty()) agreement = compareBlocks(means[0], means[1]);
    agreement.scene = scene.name;
    agreements.push_back(agreement);
    say(fmt::format("{}: {}\n", scene.name, agreement.failure.empty() ? "done" : agreement.failure));
  }
  const std::string text = fmt::format(
      "# {} against {}\n\nMeans of blocks of {} x {} pixels over {} pictures each; Welch's t-test, "
      "significance {} over all blocks and channels of a scene.\n\n{}",
      first, second, block, block, seeds, kSignificance, describeAgreements(agreements));
  writeText(session.folder / "agreement.md", text);
  say("\n" + text);
  const auto bad = [](const Agreement& a) { return a.differing > 0 || !a.failure.empty(); };
  return std::ranges::any_of(agreements, bad) ? 1 : 0;
}

int compareFiles(const std::string& before, const std::string& after) {
  const Results old = readResults(before), now = readResults(after);
  const std::vector<Point> a = summarizeRuns(old), b = summarizeRuns(now);
  for (const auto& [points, file] : {std::pair(&a, before), std::pair(&b, after)})
    if (namesOf(*points, &Point::build).size() > 1)
      throw std::runtime_error(file + " holds results of several programs");
  const std::vector<Change> changes = compareRuns(a, b);
  say(describeChanges(changes));
  return changes.empty() || std::ranges::any_of(changes, [](const Change& c) { return c.changed; }) ? 1 : 0;
}

}  // namespace patina::bench
