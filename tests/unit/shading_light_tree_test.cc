// SPDX-License-Identifier: Apache-2.0
// The hierarchy of lights: its chances, its picks, and how well it tells which light matters.
#include "renderer/shading/light_tree.h"

#include <numeric>

#include "tests/unit/chi_square.h"

namespace patina::test {
namespace {

V3f directionOf(Independent& random) {
  const float z = 2 * random.next() - 1, r = std::sqrt(1 - z * z), phi = 2 * kPi * random.next();
  return {r * std::cos(phi), r * std::sin(phi), z};
}

LightBounds pointLight(const V3f& at, float strength) {
  LightBounds light;
  light.box = Box3f(at);
  light.power = 4 * kPi * strength;
  return light;
}

/// A square about a point, of half the width `half`.
LightBounds panel(const V3f& at, const V3f& normal, float half, float strength) {
  const Frame frame(normal);
  LightBounds light = pointLight(at, strength);
  for (const float x : {-half, half})
    for (const float y : {-half, half}) light.box.extendBy(at + frame.x * x + frame.y * y);
  light.cone = {normal, 0, kPi / 2};
  light.power = kPi * strength;
  return light;
}

LightBounds spot(const V3f& at, const V3f& axis, float cone, float strength) {
  LightBounds light = pointLight(at, strength);
  light.cone = {axis, cone, 0};
  light.power = 2 * kPi * (1 - std::cos(cone)) * strength;
  return light;
}

LightBounds sun(float strength) {
  LightBounds light;
  light.power = strength;
  return light;
}

/// Lights of all kinds in a cube of size 20.
std::vector<LightBounds> mixed(size_t n, uint64_t seed, int suns = 0) {
  Independent random(seed);
  std::vector<LightBounds> lights;
  for (size_t k = 0; k < n; ++k) {
    const float x = random.next(), y = random.next();
    const V3f at = V3f(x, y, random.next()) * 20 - V3f(10, 10, 10), d = directionOf(random);
    const float strength = 0.1f + 3 * random.next();
    switch (k % 4) {
      case 0:
        lights.push_back(pointLight(at, strength));
        break;
      case 1:
        lights.push_back(panel(at, d, 0.5f * random.next(), strength));
        break;
      case 2:
        lights.push_back(spot(at, d, 0.2f + random.next(), strength));
        break;
      default:
        lights.push_back(panel(at, d, 0.1f, strength));
        lights.back().twoSided = true;
    }
  }
  for (int k = 0; k < suns; ++k)
    lights.insert(lights.begin() + k * 3, sun(0.01f * static_cast<float>(k + 1)));
  return lights;
}

LightReceiver receiverIn(Independent& random, float size) {
  LightReceiver at;
  const float x = random.next(), y = random.next();
  at.P = (V3f(x, y, random.next()) * 2 - V3f(1, 1, 1)) * size;
  at.normal = directionOf(random);
  at.bothSides = random.next() < 0.3f;
  if (random.next() < 0.1f) at.normal = V3f(0, 0, 0);
  return at;
}

std::vector<float> chances(const LightTree& tree, const LightReceiver& at) {
  std::vector<float> all;
  for (uint32_t k = 0; k < tree.lights(); ++k) all.push_back(tree.chanceOf(at, k));
  return all;
}

TEST(LightTree, ChancesAddUpToOne) {
  Independent random(1);
  for (const size_t n : {1, 2, 3, 4, 5, 9, 60, 500})
    for (const int suns : {0, 1, 3}) {
      if (n < static_cast<size_t>(3 * suns)) continue;
      const LightTree tree(mixed(n, n, suns));
      ASSERT_EQ(tree.lights(), n + static_cast<size_t>(suns));
      for (int k = 0; k < 200; ++k) {
        const std::vector<float> all = chances(tree, receiverIn(random, k % 2 ? 12.0f : 100.0f));
        EXPECT_NEAR(std::accumulate(all.begin(), all.end(), 0.0), 1, 2e-6);
      }
    }
}

TEST(LightTree, PicksAsOftenAsItSays) {
  Fits fits;
  int number = 0;
  for (const auto& [n, suns] : {std::pair<size_t, int>{3, 0}, {40, 0}, {40, 2}, {300, 1}}) {
    const LightTree tree(mixed(n, 7 * n, suns));
    Independent random(n);
    for (int k = 0; k < 3; ++k) {
      LightReceiver at;
      std::vector<float> chance;
      do {  // a point for which there is something to choose
        at = receiverIn(random, 12);
        chance = chances(tree, at);
      } while (std::ranges::count_if(chance, [](float c) { return c > 0.01f; }) < 2);
      std::vector<double> counts(chance.size());
      for (uint32_t i = 0; i < kChiSquareSamples; ++i) {
        const LightTree::Pick pick = tree.pick(at, random.next());
        ASSERT_EQ(pick.chance, chance[pick.light]);
        ++counts[pick.light];
      }
      fits.add("lights " + std::to_string(number++), counts, {chance.begin(), chance.end()});
    }
  }
}

/// All at once as one by one, but for numbers on the very edges between lights.
TEST(LightTree, ManyPicksAreThoseOfSingleOnes) {
  Independent random(17);
  for (const auto& [n, suns] : {std::pair<size_t, int>{2, 0}, {40, 0}, {40, 2}, {300, 1}, {9, 3}}) {
    const LightTree tree(mixed(n, 5 * n, suns));
    std::vector<LightTree::Picks> picks;
    for (int k = 0; k < 200; ++k) {
      const LightReceiver at = receiverIn(random, 12);
      constexpr uint32_t kPicks = 64;
      const float u = random.next();
      tree.pickMany(at, kPicks, u, picks);
      std::vector<int> counts(tree.lights());
      uint32_t all = 0;
      for (const LightTree::Picks& p : picks) {
        EXPECT_NEAR(p.chance / tree.chanceOf(at, p.light), 1, 1e-5);
        EXPECT_EQ(counts[p.light], 0);
        // As even as can be.
        EXPECT_LT(std::abs(static_cast<float>(p.count) - kPicks * p.chance), 1.001f);
        counts[p.light] = static_cast<int>(p.count), all += p.count;
      }
      EXPECT_EQ(all, kPicks);
      for (uint32_t i = 0; i < kPicks; ++i)
        --counts[tree.pick(at, (static_cast<float>(i) + u) / kPicks).light];
      int different = 0;
      for (const int count : counts) different += std::abs(count);
      EXPECT_LE(different, 2);
    }
  }
}

/// A point light behind the surface is of no use, and a panel that looks away; but what may just reach the
/// point is not left out. The light that bounds stand for is sampled.
TEST(LightTree, NoLightThatReachesThePointIsLeftOut) {
  Independent random(5);
  int unreached = 0, reached = 0;
  for (int scene = 0; scene < 60; ++scene) {
    const std::vector<LightBounds> lights = mixed(scene < 30 ? 4 : 48, 100 + static_cast<uint64_t>(scene));
    const LightTree tree(lights);
    for (int k = 0; k < 60; ++k) {
      const LightReceiver at = receiverIn(random, 11);
      const std::vector<float> chance = chances(tree, at);
      for (uint32_t i = 0; i < lights.size(); ++i) {
        const LightBounds& light = lights[i];
        double most = 0;
        for (int sample = 0; sample < 20; ++sample) {
          const V3f size = light.box.size();
          const float x = random.next(), y = random.next(), z = random.next();
          const V3f d = at.P - (light.box.min + V3f(x * size.x, y * size.y, z * size.z)), w = d.normalized();
          const float facing = isBlack(at.normal) ? 1
                               : at.bothSides     ? std::abs(at.normal.dot(w))
                                                  : -at.normal.dot(w);
          const float along = light.twoSided ? std::abs(light.cone.axis.dot(w)) : light.cone.axis.dot(w);
          const float edge = std::cos(std::min(light.cone.spread + light.cone.beyond, kPi));
          if (along > edge && facing > 0) most = std::max(most, static_cast<double>(facing / d.length2()));
        }
        if (most > 0) {
          ++reached;
          EXPECT_GT(chance[i], 0) << "light " << i << " gives " << most;
        } else {
          unreached += chance[i] == 0;
        }
      }
    }
  }
  EXPECT_GT(reached, 20000);
  EXPECT_GT(unreached, 20000);  // and those are no waste of samples
}

TEST(LightTree, ImportanceFallsWithTheSquareOfTheDistance) {
  const LightBounds lamp = pointLight({1, 2, 3}, 5);
  for (const float distance : {0.01f, 1.0f, 7.0f, 1e3f, 1e9f, 1e15f}) {
    const LightReceiver at{V3f(1, 2, 3) + V3f(0, distance, 0), {0, -1, 0}};
    const double d = static_cast<double>(at.P.y) - 2;
    EXPECT_NEAR(LightTree::importance(lamp, at) * d * d / 5, 1, 1e-5) << distance;
  }
  // By the cosines of both, too, where the light is small.
  const LightBounds square = panel({0, 0, 0}, {0, 0, 1}, 1e-4f, 2);
  const float a = std::sqrt(0.5f);
  EXPECT_NEAR(LightTree::importance(square, {{3, 0, 3}, {-a, 0, -a}}), 2 / 18.0 * 0.7071, 1e-4);
  EXPECT_NEAR(LightTree::importance(square, {{3, 0, 3}, {-1, 0, 0}}), 2 / 18.0 * 0.5, 1e-4);
  EXPECT_EQ(LightTree::importance(square, {{3, 0, 3}, {1, 0, 0}}), 0);
  EXPECT_EQ(LightTree::importance(square, {{3, 0, -3}, {-1, 0, 0}}), 0);
  EXPECT_NEAR(LightTree::importance(square, {{3, 0, 3}, {1, 0, 0}, true}), 2 / 18.0 * 0.5, 1e-4);
  EXPECT_NEAR(LightTree::importance(sun(3), {{3, 0, -3}, {-1, 0, 0}}), 3, 1e-6);
}

TEST(LightTree, OneLightIsCertain) {
  for (const LightBounds& light : {pointLight({0, 0, 0}, 0), panel({0, 0, 0}, {0, 0, 1}, 1, 1), sun(0),
                                   pointLight({kInfinity, 0, 0}, 1)}) {
    const LightTree tree(std::span(&light, 1));
    const LightReceiver behind{{0, 0, -1}, {0, 0, 1}};
    EXPECT_EQ(tree.pick(behind, 0.7f).chance, 1);
    EXPECT_EQ(tree.chanceOf(behind, 0), 1);
  }
}

TEST(LightTree, MakesTheBestOfOddNumbers) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), huge = 3e38f;
  std::vector<LightBounds> lights = mixed(20, 3);
  for (const float s : {0.0f, -1.0f, nan, kInfinity, 1e-38f, huge}) {
    lights.push_back(pointLight({1, 1, 1}, s));
    lights.push_back(sun(s));
  }
  for (const float p : {nan, kInfinity, -kInfinity, huge, 1e17f, -1e17f})
    lights.push_back(pointLight({p, 0, p}, 1));
  for (int k = 0; k < 50; ++k) lights.push_back(pointLight({2, 2, 2}, 1));  // in one place
  LightBounds everywhere = pointLight({-1e17f, -1e17f, -1e17f}, 1);
  everywhere.box.extendBy(V3f(1e17f, 1e17f, 1e17f));
  lights.push_back(everywhere);
  const LightTree tree(lights);
  Independent random(9);
  std::vector<LightReceiver> points{{{2, 2, 2}, {0, 0, 1}},          {{0, 0, 0}, {0, 0, 0}},
                                    {{huge, huge, huge}, {0, 1, 0}}, {{nan, 0, 0}, {0, 1, 0}},
                                    {{1, 0, 0}, {nan, nan, nan}},    {{kInfinity, 0, 0}, {0, 1, 0}}};
  for (int k = 0; k < 20; ++k) points.push_back(receiverIn(random, 10));
  for (const LightReceiver& at : points) {
    const std::vector<float> all = chances(tree, at);
    EXPECT_NEAR(std::accumulate(all.begin(), all.end(), 0.0), 1, 1e-5);
    for (int k = 0; k < 500; ++k) {
      const LightTree::Pick pick = tree.pick(at, k == 0 ? 0 : k == 1 ? kOneMinusEpsilon : random.next());
      ASSERT_LT(pick.light, lights.size());
      EXPECT_EQ(pick.chance, all[pick.light]);
      EXPECT_GT(pick.chance, 0);
    }
  }
  EXPECT_EQ(LightTree(std::span<const LightBounds>()).lights(), 0u);
}

TEST(LightTree, IsTheSameEachTime) {
  const std::vector<LightBounds> lights = mixed(1000, 11, 4);
  EXPECT_EQ(LightTree(lights), LightTree(lights));
  EXPECT_LT(LightTree(lights).nodes(), lights.size());
}

/// Bounds of a group hold for all that is in it: cones at random, merged.
TEST(LightCone, MergedHoldsBoth) {
  Independent random(21);
  for (int k = 0; k < 20000; ++k) {
    LightCone cones[2];
    for (LightCone& c : cones) {
      const float x = random.next();
      c = {directionOf(random), kPi * x * x, kPi * random.next()};
    }
    if (k % 5 == 0) cones[1].axis = (cones[0].axis + directionOf(random) * 1e-4f).normalized();
    if (k % 5 == 1) cones[1].axis = -cones[0].axis;
    const LightCone both = LightCone::merged(cones[0], cones[1]);
    for (const LightCone& c : cones) {
      EXPECT_GE(both.beyond, c.beyond);
      const V3d a(both.axis), b(c.axis);
      const double between = std::atan2(a.cross(b).length(), a.dot(b));
      EXPECT_GE(static_cast<double>(both.spread) + 2e-6,
                std::min(between + static_cast<double>(c.spread), std::numbers::pi));
    }
    EXPECT_LE(both.spread, kPi);
    EXPECT_NEAR(both.axis.length(), 1, 1e-5);
  }
}

/// What a pick's estimate of the sum of all lights scatters, relative to the sum: its variance over the
/// square, from the chances themselves.
double scatter(std::span<const double> light, std::span<const float> chance) {
  double sum = 0, squares = 0;
  for (size_t k = 0; k < light.size(); ++k) {
    sum += light[k];
    if (light[k] > 0) squares += light[k] * light[k] / static_cast<double>(chance[k]);
  }
  return squares / (sum * sum) - 1;
}

/// 200 lamps along a hall of 100 m, all alike: by power, that is evenly, against the hierarchy. Each point of
/// the floor is lit by few of them.
TEST(LightTree, LampsOfALongHall) {
  std::vector<LightBounds> lights;
  for (int k = 0; k < 100; ++k)
    for (const float x : {-1.5f, 1.5f}) lights.push_back(pointLight({x, 2.8f, static_cast<float>(k)}, 1));
  const LightTree tree(lights);
  const std::vector<float> evenly(lights.size(), 1.0f / static_cast<float>(lights.size()));
  Independent random(31);
  double byTree = 0, byPower = 0;
  constexpr int kPoints = 2000;
  for (int k = 0; k < kPoints; ++k) {
    const float x = random.next();
    const LightReceiver at{{4 * x - 2, 0, 100 * random.next()}, {0, 1, 0}};
    std::vector<double> light;
    for (const LightBounds& l : lights) {
      const V3d d(l.box.min - at.P);
      light.push_back(d.y / std::pow(d.length2(), 1.5));
    }
    const std::vector<float> chance = chances(tree, at);
    byTree += scatter(light, chance) / kPoints;
    byPower += scatter(light, evenly) / kPoints;
    // And it is unbiased: one pick for each of many even numbers gives the sum.
    if (k % 200) continue;
    double mean = 0;
    constexpr int kPicks = 20000;
    for (int i = 0; i < kPicks; ++i) {
      const LightTree::Pick pick = tree.pick(at, (static_cast<float>(i) + 0.5f) / kPicks);
      mean += light[pick.light] / static_cast<double>(pick.chance) / kPicks;
    }
    const double sum = std::accumulate(light.begin(), light.end(), 0.0);
    EXPECT_NEAR(mean, sum, 0.02 * sum);
  }
  RecordProperty("by_tree", std::to_string(byTree));
  RecordProperty("by_power", std::to_string(byPower));
  EXPECT_LT(byTree, byPower / 10);
}

}  // namespace
}  // namespace patina::test
