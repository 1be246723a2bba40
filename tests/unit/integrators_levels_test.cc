// SPDX-License-Identifier: Apache-2.0
// What coarse levels of the cache may cost: detail, not light.
#include <gtest/gtest.h>

#include "tests/unit/integrators_render.h"

namespace patina {
namespace {

/// A closed room of 2 x 2 x 2, whose creases are dark and whose ceiling has a lamp.
std::string room(const std::string& options) {
  return options + R"(
Format 64 64 1
PixelFilter "box" 1 1
Projection "perspective" "fov" [80]
Translate 0 0 0.9
WorldBegin
  Color [0.8 0.8 0.8]
  Surface "matte" "Kd" [1]
  Attribute "trace" "int maxdiffusedepth" [4]
  AttributeBegin
    AreaLightSource "arealight" 1 "intensity" [6]
    Polygon "P" [-0.4 0.99 -0.4  0.4 0.99 -0.4  0.4 0.99 0.4  -0.4 0.99 0.4]
  AttributeEnd
  Illuminate 1 1
  Polygon "P" [-1 -1 -1  1 -1 -1  1 -1 1  -1 -1 1]
  Polygon "P" [-1 1 -1  -1 1 1  1 1 1  1 1 -1]
  Polygon "P" [-1 -1 -1  -1 -1 1  -1 1 1  -1 1 -1]
  Polygon "P" [1 -1 -1  1 1 -1  1 1 1  1 -1 1]
  Polygon "P" [-1 -1 1  1 -1 1  1 1 1  -1 1 1]
  Polygon "P" [-1 -1 -1  -1 1 -1  1 1 -1  1 -1 -1]
WorldEnd
)";
}

double meanOf(const std::string& rib, const std::string& mode, int seed) {
  RenderSettings settings;
  settings.mode = mode, settings.samples = 4, settings.rays = 64, settings.seed = seed;
  const std::vector<Rgb> picture = renderPicture(rib, settings);
  double sum = 0;
  for (const Rgb& c : picture) sum += static_cast<double>(c.x + c.y + c.z) / 3;
  return sum / static_cast<double>(picture.size());
}

// Values on the rims of patches lie in the dark of the creases: interpolated between those, walls lose 3 % of
// their light.
TEST(Levels, CoarseOnesKeepTheMeanLight) {
  double truth = 0, coarse = 0;
  for (const int seed : {1, 2, 3, 4}) {
    truth += meanOf(room(""), "distribution", seed) / 4;
    coarse += meanOf(room("Option \"patina\" \"float levelscale\" [10]"), "radiosity", seed) / 4;
  }
  EXPECT_NEAR(coarse / truth, 1, 0.012);
}

}  // namespace
}  // namespace patina
