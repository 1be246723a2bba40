// SPDX-License-Identifier: Apache-2.0
// What a scene does not use is not started, and entry points that do nothing are not called.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdio.h>
#include <sys/wait.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

namespace patina {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

class Skipping : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = testing::TempDir() + "patina-skipping-XXXXXX";
    folder_ = mkdtemp(pattern.data());
  }
  void TearDown() override { fs::remove_all(folder_); }

  struct Run {
    int status;  // of wait()
    nlohmann::json statistics;
    std::string loaded;  // what the dynamic loader says of the libraries that it opens
    int64_t of(const std::string& pointer) const {
      return statistics.value(nlohmann::json::json_pointer(pointer), int64_t{0});
    }
  };

  /// Of a ball, bound to what `requests` says, lit head-on.
  Run render(const std::string& requests, const std::string& arguments) {
    std::ofstream(folder_ / "scene.rib")
        << "Format 32 24 1\nProjection \"perspective\" \"fov\" [40]\nTranslate 0 0 4\n"
           "WorldBegin\nLightSource \"distantlight\" 1\n"
        << requests << "\nSphere 1 -1 1 360\nWorldEnd\n";
    const std::string at = folder_.string(), command = "cd " + at +
                                                       " && LD_DEBUG=files " PATINA_BINARY_DIR
                                                       "/bin/patina -q --shader-path " PATINA_BINARY_DIR
                                                       "/tests/plugins --stats stats.json " +
                                                       arguments + " scene.rib 2>files.txt >out.txt";
    Run run{std::system(command.c_str()), {}, {}};
    std::ifstream statistics(folder_ / "stats.json");
    if (run.status == 0) run.statistics = nlohmann::json::parse(statistics);
    std::ostringstream files;
    files << std::ifstream(folder_ / "files.txt").rdbuf();
    run.loaded = files.str();
    return run;
  }

  fs::path folder_;
};

TEST_F(Skipping, WithoutTexturesThereIsNoTextureSystemAndNoOcio) {
  for (const char* mode : {"radiosity", "distribution", "path", "direct", "points"}) {
    const Run run = render("Surface \"plastic\"", std::string("-o p.exr --mode ") + mode);
    ASSERT_EQ(run.status, 0) << mode;
    EXPECT_EQ(run.of("/Textures/texture systems started"), 0);
    EXPECT_EQ(run.of("/Film/image module loads"), 0);
    EXPECT_EQ(run.of("/Film/OpenColorIO views applied"), 0);
    EXPECT_THAT(run.loaded, HasSubstr("libembree"));  // the loader did say something
    EXPECT_THAT(run.loaded, Not(HasSubstr("OpenImageIO")));
    EXPECT_THAT(run.loaded, Not(HasSubstr("OpenColorIO")));
  }
}

TEST_F(Skipping, TheyAreCountedWhereTheyAreUsed) {
  const Run made = render("Surface \"matte\"", "-o picture.png --display-view \"ACES sRGB\"");
  ASSERT_EQ(made.status, 0);
  EXPECT_EQ(made.of("/Film/image module loads"), 1);
  EXPECT_EQ(made.of("/Film/OpenColorIO views applied"), 1);
  EXPECT_EQ(made.of("/Textures/texture systems started"), 0);
  const Run run = render("Surface \"paintedplastic\" \"texturename\" [\"picture.png\"]", "-o p.exr");
  ASSERT_EQ(run.status, 0);
  EXPECT_EQ(run.of("/Textures/texture systems started"), 1);
  EXPECT_EQ(run.of("/Film/OpenColorIO views applied"), 0);
  EXPECT_THAT(run.loaded, HasSubstr("OpenImageIO"));
}

TEST_F(Skipping, WhatDoesNothingIsNotCalled) {
  const auto calls = [](const Run& run, const std::string& what) {
    return run.of("/Shaders/" + what + "/calls");
  };
  const Run matte = render("Surface \"matte\"", "-o p.exr");
  EXPECT_GT(calls(matte, "matte/radiosity"), 0);
  EXPECT_EQ(calls(matte, "matte/view"), 0);
  const Run dull = render("Surface \"plastic\" \"Ks\" [0]", "-o p.exr");
  EXPECT_GT(calls(dull, "plastic/radiosity"), 0);
  EXPECT_EQ(calls(dull, "plastic/view"), 0);
  EXPECT_GT(calls(render("Surface \"plastic\"", "-o p.exr"), "plastic/view"), 0);
  const Run flat = render("Displacement \"noisebump\" \"Km\" [0]", "-o p.exr");
  EXPECT_EQ(calls(flat, "noisebump/displacement"), 0);
  EXPECT_EQ(flat.of("/Displacement/surfaces"), 0);
  EXPECT_GT(calls(render("Displacement \"noisebump\"", "-o p.exr"), "noisebump/displacement"), 0);
  const Run dark = render("Surface \"matte\" LightSource \"pointlight\" 2 \"intensity\" [0]", "-o p.exr");
  EXPECT_EQ(calls(dark, "pointlight/light"), 0);
  EXPECT_GT(calls(render("Surface \"matte\" LightSource \"pointlight\" 2 \"from\" [0 0 -4]", "-o p.exr"),
                  "pointlight/light"),
            0);
}

// Not by the renderer's own account: a call would end the process.
TEST_F(Skipping, AnInactiveEntryPointIsNeverCalled) {
  const std::string all = "Surface \"inactive\"\nDisplacement \"inactive\"\nLightSource \"inactive\" 2";
  for (const char* mode : {"radiosity", "distribution", "path", "direct", "points"})
    EXPECT_EQ(render(all, std::string("-o p.exr --mode ") + mode).status, 0) << mode;
  EXPECT_NE(render("Surface \"inactive\" \"int active\" [12]", "-o p.exr").status, 0);      // view
  EXPECT_NE(render("Displacement \"inactive\" \"int active\" [5]", "-o p.exr").status, 0);  // displacement
  EXPECT_NE(render("Surface \"matte\" LightSource \"inactive\" 2 \"int active\" [6]", "-o p.exr").status,
            0);  // light
}

}  // namespace
}  // namespace patina
