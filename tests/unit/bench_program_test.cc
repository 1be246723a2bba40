// SPDX-License-Identifier: Apache-2.0
// The program patina-bench on a tiny scene: measures, resumes, compares, tests agreement.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/wait.h>

#include <chrono>
#include <filesystem>
#include <fstream>

#include "renderer/film/image.h"
#include "tools/patina-bench/child.h"
#include "tools/patina-bench/results.h"

namespace patina::bench {
namespace {

using testing::HasSubstr;

class BenchProgram : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = testing::TempDir() + "patina-bench-XXXXXX";
    folder_ = mkdtemp(pattern.data());
    write("ball.rib",
          "Display \"ball.exr\" \"openexr\" \"rgb\" Format 16 16 1 PixelFilter \"box\" 1 1 "
          "Projection \"perspective\" \"fov\" [40] Translate 0 0 4 WorldBegin "
          "LightSource \"envlight\" 1 \"float intensity\" [1] Surface \"matte\" \"float Kd\" [1] Color [.5 "
          ".4 .3] "
          "Polygon \"P\" [-3 -1 -3 -3 -1 3 3 -1 3 3 -1 -3] Sphere 1 -1 1 360 WorldEnd\n");
    write("settings.json", R"({"radiosity": [{"name": "a", "args": ["--samples", "4", "--rays", "16"]}],
                              "path": [{"name": "4", "args": ["--samples", "4"]},
                                       {"name": "16", "args": ["--samples", "16"]}]})");
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  void write(const std::string& name, const std::string& text) { std::ofstream(folder_ / name) << text; }
  std::string read(const std::string& name) {
    std::ifstream in(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  int run(const std::string& arguments) {
    const std::string command =
        "cd " + folder_.string() + " && " PATINA_BINARY_DIR "/bin/patina-bench " + arguments + " > log 2>&1";
    return WEXITSTATUS(std::system(command.c_str()));
  }
  std::filesystem::path folder_;
};

TEST_F(BenchProgram, MeasuresResumesAndCompares) {
  const std::string common =
      "--settings settings.json --reference-samples 64 --reference-seeds 3 --repeat 2 -o out ";
  ASSERT_EQ(run(common + "--only '*/path' ball.rib"), 0) << read("log");
  const Results part = readResults(folder_ / "out/results.json");
  ASSERT_EQ(part.runs.size(), 4u);
  ASSERT_EQ(run(common + "--resume ball.rib"), 0) << read("log");
  const Results all = readResults(folder_ / "out/results.json");
  ASSERT_EQ(all.runs.size(), 6u);
  EXPECT_EQ(all.runs[0].wallSeconds, part.runs[0].wallSeconds);  // was not measured again
  for (const auto& r : all.runs) {
    EXPECT_EQ(r.failure, "");
    EXPECT_GT(r.wallSeconds, 0);
    EXPECT_GT(r.cpuSeconds, 0);
    EXPECT_GT(r.peakMb, 1);
    EXPECT_GT(r.rays, 16 * 16 * 4);
    EXPECT_GT(r.shaderPoints, 100);
    EXPECT_GT(r.errors.relMse, 0);
    EXPECT_LT(r.errors.relMse, 0.1);
  }
  EXPECT_NE(all.runs[0].picture, all.runs[2].picture);  // another repeat, another seed
  const std::vector<Point> points = summarizeRuns(all);
  ASSERT_EQ(points.size(), 3u);
  EXPECT_LT(points[1].relMse.mean, points[0].relMse.mean);  // 16 samples, 4 samples
  // Four times the samples of a reference, a quarter of its noise: three pictures tell within a factor of
  // two.
  const double noise = all.references.at("ball").relMse;
  EXPECT_GT(noise, 0);
  EXPECT_LT(noise, points[1].relMse.mean);
  EXPECT_THAT(read("out/report.md"), HasSubstr("| ball | patina | path |"));
  EXPECT_THAT(read("out/ball.patina.svg"), HasSubstr("radiosity"));
  std::string error;
  const auto sheet = readImage((folder_ / "out/ball.patina.png").string(), error);
  ASSERT_TRUE(sheet) << error;
  EXPECT_EQ(sheet->width, 2 * 20);
  EXPECT_EQ(sheet->height, 5 * 20 + 3 * 22);  // and captions
  EXPECT_EQ(run("--compare out/results.json out/results.json"), 0);
  EXPECT_THAT(read("log"), HasSubstr("No difference."));
}

// A folder of scenes, and a time that is too short for most of it: the rest is told, and nothing has failed.
TEST_F(BenchProgram, EndsInTime) {
  std::filesystem::create_directories(folder_ / "set/one");
  std::filesystem::copy_file(folder_ / "ball.rib", folder_ / "set/one/ball.rib");
  write("set/one/bench.json", R"({"rib": "ball.rib"})");
  write("settings.json", R"({"path": [{"name": "1", "args": ["--samples", "1"]},
                                      {"name": "many", "args": ["--samples", "4194304"]},
                                      {"name": "more", "args": ["--samples", "8388608"]}]})");
  const auto start = std::chrono::steady_clock::now();
  ASSERT_EQ(run("--settings settings.json --minutes 0.1 -o out set"), 0) << read("log");
  // Six seconds, of which renders may not use all; machines that do other work too are given some more.
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));
  const Results results = readResults(folder_ / "out/results.json");
  ASSERT_EQ(results.runs.size(), 3u);
  EXPECT_EQ(results.runs[0].failure, "");
  EXPECT_THAT(results.runs[1].failure, HasSubstr("took more than"));
  EXPECT_THAT(results.runs[2].failure, HasSubstr("not begun"));
  EXPECT_TRUE(results.runs[1].outOfTime && results.runs[2].outOfTime);
  const ReferenceInfo& reference = results.references.at("one");
  EXPECT_GE(reference.samples, 16);
  EXPECT_GE(reference.seeds, 4);
  EXPECT_GT(reference.seconds, 0);
  EXPECT_THAT(read("out/report.md"), HasSubstr("| path | more | not begun, no time left |"));
  // What was measured stays with its reference when there is more time.
  ASSERT_EQ(run("--settings settings.json --minutes 60 --only one/path/1 --resume -o out set"), 0)
      << read("log");
  EXPECT_TRUE(readResults(folder_ / "out/results.json").references.at("one").isSame(reference));
}

TEST_F(BenchProgram, TellsSettingsThatAgreeFromOthers) {
  const std::string common = "-o out --seeds 8 --block 8 --agree 'path --samples 16' ";
  EXPECT_EQ(run(common + "'path --samples 8' ball.rib"), 0) << read("log");
  EXPECT_THAT(read("log"), HasSubstr("| ball | 0 of 4 |"));
  EXPECT_EQ(run(common + "'direct --samples 16' ball.rib"), 1) << read("log");
  EXPECT_THAT(read("out/agreement.md"), HasSubstr("of 4 |"));
  EXPECT_THAT(read("out/agreement.md"), testing::Not(HasSubstr("| 0 of 4 |")));
}

TEST_F(BenchProgram, SaysWhatIsWrong) {
  EXPECT_EQ(run(""), 2);
  EXPECT_EQ(run("--repeat 0 ball.rib"), 2);
  EXPECT_EQ(run("lost.rib"), 1);
  EXPECT_THAT(read("log"), HasSubstr("lost.rib does not exist"));
  EXPECT_EQ(run("--patina lost ball.rib"), 1);
  EXPECT_THAT(read("log"), HasSubstr("lost is not a program"));
  EXPECT_EQ(run("--only nothing ball.rib"), 1);
  EXPECT_THAT(read("log"), HasSubstr("no scene and setting matches"));
  EXPECT_EQ(run("--compare settings.json settings.json"), 1);
  EXPECT_THAT(read("log"), HasSubstr("settings.json holds no results"));
  write("settings.json", R"({"radiosity": [{"name": "a", "args": ["--nonsense"]}]})");
  EXPECT_EQ(run("--settings settings.json --reference-samples 1 --reference-seeds 2 -o out ball.rib"), 1);
  EXPECT_THAT(read("out/report.md"), HasSubstr("ended with status 2"));
}

TEST(BenchChild, TellsCostsAndEnds) {
  const ChildUsage busy =
      runChild({"/bin/sh", "-c", "i=0; while [ $i -lt 100000 ]; do i=$((i+1)); done"}, {});
  EXPECT_EQ(busy.failure, "");
  EXPECT_GT(busy.cpuSeconds, 0.005);
  EXPECT_GT(busy.peakMb, 0.5);
  EXPECT_EQ(runChild({"/bin/sh", "-c", "exit 3"}, {}).failure, "ended with status 3");
  EXPECT_EQ(runChild({"/bin/sh", "-c", "kill -9 $$"}, {}).failure, "ended by signal 9");
  EXPECT_THAT(runChild({"/no/such/program"}, {}).failure, HasSubstr("cannot be started"));
  const ChildUsage slow = runChild({"/bin/sleep", "60"}, {"", "", 0.1});
  EXPECT_EQ(slow.failure, "took more than 0.1 s");
  EXPECT_LT(slow.wallSeconds, 30);
}

}  // namespace
}  // namespace patina::bench
