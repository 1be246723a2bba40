// SPDX-License-Identifier: Apache-2.0
// Rays against facets: sides, parameters, self-intersection, instances, sidedness, packets.
#include "renderer/accel/accel.h"

#include <gtest/gtest.h>

#include <random>

#include "renderer/base/sampling.h"
#include "renderer/scene/trim_region.h"

namespace patina {
namespace {

PrimVar pointsVariable(std::vector<float> floats) {
  PrimVar p;
  p.name = "P", p.storage = StorageClass::Vertex, p.type = ValueType::Point, p.components = 3;
  p.floats = std::move(floats);
  return p;
}

Primitive sphere(float radius, const M44d& objectToWorld) {
  Primitive p;
  Quadric q;
  q.kind = Quadric::Kind::Sphere;
  q.values = {radius, -radius, radius};
  p.shape = q;
  p.objectToWorld = objectToWorld;
  p.attributes = 0;
  return p;
}

/// A convex quad (two triangles), a triangle and a concave polygon, in the plane z = 0 with the outside
/// towards -z or +z.
Primitive polygons(const M44d& objectToWorld) {
  Primitive p;
  p.shape = PolygonMesh{{1, 1, 1}, {4, 3, 4}, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10}};
  p.variables.push_back(pointsVariable({0, 0, 0, 2, 0, 0, 2, 1, 0, 0, 1, 0,  //
                                        3, 0, 0, 5, 0, 0, 3, 2, 0,           //
                                        6, 0, 0, 8, 1, 0, 6, 2, 0, 7, 1, 0}));
  p.objectToWorld = objectToWorld;
  p.attributes = 0;
  return p;
}

struct Fixture {
  Scene scene;
  std::vector<std::string> messages;
  ErrorHandler errors{[this](Severity, std::string_view text) { messages.emplace_back(text); }};
  std::unique_ptr<Geometry> geometry;
  std::unique_ptr<Accel> accel;

  Fixture() {
    scene.attributes.emplace_back();
    scene.camera.worldToCamera.setTranslation(V3d(0, 0, 20));
  }
  void build() {
    geometry = std::make_unique<Geometry>(scene, RasterCamera(scene.camera, scene.options), errors);
    accel = std::make_unique<Accel>(*geometry);
  }
  /// Random rays at the bound of the scene; each hit is handed to `check`.
  template <class Check>
  int shoot(int count, Check check) {
    const V3f center = (geometry->bound().min + geometry->bound().max) * 0.5f;
    const float radius = (geometry->bound().max - center).length();
    int hits = 0;
    for (int k = 0; k < count; ++k) {
      const V2f a = sobol2(static_cast<uint32_t>(k), 1), b = sobol2(static_cast<uint32_t>(k), 2);
      const auto onSphere = [&](const V2f& u) {
        const float z = 1 - 2 * u.x, r = std::sqrt(std::max(0.0f, 1 - z * z));
        return V3f(r * std::cos(2 * kPi * u.y), r * std::sin(2 * kPi * u.y), z);
      };
      const V3f origin = center + onSphere(a) * (2 * radius), target = center + onSphere(b) * (0.7f * radius);
      const Ray ray{origin, (target - origin).normalized(), 0, kInfinity, kCameraRay};
      const Hit hit = accel->intersect(ray);
      if (hit.valid()) ++hits, check(ray, hit);
    }
    return hits;
  }
};

M44d tilted(double scaleX) {
  M44d scale, rotate, translate;
  scale.setScale(Imath::V3d(scaleX, 1.5, 0.7));
  rotate.setAxisAngle(Imath::V3d(1, 2, 3).normalized(), 0.8);
  translate.setTranslation(Imath::V3d(100, -50, 30));
  return scale * rotate * translate;
}

/// What must hold at every hit: the facet's point lies on the ray, the side agrees with the facet's normal,
/// and rays that leave the facet do not meet it again.
void expectConsistent(Fixture& f, const Ray& ray, const Hit& hit) {
  const Facet facet = f.geometry->facet(hit.placement, hit.face, hit.u, hit.v);
  const V3f onRay = ray.origin + ray.direction * hit.t;
  // The distance along the ray is less exact than the point, at grazing angles more so.
  const float cosine = std::abs(facet.N.dot(ray.direction));
  ASSERT_LT((facet.P - onRay).length() * cosine, 64 * kMachineEpsilon * (maxAbsComponent(ray.origin) + hit.t))
      << hit.placement;
  if (cosine > 1e-3f) {
    ASSERT_EQ(hit.front, facet.N.dot(ray.direction) <= 0);
  }
  for (const V3f& direction : {facet.N, -facet.N}) {
    // Straight out and nearly tangential.
    const Frame frame(direction);
    for (const V3f& local : {V3f(0, 0, 1), V3f(0.999f, 0, 0.0447f), V3f(0, -0.99999f, 0.0045f)}) {
      const V3f d = frame.toWorld(local);
      const Hit again = f.accel->intersect({leave(facet, d), d, 0, kInfinity, kDiffuseRay});
      if (again.valid() && again.placement == hit.placement && again.face == hit.face &&
          !f.geometry->isTessellated(f.geometry->placements()[hit.placement].traced))
        FAIL() << "flat face met by its own ray at t = " << again.t;
    }
  }
}

/// A square in z = 0 over [0, 2]^2, of NURBS of order 2 (flat) or 3 (a grid), trimmed by a square loop whose
/// corners are a quarter and three quarters of it.
Primitive trimmedSquare(int order, bool keepInside) {
  TrimCurve loop;
  loop.spline = {5, 2, {0, 0, 1, 2, 3, 4, 4}, 0, 4};
  loop.u = {0.25f, 0.75f, 0.75f, 0.25f, 0.25f};
  loop.v = {0.25f, 0.25f, 0.75f, 0.75f, 0.25f};
  loop.w = {1, 1, 1, 1, 1};
  SplineKnots spline{order, order, std::vector<float>(static_cast<size_t>(2 * order), 1.0f), 0, 1};
  std::fill_n(spline.knots.begin(), order, 0.0f);
  std::vector<float> P;
  for (int j = 0; j < order; ++j)
    for (int i = 0; i < order; ++i)
      P.insert(P.end(), {2 * static_cast<float>(i) / static_cast<float>(order - 1),
                         2 * static_cast<float>(j) / static_cast<float>(order - 1), 0});
  Primitive p;
  p.shape = NurbsPatch{spline, spline,
                       std::make_shared<const TrimRegion>(std::vector<TrimLoop>{TrimLoop{loop}}), keepInside};
  p.variables.push_back(pointsVariable(P));
  p.attributes = 0;
  return p;
}

TEST(Accel, RaysPassThroughHoles) {
  for (const int order : {2, 3})
    for (const bool keepInside : {false, true})
      for (const bool oneSided : {false, true}) {
        Fixture f;
        f.scene.attributes[0].oneSided = oneSided;
        f.scene.primitives.push_back(trimmedSquare(order, keepInside));
        f.build();
        ASSERT_EQ(f.geometry->isTessellated(0), order != 2);
        std::vector<Ray> rays;
        for (int j = 0; j < 40; ++j)
          for (int i = 0; i < 40; ++i)
            rays.push_back({V3f(0.025f + 0.05f * static_cast<float>(i),
                                0.025f + 0.05f * static_cast<float>(j), j % 2 ? 3.0f : -3.0f),
                            V3f(0, 0, j % 2 ? -1.0f : 1.0f), 0, kInfinity, kCameraRay});
        std::vector<Hit> many(rays.size());
        f.accel->intersectMany(rays, many);
        for (size_t k = 0; k < rays.size(); ++k) {
          const V3f& o = rays[k].origin;
          const bool inLoop = o.x > 0.5f && o.x < 1.5f && o.y > 0.5f && o.y < 1.5f;
          // The outside is the side of +z: dPdu x dPdv.
          const bool met = inLoop == keepInside && (!oneSided || o.z > 0);
          ASSERT_EQ(f.accel->intersect(rays[k]).valid(), met) << o << order << keepInside << oneSided;
          ASSERT_EQ(f.accel->occluded(rays[k]), met);
          ASSERT_EQ(many[k].valid(), met);
        }
      }
}

/// A square of edge 2 * `half` around the origin, in z = 0.
Primitive square(float half, const M44d& objectToWorld) {
  Primitive p;
  p.shape = PolygonMesh{{1}, {4}, {0, 1, 2, 3}};
  p.variables.push_back(pointsVariable({-half, -half, 0, half, -half, 0, half, half, 0, -half, half, 0}));
  p.objectToWorld = objectToWorld;
  p.attributes = 0;
  return p;
}

TEST(Accel, BeadsOnWidePlanesAreMetBelow) {
  // The plane is wide, but its height is exact: rays that leave it start next to it, not above the bead.
  constexpr float kBead = 1e-3f;
  Fixture f;
  M44d onTop;
  onTop.setTranslation(V3d(0.01, 0, kBead));
  f.scene.primitives = {square(500, M44d()), sphere(kBead, onTop)};
  f.build();
  for (const float height : {2e-4f, 5e-4f, 1e-3f}) {
    const V3f target(0.01f, 0, height), from(0.0037f, 0.0021f, 0);
    const Hit floor = f.accel->intersect({from + V3f(0, 0, 1), V3f(0, 0, -1), 0, kInfinity, kCameraRay});
    ASSERT_TRUE(floor.valid());
    const Facet facet = f.geometry->facet(floor.placement, floor.face, floor.u, floor.v);
    EXPECT_LT(facet.error, 1e-5f);
    const V3f d = (target - from).normalized();
    const Hit hit = f.accel->intersect({leave(facet, d), d, 0, kInfinity, kDiffuseRay});
    ASSERT_TRUE(hit.valid()) << height;
    EXPECT_NE(hit.placement, floor.placement) << height;
    EXPECT_LT(hit.t, 0.02f);
  }
}

TEST(Accel, RaysThatLeaveSquaresOfAnySizeAndPlaceDoNotMeetThem) {
  int hits = 0;
  for (const float half : {1e-3f, 1.0f, 500.0f, 1e6f})
    for (const V3d& axis : {V3d(0, 0, 1), V3d(1, 0, 0), V3d(1, 2, 3), V3d(1e-4, 0, 1)})
      for (const double angle : {0.0, kPi / 2.0, 0.3, 1e-5})
        for (const double away : {0.0, 0.1, 1234.567}) {
          Fixture f;
          M44d rotate, translate;
          rotate.setAxisAngle(axis.normalized(), angle);
          translate.setTranslation(V3d(0.3, -0.7, 1.1) * away);
          f.scene.primitives.push_back(square(half, rotate * translate));
          f.build();
          hits += f.shoot(200, [&](const Ray& ray, const Hit& hit) { expectConsistent(f, ray, hit); });
        }
  EXPECT_GT(hits, 5000);
}

TEST(Accel, FlatFacesUnderAllTransformations) {
  for (const double scaleX : {2.0, -2.0}) {
    Fixture f;
    f.scene.primitives.push_back(polygons(tilted(scaleX)));
    f.build();
    EXPECT_GT(f.shoot(20000, [&](const Ray& ray, const Hit& hit) { expectConsistent(f, ray, hit); }), 500);
  }
}

TEST(Accel, CurvedFacetsUnderAllTransformations) {
  for (const double scaleX : {2.0, -2.0}) {
    Fixture f;
    f.scene.primitives.push_back(sphere(1.5f, tilted(scaleX)));
    f.build();
    int fronts = 0;
    const int hits = f.shoot(5000, [&](const Ray& ray, const Hit& hit) {
      expectConsistent(f, ray, hit);
      fronts += hit.front;
    });
    EXPECT_GT(hits, 500);
    EXPECT_EQ(fronts, hits) << "a sphere shows its outside to who is outside";
  }
}

TEST(Accel, ParametersAreThoseOfThePointAlongStraightSidesToo) {
  // The sides of a twisted patch are straight, so that they have one facet where its inside has many.
  Primitive leaf;
  const SplineKnots linear{2, 2, {0, 0, 1, 1}, 0, 1};
  leaf.shape = NurbsPatch{linear, linear, nullptr, false};
  leaf.variables.push_back(pointsVariable({-0.5f, 0, 0, 0.5f, 0, 0, -0.5f, 1, -0.4f, 0.5f, 1, 0.4f}));
  leaf.objectToWorld = tilted(2);
  leaf.attributes = 0;
  Fixture f;
  f.scene.primitives.push_back(leaf);
  f.scene.camera.worldToCamera.setTranslation(V3d(-100, 50, -28));
  f.build();
  const Surface& surface = f.geometry->surface(f.geometry->placements()[0]);
  const M44f toWorld(leaf.objectToWorld);
  double worst = 0;
  const int hits = f.shoot(20000, [&](const Ray& ray, const Hit& hit) {
    const V3f met = ray.origin + ray.direction * hit.t;
    const Facet facet = f.geometry->facet(hit.placement, hit.face, hit.u, hit.v);
    const V3f exact = transformPoint(surface.evaluate(hit.face, hit.u, hit.v).P, toWorld);
    worst = std::max({worst, double{(met - exact).length()}, double{(facet.P - exact).length()}});
  });
  EXPECT_GT(hits, 500);
  EXPECT_LT(worst, 0.01);
}

TEST(Accel, InstancesMeetTheirPrimitivesAtTheirPlace) {
  Fixture f;
  f.scene.objects.emplace_back();
  M44d small;
  small.setScale(Imath::V3d(0.5, -0.5, 0.5));  // mirrored within the object, too
  f.scene.objects[0].primitives.push_back(polygons(M44d()));
  f.scene.objects[0].primitives.push_back(sphere(1, small));
  for (const double scaleX : {1.0, -1.0}) {
    Instance instance;
    instance.object = 0, instance.attributes = 0;
    instance.objectToWorld = tilted(scaleX) * M44d().setTranslation(Imath::V3d(20 * scaleX, 0, 0));
    f.scene.instances.push_back(instance);
  }
  f.build();
  std::array<int, 4> met{};
  f.shoot(40000, [&](const Ray& ray, const Hit& hit) {
    expectConsistent(f, ray, hit);
    ++met[hit.placement];
  });
  for (const int count : met) EXPECT_GT(count, 10);
}

TEST(Accel, OneSidedSurfacesAreMetFromOutsideOnly) {
  Fixture f;
  f.scene.attributes[0].oneSided = true;
  f.scene.primitives.push_back(sphere(1, M44d()));
  f.build();
  const Ray inside{{0, 0, 0}, {0.6f, 0, 0.8f}, 0, kInfinity, kCameraRay};
  EXPECT_FALSE(f.accel->intersect(inside).valid());
  EXPECT_FALSE(f.accel->occluded(inside));
  EXPECT_TRUE(f.accel->intersect({{0, 0.1f, -5}, {0, 0, 1}, 0, kInfinity, kCameraRay}).valid());
}

TEST(Accel, VisibilityHidesFromKindsOfRays) {
  Fixture f;
  f.scene.attributes[0].visibility = kDiffuseRay;
  f.scene.primitives.push_back(sphere(1, M44d()));
  f.build();
  Ray ray{{0, 0.1f, -5}, {0, 0, 1}, 0, kInfinity, kCameraRay};
  EXPECT_FALSE(f.accel->intersect(ray).valid());
  ray.mask = kDiffuseRay;
  EXPECT_TRUE(f.accel->intersect(ray).valid());
}

TEST(Accel, PacketsAndSingleRaysAgree) {
  Fixture f;
  f.scene.primitives.push_back(sphere(1, M44d()));
  f.scene.primitives.push_back(polygons(M44d().setTranslation(Imath::V3d(-4, 0.5, 0.3))));
  f.build();
  std::vector<Ray> rays;
  for (uint32_t k = 0; k < 1003; ++k) {
    const V2f u = sobol2(k, 5);
    rays.push_back({{u.x * 10 - 5, u.y * 4 - 2, -5}, {0, 0, 1}, 0, kInfinity, kCameraRay});
  }
  std::vector<Hit> hits(rays.size());
  f.accel->intersectMany(rays, hits);
  int different = 0;
  for (size_t k = 0; k < rays.size(); ++k) {
    const Hit one = f.accel->intersect(rays[k]);
    EXPECT_EQ(one.placement, hits[k].placement);
    different += one.face != hits[k].face || std::abs(one.t - hits[k].t) > 1e-5f;
  }
  EXPECT_LE(different, 2) << "kernels may differ on an edge";
}

}  // namespace
}  // namespace patina
