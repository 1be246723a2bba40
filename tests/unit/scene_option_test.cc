// SPDX-License-Identifier: Apache-2.0
// Options: camera conventions, frames, displays, and what values are refused.
#include "renderer/scene/camera.h"
#include "scene_fixture.h"

namespace patina {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

Scene worldOf(std::string_view options) {
  return buildClean(std::string(options) + " WorldBegin WorldEnd").world();
}

TEST(Options, DefaultsOfRi) {
  const Scene scene = worldOf("");
  EXPECT_FALSE(scene.camera.perspective);
  EXPECT_EQ(scene.options.xResolution, 640);
  EXPECT_EQ(scene.options.yResolution, 480);
  EXPECT_EQ(scene.options.filter, "gaussian");
  EXPECT_FLOAT_EQ(scene.camera.screenWindow[0], -4.0f / 3);
  EXPECT_FLOAT_EQ(scene.camera.screenWindow[3], 1);
}

TEST(Options, ScreenWindowFollowsTheFrame) {
  // RI 3.2: the shorter side spans -1 to 1.
  EXPECT_THAT(worldOf("Format 100 300 1").camera.screenWindow, ElementsAre(-1, 1, -3, 3));
  EXPECT_THAT(worldOf("Format 100 100 2").camera.screenWindow, ElementsAre(-2, 2, -1, 1));
  EXPECT_THAT(worldOf("ScreenWindow -1 2 -3 4 Format 10 10 1").camera.screenWindow,
              ElementsAre(-1, 2, -3, 4));
}

TEST(Options, FrameAspectRatioFitsThePictureIntoTheFormat) {
  const Scene narrow = worldOf("Format 640 480 1 FrameAspectRatio 1");
  EXPECT_EQ(narrow.options.xResolution, 480);
  EXPECT_EQ(narrow.options.yResolution, 480);
  EXPECT_THAT(narrow.camera.screenWindow, ElementsAre(-1, 1, -1, 1));
  const Scene wide = worldOf("Format 400 400 1 FrameAspectRatio 2");
  EXPECT_EQ(wide.options.xResolution, 400);
  EXPECT_EQ(wide.options.yResolution, 200);
}

TEST(Options, FormatMinusOneIsTheDefault) {
  const Scene scene = worldOf("Format 380 -1 -1");
  EXPECT_EQ(scene.options.xResolution, 380);
  EXPECT_EQ(scene.options.yResolution, 480);
  EXPECT_EQ(scene.options.pixelAspect, 1);
}

TEST(Options, PerspectiveProjectsTheUnitWindowAtItsAngle) {
  // At fov 60 the ray at 30 degrees above the axis meets the window's upper edge.
  const Scene scene =
      worldOf("Format 100 100 1 Projection \"perspective\" \"fov\" 60 Clipping 1 1e38 Translate 0 0 5");
  const M44d toScreen = worldToNormalizedScreen(scene.camera);
  V3d edge;
  toScreen.multVecMatrix(V3d(0, 7 * std::tan(std::numbers::pi / 6), 2), edge);
  EXPECT_NEAR(edge.x, 0, 1e-12);
  EXPECT_NEAR(edge.y, 1, 1e-12);
  V3d near;
  toScreen.multVecMatrix(V3d(0, 0, -4), near);  // one unit before the eye
  EXPECT_NEAR(near.z, 0, 1e-12);
}

TEST(Options, CameraIsTheTransformationAtWorldBegin) {
  const Scene scene = worldOf("Projection \"orthographic\" Translate 0 0 5 Scale 1 1 -1");
  expectMatrix(scene.camera.worldToCamera, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 5, 1}, 0);
}

TEST(Options, HoldOverWorldsAndAreRestoredByFrames) {
  const Built built = build(
      "PixelSamples 3 3 FrameBegin 4 PixelSamples 5 5 Translate 0 0 9 Display \"a\" \"file\" \"rgb\" "
      "WorldBegin WorldEnd FrameEnd "
      "FrameBegin 5 WorldBegin WorldEnd FrameEnd Exposure 2 1 WorldBegin WorldEnd WorldBegin WorldEnd");
  ASSERT_THAT(built.worlds, SizeIs(4));
  EXPECT_THAT(built.messages, SizeIs(0));
  EXPECT_EQ(built.worlds[0].options.pixelSamplesX, 5);
  EXPECT_EQ(built.worlds[0].frame, 4);
  EXPECT_EQ(built.worlds[1].options.pixelSamplesX, 3);
  EXPECT_THAT(built.worlds[1].options.displays, SizeIs(0));
  expectMatrix(built.worlds[1].camera.worldToCamera, M44d(), 0);
  EXPECT_EQ(built.worlds[1].options.exposureGain, 1);
  EXPECT_EQ(built.worlds[2].options.exposureGain, 2);
  EXPECT_EQ(built.worlds[2].frame, 0);
  EXPECT_EQ(built.worlds[3].options.exposureGain, 2);
}

TEST(Options, ChangesOfTheReceiverLastForOneWorld) {
  std::vector<int> seen;
  ErrorHandler errors;
  SceneBuilder builder({}, errors, [&](Scene& scene) {
    seen.push_back(scene.options.xResolution);
    scene.options.xResolution = 7;
  });
  builder.readText("Format 20 20 1 WorldBegin WorldEnd WorldBegin WorldEnd", "t.rib");
  EXPECT_THAT(seen, ElementsAre(20, 20));
}

TEST(Options, DisplaysAddUpWithAPlus) {
  const Scene scene = worldOf(
      "Display \"x\" \"file\" \"rgb\" Display \"a.tif\" \"tiff\" \"rgba\" \"string compression\" \"lzw\" "
      "Display \"+b.exr\" \"openexr\" \"z\" \"float[2] exposure\" [1 2]");
  ASSERT_THAT(scene.options.displays, SizeIs(2));
  EXPECT_EQ(scene.options.displays[0].name, "a.tif");
  EXPECT_EQ(scene.options.displays[0].strings.at("compression"), "lzw");
  EXPECT_EQ(scene.options.displays[1].name, "b.exr");
  EXPECT_THAT(scene.options.displays[1].numbers.at("exposure"), ElementsAre(1, 2));
}

TEST(Options, SeedOfRandomNumbers) {
  EXPECT_EQ(worldOf("").options.seed, 0);
  EXPECT_EQ(worldOf("Option \"patina\" \"int seed\" 7").options.seed, 7);
}

TEST(Options, ConstantsOfTheCache) {
  const Scene scene = worldOf("Option \"patina\" \"float levelscale\" .5 \"float finescale\" 1");
  EXPECT_EQ(scene.options.levelScale, .5f);
  EXPECT_EQ(scene.options.fineScale, 1);
  const Built built = build(
      "Option \"patina\" \"float levelscale\" -1\nOption \"patina\" \"float finescale\" 1001\nWorldBegin\n"
      "WorldEnd");
  EXPECT_THAT(
      built.messages,
      ElementsAre("t.rib:1:1: error: range: Option \"patina\" \"levelscale\" -1: expected 0 to 1000",
                  "t.rib:2:1: error: range: Option \"patina\" \"finescale\" 1001: expected 0 to 1000"));
  EXPECT_EQ(built.world().options.levelScale, .35f);
  EXPECT_EQ(built.world().options.fineScale, 2);
}

TEST(Options, ModeByHiderAndByPatina) {
  EXPECT_EQ(
      worldOf("Hider \"raytrace\" \"string integrationmode\" [\"path\"] \"int maxsamples\" 64").options.mode,
      "path");
  EXPECT_EQ(
      worldOf("Option \"patina\" \"string mode\" \"direct\" Integrator \"PxrPathTracer\" \"i\"").options.mode,
      "direct");
  EXPECT_EQ(worldOf("Hider \"raytrace\" \"int maxsamples\" 64 \"int minsamples\" 0").options.maxSamples, 64);
}

TEST(Options, IncrementalIsTheRaytraceHiders) {
  EXPECT_FALSE(worldOf("").options.incremental);
  EXPECT_TRUE(worldOf("Hider \"raytrace\" \"int incremental\" [1]").options.incremental);
  EXPECT_TRUE(worldOf("Hider \"raytrace\" \"incremental\" 1 Hider \"raytrace\" \"int minsamples\" 2")
                  .options.incremental);
  EXPECT_FALSE(worldOf("Hider \"raytrace\" \"incremental\" 1 Hider \"raytrace\" \"incremental\" 0")
                   .options.incremental);
}

TEST(Options, SearchPathsKeepWhatTheAmpersandNames) {
  const Scene scene =
      worldOf("Option \"searchpath\" \"string shader\" \"a:b\" Option \"searchpath\" \"shader\" [\"c:&:d\"]");
  EXPECT_EQ(scene.options.searchPaths.at("shader"), "c:a:b:d");
}

TEST(Options, BackgroundByAnyOfItsNames) {
  for (const char* token : {"color", "bgcolor", "background"}) {
    const Scene scene = worldOf(std::string("Imager \"background\" \"color ") + token + "\" [.1 .2 .3]");
    EXPECT_EQ(scene.options.background, Rgb(.1f, .2f, .3f)) << token;
  }
}

TEST(Options, RefusesValuesOutOfRange) {
  const Built built = build(
      "Clipping 5 2\nCropWindow 0 2 0 1\nProjection \"perspective\" \"fov\" 180\nExposure 1 0\nShutter 1 0\n"
      "PixelSamples 1e9 1\nQuantize \"rgba\" 255 9 1 0\nFrameAspectRatio -1\nFormat 100000 1 1\n"
      "ScreenWindow 1 1 0 1\nOption \"patina\" \"int seed\" -1\nWorldBegin\nWorldEnd");
  EXPECT_THAT(built.messages, ElementsAre("t.rib:1:1: error: range: Clipping 5 2: expected 0 < near < far",
                                          HasSubstr("t.rib:2:1: error: range: CropWindow 0 2 0 1"),
                                          HasSubstr("t.rib:3:1: error: range: Projection: fov 180"),
                                          HasSubstr("t.rib:4:1: error: range: Exposure 1 0"),
                                          HasSubstr("t.rib:5:1: error: range: Shutter 1 0"),
                                          HasSubstr("t.rib:6:1: error: limitcheck: PixelSamples"),
                                          HasSubstr("t.rib:7:1: error: range: Quantize"),
                                          HasSubstr("t.rib:8:1: error: range: FrameAspectRatio"),
                                          HasSubstr("t.rib:9:1: error: limitcheck: Format"),
                                          HasSubstr("t.rib:10:1: error: range: ScreenWindow"),
                                          HasSubstr("t.rib:11:1: error: range: Option \"patina\" \"seed\" "
                                                    "-1: expected 0 or more")));
  EXPECT_EQ(built.world().options.pixelSamplesX, 2);
  EXPECT_EQ(built.world().options.seed, 0);
}

TEST(Options, UnknownNamesAreReported) {
  const Built built = build(
      "Option \"rerender\" \"string lodrange\" \"x\"\nOption \"limits\" \"int gridsize\" 256 \"int "
      "gridsise\" 3\n"
      "Hider \"zbuffer\"\nProjection \"fisheye\"\nPixelFilter \"bob\" 2 2\nWorldBegin\nWorldEnd");
  EXPECT_THAT(
      built.messages,
      testing::UnorderedElementsAre(
          HasSubstr("\"gridsise\""),
          HasSubstr(
              "t.rib:3:1: warning: unimplemented: request Hider \"zbuffer\" is not carried out yet (once)"),
          HasSubstr("t.rib:4:1: warning: badtoken: Projection \"fisheye\" is unknown"),
          HasSubstr("t.rib:5:1: warning: badtoken: PixelFilter \"bob\" is unknown")));
}

TEST(Options, WhatHasNoEffectIsNamedOnce) {
  const Built built = build(
      "Option \"user\" \"float a\" 1\nOption \"radiosity\" \"int steps\" 1\nOption \"trace\" \"maxdepth\" 3\n"
      "Option \"radiosity\" \"int steps\" 2\nAttribute \"sss\" \"float a\" 2\nAttribute \"trace\" \"float "
      "bias\" 1\n"
      "WorldBegin\nWorldEnd");
  EXPECT_THAT(built.messages,
              testing::UnorderedElementsAre(
                  "t.rib:2:1: warning: unimplemented: Option \"radiosity\" has no effect (2 times)",
                  "t.rib:3:1: warning: unimplemented: Option \"trace\" \"maxdepth\" has no effect (once)",
                  "t.rib:5:1: warning: unimplemented: Attribute \"sss\" has no effect (once)"));
}

TEST(Options, NoticesAreLimited) {
  std::string text;
  for (int i = 0; i < 3000; ++i) text += "Option \"a" + std::to_string(i) + "\" \"float a\" 1\n";
  const Built built = build(text + "WorldBegin\nWorldEnd");
  EXPECT_EQ(built.messages.size(), 201u);
  EXPECT_THAT(built.messages, testing::Contains(HasSubstr("more of the kinds named here (2800 times)")));
}

TEST(Options, Caustics) {
  EXPECT_TRUE(build("WorldBegin WorldEnd").world().options.caustics);
  for (const char* off : {R"(Option "trace" "int allowcaustics" [0])",
                          R"(Integrator "PxrPathTracer" "handle" "int allowCaustics" [0])"}) {
    const Built built = build(std::string(off) + " WorldBegin WorldEnd");
    EXPECT_FALSE(built.world().options.caustics) << off;
    EXPECT_TRUE(built.messages.empty());
  }
}

TEST(Options, Points) {
  const Built built = build(
      R"(Option "points" "maxsolidangle" [.01] "resolution" [32] "bounces" [2] "memory" [1000] "surfelsize" [4]
    WorldBegin WorldEnd)");
  const PointOptions& points = built.world().options.points;
  EXPECT_EQ(points.maxSolidAngle, .01f);
  EXPECT_EQ(points.resolution, 32);
  EXPECT_EQ(points.bounces, 2);
  EXPECT_EQ(points.memoryKb, 1000);
  EXPECT_EQ(points.surfelSize, 4);
  EXPECT_TRUE(built.messages.empty());
  const Built wrong = build(
      R"(Option "points" "maxsolidangle" [7] "resolution" [15] "bounces" [0] "memory" [-1] "surfelsize" [-1]
    WorldBegin WorldEnd)");
  EXPECT_EQ(wrong.messages.size(), 5u);
  EXPECT_FALSE(wrong.world().options.points.resolution);
  EXPECT_FALSE(wrong.world().options.points.bounces);
  EXPECT_FALSE(wrong.world().options.points.surfelSize);
}

}  // namespace
}  // namespace patina
