// SPDX-License-Identifier: Apache-2.0
// Shaders that throw, fail, hang, write where nothing is theirs, or give what is no light: a render ends by
// itself, with a picture of finite numbers and a message that names shader, entry point and place.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "renderer/film/image.h"
#include "tests/unit/program_runs.h"

namespace patina {
namespace {

using std::chrono::duration;
using std::chrono::steady_clock;
using testing::HasSubstr;

class HostileShaders : public ProgramRuns {
 protected:
  /// A ball on the left that is as it should be, and one on the right with the shader; the line of the
  /// shader's request is 5, that of its ball 6.
  void writeScene(const std::string& where, const std::string& what) const {
    const std::string call =
        fmt::format("\"hostile\" \"string where\" [\"{}\"] \"string what\" [\"{}\"]", where, what);
    std::string request = "Surface " + call;
    if (where == "displacement")
      request =
          "Surface \"matte\" Attribute \"displacementbound\" \"float sphere\" [0.1] Displacement " + call;
    if (where == "light")
      request = "Surface \"matte\" LightSource " + call.substr(0, 9) + " 2" + call.substr(9);
    write("s.rib",
          "Display \"x.exr\" \"openexr\" \"rgba\" Format 48 16 1 PixelSamples 1 1 Projection \"perspective\" "
          "\"fov\" [30]\n"
          "WorldBegin Attribute \"trace\" \"int maxdiffusedepth\" [0] LightSource \"distantlight\" "
          "1\nTranslate 0 0 4\nTransformBegin Translate -2 0 0 Surface "
          "\"matte\" Sphere 1 -1 1 360 TransformEnd Translate 2 0 0\n" +
              request + "\nSphere 1 -1 1 360\nWorldEnd\n");
  }
  Outcome render(const std::string& where, const std::string& what,
                 std::vector<std::string> more = {}) const {
    writeScene(where, what);
    std::filesystem::remove(folder_ / "x.exr");
    std::vector<std::string> arguments = {
        "s.rib", "--rays", "8", "-t", "1", "--shader-path", PATINA_BINARY_DIR "/tests/plugins"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }
  /// That there is a picture of finite numbers, on which the left ball is seen.
  void expectPicture(const std::string& of) const {
    std::string error;
    const auto image = readImage(at("x.exr"), error);
    ASSERT_TRUE(image) << of << ": " << error;
    float left = 0;
    for (size_t k = 0; k < image->pixels.size(); ++k) {
      ASSERT_TRUE(std::isfinite(image->pixels[k])) << of;
      const size_t column = k / static_cast<size_t>(image->channels) % static_cast<size_t>(image->width);
      const bool isRed = k % static_cast<size_t>(image->channels) == 0;
      if (isRed && column < 14) left = std::max(left, image->pixels[k]);
    }
    EXPECT_GT(left, 0.5f) << of;
  }
};

TEST_F(HostileShaders, WhatTheyThrowIsAnError) {
  for (const std::string where : {"displacement", "light", "radiosity", "view"})
    for (const std::string mode : {"radiosity", "path"})
      for (const auto& [what, says] :
           {std::pair{"throws", "threw an exception: out of spite"},
            std::pair{"throws int", "threw an exception: which is no std::exception"}}) {
        const Outcome outcome = render(where, what, {"--mode", mode});
        const std::string of = where + " " + what + " " + mode + "\n" + outcome.errors;
        EXPECT_EQ(outcome.status, 1) << of << outcome.signal;
        EXPECT_THAT(outcome.errors, HasSubstr("s.rib:5:")) << of;
        EXPECT_THAT(outcome.errors, HasSubstr(fmt::format(": {} {}", where, says))) << of;
        if (where != "light") {
          EXPECT_THAT(outcome.errors, HasSubstr("of the primitive at s.rib:6:")) << of;
        }
        expectPicture(of);
      }
  const Outcome prepare = render("prepare", "throws");
  EXPECT_EQ(prepare.status, 1);
  EXPECT_THAT(prepare.errors, HasSubstr("shader \"hostile\": prepare threw an exception: out of spite"));
  expectPicture("prepare");
}

TEST_F(HostileShaders, AStatusIsAnError) {
  for (const std::string where : {"displacement", "light", "radiosity", "view"}) {
    const Outcome outcome = render(where, "fails");
    EXPECT_EQ(outcome.status, 1) << where;
    EXPECT_THAT(outcome.errors, HasSubstr(where + " failed with status 1 (a parameter makes no sense)"));
    expectPicture(where);
  }
}

TEST_F(HostileShaders, ValuesThatAreNoneLeaveNoTrace) {
  for (const std::string where : {"displacement", "light", "radiosity", "view"})
    for (const std::string what : {"nan", "inf", "negative", "huge"})
      for (const std::string mode : {"radiosity", "path", "points"}) {
        const Outcome outcome = render(where, what, {"--mode", mode, "--points-resolution", "8"});
        const std::string of = where + " " + what + " " + mode + "\n" + outcome.errors;
        EXPECT_EQ(outcome.status, 0) << of;
        // To move by a million is what a shader may do, though rays miss what leaves the bound; and negative
        // light is a way to take some away.
        if (what == "negative" && where == "displacement") {
          EXPECT_THAT(outcome.errors, HasSubstr("rays miss what sticks out")) << of;
        } else if (what != "negative" || where != "light") {
          EXPECT_THAT(outcome.errors, HasSubstr("shader \"hostile\" (code -")) << of;
        }
        expectPicture(of);
      }
}

TEST_F(HostileShaders, WhatTheyWriteOutsideOfTheirLanesIsFound) {
  for (const std::string where : {"displacement", "light", "radiosity", "view"}) {
    const Outcome behind = render(where, "writes behind", {"--validate-shaders"});
    EXPECT_EQ(behind.status, 1) << where;
    EXPECT_THAT(behind.errors, HasSubstr(where + " writes behind the end of a plane: to index "));
    EXPECT_THAT(behind.errors, HasSubstr("s.rib:5:"));
    const Outcome before = render(where, "writes before", {"--validate-shaders"});
    EXPECT_EQ(before.status, 1) << where;
    EXPECT_THAT(before.errors, HasSubstr(where + " writes 1 floats before the beginning of a plane"));
    expectPicture(where);
  }
}

TEST_F(HostileShaders, OneThatNeverReturnsEndsTheRenderWithWhatIsThere) {
  for (const std::string where : {"displacement", "radiosity", "view"})
    for (const std::string mode : {"radiosity", "path"}) {
      const auto begin = steady_clock::now();
      const Outcome outcome = render(where, "hangs", {"--mode", mode, "--shader-seconds", "0.5"});
      const std::string of = where + " " + mode + "\n" + outcome.errors;
      EXPECT_LT(duration<double>(steady_clock::now() - begin).count(), 30) << of;
      EXPECT_EQ(outcome.status, 1) << of;
      EXPECT_THAT(outcome.errors, HasSubstr("s.rib:5:")) << of;
      EXPECT_THAT(outcome.errors,
                  HasSubstr(fmt::format(
                      "severe: system: shader \"hostile\": {} has not returned within 0.5 seconds", where)))
          << of;
      EXPECT_THAT(outcome.errors, HasSubstr("of the primitive at s.rib:6:")) << of;
      // Surfaces are displaced before the first bucket: nothing is finished then.
      const bool isBefore = where == "displacement";
      EXPECT_THAT(outcome.errors, HasSubstr(isBefore ? "nothing was finished, and nothing has been written"
                                                     : "the buckets that were finished have been written"))
          << of;
      if (!isBefore) expectPicture(of);
    }
  // Before there is a picture.
  const Outcome prepare = render("prepare", "hangs", {"--shader-seconds", "0.5"});
  EXPECT_EQ(prepare.status, 1);
  EXPECT_THAT(prepare.errors, HasSubstr("shader \"hostile\": prepare has not returned within 0.5 seconds"));
  EXPECT_THAT(prepare.errors, HasSubstr("nothing was finished, and nothing has been written"));
  EXPECT_FALSE(bytes("x.exr"));
  // Shaders that are only slow against the limit of nobody.
  EXPECT_EQ(render("light", "", {"--shader-seconds", "60"}).status, 0);
}

// A signal ends a render whose threads do not come back, too.
TEST_F(HostileShaders, ASignalEndsARenderThatHangs) {
  writeScene("radiosity", "hangs");
  const pid_t child =
      start({"s.rib", "--mode", "path", "-t", "1", "--shader-path", PATINA_BINARY_DIR "/tests/plugins"});
  std::this_thread::sleep_for(std::chrono::seconds(2));
  EXPECT_FALSE(hasEnded(child));
  kill(child, SIGINT);
  const Outcome outcome = wait(child);
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.errors, HasSubstr("has not ended within 10 seconds of the interruption"));
  EXPECT_THAT(outcome.errors, HasSubstr("the buckets that were finished have been written"));
  expectPicture(outcome.errors);
}

}  // namespace
}  // namespace patina
