// SPDX-License-Identifier: Apache-2.0
// Curves: the splines of every basis, ribbons and tubes, joints without cracks, frames without twist, widths,
// variables, hostile values.
#include <gmock/gmock.h>

#include <array>
#include <random>

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

CurveSet cubic(const CubicBasis& basis, std::vector<int> counts, bool periodic = false, bool round = false) {
  return {true, periodic, round, basis, std::move(counts)};
}
CurveSet linear(std::vector<int> counts, bool periodic = false, bool round = false) {
  return {false, periodic, round, {}, std::move(counts)};
}

std::vector<float> wavy(int n, uint32_t seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> noise(-0.4f, 0.4f);
  std::vector<float> P;
  for (int i = 0; i < n; ++i)
    P.insert(P.end(), {static_cast<float>(i) + noise(random), noise(random) * 2, 4 + noise(random) * 2});
  return P;
}

/// A closed ring with ups and downs.
std::vector<float> ring(int n) {
  std::vector<float> P;
  for (int i = 0; i < n; ++i) {
    const float a = 2 * kPi * static_cast<float>(i) / static_cast<float>(n);
    P.insert(P.end(), {3 * std::cos(a), 3 * std::sin(a), std::sin(2 * a) + 5});
  }
  return P;
}

Primitive curves(CurveSet set, std::vector<float> P, float width = 0.2f) {
  Primitive p = primitive(std::move(set), std::move(P));
  p.variables.push_back(variable("constantwidth", StorageClass::Constant, ValueType::Float, 1, {width}));
  return p;
}

V3d pointOf(const std::vector<float>& P, size_t k) { return V3d(V3f(P[3 * k], P[3 * k + 1], P[3 * k + 2])); }

// The formulas of the splines as their books have them, in double.
TEST(Curves, EveryBasisIsItsSpline) {
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
    for (const bool round : {false, true}) {
      const int points = 4 + 2 * c.basis.step;  // three segments
      const std::vector<float> P = wavy(points);
      const auto s = make(curves(cubic(c.basis, {points}, false, round), P));
      ASSERT_EQ(s->faceCount(), 3u);
      for (uint32_t face = 0; face < 3; ++face)
        for (float v : {0.0f, 0.2f, 0.5f, 0.9f, 1.0f}) {
          const Weights w = c.weights(static_cast<double>(v));
          V3d expected(0);
          for (size_t k = 0; k < 4; ++k)
            expected += pointOf(P, face * static_cast<size_t>(c.basis.step) + k) * w[k];
          // Opposite points lie at the same distance from the curve.
          const V3f a = s->evaluate(face, 0, v).P, b = s->evaluate(face, round ? 0.5f : 1, v).P;
          const float tolerance = 1e-6f * (1 + static_cast<float>(expected.length()));
          expectNear((a + b) * 0.5f, V3f(expected), tolerance);
          EXPECT_NEAR((a - b).length(), 0.2f, tolerance);
        }
      EXPECT_EQ(s->surfaceParameters(1, 0.25f, 0.5f), V2f(0.25f, 0.5f));
      EXPECT_EQ(s->surfaceParameters(2, 1, 1), V2f(1, 1));
      EXPECT_EQ(s->parameterScale(0), V2f(1, 1 / 3.0f));
    }
}

TEST(Curves, PeriodicOnesWrap) {
  for (const auto& [basis, segments] :
       {std::pair{kBezier, 2u}, {kBspline, 6u}, {kCatmullRom, 6u}, {kHermite, 3u}}) {
    const auto s = make(curves(cubic(basis, {6}, true), ring(6)));
    ASSERT_EQ(s->faceCount(), segments);
    for (float u : {0.0f, 0.7f, 1.0f})
      EXPECT_EQ(Bits(s->evaluate(segments - 1, u, 1).P), Bits(s->evaluate(0, u, 0).P));
  }
  EXPECT_EQ(make(curves(linear({6}, true), ring(6)))->faceCount(), 6u);
  EXPECT_EQ(make(curves(cubic(kPower, {8}, true), ring(8)))->faceCount(), 2u);
}

// Central differences of positions in float: good to about 1e-3 of sizes near 1.
TEST(Curves, DerivativesAreThoseOfThePosition) {
  for (const bool round : {false, true})
    for (const bool normals : {false, true})
      for (const CubicBasis& basis : {kBezier, kBspline, kCatmullRom, kHermite}) {
        const int n = 4 + basis.step;
        Primitive p = primitive(cubic(basis, {n}, false, round), wavy(n, 5));
        p.variables.push_back(
            variable("width", StorageClass::Varying, ValueType::Float, 1, {0.1f, 0.7f, 0.4f}));
        if (normals)
          p.variables.push_back(variable("N", StorageClass::Varying, ValueType::Normal, 3,
                                         {0, 0, -1, 0, 0.6f, -0.8f, 0.3f, 1, -0.2f}));
        const auto s = make(std::move(p));
        for (uint32_t face = 0; face < 2; ++face)
          for (float u : {0.0f, 0.3f, 1.0f})
            for (float v : {0.03f, 0.3f, 0.55f, 0.95f}) expectDerivatives(*s, face, u, v, 4e-3f);
      }
  // Half a turn within one segment, where the smallest rotation from its start to its end is not defined.
  const auto bend =
      make(curves(cubic(kBezier, {4}, false, true), {0, 0, 0, 2, 0, 0, 2, 1, 0.5f, 0, 1, 0.5f}, 0.3f));
  for (float v : {0.1f, 0.4f, 0.9f, 1.0f}) expectDerivatives(*bend, 0, 0.2f, v, 1e-2f);
}

TEST(Curves, RibbonsFaceTheEye) {
  Messages messages;
  const Primitive p = curves(cubic(kBspline, {7}), wavy(7));
  for (const Viewpoint& view :
       {Viewpoint{}, Viewpoint{true, {1, 9, -3}, {}}, Viewpoint{false, {}, {0, 0.6f, 0.8f}}}) {
    const auto s = makeSurface(p, messages.handler, view);
    for (uint32_t face = 0; face < s->faceCount(); ++face)
      for (float v : {0.0f, 0.5f, 1.0f}) {
        const SurfacePoint a = s->evaluate(face, 0, v), b = s->evaluate(face, 0.5f, v);
        const V3f toEye = view.perspective ? (view.eye - b.P).normalized() : -view.direction;
        EXPECT_NEAR((b.P - a.P).dot(toEye), 0, 1e-6f);
        EXPECT_GT(b.N.dot(toEye), 0);
        expectNear(b.N, b.dPdu.cross(b.dPdv).normalized(), 1e-6f);
      }
  }
}

TEST(Curves, RibbonsLieAcrossN) {
  // A straight curve along x whose normal turns from z to y: across is x cross N.
  Primitive p = curves(linear({3}, false, true), {0, 0, 0, 1, 0, 0, 2, 0, 0}, 2);  // N wins over round
  p.variables.push_back(
      variable("N", StorageClass::Vertex, ValueType::Normal, 3, {0, 0, 1, 0, 1, 1, 0, 1, 0}));
  const auto s = make(std::move(p));
  expectNear(s->evaluate(0, 1, 0).P, {0, -1, 0}, 1e-6f);
  expectNear(s->evaluate(0, 0, 0).N, {0, 0, 1}, 1);
  expectNear(s->evaluate(1, 1, 1).P, {2, 0, 1}, 1e-6f);
  const float r = std::sqrt(0.5f);
  expectNear(s->evaluate(0, 1, 1).P, {1, -r, r}, 1e-6f);
  expectNear(s->evaluate(0, 0.5f, 0.5f).N, V3f(0, 0.5f, 1).normalized(), 1e-6f);
}

TEST(Curves, TubesAreRoundAndFaceOut) {
  const std::vector<float> P = wavy(7, 3);
  const auto s = make(curves(cubic(kCatmullRom, {7}, false, true), P, 0.1f));
  for (uint32_t face = 0; face < 4; ++face)
    for (float v : {0.0f, 0.4f, 1.0f}) {
      const V3f middle = (s->evaluate(face, 0, v).P + s->evaluate(face, 0.5f, v).P) * 0.5f;
      V3f last = s->evaluate(face, 0, v).P;
      EXPECT_EQ(Bits(last), Bits(s->evaluate(face, 1, v).P));
      for (int k = 1; k <= 8; ++k) {
        const SurfacePoint p = s->evaluate(face, static_cast<float>(k) / 8, v);
        EXPECT_NEAR((p.P - middle).length(), 0.05f, 1e-6f);
        EXPECT_NEAR((p.P - last).length(), 0.1f * std::sin(kPi / 8), 1e-6f);
        expectNear(p.N, (p.P - middle).normalized(), 1e-5f);  // of a canal surface of constant radius
        last = p.P;
      }
    }
}

// Neighbouring segments, seams and closed rings share every vertex: what stays open are rims.
TEST(Curves, NothingGapes) {
  const std::vector<float> zigzag{0, 0, 5, 1, 0, 5, 1, 1, 5, 0.2f, 1, 6, 0.2f, 0, 6, 2, 2, 4};
  for (const uint32_t cells : {4u, 16u}) {
    for (const CubicBasis& basis : {kBezier, kBspline, kCatmullRom, kHermite}) {
      const int n = 4 + 3 * basis.step;
      for (uint32_t seed = 0; seed < 8; ++seed) {
        EXPECT_EQ(openEdges(*make(curves(cubic(basis, {n}, false, true), wavy(n, seed))), cells), 2 * cells);
        EXPECT_EQ(openEdges(*make(curves(cubic(basis, {n}), wavy(n, seed))), cells), 2 * cells + 8 * cells);
      }
      EXPECT_EQ(openEdges(*make(curves(cubic(basis, {12}, true, true), ring(12))), cells), 0u);
      const uint32_t segments = 12 / static_cast<uint32_t>(basis.step);
      EXPECT_EQ(openEdges(*make(curves(cubic(basis, {12}, true), ring(12))), cells), 2 * cells * segments);
    }
    EXPECT_EQ(openEdges(*make(curves(linear({6}, false, true), zigzag)), cells), 2 * cells);
    EXPECT_EQ(openEdges(*make(curves(linear({6}), zigzag)), cells), 2 * cells + 10 * cells);
    EXPECT_EQ(openEdges(*make(curves(linear({6}, true, true), zigzag)), cells), 0u);
    // Two curves of different lengths; normals and widths of their own.
    Primitive p = primitive(linear({2, 4}), zigzag);
    p.variables.push_back(
        variable("width", StorageClass::Vertex, ValueType::Float, 1, {0.1f, 0.2f, 0.3f, 0.2f, 0.1f, 0.05f}));
    p.variables.push_back(variable("N", StorageClass::Varying, ValueType::Normal, 3,
                                   {0, 0, -1, 0, 0, -1, 0, 1, 0, 1, 0, 0.3f, 0, 0.5f, -1, 0, 0, 1}));
    EXPECT_EQ(openEdges(*make(std::move(p)), cells), 2 * (2 * cells) + (2 + 6) * cells);
  }
  // Pappus: the volume of a torus is that of its circle times the way of its centre; positive: N is outside.
  std::vector<float> circle;
  for (int i = 0; i < 48; ++i) {
    const float a = 2 * kPi * static_cast<float>(i) / 48;
    circle.insert(circle.end(), {3 * std::cos(a), 3 * std::sin(a), 0});
  }
  EXPECT_NEAR(volume(*make(curves(cubic(kCatmullRom, {48}, true, true), circle, 2)), 32),
              6 * std::numbers::pi * std::numbers::pi, 0.5);
}

// The angle of an axis of a frame to the binormal of a helix of radius a and slope b turns back by the
// torsion b / (a^2 + b^2) per length (Bishop 1975): by 2 pi b / sqrt(a^2 + b^2) in a turn.
TEST(Curves, FramesDoNotTwist) {
  constexpr double a = 1, b = 0.5;
  constexpr int kTurnPoints = 48;
  std::vector<float> P;
  for (int i = -1; i <= kTurnPoints + 1; ++i) {
    const double t = 2 * std::numbers::pi * i / kTurnPoints;
    P.insert(P.end(), {static_cast<float>(a * std::cos(t)), static_cast<float>(a * std::sin(t)),
                       static_cast<float>(b * t)});
  }
  const auto s = make(curves(cubic(kCatmullRom, {kTurnPoints + 3}, false, true), P));
  const auto angle = [&](uint32_t face, float v, double t) {
    const V3f middle = (s->evaluate(face, 0, v).P + s->evaluate(face, 0.5f, v).P) * 0.5f;
    const V3d axis = V3d((s->evaluate(face, 0, v).P - middle) * 10.0f);
    const double l = std::hypot(a, b);
    const V3d normal(-std::cos(t), -std::sin(t), 0),
        binormal(b / l * std::sin(t), -b / l * std::cos(t), a / l);
    return std::atan2(axis.dot(binormal), axis.dot(normal));
  };
  const double start = angle(0, 0, 0);
  for (const int k : {6, 24, 48}) {
    const double t = 2 * std::numbers::pi * k / kTurnPoints;
    const double turned = angle(static_cast<uint32_t>(k - 1), 1, t) - start;
    EXPECT_NEAR(std::remainder(turned + b / std::hypot(a, b) * t, 2 * std::numbers::pi), 0, 2e-3) << k;
  }
  // In a plane, the axis keeps its height over the plane, also in one segment of three quarters of a turn.
  const auto flat = make(curves(cubic(kBezier, {4}, false, true), {0, 0, 0, 4, 0, 0, 4, 4, 0, -1, 3, 0}));
  const float height = flat->evaluate(0, 0, 0).P.z;
  for (float v : {0.1f, 0.3f, 0.5f, 0.8f, 1.0f}) EXPECT_NEAR(flat->evaluate(0, 0, v).P.z, height, 1e-6f);
}

TEST(Curves, WidthsOfEveryClass) {
  // Two Bezier curves, of two segments and of one: 3 faces, 5 varying values, 11 points.
  const auto width = [](StorageClass storage, std::vector<float> values, uint32_t face, float v) {
    float found[2];
    for (const bool round : {false, true}) {
      Primitive p = curves(cubic(kBezier, {7, 4}, false, round), wavy(11), 77);
      p.variables.push_back(variable("width", storage, ValueType::Float, 1, values));
      const auto s = make(std::move(p));
      found[round] = (s->evaluate(face, 0, v).P - s->evaluate(face, round ? 0.5f : 1, v).P).length();
    }
    EXPECT_NEAR(found[0], found[1], 2e-6f);
    return found[0];
  };
  EXPECT_NEAR(width(StorageClass::Constant, {0.3f}, 2, 0.5f), 0.3f, 2e-6f);
  EXPECT_NEAR(width(StorageClass::Uniform, {0.3f, 0.6f}, 1, 0.5f), 0.3f, 2e-6f);
  EXPECT_NEAR(width(StorageClass::Uniform, {0.3f, 0.6f}, 2, 1), 0.6f, 2e-6f);
  EXPECT_NEAR(width(StorageClass::Varying, {0, 0.1f, 0.3f, 0.5f, 0.9f}, 1, 0.25f), 0.15f, 2e-6f);
  EXPECT_NEAR(width(StorageClass::FaceVarying, {0, 0.1f, 0.3f, 0.5f, 0.9f}, 2, 0.75f), 0.8f, 2e-6f);
  const std::vector<float> eleven{0, 0, 0, 0.8f, 0, 0, 0, 0.1f, 0.2f, 0.3f, 0.4f};
  EXPECT_NEAR(width(StorageClass::Vertex, eleven, 1, 0.5f), 0.1f, 2e-6f);
  EXPECT_NEAR(width(StorageClass::Vertex, eleven, 2, 0.5f), 0.25f, 2e-6f);
  EXPECT_EQ(width(StorageClass::Varying, {0.2f, -0.1f, -0.1f, 0, 0}, 0, 1), 0);  // negative counts as 0
  // Neither: 1 in object space.
  EXPECT_NEAR(make(primitive(linear({2}), {0, 0, 1, 1, 0, 1}))->evaluate(0, 1, 0).dPdu.length(), 1, 1e-6f);
}

TEST(Curves, TipsAreFine) {
  for (const bool round : {false, true}) {
    Primitive p = primitive(cubic(kBezier, {4}, false, round), {0, 0, 5, 0, 1, 5, 0.2f, 2, 5, 0.5f, 3, 5});
    p.variables.push_back(variable("width", StorageClass::Varying, ValueType::Float, 1, {0.2f, 0}));
    const auto s = make(std::move(p));
    for (float u : {0.0f, 0.3f, 1.0f}) {
      const SurfacePoint tip = s->evaluate(0, u, 1);
      expectNear(tip.P, {0.5f, 3, 5}, 0);
      EXPECT_EQ(tip.dPdu, V3f(0, 0, 0));
      EXPECT_NEAR(tip.N.length(), 1, 1e-6f);
      expectNear(tip.N, s->evaluate(0, u, 0.999f).N, 1e-2f);
    }
  }
}

TEST(Curves, VariablesOfEveryClass) {
  Primitive p = curves(cubic(kBspline, {5, 4}, false, true), wavy(9));
  p.variables.push_back(variable("constant", StorageClass::Constant, ValueType::Float, 1, {9}));
  p.variables.push_back(variable("uniform", StorageClass::Uniform, ValueType::Float, 1, {1, 2}));
  p.variables.push_back(variable("varying", StorageClass::Varying, ValueType::Float, 1, {0, 1, 2, 10, 11}));
  p.variables.push_back(
      variable("facevarying", StorageClass::FaceVarying, ValueType::Float, 1, {0, 1, 2, 10, 11}));
  p.variables.push_back(
      variable("facevertex", StorageClass::FaceVertex, ValueType::Float, 1, {0, 1, 2, 10, 11}));
  p.variables.push_back(variable("vertex", StorageClass::Vertex, ValueType::Point, 3, wavy(9)));
  p.variables.push_back(
      variable("st", StorageClass::Varying, ValueType::Float, 2, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9}));
  const auto s = make(std::move(p));
  const auto value = [&](const char* name, uint32_t face, float v) {
    V3f out(0);
    s->interpolate(*findVariable(*s.primitive, name), face, 0.3f, v, out.getValue());
    return out;
  };
  EXPECT_EQ(value("constant", 2, 0.5f).x, 9);
  EXPECT_EQ(value("uniform", 1, 0.5f).x, 1);
  EXPECT_EQ(value("uniform", 2, 0.5f).x, 2);
  for (const char* name : {"varying", "facevarying", "facevertex"}) {
    EXPECT_EQ(value(name, 0, 0.5f).x, 0.5f) << name;
    EXPECT_EQ(value(name, 1, 0.25f).x, 1.25f) << name;
    EXPECT_EQ(value(name, 2, 0.5f).x, 10.5f) << name;
  }
  EXPECT_EQ(value("st", 1, 1), V3f(4, 5, 0));
  expectNear(value("vertex", 2, 0.7f), (s->evaluate(2, 0, 0.7f).P + s->evaluate(2, 0.5f, 0.7f).P) * 0.5f,
             1e-6f);
  for (uint32_t face : {0u, 1u, 2u}) EXPECT_EQ(s->uniformIndex(face), face / 2);
  // Periodic: as many varying values as segments; the last segment leads back to the first.
  Primitive q = curves(linear({3}, true), ring(3));
  q.variables.push_back(variable("varying", StorageClass::Varying, ValueType::Float, 1, {0, 1, 4}));
  const auto t = make(std::move(q));
  float out = 0;
  t->interpolate(*findVariable(*t.primitive, "varying"), 2, 0, 0.25f, &out);
  EXPECT_EQ(out, 3);
}

TEST(Curves, RationalCurvesAreProjected) {
  // A quarter circle as a rational cubic: the quadratic weights (1, 1, 2) raised by one degree.
  const float q = 2.0f / 3;
  for (const bool round : {false, true}) {
    Primitive p = curves(cubic(kBezier, {4}, false, round), {});
    p.variables.push_back(variable("Pw", StorageClass::Vertex, ValueType::HPoint, 4,
                                   {1, 0, 0, 1, 1, q, 0, 1, q, 2 * q, 0, 2 * q, 0, 2, 0, 2}));
    const auto s = make(std::move(p));
    for (float v : {0.0f, 0.3f, 0.7f, 1.0f}) {
      const V3f middle = (s->evaluate(0, 0, v).P + s->evaluate(0, round ? 0.5f : 1, v).P) * 0.5f;
      EXPECT_NEAR(middle.length(), 1, 1e-6f);
      if (round) expectDerivatives(*s, 0, 0.3f, v, 2e-3f);
    }
  }
}

TEST(Curves, TheBoundHoldsThem) {
  for (const CubicBasis& basis : {kBezier, kBspline, kCatmullRom, kHermite, kPower})
    for (uint32_t seed = 0; seed < 20; ++seed)
      for (const bool round : {false, true}) {
        Primitive p = primitive(cubic(basis, {4 + basis.step}, false, round), wavy(4 + basis.step, seed));
        std::vector<float> widths;
        for (int k = 0; k < 4 + basis.step; ++k) widths.push_back(static_cast<float>((k * 7 + 3) % 5) * 0.2f);
        p.variables.push_back(variable("width", StorageClass::Vertex, ValueType::Float, 1, widths));
        const auto s = make(std::move(p));
        const std::vector<V3f> grid = tessellated(*s, 8);
        for (const V3f& q : grid) ASSERT_TRUE(s->bound().intersects(q)) << q;
      }
}

TEST(Curves, CornersAndTessellationAreEvaluation) {
  for (const bool round : {false, true}) {
    const auto s = make(curves(linear({3}, false, round), {0, 0, 5, 1, 0, 5, 1, 1, 6}));
    const std::vector<V3f> grid = tessellated(*s, 4);
    for (uint32_t face = 0; face < 2; ++face) {
      V3f c[4];
      s->corners(face, c);
      for (size_t k = 0; k < 25; ++k) {
        const auto u = static_cast<float>(k % 5) / 4, v = static_cast<float>(k / 5) / 4;
        EXPECT_EQ(Bits(grid[face * 25 + k]), Bits(s->evaluate(face, u, v).P));
      }
      for (size_t k = 0; k < 4; ++k)
        EXPECT_EQ(Bits(c[k]), Bits(grid[face * 25 + 4 * (k % 2) + 20 * (k / 2)]));
    }
  }
}

// A million hairs of 4 points must fit into a few hundred MB: the figures of a thousandth of them.
TEST(Curves, HairIsSmall) {
  constexpr int kHairs = 1000;
  std::vector<float> P;
  for (int i = 0; i < kHairs; ++i)
    for (int k = 0; k < 4; ++k)
      P.insert(P.end(),
               {static_cast<float>(i) * 0.01f, static_cast<float>(k), 0.1f * static_cast<float>(k * k)});
  const auto bytesPerHair = [&](CurveSet set) {
    return static_cast<double>(make(curves(std::move(set), P))->memory()) / kHairs;
  };
  const std::vector<int> counts(kHairs, 4);
  EXPECT_LT(bytesPerHair(cubic(kBspline, counts)), 10);
  EXPECT_LT(bytesPerHair(cubic(kBspline, counts, false, true)), 26);
  EXPECT_LT(bytesPerHair(linear(counts)), 22);
  EXPECT_LT(bytesPerHair(linear(counts, false, true)), 54);
}

TEST(Curves, HostileShapesStayFinite) {
  const auto check = [](const Primitive& p) {
    Messages messages;
    for (const Viewpoint& view : {Viewpoint{}, Viewpoint{false, {}, {0, 0, 1}}}) {
      const auto s = makeSurface(p, messages.handler, view);
      ASSERT_TRUE(s) << messages.all();
      for (uint32_t face = 0; face < s->faceCount(); ++face)
        for (float u : {0.0f, 0.4f, 1.0f})
          for (float v : {0.0f, 0.25f, 0.5f, 1.0f}) {
            const SurfacePoint q = s->evaluate(face, u, v);
            ASSERT_TRUE(isFinite(q.P) && isFinite(q.dPdu) && isFinite(q.dPdv)) << q.P << q.dPdu << q.dPdv;
            ASSERT_NEAR(q.N.length(), 1, 1e-5f) << face << " " << u << " " << v;
          }
    }
  };
  const std::array<std::vector<float>, 8> shapes{{
      {0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0, 4},                    // along the line of sight
      {1, 2, 3, 1, 2, 3, 1, 2, 3, 1, 2, 3},                    // a point
      {0, 0, 5, 0, 0, 5, 1, 0, 5, 1, 0, 5},                    // doubled ends
      {0, 0, 5, 1, 0, 5, 0, 0, 5, 1, 0, 5},                    // there and back
      {0, 0, 5, 1, 1, 5, 0, 1, 5, 1, 0, 5},                    // crosses itself
      {0, 0, 5, 1, 0, 5, 2, 0, 5, 0, 0, 5},                    // a cusp
      {0, 0, 5, 0, 0, 5, 0, 0, 5, 1, 0, 5},                    // tripled
      {-1e17f, 0, 0, 1e17f, 1, 0, 1e-30f, 0, 0, 1e17f, 0, 0},  // huge
  }};
  for (const std::vector<float>& P : shapes)
    for (const bool round : {false, true})
      for (const bool periodic : {false, true})
        for (const float width : {0.5f, 0.0f, -1.0f, 1e-30f, 1e10f}) {
          check(curves(linear({4}, periodic, round), P, width));
          for (const CubicBasis& basis : {kBspline, kCatmullRom, kHermite, kPower})
            check(curves(cubic(basis, {4}, periodic, round), P, width));
          if (!periodic) check(curves(cubic(kBezier, {4}, false, round), P, width));
        }
  Primitive p =
      curves(linear({4}), wavy(4));  // normals that vanish, run along the curve, or turn right round
  p.variables.push_back(
      variable("N", StorageClass::Varying, ValueType::Normal, 3, {0, 0, 0, 0, 0, 1, 0, 0, -1, 1, 0, 0}));
  check(p);
}

TEST(Curves, BadInputIsRefused) {
  const auto report = [](const Primitive& p) {
    Messages messages;
    EXPECT_EQ(makeSurface(p, messages.handler), nullptr);
    return messages.all();
  };
  using ::testing::HasSubstr;
  EXPECT_THAT(report(primitive(linear({2}))),
              HasSubstr("test.rib:7:3: error: missingdata: Curves are left out: they "
                        "need \"P\""));
  EXPECT_THAT(report(curves(linear({2, 2}), wavy(3))), HasSubstr("they need 4 points, not 3"));
  EXPECT_THAT(report(curves(linear({2147483647}), wavy(3))), HasSubstr("they need 2147483647 points, not 3"));
  EXPECT_THAT(report(curves(linear({4, 1}), wavy(5))), HasSubstr("1 points make no whole number of linear "
                                                                 "segments (curve 1)"));
  EXPECT_THAT(report(curves(linear({std::numeric_limits<int>::min()}), wavy(5))),
              HasSubstr("no whole number"));
  EXPECT_THAT(report(curves(cubic(kBezier, {6}), wavy(6))),
              HasSubstr("6 points make no whole number of cubic"));
  EXPECT_THAT(report(curves(cubic(kBezier, {7}, true), wavy(7))), HasSubstr("no whole number"));
  EXPECT_THAT(report(curves(linear({}), wavy(2))), HasSubstr("there is no curve"));
  EXPECT_THAT(report(curves(linear({2}), {0, 0, 0, kInfinity, 0, 0})), HasSubstr("point 1 is not finite"));
  EXPECT_THAT(report(curves(linear({2}), wavy(2), NAN)), HasSubstr("a width is not finite"));
  CubicBasis broken = kBezier;
  broken.matrix[1][1] = NAN;
  EXPECT_THAT(report(curves(cubic(broken, {4}), wavy(4))), HasSubstr("basis matrix"));
  broken = kBezier;
  broken.step = 0;
  EXPECT_THAT(report(curves(cubic(broken, {4}), wavy(4))), HasSubstr("no whole number"));
  Primitive p = primitive(linear({2}), wavy(2));
  p.variables.push_back(variable("width", StorageClass::Varying, ValueType::Float, 1, {1}));
  EXPECT_THAT(report(p), HasSubstr("too few values"));
  p = primitive(linear({2}));
  p.variables.push_back(
      variable("Pw", StorageClass::Vertex, ValueType::HPoint, 4, {0, 0, 0, 1, 1, 0, 0, -1}));
  EXPECT_THAT(report(p), HasSubstr("the weight of point 1 is not positive"));
}

}  // namespace
}  // namespace patina
