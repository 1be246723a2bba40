// SPDX-License-Identifier: Apache-2.0
// Irradiance from surfels against closed forms.
#include "renderer/points/point_raster.h"

#include <gtest/gtest.h>

#include "points_shapes.h"

namespace patina {
namespace {

/// The mean over rasters that are turned.
PointRaster::Estimate mean(const std::vector<Surfel>& surfels, const V3f& P, const V3f& N,
                           const PointRaster::Settings& settings = {},
                           const PointRaster::Environment& sky = {}) {
  const PointTree tree(surfels);
  PointRaster raster(settings);
  PointRaster::Estimate sum;
  constexpr int kTurns = 16;
  for (int k = 0; k < kTurns; ++k) {
    const auto e = raster.gather(tree, P, N, (static_cast<float>(k) + 0.5f) / kTurns, 1e-4f, sky);
    sum.irradiance += e.irradiance / kTurns, sum.covered += e.covered / kTurns;
  }
  return sum;
}

PointRaster::Environment white() {
  return [](std::span<const V3f>, std::span<Rgb> out) { std::fill(out.begin(), out.end(), Rgb(1)); };
}

TEST(PointRaster, NothingButSky) {
  const auto e = mean({}, {0, 0, 0}, {0, 0.6f, 0.8f}, {}, white());
  EXPECT_NEAR(e.irradiance.x, kPi, 1e-4f);
  EXPECT_EQ(e.covered, 0);
  EXPECT_EQ(mean({}, {0, 0, 0}, {0, 0, 1}).irradiance, Rgb(0));
  // Directions are the world's: half of a sky that is white where x > 0, from a floor and from a wall.
  const PointRaster::Environment half = [](std::span<const V3f> directions, std::span<Rgb> out) {
    for (size_t k = 0; k < out.size(); ++k) out[k] = Rgb(directions[k].x > 0 ? 1 : 0);
  };
  EXPECT_NEAR(mean({}, {0, 0, 0}, {0, 0, 1}, {}, half).irradiance.x, kPi / 2, 0.01f);
  EXPECT_NEAR(mean({}, {0, 0, 0}, {1, 0, 0}, {}, half).irradiance.x, kPi, 1e-4f);
}

TEST(PointRaster, ASphereAboveAFloor) {
  // E = pi L (r/d)^2 cos: a closed form whatever the distance, as long as no part is below the horizon.
  for (const float distance : {1.3f, 2.0f, 5.0f, 20.0f})
    for (const float cosine : {1.0f, 0.8f}) {
      const V3f center(distance * std::sqrt(1 - cosine * cosine), 0, distance * cosine);
      const auto e = mean(sphere(center, 1, 20000, Rgb(1), false, false), {0, 0, 0}, {0, 0, 1});
      const float expected = cosine / (distance * distance);
      if (distance * cosine < 1) continue;
      EXPECT_NEAR(e.irradiance.x / kPi, expected, 0.06f * expected) << distance << ' ' << cosine;
      EXPECT_NEAR(e.covered, expected, 0.06f * expected);
    }
}

/// Pieces of random places and normals in a slab above a floor.
std::vector<Surfel> tangle(int count, float from, float to) {
  std::vector<Surfel> result;
  for (int k = 0; k < count; ++k) {
    const auto at = [&](uint64_t n) {
      return toUnit(static_cast<uint32_t>(hashOf(uint64_t{7}, k, n) >> 32));
    };
    const float z = 2 * at(0) - 1, angle = 2 * kPi * at(1), r = std::sqrt(1 - z * z);
    Surfel s;
    s.P = V3f(8 * at(2) - 4, 8 * at(3) - 4, from + (to - from) * at(4));
    s.N = V3f(r * std::cos(angle), r * std::sin(angle), z);
    s.area = 0.01f, s.radius = 0.07f, s.halfU = s.halfV = 0.05f;
    s.front = s.back = Rgb(1);
    result.push_back(s);
  }
  return result;
}

TEST(PointRaster, WhatIsHiddenIsNotLookedAt) {
  std::vector<Surfel> behind = tangle(30000, 1.5f, 3), plate;
  addQuad(plate, {-20, -20, 0.1f}, {0, 40, 0}, {40, 0, 0}, 200, Rgb(0.5f));
  std::vector<Surfel> both = plate;
  both.insert(both.end(), behind.begin(), behind.end());
  const auto looked = [](const std::vector<Surfel>& surfels) {
    PointRaster raster({});
    return raster.gather(PointTree(surfels), {0.1f, 0.2f, 0}, {0, 0, 1}, 0.3f, 1e-4f, {});
  };
  const auto alone = looked(plate), hidden = looked(both), open = looked(behind);
  EXPECT_LT(hidden.looked, alone.looked + open.looked / 10);
  EXPECT_NEAR(hidden.irradiance.x, alone.irradiance.x, 0.01f * alone.irradiance.x);
  // A tangle hides itself: ten times as deep, it is looked at little more.
  EXPECT_LT(looked(tangle(300000, 1.5f, 16.5f)).looked, 3 * open.looked);
}

TEST(PointRaster, WhatWasSeenIsSeenInAnotherLight) {
  // A tangle in a box with a gradient along a wall, under a sky: planes, nodes and pieces.
  std::vector<Surfel> surfels = tangle(3000, 0.2f, 0.9f);
  const std::vector<Surfel> box = boxFromInside(24, Rgb(0.5f));
  surfels.insert(surfels.end(), box.begin(), box.end());
  PointTree tree(surfels);
  PointRaster raster({});
  const V3f P(0.1f, 0.2f, -0.9f), N(0, 0, 1);
  SurfelView view;
  for (const float scale : {1.0f, 3.0f}) {
    std::vector<Rgb> front, back;
    for (const Surfel& s : tree.surfels()) {
      front.push_back(Rgb(1.5f + s.P.x, 1, scale));
      back.push_back(Rgb(0.2f, 1 + 0.5f * s.P.y, scale));
    }
    tree.setRadiance(front, back);
    const auto drawn = raster.gather(tree, P, N, 0.3f, 1e-4f, white());
    if (scale == 1) {
      const auto viewed = raster.gather(tree, P, N, 0.3f, 1e-4f, white(), true, Surfel::kNobody, &view);
      EXPECT_EQ(viewed.irradiance, view.irradiance(tree));
      EXPECT_EQ(viewed.covered, drawn.covered);
      EXPECT_EQ(view.nearest, drawn.nearest);
      EXPECT_GT(view.along.size(), 0u);
    }
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(view.irradiance(tree)[c], drawn.irradiance[c], 2e-3f * drawn.irradiance[c]) << c;
  }
  SurfelViews views(view.memory() + 100);
  views.keep(1, view), views.keep(2, view);
  ASSERT_TRUE(views.find(1));
  EXPECT_EQ(views.find(1)->irradiance(tree), view.irradiance(tree));
  EXPECT_FALSE(views.find(2)) << "more than the budget";
}

TEST(PointRaster, AParallelSquare) {
  // The form factor of a square of side 2 at the distance h over its middle (Siegel and Howell, C-11).
  for (const float h : {0.1f, 0.5f, 1.0f, 4.0f}) {
    std::vector<Surfel> square;
    addQuad(square, {-1, -1, h}, {0, 2, 0}, {2, 0, 0}, 64, Rgb(1));
    const float a = 1 / h, root = std::sqrt(1 + a * a);
    const float F = 4 * (a / root * std::atan(a / root)) / kPi;
    const auto e = mean(square, {0, 0, 0}, {0, 0, 1});
    EXPECT_NEAR(e.irradiance.x / kPi, F, 0.03f * F) << h;
    // All of it is at h or farther.
    const PointTree tree(square);
    const auto one = PointRaster({}).gather(tree, {0, 0, 0}, {0, 0, 1}, 0, 1e-4f, {});
    EXPECT_NEAR(one.nearest, h, 0.03f * h);
    EXPECT_LT(one.inverseDistance, 1 / h);
    EXPECT_GT(one.inverseDistance, F / std::sqrt(h * h + 2));
    // From behind it is black, and covers as much.
    const auto behind = mean(square, {0, 0, 2 * h}, {0, 0, -1});
    EXPECT_EQ(behind.irradiance.x, 0) << h;
    EXPECT_NEAR(behind.covered, F, 0.03f * F) << h;
  }
}

TEST(PointRaster, AClosedBoxIsFullEverywhere) {
  // Neither is light lost inside, nor does the white sky behind black walls come in: in the middle, at walls
  // and in corners, with few and with many surfels.
  for (const int n : {8, 32, 96}) {
    const std::vector<Surfel> lit = boxFromInside(n, Rgb(1)), black = boxFromInside(n, Rgb(0), Rgb(1));
    for (const V3f& P :
         {V3f(0, 0, -1), V3f(0.9f, 0.1f, -1), V3f(0.97f, -0.97f, -1), V3f(0.3f, 0.2f, -0.4f)}) {
      const auto e = mean(lit, P, {0, 0, 1});
      EXPECT_NEAR(e.irradiance.x / kPi, 1, 0.01f) << n << ' ' << P;
      const auto leak = mean(black, P, {0, 0, 1}, {}, white());
      EXPECT_LT(leak.irradiance.x / kPi, 0.002f) << n << ' ' << P;
    }
  }
}

TEST(PointRaster, AWallThatIsTurnedIsNoLarger) {
  // What bounds it along the axes of the world would be twice as large.
  for (const float angle : {0.3f, 0.785f}) {
    const V3f u(2 * std::cos(angle), 2 * std::sin(angle), 0), v(-u.y, u.x, 0);
    std::vector<Surfel> square;
    addQuad(square, V3f(0, 0, 1) - (u + v) / 2, v, u, 64, Rgb(1));
    const float root = std::sqrt(2.0f), F = 4 / root * std::atan(1 / root) / kPi;
    for (const float most : {0.02f, 0.25f, 1.0f})
      EXPECT_NEAR(mean(square, {0, 0, 0}, {0, 0, 1}, {16, most}).irradiance.x / kPi, F, 0.01f * F)
          << angle << ' ' << most;
  }
}

TEST(PointRaster, ATriangleOfPiecesIsNoRectangle) {
  // Half of a square, along its diagonal: half of the square's form factor over the middle.
  std::vector<Surfel> square, half;
  addQuad(square, {-1, -1, 1}, {0, 2, 0}, {2, 0, 0}, 128, Rgb(1));
  for (const Surfel& s : square)
    if (s.P.x > s.P.y) half.push_back(s);
  const float root = std::sqrt(2.0f), F = 4 / root * std::atan(1 / root) / kPi;
  EXPECT_NEAR(mean(half, {0, 0, 0}, {0, 0, 1}, {16, 1}).irradiance.x / kPi, F / 2, 0.03f * F / 2);
}

/// A piece that is a triangle, of radiance 1 on both sides.
Surfel trianglePiece(const std::array<V3f, 3>& corners) {
  const V3f cross = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  Surfel s;
  s.P = (corners[0] + corners[1] + corners[2]) / 3, s.N = cross.normalized(), s.area = cross.length() / 2;
  s.U = (corners[1] - corners[0]).normalized();
  s.halfU = s.halfV = 0;
  const V3f V = s.N.cross(s.U);
  for (const V3f& corner : corners) {
    const V3f d = corner - s.P;
    s.halfU = std::max(s.halfU, std::abs(d.dot(s.U))), s.halfV = std::max(s.halfV, std::abs(d.dot(V)));
    s.radius = std::max(s.radius, d.length());
  }
  s.triangle = {(corners[0] - s.P).dot(s.U), (corners[1] - s.P).dot(s.U), (corners[0] - s.P).dot(V)};
  s.front = s.back = Rgb(1);
  return s;
}

/// A triangle in n x n equal ones.
std::vector<Surfel> trianglePieces(const std::array<V3f, 3>& corners, int n) {
  std::vector<Surfel> pieces;
  const V3f u = (corners[1] - corners[0]) / static_cast<float>(n),
            v = (corners[2] - corners[0]) / static_cast<float>(n);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n - j; ++i) {
      const V3f P = corners[0] + u * static_cast<float>(i) + v * static_cast<float>(j);
      pieces.push_back(trianglePiece({P, P + u, P + v}));
      if (i + j + 1 < n) pieces.push_back(trianglePiece({P + u + v, P + v, P + u}));
    }
  return pieces;
}

TEST(PointRaster, FewPiecesOfATriangleAreNoLarger) {
  // Lambert's formula: half the sum over sides of the angle times the cosine of the plane through them.
  const std::array<V3f, 3> corners{V3f(-0.7f, -0.3f, 0.9f), V3f(0.8f, -0.5f, 1.4f), V3f(0.2f, 1.1f, 0.6f)};
  double irradiance = 0;
  for (size_t k = 0; k < 3; ++k) {
    const V3d a = V3d(corners[k]).normalized(), b = V3d(corners[(k + 1) % 3]).normalized();
    irradiance += std::acos(a.dot(b)) * a.cross(b).normalized().z / 2;
  }
  for (const bool around : {false, true}) {  // either side is the front
    const std::array<V3f, 3> turned{corners[0], corners[2], corners[1]};
    for (const int n : {1, 2, 4, 16, 64})
      EXPECT_NEAR(mean(trianglePieces(around ? turned : corners, n), {0, 0, 0}, {0, 0, 1}).irradiance.x,
                  irradiance, 0.03 * irradiance)
          << n << ' ' << around;
  }
}

TEST(PointRaster, LightOfOneLampChangesWithinItsDistance) {
  // However little of the view it fills: interpolation asks how far away what shines is.
  std::vector<Surfel> lamp;
  addQuad(lamp, {-0.05f, -0.05f, 0.5f}, {0, 0.1f, 0}, {0.1f, 0, 0}, 8, Rgb(1));
  const auto seen = PointRaster({}).gather(PointTree(lamp), {0, 0, 0}, {0, 0, 1}, 0, 1e-4f, {});
  EXPECT_LT(seen.covered, 0.05f);
  EXPECT_NEAR(seen.inverseDistance, 2, 0.05f);
  // Below an even sky that is all there is, it hardly counts.
  const auto below = PointRaster({}).gather(PointTree(lamp), {0, 0, 0}, {0, 0, 1}, 0, 1e-4f, white());
  EXPECT_LT(below.inverseDistance, 0.2f);
}

TEST(PointRaster, RadianceIsLinearInAWall) {
  // A wall beside the place that gets brighter upwards: its mean alone would be much too bright.
  std::vector<Surfel> wall;
  addQuad(wall, {0.5f, -4, 0}, {0, 0, 4}, {0, 8, 0}, 128, Rgb(1), Rgb(1));
  for (Surfel& s : wall) s.front = s.back = Rgb(s.P.z, 4 - s.P.z, 0);
  const auto at = [&](float most, int resolution) {
    return mean(wall, {0, 0, 0}, {0, 0, 1}, {resolution, most}).irradiance;
  };
  const Rgb truth = at(1e-4f, 16), seen = at(1, 16);
  for (int c = 0; c < 2; ++c) EXPECT_NEAR(seen[c], truth[c], 0.02f * truth[c]);
}

TEST(PointRaster, WhatIsNearHidesWhatIsFar) {
  // A black screen before a white wall, each of them by one square; and the other way about.
  for (const bool screenIsNear : {true, false}) {
    std::vector<Surfel> surfels;
    addQuad(surfels, {-4, -4, 2}, {0, 8, 0}, {8, 0, 0}, 64, Rgb(screenIsNear ? 1 : 0));
    addQuad(surfels, {-2, -2, 1}, {0, 4, 0}, {4, 0, 0}, 64, Rgb(screenIsNear ? 0 : 1));
    const auto e = mean(surfels, {0, 0, 0}, {0, 0, 1});
    const float root = std::sqrt(5.0f), F = 4 * (2 / root * std::atan(2 / root)) / kPi;
    EXPECT_NEAR(e.irradiance.x / kPi, screenIsNear ? 0 : F, 0.02f);
    EXPECT_NEAR(e.covered, F, 0.02f);
  }
}

TEST(PointRaster, SmallerAnglesAreBetter) {
  // A ball with a white and a black half, at a distance where nodes of it show both.
  std::vector<Surfel> ball = sphere({0, 0, 3}, 1, 20000, Rgb(1), false, false);
  for (Surfel& s : ball)
    if (s.P.x < 0) s.front = Rgb(0);
  // The exact irradiance: of stratified directions with density cos / pi those that meet the white half.
  const V3f P(0.5f, 0, 0), center(0, 0, 3);
  constexpr uint32_t kDirections = 1 << 20;
  uint32_t white = 0;
  for (uint32_t k = 0; k < kDirections; ++k) {
    const V3f d = sampleCosineHemisphere(sobol2(k, 1)), to = center - P;
    const float along = to.dot(d), inside = 1 - (to.length2() - along * along);
    if (inside > 0 && (P + d * (along - std::sqrt(inside))).x >= 0) ++white;
  }
  const float truth = kPi * static_cast<float>(white) / kDirections;
  const auto errorAt = [&](float angle, int resolution) {
    return std::abs(mean(ball, P, {0, 0, 1}, {resolution, angle}).irradiance.x - truth) / truth;
  };
  const float coarse = errorAt(2, 4), middle = errorAt(0.25f, 16), fine = errorAt(0.01f, 64);
  EXPECT_LT(fine, 0.03f);
  EXPECT_LT(middle, 0.03f);
  EXPECT_LT(coarse, 0.3f);
  EXPECT_LT(fine, coarse);
}

TEST(PointRaster, TheHorizonCutsWhatReachesBelow) {
  // A wall that goes from below the floor to far up covers half of what a floor sees.
  std::vector<Surfel> wall;
  addQuad(wall, {0.05f, -50, -50}, {0, 0, 100}, {0, 100, 0}, 200, Rgb(0), Rgb(0));
  std::vector<Surfel> lit;
  addQuad(lit, {0.05f, -50, -50}, {0, 0, 100}, {0, 100, 0}, 200, Rgb(1), Rgb(1));
  EXPECT_NEAR(mean(wall, {0, 0, 0}, {0, 0, 1}, {}, white()).irradiance.x, kPi / 2, 0.05f);
  EXPECT_NEAR(mean(lit, {0, 0, 0}, {0, 0, 1}).irradiance.x, kPi / 2, 0.05f);
}

TEST(PointRaster, InnerSidesLookAsOuterOnesFromOutside) {
  // The place is behind a disc of its own surface, as on a rough one: a black back would be an artefact.
  Surfel disc;
  disc.P = {0, 0, 0.3f}, disc.N = {0, 0, 1};
  disc.radius = 1, disc.area = kPi;
  disc.front = {1, 1, 1}, disc.back = {0, 0, 0};
  disc.inner = Surfel::Inner::Back, disc.owner = 7;
  std::vector<Surfel> far;  // and a node of its own
  for (int k = 0; k < 16; ++k) {
    Surfel s = disc;
    s.P = {0.1f * static_cast<float>(k % 4), 0.1f * static_cast<float>(k / 4), 20}, s.radius = 0.2f,
    s.area = 0.04f;
    s.N = normalizedOr(V3f(0.3f * static_cast<float>(k % 3 - 1), 0.2f, 1), V3f(0, 0, 1));
    far.push_back(s);
  }
  for (const std::vector<Surfel>& surfels : {std::vector<Surfel>{disc}, far}) {
    const PointTree tree(surfels);
    SurfelView view;
    PointRaster raster({});
    const auto from = [&](uint32_t outside, SurfelView* to) {
      return raster.gather(tree, {0, 0, 0}, {0, 0, 1}, 0.3f, 1e-4f, {}, true, outside, to).irradiance.x;
    };
    const auto seen = raster.gather(tree, {0, 0, 0}, {0, 0, 1}, 0.3f, 1e-4f, {}, true, 7);
    EXPECT_GT(seen.covered, 1e-5f);
    for (const uint32_t other : {Surfel::kNobody, 6u})  // harmonics ring
      EXPECT_LT(from(other, nullptr), 0.1f * seen.irradiance.x) << other;
    EXPECT_NEAR(seen.irradiance.x, kPi * seen.covered, 1e-3f * seen.irradiance.x);
    EXPECT_NEAR(from(7, &view), seen.irradiance.x, 1e-3f * seen.irradiance.x);
  }
}

}  // namespace
}  // namespace patina
