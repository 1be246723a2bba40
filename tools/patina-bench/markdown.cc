// SPDX-License-Identifier: Apache-2.0
// Tables of results, as Markdown.
#include <fmt/format.h>

#include <algorithm>

#include "tools/patina-bench/report.h"

namespace patina::bench {
namespace {

std::string number(double v) { return fmt::format("{:.3g}", v); }
std::string count(double v) {
  return v >= 1e9   ? fmt::format("{:.3g} G", v / 1e9)
         : v >= 1e6 ? fmt::format("{:.3g} M", v / 1e6)
                    : fmt::format("{:.3g} k", v / 1e3);
}
// With its standard error, if that is known.
std::string withError(const Summary& s, double scale = 1) {
  if (s.count < 2) return number(s.mean * scale);
  return fmt::format("{} ± {:.2g}", number(s.mean * scale), s.standardError() * std::abs(scale));
}

// What a reader needs to judge the numbers. Results of before there was such a record have none.
void addEnvironment(std::string& text, const Results& results) {
  const Environment& e = results.environment;
  if (e.command.empty() && e.cpu.empty()) return;
  int repeats = 0;
  for (const Run& run : results.runs) repeats = std::max(repeats, run.repeat + 1);
  text += "| | |\n| --- | --- |\n";
  const auto row = [&](const std::string& name, const std::string& value) {
    if (!value.empty()) text += fmt::format("| {} | {} |\n", name, value);
  };
  row("command", "`" + e.command + "`");
  for (const auto& [name, version] : e.builds) row("build " + name, version);
  row("CPU", fmt::format("{}, {} processors used", e.cpu, e.processors));
  row("memory", fmt::format("{:.3g} GB", e.memoryGb));
  row("system", e.system);
  row("date", e.date);
  row("load before", fmt::format("{:.2g} (0 = idle; others' work makes wall times longer)", e.load));
  row("repeats", fmt::format("{}{}", repeats, repeats > 1 ? "; ± is the standard error over them" : ""));
  text += "\n";
}

std::string secondsText(const std::vector<CurvePoint>& curve, double error, double noise) {
  const std::optional<EqualError> found = secondsAtError(curve, error);
  if (!found) return "not reached";
  // What is left after the noise was taken off is a difference of like numbers there.
  if (error < noise) return "(" + secondsText(curve, error, 0) + ")";
  const char* mark = found->kind == EqualError::AtMost         ? "at most "
                     : found->kind == EqualError::Extrapolated ? "about "
                                                               : "";
  return mark + number(found->seconds);
}

void addEqualError(std::string& text, const Results& results, std::span<const Point> points,
                   std::span<const double> targets) {
  text += "| scene | build | mode |";
  for (const double t : targets) text += fmt::format(" {:g} |", t);
  text += "\n| --- | --- | --- |";
  for (size_t i = 0; i < targets.size(); ++i) text += " --- |";
  text += "\n";
  const std::vector<std::string> modes = namesOf(points, &Point::mode);
  for (const std::string& scene : namesOf(points, &Point::scene))
    for (const std::string& build : namesOf(points, &Point::build))
      for (const std::string& mode : modes) {
        const std::vector<CurvePoint> curve = curveOf(pointsOf(points, scene, build), mode);
        if (curve.empty()) continue;
        const auto info = results.references.find(scene);
        const double noise = info == results.references.end() ? 0 : info->second.relMse;
        text += fmt::format("| {} | {} | {} |", scene, build, mode);
        for (const double t : targets) text += " " + secondsText(curve, t, noise) + " |";
        text += "\n";
      }
}

void addScene(std::string& text, const Results& results, std::span<const Point> points,
              const std::string& scene, const std::string& build) {
  const std::vector<const Point*> own = pointsOf(points, scene, build);
  if (own.empty()) return;
  text += fmt::format("\n## {}, {}\n\n", scene, build);
  if (const auto found = results.references.find(scene); found != results.references.end()) {
    const ReferenceInfo& r = found->second;
    if (r.kind == "path") {
      text += fmt::format(
          "Reference: path mode, {} pictures of {} samples per pixel{}; its own noise is relMSE {}", r.seeds,
          r.samples, r.seconds > 0 ? fmt::format(" ({:.0f} s)", r.seconds) : "", number(r.relMse));
    } else {
      text += fmt::format("Reference: {}; its own noise is relMSE {}", r.file, number(r.relMse));
    }
    text += ", which is taken off below.\n\n";
  }
  text +=
      "| mode | setting | wall s | CPU s | rays | shader points | peak MB | relMSE | 99th percentile | mean "
      "error % |\n"
      "| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n";
  for (const std::string& mode : namesOf(points, &Point::mode))
    for (const Point* p : own) {
      if (p->mode != mode) continue;
      text += fmt::format("| {} | {} | ", p->mode, p->setting);
      if (p->runs.empty()) {
        text += fmt::format("{} | | | | | | | |\n", p->failure);
        continue;
      }
      text += fmt::format("{} | {} | {} | {} | {:.0f} | {} | {} | {} |\n", withError(p->wall),
                          withError(p->cpu), count(p->rays.mean), count(p->shaderPoints.mean), p->peakMb.mean,
                          withError(p->relMse), number(p->percentile99.mean), withError(p->meanError, 100));
    }
  text += fmt::format("\n![relMSE over seconds]({})\n\n![pictures, and their errors below]({})\n",
                      plotFile(scene, build), sheetFile(scene, build));
}

}  // namespace

std::string plotFile(const std::string& scene, const std::string& build) {
  std::string name = scene + "." + build + ".svg";
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '.' && c != '-') c = '_';
  return name;
}

std::string sheetFile(const std::string& scene, const std::string& build) {
  std::string name = plotFile(scene, build);
  return name.replace(name.size() - 3, 3, "png");
}

std::string markdownReport(const Results& results, std::span<const double> targets) {
  const std::vector<Point> points = summarizeRuns(results);
  std::string text = "# Time against error\n\n";
  addEnvironment(text, results);
  text +=
      "## Wall seconds at equal error\n\n"
      "Wall seconds at equal relMSE = mean((x - r)^2 / (r^2 + 0.01)), by the best settings of each mode: "
      "interpolated between settings; \"about\": extrapolated beyond the best; \"at most\": the quickest is "
      "better already; in brackets: uncertain, as the error is below the noise of the reference.\n\n";
  addEqualError(text, results, points, targets);
  for (const std::string& scene : namesOf(points, &Point::scene))
    for (const std::string& build : namesOf(points, &Point::build))
      addScene(text, results, points, scene, build);
  std::string failures;
  for (const Run& run : results.runs)
    if (!run.failure.empty() && !run.outOfTime)
      failures +=
          fmt::format("* {}/{}/{}, {}: {}\n", run.scene, run.mode, run.setting, run.build, run.failure);
  if (!failures.empty()) text += "\n## Failed\n\n" + failures;
  return text;
}

}  // namespace patina::bench
