// SPDX-License-Identifier: Apache-2.0
// Motion blur, depth of field and textures together: mode radiosity against path mode, by a Z-test.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "renderer/integrators/render.h"
#include "renderer/scene/scene_builder.h"

namespace patina {
namespace {

constexpr int kSize = 48, kBlock = 8, kBlocks = kSize / kBlock;  // pixels; along the picture

/// A soft pattern that has other colours on each side of a ball, as PPM.
std::string makeTexture() {
  std::string folder = testing::TempDir() + "patina-blur-XXXXXX";
  if (!mkdtemp(folder.data())) ADD_FAILURE() << "no folder " << folder;
  std::ofstream file(folder + "/soft.ppm", std::ios::binary);
  constexpr int kWidth = 128, kHeight = 64;
  file << "P6 " << kWidth << ' ' << kHeight << " 255\n";
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const double u = 2 * M_PI * x / kWidth, v = M_PI * y / kHeight;
      for (const double c : {0.5 + 0.4 * std::sin(4 * u) * std::cos(3 * v), 0.5 + 0.4 * std::cos(3 * u),
                             0.3 + 0.25 * std::sin(8 * v)})
        file.put(static_cast<char>(std::lround(255 * c)));
    }
  return folder;
}

struct Blur {
  const char* name;
  const char* options;   ///< shutter and lens
  const char* camera;    ///< its place
  const char* movement;  ///< of the balls
};

/// One of several independent pictures of the same: the view is that of kSize columns, and more at the left,
/// so that its pixels have other numbers and draw other samples.
std::vector<Rgb> render(const Blur& blur, const std::string& folder, const std::string& mode, int samples,
                        int replicate) {
  const int columns = kSize + 2 * kBlock * replicate;
  const std::string left = std::to_string(1 - 2.0 * columns / kSize), width = std::to_string(columns),
                    height = std::to_string(kSize);
  const std::string rib =
      "Format " + width + " " + height + " 1 PixelFilter \"box\" 1 1 " + blur.options +
      " Projection \"perspective\" \"fov\" [40] ScreenWindow " + left + " 1 -1 1 " + blur.camera +
      " WorldBegin LightSource \"distantlight\" 1 \"from\" [1 3 -2] \"to\" [0 0 0] Surface \"matte\" "
      "\"float Kd\" [1] Color [.6 .5 .4] Polygon \"P\" [-5 -.5 -5 -5 -.5 5 5 -.5 5 5 -.5 -5] " +
      blur.movement +
      " AttributeBegin Surface \"paintedplastic\" \"float Ks\" [0] \"float Ka\" [0] \"float Kd\" [1] "
      "\"string texturename\" [\"soft.ppm\"] Color [1 1 1] Sphere .5 -.5 .5 360 AttributeEnd "
      "Color [.2 .9 .3] Translate 0 .8 0 Sphere .2 -.2 .2 360 WorldEnd";
  ErrorHandler errors([](Severity, std::string_view message) { ADD_FAILURE() << message; });
  RenderSettings settings;
  settings.mode = mode, settings.samples = samples, settings.threads = 2, settings.shadeAtHits = true;
  settings.shaderPath = PATINA_BINARY_DIR "/lib/patina/shaders";
  settings.texturePath = folder;
  std::vector<Rgb> picture;
  SceneBuilder builder({}, errors, [&](Scene& scene) {
    const auto film = renderFrame(scene, settings, errors);
    ASSERT_TRUE(film);
    for (int y = 0; y < kSize; ++y)
      for (int x = columns - kSize; x < columns; ++x)
        picture.emplace_back(film->value(x, y, 0), film->value(x, y, 1), film->value(x, y, 2));
  });
  builder.readText(rib, "blur.rib");
  return picture;
}

/// Mean of each block and channel, and the variance of that mean.
struct Estimate {
  std::vector<double> mean, variance;
};
/// From replicates, pixel by pixel: a block's variance then has 64 degrees of freedom for each after the
/// first.
Estimate estimate(const Blur& blur, const std::string& folder, const std::string& mode, int samples) {
  constexpr int kReplicates = 2;
  std::vector<Rgb> pictures[kReplicates];
  for (int r = 0; r < kReplicates; ++r) {
    pictures[r] = render(blur, folder, mode, samples, r);
    if (pictures[r].size() != size_t{kSize} * kSize) return {};
  }
  Estimate all;
  for (int block = 0; block < kBlocks * kBlocks; ++block)
    for (int c = 0; c < 3; ++c) {
      double sum = 0, squares = 0;
      for (int k = 0; k < kBlock * kBlock; ++k) {
        const int x = block % kBlocks * kBlock + k % kBlock, y = block / kBlocks * kBlock + k / kBlock;
        const auto pixel = static_cast<size_t>(y * kSize + x);
        const double a = static_cast<double>(pictures[0][pixel][c]),
                     b = static_cast<double>(pictures[1][pixel][c]);
        sum += (a + b) / 2, squares += (a - b) * (a - b) / 4;  // the variance of (a + b) / 2
      }
      constexpr double kPixels = kBlock * kBlock;
      all.mean.push_back(sum / kPixels), all.variance.push_back(squares / (kPixels * kPixels));
    }
  return all;
}

TEST(Blur, RadiosityAgreesWithPathInEveryBlock) {
  const std::string folder = makeTexture();
  double worst = 0, above = 0, count = 0;
  for (const Blur& blur :
       {Blur{"moving ball out of focus", "Shutter 0 1 DepthOfField 4 .6 3", "Translate 0 -.3 4",
             "MotionBegin [0 .5 1] Translate -.6 0 0 Translate 0 .5 0 Translate .6 0 0 MotionEnd "
             "MotionBegin [0 1] Rotate 0 1 1 0 Rotate 150 1 1 0 MotionEnd"},
        Blur{"out of focus", "DepthOfField 4 .6 3", "Translate 0 -.3 4", ""},
        Blur{"moving camera", "Shutter 0 1",
             "MotionBegin [0 1] Translate -.2 -.3 4 Translate .2 -.2 3.8 MotionEnd", ""}}) {
    const Estimate path = estimate(blur, folder, "path", 256),
                   radiosity = estimate(blur, folder, "radiosity", 16);
    ASSERT_EQ(path.mean.size(), radiosity.mean.size()) << blur.name;
    double sum = 0, expected = 0;
    for (size_t k = 0; k < path.mean.size(); ++k) {
      sum += radiosity.mean[k], expected += path.mean[k];
      if (path.mean[k] == 0 && radiosity.mean[k] == 0) continue;  // the sky
      // Diffuse rays see textures through filters as wide as they are, which are wider than path mode's: a
      // stated bias. Without the texture, but else as here, no block is off by more than 0.03 %.
      const double bias = 0.001 * path.mean[k];
      const double z = std::max(std::abs(radiosity.mean[k] - path.mean[k]) - bias, 0.0) /
                       std::sqrt(path.variance[k] + radiosity.variance[k]);
      // Significance 1 % over 3 x 36 x 3 values (Sidak): 3.1e-5 for each, two-sided.
      EXPECT_LT(z, 4.17) << blur.name << ", block " << k / 3 << ", channel " << k % 3;
      worst = std::max(worst, z), above += z > 2, ++count;
    }
    EXPECT_NEAR(sum / expected, 1, 0.002) << blur.name;
  }
  EXPECT_LT(above / count, 0.1);  // 0.046 of normal values
  RecordProperty("worst", std::to_string(worst)), RecordProperty("above", std::to_string(above / count));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace patina
