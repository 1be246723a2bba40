// SPDX-License-Identifier: Apache-2.0
// Measuring: from options to results and their report.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "tools/patina-bench/compare.h"
#include "tools/patina-bench/report.h"
#include "tools/patina-bench/schedule.h"
#include "tools/patina-bench/session.h"

namespace patina::bench {
namespace {

namespace fs = std::filesystem;

// Of a scene's time, what its reference may take. The longest renders of path mode get a sixth or so: the
// reference has a third of their squared error then.
constexpr double kReferenceShare = 0.45;
// Later repeats measure what the first one had time for; they take as long, or so many times that at most.
constexpr double kSlack = 3;
// Of all time, what plots and the making of scenes may take.
constexpr double kReserve = 0.03;

std::vector<Setting> settingsFrom(const std::string& file) {
  if (file.empty()) return defaultSettings();
  try {
    return parseSettings(nlohmann::json::parse(readFile(file)), file);
  } catch (const nlohmann::json::exception& problem) {
    throw std::runtime_error(file + ": " + problem.what());
  }
}

// A sheet shows the first repeat of every setting whose picture is still there.
void writePictures(const Session& session, const Results& results, const Scene& scene,
                   const ImageData& reference) {
  const std::vector<Point> points = summarizeRuns(results);
  const auto info = results.references.find(scene.name);
  const double noise = info == results.references.end() ? 0 : info->second.relMse;
  for (const Build& build : session.builds) {
    const std::vector<const Point*> own = pointsOf(points, scene.name, build.name);
    std::string title = scene.name;
    if (session.builds.size() > 1) title += ", " + build.name;
    writeText(session.folder / plotFile(scene.name, build.name), svgPlot(title, own, noise));
    std::vector<std::vector<SheetPicture>> rows;
    for (const std::string& mode : namesOf(points, &Point::mode)) {
      std::vector<SheetPicture> row;
      for (const Point* p : own) {
        if (p->mode != mode) continue;
        if (p->runs.empty()) continue;
        const fs::path file = pictureOf(*p->runs[0], session.folder);
        if (!fs::exists(file)) continue;
        row.push_back({loadPicture(file),
                       {p->mode + " " + p->setting,
                        fmt::format("{:.3g} s, relMSE {:.2g}", p->wall.mean, p->relMse.mean)}});
      }
      if (!row.empty()) rows.push_back(std::move(row));
    }
    writeSheet(session.folder / sheetFile(scene.name, build.name), reference, rows);
  }
}

// The settings of one repeat on a scene, within the seconds that there are for it; by turns of builds, too,
// so that what disturbs the machine for a while disturbs all of them.
class SceneJob {
 public:
  SceneJob(const BenchOptions& options, const Session& session, const Scene& scene,
           const std::vector<Setting>& settings, const ImageData& reference, Results& results)
      : options_(options), session_(session), scene_(scene), reference_(reference), results_(results) {
    for (const Setting& s : byTurns(settings))
      if (isWanted(options.only, scene.name, s)) settings_.push_back(s);
  }

  void measure(int repeat, const Budget& budget) {
    Shares shares(settings_);
    const auto builds = static_cast<double>(session_.builds.size());
    for (const Setting& setting : settings_) {
      for (const Build& build : session_.builds) {
        Run run = plan(session_, scene_, setting, build, repeat);
        if (isKnown(run)) continue;
        RenderOptions render = session_.render;
        if (budget.limited()) {
          const double seconds =
              repeat > 0 ? kSlack * firstSeconds(run) : shares.allow(setting.mode, budget.left() / builds);
          if (seconds <= 0 && repeat > 0) continue;  // the first repeat tells why
          if (seconds <= 0) {
            run.failure = "not begun, no time left", run.outOfTime = true;
            record(std::move(run));
            continue;
          }
          if (render.timeoutSeconds <= 0 || seconds < render.timeoutSeconds) render.timeoutSeconds = seconds;
        }
        const Budget own(0);
        carryOut(build, render, run);
        shares.took(setting.mode, own.elapsed(), run.outOfTime);
        record(std::move(run));
      }
      shares.pass(setting.mode);
    }
  }

 private:
  // Of the first repeat; 0 = it has no picture.
  double firstSeconds(const Run& run) const {
    const auto found = std::ranges::find_if(results_.runs, [&](const Run& r) {
      return r.scene == run.scene && r.mode == run.mode && r.setting == run.setting && r.build == run.build &&
             r.repeat == 0;
    });
    return found != results_.runs.end() && found->failure.empty() ? found->wallSeconds : 0;
  }
  bool isKnown(const Run& run) const {
    return std::ranges::any_of(results_.runs,
                               [&](const Run& r) { return r.failure.empty() && r.isSameWork(run); });
  }
  void carryOut(const Build& build, const RenderOptions& render, Run& run) {
    say(fmt::format("{}/{}/{} {} #{} ", run.scene, run.mode, run.setting, build.name, run.repeat + 1));
    const ImageData picture = bench::render(build, scene_, render, run);
    if (run.failure.empty()) {
      run.errors = imageErrors(picture, reference_);
      say(fmt::format("{:.2f} s, relMSE {:.3g}\n", run.wallSeconds, run.errors.relMse));
    } else {
      say((run.outOfTime ? "" : "failed: ") + run.failure + "\n");
    }
  }
  void record(Run run) {
    std::erase_if(results_.runs, [&](const Run& r) {
      return r.scene == run.scene && r.mode == run.mode && r.setting == run.setting && r.build == run.build &&
             r.repeat == run.repeat;
    });
    results_.runs.push_back(std::move(run));
    writeResults(session_.folder / "results.json", results_);
  }

  const BenchOptions& options_;
  const Session& session_;
  const Scene& scene_;
  const ImageData& reference_;
  Results& results_;
  std::vector<Setting> settings_;
};

// Another reference makes other errors: what was measured with the one before is measured anew.
void useReference(const std::string& scene, const ReferenceInfo& info, Results& results) {
  const auto before = results.references.find(scene);
  if (before != results.references.end() && !before->second.isSame(info))
    std::erase_if(results.runs, [&](const Run& r) { return r.scene == scene; });
  results.references[scene] = info;
}

void measureScene(const BenchOptions& options, const Session& session, const Scene& scene,
                  const std::vector<Setting>& settings, double seconds, Results& results) {
  const Budget budget(seconds);
  ReferenceOptions wanted = options.reference;
  if (wanted.cache.empty()) wanted.cache = session.folder / "references";
  wanted.seconds = seconds * kReferenceShare;
  // What was measured against a reference goes on with it, however much time there is now.
  wanted.keep = results.references.contains(scene.name);
  say(fmt::format("{}: reference\n", scene.name));
  const Reference reference = findReference(session.builds[0], scene, session.render, wanted);
  useReference(scene.name, reference.info, results);
  SceneJob job(options, session, scene, settings, reference.picture, results);
  for (int repeat = 0; repeat < options.repeats; ++repeat)
    job.measure(repeat,
                Budget(budget.limited() ? std::max(budget.left() / (options.repeats - repeat), 1e-3) : 0));
  writeResults(session.folder / "results.json", results);
  writePictures(session, results, scene, reference.picture);
  writeText(session.folder / "report.md", markdownReport(results, options.targets));
}

// Each program against the first one.
void compareBuilds(const Session& session, const Results& results) {
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
}

}  // namespace

int measure(const BenchOptions& options) {
  const Budget budget(60 * options.minutes * (1 - kReserve));
  const Session session(options);
  const std::vector<Setting> common = settingsFrom(options.settingsFile);
  const auto settingsOf = [&](const Scene& scene) -> const std::vector<Setting>& {
    return scene.settings.empty() ? common : scene.settings;
  };
  std::vector<Scene> scenes = session.load(options.scenes);
  std::erase_if(scenes, [&](const Scene& s) { return !isWanted(options.only, s.name, settingsOf(s)); });
  if (scenes.empty()) throw std::runtime_error("no scene and setting matches --only");
  if (options.list) {
    for (const Scene& scene : scenes)
      for (const Setting& s : settingsOf(scene))
        if (isWanted(options.only, scene.name, s))
          say(fmt::format("{}/{}/{}: {}\n", scene.name, s.mode, s.name,
                          fmt::join(plan(session, scene, s, session.builds[0], 0).args, " ")));
    return 0;
  }
  const fs::path file = session.folder / "results.json";
  Results results;
  if (options.resume && fs::exists(file)) results = readResults(file);
  results.environment = describeMachine();
  results.environment.command = options.command;
  for (const Build& build : session.builds)
    results.environment.builds[build.name] = versionOf(build.program.string());
  for (size_t k = 0; k < scenes.size(); ++k) {
    // What a scene leaves over goes to those that follow.
    const double seconds =
        budget.limited() ? std::max(budget.left() / static_cast<double>(scenes.size() - k), 1e-3) : 0;
    measureScene(options, session, scenes[k], settingsOf(scenes[k]), seconds, results);
  }
  compareBuilds(session, results);
  say("\n" + (session.folder / "report.md").string() + "\n");
  const auto failed = [](const Run& r) { return !r.failure.empty() && !r.outOfTime; };
  return std::ranges::any_of(results.runs, failed) ? 1 : 0;
}

}  // namespace patina::bench
