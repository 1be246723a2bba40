// SPDX-License-Identifier: Apache-2.0
// Polygon meshes: orientation, parametrisation, variables of every class, memory, degenerate input.
#include <gmock/gmock.h>

#include "tests/unit/geometry_surface_fixtures.h"

namespace patina {
namespace {

using namespace test;

// The light of ../shared/reference/cornell.rib: its outside must be below it, as seen in the object's own
// coordinates.
TEST(PolygonSurface, NormalIsTheOutsideOfRi) {
  const Primitive light = primitive(polygons({4}, {0, 1, 2, 3}),
                                    {343, 548.3f, 227, 343, 548.3f, 332, 213, 548.3f, 332, 213, 548.3f, 227});
  const auto s = make(light);
  ASSERT_TRUE(s);
  EXPECT_EQ(s->faceCount(), 1u);
  EXPECT_EQ(s->faceShape(0), FaceShape::Quad);
  EXPECT_TRUE(s->isFlat());
  for (float u : {0.0f, 0.3f, 1.0f}) expectNear(s->evaluate(0, u, 0.9f).N, {0, -1, 0}, 0);
  // In left-handed camera space, x right, y up, z away: clockwise as seen is towards the eye.
  const auto t = make(primitive(polygons({3}, {0, 1, 2}), {0, 0, 5, 0, 1, 5, 1, 1, 5}));
  expectNear(t->evaluate(0, 0.2f, 0.2f).N, {0, 0, -1}, 0);
}

TEST(PolygonSurface, QuadIsTwoTriangles) {
  const Primitive p = primitive(polygons({4}, {0, 1, 2, 3}), {0, 0, 0, 4, 0, 0, 3, 2, 1, 0, 2, 0});
  const auto s = make(p);
  V3f c[4];
  s->corners(0, c);
  expectNear(c[0], {0, 0, 0}, 0);
  expectNear(c[1], {4, 0, 0}, 0);
  expectNear(c[2], {0, 2, 0}, 0);
  expectNear(c[3], {3, 2, 1}, 0);
  expectNear(s->evaluate(0, 0.25f, 0.5f).P, {1, 1, 0}, 0);
  expectNear(s->evaluate(0, 0.5f, 0.5f).P, {2, 1, 0}, 0);  // the diagonal
  // In the other triangle: c3 + (1-u)(c2-c3) + (1-v)(c1-c3).
  expectNear(s->evaluate(0, 0.75f, 0.5f).P, V3f(3, 2, 1) + V3f(-3, 0, -1) * 0.25f + V3f(1, -2, -1) * 0.5f,
             1e-6f);
  expectDerivatives(*s, 0, 0.2f, 0.3f, 1e-3f);
  expectDerivatives(*s, 0, 0.7f, 0.8f, 1e-3f);
}

TEST(PolygonSurface, ConcaveQuadIsCutAtItsReflexCorner) {
  for (int reflex = 0; reflex < 4; ++reflex) {
    const float arrow[4][2] = {{0, 0}, {4, 4}, {0, 1}, {-4, 4}};  // corner 2 is reflex
    std::vector<float> P;
    for (int k = 0; k < 4; ++k) {
      const int from = (k - reflex + 2 + 4) % 4;
      P.insert(P.end(), {arrow[from][0], arrow[from][1], 0});
    }
    const Primitive p = primitive(polygons({4}, {0, 1, 2, 3}), P);
    const auto s = make(p);
    ASSERT_EQ(s->faceCount(), 1u) << reflex;
    ASSERT_EQ(s->faceShape(0), FaceShape::Quad);
    V3f c[4];
    s->corners(0, c);
    const float first = (c[1] - c[0]).cross(c[2] - c[0]).z, second = (c[2] - c[3]).cross(c[1] - c[3]).z;
    EXPECT_GT(first, 0);
    EXPECT_GT(second, 0);
    EXPECT_FLOAT_EQ(first + second, 8);  // twice the area by the shoelace formula
  }
}

TEST(PolygonSurface, VariablesByClass) {
  // Two triangles and an L-shaped hexagon.
  Primitive p = primitive(polygons({3, 6, 3}, {0, 1, 2, 3, 4, 5, 6, 7, 8, 2, 1, 0}),
                          {0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 0, 0, 7, 0, 0, 7, 1, 0, 6, 1, 0, 6, 2, 0, 5, 2, 0});
  std::vector<float> perVertex, perCorner;
  for (int i = 0; i < 9; ++i)
    perVertex.push_back(p.variables[0].floats[3 * static_cast<size_t>(i)] * 10);  // 10 x: linear
  for (int i = 0; i < 12; ++i) perCorner.push_back(static_cast<float>(i));
  p.variables.push_back(variable("constant", StorageClass::Constant, ValueType::Float, 1, {42}));
  p.variables.push_back(variable("uniform", StorageClass::Uniform, ValueType::Float, 1, {100, 101, 102}));
  p.variables.push_back(variable("varying", StorageClass::Varying, ValueType::Float, 1, perVertex));
  p.variables.push_back(variable("vertex", StorageClass::Vertex, ValueType::Float, 1, perVertex));
  p.variables.push_back(variable("corner", StorageClass::FaceVarying, ValueType::Float, 1, perCorner));
  p.variables.push_back(variable("short", StorageClass::FaceVertex, ValueType::Float, 1, {3}));
  const auto s = make(p);
  ASSERT_EQ(s->faceCount(), 6u);  // 1 + 4 + 1
  const auto value = [&](const char* name, uint32_t face, float u, float v) {
    float out = -1;
    s->interpolate(*findVariable(p, name), face, u, v, &out);
    return out;
  };
  for (uint32_t face = 0; face < 6; ++face) {
    const uint32_t polygon = face == 0 ? 0 : face < 5 ? 1 : 2;
    EXPECT_EQ(s->uniformIndex(face), polygon);
    EXPECT_EQ(value("constant", face, 0.1f, 0.2f), 42);
    EXPECT_EQ(value("uniform", face, 0.1f, 0.2f), 100 + static_cast<float>(polygon));
    const float x = s->evaluate(face, 0.3f, 0.5f).P.x;
    EXPECT_NEAR(value("varying", face, 0.3f, 0.5f), 10 * x, 1e-5f);
    EXPECT_NEAR(value("vertex", face, 0.3f, 0.5f), 10 * x, 1e-5f);
    EXPECT_EQ(s->surfaceParameters(face, 0.3f, 0.5f).x, x);
  }
  EXPECT_EQ(value("corner", 0, 1, 0), 1);
  EXPECT_EQ(value("corner", 5, 0, 0), 9);
  EXPECT_EQ(value("corner", 5, 0, 1), 11);
  EXPECT_EQ(value("short", 5, 0, 1), 0);  // beyond the data
  EXPECT_EQ(valueCount(p.shape, 9, StorageClass::Uniform), 3u);
  EXPECT_EQ(valueCount(p.shape, 9, StorageClass::FaceVarying), 12u);
  EXPECT_EQ(valueCount(p.shape, 9, StorageClass::Varying), 9u);
}

TEST(PolygonSurface, HolesAreCutOut) {
  Primitive p = primitive(PolygonMesh{{2}, {4, 4}, {0, 1, 2, 3, 4, 5, 6, 7}},
                          {0, 0, 1, 3, 0, 1, 3, 3, 1, 0, 3, 1, 1, 1, 1, 1, 2, 1, 2, 2, 1, 2, 1, 1});
  const auto s = make(p);
  ASSERT_EQ(s->faceCount(), 8u);
  double area = 0;
  for (uint32_t face = 0; face < 8; ++face) {
    const SurfacePoint q = s->evaluate(face, 0.25f, 0.25f);
    area += static_cast<double>(q.dPdu.cross(q.dPdv).length()) / 2;
    expectNear(q.N, {0, 0, 1}, 0);
  }
  EXPECT_NEAR(area, 8, 1e-6);
}

// Neighbours see an edge from opposite ends; whatever its direction and parameters, they must place the same
// points.
TEST(PolygonSurface, EdgesAreBitIdentical) {
  std::vector<float> P;
  uint32_t state = 1;
  for (int i = 0; i < 12; ++i) {
    state = state * 1664525u + 1013904223u;
    P.push_back(static_cast<float>(state >> 8) * 1e-5f - 80.0f);
  }
  const auto s = make(primitive(polygons({3, 3}, {0, 1, 2, 2, 1, 3}), P));
  for (int k = 0; k <= 4096; ++k) {
    const float t = static_cast<float>(k) / 4096;
    EXPECT_EQ(Bits(s->evaluate(0, 1 - t, t).P), Bits(s->evaluate(1, 1 - t, 0).P));
  }
}

TEST(PolygonSurface, PlainMeshesKeepNoFaces) {
  std::vector<float> P;
  std::vector<int> vertices;
  for (int j = 0; j <= 100; ++j)
    for (int i = 0; i <= 100; ++i) P.insert(P.end(), {static_cast<float>(i), static_cast<float>(j), 0});
  for (int j = 0; j < 100; ++j)
    for (int i = 0; i < 100; ++i) {
      const int v = j * 101 + i;
      vertices.insert(vertices.end(), {v, v + 1, v + 102, v + 101});
    }
  const auto quads = make(primitive(polygons(std::vector<int>(10000, 4), vertices), P));
  EXPECT_EQ(quads->faceCount(), 10000u);
  EXPECT_LT(quads->memory(), 1000u);
  // One pentagon among them: 16 bytes for each face.
  std::vector<int> sizes(10001, 4);
  sizes[10000] = 5;
  vertices.insert(vertices.end(), {0, 1, 2, 103, 101});
  const auto mixed = make(primitive(polygons(sizes, vertices), P));
  EXPECT_EQ(mixed->faceCount(), 10003u);
  EXPECT_LT(mixed->memory(), 10003u * 18 + 1000);
}

TEST(PolygonSurface, TrianglesWithoutAreaCostNoMoreThanANumberPerFace) {
  std::vector<float> P;
  std::vector<int> vertices;
  for (int k = 0; k <= 10000; ++k) P.insert(P.end(), {static_cast<float>(k), static_cast<float>(k % 2), 0});
  for (int k = 0; k < 9999; ++k) vertices.insert(vertices.end(), {k, k + (k == 77 ? 0 : 1), k + 2});
  PolygonMesh mesh{{}, {}, vertices, 3};
  EXPECT_EQ(mesh.faceCount(), 9999u);
  Messages messages;
  Primitive p = primitive(mesh, P);
  PrimVar number;
  number.name = "number";
  for (int k = 0; k < 9999; ++k) number.floats.push_back(static_cast<float>(k));
  p.variables.push_back(number);
  const auto s = makeSurface(p, messages.handler);
  EXPECT_THAT(messages.all(), ::testing::HasSubstr("1 of 9999 polygons have no area (first: number 77)"));
  ASSERT_EQ(s->faceCount(), 9998u);
  EXPECT_LT(s->memory(), 9998u * 5);
  for (const uint32_t face : {0u, 76u, 77u, 5000u}) {
    const uint32_t polygon = face + (face >= 77);
    EXPECT_EQ(s->uniformIndex(face), polygon);
    float value;
    s->interpolate(p.variables.back(), face, 0.3f, 0.3f, &value);
    EXPECT_EQ(value, static_cast<float>(polygon));
    V3f corner[4];
    s->corners(face, corner);
    EXPECT_EQ(corner[2].x, static_cast<float>(polygon + 2));
  }
}

TEST(PolygonSurface, DegenerateInputIsReported) {
  const std::vector<float> square{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
  const auto report = [&](const PolygonMesh& mesh, std::vector<float> P, uint32_t faces) {
    Messages messages;
    const Primitive p = primitive(mesh, std::move(P));
    const auto s = makeSurface(p, messages.handler);
    EXPECT_EQ(s ? s->faceCount() : 0, faces);
    return messages.all();
  };
  using ::testing::HasSubstr;
  EXPECT_THAT(report(polygons({4, 3}, {0, 1, 2, 3, 0, 1, 9}), square, 1),
              HasSubstr("test.rib:7:3: error: range: 1 of 2 polygons use a vertex that \"P\" does not have "
                        "(first: number 1); left out"));
  EXPECT_THAT(report(polygons({4, 2}, {0, 1, 2, 3, 0, 1}), square, 1),
              HasSubstr("1 of 2 polygons have fewer than 3 vertices"));
  EXPECT_THAT(report(polygons({4, 3}, {0, 1, 2, 3, 0, 1, 1}), square, 1),
              HasSubstr("1 of 2 polygons have no area"));
  EXPECT_THAT(report(polygons({3, 3}, {0, 1, 2, 0, 1, -1}), square, 1), HasSubstr("use a vertex"));
  EXPECT_THAT(report(polygons({3}, {0, 1, 2}), {0, 0, 0, 1, 0, 0, NAN, 1, 0}, 0),
              HasSubstr("have a point that is not finite"));
  EXPECT_THAT(report(polygons({3}, {0, 1, 2}), {0, 0, 0, 1, 0, 0, 1e30f, 1, 0}, 0),
              HasSubstr("no polygon with an area is left"));
  EXPECT_THAT(report(polygons({4}, {0, 2, 1, 3}), square, 1), HasSubstr("cross themselves"));
  EXPECT_THAT(report(polygons({5}, {0, 1, 2, 3}), square, 0), HasSubstr("do not add up"));
  EXPECT_THAT(report(polygons({-4, 8}, {0, 1, 2, 3}), square, 0), HasSubstr("do not add up"));
  EXPECT_THAT(report(PolygonMesh{{0, 1}, {4}, {0, 1, 2, 3}}, square, 1),
              HasSubstr("fewer than 3 vertices (first: number 0)"));
  EXPECT_THAT(report(polygons({3}, {0, 1, 2}), {}, 0), HasSubstr("need \"P\""));
  EXPECT_THAT(report(polygons({}, {}), square, 0), HasSubstr("no polygon"));
  EXPECT_EQ(report(polygons({4}, {0, 1, 2, 2}), square, 1), "");  // a triangle written as a quad is no error
}

}  // namespace
}  // namespace patina
