// SPDX-License-Identifier: Apache-2.0
// Light from polygons and discs, by bounces and by light samples.
#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tests/stress/closed_forms.h"

namespace patina::stress {
namespace {

constexpr double kPi = std::numbers::pi;

// A polygon of radiance 1: as a surface that glows, found by diffuse rays; or as an area light, found by
// shadow rays.
std::string glowing(const std::vector<V3d>& corners) {
  return "AttributeBegin Color [0 0 0] Surface \"matte\" \"color emission\" [1 1 1]\n" + polygon(corners) +
         "AttributeEnd\n";
}
std::string shining(const std::string& geometry) {
  return "AttributeBegin AreaLightSource \"arealight\" 1 \"int sides\" [2]\n" + geometry +
         "AttributeEnd Illuminate 1 1\n";
}

std::vector<Claim> byBounces() {
  return {{"path", 2e-4, "rounding"},
          {"distribution", 0.01, "values between the camera's vertices"},
          {"radiosity", 0.01, "values between the camera's vertices"},
          {"points", 0.03, "a raster of 16 x 16 pixels"}};
}
std::vector<Claim> byLights(double between) {
  const char* reason = "values between the camera's vertices";
  return {{"path", 2e-4, "rounding"},
          {"direct", between, reason},
          {"distribution", between, reason},
          {"radiosity", between, reason},
          {"points", between, reason}};
}

/// Radiosity of a white floor y = 0 under polygons, in a window around (x, z).
ClosedForm floorUnder(const std::vector<V3d>& light, bool isLight, double x, double z, double half,
                      double above) {
  ClosedForm c;
  c.expected = overWindow(
      [&](double px, double pz) {
        return polygonIrradiance({px, 0, pz}, {0, 1, 0}, light) / kPi;
      },
      c.width, c.height, x, z, half, half);
  const V3d low(x - half, 0, z - half), high(x + half, 0, z + half);
  c.rib = format(c.width, c.height) + lookDown(x, above, z, half, half) +
          "WorldBegin Attribute \"trace\" \"int maxdiffusedepth\" [1] Surface \"matte\" \"Kd\" [1]\n" +
          (isLight ? shining(polygon(light)) : glowing(light)) +
          polygon({low, {low.x, 0, high.z}, high, {high.x, 0, low.z}}) + "WorldEnd\n";
  c.samples = isLight ? 16 : 64;
  return c;
}

double meanOf(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

/// Opposite unit squares at distance 1, and two that share an edge.
void addRectangles(std::vector<ClosedForm>& cases) {
  // Form factors: Howell, "A catalog of radiation heat transfer configuration factors", C-11 and C-14.
  const double parallel = 0.199824895698, perpendicular = 0.200043776075;
  for (const bool faces : {true, false})
    for (const bool light : {false, true}) {
      const std::vector<V3d> emitter = faces ? std::vector<V3d>{{0, 1, 0}, {0, 1, 1}, {1, 1, 1}, {1, 1, 0}}
                                             : std::vector<V3d>{{0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1}};
      ClosedForm c = floorUnder(emitter, light, 0.5, 0.5, 0.5, 0.5);
      const double factor = faces ? parallel : perpendicular;
      if (std::abs(meanOf(c.expected) / factor - 1) > 2e-3)
        throw std::runtime_error("Lambert's formula and the form factor disagree");
      c.group = "rectangles";
      c.name = fmt::format("{}, {}", faces ? "parallel" : "perpendicular", light ? "area light" : "glowing");
      c.formula = fmt::format("Lambert's formula; its mean is the form factor {:.5f}", factor);
      c.claims = light ? byLights(0.02) : byBounces();
      c.converges = true;
      if (!light && !faces)
        for (Claim& claim : c.claims)
          if (claim.bias > 2e-4) claim.bias = 0.03, claim.reason = "vertices in the corner between the two";
      cases.push_back(std::move(c));
    }
}

/// Triangles anywhere, one of them partly below the horizon. The light that is below would meet the floor
/// from beneath.
void addPolygons(std::vector<ClosedForm>& cases) {
  const std::vector<V3d> high{{-0.7, 0.9, -0.3}, {0.8, 1.4, -0.5}, {0.2, 0.6, 1.1}},
      low{{0.5, -0.6, -0.8}, {0.7, 1.2, 0.1}, {0.4, -0.3, 0.9}};
  for (const bool whole : {true, false})
    for (const bool light : {true, false}) {
      const std::vector<V3d>& emitter = whole ? high : low;
      ClosedForm c = floorUnder(emitter, light, 0, 0, 0.2, 0.1);
      c.group = "polygons";
      c.name = fmt::format("triangle{}, {}", whole ? "" : " partly below the horizon",
                           light ? "area light" : "glowing");
      c.formula = "Lambert's formula";
      c.claims = light ? byLights(5e-3) : byBounces();
      c.converges = whole;
      cases.push_back(std::move(c));
    }
}

/// Through the centre of a disc of radius a at height h: a^2 / (a^2 + h^2).
void addDiscs(std::vector<ClosedForm>& cases) {
  for (const double a : {0.1, 1.0, 10.0}) {
    ClosedForm c;
    c.group = "disc above a point";
    c.name = fmt::format("radius {} at height 1", a);
    c.formula = "a^2 / (a^2 + h^2)";
    constexpr double kHalf = 0.01;
    c.rib = format(c.width, c.height) + lookDown(0, 0.5, 0, kHalf, kHalf) +
            "WorldBegin Surface \"matte\" \"Kd\" [1]\n" +
            shining(fmt::format("Translate 0 1 0 Rotate 90 1 0 0 Disk 0 {} 360\n", a)) +
            polygon({{-kHalf, 0, -kHalf}, {-kHalf, 0, kHalf}, {kHalf, 0, kHalf}, {kHalf, 0, -kHalf}}) +
            "WorldEnd\n";
    c.expected.assign(64, a * a / (a * a + 1));
    c.samples = 16;
    if (a > 1) c.lightSamples = 1024;  // picked by area, of which little is above the point
    c.claims = byLights(1e-3);
    for (Claim& claim : c.claims) claim.bias = 2e-3, claim.reason = "the disc's facets; the window's width";
    c.converges = a == 1;
    cases.push_back(std::move(c));
  }
}

/// Irradiance at (x, 0, 0) from the part x' > -x of a disc of radius a and radiance 1 at height h above 0:
/// what a half plane x < 0 at half the height lets through. By the midpoint rule in polar coordinates.
double halfDisc(double x, double a, double h) {
  constexpr int kRings = 160, kSectors = 320;
  double sum = 0;
  for (int i = 0; i < kRings; ++i)
    for (int k = 0; k < kSectors; ++k) {
      const double r = a * (i + 0.5) / kRings, phi = 2 * kPi * (k + 0.5) / kSectors;
      const double lx = r * std::cos(phi), ly = r * std::sin(phi);
      // The edge's shadow passes through the cell: its part that is lit.
      const double width = a / kRings;
      const double part = std::clamp((lx + x) / width + 0.5, 0.0, 1.0);
      const double d2 = (lx - x) * (lx - x) + ly * ly + h * h;
      sum += part * h * h / (d2 * d2) * r;
    }
  return sum * (a / kRings) * (2 * kPi / kSectors);
}

void addPenumbra(std::vector<ClosedForm>& cases) {
  ClosedForm c;
  c.group = "penumbra";
  c.name = "disc light half covered by a half plane";
  c.formula = "integral over what is seen of the disc; half of a^2 / (a^2 + h^2) in the middle";
  constexpr double kRadius = 0.5, kHalf = 0.6;
  c.width = 48, c.height = 6, c.block = 3;
  const double thin = kHalf * c.height / c.width;
  const auto profile = overWindow([&](double x, double) { return halfDisc(x, kRadius, 1) / kPi; }, c.width, 1,
                                  0, 0, kHalf, thin, 2);
  for (int j = 0; j < c.height; ++j)
    for (const double v : profile) c.expected.push_back(v);
  const double middle = halfDisc(0, kRadius, 1) / kPi, half = kRadius * kRadius / (1 + kRadius * kRadius) / 2;
  if (std::abs(middle / half - 1) > 2e-3) throw std::runtime_error("the penumbra's middle is not half of it");
  c.rib = format(c.width, c.height) + lookDown(0, 0.25, 0, kHalf, thin) +
          "WorldBegin Surface \"matte\" \"Kd\" [1]\n" +
          shining(fmt::format("Translate 0 1 0 Rotate 90 1 0 0 Disk 0 {} 360\n", kRadius)) +
          polygon({{-1, 0, -1}, {-1, 0, 1}, {1, 0, 1}, {1, 0, -1}}) + "Color [0 0 0]\n" +
          polygon({{-9, 0.5, -9}, {-9, 0.5, 9}, {0, 0.5, 9}, {0, 0.5, -9}}) + "WorldEnd\n";
  c.samples = 64;
  c.claims = byLights(0.01);
  c.claims[0].bias = 5e-3, c.claims[0].reason = "pixels are 0.1 high: off the axis by so much";
  c.converges = true;
  cases.push_back(std::move(c));
}

}  // namespace

void addFormFactors(std::vector<ClosedForm>& cases) {
  addRectangles(cases);
  addPolygons(cases);
  addDiscs(cases);
  addPenumbra(cases);
}

}  // namespace patina::stress
