// SPDX-License-Identifier: Apache-2.0
// Points: balls around them, closed, of even faces, with their values.
#include "geometry_surface_fixtures.h"

#include <gmock/gmock.h>

#include "renderer/geometry/points_surface.h"

namespace patina::test {
namespace {

using testing::HasSubstr;

Primitive pointSet(std::vector<float> P) {
  const size_t count = P.size() / 3;
  return primitive(PointSet{count}, std::move(P));
}
PrimVar widths(StorageClass storage, std::vector<float> values) {
  return variable(storage == StorageClass::Constant ? "constantwidth" : "width", storage, ValueType::Float, 1,
                  std::move(values));
}

TEST(Points, AreBallsOfTheirWidths) {
  Primitive p = pointSet({1, 2, 3, -4, 0, 5});
  p.variables.push_back(widths(StorageClass::Varying, {0.5f, 3}));
  const auto s = make(std::move(p));
  ASSERT_EQ(s->faceCount(), 12u);
  const V3d centers[2] = {{1, 2, 3}, {-4, 0, 5}};
  const double radii[2] = {0.25, 1.5};
  for (uint32_t face = 0; face < 12; ++face)
    for (int k = 0; k < 25; ++k) {
      const float u = static_cast<float>(k % 5) / 4, v = static_cast<float>(k / 5) / 4;
      const SurfacePoint at = s->evaluate(face, u, v);
      const V3d r = V3d(at.P) - centers[face / 6];
      EXPECT_NEAR(r.length(), radii[face / 6], 1e-6);
      EXPECT_GT(V3d(at.N).dot(r) / r.length(), 1 - 1e-6);  // outwards
      expectDerivatives(*s, face, u, v, 2e-3f);
    }
  expectNear(s->bound().min, V3f(-5.5f, -1.5f, 2.75f), 1e-6f);
  expectNear(s->bound().max, V3f(1.25f, 2.25f, 6.5f), 1e-6f);
}

TEST(Points, OneUnitWideWithoutAWidth) {
  const auto s = make(pointSet({0, 0, 0}));
  expectNear(s->evaluate(0, 0.5f, 0.5f).P, V3f(0.5f, 0, 0), 0);
  V3f c[4];
  s->corners(0, c);
  const float third = 0.5f / std::sqrt(3.0f);
  expectNear(c[0], V3f(third, -third, -third), 1e-7f);
  expectNear(c[3], V3f(third, third, third), 1e-7f);
  Primitive wide = pointSet({0, 0, 0});
  wide.variables.push_back(widths(StorageClass::Constant, {4}));
  expectNear(make(std::move(wide))->evaluate(3, 0.5f, 0.5f).P, V3f(0, -2, 0), 0);
}

TEST(Points, AreClosed) {
  Primitive p = pointSet({1.1f, 2.3f, -0.7f, 1000.1f, 3, 5});
  p.variables.push_back(widths(StorageClass::Vertex, {0.3f, 0.7f}));
  const auto s = make(std::move(p));
  for (const uint32_t cells : {1u, 2u, 8u, 16u}) EXPECT_EQ(openEdges(*s, cells), 0u) << cells;
  // 4/3 pi r^3 of radius 1/2, from inside: what is missing falls with the square of the cells.
  const auto ball = make(pointSet({0, 0, 0}));
  EXPECT_NEAR(volume(*ball, 32), std::numbers::pi / 6, 1e-3);
  EXPECT_NEAR(volume(*ball, 64), std::numbers::pi / 6, 3e-4);
}

TEST(Points, TessellateAsTheyEvaluate) {
  const auto s = make(pointSet({0.1f, 0.2f, 0.3f, 7, 8, 9}));
  constexpr uint32_t kCells = 4;
  const std::vector<V3f> grid = tessellated(*s, kCells);
  for (uint32_t face = 0; face < s->faceCount(); ++face)
    for (uint32_t k = 0; k < 25; ++k)
      EXPECT_EQ(grid[face * 25 + k],
                s->evaluate(face, static_cast<float>(k % 5) / 4, static_cast<float>(k / 5) / 4).P);
}

TEST(Points, FacesAreEven) {
  // |dPdu x dPdv| of the equiangular cube is (1 + x^2)(1 + y^2) / (1 + x^2 + y^2)^(3/2): 1 in the middle,
  // 1/sqrt(2) in the middle of an edge, 4 / 3^(3/2) in a corner.
  const auto s = make(pointSet({0, 0, 0}));
  const auto area = [&](float u, float v) {
    const SurfacePoint p = s->evaluate(2, u, v);
    return p.dPdu.cross(p.dPdv).length();
  };
  const float middle = area(0.5f, 0.5f);
  EXPECT_NEAR(middle, std::numbers::pi * std::numbers::pi / 16, 1e-6);
  EXPECT_NEAR(area(1, 0.5f) / middle, std::sqrt(0.5), 1e-6);
  EXPECT_NEAR(area(0, 1) / middle, 4 / std::pow(3, 1.5), 1e-6);
}

TEST(Points, ValuesBelongToPoints) {
  Primitive p = pointSet({0, 0, 0, 3, 0, 0});
  p.variables.push_back(variable("a", StorageClass::Varying, ValueType::Color, 3, {1, 2, 3, 4, 5, 6}));
  p.variables.push_back(variable("b", StorageClass::Vertex, ValueType::Float, 1, {7, 8}));
  p.variables.push_back(variable("c", StorageClass::Uniform, ValueType::Float, 1, {9}));
  p.variables.push_back(variable("d", StorageClass::Constant, ValueType::Float, 1, {10}));
  const auto s = make(std::move(p));
  const auto at = [&](size_t which, uint32_t face) {
    float out[3] = {};
    s->interpolate(s.primitive->variables[which], face, 0.3f, 0.9f, out);
    return out[0];
  };
  EXPECT_EQ(at(1, 5), 1);
  EXPECT_EQ(at(1, 6), 4);
  EXPECT_EQ(at(2, 11), 8);
  EXPECT_EQ(at(3, 11), 9);
  EXPECT_EQ(at(4, 11), 10);
  EXPECT_EQ(s->uniformIndex(11), 0u);
  EXPECT_EQ(s->surfaceParameters(7, 0.2f, 0.3f), V2f(0, 0));
}

TEST(Points, WithoutAWidthAreLeftOut) {
  Primitive p = pointSet({0, 0, 0, 3, 0, 0, 6, 0, 0, 9, 0, 0});
  p.variables.push_back(widths(StorageClass::Varying, {1, 0, 2, -1}));
  p.variables.push_back(variable("a", StorageClass::Varying, ValueType::Float, 1, {1, 2, 3, 4}));
  Messages messages;
  const auto s = makeSurface(p, messages.handler);
  ASSERT_TRUE(s);
  EXPECT_TRUE(messages.mention("2 of 4 have a width that is not more than 0")) << messages.all();
  ASSERT_EQ(s->faceCount(), 12u);
  expectNear(s->evaluate(6, 0.5f, 0.5f).P, V3f(7, 0, 0), 1e-6f);
  float value = 0;
  s->interpolate(p.variables[2], 6, 0, 0, &value);
  EXPECT_EQ(value, 3);
}

TEST(Points, BadInputIsRefused) {
  const auto report = [](Primitive p) {
    Messages messages;
    EXPECT_FALSE(makeSurface(p, messages.handler));
    return messages.all();
  };
  EXPECT_THAT(report(primitive(PointSet{1})),
              HasSubstr("error: missingdata: Points are left out: they need"));
  EXPECT_THAT(report(primitive(PointSet{3}, {0, 0, 0})), HasSubstr("\"P\" has 1 points, expected 3"));
  EXPECT_THAT(report(pointSet({0, kInfinity, 0})),
              HasSubstr("range: Points are left out: point 0 is not finite"));
  for (const float width : {0.0f, -1.0f, kInfinity, std::numeric_limits<float>::quiet_NaN()}) {
    Primitive p = pointSet({0, 0, 0, 1, 1, 1});
    p.variables.push_back(widths(StorageClass::Constant, {width}));
    EXPECT_THAT(report(std::move(p)), HasSubstr("range: Points are left out: their width is"));
    p = pointSet({0, 0, 0, 1, 1, 1});
    p.variables.push_back(widths(StorageClass::Varying, {width, width}));
    EXPECT_THAT(report(std::move(p)), HasSubstr("range: Points are left out: "));
  }
}

}  // namespace
}  // namespace patina::test
