// SPDX-License-Identifier: Apache-2.0
// Area lights as things to sample, against closed forms of the irradiance they give.
#include "renderer/shading/emitters.h"

#include <gtest/gtest.h>

#include "mesh_primitive.h"
#include "renderer/base/sampling.h"

namespace patina {
namespace {

struct Fixture {
  Scene scene;
  ErrorHandler errors{[](Severity, std::string_view) {}};
  std::unique_ptr<Geometry> geometry;
  Emitters emitters;

  void build(Primitive primitive) {
    scene.attributes.emplace_back();
    primitive.attributes = 0;
    scene.primitives.push_back(std::move(primitive));
    scene.camera.worldToCamera.setTranslation(V3d(0, 0, 20));
    geometry = std::make_unique<Geometry>(scene, RasterCamera(scene.camera, scene.options), errors);
    emitters.add(*geometry, 0);
    emitters.finish();
  }
  /// Irradiance at `from` with normal `normal` under unit radiance.
  double irradiance(const V3f& from, const V3f& normal, uint32_t samples = 1 << 14) const {
    double sum = 0;
    for (uint32_t k = 0; k < samples; ++k) {
      const EmitterSample s = emitters.sample(from, sobol2(k, 3));
      if (s.pdf == 0) continue;
      const V3f d = (s.P - from).normalized();
      sum += std::max(0.0f, d.dot(normal)) / s.pdf;
    }
    return sum / samples;
  }
};

/// Irradiance under a uniform polygon by Lambert's formula: E = 1/2 sum of theta_i (Gamma_i . n).
double lambert(const std::vector<V3d>& corners, const V3d& from, const V3d& normal) {
  V3d sum(0, 0, 0);
  for (size_t k = 0; k < corners.size(); ++k) {
    const V3d a = (corners[k] - from).normalized(),
              b = (corners[(k + 1) % corners.size()] - from).normalized();
    const V3d cross = a.cross(b);
    sum += cross.normalized() * std::atan2(cross.length(), a.dot(b));
  }
  return std::abs(sum.dot(normal)) / 2;
}

TEST(Emitters, RectanglesGiveLambertsIrradianceFarAndNear) {
  Fixture f;
  f.build(polygonPrimitive({-1, -0.5f, 2, 1, -0.5f, 2, 1, 0.5f, 2, -1, 0.5f, 2}));
  const std::vector<V3d> corners{{-1, -0.5, 2}, {1, -0.5, 2}, {1, 0.5, 2}, {-1, 0.5, 2}};
  for (const V3f& from :
       {V3f(0, 0, 0), V3f(0.9f, 0.3f, 1.9f), V3f(3, 2, 0), V3f(30, 10, -80), V3f(0, 0, 1.999f)}) {
    const double expected = lambert(corners, V3d(from), {0, 0, 1});
    EXPECT_NEAR(f.irradiance(from, {0, 0, 1}), expected, 2e-3 * expected) << from;
  }
}

TEST(Emitters, TrianglesGiveLambertsIrradiance) {
  Fixture f;
  f.build(polygonPrimitive({0, 0, 2, 1, 0, 2.5f, 0, 1, 2}));
  const std::vector<V3d> corners{{0, 0, 2}, {1, 0, 2.5}, {0, 1, 2}};
  for (const V3f& from : {V3f(0.3f, 0.3f, 0), V3f(-2, 1, 0.5f)}) {
    const double expected = lambert(corners, V3d(from), {0, 0, 1});
    EXPECT_NEAR(f.irradiance(from, {0, 0, 1}), expected, 3e-3 * expected) << from;
  }
}

TEST(Emitters, SpheresGivePiTimesTheSquareOfTheirAngle) {
  Fixture f;
  Primitive sphere;
  Quadric q;
  q.values = {1, -1, 1};
  sphere.shape = q;
  sphere.objectToWorld = M44d().setTranslation(Imath::V3d(0, 0, 5));
  f.build(std::move(sphere));
  // A sphere above the horizon: E = pi sin^2(alpha), sin(alpha) = r / d. Far away, near, and almost touching.
  for (const float z : {-95.0f, 0.0f, 3.0f, 3.999f}) {
    const double d = 5 - static_cast<double>(z), expected = std::numbers::pi / (d * d);
    EXPECT_NEAR(f.irradiance({0, 0, z}, {0, 0, 1}), expected, 2e-3 * expected) << z;
  }
  // From inside, all directions see it: E = pi.
  EXPECT_NEAR(f.irradiance({0.3f, 0, 5.2f}, {0, 0, 1}), std::numbers::pi, 0.02);
}

TEST(Emitters, DensitiesOfHitsAgreeWithThoseOfSamples) {
  Fixture f;
  f.build(polygonPrimitive({-1, -0.5f, 2, 1, -0.5f, 2, 1, 0.5f, 2, -1, 0.5f, 2}));
  for (uint32_t k = 0; k < 100; ++k) {
    const V3f from(0.3f, -2, 0.5f);
    const EmitterSample s = f.emitters.sample(from, sobol2(k, 4));
    EXPECT_NEAR(f.emitters.pdf(0, 0, from, s.P, s.N), s.pdf, 1e-4f * s.pdf);
  }
}

TEST(Emitters, NoAreaNoLight) {
  Emitters none;
  none.finish();
  EXPECT_TRUE(none.empty());
  EXPECT_EQ(none.sample({0, 0, 0}, {0.5f, 0.5f}).pdf, 0);
}

}  // namespace
}  // namespace patina
