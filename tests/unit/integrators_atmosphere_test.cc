// SPDX-License-Identifier: Apache-2.0
// RI's Atmosphere: fog and depthcue against their formulas (RI 3.2, appendix A), in every mode.
#include <cmath>
#include <fstream>

#include "integrators_render.h"

namespace patina {
namespace {

/// A camera at 0 that looks along z, 1x1 pixel, narrow; `world` is what it sees.
std::string scene(const std::string& world) {
  return "Format 1 1 1 PixelSamples 4 4 PixelFilter \"box\" 1 1 Clipping 1 11\n"
         "Projection \"perspective\" \"fov\" 0.5\nWorldBegin\nSurface \"constant\"\n" +
         world + "WorldEnd\n";
}
/// A square of constant colour across the view.
std::string square(float z) {
  return "Polygon \"P\" [-1 -1 " + std::to_string(z) + " 1 -1 " + std::to_string(z) + " 1 1 " +
         std::to_string(z) + " -1 1 " + std::to_string(z) + "]\n";
}
const std::string kModes[] = {"radiosity", "distribution", "path", "points", "direct"};

void expectColor(const std::string& world, const Rgb& expected, float tolerance = 1e-3f) {
  for (const std::string& mode : kModes) {
    RenderSettings settings;
    settings.mode = mode;
    const auto picture = renderPicture(scene(world), settings);
    ASSERT_EQ(picture.size(), 1u);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(picture[0][c], expected[c], tolerance) << mode << ' ' << c;
  }
}

TEST(Atmosphere, FogMixesByTheLengthOfI) {
  const float d = 1 - std::exp(-5.0f / 4);
  expectColor("Color 1 0.5 0 Atmosphere \"fog\" \"float distance\" 4 \"color background\" [0.2 0.4 0.8]\n" +
                  square(5),
              Rgb(1, 0.5f, 0) * (1 - d) + Rgb(0.2f, 0.4f, 0.8f) * d);
}

TEST(Atmosphere, DepthcueMixesByTheDepthBetweenTheClippingPlanes) {
  // depth(P) = (6 - 1) / (11 - 1); d = (0.5 - 0.25) / (0.75 - 0.25).
  expectColor(
      "Color 1 0.5 0 Atmosphere \"depthcue\" \"float mindistance\" 0.25 \"float maxdistance\" 0.75 "
      "\"color background\" [0.2 0.4 0.8]\n" +
          square(6),
      Rgb(1, 0.5f, 0) * 0.5f + Rgb(0.2f, 0.4f, 0.8f) * 0.5f);
}

TEST(Atmosphere, OnlySurfacesThatHaveItAreSeenThroughIt) {
  expectColor("AttributeBegin Color 1 1 1 " + square(5) + "AttributeEnd\n" +
                  "Atmosphere \"fog\" \"float distance\" 1\n" + square(8),
              Rgb(1, 1, 1));
  EXPECT_EQ(statistic("Atmosphere/segments"), 0);
  expectColor("AttributeBegin Atmosphere \"fog\" Atmosphere \"null\"" + square(5) + "AttributeEnd\n",
              Rgb(1, 1, 1));
}

// Fog before a half transparent square and before what is behind it: T(5) * (0.5 C1 + 0.5 (T(3) C2 + ...)).
TEST(Atmosphere, ItLiesBeforeEachOfTheLayersThatAreSeen) {
  const float near = std::exp(-5.0f / 4), far = std::exp(-3.0f / 4);
  const Rgb air(0.2f, 0.4f, 0.8f), behind = Rgb(0, 0, 1) * far + air * (1 - far);
  const Rgb expected = (Rgb(1, 0, 0) * 0.5f + behind * 0.5f) * near + air * (1 - near);
  const std::string world =
      "Atmosphere \"fog\" \"float distance\" 4 \"color background\" [0.2 0.4 0.8]\n"
      "AttributeBegin Color 1 0 0 Opacity 0.5 0.5 0.5 " +
      square(5) + "AttributeEnd\nColor 0 0 1 " + square(8);
  for (const std::string& mode : kModes) {
    RenderSettings settings;
    settings.mode = mode, settings.samples = 256;
    const auto picture = renderPicture(scene(world), settings);
    const float tolerance = mode == "path" ? 0.02f : 1e-3f;  // layers are picked by chance there
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(picture.at(0)[c], expected[c], tolerance) << mode << ' ' << c;
  }
}

// Light from what the camera sees directly is dimmed as all else.
TEST(Atmosphere, AreaLightsAreDimmed) {
  const float d = 1 - std::exp(-5.0f / 4);
  expectColor(
      "Atmosphere \"fog\" \"float distance\" 4\nAreaLightSource \"arealight\" 1 \"intensity\" 3 \"int "
      "sides\" 2\nSurface \"null\"\n" +
          square(5),
      Rgb(3, 3, 3) * (1 - d), 3e-3f);
}

TEST(Atmosphere, ShadersThatAreNoneAreReported) {
  std::vector<std::string> messages;
  ErrorHandler errors([&](Severity, std::string_view message) { messages.emplace_back(message); });
  RenderSettings settings;
  settings.threads = 2, settings.shaderPath = PATINA_BINARY_DIR "/lib/patina/shaders";
  SceneBuilder builder({}, errors, [&](Scene& s) { renderFrame(s, settings, errors); });
  builder.readText(scene("Atmosphere \"matte\"\n" + square(5)), "t.rib");
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_EQ(messages[0], "t.rib:5:1: error: noshader: \"matte\" is no shader for Atmosphere");
}

}  // namespace
}  // namespace patina
