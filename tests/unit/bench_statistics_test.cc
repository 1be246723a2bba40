// SPDX-License-Identifier: Apache-2.0
// Errors of pictures, Student's and Welch's tests, blocks, and time at equal error.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "tools/patina-bench/compare.h"
#include "tools/patina-bench/statistics.h"

namespace patina::bench {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;

ImageData picture(int width, int height, std::vector<float> pixels) {
  return {width, height, 3, {"R", "G", "B"}, false, std::move(pixels)};
}

TEST(BenchErrors, AreThoseOfTheDefinition) {
  const ImageData reference = picture(2, 1, {0, 0.5f, 1, 0, 0.5f, 1});
  const ImageData same = reference, other = picture(2, 1, {0.1f, 0.5f, 1, 0, 0.5f, 2});
  EXPECT_EQ(imageErrors(same, reference).relMse, 0);
  const ImageErrors e = imageErrors(other, reference);
  // 0.1^2 / 0.01 = 1 and 1 / 1.01, of six values.
  EXPECT_NEAR(e.relMse, (1 + 1 / 1.01) / 6, 1e-7);
  EXPECT_THAT(e.meanError, ElementsAre(DoubleNear(0.05, 1e-8), 0, 0.5));
  EXPECT_THAT(e.meanReference, ElementsAre(0, 0.5, 1));
}

TEST(BenchErrors, PercentileLeavesTheWorstHundredthAway) {
  ImageData reference = picture(100, 1, std::vector<float>(300, 0)), noisy = reference;
  for (size_t i = 0; i < 300; ++i) noisy.pixels[i] = static_cast<float>(i) * 1e-3f;
  // 297 of 300 values are smaller or equal; black is divided by 0.1.
  EXPECT_NEAR(imageErrors(noisy, reference).percentile99, 2.96, 1e-5);
}

TEST(BenchErrors, RefusesOtherSizesAndWhatIsNotFinite) {
  const ImageData a = picture(2, 1, std::vector<float>(6)), b = picture(1, 2, std::vector<float>(6));
  EXPECT_THROW(imageErrors(a, b), std::runtime_error);
  ImageData wrong = a;
  wrong.pixels[4] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(imageErrors(wrong, a), std::runtime_error);
}

// Two-sided critical values from Student's table: t(0.975; 10) = 2.228, t(0.995; 4) = 4.604, t(0.95; 1)
// = 6.314.
TEST(BenchTests, StudentsTails) {
  EXPECT_NEAR(studentTails(2.22814, 10), 0.05, 1e-5);
  EXPECT_NEAR(studentTails(-4.60409, 4), 0.01, 1e-6);
  EXPECT_NEAR(studentTails(6.31375, 1), 0.10, 1e-5);
  EXPECT_EQ(studentTails(0, 7), 1);
}

// An example of which t, degrees of freedom and p are known: -2.46, 25.0 and 0.021.
TEST(BenchTests, WelchOnKnownData) {
  const std::vector<double> a = {27.5, 21.0, 19.0, 23.6, 17.0, 17.9, 16.9, 20.1,
                                 21.9, 22.6, 23.1, 19.6, 19.0, 21.7, 21.4},
                            b = {27.1, 22.0, 20.8, 23.4, 23.4, 23.5, 25.8, 22.0,
                                 24.8, 20.2, 21.9, 22.1, 22.9, 20.5, 24.4};
  const TTest test = welchTest(summarize(a), summarize(b));
  EXPECT_NEAR(summarize(a).mean, 20.82, 1e-9);
  EXPECT_NEAR(test.t, -2.46, 5e-3);
  EXPECT_NEAR(test.freedom, 25.0, 0.05);
  EXPECT_NEAR(test.p, 0.021, 5e-4);
}

TEST(BenchTests, WithoutVarianceMeansDifferOrNot) {
  const std::vector<double> one = {1, 1}, two = {2, 2};
  EXPECT_EQ(welchTest(summarize(one), summarize(one)).p, 1);
  EXPECT_EQ(welchTest(summarize(one), summarize(two)).p, 0);
  EXPECT_EQ(welchTest(summarize(std::vector<double>{1}), summarize(two)).p, 1);  // nothing can be said
}

// Student's own example (1908): extra hours of sleep by one drug over another, t = 4.06, nine degrees of
// freedom.
TEST(BenchTests, StudentOnHisPairs) {
  const std::vector<double> more = {1.2, 2.4, 1.3, 1.3, 0, 1.0, 1.8, 0.8, 4.6, 1.4};
  const TTest test = studentTest(summarize(more));
  EXPECT_NEAR(test.t, 4.06, 5e-3);
  EXPECT_EQ(test.freedom, 9);
  EXPECT_NEAR(test.p, 0.0028, 5e-5);
  EXPECT_EQ(studentTest(summarize(std::vector<double>{1})).p, 1);
  EXPECT_EQ(studentTest(summarize(std::vector<double>{0, 0})).p, 1);
  EXPECT_EQ(studentTest(summarize(std::vector<double>{1, 1})).p, 0);
}

TEST(BenchTests, SidakHoldsTheWhole) {
  EXPECT_NEAR(1 - std::pow(1 - sidak(0.01, 768), 768), 0.01, 1e-12);
  EXPECT_EQ(sidak(0.01, 1), -std::expm1(std::log1p(-0.01)));
}

TEST(BenchBlocks, HoldWhatIsLeftAtTheEdges) {
  ImageData p = picture(3, 2, std::vector<float>(18));
  for (size_t i = 0; i < 18; ++i)
    p.pixels[i] = static_cast<float>(i % 3 == 0 ? i / 3 : 0);  // red: 0 1 2 / 3 4 5
  EXPECT_THAT(blockMeans(p, 2), ElementsAre(2, 0, 0, 3.5, 0, 0));
}

std::vector<std::vector<double>> noise(unsigned seed, double shift) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(1, 0.1);
  std::vector<std::vector<double>> pictures(12, std::vector<double>(300));
  for (auto& p : pictures)
    for (double& v : p) v = normal(random);
  for (auto& p : pictures) p[42] += shift;
  return pictures;
}

TEST(BenchAgreement, TellsABlockFromNoise) {
  const Agreement same = compareBlocks(noise(1, 0), noise(2, 0));
  EXPECT_EQ(same.blocks, 100u);
  EXPECT_EQ(same.differing, 0u);
  EXPECT_LT(same.largestT, 6);
  // Ten standard errors: sqrt(2 / 12) * 0.1 * 10.
  const Agreement other = compareBlocks(noise(1, 0), noise(2, 0.41));
  EXPECT_EQ(other.differing, 1u);
  EXPECT_GT(other.largestT, 6);
  EXPECT_THROW(compareBlocks(noise(1, 0), std::vector<std::vector<double>>(1)), std::runtime_error);
}

TEST(BenchEqualError, InterpolatesBetweenLogarithms) {
  const std::vector<CurvePoint> points = {
      {100, 1e-4}, {1, 1e-2}, {10, 1e-3}, {20, 2e-3}};  // the last is beaten
  const auto at = [&](double error) { return secondsAtError(points, error); };
  EXPECT_EQ(lowerEnvelope(points).size(), 3u);
  EXPECT_NEAR(at(std::sqrt(1e-5))->seconds, std::sqrt(10), 1e-9);
  EXPECT_EQ(at(1e-3)->seconds, 10);
  EXPECT_EQ(at(1e-3)->kind, EqualError::Interpolated);
  EXPECT_EQ(at(1)->kind, EqualError::AtMost);
  EXPECT_EQ(at(1)->seconds, 1);
  EXPECT_EQ(at(5e-5)->kind, EqualError::Extrapolated);
  EXPECT_NEAR(at(5e-5)->seconds, 200, 1e-9);
  EXPECT_FALSE(at(1e-6).has_value());  // 100 times the time
}

TEST(BenchEqualError, OneSettingFallsAsTheInverseOfTime) {
  EXPECT_NEAR(secondsAtError({{2, 1e-2}}, 5e-3)->seconds, 4, 1e-12);
  EXPECT_FALSE(secondsAtError({}, 1e-2).has_value());
  EXPECT_FALSE(secondsAtError({{0, 1}, {1, 0}, {1, std::nan("")}}, 1e-2).has_value());
}

// A bias that no time lowers is not reached.
TEST(BenchEqualError, DoesNotPromiseWhatIsNotThere) {
  EXPECT_FALSE(secondsAtError({{1, 1.01e-3}, {50, 1e-3}}, 3e-4).has_value());
}

}  // namespace
}  // namespace patina::bench
