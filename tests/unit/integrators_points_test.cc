// SPDX-License-Identifier: Apache-2.0
// Mode points against closed forms, and against itself.
#include <gtest/gtest.h>

#include <cmath>

#include "renderer/base/statistics.h"
#include "renderer/integrators/render.h"
#include "renderer/scene/scene_builder.h"

namespace patina {
namespace {

constexpr int kSize = 24;

std::vector<Rgb> render(const std::string& rib, const PointOptions& points,
                        const std::string& mode = "points", int threads = 2, int samples = 4) {
  std::vector<Rgb> picture;
  ErrorHandler errors([](Severity, std::string_view message) { ADD_FAILURE() << message; });
  RenderSettings settings;
  settings.mode = mode, settings.samples = samples, settings.threads = threads, settings.points = points;
  settings.shaderPath = PATINA_BINARY_DIR "/lib/patina/shaders";
  SceneBuilder builder({}, errors, [&](Scene& scene) {
    scene.options.xResolution = scene.options.yResolution = kSize;
    scene.options.filter = "box", scene.options.filterWidthX = scene.options.filterWidthY = 1;
    const auto film = renderFrame(scene, settings, errors);
    ASSERT_TRUE(film);
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x)
        picture.push_back({film->value(x, y, 0), film->value(x, y, 1), film->value(x, y, 2)});
  });
  builder.readText(rib, "points.rib");
  return picture;
}

Rgb mean(const std::vector<Rgb>& picture) {
  V3d sum(0, 0, 0);
  for (const Rgb& c : picture) sum += V3d(c);
  return V3f(sum / static_cast<double>(picture.size()));
}

PointOptions bounces(int n) {
  PointOptions options;
  options.bounces = n;
  return options;
}

const std::string kFront = "Format 24 24 1 ShadingRate 16 Projection \"perspective\" \"fov\" [90] ";

TEST(Points, EachBounceOfAFurnaceIsThere) {
  // Inside of what emits E everywhere and reflects rho of it: E (1 + rho + ... + rho^n).
  const std::string glow =
      "Attribute \"trace\" \"maxdiffusedepth\" [8] Color [.8 .5 .2] Surface \"matte\" \"Kd\" [1] \"color "
      "emission\" [.2 .2 .2] ";
  const std::string ball = kFront + "WorldBegin " + glow + "Sphere 1 -1 1 360 WorldEnd",
                    box = kFront + "WorldBegin " + glow + R"(
    Polygon "P" [-1 -1 -1  1 -1 -1  1 -1 1  -1 -1 1] Polygon "P" [-1 1 -1  -1 1 1  1 1 1  1 1 -1]
    Polygon "P" [-1 -1 -1  -1 -1 1  -1 1 1  -1 1 -1] Polygon "P" [1 -1 -1  1 1 -1  1 1 1  1 -1 1]
    Polygon "P" [-1 -1 1  1 -1 1  1 1 1  -1 1 1] Polygon "P" [-1 -1 -1  -1 1 -1  1 1 -1  1 -1 -1] WorldEnd)";
  for (const std::string& rib : {ball, box})
    for (const int n : {1, 2, 3}) {
      const Rgb seen = mean(render(rib, bounces(n)));
      const float albedos[3] = {0.8f, 0.5f, 0.2f};
      for (int c = 0; c < 3; ++c) {
        const float expected =
            0.2f * (1 - std::pow(albedos[c], static_cast<float>(n + 1))) / (1 - albedos[c]);
        EXPECT_NEAR(seen[c] / expected, 1, 0.03) << n << ' ' << c << (rib == ball ? " ball" : " box");
      }
    }
}

/// A room with a lit half, a wall across, and no way through.
const std::string kTwoRooms = kFront + R"(Translate 0 0 .9 WorldBegin
  Attribute "trace" "maxdiffusedepth" [10] LightSource "pointlight" 1 "from" [-.5 .5 .5] "intensity" [2] Surface "matte" "Kd" [1] Color [.8 .8 .8]
  Polygon "P" [-1 -1 -1  1 -1 -1  1 -1 1  -1 -1 1] Polygon "P" [-1 1 -1  -1 1 1  1 1 1  1 1 -1]
  Polygon "P" [-1 -1 -1  -1 -1 1  -1 1 1  -1 1 -1] Polygon "P" [1 -1 -1  1 1 -1  1 1 1  1 -1 1]
  Polygon "P" [-1 -1 1  1 -1 1  1 1 1  -1 1 1] Polygon "P" [-1 -1 -1  -1 1 -1  1 1 -1  1 -1 -1]
  Polygon "P" [0 -1 -1  0 1 -1  0 1 1  0 -1 1] WorldEnd)";

TEST(Points, NoLightGetsThroughAWall) {
  const std::vector<Rgb> picture = render(kTwoRooms, {});
  double lit = 0, dark = 0;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const double value = static_cast<double>(picture[static_cast<size_t>(y * kSize + x)].x);
      if (x < kSize / 2 - 1) lit += value;
      if (x > kSize / 2) dark += value;
    }
  EXPECT_GT(lit / (kSize * kSize), 0.05);
  EXPECT_LT(dark, 0.005 * lit);
}

TEST(Points, AgreeWithPathsInARoom) {
  const Rgb points = mean(render(kTwoRooms, bounces(12))), path = mean(render(kTwoRooms, {}, "path", 2, 64));
  EXPECT_NEAR(points.x / path.x, 1, 0.04);
}

TEST(Points, ThreadsChangeNoBit) {
  EXPECT_EQ(render(kTwoRooms, bounces(2), "points", 1), render(kTwoRooms, bounces(2), "points", 4));
}

TEST(Points, TheSkyIsSeenWhereNothingElseIs) {
  // A white sky over a floor, and a shade close above half of it.
  const std::string sky = kFront + R"(Translate 0 0 2 WorldBegin LightSource "envlight" 1 "lightcolor" [1 1 1]
    Surface "matte" "Kd" [1] Color [.5 .5 .5] Polygon "P" [-9 -9 1  9 -9 1  9 9 1  -9 9 1] WorldEnd)";
  const Rgb open = mean(render(sky, {}));
  EXPECT_NEAR(open.x, 0.5, 0.01);
}

TEST(Points, MemoryIsABudget) {
  PointOptions few = bounces(1);
  few.memoryKb = 100;
  const auto statistic = [](const std::string& name) {
    for (const StatEntry& entry : statistics())
      if (entry.name == name) return entry.value;
    return 0.0;
  };
  resetStatistics();
  render(kTwoRooms, few);
  const double small = statistic("Memory/points MB");
  EXPECT_LT(small, 0.1);
  EXPECT_GT(statistic("Points/micropolygons along a surfel"), 1);
  resetStatistics();
  render(kTwoRooms, bounces(1));
  EXPECT_GT(statistic("Memory/points MB"), small);
  EXPECT_EQ(statistic("Points/micropolygons along a surfel"), 1);
}

}  // namespace
}  // namespace patina
