// SPDX-License-Identifier: Apache-2.0
// Quadrics against the closed forms of RI 3.2 section 5.4, with derivatives, limits, closure and hostile
// values.
#include <gmock/gmock.h>

#include <array>

#include "tests/unit/geometry_surface_fixtures.h"

namespace patina {
namespace {

using namespace test;
using Kind = Quadric::Kind;

Primitive quadric(Kind kind, std::array<float, 6> values, float thetaMax = 360) {
  return primitive(Quadric{kind, values, thetaMax});
}

V3f polar(double r, double degrees, double z) {
  const double a = degrees * std::numbers::pi / 180;
  return V3f(V3d(r * std::cos(a), r * std::sin(a), z));
}

/// Positions against `form(u, v)`, derivatives against differences, all inside the bound.
template <typename Form>
void check(const Primitive& p, const Form& form, bool derivativesAtEnds = true) {
  const auto s = make(p);
  ASSERT_TRUE(s);
  const Box3f box = s->bound();
  const float size = (box.max - box.min).length();
  for (int j = 0; j <= 16; ++j)
    for (int i = 0; i <= 16; ++i) {
      const float u = static_cast<float>(i) / 16, v = static_cast<float>(j) / 16;
      const V3f q = s->evaluate(0, u, v).P;
      expectNear(q, form(static_cast<double>(u), static_cast<double>(v)), 1e-6f * size,
                 "u " + std::to_string(u));
      EXPECT_TRUE(box.intersects(q));
      if (derivativesAtEnds || (j > 1 && j < 15)) expectDerivatives(*s, 0, u, v, 1e-3f * size);
    }
}

TEST(QuadricSurface, Sphere) {
  check(quadric(Kind::Sphere, {2, -2, 2}), [](double u, double v) {
    const double phi = (v - 0.5) * std::numbers::pi;
    return polar(2 * std::cos(phi), 360 * u, 2 * std::sin(phi));
  });
  // A partial sphere: phi runs from asin(zmin/r) to asin(zmax/r).
  check(quadric(Kind::Sphere, {2, -1, 1.5f}, -220), [](double u, double v) {
    const double low = std::asin(-0.5), phi = low + v * (std::asin(0.75) - low);
    return polar(2 * std::cos(phi), -220 * u, 2 * std::sin(phi));
  });
}

TEST(QuadricSurface, SphereNormalsPointOutAndReachThePoles) {
  const auto s = make(quadric(Kind::Sphere, {3, -5, 5}));
  for (int j = 0; j <= 8; ++j)
    for (int i = 0; i <= 8; ++i) {
      const SurfacePoint p = s->evaluate(0, static_cast<float>(i) / 8, static_cast<float>(j) / 8);
      expectNear(p.N, p.P / 3, 1e-6f);
    }
  EXPECT_EQ(Bits(s->evaluate(0, 0.3f, 0).P), Bits({0, 0, -3}));
  EXPECT_EQ(Bits(s->evaluate(0, 0.9f, 1).P), Bits({0, 0, 3}));
  expectNear(s->evaluate(0, 0.3f, 1).N, {0, 0, 1}, 0);
  // A sweep the other way turns it inside out.
  const auto inside = make(quadric(Kind::Sphere, {3, -3, 3}, -360));
  const SurfacePoint p = inside->evaluate(0, 0.2f, 0.7f);
  expectNear(p.N, p.P / -3, 1e-6f);
}

TEST(QuadricSurface, Cone) {
  check(quadric(Kind::Cone, {3, 2}), [](double u, double v) { return polar(2 * (1 - v), 360 * u, 3 * v); });
  const auto s = make(quadric(Kind::Cone, {3, 2}));
  const double l = std::sqrt(13.0);
  for (float u : {0.0f, 0.125f, 0.7f})
    for (float v : {0.0f, 0.5f, 1.0f})  // (h cos, h sin, r) / l, up to the apex
      expectNear(s->evaluate(0, u, v).N, polar(3 / l, 360 * static_cast<double>(u), 2 / l), 1e-6f);
  const auto flat = make(quadric(Kind::Cone, {0, 2}));
  expectNear(flat->evaluate(0, 0.3f, 1).N, {0, 0, 1}, 0);
}

TEST(QuadricSurface, Cylinder) {
  check(quadric(Kind::Cylinder, {2, -1, 3}, 90),
        [](double u, double v) { return polar(2, 90 * u, 4 * v - 1); });
  const auto s = make(quadric(Kind::Cylinder, {2, -1, 3}));
  expectNear(s->evaluate(0, 0.25f, 0.5f).N, {0, 1, 0}, 0);
}

TEST(QuadricSurface, Hyperboloid) {
  const V3d p1(2, -1, -2), p2(1, 1.5, 3);
  check(quadric(Kind::Hyperboloid, {2, -1, -2, 1, 1.5f, 3}, 300), [&](double u, double v) {
    const V3d p = p1 * (1 - v) + p2 * v;
    const double a = std::atan2(p.y, p.x) * 180 / std::numbers::pi;
    return polar(std::hypot(p.x, p.y), a + 300 * u, p.z);
  });
  // A cone from the axis, its apex at v = 0: the limit of the normal along each line.
  const auto cone = make(quadric(Kind::Hyperboloid, {0, 0, 0, 1, 0, 1}));
  for (float u : {0.0f, 0.3f}) expectNear(cone->evaluate(0, u, 0).N, cone->evaluate(0, u, 0.5f).N, 1e-6f);
  const auto other = make(quadric(Kind::Hyperboloid, {1, 0, 1, 0, 0, 0}));
  for (float u : {0.0f, 0.3f}) expectNear(other->evaluate(0, u, 1).N, other->evaluate(0, u, 0.5f).N, 1e-6f);
  // A segment in the plane z = 1 that starts where it is nearest to the axis.
  const auto ring = make(quadric(Kind::Hyperboloid, {1, 0, 1, 1, 2, 1}));
  expectNear(ring->evaluate(0, 0.3f, 0).N, ring->evaluate(0, 0.3f, 0.5f).N, 1e-6f);
}

TEST(QuadricSurface, Paraboloid) {
  const auto form = [](double u, double v) {
    const double z = 1 + 3 * v;
    return polar(2 * std::sqrt(z / 4), 360 * u, z);
  };
  check(quadric(Kind::Paraboloid, {2, 1, 4}), form);
  const auto s = make(quadric(Kind::Paraboloid, {2, 0, 4}));
  expectNear(s->evaluate(0, 0.4f, 0).N, {0, 0, -1}, 0);
  EXPECT_EQ(Bits(s->evaluate(0, 0.4f, 0).P), Bits({0, 0, 0}));
  EXPECT_TRUE(isFinite(s->evaluate(0, 0.4f, 0).dPdv));
  // z = (r / rmax)^2 zmax has the normal (2 x, 2 y, -1) up to scale for rmax = 2, zmax = 4.
  const SurfacePoint p = s->evaluate(0, 0.1f, 0.3f);
  expectNear(p.N, V3f(2 * p.P.x, 2 * p.P.y, -1).normalized(), 1e-6f);
}

TEST(QuadricSurface, Disk) {
  check(quadric(Kind::Disk, {1.5f, 2}, 200),
        [](double u, double v) { return polar(2 * (1 - v), 200 * u, 1.5); });
  expectNear(make(quadric(Kind::Disk, {1, 2}))->evaluate(0, 0.5f, 1).N, {0, 0, 1}, 0);
  expectNear(make(quadric(Kind::Disk, {1, 2}, -360))->evaluate(0, 0.5f, 1).N, {0, 0, -1}, 0);
}

TEST(QuadricSurface, Torus) {
  check(quadric(Kind::Torus, {3, 1, -30, 200}, 100), [](double u, double v) {
    const double phi = (-30 + 230 * v) * std::numbers::pi / 180;
    return polar(3 + std::cos(phi), 100 * u, std::sin(phi));
  });
  const auto s = make(quadric(Kind::Torus, {3, 1, 0, 360}));
  expectNear(s->evaluate(0, 0, 0).N, {1, 0, 0}, 0);
  expectNear(s->evaluate(0, 0, 0.5f).N, {-1, 0, 0}, 1e-6f);
}

TEST(QuadricSurface, WholeSweepsCloseBitForBit) {
  for (uint32_t cells : {1u, 2u, 8u, 64u}) {
    EXPECT_EQ(openEdges(*make(quadric(Kind::Sphere, {1.7f, -2, 2})), cells), 0u) << cells;
    EXPECT_EQ(openEdges(*make(quadric(Kind::Torus, {3, 1, 0, 360})), cells), 0u) << cells;
    EXPECT_EQ(openEdges(*make(quadric(Kind::Torus, {3, 1, -77.7f, 282.3f})), cells), 0u) << cells;
    // A cylinder is open at its two rims only, a cone at one.
    EXPECT_EQ(openEdges(*make(quadric(Kind::Cylinder, {0.3f, -2, 2})), cells), cells < 3 ? 0u : 2 * cells)
        << cells;
    EXPECT_EQ(openEdges(*make(quadric(Kind::Cone, {0.3f, 2})), cells), cells < 3 ? 0u : cells) << cells;
  }
  // Volumes by the divergence theorem: positive, so N is the outside.
  EXPECT_NEAR(volume(*make(quadric(Kind::Sphere, {1, -1, 1})), 256), 4 * std::numbers::pi / 3, 1e-3);
  EXPECT_NEAR(volume(*make(quadric(Kind::Torus, {3, 1, 0, 360})), 256),
              6 * std::numbers::pi * std::numbers::pi, 2e-2);
}

TEST(QuadricSurface, TessellationIsEvaluation) {
  for (const Primitive& p :
       {quadric(Kind::Sphere, {2, -1, 1.5f}, 200), quadric(Kind::Hyperboloid, {2, -1, -2, 1, 1.5f, 3}),
        quadric(Kind::Torus, {3, 1, -30, 200}, 100)}) {
    const auto s = make(p);
    const std::vector<V3f> grid = tessellated(*s, 16);
    for (size_t j = 0; j <= 16; ++j)
      for (size_t i = 0; i <= 16; ++i)
        EXPECT_EQ(Bits(grid[17 * j + i]),
                  Bits(s->evaluate(0, static_cast<float>(i) / 16, static_cast<float>(j) / 16).P));
  }
}

// ---- Every partial form -----------------------------------------------------------------------------------

/// P, dPdu, dPdv and N of a quadric against its closed form in double. Derivatives of the form are central
/// differences of fourth order: their error is about 1e-11 of the size. Tolerances are those of float: a few
/// roundings (6e-8) of the quadric's size, and of the derivatives' lengths.
template <typename Form>
void checkAll(const Primitive& p, const Form& form) {
  const auto s = make(p);
  ASSERT_TRUE(s);
  const Box3f box = s->bound();
  const double size = static_cast<double>((box.max - box.min).length() + maxAbsComponent(box.max));
  const auto unit = [](const V3d& n) { return n / std::sqrt(n.dot(n)); };
  for (const double v : {0.0, 0.0625, 0.375, 0.5, 0.84375, 1.0})
    for (const double u : {0.0, 0.1875, 0.5, 0.71875, 1.0}) {
      const auto uf = static_cast<float>(u), vf = static_cast<float>(v);
      const std::string where = "u " + std::to_string(u) + " v " + std::to_string(v);
      const SurfacePoint q = s->evaluate(0, uf, vf);
      EXPECT_EQ(s->surfaceParameters(0, uf, vf), V2f(uf, vf));
      EXPECT_LE((V3d(q.P) - form(u, v)).length(), 3e-7 * size) << where;
      EXPECT_TRUE(box.intersects(q.P)) << where;
      constexpr double h = 1e-3;
      const auto derivative = [&](double du, double dv) {
        const auto at = [&](double k) { return form(u + k * h * du, v + k * h * dv); };
        return ((at(1) - at(-1)) * 8.0 - at(2) + at(-2)) / (12 * h);
      };
      // The form of the paraboloid and arc sines end at the domain: there the derivative by v is left out.
      const bool inside = v > 0.01 && v < 0.99;
      const V3d du = derivative(1, 0), dv = inside ? derivative(0, 1) : V3d(q.dPdv);
      EXPECT_LE((V3d(q.dPdu) - du).length(), 1e-6 * (size + du.length())) << where << q.dPdu << du;
      EXPECT_LE((V3d(q.dPdv) - dv).length(), 1e-6 * (size + dv.length())) << where << q.dPdv << dv;
      EXPECT_NEAR(q.N.length(), 1, 1e-6f) << where;
      const V3d n = du.cross(dv);
      if (n.length() > 1e-6 * size * size) {
        EXPECT_LE((V3d(q.N) - unit(n)).length(), 2e-5) << where << q.N << unit(n);
      } else if (v == 0 || v == 1) {  // a tip: the limit along v
        const V3f near = s->evaluate(0, uf, v == 0 ? 0.0001f : 0.9999f).N;
        EXPECT_LE((q.N - near).length(), 0.05f) << where << q.N << near;
      }
    }
}

V3d swept(double r, double degrees, double z) {
  const double a = degrees * std::numbers::pi / 180;
  return {r * std::cos(a), r * std::sin(a), z};
}

TEST(QuadricSurface, PartialForms) {
  // Angles that are cut: beyond a whole turn either way.
  const auto turn = [](float theta) { return std::clamp(static_cast<double>(theta), -360.0, 360.0); };
  const auto mixed = [](double v, float a, float b) {
    return static_cast<double>(a) * (1 - v) + static_cast<double>(b) * v;
  };
  for (const float theta : {360.0f, 37.5f, -90.0f, -222.0f, 271.0f, 720.0f, -1000.0f}) {
    const double t = turn(theta);
    for (const auto& [r, low, high] :
         {std::array{2.0f, -2.0f, 2.0f}, std::array{2.0f, -1.0f, 1.5f}, std::array{2.0f, 1.5f, -1.0f},
          std::array{2.0f, 0.5f, 9.0f}, std::array{-2.0f, -1.0f, 1.0f}, std::array{-2.0f, -2.0f, 2.0f}}) {
      const auto latitude = [&, radius = r](float z) {
        return std::asin(std::clamp(static_cast<double>(z) / static_cast<double>(radius), -1.0, 1.0));
      };
      const double from = latitude(low), to = latitude(high), radius = static_cast<double>(r);
      checkAll(quadric(Kind::Sphere, {r, low, high}, theta), [&](double u, double v) {
        const double phi = from + v * (to - from);
        return swept(radius * std::cos(phi), t * u, radius * std::sin(phi));
      });
    }
    for (const auto& [h, r] : {std::pair{3.0f, 2.0f}, {-3.0f, 2.0f}, {3.0f, -2.0f}, {0.0f, 2.0f}})
      checkAll(quadric(Kind::Cone, {h, r}, theta),
               [&, height = static_cast<double>(h), radius = static_cast<double>(r)](double u, double v) {
                 return swept(radius * (1 - v), t * u, height * v);
               });
    for (const auto& [r, low, high] :
         {std::array{2.0f, -1.0f, 3.0f}, std::array{2.0f, 3.0f, -1.0f}, std::array{-2.0f, -1.0f, 3.0f}})
      checkAll(quadric(Kind::Cylinder, {r, low, high}, theta),
               [&, radius = static_cast<double>(r), a = low, b = high](double u, double v) {
                 return swept(radius, t * u, mixed(v, a, b));
               });
    // Across the axis, meeting it at an end, in a plane across it, along it, aslant.
    for (const std::array<float, 6>& x : {std::array<float, 6>{-1, 0.5f, -1, 2, -1, 1},
                                          {0, 0, 0, 1, 0, 1},
                                          {1, 1, 1, 0, 0, 2},
                                          {1, 0, 1, 2, 1, 1},
                                          {2, 1, 3, 2, 1, -1},
                                          {2, -1, -2, 1, 1.5f, 3},
                                          {1, -1, 0, 1, 1, 1}})
      checkAll(quadric(Kind::Hyperboloid, x, theta), [&](double u, double v) {
        const double px = mixed(v, x[0], x[3]), py = mixed(v, x[1], x[4]), a = t * u * std::numbers::pi / 180;
        return V3d(px * std::cos(a) - py * std::sin(a), px * std::sin(a) + py * std::cos(a),
                   mixed(v, x[2], x[5]));
      });
    for (const auto& [r, low, high] :
         {std::array{2.0f, 0.0f, 4.0f}, std::array{2.0f, 1.0f, 4.0f}, std::array{-2.0f, 1.0f, 4.0f},
          std::array{2.0f, -1.0f, -4.0f}, std::array{2.0f, 4.0f, 1.0f}, std::array{2.0f, 8.0f, 4.0f}})
      checkAll(quadric(Kind::Paraboloid, {r, low, high}, theta),
               [&, radius = static_cast<double>(r), a = low, b = high](double u, double v) {
                 const double z = mixed(v, a, b);
                 return swept(radius * std::sqrt(std::max(z / static_cast<double>(b), 0.0)), t * u, z);
               });
    for (const auto& [z, r] : {std::pair{1.5f, 2.0f}, {-1.5f, -2.0f}})
      checkAll(quadric(Kind::Disk, {z, r}, theta),
               [&, height = static_cast<double>(z), radius = static_cast<double>(r)](double u, double v) {
                 return swept(radius * (1 - v), t * u, height);
               });
    for (const auto& [R, r, low, high] :
         {std::array{3.0f, 1.0f, 0.0f, 360.0f}, std::array{3.0f, 1.0f, -30.0f, 200.0f},
          std::array{3.0f, 1.0f, 200.0f, -30.0f}, std::array{3.0f, -1.0f, 10.0f, 100.0f},
          std::array{-3.0f, 1.0f, 10.0f, 100.0f}, std::array{1.0f, 2.0f, 0.0f, 360.0f},
          std::array{3.0f, 1.0f, 700.0f, 800.0f}})
      checkAll(quadric(Kind::Torus, {R, r, low, high}, theta),
               [&, major = static_cast<double>(R), minor = static_cast<double>(r), a = low, b = high](
                   double u, double v) {
                 const double phi = mixed(v, a, b) * std::numbers::pi / 180;
                 return swept(major + minor * std::cos(phi), t * u, minor * std::sin(phi));
               });
  }
}

TEST(QuadricSurface, VaryingIsBilinear) {
  Primitive p = quadric(Kind::Disk, {0, 1});
  p.variables.push_back(variable("a", StorageClass::Varying, ValueType::Float, 1, {0, 1, 10, 11}));
  const auto s = make(p);
  float out = 0;
  s->interpolate(p.variables[0], 0, 0.25f, 0.5f, &out);
  EXPECT_FLOAT_EQ(out, 5.25f);
  EXPECT_EQ(s->surfaceParameters(0, 0.25f, 0.5f), V2f(0.25f, 0.5f));
}

TEST(QuadricSurface, HostileValues) {
  const auto report = [](const Primitive& p, bool made) {
    Messages messages;
    const auto s = makeSurface(p, messages.handler);
    EXPECT_EQ(s != nullptr, made);
    if (s)
      for (float u : {0.0f, 0.5f, 1.0f})
        for (float v : {0.0f, 0.5f, 1.0f}) {
          const SurfacePoint q = s->evaluate(0, u, v);
          EXPECT_TRUE(isFinite(q.P) && isFinite(q.dPdu) && isFinite(q.dPdv)) << u << v;
          EXPECT_NEAR(q.N.length(), 1, 1e-5f);
        }
    return messages.all();
  };
  using ::testing::HasSubstr;
  EXPECT_THAT(report(quadric(Kind::Sphere, {0, -1, 1}), false),
              HasSubstr("test.rib:7:3: error: badargument: Sphere: has no area"));
  EXPECT_THAT(report(quadric(Kind::Sphere, {1, 2, 3}), false), HasSubstr("no area"));
  EXPECT_THAT(report(quadric(Kind::Sphere, {NAN, -1, 1}), false), HasSubstr("not finite"));
  EXPECT_THAT(report(quadric(Kind::Sphere, {1, -1, 1}, 0), false), HasSubstr("no area"));
  EXPECT_THAT(report(quadric(Kind::Sphere, {1, -1, 1}, kInfinity), false), HasSubstr("thetamax"));
  EXPECT_THAT(report(quadric(Kind::Cone, {1, 0}), false), HasSubstr("no area"));
  EXPECT_THAT(report(quadric(Kind::Cylinder, {1, 2, 2}), false), HasSubstr("no area"));
  EXPECT_THAT(report(quadric(Kind::Hyperboloid, {0, 0, 0, 0, 0, 1}), false), HasSubstr("no area"));
  EXPECT_THAT(report(quadric(Kind::Hyperboloid, {1, 0, 0, 1, 0, 0}), false), HasSubstr("no area"));
  EXPECT_THAT(report(quadric(Kind::Paraboloid, {1, 0, 0}), false), HasSubstr("no area"));
  EXPECT_THAT(report(quadric(Kind::Paraboloid, {1, -1, 1}), true), HasSubstr("different sides of 0"));
  EXPECT_THAT(report(quadric(Kind::Torus, {1, 1, 0, 1000}), true), HasSubstr("cut to one turn"));
  EXPECT_EQ(report(quadric(Kind::Torus, {1, 1, 0, 360}), true), "");  // meets the axis
  EXPECT_EQ(report(quadric(Kind::Torus, {1, 2, 0, 360}), true), "");  // passes through it
  EXPECT_EQ(report(quadric(Kind::Sphere, {-1, -1, 1}), true), "");
  EXPECT_EQ(report(quadric(Kind::Sphere, {1, 1, -1}, 4000), true), "");
  EXPECT_EQ(report(quadric(Kind::Paraboloid, {-1, -1, -2}), true), "");
  EXPECT_EQ(report(quadric(Kind::Hyperboloid, {-1, 0, -1, 1, 0, 1}), true),
            "");  // crosses the axis at v = 1/2
  EXPECT_EQ(report(quadric(Kind::Cone, {-1, -1}), true), "");
  EXPECT_EQ(report(quadric(Kind::Cylinder, {1e-20f, 0, 1e17f}), true), "");
}

}  // namespace
}  // namespace patina
