// SPDX-License-Identifier: Apache-2.0
// Light linking by Illuminate: objects see the lights that are on where they are made, in all modes, whatever
// kind of light it is.
#include <gtest/gtest.h>

#include "tests/unit/integrators_render.h"

namespace patina {
namespace {

constexpr int kSize = 32;

class Linking : public testing::TestWithParam<const char*> {};

/// Two squares side by side, seen from the front; the first light is off for the left one, the second for the
/// right one.
TEST_P(Linking, ObjectsSeeTheLightsThatAreOnForThem) {
  RenderSettings settings;
  settings.mode = GetParam(), settings.samples = 16;
  const std::string area =
      "AttributeBegin Surface \"matte\" \"float Kd\" [0] AreaLightSource \"arealight\" 2 "
      "\"float intensity\" [9] \"color lightcolor\" [0 1 0] Translate 0 0 -5 Sphere 1 -1 1 360 "
      "AttributeEnd Illuminate 2 1 ";
  const std::string point =
      "LightSource \"pointlight\" 2 \"float intensity\" [25] \"color lightcolor\" [0 1 0] \"point from\" [0 "
      "0 -5] ";
  // Whose up, z, is towards the camera.
  const std::string sky =
      "TransformBegin Rotate 180 1 0 0 LightSource \"sunsky\" 2 \"color lightcolor\" [0 1 0] "
      "\"vector sundirection\" [0 .2 1] TransformEnd ";
  for (const std::string& green : {point, area, sky}) {
    const std::vector<Rgb> picture = renderPicture(
        "Format 32 32 1 PixelFilter \"box\" 1 1 Projection \"orthographic\" ScreenWindow -2 2 -2 2 Clipping "
        "0.1 100 "
        "WorldBegin Translate 0 0 2 Attribute \"trace\" \"int maxdiffusedepth\" [0] "
        "LightSource \"distantlight\" 1 \"color lightcolor\" [1 0 0] \"point from\" [0 0 -1] \"point to\" [0 "
        "0 0] " +
            green +
            "Surface \"matte\" \"float Ka\" [0] \"float Kd\" [1] Color [1 1 1] "
            "AttributeBegin Illuminate 1 0 Polygon \"P\" [-2 -2 0  0 -2 0  0 2 0  -2 2 0] AttributeEnd "
            "AttributeBegin Illuminate 2 0 Polygon \"P\" [0 -2 0  2 -2 0  2 2 0  0 2 0] AttributeEnd "
            "WorldEnd",
        settings);
    ASSERT_EQ(picture.size(), size_t{kSize * kSize});
    const Rgb &left = picture[16 * kSize + 8], &right = picture[16 * kSize + 24];
    EXPECT_EQ(left.x, 0) << green;
    EXPECT_GT(left.y, 0.05f) << green;
    EXPECT_NEAR(right.x, 1, 1e-5) << green;
    EXPECT_EQ(right.y, 0) << green;
  }
}

INSTANTIATE_TEST_SUITE_P(Modes, Linking,
                         testing::Values("radiosity", "distribution", "points", "path", "direct"),
                         [](const auto& tested) { return std::string(tested.param); });

}  // namespace
}  // namespace patina
