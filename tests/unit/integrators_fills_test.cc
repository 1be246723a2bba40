// SPDX-License-Identifier: Apache-2.0
// What the radiosity cache makes, and how often.
#include <gtest/gtest.h>

#include "tests/unit/integrators_render.h"

namespace patina {
namespace {

double verticesMade(int threads) {
  ErrorHandler errors([](Severity, std::string_view message) { ADD_FAILURE() << message; });
  RenderSettings settings;
  settings.mode = "radiosity", settings.samples = 4, settings.threads = threads, settings.rays = 32;
  settings.shaderPath = PATINA_BINARY_DIR "/lib/patina/shaders";
  SceneBuilder builder({}, errors, [&](Scene& scene) {
    scene.options.xResolution = scene.options.yResolution = 64;
    resetStatistics();
    ASSERT_TRUE(renderFrame(scene, settings, errors));
  });
  EXPECT_TRUE(builder.readFile(PATINA_SOURCE_DIR "/tests/scenes/cornell/scene.rib"));
  const double made = statistic("Radiosity/points shaded from the cache's vertices");
  // There is room for all of them; one entry of 64 is watched.
  EXPECT_EQ(statistic("Radiosity cache/values/made again, about"), 0);
  EXPECT_NEAR(statistic("Radiosity cache/values/made, about"), made, 0.25 * made);
  EXPECT_LT(statistic("Radiosity cache/values/made and never asked for, about"), 0.25 * made);
  return made;
}

TEST(RadiosityFills, ThreadsDoNotMakeTheSameTwice) {
  const double alone = verticesMade(1);
  EXPECT_GT(alone, 20000);
  // A store that meets another in the same slot may be dropped, and what was to be stored is made again.
  EXPECT_NEAR(verticesMade(4), alone, alone * 1e-3);
}

}  // namespace
}  // namespace patina
