// SPDX-License-Identifier: Apache-2.0
// --sandbox: what a RIB of unknown origin cannot read, write or start, each with the message that it gets.
#include <gmock/gmock.h>

#include <cstdlib>

#include "tests/unit/program_runs.h"

namespace patina {
namespace {

using testing::HasSubstr;
using testing::Not;
namespace fs = std::filesystem;

// The folder holds: scenes/ with the RIB, outside/ with what it is not to see, here/ as the working folder.
class Sandbox : public ProgramRuns {
 protected:
  void SetUp() override {
    ProgramRuns::SetUp();
    fs::create_directories(folder_ / "here");
    write("outside/secret.rib", "Sphere 1 -1 1 360 NoSuchRequest\n");
    write("scenes/inside.rib", "Sphere 1 -1 1 360\n");
    // A PPM of one pixel is a picture for every reader.
    write("outside/secret.ppm", "P3 1 1 255 9 9 9\n");
    write("scenes/inside.ppm", "P3 1 1 255 9 9 9\n");
    fs::create_symlink(folder_ / "outside", folder_ / "scenes/link");
    fs::create_symlink(folder_ / "outside/secret.rib", folder_ / "scenes/linked.rib");
    fs::create_symlink(folder_ / "outside/secret.ppm", folder_ / "scenes/linked.ppm");
  }
  Outcome render(const std::string& options, const std::string& world,
                 std::vector<std::string> more = {}) const {
    write("scenes/s.rib", "Format 8 8 1 PixelSamples 1 1\n" + options + "\nWorldBegin\nTranslate 0 0 3\n" +
                              world + "\nWorldEnd\n");
    more.insert(more.begin(), {"../scenes/s.rib", "--sandbox", "--mode", "direct"});
    return run(more, [&] { static_cast<void>(!chdir("here")); });
  }
  static constexpr const char* kOut = "Display \"x.exr\" \"openexr\" \"rgba\"";
};

TEST_F(Sandbox, LetsThroughWhatIsBesideTheRib) {
  const Outcome outcome =
      render(kOut,
             "ReadArchive \"inside.rib\" Procedural \"DelayedReadArchive\" [\"inside.rib\"] [-1 1 "
             "-1 1 -1 1] Surface \"paintedplastic\" \"texturename\" [\"inside.ppm\"] Disk 0 9 360");
  EXPECT_EQ(outcome.status, 0) << outcome.errors;
  EXPECT_EQ(outcome.errors, "");
  EXPECT_TRUE(bytes("here/x.exr"));
}

TEST_F(Sandbox, ArchivesOutsideAreNotRead) {
  const std::string absolute = at("outside/secret.rib");
  for (const std::string& name :
       {absolute, std::string("../outside/secret.rib"), std::string("linked.rib"),
        std::string("link/secret.rib"), std::string("inside/../../outside/secret.rib")}) {
    const Outcome outcome = render(kOut, "ReadArchive \"" + name + "\"");
    EXPECT_EQ(outcome.status, 1) << name;
    EXPECT_THAT(outcome.errors,
                HasSubstr("../scenes/s.rib:5:1: error: nofile: archive \"" + name + "\" is not found"));
    EXPECT_THAT(outcome.errors, HasSubstr("(outside of the sandbox, which is"));
    EXPECT_THAT(outcome.errors, Not(HasSubstr("NoSuchRequest"))) << "nothing of the file is shown";
    const Outcome delayed =
        render(kOut, "Procedural \"DelayedReadArchive\" [\"" + name + "\"] [-1 1 -1 1 -1 1]");
    EXPECT_EQ(delayed.status, 1) << name;
    EXPECT_THAT(delayed.errors, HasSubstr("outside of the sandbox"));
  }
  // Nor by the RIB's own search path; but by the user's.
  const std::string path = "Option \"searchpath\" \"archive\" [\"" + at("outside") + "\"]" + kOut;
  EXPECT_EQ(render(path, "ReadArchive \"secret.rib\"").status, 1);
  EXPECT_THAT(render(kOut, "ReadArchive \"secret.rib\"", {"--archive-path", "../outside"}).errors,
              HasSubstr("NoSuchRequest"));
}

TEST_F(Sandbox, TexturesOutsideAreNotRead) {
  for (const std::string& name : {at("outside/secret.ppm"), std::string("../outside/secret.ppm"),
                                  std::string("linked.ppm"), std::string("link/secret.ppm")}) {
    const std::string surface = "Surface \"paintedplastic\" \"texturename\" [\"" + name + "\"] Disk 0 9 360";
    const Outcome outcome = render(kOut, surface);
    EXPECT_EQ(outcome.status, 1) << name;
    EXPECT_THAT(outcome.errors, HasSubstr("texture \"" + name + "\" is not found"));
    EXPECT_THAT(outcome.errors, HasSubstr("outside of the sandbox"));
    EXPECT_THAT(outcome.errors, HasSubstr("s.rib:5:1"));
    const Outcome made = render("MakeTexture \"" + name + "\" \"x.tif\" \"black\" \"black\" \"box\" 1 1", "");
    EXPECT_EQ(made.status, 1);
    EXPECT_THAT(made.errors, HasSubstr("there is no picture \"" + name + "\""));
    EXPECT_FALSE(bytes("here/x.tif"));
  }
}

TEST_F(Sandbox, FilesOfShadersOutsideAreNotRead) {
  write("outside/secret.ies", "IESNA:LM-63-1995\nTILT=NONE\n1 -1 1 2 1 1 1 0 0 0\n1 1 0\n0 90\n0\n500 500\n");
  fs::create_symlink(folder_ / "outside/secret.ies", folder_ / "scenes/linked.ies");
  const std::string light = "LightSource \"ieslight\" 1 \"string profile\" ";
  for (const std::string& name : {at("outside/secret.ies"), std::string("linked.ies")}) {
    const Outcome outcome = render(kOut, light + "\"" + name + "\" Sphere 1 -1 1 360");
    EXPECT_THAT(outcome.errors, HasSubstr(name)) << outcome.errors;
    EXPECT_EQ(outcome.status, 1) << name;
  }
  fs::copy_file(folder_ / "outside/secret.ies", folder_ / "scenes/own.ies");
  EXPECT_EQ(render(kOut, light + "\"own.ies\" Sphere 1 -1 1 360").errors, "");
}

TEST_F(Sandbox, NothingIsWrittenOutsideOfTheOutputFolder) {
  fs::create_symlink(folder_ / "outside", folder_ / "here/way");
  for (const std::string& name : {at("outside/x.exr"), std::string("../outside/x.exr"),
                                  std::string("way/x.exr"), std::string("../scenes/x.exr")}) {
    const Outcome outcome = render("Display \"" + name + "\" \"openexr\" \"rgba\"", "Sphere 1 -1 1 360");
    EXPECT_EQ(outcome.status, 1) << name;
    EXPECT_THAT(outcome.errors,
                HasSubstr("s.rib:2:1: error: system: cannot write " + name + ": outside of the sandbox"));
    EXPECT_FALSE(bytes("outside/x.exr") || bytes("scenes/x.exr"));
  }
  const Outcome texture =
      render("MakeTexture \"inside.ppm\" \"way/x.tif\" \"black\" \"black\" \"box\" 1 1", "");
  EXPECT_EQ(texture.status, 1);
  EXPECT_THAT(texture.errors,
              HasSubstr("s.rib:2:1: error: badargument: MakeTexture \"way/x.tif\": outside of the sandbox"));
  EXPECT_FALSE(bytes("outside/x.tif"));
  for (const std::string& name : {at("outside/x.txt"), std::string("way/x.txt"), std::string("Makefile")}) {
    const Outcome outcome =
        render("Option \"statistics\" \"endofframe\" [1] \"string filename\" [\"" + name + "\"]", "");
    EXPECT_EQ(outcome.status, 1) << name;
    EXPECT_THAT(outcome.errors,
                HasSubstr("s.rib:2:1: error: system: Option \"statistics\" \"filename\" \"" + name));
    EXPECT_FALSE(bytes("outside/x.txt") || bytes("here/Makefile"));
  }
  // The output's folder is where -o says.
  fs::create_directories(folder_ / "out");
  EXPECT_EQ(render(kOut, "Sphere 1 -1 1 360", {"-o", "../out/y.exr"}).status, 0);
  EXPECT_TRUE(bytes("out/y.exr"));
}

TEST_F(Sandbox, NoProgramsAreStartedAndNoShadersBrought) {
  write("scenes/program", "#!/bin/sh\ntouch ../here/started\n");
  fs::permissions(folder_ / "scenes/program", fs::perms::owner_all);
  const Outcome program =
      render(kOut, "Procedural \"RunProgram\" [\"../scenes/program\" \"\"] [-1 1 -1 1 -1 1]");
  EXPECT_THAT(program.errors, HasSubstr("Procedural \"RunProgram\" is left out"));
  EXPECT_FALSE(bytes("here/started"));
  fs::copy_file(fs::path(PATINA_BINARY_DIR) / "lib/patina/shaders/matte.so", folder_ / "scenes/mine.so");
  const std::string path = "Option \"searchpath\" \"shader\" [\"" + at("scenes") + "\"]";
  const Outcome shader = render(path + kOut, "Surface \"mine\" Sphere 1 -1 1 360");
  EXPECT_THAT(
      shader.errors,
      HasSubstr(
          "s.rib:2:1: warning: incapable: Option \"searchpath\" \"shader\" has no effect with --sandbox"));
  EXPECT_THAT(shader.errors, HasSubstr("shader \"mine\" is not found"));
  for (const std::string& name : {at("scenes/mine"), std::string("../scenes/mine")}) {
    const Outcome named = render(kOut, "Surface \"" + name + "\" Sphere 1 -1 1 360");
    EXPECT_EQ(named.status, 1) << name;
    EXPECT_THAT(named.errors,
                HasSubstr("is refused: a RIB may not name a plugin by absolute path or with \"..\""));
  }
  const Outcome colours = render("Option \"patina\" \"string ocio\" [\"inside.ocio\"]", "Sphere 1 -1 1 360");
  EXPECT_EQ(colours.status, 1);
  EXPECT_THAT(
      colours.errors,
      HasSubstr("s.rib:2:1: error: incapable: Option \"patina\" \"ocio\" has no effect with --sandbox"));
  for (const char* allowed : {"--allow-programs", "--allow-texture-paths", "--allow-shader-paths"}) {
    const Outcome both = render(kOut, "", {allowed});
    EXPECT_EQ(both.status, 2);
    EXPECT_THAT(both.errors, HasSubstr("--sandbox: what the --allow options allow, it forbids"));
  }
}

}  // namespace
}  // namespace patina
