// SPDX-License-Identifier: Apache-2.0
// Light does not leak: what is closed is black, though its floor and walls are those of lit rooms, too.
// That what is near walls, doors, corners and leaves is as bright as it should be is checked against
// references by tests/scenes/leaks.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "renderer/base/statistics.h"
#include "renderer/integrators/render.h"
#include "renderer/scene/scene_builder.h"

namespace patina {
namespace {

constexpr int kSize = 64;

std::string contents(const std::string& name) {
  std::ifstream in(PATINA_SOURCE_DIR "/tests/scenes/leaks/" + name + ".rib");
  EXPECT_TRUE(in) << name;
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::vector<float> render(const std::string& rib, const std::string& mode, int samples, bool atHits) {
  ErrorHandler errors([](Severity, std::string_view message) { ADD_FAILURE() << message; });
  RenderSettings settings;
  settings.mode = mode, settings.samples = samples, settings.rays = 32;
  settings.threads = 2, settings.shadeAtHits = atHits;
  settings.shaderPath = PATINA_BINARY_DIR "/lib/patina/shaders";
  resetStatistics();
  std::vector<float> picture;  // the brightest channel
  SceneBuilder builder({}, errors, [&](Scene& scene) {
    const auto film = renderFrame(scene, settings, errors);
    ASSERT_TRUE(film);
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x)
        picture.push_back(std::max({film->value(x, y, 0), film->value(x, y, 1), film->value(x, y, 2)}));
  });
  builder.readText(rib, "leaks.rib");
  return picture;
}

double statistic(const std::string& name) {
  for (const StatEntry& entry : statistics())
    if (entry.name == name) return entry.value;
  return 0;
}

/// `least`: pixels that show a closed room, by the geometry of the scene.
void expectBlack(const std::string& name, int least) {
  const std::string rib = contents(name);
  // Path mode carries no light through walls, and each of its samples looks for the lamp: where 16 of them
  // find nothing there is nothing.
  const std::vector<float> truth = render(rib, "path", 16, false);
  ASSERT_EQ(truth.size(), size_t{kSize * kSize});
  double lit = 0;
  int litPixels = 0, black = 0;
  for (const float v : truth) {
    lit += static_cast<double>(v), litPixels += v > 0, black += v == 0;
  }
  EXPECT_GE(black, least) << name;
  ASSERT_GT(litPixels, 500) << name;
  const double most = 1e-4 * lit / litPixels;
  for (const bool atHits : {false, true}) {
    const std::vector<float> picture = render(rib, "radiosity", 4, atHits);
    EXPECT_GT(statistic("Radiosity cache/fine/depth 1/hits"), 1000) << "the cache is not used";
    float leak = 0;
    for (size_t k = 0; k < picture.size(); ++k)
      if (truth[k] == 0) leak = std::max(leak, picture[k]);
    EXPECT_LE(static_cast<double>(leak), most) << name << (atHits ? ", shaded at hits" : "");
  }
}

// The wall is seen on edge: the right half of the picture, up to the rooms' height, is the closed room.
TEST(Leaks, AWallWithoutThicknessWhereVerticesAre) { expectBlack("wall_at_vertices", 1200); }
TEST(Leaks, AWallOfAHundredthOfAMicropolygon) { expectBlack("thin_wall", 1100); }
// Six fronts, of 2 to 7 pixels each way.
TEST(Leaks, ClosedBoxesOnALitFloor) { expectBlack("closed_boxes", 80); }

}  // namespace
}  // namespace patina
