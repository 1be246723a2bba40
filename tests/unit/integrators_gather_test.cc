// SPDX-License-Identifier: Apache-2.0
// How much gathers cost: rays where they count, few where vertices share a pixel, where lights outshine what
// is gathered, and where surfaces reflect next to nothing; with the same mean.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/integrators_render.h"
#include "tools/patina-bench/statistics.h"

namespace patina {
namespace {

constexpr int kSize = 24;

std::vector<Rgb> render(const std::string& world, RenderSettings settings) {
  return renderPicture(
      "Format 24 24 1 PixelFilter \"box\" 1 1 PixelSamples 2 2 Projection \"perspective\" \"fov\" [60] "
      "WorldBegin Attribute \"trace\" \"int maxdiffusedepth\" [2] \"int maxspeculardepth\" [2] " +
          world + " WorldEnd",
      settings);
}

/// A floor, and a wall to its left; `light` may be switched off for the floor.
std::string corner(const std::string& forTheFloor) {
  return "LightSource \"distantlight\" 1 \"float intensity\" [3] \"point from\" [2 3 0] \"point to\" [0 0 0] "
         "Surface \"matte\" \"float Ka\" [0] \"float Kd\" [.6] "
         "Polygon \"P\" [-3 -1 -1  -3 -1 8  -3 4 8  -3 4 -1] " +
         forTheFloor + "Polygon \"P\" [-3 -1 -1  3 -1 -1  3 -1 8  -3 -1 8]";
}

TEST(Gather, SendsFewerRaysWhereLightsOutshineWhatIsGathered) {
  render(corner("Illuminate 1 0 "), {});
  const double dark = statistic("Radiosity/gather rays");
  render(corner(""), {});
  EXPECT_LT(statistic("Radiosity/gather rays"), 0.75 * dark);
}

/// A ball in a lit room: nothing is interpolated on it.
std::string ball(const std::string& shadingRate) {
  return "LightSource \"distantlight\" 1 \"float intensity\" [3] \"point from\" [2 3 -1] \"point to\" [0 0 "
         "0] "
         "Surface \"matte\" \"float Ka\" [0] \"float Kd\" [.6] "
         "Polygon \"P\" [-30 -2 -30  30 -2 -30  30 -2 30  -30 -2 30] Illuminate 1 0 ShadingRate " +
         shadingRate + " Translate 0 0 3.5 Sphere 1.9 -1.9 1.9 360";
}

TEST(Gather, DividesThePixelsRaysAmongItsVertices) {
  const std::vector<Rgb> coarse = render(ball("1"), {});
  const double one = statistic("Radiosity/gather rays"),
               vertices = statistic("Irradiance cache/vertices gathered");
  const std::vector<Rgb> fine = render(ball("0.0625"), {});
  const double many = statistic("Irradiance cache/vertices gathered") / vertices;
  EXPECT_GT(many, 3) << "else this says nothing";
  EXPECT_LT(statistic("Radiosity/gather rays") / one, 0.55 * many);
  double a = 0, b = 0;
  for (size_t k = 0; k < coarse.size(); ++k) a += coarse[k].x, b += fine[k].x;
  EXPECT_NEAR(b / a, 1, 0.01);
}

/// Inside of a box whose walls have a sheen, or are half mirrors.
std::string box(const std::string& shine) {
  return "LightSource \"pointlight\" 1 \"float intensity\" [20] \"point from\" [1 2 4] "
         "Surface \"plastic\" \"float Ka\" [0] \"float Kd\" [.5] " +
         shine +
         "Polygon \"P\" [-3 -3 -1  3 -3 -1  3 -3 8  -3 -3 8] Polygon \"P\" [-3 3 -1  -3 3 8  3 3 8  3 3 -1] "
         "Polygon \"P\" [-3 -3 -1  -3 -3 8  -3 3 8  -3 3 -1] Polygon \"P\" [3 -3 -1  3 3 -1  3 3 8  3 -3 8] "
         "Polygon \"P\" [-3 -3 8  3 -3 8  3 3 8  -3 3 8] Polygon \"P\" [-3 -3 -1  -3 3 -1  3 3 -1  3 -3 -1]";
}

TEST(Gather, FollowsWeakLobesSeldom) {
  const std::string weak = "\"float Ks\" [.2] \"float roughness\" [.1] ";
  render(box(weak), {});
  EXPECT_GT(statistic("Radiosity/specular continuations"), 10000);
  EXPECT_LT(statistic("Rays/specular"), 0.3 * statistic("Radiosity/specular continuations"));
}

/// Walls whose diffuse light and whose sheen go to the same directions: each is cut off by its own depth, and
/// the other goes on, in all modes alike.
TEST(Gather, FollowsEachKindOfLightToItsOwnDepth) {
  for (const bool specular : {false, true}) {
    std::vector<double> walks, paths;
    for (int seed = 1; seed <= 12; ++seed) {
      RenderSettings settings;
      settings.seed = seed, settings.samples = 4;
      const std::string depths =
          std::string("Attribute \"trace\" \"int maxdiffusedepth\" [1] \"int maxspeculardepth\" ") +
          (specular ? "[1] " : "[0] ");
      const auto mean = [&](const char* mode, bool unbiased) {
        settings.mode = mode, settings.unbiased = unbiased;
        double sum = 0;
        for (const Rgb& c : render(depths + box("\"float Ks\" [.5] \"float roughness\" [.3] "), settings))
          sum += c.x;
        return sum / (kSize * kSize);
      };
      walks.push_back(mean("radiosity", true)), paths.push_back(mean("path", false));
    }
    const bench::Summary a = bench::summarize(walks), b = bench::summarize(paths);
    EXPECT_GT(bench::welchTest(a, b).p, 0.01) << a.mean << " " << b.mean << " " << specular;
    EXPECT_LT(b.standardError(), 0.01 * b.mean) << "else this says nothing";
  }
}

/// A sky that is sampled, with a sun in it: its broad part comes by the gathers' rays, the sun by light
/// samples.
TEST(Gather, SharesSkiesWithLightSamples) {
  const std::string world =
      "TransformBegin Rotate -90 1 0 0 LightSource \"sunsky\" 1 \"vector sundirection\" [-.6 .3 1] "
      "TransformEnd "
      "Surface \"matte\" \"float Ka\" [0] \"float Kd\" [.6] "
      "Polygon \"P\" [-30 -1 -30  30 -1 -30  30 -1 30  -30 -1 30] Translate 0 0 4 Sphere 1 -1 1 360";
  std::vector<double> rays, paths, shaded;
  for (int seed = 1; seed <= 8; ++seed) {
    RenderSettings settings;
    settings.seed = seed;
    const auto picture = [&](const char* mode, int samples, bool unbiased) {
      settings.mode = mode, settings.samples = samples, settings.unbiased = unbiased;
      return render(world, settings);
    };
    const auto mean = [&](const std::vector<Rgb>& pixels) {
      double sum = 0;
      for (const Rgb& c : pixels) sum += c.x + c.y + c.z;
      return sum / (3 * kSize * kSize);
    };
    rays.push_back(mean(picture("radiosity", 4, true))), paths.push_back(mean(picture("path", 16, false)));
    // In the ball's shadow, where the sky alone shines.
    shaded.push_back(double(picture("radiosity", 4, false)[14 * kSize + 18].z));
  }
  const bench::Summary a = bench::summarize(rays), b = bench::summarize(paths), c = bench::summarize(shaded);
  EXPECT_GT(bench::welchTest(a, b).p, 0.01) << a.mean << " " << b.mean;
  EXPECT_LT(b.standardError(), 0.01 * b.mean) << "else this says nothing";
  EXPECT_LT(std::sqrt(c.variance), 0.05 * c.mean);
}

double meanOf(const std::vector<Rgb>& picture) {
  double sum = 0;
  for (const Rgb& c : picture) sum += static_cast<double>(c.x + c.y + c.z);
  return sum / (3 * static_cast<double>(picture.size()));
}

/// A corner whose floor shows the wall in a rough mirror.
std::string shine(const std::string& floor) { return corner(floor + " \"float Ka\" [0] \"float Kd\" [.2] "); }

// What a rough lobe's directions meet is taken from what diffuse rays see, and no vertex is gathered for it.
TEST(Gather, MakesNothingForRoughLobesAlone) {
  const std::string matte = "Surface \"matte\"",
                    rough = "Surface \"plastic\" \"float Ks\" [.8] \"float roughness\" [.2]";
  render(shine(matte), {});
  EXPECT_EQ(statistic("Camera/points met by way of rough lobes"), 0);
  const double alone = statistic("Irradiance cache/vertices gathered");
  RenderSettings settings;
  settings.samples = 64;
  const double seen = meanOf(render(shine(rough), settings));
  EXPECT_GT(statistic("Camera/points met by way of rough lobes"), 1000);
  EXPECT_LT(statistic("Camera/points met by way of rough lobes, not in the cache"),
            0.2 * statistic("Camera/points met by way of rough lobes"));
  EXPECT_LT(statistic("Irradiance cache/vertices gathered"), 1.2 * alone);
  settings.mode = "distribution";
  EXPECT_NEAR(meanOf(render(shine(rough), settings)) / seen, 1, 0.01);
  settings.mode = "path", settings.samples = 1024;
  EXPECT_NEAR(meanOf(render(shine(rough), settings)) / seen, 1, 0.01);
}

// Micropolygons far larger than the holes: what is between vertices that are all solid has holes, too.
TEST(Gather, SeesHolesBetweenVertices) {
  const std::string sheet =
      "LightSource \"distantlight\" 1 \"point from\" [1 1 -2] \"point to\" [0 0 0] ShadingRate 64 Surface "
      "\"cutout\" \"float Ka\" [0] \"float frequency\" [17.3] \"float radius\" [.25] "
      "Polygon \"P\" [-3 -3 4  3 -3 4  3 3 4  -3 3 4] \"st\" [0 0 1 0 1 1 0 1]";
  RenderSettings settings;
  settings.samples = 64;
  const double seen = meanOf(render(sheet, settings));
  settings.shadeAtHits = true;
  EXPECT_NEAR(seen / meanOf(render(sheet, settings)), 1, 0.01);
}

// As the cache's vertices are shaded: the same picture, of more rays.
TEST(Gather, MayShadeHitsAsFullyAsVertices) {
  RenderSettings settings;
  // At hits of the camera all gathers have as many rays.
  settings.mode = "distribution", settings.rays = 256, settings.shadeAtHits = true;
  const double thrifty = meanOf(render(corner("Illuminate 1 0 "), settings)),
               rays = statistic("Radiosity/gather rays");
  settings.fullHits = true;
  EXPECT_NEAR(meanOf(render(corner("Illuminate 1 0 "), settings)) / thrifty, 1, 0.01);
  EXPECT_GT(statistic("Radiosity/gather rays"), 1.2 * rays);
}

}  // namespace
}  // namespace patina
