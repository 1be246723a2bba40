// SPDX-License-Identifier: Apache-2.0
// Pictures of principled's bump and normal maps: the light on flat sheets against the normals that the maps'
// formulas give, and maps that say nothing, which change nothing.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <numbers>

#include "tests/unit/integrators_render.h"
#include "tests/unit/texture_files.h"

namespace patina {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kSize = 48;
constexpr double kHalf = 1.2;  // of the picture's width

V3d unit(const V3d& v) { return v / v.length(); }
const V3d kFrom(-2, 3, -6);

class NormalMaps : public testing::Test {
 protected:
  NormalMaps() {
    std::string name = testing::TempDir() + "patina-normal-maps-XXXXXX";
    folder_ = mkdtemp(name.data());
  }
  ~NormalMaps() override { std::filesystem::remove_all(folder_); }

  std::vector<Rgb> render(const std::string& world, const std::string& mode = "direct", int samples = 64) {
    RenderSettings settings;
    settings.mode = mode, settings.samples = samples, settings.shadeAtHits = true;
    settings.texturePath = folder_;
    return renderPicture(
        "Display \"x\" \"file\" \"rgb\" Format 48 48 1 PixelFilter \"box\" 1 1 PixelSamples 8 8\n"
        "Projection \"orthographic\" ScreenWindow -1.2 1.2 -1.2 1.2 ShadingRate 0.06 Translate 0 0 5\n"
        "WorldBegin LightSource \"distantlight\" 1 \"from\" [-2 3 -6] \"to\" [0 0 0]\n"
        "Color [1 1 1] Surface \"matte\" \"Ka\" [0]\n" +
            world + "\nWorldEnd\n",
        settings);
  }

  /// The light at each pixel that looks at the sheet's inside against the cosine of `normal(x, y)`.
  void expectLight(const std::vector<Rgb>& picture, const std::function<bool(double, double)>& inside,
                   const std::function<V3d(double, double)>& normal, double tolerance,
                   const std::string& what) {
    ASSERT_EQ(picture.size(), size_t{kSize * kSize});
    int judged = 0;
    double worst = 0, least = 1, most = 0;
    for (int j = 0; j < kSize; ++j)
      for (int i = 0; i < kSize; ++i) {
        constexpr int kGrid = 8;
        double value = 0;
        bool all = true;
        for (int k = 0; k < kGrid * kGrid; ++k) {
          const double x = kHalf * (2 * (i + (k % kGrid + 0.5) / kGrid) / kSize - 1),
                       y = kHalf * (1 - 2 * (j + (k / kGrid + 0.5) / kGrid) / kSize);
          all &= inside(x, y);
          value += std::max(unit(normal(x, y)).dot(unit(kFrom)), 0.0) / (kGrid * kGrid);
        }
        if (!all) continue;
        const double got = double(picture[size_t(j * kSize + i)].x);
        worst = std::max(worst, std::abs(got - value));
        least = std::min(least, value), most = std::max(most, value);
        ++judged;
      }
    EXPECT_LT(worst, tolerance) << what << ": light from " << least << " to " << most;
    EXPECT_GT(judged, 200) << what;
  }

  std::string folder_;
};

/// A sheet in the plane z = 0, its outside towards -z, with s and t that are linear in x and y.
struct Sheet {
  const char* name;
  const char* rib;
  V3d origin, s, t;  // P at (0, 0), and its derivatives
  V3d coordinates(double x, double y) const {
    const double det = s.x * t.y - s.y * t.x, dx = x - origin.x, dy = y - origin.y;
    return {(dx * t.y - dy * t.x) / det, (dy * s.x - dx * s.y) / det, 0};
  }
  /// Of a height h(s, t) along -z: the gradient in x and y by the chain rule.
  V3d bent(double hs, double ht) const {
    const double det = s.x * t.y - s.y * t.x;
    return unit(V3d(-(hs * t.y - ht * s.y) / det, -(-hs * t.x + ht * s.x) / det, -1));
  }
};

const Sheet kSheets[] = {
    {"square",
     "Patch \"bilinear\" \"P\" [-1 1 0  1 1 0  -1 -1 0  1 -1 0]",
     {-1, 1, 0},
     {2, 0, 0},
     {0, -2, 0}},
    {"oblique",
     "Patch \"bilinear\" \"P\" [-1 0.8 0  0.6 1.1 0  -0.6 -1 0  1 -0.7 0]",
     {-1, 0.8, 0},
     {1.6, 0.3, 0},
     {0.4, -1.8, 0}},
    {"mirrored",
     "Scale -1 1 1 Patch \"bilinear\" \"P\" [-1 1 0  1 1 0  -1 -1 0  1 -1 0]",
     {1, 1, 0},
     {-2, 0, 0},
     {0, -2, 0}},
    {"of patches",
     "PatchMesh \"bilinear\" 3 \"nonperiodic\" 2 \"nonperiodic\" \"P\" [-1 1 0  0 1 0  1 1 0  "
     "-1 -1 0  0 -1 0  1 -1 0]",
     {-1, 1, 0},
     {2, 0, 0},
     {0, -2, 0}},
    {"of a polygon", "Polygon \"P\" [-1 -1 0  -1 1 0  1 1 0  1 -1 0]", {0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
    // s and t that run otherwise than u and v: turned by a right angle, and at any angle.
    {"with turned s, t",
     "Patch \"bilinear\" \"P\" [-1 1 0  1 1 0  -1 -1 0  1 -1 0] \"varying float[2] st\" [0 1  0 0  1 1  1 0]",
     {1, 1, 0},
     {0, -2, 0},
     {-2, 0, 0}},
    {"of triangles with s, t",
     "PointsPolygons [3 3] [0 1 2 2 1 3] \"P\" [-1 1 0  1 1 0  -1 -1 0  1 -1 0] \"vertex float[2] st\" "
     "[0.15 1.55  1.55 1.0833333  -0.55 -0.0833333  0.85 -0.55]",
     {-0.35714286, -0.71428571, 0},
     {1.25, 0.35714286, 0},
     {-0.53571429, 1.07142857, 0}}};

constexpr double kDepth = 0.2;
double wave(double s, double t) { return 0.5 + 0.25 * std::sin(4 * kPi * s) * std::cos(2 * kPi * t); }

TEST_F(NormalMaps, BumpsBendNormalsByTheGradientOfTheirHeights) {
  constexpr int kTexels = 256;
  test::writeTiff32(folder_ + "/bump.tif", kTexels, kTexels, [](int x, int y) {
    const auto h = float(wave((x + 0.5) / kTexels, (y + 0.5) / kTexels));
    return std::array<float, 3>{h, h, h};
  });
  for (const Sheet& sheet : kSheets) {
    const std::vector<Rgb> picture =
        render("Displacement \"principled\" \"string bumpmap\" [\"bump.tif\"] \"float bumpdepth\" [0.2]\n" +
               std::string(sheet.rib));
    const bool repeats = std::string(sheet.name) == "of a polygon";  // s, t from -1 to 1
    expectLight(
        picture,
        [&](double x, double y) {
          const V3d at = sheet.coordinates(x, y);
          const double low = repeats ? -0.99 : 0.01;
          return at.x > low && at.x < 0.99 && at.y > low && at.y < 0.99;
        },
        [&](double x, double y) {
          const V3d at = sheet.coordinates(x, y);
          return sheet.bent(kDepth * kPi * std::cos(4 * kPi * at.x) * std::cos(2 * kPi * at.y),
                            -kDepth * 0.5 * kPi * std::sin(4 * kPi * at.x) * std::sin(2 * kPi * at.y));
        },
        0.005, sheet.name);
  }
}

TEST_F(NormalMaps, NormalsOfTheMapTurnAlongSAndT) {
  const V3d n = unit(V3d(0.3, -0.2, 0.9));
  test::writeTiff32(folder_ + "/turned.tif", 8, 8, [&](int, int) {
    return std::array<float, 3>{float(0.5 + 0.5 * n.x), float(0.5 + 0.5 * n.y), float(0.5 + 0.5 * n.z)};
  });
  for (const Sheet& sheet : kSheets) {
    const V3d expected = unit(unit(sheet.s) * n.x + unit(sheet.t) * n.y + V3d(0, 0, -n.z));
    const std::vector<Rgb> picture =
        render("Displacement \"principled\" \"string normalmap\" [\"turned.tif\"]\n" + std::string(sheet.rib),
               "direct", 16);
    const bool repeats = std::string(sheet.name) == "of a polygon";
    expectLight(
        picture,
        [&](double x, double y) {
          const V3d at = sheet.coordinates(x, y);
          return at.x > (repeats ? -0.99 : 0.01) && at.x < 0.99 && at.y > (repeats ? -0.99 : 0.01) &&
                 at.y < 0.99;
        },
        [&](double, double) { return expected; }, 2e-4, sheet.name);
  }
}

TEST_F(NormalMaps, MapsThatSayNothingChangeNothing) {
  test::writeTiff32(folder_ + "/flat.tif", 8, 8, [](int, int) {
    return std::array<float, 3>{0.5f, 0.5f, 1};
  });
  const std::string looks =
      " \"float roughness\" [0.3] \"float coat\" [1] \"color basecolor\" [0.7 0.3 0.2]\n";
  const std::string map =
      "Displacement \"principled\" \"string normalmap\" [\"flat.tif\"] \"string bumpmap\" "
      "[\"flat.tif\"]\n";
  const std::string surface = "Surface \"principled\"" + looks;
  const std::string card = "Patch \"bilinear\" \"P\" [-1 1 0  1 1 0  -1 -1 0  1 -1 0]",
                    ball = "Rotate -60 1 0 0 Sphere 1 -1 1 360";
  // Differences of pixels, ascending.
  const auto differences = [](const std::vector<Rgb>& a, const std::vector<Rgb>& b) {
    EXPECT_EQ(a.size(), b.size());
    std::vector<float> all;
    for (size_t i = 0; i < std::min(a.size(), b.size()); ++i)
      all.push_back(std::abs(a[i].x - b[i].x) / (0.05f + a[i].x));
    std::ranges::sort(all);
    return all;
  };
  for (const char* mode : {"direct", "path"}) {
    const auto flat = differences(render(surface + card, mode, 4), render(map + surface + card, mode, 4));
    EXPECT_LT(flat.back(), 2e-6f) << mode;
    // What is displaced is its facets, with normals at their vertices that are exact to 7e-5 (packNormal):
    // other samples meet the ball's edge, cross its terminator, and miss the middle of its highlight.
    const auto round = differences(render(surface + ball, mode, 4), render(map + surface + ball, mode, 4));
    EXPECT_LT(round[round.size() / 2], 1e-4f) << mode;
    EXPECT_LT(round[round.size() * 97 / 100], 6e-3f) << mode;
  }
}

}  // namespace
}  // namespace patina
