// SPDX-License-Identifier: Apache-2.0
// Pictures of what moves, and of what is out of focus, against closed forms; and what they cost.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "renderer/base/statistics.h"
#include "renderer/integrators/render.h"
#include "renderer/scene/scene_builder.h"

namespace patina {
namespace {

struct Picture {
  int width = 0, height = 0;
  std::vector<Rgb> color;
  std::vector<float> alpha;

  double sum(double (*weigh)(double x, double y), double centerX = 0, double centerY = 0) const {
    double total = 0;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        total += static_cast<double>(alpha[static_cast<size_t>(y * width + x)]) *
                 weigh(x + 0.5 - centerX, y + 0.5 - centerY);
    return total;
  }
  float alphaAt(int x, int y) const { return alpha[static_cast<size_t>(y * width + x)]; }
};

Picture render(const std::string& rib, const std::string& mode, int samples, int threads = 2) {
  std::vector<std::string> messages;
  ErrorHandler errors([&](Severity, std::string_view message) { messages.emplace_back(message); });
  RenderSettings settings;
  settings.mode = mode, settings.samples = samples, settings.threads = threads;
  settings.shaderPath = PATINA_BINARY_DIR "/lib/patina/shaders";
  Picture picture;
  SceneBuilder builder({}, errors, [&](Scene& scene) {
    resetStatistics();
    const auto film = renderFrame(scene, settings, errors);
    ASSERT_TRUE(film);
    picture.width = scene.options.xResolution, picture.height = scene.options.yResolution;
    for (int y = 0; y < picture.height; ++y)
      for (int x = 0; x < picture.width; ++x) {
        picture.color.emplace_back(film->value(x, y, 0), film->value(x, y, 1), film->value(x, y, 2));
        picture.alpha.push_back(film->value(x, y, 3));
      }
  });
  builder.readText(rib, "t.rib");
  for (const std::string& message : messages) ADD_FAILURE() << message;
  return picture;
}

double counter(const std::string& name) {
  for (const StatEntry& entry : statistics())
    if (entry.name == name) return entry.value;
  return 0;
}

double one(double, double) { return 1; }
double alongX(double x, double) { return x; }
double alongY(double, double y) { return y; }
double squareX(double x, double) { return x * x; }
double squareY(double, double y) { return y * y; }

const std::string kHead = "PixelFilter \"box\" 1 1 Surface \"constant\" Shutter 0 1 ";

/// The share of the shutter for which a disc of radius 0.3, whose centre goes from x = -0.5 to 0.5, covers a
/// pixel of a 32 x 32 raster over [-1, 1]^2: along x in closed form, over the pixel by 16 x 16 points.
double coverage(int column, int row) {
  double sum = 0;
  for (int j = 0; j < 16; ++j)
    for (int i = 0; i < 16; ++i) {
      const double x = (column + (i + 0.5) / 16) / 16 - 1, y = 1 - (row + (j + 0.5) / 16) / 16;
      if (std::abs(y) >= 0.3) continue;
      const double half = std::sqrt(0.09 - y * y);
      // Covered while |x - (t - 0.5)| < half.
      sum += std::max(0.0, std::min(1.0, x + 0.5 + half) - std::max(0.0, x + 0.5 - half));
    }
  return sum / 256;
}

TEST(MotionBlur, ADiscCoversPixelsForItsShareOfTheTime) {
  for (const char* mode : {"path", "radiosity", "direct"})
    for (const double opacity : {1.0, 0.5}) {
      const Picture p = render(
          kHead + "Format 32 32 1 WorldBegin Opacity [" + std::to_string(opacity) + " " +
              std::to_string(opacity) + " " + std::to_string(opacity) +
              "] MotionBegin [0 1] Translate -.5 0 1 Translate .5 0 1 MotionEnd Disk 0 .3 360 WorldEnd",
          mode, 256);
      double squares = 0, worst = 0, sum = 0, expected = 0;
      for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 32; ++x) {
          const double c = opacity * coverage(x, y), d = static_cast<double>(p.alphaAt(x, y)) - c;
          squares += d * d, worst = std::max(worst, std::abs(d));
          sum += static_cast<double>(p.alphaAt(x, y)), expected += c;
        }
      // 256 independent samples would have a standard deviation of at most 0.031. Facets of the disc stay
      // within an eightieth of a pixel of it, inside: of 4.8 pixels of radius that is at most 0.5 % of the
      // area.
      EXPECT_LT(std::sqrt(squares / 1024), 0.01) << mode << opacity;
      EXPECT_LT(worst, 0.1) << mode << opacity;
      EXPECT_NEAR(sum / expected, 0.9975, 0.003) << mode << opacity;
    }
}

TEST(MotionBlur, TheSameBitsForAnyNumberOfThreads) {
  const std::string rib =
      "Format 32 32 1 Shutter 0 1 Projection \"perspective\" MotionBegin [0 1] Translate 0 0 3 Translate .2 "
      "0 2 "
      "MotionEnd WorldBegin LightSource \"distantlight\" 1 Attribute \"trace\" \"int samplemotion\" [1] "
      "MotionBegin [0 1] Rotate 0 0 0 1 Rotate 90 0 0 1 MotionEnd Translate .5 0 0 Sphere .3 -.3 .3 360 "
      "Identity Polygon \"P\" [-2 -2 1 -2 2 1 2 2 1 2 -2 1] WorldEnd";
  for (const char* mode : {"path", "radiosity"})
    EXPECT_EQ(render(rib, mode, 4, 1).color, render(rib, mode, 4, 2).color) << mode;
}

TEST(MotionBlur, ASquareThatShadesWithSampleMotionCastsABlurredShadow) {
  // Light along +z; an occluder, unseen by the camera, over x from -0.5 to -0.1 moves by 0.6.
  for (const bool sampled : {false, true})
    for (const char* mode : {"path", "radiosity"}) {
      const Picture p = render(
          "PixelFilter \"box\" 1 1 Format 32 32 1 Shutter 0 1 WorldBegin LightSource \"distantlight\" 1 "
          "\"from\" [0 0 0] \"to\" [0 0 1] Surface \"matte\" \"float Kd\" [1] "
          "Polygon \"P\" [-2 -2 2 -2 2 2 2 2 2 2 -2 2] AttributeBegin Attribute \"visibility\" \"int "
          "camera\" [0] "
          "Attribute \"trace\" \"int samplemotion\" [" +
              std::to_string(sampled) +
              "] "
              "MotionBegin [0 1] Translate 0 0 0 Translate .6 0 0 MotionEnd "
              "Polygon \"P\" [-.5 -3 1 -.5 3 1 -.1 3 1 -.1 -3 1] AttributeEnd WorldEnd",
          mode, 64);
      for (int column = 0; column < 32; ++column) {
        const double x = (column + 0.5) / 16 - 1;
        double lit = 0;
        for (int row = 0; row < 32; ++row)
          lit += static_cast<double>(p.color[static_cast<size_t>(row * 32 + column)].x) / 32;
        const double dark =
            sampled ? std::max(0.0, std::min(1.0, (x + 0.5) / 0.6) - std::max(0.0, (x + 0.1) / 0.6))
                    : static_cast<double>(x > -0.5 && x < -0.1);
        // Columns at the edges of a hard shadow are partly lit.
        if (!sampled && (std::abs(x + 0.5) < 0.1 || std::abs(x + 0.1) < 0.1)) continue;
        EXPECT_NEAR(lit, 1 - dark, 0.06) << mode << " column " << column << " sampled " << sampled;
      }
    }
}

/// A ball with a pattern that moves, out of focus, above a floor that it lights and shades.
const std::string kBall =
    "Format 48 48 1 PixelFilter \"box\" 1 1 Shutter 0 1 DepthOfField 4 .6 3 Projection \"perspective\" "
    "\"fov\" [40] "
    "Translate 0 -.3 4 WorldBegin LightSource \"distantlight\" 1 \"from\" [1 3 -2] \"to\" [0 0 0] "
    "Surface \"matte\" \"float Kd\" [1] Color [.6 .5 .4] Polygon \"P\" [-5 -.5 -5 -5 -.5 5 5 -.5 5 5 -.5 -5] "
    "MotionBegin [0 .5 1] Translate -.6 0 0 Translate 0 .5 0 Translate .6 0 0 MotionEnd "
    "MotionBegin [0 1] Rotate 0 1 1 0 Rotate 150 1 1 0 MotionEnd AttributeBegin Surface \"showst\" "
    "Sphere .5 -.5 .5 360 AttributeEnd Color [.2 .9 .3] Translate 0 .8 0 Sphere .2 -.2 .2 360 WorldEnd";

TEST(MotionBlur, RadiosityAgreesWithPath) {
  const Picture path = render(kBall, "path", 256), radiosity = render(kBall, "radiosity", 64);
  Rgb sum(0, 0, 0), reference(0, 0, 0);
  double squares = 0;
  for (size_t k = 0; k < path.color.size(); ++k) {
    sum += radiosity.color[k], reference += path.color[k];
    squares += static_cast<double>((radiosity.color[k] - path.color[k]).length2()) / 3;
  }
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c] / reference[c], 1, 0.01) << c;
  // The noise of both: 64 samples of a spread of about 0.3 have a deviation of 0.04 where all is blurred.
  EXPECT_LT(std::sqrt(squares / static_cast<double>(path.color.size())), 0.03);
}

TEST(MotionBlur, SamplesDoNotMultiplyShading) {
  // By one thread, as two may make the same vertex.
  std::map<std::string, std::vector<double>> counts;
  for (const int samples : {4, 16, 64, 256}) {
    render(kBall, "radiosity", samples, 1);
    for (const char* name : {"points shaded from the cache's vertices", "gather rays"})
      counts[name].push_back(counter(std::string("Radiosity/") + name));
  }
  // What is new are vertices that few samples have missed, at silhouettes that move and are out of focus.
  const std::vector<double>& vertices = counts["points shaded from the cache's vertices"];
  EXPECT_GT(vertices[0], 1000);
  EXPECT_LT(vertices[1], vertices[0] * 1.2);
  EXPECT_LT(vertices[2], vertices[1] * 1.08);
  EXPECT_LT(vertices[3], vertices[2] * 1.03);
  // 64 times as many samples take little more of all else, too: where balls touch the floor's micropolygons
  // points are shaded one by one, but no more than some in each pixel.
  const std::vector<double>& rays = counts["gather rays"];
  EXPECT_LT(rays[3], rays[0] * 1.6);
}

/// Mean and spread of the picture of a small disc of radius `size` at depth z, out of focus.
struct Spot {
  double x, y, varianceX, varianceY, area;
};
Spot spotOf(const std::string& projection, double x, double y, double z, double size) {
  const auto text = [](double v) { return std::to_string(v) + " "; };
  const Picture p =
      render(kHead + "Format 96 96 1 DepthOfField 2 .4 3 " + projection + " WorldBegin Translate " + text(x) +
                 text(y) + text(z) + "Disk 0 " + text(size) + "360 WorldEnd",
             "path", 256);
  Spot s{};
  s.area = p.sum(one);
  s.x = p.sum(alongX) / s.area, s.y = p.sum(alongY) / s.area;
  s.varianceX = p.sum(squareX, s.x, s.y) / s.area, s.varianceY = p.sum(squareY, s.x, s.y) / s.area;
  return s;
}

/// A uniform disc of diameter d has the variance d^2/16 along x and along y; that of the spot is the sum of
/// the blur's, of the little disc's and of a pixel's (1/12).
double diameterOf(double variance, double radius) {
  return 4 * std::sqrt(variance - radius * radius / 4 - 1.0 / 12);
}

TEST(DepthOfField, CircleOfConfusionInPerspective) {
  // RI 3.2, DepthOfField: a lens of focal length f and diameter f/fstop, focussed at d, makes of a point at z
  // a circle whose diameter, seen from the lens, is f/fstop * |1/z - 1/d|. A unit at depth 1 covers 48
  // pixels.
  for (const double z : {2.0, 3.0, 6.0}) {
    const double x = 0.1 * z, y = -0.2 * z, radius = 1.5;  // of the disc, pixels
    const Spot s = spotOf("Projection \"perspective\" \"fov\" [90]", x, y, z, radius / 48 * z);
    const double expected = 48 * 0.2 * std::abs(1 / z - 1.0 / 3) * 1.0;
    EXPECT_NEAR(s.x, 48 + 4.8, 0.05) << z;
    EXPECT_NEAR(s.y, 48 + 9.6, 0.05) << z;
    EXPECT_NEAR(s.area, std::numbers::pi * radius * radius, 0.35) << z;
    if (expected == 0) {
      EXPECT_NEAR(s.varianceX, radius * radius / 4 + 1.0 / 12, 0.05);
      continue;
    }
    EXPECT_NEAR(diameterOf(s.varianceX, radius) / expected, 1, 0.05) << z;
    EXPECT_NEAR(diameterOf(s.varianceY, radius) / expected, 1, 0.05) << z;
  }
}

TEST(DepthOfField, CircleOfConfusionInOrthographicViews) {
  // Rays through a point of the plane of focus fill a cone as wide as the lens at the camera: at depth z it
  // is |z - d| / d of that, whatever the scale of the picture.
  for (const double z : {1.0, 5.0}) {
    const double radius = 1.5;
    const Spot s = spotOf("Projection \"orthographic\"", 0.25, 0.125, z, radius / 48);
    const double expected = 48 * 0.2 * std::abs(z - 3) / 3;
    EXPECT_NEAR(s.x, 48 + 12, 0.05) << z;
    EXPECT_NEAR(s.y, 48 - 6, 0.05) << z;
    EXPECT_NEAR(diameterOf(s.varianceX, radius) / expected, 1, 0.05) << z;
    EXPECT_NEAR(diameterOf(s.varianceY, radius) / expected, 1, 0.05) << z;
  }
}

TEST(MotionBlur, TheCameraMovesToo) {
  // The camera goes to the left by 1 while the disc stands still: the same streak as of a disc that moves.
  const Picture p =
      render(kHead +
                 "Format 32 32 1 MotionBegin [0 1] Translate -.5 0 0 Translate .5 0 0 MotionEnd "
                 "WorldBegin Translate 0 0 1 Disk 0 .3 360 WorldEnd",
             "radiosity", 256);
  double squares = 0;
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x) {
      const double d = static_cast<double>(p.alphaAt(x, y)) - coverage(x, y);
      squares += d * d;
    }
  EXPECT_LT(std::sqrt(squares / 1024), 0.01);
  EXPECT_EQ(counter("Motion/moving placements"), 0);
}

}  // namespace
}  // namespace patina
