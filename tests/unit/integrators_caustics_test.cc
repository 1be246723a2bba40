// SPDX-License-Identifier: Apache-2.0
// Light that lobes pass on to diffuse surfaces, with and without it, in all modes.
#include <gtest/gtest.h>

#include "tests/unit/integrators_render.h"

namespace patina {
namespace {

constexpr int kSize = 16;

/// A floor seen from above, a lit wall on its right, and `left` on its left, across a gap that the camera
/// sees nothing of; `more` is put into the world before.
std::string scene(const std::string& left, const std::string& options = {}, const std::string& more = {}) {
  return options +
         "Format 16 16 1 PixelFilter \"box\" 1 1 Projection \"orthographic\" ScreenWindow -2 2 -2 2 "
         "Clipping 0.1 100 WorldBegin Translate 0 0 4 " +
         more +
         "LightSource \"spotlight\" 1 \"float intensity\" [60] \"point from\" [-1.9 0 -1] \"point to\" [2 0 "
         "-1] "
         "\"float coneangle\" [.45] \"float conedeltaangle\" [.1] "
         "Color [1 1 1] Surface \"matte\" \"float Ka\" [0] \"float Kd\" [.7] "
         "Polygon \"P\" [-2 -2 0  2 -2 0  2 2 0  -2 2 0] Polygon \"P\" [2 -2 0  2 2 0  2 2 -2  2 -2 -2] " +
         left + " Polygon \"P\" [-2 -2 0  -2 2 0  -2 2 -2  -2 -2 -2] WorldEnd";
}

const std::string kMirror = "Surface \"conductor\" ";
const std::string kPlastic = "Surface \"plastic\" \"float Ka\" [0] \"float Kd\" [.4] \"float Ks\" [.6] ";
const std::string kMatte = "Surface \"matte\" \"float Ka\" [0] \"float Kd\" [.4] ";
const std::string kBlack = "Surface \"matte\" \"float Ka\" [0] \"float Kd\" [0] ";

class Caustics : public testing::TestWithParam<const char*> {
 protected:
  std::vector<Rgb> render(const std::string& rib, std::optional<bool> caustics = {}) const {
    RenderSettings settings;
    settings.mode = GetParam(), settings.samples = settings.mode == "path" ? 1024 : 4;
    settings.rays = 256, settings.caustics = caustics;
    return renderPicture(rib, settings);
  }
};

/// Mean of a picture's left half, where the most light comes from what stands on the left.
float leftOf(const std::vector<Rgb>& picture) {
  float sum = 0;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize / 2; ++x) sum += picture[static_cast<size_t>(y * kSize + x)].x;
  return sum / (kSize * kSize / 2);
}

// Without caustics a mirror is black to diffuse rays, and plastic is as matte.
TEST_P(Caustics, AreLeftOutOnDemand) {
  const std::string off = "Option \"trace\" \"int allowcaustics\" [0] ";
  const float black = leftOf(render(scene(kBlack))), matte = leftOf(render(scene(kMatte)));
  ASSERT_GT(black, 0.01f);
  const float mirror = leftOf(render(scene(kMirror, off)));
  EXPECT_EQ(statistic("Radiosity/specular continuations"), 0);
  EXPECT_NEAR(mirror, black, 0.01f * black);
  EXPECT_NEAR(leftOf(render(scene(kPlastic), false)), matte, 0.01f * matte);
  // The command line goes before the file.
  const float seen = leftOf(render(scene(kMirror, off), true));
  if (GetParam() == std::string("points"))
    EXPECT_NEAR(seen, black, 0.01f * black) << "points have diffuse light alone";
  else
    EXPECT_GT(seen, 1.2f * black);
}

// What the camera sees by way of mirrors is no caustic.
TEST_P(Caustics, AreNotWhatTheCameraSeesInMirrors) {
  // It shows the wall on the right.
  const std::string mirror = "AttributeBegin " + kMirror +
                             "Polygon \"P\" [-2 -2 -3  -.5 -2 -1.5  -.5 2 -1.5  -2 2 -3] AttributeEnd ";
  const float with = leftOf(render(scene(kMatte, {}, mirror), true)),
              without = leftOf(render(scene(kMatte, {}, mirror), false));
  ASSERT_GT(with, 0.01f);
  EXPECT_NEAR(with, without, 0.02f * with);
}

INSTANTIATE_TEST_SUITE_P(Modes, Caustics, testing::Values("radiosity", "distribution", "points", "path"),
                         [](const auto& tested) { return std::string(tested.param); });

}  // namespace
}  // namespace patina
