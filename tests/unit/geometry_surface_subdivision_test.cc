// SPDX-License-Identifier: Apache-2.0
// Subdivision surfaces: against closed forms, against uniform refinement by OpenSubdiv's Far (another
// implementation), seams, variables, tags.
#include <gmock/gmock.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <set>
#include <thread>

#include "tests/unit/geometry_subdivision_fixtures.h"

namespace patina {
namespace {

using namespace test;
namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

// neighbours) / (n (n + 5)) (Halstead, Kass, DeRose 1993). On the cube: (9 v + 4 * 3 edges + 3 faces) / 24.
TEST(SubdivisionSurface, CubeCornersAreTheClosedForm) {
  const auto s = make(primitive(cube(), kCubePoints));
  ASSERT_EQ(s->faceCount(), 6u);
  const float expected =
      (9.0f + 4 * 1 - 1) / 24;  // edge neighbours sum to (1,1,1), face neighbours to (-1,-1,-1)
  for (uint32_t face = 0; face < 6; ++face) {
    V3f c[4];
    s->corners(face, c);
    for (const V3f& p : c) EXPECT_NEAR(maxAbsComponent(p), expected, 1e-6f);
    for (const V3f& p : c) EXPECT_NEAR(p.length(), expected * std::sqrt(3.0f), 1e-6f);
    for (float u : {0.0f, 0.25f, 1.0f})
      for (float v : {0.0f, 0.6f, 1.0f}) {
        const SurfacePoint p = s->evaluate(face, u, v);
        EXPECT_GT(p.N.dot(p.P), 0);
        EXPECT_TRUE(s->bound().intersects(p.P));
      }
    for (float u : {0.1f, 0.5f, 0.8f}) expectDerivatives(*s, face, u, 0.3f, 2e-2f);
  }
  // The middle of a face lies on its axis; the normal follows by symmetry.
  expectNear(s->evaluate(1, 0.5f, 0.5f).N, {0, 0, 1}, 1e-6f);
  expectNear(s->evaluate(1, 1, 1).N, V3f(1, 1, 1).normalized(), 1e-4f);
}

TEST(SubdivisionSurface, FirstVertexIsTheOriginAndUGoesToTheSecond) {
  const auto s = make(primitive(cube(), kCubePoints));
  for (uint32_t face = 0; face < 6; ++face) {
    V3f c[4];
    s->corners(face, c);
    const size_t order[4] = {0, 1, 3, 2};
    for (size_t k = 0; k < 4; ++k) {
      const auto v = static_cast<size_t>(kCubeFaces[4 * face + order[k]]);
      expectNear(c[k], V3f(kCubePoints[3 * v], kCubePoints[3 * v + 1], kCubePoints[3 * v + 2]) * 0.5f, 1e-6f);
    }
  }
  // Parts of an n-gon: each begins at its own vertex, all end at the middle.
  const Primitive five = prism(5, {{"interpolateboundary", {1}, {}, {}}});
  const auto p = make(five);
  ASSERT_EQ(p->faceCount(), 15u);
  for (uint32_t k = 0; k < 5; ++k) {
    V3f c[4], next[4];
    p->corners(k, c);
    p->corners((k + 1) % 5, next);
    expectNear(c[1], next[2], 1e-6f);
    expectNear(c[3], next[3], 1e-6f);
    EXPECT_EQ(p->uniformIndex(k), 0u);
    expectDerivatives(*p, k, 0.4f, 0.3f, 2e-2f);
    expectDerivatives(*p, k, 0.9f, 0.95f, 2e-2f);
  }
}

/// Limit positions of all base vertices and face middles after `levels` uniform refinements by Far.
struct FarPoint {
  V3d p{0};
  void Clear() { p = V3d(0); }
  void AddWithWeight(const FarPoint& q, float w) { p += q.p * static_cast<double>(w); }
};
std::set<std::tuple<int, int, int>> farLimit(const SubdivisionMesh& mesh, const std::vector<float>& P,
                                             Sdc::Options options, const std::vector<int>& pairs = {},
                                             const std::vector<float>& weights = {}, int levels = 4,
                                             Sdc::SchemeType scheme = Sdc::SCHEME_CATMARK,
                                             std::vector<V3d>* positions = nullptr,
                                             const std::vector<int>& corners = {},
                                             const std::vector<float>& cornerWeights = {}) {
  Far::TopologyDescriptor d;
  d.numVertices = static_cast<int>(P.size() / 3);
  d.numFaces = static_cast<int>(mesh.vertsPerFace.size());
  d.numVertsPerFace = mesh.vertsPerFace.data();
  d.vertIndicesPerFace = mesh.vertices.data();
  d.numCreases = static_cast<int>(weights.size());
  d.creaseVertexIndexPairs = pairs.data();
  d.creaseWeights = weights.data();
  d.numCorners = static_cast<int>(corners.size());
  d.cornerVertexIndices = corners.data();
  d.cornerWeights = cornerWeights.data();
  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  std::unique_ptr<Far::TopologyRefiner> refiner(Factory::Create(d, Factory::Options(scheme, options)));
  Far::TopologyRefiner::UniformOptions uniform(levels);
  uniform.fullTopologyInLastLevel = true;
  refiner->RefineUniform(uniform);
  Far::PrimvarRefiner primvars(*refiner);
  std::vector<FarPoint> points(P.size() / 3);
  for (size_t i = 0; i < points.size(); ++i) points[i].p = V3d(V3f(P[3 * i], P[3 * i + 1], P[3 * i + 2]));
  for (int level = 1; level <= levels; ++level) {
    std::vector<FarPoint> next(static_cast<size_t>(refiner->GetLevel(level).GetNumVertices()));
    primvars.Interpolate(level, points, next);
    points = std::move(next);
  }
  std::vector<FarPoint> limit(points.size());
  primvars.Limit(points, limit);
  std::set<std::tuple<int, int, int>> out;
  for (const FarPoint& q : limit) {
    out.insert({static_cast<int>(std::lround(q.p.x * 1e3)), static_cast<int>(std::lround(q.p.y * 1e3)),
                static_cast<int>(std::lround(q.p.z * 1e3))});
    if (positions) positions->push_back(q.p);
  }
  return out;
}

/// Every Far limit point of `levels` refinements must be a point of our grids of 2^levels cells, and the
/// other way round.
void expectSamePoints(const Surface& s, const std::vector<V3d>& far, uint32_t cells, float tolerance) {
  const size_t side = cells + 1;
  std::vector<V3f> ours;
  for (uint32_t face = 0; face < s.faceCount(); ++face)
    for (size_t j = 0; j < side; ++j)
      for (size_t i = 0; i < side; ++i)
        ours.push_back(s.evaluate(face, static_cast<float>(i) / static_cast<float>(cells),
                                  static_cast<float>(j) / static_cast<float>(cells))
                           .P);
  const auto nearest = [](const auto& p, const auto& cloud) {
    double best = 1e30;
    for (const auto& q : cloud) best = std::min(best, (V3d(q) - V3d(p)).length());
    return best;
  };
  double worst = 0;
  for (const V3f& p : ours) worst = std::max(worst, nearest(p, far));
  for (const V3d& p : far) worst = std::max(worst, nearest(p, ours));
  EXPECT_LT(worst, static_cast<double>(tolerance));
}

Sdc::Options boundary(Sdc::Options::VtxBoundaryInterpolation rule) {
  Sdc::Options options;
  options.SetVtxBoundaryInterpolation(rule);
  return options;
}

TEST(SubdivisionSurface, AgreesWithUniformRefinement) {
  std::vector<V3d> far;
  farLimit(cube(), kCubePoints, {}, {}, {}, 3, Sdc::SCHEME_CATMARK, &far);
  expectSamePoints(*make(primitive(cube(), kCubePoints)), far, 8, 2e-4f);

  for (int rule : {1, 2}) {
    const auto s = make(sheet(4, 4, {{"interpolateboundary", {rule}, {}, {}}}));
    far.clear();
    farLimit(std::get<SubdivisionMesh>(s.primitive->shape), s.primitive->variables[0].floats,
             boundary(rule == 1 ? Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER
                                : Sdc::Options::VTX_BOUNDARY_EDGE_ONLY),
             {}, {}, 3, Sdc::SCHEME_CATMARK, &far);
    expectSamePoints(*s, far, 8, 1e-5f);
  }
  const auto s = make(prism(5));
  far.clear();
  farLimit(std::get<SubdivisionMesh>(s.primitive->shape), s.primitive->variables[0].floats, {}, {}, {}, 3,
           Sdc::SCHEME_CATMARK, &far);
  // The quads have 8 cells and the parts of the pentagons 4 at the third refinement: compare the corners of
  // all.
  for (uint32_t face = 0; face < s->faceCount(); ++face) {
    V3f c[4];
    s->corners(face, c);
    for (const V3f& p : c) {
      double best = 1;
      for (const V3d& q : far) best = std::min(best, (q - V3d(p)).length());
      EXPECT_LT(best, 2e-4) << face;
    }
  }
}

TEST(SubdivisionSurface, Creases) {
  // An infinitely sharp ring around the top of the cube, and a semi-sharp one of 2.5.
  for (float sharpness : {10.0f, 2.0f, 0.5f}) {
    const std::vector<int> ring{4, 5, 7, 6, 4};
    const auto s = make(primitive(cube({{"crease", ring, {sharpness}, {}}}), kCubePoints));
    std::vector<int> pairs;
    for (size_t i = 0; i + 1 < ring.size(); ++i) pairs.insert(pairs.end(), {ring[i], ring[i + 1]});
    std::vector<V3d> far;
    farLimit(cube(), kCubePoints, {}, pairs, std::vector<float>(4, sharpness), 4, Sdc::SCHEME_CATMARK, &far);
    expectSamePoints(*s, far, 16, 1e-3f);
    if (sharpness == 10) {
      // A closed ring of infinite sharpness is a cubic B-spline: at its points (1 + 4 + 1) / 6.
      EXPECT_NEAR(s->evaluate(1, 0, 0).P.x, -(4.0f + 1 - 1) / 6, 1e-5f);
      EXPECT_NEAR(s->evaluate(1, 0, 0).P.z, 1, 1e-5f);
      EXPECT_EQ(openEdges(*s, 8), 0u);
    }
  }
}

TEST(SubdivisionSurface, CornersStayWhereTheyAre) {
  const auto s = make(primitive(cube({{"corner", {7}, {10}, {}}}), kCubePoints));
  expectNear(s->evaluate(1, 1, 1).P, {1, 1, 1}, 1e-5f);
  const auto square = make(sheet(2, 2, {{"interpolateboundary", {1}, {}, {}}}));
  V3f c[4];
  square->corners(0, c);
  for (int k = 0; k < 4; ++k) {
    const size_t v = static_cast<size_t>(k);
    expectNear(
        c[k],
        V3f(square.primitive->variables[0].floats[3 * v], square.primitive->variables[0].floats[3 * v + 1],
            square.primitive->variables[0].floats[3 * v + 2]),
        1e-6f);
  }
}

TEST(SubdivisionSurface, HolesAndBoundaryFacesAreLeftOut) {
  const auto s = make(primitive(cube({{"hole", {1}, {}, {}}}), kCubePoints));
  EXPECT_EQ(s->faceCount(), 5u);
  EXPECT_EQ(s->uniformIndex(1), 2u);
  EXPECT_EQ(openEdges(*s, 4), 16u);                   // the rim of the hole
  EXPECT_EQ(make(sheet(5, 4, {}))->faceCount(), 2u);  // the inner 2 x 1 of 4 x 3
  EXPECT_EQ(make(sheet(5, 4, {{"interpolateboundary", {}, {}, {}}}))->faceCount(), 12u);
}

TEST(SubdivisionSurface, ClosedMeshesAreWatertight) {
  for (uint32_t cells : {1u, 2u, 4u, 16u}) {
    EXPECT_EQ(openEdges(*make(primitive(cube(), kCubePoints)), cells), 0u) << cells;
    for (int n : {3, 5, 7}) EXPECT_EQ(openEdges(*make(prism(n)), cells), 0u) << n << " " << cells;
    EXPECT_EQ(openEdges(*make(primitive(
                            SubdivisionMesh{"loop", {3, 3, 3, 3}, {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2}, {}},
                            {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1})),
                        cells),
              0u)
        << cells;
    SubdivisionMesh bilinear = cube();
    bilinear.scheme = "bilinear";
    EXPECT_EQ(openEdges(*make(primitive(bilinear, kCubePoints)), cells), 0u) << cells;
  }
  EXPECT_GT(volume(*make(primitive(cube(), kCubePoints)), 16), 0);
}

TEST(SubdivisionSurface, TessellationIsTheLimit) {
  for (const Made& s : {make(prism(5)), make(sheet(6, 6, {{"interpolateboundary", {1}, {}, {}}}))}) {
    const Facets facets = uniformFacets(*s, 8);
    for (uint32_t face = 0; face < s->faceCount(); ++face) {
      const uint32_t nu = facets.rates.tiles[face].cellsU(), nv = facets.rates.tiles[face].cellsV();
      for (uint32_t j = 1; j < nv; ++j)
        for (uint32_t i = 1; i < nu; ++i)
          expectNear(facets.vertices[facets.first[face] + j * (nu + 1) + i],
                     s->evaluate(face, static_cast<float>(i) / static_cast<float>(nu),
                                 static_cast<float>(j) / static_cast<float>(nv))
                         .P,
                     5e-7f);
    }
  }
}

TEST(SubdivisionSurface, Loop) {
  // Octahedron: valence 4. Limit = (v + chi sum) / (1 + n chi), beta = (5/8 - (3/8 + cos(2 pi / n) / 4)^2) /
  // n, chi = 1 / (3/(8 beta) + n).
  const std::vector<float> P{1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1};
  const std::vector<int> v{0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
  const auto s = make(primitive(SubdivisionMesh{"loop", std::vector<int>(8, 3), v, {}}, P));
  ASSERT_EQ(s->faceCount(), 24u);
  const double beta = (5.0 / 8 - std::pow(3.0 / 8, 2)) / 4, chi = 1 / (3 / (8 * beta) + 4);
  const double limit = 1 - 4 * chi;  // the neighbours sum to zero
  EXPECT_NEAR(s->evaluate(0, 0, 0).P.x, limit, 1e-5);
  expectNear(s->evaluate(0, 0, 0).N, {1, 0, 0}, 1e-4f);
  for (uint32_t face = 0; face < 24; ++face) {
    EXPECT_EQ(s->uniformIndex(face), face / 3);
    expectDerivatives(*s, face, 0.3f, 0.6f, 2e-2f);
    expectNear(s->evaluate(face, 1, 1).P, s->evaluate(face / 3 * 3, 1, 1).P, 1e-6f);
  }
}

TEST(SubdivisionSurface, SemiSharpCornersAgreeWithUniformRefinement) {
  for (float sharpness : {0.5f, 1.0f, 2.0f}) {
    std::vector<V3d> far;
    farLimit(cube(), kCubePoints, {}, {}, {}, 4, Sdc::SCHEME_CATMARK, &far, {7, 0}, {sharpness, 10});
    const auto s = make(primitive(cube({{"corner", {7, 0}, {sharpness, 10}, {}}}), kCubePoints));
    expectSamePoints(*s, far, 16, 1e-3f);
  }
}

// Parts of a triangle meet Far's points at its vertices and the middles of its edges. Inner vertices of the
// sheet are regular, so that the limit is exact; the tolerance is float's.
TEST(SubdivisionSurface, LoopWithBoundariesCreasesCornersAndHoles) {
  for (int rule : {1, 2})
    for (float sharpness : {0.0f, 1.5f, 10.0f}) {
      std::vector<SubdivisionMesh::Tag> tags{{"interpolateboundary", {rule}, {}, {}}, {"hole", {5}, {}, {}}};
      std::vector<int> pairs;
      if (sharpness > 0) tags.push_back({"crease", {5, 6, 7}, {sharpness}, {}}), pairs = {5, 6, 6, 7};
      Primitive p = sheet(4, 4, tags);
      auto& mesh = std::get<SubdivisionMesh>(p.shape);
      mesh.scheme = "loop";
      std::vector<int> triangles;
      for (size_t f = 0; f < 9; ++f) {
        const int* q = &mesh.vertices[4 * f];
        triangles.insert(triangles.end(), {q[0], q[1], q[2], q[0], q[2], q[3]});
      }
      mesh.vertices = triangles;
      mesh.vertsPerFace.assign(18, 3);
      const auto s = make(std::move(p));
      ASSERT_EQ(s->faceCount(), 3u * 17);
      std::vector<V3d> far;
      farLimit(std::get<SubdivisionMesh>(s.primitive->shape), s.primitive->variables[0].floats,
               boundary(rule == 1 ? Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER
                                  : Sdc::Options::VTX_BOUNDARY_EDGE_ONLY),
               pairs, std::vector<float>(pairs.size() / 2, sharpness), 4, Sdc::SCHEME_LOOP, &far);
      for (uint32_t face = 0; face < s->faceCount(); ++face) {
        EXPECT_EQ(s->uniformIndex(face), face / 3 + (face / 3 >= 5 ? 1 : 0));
        V3f c[4];
        s->corners(face, c);
        for (size_t k = 0; k < 3; ++k) {
          double best = 1;
          for (const V3d& q : far) best = std::min(best, (q - V3d(c[k])).length());
          EXPECT_LT(best, 1e-3) << rule << " " << sharpness << " face " << face << " corner " << k;
        }
      }
    }
}

// s of 0 6 0 0 along both rows of a strip. A smooth boundary is a cubic B-spline, at its points (a + 4 b + c)
// / 6: 4 beside the corner. The corner is kept, but by rule 2 where the mesh itself has no sharp corners:
// then it is smooth as well, between its neighbours 6 and 0.
TEST(SubdivisionSurface, FaceVaryingBoundaryRules) {
  struct Case {
    int mesh, rule;
    float corner, second;
  };
  for (const auto& [mesh, rule, corner, second] : {Case{1, 0, 0, 6},
                                                   {1, 1, 0, 4},
                                                   {2, 1, 0, 4},
                                                   {1, 2, 0, 4},
                                                   {2, 2, 1, 4},
                                                   {1, 3, 0, 6},
                                                   {2, 3, 0, 6}}) {
    Primitive p = sheet(
        4, 2, {{"interpolateboundary", {mesh}, {}, {}}, {"facevaryinginterpolateboundary", {rule}, {}, {}}});
    std::vector<float> values;
    for (const int v : std::get<SubdivisionMesh>(p.shape).vertices)
      values.push_back(v % 4 == 1 ? 6.0f : 0.0f);
    p.variables.push_back(variable("s", StorageClass::FaceVarying, ValueType::Float, 1, values));
    const auto s = make(std::move(p));
    const auto at = [&](uint32_t face, float u) {
      float out = -1;
      s->interpolate(s.primitive->variables[1], face, u, 0, &out);
      return out;
    };
    EXPECT_NEAR(at(0, 0), corner, 1e-5f) << mesh << rule;
    EXPECT_NEAR(at(0, 1), second, 1e-5f) << mesh << rule;
    EXPECT_NEAR(at(1, 0), second, 1e-5f) << mesh << rule;
    if (rule == 0 || rule == 3) {
      EXPECT_NEAR(at(0, 0.25f), 1.5f, 1e-5f) << mesh << rule;  // linear along the edge
    }
  }
}

TEST(SubdivisionSurface, VariablesByClass) {
  Primitive p = primitive(cube(), kCubePoints);
  std::vector<float> perCorner(24), x;
  for (size_t c = 0; c < 24; ++c) perCorner[c] = kCubePoints[3 * static_cast<size_t>(kCubeFaces[c])];
  for (size_t i = 0; i < 8; ++i) x.push_back(kCubePoints[3 * i]);
  p.variables.push_back(variable("vertex", StorageClass::Vertex, ValueType::Point, 3, kCubePoints));
  p.variables.push_back(variable("varying", StorageClass::Varying, ValueType::Float, 1, x));
  p.variables.push_back(variable("corner", StorageClass::FaceVarying, ValueType::Float, 1, perCorner));
  p.variables.push_back(variable("smooth", StorageClass::FaceVertex, ValueType::Float, 1, perCorner));
  p.variables.push_back(variable("uniform", StorageClass::Uniform, ValueType::Float, 1, {0, 1, 2, 3, 4, 5}));
  const auto s = make(std::move(p));
  const auto value = [&](const char* name, uint32_t face, float u, float v) {
    V3f out(0);
    s->interpolate(*findVariable(*s.primitive, name), face, u, v, out.getValue());
    return out;
  };
  for (uint32_t face = 0; face < 6; ++face)
    for (float u : {0.0f, 0.3f, 1.0f})
      for (float v : {0.0f, 0.7f}) {
        const V3f P = s->evaluate(face, u, v).P;
        expectNear(value("vertex", face, u, v), P, 1e-6f);
        EXPECT_NEAR(value("smooth", face, u, v).x, P.x,
                    1e-6f);  // equal around every vertex: the same surface
        const auto corner = [&](size_t k) { return perCorner[4 * face + k]; };
        const float flat =
            (corner(0) * (1 - u) + corner(1) * u) * (1 - v) + (corner(3) * (1 - u) + corner(2) * u) * v;
        EXPECT_NEAR(value("varying", face, u, v).x, flat, 1e-6f);
        EXPECT_NEAR(value("corner", face, u, v).x, flat, 1e-6f);
        EXPECT_EQ(value("uniform", face, u, v).x, static_cast<float>(face));
      }
  // The parts of an n-gon: linear data stay linear.
  Primitive q = prism(5);
  std::vector<float> values;
  for (int v : std::get<SubdivisionMesh>(q.shape).vertices)
    values.push_back(q.variables[0].floats[3 * static_cast<size_t>(v)]);
  q.variables.push_back(variable("corner", StorageClass::FaceVarying, ValueType::Float, 1, values));
  const auto t = make(std::move(q));
  for (uint32_t face = 0; face < 5; ++face) {
    float middle = 1, vertex = 0;
    t->interpolate(t.primitive->variables[1], face, 1, 1, &middle);
    t->interpolate(t.primitive->variables[1], face, 0, 0, &vertex);
    EXPECT_NEAR(middle, 0, 1e-6f);
    EXPECT_EQ(vertex, values[face]);
  }
}

TEST(SubdivisionSurface, SmoothFaceVaryingKeepsSeams) {
  // st over a sheet with a jump of 5 between its left and right half; boundaries sharp (3).
  Primitive p =
      sheet(5, 3, {{"interpolateboundary", {1}, {}, {}}, {"facevaryinginterpolateboundary", {3}, {}, {}}});
  std::vector<float> values;
  const auto& mesh = std::get<SubdivisionMesh>(p.shape);
  for (size_t c = 0; c < mesh.vertices.size(); ++c) {
    const bool right = c / 4 % 4 >= 2;
    values.push_back(static_cast<float>(mesh.vertices[c] % 5) + (right ? 5.0f : 0.0f));
  }
  p.variables.push_back(variable("s", StorageClass::FaceVarying, ValueType::Float, 1, values));
  const auto s = make(std::move(p));
  float left = 0, right = 0, inner = 0;
  s->interpolate(s.primitive->variables[1], 1, 1, 0.5f, &left);
  s->interpolate(s.primitive->variables[1], 2, 0, 0.5f, &right);
  s->interpolate(s.primitive->variables[1], 0, 0.5f, 0.5f, &inner);
  EXPECT_NEAR(left, 2, 1e-5f);
  EXPECT_NEAR(right, 7, 1e-5f);
  EXPECT_GT(inner, 0.4f);
  EXPECT_LT(inner, 0.6f);
}

TEST(SubdivisionSurface, ThreadsSeeTheSame) {
  const auto s = make(prism(7));
  std::vector<V3f> expected;
  for (uint32_t face = 0; face < s->faceCount(); ++face) expected.push_back(s->evaluate(face, 0.3f, 0.4f).P);
  std::vector<std::thread> threads;
  std::atomic<int> wrong = 0;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      for (int k = 0; k < 2000; ++k) {
        const auto face = static_cast<uint32_t>(k * (t + 3)) % s->faceCount();
        wrong += Bits(s->evaluate(face, 0.3f, 0.4f).P) != Bits(expected[face]);
      }
    });
  for (std::thread& t : threads) t.join();
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace patina
