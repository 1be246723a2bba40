// SPDX-License-Identifier: Apache-2.0
// The program catrib: what it reads, writes and says with its exit status.
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/wait.h>

#include <filesystem>
#include <fstream>
#include <iterator>

namespace patina {
namespace {

class Catrib : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = testing::TempDir() + "patina-catrib-XXXXXX";
    folder_ = mkdtemp(pattern.data());
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  void write(const std::string& name, const std::string& text) { std::ofstream(folder_ / name) << text; }
  std::string read(const std::string& name) {
    std::ifstream in(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  int run(const std::string& arguments) {
    const std::string command =
        "cd " + folder_.string() + " && " PATINA_BINARY_DIR "/bin/catrib " + arguments;
    return WEXITSTATUS(std::system(command.c_str()));
  }
  std::filesystem::path folder_;
};

TEST_F(Catrib, AFileMayBeWrittenOverItself) {
  const std::string text = "WorldBegin\n  Sphere 1 -1 1 360\n  Sphere 2 -2 2 360\nWorldEnd\n";
  write("a.rib", text);
  EXPECT_EQ(run("-binary --gzip -o a.rib a.rib"), 0);
  EXPECT_TRUE(read("a.rib").starts_with("\x1f\x8b"));
  EXPECT_EQ(run("-o a.rib a.rib"), 0);
  EXPECT_EQ(read("a.rib"), text);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 1);  // nothing is left behind
}

TEST_F(Catrib, ExpandsArchives) {
  write("part.rib", "Sides 1\n");
  write("a.rib", "ReadArchive \"part.rib\"\nArchiveBegin \"b\" Sides 2 ArchiveEnd ReadArchive \"b\"\n");
  EXPECT_EQ(run("--expand -o out.rib a.rib"), 0);
  EXPECT_EQ(read("out.rib"), "Sides 1\nSides 2\n");
}

TEST_F(Catrib, TwinsDrawTheSamePicture) {
  const std::string scene = PATINA_SOURCE_DIR "/tests/scenes/cornell/scene.rib";
  const std::string draw =
      " && " PATINA_BINARY_DIR "/bin/patina --quiet --res 24x24 --samples 2 --rays 8 -o ";
  EXPECT_EQ(run("-binary -o binary.rib " + scene + draw + "binary.exr binary.rib > /dev/null"), 0);
  EXPECT_EQ(run("--gzip -o text.rib binary.rib" + draw + "text.exr text.rib > /dev/null"), 0);
  EXPECT_EQ(run("-o other.rib text.rib" + draw + "scene.exr " + scene + "> /dev/null"), 0);
  EXPECT_GT(read("scene.exr").size(), 1000u);
  EXPECT_EQ(read("scene.exr"), read("binary.exr"));
  EXPECT_EQ(read("scene.exr"), read("text.exr"));
}

TEST_F(Catrib, SaysWhatWasWrongByItsStatus) {
  write("a.rib", "Sphree 1\nSides 1\n");
  EXPECT_EQ(run("-o out.rib a.rib 2> /dev/null"), 1);
  EXPECT_EQ(read("out.rib"), "Sides 1\n");
  EXPECT_EQ(run("-o out.rib none.rib 2> /dev/null"), 1);
  EXPECT_EQ(run("--nonsense 2> /dev/null"), 2);
  EXPECT_EQ(run("a.rib > /dev/full 2> /dev/null"), 1);
}

}  // namespace
}  // namespace patina
