// SPDX-License-Identifier: Apache-2.0
// Spherical, distant and environment lights; filters.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "tests/stress/closed_forms.h"

namespace patina::stress {
namespace {

constexpr double kPi = std::numbers::pi;

/// Irradiance over pi from a sphere of radius 1 and radiance 1, its centre at distance d and the cosine c
/// from the normal, cut by the horizon (Snyder, "Area light sources for real-time graphics", MSR-TR-96-11,
/// 1996; Lagarde and de Rousiers, "Moving Frostbite to PBR", SIGGRAPH 2014 course, listing 7).
double sphereFactor(double d, double c) {
  const double h2 = d * d;
  if (h2 * c * c > 1) return std::max(c, 0.0) / h2;
  const double s = std::sqrt(1 - c * c), x = std::sqrt(h2 - 1), y = -x * c / s;
  const double root = s * std::sqrt(std::max(1 - y * y, 0.0));
  return ((c * std::acos(std::clamp(y, -1.0, 1.0)) - x * root) / h2 + std::atan(root / x)) / kPi;
}

struct Ball {
  const char* name;
  V3d center;      // of a sphere of radius 1 above, through or below the plane y = 0
  double x, half;  // the window
};

void addSpheres(std::vector<ClosedForm>& cases) {
  // A floor of just the window's size: the rest of the sphere may lie below.
  const Ball balls[] = {{"at distance 100", {0, 100, 0}, 0, 0.1},
                        {"at distance 3", {0, 3, 0}, 0, 0.1},
                        {"at distance 1.01", {0, 1.01, 0}, 0, 0.005},
                        {"touching the floor, 0.05 to 0.35 from there", {0, 1, 0}, 0.2, 0.15},
                        {"oblique", {2, 1.5, 0}, 0, 0.1},
                        {"half below the horizon", {2, 0, 0}, 0, 0.1},
                        {"centre above the horizon", {2, 0.6, 0}, 0, 0.1},
                        {"centre below the horizon", {2, -0.5, 0}, 0, 0.1},
                        {"half below, 0.01 beside", {1.11, 0, 0}, 0, 0.1}};
  for (const Ball& ball : balls) {
    ClosedForm c;
    c.group = "spherical light";
    c.name = ball.name;
    c.formula = "Snyder's formula; (R / d)^2 cos where all of it is above";
    c.expected = overWindow(
        [&](double x, double z) {
          const V3d to = ball.center - V3d(x, 0, z);
          return sphereFactor(to.length(), to.y / to.length());
        },
        c.width, c.height, ball.x, 0, ball.half, ball.half, 8);
    const double lower = std::max(ball.center.y - 1, 0.0);
    const double above = lower > 0 ? lower / 2 : 1e-4;
    const double x0 = ball.x - ball.half, x1 = ball.x + ball.half;
    c.rib = format(c.width, c.height) + lookDown(ball.x, above, 0, ball.half, ball.half) +
            "WorldBegin Attribute \"trace\" \"int maxdiffusedepth\" [0] Surface \"matte\" \"Kd\" [1]\n" +
            fmt::format(
                "AttributeBegin AreaLightSource \"arealight\" 1\nTranslate {} {} {} Sphere 1 -1 1 360\n"
                "AttributeEnd Illuminate 1 1\n",
                ball.center.x, ball.center.y, ball.center.z) +
            polygon({{x0, 0, -ball.half}, {x0, 0, ball.half}, {x1, 0, ball.half}, {x1, 0, -ball.half}}) +
            "WorldEnd\n";
    c.samples = ball.center.y < 0 ? 128 : 16;
    const double between = ball.half > 0.12 || ball.center.x > 1 ? 0.01 : 2e-3;
    const char* reason = "values between the camera's vertices; facets of the sphere";
    c.claims = {{"path", 1e-3, "facets of the sphere"},
                {"direct", between, reason},
                {"distribution", between, reason},
                {"radiosity", between, reason},
                {"points", between, reason}};
    c.converges = ball.center.y == 0.6;
    cases.push_back(std::move(c));
  }
}

void addSkies(std::vector<ClosedForm>& cases) {
  const auto add = [&](const std::string& name, const std::string& formula, const std::string& light,
                       double expected, double bias, bool points, double pointsBias) {
    ClosedForm c;
    c.group = "distant and environment lights";
    c.name = name;
    c.formula = formula;
    c.rib = format(c.width, c.height) + lookDown(0, 0.5, 0, 0.01, 0.01) + "WorldBegin\n" + light +
            "Attribute \"trace\" \"int maxdiffusedepth\" [1] Surface \"matte\" \"Kd\" [1]\n" +
            polygon({{-1, 0, -1}, {-1, 0, 1}, {1, 0, 1}, {1, 0, -1}}) + "WorldEnd\n";
    c.expected.assign(64, expected);
    c.samples = 16;
    const char* reason = bias > 1e-4 ? "the disc's facets" : "rounding";
    c.claims = {{"path", bias, reason}, {"distribution", bias, reason}, {"radiosity", bias, reason}};
    if (points)
      c.claims.push_back({"points", pointsBias, pointsBias > 1e-3 ? "a raster of 16 x 16 pixels" : reason});
    if (name.find("distant") == 0) c.claims.push_back({"direct", bias, reason});
    c.converges = name.find("full angle 60") != std::string::npos || name.find("below") != std::string::npos;
    cases.push_back(std::move(c));
  };
  for (const double degrees : {0.0, 60.0, 85.0}) {
    const double a = degrees * kPi / 180;
    const std::string from = fmt::format("\"from\" [{} {} 0] \"to\" [0 0 0]", std::sin(a), std::cos(a));
    add(fmt::format("distant, {} degrees from the normal", degrees), "Cl cos",
        "LightSource \"distantlight\" 1 " + from + "\n", std::cos(a), 1e-4, true, 1e-4);
  }
  add("distant, full angle 60 degrees", "Cl cos",
      "LightSource \"distantlight\" 1 \"float angle\" [60] \"from\" [1 1.5 0] \"to\" [0 0 0]\n",
      1.5 / std::sqrt(3.25), 1e-4, true, 1e-4);
  add("distant, full angle 180 degrees, overhead", "Cl",
      "LightSource \"distantlight\" 1 \"float angle\" [180] \"from\" [0 1 0] \"to\" [0 0 0]\n", 1, 1e-4, true,
      1e-4);
  add("even sky", "L", "LightSource \"envlight\" 1\n", 1, 1e-4, true, 0.01);
  add("even sky, a black disc of radius 1 at height 1 below it", "1 - a^2 / (a^2 + h^2)",
      "LightSource \"envlight\" 1\nAttributeBegin Color [0 0 0] Surface \"constant\" Translate 0 1 0 Rotate "
      "90 1 0 0 Disk 0 1 360 "
      "AttributeEnd\n",
      0.5, 3e-3, true, 0.03);
}

// ---- Filters ----------------------------------------------------------------------------------------------

/// RI 3.2, appendix E: RiBoxFilter and so on, of widths w.
double filterWeight(const std::string& name, double x, double y, double w) {
  if (std::abs(x) >= w / 2 || std::abs(y) >= w / 2) return 0;
  if (name == "box") return 1;
  if (name == "triangle") return (1 - 2 * std::abs(x) / w) * (1 - 2 * std::abs(y) / w);
  if (name == "sinc") {
    const auto axis = [&](double d) {
      return d == 0 ? 1 : std::sin(kPi * d) / (kPi * d) * std::cos(kPi * d / w);
    };
    return axis(x) * axis(y);
  }
  if (name == "gaussian") return std::exp(-2 * (4 * x * x / (w * w) + 4 * y * y / (w * w)));
  const double r = std::hypot(x, y);
  return r >= 2 ? 0 : r < 1 ? 1.5 * r * r * r - 2.5 * r * r + 1 : -0.5 * r * r * r + 2.5 * r * r - 4 * r + 2;
}

/// A straight edge of light across the pixels: what the filter has on the bright side of it.
void addFilters(std::vector<ClosedForm>& cases) {
  struct Filter {
    const char* name;
    double width;
  };
  for (const Filter f : {Filter{"box", 1}, Filter{"box", 3}, Filter{"triangle", 2}, Filter{"gaussian", 2},
                         Filter{"gaussian", 4}, Filter{"catmull-rom", 4}, Filter{"sinc", 4}}) {
    ClosedForm c;
    c.group = "filters";
    c.name = fmt::format("{} of width {}, an edge", f.name, f.width);
    c.formula = "the filter's part beyond the edge (RI 3.2, appendix E)";
    c.width = 12, c.height = 8, c.block = 1;
    // The edge is 5.3 pixels from the left, and slanted by 0.25 pixels per row.
    const auto edgeAt = [](double y) { return 4.3 + 0.25 * y; };
    constexpr int kSteps = 400;
    for (int j = 0; j < c.height; ++j)
      for (int i = 0; i < c.width; ++i) {
        double lit = 0, all = 0;
        for (int n = 0; n < kSteps * kSteps; ++n) {
          const double dx = f.width * ((n % kSteps + 0.5) / kSteps - 0.5),
                       dy = f.width * ((n / kSteps + 0.5) / kSteps - 0.5);
          const double w = filterWeight(f.name, dx, dy, f.width);
          all += w;
          if (i + 0.5 + dx > edgeAt(j + 0.5 + dy)) lit += w;
        }
        c.expected.push_back(lit / all);
      }
    // One unit is a pixel, y = 0 its upper edge.
    c.rib =
        fmt::format(
            "Format 12 8 1 PixelFilter \"{0}\" {1} {1}\nProjection \"orthographic\" ScreenWindow 0 12 -8 0\n"
            "WorldBegin Surface \"constant\"\nTranslate 0 0 1 ",
            f.name, f.width) +
        polygon({{edgeAt(-9), 9, 0}, {edgeAt(17), -17, 0}, {60, -17, 0}, {60, 9, 0}}) + "WorldEnd\n";
    c.samples = 64;
    c.claims = {{"path", 2e-3, "weights' sum is of the samples that there are"},
                {"radiosity", 2e-3, "weights' sum is of the samples that there are"}};
    c.converges = f.width == 4;
    cases.push_back(c);

    // What is the same everywhere stays so, however negative some weights are.
    c.name = fmt::format("{} of width {}, constant", f.name, f.width);
    c.formula = "L";
    c.expected.assign(c.expected.size(), 1);
    c.rib =
        fmt::format(
            "Format 12 8 1 PixelFilter \"{0}\" {1} {1}\nProjection \"orthographic\" ScreenWindow 0 12 -8 0\n"
            "WorldBegin Surface \"constant\"\nTranslate 0 0 1 ",
            f.name, f.width) +
        polygon({{-60, 9, 0}, {-60, -17, 0}, {60, -17, 0}, {60, 9, 0}}) + "WorldEnd\n";
    c.samples = 4;
    c.claims = {{"path", 1e-6, "rounding"}, {"radiosity", 1e-6, "rounding"}};
    c.converges = false;
    cases.push_back(std::move(c));
  }
}

}  // namespace

void addLights(std::vector<ClosedForm>& cases) {
  addSpheres(cases);
  addSkies(cases);
}

void addSignals(std::vector<ClosedForm>& cases) { addFilters(cases); }

}  // namespace patina::stress
