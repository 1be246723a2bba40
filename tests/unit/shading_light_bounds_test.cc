// SPDX-License-Identifier: Apache-2.0
// What lights say of themselves for the choice among them, against what they give when they are sampled.
#include "renderer/shading/light_bounds.h"

#include "renderer/shading/light_tree.h"
#include "renderer/shading/lights.h"
#include "tests/unit/chi_square.h"
#include "tests/unit/mesh_primitive.h"
#include "tests/unit/plugins/bound_shader.h"

namespace patina::test {
namespace {

Primitive polygon(std::vector<float> points, uint32_t attributes) {
  Primitive p = polygonPrimitive(std::move(points));
  p.attributes = attributes;
  return p;
}

enum : uint32_t { kPoint, kSpot, kDistant, kPanel, kTwoSided, kSphere, kTent, kSun, kCount };

/// One light of each kind.
struct Fixture {
  BoundShader point{"pointlight", {number("intensity", 2), triple("from", ValueType::Point, {1, 2, 3})}};
  BoundShader spot{"spotlight",
                   {number("intensity", 2), number("coneangle", 0.4f), number("conedeltaangle", 1e-4f),
                    number("beamdistribution", 0), triple("from", ValueType::Point, {-1, 0, 0}),
                    triple("to", ValueType::Point, {-1, 3, 3})}};
  BoundShader distant{"distantlight", {number("intensity", 2), triple("to", ValueType::Point, {0, -1, 0})}};
  BoundShader panel{"arealight", {number("intensity", 3)}};
  BoundShader twoSided{"arealight", {number("intensity", 3), integer("sides", 2)}};
  BoundShader sun{"distantlight", {number("angle", 5)}};
  std::vector<const ShaderInstance*> shaders{&*point,    &*spot,  &*distant, &*panel,
                                             &*twoSided, &*panel, &*panel,   &*sun};
  Scene scene;
  ErrorHandler errors{[](Severity, std::string_view) {}};
  std::unique_ptr<Geometry> geometry;
  std::unique_ptr<Lights> lights;

  Fixture() {
    for (uint32_t k = 0; k < kCount; ++k) {
      scene.lights.push_back({k, k == kPanel || k == kTwoSided || k == kSphere || k == kTent, true, ""});
      scene.attributes.emplace_back();
      if (scene.lights.back().isArea) scene.attributes.back().areaLight = k;
    }
    scene.primitives.push_back(polygon({0, 0, 0, .5, 0, 0, .5, .3f, 0, 0, .3f, 0}, kPanel));
    scene.primitives.push_back(polygon({2, 0, 0, 2, .5, 0, 2, 0, .5}, kTwoSided));
    Primitive sphere;
    Quadric q;
    q.values = {0.2f, -0.2f, 0.2f};
    sphere.shape = q, sphere.attributes = kSphere;
    sphere.objectToWorld = M44d().setTranslation(Imath::V3d(0, -2, 0));
    scene.primitives.push_back(sphere);
    // Two slopes of a roof: a cone of normals.
    scene.primitives.push_back(polygon({-3, 0, 0, -2, 0, 0, -2, .3f, .3f, -3, .3f, .3f}, kTent));
    scene.primitives.push_back(polygon({-3, .3f, .3f, -2, .3f, .3f, -2, 0, .6f, -3, 0, .6f}, kTent));
    scene.camera.worldToCamera.setTranslation(V3d(0, 0, 20));
    geometry = std::make_unique<Geometry>(scene, RasterCamera(scene.camera, scene.options), errors);
    lights = std::make_unique<Lights>(*geometry, shaders);
  }
  /// Irradiance from a light, without shadows; a normal of zero: of a facet that always faces it.
  double irradiance(uint32_t light, const LightReceiver& at, uint32_t samples) const {
    const std::vector<V3f> points(samples, at.P);
    std::vector<V2f> random(samples);
    for (uint32_t k = 0; k < samples; ++k) random[k] = sobol2(k, light);
    std::vector<LightSample> out(samples);
    lights->sample(light, points, random, out);
    double sum = 0;
    for (const LightSample& s : out) {
      if (s.pdf == 0) continue;
      float cosine = isBlack(at.normal) ? 1 : s.direction.dot(at.normal);
      if (at.bothSides) cosine = std::abs(cosine);
      if (cosine > 0) sum += static_cast<double>(s.radiance.x * cosine / s.pdf) / samples;
    }
    return sum;
  }
};

TEST(LightBounds, ImportanceIsTheIrradianceFromAfar) {
  const Fixture f;
  const auto expectNear = [&](uint32_t light, const V3f& at) {
    const LightReceiver point{at, {0, 0, 0}};
    const double expected = f.irradiance(light, point, 256);
    EXPECT_GT(expected, 0) << light;
    EXPECT_NEAR(LightTree::importance(f.lights->bounds(light), point), expected, 0.03 * expected) << light;
  };
  expectNear(kPoint, {4, 5, 6});
  expectNear(kSpot, {-1, 7, 7});
  expectNear(kDistant, {1, 1, 1});
  expectNear(kPanel, {1, 1, f.lights->bounds(kPanel).cone.axis.z * 20});
  expectNear(kTwoSided, {20, 0, 0});
  expectNear(kTwoSided, {-20, 0, 0});
  expectNear(kSphere, {3, 4, 10});
  expectNear(kSun, {1, 1, 1});
}

TEST(LightBounds, NothingIsLeftOut) {
  const Fixture f;
  Independent random(3);
  int unreached[kCount] = {}, reached[kCount] = {};
  for (int k = 0; k < 4000; ++k) {
    LightReceiver at;
    const float size = k % 2 ? 1.0f : 4.0f, x = random.next(), y = random.next();
    at.P = (V3f(x, y, random.next()) * 2 - V3f(1, 1, 1)) * size;
    const float z = 2 * random.next() - 1, r = std::sqrt(1 - z * z), phi = 2 * kPi * random.next();
    at.normal = {r * std::cos(phi), r * std::sin(phi), z};
    at.bothSides = k % 5 == 0;
    for (uint32_t light = 0; light < kCount; ++light) {
      const double importance = LightTree::importance(f.lights->bounds(light), at);
      if (f.irradiance(light, at, 8) > 0) {
        ++reached[light];
        ASSERT_GT(importance, 0) << "light " << light << " from " << at.P;
      } else {
        unreached[light] += importance == 0;
      }
    }
  }
  for (const uint32_t light : {kPoint, kSpot, kPanel, kTwoSided, kSphere, kTent}) {
    EXPECT_GT(reached[light], 50) << light;
    EXPECT_GT(unreached[light], 800) << light;  // bounds are of use
  }
}

TEST(LightBounds, SayWhatIsKnown) {
  const Fixture f;
  EXPECT_FALSE(f.lights->bounds(kDistant).isPlaced());
  EXPECT_FALSE(f.lights->bounds(kSun).isPlaced());
  const LightBounds spot = f.lights->bounds(kSpot), tent = f.lights->bounds(kTent);
  EXPECT_EQ(spot.box.min, V3f(-1, 0, 0));
  EXPECT_NEAR(spot.cone.spread, 0.4, 1e-6);
  // The slopes rise by 45 degrees, so that their normals stand square to each other.
  EXPECT_NEAR(tent.cone.spread, kPi / 4, 1e-4);
  EXPECT_NEAR(std::abs(tent.cone.axis.y), 1, 1e-4);
  EXPECT_NEAR(tent.box.max.z, 0.6, 1e-5);
  EXPECT_TRUE(f.lights->bounds(kTwoSided).twoSided);
}

}  // namespace
}  // namespace patina::test
