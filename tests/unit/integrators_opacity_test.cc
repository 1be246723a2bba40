// SPDX-License-Identifier: Apache-2.0
// The opacity cache: how much light surfaces let pass, who is asked, and what it costs scenes without them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "renderer/base/statistics.h"
#include "renderer/integrators/render.h"
#include "renderer/scene/scene_builder.h"

namespace patina {
namespace {

struct Rendered {
  std::vector<Rgb> pixels;
  std::map<std::string, double> statistics;
  double of(const std::string& name) const {
    const auto found = statistics.find(name);
    return found == statistics.end() ? 0 : found->second;
  }
  Rgb mean() const {
    Rgb sum(0, 0, 0);
    for (const Rgb& c : pixels) sum += c;
    return sum / static_cast<float>(pixels.size());
  }
};

Rendered render(const std::string& rib, const std::string& mode, int threads = 2, int samples = 4) {
  ErrorHandler errors([](Severity, std::string_view message) { ADD_FAILURE() << message; });
  RenderSettings settings;
  settings.mode = mode, settings.samples = samples, settings.threads = threads, settings.rays = 16;
  settings.shaderPath = PATINA_BINARY_DIR "/lib/patina/shaders";
  Rendered picture;
  SceneBuilder builder({}, errors, [&](Scene& scene) {
    resetStatistics();
    const auto film = renderFrame(scene, settings, errors);
    ASSERT_TRUE(film);
    for (int y = 0; y < scene.options.yResolution; ++y)
      for (int x = 0; x < scene.options.xResolution; ++x)
        picture.pixels.emplace_back(film->value(x, y, 0), film->value(x, y, 1), film->value(x, y, 2));
    for (const StatEntry& entry : statistics()) picture.statistics[entry.name] = entry.value;
  });
  builder.readText(rib, "t.rib");
  return picture;
}

/// A white floor at z = 2 that fills an orthographic view of 2 x 2, lit along z, behind what casts shadows
/// and is not seen itself. Without shadows it shows 1.
std::string shadowOf(const std::string& occluders, const std::string& light = "") {
  return "Format 48 48 1 PixelFilter \"box\" 1 1 ScreenWindow -1 1 -1 1 WorldBegin LightSource "
         "\"distantlight\" 1 \"from\" [0 0 0] \"to\" [0 0 1] " +
         light +
         " Attribute \"trace\" \"int maxdiffusedepth\" [0] Surface \"matte\" \"float Kd\" [1] "
         "Polygon \"P\" [-2 -2 2  -2 2 2  2 2 2  2 -2 2] Attribute \"visibility\" \"int camera\" [0] " +
         occluders + " WorldEnd";
}

/// Leaves over a square of edge 1.6 in the middle of the view, n x n, each as large as fits.
std::string leaves(int n, const std::string& attributes = "") {
  std::string rib = "Surface \"leaf\" \"float width\" [0.8] " + attributes;
  const double edge = 1.6 / n;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i)
      rib += fmt::format(
          "TransformBegin Translate {} {} 1 Scale {} {} 1 Patch \"bilinear\" \"P\" [0 0 0  1 0 0  0 1 "
          "0  1 1 0] TransformEnd ",
          i * edge - 0.8, j * edge - 0.8, edge, edge);
  return rib;
}
/// Of leaves(): the part of the view that they cover. The area under |x - 1/2| < w/2 sin(pi y) is 2 w / pi.
constexpr double kCovered = 1.6 * 1.6 / 4 * 2 * 0.8 / std::numbers::pi;

TEST(OpacityCache, LeavesOfAnySizeTakeAwayTheLightThatTheyCover) {
  // A sun of 12 degrees is 0.2 wide behind a distance of 1: its 16 rays are 0.05 wide each, 1.3 pixels. A
  // leaf has from 38 micropolygons along its edge down to less than one.
  const std::string wide = "\"float angle\" [12]";
  for (const int n : {1, 3, 12, 48})
    for (const char* mode : {"path", "distribution", "radiosity"}) {
      const Rendered picture = render(shadowOf(leaves(n), wide), mode, 2, 16);
      // A leaf takes away its own area of light whatever the direction, as it is parallel to the floor; the
      // penumbra stays within the view. 48 x 48 x 16 samples of 0 or 1 have a mean that is off by 0.3 %.
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(picture.mean()[c], 1 - kCovered, 0.006) << mode << ", " << n << " x " << n;
      if (mode == std::string("radiosity"))
        EXPECT_GT(picture.of("Opacity cache/look-ups answered"), 5000) << n;
      else
        EXPECT_EQ(picture.of("Opacity cache/look-ups answered"), 0) << mode;
    }
}

TEST(OpacityCache, FiltersOfEachColour) {
  for (const char* mode : {"path", "radiosity"}) {
    const Rendered picture =
        render(shadowOf(leaves(3, "Opacity [0.25 0.5 1] "), "\"float angle\" [12]"), mode, 2, 16);
    for (int c = 0; c < 3; ++c) {
      const double opacity = c == 0 ? 0.25 : c == 1 ? 0.5 : 1;
      EXPECT_NEAR(picture.mean()[c], 1 - opacity * kCovered, 0.006) << mode << c;
    }
  }
}

TEST(OpacityCache, GivesTheSameBitsForAnyBudgetAndThreads) {
  const auto scene = [](int kilobytes) {
    return fmt::format("Option \"limits\" \"int opacitycachememory\" [{}] ", kilobytes) +
           shadowOf(leaves(5), "\"float angle\" [8]");
  };
  const Rendered plenty = render(scene(65536), "radiosity", 1);
  EXPECT_GT(plenty.of("Opacity cache/fine/entries"), 50);
  for (const int kilobytes : {0, 1, 20}) {
    const Rendered little = render(scene(kilobytes), "radiosity", 3);
    EXPECT_EQ(little.pixels, plenty.pixels) << kilobytes;
    EXPECT_LE(little.of("Opacity cache/bytes reserved"), kilobytes * 1024.0);
  }
}

TEST(OpacityCache, IsAskedInPlaceOfTheShaderAndFilledOnce) {
  const std::string rib = shadowOf(leaves(3), "\"float angle\" [12]");
  const double asked = render(rib, "distribution").of("Shaders/leaf/radiosity/points");
  const Rendered alone = render(rib, "radiosity", 1), together = render(rib, "radiosity", 4);
  // Rays of an area of the sun share what the shader says of the same vertices.
  EXPECT_LT(alone.of("Shaders/leaf/radiosity/points"), asked / 4);
  EXPECT_GT(alone.of("Opacity cache/shader points saved"), asked / 2);
  EXPECT_NEAR(together.of("Opacity cache/points shaded"), alone.of("Opacity cache/points shaded"),
              1e-3 * alone.of("Opacity cache/points shaded"));
  for (const char* level : {"coarse", "medium", "fine"}) {
    const std::string path = fmt::format("Opacity cache/{}/", level);
    EXPECT_EQ(alone.of(path + "look-ups"), alone.of(path + "hits") + alone.of(path + "misses")) << level;
    EXPECT_EQ(alone.of(path + "bytes"), alone.of(path + "entries") * alone.of(path + "bytes per slot"));
  }
}

TEST(OpacityCache, OpacityThatIsOsIsKnownWithoutTheShader) {
  for (const char* mode : {"path", "distribution", "radiosity", "direct"}) {
    const Rendered picture =
        render(shadowOf("Surface \"constant\" Opacity [0.25 0.5 1] Polygon \"P\" [-3 -3 1  -3 3 "
                        "1  3 3 1  3 -3 1] Surface \"null\" Disk 0.5 3 360"),
               mode);
    EXPECT_NEAR(picture.mean().x, 0.75, 1e-5) << mode;
    EXPECT_NEAR(picture.mean().y, 0.5, 1e-5) << mode;
    EXPECT_NEAR(picture.mean().z, 0, 1e-5) << mode;
    for (const auto& [name, value] : picture.statistics) {
      EXPECT_FALSE(name.starts_with("Shaders/constant") || name.starts_with("Shaders/null")) << name;
      EXPECT_FALSE(name.starts_with("Opacity cache")) << name;
    }
  }
}

/// A floor of albedo 0.8 that fills the view, and a ceiling like it behind the eye; between them `count`
/// layers that glow with 1 as far as they are opaque, and that the camera does not see. All reach so far that
/// they are infinite.
std::string glowingLayers(int count, const std::string& opacity, int bounces) {
  const auto plane = [](double z) {
    return fmt::format("Polygon \"P\" [-1000 -1000 {0} -1000 1000 {0} 1000 1000 {0} 1000 -1000 {0}] ", z);
  };
  std::string rib = fmt::format(
      "Format 8 8 1 PixelFilter \"box\" 1 1 ScreenWindow -1 1 -1 1 WorldBegin Attribute \"trace\" \"int "
      "maxdiffusedepth\" [{}] Surface \"matte\" \"float Kd\" [0.8] ",
      bounces);
  rib += plane(4) + plane(-1) + "Attribute \"visibility\" \"int camera\" [0] Surface \"constant\" Opacity " +
         opacity;
  for (int k = 0; k < count; ++k) rib += plane(1 + 2.0 * k / count);
  return rib + " WorldEnd";
}

TEST(Layers, LightOfAllOfThemArrives) {
  const std::string rib = glowingLayers(6, "[0.1 0.2 0.4] ", 3);
  for (const char* mode : {"path", "distribution", "radiosity"}) {
    const Rgb mean = render(rib, mode, 2, mode == std::string("path") ? 512 : 64).mean();
    for (int c = 0; c < 3; ++c) {
      // What a surface shows that light may still reach by so many bounces; behind the layers is the other
      // one.
      const double passed = std::pow(c == 0 ? 0.9 : c == 1 ? 0.8 : 0.6, 6);
      double expected = 0;
      for (int bounces = 1; bounces <= 3; ++bounces) expected = 0.8 * (1 - passed + passed * expected);
      // 64 pixels of 16 rays or 512 paths: a per cent or so.
      EXPECT_NEAR(mean[c], expected, 0.03) << mode << c;
    }
  }
}

TEST(Layers, RaysDoNotBranchAtEachOfThem) {
  // A ten-thousandth is left behind 41 of them: so many values each ray took, and the rays that those needed.
  const Rendered picture = render(glowingLayers(60, "[0.2 0.2 0.2] ", 4), "distribution");
  EXPECT_GT(picture.of("Radiosity/gather rays"), 500);
  EXPECT_LT(picture.of("Radiosity/points shaded at hits"), 16 * picture.of("Radiosity/gather rays"));
  EXPECT_NEAR(picture.mean().x, 0.8, 0.03);
}

TEST(OpacityCache, OpaqueScenesPayNothing) {
  const Rendered picture = render(shadowOf("Surface \"matte\" Sphere 0.3 -0.3 0.3 360"), "radiosity");
  for (const auto& [name, value] : picture.statistics) {
    EXPECT_FALSE(name.starts_with("Opacity cache")) << name;
    EXPECT_NE(name, "Shading/opacity look-ups");
  }
}

}  // namespace
}  // namespace patina
