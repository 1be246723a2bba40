// SPDX-License-Identifier: Apache-2.0
// Rays that shaders trace: what they meet, against closed forms; what they cost; and what is refused.
#include <gmock/gmock.h>

#include <cmath>

#include "tests/unit/integrators_render.h"

namespace patina {
namespace {

constexpr const char* kPlugins = PATINA_BINARY_DIR "/tests/plugins:@";

/// The pixel in the middle: of a floor at z = 0, whose outside is towards -z, seen from there along z.
Rgb middle(const std::string& floorShader, const std::string& around, const std::string& mode = "direct",
           int threads = 2) {
  RenderSettings settings;
  settings.mode = mode, settings.samples = 1, settings.threads = threads;
  const std::vector<Rgb> picture = renderPicture(
      "Option \"searchpath\" \"string shader\" [\"" + std::string(kPlugins) +
          "\"]\nFormat 3 3 1 PixelSamples 1 1 PixelFilter \"box\" 1 1\n"
          "Projection \"orthographic\" ScreenWindow -0.01 0.01 -0.01 0.01 Translate 0 0 5\nWorldBegin\n"
          "AttributeBegin Surface " +
          floorShader +
          " Patch \"bilinear\" \"P\" [-1 1 0  1 1 0  -1 -1 0  1 -1 0] AttributeEnd\n"
          "Attribute \"visibility\" \"int camera\" [0]\nSurface \"matte\"\n" +
          around + "\nWorldEnd\n",
      settings);
  return picture.size() == 9 ? picture[4] : Rgb(-1, -1, -1);
}

// By 254 directions. What the shapes below cut out of the spiral is off by at most three of them.
constexpr float kShare = 3.0f / 254;  // distances: by the rounding of cached values, 1e-4

TEST(ShaderRays, CoverOfADiscAbove) {
  EXPECT_EQ(middle("\"surroundings\"", ""), Rgb(0, 4, 0)) << "nothing there but the plane itself";
  for (const double height : {0.3, 0.7, 2.0}) {
    const double radius = 0.8;
    const std::string disc = "Translate 0 0 " + std::to_string(-height) + " Disk 0 0.8 360";
    const Rgb near = middle("\"surroundings\"", disc);
    // The form factor of a disc from below its middle.
    EXPECT_NEAR(near.x, radius * radius / (radius * radius + height * height), kShare) << height;
    EXPECT_NEAR(near.y, height, 1e-4) << height;
    // Rays end before it, or just behind its middle.
    EXPECT_EQ(middle("\"surroundings\" \"float maximum\" [" + std::to_string(0.99 * height) + "]", disc).x,
              0);
    const Rgb part =
        middle("\"surroundings\" \"float maximum\" [" + std::to_string(1.1 * height) + "]", disc);
    const double reach = std::min(radius / height, std::sqrt(1.1 * 1.1 - 1));  // as a tangent
    EXPECT_NEAR(part.x, reach * reach / (1 + reach * reach), kShare) << height;
  }
}

TEST(ShaderRays, CoverOfAWallBeside) {
  for (const double away : {0.2, 0.6}) {
    // From the floor up to a height of 1.5, and as good as endless along y.
    const std::string x = std::to_string(away);
    const Rgb near = middle("\"surroundings\"", "Polygon \"P\" [" + x + " -3000 0  " + x + " 3000 0  " + x +
                                                    " 3000 -1.5  " + x + " -3000 -1.5]");
    // Half the difference of the sines of the angles to the normal (H. C. Hottel), 90 degrees at the floor.
    EXPECT_NEAR(near.x, 0.5 * (1 - away / std::hypot(away, 1.5)), kShare) << away;
    EXPECT_EQ(near.y, 4);
  }
}

TEST(ShaderRays, SeeWhatDiffuseRaysSeeAndCountAllAsOpaque) {
  const std::string ceiling = " Translate 0 0 -0.5 Disk 0 50 360";
  EXPECT_NEAR(middle("\"surroundings\"", "Opacity [0.1 0.1 0.1]" + ceiling).y, 0.5, 1e-4);
  EXPECT_EQ(middle("\"surroundings\"", "Attribute \"visibility\" \"int diffuse\" [0]" + ceiling).y, 4);
  EXPECT_NEAR(middle("\"surroundings\"",
                     "Attribute \"visibility\" \"int specular\" [0] \"int transmission\" [0]" + ceiling)
                  .y,
              0.5, 1e-4);
}

TEST(ShaderRays, BeginElsewhereInView) {
  // From (2, 0, -3) along z: a ball about (2, 0, 0) of radius 1 is met after 2.
  const std::string ball = "Translate 2 0 0 Sphere 1 -1 1 360";
  EXPECT_EQ(middle("\"elsewhere\" \"point origin\" [2 0 -3]", ball), Rgb(0, 1, 1));
  EXPECT_EQ(middle("\"elsewhere\" \"point origin\" [2 0 -3] \"float maximum\" [1.99]", ball), Rgb(0, 1, 0));
  EXPECT_EQ(middle("\"elsewhere\" \"point origin\" [2 1.01 -3]", ball), Rgb(0, 1, 0));
}

TEST(ShaderRays, AreCountedAndAreTheSameInAllModesAndWithAnyNumberOfThreads) {
  const std::string disc = "Translate 0 0 -0.4 Disk 0 0.5 360";
  const Rgb direct = middle("\"surroundings\"", disc);
  const double rays = statistic("Shaders/surroundings/radiosity/rays"),
               points = statistic("Shaders/surroundings/radiosity/points");
  EXPECT_GT(points, 0);
  EXPECT_EQ(rays, 255 * points);
  EXPECT_EQ(statistic("Shaders/rays traced"), rays);
  EXPECT_EQ(statistic("Shaders/rays refused"), 0);
  for (const char* mode : {"direct", "radiosity", "distribution", "points", "path"})
    for (const int threads : {2, 3}) {
      const Rgb other = middle("\"surroundings\"", disc, mode, threads);
      // Where rays are shaded instead of vertices, other points count.
      const bool same = std::string(mode) != "path";
      EXPECT_NEAR(other.x, direct.x, same ? 0 : kShare) << mode;
      EXPECT_NEAR(other.y, direct.y, same ? 0 : 1e-4f) << mode;
    }
  // Rays that reach nowhere are not traced, and shaders without rays have none.
  middle("\"elsewhere\"", disc);
  EXPECT_EQ(statistic("Shaders/elsewhere/view/rays"), statistic("Shaders/elsewhere/view/points"));
  middle("\"matte\"", disc);
  EXPECT_EQ(statistic("Shaders/rays traced"), 0);
}

}  // namespace
}  // namespace patina
