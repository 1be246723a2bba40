// SPDX-License-Identifier: Apache-2.0
// Descriptions of scenes and settings, patterns, results and their comparison.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tools/patina-bench/compare.h"
#include "tools/patina-bench/report.h"
#include "tools/patina-bench/scenes.h"

namespace patina::bench {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

std::string problemOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::runtime_error& problem) {
    return problem.what();
  }
  return "";
}

TEST(BenchPatterns, StandForSceneModeAndSetting) {
  const Setting high{"radiosity", "high", {}};
  EXPECT_TRUE(isWanted({}, "cornell", high));
  for (const char* pattern :
       {"cornell", "c*", "*/radiosity", "cornell/*/high", "*/*/h?gh", "cornell/radiosity/high"})
    EXPECT_TRUE(isWanted({"other", pattern}, "cornell", high)) << pattern;
  for (const char* pattern : {"corn", "*/path", "cornell/radiosity/best", "radiosity", "", "*/high"})
    EXPECT_FALSE(isWanted({pattern}, "cornell", high)) << pattern;
}

TEST(BenchSettings, ComeInLadders) {
  const std::vector<Setting> all = defaultSettings();
  std::map<std::string, int> count;
  for (const Setting& s : all) ++count[s.mode];
  EXPECT_GE(count["radiosity"], 3);
  EXPECT_GE(count["distribution"], 3);
  EXPECT_GE(count["path"], 4);
}

TEST(BenchSettings, AreReadAndChecked) {
  const auto parse = [](const char* text) { return parseSettings(nlohmann::json::parse(text), "s.json"); };
  const std::vector<Setting> two =
      parse(R"({"path": [{"name": "a", "args": ["--samples", "4"]}, {"name": "b"}]})");
  ASSERT_EQ(two.size(), 2u);
  EXPECT_EQ(two[0].mode, "path");
  EXPECT_THAT(two[0].args, ElementsAre("--samples", "4"));
  EXPECT_TRUE(two[1].args.empty());
  EXPECT_THAT(problemOf([&] { parse("[]"); }), HasSubstr("s.json: expected lists of settings by mode"));
  EXPECT_THAT(problemOf([&] { parse(R"({"path": {}})"); }), HasSubstr("path: expected a list"));
  EXPECT_THAT(problemOf([&] { parse(R"({"path": [{"args": []}]})"); }),
              HasSubstr("path[0]: expected {\"name\""));
  EXPECT_THAT(problemOf([&] { parse(R"({"path": [{"name": "a", "arg": []}]})"); }),
              HasSubstr("unknown key arg"));
  EXPECT_THAT(problemOf([&] { parse(R"({"path": [{"name": "a", "args": [1]}]})"); }),
              HasSubstr("list of texts"));
  EXPECT_THAT(problemOf([&] { parse(R"({"path": [{"name": "a"}, {"name": "a"}]})"); }), HasSubstr("unique"));
}

class BenchScene : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = testing::TempDir() + "patina-bench-XXXXXX";
    folder_ = mkdtemp(pattern.data());
    write("scene.rib", "WorldBegin WorldEnd");
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  void write(const std::string& name, const std::string& text) { std::ofstream(folder_ / name) << text; }
  Scene describe(const std::string& json) {
    write("bench.json", json);
    return loadScene(folder_, folder_ / "work");
  }
  std::filesystem::path folder_;
};

TEST_F(BenchScene, HasADescriptionOrIsARib) {
  const Scene scene = describe(R"({"rib": "scene.rib", "args": ["--res", "8x8"], "why": "test"})");
  EXPECT_EQ(scene.name, folder_.filename());
  EXPECT_EQ(scene.rib, std::filesystem::canonical(folder_ / "scene.rib"));
  EXPECT_THAT(scene.args, ElementsAre("--res", "8x8"));
  EXPECT_EQ(loadScene(folder_ / "scene.rib", folder_).name, "scene");
  const Scene given = describe(R"({"rib": "scene.rib", "reference": {"file": "a.exr", "relmse": 1e-6}})");
  EXPECT_EQ(given.reference, std::filesystem::canonical(folder_) / "a.exr");
  EXPECT_EQ(given.referenceRelMse, 1e-6);
}

TEST_F(BenchScene, HashKnowsRibFilesAndArguments) {
  const uint64_t first = describe(R"({"rib": "scene.rib"})").hash;
  EXPECT_EQ(describe(R"({"rib": "scene.rib", "why": "words change nothing"})").hash, first);
  EXPECT_NE(describe(R"({"rib": "scene.rib", "args": ["--res", "8x8"]})").hash, first);
  write("texture.ppm", "P6");
  const uint64_t second = describe(R"({"rib": "scene.rib"})").hash;
  EXPECT_NE(second, first);
  write("scene.rib", "WorldBegin Sphere 1 -1 1 360 WorldEnd");
  EXPECT_NE(describe(R"({"rib": "scene.rib"})").hash, second);
}

TEST_F(BenchScene, IsMadeByAScript) {
  write("make.py", "import sys\nopen(sys.argv[1] + '/scene.rib', 'w').write('WorldBegin WorldEnd')\n");
  const Scene scene = describe(R"({"make": "make.py"})");
  EXPECT_EQ(readFile(scene.rib), "WorldBegin WorldEnd");
  write("make.py", "raise SystemExit('no clay')\n");
  EXPECT_THAT(problemOf([&] { describe(R"({"make": "make.py"})"); }),
              HasSubstr("ended with status 1: no clay"));
  write("make.py", "");
  EXPECT_THAT(problemOf([&] { describe(R"({"make": "make.py"})"); }), HasSubstr("has not written scene.rib"));
}

TEST_F(BenchScene, SaysWhatIsWrong) {
  EXPECT_THAT(problemOf([&] { describe("{"); }), HasSubstr("bench.json: "));
  EXPECT_THAT(problemOf([&] { describe("{}"); }), HasSubstr("expected either rib or make"));
  EXPECT_THAT(problemOf([&] { describe(R"({"rib": "scene.rib", "make": "m.py"})"); }),
              HasSubstr("either rib or make"));
  EXPECT_THAT(problemOf([&] { describe(R"({"rib": "scene.rib", "argz": []})"); }),
              HasSubstr("unknown key argz"));
  EXPECT_THAT(problemOf([&] { describe(R"({"rib": 3})"); }), HasSubstr("rib: expected a text"));
  for (const char* reference :
       {"3", "{}", R"({"file": "a.exr", "relmse": "b"})", R"({"file": "a.exr", "noise": 1})"}) {
    const std::string json = std::string(R"({"rib": "scene.rib", "reference": )") + reference + "}";
    EXPECT_THAT(problemOf([&] { describe(json); }), HasSubstr("reference: expected {\"file\": text"));
  }
  EXPECT_THAT(problemOf([&] { describe(R"({"rib": "lost.rib"})"); }), HasSubstr("lost.rib cannot be read"));
  EXPECT_THAT(problemOf([&] { loadScene(folder_ / "nowhere", folder_); }), HasSubstr("does not exist"));
}

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

TEST_F(BenchScene, ResultsComeBackAsTheyWere) {
  Results results = measured(2);
  results.runs[1] = {};
  results.runs[1].scene = "box", results.runs[1].failure = "ended by signal 9";
  const auto file = folder_ / "results.json";
  writeResults(file, results);
  const Results again = readResults(file);
  ASSERT_EQ(again.runs.size(), 5u);
  for (size_t i = 0; i < 5; ++i) EXPECT_TRUE(again.runs[i].isSameWork(results.runs[i]));
  EXPECT_EQ(again.runs[0].errors.relMse, results.runs[0].errors.relMse);
  EXPECT_EQ(again.runs[0].errors.meanReference, results.runs[0].errors.meanReference);
  EXPECT_EQ(again.runs[0].picture, results.runs[0].picture);
  EXPECT_EQ(again.runs[1].failure, "ended by signal 9");
  EXPECT_EQ(again.references.at("box").relMse, 2e-4);
  auto other = results.runs[0];
  other.sceneHash = 7;
  EXPECT_FALSE(other.isSameWork(results.runs[0]));
  write("results.json", R"({"version": 99})");
  EXPECT_THAT(problemOf([&] { readResults(file); }), HasSubstr("expected version 1, not 99"));
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
  EXPECT_THAT(comparison(measured(2), measured(2.001)), HasSubstr("No difference."));
  const std::string slower = comparison(measured(2), measured(2.2));
  EXPECT_THAT(slower, HasSubstr("Changed:"));
  EXPECT_THAT(slower, HasSubstr("* box/path/16: wall s: 2.008 -> 2.209, ratio 1.1000 ± 0.0022"));
  EXPECT_THAT(slower, Not(HasSubstr("* box/path/16: relMSE")));
  const std::string other = comparison(measured(2), measured(2, 2e-3, 100));
  EXPECT_THAT(other, HasSubstr("* box/path/16: picture: other bits"));
  EXPECT_THAT(other, HasSubstr("* box/path/16: relMSE"));
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
  const Results results = measured(2);
  const double targets[] = {1e-2, 4.1e-4, 1e-9};
  const std::string text = markdownReport(results, targets);
  EXPECT_THAT(text, HasSubstr("| box | patina | path | at most 2.01 | about 4.02 | not reached |"));
  EXPECT_THAT(text, HasSubstr("(box.patina.svg)"));
  const std::vector<Point> points = summarizeRuns(results);
  const std::string svg = svgPlot("a < b", pointsOf(points, "box", "patina"));
  EXPECT_THAT(svg, HasSubstr("a &lt; b"));
  EXPECT_THAT(svg, HasSubstr(">path</text>"));
  EXPECT_THAT(svg, HasSubstr("path 16: 2.01 s, relMSE 0.00082"));
  EXPECT_THAT(svgPlot("nothing", {}), HasSubstr("nothing was measured"));
}

}  // namespace
}  // namespace patina::bench
