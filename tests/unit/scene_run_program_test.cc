// SPDX-License-Identifier: Apache-2.0
// Procedural "RunProgram": what programs may do, and what happens when they do more.
#include "renderer/scene/run_program.h"

#include <chrono>
#include <filesystem>
#include <fstream>

#include "scene_fixture.h"

namespace patina {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A folder with a program in it.
class Programs : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = testing::TempDir() + "patina-program-XXXXXX";
    folder_ = mkdtemp(pattern.data());
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string program(const std::string& name, const std::string& script) {
    const auto path = folder_ / name;
    std::ofstream(path) << "#!/bin/sh\n" << script;
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
    return path.string();
  }
  ProgramOutput run(const std::string& script, std::string_view input = "",
                    const ProgramLimits& limits = {}) {
    const std::vector<std::string> words{program("p", script)};
    return runProgram(words, input, limits);
  }
  Built read(const std::string& rib, bool allow = true) {
    SceneBuilderSettings settings;
    settings.allowPrograms = allow;
    return build(rib, settings);
  }
  std::filesystem::path folder_;
};

TEST_F(Programs, AnswerWhatTheyAreTold) {
  const ProgramOutput output =
      run("read detail data; echo \"$data|$detail\"; printf '\\377more'", "12 a b\n");
  EXPECT_EQ(output.text, "a b|12\n");
  EXPECT_EQ(output.problem, "");
  // The end of output ends the reply, too.
  EXPECT_EQ(run("echo x").text, "x\n");
  // Input that nobody reads, and more of it than a pipe holds.
  EXPECT_EQ(run("echo y", std::string(1 << 20, 'q')).text, "y\n");
  EXPECT_EQ(run("cat", std::string(1 << 20, 'q')).text.size(), size_t{1} << 20);
}

TEST_F(Programs, AreEndedWhenTheyPassALimit) {
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(run("echo a; sleep 100 & sleep 100", "", {.seconds = 0.3}).problem, "it took more than 0.3 s");
  EXPECT_EQ(run("yes", "", {.seconds = 60, .outputBytes = 100000}).problem,
            "it wrote more than 100000 bytes");
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));
}

TEST_F(Programs, ThatFailSaySo) {
  EXPECT_EQ(run("echo half; exit 3").problem, "it ended with status 3");
  EXPECT_EQ(run("echo half; exit 3").text, "half\n");
  EXPECT_EQ(run("kill -9 $$").problem, "it was ended by signal 9");
  const std::vector<std::string> none{(folder_ / "none").string()};
  EXPECT_THAT(runProgram(none, "").problem, HasSubstr("it does not start"));
}

TEST_F(Programs, DrawInAScopeOfTheirOwn) {
  const std::string p = program("spheres",
                                "read detail radius count; i=0; echo 'Color [1 0 0]'\n"
                                "while [ $i -lt $count ]; do echo Sphere $radius -1 1 360; i=$((i+1)); done");
  const std::string rib = "WorldBegin Procedural \"RunProgram\" [\"" + p +
                          "\" \"2 3\"] [-1 1 -1 1 -1 1] Sphere 1 -1 1 360 WorldEnd";
  const Built built = read(rib);
  EXPECT_THAT(built.messages, IsEmpty());
  ASSERT_EQ(built.world().primitives.size(), 4u);
  EXPECT_EQ(built.attributesOf(2).color, Rgb(1, 0, 0));
  EXPECT_EQ(built.attributesOf(3).color, Rgb(1, 1, 1));
  // By search path, and with a word of the command.
  const Built found =
      read("Option \"searchpath\" \"string procedural\" \"" + folder_.string() + "\"\n" +
           "WorldBegin Procedural \"RunProgram\" [\"spheres x\" \"1 2\"] [-1 1 -1 1 -1 1] WorldEnd");
  EXPECT_EQ(found.world().primitives.size(), 2u);
}

TEST_F(Programs, AreNotStartedUnlessAllowed) {
  const std::string touched = (folder_ / "touched").string();
  const std::string p = program("touch", "touch " + touched);
  const std::string rib =
      "WorldBegin Procedural \"RunProgram\" [\"" + p + "\" \"\"] [-1 1 -1 1 -1 1] WorldEnd";
  const Built built = read(rib, false);
  EXPECT_THAT(built.messages,
              ElementsAre(HasSubstr("programs are started with --allow-programs only (once)")));
  EXPECT_FALSE(std::filesystem::exists(touched));
  read(rib, true);
  EXPECT_TRUE(std::filesystem::exists(touched));
}

TEST_F(Programs, ThatAskForThemselvesAreStopped) {
  const std::string path = (folder_ / "again").string();
  program("again", "echo 'Procedural \"RunProgram\" [\"" + path + "\" \"\"] [-1 1 -1 1 -1 1]'");
  SceneBuilderSettings settings;
  settings.allowPrograms = true;
  settings.programRuns = 20;
  const Built built = build(
      "WorldBegin Procedural \"RunProgram\" [\"" + path + "\" \"\"] [-1 1 -1 1 -1 1] WorldEnd", settings);
  EXPECT_THAT(built.messages, ElementsAre(HasSubstr("more than 20 programs run")));
}

}  // namespace
}  // namespace patina
