// SPDX-License-Identifier: Apache-2.0
// Pictures of delayed archives are those of the same archives read at once, whatever they hold, and the same
// for any number of threads.
#include <gtest/gtest.h>

#include <bit>

#include "renderer/base/statistics.h"
#include "renderer/integrators/render.h"
#include "renderer/scene/scene_builder.h"

namespace patina {
namespace {

/// A displaced ball, a carved one, and a disc that lets light through; a shader and a coordinate system of
/// the archive's own.
constexpr std::string_view kStill =
    "Surface \"matte\" \"Kd\" [.9] CoordinateSystem \"mine\"\n"
    "AttributeBegin Color .3 .8 .3 Attribute \"displacementbound\" \"sphere\" [.1] "
    "Displacement \"waves\" \"amplitude\" [.08] Translate .5 .5 0 Sphere .35 -.35 .35 360 AttributeEnd\n"
    "AttributeBegin Color .3 .4 .9 Translate -.5 -.5 0 SolidBegin \"difference\" "
    "SolidBegin \"primitive\" Sphere .4 -.4 .4 360 SolidEnd "
    "SolidBegin \"primitive\" Translate .1 .1 -.3 Sphere .3 -.3 .3 360 SolidEnd SolidEnd AttributeEnd\n"
    "AttributeBegin Opacity .5 .6 .7 Translate .1 0 -.4 Disk 0 .5 360 AttributeEnd\n"
    "AttributeBegin Color .9 .3 .2 Translate -.5 .5 0 MotionBegin [0 1] Sphere .2 -.2 .2 360 "
    "Sphere .35 -.35 .35 360 MotionEnd AttributeEnd\n";
/// A ball that goes by, and one that turns and is displaced, by what it does not say.
constexpr std::string_view kMoving =
    "AttributeBegin Color .9 .3 .2 MotionBegin [0 1] Translate -.5 .4 -.3 Translate 0 .6 .1 MotionEnd "
    "Sphere .2 -.2 .2 360 AttributeEnd\n"
    "AttributeBegin Displacement \"waves\" \"amplitude\" [.05] Translate .5 -.5 0 "
    "MotionBegin [0 1] Rotate 0 0 0 1 Rotate 60 0 0 1 MotionEnd Translate .2 0 0 Sphere .2 -.2 .2 360 "
    "AttributeEnd\n";

std::string scene(bool delayed, bool moving, const std::string& before = {}) {
  std::string text =
      "Format 40 40 1 PixelFilter \"box\" 1 1 Projection \"perspective\" \"fov\" 40 Shutter 0 1 "
      "ClippingPlane 0 -1.5 0 0 -1 0 Translate 0 0 6 Declare \"amplitude\" \"uniform float\" "
      "ArchiveBegin \"a\"\n" +
      std::string(kStill) + std::string(moving ? kMoving : "") +
      "ArchiveEnd WorldBegin\nLightSource \"pointlight\" 1 \"from\" [-2 3 -4] \"intensity\" [20]\n"
      "LightSource \"envlight\" 2 \"intensity\" [.3]\nSurface \"matte\"\n"
      "Polygon \"P\" [-3 -3 1.5  3 -3 1.5  3 3 1.5  -3 3 1.5] " +
      before + "\n";
  for (const char* place : {"Translate -.9 -.9 0 Rotate 20 1 1 0", "Translate .9 .8 0 Scale -1 1 1"})
    text += std::string("AttributeBegin ") + place +
            (delayed ? " Procedural \"DelayedReadArchive\" [\"a\"] [-1 1 -1 1 -1 1]"
                     : " AttributeBegin ReadArchive \"a\" AttributeEnd") +
            " AttributeEnd\n";
  return text + "WorldEnd\n";
}

std::vector<float> render(const std::string& rib, const std::string& mode, int samples, int threads,
                          size_t expectedMessages) {
  std::vector<std::string> messages;
  ErrorHandler errors([&](Severity, std::string_view message) { messages.emplace_back(message); });
  RenderSettings settings;
  settings.mode = mode, settings.samples = samples, settings.threads = threads;
  settings.shaderPath = PATINA_BINARY_DIR "/lib/patina/shaders";
  std::vector<float> values;
  SceneBuilder builder({}, errors, [&](Scene& frame) {
    resetStatistics();
    const auto film = renderFrame(frame, settings, errors);
    ASSERT_TRUE(film);
    for (int y = 0; y < frame.options.yResolution; ++y)
      for (int x = 0; x < frame.options.xResolution; ++x)
        for (int c = 0; c < 4; ++c) values.push_back(film->value(x, y, c));
  });
  builder.readText(rib, "t.rib");
  errors.summarize();
  // What moves says no displacementbound.
  EXPECT_EQ(messages.size(), expectedMessages);
  for (const std::string& message : messages)
    EXPECT_NE(message.find("without Attribute \"displacementbound\""), std::string::npos) << message;
  return values;
}

double counter(const std::string& name) {
  for (const StatEntry& entry : statistics())
    if (entry.name == name) return entry.value;
  return 0;
}

size_t differing(const std::vector<float>& a, const std::vector<float>& b) {
  EXPECT_EQ(a.size(), b.size());
  size_t count = 0;
  for (size_t k = 0; k < std::min(a.size(), b.size()); ++k)
    count += std::bit_cast<uint32_t>(a[k]) != std::bit_cast<uint32_t>(b[k]);
  return count;
}

TEST(DelayedPictures, AreThoseOfArchivesReadAtOnce) {
  // Random numbers of path mode belong to pixels.
  for (const std::string& before :
       {std::string(), std::string("Attribute \"trace\" \"int samplemotion\" [1]")})
    for (const bool moving : {false, true}) {
      const std::vector<float> atOnce = render(scene(false, moving, before), "path", 4, 2, moving);
      EXPECT_EQ(counter("Delayed archives/requests"), 0);
      const std::vector<float> delayed = render(scene(true, moving, before), "path", 4, 2, moving ? 2 : 0);
      EXPECT_EQ(counter("Delayed archives/read"), 2);
      // Where instances move, Embree's kernels for sixteen rays, which meet archives one by one, and for one
      // ray do not round alike.
      if (!moving) {
        EXPECT_EQ(differing(atOnce, delayed), 0u) << before;
      }
      for (size_t k = 0; k < atOnce.size(); ++k) ASSERT_NEAR(atOnce[k], delayed[k], 2e-6f) << k;
    }
}

TEST(DelayedPictures, AreTheSameForAnyNumberOfThreads) {
  const std::vector<float> one = render(scene(true, true), "radiosity", 2, 1, 2);
  EXPECT_EQ(differing(one, render(scene(true, true), "radiosity", 2, 2, 2)), 0u);
  EXPECT_EQ(differing(one, render(scene(true, true), "radiosity", 2, 5, 2)), 0u);
  // And those of archives read at once but for their noise: other seeds.
  const std::vector<float> atOnce = render(scene(false, true), "radiosity", 2, 2, 1);
  double sum = 0, error = 0;
  for (size_t k = 0; k < one.size(); ++k)
    sum += static_cast<double>(atOnce[k]), error += static_cast<double>(one[k] - atOnce[k]);
  EXPECT_GT(differing(one, atOnce), 0u);
  EXPECT_LT(std::abs(error) / sum, 0.005);
}

TEST(DelayedPictures, LoadNothingThatNobodyMeets) {
  // Behind the camera, and hidden from all rays by walls around the rest.
  std::string rib = "Format 16 16 1 Translate 0 0 3 WorldBegin Surface \"constant\" Sphere 5 -5 5 360 ";
  for (int k = 0; k < 50; ++k)
    rib +=
        "TransformBegin Translate " + std::to_string(10 + 3 * k) +
        " 0 0 Procedural \"DelayedReadArchive\" [\"there is no such file\"] [-1 1 -1 1 -1 1] TransformEnd\n";
  render(rib + "WorldEnd", "path", 1, 2, 0);
  EXPECT_EQ(counter("Delayed archives/read"), 0);
  EXPECT_EQ(counter("Geometry/primitives"), 1);
}

}  // namespace
}  // namespace patina
