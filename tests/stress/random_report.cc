// SPDX-License-Identifier: Apache-2.0
// Rows as JSON and Markdown, and their verdicts.
#include "tests/stress/random_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tools/patina-bench/statistics.h"

namespace patina::stress {
namespace {

/// A comparison that noise leaves little of: bias may be twice what is allowed, and not be found.
constexpr double kNoisy = 0.3;

bool isNoisy(const Agreement& a) { return !(std::hypot(a.noise, a.pathNoise) <= kNoisy); }

std::string describe(const Agreement& a) {
  return fmt::format("{:+.2f} % ± {:.2f} %", 100 * a.pictureBias, 100 * a.pictureError);
}

double slowest(const Row& row) {
  double most = 0;
  for (const auto& [mode, seconds] : row.seconds) most = std::max(most, seconds);
  return most;
}

}  // namespace

nlohmann::json asJson(const Row& row) {
  nlohmann::json agreements = nlohmann::json::object();
  for (const auto& [mode, a] : row.comparison.agreements)
    agreements[mode] = {{"chance", a.chance},
                        {"difference", a.difference},
                        {"reference", a.reference},
                        {"standard error", a.standardError},
                        {"picture bias", a.pictureBias},
                        {"picture error", a.pictureError},
                        // JSON has no infinity.
                        {"noise", std::min(a.noise, 1e30)},
                        {"path noise", std::min(a.pathNoise, 1e30)},
                        {"tests", a.tests},
                        {"black", a.isBlack}};
  return {{"scene", row.number},
          {"ingredients", row.ingredients},
          {"comparable", row.isComparable},
          {"wrong", row.wrong},
          {"seconds", row.seconds},
          {"samples refused", row.areSamplesRefused},
          {"agreements", agreements},
          {"efforts", row.comparison.efforts},
          {"out of time", row.comparison.isOutOfTime},
          {"comparison seconds", row.comparison.seconds}};
}

Row rowOf(const nlohmann::json& json) {
  Row row;
  json.at("scene").get_to(row.number);
  json.at("ingredients").get_to(row.ingredients);
  json.at("comparable").get_to(row.isComparable);
  json.at("wrong").get_to(row.wrong);
  json.at("seconds").get_to(row.seconds);
  json.at("samples refused").get_to(row.areSamplesRefused);
  for (const auto& [mode, a] : json.at("agreements").items()) {
    Agreement& to = row.comparison.agreements[mode];
    a.at("chance").get_to(to.chance);
    a.at("difference").get_to(to.difference);
    a.at("reference").get_to(to.reference);
    a.at("standard error").get_to(to.standardError);
    a.at("picture bias").get_to(to.pictureBias);
    a.at("picture error").get_to(to.pictureError);
    a.at("noise").get_to(to.noise);
    a.at("path noise").get_to(to.pathNoise);
    a.at("tests").get_to(to.tests);
    a.at("black").get_to(to.isBlack);
  }
  json.at("efforts").get_to(row.comparison.efforts);
  json.at("out of time").get_to(row.comparison.isOutOfTime);
  json.at("comparison seconds").get_to(row.comparison.seconds);
  return row;
}

std::string asLine(const Row& row) {
  std::string line = fmt::format("{:4} {:6.2f} s {}", row.number, slowest(row),
                                 row.areSamplesRefused ? "[samples refused] " : "");
  for (const auto& [mode, a] : row.comparison.agreements)
    line += fmt::format("{} {}{}, block {:.3g} for {:.3g}, chance {:.2g}, noise {:.2g} {:.2g}; ", mode,
                        describe(a), a.isBlack ? " black" : "", a.reference + a.difference, a.reference,
                        a.chance, a.noise, a.pathNoise);
  if (!row.comparison.agreements.empty()) line += fmt::format("{:.0f} s; ", row.comparison.seconds);
  for (const std::string& w : row.wrong) line += "WRONG " + w + "; ";
  return line;
}

Summary summaryOf(std::span<const Row> rows, std::span<const std::string> modes, double bias) {
  size_t tests = 0;
  for (const Row& row : rows)
    for (const auto& [mode, a] : row.comparison.agreements) tests += a.tests;
  const double significance = bench::sidak(1e-3, tests);
  Summary summary;
  summary.table = "| scene | ingredients | slowest mode, s |";
  for (const std::string& mode : modes) summary.table += " " + mode + " against path |";
  summary.table += " |\n| ---: | --- | ---: |";
  for (size_t k = 0; k < modes.size(); ++k) summary.table += " --- |";
  summary.table += " --- |\n";
  int compared = 0, black = 0, insane = 0, wrong = 0;
  std::vector<uint64_t> differ, noisy, late;
  const Row* worst = nullptr;
  double leastChance = 1;
  for (const Row& row : rows) {
    wrong += !row.wrong.empty(), insane += !row.isComparable;
    bool differs = false, isNoise = false, isBlack = true;
    std::string cells;
    for (const std::string& mode : modes) {
      const auto found = row.comparison.agreements.find(mode);
      if (found == row.comparison.agreements.end()) {
        cells += row.isComparable ? " |" : " light is not sane |";
        continue;
      }
      const Agreement& a = found->second;
      differs |= a.differs(significance), isNoise |= isNoisy(a), isBlack &= a.isBlack;
      if (!worst || a.chance < leastChance) worst = &row, leastChance = a.chance;
      cells += " " + (a.isBlack ? "black" : describe(a)) + " |";
    }
    const bool all = row.comparison.agreements.size() == modes.size();
    if (all) ++compared, black += isBlack;
    if (row.isComparable && !all) late.push_back(row.number);
    if (differs) differ.push_back(row.number);
    if (all && isNoise && !differs) noisy.push_back(row.number);
    summary.bad += differs || !row.wrong.empty();
    std::string verdict = differs ? " **differs**" : all && isNoise ? " noisy" : "";
    if (row.areSamplesRefused) verdict += " samples refused";
    for (const std::string& w : row.wrong) verdict += " **" + w + "**";
    summary.table += fmt::format("| {} | {} | {:.2f} |{}{} |\n", row.number, fmt::join(row.ingredients, ", "),
                                 slowest(row), cells, verdict);
  }
  const auto list = [](const std::vector<uint64_t>& numbers) {
    return numbers.empty() ? std::string() : fmt::format(" ({})", fmt::join(numbers, ", "));
  };
  summary.text = fmt::format("{} scenes: {} wrong", rows.size(), wrong);
  if (!modes.empty())
    summary.text += fmt::format(
        "; {} whose light is not sane; {} compared with path mode, of which {} are black; {}{} differ by "
        "more "
        "than {:g} % and chance; {}{} are too noisy to find twice that; {}{} took too long to be compared",
        insane, compared, black, differ.size(), list(differ), 100 * bias, noisy.size(), list(noisy),
        late.size(), list(late));
  if (worst)
    summary.text += fmt::format("; nearest to differing: {} (chance {:.2g})", worst->number, leastChance);
  summary.text += ".";
  return summary;
}

}  // namespace patina::stress
