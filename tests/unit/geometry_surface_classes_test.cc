// SPDX-License-Identifier: Apache-2.0
// Primitive variables of every class and size on every kind of primitive: what holds for all of them.
#include <set>

#include "renderer/scene/value_count.h"
#include "tests/unit/geometry_subdivision_fixtures.h"

namespace patina {
namespace {

using namespace test;

struct Kind {
  const char* name;
  Primitive primitive;
  bool linear = false;  ///< vertex values are those of corners, as varying ones are
};

std::vector<float> grid(int nu, int nv) {
  std::vector<float> P;
  for (int j = 0; j < nv; ++j)
    for (int i = 0; i < nu; ++i)
      P.insert(P.end(), {static_cast<float>(i), static_cast<float>(j), static_cast<float>(i * j % 3)});
  return P;
}

SplineKnots clamped(int count, int order) {
  SplineKnots s{count, order, {}, 0, static_cast<float>(count - order + 1)};
  for (int k = 0; k < count + order; ++k)
    s.knots.push_back(static_cast<float>(std::clamp(k - order + 1, 0, count - order + 1)));
  return s;
}

std::vector<Kind> kinds() {
  using Quadrics = Quadric::Kind;
  const CubicBasis bezier{M44f(-1, 3, -3, 1, 3, -6, 3, 0, -3, 3, 0, 0, 1, 0, 0, 0), 3};
  std::vector<Kind> all;
  for (const auto kind : {Quadrics::Sphere, Quadrics::Cone, Quadrics::Cylinder, Quadrics::Hyperboloid,
                          Quadrics::Paraboloid, Quadrics::Disk, Quadrics::Torus})
    all.push_back({"quadric", primitive(Quadric{kind, {2, 0.5f, 1, 90, 2, 3}, 200}), true});
  all.push_back({"polygons",
                 primitive({polygons({4, 3, 5}, {0, 1, 4, 3, 1, 2, 5, 3, 4, 5, 7, 6})},
                           {0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0, 1, 1, 0, 2, 1, 0, 0, 2, 0, 2, 2, 0}),
                 true});
  all.push_back(
      {"bilinear mesh", primitive(ParametricMesh{false, 4, 3, false, false, {}, {}}, grid(4, 3)), true});
  all.push_back(
      {"bicubic mesh", primitive(ParametricMesh{true, 7, 4, false, false, bezier, bezier}, grid(7, 4))});
  all.push_back({"subdivision mesh", sheet(4, 3, {{"interpolateboundary", {1}, {}, {}}})});
  all.push_back({"linear curves", primitive(CurveSet{false, false, false, {}, {3, 4}}, grid(7, 1))});
  all.push_back({"cubic curves", primitive(CurveSet{true, false, false, bezier, {7, 4}}, grid(11, 1))});
  all.push_back({"NURBS", primitive(NurbsPatch{clamped(5, 3), clamped(4, 4), nullptr}, grid(5, 4))});
  Primitive rational = primitive(NurbsPatch{clamped(5, 3), clamped(4, 4), nullptr});
  rational.variables.push_back(variable("Pw", StorageClass::Vertex, ValueType::HPoint, 4, {}));
  for (int k = 0; k < 20; ++k) {
    const auto x = static_cast<float>(k % 5), y = static_cast<float>(k / 5);
    const float w = 0.5f + static_cast<float>(k % 3);
    const std::array<float, 4> point{x * w, y * w, w, w};
    rational.variables[0].floats.insert(rational.variables[0].floats.end(), point.begin(), point.end());
  }
  all.push_back({"rational NURBS", rational});
  all.push_back({"points", primitive(PointSet{3}, {0, 0, 0, 3, 0, 0, 6, 0, 0}), true});
  return all;
}

/// Values k + 100 c of component c at index k: as weights sum to one, all components tell the same.
PrimVar counting(StorageClass storage, int components, size_t values) {
  PrimVar v = variable("v", storage, ValueType::Float, components, {});
  for (size_t k = 0; k < values; ++k)
    for (int c = 0; c < components; ++c)
      v.floats.push_back(static_cast<float>(k) + 100 * static_cast<float>(c));
  return v;
}

TEST(Classes, OfEverySizeOnEveryKindOfPrimitive) {
  for (Kind& kind : kinds()) {
    size_t points = 0;
    for (const PrimVar& v : kind.primitive.variables)
      points = std::max(points, v.floats.size() / static_cast<size_t>(v.components));
    const ValueCounts counts = valueCounts(kind.primitive.shape, points);
    const auto s = make(kind.primitive);
    for (const StorageClass storage :
         {StorageClass::Constant, StorageClass::Uniform, StorageClass::Varying, StorageClass::Vertex,
          StorageClass::FaceVarying, StorageClass::FaceVertex}) {
      SCOPED_TRACE(std::string(kind.name) + ", class " + std::to_string(static_cast<int>(storage)));
      const size_t n = counts.of(storage);
      ASSERT_GT(n, 0u);
      std::set<long> met;  // whole values at corners
      for (const int components : {1, 3, 4, 16}) {
        const PrimVar v = counting(storage, components, n),
                      twin = counting(StorageClass::FaceVarying, components, n);
        for (uint32_t face = 0; face < s->faceCount(); ++face)
          for (const float x : {0.0f, 0.3f, 1.0f})
            for (const float y : {0.0f, 0.6f, 1.0f}) {
              if (s->faceShape(face) == FaceShape::Triangle && x + y > 1) continue;
              float out[17], other[17];
              out[components] = -7;
              s->interpolate(v, face, x, y, out);
              EXPECT_EQ(out[components], -7);  // no more is written than it has
              for (int c = 1; c < components; ++c)
                EXPECT_NEAR(out[c], out[0] + 100 * static_cast<float>(c), 2e-3f);
              EXPECT_GE(out[0], -1e-4f);
              EXPECT_LE(out[0], static_cast<float>(n - 1) + 1e-4f);
              if (storage == StorageClass::Constant) {
                EXPECT_EQ(out[0], 0);
              }
              if (storage == StorageClass::Uniform) {
                EXPECT_EQ(out[0], static_cast<float>(s->uniformIndex(face)));
              }
              if (storage == StorageClass::FaceVertex && kind.linear) {
                s->interpolate(twin, face, x, y, other);
                EXPECT_EQ(out[0], other[0]);
              }
              if (std::abs(out[0] - std::round(out[0])) < 1e-4f) met.insert(std::lround(out[0]));
            }
      }
      // Every value is used where it belongs.
      if (storage != StorageClass::Vertex || kind.linear) {
        EXPECT_EQ(met.size(), n);
      }
    }
  }
}

}  // namespace
}  // namespace patina
