// SPDX-License-Identifier: Apache-2.0
// Facets of different rates: nothing gapes where they meet, and places in facets are found again.
#include "renderer/base/sampling.h"
#include "renderer/geometry/facet_rates.h"

#include <set>

#include "renderer/geometry/geometry.h"
#include "tests/unit/geometry_subdivision_fixtures.h"

namespace patina {
namespace {

using namespace test;

/// A camera at `eye` that looks down +z, 45 degrees over 512 pixels.
RasterCamera cameraAt(const V3d& eye) {
  Camera camera;
  camera.fov = 45;
  camera.worldToCamera.setTranslation(-eye);
  Options options;
  options.xResolution = options.yResolution = 512;
  return {camera, options};
}

Primitive quadric(Quadric::Kind kind, std::array<float, 6> values) {
  return primitive(Quadric{kind, values, 360});
}

/// A torus of control points, periodic both ways.
Primitive patchTorus() {
  ParametricMesh mesh;
  mesh.bicubic = true;
  mesh.nu = 9, mesh.nv = 6;
  mesh.periodicU = mesh.periodicV = true;
  const M44f bspline(-1 / 6.0f, 0.5f, -0.5f, 1 / 6.0f, 0.5f, -1, 0.5f, 0, -0.5f, 0, 0.5f, 0, 1 / 6.0f,
                     4 / 6.0f, 1 / 6.0f, 0);
  mesh.basisU = mesh.basisV = {bspline, 1};
  std::vector<float> P;
  for (int j = 0; j < 6; ++j)
    for (int i = 0; i < 9; ++i) {
      const float a = 2 * kPi * static_cast<float>(i) / 9, b = 2 * kPi * static_cast<float>(j) / 6,
                  r = 3 + std::cos(b);
      P.insert(P.end(), {r * std::cos(a), r * std::sin(a), std::sin(b)});
    }
  return primitive(mesh, std::move(P));
}

Primitive octahedron() {
  return primitive(polygons(std::vector<int>(8, 3),
                            {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5}),
                   {1.1f, 0, 0, -1.3f, 0, 0, 0, 1.7f, 0, 0, -1, 0.1f, 0, 0, 1, 0, 0.3f, -1});
}

std::vector<Primitive> closedPrimitives() {
  std::vector<Primitive> all{quadric(Quadric::Kind::Sphere, {1.7f, -2, 2}),
                             quadric(Quadric::Kind::Torus, {3, 1, -77.7f, 282.3f}),
                             patchTorus(),
                             primitive(cube(), kCubePoints),
                             prism(5),
                             prism(7, {{"crease", {0, 1, 2}, {3}, {}}})};
  Primitive points = primitive(PointSet{3}, {0, 0, 0, 0.7f, 0, 5, -3, 1, 30});
  points.variables.push_back(variable("width", StorageClass::Vertex, ValueType::Float, 1, {1, 0.5f, 4}));
  all.push_back(std::move(points));
  return all;
}

TEST(FacetRates, NothingGapesWhereRatesDiffer) {
  std::set<uint8_t> levels;
  size_t thinned = 0;
  for (const Primitive& p : closedPrimitives())
    for (const V3d& eye : {V3d(0.3, 0.2, -40), V3d(0.4, 1.1, -3.5), V3d(2.5, 0.3, -1.6), V3d(0.1, 0, 1.2)}) {
      const Made s = make(p);
      const Facets facets(*s, traceRates(cameraAt(eye), *s, std::array{M44f()}));
      EXPECT_FALSE(facets.rates.limited);
      EXPECT_EQ(openEdges(facets), 0u) << p.shape.index() << " from " << eye;
      for (const TileRates& r : facets.rates.tiles) {
        levels.insert(r.u);
        for (size_t k = 0; k < kTileSides; ++k) {
          ASSERT_LE(r.side[k], k < 2 ? r.u : r.v);
          thinned += r.side[k] < (k < 2 ? r.u : r.v);
        }
      }
    }
  EXPECT_GE(levels.size(), 5u);  // or the test shows nothing
  EXPECT_GT(thinned, 100u);
}

TEST(FacetRates, FlatFacesThatAreDisplacedDoNotGape) {
  std::vector<Primitive> all{octahedron(), primitive(polygons({4, 4, 4, 4, 4, 4}, kCubeFaces), kCubePoints)};
  for (const Primitive& p : all)
    for (const V3d& eye : {V3d(0.3, 0.2, -40), V3d(0.4, 1.1, -2.5)}) {
      const Made s = make(p);
      ASSERT_TRUE(s->isFlat());
      const Facets facets(*s, traceRates(cameraAt(eye), *s, std::array{M44f()}, 4.0f));
      EXPECT_EQ(openEdges(facets), 0u) << eye;
      EXPECT_GT(facets.rates.tiles.size() << (2 * facets.rates.tiles[0].u), 12u);
    }
}

// Micropolygons of the asked area: between half and twice of it where the surface is seen face on.
TEST(FacetRates, ShadingRateIsTheAreaOfMicropolygons) {
  const Made s = make(primitive(polygons({4}, {0, 1, 3, 2}), {-1, -1, 0, 1, -1, 0, -1, 1, 0, 1, 1, 0}));
  const RasterCamera camera = cameraAt({0, 0, -4});
  const float pixels = 2 * camera.pixelsPerUnit(4);
  for (const float rate : {1.0f, 4.0f, 30.0f}) {
    const Facets facets(*s, traceRates(camera, *s, std::array{M44f()}, rate));
    size_t count = 0;
    facets.forEach([&](const V3f&, const V3f&, const V3f&, const V3f&) { ++count; });
    const float area = pixels * pixels / static_cast<float>(count);
    EXPECT_GT(area, rate / 2.2f) << rate;
    EXPECT_LT(area, rate * 2.2f) << rate;
  }
}

TEST(FacetRates, StayWithinTheirLimit) {
  const Made s = make(quadric(Quadric::Kind::Sphere, {1.7f, -2, 2}));
  Camera camera;
  camera.fov = 0.01f;
  camera.worldToCamera.setTranslation(V3d(0, 0, 1.8));
  Options options;
  options.xResolution = options.yResolution = 1 << 20;
  const SurfaceRates rates = traceRates(RasterCamera(camera, options), *s, std::array{M44f()}, 0.01f);
  EXPECT_TRUE(rates.limited);
  size_t facets = 0;
  for (const TileRates& r : rates.tiles) facets += size_t{1} << (r.u + r.v);
  EXPECT_LE(facets, size_t{1} << 22);
  EXPECT_GT(facets, size_t{1} << 19);
  EXPECT_EQ(openEdges(Facets(*s, rates)), 0u);
}

// A displaced ball that fills a view of a thousandth of a degree has no more facets than the picture has room
// for, however many its shading rate asks for.
TEST(FacetRates, PicturesBoundTheFacetsOfWhatIsDisplaced) {
  const Made s = make(quadric(Quadric::Kind::Sphere, {1, -1, 1}));
  const auto facetsFor = [&](int resolution, float shadingRate) {
    Camera camera;
    camera.fov = 0.001f;
    camera.worldToCamera.setTranslation(V3d(0, 0, 4));
    Options options;
    options.xResolution = options.yResolution = resolution;
    const SurfaceRates rates = traceRates(RasterCamera(camera, options), *s, std::array{M44f()}, shadingRate);
    EXPECT_TRUE(rates.limited);
    size_t sum = 0;
    for (const TileRates& r : rates.tiles) sum += size_t{1} << (r.u + r.v);
    return sum;
  };
  EXPECT_LE(facetsFor(16, 1), 65536u);
  EXPECT_LE(facetsFor(200, 1), 32u * 200 * 200);
  EXPECT_GT(facetsFor(200, 1), 65536u);
  EXPECT_GT(facetsFor(200, 0.25f), 32u * 200 * 200 / 4) << "of smaller micropolygons there are more";
  EXPECT_LE(facetsFor(4000, 0.01f), size_t{1} << 22);
}

TEST(FacetRates, PlacesAlongThinnedSidesAreFoundAgain) {
  // All ways in which the sides of tiles of 1 to 16 facets can have fewer.
  SurfaceRates rates;
  for (uint8_t u = 0; u <= 4; ++u)
    for (uint8_t v = 0; v <= 4; v += 2)
      for (uint8_t a = 0; a <= u; ++a)
        for (uint8_t b = 0; b <= u; b += 2)
          for (uint8_t c = 0; c <= v; ++c)
            for (uint8_t points = 0; points < 16; points += 5)
              rates.tiles.push_back({u, v, {a, b, c, static_cast<uint8_t>(v - c)}, points});
  size_t moved = 0;
  for (uint32_t face = 0; face < rates.tiles.size(); ++face) {
    const TileRates& r = rates.tiles[face];
    const V2f cells(static_cast<float>(r.cellsU()), static_cast<float>(r.cellsV()));
    for (uint32_t k = 0; k < 32; ++k) {
      const V2f met = sobol2(k, face), st = gridToTile(r, met);
      moved += st != met;
      ASSERT_TRUE(st.x >= 0 && st.x <= 1 && st.y >= 0 && st.y <= 1);
      for (const V2f& wanted : {st, met}) {  // these are spread over the tile, too
        const FacetPlace at = locateFacet(rates, FaceShape::Quad, face, wanted);
        bool first;
        const V2f w = at.weights(first);
        ASSERT_TRUE(w.x >= 0 && w.y >= 0 && w.x + w.y <= 1 + 1e-6f);
        const uint32_t i = at.vertex % at.row, j = at.vertex / at.row;
        const V2f p = r.standsAt(i + !first, j + !first) * (1 - w.x - w.y) +
                      r.standsAt(i + first, j + !first) * w.x + r.standsAt(i + !first, j + first) * w.y;
        ASSERT_LT((p - wanted * cells).length(), 1e-4f) << face << ' ' << wanted;
      }
    }
  }
  EXPECT_GT(moved, 5000u);
}

TEST(FacetRates, PlacesAreFoundAgain) {
  SurfaceRates rates;
  rates.tiling = 2;
  rates.tiles.assign(2 * 16, TileRates{3, 1, {3, 3, 1, 1}});
  for (const FaceShape shape : {FaceShape::Quad, FaceShape::Triangle})
    for (uint32_t face = 0; face < 2; ++face)
      for (uint32_t k = 0; k < 16; ++k)
        for (const V2f& st : {V2f(0.3f, 0.4f), V2f(0.9f, 0.1f), V2f(0.01f, 0.98f)}) {
          const uint32_t tile = 16 * face + k;
          EXPECT_EQ(rates.faceOf(tile), face);
          const FacetPlace at = locateFacet(rates, shape, face, tileToFace(rates, shape, tile, st));
          EXPECT_EQ(at.tile, tile);
          EXPECT_EQ(at.row, 9u);
          const auto i = static_cast<float>(at.vertex % at.row), j = static_cast<float>(at.vertex / at.row);
          EXPECT_NEAR((i + at.uv.x) / 8, st.x, 2e-5f);
          EXPECT_NEAR((j + at.uv.y) / 2, st.y, 2e-5f);
        }
  // The corner that a triangle's last row is.
  const FacetPlace corner = locateFacet(rates, FaceShape::Triangle, 0, {0, 1});
  EXPECT_EQ(corner.tile / 4, 3u);
}

// Cells at poles and thinned sides collapse into lines and points; whoever asks for a place in one gets the
// surface's normal there. (With fused multiplications their cross products are not zero.)
TEST(FacetRates, CollapsedFacetsHaveTheNormalOfTheSurface) {
  Scene scene;
  scene.attributes.emplace_back();
  scene.primitives = {quadric(Quadric::Kind::Sphere, {1, -1, 1}), primitive(cube(), kCubePoints)};
  for (Primitive& p : scene.primitives) p.attributes = 0;
  scene.primitives[1].objectToWorld.setTranslation(V3d(0.5, 1.2, 1));
  Messages messages;
  const Geometry geometry(scene, cameraAt({0.9, 0.1, -0.6}), messages.handler);
  geometry.tessellations().setMaker({[&](uint32_t unit) { return geometry.tessellate(unit); },
                                     [](uint32_t, std::unique_ptr<Tessellation>&) {},
                                     [] { return size_t{0}; }, [](uint32_t) { return size_t{0}; }});
  for (uint32_t placement = 0; placement < 2; ++placement) {
    const Surface& surface = geometry.surface(placement);
    int collapsed = 0;
    constexpr int kSteps = 257;
    for (uint32_t face = 0; face < surface.faceCount(); ++face)
      for (int j = 0; j <= kSteps; ++j)
        for (int i = 0; i <= kSteps; ++i) {
          const float u = static_cast<float>(i) / kSteps, v = static_cast<float>(j) / kSteps;
          V3f corner[3];
          V2f weights;
          geometry.facetCorners(placement, face, u, v, corner, weights);
          if (hasArea(corner[1] - corner[0], corner[2] - corner[0])) continue;
          ++collapsed;
          const V3f expected = surface.evaluate(face, u, v).N;
          EXPECT_GT(geometry.facet(placement, face, u, v).N.dot(expected), 0.9999f) << u << " " << v;
        }
    // Those at poles have places of their own, those at thinned sides none but rounding's.
    EXPECT_TRUE(placement == 0 ? collapsed > 100 : collapsed < 10) << collapsed;
  }
  EXPECT_TRUE(messages.lines.empty()) << messages.all();
}

}  // namespace
}  // namespace patina
