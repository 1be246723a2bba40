// SPDX-License-Identifier: Apache-2.0
// Furnaces: light inside the closed shapes of tests/stress/watertight, against the closed form.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "renderer/integrators/render.h"
#include "renderer/scene/scene_builder.h"

namespace patina {
namespace {

namespace fs = std::filesystem;

/// Inside a closed surface of albedo rho that emits E everywhere, the light that has met it up to 1 +
/// kBounces times is E (1 + rho + ... + rho^kBounces), wherever one looks. So few bounces are neither cut
/// short nor prolonged by Russian roulette in any mode: there is no noise. What is missing got lost, or comes
/// from vertices that are not where their value is used.
constexpr double kAlbedo = 0.8, kEmission = 0.2;
constexpr int kBounces = 4;
const double kExpected = kEmission * (1 - std::pow(kAlbedo, kBounces + 1)) / (1 - kAlbedo);

constexpr int kSize = 24;  // pixels along the picture

std::vector<fs::path> closedShapes() {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(PATINA_SOURCE_DIR "/tests/stress/watertight"))
    if (entry.path().extension() == ".rib") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// What is seen from the origin, over the expected, pixel by pixel.
std::vector<double> furnace(const fs::path& file, const std::string& mode, int samples, bool turning) {
  std::ifstream in(file);
  std::string rib{std::istreambuf_iterator<char>(in), {}};
  const std::string begin = "WorldBegin";
  const size_t at = rib.find(begin);
  if (at == std::string::npos) {
    ADD_FAILURE() << file << " has no world";
    return {};
  }
  // What solids are made of stands still, which the renderer says.
  turning = turning && rib.find("SolidBegin") == std::string::npos;
  rib.insert(at + begin.size(),
             " Attribute \"trace\" \"int maxdiffusedepth\" [" + std::to_string(kBounces) +
                 "] Color [.8 .8 .8] Surface \"matte\" \"float Kd\" [1] \"color emission\" "
                 "[.2 .2 .2] " +
                 (turning ? "MotionBegin [0 1] Rotate 0 3 2 1 Rotate 70 3 2 1 MotionEnd " : ""));
  if (turning) rib.insert(0, "Shutter 0 1 ");
  ErrorHandler errors([](Severity, std::string_view message) { ADD_FAILURE() << message; });
  RenderSettings settings;
  settings.mode = mode, settings.samples = samples, settings.threads = 2;
  settings.shaderPath = PATINA_BINARY_DIR "/lib/patina/shaders";
  std::vector<double> picture;
  SceneBuilder builder({}, errors, [&](Scene& scene) {
    scene.camera.worldToCamera.makeIdentity();
    scene.camera.fov = 90, scene.camera.screenWindow = {-1, 1, -1, 1};
    scene.options.xResolution = scene.options.yResolution = kSize;
    scene.options.filter = "box", scene.options.filterWidthX = scene.options.filterWidthY = 1;
    const auto film = renderFrame(scene, settings, errors);
    ASSERT_TRUE(film);
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x)
        picture.push_back(static_cast<double>(film->value(x, y, 0)) / kExpected);
  });
  builder.readText(rib, file.filename().string());
  return picture;
}

class Furnace : public testing::TestWithParam<fs::path> {};

TEST_P(Furnace, PathsDoNotGetOut) {
  // Each path that stays inside carries the expected light exactly, but for rounding. A few in a million
  // start so near a facet's edge that they begin behind its neighbour.
  const std::vector<double> picture = furnace(GetParam(), "path", 16, false);
  ASSERT_EQ(picture.size(), size_t{kSize} * kSize);
  double sum = 0;
  size_t exact = 0;
  for (const double value : picture) sum += value, exact += std::abs(value - 1) < 1e-5;
  EXPECT_NEAR(sum / (kSize * kSize), 1, 5e-4);
  EXPECT_GE(exact, picture.size() * 99 / 100);
}

TEST_P(Furnace, TheCacheHoldsItsLightInEveryPixel) {
  for (const bool turning : {false, true}) {
    const std::vector<double> picture = furnace(GetParam(), "radiosity", 4, turning);
    ASSERT_EQ(picture.size(), size_t{kSize} * kSize);
    const auto [least, most] = std::minmax_element(picture.begin(), picture.end());
    EXPECT_GT(*least, 0.995) << "pixel " << (least - picture.begin()) % kSize << ", "
                             << (least - picture.begin()) / kSize << (turning ? ", turning" : "");
    EXPECT_LT(*most, 1.0001) << (turning ? "turning" : "");
    RecordProperty(turning ? "leastTurning" : "least", std::to_string(*least));
  }
}

INSTANTIATE_TEST_SUITE_P(Inside, Furnace, testing::ValuesIn(closedShapes()),
                         [](const auto& tested) { return tested.param.stem().string(); });

TEST(Furnaces, AreOfEveryClosedShape) { EXPECT_GE(closedShapes().size(), 19u); }

}  // namespace
}  // namespace patina
