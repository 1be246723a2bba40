// SPDX-License-Identifier: Apache-2.0
// Results to JSON and back, and their means over repeats.
#include "tools/patina-bench/results.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "tools/patina-bench/scenes.h"

namespace patina::bench {
namespace {

using nlohmann::json;
constexpr int kVersion = 1;

std::string hex(uint64_t hash) { return fmt::format("{:016x}", hash); }
uint64_t fromHex(const std::string& text) { return std::stoull(text, nullptr, 16); }

json toJson(const Run& r) {
  json j = {{"scene", r.scene},
            {"mode", r.mode},
            {"setting", r.setting},
            {"build", r.build},
            {"args", r.args},
            {"repeat", r.repeat},
            {"seed", r.seed},
            {"threads", r.threads},
            {"sceneHash", hex(r.sceneHash)},
            {"buildHash", hex(r.buildHash)}};
  if (!r.failure.empty()) {
    j["failure"] = r.failure;
    if (r.outOfTime) j["outOfTime"] = true;
    return j;
  }
  j.update({{"wallSeconds", r.wallSeconds},
            {"cpuSeconds", r.cpuSeconds},
            {"peakMb", r.peakMb},
            {"rays", r.rays},
            {"shaderPoints", r.shaderPoints},
            {"relMse", r.errors.relMse},
            {"meanError", r.errors.meanError},
            {"meanReference", r.errors.meanReference},
            {"percentile99", r.errors.percentile99},
            {"picture", hex(r.picture)}});
  return j;
}

json toJson(const Environment& e) {
  return {{"cpu", e.cpu},         {"processors", e.processors}, {"memoryGb", e.memoryGb},
          {"load", e.load},       {"system", e.system},         {"date", e.date},
          {"command", e.command}, {"builds", e.builds}};
}

Environment environmentFrom(const json& j) {
  Environment e;
  e.cpu = j.at("cpu"), e.processors = j.at("processors"), e.memoryGb = j.at("memoryGb"),
  e.load = j.at("load");
  e.system = j.at("system"), e.date = j.at("date"), e.command = j.at("command");
  e.builds = j.at("builds").get<std::map<std::string, std::string>>();
  return e;
}

Run runFrom(const json& j) {
  Run r;
  r.scene = j.at("scene"), r.mode = j.at("mode"), r.setting = j.at("setting"), r.build = j.at("build");
  r.args = j.at("args").get<std::vector<std::string>>();
  r.repeat = j.at("repeat"), r.seed = j.at("seed"), r.threads = j.at("threads");
  r.sceneHash = fromHex(j.at("sceneHash")), r.buildHash = fromHex(j.at("buildHash"));
  r.failure = j.value("failure", ""), r.outOfTime = j.value("outOfTime", false);
  if (!r.failure.empty()) return r;
  r.wallSeconds = j.at("wallSeconds"), r.cpuSeconds = j.at("cpuSeconds"), r.peakMb = j.at("peakMb");
  r.rays = j.at("rays"), r.shaderPoints = j.at("shaderPoints");
  r.errors.relMse = j.at("relMse"), r.errors.percentile99 = j.at("percentile99");
  r.errors.meanError = j.at("meanError"), r.errors.meanReference = j.at("meanReference");
  r.picture = fromHex(j.at("picture"));
  return r;
}

}  // namespace

bool ReferenceInfo::isSame(const ReferenceInfo& o) const {
  const auto name = [](const std::string& path) { return std::filesystem::path(path).filename(); };
  return kind == o.kind && name(file) == name(o.file) && samples == o.samples && seeds == o.seeds &&
         relMse == o.relMse;
}

bool Run::isSameWork(const Run& o) const {
  return scene == o.scene && mode == o.mode && setting == o.setting && build == o.build && args == o.args &&
         repeat == o.repeat && seed == o.seed && threads == o.threads && sceneHash == o.sceneHash &&
         buildHash == o.buildHash;
}

Results readResults(const std::filesystem::path& path) {
  try {
    const json j = json::parse(readFile(path));
    if (j.at("version") != kVersion)
      throw std::runtime_error(fmt::format("expected version {}, not {}", kVersion, j.at("version").dump()));
    Results results;
    for (const json& run : j.at("runs")) results.runs.push_back(runFrom(run));
    for (const auto& [scene, r] : j.at("references").items())
      results.references[scene] = {r.at("kind"),  r.at("file"),   r.at("samples"),
                                   r.at("seeds"), r.at("relMse"), r.value("seconds", 0.0)};
    if (j.contains("environment")) results.environment = environmentFrom(j["environment"]);
    return results;
  } catch (const std::exception& problem) {
    throw std::runtime_error(fmt::format("{} holds no results: {}", path.string(), problem.what()));
  }
}

void writeResults(const std::filesystem::path& path, const Results& results) {
  json j = {{"version", kVersion},
            {"environment", toJson(results.environment)},
            {"runs", json::array()},
            {"references", json::object()}};
  for (const Run& run : results.runs) j["runs"].push_back(toJson(run));
  for (const auto& [scene, r] : results.references) {
    j["references"][scene] = {{"kind", r.kind},   {"file", r.file},     {"samples", r.samples},
                              {"seeds", r.seeds}, {"relMse", r.relMse}, {"seconds", r.seconds}};
  }
  writeText(path, j.dump(1) + "\n");
}

std::vector<Point> summarizeRuns(const Results& results) {
  std::vector<Point> points;
  for (const Run& run : results.runs) {
    auto found = std::ranges::find_if(points, [&](const Point& p) {
      return p.scene == run.scene && p.mode == run.mode && p.setting == run.setting && p.build == run.build;
    });
    if (found == points.end()) {
      Point point;
      point.scene = run.scene, point.mode = run.mode, point.setting = run.setting, point.build = run.build;
      found = points.insert(points.end(), std::move(point));
    }
    if (run.failure.empty()) {
      found->runs.push_back(&run);
    } else if (found->failure.empty()) {
      found->failure = run.failure;
    }
  }
  for (Point& point : points) {
    const auto over = [&](auto value) {
      std::vector<double> values;
      for (const Run* run : point.runs) values.push_back(value(*run));
      return summarize(values);
    };
    const auto reference = results.references.find(point.scene);
    const double noise = reference == results.references.end() ? 0 : reference->second.relMse;
    point.wall = over([](const Run& r) { return r.wallSeconds; });
    point.cpu = over([](const Run& r) { return r.cpuSeconds; });
    point.peakMb = over([](const Run& r) { return r.peakMb; });
    point.rays = over([](const Run& r) { return r.rays; });
    point.shaderPoints = over([](const Run& r) { return r.shaderPoints; });
    point.percentile99 = over([](const Run& r) { return r.errors.percentile99; });
    // The noise of picture and reference is independent: their squares add up. A twentieth is left, as the
    // share is an estimate itself.
    point.relMse = over([&](const Run& r) { return std::max(r.errors.relMse - noise, 0.05 * noise); });
    point.meanError = over([](const Run& r) {
      double error = 0, mean = 0;
      for (size_t c = 0; c < 3; ++c) error += r.errors.meanError[c], mean += r.errors.meanReference[c];
      return mean != 0 ? error / mean : 0;
    });
  }
  return points;
}

std::vector<const Point*> pointsOf(std::span<const Point> points, const std::string& scene,
                                   const std::string& build) {
  std::vector<const Point*> found;
  for (const Point& p : points)
    if (p.scene == scene && p.build == build) found.push_back(&p);
  return found;
}

std::vector<std::string> namesOf(std::span<const Point> points, std::string Point::*member) {
  std::vector<std::string> names;
  for (const Point& p : points)
    if (std::ranges::find(names, p.*member) == names.end()) names.push_back(p.*member);
  return names;
}

std::vector<CurvePoint> curveOf(std::span<const Point* const> points, const std::string& mode) {
  std::vector<CurvePoint> curve;
  for (const Point* p : points)
    if (p->mode == mode && !p->runs.empty()) curve.push_back({p->wall.mean, p->relMse.mean});
  return curve;
}

}  // namespace patina::bench
