// SPDX-License-Identifier: Apache-2.0
// View-independent light where the camera sees it: what vertices say, and where they do not suffice.
#include <gtest/gtest.h>

#include "tests/unit/integrators_render.h"

namespace patina {
namespace {

constexpr int kSize = 32;

/// A floor seen from above, on which a light from far away casts the shadow of a wall beside the view: lit
/// where x + y / 4 < 0, with the view from -1 to 1.
const std::string kEdge =
    "Format 32 32 1 PixelFilter \"box\" 1 1 Projection \"orthographic\" Rotate -90 1 0 0 Translate 0 -1 0 "
    "WorldBegin LightSource \"distantlight\" 1 \"from\" [-1 1 0] \"to\" [0 0 0] Attribute \"trace\" \"int "
    "maxdiffusedepth\" [0] Surface \"matte\" \"float Kd\" [1] Color [1 1 1] ShadingRate 4 "
    "Polygon \"P\" [-3 0 -3  -3 0 3  3 0 3  3 0 -3] "
    "Polygon \"P\" [-2.5 .75 3  -2.5 2.5 3  -3.2 2.5 -3  -3.2 .75 -3] WorldEnd";

std::vector<Rgb> renderEdge(const std::string& mode, bool hits = false) {
  RenderSettings settings;
  settings.mode = mode, settings.samples = 64, settings.shadeAtHits = hits;
  return renderPicture(kEdge, settings);
}

class CameraShading : public testing::TestWithParam<const char*> {};

// Micropolygons are two pixels wide: interpolated between their vertices, the edge would be four.
TEST_P(CameraShading, EdgesOfShadowsAreSharp) {
  const std::vector<Rgb> truth = renderEdge("path"), picture = renderEdge(GetParam());
  const double parts = statistic("Camera/points shaded for parts of pixels"), samples = kSize * kSize * 64;
  ASSERT_EQ(picture.size(), truth.size());
  int lit = 0, dark = 0, between = 0;
  for (size_t i = 0; i < truth.size(); ++i) {
    (truth[i].x == 0 ? dark : truth[i].x > 0.7f ? lit : between) += 1;
    // 16 points of a pixel, of its 64 samples.
    EXPECT_NEAR(picture[i].x, truth[i].x, 0.15) << i % kSize << ' ' << i / kSize;
  }
  EXPECT_GT(lit, 300);
  EXPECT_GT(dark, 300);
  EXPECT_GT(between, 30);
  // Elsewhere vertices suffice.
  EXPECT_GT(parts, 16 * kSize);
  EXPECT_LT(parts, samples / 16);
}

INSTANTIATE_TEST_SUITE_P(Modes, CameraShading, testing::Values("radiosity", "distribution", "direct"));

}  // namespace
}  // namespace patina
