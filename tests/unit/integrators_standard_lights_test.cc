// SPDX-License-Identifier: Apache-2.0
// Pictures of a sphere under each of RI 3.2's standard lights, pixel by pixel against the formulas of its
// appendix A.
#include <cmath>
#include <functional>

#include "tests/unit/integrators_render.h"

namespace patina {
namespace {

constexpr int kSize = 32;
constexpr double kHalf = 1.2;  // of the picture's width; the sphere has radius 1

V3d unit(const V3d& v) { return v / v.length(); }

/// Cl and the direction towards the light, at P.
struct Cl {
  double value;
  V3d L;
};
struct Case {
  const char* request;  // a LightSource
  bool ambient;
  std::function<Cl(const V3d&)> at;
};

const V3d kFrom(1.5, 2, -3), kSpot(0.5, 0.3, -4);

std::vector<Case> cases() {
  const auto point = [](const V3d& from, const V3d& P) {
    return Cl{1 / (from - P).length2(), unit(from - P)};
  };
  return {{R"(LightSource "ambientlight" 1 "intensity" [0.7])", true,
           [](const V3d&) {
             return Cl{0.7, {}};
           }},
          {R"(LightSource "distantlight" 1 "intensity" [0.9] "from" [1.5 2 -3] "to" [0 0 0])", false,
           [](const V3d&) {
             return Cl{0.9, unit(kFrom)};
           }},
          {R"(LightSource "pointlight" 1 "intensity" [8] "from" [1.5 2 -3])", false,
           [=](const V3d& P) {
             Cl light = point(kFrom, P);
             light.value *= 8;
             return light;
           }},
          {R"(LightSource "spotlight" 1 "intensity" [11] "from" [0.5 0.3 -4] "to" [0 0 0] "coneangle" [0.25]
              "conedeltaangle" [0.15] "beamdistribution" [6])",
           false, [=](const V3d& P) {
             Cl light = point(kSpot, P);
             const double cosangle = light.L.dot(unit(kSpot));
             const double edge = std::cos(0.25), full = std::cos(0.25 - 0.15);
             const double t = std::clamp((cosangle - edge) / (full - edge), 0.0, 1.0);
             light.value *= 11 * std::pow(cosangle, 6) * t * t * (3 - 2 * t);
             return light;
           }}};
}

/// Ci of matte (Ks = 0) or plastic with Ka = 0.8, Kd = 0.6, Ks = 0.4, roughness 0.9, by the lobe that
/// patina/shader.h documents for specular().
double expected(const Case& c, const V3d& P, bool plastic) {
  const Cl light = c.at(P);
  if (c.ambient) return 0.8 * light.value;
  const double diffuse = 0.6 * light.value * std::max(P.dot(light.L), 0.0);
  const V3d H = unit(light.L + V3d(0, 0, -1));
  const bool lit = P.dot(light.L) > 0;
  return diffuse + (plastic && lit ? 0.4 * light.value * std::pow(std::max(P.dot(H), 0.0), 8 / 0.9) : 0.0);
}

TEST(StandardLightsInPictures, SphereHasTheValuesOfTheFormulas) {
  for (const bool classic : {false, true})
    for (const bool plastic : {false, true})
      for (const Case& c : cases()) {
        RenderSettings settings;
        settings.mode = "direct", settings.samples = 256, settings.classic = classic;
        settings.shadeAtHits = true;
        const std::string surface =
            plastic ? R"(Surface "plastic" "Ka" [0.8] "Kd" [0.6] "Ks" [0.4] "roughness" [0.9])"
                    : R"(Surface "matte" "Ka" [0.8] "Kd" [0.6])";
        const std::vector<Rgb> picture = renderPicture(
            "Display \"x\" \"file\" \"rgb\" Format 32 32 1 PixelFilter \"box\" 1 1 PixelSamples 16 16\n"
            "Projection \"orthographic\" ScreenWindow -1.2 1.2 -1.2 1.2 ShadingRate 0.05 Translate 0 0 5\n"
            "WorldBegin\n" +
                std::string(c.request) + "\nColor [1 1 1]\n" + surface + "\nSphere 1 -1 1 360\nWorldEnd\n",
            settings);
        ASSERT_EQ(picture.size(), size_t{kSize * kSize});
        int judged = 0;
        double worst = 0;
        for (int j = 0; j < kSize; ++j)
          for (int i = 0; i < kSize; ++i) {
            // The mean over the pixel.
            constexpr int kGrid = 12;
            double value = 0, farthest = 0;
            int lit = 0;
            for (int k = 0; k < kGrid * kGrid; ++k) {
              const double x = kHalf * (2 * (i + (k % kGrid + 0.5) / kGrid) / kSize - 1),
                           y = kHalf * (1 - 2 * (j + (k / kGrid + 0.5) / kGrid) / kSize);
              const double square = x * x + y * y;
              farthest = std::max(farthest, square);
              const V3d P(x, y, -std::sqrt(std::max(1 - square, 0.0)));
              if (!c.ambient) lit += P.dot(c.at(P).L) > 0;
              value += expected(c, P, plastic) / (kGrid * kGrid);
            }
            // Next to the terminator a pixel's samples are not good enough: it is dark, and changes fast.
            const bool ends = lit != 0 && lit != kGrid * kGrid;
            if (farthest > 0.6 || value < 0.15 || ends) continue;
            const double got = double(picture[size_t(j * kSize + i)].x);
            worst = std::max(worst, std::abs(got / value - 1));
            ++judged;
          }
        EXPECT_LT(worst, 5e-3) << c.request << (plastic ? " plastic" : " matte")
                               << (classic ? " classic" : "");
        EXPECT_GT(judged, 100) << c.request;
      }
}

}  // namespace
}  // namespace patina
