// SPDX-License-Identifier: Apache-2.0
// Displacement of facets: nothing gapes, normals are those of the displaced surface, bounds are found and
// kept.
#include "renderer/geometry/displacement.h"

#include <functional>

#include "renderer/geometry/geometry.h"
#include "tests/unit/geometry_subdivision_fixtures.h"

namespace patina {
namespace {

using namespace test;

/// Moves every vertex by a function of its place, and counts what it is asked.
class TestDisplacer final : public Displacer {
 public:
  using Move = std::function<void(const Vertices&, size_t, V3f& P)>;
  explicit TestDisplacer(Move move, Bound bound = {0, 0}) : move_(std::move(move)), bound_(bound) {}
  std::optional<Bound> boundOf(const Attributes& attributes) const override {
    return attributes.displacement == kNone ? std::nullopt : std::optional(bound_);
  }
  bool displace(const Vertices& v) const override {
    ++tiles;
    vertices += v.P.size();
    for (size_t k = 0; k < v.P.size(); ++k) {
      EXPECT_NEAR(v.N[k].length(), 1, 1e-5f);
      EXPECT_GT(v.footprint[k], 0);
      V3f moved = v.P[k];
      move_(v, k, moved);
      v.P[k] = moved;
    }
    return false;
  }
  mutable size_t tiles = 0, vertices = 0;

 private:
  Move move_;
  Bound bound_;
};

RasterCamera camera() {
  Camera settings;
  settings.fov = 45;
  settings.worldToCamera.setTranslation(V3d(0.2, 0.1, 6));
  Options options;
  options.xResolution = options.yResolution = 200;
  return {settings, options};
}

struct Displaced {
  Facets facets;
  DisplacementResult result;
};
Displaced displaced(const Made& s, const Displacer& displacer, const M44f& toWorld = {}) {
  Displaced d{{}, {}};
  d.facets.rates = traceRates(camera(), *s, std::array{toWorld}, 9.0f);
  tessellate(*s, d.facets.rates, d.facets.first, d.facets.vertices);
  d.result = displaceFacets(*s, *s.primitive, Attributes{}, toWorld, false, displacer, d.facets.rates,
                            d.facets.first, d.facets.vertices);
  return d;
}

Primitive sphere() { return primitive(Quadric{Quadric::Kind::Sphere, {1, -1, 1}, 360}); }
Primitive polygonCube() { return primitive(polygons({4, 4, 4, 4, 4, 4}, kCubeFaces), kCubePoints); }

TEST(Displacement, NothingGapes) {
  // Along N, which differs on either side of creases and seams, by what differs there, too.
  const TestDisplacer alongN([](const Displacer::Vertices& v, size_t k, V3f& P) {
    P += v.N[k] * (0.1f + 0.05f * std::sin(20 * v.uv[k].x) * std::cos(13 * v.uv[k].y) +
                   0.01f * static_cast<float>(v.face % 5));
  });
  M44f squashed;
  squashed.scale(V3f(1.3f, 0.4f, -0.7f));
  for (const Primitive& p : {sphere(), primitive(Quadric{Quadric::Kind::Torus, {1, 0.3f, 0, 360}, 360}),
                             primitive(cube(), kCubePoints), prism(5), polygonCube(),
                             primitive(polygons(std::vector<int>(4, 3), {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2}),
                                       {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1})})
    for (const M44f& toWorld : {M44f(), squashed}) {
      const Displaced d = displaced(make(p), alongN, toWorld);
      EXPECT_EQ(openEdges(d.facets), 0u) << p.shape.index();
      EXPECT_GT(d.result.moved, 0.05f);
      EXPECT_EQ(d.result.normals.size(), d.facets.vertices.size());
    }
}

// r = 1 + 0.1 z on the unit sphere, that is a sphere moved along z but for terms of second order: positions
// as asked for to a few roundings, and its normal is that of the implicit surface r - 0.1 z / r = 1.
TEST(Displacement, NormalsAreThoseOfTheDisplacedSurface) {
  const TestDisplacer radial([](const Displacer::Vertices&, size_t, V3f& P) { P *= 1 + 0.1f * P.z; });
  const Displaced d = displaced(make(sphere()), radial);
  float worst = 0;
  for (size_t k = 0; k < d.facets.vertices.size(); ++k) {
    const V3f P = d.facets.vertices[k];
    const float r = P.length();
    EXPECT_NEAR(r, 1 + 0.1f * P.z / r, 1e-6f);
    const V3f gradient = P / r - (V3f(0, 0, 1) / r - P * (P.z / (r * r * r))) * 0.1f;
    const V3f n = unpackNormal(d.result.normals[k]);
    EXPECT_NEAR(n.length(), 1, 1e-6f);
    worst = std::max(worst, std::acos(std::min(std::abs(n.dot(gradient.normalized())), 1.0f)));
  }
  EXPECT_LT(worst, 0.05f);  // facets turn by up to 0.2 radians; means of neighbours are better
  EXPECT_NEAR(d.result.moved, 0.1f, 1e-3f);
}

TEST(Displacement, CreasesStayAndSmoothNormalsTurn) {
  const TestDisplacer outwards([](const Displacer::Vertices& v, size_t k, V3f& P) { P += v.N[k] * 0.1f; });
  // A cube keeps flat sides right up to where they meet.
  const Displaced box = displaced(make(polygonCube()), outwards);
  size_t square = 0;
  for (const uint32_t packed : box.result.normals) square += maxAbsComponent(unpackNormal(packed)) > 0.9999f;
  EXPECT_GT(square, box.result.normals.size() / 2);
  // One that is to look round shows its own normals where nothing turns.
  Primitive round = primitive(polygons({4}, {0, 1, 3, 2}), {-1, -1, 0, 1, -1, 0, -1, 1, 0, 1, 1, 0});
  round.variables.push_back(variable("N", StorageClass::Vertex, ValueType::Normal, 3,
                                     {-0.3f, 0, 1, 0.3f, 0, 1, -0.3f, 0, 1, 0.3f, 0, 1}));
  const TestDisplacer lifted([](const Displacer::Vertices&, size_t, V3f& P) { P.z += 0.2f; });
  const Made s = make(round);
  const Displaced d = displaced(s, lifted);
  const TileRates& r = d.facets.rates.tiles[0];
  const V3f corner = unpackNormal(d.result.normals[0]),
            middle = unpackNormal(d.result.normals[r.cellsU() / 2]);
  EXPECT_NEAR(std::abs(corner.x), 0.3f / std::sqrt(1.09f), 0.02f);
  EXPECT_NEAR(std::abs(middle.z), 1, 1e-3f);
}

// Two sides of a sheet, in the same places: each keeps its own displacement.
TEST(Displacement, SidesOfASheetAreNotSewnTogether) {
  const TestDisplacer alongN([](const Displacer::Vertices& v, size_t k, V3f& P) { P += v.N[k] * 0.1f; });
  const Displaced d = displaced(
      make(primitive(polygons({4, 4}, {0, 1, 3, 2, 2, 3, 1, 0}), {-1, -1, 0, 1, -1, 0, -1, 1, 0, 1, 1, 0})),
      alongN);
  for (const V3f& p : d.facets.vertices) EXPECT_NEAR(std::abs(p.z), 0.1f, 1e-6f);
}

TEST(Displacement, PackedNormalsComeBack) {
  for (int k = 0; k < 10000; ++k) {
    const float z = 1 - 2 * (static_cast<float>(k) + 0.5f) / 10000, a = 2.4f * static_cast<float>(k),
                r = std::sqrt(std::max(0.0f, 1 - z * z));
    const V3f n(r * std::cos(a), r * std::sin(a), z);
    EXPECT_LT((unpackNormal(packNormal(n)) - n).length(), 7e-5f);
  }
  for (const V3f& axis : {V3f(0, 0, 1), V3f(0, 0, -1), V3f(1, 0, 0), V3f(0, -1, 0)})
    EXPECT_LT((unpackNormal(packNormal(axis)) - axis).length(), 5e-5f);
}

/// A scene of `sphere()` with displacement, in the world or in an object with instances.
struct World {
  Scene scene;
  Messages messages;
  std::unique_ptr<Geometry> geometry;

  World(const Displacer& displacer, int instances, bool ofInstance) {
    Attributes plain, moved;
    moved.displacement = 0;
    moved.displacementBound = 0;
    scene.attributes = {plain, moved};
    scene.shaders.emplace_back();
    Primitive p = sphere();
    p.attributes = 1;
    if (instances == 0) {
      scene.primitives.push_back(p);
    } else {
      if (ofInstance) p.attributes = kNone;
      scene.objects.emplace_back().primitives.push_back(p);
      for (int k = 0; k < instances; ++k) {
        Instance instance;
        instance.object = 0, instance.attributes = ofInstance ? 1 : 0;
        instance.objectToWorld.setTranslation(V3d(3.0 * k, 0, 0));
        scene.instances.push_back(instance);
      }
    }
    geometry = std::make_unique<Geometry>(scene, camera(), messages.handler, &displacer);
    geometry->tessellations().setMaker({[this](uint32_t unit) { return geometry->tessellate(unit); },
                                        [](uint32_t, std::unique_ptr<Tessellation>&) {},
                                        [] { return size_t{0}; }, [](uint32_t) { return size_t{0}; }});
  }
};

TEST(Displacement, HappensWhenAUnitIsMetAndOnceForAllInstances) {
  const auto grow = [](const Displacer::Vertices& v, size_t k, V3f& P) { P += v.N[k] * 0.25f; };
  {
    const TestDisplacer bounded(grow, {0, 0.3f});
    const World w(bounded, 0, false);
    EXPECT_EQ(bounded.vertices, 0u);
    EXPECT_NEAR(w.geometry->bound().max.x, 1.3f, 1e-4f);
    EXPECT_NEAR(w.geometry->facet(0, 0, 0.3f, 0.4f).P.length(), 1.25f, 2e-3f);
    EXPECT_GT(bounded.vertices, 0u);
    const Geometry::DisplacedPoint at = w.geometry->displacedPoint(0, 0, 0.3f, 0.4f);
    const V3f P = w.geometry->facet(0, 0, 0.3f, 0.4f).P;
    EXPECT_GT(std::abs(at.N.dot(P.normalized())), 0.999f);
    EXPECT_NEAR(at.dPdu.length(), 2 * kPi * std::hypot(P.x, P.y), 0.2f);
    EXPECT_NEAR(at.dPdv.length(), kPi * 1.25f, 0.1f);
    EXPECT_TRUE(w.messages.lines.empty()) << w.messages.all();
  }
  const TestDisplacer shared(grow, {0, 0.3f});
  const World w(shared, 3, false);
  size_t before = 0;
  for (uint32_t k = 0; k < 3; ++k) {
    const V3f center(3.0f * static_cast<float>(k), 0, 0);
    EXPECT_NEAR((w.geometry->facet(k, 0, 0.3f, 0.4f).P - center).length(), 1.25f, 2e-3f);
    if (k == 0) before = shared.vertices;
  }
  EXPECT_EQ(shared.vertices, before);
  // Displacement that belongs to the instances: surfaces of their own, in world space.
  const TestDisplacer byPlace(
      [](const Displacer::Vertices& v, size_t k, V3f& P) { P += v.N[k] * (P.x > 1.5f ? 0.2f : 0.1f); },
      {0, 0.3f});
  const World own(byPlace, 2, true);
  ASSERT_EQ(own.geometry->placements().size(), 2u);
  EXPECT_NEAR(own.geometry->facet(0, 0, 0.3f, 0.4f).P.length(), 1.1f, 2e-3f);
  EXPECT_NEAR((own.geometry->facet(1, 0, 0.3f, 0.4f).P - V3f(3, 0, 0)).length(), 1.2f, 2e-3f);
}

TEST(Displacement, VerticesStandInFacetsThatHaveArea) {
  const TestDisplacer waves([](const Displacer::Vertices& v, size_t k,
                               V3f& P) { P += v.N[k] * (0.1f * std::sin(9 * P.x) * std::sin(7 * P.y)); },
                            {0, 0.1f});
  const World w(waves, 0, false);
  constexpr int kSteps = 300;
  int collapsed = 0;
  for (int j = 0; j <= kSteps; ++j)
    for (int i = 0; i <= kSteps; ++i) {
      const V2f uv(static_cast<float>(i) / kSteps, static_cast<float>(j) / kSteps);
      V3f corner[3];
      V2f weights;
      w.geometry->facetCorners(0, 0, uv.x, uv.y, corner, weights);
      collapsed += !hasArea(corner[1] - corner[0], corner[2] - corner[0]);
      const V2f inside = w.geometry->insideFacet(0, 0, uv.x, uv.y);
      w.geometry->facetCorners(0, 0, inside.x, inside.y, corner, weights);
      EXPECT_TRUE(hasArea(corner[1] - corner[0], corner[2] - corner[0])) << uv;
      EXPECT_GT(std::min({weights.x, weights.y, 1 - weights.x - weights.y}), 0.08f) << uv;
      EXPECT_LT((inside - uv).length(), 0.1f) << uv;
    }
  EXPECT_GT(collapsed, 0);
}

TEST(Displacement, BoundsAreFoundAndChecked) {
  const auto grow = [](const Displacer::Vertices& v, size_t k, V3f& P) { P += v.N[k] * 0.25f; };
  const TestDisplacer unbounded(grow);
  const World found(unbounded, 0, false);
  EXPECT_GT(unbounded.vertices, 0u);  // at once
  EXPECT_TRUE(found.messages.mention("displacementbound")) << found.messages.all();
  EXPECT_TRUE(found.messages.mention("0.25"));
  EXPECT_NEAR(found.geometry->bound().max.x, 1.25f, 1e-2f);

  const TestDisplacer lying(grow, {0, 0.1f});
  const World exceeding(lying, 0, false);
  exceeding.geometry->facet(0, 0, 0.5f, 0.5f);
  EXPECT_TRUE(exceeding.messages.mention("reaches 0.25")) << exceeding.messages.all();
  EXPECT_TRUE(exceeding.messages.mention("is 0.1"));

  const TestDisplacer idle([](const Displacer::Vertices&, size_t, V3f&) {}, {0, 0.1f});
  const World nothing(idle, 0, false);
  nothing.geometry->facet(0, 0, 0.5f, 0.5f);
  nothing.geometry->facet(0, 0, 0.1f, 0.5f);
  EXPECT_EQ(nothing.messages.lines.size(), 1u) << nothing.messages.all();
  EXPECT_TRUE(nothing.messages.mention("moves nothing"));
}

}  // namespace
}  // namespace patina
