// SPDX-License-Identifier: Apache-2.0
// --checkpoint and --resume: whatever stops a render, what is gone on with ends as the same files.
#include <fmt/format.h>
#include <sys/stat.h>

#include <random>

#include "tests/unit/program_runs.h"

namespace patina {
namespace {

using Arguments = std::vector<std::string>;
using std::chrono::steady_clock;
using testing::Test;

// Of everything that has to be kept: several displays, depth, edges for adaptive sampling, a filter that
// reaches into neighbouring buckets, transparency, gloss, a moving sphere, an area light.
constexpr const char* kScene = R"(
Option "limits" "bucketsize" [8 8]
PixelFilter "catmull-rom" 4 4
Shutter 0 1
Display "a.exr" "openexr" "rgba"
Display "+b.png" "png" "rgb"
Display "+z.exr" "openexr" "z"
Projection "perspective" "fov" [60]
WorldBegin
Attribute "trace" "int maxdiffusedepth" [2]
AttributeBegin
AreaLightSource "arealight" 1 "intensity" [6]
Surface "constant"
Polygon "P" [-1 2 4  1 2 4  1 2 6  -1 2 6]
AttributeEnd
LightSource "envlight" 2 "intensity" [0.2]
Surface "matte"
Color [0.8 0.4 0.3]
Polygon "P" [-5 -2 1  -5 -2 12  5 -2 12  5 -2 1]
Polygon "P" [-5 -2 9  -5 5 9  5 5 9  5 -2 9]
AttributeBegin
Surface "plastic" "roughness" [0.2]
MotionBegin [0 1]
Translate -1 -1 5
Translate -1 -0.6 5
MotionEnd
Sphere 1 -1 1 360
AttributeEnd
AttributeBegin
Opacity [0.5 0.6 0.7]
Translate 1.2 -1 5
Sphere 0.9 -0.9 0.9 360
AttributeEnd
WorldEnd
)";

Arguments operator+(Arguments a, const Arguments& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

const Arguments kFiles = {"a.exr", "b.png", "z.exr"};

struct Case {
  const char* name;
  Arguments arguments;
};
void PrintTo(const Case& c, std::ostream* to) { *to << c.name; }

class Checkpoints : public ProgramRuns {
 protected:
  void SetUp() override {
    ProgramRuns::SetUp();
    write("scene.rib", kScene);
  }
  /// The files of an uninterrupted run, which are taken away; and how long it took.
  std::vector<std::string> reference(const Arguments& arguments, double& seconds) const {
    const auto begin = steady_clock::now();
    const Outcome whole = run(arguments);
    seconds = std::chrono::duration<double>(steady_clock::now() - begin).count();
    EXPECT_EQ(whole.status, 0) << whole.errors;
    std::vector<std::string> result;
    for (const std::string& file : kFiles) {
      result.push_back(bytes(file).value_or(""));
      EXPECT_FALSE(result.back().empty()) << file;
      std::filesystem::remove(folder_ / file);
    }
    return result;
  }
  Arguments kept(const Arguments& arguments) const {
    Arguments all = arguments + Arguments{"--checkpoint", "c", "--checkpoint-interval", "0"};
    if (std::filesystem::exists(folder_ / "c")) all = all + Arguments{"--resume", "c"};
    return all;
  }
};

class KilledRenders : public Checkpoints, public testing::WithParamInterface<Case> {};

// Together the cases make 24 kills. Some come at any moment of a run, some soon after a checkpoint has been
// written, when others follow; how soon is drawn by seed.
TEST_P(KilledRenders, EndAsTheSameFiles) {
  const Arguments arguments =
      Arguments{"scene.rib", "--quiet", "-t", "2", "--res", "40x30"} + GetParam().arguments;
  double seconds = 0;
  const std::vector<std::string> expected = reference(arguments, seconds);
  const std::string name = GetParam().name;
  std::seed_seq seed(name.begin(), name.end());
  std::mt19937 random(seed);
  const auto part = [&] { return std::uniform_real_distribution<double>()(random); };
  const auto place = [&] {  // another file each time that it is written
    struct stat status {};
    return stat(at("c").c_str(), &status) == 0 ? status.st_ino : 0;
  };
  int kills = 0;
  for (int tries = 0; kills < 3 && tries < 20; ++tries) {
    const ino_t before = place();
    const pid_t child = start(kept(arguments));
    const auto late = steady_clock::now() + std::chrono::duration<double>(seconds * part());
    while (kills > 0 && place() == before && steady_clock::now() < late + std::chrono::seconds(60) &&
           !hasEnded(child))
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (kills > 0)
      std::this_thread::sleep_for(std::chrono::duration<double>(seconds * 0.2 * part()));
    else
      std::this_thread::sleep_until(late);
    kill(child, SIGKILL);
    // What is killed when all is done, but not yet ended, leaves nothing to go on from.
    if (wait(child).signal == SIGKILL && (kills == 0 || bytes("c"))) ++kills;
    // Pictures on the way are others, but whole.
    if (GetParam().arguments.back() == "--progressive") continue;
    for (size_t f = 0; f < kFiles.size(); ++f)
      EXPECT_TRUE(bytes(kFiles[f]).value_or(expected[f]) == expected[f]) << "half a file: " << kFiles[f];
  }
  EXPECT_EQ(kills, 3);
  ASSERT_TRUE(std::filesystem::exists(folder_ / "c"));
  for (const std::string& file : kFiles) std::filesystem::remove(folder_ / file);
  const Outcome last = run(kept(arguments) + Arguments{"--stats", "s.json"});
  EXPECT_EQ(last.status, 0) << last.errors;
  EXPECT_NE(bytes("s.json").value_or("").find("samples resumed"), std::string::npos);
  for (size_t f = 0; f < kFiles.size(); ++f)
    EXPECT_TRUE(bytes(kFiles[f]).value_or("") == expected[f]) << kFiles[f];
  EXPECT_FALSE(std::filesystem::exists(folder_ / "c")) << "is removed in the end";
}

INSTANTIATE_TEST_SUITE_P(
    Modes, KilledRenders,
    testing::Values(Case{"radiosity", {"--samples", "64"}},
                    Case{"unbiased", {"--samples", "16", "--unbiased"}},
                    Case{"distribution", {"--mode", "distribution", "--samples", "16", "--rays", "16"}},
                    Case{"distribution_progressive",
                         {"--mode", "distribution", "--samples", "16", "--rays", "16", "--progressive"}},
                    Case{"points", {"--mode", "points", "--samples", "36"}},
                    Case{"path_progressive", {"--mode", "path", "--samples", "256", "--progressive"}},
                    Case{"path_adaptive", {"--mode", "path", "--samples", "600", "--variance", "0.0001"}},
                    Case{"direct_adaptive_progressive",
                         {"--mode", "direct", "--samples", "900", "--variance", "0.00001", "--progressive"}}),
    [](const auto& of) { return of.param.name; });

// ---- Interruptions, and what cannot be gone on from

class InterruptedRenders : public Checkpoints {
 protected:
  // So many samples that it would take days.
  const Arguments long_ = {"scene.rib",
                           "-t",
                           "2",
                           "--res",
                           "40x30",
                           "--mode",
                           "direct",
                           "--samples",
                           "16777216",
                           "--progressive",
                           "--checkpoint-interval",
                           "0"};
  void SetUp() override {
    Checkpoints::SetUp();
    const pid_t child = start(long_ + Arguments{"--checkpoint", "c"});
    for (int k = 0; k < 60000 && !bytes("c") && !hasEnded(child); ++k)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    kill(child, SIGINT);
    outcome_ = wait(child);
    ASSERT_TRUE(bytes("c"));
  }
  void expectRefused(const Arguments& arguments, const std::string& why) const {
    const std::string before = bytes("c").value_or("");
    for (const std::string& file : kFiles) std::filesystem::remove(folder_ / file);
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 1);
    EXPECT_NE(outcome.errors.find(why), std::string::npos) << outcome.errors;
    EXPECT_FALSE(bytes("a.exr")) << "nothing is rendered";
    EXPECT_TRUE(bytes("c").value_or("") == before) << "nor is the file touched";
  }
  Outcome outcome_;
};

TEST_F(InterruptedRenders, SayHowToGoOnAndDo) {
  EXPECT_EQ(outcome_.status, 1);
  EXPECT_NE(outcome_.errors.find(
                "what is there has been written. To go on, give the same arguments and --resume c"),
            std::string::npos)
      << outcome_.errors;
  for (const std::string& file : kFiles) EXPECT_TRUE(bytes(file)) << file;
  const std::string before = *bytes("c");
  const pid_t child = start(long_ + Arguments{"--resume", "c"});
  while (bytes("c") == before && !hasEnded(child)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  kill(child, SIGTERM);
  EXPECT_EQ(wait(child).status, 1);
  EXPECT_FALSE(*bytes("c") == before) << "goes on keeping the file that it is resumed from";
}

TEST_F(InterruptedRenders, OtherPicturesAreRefused) {
  const Arguments resume = long_ + Arguments{"--resume", "c"};
  expectRefused(resume + Arguments{"--seed", "3"},
                "checkpoint c cannot be resumed: it is of another picture: --seed was not said, --seed is 3");
  Arguments larger = resume;
  larger[4] = "41x30";
  expectRefused(larger, "resolution was 40x30, resolution is 41x30");
  Arguments others = resume;
  others[8] = "16777215";
  expectRefused(others, "--samples was 16777216, --samples is 16777215");
  write("scene.rib", std::string(kScene) + " ");
  expectRefused(resume, "it is of another scene: scene.rib has changed");
}

TEST_F(InterruptedRenders, DamagedFilesAreRefused) {
  const Arguments resume = long_ + Arguments{"--resume", "c"};
  const std::string whole = *bytes("c");
  write("c", whole.substr(0, whole.size() / 2));
  expectRefused(resume, "it is damaged or cut off: its check sum is wrong");
  std::string flipped = whole;
  flipped[whole.size() / 3] ^= 4;
  write("c", flipped);
  expectRefused(resume, "it is damaged or cut off: its check sum is wrong");
  write("c", "PatinaCP");
  expectRefused(resume, "its check sum is wrong");
  write("c", "");
  expectRefused(resume, "it is cut off");
  // Whoever can damage the file can also make its check sum right (CRC-32 of ISO 3309).
  const auto sealed = [](std::string bytes) {
    bytes.resize(bytes.size() - 4);
    uint32_t crc = 0xffffffff;
    for (const char c : bytes) {
      crc ^= static_cast<unsigned char>(c);
      for (int k = 0; k < 8; ++k) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320 : 0);
    }
    crc = ~crc;
    return bytes.append(reinterpret_cast<const char*>(&crc), sizeof crc);
  };
  ASSERT_TRUE(sealed(whole) == whole);
  write("c", sealed("x" + whole));
  expectRefused(resume, "it is no checkpoint");
  std::string newer = whole;
  newer[12] = 3;
  write("c", sealed(newer));
  expectRefused(resume, "it is of version 3; this program reads version 2");
  write("c", sealed(whole.substr(0, whole.size() - 1000)));
  expectRefused(resume, "the checkpoint does not fit the picture");
  write("c", sealed(whole.substr(0, 200)));
  expectRefused(resume, "cannot be resumed: ");
  // Each byte that says how much follows may say anything: no crash, and no more memory than the file has.
  std::mt19937 random(5);
  for (int k = 0; k < 12; ++k) {
    std::string hostile = whole;
    const size_t at = k < 6 ? 16 + random() % 600 : random() % (whole.size() - 8);
    for (size_t i = at; i < at + 8; ++i) hostile[i] = '\xff';
    write("c", sealed(hostile));
    const pid_t child = start(resume);
    for (int ms = 0; ms < 1000 && !hasEnded(child); ++ms)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    kill(child, SIGINT);  // floats of the picture that are still numbers are believed
    EXPECT_EQ(wait(child).status, 1) << at;
  }
}

TEST_F(Checkpoints, MissingFilesAndFoldersAreSaid) {
  const Outcome missing = run({"scene.rib", "--resume", "none"});
  EXPECT_EQ(missing.status, 1);
  EXPECT_NE(missing.errors.find("checkpoint none cannot be resumed: No such file or directory"),
            std::string::npos)
      << missing.errors;
  const Outcome nowhere = run({"scene.rib", "--checkpoint", "no/c"});
  EXPECT_EQ(nowhere.status, 1);
  EXPECT_NE(nowhere.errors.find("there is no folder no"), std::string::npos) << nowhere.errors;
  EXPECT_FALSE(bytes("a.exr"));
}

// Frames that are finished are not made again, unless their pictures have gone; a picture that could not be
// written is written without being rendered again.
TEST_F(Checkpoints, FramesAndPicturesThatCouldNotBeWritten) {
  std::string rib;
  for (int frame = 1; frame <= 3; ++frame)
    rib += "FrameBegin " + std::to_string(frame) + " Display \"" + (frame == 2 ? "in/" : "") + "f" +
           std::to_string(frame) +
           ".exr\" \"openexr\" \"rgba\" Format 64 48 1 WorldBegin Surface \"matte\" "
           "LightSource \"envlight\" 1 Translate 0 0 " +
           std::to_string(frame + 2) + " Sphere 1 -1 1 360 WorldEnd FrameEnd\n";
  write("frames.rib", rib);
  write("in/x", "");
  const Arguments arguments = {"frames.rib", "--samples", "100", "--mode", "direct", "-t", "1"};
  EXPECT_EQ(run(arguments).status, 0);
  std::vector<std::string> expected;
  for (const char* file : {"f1.exr", "in/f2.exr", "f3.exr"}) {
    expected.push_back(bytes(file).value_or(""));
    std::filesystem::remove(folder_ / file);
  }
  // The folder goes while its frame is made, and what comes after is left undone. On a busy machine that
  // frame may have been written before the folder went: then again.
  Outcome broken;
  for (int attempt = 0; attempt < 50; ++attempt) {
    const pid_t child = start(arguments + Arguments{"--checkpoint", "c", "--checkpoint-interval", "0"});
    while (!bytes("f1.exr") && !hasEnded(child)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::filesystem::rename(folder_ / "in", folder_ / "out");
    broken = wait(child);
    if (!bytes("out/f2.exr")) break;
    std::filesystem::rename(folder_ / "out", folder_ / "in");
    for (const char* file : {"f1.exr", "in/f2.exr", "f3.exr", "c"}) std::filesystem::remove(folder_ / file);
  }
  EXPECT_EQ(broken.status, 1);
  EXPECT_NE(broken.errors.find("in/f2.exr"), std::string::npos) << broken.errors;
  EXPECT_TRUE(bytes("c"));
  EXPECT_FALSE(bytes("f3.exr"));
  EXPECT_TRUE(bytes("f1.exr") == expected[0]);
  std::filesystem::rename(folder_ / "out", folder_ / "in");
  write("f1.exr", "left alone");
  const Outcome resumed = run(arguments + Arguments{"--resume", "c"});
  EXPECT_EQ(resumed.status, 0) << resumed.errors;
  EXPECT_EQ(bytes("f1.exr"), "left alone");
  EXPECT_TRUE(bytes("in/f2.exr") == expected[1]);
  EXPECT_TRUE(bytes("f3.exr") == expected[2]);
  EXPECT_EQ(resumed.output, "in/f2.exr\nf3.exr\n");
  EXPECT_FALSE(bytes("c"));
}

// Frames have textures of their own, which are read when they are rendered: the frames before one that is
// gone on with are not, unless their pictures have gone.
TEST_F(Checkpoints, FramesBeforeHaveReadOtherFiles) {
  std::string rib;
  for (const char name : {'a', 'b'})
    rib += fmt::format(
        "FrameBegin 1 Display \"{0}.exr\" \"openexr\" \"rgba\" Format 64 48 1 Projection \"perspective\" "
        "WorldBegin "
        "LightSource \"envlight\" 1 Surface \"paintedplastic\" \"texturename\" \"{0}.ppm\" Translate 0 0 3 "
        "Sphere 1 -1 1 360 WorldEnd FrameEnd\n",
        name);
  write("frames.rib", rib);
  write("a.ppm", "P6 1 1 255\n\x80\x80\x80");
  write("b.ppm", "P6 1 1 255\n\x40\x80\x20");
  const Arguments arguments = {"frames.rib", "--samples", "225", "--mode", "direct", "-t", "1"};
  EXPECT_EQ(run(arguments).status, 0);
  const std::vector<std::string> expected = {*bytes("a.exr"), *bytes("b.exr")};
  // A checkpoint from the midst of the second frame: it names what that has read.
  const auto isOfSecond = [&] { return bytes("c").value_or("").find("b.ppm") != std::string::npos; };
  for (int attempt = 0; attempt < 50; ++attempt) {
    for (const char* file : {"a.exr", "b.exr", "c"}) std::filesystem::remove(folder_ / file);
    const pid_t child = start(arguments + Arguments{"--checkpoint", "c", "--checkpoint-interval", "0"});
    while (!isOfSecond() && !hasEnded(child)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    kill(child, SIGKILL);
    wait(child);
    if (isOfSecond() && !bytes("b.exr")) break;
  }
  const std::string kept = bytes("c").value_or("");
  ASSERT_TRUE(isOfSecond());
  const auto resume = [&] { return run(arguments + Arguments{"--resume", "c"}); };
  for (const bool isGone : {false, true}) {
    if (isGone) std::filesystem::remove(folder_ / "a.exr");
    std::filesystem::remove(folder_ / "b.exr");
    const Outcome resumed = resume();
    EXPECT_EQ(resumed.status, 0) << resumed.errors;
    EXPECT_EQ(resumed.output, isGone ? "a.exr\nb.exr\n" : "b.exr\n");
    EXPECT_TRUE(bytes("a.exr") == expected[0]);
    EXPECT_TRUE(bytes("b.exr") == expected[1]);
    write("c", kept);
  }
  std::filesystem::remove(folder_ / "b.exr");
  write("b.ppm", "P6 1 1 255\n\x40\x80\x21");
  const Outcome other = resume();
  EXPECT_EQ(other.status, 1);
  EXPECT_NE(other.errors.find("b.ppm has changed since"), std::string::npos) << other.errors;
}

}  // namespace
}  // namespace patina
