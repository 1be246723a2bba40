// SPDX-License-Identifier: Apache-2.0
// Warps of the unit square: chi-square tests of their densities.
#include "tests/unit/chi_square.h"

namespace patina::test {
namespace {

/// Counts of points of the unit square, which should be even, in 16 x 16 cells.
void fitSquare(Fits& fits, const std::string& name, const std::function<V2f(Independent&)>& sample) {
  constexpr size_t kSide = 16;
  std::vector<double> counts(kSide * kSide);
  Independent random(seedOf(name));
  const auto cell = [](float x) {
    EXPECT_TRUE(x >= -1e-6f && x <= 1 + 1e-6f) << x;
    return std::min(static_cast<size_t>(std::max(x, 0.0f) * kSide), kSide - 1);
  };
  for (uint32_t k = 0; k < kChiSquareSamples; ++k) {
    const V2f p = sample(random);
    ++counts[cell(p.y) * kSide + cell(p.x)];
  }
  fits.add(name, std::move(counts), std::vector<double>(kSide * kSide, 1.0 / (kSide * kSide)));
}

TEST(WarpsChiSquare, EveryWarpHasItsDensity) {
  Fits fits;
  fitSquare(fits, "hashed numbers", [](Independent& random) { return random.next2(); });
  // Uniform in area: the square of the radius and the angle are uniform, and independent.
  fitSquare(fits, "disk", [](Independent& random) {
    const V2f d = sampleDisk(random.next2());
    return V2f(d.length2(), std::atan2(d.y, d.x) / (2 * kPi) + 0.5f);
  });
  // Of the weights of a uniform point of a triangle, (1 - b)^2 is uniform, and so is how the rest is shared.
  fitSquare(fits, "triangle", [](Independent& random) {
    const V2f b = sampleTriangle(random.next2());
    return V2f((1 - b.x) * (1 - b.x), std::clamp(b.y / (1 - b.x), 0.0f, 1.0f));
  });
  for (const V3f& normal : {V3f(0, 0, 1), V3f(0, 0, -1), V3f(0.48f, -0.6f, 0.64f)}) {
    const Frame frame(normal);
    // Two axes of the grid, as a density that depends on the angle to its own axis alone cannot turn wrong.
    for (const V3f& axis : {normal, V3f(0.6f, 0, 0.8f)})
      fitDirections(
          fits, "cosine hemisphere " + std::to_string(normal.x) + std::to_string(normal.z + axis.x),
          SphereGrid::even(axis),
          [&](Independent& random) {
            return std::optional(frame.toWorld(sampleCosineHemisphere(random.next2())));
          },
          [&](const V3f& w) { return std::max(w.dot(normal), 0.0f) * kInvPi; });
  }
}

// Why the tests draw independent numbers: stratified ones hit each cell as often as expected, and a statistic
// that is nearly zero has p = 1, whatever is wrong within the cells.
TEST(WarpsChiSquare, StratifiedPointsAreTooEvenToBeJudged) {
  constexpr size_t kSide = 16, kSamples = 1 << 12;
  std::vector<double> counts(kSide * kSide);
  for (uint32_t k = 0; k < kSamples; ++k) {
    const V2f p = sobol2(k, 3);
    ++counts[static_cast<size_t>(p.y * kSide) * kSide + static_cast<size_t>(p.x * kSide)];
  }
  for (const double count : counts) EXPECT_EQ(count, kSamples / (kSide * kSide));
}

}  // namespace
}  // namespace patina::test
