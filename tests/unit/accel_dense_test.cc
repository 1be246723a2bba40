// SPDX-License-Identifier: Apache-2.0
// Dense meshes, which are traced in chunks, against one Embree scene of all their faces.
#include <gtest/gtest.h>

#include <random>

#include "renderer/accel/accel.h"
#include "renderer/accel/embree_scene.h"
#include "renderer/base/statistics.h"

namespace patina {
namespace {

constexpr int kCells = 400;  // 320000 triangles: five chunks

/// A bumpy sheet of triangles in random order, or of quads for the greater part.
Primitive sheet(bool quads) {
  PolygonMesh mesh;
  PrimVar points;
  points.name = "P", points.storage = StorageClass::Vertex, points.type = ValueType::Point;
  points.components = 3;
  for (int j = 0; j <= kCells; ++j)
    for (int i = 0; i <= kCells; ++i) {
      const float x = 2 * static_cast<float>(i) / kCells - 1, y = 2 * static_cast<float>(j) / kCells - 1;
      const float z = 0.3f * std::sin(5 * x) * std::cos(4 * y) + 0.01f * std::sin(90 * x) * std::sin(80 * y);
      points.floats.insert(points.floats.end(), {x, y, z});
    }
  std::vector<std::vector<int>> faces;
  for (int j = 0; j < kCells; ++j)
    for (int i = 0; i < kCells; ++i) {
      const int a = j * (kCells + 1) + i;
      if (quads && i % 3 > 0) {
        faces.push_back({a, a + 1, a + kCells + 2, a + kCells + 1});
      } else {
        faces.push_back({a, a + 1, a + kCells + 1});
        faces.push_back({a + kCells + 2, a + kCells + 1, a + 1});
      }
    }
  std::shuffle(faces.begin(), faces.end(), std::mt19937(5));
  for (const auto& face : faces) {
    mesh.vertsPerLoop.push_back(static_cast<int>(face.size()));
    mesh.vertices.insert(mesh.vertices.end(), face.begin(), face.end());
  }
  Primitive p;
  p.shape = std::move(mesh);
  p.variables = {points};
  p.objectToWorld.setScale(V3d(3, 2, 1.5));
  p.objectToWorld.rotate(V3d(0.3, 0.2, 0.1));
  p.attributes = 0;
  return p;
}

struct World {
  Scene scene;
  std::vector<std::string> messages;
  ErrorHandler errors{[this](Severity, std::string_view text) { messages.emplace_back(text); }};
  std::unique_ptr<Geometry> geometry;
  std::unique_ptr<Accel> accel;

  explicit World(Primitive primitive, int kilobytes = 1 << 18) {
    scene.attributes.emplace_back();
    scene.camera.worldToCamera.setTranslation(V3d(0, 0, 20));
    scene.options.geometryCacheKb = kilobytes;
    scene.primitives.push_back(std::move(primitive));
    geometry = std::make_unique<Geometry>(scene, RasterCamera(scene.camera, scene.options), errors);
    accel = std::make_unique<Accel>(*geometry);
  }
  Ray ray(uint32_t k) const {
    std::mt19937 random(k);
    std::uniform_real_distribution<float> uniform(-1, 1);
    const V3f origin(4 * uniform(random), 3 * uniform(random), -4 - uniform(random));
    const V3f target(2.5f * uniform(random), 1.5f * uniform(random), 0.4f * uniform(random));
    return {origin, (target - origin).normalized(), 0, kInfinity, kDiffuseRay};
  }
};

int64_t counter(const std::string& name) {
  for (const StatEntry& entry : statistics())
    if (entry.name == name) return static_cast<int64_t>(entry.value);
  return 0;
}

void expectSameHits(Primitive primitive) {
  resetStatistics();
  const World world(std::move(primitive));
  ASSERT_GE(world.geometry->units().size(), 4u);
  EXPECT_EQ(counter("Geometry/chunks of dense meshes"), static_cast<int64_t>(world.geometry->units().size()));
  EXPECT_EQ(counter("Geometry/units tessellated"), 0);
  const RTCDevice device = rtcNewDevice(nullptr);
  {
    EmbreeScene whole(device, *world.geometry, RTC_BUILD_QUALITY_MEDIUM, {.compact = true});
    whole.addFlat(0);
    whole.attach();
    rtcCommitScene(whole.scene());
    size_t hits = 0;
    for (uint32_t k = 0; k < 20000; ++k) {
      const Ray ray = world.ray(k);
      const Hit hit = world.accel->intersect(ray);
      RTCRayHit r{};
      r.ray.org_x = ray.origin.x, r.ray.org_y = ray.origin.y, r.ray.org_z = ray.origin.z;
      r.ray.dir_x = ray.direction.x, r.ray.dir_y = ray.direction.y, r.ray.dir_z = ray.direction.z;
      r.ray.tfar = kInfinity, r.ray.mask = kAnyRay;
      r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      rtcIntersect1(whole.scene(), &context, &r);
      ASSERT_EQ(hit.valid(), r.hit.geomID != RTC_INVALID_GEOMETRY_ID) << k;
      if (!hit.valid()) continue;
      ++hits;
      ASSERT_EQ(hit.t, r.ray.tfar) << k;
      ASSERT_EQ(hit.face, whole.ownerOf(r.hit.geomID, r.hit.primID, r.hit.u, r.hit.v).face) << k;
      ASSERT_EQ(hit.u, r.hit.u) << k;
      ASSERT_EQ(hit.v, r.hit.v) << k;
    }
    EXPECT_GT(hits, 15000u);
  }
  rtcReleaseDevice(device);
  EXPECT_TRUE(world.messages.empty());
}

TEST(DenseMesh, ChunksOfTrianglesAreHitAsTheWholeIs) { expectSameHits(sheet(false)); }

TEST(DenseMesh, ChunksOfQuadsAndTrianglesAreHitAsTheWholeIs) { expectSameHits(sheet(true)); }

TEST(DenseMesh, NoRayPassesBetweenChunks) {
  // Rays at points of edges and at corners, from above: all of the sheet's inside is closed.
  const World world(sheet(false));
  const Surface& surface = world.geometry->surface(0);
  const M44f& toWorld = world.geometry->placements()[0].objectToWorld;
  for (uint32_t face = 0; face < surface.faceCount(); face += 7) {
    V3f p[4];
    surface.corners(face, p);
    const V3f middle = (p[0] + p[1]) * 0.5f;
    for (const V3f& at : {p[0], middle}) {
      if (std::max(std::abs(at.x), std::abs(at.y)) > 0.99f) continue;
      const V3f target = transformPoint(at, toWorld);
      const Ray ray{target + V3f(0, 0, -4), {0, 0, 1}, 0, kInfinity, kDiffuseRay};
      ASSERT_TRUE(world.accel->occluded(ray)) << face;
      ASSERT_TRUE(world.accel->intersect(ray).valid()) << face;
    }
  }
}

TEST(DenseMesh, ChunksAreMadeWhenMetAndDroppedWithinTheBudget) {
  const World large(sheet(false));
  resetStatistics();
  EXPECT_TRUE(large.accel->intersect({V3f(-2, -1.2f, -5), V3f(0, 0, 1), 0, kInfinity, kDiffuseRay}).valid());
  EXPECT_GE(counter("Geometry/units tessellated"), 1);
  EXPECT_LT(counter("Geometry/units tessellated"), 5);
  constexpr uint32_t kRays = 60;
  std::vector<Hit> expected;
  for (uint32_t k = 0; k < kRays; ++k) expected.push_back(large.accel->intersect(large.ray(k)));
  const size_t whole = large.geometry->tessellations().peak();
  EXPECT_LT(whole, 320000u * 80);  // bytes per triangle

  const World small(sheet(false), static_cast<int>(whole / 1024 * 5 / 8));
  resetStatistics();
  for (uint32_t k = 0; k < kRays; ++k) {
    const Hit hit = small.accel->intersect(small.ray(k));
    ASSERT_EQ(hit.t, expected[k].t);
    ASSERT_EQ(hit.face, expected[k].face);
  }
  EXPECT_GT(counter("Geometry/units dropped"), 5);
  // A chunk, a fifth of the whole, is counted when it is there.
  EXPECT_LE(small.geometry->tessellations().peak(), small.geometry->tessellations().budget() + whole / 4);
}

}  // namespace
}  // namespace patina
