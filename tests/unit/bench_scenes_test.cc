// SPDX-License-Identifier: Apache-2.0
// Descriptions of scenes and settings, patterns.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tools/patina-bench/scenes.h"

namespace patina::bench {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

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
  EXPECT_GE(count["points"], 3);
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

TEST_F(BenchScene, AFolderOfFoldersIsASet) {
  for (const char* name : {"b", "a/deep", "a"}) {
    std::filesystem::create_directories(folder_ / "set" / name);
    write(std::string("set/") + name + "/bench.json", "{}");
  }
  write("set/b/scene.rib", "");
  const auto set = folder_ / "set";
  EXPECT_THAT(findScenes(set), ElementsAre(set / "a", set / "a/deep", set / "b"));
  EXPECT_THAT(findScenes(set / "b"), ElementsAre(set / "b"));
  EXPECT_THAT(findScenes(folder_ / "scene.rib"), ElementsAre(folder_ / "scene.rib"));
  EXPECT_THAT(findScenes("nowhere"), ElementsAre("nowhere"));  // loadScene() says what is wrong
  std::filesystem::create_directory(folder_ / "empty");
  EXPECT_THAT(problemOf([&] { findScenes(folder_ / "empty"); }), HasSubstr("has no bench.json"));
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

}  // namespace
}  // namespace patina::bench
