// SPDX-License-Identifier: Apache-2.0
// Patches and patch meshes: de Casteljau, continuity of the splines, counts, variables, rational points,
// closure.
#include <gmock/gmock.h>

#include <array>
#include <random>

#include "renderer/geometry/primvar.h"
#include "tests/unit/geometry_surface_fixtures.h"

namespace patina {
namespace {

using namespace test;

// The bases of RI 3.2, section 5.2.
const CubicBasis kBezier{M44f(-1, 3, -3, 1, 3, -6, 3, 0, -3, 3, 0, 0, 1, 0, 0, 0), 3};
const CubicBasis kBspline{M44f(-1, 3, -3, 1, 3, -6, 3, 0, -3, 0, 3, 0, 1, 4, 1, 0) * (1 / 6.0f), 1};
const CubicBasis kCatmullRom{M44f(-1, 3, -3, 1, 2, -5, 4, -1, -1, 0, 1, 0, 0, 2, 0, 0) * 0.5f, 1};
const CubicBasis kHermite{M44f(2, 1, -2, 1, -3, -2, 3, -1, 0, 1, 0, 0, 1, 0, 0, 0), 2};
const CubicBasis kPower{M44f(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1), 4};

ParametricMesh bicubic(int nu, int nv, const CubicBasis& basis, bool periodicU = false,
                       bool periodicV = false) {
  return {true, nu, nv, periodicU, periodicV, basis, basis};
}
ParametricMesh bilinear(int nu, int nv, bool periodicU = false, bool periodicV = false) {
  return {false, nu, nv, periodicU, periodicV, {}, {}};
}

std::vector<float> wavyPoints(int nu, int nv, uint32_t seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> noise(-0.3f, 0.3f);
  std::vector<float> P;
  for (int j = 0; j < nv; ++j)
    for (int i = 0; i < nu; ++i)
      P.insert(P.end(), {static_cast<float>(i) + noise(random), static_cast<float>(j) + noise(random),
                         noise(random) * 5});
  return P;
}

/// A ring of points around z for each column of u; closed in u when periodic.
std::vector<float> tubePoints(int nu, int nv, float bulge) {
  std::vector<float> P;
  for (int j = 0; j < nv; ++j)
    for (int i = 0; i < nu; ++i) {
      const float a = 2 * kPi * static_cast<float>(i) / static_cast<float>(nu),
                  t = static_cast<float>(j) / static_cast<float>(nv - 1);
      const float r = 1 + bulge * t * (1 - t);
      P.insert(P.end(), {r * std::cos(a), r * std::sin(a), 3 * t});
    }
  return P;
}

V3d deCasteljau(std::array<V3d, 4> p, double t) {
  for (size_t n = 3; n > 0; --n)
    for (size_t i = 0; i < n; ++i) p[i] = p[i] * (1 - t) + p[i + 1] * t;
  return p[0];
}

TEST(ParametricMesh, BezierIsDeCasteljau) {
  const std::vector<float> P = wavyPoints(7, 4);
  const auto s = make(primitive(bicubic(7, 4, kBezier), P));
  ASSERT_EQ(s->faceCount(), 2u);
  for (uint32_t face = 0; face < 2; ++face)
    for (float u : {0.0f, 0.1f, 0.5f, 0.77f, 1.0f})
      for (float v : {0.0f, 0.3f, 0.9f, 1.0f}) {
        std::array<V3d, 4> rows;
        for (size_t j = 0; j < 4; ++j) {
          std::array<V3d, 4> row;
          for (size_t i = 0; i < 4; ++i) {
            const float* p = &P[3 * (7 * j + 3 * face + i)];
            row[i] = V3d(V3f(p[0], p[1], p[2]));
          }
          rows[j] = deCasteljau(row, static_cast<double>(u));
        }
        expectNear(s->evaluate(face, u, v).P, V3f(deCasteljau(rows, static_cast<double>(v))), 1e-6f);
        expectDerivatives(*s, face, u, v, 2e-3f);
      }
  EXPECT_EQ(s->surfaceParameters(1, 0.5f, 0.25f), V2f(0.75f, 0.25f));
  EXPECT_EQ(s->parameterScale(1), V2f(0.5f, 1));
}

// The formulas of the splines as their books have them, in double; periodic meshes take points from their
// beginning.
TEST(ParametricMesh, EveryBasisAlsoPeriodic) {
  using Weights = std::array<double, 4>;
  struct Case {
    CubicBasis basis;
    Weights (*weights)(double);
  };
  const std::array<Case, 5> cases{
      Case{kBezier,
           [](double t) {
             const double s = 1 - t;
             return Weights{s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t};
           }},
      Case{kBspline,
           [](double t) {
             const double s = 1 - t;
             return Weights{s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6,
                            (3 * s * s * s - 6 * s * s + 4) / 6, t * t * t / 6};
           }},
      Case{kCatmullRom,
           [](double t) {
             return Weights{t * (-1 + t * (2 - t)) / 2, (2 + t * t * (-5 + 3 * t)) / 2,
                            t * (1 + t * (4 - 3 * t)) / 2, t * t * (t - 1) / 2};
           }},
      Case{kHermite,
           [](double t) {
             return Weights{(1 + 2 * t) * (1 - t) * (1 - t), t * (1 - t) * (1 - t), t * t * (3 - 2 * t),
                            t * t * (t - 1)};
           }},
      Case{kPower, [](double t) {
             return Weights{t * t * t, t * t, t, 1};
           }}};
  for (const Case& c : cases)
    for (const bool periodic : {false, true}) {
      const int step = c.basis.step, nu = periodic ? 12 : 4 + 2 * step, nv = 4 + step;
      const int patchesU = periodic ? 12 / step : 3;
      const std::vector<float> P = wavyPoints(nu, nv);
      const auto s = make(primitive(bicubic(nu, nv, c.basis, periodic, false), P));
      ASSERT_EQ(s->faceCount(), static_cast<uint32_t>(2 * patchesU));
      for (uint32_t face = 0; face < s->faceCount(); ++face)
        for (float u : {0.0f, 0.3f, 1.0f})
          for (float v : {0.0f, 0.6f, 1.0f}) {
            const Weights wu = c.weights(static_cast<double>(u)), wv = c.weights(static_cast<double>(v));
            V3d expected(0);
            for (int j = 0; j < 4; ++j)
              for (int i = 0; i < 4; ++i) {
                const int column = (static_cast<int>(face) % patchesU * step + i) % nu;
                const int row = static_cast<int>(face) / patchesU * step + j;
                const float* p = &P[static_cast<size_t>(3 * (nu * row + column))];
                expected +=
                    V3d(V3f(p[0], p[1], p[2])) * wu[static_cast<size_t>(i)] * wv[static_cast<size_t>(j)];
              }
            expectNear(s->evaluate(face, u, v).P, V3f(expected),
                       1e-6f * (1 + static_cast<float>(expected.length())));
          }
      // The last patch around u ends at parameter 1.
      EXPECT_EQ(s->surfaceParameters(static_cast<uint32_t>(patchesU) - 1, 1, 0).x, 1);
    }
}

TEST(ParametricMesh, SplinesJoinSmoothly) {
  for (const CubicBasis& basis : {kBspline, kCatmullRom}) {
    const auto s = make(primitive(bicubic(6, 5, basis), wavyPoints(6, 5)));
    ASSERT_EQ(s->faceCount(), 6u);  // 3 x 2
    for (float v : {0.0f, 0.4f, 1.0f}) {
      const SurfacePoint a = s->evaluate(0, 1, v), b = s->evaluate(1, 0, v);
      EXPECT_EQ(Bits(a.P), Bits(b.P));
      expectNear(a.dPdu, b.dPdu, 1e-5f);
      expectNear(a.N, b.N, 1e-5f);
      const SurfacePoint c = s->evaluate(0, v, 1), d = s->evaluate(3, v, 0);
      EXPECT_EQ(Bits(c.P), Bits(d.P));
      expectNear(c.dPdv, d.dPdv, 1e-5f);
    }
    expectDerivatives(*s, 4, 0.3f, 0.6f, 2e-3f);
  }
  // Catmull-Rom goes through its inner points; a B-spline of points on a line of equal steps is that line.
  const std::vector<float> P = wavyPoints(4, 4);
  const auto c = make(primitive(bicubic(4, 4, kCatmullRom), P));
  expectNear(c->evaluate(0, 0, 0).P, {P[15], P[16], P[17]}, 0);
  expectNear(c->evaluate(0, 1, 1).P, {P[30], P[31], P[32]}, 0);
  // Hermite: rows of point, tangent, point, tangent.
  std::vector<float> hermite;
  for (int j = 0; j < 4; ++j)
    for (const V3f& p : {V3f(0, 0, 0), V3f(3, 1, 0), V3f(1, 2, 0), V3f(0, 5, 0)})
      hermite.insert(hermite.end(),
                     {j % 2 ? 0 : p.x, j % 2 ? 0 : p.y, j % 2 ? 1.0f : static_cast<float>(j / 2)});
  const auto h = make(primitive(bicubic(4, 4, kHermite), hermite));
  expectNear(h->evaluate(0, 0, 0).dPdu, {3, 1, 0}, 1e-6f);
  expectNear(h->evaluate(0, 1, 0).dPdu, {0, 5, 0}, 1e-6f);
  expectNear(h->evaluate(0, 1, 0).P, {1, 2, 0}, 1e-6f);
  // Power: P(u, v) = sum of p_ij u^(3-i) v^(3-j).
  const auto w = make(primitive(bicubic(4, 4, kPower), P));
  V3d sum(0);
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i) {
      const float* p = &P[static_cast<size_t>(3 * (4 * j + i))];
      sum += V3d(V3f(p[0], p[1], p[2])) * std::pow(0.3, 3 - i) * std::pow(0.7, 3 - j);
    }
  expectNear(w->evaluate(0, 0.3f, 0.7f).P, V3f(sum), 1e-6f);
}

TEST(ParametricMesh, CountsOfPatchesAndVariables) {
  const auto counts = [](const ParametricMesh& m) {
    return std::array<size_t, 3>{valueCount(m, 0, StorageClass::Uniform),
                                 valueCount(m, 0, StorageClass::Varying),
                                 valueCount(m, 0, StorageClass::Vertex)};
  };
  EXPECT_THAT(counts(bilinear(4, 3)), ::testing::ElementsAre(6u, 12u, 12u));
  EXPECT_THAT(counts(bilinear(4, 3, true, false)), ::testing::ElementsAre(8u, 12u, 12u));
  EXPECT_THAT(counts(bicubic(7, 4, kBezier)), ::testing::ElementsAre(2u, 6u, 28u));
  EXPECT_THAT(counts(bicubic(6, 4, kBezier, true, false)), ::testing::ElementsAre(2u, 4u, 24u));
  EXPECT_THAT(counts(bicubic(8, 6, kBspline, true, false)), ::testing::ElementsAre(24u, 32u, 48u));
  EXPECT_THAT(counts(bicubic(8, 6, kCatmullRom)), ::testing::ElementsAre(15u, 24u, 48u));
  EXPECT_THAT(counts(bicubic(6, 4, kHermite)), ::testing::ElementsAre(2u * 1u, 3u * 2u, 24u));
}

TEST(ParametricMesh, VariablesByClass) {
  Primitive p = primitive(bicubic(6, 4, kBezier, true, false), tubePoints(6, 4, 0));
  p.variables.push_back(variable("uniform", StorageClass::Uniform, ValueType::Float, 1, {7, 8}));
  p.variables.push_back(variable("varying", StorageClass::Varying, ValueType::Float, 1, {0, 1, 10, 11}));
  p.variables.push_back(
      variable("corner", StorageClass::FaceVarying, ValueType::Float, 1, {0, 1, 2, 3, 4, 5, 6, 7}));
  p.variables.push_back(variable("vertex", StorageClass::Vertex, ValueType::Point, 3, p.variables[0].floats));
  const auto s = make(std::move(p));
  const auto value = [&](const char* name, uint32_t face, float u, float v) {
    V3f out(0);
    s->interpolate(*findVariable(*s.primitive, name), face, u, v, out.getValue());
    return out;
  };
  EXPECT_EQ(value("uniform", 1, 0.5f, 0.5f).x, 8);
  EXPECT_EQ(value("varying", 0, 0.5f, 0).x, 0.5f);
  EXPECT_EQ(value("varying", 1, 0.25f, 1).x, 10.75f);  // from 11 round to 10
  EXPECT_EQ(value("corner", 1, 0, 1).x, 6);
  expectNear(value("vertex", 1, 0.3f, 0.8f), s->evaluate(1, 0.3f, 0.8f).P, 1e-6f);
}

TEST(ParametricMesh, BilinearAndFlat) {
  const auto twisted = make(primitive(bilinear(2, 2), {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 1}));
  EXPECT_FALSE(twisted->isFlat());
  expectNear(twisted->evaluate(0, 0.5f, 0.5f).P, {0.5f, 0.5f, 0.25f}, 0);
  expectDerivatives(*twisted, 0, 0.3f, 0.4f, 1e-3f);
  EXPECT_TRUE(
      make(primitive(bilinear(3, 2), {0, 0, 0, 1, 0, 0, 2, 0, 1, 0, 1, 0, 1, 1, 0, 2, 1, 1}))->isFlat());
  EXPECT_FALSE(
      make(primitive(bilinear(2, 2), {0, 0, 0, 2, 0, 0, 0, 1, 0, 1, 1, 0}))->isFlat());  // a trapezium
  // A side of no length: the normal is that of the triangle, up to the collapsed corner.
  const auto triangle = make(primitive(bilinear(2, 2), {0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 1, 0}));
  for (float v : {0.0f, 0.001f, 1.0f}) expectNear(triangle->evaluate(0, 0.5f, v).N, {0, 0, 1}, 1e-5f);
}

TEST(ParametricMesh, CollapsedEdgeHasTheLimitNormal) {
  // A bicubic cap: all points of v = 0 at the pole of a bowl, z = r^2 to second order.
  std::vector<float> P;
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i) {
      const float r = static_cast<float>(j), a = static_cast<float>(i) * 0.4f;
      P.insert(P.end(), {r * std::cos(a), r * std::sin(a), j < 2 ? 0 : r * r * 0.1f});
    }
  const auto s = make(primitive(bicubic(4, 4, kBezier), P));
  for (float u : {0.0f, 0.5f, 1.0f}) expectNear(s->evaluate(0, u, 0).N, {0, 0, -1}, 1e-4f);
  EXPECT_EQ(Bits(s->evaluate(0, 0.123f, 0).P), Bits(s->evaluate(0, 0.9f, 0).P));
}

TEST(ParametricMesh, RationalQuarterCylinderIsRound) {
  // A quarter circle as a rational cubic: the quadratic (1, 1, 2) weights raised by one degree.
  const float q = 2.0f / 3;
  std::vector<float> Pw;
  const std::array<std::array<float, 3>, 4> arc{{{1, 0, 1}, {1, q, 1}, {q, 2 * q, 2 * q}, {0, 2, 2}}};
  for (int j = 0; j < 4; ++j)
    for (const auto& [x, y, w] : arc) Pw.insert(Pw.end(), {x, y, static_cast<float>(j) * w, w});
  Primitive p = primitive(bicubic(4, 4, kBezier));
  p.variables.push_back(variable("Pw", StorageClass::Vertex, ValueType::HPoint, 4, Pw));
  const auto s = make(std::move(p));
  ASSERT_TRUE(s);
  for (int i = 0; i <= 16; ++i) {
    const SurfacePoint at = s->evaluate(0, static_cast<float>(i) / 16, 0.3f);
    EXPECT_NEAR(std::hypot(at.P.x, at.P.y), 1, 1e-6f);
    EXPECT_NEAR(at.P.z, 0.9f, 1e-6f);
    expectNear(at.N, {at.P.x, at.P.y, 0}, 2e-6f);
  }
  expectDerivatives(*s, 0, 0.4f, 0.6f, 2e-3f);
}

TEST(ParametricMesh, BoundHoldsTheSurface) {
  for (const CubicBasis& basis : {kBezier, kBspline, kCatmullRom, kHermite, kPower})
    for (uint32_t seed = 0; seed < 20; ++seed) {
      const auto s = make(primitive(bicubic(4, 4, basis), wavyPoints(4, 4, seed)));
      const Box3f box = s->bound();
      const std::vector<V3f> grid = tessellated(*s, 16);
      for (const V3f& q : grid) EXPECT_TRUE(box.intersects(q));
    }
}

TEST(ParametricMesh, ClosedMeshesAreWatertight) {
  for (uint32_t cells : {1u, 2u, 4u, 16u}) {
    // Tori of control points: periodic both ways.
    std::vector<float> torus;
    for (int j = 0; j < 6; ++j)
      for (int i = 0; i < 9; ++i) {
        const float a = 2 * kPi * static_cast<float>(i) / 9, b = 2 * kPi * static_cast<float>(j) / 6,
                    r = 3 + std::cos(b);
        torus.insert(torus.end(), {r * std::cos(a), r * std::sin(a), std::sin(b)});
      }
    for (const CubicBasis& basis : {kBspline, kCatmullRom, kBezier})
      EXPECT_EQ(openEdges(*make(primitive(bicubic(9, 6, basis, true, true), torus)), cells), 0u) << cells;
    EXPECT_EQ(openEdges(*make(primitive(bilinear(9, 6, true, true), torus)), cells), 0u) << cells;
    // A B-spline closed by hand: its first three columns repeated.
    std::vector<float> wrapped;
    for (int j = 0; j < 6; ++j)
      for (int i = 0; i < 12; ++i) {
        const float* point = &torus[static_cast<size_t>(3 * (9 * j + i % 9))];
        wrapped.insert(wrapped.end(), point, point + 3);
      }
    EXPECT_EQ(openEdges(*make(primitive(bicubic(12, 6, kBspline, false, true), wrapped)), cells), 0u)
        << cells;
  }
  // A ball out of one periodic Bezier mesh whose first and last rows are points: u turns, v goes up.
  std::vector<float> ball;
  for (int j = 0; j < 7; ++j)
    for (int i = 0; i < 12; ++i) {
      const float a = 2 * kPi * static_cast<float>(i) / 12, r = j == 0 || j == 6 ? 0.0f : 1.0f;
      ball.insert(ball.end(), {r * std::cos(a) + 0.1f, r * std::sin(a) + 0.1f, static_cast<float>(j) / 6});
    }
  EXPECT_EQ(openEdges(*make(primitive(bicubic(12, 7, kBezier, true, false), ball)), 16), 0u);
  EXPECT_GT(volume(*make(primitive(bicubic(12, 7, kBezier, true, false), ball)), 16), 0);
}

TEST(ParametricMesh, TessellationIsEvaluation) {
  const auto s = make(primitive(bicubic(6, 5, kBspline), wavyPoints(6, 5)));
  const std::vector<V3f> grid = tessellated(*s, 8);
  for (uint32_t face = 0; face < s->faceCount(); ++face)
    for (size_t k = 0; k < 81; ++k)
      EXPECT_EQ(Bits(grid[face * 81 + k]),
                Bits(s->evaluate(face, static_cast<float>(k % 9) / 8, static_cast<float>(k / 9) / 8).P));
}

TEST(ParametricMesh, HostileInput) {
  const auto report = [](const Primitive& p) {
    Messages messages;
    EXPECT_EQ(makeSurface(p, messages.handler), nullptr);
    return messages.all();
  };
  using ::testing::HasSubstr;
  EXPECT_THAT(report(primitive(bicubic(5, 4, kBezier), wavyPoints(5, 4))),
              HasSubstr("5 x 4 points make no whole number of bicubic patches (basis steps 3 and 3)"));
  EXPECT_THAT(report(primitive(bilinear(1, 4), wavyPoints(1, 4))), HasSubstr("bilinear patches"));
  EXPECT_THAT(report(primitive(bilinear(-2, -2), wavyPoints(2, 2))), HasSubstr("no whole number"));
  EXPECT_THAT(report(primitive(bilinear(3, 3), wavyPoints(2, 2))), HasSubstr("needs 9 points, not 4"));
  EXPECT_THAT(report(primitive(bilinear(1 << 30, 1 << 30), wavyPoints(2, 2))), HasSubstr("points, not 4"));
  EXPECT_THAT(report(primitive(bilinear(2, 2))), HasSubstr("needs \"P\" or \"Pw\""));
  EXPECT_THAT(report(primitive(bilinear(2, 2), {0, 0, 0, 1, 0, 0, kInfinity, 1, 0, 1, 1, 1})),
              HasSubstr("point 2 is not finite"));
  EXPECT_THAT(report(primitive(bilinear(2, 2), {1, 2, 3, 1, 2, 3, 1, 2, 3, 1, 2, 3})), HasSubstr("no area"));
  CubicBasis broken = kBezier;
  broken.matrix[1][1] = NAN;
  EXPECT_THAT(report(primitive(bicubic(4, 4, broken), wavyPoints(4, 4))), HasSubstr("basis matrix"));
  broken = kBezier;
  broken.step = 0;
  EXPECT_THAT(report(primitive(bicubic(4, 4, broken), wavyPoints(4, 4))), HasSubstr("no whole number"));
  Primitive p = primitive(bilinear(2, 2));
  p.variables.push_back(variable("Pw", StorageClass::Vertex, ValueType::HPoint, 4,
                                 {0, 0, 0, 1, 1, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, 1}));
  EXPECT_THAT(report(p), HasSubstr("the weight of point 2 is not positive"));
}

}  // namespace
}  // namespace patina
