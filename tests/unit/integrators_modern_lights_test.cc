// SPDX-License-Identifier: Apache-2.0
// Lights by their modern names: the light on a white matte card against the closed forms of its irradiance,
// and shadows that have a colour.
#include <cmath>
#include <numbers>

#include "tests/unit/integrators_render.h"

namespace patina {
namespace {

constexpr double kPi = std::numbers::pi;

/// Mean of a picture of 8 by 8 pixels, of the card's middle, 0.02 wide, at z = 0, that faces -z.
Rgb seen(const std::string& lights, const std::string& mode, const std::string& things = "") {
  RenderSettings settings;
  settings.mode = mode, settings.samples = 256, settings.shadeAtHits = true;
  const std::vector<Rgb> picture = renderPicture(
      "Display \"x\" \"file\" \"rgb\" Format 8 8 1 PixelFilter \"box\" 1 1\n"
      "Projection \"orthographic\" ScreenWindow -.01 .01 -.01 .01 Translate 0 0 2\n"
      "Attribute \"trace\" \"int maxdiffusedepth\" [0] \"int maxspeculardepth\" [0]\n"
      "WorldBegin\n" +
          lights + "\nColor [1 1 1] Surface \"matte\" \"Ka\" [0]\n" + things +
          "Patch \"bilinear\" \"P\" [-1 1 0  1 1 0  -1 -1 0  1 -1 0]\nWorldEnd\n",
      settings);
  Rgb sum(0, 0, 0);
  for (const Rgb& c : picture) sum += c / static_cast<float>(picture.size());
  return sum;
}

struct Case {
  const char* light;
  double irradiance;
};

/// Of a rectangle of radiance 1, a by b, at the distance h of what it faces with its middle: four times the
/// configuration factor of a quarter of it (Howell, A Catalog of Radiation Heat Transfer Configuration
/// Factors, B-3), times pi.
double rectangle(double a, double b, double h) {
  const double A = a / 2 / h, B = b / 2 / h, x = std::sqrt(1 + A * A), y = std::sqrt(1 + B * B);
  return 4 * 0.5 * (A / x * std::atan(B / x) + B / y * std::atan(A / y));
}

TEST(ModernLights, IrradianceIsThatOfTheirShapes) {
  // Flat lights face +z; all stand behind the camera.
  const Case cases[] = {
      {"AttributeBegin Translate 0 0 -4 Scale 3 5 1 Light \"PxrRectLight\" \"l\" \"float exposure\" [1] "
       "AttributeEnd",
       2 * rectangle(3, 5, 4)},
      {"AttributeBegin Translate 0 0 -4 Scale 3 5 1 Light \"PxrRectLight\" \"l\" \"int areaNormalize\" [1] "
       "AttributeEnd",
       rectangle(3, 5, 4) / 15},
      {"AttributeBegin Translate 0 0 -4 Scale 6 6 1 Light \"PxrDiskLight\" \"l\" AttributeEnd",
       kPi * 9 / (9 + 16.0)},
      {"AttributeBegin Translate 0 0 -4 Scale 2 2 2 Light \"PxrSphereLight\" \"l\" AttributeEnd", kPi / 16},
      {"Light \"PxrDistantLight\" \"l\" \"float intensity\" [2] \"float angleExtent\" [5]", 2},
      {"Light \"PxrDistantLight\" \"l\" \"float intensity\" [2] \"float angleExtent\" [0]", 2},
      {"Light \"PxrDomeLight\" \"l\" \"color lightColor\" [.5 .5 .5]", kPi / 2}};
  for (const Case& c : cases)
    for (const char* mode : {"direct", "path"}) {
      const double got = kPi * double(seen(c.light, mode).y);
      // 16384 samples; the slack is for the dome, of which each has a variance.
      EXPECT_NEAR(got / c.irradiance, 1, 5e-3) << mode << ' ' << c.light;
    }
}

TEST(ModernLights, ShadowsHaveTheColourOfTheirLight) {
  const std::string ball = "AttributeBegin Translate 0 0 -3 Sphere .5 -.5 .5 360 AttributeEnd\n";
  const auto lamp = [](const std::string& shadow) {
    return "LightSource \"pointlight\" 1 \"from\" [0 0 -4] \"intensity\" [16] " + shadow;
  };
  for (const char* mode : {"direct", "path", "radiosity"}) {
    const Rgb shadowed = seen(lamp("\"color shadowcolor\" [.5 .25 0]"), mode, ball);
    EXPECT_NEAR(shadowed.x, 0.5f, 1e-3f) << mode;
    EXPECT_NEAR(shadowed.y, 0.25f, 1e-3f) << mode;
    EXPECT_EQ(shadowed.z, 0) << mode;
    EXPECT_EQ(seen(lamp(""), mode, ball), Rgb(0, 0, 0)) << mode;
    const Rgb open = seen(lamp("\"color shadowcolor\" [.5 .25 0]"), mode);
    EXPECT_NEAR(open.z, 1, 1e-3f) << mode;
    // Half of the rest gets through what is half opaque.
    const Rgb half = seen(lamp("\"color shadowcolor\" [.5 .25 0]"), mode,
                          "Opacity [.5 .5 .5]\n" + ball + "Opacity [1 1 1]\n");
    EXPECT_NEAR(half.y, 1 - 0.75f * 0.75f, 1e-3f) << mode;  // in and out of the ball
  }
  const Rgb modern = seen(
      "AttributeBegin Light \"PxrDistantLight\" \"l\" \"float intensity\" [3.14159265] \"float "
      "angleExtent\" [0] \"color shadowColor\" [.5 .25 0] AttributeEnd",
      "direct", ball);
  EXPECT_NEAR(modern.y, 0.25f, 1e-3f);
}

}  // namespace
}  // namespace patina
