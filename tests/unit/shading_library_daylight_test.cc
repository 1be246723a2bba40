// SPDX-License-Identifier: Apache-2.0
// sunsky against the formulas of Preetham, Shirley and Smits 1999, integrals of its own radiance, and what
// is known of daylight.
#include <cmath>
#include <numbers>
#include <random>

#include "tests/unit/chi_square.h"
#include "tests/unit/plugins/bound_shader.h"

namespace patina::test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180;

Triple fromAngles(double zenith, double azimuth) {
  return {float(std::sin(zenith) * std::cos(azimuth)), float(std::sin(zenith) * std::sin(azimuth)),
          float(std::cos(zenith))};
}
double luminance(const Triple& c) {
  return 0.2126729 * double(c[0]) + 0.7151522 * double(c[1]) + 0.0721750 * double(c[2]);
}

/// CIE x and y of linear Rec.709, by the primaries of the standard.
std::array<double, 2> chromaticity(const Triple& c) {
  const double r = double(c[0]), g = double(c[1]), b = double(c[2]);
  const double X = 0.4124564 * r + 0.3575761 * g + 0.1804375 * b, Y = luminance(c),
               Z = 0.0193339 * r + 0.1191920 * g + 0.9503041 * b;
  return {X / (X + Y + Z), Y / (X + Y + Z)};
}

struct Answers {
  std::vector<Triple> directions, radiance;
  std::vector<float> pdf;
};

Answers evaluated(const BoundShader& shader, std::vector<Triple> directions) {
  const auto count = uint32_t(directions.size());
  Batch batch = shader.batch(count);
  batch.lightIn.task = PATINA_LIGHT_EVALUATE;
  batch.lightIn.P = batch.uniform({0, 0, 0});
  batch.lightIn.direction = batch.varying3([&](uint32_t i) { return directions[i]; });
  PatinaLightOut out = batch.lightOut();
  EXPECT_EQ(shader->light(batch.lightIn, out), PATINA_OK);
  Answers answers{std::move(directions), {}, {out.pdf, out.pdf + count}};
  for (uint32_t i = 0; i < count; ++i) answers.radiance.push_back(get(out.radiance, i));
  return answers;
}

Answers sampled(const BoundShader& shader, uint32_t count, uint32_t seed = 7) {
  Batch batch = shader.batch(count);
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0, 1);
  batch.lightIn.task = PATINA_LIGHT_SAMPLE;
  batch.lightIn.P = batch.uniform({0, 0, 0});
  batch.lightIn.random_x = batch.varying([&](uint32_t) { return uniform(random); });
  batch.lightIn.random_y = batch.varying([&](uint32_t) { return uniform(random); });
  PatinaLightOut out = batch.lightOut();
  EXPECT_EQ(shader->light(batch.lightIn, out), PATINA_OK);
  Answers answers{{}, {}, {out.pdf, out.pdf + count}};
  for (uint32_t i = 0; i < count; ++i) {
    answers.radiance.push_back(get(out.radiance, i));
    answers.directions.push_back(get(out.direction, i));
  }
  return answers;
}

std::vector<ShaderArgument> daylight(float turbidity, const Triple& sun,
                                     std::vector<ShaderArgument> more = {}) {
  more.push_back(number("intensity", 1));
  more.push_back(number("turbidity", turbidity));
  more.push_back(triple("sundirection", ValueType::Vector, sun));
  return more;
}

/// Luminance in kcd/m^2 of the paper's sky (equation 3, appendix A.2).
double paperLuminance(double T, double sunAngle, double zenithAngle, double fromSun) {
  const double A = 0.1787 * T - 1.4630, B = -0.3554 * T + 0.4275, C = -0.0227 * T + 5.3251,
               D = 0.1206 * T - 2.5771, E = -0.0670 * T + 0.3703;
  const auto F = [&](double theta, double gamma) {
    return (1 + A * std::exp(B / std::cos(theta))) *
           (1 + C * std::exp(D * gamma) + E * std::cos(gamma) * std::cos(gamma));
  };
  const double chi = (4.0 / 9 - T / 120) * (kPi - 2 * sunAngle);
  const double zenith = (4.0453 * T - 4.9710) * std::tan(chi) - 0.2155 * T + 2.4192;
  return zenith * F(zenithAngle, fromSun) / F(0, sunAngle);
}

TEST(SunSky, SkyIsThePapers) {
  for (const double T : {2.0, 3.0, 6.0})
    for (const double sunAngle : {20 * kDegree, 50 * kDegree, 75 * kDegree}) {
      const Triple sun = fromAngles(sunAngle, 0.4);
      const BoundShader shader("sunsky", daylight(float(T), sun, {number("sun", 0)}));
      std::vector<std::array<double, 2>> angles{{0, 0}};
      for (const double theta : {0.3, 0.9, 1.4})
        for (const double phi : {-2.0, 0.0, 1.1}) angles.push_back({theta, phi});
      std::vector<Triple> directions;
      for (const auto& [theta, phi] : angles) directions.push_back(fromAngles(theta, phi));
      const Answers got = evaluated(shader, directions);
      for (size_t i = 0; i < directions.size(); ++i) {
        double cosine = 0;
        for (size_t k = 0; k < 3; ++k) cosine += double(directions[i][k]) * double(sun[k]);
        const double expected = paperLuminance(T, sunAngle, angles[i][0], std::acos(std::min(cosine, 1.0)));
        // The shader computes in single precision; a colour outside of Rec.709 would change its luminance.
        if (std::min({got.radiance[i][0], got.radiance[i][1], got.radiance[i][2]}) == 0) continue;
        EXPECT_NEAR(luminance(got.radiance[i]), expected, 1e-3 * expected)
            << "turbidity " << T << " sun " << sunAngle << " at " << angles[i][0] << ',' << angles[i][1];
      }
      EXPECT_GT(std::min({got.radiance[0][0], got.radiance[0][1], got.radiance[0][2]}), 0);
      // Chromaticity of the zenith: the paper's matrices, turbidity by powers of the sun's angle.
      const double t = sunAngle, T2 = T * T;
      const auto cubic = [&](double a, double b, double c, double d) {
        return ((a * t + b) * t + c) * t + d;
      };
      const double x = T2 * cubic(0.00166, -0.00375, 0.00209, 0) +
                       T * cubic(-0.02903, 0.06377, -0.03202, 0.00394) +
                       cubic(0.11693, -0.21196, 0.06052, 0.25886);
      const double y = T2 * cubic(0.00275, -0.00610, 0.00317, 0) +
                       T * cubic(-0.04214, 0.08970, -0.04153, 0.00516) +
                       cubic(0.15346, -0.26756, 0.06670, 0.26688);
      EXPECT_NEAR(chromaticity(got.radiance[0])[0], x, 1e-4);
      EXPECT_NEAR(chromaticity(got.radiance[0])[1], y, 1e-4);
    }
}

/// Irradiance of a level surface from above the horizon, by quadrature of the radiance. The sun's disc is
/// to be wide enough for the grid.
Triple levelIrradiance(const BoundShader& shader) {
  constexpr int kHeights = 400, kAround = 800;
  std::vector<Triple> directions;
  for (int i = 0; i < kHeights; ++i)  // equal steps of sin^2: equal projected solid angles
    for (int k = 0; k < kAround; ++k)
      directions.push_back(
          fromAngles(std::asin(std::sqrt((i + 0.5) / kHeights)), 2 * kPi * (k + 0.5) / kAround));
  const Answers got = evaluated(shader, std::move(directions));
  Triple sum{};
  for (const Triple& c : got.radiance)
    for (size_t k = 0; k < 3; ++k) sum[k] += c[k] * float(kPi / (kHeights * kAround));
  return sum;
}

TEST(SunSky, SamplesGiveTheIrradianceOfALevelSurface) {
  for (const float turbidity : {2.5f, 6.0f}) {
    const BoundShader shader("sunsky", daylight(turbidity, fromAngles(0.9, 2.0), {number("sunangle", 10)}));
    const Triple expected = levelIrradiance(shader);
    constexpr uint32_t kCount = 200000;
    const Answers got = sampled(shader, kCount);
    double sum = 0, squares = 0;
    for (uint32_t i = 0; i < kCount; ++i) {
      const double value =
          luminance(got.radiance[i]) * std::max(double(got.directions[i][2]), 0.0) / double(got.pdf[i]);
      sum += value, squares += value * value;
    }
    const double mean = sum / kCount, error = std::sqrt((squares / kCount - mean * mean) / kCount);
    // Four standard errors, and the quadrature's error at the disc's edge.
    EXPECT_NEAR(mean, luminance(expected), 4 * error + 1e-3 * mean);
    EXPECT_LT(error * std::sqrt(kCount), 1.2 * mean);  // sampled by importance: uniform directions have 12
  }
}

TEST(SunSky, GroundReflectsWhatFallsOnIt) {
  const BoundShader shader(
      "sunsky",
      daylight(3, fromAngles(0.7, 1.0),
               {number("sunangle", 10), triple("groundalbedo", ValueType::Color, {0.4f, 0.2f, 0.1f})}));
  const Triple irradiance = levelIrradiance(shader);
  const Answers down = evaluated(shader, {fromAngles(1.6, 0), fromAngles(3.0, 2)});
  for (const Triple& c : down.radiance)
    for (size_t k = 0; k < 3; ++k) {
      const double expected = double(irradiance[k]) * std::array{0.4, 0.2, 0.1}[k] / kPi;
      EXPECT_NEAR(c[k], expected, 2e-3 * expected);
    }
}

// Whatever the disc's angle, the light in it is the same.
TEST(SunSky, SunHasItsAngleAndKeepsItsLight) {
  const Triple sun = fromAngles(0.6, 0);
  double reference = 0;
  for (const float angle : {0.533f, 2.0f, 20.0f}) {
    const BoundShader shader("sunsky", daylight(3, sun, {number("sunangle", angle), number("sky", 0)}));
    const double half = double(angle) / 2 * kDegree;
    const Answers got =
        evaluated(shader, {fromAngles(0.6 - 0.99 * half, 0), fromAngles(0.6 + 0.99 * half, 0),
                           fromAngles(0.6 - 1.01 * half, 0), fromAngles(0.6 + 1.01 * half, 0)});
    EXPECT_EQ(got.radiance[0], got.radiance[1]);
    EXPECT_EQ(got.radiance[2], (Triple{0, 0, 0}));
    EXPECT_EQ(got.radiance[3], (Triple{0, 0, 0}));
    const double flux = luminance(got.radiance[0]) * 2 * kPi * (1 - std::cos(half));
    if (reference == 0) reference = flux;
    EXPECT_NEAR(flux, reference, 1e-4 * reference) << angle;
  }
  // A clear sky's sun, 56 degrees high, gives a surface that faces it 80 to 105 klx (CIE 110-1994 has about
  // 93 for an optical thickness of 0.2).
  EXPECT_GT(reference, 80);
  EXPECT_LT(reference, 105);
}

TEST(SunSky, DaylightIsWhiteAndSunsetsAreRed) {
  // Sun and sky together on a level surface: between the CIE's daylights D55 and D75 (x 0.3324 and 0.2990),
  // and on their locus within 0.015 (y = -3 x^2 + 2.87 x - 0.275, CIE 15).
  const BoundShader noon("sunsky", daylight(3, fromAngles(0.6, 0), {number("sunangle", 10)}));
  const auto [x, y] = chromaticity(levelIrradiance(noon));
  EXPECT_GT(x, 0.2990);
  EXPECT_LT(x, 0.3324);
  EXPECT_NEAR(y, -3 * x * x + 2.87 * x - 0.275, 0.015);
  double last = 2;
  for (const double height : {40.0, 10.0, 2.0}) {  // the lower, the redder
    const Triple sun = fromAngles((90 - height) * kDegree, 0);
    const Triple c =
        evaluated(BoundShader("sunsky", daylight(3, sun, {number("sky", 0)})), {sun}).radiance[0];
    EXPECT_LT(double(c[2] / c[0]), 0.8 * last) << height;
    last = double(c[2] / c[0]);
  }
}

TEST(SunSky, FadesInTwilight) {
  double last = 1e9;
  for (const double below : {-1.0, 0.0, 3.0, 6.0}) {
    const BoundShader shader("sunsky", daylight(3, fromAngles((90 + below) * kDegree, 0)));
    const double now = luminance(evaluated(shader, {{0, 0, 1}}).radiance[0]);
    EXPECT_LT(now, last);
    EXPECT_GT(now, 0);
    last = now;
  }
  EXPECT_LT(last, 0.02);
}

// ---- Place and time --------------------------------------------------------------------------------------

/// Where the disc is, by the samples that are drawn in it.
Triple sunOf(std::vector<ShaderArgument> arguments, const M44d& space = M44d()) {
  arguments.push_back(number("sky", 0));
  arguments.push_back(triple("groundalbedo", ValueType::Color, {0, 0, 0}));
  const Answers got = sampled(BoundShader("sunsky", arguments, space), 64);
  Triple sum{};
  for (const Triple& d : got.directions)
    for (size_t k = 0; k < 3; ++k) sum[k] += d[k] / 64;
  return sum;
}

std::vector<ShaderArgument> at(float latitude, float longitude, float zone, float day, float time) {
  return {number("latitude", latitude), number("longitude", longitude), number("zone", zone),
          number("day", day), number("time", time)};
}
double heightOf(const Triple& d) { return std::asin(double(d[2])) / kDegree; }

// Heights at true noon are 90 - latitude + declination, and the sun is in the south; half a degree is twice
// what the paper's formulas are off, and the samples' mean lies within a twentieth of the disc.
TEST(SunSky, SunStandsWhereAstronomyHasIt) {
  const Triple summer = sunOf(at(51.48f, 0, 0, 172, 12.03f));
  EXPECT_NEAR(heightOf(summer), 90 - 51.48 + 23.44, 0.5);
  EXPECT_NEAR(summer[0], 0, 0.01);
  EXPECT_LT(summer[1], 0);
  EXPECT_NEAR(heightOf(sunOf(at(51.48f, 0, 0, 355, 11.97f))), 90 - 51.48 - 23.44, 0.5);
  // An equinox on the equator: overhead at noon. In the east in the morning, in the west in the evening: the
  // space of the test is left-handed as RI's, with y north and z up x is west.
  EXPECT_NEAR(heightOf(sunOf(at(0, 0, 0, 80, 12.12f))), 90, 1);
  EXPECT_LT(sunOf(at(0, 0, 0, 80, 8))[0], -0.8);
  EXPECT_GT(sunOf(at(0, 0, 0, 80, 16))[0], 0.8);
  M44d mirrored;
  mirrored.setScale(V3d(-1, 1, 1));  // right-handed: x is east, and world's x still to the right
  EXPECT_LT(sunOf(at(0, 0, 0, 80, 8), mirrored)[0], -0.8);
  // New York at 9 h Eastern Standard Time on 14 November, with the almanac's declination of -18.2 degrees and
  // equation of time of 15.6 minutes.
  const double latitude = 40.71 * kDegree, declination = -18.2 * kDegree;
  const double hour = (9 + (75 - 74.01) / 15 + 15.6 / 60 - 12) * 15 * kDegree;
  const Triple york = sunOf(at(40.71f, -74.01f, -5, 318, 9));
  EXPECT_NEAR(heightOf(york),
              std::asin(std::sin(latitude) * std::sin(declination) +
                        std::cos(latitude) * std::cos(declination) * std::cos(hour)) /
                  kDegree,
              0.5);
  EXPECT_NEAR(-york[0], -std::cos(declination) * std::sin(hour), 0.01);
}

TEST(LightsChiSquare, Daylight) {
  Fits fits(1e-3);  // the horizon and the table's cells go through the grid's
  const auto fit = [&](const std::string& name, const Triple& sun, float angle) {
    const BoundShader shader("sunsky", daylight(3, sun, {number("sunangle", angle)}));
    // Rows that grow from the disc's own size: one with the disc, the others with the sky around it.
    const double half = double(angle) / 2 * kDegree;
    const SphereGrid grid = SphereGrid::narrow(V3f(sun[0], sun[1], sun[2]), 1 - std::cos(half));
    constexpr uint32_t kBatch = 1 << 12;
    Answers drawn;
    size_t used = 0;
    uint32_t seed = 0;
    fitDirections(
        fits, name, grid,
        [&](Independent&) {
          if (used == drawn.directions.size()) drawn = sampled(shader, kBatch, ++seed), used = 0;
          const Triple& d = drawn.directions[used++];
          return std::optional(V3f(d[0], d[1], d[2]));
        },
        [&](const V3f& w) {
          return evaluated(shader, {{w.x, w.y, w.z}}).pdf[0];
        });
  };
  fit("daylight", fromAngles(0.5, 1), 0.533f);
}

}  // namespace
}  // namespace patina::test
