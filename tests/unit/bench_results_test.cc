// SPDX-License-Identifier: Apache-2.0
// Results, their comparison and their report.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include "tools/patina-bench/compare.h"
#include "tools/patina-bench/report.h"

namespace patina::bench {
namespace {

using testing::HasSubstr;
using testing::Not;

/// Repeats of one setting whose times are about `seconds`.
Results measured(double seconds, double error = 1e-3, uint64_t picture = 1) {
  Results results;
  for (int repeat = 0; repeat < 5; ++repeat) {
    Run run;
    run.scene = "box", run.mode = "path", run.setting = "16", run.build = "patina";
    run.repeat = repeat, run.seed = repeat + 1, run.args = {"--samples", "16"};
    run.wallSeconds = run.cpuSeconds = seconds * (1 + 0.002 * repeat);
    run.peakMb = 50, run.rays = 1000, run.shaderPoints = 500,
    run.picture = picture + static_cast<uint64_t>(repeat);
    run.errors.relMse = error * (1 + 0.01 * repeat);
    run.errors.meanError = {0.01, 0.01, 0.01}, run.errors.meanReference = {1, 1, 1};
    results.runs.push_back(run);
  }
  results.references["box"] = {"path", "box.exr", 4096, 4, 2e-4};
  return results;
}

std::string comparison(const Results& a, const Results& b) {
  return describeChanges(compareRuns(summarizeRuns(a), summarizeRuns(b)));
}

TEST(BenchResults, ComeBackAsTheyWere) {
  std::string pattern = testing::TempDir() + "patina-results-XXXXXX";
  const std::filesystem::path folder = mkdtemp(pattern.data());
  Results results = measured(2);
  results.runs[1] = {};
  results.runs[1].scene = "box", results.runs[1].failure = "ended by signal 9";
  results.runs[1].outOfTime = true;
  results.environment.cpu = "Z80", results.environment.command = "patina-bench 'a b'";
  results.environment.builds["patina"] = "patina 1; commit 2";
  const auto file = folder / "results.json";
  writeResults(file, results);
  const Results again = readResults(file);
  ASSERT_EQ(again.runs.size(), 5u);
  for (size_t i = 0; i < 5; ++i) EXPECT_TRUE(again.runs[i].isSameWork(results.runs[i]));
  EXPECT_EQ(again.runs[0].errors.relMse, results.runs[0].errors.relMse);
  EXPECT_EQ(again.runs[0].errors.meanReference, results.runs[0].errors.meanReference);
  EXPECT_EQ(again.runs[0].picture, results.runs[0].picture);
  EXPECT_EQ(again.runs[1].failure, "ended by signal 9");
  EXPECT_TRUE(again.runs[1].outOfTime);
  EXPECT_EQ(again.environment.cpu, "Z80");
  EXPECT_EQ(again.environment.command, "patina-bench 'a b'");
  EXPECT_EQ(again.environment.builds.at("patina"), "patina 1; commit 2");
  EXPECT_EQ(again.references.at("box").relMse, 2e-4);
  auto other = results.runs[0];
  other.sceneHash = 7;
  EXPECT_FALSE(other.isSameWork(results.runs[0]));
  std::ofstream(file) << R"({"version": 99})";
  EXPECT_THAT([&] { readResults(file); },
              testing::ThrowsMessage<std::runtime_error>(HasSubstr("expected version 1, not 99")));
  std::filesystem::remove_all(folder);
}

TEST(BenchResults, TheReferencesNoiseIsTakenOff) {
  const Results results = measured(2);
  const std::vector<Point> points = summarizeRuns(results);
  ASSERT_EQ(points.size(), 1u);
  EXPECT_NEAR(points[0].relMse.mean, 1.02e-3 - 2e-4, 1e-12);
  EXPECT_NEAR(points[0].meanError.mean, 0.01, 1e-12);
  EXPECT_NEAR(points[0].wall.mean, 2 * 1.004, 1e-12);
  EXPECT_NEAR(summarizeRuns(measured(2, 1e-6))[0].relMse.mean, 1e-5, 1e-12);  // never 0
}

TEST(BenchCompare, SaysNoDifferenceOrWhatChanged) {
  EXPECT_THAT(comparison(measured(2), measured(2)), HasSubstr("No difference."));
  EXPECT_THAT(comparison(measured(2), measured(2.001)), HasSubstr("No difference."));  // not worth a word
  const std::string slower = comparison(measured(2), measured(2.2));
  EXPECT_THAT(slower, HasSubstr("Changed:"));
  EXPECT_THAT(slower, HasSubstr("* box/path/16: wall s: 2.008 -> 2.209, ratio 1.1000 ± 0.0000"));
  EXPECT_THAT(slower, Not(HasSubstr("* box/path/16: relMSE")));
  const std::string other = comparison(measured(2), measured(2, 2e-3, 100));
  EXPECT_THAT(other, HasSubstr("* box/path/16: picture: other bits"));
  EXPECT_THAT(other, HasSubstr("* box/path/16: relMSE"));
}

// Without equal seeds there are no pairs: ten percent are found all the same, with the error of both.
TEST(BenchCompare, OtherSeedsAreNoPairs) {
  Results other = measured(2.2);
  for (auto& run : other.runs) run.seed += 100;
  EXPECT_THAT(comparison(measured(2), other),
              HasSubstr("* box/path/16: wall s: 2.008 -> 2.209, ratio 1.1000 ± 0.0022"));
}

// Times of two builds by turns on a machine that others use, too: each turn is up to 1.6 times as slow as the
// quickest, and each render 8 % more or less, as was measured with two other renders going on.
std::pair<Results, Results> byTurnsOnABusyMachine(double slower, unsigned seed, int repeats) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> turn(1, 1.6);
  std::normal_distribution<double> each(0, 0.08);
  std::pair<Results, Results> result;
  for (int repeat = 0; repeat < repeats; ++repeat)
    for (const char* setting : {"16", "64", "256"}) {
      const double disturbed = turn(random);
      for (const bool second : {false, true}) {
        auto run = measured(1).runs[0];
        run.setting = setting, run.repeat = repeat, run.seed = repeat + 1;
        run.wallSeconds = 2 * disturbed * std::exp(each(random)) * (second ? slower : 1);
        run.cpuSeconds = 1.5 * disturbed * std::exp(each(random)) * (second ? slower : 1);
        run.picture = static_cast<uint64_t>(repeat);
        (second ? result.second : result.first).runs.push_back(run);
      }
    }
  return result;
}

TEST(BenchCompare, FindsTwentyPercentOnABusyMachine) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto [old, now] = byTurnsOnABusyMachine(1.2, seed, 8);
    EXPECT_THAT(comparison(old, now), HasSubstr("Changed:")) << seed;  // only times can have
  }
}

// At a significance of 0.01 one of a hundred comparisons is wrong; four or more of 100 are less likely than
// 0.02 (the binomial distribution). The seeds are fixed.
TEST(BenchCompare, FindsNothingWhereNothingIs) {
  int wrong = 0;
  for (unsigned seed = 1; seed <= 100; ++seed) {
    const auto [old, now] = byTurnsOnABusyMachine(1, seed, 8);
    wrong += comparison(old, now).find("No difference.") == std::string::npos;
  }
  EXPECT_LE(wrong, 3);
  const auto [old, now] = byTurnsOnABusyMachine(1, 1, 8);
  EXPECT_THAT(comparison(old, old), HasSubstr("No difference."));  // with itself, whatever the noise
}

TEST(BenchCompare, CountsAreComparedForEqualSeeds) {
  Results more = measured(2);
  for (auto& run : more.runs) run.rays = 1100;
  EXPECT_THAT(comparison(measured(2), more), HasSubstr("* box/path/16: rays: 1000 -> 1100"));
}

TEST(BenchCompare, OneRepeatCannotBeJudged) {
  Results one = measured(2), slow = measured(4);
  one.runs.resize(1), slow.runs.resize(1);
  EXPECT_THAT(comparison(one, slow), HasSubstr("could not be judged"));
  EXPECT_THAT(comparison(one, Results{}), HasSubstr("Nothing to compare"));
}

TEST(BenchReport, HasTablesAndPlots) {
  Results results = measured(2);
  results.environment.cpu = "Z80", results.environment.builds["patina"] = "patina 1; commit 2";
  auto late = results.runs[0];
  late.setting = "64", late.failure = "took more than 9 s", late.outOfTime = true;
  results.runs.push_back(late);
  const double targets[] = {1e-2, 4.1e-4, 1e-9};
  const std::string text = markdownReport(results, targets);
  EXPECT_THAT(text, HasSubstr("| box | patina | path | at most 2.01 | about 4.02 | not reached |"));
  const double noisy[] = {1.5e-4};  // the reference has 2e-4
  EXPECT_THAT(markdownReport(results, noisy), HasSubstr("| box | patina | path | (about 11) |"));
  EXPECT_THAT(text, HasSubstr("(box.patina.svg)"));
  EXPECT_THAT(text, HasSubstr("| CPU | Z80, 0 processors used |"));
  EXPECT_THAT(text, HasSubstr("| build patina | patina 1; commit 2 |"));
  EXPECT_THAT(text, HasSubstr("| path | 64 | took more than 9 s |"));
  EXPECT_THAT(text, Not(HasSubstr("## Failed")));  // nothing is wrong with it
  const std::vector<Point> points = summarizeRuns(results);
  const std::string svg = svgPlot("a < b", pointsOf(points, "box", "patina"), 6e-4);
  EXPECT_THAT(svg, HasSubstr("wall time (s)"));
  EXPECT_THAT(svg, HasSubstr("± standard error"));
  EXPECT_THAT(svg, HasSubstr("reference’s noise"));
  EXPECT_THAT(svg, Not(HasSubstr("slower and worse")));
  EXPECT_THAT(svg, HasSubstr("a &lt; b"));
  EXPECT_THAT(svg, HasSubstr(">path</text>"));
  EXPECT_THAT(svg, HasSubstr("path 16: 2.01 s, relMSE 0.00082"));
  EXPECT_THAT(svgPlot("nothing", {}), HasSubstr("nothing was measured"));
}

}  // namespace
}  // namespace patina::bench
