// SPDX-License-Identifier: Apache-2.0
// Surfaces that are tessellated when rays meet them, and again when they had to go.
#include <gtest/gtest.h>

#include <random>
#include <thread>

#include "renderer/accel/accel.h"
#include "renderer/base/sampling.h"
#include "renderer/base/statistics.h"

namespace patina {
namespace {

Primitive sphereAt(const V3d& center) {
  Primitive p;
  Quadric q;
  q.kind = Quadric::Kind::Sphere;
  q.values = {1, -1, 1};
  p.shape = q;
  p.objectToWorld.setTranslation(center);
  p.attributes = 0;
  return p;
}

/// A fine grid of triangles, slightly bent, in one request.
Primitive meshAt(const V3d& center, int cells) {
  PolygonMesh mesh;
  PrimVar points;
  points.name = "P", points.storage = StorageClass::Vertex, points.type = ValueType::Point;
  points.components = 3;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i) {
      const float x = 2 * static_cast<float>(i) / static_cast<float>(cells) - 1,
                  y = 2 * static_cast<float>(j) / static_cast<float>(cells) - 1;
      points.floats.insert(points.floats.end(), {x, y, 0.2f * x * y});
    }
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const int a = j * (cells + 1) + i;
      for (const int v : {a, a + 1, a + cells + 1, a + cells + 2, a + cells + 1, a + 1})
        mesh.vertices.push_back(v);
      mesh.loopsPerFace.insert(mesh.loopsPerFace.end(), {1, 1});
      mesh.vertsPerLoop.insert(mesh.vertsPerLoop.end(), {3, 3});
    }
  Primitive p;
  p.shape = mesh;
  p.variables = {points};
  p.objectToWorld.setTranslation(center);
  p.attributes = 0;
  return p;
}

struct World {
  Scene scene;
  std::vector<std::string> messages;
  ErrorHandler errors{[this](Severity, std::string_view text) { messages.emplace_back(text); }};
  std::unique_ptr<Geometry> geometry;
  std::unique_ptr<Accel> accel;

  /// A 20 x 20 field of spheres and meshes; every other one twice, by way of an object.
  explicit World(int kilobytes) {
    scene.attributes.emplace_back();
    scene.camera.worldToCamera.setTranslation(V3d(0, 0, 80));
    scene.options.geometryCacheKb = kilobytes;
    ObjectDefinition object;
    for (int k = 0; k < 400; ++k) {
      const V3d center(3.0 * (k % 20) - 28.5, 3.0 * (k / 20) - 28.5, 0);
      Primitive p = k % 3 == 0 ? meshAt(center, 10) : sphereAt(center);
      if (k % 2 == 0) {
        object.primitives.push_back(p);
        object.primitives.back().attributes = kNone;
      }
      scene.primitives.push_back(std::move(p));
    }
    scene.objects.push_back(std::move(object));
    Instance instance;
    instance.object = 0, instance.attributes = 0;
    instance.objectToWorld.setTranslation(V3d(0, 0, 10));
    scene.instances = {instance};
    geometry = std::make_unique<Geometry>(scene, RasterCamera(scene.camera, scene.options), errors);
    accel = std::make_unique<Accel>(*geometry);
  }
  Ray ray(uint32_t k) const {
    std::mt19937 random(k);
    std::uniform_real_distribution<float> uniform(-1, 1);
    const V3f origin(30 * uniform(random), 30 * uniform(random), -8);
    const V3f target(28 * uniform(random), 28 * uniform(random), 5 + 5 * uniform(random));
    return {origin, (target - origin).normalized(), 0, kInfinity, kDiffuseRay};
  }
};

int64_t counter(const std::string& name) {
  for (const StatEntry& entry : statistics())
    if (entry.name == name) return static_cast<int64_t>(entry.value);
  return 0;
}

bool operator==(const Hit& a, const Hit& b) {
  return a.t == b.t && a.placement == b.placement && a.face == b.face && a.u == b.u && a.v == b.v &&
         a.front == b.front;
}

TEST(Units, NothingIsMadeThatNoRayMeets) {
  resetStatistics();
  World world(1 << 18);
  EXPECT_EQ(counter("Geometry/units tessellated"), 0);
  EXPECT_EQ(counter("Geometry/facets of curved surfaces"), 0);
  const int64_t early = counter("Geometry/surfaces made");  // quadrics are made to be bounded, meshes are not
  ASSERT_FALSE(world.accel->intersect({V3f(70, 0, -8), V3f(0, 0, 1), 0, kInfinity, kCameraRay}).valid());
  EXPECT_EQ(counter("Geometry/units tessellated"), 0);
  const Hit hit = world.accel->intersect({V3f(-28.5f, -28.5f, -8), V3f(0, 0, 1), 0, kInfinity, kCameraRay});
  ASSERT_TRUE(hit.valid());
  EXPECT_GE(counter("Geometry/units tessellated"), 1);
  // Its own, and neighbours whose bounds are met, too.
  EXPECT_LE(counter("Geometry/units tessellated"), 4);
  EXPECT_GT(world.geometry->units().size(), 20u);
  EXPECT_LT(counter("Geometry/surfaces made") - early, 100);
  EXPECT_EQ(counter("Geometry/patches"), 0);
  world.geometry->patches().find(hit.placement, hit.face, hit.u, hit.v);
  EXPECT_EQ(counter("Geometry/placements diced"), 1);
}

TEST(Units, SettledOnesAreHitAsBefore) {
  resetStatistics();
  constexpr uint32_t kRays = 4000;
  World world(1 << 18);
  std::vector<Hit> before(kRays), after(kRays), many(kRays);
  std::vector<Ray> rays;
  for (uint32_t k = 0; k < kRays; ++k) rays.push_back(world.ray(k));
  // What the first hundred have met settles; later ones meet both kinds.
  world.accel->intersect(std::span(rays).first(100), std::span(before).first(100));
  const int64_t made = counter("Geometry/units tessellated");
  world.accel->settle();
  EXPECT_EQ(counter("Geometry/units moved into the scene's own structure"), made);
  EXPECT_GT(made, 20);
  const World lazy(1 << 18);
  lazy.accel->intersect(rays, before);
  EXPECT_GT(counter("Geometry/units tessellated"), made);
  world.accel->intersect(rays, after);
  world.accel->intersectMany(rays, many);
  std::vector<uint8_t> occluded(kRays);
  world.accel->occluded(rays, occluded);
  for (uint32_t k = 0; k < kRays; ++k) {
    ASSERT_TRUE(after[k] == before[k]) << k;
    ASSERT_EQ(many[k].placement, before[k].placement) << k;
    ASSERT_EQ(many[k].face, before[k].face) << k;
    ASSERT_EQ(occluded[k] != 0, before[k].valid()) << k;
  }
}

TEST(Units, SettledOnesCountInTheBudget) {
  // Only so many settle as half of the budget holds, and these stay while others come and go.
  resetStatistics();
  const World large(1 << 18);
  for (uint32_t k = 0; k < 2000; ++k) large.accel->intersect(large.ray(k));
  const size_t whole = large.geometry->tessellations().peak();
  World world(static_cast<int>(whole / 1024 / 2));
  const TessellationCache& cache = world.geometry->tessellations();
  for (uint32_t k = 0; k < 12; ++k) world.accel->intersect(world.ray(k));
  ASSERT_FALSE(cache.isTight());
  world.accel->settle();
  const int64_t settled = counter("Geometry/units moved into the scene's own structure");
  EXPECT_GT(settled, 5);
  const size_t units = world.geometry->units().size();
  std::vector<uint32_t> there;
  for (uint32_t k = 0; k < units; ++k)
    if (const Tessellation* made = cache.resident(k); made && !made->tracer) there.push_back(k);
  EXPECT_EQ(static_cast<int64_t>(there.size()), settled);
  for (uint32_t k = 0; k < 4000; ++k) {
    const Hit hit = world.accel->intersect(world.ray(k)), expected = large.accel->intersect(large.ray(k));
    ASSERT_TRUE(hit == expected) << k;
  }
  EXPECT_TRUE(cache.isTight());
  EXPECT_LE(cache.peak(), cache.budget() * 105 / 100);
  for (const uint32_t unit : there) EXPECT_NE(cache.resident(unit), nullptr);
  world.accel->settle();  // too late: there is no room
  EXPECT_EQ(counter("Geometry/units moved into the scene's own structure"), settled);
}

TEST(Units, TheBudgetChangesNoHit) {
  constexpr uint32_t kRays = 1000;
  const World large(1 << 18);
  std::vector<Hit> expected;
  for (uint32_t k = 0; k < kRays; ++k) expected.push_back(large.accel->intersect(large.ray(k)));
  const size_t whole = large.geometry->tessellations().peak();
  EXPECT_GT(std::count_if(expected.begin(), expected.end(), [](const Hit& h) { return h.valid(); }), 200);
  ASSERT_GT(large.geometry->units().size(), 15u);
  ASSERT_LT(whole, large.geometry->tessellations().budget());

  const World small(static_cast<int>(whole / 1024 / 3));
  resetStatistics();
  for (uint32_t k = 0; k < kRays; ++k) {
    const Ray ray = small.ray(k);
    ASSERT_TRUE(small.accel->intersect(ray) == expected[k]) << k;
    ASSERT_EQ(small.accel->occluded(ray), expected[k].valid()) << k;
    if (!expected[k].valid()) continue;
    const Hit& h = expected[k];
    const Facet a = large.geometry->facet(h.placement, h.face, h.u, h.v),
                b = small.geometry->facet(h.placement, h.face, h.u, h.v);
    ASSERT_TRUE(a.P == b.P && a.N == b.N && a.error == b.error);
  }
  EXPECT_GT(counter("Geometry/units dropped"), 10);
  EXPECT_GT(counter("Geometry/units tessellated again"), 10);
  EXPECT_LE(small.geometry->tessellations().peak(), small.geometry->tessellations().budget() * 105 / 100);
}

TEST(Units, BatchesMeetTheSameAndMakeEachUnitOnce) {
  constexpr uint32_t kRays = 20000;
  const World large(1 << 18);
  std::vector<Ray> rays;
  for (uint32_t k = 0; k < kRays; ++k) rays.push_back(large.ray(k));
  std::vector<Hit> expected(kRays), met(kRays), packets(kRays), samePackets(kRays);
  std::vector<uint8_t> occluded(kRays);
  large.accel->intersect(rays, expected);
  large.accel->intersectMany(rays, samePackets);
  const size_t whole = large.geometry->tessellations().peak();
  EXPECT_FALSE(large.geometry->tessellations().isTight());

  const World small(static_cast<int>(whole / 1024 / 10));
  const TessellationCache& cache = small.geometry->tessellations();
  for (uint32_t k = 0; k < 20; ++k) small.accel->intersect(rays[k]);
  ASSERT_TRUE(cache.isTight());
  resetStatistics();
  small.accel->intersect(rays, met);
  // Each unit that rays meet, and those once more that were there at the beginning and had to go.
  EXPECT_LE(counter("Geometry/units tessellated again") + counter("Geometry/units tessellated"),
            static_cast<int64_t>(cache.units()) * 5 / 4);
  EXPECT_GT(counter("Rays/meetings that waited"), kRays / 2);
  small.accel->intersectMany(rays, packets);
  small.accel->occluded(rays, occluded);
  for (uint32_t k = 0; k < kRays; ++k) {
    ASSERT_TRUE(met[k] == expected[k]) << k;
    ASSERT_TRUE(packets[k] == samePackets[k]) << k;
    ASSERT_EQ(occluded[k] != 0, expected[k].valid()) << k;
  }
  EXPECT_LE(cache.peak(), cache.budget() * 105 / 100);
}

TEST(Units, SurfacesAtTheSameDistanceAreMetInTheSameOrder) {
  // Spheres upon each other, in different units and in instances: which is met is up to the traversal, and
  // not to what happens to be there.
  const auto build = [](World& world) {
    const auto count = static_cast<uint32_t>(world.scene.primitives.size());
    for (uint32_t k = 0; k < count; ++k)
      world.scene.primitives.push_back(world.scene.primitives[count - 1 - k]);
    Instance again = world.scene.instances[0];
    world.scene.instances.push_back(again);
    world.accel.reset();
    world.geometry = std::make_unique<Geometry>(
        world.scene, RasterCamera(world.scene.camera, world.scene.options), world.errors);
    world.accel = std::make_unique<Accel>(*world.geometry);
  };
  World large(1 << 18);
  build(large);
  constexpr uint32_t kRays = 4000;
  std::vector<Ray> rays;
  for (uint32_t k = 0; k < kRays; ++k) rays.push_back(large.ray(k));
  std::vector<Hit> expected(kRays), met(kRays);
  large.accel->intersect(rays, expected);
  World small(static_cast<int>(large.geometry->tessellations().peak() / 1024 / 4));
  build(small);
  for (uint32_t k = 0; k < kRays && !small.geometry->tessellations().isTight(); ++k)
    small.accel->intersect(rays[k]);
  ASSERT_TRUE(small.geometry->tessellations().isTight());
  small.accel->intersect(rays, met);
  for (uint32_t k = 0; k < kRays; ++k) ASSERT_TRUE(met[k] == expected[k]) << k;
}

/// f(0) ... f(n - 1) on four threads. (Plain threads: ThreadSanitizer knows when they begin and end.)
template <typename F>
void onThreads(uint32_t n, const F& f) {
  std::vector<std::thread> threads;
  for (uint32_t t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      for (uint32_t k = t; k < n; k += 4) f(k);
    });
  for (std::thread& thread : threads) thread.join();
}

TEST(Units, ThreadsMeetTheSame) {
  constexpr uint32_t kRays = 400;
  const World large(1 << 18);
  const World small(100);
  std::vector<Hit> expected(kRays), met(kRays), packets(kRays);
  std::vector<Ray> rays;
  for (uint32_t k = 0; k < kRays; ++k) rays.push_back(large.ray(k));
  onThreads(kRays, [&](uint32_t k) { expected[k] = large.accel->intersect(rays[k]); });
  onThreads(kRays, [&](uint32_t k) { met[k] = small.accel->intersect(rays[k]); });
  onThreads(kRays / 50, [&](uint32_t k) {
    small.accel->intersectMany(std::span(rays).subspan(k * 50, 50), std::span(packets).subspan(k * 50, 50));
  });
  for (uint32_t k = 0; k < kRays; ++k) {
    ASSERT_TRUE(met[k] == expected[k]) << k;
    ASSERT_EQ(packets[k].placement, expected[k].placement) << k;
  }
}

}  // namespace
}  // namespace patina
