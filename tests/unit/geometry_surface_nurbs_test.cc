// SPDX-License-Identifier: Apache-2.0
// NuPatch: the Cox-de Boor definition, conics, closure, ranges, variables, holes, refusals.
#include <gmock/gmock.h>

#include <array>
#include <random>

#include "renderer/geometry/spline_direction.h"
#include "renderer/scene/trim_region.h"
#include "tests/unit/geometry_surface_fixtures.h"

namespace patina {
namespace {

using namespace test;

const float kRoot = std::sqrt(0.5f);
/// A unit circle of nine homogeneous points (x, y, w) with these knots (Piegl and Tiller, example 7.2).
const std::array<std::array<float, 3>, 9> kCircle{{{1, 0, 1},
                                                   {kRoot, kRoot, kRoot},
                                                   {0, 1, 1},
                                                   {-kRoot, kRoot, kRoot},
                                                   {-1, 0, 1},
                                                   {-kRoot, -kRoot, kRoot},
                                                   {0, -1, 1},
                                                   {kRoot, -kRoot, kRoot},
                                                   {1, 0, 1}}};
const SplineKnots kCircleKnots{9, 3, {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4}, 0, 4};

SplineKnots uniformKnots(int count, int order) {
  SplineKnots s{count, order, {}, 0, 0};
  for (int k = 0; k < count + order; ++k) s.knots.push_back(static_cast<float>(k));
  s.min = static_cast<float>(order - 1), s.max = static_cast<float>(count);
  return s;
}
SplineKnots clampedKnots(int count, int order) {
  SplineKnots s{count, order, {}, 0, static_cast<float>(count - order + 1)};
  for (int k = 0; k < count + order; ++k)
    s.knots.push_back(static_cast<float>(std::clamp(k - order + 1, 0, count - order + 1)));
  return s;
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

Primitive rational(NurbsPatch patch, std::vector<float> Pw) {
  Primitive p = primitive(std::move(patch));
  p.variables.push_back(variable("Pw", StorageClass::Vertex, ValueType::HPoint, 4, std::move(Pw)));
  return p;
}

/// A profile of homogeneous (r, z, w), turned about z.
Primitive revolved(const std::vector<std::array<float, 3>>& profile, const SplineKnots& v) {
  std::vector<float> Pw;
  for (const auto& [r, z, w] : profile)
    for (const auto& [x, y, c] : kCircle) Pw.insert(Pw.end(), {x * r, y * r, z * c, w * c});
  return rational({kCircleKnots, v, nullptr}, Pw);
}
Primitive ball() {
  return revolved({{0, -1, 1}, {kRoot, -kRoot, kRoot}, {1, 0, 1}, {kRoot, kRoot, kRoot}, {0, 1, 1}},
                  {5, 3, {0, 0, 0, 1, 1, 2, 2, 2}, 0, 2});
}
Primitive torus() {
  std::vector<std::array<float, 3>> profile;
  for (const auto& [x, y, w] : kCircle) profile.push_back({2 * w + 0.5f * x, 0.5f * y, w});
  return revolved(profile, kCircleKnots);
}

/// The definition: N(i, p) as a recursive function, 0/0 = 0 (the NURBS Book, equation 2.5).
double coxDeBoor(const std::vector<float>& knots, size_t i, int p, double t) {
  const auto k = [&](size_t n) { return static_cast<double>(knots[n]); };
  const auto n = static_cast<size_t>(p);
  if (p == 0) return k(i) <= t && t < k(i + 1) ? 1 : 0;
  const double a = k(i + n) > k(i) ? (t - k(i)) / (k(i + n) - k(i)) : 0;
  const double b = k(i + n + 1) > k(i + 1) ? (k(i + n + 1) - t) / (k(i + n + 1) - k(i + 1)) : 0;
  return a * coxDeBoor(knots, i, p - 1, t) + b * coxDeBoor(knots, i + 1, p - 1, t);
}
V3d byDefinition(const NurbsPatch& patch, const std::vector<float>& points, size_t components, double u,
                 double v) {
  double sum[4] = {};
  for (int j = 0; j < patch.v.count; ++j)
    for (int i = 0; i < patch.u.count; ++i) {
      const double weight = coxDeBoor(patch.u.knots, static_cast<size_t>(i), patch.u.order - 1, u) *
                            coxDeBoor(patch.v.knots, static_cast<size_t>(j), patch.v.order - 1, v);
      for (size_t c = 0; c < 4; ++c)
        sum[c] +=
            weight *
            (c < components
                 ? static_cast<double>(points[static_cast<size_t>(j * patch.u.count + i) * components + c])
                 : 1.0);
    }
  return V3d(sum[0], sum[1], sum[2]) / sum[3];
}

TEST(Nurbs, IsTheDefinition) {
  // Uneven knots, double ones, a range that begins and ends within intervals.
  const SplineKnots u{8, 4, {0, 0.5f, 1, 1.5f, 2, 2.25f, 2.25f, 4, 5, 6, 7, 8}, 1.75f, 4.5f};
  const SplineKnots v{5, 3, {-1, -1, -1, 0, 3, 4, 4, 4}, -1, 4};
  std::vector<float> Pw;
  for (const float x : wavyPoints(8, 5)) {
    Pw.push_back(x);
    if (Pw.size() % 4 == 3) Pw.push_back(0.5f + 0.3f * static_cast<float>(Pw.size() % 7));
  }
  const NurbsPatch patch{u, v, nullptr};
  const auto plain = make(primitive(patch, wavyPoints(8, 5)));
  const auto weighted = make(rational(patch, Pw));
  ASSERT_EQ(plain->faceCount(), 4u * 3u);
  for (const auto& [s, points, components] :
       {std::tuple(&plain, wavyPoints(8, 5), size_t{3}), std::tuple(&weighted, Pw, size_t{4})})
    for (uint32_t face = 0; face < 12; ++face)
      for (float x : {0.0f, 0.2f, 0.5f, 0.96875f})
        for (float y : {0.0f, 0.7f}) {
          const V2f t = (*s)->surfaceParameters(face, x, y);
          expectNear((*s)->evaluate(face, x, y).P,
                     V3f(byDefinition(patch, points, components, static_cast<double>(t.x),
                                      static_cast<double>(t.y))),
                     4e-6f);
          expectDerivatives(**s, face, x, y, 6e-3f);
        }
}

TEST(Nurbs, OrdersTwoToSix) {
  // Knots of a periodic spline, whose basis functions are all alike: orders differ along u and v.
  for (int order = 2; order <= 6; ++order) {
    const NurbsPatch patch{uniformKnots(9, order), uniformKnots(8, 8 - order), nullptr};
    std::vector<float> Pw;
    for (const float x : wavyPoints(9, 8, static_cast<uint32_t>(order))) {
      Pw.push_back(x);
      if (Pw.size() % 4 == 3) Pw.push_back(0.5f + 0.3f * static_cast<float>(Pw.size() % 7));
    }
    const auto s = make(rational(patch, Pw));
    ASSERT_EQ(s->faceCount(), static_cast<uint32_t>((10 - order) * (1 + order)));
    for (uint32_t face = 0; face < s->faceCount(); ++face)
      for (const float x : {0.1f, 0.5f, 0.9f}) {
        const V2f t = s->surfaceParameters(face, x, 0.7f);
        const V3d expected = byDefinition(patch, Pw, 4, static_cast<double>(t.x), static_cast<double>(t.y));
        expectNear(s->evaluate(face, x, 0.7f).P, V3f(expected), 1e-5f, "order " + std::to_string(order));
        expectDerivatives(*s, face, x, 0.7f, 1e-2f);
      }
  }
}

TEST(Nurbs, ClampedSplineOfOneIntervalIsBezier) {
  const std::vector<float> P = wavyPoints(4, 4);
  const auto s = make(primitive(NurbsPatch{clampedKnots(4, 4), clampedKnots(4, 4), nullptr}, P));
  ASSERT_EQ(s->faceCount(), 1u);
  EXPECT_EQ(s->evaluate(0, 1, 1).P, V3f(P[45], P[46], P[47]));  // exactly the corner
  // dP/du of a Bezier patch at its corner: three times the first edge.
  expectNear(s->evaluate(0, 0, 0).dPdu, V3f(P[3] - P[0], P[4] - P[1], P[5] - P[2]) * 3.0f, 1e-6f);
}

TEST(Nurbs, SphereIsRoundWithNormalsOutToThePoles) {
  const auto s = make(ball());
  ASSERT_EQ(s->faceCount(), 8u);
  for (uint32_t face = 0; face < 8; ++face)
    for (int i = 0; i <= 8; ++i)
      for (int j = 0; j <= 8; ++j) {
        const SurfacePoint p = s->evaluate(face, static_cast<float>(i) / 8, static_cast<float>(j) / 8);
        EXPECT_NEAR(p.P.length(), 1, 3e-7f);
        expectNear(p.N, p.P, 3e-6f);
      }
  expectDerivatives(*s, 5, 0.3f, 0.6f, 2e-3f);
  EXPECT_EQ(openEdges(*s, 16), 0u);
  // A sphere of 64 x 64 facets a quarter is 4/3 pi less the facets' share, about (pi/128)^2 relative.
  EXPECT_NEAR(volume(*s, 64), 4.0 / 3 * std::numbers::pi, 4e-3);
}

TEST(Nurbs, TorusIsClosed) {
  const auto s = make(torus());
  ASSERT_EQ(s->faceCount(), 16u);
  for (uint32_t cells : {1u, 2u, 16u}) EXPECT_EQ(openEdges(*s, cells), 0u);
  EXPECT_NEAR(volume(*s, 32), 2 * std::numbers::pi * std::numbers::pi * 2 * 0.25, 2e-2);
  for (uint32_t face = 0; face < 16; ++face) {
    const SurfacePoint p = s->evaluate(face, 0.4f, 0.1f);
    EXPECT_NEAR(std::hypot(std::hypot(p.P.x, p.P.y) - 2, p.P.z), 0.5, 1e-6);
  }
}

TEST(Nurbs, SplinesClosedByRepeatedPointsAreWatertight) {
  for (const int order : {2, 3, 4, 6}) {
    // Both ways round; as many points repeated as the degree, knots written with six digits.
    const int nu = 7 + order - 1, nv = 6 + order - 1;
    std::vector<float> P;
    for (int j = 0; j < nv; ++j)
      for (int i = 0; i < nu; ++i) {
        const float a = 2 * kPi * static_cast<float>(i % 7) / 7, b = 2 * kPi * static_cast<float>(j % 6) / 6,
                    r = 3 + std::cos(b);
        P.insert(P.end(), {r * std::cos(a), r * std::sin(a), std::sin(b)});
      }
    NurbsPatch patch{uniformKnots(nu, order), uniformKnots(nv, order), nullptr};
    for (SplineKnots* s : {&patch.u, &patch.v}) {
      for (float& k : s->knots) k = std::round(k / static_cast<float>(s->knots.size() - 1) * 1e6f) / 1e6f;
      s->min = s->knots[static_cast<size_t>(order) - 1], s->max = s->knots[static_cast<size_t>(s->count)];
    }
    const auto s = make(primitive(patch, P));
    EXPECT_EQ(s->faceCount(), 42u);
    for (uint32_t cells : {1u, 4u, 16u}) EXPECT_EQ(openEdges(*s, cells), 0u) << order;
    // One point moved: open, and where the control points say.
    P[0] += 0.5f;
    EXPECT_GT(openEdges(*make(primitive(patch, P)), 4), 0u);
  }
}

TEST(Nurbs, NeighboursShareTheirEdges) {
  // Orders, knots of every multiplicity from one to the order; at the last the two sides may part.
  for (int order = 2; order <= 6; ++order)
    for (int multiplicity = 1; multiplicity <= order; ++multiplicity) {
      SplineKnots s{2 * order + multiplicity, order, {}, 0, 3};
      for (int k = 0; k < order; ++k) s.knots.push_back(0);
      for (int k = 0; k < multiplicity; ++k) s.knots.push_back(0.7f);
      for (int k = 0; k < order; ++k) s.knots.push_back(1.3f + 0.1f * static_cast<float>(k));
      for (int k = 0; k < order; ++k) s.knots.push_back(3);
      ASSERT_EQ(s.knots.size(), static_cast<size_t>(s.count + order));
      // Positions in float would mostly agree even if the weights, in double, did not.
      const SplineDirection direction(s);
      for (uint32_t k = 0; k + 1 < direction.intervals() && multiplicity < order; ++k) {
        const auto end = direction.positionAt(k, 1), begin = direction.positionAt(k + 1, 0);
        EXPECT_EQ(end.first, begin.first);
        for (size_t i = 0; i < direction.order(); ++i) EXPECT_EQ(end.w[i], begin.w[i]);
      }
      std::vector<float> P = wavyPoints(s.count, s.count, 3);
      const auto surface = make(primitive(NurbsPatch{s, s, nullptr}, P));
      const uint32_t across = static_cast<uint32_t>(std::lround(std::sqrt(surface->faceCount())));
      for (float t : {0.0f, 0.3f, 1.0f}) {
        const SurfacePoint a = surface->evaluate(0, 1, t), b = surface->evaluate(1, 0, t);
        const SurfacePoint c = surface->evaluate(0, t, 1), d = surface->evaluate(across, t, 0);
        EXPECT_EQ(Bits(a.P) == Bits(b.P), multiplicity < order) << order << " " << multiplicity;
        EXPECT_EQ(Bits(c.P) == Bits(d.P), multiplicity < order);
        if (multiplicity < order - 1) {
          expectNear(a.N, b.N, 1e-5f);
        }
      }
    }
}

TEST(Nurbs, TessellationIsEvaluationAndBoundHoldsIt) {
  for (const Primitive& p :
       {ball(), torus(),
        primitive(NurbsPatch{uniformKnots(7, 4), clampedKnots(6, 5), nullptr}, wavyPoints(7, 6, 9))}) {
    const auto s = make(p);
    const std::vector<V3f> grid = tessellated(*s, 8);
    for (uint32_t face = 0; face < s->faceCount(); ++face) {
      V3f c[4];
      s->corners(face, c);
      for (size_t k = 0; k < 4; ++k)
        EXPECT_EQ(Bits(c[k]), Bits(grid[face * 81 + 8 * (k % 2) + 72 * (k / 2)]));
      for (size_t k = 0; k < 81; ++k) {
        EXPECT_TRUE(s->bound().intersects(grid[face * 81 + k]));
        EXPECT_EQ(Bits(grid[face * 81 + k]),
                  Bits(s->evaluate(face, static_cast<float>(k % 9) / 8, static_cast<float>(k / 9) / 8).P));
      }
    }
  }
}

TEST(Nurbs, ParametersRunOverTheKnotsAndTexturesOverTheRange) {
  const SplineKnots u{5, 3, {0, 1, 2, 4, 8, 9, 9, 9}, 3, 9}, v{3, 3, {0, 0, 0, 2, 2, 2}, 0.5f, 1.5f};
  const auto s = make(primitive(NurbsPatch{u, v, nullptr}, wavyPoints(5, 3)));
  ASSERT_EQ(s->faceCount(), 3u);  // 3 to 4, 4 to 8, 8 to 9
  EXPECT_EQ(s->surfaceParameters(1, 0.25f, 0.5f), V2f(5, 1));
  EXPECT_EQ(s->surfaceParameters(2, 1, 1), V2f(9, 1.5f));
  EXPECT_EQ(s->textureParameters(0, 0, 0), V2f(0, 0));
  EXPECT_EQ(s->textureParameters(1, 0.5f, 0.5f), V2f(0.5f, 0.5f));
  EXPECT_EQ(s->textureParameters(2, 1, 1), V2f(1, 1));
  expectNear(V3f(s->parameterScale(1).x, s->parameterScale(1).y, 0), V3f(4.0f / 6, 1, 0), 1e-7f);
}

TEST(Nurbs, VariablesByClass) {
  // u: five segments, of which the third has no length; v: one, of which the second half is drawn.
  const SplineKnots u{6, 2, {0, 0, 1, 3, 3, 4, 5, 5}, 0, 5}, v{2, 2, {0, 0, 2, 2}, 1, 2};
  std::vector<float> P = wavyPoints(6, 2);
  Primitive p = primitive(NurbsPatch{u, v, nullptr}, P);
  EXPECT_EQ(valueCount(p.shape, 0, StorageClass::Uniform), 5u);
  EXPECT_EQ(valueCount(p.shape, 0, StorageClass::Varying), 12u);
  EXPECT_EQ(valueCount(p.shape, 0, StorageClass::Vertex), 12u);
  EXPECT_EQ(valueCount(p.shape, 0, StorageClass::FaceVarying), 20u);
  const auto count = [](size_t n) {
    std::vector<float> values(n);
    for (size_t k = 0; k < n; ++k) values[k] = static_cast<float>(k);
    return values;
  };
  p.variables.push_back(variable("constant", StorageClass::Constant, ValueType::Float, 1, {42}));
  p.variables.push_back(variable("uniform", StorageClass::Uniform, ValueType::Float, 1, count(5)));
  p.variables.push_back(variable("varying", StorageClass::Varying, ValueType::Float, 1, count(12)));
  p.variables.push_back(variable("corner", StorageClass::FaceVarying, ValueType::Float, 1, count(20)));
  p.variables.push_back(variable("vertex", StorageClass::Vertex, ValueType::Point, 3, P));
  const auto s = make(std::move(p));
  ASSERT_EQ(s->faceCount(), 4u);
  const auto value = [&](const char* name, uint32_t face, float x, float y) {
    V3f out(0);
    s->interpolate(*findVariable(*s.primitive, name), face, x, y, out.getValue());
    return out;
  };
  EXPECT_EQ(value("constant", 2, 0.5f, 0.5f).x, 42);
  for (uint32_t face = 0; face < 4; ++face) {
    const uint32_t segment = face < 2 ? face : face + 1;  // the empty one is left out
    EXPECT_EQ(s->uniformIndex(face), segment);
    EXPECT_EQ(value("uniform", face, 0.5f, 0.5f).x, static_cast<float>(segment));
    // Values k along u and 6 + k above; y = 0 is half-way up the segment.
    EXPECT_NEAR(value("varying", face, 0.25f, 0).x, static_cast<float>(segment) + 3.25f, 1e-5f);
    EXPECT_NEAR(value("varying", face, 0.25f, 1).x, static_cast<float>(segment) + 6.25f, 1e-5f);
    EXPECT_NEAR(value("corner", face, 0, 1).x, static_cast<float>(4 * segment + 2), 1e-5f);
    expectNear(value("vertex", face, 0.3f, 0.8f), s->evaluate(face, 0.3f, 0.8f).P, 1e-6f);
  }
}

TEST(Nurbs, VertexVariablesOfRationalPatchesGoWithThePoints) {
  Primitive p = ball();
  std::vector<float> P;
  const std::vector<float>& Pw = p.variables[0].floats;
  for (size_t k = 0; k < Pw.size(); k += 4)
    P.insert(P.end(), {Pw[k] / Pw[k + 3], Pw[k + 1] / Pw[k + 3], Pw[k + 2] / Pw[k + 3]});
  p.variables.push_back(variable("rest", StorageClass::Vertex, ValueType::Point, 3, P));
  const auto s = make(std::move(p));
  for (float x : {0.0f, 0.3f, 1.0f}) {
    V3f out(0);
    s->interpolate(*findVariable(*s.primitive, "rest"), 6, x, 0.4f, out.getValue());
    expectNear(out, s->evaluate(6, x, 0.4f).P, 1e-6f);
  }
}

TEST(Nurbs, FlatWhereItsPatchesAreParallelograms) {
  const auto patch = [](const std::vector<float>& P) {
    return make(primitive(NurbsPatch{clampedKnots(3, 2), clampedKnots(2, 2), nullptr}, P));
  };
  EXPECT_TRUE(patch({0, 0, 0, 1, 0, 0, 2, 0, 1, 0, 1, 0, 1, 1, 0, 2, 1, 1})->isFlat());
  EXPECT_FALSE(patch({0, 0, 0, 1, 0, 0, 2, 0, 1, 0, 1, 0, 1, 1, 1, 2, 1, 1})->isFlat());
  EXPECT_FALSE(make(ball())->isFlat());
}

// ---- Trim loops -------------------------------------------------------------------------------------------

TrimCurve circle(float u, float v, float r) {
  TrimCurve c;
  c.spline = kCircleKnots;
  for (const auto& [x, y, w] : kCircle)
    c.u.push_back(u * w + r * x), c.v.push_back(v * w + r * y), c.w.push_back(w);
  return c;
}
TrimCurve polyline(const std::vector<std::array<float, 2>>& points) {
  TrimCurve c;
  c.spline = clampedKnots(static_cast<int>(points.size()), 2);
  for (const auto& [u, v] : points) c.u.push_back(u), c.v.push_back(v), c.w.push_back(1);
  return c;
}

TEST(TrimRegion, CirclesWithinCirclesAreRings) {
  const std::vector<TrimLoop> loops{{circle(0.5f, 0.5f, 0.4f)}, {circle(0.5f, 0.5f, 0.2f)}};
  const TrimRegion region(loops);
  EXPECT_EQ(region.openLoops(), 0u);
  // Chords within 1e-6 of arcs: about pi * sqrt(0.4 / 2e-6) of them, up to twice as many by halving.
  EXPECT_GT(region.segmentCount(), 1000u);
  EXPECT_LT(region.segmentCount(), 20000u);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-0.1, 1.1);
  for (int k = 0; k < 100000; ++k) {
    const double u = any(random), v = any(random), r = std::hypot(u - 0.5, v - 0.5);
    if (std::abs(r - 0.4) < 2e-6 || std::abs(r - 0.2) < 2e-6) continue;
    ASSERT_EQ(region.contains(u, v), r < 0.4 && r > 0.2) << u << " " << v;
  }
}

TEST(TrimRegion, IsTheCrossingNumberOfItsPolygon) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> any(0, 1);
  for (const size_t sides : {3u, 4u, 17u, 300u}) {
    std::vector<std::array<float, 2>> points(sides);
    for (auto& p : points) p = {any(random), any(random)};
    points.push_back(points[0]);
    const std::vector<TrimLoop> loops{{polyline(points)}};
    const TrimRegion region(loops);
    EXPECT_EQ(region.segmentCount(), sides);
    for (int k = 0; k < 2000; ++k) {
      // Heights of vertices among the points: a line through a vertex counts rightly, too.
      const double u = static_cast<double>(any(random));
      const double v = k % 4 ? static_cast<double>(any(random))
                             : static_cast<double>(points[static_cast<size_t>(k) % sides][1]);
      bool odd = false;
      for (size_t i = 0; i < sides; ++i) {
        const double u0 = static_cast<double>(points[i][0]), v0 = static_cast<double>(points[i][1]),
                     u1 = static_cast<double>(points[i + 1][0]), v1 = static_cast<double>(points[i + 1][1]);
        if ((v0 <= v) != (v1 <= v) && u0 + (v - v0) / (v1 - v0) * (u1 - u0) > u) odd = !odd;
      }
      ASSERT_EQ(region.contains(u, v), odd) << u << " " << v;
    }
  }
}

TEST(TrimRegion, OpenLoopsAreClosedByALine) {
  const std::vector<TrimLoop> loops{{polyline({{0, 0}, {1, 0}}), polyline({{1, 0}, {1, 1}})}};
  const TrimRegion region(loops);
  EXPECT_EQ(region.openLoops(), 1u);
  EXPECT_TRUE(region.contains(0.6, 0.5));
  EXPECT_FALSE(region.contains(0.4, 0.5));
}

TEST(TrimRegion, CurvesThatJumpAndRangesWithinThem) {
  // Two line pieces with a jump between them, by a knot of full multiplicity: a square's lower and upper
  // side.
  TrimCurve c = polyline({{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  c.spline = {4, 2, {0, 0, 1, 1, 2, 2}, 0, 2};
  EXPECT_TRUE(TrimRegion(std::vector<TrimLoop>{{c}}).contains(0.5, 0.5));
  // Half of a circle: cut at its parameters 1 and 3, where it is vertical.
  TrimCurve half = circle(0, 0, 1);
  half.spline.min = 1, half.spline.max = 3;
  const TrimRegion region(std::vector<TrimLoop>{{half}});
  EXPECT_TRUE(region.contains(-0.5, 0.5));
  EXPECT_FALSE(region.contains(0.5, 0.5));
  EXPECT_EQ(region.openLoops(), 1u);
}

TEST(Nurbs, HolesAreWhatTheLoopsEnclose) {
  const std::vector<TrimLoop> loops{{circle(2, 1, 0.5f)}};
  NurbsPatch patch{clampedKnots(6, 3), clampedKnots(4, 3),
                   std::make_shared<const TrimRegion>(loops)};  // 4 x 2
  for (const bool keepInside : {false, true}) {
    patch.keepInside = keepInside;
    const auto s = make(primitive(patch, wavyPoints(6, 4)));
    EXPECT_TRUE(s->hasHoles());
    for (uint32_t face = 0; face < s->faceCount(); ++face)
      for (float x : {0.1f, 0.4f, 0.8f})
        for (float y : {0.05f, 0.6f, 0.7f}) {
          const V2f t = s->surfaceParameters(face, x, y);
          EXPECT_EQ(s->isHole(face, x, y), (std::hypot(t.x - 2, t.y - 1) < 0.5f) != keepInside);
        }
  }
  patch.trim = nullptr;
  EXPECT_FALSE(make(primitive(patch, wavyPoints(6, 4)))->hasHoles());
}

/// What is said of a patch that is left out.
std::string report(const Primitive& p) {
  Messages messages;
  EXPECT_EQ(makeSurface(p, messages.handler), nullptr);
  return messages.all();
}

TEST(Nurbs, HostileInput) {
  using ::testing::HasSubstr;
  const auto reportU = [&](const SplineKnots& u) {
    return report(primitive(NurbsPatch{u, clampedKnots(2, 2), nullptr}, wavyPoints(4, 2)));
  };
  EXPECT_THAT(reportU({4, 1, {0, 1, 2, 3, 4}, 0, 1}), HasSubstr("along u, order 1, expected 2 to 32"));
  EXPECT_THAT(reportU({40, 33, std::vector<float>(73), 0, 1}), HasSubstr("order 33"));
  EXPECT_THAT(reportU({2, 3, {0, 0, 0, 1, 1}, 0, 1}),
              HasSubstr("2 control points, expected at least the order, 3"));
  EXPECT_THAT(reportU({-4, 2, {}, 0, 1}), HasSubstr("-4 control points"));
  EXPECT_THAT(reportU({4, 2, {0, 0, 1, 1}, 0, 1}), HasSubstr("4 knots, expected 6"));
  EXPECT_THAT(reportU({4, 2, {0, 0, 1, 0.5f, 2, 2}, 0, 1}), HasSubstr("knot 3 (0.5) comes after 1"));
  EXPECT_THAT(reportU({4, 2, {0, 0, 1, NAN, 2, 2}, 0, 1}), HasSubstr("knot 3 is not finite"));
  EXPECT_THAT(reportU({4, 2, {0, 1, 1, 1, 2, 2}, 1, 2}), HasSubstr("the knot 1 comes more than 2 times"));
  EXPECT_THAT(reportU({4, 2, {0, 0, 1, 2, 3, 3}, 0, 4}),
              HasSubstr("the range 0 to 4 is empty or outside of 0 to 3"));
  EXPECT_THAT(reportU({4, 2, {0, 0, 1, 2, 3, 3}, 2, 2}), HasSubstr("the range 2 to 2"));
  EXPECT_THAT(reportU({4, 2, {0, 0, 1, 2, 3, 3}, NAN, 2}), HasSubstr("the range nan to 2"));
  const NurbsPatch patch{clampedKnots(4, 2), clampedKnots(2, 2), nullptr};
  EXPECT_THAT(report(primitive(patch)), HasSubstr("needs \"P\" or \"Pw\""));
  EXPECT_THAT(report(primitive(patch, wavyPoints(3, 2))), HasSubstr("4 x 2 control points are 8, not 6"));
  EXPECT_THAT(report(primitive(patch, std::vector<float>(24, 1.0f))), HasSubstr("no area"));
  std::vector<float> P = wavyPoints(4, 2);
  P[7] = kInfinity;
  EXPECT_THAT(report(primitive(patch, P)), HasSubstr("point 2 is not finite"));
  std::vector<float> Pw(32, 1.0f);
  Pw[0] = 2;
  for (const float w : {-1.0f, NAN, 1e-30f, 1e30f}) {
    Pw[15] = w;
    EXPECT_THAT(report(rational(patch, Pw)),
                HasSubstr("the weight of point 3 is not 0, or between 1e-18 and 1e+18"));
  }
}

/// Half a circle about the origin by three points, the middle one infinitely far up; and a quarter of it.
const std::vector<std::array<float, 4>> kHalfCircle = {{1, 0, 0, 1}, {0, 1, 0, 0}, {-1, 0, 0, 1}};

TEST(Nurbs, PointsAtInfinityAreDirections) {
  // Half a cylinder.
  std::vector<float> Pw;
  for (const float z : {0.0f, 2.0f})
    for (const auto& p : kHalfCircle) Pw.insert(Pw.end(), {p[0], p[1], z * p[3], p[3]});
  const auto cylinder = make(rational({clampedKnots(3, 3), clampedKnots(2, 2), nullptr}, Pw));
  // Half a ball: half a circle, turned by half a turn; both have points of weight zero.
  Pw.clear();
  for (const auto& q : kHalfCircle)
    for (const auto& p : kHalfCircle)
      Pw.insert(Pw.end(), {p[0] * q[3], p[1] * q[0], p[1] * q[1], p[3] * q[3]});
  const auto ball = make(rational({clampedKnots(3, 3), clampedKnots(3, 3), nullptr}, Pw));
  for (int j = 0; j <= 16; ++j)
    for (int i = 0; i <= 16; ++i) {
      const float u = static_cast<float>(i) / 16, v = static_cast<float>(j) / 16;
      const SurfacePoint onCylinder = cylinder->evaluate(0, u, v);
      EXPECT_NEAR(std::hypot(onCylinder.P.x, onCylinder.P.y), 1, 1e-6f);
      EXPECT_NEAR(std::abs(onCylinder.N.dot(V3f(onCylinder.P.x, onCylinder.P.y, 0))), 1, 1e-6f);
      EXPECT_NEAR(onCylinder.P.z, 2 * v, 1e-6f);
      expectDerivatives(*cylinder, 0, u, v, 6e-3f);
      const SurfacePoint onBall = ball->evaluate(0, u, v);
      EXPECT_NEAR(onBall.P.length(), 1, 1e-6f);
      EXPECT_NEAR(std::abs(onBall.N.dot(onBall.P)), 1, 2e-6f);
      for (const auto& s : {&cylinder, &ball})
        EXPECT_TRUE((*s)->bound().intersects((*s)->evaluate(0, u, v).P));
    }
  // Tight to what quarters' hulls allow.
  EXPECT_LT(cylinder->bound().max.y, 1.0001f);
  EXPECT_GT(cylinder->bound().min.y, -1e-6f);
  EXPECT_LT(ball->bound().size().length(), 4);

  // Several intervals, some with two points at infinity next to each other, and a range cut within them.
  Pw.clear();
  std::vector<float> weights = {1, 0, 0.5f, 0, 0, 2};
  for (int j = 0; j < 6; ++j)
    for (int i = 0; i < 6; ++i) {
      const auto x = static_cast<float>(i), y = static_cast<float>(j);
      Pw.insert(Pw.end(), {x, y, std::sin(2 * x + y), weights[static_cast<size_t>(i)] * (j == 2 ? 0 : 1.0f)});
    }
  const SplineKnots knots{6, 4, {0, 0, 0, 0, 1, 3, 4, 4, 4, 4}, 0, 3.5f};
  const NurbsPatch patch{knots, {6, 3, {0, 1, 2, 3, 4, 5, 6, 7, 8}, 2.5f, 6}, nullptr};
  const auto s = make(rational(patch, Pw));
  ASSERT_EQ(s->faceCount(), 12u);
  for (uint32_t face = 0; face < 12; ++face)
    for (const float x : {0.0f, 0.03f, 0.5f, 0.96875f})
      for (const float y : {0.0f, 0.7f, 0.99f}) {
        const V2f t = s->surfaceParameters(face, x, y);
        const V3f P = s->evaluate(face, x, y).P;
        expectNear(P, V3f(byDefinition(patch, Pw, 4, static_cast<double>(t.x), static_cast<double>(t.y))),
                   1e-6f * (1 + P.length()));
        EXPECT_TRUE(s->bound().intersects(P)) << P;
      }
}

TEST(Nurbs, PlacesWithoutAnyWeightAreReported) {
  using ::testing::HasSubstr;
  // A corner without a weight; a row of which all are zero, between others and at an end.
  const auto reportOf = [](std::vector<float> weights) {
    std::vector<float> Pw;
    for (size_t k = 0; k < weights.size(); ++k)
      Pw.insert(Pw.end(), {static_cast<float>(k % 4), static_cast<float>(k / 4), 1, weights[k]});
    return report(rational({clampedKnots(4, 2), clampedKnots(3, 3), nullptr}, Pw));
  };
  EXPECT_THAT(reportOf({0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1}),
              HasSubstr("infinite at u = 0, v = 0, where only weights of 0 count"));
  EXPECT_THAT(reportOf({1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0}), HasSubstr("infinite at u = 0, v = 1,"));
  EXPECT_THAT(reportOf({1, 1, 0, 1, 1, 1, 0, 1, 1, 1, 0, 1}), HasSubstr("infinite at u = "));
  EXPECT_THAT(reportOf(std::vector<float>(12, 0.0f)), HasSubstr("infinite at u = 0, v = 0,"));
}

TEST(Nurbs, ExtremesStayFinite) {
  // Weights and knots of very different size, the highest order.
  std::mt19937 random(2);
  std::uniform_real_distribution<float> exponent(-17, 17), at(-1, 1);
  for (const int order : {2, 5, 32}) {
    SplineKnots s = clampedKnots(order + 3, order);
    s.knots[static_cast<size_t>(order)] = 1e-30f;
    for (size_t k = static_cast<size_t>(order) + 3; k < s.knots.size(); ++k) s.knots[k] = 1e30f;
    s.max = 1e30f;
    std::vector<float> Pw;
    for (int k = 0; k < s.count * s.count; ++k) {
      const float w = std::pow(10.0f, exponent(random));
      Pw.insert(Pw.end(), {at(random) * w, at(random) * w, at(random) * w, w});
    }
    const auto surface = make(rational({s, s, nullptr}, Pw));
    ASSERT_TRUE(surface);
    for (uint32_t face = 0; face < surface->faceCount(); ++face)
      for (float x : {0.0f, 1e-7f, 0.5f, 1.0f}) {
        const SurfacePoint p = surface->evaluate(face, x, 1 - x);
        EXPECT_TRUE(isFinite(p.P) && isFinite(p.N) && isFinite(p.dPdu) && isFinite(p.dPdv));
        EXPECT_NEAR(p.N.length(), 1, 1e-5f);
        EXPECT_TRUE(surface->bound().intersects(p.P));
      }
  }
}

}  // namespace
}  // namespace patina
