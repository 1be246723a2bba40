// SPDX-License-Identifier: Apache-2.0
// Pictures against closed forms, in every mode that claims them.
//
//   stress_closed_forms [--mode M] [--only TEXT] [--seeds N] [--effort K] [--report FILE]
//   stress_closed_forms --convergence [--mode M] [--only TEXT] [--seeds N] [--effort K] [--report FILE]
//
// Exit status 0 = all is as it should be. `--effort` multiplies the samples; with 1, what takes long is left
// out. `--report` writes the table into the file: README.md says how its own were made.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cmath>
#include <iostream>

#include "tests/stress/closed_forms.h"
#include "tools/patina-bench/statistics.h"

namespace patina::stress {
namespace {

struct Wanted {
  std::string mode, only, report;
  int seeds = 6, effort = 1;
  bool convergence = false;
};

/// A single-precision sum of as many terms as a pixel has; and what a mean over blocks without any noise may
/// be off.
constexpr double kRounding = 2e-6;

/// Noise that a verdict may have at most, of a block's mean: more would hide faults.
constexpr double kMostNoise = 0.02;

std::string sized(double value) { return value == 0 ? "0" : fmt::format("{:.1e}", value); }

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

/// Camera samples, diffuse rays and shadow rays grow alike.
RenderSettings settingsOf(const ClosedForm& c, const std::string& mode, int effort, int seed) {
  RenderSettings settings;
  settings.mode = mode, settings.samples = c.samples * effort, settings.seed = seed, settings.threads = 2;
  if (mode != "path") settings.rays = 256 * effort, settings.lightSamples = c.lightSamples * effort;
  return settings;
}

struct Verdict {
  double measured = 0;  ///< mean of the picture
  double worst = 0;     ///< largest difference of a block, relative to the mean of what is expected
  double noise = 0;     ///< largest standard error of a block, relative to the same
  bool holds = false;
};

Verdict judge(const ClosedForm& c, const Claim& claim, const Wanted& wanted) {
  std::vector<std::vector<double>> blocks;  // by seed
  std::vector<double> wholes;
  for (int seed = 1; seed <= wanted.seeds; ++seed) {
    const Picture p = render(c.rib, settingsOf(c, claim.mode, wanted.effort, seed), c.adjust);
    if (p.width != c.width || p.height != c.height) throw std::runtime_error(c.name + ": wrong size");
    blocks.push_back(blockMeans(p.values, p.width, p.height, c.block));
    wholes.push_back(p.mean());
  }
  const double scale = mean(c.expected);
  const std::vector<double> expected = blockMeans(c.expected, c.width, c.height, c.block);
  Verdict v;
  const bench::Summary whole = bench::summarize(wholes);
  v.measured = whole.mean, v.holds = true;
  const double level = bench::sidak(0.001, expected.size());
  for (size_t k = 0; k < expected.size(); ++k) {
    std::vector<double> values;
    for (const auto& b : blocks) values.push_back(b[k]);
    const bench::Summary s = bench::summarize(values);
    const double off = std::abs(s.mean - expected[k]);
    v.worst = std::max(v.worst, off / scale), v.noise = std::max(v.noise, s.standardError() / scale);
    // What is left beyond the bias has to be noise: Student's test, corrected for the number of blocks.
    const double beyond = off - claim.bias * scale, rounding = kRounding * scale;
    if (beyond <= rounding) continue;
    const double error = std::max(s.standardError(), rounding / 3);
    v.holds = v.holds && bench::studentTails(beyond / error, wanted.seeds - 1) >= level;
  }
  v.holds = v.holds && v.noise <= kMostNoise;
  return v;
}

bool isWanted(const ClosedForm& c, const Claim& claim, const Wanted& wanted) {
  if (claim.slow && wanted.effort == 1 && wanted.only.empty()) return false;
  return (wanted.mode.empty() ||
          ("," + wanted.mode + ",").find(fmt::format(",{},", claim.mode)) != std::string::npos) &&
         (wanted.only.empty() || (c.group + ": " + c.name).find(wanted.only) != std::string::npos);
}

bool judgeAll(const std::vector<ClosedForm>& cases, const Wanted& wanted) {
  std::string table =
      "| case | closed form | mode | expected | measured | largest error of a block | noise of a block | "
      "tolerance | "
      "because of |\n"
      "| --- | --- | --- | ---: | ---: | ---: | ---: | ---: | --- |\n";
  bool all = true;
  int judged = 0, failed = 0;
  for (const ClosedForm& c : cases) {
    bool first = true;
    for (const Claim& claim : c.claims) {
      if (!isWanted(c, claim, wanted)) continue;
      const Verdict v = judge(c, claim, wanted);
      ++judged, failed += !v.holds && !claim.known;
      all = all && (v.holds || claim.known);
      const std::string line = fmt::format(
          "| {} | {} | {} | {:.6g} | {:.6g} | {}{} | {} | {} | {} |\n", first ? c.group + ": " + c.name : "",
          first ? c.formula : "", claim.mode, mean(c.expected), v.measured, sized(v.worst),
          v.holds       ? ""
          : claim.known ? " **does not hold**"
                        : " **fails**",
          sized(v.noise), sized(claim.bias), claim.known && !v.holds ? claim.known : claim.reason);
      table += line;
      if (v.holds && claim.known) std::cout << "known to fail, but holds now: ";
      if (!v.holds || claim.known || !wanted.report.empty() || !wanted.only.empty())
        std::cout
            << fmt::format(
                   "{}: {}, {}: expected {:.6g}, measured {:.6g}, block off by {}, noise {}, bias {}{}\n",
                   c.group, c.name, claim.mode, mean(c.expected), v.measured, sized(v.worst), sized(v.noise),
                   sized(claim.bias),
                   v.holds       ? ""
                   : claim.known ? "  does not hold, as is known"
                                 : "  FAILS")
            << std::flush;
      first = false;
    }
  }
  std::cout << fmt::format("{} of {} are as they should be\n", judged - failed, judged);
  if (!wanted.report.empty()) replaceSection(wanted.report, "closed forms", table);
  return all && judged > 0;
}

// ---- Convergence ------------------------------------------------------------------------------------------

/// Root of the mean square over pixels and pictures of different seeds, relative to the expected mean; and
/// what is left of it in the mean of those pictures, over blocks.
struct Errors {
  double rms = 0, bias = 0;
};

Errors errorsOf(const ClosedForm& c, const Claim& claim, int effort, int seeds) {
  const double scale = mean(c.expected);
  double square = 0;
  std::vector<double> sum(c.expected.size(), 0);
  for (int seed = 1; seed <= seeds; ++seed) {
    RenderSettings settings = settingsOf(c, claim.mode, 1, seed);
    settings.samples = effort, settings.rays = 4 * effort, settings.lightSamples = std::max(1, effort / 4);
    if (std::string(claim.mode) == "path") settings.rays.reset(), settings.lightSamples.reset();
    const Picture p = render(c.rib, settings, c.adjust);
    for (size_t k = 0; k < sum.size(); ++k) {
      const double off = p.values[k] - c.expected[k];
      square += off * off, sum[k] += off;
    }
  }
  Errors e;
  e.rms = std::sqrt(square / static_cast<double>(sum.size() * static_cast<size_t>(seeds))) / scale;
  for (double& s : sum) s /= seeds;
  for (const double b : blockMeans(sum, c.width, c.height, c.block)) e.bias += b * b;
  e.bias =
      std::sqrt(e.bias / static_cast<double>(blockMeans(sum, c.width, c.height, c.block).size())) / scale;
  return e;
}

bool study(const std::vector<ClosedForm>& cases, const Wanted& wanted) {
  const std::vector<int> efforts{1, 4, 16, 64};
  std::string table = "| case | mode |";
  for (const int k : efforts) table += fmt::format(" {} |", k * wanted.effort);
  table += " slope | left in the mean | ends at |\n| --- | --- |";
  for (size_t k = 0; k < efforts.size(); ++k) table += " ---: |";
  table += " ---: | ---: | --- |\n";
  bool all = true;
  int judged = 0;
  for (const ClosedForm& c : cases) {
    if (!c.converges) continue;
    for (const Claim& claim : c.claims) {
      if (!isWanted(c, claim, wanted)) continue;
      std::vector<double> x, y;
      Errors e;
      std::string line = fmt::format("| {}: {} | {} |", c.group, c.name, claim.mode);
      for (const int k : efforts) {
        e = errorsOf(c, claim, k * wanted.effort, wanted.seeds);
        line += " " + sized(e.rms) + " |";
        // Where the bias is reached there is no slope.
        if (e.rms > std::max(2 * claim.bias, 1e-5)) x.push_back(std::log(k)), y.push_back(std::log(e.rms));
      }
      std::string slope = "-";
      bool falls = false;
      if (x.size() >= 2) {
        const double mx = mean(x), my = mean(y);
        double xx = 0, xy = 0;
        for (size_t k = 0; k < x.size(); ++k)
          xx += (x[k] - mx) * (x[k] - mx), xy += (x[k] - mx) * (y[k] - my);
        slope = fmt::format("{:.2f}", xy / xx);
        falls = xy / xx < -0.4;
      }
      const bool ended = e.rms <= std::max(2 * claim.bias, 1e-5);
      const bool holds = falls || ended || claim.known;
      line += fmt::format(" {} | {} | {}{} |\n", slope, sized(e.bias),
                          claim.known && !falls && !ended ? claim.known
                          : ended ? fmt::format("{}: {}", sized(claim.bias), claim.reason)
                                  : "noise",
                          holds ? "" : " **fails**");
      std::cout << line << std::flush;
      table += line;
      all = all && holds;
      ++judged;
    }
  }
  if (!wanted.report.empty()) replaceSection(wanted.report, "convergence", table);
  return all && judged > 0;
}

}  // namespace
}  // namespace patina::stress

int main(int count, char** arguments) {
  using namespace patina::stress;
  Wanted wanted;
  CLI::App app("Pictures against closed forms");
  app.add_option("--mode", wanted.mode, "these modes only, with commas between them");
  app.add_option("--only", wanted.only, "cases whose name has this");
  app.add_option("--seeds", wanted.seeds, "independent pictures")->check(CLI::Range(2, 1000));
  app.add_option("--effort", wanted.effort, "multiplies samples")->check(CLI::Range(1, 4096));
  app.add_option("--report", wanted.report, "Markdown file with places for the tables");
  app.add_flag("--convergence", wanted.convergence, "errors against samples");
  CLI11_PARSE(app, count, arguments);
  try {
    std::vector<ClosedForm> cases;
    addFurnaces(cases), addFormFactors(cases), addLights(cases), addSignals(cases);
    return (wanted.convergence ? study(cases, wanted) : judgeAll(cases, wanted)) ? 0 : 1;
  } catch (const std::exception& error) {
    std::cout << error.what() << "\n";
    return 1;
  }
}
