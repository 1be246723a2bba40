// SPDX-License-Identifier: Apache-2.0
// PixelVariance: pixels get as many samples as their variance asks for.
#include <cmath>

#include "renderer/integrators/passes.h"
#include "tests/unit/integrators_render.h"

namespace patina {
namespace {

TEST(SamplePlan, FollowsTheCommandLineThenTheHiderThenPixelSamples) {
  Options options;
  RenderSettings settings;
  options.pixelSamplesX = 6, options.pixelSamplesY = 6;
  SamplePlan plan = samplePlan(options, settings);
  EXPECT_EQ(plan.most, 36);
  EXPECT_FALSE(plan.isAdaptive()) << "PixelVariance 0";
  options.pixelVariance = 0.01f;
  plan = samplePlan(options, settings);
  EXPECT_EQ(plan.least, 6);
  EXPECT_EQ(plan.most, 36);
  EXPECT_FLOAT_EQ(plan.variance, 0.01f);
  options.maxSamples = 100, options.exposureGain = 2;
  plan = samplePlan(options, settings);
  EXPECT_EQ(plan.least, 10);
  EXPECT_EQ(plan.most, 100);
  EXPECT_FLOAT_EQ(plan.variance, 0.0025f) << "of what the picture shows";
  EXPECT_FLOAT_EQ(plan.white, 0.5f);
  options.minSamples = 1;
  EXPECT_EQ(samplePlan(options, settings).least, 2) << "one has no variance";
  options.minSamples = 200;
  EXPECT_FALSE(samplePlan(options, settings).isAdaptive());
  options.minSamples.reset();
  settings.samples = 9;
  plan = samplePlan(options, settings);
  EXPECT_EQ(plan.least, 4) << "fewer say little";
  EXPECT_EQ(plan.most, 9);
}

/// A matte wall under a large lamp, half of it behind a card that shines evenly, all under a wide filter.
std::string scene(const std::string& options) {
  return "Format 40 40 1 PixelFilter \"gaussian\" 2 2 Projection \"perspective\" \"fov\" [50] " + options +
         " WorldBegin AttributeBegin AreaLightSource \"arealight\" 1 \"float intensity\" [3] Surface "
         "\"null\" "
         "Polygon \"P\" [-2 1.9 1  -2 1.9 3  2 1.9 3  2 1.9 1] AttributeEnd Surface \"matte\" "
         "Polygon \"P\" [-9 -9 4  -9 9 4  9 9 4  9 -9 4] "
         "Surface \"constant\" Color [.5 .5 .5] Polygon \"P\" [-1 -1 2  -1 1 2  .15 1 2  -.2 -1 2] WorldEnd";
}

class Adaptive : public testing::TestWithParam<const char*> {};

double meanOf(const std::vector<Rgb>& picture) {
  double sum = 0;
  for (const Rgb& c : picture) sum += static_cast<double>(luminance(c)) / static_cast<double>(picture.size());
  return sum;
}

TEST_P(Adaptive, SamplesGoWhereTheVarianceIs) {
  RenderSettings settings;
  settings.mode = GetParam(), settings.samples = 256, settings.rays = 16;
  const std::vector<Rgb> full = renderPicture(scene(""), settings);
  const double all = statistic("Film/samples");
  EXPECT_EQ(statistic("Adaptive sampling/pixels"), 0) << "nothing of it where it is not asked for";
  const std::vector<Rgb> adaptive = renderPicture(scene("PixelVariance 1e-4"), settings);
  const double some = statistic("Film/samples");
  EXPECT_LT(some, 0.6 * all);
  EXPECT_GE(some, all / 16);
  EXPECT_GT(statistic("Adaptive sampling/pixels"), 40 * 40);
  EXPECT_LT(statistic("Adaptive sampling/with all samples"), 0.6 * statistic("Adaptive sampling/pixels"));
  // A variance of at most 1e-4 where sampling stopped; pixels have their neighbours' samples, too.
  double squares = 0;
  for (size_t k = 0; k < full.size(); ++k) {
    const double d = static_cast<double>(luminance(adaptive[k]) - luminance(full[k]));
    squares += d * d / static_cast<double>(full.size());
  }
  EXPECT_LT(squares, 1e-4);
  EXPECT_NEAR(meanOf(adaptive), meanOf(full), 0.005 * meanOf(full));
  // A tenth of the error is wanted: more samples, though edges have all of them already.
  renderPicture(scene("PixelVariance 1e-6"), settings);
  EXPECT_GT(statistic("Film/samples"), some);
}

TEST_P(Adaptive, NeitherThreadsNorPassesChangeABit) {
  RenderSettings settings;
  settings.mode = GetParam(), settings.samples = 24, settings.rays = 8;
  const std::string rib = scene("PixelVariance 1e-4");
  const std::vector<Rgb> two = renderPicture(rib, settings);
  settings.threads = 5;
  EXPECT_EQ(renderPicture(rib, settings), two);
  if (settings.mode != "path") return;  // others share rays among the samples of a pass
  settings.progressive = true;
  EXPECT_EQ(renderPicture(rib, settings), two);
}

TEST(AdaptiveLimit, BucketsKeepNoMoreThanTheyMay) {
  // A bucket of 256 by 256 would keep 28 bytes of each of 4096 samples of 65536 pixels: 7 GB.
  std::vector<std::string> messages;
  ErrorHandler errors([&](Severity, std::string_view message) { messages.emplace_back(message); });
  RenderSettings settings;
  settings.mode = "path", settings.samples = 4096;
  settings.shaderPath = PATINA_BINARY_DIR "/lib/patina/shaders";
  settings.interrupted = [] { return true; };
  SceneBuilder builder({}, errors, [&](Scene& scene) { renderFrame(scene, settings, errors); });
  builder.readText(
      "Format 256 256 1 PixelVariance 1e-4 Option \"limits\" \"bucketsize\" [256 256] "
      "Projection \"perspective\" WorldBegin Surface \"constant\" Sphere 1 -1 1 360 WorldEnd",
      "text.rib");
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_NE(messages[0].find("PixelVariance has no effect"), std::string::npos) << messages[0];
}

INSTANTIATE_TEST_SUITE_P(Modes, Adaptive, testing::Values("path", "radiosity", "points", "direct"),
                         [](const auto& mode) { return std::string(mode.param); });

}  // namespace
}  // namespace patina
