// SPDX-License-Identifier: Apache-2.0
// What the machine can do to a render, and what a file can claim: no half-written picture, a clear error, the
// right exit status, no memory taken before there is a reason to.
#include <gmock/gmock.h>
#include <sched.h>
#include <sys/mount.h>

#include <random>

#include "renderer/film/image.h"
#include "tests/unit/program_runs.h"

namespace patina {
namespace {

using std::chrono::duration;
using std::chrono::steady_clock;
using testing::HasSubstr;
namespace fs = std::filesystem;

class Faults : public ProgramRuns {
 protected:
  void SetUp() override {
    ProgramRuns::SetUp();
    write("s.rib", scene("Surface \"matte\" Sphere 1 -1 1 360"));
  }
  static std::string scene(const std::string& world, const std::string& options = "") {
    return "Display \"x.exr\" \"openexr\" \"rgba\"\nFormat 8 8 1\nPixelSamples 1 1\n" + options +
           "\nWorldBegin\nTranslate 0 0 3\n" + world + "\nWorldEnd\n";
  }
  /// A file system of 64 KB for the process that calls it, as root; false: it cannot be had.
  bool mountSmall() const {
    return unshare(CLONE_NEWNS) == 0 && mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
           mount("tmpfs", at("small").c_str(), "tmpfs", 0, "size=64k") == 0;
  }
  bool canMountSmall() const {
    fs::create_directories(folder_ / "small");
    const pid_t child = fork();
    if (child == 0) _exit(mountSmall() ? 0 : 1);
    int status = 0;
    waitpid(child, &status, 0);
    return status == 0;
  }
  static void limitMemory(rlim_t megabytes) {
    const rlimit limit{megabytes << 20, megabytes << 20};
    setrlimit(RLIMIT_AS, &limit);
    const rlimit none{0, 0};
    setrlimit(RLIMIT_CORE, &none);
  }
};

// Pictures of several formats that take longer to write than to render; moments are drawn by seed.
TEST_F(Faults, AKillWhileWritingLeavesNoHalfPicture) {
  write("k.rib",
        "Format 500 400 1 PixelSamples 1 1 PixelFilter \"box\" 1 1 Display \"a.exr\" \"openexr\" \"rgbaz\" "
        "Display \"+b.png\" \"png\" \"rgba\" Display \"+c.tif\" \"tiff\" \"rgba\" Display \"+d.exr\" "
        "\"openexr\" \"z\" "
        "WorldBegin Translate 0 0 3 Surface \"constant\" Sphere 1 -1 1 360 WorldEnd");
  const std::vector<std::string> files = {"a.exr", "b.png", "c.tif", "d.exr"};
  const std::vector<std::string> arguments = {"k.rib", "--mode", "direct", "-t", "2"};
  const auto begin = steady_clock::now();
  ASSERT_EQ(run(arguments).status, 0);
  const double seconds = duration<double>(steady_clock::now() - begin).count();
  std::vector<std::string> expected;
  for (const std::string& file : files) expected.push_back(bytes(file).value());
  std::mt19937 random(11);
  int kills = 0;
  for (int k = 0; k < 6; ++k) {
    for (const std::string& file : files) fs::remove(folder_ / file);
    const double moment = std::uniform_real_distribution(0.3, 1.0)(random) * seconds;
    kills += runAndKill(arguments, moment).signal == SIGKILL ? 1 : 0;
    for (size_t f = 0; f < files.size(); ++f)
      if (files[f].ends_with(".tif")) {  // OpenImageIO puts the time of day into it
        std::string error;
        EXPECT_TRUE(!bytes(files[f]) || readImage(at(files[f]), error)) << error << " at " << moment;
      } else {
        EXPECT_TRUE(bytes(files[f]).value_or(expected[f]) == expected[f]) << files[f] << " at " << moment;
      }
  }
  EXPECT_GT(kills, 0);
}

TEST_F(Faults, AFileThatMayNotGrowIsAnError) {
  // Noise, which compression does not make small.
  write("big.rib",
        "Format 200 200 1 PixelSamples 1 1 Display \"x.exr\" \"openexr\" \"rgba\" Display \"+y.png\" \"png\" "
        "\"rgba\" WorldBegin Translate 0 0 2 Surface \"matte\" LightSource \"arealight\" 1 Sphere 1 -1 1 360 "
        "LightSource \"envlight\" 2 WorldEnd");
  const Outcome outcome = run({"big.rib", "--mode", "path", "--checkpoint", "c"}, [] {
    const rlimit limit{5000, 5000};
    setrlimit(RLIMIT_FSIZE, &limit);
  });
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.errors, HasSubstr("cannot write x.exr: File too large"));
  EXPECT_THAT(outcome.errors, HasSubstr("checkpoint: cannot write c: File too large"));
  EXPECT_FALSE(bytes("x.exr") || bytes("c"));
  for (const auto& entry : fs::directory_iterator(folder_)) EXPECT_NE(entry.path().extension(), ".part");
}

TEST_F(Faults, AFullDiskIsAnError) {
  if (!canMountSmall()) GTEST_SKIP() << "file systems of a chosen size can be mounted by root only";
  write("big.rib",
        "Format 200 200 1 PixelSamples 1 1 Display \"small/x.exr\" \"openexr\" \"rgba\" Display "
        "\"+small/y.tif\" \"tiff\" \"rgba\" Display \"+z.exr\" \"openexr\" \"z\" WorldBegin Translate 0 0 2 "
        "Surface \"matte\" Sphere 1 -1 1 360 LightSource \"envlight\" 2 WorldEnd");
  const Outcome outcome = run({"big.rib", "--mode", "path", "--stats", "small/s.json"}, [&] {
    if (!mountSmall()) _exit(125);
    const int filler = open("small/filler", O_CREAT | O_WRONLY, 0600);
    const std::string zeros(1 << 16, '\0');
    static_cast<void>(!::write(filler, zeros.data(), zeros.size()));
  });
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.errors, HasSubstr("cannot write small/x.exr: No space left on device"));
  EXPECT_THAT(outcome.errors, HasSubstr("cannot write small/y.tif: No space left on device"));
  EXPECT_THAT(outcome.errors, HasSubstr("statistics cannot be written to small/s.json"));
  EXPECT_TRUE(bytes("z.exr")) << "what has a place is written";

  // Textures: their library would not come to an end.
  std::string picture = "P6 300 300 255\n";
  picture.resize(picture.size() + 300 * 300 * 3, '\x40');
  write("p.ppm", picture);
  write("m.rib", scene("", "MakeTexture \"p.ppm\" \"small/t.tif\" \"black\" \"black\" \"box\" 1 1"));
  const Outcome made = run({"m.rib", "--mode", "direct"}, [&] {
    if (!mountSmall()) _exit(125);
    alarm(60);
  });
  EXPECT_EQ(made.status, 1) << made.signal;
  EXPECT_THAT(made.errors,
              HasSubstr("MakeTexture \"small/t.tif\": it cannot be made: No space left on device"));
}

TEST_F(Faults, FoldersWithoutPermissionAreSaidBeforeTheRender) {
  fs::create_directories(folder_ / "locked");
  fs::permissions(folder_ / "locked", fs::perms::owner_read | fs::perms::owner_exec);
  fs::permissions(folder_, fs::perms::all);
  const Outcome outcome = run({"s.rib", "-o", "locked/x.exr", "--checkpoint", "locked/c"}, [] {
    if (geteuid() == 0 && setuid(65534) != 0) _exit(125);  // root may write everywhere
  });
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.errors, HasSubstr("checkpoint: cannot write locked/c: Permission denied"));
  const Outcome plain = run({"s.rib", "-o", "locked/x.exr"}, [] {
    if (geteuid() == 0 && setuid(65534) != 0) _exit(125);
  });
  EXPECT_EQ(plain.status, 1);
  EXPECT_THAT(plain.errors, HasSubstr("cannot write locked/x.exr: Permission denied"));
}

// ---- Textures

std::string bytesOf(uint64_t value, int count) {
  std::string result;
  for (int k = 0; k < count; ++k) result += static_cast<char>(value >> (8 * k));
  return result;
}
/// A TIFF's head, of one strip, without its pixels.
std::string tiffHead(uint32_t width, uint32_t height) {
  const std::array<std::array<uint32_t, 3>, 9> entries = {{{256, 4, width},
                                                           {257, 4, height},
                                                           {258, 3, 8},
                                                           {259, 3, 1},
                                                           {262, 3, 2},
                                                           {273, 4, 8},
                                                           {277, 3, 3},
                                                           {278, 4, height},
                                                           {279, 4, 0xffffffff}}};
  std::string file = "II*" + std::string(1, '\0') + bytesOf(8, 4) + bytesOf(entries.size(), 2);
  for (const auto& [tag, type, value] : entries)
    file += bytesOf(tag, 2) + bytesOf(type, 2) + bytesOf(1, 4) + bytesOf(value, 4);
  return file + bytesOf(0, 4);
}

TEST_F(Faults, TexturesThatClaimMoreThanTheyHoldTakeNoMemory) {
  write("huge.ppm", "P6 2000000000 2000000000 255\nabc");
  write("wide.ppm", "P6 60000 60000 255\nabc");
  write("some.ppm", "P6 15000 15000 255\nabc");
  write("wide.tif", tiffHead(60000, 60000));
  write("sky.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1000000000 +X 1000000000\nabc");
  for (const std::string name : {"huge.ppm", "wide.ppm", "some.ppm", "wide.tif", "sky.hdr"}) {
    for (const std::string& use :
         {scene("Surface \"paintedplastic\" \"texturename\" [\"" + name + "\"] Sphere 1 -1 1 360"),
          scene("LightSource \"envlight\" 1 \"texturename\" [\"" + name + "\"]"),
          scene("", "MakeTexture \"" + name + "\" \"t.tif\" \"black\" \"black\" \"box\" 1 1")}) {
      write("t.rib", use);
      const Outcome outcome = run({"t.rib", "--mode", "direct"}, [] { limitMemory(4000); });
      EXPECT_EQ(outcome.status, 1) << use << outcome.errors;
      EXPECT_THAT(outcome.errors,
                  testing::AnyOf(HasSubstr("which is too large"), HasSubstr("bytes cannot hold")));
      EXPECT_LT(outcome.peakKb, 400'000) << use;
    }
  }
}

TEST_F(Faults, TexturesThatEndBeforeTheirPixelsAreErrors) {
  const std::string head = tiffHead(64, 64);  // its strip begins at the eighth byte
  write("head.tif", head);
  write("half.tif", head + std::string(64 * 32 * 3, '\x40'));
  write("whole.tif", head + std::string(64 * 64 * 3, '\x40'));
  for (const std::string name : {"head", "half", "whole"})
    for (const std::string& use :
         {scene("Surface \"paintedplastic\" \"texturename\" [\"" + name + ".tif\"] Sphere 1 -1 1 360"),
          scene("", "MakeTexture \"" + name + ".tif\" \"t.tif\" \"black\" \"black\" \"box\" 1 1")}) {
      write("t.rib", use);
      const Outcome outcome = run({"t.rib", "--mode", "direct"});
      EXPECT_EQ(outcome.status, name == "whole" ? 0 : 1) << use << outcome.errors;
      if (name != "whole") {
        EXPECT_THAT(outcome.errors, HasSubstr("Read error")) << use;
      }
    }
}

TEST_F(Faults, TexturesThatGoAndThatAreLockedEndNoRender) {
  // Taken away while rendering, and locked.
  std::string picture = "P6 2048 2048 255\n";
  picture.resize(picture.size() + 2048 * 2048 * 3, '\x40');
  write("gone.ppm", picture);
  write("gone.rib", scene("LightSource \"envlight\" 1 Surface \"paintedplastic\" \"texturename\" "
                          "[\"gone.ppm\"] Sphere 1 -1 1 360"));
  const pid_t child = start({"gone.rib", "--mode", "direct", "--progressive", "--res", "200x200", "--samples",
                             "16777216", "-t", "1"});
  while (!bytes("x.exr") && !hasEnded(child)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  fs::resize_file(folder_ / "gone.ppm", 20);
  fs::remove(folder_ / "gone.ppm");
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  kill(child, SIGINT);
  EXPECT_EQ(wait(child).status, 1);
  std::string error;
  const auto image = readImage(at("x.exr"), error);
  ASSERT_TRUE(image) << error;
  for (const float value : image->pixels) ASSERT_TRUE(std::isfinite(value));

  write("locked.ppm", picture);
  fs::permissions(folder_ / "locked.ppm", fs::perms::none);
  fs::permissions(folder_, fs::perms::all);
  write("locked.rib", scene("Surface \"paintedplastic\" \"texturename\" [\"locked.ppm\"] Sphere 1 -1 1 360"));
  fs::permissions(folder_ / "x.exr", fs::perms::all);
  const Outcome locked = run({"locked.rib", "--mode", "direct"}, [] {
    if (geteuid() == 0 && setuid(65534) != 0) _exit(125);
  });
  EXPECT_EQ(locked.status, 1);
  EXPECT_THAT(locked.errors, HasSubstr("texture \"locked.ppm\" is not found, it reads 1; tried:"));
}

// ---- Memory

TEST_F(Faults, TooLittleMemoryIsAnErrorAndNoCrash) {
  const Outcome caches = run({"s.rib"}, [] { limitMemory(400); });
  EXPECT_EQ(caches.status, 1);
  EXPECT_THAT(caches.errors, HasSubstr("severe: outofmemory: there is not enough memory for this picture"));
  const Outcome film = run({"s.rib", "--mode", "path", "--res", "20000x20000"}, [] { limitMemory(2000); });
  EXPECT_EQ(film.status, 1);
  EXPECT_THAT(film.errors, HasSubstr("there is not enough memory for this picture"));
  EXPECT_LT(film.peakKb, 500'000);
  // Wherever it runs out: rendered, or an error that says so.
  write("m.rib", scene("Surface \"plastic\" LightSource \"envlight\" 1 Sphere 1 -1 1 360",
                       "Display \"+y.png\" \"png\" \"rgb\""));
  for (const char* mode : {"path", "radiosity", "points"})
    for (const rlim_t megabytes : {120, 200, 300, 420, 500, 560, 700}) {
      const Outcome outcome = run({"m.rib", "--mode", mode, "-t", "2"}, [=] { limitMemory(megabytes); });
      EXPECT_TRUE(outcome.status == 0 || (outcome.status == 1 && !outcome.errors.empty()))
          << mode << ' ' << megabytes << ": " << outcome.status << " signal " << outcome.signal
          << outcome.errors;
    }
}

struct Claim {
  const char* name;
  const char* options;
  const char* world;
  const char* message;  ///< "": it is rendered, within the memory
};
void PrintTo(const Claim& c, std::ostream* to) { *to << c.name; }

class Claims : public Faults, public testing::WithParamInterface<Claim> {};

TEST_P(Claims, TakeNoMemoryBeforeTheyAreChecked) {
  const Claim& claim = GetParam();
  write("c.rib", scene(claim.world, claim.options));
  const Outcome outcome = run({"c.rib", "--rays", "4", "-t", "1"}, [] { limitMemory(3000); });
  EXPECT_EQ(outcome.status, *claim.message ? 1 : 0) << outcome.errors << outcome.signal;
  EXPECT_THAT(outcome.errors, HasSubstr(claim.message));
  EXPECT_LT(outcome.peakKb, 400'000);
}

INSTANTIATE_TEST_SUITE_P(
    Sizes, Claims,
    testing::Values(
        Claim{"polygons", "", R"(PointsPolygons [2000000000] [0 1 2] "P" [0 0 0 1 0 0 0 1 0])",
              "c.rib:7:1: error: consistency: polygons are left out: the counts ask for 2000000000 vertices"},
        Claim{"vertices", "", R"(PointsPolygons [3] [0 1 2000000000] "P" [0 0 0 1 0 0 0 1 0])",
              "expected 6000000003 (2000000001 points)"},
        Claim{"loops", "", R"(PointsGeneralPolygons [2000000000] [3] [0 1 2] "P" [0 0 0 1 0 0 0 1 0])",
              "the counts ask for 2000000000 loops, there are 1"},
        Claim{"nurbs", "",
              R"(NuPatch 2000000000 4 [0 0 0 0 1 1 1 1] 0 1 2000000000 4 [0 0 0 0 1 1 1 1] 0 1 "P" [0 0 0])",
              "8 knots, expected 2000000004 (control points plus order)"},
        Claim{"order", "", R"(NuPatch 4 1000000000 [0 0 0 0 1 1 1 1] 0 1 4 4 [0 0 0 0 1 1 1 1] 0 1 "P" [0])",
              "order 1000000000, expected 2 to 32"},
        Claim{"trim", "", "TrimCurve [2000000000] [3] [0 0 1 1] [0] [1] [2] [0 1] [0 1] [1 1]",
              "expected 2000000000 (curves)"},
        Claim{"curves", "", R"(Curves "linear" [2000000000] "nonperiodic" "P" [0 0 0 1 1 1])",
              "expected 6000000000 (2000000000 points)"},
        Claim{"mesh", "",
              R"(PatchMesh "bilinear" 2000000000 "nonperiodic" 2000000000 "nonperiodic" "P" [0 0 0])",
              "4000000000000000000 points"},
        Claim{"subdivision", "",
              R"(SubdivisionMesh "catmull-clark" [2000000000] [0 1 2 3] [] [] [] [] "P" [0 0 0])",
              "the counts ask for 2000000000 vertices, there are 4"},
        Claim{
            "tags", "",
            R"(SubdivisionMesh "catmull-clark" [4] [0 1 2 3] ["crease"] [2000000000 1] [0 1] [3] "P" [0 0 0 1 0 0 1 1 0 0 1 0] Surface "nosuch")",
            "the tags' values do not match their counts"},
        Claim{"blobby", "", "Blobby 1 [1001 0 2 2000000000 0] [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1] []",
              "wants 2000000000 operands"},
        Claim{"format", "Format 1000000000 1000000000 1", "",
              "c.rib:4:1: error: limitcheck: Format 1000000000 1000000000: at most 65536"},
        Claim{"film", "Format 60000 60000 1", "", "the picture's channels would take more than 16 GB"},
        Claim{"samples", "PixelSamples 1e9 1e9", "",
              "c.rib:4:1: error: limitcheck: PixelSamples 1000000000 1000000000: at most 4096"},
        Claim{"filter", R"(PixelFilter "sinc" 1e9 1e9)", "", "are not between 0 and 64 pixels"},
        Claim{"raster", R"(Option "points" "int resolution" [2147483646])", "",
              "expected an even number from 4 to 128"},
        // A unit sphere at that rate would have 1e15 micropolygons.
        Claim{"dicing", "", R"(ShadingRate 1e-12 LightSource "envlight" 1 Surface "matte" Sphere 1 -1 1 360)",
              ""},
        Claim{
            "displaced", "",
            R"(ShadingRate 1e-12 Attribute "displacementbound" "float sphere" [0.1] Displacement "dented" Sphere 1 -1 1 360)",
            ""}),
    [](const auto& of) { return of.param.name; });

}  // namespace
}  // namespace patina
