// SPDX-License-Identifier: Apache-2.0
// Light that cannot get out: closed surfaces whose radiosity is the same everywhere, or nearly so; and things
// that reflect all of an even light, which cannot be seen.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "tests/stress/closed_forms.h"

namespace patina::stress {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExact = "every path carries the same light: rounding";
constexpr const char* kFacets = "edges of facets: a few paths in a million get out";

/// Of the light of each bounce, in spheres of few surfels: n bounces multiply it.
constexpr double kPointsLoss = 0.01;
constexpr const char* kPointsReason = "1 % of each bounce, by surfels and rasters of 16 x 16 pixels";

const char* const kBox =
    "PointsPolygons [4 4 4 4 4 4] [0 2 3 1 4 5 7 6 0 1 5 4 2 6 7 3 0 4 6 2 1 3 7 5] "
    "\"P\" [-1 -1 -1 1 -1 -1 -1 1 -1 1 1 -1 -1 -1 1 1 -1 1 -1 1 1 1 1 1]\n";

std::string inside(int size) { return format(size, size) + "Projection \"perspective\" \"fov\" [90]\n"; }

std::string glow(double albedo, double emission, int depth) {
  return fmt::format(
      "Attribute \"trace\" \"int maxdiffusedepth\" [{}] Color [{} {} {}]\n"
      "Surface \"matte\" \"Kd\" [1] \"color emission\" [{} {} {}]\n",
      depth, albedo, albedo, albedo, emission, emission, emission);
}

/// Emission 1 - rho makes 1 after all bounces, of which there are so many that 1e-4 is left out at most.
void addAlbedos(std::vector<ClosedForm>& cases) {
  for (const double albedo : {0.1, 0.5, 0.9, 0.99})
    for (const bool box : {true, false}) {
      ClosedForm c;
      c.group = "furnace";
      c.name = fmt::format("{}, albedo {}", box ? "box" : "sphere", albedo);
      c.formula = "M / (1 - rho), M = 1 - rho";
      const int depth = static_cast<int>(std::ceil(std::log(1e-4) / std::log(albedo)));
      c.rib = inside(c.width) + "WorldBegin\n" + glow(albedo, 1 - albedo, depth) +
              (box ? kBox : "Sphere 1 -1 1 360\n") + "WorldEnd\n";
      c.expected.assign(64, 1);
      c.samples = albedo > 0.8 ? 64 : 4;
      c.claims = {{"path", 5e-4, "1e-4 beyond the last bounce; facets' edges"},
                  {"distribution", 5e-3, "hits nearer than a vertex's spacing"},
                  {"radiosity", 5e-3, "values between cached vertices"},
                  {"points", kPointsLoss * albedo / (1 - albedo * (1 - kPointsLoss)), kPointsReason, nullptr,
                   albedo > 0.8}};
      // The other two modes' tails go on with a chance of 0.95 at most: above an albedo of 0.975 their
      // variance has no bound.
      if (albedo > 0.95) c.claims = {c.claims[0], c.claims[3]};
      c.converges = albedo == 0.5;
      cases.push_back(std::move(c));
    }
}

/// The shapes of the folder watertight, with four bounces: no noise.
void addShapes(std::vector<ClosedForm>& cases) {
  constexpr double kAlbedo = 0.8, kEmission = 0.2;
  constexpr int kBounces = 4;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(PATINA_SOURCE_DIR "/tests/stress/watertight"))
    if (entry.path().extension() == ".rib") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    ClosedForm c;
    c.group = "closed shapes";
    c.name = file.stem().string();
    c.formula = "M (1 + rho + ... + rho^4)";
    c.rib = contents(file.string());
    c.rib.insert(c.rib.find("WorldBegin") + 10, "\n" + glow(kAlbedo, kEmission, kBounces));
    c.adjust = [size = c.width](Scene& scene) {
      scene.camera.worldToCamera.makeIdentity();
      scene.camera.fov = 90, scene.camera.screenWindow = {-1, 1, -1, 1};
      scene.options.xResolution = scene.options.yResolution = size;
      scene.options.filter = "box", scene.options.filterWidthX = scene.options.filterWidthY = 1;
    };
    c.expected.assign(64, kEmission * (1 - std::pow(kAlbedo, kBounces + 1)) / (1 - kAlbedo));
    c.claims = {{"path", 5e-4, kFacets}, {"distribution", 5e-3, kFacets}, {"radiosity", 5e-3, kFacets}};
    cases.push_back(std::move(c));
  }
}

/// Of bands of a sphere, by their lower and upper z, with an emission each.
struct Band {
  double low, high, emission;
};
constexpr Band kBands[] = {{-1, -0.5, 0.1}, {-0.5, 0.2, 0.8}, {0.2, 0.6, 0.3}, {0.6, 1, 1.5}};

/// Everything inside of a sphere sees the same mean of all: B = M + rho mean(M) (1 + rho + ... + rho^(n -
/// 1)).
void addUneven(std::vector<ClosedForm>& cases) {
  constexpr double kAlbedo = 0.6;
  double mean = 0;
  for (const Band& b : kBands) mean += b.emission * (b.high - b.low) / 2;
  for (const int bounces : {0, 1, 2, 3, 20}) {
    ClosedForm c;
    c.group = "sphere with uneven emission";
    c.name = bounces == 20 ? "all bounces" : fmt::format("bounce {}", bounces);
    c.formula = "M + rho mean(M) (1 - rho^n) / (1 - rho)";
    c.rib = inside(c.width) + "Rotate -90 1 0 0\nWorldBegin\n";
    for (const Band& b : kBands)
      c.rib += glow(kAlbedo, b.emission, bounces) + fmt::format("Sphere 1 {} {} 360\n", b.low, b.high);
    c.rib += "WorldEnd\n";
    // The camera's y is z of the sphere, or its opposite: the sign is that of Rotate.
    constexpr int kGrid = 16;
    for (int j = 0; j < c.height; ++j)
      for (int i = 0; i < c.width; ++i) {
        double sum = 0;
        for (int k = 0; k < kGrid * kGrid; ++k) {
          const double x = 2 * (i + (k % kGrid + 0.5) / kGrid) / c.width - 1,
                       y = 1 - 2 * (j + (k / kGrid + 0.5) / kGrid) / c.height;
          const double z = y / std::sqrt(x * x + y * y + 1);
          for (const Band& b : kBands) sum += z >= b.low && z < b.high ? b.emission : 0;
        }
        c.expected.push_back(sum / (kGrid * kGrid) +
                             kAlbedo * mean * (1 - std::pow(kAlbedo, bounces)) / (1 - kAlbedo));
      }
    c.samples = 16;
    c.claims = {{"path", 2e-3, "edges of bands in 16 x 16 points of a pixel"},
                {"distribution", 0.01, "the same; values between vertices"},
                {"radiosity", 0.01, "the same; values between vertices"}};
    if (bounces > 0)
      c.claims.push_back(
          {"points", kPointsLoss * kAlbedo / (1 - kAlbedo * (1 - kPointsLoss)), kPointsReason});
    if (bounces == 0) c.claims.push_back({"direct", 2e-3, "edges of bands in 16 x 16 points of a pixel"});
    c.converges = bounces == 1;
    cases.push_back(std::move(c));
  }
}

/// What reflects or lets through all of an even light looks like it; what reflects half of it, like half.
void addMirrors(std::vector<ClosedForm>& cases) {
  const auto add = [&](const std::string& name, const std::string& surface, double expected,
                       const char* geometry, const std::string& formula) {
    ClosedForm c;
    c.group = "mirrors and glass";
    c.name = name;
    c.formula = formula;
    c.rib = format(c.width, c.height) +
            "Projection \"perspective\" \"fov\" [18] Translate 0 0 3\nWorldBegin\n"
            "LightSource \"envlight\" 1 \"lightcolor\" [1 1 1]\n"
            "Attribute \"trace\" \"int maxspeculardepth\" [100]\n" +
            surface + "\n" + geometry + "WorldEnd\n";
    c.expected.assign(64, expected);
    c.samples = 16;
    c.claims = {{"path", 1e-3, "100 refractions at most"},
                {"distribution", 1e-3, "100 refractions at most"},
                {"radiosity", 1e-3, "100 refractions at most"}};
    cases.push_back(std::move(c));
  };
  const char* ball = "Sphere 1 -1 1 360\n";
  const char* cube = "Rotate 30 1 2 3 Scale .8 .8 .8\n";
  for (const double reflectance : {0.5, 1.0})
    add(fmt::format("conductor, reflectance {}", reflectance),
        fmt::format("Surface \"conductor\" \"float alpha\" [0] \"color reflectance\" [{0} {0} {0}]",
                    reflectance),
        reflectance, ball, "reflectance");
  for (const double ior : {1.1, 1.5, 2.4}) {
    const std::string glass = fmt::format("Surface \"dielectric\" \"float ior\" [{}]", ior);
    add(fmt::format("dielectric ball, index {}", ior), glass, 1, ball, "reflection and refraction add up");
    add(fmt::format("dielectric cube, index {}", ior), glass, 1, (std::string(cube) + kBox).c_str(),
        "reflection and refraction add up");
  }
}

}  // namespace

void addFurnaces(std::vector<ClosedForm>& cases) {
  addAlbedos(cases);
  addShapes(cases);
  addUneven(cases);
  addMirrors(cases);
}

}  // namespace patina::stress
