// SPDX-License-Identifier: Apache-2.0
// The standard lights against the formulas of RI 3.2, and of those that are sampled: their densities.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/unit/plugins/bound_shader.h"

namespace patina::test {
namespace {

constexpr double kPi = std::numbers::pi;
const Triple kWarm{1, 0.5f, 0.25f};

Triple scaled(const Triple& c, double f) { return {float(c[0] * f), float(c[1] * f), float(c[2] * f)}; }

// Points on a wavy line around the origin.
Triple pointAt(uint32_t i) { return {0.3f * float(i) - 2, 1.5f - 0.1f * float(i), 2 + 0.05f * float(i)}; }

struct Lit {
  explicit Lit(const BoundShader& shader, uint32_t count = 20) : batch(shader.batch(count)) {
    batch.lightIn.task = PATINA_LIGHT_SAMPLE;
    batch.lightIn.P = batch.varying3(pointAt);
    std::mt19937 random(7);
    std::uniform_real_distribution<float> uniform(0, 1);
    batch.lightIn.random_x = batch.varying([&](uint32_t) { return uniform(random); });
    batch.lightIn.random_y = batch.varying([&](uint32_t) { return uniform(random); });
    out = batch.lightOut();
    EXPECT_EQ(shader->light(batch.lightIn, out), PATINA_OK);
  }
  Batch batch;
  PatinaLightOut out;
};

TEST(StandardLights, Ambient) {
  const BoundShader shader("ambientlight",
                           {number("intensity", 2), triple("lightcolor", ValueType::Color, kWarm)});
  EXPECT_EQ(shader->traits().light_kind, uint32_t(PATINA_LIGHT_AMBIENT));
  EXPECT_TRUE(shader->has(PATINA_TRAIT_UNSHADOWED));
  const Lit lit(shader);
  for (uint32_t i = 0; i < 20; ++i) expectNear(get(lit.out.radiance, i), scaled(kWarm, 2));
}

TEST(StandardLights, PointFallsOffWithTheSquare) {
  const Triple from{1, 2, 3};
  const BoundShader shader("pointlight",
                           {number("intensity", 50), triple("lightcolor", ValueType::Color, kWarm),
                            triple("from", ValueType::Point, from)});
  EXPECT_EQ(shader->traits().light_kind, uint32_t(PATINA_LIGHT_DELTA));
  const Lit lit(shader);
  for (uint32_t i = 0; i < 20; ++i) {
    const Triple p = pointAt(i);
    const double x = double(from[0]) - double(p[0]), y = double(from[1]) - double(p[1]),
                 z = double(from[2]) - double(p[2]);
    const double square = x * x + y * y + z * z, distance = std::sqrt(square);
    expectNear(get(lit.out.radiance, i), scaled(kWarm, 50 / square));
    expectNear(get(lit.out.direction, i), {float(x / distance), float(y / distance), float(z / distance)},
               1e-5f);
    EXPECT_NEAR(lit.out.distance[i], distance, 1e-6 * distance);
  }
}

TEST(StandardLights, PointLightAtItsOwnPlaceGivesNothing) {
  const Triple from = pointAt(0);
  const BoundShader shader("pointlight", {triple("from", ValueType::Point, from)});
  const Lit lit(shader);
  expectNear(get(lit.out.radiance, 0), {0, 0, 0});
  EXPECT_TRUE(std::isfinite(lit.out.direction.x[0]));
}

TEST(StandardLights, SpotFollowsItsConeAndBeam) {
  const double cone = 0.7, delta = 0.3, beam = 3;
  const BoundShader shader("spotlight",
                           {number("intensity", 8), triple("from", ValueType::Point, {0, 0, 0}),
                            triple("to", ValueType::Point, {0, 0, 5}), number("coneangle", float(cone)),
                            number("conedeltaangle", float(delta)), number("beamdistribution", float(beam))});
  const Lit lit(shader);
  int inside = 0, soft = 0;
  for (uint32_t i = 0; i < 20; ++i) {
    const Triple p = pointAt(i);
    const double square = double(p[0]) * p[0] + double(p[1]) * p[1] + double(p[2]) * p[2];
    const double cosangle = p[2] / std::sqrt(square);
    const double x =
        std::clamp((cosangle - std::cos(cone)) / (std::cos(cone - delta) - std::cos(cone)), 0.0, 1.0);
    const double expected = 8 * std::pow(cosangle, beam) / square * x * x * (3 - 2 * x);
    inside += x == 1;
    soft += x > 0 && x < 1;
    // At the edge of the cone, where x is small, the cosine's rounding (6e-8) counts: 8 / square * 6 x * 6e-8
    // / range.
    EXPECT_NEAR(lit.out.radiance.x[i], expected, 1e-5 * expected + 1e-6);
  }
  EXPECT_GT(inside, 2);
  EXPECT_GT(soft, 2);
}

TEST(StandardLights, DistantIsParallelAndDoesNotFallOff) {
  const BoundShader shader("distantlight",
                           {number("intensity", 3), triple("from", ValueType::Point, {0, 2, 0}),
                            triple("to", ValueType::Point, {0, 0, 0})});
  EXPECT_EQ(shader->traits().light_kind, uint32_t(PATINA_LIGHT_DELTA));
  const Lit lit(shader);
  for (uint32_t i = 0; i < 20; ++i) {
    expectNear(get(lit.out.radiance, i), {3, 3, 3});
    expectNear(get(lit.out.direction, i), {0, 1, 0});
    EXPECT_EQ(lit.out.distance[i], PATINA_INFINITE_DISTANCE);
  }
}

class Sun : public testing::TestWithParam<float> {};

// Irradiance on a facing surface is pi Cl; samples lie in the cone, and `evaluate` agrees with `sample` on
// all of them.
TEST_P(Sun, HasTheIrradianceOfAParallelLight) {
  const float angle = GetParam();
  const BoundShader shader("distantlight", {number("intensity", 2), number("angle", angle),
                                            triple("to", ValueType::Point, {1, 2, 3})});
  ASSERT_EQ(shader->traits().light_kind, uint32_t(PATINA_LIGHT_INFINITE));
  constexpr uint32_t kCount = 100000;
  const Lit lit(shader, kCount);
  const double length = std::sqrt(14.0), half = double(angle) / 2 * kPi / 180;
  double irradiance = 0;
  for (uint32_t i = 0; i < kCount; ++i) {
    const Triple d = get(lit.out.direction, i);
    const double cosine = -(d[0] * 1.0 + d[1] * 2.0 + d[2] * 3.0) / length;
    EXPECT_GE(cosine, std::cos(half) - 2e-7);
    irradiance += double(lit.out.radiance.x[i]) * cosine / double(lit.out.pdf[i]) / kCount;
  }
  // The estimator's relative standard deviation is under (1 - cos) / sqrt(12) / mean cos; five sigma and
  // rounding.
  const double spread = (1 - std::cos(half)) / std::sqrt(12.0) * 2 / std::sqrt(double(kCount));
  EXPECT_NEAR(irradiance, 2 * kPi, 2 * kPi * (5 * spread + 2e-6));

  Batch batch = shader.batch(kCount);
  batch.lightIn.task = PATINA_LIGHT_EVALUATE;
  batch.lightIn.P = batch.uniform({0, 0, 0});
  batch.lightIn.direction = batch.varying3([&](uint32_t i) { return get(lit.out.direction, i); });
  PatinaLightOut out = batch.lightOut();
  ASSERT_EQ(shader->light(batch.lightIn, out), PATINA_OK);
  uint32_t outside = 0;
  for (uint32_t i = 0; i < kCount; ++i) {
    outside += out.pdf[i] == 0;
    if (out.pdf[i] > 0) {
      EXPECT_EQ(out.pdf[i], lit.out.pdf[i]);
      EXPECT_EQ(out.radiance.x[i], lit.out.radiance.x[i]);
    }
  }
  EXPECT_LE(outside, kCount / 2000);  // those on the rim, by rounding of unit vectors
}
INSTANTIATE_TEST_SUITE_P(Angles, Sun, testing::Values(0.53f, 5.0f, 90.0f, 180.0f));

TEST(StandardLights, AreaShinesFromItsOutsideOrBoth) {
  for (const int sides : {1, 2}) {
    const BoundShader shader(
        "arealight",
        {number("intensity", 4), triple("lightcolor", ValueType::Color, kWarm), integer("sides", sides)});
    EXPECT_EQ(shader->traits().light_kind, uint32_t(PATINA_LIGHT_AREA));
    EXPECT_EQ(shader->has(PATINA_TRAIT_TWO_SIDED), sides == 2);
    Batch batch = shader.batch(2);
    batch.lightIn.task = PATINA_LIGHT_EMIT;
    batch.lightIn.P = batch.uniform({0, 0, 0});
    batch.lightIn.N = batch.uniform({0, 0, 1});
    batch.lightIn.direction = batch.varying3([](uint32_t i) {
      return Triple{0.6f, 0, i == 0 ? 0.8f : -0.8f};
    });
    PatinaLightOut out = batch.lightOut();
    ASSERT_EQ(shader->light(batch.lightIn, out), PATINA_OK);
    expectNear(get(out.radiance, 0), scaled(kWarm, 4));
    expectNear(get(out.radiance, 1), scaled(kWarm, sides == 2 ? 4 : 0));
  }
}

TEST(StandardLights, EnvironmentIsUniform) {
  const BoundShader shader("envlight",
                           {number("intensity", 2), triple("lightcolor", ValueType::Color, kWarm)});
  EXPECT_EQ(shader->traits().light_kind, uint32_t(PATINA_LIGHT_INFINITE));
  EXPECT_TRUE(shader->has(PATINA_TRAIT_CAMERA_VISIBLE));
  constexpr uint32_t kCount = 20000;
  const Lit lit(shader, kCount);
  Triple sum{};
  for (uint32_t i = 0; i < kCount; ++i) {
    const Triple d = get(lit.out.direction, i);
    EXPECT_NEAR(d[0] * d[0] + d[1] * d[1] + d[2] * d[2], 1, 1e-5);
    EXPECT_NEAR(lit.out.pdf[i], 1 / (4 * kPi), 1e-7);
    expectNear(get(lit.out.radiance, i), scaled(kWarm, 2));
    for (size_t c = 0; c < 3; ++c) sum[c] += d[c] / kCount;
  }
  // Each coordinate has the variance 1/3: five sigma.
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(sum[c], 0, 5 / std::sqrt(3.0 * kCount));
}

TEST(StandardLights, EnvironmentHidesFromTheCamera) {
  EXPECT_FALSE(BoundShader("envlight", {integer("camera", 0)})->has(PATINA_TRAIT_CAMERA_VISIBLE));
}

}  // namespace
}  // namespace patina::test
