// SPDX-License-Identifier: Apache-2.0
// Pictures within a geometry cache that holds a tenth of what they need: the same bits, in every mode.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "renderer/base/statistics.h"
#include "renderer/integrators/render.h"
#include "renderer/scene/scene_builder.h"

namespace patina {
namespace {

/// Balls on a floor: displaced, shiny, half transparent, moving, and instances.
std::string field(size_t kilobytes) {
  std::string rib = fmt::format(
      "Option \"limits\" \"int geocachememory\" [{}] Shutter 0 1 Format 48 36 1\n"
      "Projection \"perspective\" \"fov\" [40] Translate 0 0 15 Rotate -35 1 0 0 WorldBegin\n"
      "LightSource \"envlight\" 1 \"intensity\" [0.7]\n"
      "LightSource \"distantlight\" 2 \"from\" [2 5 -3] \"to\" [0 0 0] \"intensity\" [0.5]\n"
      "ObjectBegin \"ball\" Sphere 0.3 -0.3 0.3 360 ObjectEnd\n"
      "Surface \"matte\" Polygon \"P\" [-20 -.5 -20 -20 -.5 20 20 -.5 20 20 -.5 -20]\n",
      kilobytes);
  for (int j = -4; j <= 4; ++j)
    for (int i = -4; i <= 4; ++i) {
      rib += fmt::format("AttributeBegin Color [{} 0.5 {}] Translate {} 0 {}\n", 0.1 * (i + 5), 0.1 * (j + 5),
                         i, j);
      switch ((i + 4 + 3 * (j + 4)) % 5) {
        case 0:
          rib += "Surface \"plastic\" ";
          break;
        case 1:
          rib += "Opacity [.6 .6 .6] ";
          break;
        case 2:
          rib += "MotionBegin [0 1] Translate 0 0 0 Translate 0 .3 0 MotionEnd ";
          break;
        case 3:
          rib += "ObjectInstance \"ball\" Translate 0 .7 0 ";
          break;
        default:
          rib += "Attribute \"displacementbound\" \"sphere\" [.3] Displacement \"dented\" \"float Km\" [.2] ";
          break;
      }
      rib += "Sphere .4 -.4 .4 360 AttributeEnd\n";
    }
  return rib + "WorldEnd\n";
}

struct Rendered {
  std::vector<Rgb> pixels;
  double peak = 0, again = 0;
};

Rendered render(const std::string& mode, size_t kilobytes) {
  std::vector<std::string> messages;
  ErrorHandler errors([&](Severity severity, std::string_view message) {
    if (severity != Severity::Warning) messages.emplace_back(message);
  });
  RenderSettings settings;
  settings.mode = mode, settings.samples = 2, settings.threads = 2, settings.rays = 16;
  settings.shaderPath = PATINA_BINARY_DIR "/lib/patina/shaders";
  Rendered picture;
  SceneBuilder builder({}, errors, [&](Scene& scene) {
    resetStatistics();
    const auto film = renderFrame(scene, settings, errors);
    ASSERT_TRUE(film);
    for (int y = 0; y < scene.options.yResolution; ++y)
      for (int x = 0; x < scene.options.xResolution; ++x)
        picture.pixels.emplace_back(film->value(x, y, 0), film->value(x, y, 1), film->value(x, y, 2));
    for (const StatEntry& entry : statistics()) {
      if (entry.name == "Memory/tessellations, most MB") picture.peak = entry.value * 1024;
      if (entry.name == "Geometry/units tessellated again") picture.again = entry.value;
    }
  });
  builder.readText(field(kilobytes), "field.rib");
  for (const std::string& message : messages) ADD_FAILURE() << message;
  return picture;
}

class GeometryBudget : public testing::TestWithParam<const char*> {};

TEST_P(GeometryBudget, OfATenthGivesTheSameBits) {
  const Rendered whole = render(GetParam(), 1 << 18);
  EXPECT_EQ(whole.again, 0);
  const auto tenth = static_cast<size_t>(whole.peak / 10);
  const Rendered tight = render(GetParam(), tenth);
  EXPECT_GT(tight.again, 100);
  EXPECT_LE(tight.peak, static_cast<double>(tenth) * 1.05);
  EXPECT_TRUE(tight.pixels == whole.pixels);
}

INSTANTIATE_TEST_SUITE_P(Modes, GeometryBudget, testing::Values("radiosity", "distribution", "path"),
                         [](const auto& mode) { return std::string(mode.param); });

}  // namespace
}  // namespace patina
