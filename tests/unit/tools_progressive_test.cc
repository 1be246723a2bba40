// SPDX-License-Identifier: Apache-2.0
// The program with --progressive: files on the way are whole, and an interruption keeps the last.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "renderer/film/image.h"

extern char** environ;

namespace patina {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using std::chrono::seconds;

class ProgressiveProgram : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = testing::TempDir() + "patina-progressive-XXXXXX";
    folder_ = mkdtemp(pattern.data());
    // The wall fills the picture, and sends back the distant light of 1 head-on.
    std::ofstream(folder_ / "wall.rib")
        << "Format 32 24 1 Display \"" << (folder_ / "wall.exr").string()
        << "\" \"openexr\" \"rgba\" Display \"+" << (folder_ / "wall.png").string()
        << "\" \"png\" \"rgb\" WorldBegin LightSource \"distantlight\" 1 \"from\" [0 0 0] \"to\" [0 0 1] "
           "Attribute \"trace\" \"int maxdiffusedepth\" [0] Surface \"matte\" \"float Kd\" [1] "
           "Polygon \"P\" [-9 -9 1  -9 9 1  9 9 1  9 -9 1] WorldEnd";
  }
  void TearDown() override { fs::remove_all(folder_); }

  pid_t start(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), PATINA_BINARY_DIR "/bin/patina");
    std::vector<char*> pointers;
    for (std::string& argument : arguments) pointers.push_back(argument.data());
    pointers.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 1, (folder_ / "out.txt").c_str(), O_CREAT | O_WRONLY | O_TRUNC,
                                     0600);
    pid_t child = -1;
    EXPECT_EQ(posix_spawn(&child, pointers[0], &actions, nullptr, pointers.data(), environ), 0);
    posix_spawn_file_actions_destroy(&actions);
    return child;
  }
  static int statusOf(pid_t child) {
    int status = 0;
    EXPECT_EQ(waitpid(child, &status, 0), child);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  std::string printed() const {
    std::ifstream in(folder_ / "out.txt");
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void expectWall(const char* name) const {
    std::string error;
    const auto image = readImage((folder_ / name).string(), error);
    ASSERT_TRUE(image) << error;
    ASSERT_EQ(image->width * image->height, 32 * 24);
    for (const float value : image->pixels) ASSERT_NEAR(value, 1, 1e-3);
  }

  fs::path folder_;
};

TEST_F(ProgressiveProgram, AnInterruptionKeepsThePictureOnTheWay) {
  // So many samples that it would take days.
  const pid_t child = start({"--progressive", "--quiet", "-t", "2", "--samples", "16777216", "--mode",
                             "direct", (folder_ / "wall.rib").string()});
  // The first picture is written at once, others seconds later in the place of it.
  const fs::path files[] = {folder_ / "wall.exr", folder_ / "wall.png"};
  const Clock::time_point late = Clock::now() + seconds(120);
  const auto both = [&] { return fs::exists(files[0]) && fs::exists(files[1]); };
  while (!both() && Clock::now() < late) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  ASSERT_TRUE(both());
  for (int k = 0; k < 20; ++k) {
    expectWall("wall.exr");
    expectWall("wall.png");
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  kill(child, SIGINT);
  EXPECT_EQ(statusOf(child), 1);
  expectWall("wall.exr");
  expectWall("wall.png");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 4);  // nothing is left over
}

TEST_F(ProgressiveProgram, ProgressAndPathsArePrintedOnce) {
  const std::string rib = (folder_ / "wall.rib").string();
  EXPECT_EQ(statusOf(start({"--progressive", "--samples", "8", "--mode", "path", rib})), 0);
  EXPECT_EQ(printed(), (folder_ / "wall.exr").string() + "\n" + (folder_ / "wall.png").string() + "\n");
  EXPECT_EQ(statusOf(start({"--progressive", "--progress", "--samples", "8", "--mode", "path", rib})), 0);
  int last = -1;
  std::istringstream lines(printed());
  std::string word;
  for (int percent; lines >> word >> percent; last = percent) {
    EXPECT_EQ(word, "R90000");
    EXPECT_GT(percent, last);
  }
  EXPECT_EQ(last, 100);
}

TEST_F(ProgressiveProgram, WhatCannotBeWrittenOnTheWayIsSaidAndRenderedToTheEnd) {
  // The folder goes while the picture is made: the first picture has been written to it.
  fs::create_directory(folder_ / "gone");
  const pid_t child = start({"--progressive", "-t", "2", "--samples", "16777216", "--mode", "direct", "-o",
                             (folder_ / "gone/x.exr").string(), (folder_ / "wall.rib").string()});
  const Clock::time_point late = Clock::now() + seconds(120);
  while (!fs::exists(folder_ / "gone/x.exr") && Clock::now() < late)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  fs::remove_all(folder_ / "gone");
  kill(child, SIGINT);
  EXPECT_EQ(statusOf(child), 1);
  expectWall("wall.png");  // the other display is written all the same
}

}  // namespace
}  // namespace patina
