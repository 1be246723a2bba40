// SPDX-License-Identifier: Apache-2.0
// White furnaces: what a lobe makes of light that comes evenly from everywhere, by its samples, by quadrature
// over directions, and by an independent computation over half vectors.
#include "patina/shader.h"
#include "renderer/shading/bsdf.h"
#include "tests/unit/chi_square.h"

namespace patina::test {
namespace {

Lobe lobe(uint32_t type, float alpha, float eta = 1) {
  return {type, Rgb(1), Rgb(type == PATINA_LOBE_DIELECTRIC ? 1.0f : 0.0f), alpha, eta};
}

ShadingPoint pointSeenAt(double degrees, const V3f& N = {0, 0, 1}) {
  ShadingPoint p;
  p.Ng = V3f(0, 0, 1), p.N = N;
  p.I = -V3f(V3d(std::sin(degrees * std::numbers::pi / 180), 0, std::cos(degrees * std::numbers::pi / 180)));
  return p;
}

/// Power reflected and transmitted of a unit of power, as the integral of f |cos| over directions. Radiance
/// is compressed by 1 / eta^2 where it enters; power is not.
struct Albedo {
  double reflected = 0, transmitted = 0;
  double total() const { return reflected + transmitted; }
};

/// By adaptive quadrature of evaluate(): in rows that are narrow at the mirrored ray, or, for wide lobes,
/// that end at the horizon, as refraction may be squeezed into a band along it.
Albedo byQuadrature(const Bsdf& bsdf, const ShadingPoint& point, const Lobe* l) {
  const double alpha = l ? static_cast<double>(l->alpha) : 1, eta = l ? static_cast<double>(l->eta) : 1;
  const SphereGrid grid = alpha < 0.3
                              ? SphereGrid::narrow(V3f(point.I.x, point.I.y, -point.I.z), 2 * alpha * alpha)
                              : SphereGrid::even(point.Ng, 20);
  Albedo albedo;
  const auto sum = [&](bool above) {
    const std::vector<double> cells = grid.integrals(
        [&](const V3f& wi) { return (wi.dot(point.Ng) > 0) == above ? bsdf.evaluate(wi).f.x : 0; });
    return std::accumulate(cells.begin(), cells.end(), 0.0);
  };
  albedo.reflected = sum(true);
  albedo.transmitted = sum(false) * eta * eta;
  return albedo;
}

/// Mean of the samples' weights, and its variance.
bench::Summary bySamples(const Bsdf& bsdf, const std::string& name, float eta = 1) {
  constexpr uint32_t kSamples = 1 << 16;
  Independent random(seedOf(name));
  std::vector<double> weights(kSamples);
  for (double& w : weights) {
    const float choice = random.next();
    const BsdfSample s = bsdf.sample(choice, random.next2());
    if (s.pdf > 0) w = static_cast<double>(s.weight.x * (s.transmitted ? eta * eta : 1));
  }
  return bench::summarize(weights);
}

/// Judges that means of samples are what they should be; see Fits.
class Means {
 public:
  void add(const std::string& name, const bench::Summary& samples, double expected) {
    cases_.push_back({name, samples, expected});
  }
  ~Means() {
    const double level = bench::sidak(0.01, cases_.size());
    for (const Case& c : cases_) {
      // Beside the noise, what quadrature leaves; without noise, rounding of weights.
      const double off = std::max(std::abs(c.samples.mean - c.expected) - kQuadrature, 0.0) /
                         (c.samples.standardError() + 1e-7);
      EXPECT_GE(bench::studentTails(off, static_cast<double>(c.samples.count - 1)), level)
          << c.name << ": " << c.samples.mean << " in place of " << c.expected;
    }
  }
  static constexpr double kQuadrature = 2e-4;

 private:
  struct Case {
    std::string name;
    bench::Summary samples;
    double expected;
  };
  std::vector<Case> cases_;
};

// Single scattering by a microsurface, in double precision and by tangents.

/// Visits normals of a GGX surface with their shares in what is seen from `o`, which add up to one: D_o(h) dh
/// with D_o = G1 (o.h) D / o.z (Heitz 2014, eq. 16). They are enumerated by tan^2 = alpha^2 (1 - y^2) / y^2,
/// which makes D(h) cos(h) dh = 2 y dy dphi / 2 pi (Walter et al. 2007, eq. 35).
template <class Visit>
void forVisibleNormals(const V3d& o, double alpha, const Visit& visit) {
  constexpr int kSteps = 500;
  const double tangent2 = (1 - o.z * o.z) / (o.z * o.z);
  const double masking = 2 / (1 + std::sqrt(1 + alpha * alpha * tangent2));  // G1 (Walter, eq. 34)
  for (int j = 0; j < kSteps; ++j) {
    const double y = (j + 0.5) / kSteps, tangent = alpha * std::sqrt(1 - y * y) / y;
    const double z = 1 / std::sqrt(1 + tangent * tangent);
    for (int i = 0; i < kSteps; ++i) {
      const double phi = 2 * std::numbers::pi * (i + 0.5) / kSteps;
      const V3d h(z * tangent * std::cos(phi), z * tangent * std::sin(phi), z);
      const double cosine = o.dot(h);
      if (cosine > 0) visit(h, 2 * y * masking * cosine / (o.z * z) / (kSteps * kSteps));
    }
  }
}

/// Smith's Lambda (Heitz 2014, eq. 72).
double lambda(const V3d& w, double alpha) {
  const double tangent2 = (1 - w.z * w.z) / (w.z * w.z);
  return (-1 + std::sqrt(1 + alpha * alpha * tangent2)) / 2;
}

/// Fresnel's equations by angles of incidence and refraction: sines and tangents of their sum and difference.
double fresnel(double cosine, double eta) {
  const double a = std::acos(std::min(cosine, 1.0)), sine = std::sin(a) / eta;
  if (sine >= 1) return 1;
  if (a < 1e-4) return (eta - 1) * (eta - 1) / ((eta + 1) * (eta + 1));
  const double b = std::asin(sine);
  const double s = std::sin(a - b) / std::sin(a + b), p = std::tan(a - b) / std::tan(a + b);
  return (s * s + p * p) / 2;
}

V3d mirrored(const V3d& o, const V3d& h) { return h * (2 * o.dot(h)) - o; }
V3d refracted(const V3d& o, const V3d& h, double eta) {
  const double c = o.dot(h);
  return h * (c / eta - std::sqrt(1 - (1 - c * c) / (eta * eta))) - o / eta;
}

/// What leaves after one scattering: of light that comes to h the part share(h) goes to direction(h), and is
/// not shadowed there. The rest meets the surface again. `exact` takes the heights of o and i as correlated
/// (Heitz 2014, eq. 99); `least` as independent, which shadows more; in `most` all comes out that is on the
/// right side.
struct Single {
  double exact = 0, least = 0, most = 0;
};
template <class Share, class Direction>
Single single(const V3d& o, double alpha, const Share& share, const Direction& direction, double side) {
  Single sum;
  const double lo = lambda(o, alpha);
  forVisibleNormals(o, alpha, [&](const V3d& h, double seen) {
    const double part = share(h) * seen;
    if (part <= 0) return;
    const V3d i = direction(h);
    if (i.z * side <= 0) return;
    const double li = lambda(i, alpha);
    sum.exact += part * (1 + lo) / (1 + lo + li);
    sum.least += part / (1 + li);
    sum.most += part;
  });
  return sum;
}

constexpr double kAngles[] = {0, 30, 60, 80, 88};

// The exact value is only good to the steps of its own sum.
void expectWithin(double albedo, const Single& bound, const std::string& name) {
  EXPECT_NEAR(albedo, bound.exact, 2e-3 * bound.exact + 1e-4) << name;
  EXPECT_GE(albedo, bound.least - 1e-3) << name;
  EXPECT_LE(albedo, bound.most + 1e-3) << name;
  EXPECT_LE(albedo, 1 + Means::kQuadrature) << name;
}

std::string at(const std::string& name, double alpha, double degrees) {
  return name + " " + std::to_string(alpha) + " at " + std::to_string(degrees);
}

TEST(Furnace, GgxLosesWhatMeetsTheSurfaceTwice) {
  Means means;
  const SurfaceTerms none;
  for (const double alpha : {0.02, 0.1, 0.3, 0.6, 1.0})
    for (const double degrees : kAngles) {
      const std::string name = at("ggx", alpha, degrees);
      const ShadingPoint point = pointSeenAt(degrees);
      const std::vector<Lobe> lobes{lobe(PATINA_LOBE_GGX, static_cast<float>(alpha))};
      const Bsdf bsdf(point, none, lobes);
      const Albedo albedo = byQuadrature(bsdf, point, lobes.data());
      EXPECT_EQ(albedo.transmitted, 0);
      means.add(name, bySamples(bsdf, name), albedo.reflected);
      const V3d o(-point.I);
      expectWithin(
          albedo.reflected,
          single(
              o, alpha, [](const V3d&) { return 1.0; }, [&](const V3d& h) { return mirrored(o, h); }, 1),
          name);
    }
}

TEST(Furnace, RoughGlassLosesWhatMeetsTheSurfaceTwice) {
  Means means;
  const SurfaceTerms none;
  for (const double ior : {1.5, 1 / 1.5})
    for (const double alpha : {0.1, 0.3, 0.8})
      for (const double degrees : kAngles) {
        const std::string name = at(ior > 1 ? "glass" : "air", alpha, degrees);
        const ShadingPoint point = pointSeenAt(degrees);
        const std::vector<Lobe> lobes{
            lobe(PATINA_LOBE_DIELECTRIC, static_cast<float>(alpha), static_cast<float>(ior))};
        const Bsdf bsdf(point, none, lobes);
        const Albedo albedo = byQuadrature(bsdf, point, lobes.data());
        means.add(name, bySamples(bsdf, name, static_cast<float>(ior)), albedo.total());
        const V3d o(-point.I);
        const auto reflectance = [&](const V3d& h) { return fresnel(o.dot(h), ior); };
        expectWithin(albedo.reflected,
                     single(
                         o, alpha, reflectance, [&](const V3d& h) { return mirrored(o, h); }, 1),
                     name + " reflected");
        expectWithin(albedo.transmitted,
                     single(
                         o, alpha, [&](const V3d& h) { return 1 - reflectance(h); },
                         [&](const V3d& h) { return refracted(o, h, ior); }, -1),
                     name + " transmitted");
        EXPECT_LE(albedo.total(), 1 + Means::kQuadrature) << name;
      }
}

// RI 3.2 does not normalise specular(): f cos is Cl (N.H)^n / pi. Over half vectors, of which a solid angle
// becomes 4 (o.h) times as large, that is a sum that needs no BSDF. It stays below one up to roughness 1,
// which is n = 8; wider lobes make energy, and are the RIB's to scale.
TEST(Furnace, RiSpecularIsWhatItsFormulaGives) {
  Means means;
  const SurfaceTerms none;
  for (const double roughness : {0.01, 0.1, 0.5, 1.0, 4.0})
    for (const double degrees : kAngles) {
      const std::string name = at("specular", roughness, degrees);
      const ShadingPoint point = pointSeenAt(degrees);
      const std::vector<Lobe> lobes{lobe(PATINA_LOBE_RI_SPECULAR, static_cast<float>(roughness))};
      const Bsdf bsdf(point, none, lobes);
      const double albedo = byQuadrature(bsdf, point, lobes.data()).total();
      means.add(name, bySamples(bsdf, name), albedo);
      const V3d o(-point.I);
      const double n = 8 / roughness;
      constexpr int kSteps = 1000;
      double expected = 0;
      for (int j = 0; j < kSteps; ++j)  // cos^n is spent by steps of equal cos^(n + 1)
        for (int i = 0; i < kSteps; ++i) {
          const double z = std::pow((j + 0.5) / kSteps, 1 / (n + 1)), r = std::sqrt(1 - z * z),
                       phi = 2 * std::numbers::pi * (i + 0.5) / kSteps;
          const V3d h(r * std::cos(phi), r * std::sin(phi), z);
          if (o.dot(h) > 0 && mirrored(o, h).z > 0) expected += 8 * o.dot(h) / (n + 1) / (kSteps * kSteps);
        }
      EXPECT_NEAR(albedo, expected, 3e-3 * expected + 1e-4) << name;
      if (roughness <= 1) {
        EXPECT_LE(albedo, 1) << name;
      }
    }
}

TEST(Furnace, DiffuseGivesItsReflectanceWhateverTheShadingNormal) {
  Means means;
  SurfaceTerms leaf;
  leaf.reflectance = Rgb(0.6f), leaf.transmittance = Rgb(0.4f);
  for (const V3f& N : {V3f(0, 0, 1), V3f(0.6f, 0, 0.8f), V3f(-0.3f, 0.9f, 0.316f).normalized()}) {
    const ShadingPoint point = pointSeenAt(40, N);
    const Bsdf bsdf(point, leaf, {});
    const Albedo albedo = byQuadrature(bsdf, point, nullptr);
    EXPECT_NEAR(albedo.reflected, 0.6, Means::kQuadrature);
    EXPECT_NEAR(albedo.transmitted, 0.4, Means::kQuadrature);
    means.add("leaf " + std::to_string(N.z), bySamples(bsdf, "leaf " + std::to_string(N.z)), 1);
  }
}

// Around a shading normal that is not the geometric one, lobes lose what falls below the horizon and gain
// nothing.
TEST(Furnace, TiltedLobesMakeNoEnergy) {
  Means means;
  const SurfaceTerms none;
  for (const V3f& N : {V3f(0.28f, 0, 0.96f), V3f(-0.6f, 0, 0.8f), V3f(0, 0.8f, 0.6f)})
    for (const double degrees : {10.0, 60.0, 85.0})
      for (const Lobe& l : {lobe(PATINA_LOBE_GGX, 0.3f), lobe(PATINA_LOBE_DIELECTRIC, 0.3f, 1.5f)}) {
        const std::string name = at(l.eta > 1 ? "glass" : "ggx", static_cast<double>(N.z), degrees);
        const ShadingPoint point = pointSeenAt(degrees, N);
        const std::vector<Lobe> lobes{l};
        const Bsdf bsdf(point, none, lobes);
        const double albedo = byQuadrature(bsdf, point, &l).total();
        EXPECT_LE(albedo, 1 + Means::kQuadrature) << name;
        means.add(name, bySamples(bsdf, name, l.eta), albedo);
      }
}

// Delta lobes have no quadrature: nothing is lost, and a boundary between equal indices lets everything pass
// straight, however rough it is.
TEST(Furnace, SmoothLobesLoseNothing) {
  Means means;
  const SurfaceTerms none;
  for (const double degrees : kAngles)
    for (const Lobe& l : {lobe(PATINA_LOBE_GGX, 0), lobe(PATINA_LOBE_DIELECTRIC, 0, 1.5f),
                          lobe(PATINA_LOBE_DIELECTRIC, 0, 1 / 1.5f), lobe(PATINA_LOBE_DIELECTRIC, 0.3f, 1)}) {
      const ShadingPoint point = pointSeenAt(degrees);
      const std::vector<Lobe> lobes{l};
      const Bsdf bsdf(point, none, lobes);
      const std::string name = at("smooth", static_cast<double>(l.eta), degrees);
      means.add(name, bySamples(bsdf, name, l.eta), 1);
      if (l.eta == 1 && l.type == PATINA_LOBE_DIELECTRIC) {
        EXPECT_NEAR((bsdf.sample(0.5f, {0.3f, 0.6f}).direction - point.I).length(), 0, 1e-6f);
      }
    }
}

}  // namespace
}  // namespace patina::test
