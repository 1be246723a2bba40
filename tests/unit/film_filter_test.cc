// SPDX-License-Identifier: Apache-2.0
// Pixel filters and the crop rule against the formulas of RI 3.2.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "renderer/film/film.h"

namespace patina {
namespace {

using Kind = PixelFilter::Kind;
constexpr double kPiExact = std::numbers::pi;

TEST(PixelFilter, NamesOfRi) {
  EXPECT_EQ(PixelFilter::fromName("box"), Kind::Box);
  EXPECT_EQ(PixelFilter::fromName("triangle"), Kind::Triangle);
  EXPECT_EQ(PixelFilter::fromName("catmull-rom"), Kind::CatmullRom);
  EXPECT_EQ(PixelFilter::fromName("sinc"), Kind::Sinc);
  EXPECT_EQ(PixelFilter::fromName("gaussian"), Kind::Gaussian);
  EXPECT_EQ(PixelFilter::fromName("mitchell"), std::nullopt);
}

// Each formula as RI 3.2 appendix E prints it (sinc: windowed to reach 0 at the edge of the support), in
// double.
TEST(PixelFilter, FollowsItsFormula) {
  const auto sinc = [](double d, double width) {
    return (d == 0 ? 1 : std::sin(kPiExact * d) / (kPiExact * d)) * std::cos(kPiExact * d / width);
  };
  for (double x = -1.95; x < 2; x += 0.13)
    for (double y = -1.45; y < 1.5; y += 0.17) {
      const double xw = 4, yw = 3, r = std::hypot(x, y);
      const auto weight = [&](Kind kind) {
        return PixelFilter{kind, 4, 3}.weight(static_cast<float>(x), static_cast<float>(y));
      };
      EXPECT_EQ(weight(Kind::Box), 1);
      EXPECT_NEAR(weight(Kind::Triangle), (1 - std::abs(x) / (xw / 2)) * (1 - std::abs(y) / (yw / 2)), 2e-6);
      EXPECT_NEAR(weight(Kind::CatmullRom),
                  r >= 2  ? 0
                  : r < 1 ? 3 * r * r * r - 5 * r * r + 2
                          : -r * r * r + 5 * r * r - 8 * r + 4,
                  4e-6);
      EXPECT_NEAR(weight(Kind::Sinc), sinc(x, xw) * sinc(y, yw), 2e-6);
      EXPECT_NEAR(weight(Kind::Gaussian), std::exp(-2 * (std::pow(2 * x / xw, 2) + std::pow(2 * y / yw, 2))),
                  2e-6);
    }
}

TEST(PixelFilter, SupportIsClosedAtLeftAndTopOnly) {
  const PixelFilter box{Kind::Box, 1, 1};
  EXPECT_EQ(box.weight(-0.5f, -0.5f), 1);
  EXPECT_EQ(box.weight(0.5f, 0), 0);
  EXPECT_EQ(box.weight(0, 0.5f), 0);
  EXPECT_EQ((PixelFilter{Kind::Gaussian, 2, 2}.weight(1.01f, 0)), 0);
}

// RI 3.2, CropWindow: rxmin = clamp(ceil(xres*xmin), 0, xres-1), rxmax = clamp(ceil(xres*xmax - 1), 0,
// xres-1).
TEST(CropWindow, FollowsRi) {
  EXPECT_EQ(cropPixels(640, 480, {0, 1, 0, 1}), (PixelRect{0, 0, 640, 480}));
  EXPECT_EQ(cropPixels(100, 100, {0.25f, 0.75f, 0.5f, 1}), (PixelRect{25, 50, 75, 100}));
  EXPECT_EQ(cropPixels(10, 10, {0.31f, 0.39f, 0, 1}), (PixelRect{4, 0, 4, 10}))
      << "no pixel begins in the window";
  EXPECT_EQ(cropPixels(640, 480, {0.1f, 0.2f, 0, 1}), (PixelRect{64, 0, 128, 480}))
      << "0.1f is a little over 1/10";
}

TEST(CropWindow, TilesShareNoPixelAndLeaveNoneOut) {
  for (const int n : {13, 100, 640, 1921}) {
    int next = 0;
    for (int i = 0; i < 13; ++i) {
      const float a = static_cast<float>(i) / 13.f, b = static_cast<float>(i + 1) / 13.f;
      const PixelRect r = cropPixels(n, 1, {a, i == 12 ? 1.f : b, 0, 1});
      EXPECT_EQ(r.x0, next) << n << " " << i;
      next = r.x1;
    }
    EXPECT_EQ(next, n);
  }
}

}  // namespace
}  // namespace patina
