// SPDX-License-Identifier: Apache-2.0
// Chi-square tests of directions that lobes and their mixtures draw. Delta lobes have no density: they count
// as the share of samples that none is expected for.
#include "patina/shader.h"
#include "renderer/shading/bsdf.h"
#include "tests/unit/chi_square.h"

namespace patina::test {
namespace {

Lobe lobe(uint32_t type, float alpha, float eta = 1, float weight = 1, float transmission = 1) {
  Lobe l;
  l.type = type, l.alpha = alpha, l.eta = eta;
  l.weight = Rgb(weight);
  if (type == PATINA_LOBE_DIELECTRIC) l.transmission = Rgb(transmission);
  return l;
}

SurfaceTerms terms(float reflectance, float transmittance = 0) {
  SurfaceTerms t;
  t.reflectance = Rgb(reflectance), t.transmittance = Rgb(transmittance);
  return t;
}

/// Away from the axis: `degrees` from +z, turned by `around` degrees.
V3f direction(float degrees, float around = 0) {
  const float theta = degrees * kPi / 180, phi = around * kPi / 180;
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

/// Seen from +x, `degrees` from the geometric normal; the shading normal is elsewhere if `N` says so.
ShadingPoint pointSeenAt(float degrees, const V3f& N = {0, 0, 1}) {
  ShadingPoint p;
  p.Ng = V3f(0, 0, 1), p.N = N;
  p.I = -direction(degrees, 17);
  return p;
}

/// Around an axis in rows that grow from the width of a lobe of roughness alpha.
SphereGrid around(const V3f& axis, float alpha) {
  return SphereGrid::narrow(axis, std::max(2 * double{alpha} * double{alpha}, 1e-7));
}
V3f mirrored(const ShadingPoint& p) {
  const V3f wo = -p.I;
  return (p.N * (2 * wo.dot(p.N)) - wo).normalized();
}

void fit(Fits& fits, const std::string& name, const SphereGrid& grid, const Bsdf& bsdf) {
  fitDirections(
      fits, name, grid,
      [&](Independent& random) -> std::optional<V3f> {
        const float choice = random.next();
        const BsdfSample s = bsdf.sample(choice, random.next2());
        if (s.pdf == 0 || s.delta) return std::nullopt;
        return s.direction;
      },
      [&](const V3f& wi) { return bsdf.evaluate(wi).pdf; });
}

void fitLobe(Fits& fits, const std::string& name, const Lobe& l, const ShadingPoint& point) {
  const SurfaceTerms none;
  const std::vector<Lobe> lobes{l};
  const float width = l.type == PATINA_LOBE_RI_SPECULAR ? std::sqrt(l.alpha / 4) : l.alpha;
  fit(fits, name, around(mirrored(point), width), Bsdf(point, none, lobes));
}

const float kAngles[] = {0, 45, 75, 88};
const V3f kTilts[] = {direction(25, 0), direction(25, 140), direction(55, 60), direction(55, 230)};

std::string at(const std::string& name, float value, float degrees) {
  return name + " " + std::to_string(value) + " at " + std::to_string(degrees);
}

TEST(BsdfChiSquare, Diffuse) {
  Fits fits;
  const ShadingPoint point = pointSeenAt(40);
  const SurfaceTerms matte = terms(0.8f), leaf = terms(0.5f, 0.4f);
  fit(fits, "matte", SphereGrid::even(direction(20)), Bsdf(point, matte, {}));
  fit(fits, "leaf", SphereGrid::even(direction(20)), Bsdf(point, leaf, {}));
  for (const V3f& N : kTilts) {
    const ShadingPoint tilted = pointSeenAt(40, N);
    // The folded lobe's edge is the facet's horizon.
    fit(fits, at("tilted matte", N.x, N.y), SphereGrid::even(point.Ng), Bsdf(tilted, matte, {}));
    fit(fits, at("tilted leaf", N.x, N.y), SphereGrid::even(point.Ng), Bsdf(tilted, leaf, {}));
  }
}

TEST(BsdfChiSquare, GgxReflection) {
  Fits fits;
  for (const float alpha : {0.001f, 0.02f, 0.1f, 0.3f, 1.0f})
    for (const float degrees : kAngles)
      fitLobe(fits, at("ggx", alpha, degrees), lobe(PATINA_LOBE_GGX, alpha), pointSeenAt(degrees));
}

TEST(BsdfChiSquare, RiSpecular) {
  Fits fits;
  for (const float roughness : {0.01f, 0.1f, 0.5f, 2.0f})
    for (const float degrees : kAngles)
      fitLobe(fits, at("specular", roughness, degrees), lobe(PATINA_LOBE_RI_SPECULAR, roughness),
              pointSeenAt(degrees));
}

TEST(BsdfChiSquare, RoughDielectric) {
  Fits fits;
  const SurfaceTerms none;
  for (const float eta : {1.5f, 1 / 1.5f})
    for (const float alpha : {0.02f, 0.3f, 0.8f})
      for (const float degrees : {0.0f, 35.0f, 60.0f, 85.0f}) {
        const ShadingPoint point = pointSeenAt(degrees);
        const std::vector<Lobe> lobes{lobe(PATINA_LOBE_DIELECTRIC, alpha, eta)};
        const Bsdf bsdf(point, none, lobes);
        fit(fits, at("reflected", alpha + 10 * eta, degrees), around(mirrored(point), alpha), bsdf);
        // Around the refracted ray, or what is nearest to it.
        const V3f wo = -point.I;
        const V3f side = V3f(-wo.x, -wo.y, 0) / eta;
        const float below = std::max(1 - side.length2(), 0.0f);
        fit(fits, at("refracted", alpha + 10 * eta, degrees),
            around((side + V3f(0, 0, -std::sqrt(below))).normalized(), alpha), bsdf);
      }
}

// Lobes around a shading normal that is not the geometric one: what they lose below the horizon, or send to
// the wrong side, is drawn and found empty.
TEST(BsdfChiSquare, TiltedLobes) {
  Fits fits;
  for (const V3f& N : kTilts)
    for (const float degrees : {10.0f, 80.0f}) {  // some of these see the shading normal from behind
      const ShadingPoint point = pointSeenAt(degrees, N);
      const std::string where = std::to_string(N.x) + std::to_string(N.y);
      fitLobe(fits, at("ggx " + where, 0.3f, degrees), lobe(PATINA_LOBE_GGX, 0.3f), point);
      fitLobe(fits, at("specular " + where, 0.3f, degrees), lobe(PATINA_LOBE_RI_SPECULAR, 0.3f), point);
      fitLobe(fits, at("glass " + where, 0.3f, degrees), lobe(PATINA_LOBE_DIELECTRIC, 0.3f, 1.5f), point);
      // From behind, refraction into thinner matter is squeezed into a band too narrow for the quadrature.
      if (N.dot(point.I) < 0)
        fitLobe(fits, at("air " + where, 0.3f, degrees), lobe(PATINA_LOBE_DIELECTRIC, 0.3f, 1 / 1.5f), point);
    }
}

TEST(BsdfChiSquare, Mixtures) {
  struct Mixture {
    std::string name;
    SurfaceTerms terms;
    std::vector<Lobe> lobes;
  };
  const std::vector<Mixture> mixtures{
      {"plastic", terms(0.5f), {lobe(PATINA_LOBE_RI_SPECULAR, 0.1f, 1, 0.5f)}},
      {"coated", terms(0.6f), {lobe(PATINA_LOBE_GGX, 0.2f, 1, 0.2f)}},
      {"two lobes", terms(0), {lobe(PATINA_LOBE_GGX, 0.1f, 1, 0.3f), lobe(PATINA_LOBE_GGX, 0.7f, 1, 0.6f)}},
      {"leaf under glass", terms(0.3f, 0.2f), {lobe(PATINA_LOBE_DIELECTRIC, 0.3f, 1.5f, 0.8f, 0.5f)}},
      {"everything",
       terms(0.2f, 0.1f),
       {lobe(PATINA_LOBE_RI_SPECULAR, 0.5f, 1, 0.2f), lobe(PATINA_LOBE_DIELECTRIC, 0.4f, 1.3f, 0.2f, 0.4f),
        lobe(PATINA_LOBE_GGX, 0.2f, 1, 0.3f)}},
      {"with a mirror",
       terms(0.5f),
       {lobe(PATINA_LOBE_GGX, 0, 1, 0.3f), lobe(PATINA_LOBE_GGX, 0.3f, 1, 0.2f)}}};
  Fits fits;
  for (const Mixture& m : mixtures)
    for (const float degrees : {0.0f, 45.0f, 80.0f}) {
      const ShadingPoint point = pointSeenAt(degrees);
      const Bsdf bsdf(point, m.terms, m.lobes);
      fit(fits, at(m.name, 0, degrees), around(mirrored(point), 0.2f), bsdf);
      fitDirections(
          fits, at(m.name + ", lobes alone", 0, degrees), around(mirrored(point), 0.2f),
          [&](Independent& random) -> std::optional<V3f> {
            const float choice = random.next();
            const BsdfSample s = bsdf.sampleSpecular(choice, random.next2());
            if (s.pdf == 0 || s.delta) return std::nullopt;
            return s.direction;
          },
          [&](const V3f& wi) { return bsdf.evaluateSpecular(wi).pdf; });
    }
}

}  // namespace
}  // namespace patina::test
