// SPDX-License-Identifier: Apache-2.0
// Path mode is unbiased: means over blocks of independent pictures against pictures by two other renderers.
#include <cmath>
#include <filesystem>
#include <fstream>

#include "renderer/film/image.h"
#include "tests/unit/integrators_render.h"
#include "tools/patina-bench/statistics.h"

namespace patina {
namespace {

constexpr int kSize = 256;  // of the pictures; the references are means over 4 x 4 of their pixels
constexpr int kReferenceSize = 64, kBlock = 16, kBlocks = kSize / kBlock;
constexpr int kPictures = 24, kSamples = 2;

/// Of a folder of tests/scenes, with the relMSE that is left in its reference by the reference's own noise:
/// what its two renderers differ by, over 16 as the 4 x 4 pixels of a mean are independent.
struct Judged {
  std::string name;
  double floor;
};

class References : public testing::TestWithParam<Judged> {};

std::string contents(const std::string& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Means over blocks, as an image.
ImageData shrunk(const ImageData& image, int block) {
  ImageData out;
  out.width = image.width / block, out.height = image.height / block, out.channels = 3;
  for (const double v : bench::blockMeans(image, block)) out.pixels.push_back(static_cast<float>(v));
  return out;
}

/// Means over the blocks that are judged, and last over the whole picture.
std::vector<double> blocksOf(const ImageData& image) {
  std::vector<double> means = bench::blockMeans(image, kBlock * kReferenceSize / kSize);
  for (const double whole : bench::blockMeans(image, kReferenceSize)) means.push_back(whole);
  return means;
}

/// One picture at the references' resolution. It is rendered at that at which they were: facets of a sphere
/// stay within an eightieth of a pixel, which at a quarter of the resolution is half a per cent of the area
/// of these spheres.
ImageData render(const std::string& rib, int seed) {
  RenderSettings settings;
  settings.mode = "path", settings.samples = kSamples, settings.seed = seed;
  ImageData image;
  image.width = image.height = kSize, image.channels = 3;
  for (const Rgb& c : renderPicture(rib, settings)) image.pixels.insert(image.pixels.end(), {c.x, c.y, c.z});
  return shrunk(image, kSize / kReferenceSize);
}

/// Mean of var / (r^2 + 0.01) over pixels and channels: the relMSE that one picture has by its noise.
double noise(const std::vector<ImageData>& pictures, const ImageData& reference) {
  double sum = 0;
  std::vector<double> values(pictures.size());
  for (size_t k = 0; k < reference.pixels.size(); ++k) {
    for (size_t i = 0; i < pictures.size(); ++i) values[i] = static_cast<double>(pictures[i].pixels[k]);
    sum += bench::summarize(values).variance * bench::relMseWeight(static_cast<double>(reference.pixels[k]));
  }
  return sum / static_cast<double>(reference.pixels.size());
}

TEST_P(References, BlocksOfPathModeAgreeWithinTheirErrors) {
  const std::string folder = PATINA_SOURCE_DIR "/tests/scenes/" + GetParam().name;
  std::string error;
  const auto reference = readImage(folder + "/ref/" + GetParam().name + "_64.exr", error);
  ASSERT_TRUE(reference) << error;
  ASSERT_EQ(reference->channels, 3);
  ASSERT_EQ(reference->width, kReferenceSize);

  const std::string rib = contents(folder + "/scene.rib");
  std::vector<ImageData> pictures;
  std::vector<std::vector<double>> means;
  for (int seed = 1; seed <= kPictures; ++seed) {
    pictures.push_back(render(rib, seed));
    ASSERT_EQ(pictures.back().pixels.size(), reference->pixels.size());
    means.push_back(blocksOf(pictures.back()));
  }

  // The reference has noise too, and says how much in all but not where. It comes from path tracers, so it is
  // taken to lie where path mode's own lies: in each block its variance is the same multiple of a picture's.
  // The difference of means, over a standard deviation that has both parts, then has Student's distribution.
  const double multiple = GetParam().floor / noise(pictures, *reference);
  const std::vector<double> expected = blocksOf(*reference);
  double worst = 0;
  int beyond = 0, judged = 0;
  const double level = bench::sidak(0.01, expected.size());
  std::vector<double> values(kPictures);
  for (size_t k = 0; k < expected.size(); ++k) {
    for (size_t i = 0; i < kPictures; ++i) values[i] = means[i][k];
    const bench::Summary s = bench::summarize(values);
    // In blocks of sky and bare ground hardly a path meets anything, and the few that do say little of their
    // variance: five times the largest standard error of such a block.
    const bool whole = k + 3 >= expected.size();
    if (!whole && s.standardError() < 1e-3 * expected[k]) {
      EXPECT_NEAR(s.mean, expected[k], 5e-3 * expected[k]) << "block " << k / 3;
      continue;
    }
    const double t = (s.mean - expected[k]) / std::sqrt(s.variance * (1.0 / kPictures + multiple));
    const double p = bench::studentTails(t, kPictures - 1);
    EXPECT_GE(p, level) << "block " << k / 3 % kBlocks << ',' << k / 3 / kBlocks << " channel " << k % 3
                        << ": " << s.mean << " in place of " << expected[k] << ", t = " << t;
    worst = std::max(worst, std::abs(t));
    beyond += std::abs(t) > 3;
    ++judged;
  }
  // How many lie beyond three standard errors by chance: the channels of a block share their paths, so they
  // count as one draw, and the blocks' number is within four standard deviations of its mean.
  const double chance = bench::studentTails(3, kPictures - 1), blocks = judged / 3.0;
  EXPECT_LE(beyond / 3.0, blocks * chance + 4 * std::sqrt(blocks * chance));
  RecordProperty("largest_t", std::to_string(worst));
  RecordProperty("beyond_three", beyond);
  RecordProperty("judged", judged);
  RecordProperty("multiple", std::to_string(multiple));
}

INSTANTIATE_TEST_SUITE_P(Scenes, References,
                         testing::Values(Judged{"cornell", 1.6e-5 / 16}, Judged{"cornell_point", 4.4e-4 / 16},
                                         Judged{"sky_spheres", 5.4e-5 / 16}),
                         [](const auto& scene) { return scene.param.name; });

}  // namespace
}  // namespace patina
