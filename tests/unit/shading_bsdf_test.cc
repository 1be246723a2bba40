// SPDX-License-Identifier: Apache-2.0
// Lobes: what sample() draws is what evaluate() says, densities integrate to one, and no lobe makes energy.
#include "renderer/shading/bsdf.h"

#include <gtest/gtest.h>

#include <string>

#include "patina/shader.h"
#include "renderer/base/sampling.h"

namespace patina {
namespace {

struct Case {
  std::string name;
  SurfaceTerms terms;
  std::vector<Lobe> lobes;
  bool conserves;  // may reflect no more than arrives
};

Lobe lobe(uint32_t type, float alpha, float eta = 1) {
  Lobe l;
  l.type = type, l.alpha = alpha, l.eta = eta;
  l.weight = Rgb(1, 1, 1);
  if (type == PATINA_LOBE_DIELECTRIC) l.transmission = Rgb(1, 1, 1);
  return l;
}

std::vector<Case> cases() {
  SurfaceTerms none, matte, leaf;
  matte.reflectance = Rgb(0.8f, 0.8f, 0.8f);
  leaf.reflectance = Rgb(0.5f, 0.5f, 0.5f), leaf.transmittance = Rgb(0.4f, 0.4f, 0.4f);
  return {{"matte", matte, {}, true},
          {"leaf", leaf, {}, true},
          {"ggx 0.1", none, {lobe(PATINA_LOBE_GGX, 0.1f)}, true},
          {"ggx 0.5", none, {lobe(PATINA_LOBE_GGX, 0.5f)}, true},
          {"ggx 1", none, {lobe(PATINA_LOBE_GGX, 1)}, true},
          {"dielectric 1.5", none, {lobe(PATINA_LOBE_DIELECTRIC, 0.3f, 1.5f)}, false},
          {"dielectric 1/1.5", none, {lobe(PATINA_LOBE_DIELECTRIC, 0.3f, 1 / 1.5f)}, false},
          {"specular", none, {lobe(PATINA_LOBE_RI_SPECULAR, 0.8f)}, false},
          {"mixture", matte, {lobe(PATINA_LOBE_GGX, 0.3f), lobe(PATINA_LOBE_RI_SPECULAR, 1)}, false}};
}

ShadingPoint pointSeenAt(float degrees) {
  ShadingPoint p;
  p.Ng = p.N = V3f(0, 0, 1);
  p.I = -V3f(std::sin(degrees * kPi / 180), 0, std::cos(degrees * kPi / 180));
  return p;
}

/// Integrals over the sphere of f |cos| (mean of channels) and of the density, by a fine grid in (cos theta,
/// phi).
std::pair<double, double> integrate(const Bsdf& bsdf) {
  constexpr int kSteps = 1000;
  double f = 0, pdf = 0;
  for (int j = 0; j < kSteps; ++j)
    for (int i = 0; i < kSteps; ++i) {
      const float z = 1 - 2 * (static_cast<float>(j) + 0.5f) / kSteps,
                  phi = 2 * kPi * (static_cast<float>(i) + 0.5f) / kSteps;
      const float r = std::sqrt(1 - z * z);
      const Bsdf::Value v = bsdf.evaluate({r * std::cos(phi), r * std::sin(phi), z});
      f += v.f.x, pdf += v.pdf;
    }
  const double cell = 4 * std::numbers::pi / (double{kSteps} * kSteps);
  return {f * cell, pdf * cell};
}

TEST(Bsdf, SamplesAgreeWithEvaluation) {
  for (const Case& c : cases())
    for (const float degrees : {0.0f, 40.0f, 75.0f}) {
      const ShadingPoint point = pointSeenAt(degrees);
      const Bsdf bsdf(point, c.terms, c.lobes);
      const auto [albedo, total] = integrate(bsdf);
      double weight = 0, drawn = 0;
      constexpr uint32_t kSamples = 1 << 15;
      for (uint32_t k = 0; k < kSamples; ++k) {
        const BsdfSample s = bsdf.sample(sobol1(k, 5), sobol2(k, 6));
        if (s.pdf == 0) continue;
        ASSERT_NEAR(s.direction.length(), 1, 1e-4f);
        ASSERT_EQ(s.transmitted, s.direction.z < 0) << c.name;
        weight += s.weight.x, drawn += 1;
      }
      SCOPED_TRACE(c.name + " at " + std::to_string(degrees));
      // The quadrature resolves the narrowest lobe to half a per cent.
      EXPECT_NEAR(weight / kSamples, albedo, 0.01 * albedo + 1e-3);
      EXPECT_NEAR(drawn / kSamples, total, 0.012);
      EXPECT_LE(total, 1.01);
      if (c.conserves) {
        EXPECT_LE(albedo, 1.001);
      }
    }
}

TEST(Bsdf, RoughConductorsLoseOnlyWhatSingleScatteringLoses) {
  // At normal incidence the albedo is a single integral: half angles have the cumulative t^2 / (t^2 +
  // alpha^2) in their tangent t, light goes to twice the angle and is shadowed by G1 there, or lost below the
  // horizon beyond t = 1.
  const ShadingPoint point = pointSeenAt(0);
  const SurfaceTerms none;
  for (const float alpha : {0.1f, 0.5f, 1.0f}) {
    double expected = 0;
    constexpr int kSteps = 100000;
    const double a2 = double{alpha} * double{alpha}, largest = 1 / (1 + a2);
    for (int k = 0; k < kSteps; ++k) {
      const double c = largest * (k + 0.5) / kSteps, t2 = a2 * c / (1 - c);
      const double tangent = 2 * std::sqrt(t2) / (1 - t2);  // of the doubled angle
      expected += largest / kSteps / (1 + (std::sqrt(1 + a2 * tangent * tangent) - 1) / 2);
    }
    const std::vector<Lobe> lobes{lobe(PATINA_LOBE_GGX, alpha)};
    EXPECT_NEAR(integrate(Bsdf(point, none, lobes)).first, expected, 0.005) << alpha;
  }
}

TEST(Bsdf, SmoothGlassSplitsLightByFresnel) {
  // Normal incidence, ior 1.5: R = ((1.5 - 1) / (1.5 + 1))^2 = 0.04; refracted radiance scales with 1
  // / 1.5^2.
  const ShadingPoint point = pointSeenAt(0);
  const SurfaceTerms none;
  const std::vector<Lobe> lobes{lobe(PATINA_LOBE_DIELECTRIC, 0, 1.5f)};
  const Bsdf bsdf(point, none, lobes);
  const BsdfSample reflected = bsdf.sample(0.01f, {0.5f, 0.5f}), refracted = bsdf.sample(0.5f, {0.5f, 0.5f});
  EXPECT_FALSE(reflected.transmitted);
  EXPECT_TRUE(refracted.transmitted);
  EXPECT_TRUE(reflected.delta && refracted.delta);
  EXPECT_NEAR(fresnelDielectric(1, 1.5f), 0.04f, 1e-6f);
  EXPECT_NEAR(refracted.weight.x, 1 / 2.25f, 1e-5f);
  EXPECT_NEAR(reflected.weight.x, 1, 1e-5f);
  EXPECT_EQ(fresnelDielectric(0.1f, 1 / 1.5f), 1) << "total internal reflection";
}

TEST(Bsdf, NothingGivesNothing) {
  const ShadingPoint point = pointSeenAt(30);
  const SurfaceTerms none;
  const Bsdf bsdf(point, none, {});
  EXPECT_TRUE(bsdf.isBlack());
  EXPECT_EQ(bsdf.sample(0.5f, {0.5f, 0.5f}).pdf, 0);
  EXPECT_EQ(bsdf.evaluate({0, 0, 1}).pdf, 0);
}

}  // namespace
}  // namespace patina
