// SPDX-License-Identifier: Apache-2.0
// Pictures with many lights, of which each point picks some: means against closed forms and against all
// lights sampled, and how little the picks scatter.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/integrators_render.h"
#include "tools/patina-bench/statistics.h"

namespace patina {
namespace {

constexpr int kSize = 8;

std::vector<Rgb> render(const std::string& world, const std::string& mode, int samples, int seed) {
  RenderSettings settings;
  settings.mode = mode, settings.samples = samples, settings.seed = seed;
  settings.shadeAtHits = true;
  return renderPicture(
      "Format 8 8 1 PixelFilter \"box\" 1 1 Projection \"orthographic\" ScreenWindow -4 4 -4 4 "
      "Translate 0 0 .5 Rotate -90 1 0 0 WorldBegin "
      "Attribute \"trace\" \"int maxdiffusedepth\" [0] \"int maxspeculardepth\" [1] " +
          world + " WorldEnd",
      settings);
}

std::string number(double v) { return std::to_string(v) + " "; }

struct Lamp {
  V3d at;
  double intensity;
};
/// Along a hall in x, over the floor y = 0; the camera sees 8 m of it, from below the lamps.
std::vector<Lamp> lamps(int n) {
  std::vector<Lamp> all;
  for (int k = 0; k < n; ++k)
    all.push_back({{-40 + 80.0 * k / n, 1.0 + 0.2 * (k % 4), 3.0 * (k % 3) - 3}, 0.5 + 0.25 * (k % 5)});
  return all;
}
std::string pointLights(const std::vector<Lamp>& all) {
  std::string world;
  for (size_t k = 0; k < all.size(); ++k)
    world += "LightSource \"pointlight\" " + std::to_string(k + 1) + " \"float intensity\" [" +
             number(all[k].intensity) + "] \"point from\" [" + number(all[k].at.x) + number(all[k].at.y) +
             number(all[k].at.z) + "] ";
  return world;
}
std::string sphereLights(const std::vector<Lamp>& all, const std::string& r) {
  std::string world;
  for (size_t k = 0; k < all.size(); ++k) {
    const std::string name = std::to_string(k + 1);
    world += "AttributeBegin AreaLightSource \"arealight\" " + name + " \"float intensity\" [" +
             number(.2 / std::stod(r) / std::stod(r) * all[k].intensity) + "] Translate " +
             number(all[k].at.x) + number(all[k].at.y) + number(all[k].at.z) + "Sphere " + r + " -" + r +
             " " + r + " 360 AttributeEnd Illuminate " + name + " 1 ";
  }
  return world;
}
const std::string kFloor = "Polygon \"P\" [-90 0 -9  -90 0 9  90 0 9  90 0 -9] ";
const std::string kMatte = "Surface \"matte\" \"float Ka\" [0] \"float Kd\" [1] Color [1 1 1] ";
const std::string kPlastic =
    "Surface \"plastic\" \"float Ka\" [0] \"float Kd\" [.5] \"float Ks\" [.5] \"float roughness\" [.04] ";

/// Of single pixels over pictures of different seeds.
std::vector<bench::Summary> pixels(const std::string& world, const std::string& mode, int samples,
                                   int pictures) {
  std::vector<std::vector<double>> values(kSize * kSize);
  for (int seed = 1; seed <= pictures; ++seed) {
    const std::vector<Rgb> picture = render(world, mode, samples, seed);
    for (size_t k = 0; k < values.size(); ++k) values[k].push_back(static_cast<double>(picture[k].x));
  }
  std::vector<bench::Summary> all;
  for (const auto& v : values) all.push_back(bench::summarize(v));
  return all;
}

void expectSameMeans(const std::vector<bench::Summary>& a, const std::vector<bench::Summary>& b) {
  const double level = bench::sidak(0.01, a.size());
  for (size_t k = 0; k < a.size(); ++k)
    EXPECT_GE(bench::welchTest(a[k], b[k]).p, level)
        << "pixel " << k << ": " << a[k].mean << " and " << b[k].mean;
}

/// For what is far from normally distributed: within so much.
void expectMeans(const std::vector<bench::Summary>& a, const std::vector<bench::Summary>& b, double error) {
  for (size_t k = 0; k < a.size(); ++k) EXPECT_NEAR(a[k].mean, b[k].mean, error) << "pixel " << k;
}

/// RI's matte: the sum of Cl cos. 200 lamps, one pick per sample: the mean is the sum, and the variance a
/// small part of what picks by power would have, which is known in closed form.
TEST(ManyLights, PathModeAgreesWithTheSumOfAllAndScattersLittle) {
  const std::vector<Lamp> all = lamps(200);
  constexpr int kSamples = 16, kPictures = 24;
  const auto seen = pixels(pointLights(all) + kMatte + kFloor, "path", kSamples, kPictures);
  double power = 0;
  for (const Lamp& l : all) power += l.intensity;
  double variance = 0, byPower = 0;
  const double level = bench::sidak(0.01, seen.size());
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      double mean = 0, squares = 0;
      constexpr int kGrid = 8;  // over the pixel
      for (int i = 0; i < kGrid * kGrid; ++i) {
        const V3d p(-4 + x + (i % kGrid + 0.5) / kGrid, 0, 4 - y - (i / kGrid + 0.5) / kGrid);
        for (const Lamp& l : all) {
          const V3d d = l.at - p;
          const double light = l.intensity * d.y / std::pow(d.length2(), 1.5) / (kGrid * kGrid);
          mean += light;
          squares += light * light * kGrid * kGrid * power / l.intensity;
        }
      }
      const bench::Summary& s = seen[static_cast<size_t>(y * kSize + x)];
      const double t = (s.mean - mean) / s.standardError();
      EXPECT_GE(bench::studentTails(t, kPictures - 1), level)
          << x << ", " << y << ": " << s.mean << " is not " << mean;
      variance += s.variance / (mean * mean);
      byPower += (squares - mean * mean) / (mean * mean) / kSamples;
    }
  RecordProperty("variance", std::to_string(variance / kSize / kSize));
  RecordProperty("by_power", std::to_string(byPower / kSize / kSize));
  EXPECT_LT(variance, byPower / 10);
}

/// Of up to 64 lights mode direct samples every one: so the picks of path mode, its MIS with what the lobes
/// find, and the bulbs in each other's way are right.
TEST(ManyLights, PicksHaveTheMeanOfAllLights) {
  const std::string world = sphereLights(lamps(60), ".45") + kPlastic + kFloor;
  expectSameMeans(pixels(world, "path", 32, 16), pixels(world, "direct", 4, 16));
}

/// Of more lights, candidates are picked; of more than a few delta lights those for the lobes, too.
TEST(ManyLights, CandidatesHaveTheMeanOfAllLights) {
  for (const std::string& lights :
       {pointLights(lamps(150)), sphereLights(lamps(150), ".1"),
        sphereLights(lamps(100), ".4") + "Illuminate 1 0 " +
            "LightSource \"distantlight\" \"sun\" \"float intensity\" [.2] \"point "
            "from\" [1 3 1] \"point to\" [0 0 0] \"float angle\" [3] "})
    expectSameMeans(pixels(lights + kPlastic + kFloor, "path", 32, 16),
                    pixels(lights + kPlastic + kFloor, "direct", 4, 16));
}

/// Where no specular ray may follow, what lights give by way of a lobe is not to be shared with one.
TEST(ManyLights, HighlightsNeedNoSpecularDepth) {
  const std::string world =
      sphereLights(lamps(4), ".45") + "Attribute \"trace\" \"int maxspeculardepth\" [0] " + kPlastic + kFloor;
  expectSameMeans(pixels(world, "path", 32, 16), pixels(world, "direct", 8, 16));
}

/// Nor is a smooth sky, which only a lobe's own directions find, to be lost.
TEST(ManyLights, SmoothSkiesNeedNoSpecularDepth) {
  const std::string light = "LightSource \"envlight\" 1 ";
  const std::string sky = light + "Attribute \"trace\" \"int maxspeculardepth\" [0] ";
  const std::string metal = "Surface \"conductor\" \"color reflectance\" [1 1 1] \"float alpha\" [.1] ";
  const auto seen = pixels(light + metal + kFloor, "path", 64, 16);
  for (const char* mode : {"path", "direct", "radiosity"})
    expectMeans(seen, pixels(sky + metal + kFloor, mode, 64, 16), 0.015);
  // By way of a wall that diffuse rays meet.
  const std::string wall = "Polygon \"P\" [4.5 0 -90 4.5 3 -90 4.5 3 90 4.5 0 90] ";
  const std::string room =
      sky + "Attribute \"trace\" \"int maxdiffusedepth\" [1] " + metal + wall + kMatte + kFloor;
  expectSameMeans(pixels(room, "path", 64, 16), pixels(room, "radiosity", 4, 16));
}

/// As many samples as may be asked for, which are more than 16 bits count.
TEST(ManyLights, AsManySamplesAsMayBe) {
  const std::string rib =
      "Format 2 2 1 PixelFilter \"box\" 1 1 Projection \"orthographic\" ScreenWindow -.1 .1 "
      "-.1 .1 Translate 0 0 .5 Rotate -90 1 0 0 WorldBegin " +
      sphereLights({{V3d(0, 3, 0), 1}}, "1") + kMatte + kFloor + "WorldEnd";
  for (const int samples : {256, 8192, 16384, 65536}) {
    RenderSettings settings;
    settings.mode = "direct", settings.samples = 1, settings.lightSamples = samples;
    // Below a ball of radiance L: L (r / h)^2.
    for (const Rgb& c : renderPicture(rib, settings)) EXPECT_NEAR(c.x, 0.2f / 9, 5e-4f) << samples;
  }
}

/// A light that is tried without its shadow costs as much as a shadow ray.
TEST(ManyLights, FewAreTriedForEachShadowRay) {
  RenderSettings settings;
  settings.samples = 4;
  renderPicture("Format 16 16 1 Projection \"perspective\" \"fov\" [60] Translate 0 -2 8 WorldBegin " +
                    pointLights(lamps(100)) + kMatte + kFloor +
                    "Polygon \"P\" [-90 0 4  -90 8 4  90 8 4  90 0 4] WorldEnd",
                settings);
  const double traced =
      statistic("Radiosity/light samples") - statistic("Radiosity/light samples that got no shadow ray");
  EXPECT_GT(traced, 1e4);
  EXPECT_LT(statistic("Radiosity/light samples"), 4 * traced);
}

}  // namespace
}  // namespace patina
