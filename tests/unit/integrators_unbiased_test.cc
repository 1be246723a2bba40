// SPDX-License-Identifier: Apache-2.0
// --unbiased: samples of the truth make good what the cache gets wrong; many lights; depths by object.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/integrators_render.h"

namespace patina {
namespace {

constexpr int kSize = 16;

std::vector<Rgb> render(const std::string& world, const RenderSettings& wanted) {
  const std::string rib =
      "Format 16 16 1 PixelFilter \"box\" 1 1 Projection \"perspective\" \"fov\" [50] Translate 0 -1 4 "
      "WorldBegin " +
      world + " WorldEnd";
  return renderPicture(rib, wanted);
}

RenderSettings inMode(const std::string& mode, int samples) {
  RenderSettings settings;
  settings.mode = mode, settings.samples = samples;
  return settings;
}

// Micropolygons so large that the cache is wrong in places: a lamp close to the wall, a thin wall, a shiny
// ball, a half transparent one.
const std::string kRoom =
    "Attribute \"trace\" \"int maxdiffusedepth\" [4] ShadingRate 2 AttributeBegin "
    "AreaLightSource \"arealight\" 1 \"float intensity\" [30] Translate 1.2 1.9 .4 Rotate 90 1 0 0 Disk 0 "
    ".15 360 "
    "AttributeEnd Illuminate 1 1 Surface \"matte\" \"float Kd\" [1] Color [.7 .7 .7] Sides 2 "
    "PointsPolygons [4 4 4 4 4] [0 1 2 3  4 5 6 7  3 2 6 7  0 3 7 4  1 2 6 5] \"P\" [-2 0 -2  2 0 -2  2 0 2  "
    "-2 0 2  "
    "-2 2 -2  2 2 -2  2 2 2  -2 2 2] Color [.8 .3 .2] Polygon \"P\" [-.5 0 .5  -.45 1.4 .5  -.4 1.4 1.9  -.5 "
    "0 1.9] "
    "Surface \"plastic\" \"float roughness\" [.2] Color [.3 .6 .8] TransformBegin Translate .7 .5 .4 Sphere "
    ".5 -.5 .5 360 "
    "TransformEnd Surface \"matte\" Opacity [.5 .6 .7] Color [.4 .4 .2] Translate -1.3 .5 .2 Sphere .4 -.4 "
    ".4 360";

struct Moments {
  std::vector<double> mean, variance;  // of the mean; by block and channel
};

/// Of blocks of 4x4 pixels, over independent pictures.
Moments moments(RenderSettings settings, int pictures) {
  constexpr int kBlock = 4, kBlocks = kSize / kBlock;
  std::vector<double> sum(3 * kBlocks * kBlocks), squares(sum.size());
  for (int seed = 0; seed < pictures; ++seed) {
    settings.seed = seed;
    const std::vector<Rgb> picture = render(kRoom, settings);
    std::vector<double> block(sum.size());
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x)
        for (int c = 0; c < 3; ++c)
          block[static_cast<size_t>(3 * (y / kBlock * kBlocks + x / kBlock) + c)] +=
              static_cast<double>(picture[static_cast<size_t>(y * kSize + x)][c]) / (kBlock * kBlock);
    for (size_t k = 0; k < sum.size(); ++k) sum[k] += block[k], squares[k] += block[k] * block[k];
  }
  Moments m;
  const double n = pictures;
  for (size_t k = 0; k < sum.size(); ++k) {
    m.mean.push_back(sum[k] / n);
    m.variance.push_back((squares[k] / n - sum[k] * sum[k] / (n * n)) / (n - 1));
  }
  return m;
}

/// Number of means that Welch's t-test tells apart at a significance of 0.01 over all of them (Sidak); with
/// the 23 and more degrees of freedom that the pictures give, the bound for 48 values is 4.4.
int differing(const Moments& a, const Moments& b) {
  int count = 0;
  for (size_t k = 0; k < a.mean.size(); ++k)
    count += std::abs(a.mean[k] - b.mean[k]) > 4.4 * std::sqrt(a.variance[k] + b.variance[k]);
  return count;
}

TEST(Unbiased, TheMeanIsThatOfPathMode) {
  constexpr int kPictures = 24;
  const Moments path = moments(inMode("path", 64), kPictures);
  RenderSettings settings = inMode("radiosity", 16);
  settings.rays = 64;
  EXPECT_GT(differing(moments(settings, kPictures), path), 0)
      << "the cache is right anyway: nothing is tested";
  settings.unbiased = true;
  EXPECT_EQ(differing(moments(settings, kPictures), path), 0);
}

TEST(Unbiased, SaysHowWrongTheCacheIs) {
  RenderSettings settings = inMode("radiosity", 4);
  render(kRoom, settings);
  EXPECT_EQ(statistic("Radiosity cache/residual at depth 1/look-ups corrected"), 0);
  settings.unbiased = true;
  render(kRoom, settings);
  EXPECT_GT(statistic("Radiosity cache/residual at depth 1/look-ups corrected"), 100);
  EXPECT_GT(statistic("Radiosity cache/residual at depth 1/mean's standard error, relative"), 0);
}

// 40 lamps of different strength over a floor, of which a screen hides half: each point gets as many shadow
// rays as four lights would, and the mean stays.
TEST(ManyLights, AreChosenByWhatTheyPromise) {
  std::string world = "Surface \"matte\" \"float Kd\" [1] Color [1 1 1] ";
  for (int k = 0; k < 40; ++k) {
    const std::string n = std::to_string(k + 1);
    world += "LightSource \"pointlight\" " + n + " \"float intensity\" [" +
             std::to_string(.02 + .01 * (k % 7)) + "] \"point from\" [" + std::to_string(-2 + .1 * k) + " " +
             std::to_string(.3 + .05 * (k % 5)) + " " + std::to_string(.1 * (k % 11)) + "] ";
  }
  world += "Polygon \"P\" [-3 0 -3  -3 0 3  3 0 3  3 0 -3] Polygon \"P\" [0 .1 -3  0 2 -3  0 2 3  0 .1 3]";
  RenderSettings few = inMode("direct", 4), all = few;
  few.lightSamples = 1, all.lightSamples = 1000;
  const std::vector<Rgb> exact = render(world, all);
  const double allRays = statistic("Rays/transmission");
  const std::vector<Rgb> estimate = render(world, few);
  EXPECT_LT(statistic("Rays/transmission"), 0.2 * allRays);
  EXPECT_GT(statistic("Rays/transmission"), 0.05 * allRays);
  double sum = 0, sumExact = 0;
  for (size_t k = 0; k < exact.size(); ++k) sum += estimate[k].x, sumExact += exact[k].x;
  EXPECT_NEAR(sum / sumExact, 1, 0.02);
}

// A furnace: light M = 1 with albedo 1/2 sums to 1 + 1/2 + 1/4 ... up to the bounces that are allowed. PRMan:
// MIN(parent.max, parent.depth + object.max). A wall that allows one bounce ends paths one bounce after it.
TEST(Bounces, AnObjectMayAllowFewerFromThereOn) {
  const auto furnace = [](int seen, int other) {
    const auto depth = [](int max) {
      return "Attribute \"trace\" \"int maxdiffusedepth\" [" + std::to_string(max) + "] ";
    };
    // What the camera sees is a small part of the sphere about it.
    return "ReverseOrientation Surface \"matte\" \"float Kd\" [1] \"color emission\" [1 1 1] Color [.5 .5 "
           ".5] "
           "Translate 0 1 -4 " +
           depth(seen) + "Sphere 1 .8 1 360 " + depth(other) + "Sphere 1 -1 .8 360";
  };
  const auto value = [&](const std::string& mode, int seen, int other) {
    double sum = 0;
    for (const Rgb& c : render(furnace(seen, other), inMode(mode, 4))) sum += static_cast<double>(c.x);
    return sum / (kSize * kSize);
  };
  // The cap is a tenth of the sphere's area, and the light of a sphere comes evenly from all of it.
  for (const std::string mode : {"path", "radiosity", "distribution"}) {
    EXPECT_NEAR(value(mode, 3, 3), 1.875, 0.03) << mode;
    EXPECT_NEAR(value(mode, 0, 3), 1, 0.01) << mode;
    EXPECT_NEAR(value(mode, 1, 3), 1.5, 0.02) << mode;
    // Rays that meet the other part, 0.9 of them, have one bounce left; the rest two, of which again.
    EXPECT_NEAR(value(mode, 3, 0), 1 + .5 * (.9 + .1 * (1 + .5 * (.9 + .1 * 1.5))), 0.03) << mode;
    EXPECT_NEAR(value(mode, 2, 1), 1 + .5 * (.9 * 1.5 + .1 * 1.5), 0.03) << mode;
    EXPECT_NEAR(value(mode, 3, 1), 1 + .5 * (.9 * 1.5 + .1 * (1 + .5 * (.9 * 1.5 + .1 * 1.5))), 0.03) << mode;
  }
}

}  // namespace
}  // namespace patina
