// SPDX-License-Identifier: Apache-2.0
// Pictures of RIB text, for tests of integrators.
#pragma once

#include <gtest/gtest.h>

#include "renderer/base/statistics.h"
#include "renderer/integrators/render.h"
#include "renderer/scene/scene_builder.h"

namespace patina {

/// The one picture of `rib`, row by row, by two threads unless `settings` say more; statistics are of it
/// alone. Any message of Patina is a failure of the test.
inline std::vector<Rgb> renderPicture(const std::string& rib, RenderSettings settings) {
  ErrorHandler errors([](Severity, std::string_view message) { ADD_FAILURE() << message; });
  settings.threads = std::max(settings.threads, 2);
  settings.shadeAtHits = settings.shadeAtHits || settings.unbiased;
  settings.shaderPath = PATINA_BINARY_DIR "/lib/patina/shaders";
  resetStatistics();
  std::vector<Rgb> picture;
  SceneBuilder builder({}, errors, [&](Scene& scene) {
    const auto film = renderFrame(scene, settings, errors);
    ASSERT_TRUE(film);
    const PixelRect& r = film->pixels();
    for (int y = r.y0; y < r.y1; ++y)
      for (int x = r.x0; x < r.x1; ++x)
        picture.emplace_back(film->value(x, y, 0), film->value(x, y, 1), film->value(x, y, 2));
  });
  builder.readText(rib, "text.rib");
  return picture;
}

inline double statistic(const std::string& name) {
  for (const StatEntry& entry : statistics())
    if (entry.name == name) return entry.value;
  return 0;
}

}  // namespace patina
