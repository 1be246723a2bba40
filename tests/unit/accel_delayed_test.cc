// SPDX-License-Identifier: Apache-2.0
// Delayed archives under rays: read once when met, the same hits as if they had always been there.
#include <gtest/gtest.h>

#include <atomic>
#include <random>
#include <thread>

#include "renderer/accel/accel.h"

namespace patina {
namespace {

Primitive primitive(const V3d& center, bool flat) {
  Primitive p;
  if (flat) {
    ParametricMesh mesh;
    PrimVar points;
    points.name = "P", points.storage = StorageClass::Vertex, points.type = ValueType::Point;
    points.components = 3;
    points.floats = {-1, -1, 0, 1, -1, 0, -1, 1, 0, 1, 1, 0};
    p.shape = mesh;
    p.variables = {points};
  } else {
    Quadric q;
    q.kind = Quadric::Kind::Sphere;
    q.values = {1, -1, 1};
    p.shape = q;
  }
  p.objectToWorld.setTranslation(center);
  p.attributes = 0;
  return p;
}

V3d centerOf(int k) { return V3d(4.0 * (k % 10) - 18, 4.0 * (k / 10) - 18, 0); }

/// What stands at place k: a sphere, a square behind it, and an instance of both behind these.
void fill(Scene& scene, int k) {
  scene.primitives.push_back(primitive(centerOf(k), false));
  scene.primitives.push_back(primitive(centerOf(k) + V3d(1, 0, 1.5), true));
  ObjectDefinition object;
  object.primitives = {primitive(V3d(0, 0, 0), false), primitive(V3d(1, 0, 1.5), true)};
  scene.objects.push_back(object);
  Instance instance;
  instance.object = scene.firstObject + static_cast<uint32_t>(scene.objects.size() - 1);
  instance.attributes = 0;
  instance.objectToWorld.setTranslation(centerOf(k) + V3d(0, 1, 3));
  scene.instances.push_back(instance);
}

DelayedArchive request(int k, const Box3f& bound) {
  DelayedArchive archive;
  archive.file = std::to_string(k);
  archive.bound = bound;
  archive.objectToWorld.setTranslation(centerOf(k));
  return archive;
}

const Box3f kBound({-1, -1, -1}, {2, 2, 4.5f});

/// 100 places: all from the beginning, or each a delayed archive. Odd ones hold an archive that holds it.
struct Field {
  Scene scene;
  std::vector<std::string> messages;
  ErrorHandler errors{[this](Severity, std::string_view text) { messages.emplace_back(text); }};
  std::array<std::atomic<int>, 100> reads{};
  std::unique_ptr<Geometry> geometry;
  std::unique_ptr<Accel> accel;

  std::shared_ptr<const Scene> read(const Scene& around, int k, bool nested) {
    auto inner = std::make_shared<Scene>();
    inner->firstObject = around.firstObject + static_cast<uint32_t>(around.objects.size());
    inner->attributes.emplace_back();
    if (!nested) {
      ++reads[static_cast<size_t>(k)];
      fill(*inner, k);
    } else {
      inner->delayed = {request(k, kBound)};
      inner->readDelayed = [this, of = inner.get(), k](const DelayedArchive&, ErrorHandler&) {
        return read(*of, k, false);
      };
    }
    return inner;
  }
  explicit Field(bool delayed, const Box3f& bound = kBound) {
    scene.attributes.emplace_back();
    scene.camera.worldToCamera.setTranslation(V3d(0, 0, 60));
    for (int k = 0; k < 100; ++k)
      if (delayed)
        scene.delayed.push_back(request(k, bound));
      else
        fill(scene, k);
    scene.readDelayed = [this](const DelayedArchive& archive, ErrorHandler&) {
      const int k = std::stoi(archive.file);
      return read(scene, k, k % 2 == 1);
    };
    geometry = std::make_unique<Geometry>(scene, RasterCamera(scene.camera, scene.options), errors);
    accel = std::make_unique<Accel>(*geometry);
  }
  Ray ray(uint32_t k) const {
    std::mt19937 random(k);
    std::uniform_real_distribution<float> uniform(-1, 1);
    const V3f origin(25 * uniform(random), 25 * uniform(random), -8);
    const V3f target(20 * uniform(random), 20 * uniform(random), 2 + 4 * uniform(random));
    return {origin, (target - origin).normalized(), 0, kInfinity, kDiffuseRay};
  }
  int readsInAll() const {
    int sum = 0;
    for (const auto& n : reads) sum += n;
    return sum;
  }
};

/// Tables are in another order: hits are told apart by what they say of the surface.
void expectSame(const Field& a, const Hit& x, const Field& b, const Hit& y, uint32_t ray) {
  ASSERT_EQ(x.valid(), y.valid()) << ray;
  if (!x.valid()) return;
  ASSERT_EQ(x.t, y.t) << ray;
  ASSERT_TRUE(x.u == y.u && x.v == y.v && x.face == y.face && x.front == y.front) << ray;
  const Placement &p = a.geometry->placements()[x.placement], &q = b.geometry->placements()[y.placement];
  ASSERT_EQ(p.objectToWorld, q.objectToWorld) << ray;
  ASSERT_EQ(p.instance == kNone, q.instance == kNone) << ray;
  const Facet f = a.geometry->facet(x.placement, x.face, x.u, x.v),
              g = b.geometry->facet(y.placement, y.face, y.u, y.v);
  ASSERT_TRUE(f.P == g.P && f.N == g.N && f.error == g.error) << ray;
}

template <typename F>
void onThreads(uint32_t n, const F& f) {
  std::vector<std::thread> threads;
  for (uint32_t t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      for (uint32_t k = t; k < n; k += 4) f(k);
    });
  for (std::thread& thread : threads) thread.join();
}

TEST(DelayedAccel, OnlyWhatRaysMeetIsRead) {
  Field field(true);
  EXPECT_EQ(field.geometry->placements().size(), 0u);
  EXPECT_FALSE(field.accel->intersect({V3f(0, 0, -8), V3f(0, 0, -1), 0, kInfinity, kCameraRay}).valid());
  // Between the bounds of the first two places, which end at -16 and begin at -15.
  EXPECT_FALSE(field.accel->occluded({V3f(-15.5f, -18, -8), V3f(0, 0, 1), 0, kInfinity, kCameraRay}));
  EXPECT_EQ(field.readsInAll(), 0);
  // Another thing in front of a bound: t ends before it.
  EXPECT_FALSE(field.accel->occluded({V3f(-18, -18, -8), V3f(0, 0, 1), 0, 5, kCameraRay}));
  EXPECT_EQ(field.readsInAll(), 0);
  EXPECT_FLOAT_EQ(field.accel->intersect({V3f(-18, -18, -8), V3f(0, 0, 1), 0, kInfinity, kCameraRay}).t, 7);
  EXPECT_EQ(field.readsInAll(), 1);
  EXPECT_EQ(field.reads[0], 1);
  EXPECT_TRUE(field.messages.empty());
}

TEST(DelayedAccel, HitsAreThoseOfWhatIsThereFromTheBeginning) {
  constexpr uint32_t kRays = 3000;
  const Field whole(false);
  Field delayed(true);
  std::vector<Ray> rays;
  std::vector<Hit> packets(kRays);
  uint32_t hits = 0;
  for (uint32_t k = 0; k < kRays; ++k) {
    rays.push_back(whole.ray(k));
    const Hit expected = whole.accel->intersect(rays[k]);
    hits += expected.valid();
    expectSame(whole, expected, delayed, delayed.accel->intersect(rays[k]), k);
    ASSERT_EQ(delayed.accel->occluded(rays[k]), expected.valid()) << k;
  }
  EXPECT_GT(hits, 1000u);
  EXPECT_EQ(delayed.readsInAll(), 100);
  delayed.accel->intersectMany(rays, packets);
  for (uint32_t k = 0; k < kRays; ++k)
    expectSame(whole, whole.accel->intersect(rays[k]), delayed, packets[k], k);
}

TEST(DelayedAccel, ThreadsThatMeetOneAtATimeReadItOnce) {
  constexpr uint32_t kRays = 400;
  const Field whole(false);
  for (const bool packets : {false, true}) {
    Field delayed(true);
    std::vector<Ray> rays;
    std::vector<Hit> met(kRays);
    for (uint32_t k = 0; k < kRays; ++k) rays.push_back(whole.ray(packets ? k : k / 4));
    if (packets)
      onThreads(kRays / 20, [&](uint32_t k) {
        delayed.accel->intersectMany(std::span(rays).subspan(k * 20, 20), std::span(met).subspan(k * 20, 20));
      });
    else
      onThreads(kRays, [&](uint32_t k) { met[k] = delayed.accel->intersect(rays[k]); });
    for (uint32_t k = 0; k < kRays; ++k)
      expectSame(whole, whole.accel->intersect(rays[k]), delayed, met[k], k);
    for (const auto& n : delayed.reads) EXPECT_LE(n, 1);
  }
}

TEST(DelayedAccel, SeedsDoNotDependOnTheOrder) {
  Field up(true), down(true);
  const auto meet = [](Field& field, int k) {
    const V3d c = centerOf(k);
    return field.geometry
        ->placements()[field.accel
                           ->intersect({V3f(static_cast<float>(c.x), static_cast<float>(c.y), -8),
                                        V3f(0, 0, 1), 0, kInfinity, kCameraRay})
                           .placement]
        .seed;
  };
  std::map<uint64_t, int> seeds;
  std::vector<uint64_t> first(100);
  for (int k = 0; k < 100; ++k) ++seeds[first[static_cast<size_t>(k)] = meet(up, k)];
  for (int k = 99; k >= 0; --k) EXPECT_EQ(meet(down, k), first[static_cast<size_t>(k)]) << k;
  EXPECT_EQ(seeds.size(), 100u);
}

TEST(DelayedAccel, WhatSticksOutOfTheBoundIsNeverSeen) {
  // Half of the first sphere, as far as x = 0; that it is more is said once.
  Field field(true, Box3f({-1, -1, -1}, {0, 2, 4.5f}));
  const auto t = [&](float x) {
    return field.accel->intersect({V3f(x - 18, -18, -8), V3f(0, 0, 1), 0, kInfinity, kCameraRay}).t;
  };
  EXPECT_NEAR(t(-0.01f), 8 - std::sqrt(1 - 0.0001f), 2e-3f);  // facets
  EXPECT_EQ(t(0.1f), kInfinity);
  // Along x the sphere begins at 1, out of the bound: its other side is what is met.
  EXPECT_NEAR(field.accel->intersect({V3f(-16.5f, -18, 0), V3f(-1, 0, 0), 0, kInfinity, kCameraRay}).t, 2.5f,
              2e-3f);
  ASSERT_EQ(field.messages.size(), 1u);
  EXPECT_NE(field.messages[0].find(
                "warning: range: delayed archive \"0\" reaches out of its bound [-1 0 -1 2 -1 4.5]: it fills "
                "[-1 2 -1 2 -1 4.5], and what sticks out is not seen"),
            std::string::npos)
      << field.messages[0];
}

TEST(DelayedAccel, WhatThrowsIsLeftOut) {
  Field field(true);
  field.scene.readDelayed = [](const DelayedArchive&, ErrorHandler&) -> std::shared_ptr<const Scene> {
    throw std::bad_alloc();
  };
  EXPECT_FALSE(field.accel->intersect({V3f(-18, -18, -8), V3f(0, 0, 1), 0, kInfinity, kCameraRay}).valid());
  ASSERT_EQ(field.messages.size(), 1u);
  EXPECT_NE(field.messages[0].find("error: outofmemory: delayed archive \"0\" is left out: "),
            std::string::npos);
}

}  // namespace
}  // namespace patina
