// SPDX-License-Identifier: Apache-2.0
// Sobol points and warps against what they must be by construction.
#include "renderer/base/sampling.h"
#include "renderer/base/sampling_batch.h"

#include <gtest/gtest.h>

#include <set>

#include "renderer/base/statistics.h"

namespace patina {
namespace {

TEST(Sobol, EveryPowerOfTwoIsStratifiedInEveryElementaryInterval) {
  // A (0, m, 2)-net in base 2: each of the 2^m boxes of size 2^-a by 2^-(m-a) holds exactly one of 2^m
  // points.
  constexpr int m = 8;
  for (const uint64_t seed : {uint64_t{0}, uint64_t{1}, hashOf(3, 4, 5)})
    for (int a = 0; a <= m; ++a) {
      std::set<std::pair<int, int>> boxes;
      for (uint32_t k = 0; k < 1u << m; ++k) {
        const V2f p = sobol2(k, seed);
        ASSERT_GE(std::min(p.x, p.y), 0);
        ASSERT_LT(std::max(p.x, p.y), 1);
        boxes.emplace(static_cast<int>(p.x * static_cast<float>(1 << a)),
                      static_cast<int>(p.y * static_cast<float>(1 << (m - a))));
      }
      EXPECT_EQ(boxes.size(), 1u << m) << "seed " << seed << " split " << a;
    }
}

TEST(Sobol, SeedsGiveIndependentPoints) {
  // Correlation of first coordinates of neighbouring seeds over many seeds: zero within 4 standard errors.
  double sum = 0;
  constexpr int n = 20000;
  for (int k = 0; k < n; ++k)
    sum += (sobol2(0, hashOf(k, 0)).x - 0.5) * (sobol2(0, hashOf(k, 1)).x - 0.5) * 12;
  EXPECT_LT(std::abs(sum / n), 4 / std::sqrt(double{n}));
}

TEST(Warps, CosineHemisphereHasItsMoments) {
  // With density cos/pi: mean of z is 2/3, of z^2 1/2, of x 0.
  double z = 0, zz = 0, x = 0;
  constexpr uint32_t n = 1 << 14;
  for (uint32_t k = 0; k < n; ++k) {
    const V3f d = sampleCosineHemisphere(sobol2(k, 7));
    ASSERT_NEAR(d.length(), 1, 1e-6f);
    z += d.z, zz += d.z * d.z, x += d.x;
  }
  EXPECT_NEAR(z / n, 2.0 / 3, 1e-4);
  EXPECT_NEAR(zz / n, 0.5, 1e-4);
  EXPECT_NEAR(x / n, 0, 1e-3);
}

TEST(Sobol, ManyPointsAreThoseOfOneAtATime) {
  for (const size_t count : {1, 7, 8, 16, 37})
    for (const uint32_t first : {0u, 5u, 4096u, ~0u - 20}) {
      std::vector<V2f> many(count);
      sobolPoints(first, hashOf(count), many);
      for (uint32_t k = 0; k < count; ++k) EXPECT_EQ(many[k], sobol2(first + k, hashOf(count))) << first + k;
    }
}

TEST(Warps, CosineDirectionsAreTheSameManyAtATime) {
  CosineDirections many;
  for (const uint64_t seed : {uint64_t{0}, hashOf(5), hashOf(6)})
    for (const uint32_t first : {0u, 16u, 21u, 4096u, 0x7ffffff5u, ~0u - 15}) {
      many.sample(first, seed);
      for (uint32_t k = 0; k < CosineDirections::kCount; ++k) {
        const V3f one = sampleCosineHemisphere(sobol2(first + k, seed));
        EXPECT_NEAR(many.x[k], one.x, 2e-7f) << first + k;
        EXPECT_NEAR(many.y[k], one.y, 2e-7f) << first + k;
        EXPECT_NEAR(many.z[k] * many.z[k], one.z * one.z, 5e-7f) << first + k;
      }
      for (const uint32_t wanted : {1u, 4u, 5u}) {
        CosineDirections few;
        few.sample(first, seed, wanted);
        for (uint32_t k = 0; k < wanted; ++k) {
          EXPECT_EQ(few.x[k], many.x[k]);
          EXPECT_EQ(few.y[k], many.y[k]);
          EXPECT_EQ(few.z[k], many.z[k]);
        }
      }
    }
}

TEST(Warps, TriangleIsUniform) {
  double b0 = 0, b1 = 0;
  constexpr uint32_t n = 1 << 14;
  for (uint32_t k = 0; k < n; ++k) {
    const V2f b = sampleTriangle(sobol2(k, 9));
    ASSERT_GE(std::min({b.x, b.y, 1 - b.x - b.y}), -1e-6f);
    b0 += b.x, b1 += b.y;
  }
  EXPECT_NEAR(b0 / n, 1.0 / 3, 1e-4);
  EXPECT_NEAR(b1 / n, 1.0 / 3, 1e-4);
}

TEST(Frame, IsOrthonormalAroundEveryNormal) {
  for (uint32_t k = 0; k < 1000; ++k) {
    V3f n = sampleCosineHemisphere(sobol2(k, 11));
    if (k & 1) n = -n;
    const Frame f(n);
    EXPECT_NEAR(f.x.dot(f.y), 0, 1e-6f);
    EXPECT_NEAR(f.x.dot(f.z), 0, 1e-6f);
    EXPECT_NEAR((f.x.cross(f.y) - f.z).length(), 0, 1e-5f);
  }
}

TEST(Vectors, NormalizedOrSurvivesExtremes) {
  EXPECT_EQ(normalizedOr(V3f(0, 0, 0), V3f(1, 0, 0)), V3f(1, 0, 0));
  EXPECT_EQ(normalizedOr(V3f(NAN, 0, 0), V3f(1, 0, 0)), V3f(1, 0, 0));
  for (const float scale : {1e-38f, 1e-20f, 1.0f, 1e20f, 1e38f})
    EXPECT_NEAR(
        (normalizedOr(V3f(scale, scale, 0), V3f(0, 0, 1)) - V3f(0.70710678f, 0.70710678f, 0)).length(), 0,
        1e-6f);
}

TEST(Statistics, CountersAddUpOverThreadsAndPrintAsATree) {
  static StatCounter counter("Test/branch/leaf"), same("Test/branch/leaf");
  resetStatistics();
  counter += 40;
  ++same;
  EXPECT_EQ(counter.total(), 41);
  setStatistic("Test/value", 0.5);
  EXPECT_NE(statisticsTree().find("leaf"), std::string::npos);
  EXPECT_NE(statisticsJson().find("\"leaf\": 41"), std::string::npos);
  resetStatistics();
  EXPECT_EQ(counter.total(), 0);
}

TEST(Statistics, NamesThatThereIsNoRoomForAreCountedTogether) {
  std::vector<StatCounter> many;
  for (int k = 0; k < 5000; ++k) many.emplace_back("Test/many/" + std::to_string(k));
  for (StatCounter& counter : many) ++counter;
  EXPECT_EQ(many[0].total(), 1);
  EXPECT_GT(many.back().total(), 2000);
  EXPECT_NE(statisticsJson().find("no room for\": " + std::to_string(many.back().total())),
            std::string::npos);
}

}  // namespace
}  // namespace patina
