// SPDX-License-Identifier: Apache-2.0
// Mode points against closed forms, and against itself.
#include <gtest/gtest.h>

#include <cmath>

#include "integrators_render.h"
#include "renderer/base/sampling.h"

namespace patina {
namespace {

constexpr int kSize = 24;

/// kFront's settings are those of each picture.
std::vector<Rgb> render(const std::string& rib, const PointOptions& points,
                        const std::string& mode = "points", int threads = 2, int samples = 4) {
  RenderSettings settings;
  settings.mode = mode, settings.samples = samples, settings.threads = threads, settings.points = points;
  return renderPicture(rib, settings);
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

/// One for each micropolygon, however small.
PointOptions allOf(PointOptions options) {
  options.surfelSize = 0;
  return options;
}

const std::string kFront =
    "Format 24 24 1 PixelFilter \"box\" 1 1 ShadingRate 16 Projection \"perspective\" \"fov\" [90] ";

/// What emits 0.2 and reflects 0.8, 0.5 and 0.2.
std::string glow(int bounces) {
  return "Attribute \"trace\" \"maxdiffusedepth\" [" + std::to_string(bounces) +
         "] Color [.8 .5 .2] Surface \"matte\" \"Kd\" [1] \"color emission\" [.2 .2 .2] ";
}
const std::string kBox = R"(
    Polygon "P" [-1 -1 -1  1 -1 -1  1 -1 1  -1 -1 1] Polygon "P" [-1 1 -1  -1 1 1  1 1 1  1 1 -1]
    Polygon "P" [-1 -1 -1  -1 -1 1  -1 1 1  -1 1 -1] Polygon "P" [1 -1 -1  1 1 -1  1 1 1  1 -1 1]
    Polygon "P" [-1 -1 1  1 -1 1  1 1 1  -1 1 1] Polygon "P" [-1 -1 -1  -1 1 -1  1 1 -1  1 -1 -1])";

TEST(Points, EachBounceOfAFurnaceIsThere) {
  // Inside of what emits E everywhere and reflects rho of it: E (1 + rho + ... + rho^n).
  const std::string ball = kFront + "WorldBegin " + glow(8) + "Sphere 1 -1 1 360 WorldEnd",
                    box = kFront + "WorldBegin " + glow(8) + kBox + " WorldEnd";
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

/// Sums over the lit half of a picture of them, and over the dark one.
std::pair<double, double> halves(const std::vector<Rgb>& picture) {
  double lit = 0, dark = 0;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const double value = static_cast<double>(picture[static_cast<size_t>(y * kSize + x)].x);
      if (x < kSize / 2 - 1) lit += value;
      if (x > kSize / 2) dark += value;
    }
  return {lit, dark};
}

TEST(Points, NoLightGetsThroughAWall) {
  const auto [lit, dark] = halves(render(kTwoRooms, {}));
  EXPECT_GT(lit / (kSize * kSize), 0.05);
  EXPECT_LT(dark, 0.005 * lit);
}

/// A wall of small faces across a room at x, in sheets 0.02 from each other and a single mesh.
std::string fineWall(int sheets, double x) {
  constexpr int kAlong = 64;
  std::string counts, vertices, points;
  for (int side = 0; side < sheets; ++side)
    for (int j = 0; j <= kAlong; ++j)
      for (int i = 0; i <= kAlong; ++i)
        points += std::to_string(x + side * 0.02) + ' ' + std::to_string(2.0 * i / kAlong - 1) + ' ' +
                  std::to_string(2.0 * j / kAlong - 1) + ' ';
  for (int side = 0; side < sheets; ++side)
    for (int j = 0; j < kAlong; ++j)
      for (int i = 0; i < kAlong; ++i) {
        const int at = (side * (kAlong + 1) + j) * (kAlong + 1) + i;
        counts += "4 ";
        for (const int k : {at, at + 1, at + kAlong + 2, at + kAlong + 1})
          vertices += std::to_string(k) + ' ';
      }
  return "PointsPolygons [" + counts + "] [" + vertices + "] \"P\" [" + points + "]";
}

TEST(Points, SheetsOfAWallAreNoTangle) {
  // One is lit and the other is dark; the camera is where no light is.
  std::string rooms = kTwoRooms;
  const std::string wall = "Polygon \"P\" [0 -1 -1  0 1 -1  0 1 1  0 -1 1]";
  rooms.replace(rooms.find(wall), wall.size(), fineWall(2, -0.21));
  render(rooms, allOf(bounces(2)));
  EXPECT_GT(statistic("Points/surfels"), 8000);
  EXPECT_EQ(statistic("Points/tangles that share irradiance"), 0);
}

TEST(Points, NodesThatAWallStandsInAreNotWhatBothSidesSee) {
  // No boundary of the octree is there: its nodes have light on one side of the wall. What is left is of
  // pieces that the wall stands on.
  for (const int sheets : {1, 2}) {
    std::string rooms = kTwoRooms;
    const auto replace = [&rooms](const std::string& of, const std::string& with) {
      rooms.replace(rooms.find(of), of.size(), with);
    };
    replace("Polygon \"P\" [0 -1 -1  0 1 -1  0 1 1  0 -1 1]", fineWall(sheets, -0.21));
    replace("ShadingRate 16", "ShadingRate 0.25");
    const Rgb dark = mean(render(rooms, bounces(1)));
    replace("Translate 0 0", "Translate .5 0");
    const Rgb lit = mean(render(rooms, bounces(1)));
    EXPECT_GT(lit.x, 0.3f);
    EXPECT_LT(dark.x, 0.0015f * lit.x) << sheets;
  }
}

/// Leaves of one face each, of all directions; or combed hair, all of it turned alike.
std::string leaves(int count, bool combed) {
  std::string counts, vertices, points;
  for (int k = 0; k < count; ++k) {
    const auto at = [&](uint64_t n) {
      return 2 * toUnit(static_cast<uint32_t>(hashOf(uint64_t{3}, k, n) >> 32)) - 1;
    };
    const V3f P = V3f(at(0), at(1), at(2)) * 0.5f;
    const Frame frame(combed ? V3f(0, 0, 1) : normalizedOr(V3f(at(3), at(4), at(5)), V3f(0, 0, 1)));
    const float halfU = combed ? 0.03f : 0.01f, halfV = combed ? 0.003f : 0.01f;
    counts += "4 ";
    for (const auto& [u, v] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
      const V3f p = P + frame.x * (static_cast<float>(u) * halfU) + frame.y * (static_cast<float>(v) * halfV);
      points += std::to_string(p.x) + ' ' + std::to_string(p.y) + ' ' + std::to_string(p.z) + ' ';
    }
    for (int i = 0; i < 4; ++i) vertices += std::to_string(4 * k + i) + ' ';
  }
  return "PointsPolygons [" + counts + "] [" + vertices + "] \"P\" [" + points + "]";
}

TEST(Points, TanglesShareIrradiance) {
  // As in an empty furnace; each leaf for itself would be some 20 000 rasters.
  for (const bool combed : {false, true}) {
    const std::string rib = kFront + "WorldBegin " + glow(3) + kBox + leaves(10000, combed) + " WorldEnd";
    const Rgb seen = mean(render(rib, allOf(bounces(3))));
    EXPECT_GT(statistic("Points/tangles that share irradiance"), 100) << combed;
    EXPECT_LT(statistic("Points/rasters drawn"), 16000) << combed;
    const float albedos[3] = {0.8f, 0.5f, 0.2f};
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(seen[c] / (0.2f * (1 - std::pow(albedos[c], 4.0f)) / (1 - albedos[c])), 1, 0.03)
          << c << combed;
  }
}

TEST(Points, AgreeWithPathsInARoom) {
  const Rgb points = mean(render(kTwoRooms, bounces(12))), path = mean(render(kTwoRooms, {}, "path", 2, 64));
  EXPECT_NEAR(points.x / path.x, 1, 0.04);
}

TEST(Points, AllBouncesAreThereWithoutOneForEach) {
  // A furnace with a ratio of 0.8: 30 bounces, whose last ones are estimated; and objects that allow few.
  for (const int n : {2, 3, 30}) {
    const Rgb seen = mean(render(kFront + "WorldBegin " + glow(n) + kBox + " WorldEnd", {}));
    const float albedos[3] = {0.8f, 0.5f, 0.2f};
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(seen[c], 0.2f * (1 - std::pow(albedos[c], static_cast<float>(n + 1))) / (1 - albedos[c]),
                  0.01f * seen[c])
          << n << ' ' << c;
  }
  EXPECT_LT(statistic("Points/bounces baked"), 25);
  EXPECT_GT(statistic("Points/bounces baked"), 3);
}

TEST(Points, BouncesAfterTheFirstSeeWhatThatOneSaw) {
  const std::vector<Rgb> kept = render(kTwoRooms, bounces(6));
  const double pieces = statistic("Points/surfels"), drawn = statistic("Points/rasters drawn"),
               reused = statistic("Points/rasters not drawn again for another bounce"),
               step = statistic("Points/micropolygons along a surfel");
  EXPECT_GT(reused, 0.4 * drawn);
  EXPECT_GT(statistic("Memory/views of points while baking MB"), 0.1);
  // Where memory is for the pieces and no more, rasters are drawn again, and see the same.
  PointOptions tight = bounces(6);
  tight.memoryKb = static_cast<int>(pieces * 600 / 1024) + 64;
  EXPECT_EQ(render(kTwoRooms, tight), kept);
  EXPECT_EQ(statistic("Points/micropolygons along a surfel"), step);
  EXPECT_LT(statistic("Memory/views of points while baking MB"), 0.07);
  EXPECT_GT(statistic("Points/rasters drawn"), drawn + 0.8 * reused);
}

TEST(Points, ThreadsChangeNoBit) {
  EXPECT_EQ(render(kTwoRooms, bounces(2), "points", 2), render(kTwoRooms, bounces(2), "points", 5));
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
  render(kTwoRooms, few);
  const double small = statistic("Memory/points MB");
  EXPECT_LT(small, 0.1);
  EXPECT_GT(statistic("Points/micropolygons along a surfel"), 1);
  render(kTwoRooms, bounces(1));
  EXPECT_GT(statistic("Memory/points MB"), small);
  EXPECT_EQ(statistic("Points/micropolygons along a surfel"), 1);
}

TEST(Points, ScarceMemoryMakesTheSmallestPiecesLarger) {
  // The walls around ten thousand leaves keep what they have: gaps in them would be dark.
  const std::string rib =
      kFront + "ShadingRate .5 WorldBegin " + glow(3) + kBox + leaves(10000, false) + " WorldEnd";
  for (const int n : {1, 3}) {
    PointOptions few = allOf(bounces(n));
    few.memoryKb = 3000;
    const Rgb seen = mean(render(rib, few));
    EXPECT_GT(statistic("Points/micropolygons along a surfel"), 1.5) << n;
    EXPECT_LT(statistic("Points/surfels"), 5200 / (n > 2 ? 2 : 1)) << n;
    const float albedos[3] = {0.8f, 0.5f, 0.2f};
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(seen[c] / (0.2f * (1 - std::pow(albedos[c], static_cast<float>(n + 1))) / (1 - albedos[c])),
                  1, 0.03)
          << n << ' ' << c;
  }
}

TEST(Points, SurfelsAreAsLargeAsIsAskedFor) {
  // Far away and near, and in front of a plain whose pieces towards the horizon are large but look small.
  const std::string rib = kFront + "ShadingRate .25 WorldBegin " + glow(1) +
                          "Translate 0 -.5 2 Sphere .4 -.4 .4 360 Translate 0 0 18 Sphere 4 -4 4 360 "
                          "Polygon \"P\" [-1e4 -1 -19  -1e4 -1 1e4  1e4 -1 1e4  1e4 -1 -19] WorldEnd";
  double before = 0;
  for (const float size : {0.0f, 1.0f, 4.0f}) {
    PointOptions options = bounces(1);
    options.surfelSize = size;
    render(rib, options);
    const double count = statistic("Points/surfels");
    if (size > 0) {
      EXPECT_LT(count, 0.6 * before) << size;
      EXPECT_GT(count, 0.05 * before) << size;
    }
    before = count;
  }
}

TEST(Points, NeighboursOfOnePieceCoverWhatTheyDid) {
  // A wall of small faces across a room, of which one piece stands for several.
  std::string rooms = kTwoRooms;
  const std::string wall = "Polygon \"P\" [0 -1 -1  0 1 -1  0 1 1  0 -1 1]";
  rooms.replace(rooms.find(wall), wall.size(), fineWall(1, 0));
  const auto [lit, dark] = halves(render(rooms, bounces(1)));
  PointOptions few = bounces(1);
  few.memoryKb = static_cast<int>(statistic("Points/surfels") * 600 / 1024 / 4);
  const std::vector<Rgb> picture = render(rooms, few);
  const auto [fewLit, fewDark] = halves(picture);
  EXPECT_GT(statistic("Points/micropolygons along a surfel"), 1.9);
  // Discs in place of squares leave some seams.
  EXPECT_NEAR(fewLit / lit, 1, 0.05);
  EXPECT_LT(fewDark, dark + 0.03 * lit);
  EXPECT_EQ(render(rooms, few, "points", 5), picture);
}

}  // namespace
}  // namespace patina
