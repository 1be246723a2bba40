// SPDX-License-Identifier: Apache-2.0
// arealight: its texture, focus and cone against their formulas, and the irradiance of spheres, discs and
// rectangles against closed forms.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "renderer/accel/accel.h"
#include "renderer/base/sampling.h"
#include "renderer/shading/lights.h"
#include "tests/unit/mesh_primitive.h"
#include "tests/unit/plugins/bound_shader.h"

namespace patina::test {
namespace {

constexpr double kHalfTurn = std::numbers::pi;

Triple emitted(const BoundShader& shader, float cosine, float u = 0.5f, float v = 0.5f) {
  Batch batch = shader.batch(1);
  batch.lightIn.task = PATINA_LIGHT_EMIT;
  batch.lightIn.P = batch.uniform({0, 0, 0});
  batch.lightIn.N = batch.uniform({0, 0, 1});
  batch.lightIn.direction = batch.uniform({std::sqrt(1 - cosine * cosine), 0, cosine});
  batch.lightIn.u = batch.uniform(u), batch.lightIn.v = batch.uniform(v);
  PatinaLightOut out = batch.lightOut();
  EXPECT_EQ(shader->light(batch.lightIn, out), PATINA_OK);
  return get(out.radiance, 0);
}

TEST(AreaLight, FocusAndCone) {
  const BoundShader focused("arealight", {number("intensity", 4), number("focus", 3)});
  EXPECT_NEAR(emitted(focused, 1)[0], 4, 1e-5);
  EXPECT_NEAR(emitted(focused, 0.8f)[0], 4 * std::pow(0.8, 3), 1e-5);
  EXPECT_EQ(emitted(focused, -0.8f)[0], 0);
  const BoundShader cone("arealight", {number("coneangle", 1), number("conedeltaangle", 0.4f)});
  const double edge = std::cos(1.0), full = std::cos(0.6);
  for (const double cosine : {0.9, 0.75, 0.6, 0.5}) {
    const double t = std::clamp((cosine - edge) / (full - edge), 0.0, 1.0);
    EXPECT_NEAR(emitted(cone, float(cosine))[0], t * t * (3 - 2 * t), 1e-5) << cosine;
  }
}

TEST(AreaLight, TextureIsByTheSurfacesParameters) {
  std::string folder = testing::TempDir() + "patina-arealight-XXXXXX";
  ASSERT_NE(mkdtemp(folder.data()), nullptr);
  std::ofstream(folder + "/slide_linear.ppm", std::ios::binary)
      << "P6 4 2 255\n"
      << std::string("\0\0\0\63\63\63\146\146\146\231\231\231\314\314\314\377\377\377\377\0\0\0\377\0", 24);
  {
    ErrorHandler errors{[](Severity, std::string_view message) { ADD_FAILURE() << message; }};
    TextureService textures({folder}, {}, size_t{16} << 20, errors);
    const BoundShader shader("arealight", {text("texturename", "slide_linear.ppm"), number("intensity", 5)},
                             M44d(), &textures);
    for (int k = 0; k < 4; ++k)  // pixels' centres; values are fifths of 255, and no sRGB by the file's name
      EXPECT_NEAR(emitted(shader, 1, (float(k) + 0.5f) / 4, 0.25f)[1], k, 1e-4) << k;
    expectNear(emitted(shader, 1, 0.625f, 0.75f), {5, 0, 0}, 1e-4f);
    expectNear(emitted(shader, 1, 0.875f, 0.75f), {0, 5, 0}, 1e-4f);
  }
  std::filesystem::remove_all(folder);
}

/// One light, bound to a primitive, at work.
struct Lamp {
  Lamp(Primitive primitive, const BoundShader& shader) {
    scene.shaders.emplace_back();
    scene.lights.push_back({0, true, true, ""});
    scene.attributes.emplace_back().areaLight = 0;
    primitive.attributes = 0;
    scene.primitives.push_back(std::move(primitive));
    scene.camera.worldToCamera.setTranslation(V3d(0, 0, 20));
    geometry = std::make_unique<Geometry>(scene, RasterCamera(scene.camera, scene.options), errors);
    accel = std::make_unique<Accel>(*geometry);  // which makes micropolygons
    const ShaderInstance* instance = &*shader;
    lights = std::make_unique<Lights>(*geometry, std::span(&instance, 1));
  }
  /// At the origin, of a surface that faces +z.
  double irradiance(uint32_t count = 1 << 14) const {
    std::vector<V3f> points(count, V3f(0, 0, 0));
    std::vector<V2f> random;
    for (uint32_t k = 0; k < count; ++k) random.push_back(sobol2(k, 3));
    std::vector<LightSample> samples(count);
    lights->sample(0, points, random, samples);
    double sum = 0;
    for (const LightSample& s : samples)
      if (s.pdf > 0) sum += double(s.radiance.x * std::max(s.direction.z, 0.0f) / s.pdf);
    return sum / count;
  }
  Scene scene;
  ErrorHandler errors{[](Severity, std::string_view message) { ADD_FAILURE() << message; }};
  std::unique_ptr<Geometry> geometry;
  std::unique_ptr<Accel> accel;
  std::unique_ptr<Lights> lights;
};

// Irradiance on the axis at distance d: of a sphere pi L (r/d)^2, of a disc pi L r^2 / (d^2 + r^2), of a
// rectangle pi L times its form factor (four corners). 2^14 Sobol points and the facets of a disc: 0.3 %.
TEST(AreaLight, ShapesGiveTheirIrradianceAndNormalizedOnesKeepTheirPower) {
  const double r = 0.8, d = 2;
  Primitive sphere, disc;
  sphere.shape = Quadric{Quadric::Kind::Sphere, {0.8f, -0.8f, 0.8f}, 360};
  disc.shape = Quadric{Quadric::Kind::Disk, {0, 0.8f}, 360};
  sphere.objectToWorld = disc.objectToWorld = M44d().setTranslation(V3d(0, 0, d));
  const Primitive rectangle = polygonPrimitive({-1, -0.5f, 2, 1, -0.5f, 2, 1, 0.5f, 2, -1, 0.5f, 2});
  const double A = 1 / d, B = 0.5 / d, a = std::hypot(1, A), b = std::hypot(1, B);
  const double formFactor = 4 / (2 * kHalfTurn) * (A / a * std::atan(B / a) + B / b * std::atan(A / b));
  struct Shape {
    const char* name;
    const Primitive& primitive;
    double irradiance, area;
  };
  for (const Shape& shape : {Shape{"sphere", sphere, kHalfTurn * r * r / (d * d), 4 * kHalfTurn * r * r},
                             Shape{"disc", disc, kHalfTurn * r * r / (d * d + r * r), kHalfTurn * r * r},
                             Shape{"rectangle", rectangle, kHalfTurn * formFactor, 2}}) {
    const BoundShader plain("arealight", {integer("sides", 2), number("intensity", 3)});
    EXPECT_NEAR(Lamp(shape.primitive, plain).irradiance(), 3 * shape.irradiance, 9e-3 * shape.irradiance)
        << shape.name;
    const BoundShader normalized("arealight",
                                 {integer("sides", 2), number("intensity", 3), integer("normalize", 1)});
    const Lamp lamp(shape.primitive, normalized);
    EXPECT_NEAR(lamp.irradiance(), 3 * shape.irradiance / shape.area, 9e-3 * shape.irradiance / shape.area)
        << shape.name;
    EXPECT_NEAR(lamp.lights->power(0), 3 * 2 * kHalfTurn, 1e-3)
        << shape.name;  // both sides of radiance 3 / area
  }
}

// Points that are drawn on a turned sphere bear RI's parameters of the sphere.
TEST(AreaLight, SamplesOfASphereKnowTheirParameters) {
  Primitive sphere;
  sphere.shape = Quadric{Quadric::Kind::Sphere, {0.8f, -0.8f, 0.8f}, 360};
  M44d turned;
  turned.setEulerAngles(V3d(0.3, -0.8, 1.1));
  sphere.objectToWorld = turned * M44d().setTranslation(V3d(1, 2, 3));
  const M44d toWorld = sphere.objectToWorld;
  const BoundShader shader("arealight");
  const Lamp lamp(sphere, shader);
  Emitters emitters;
  emitters.add(*lamp.geometry, 0);
  emitters.finish();
  for (const V3f& from : {V3f(0, 0, 0), V3f(1, 2, 9), V3f(4, -3, 3), V3f(1.1f, 2.2f, 3)})
    for (uint32_t k = 0; k < 64; ++k) {
      const EmitterSample s = emitters.sample(from, sobol2(k, 5));
      const double phi = (double(s.v) - 0.5) * kHalfTurn, theta = 2 * kHalfTurn * double(s.u);
      V3d expected;
      toWorld.multVecMatrix(V3d(0.8 * std::cos(phi) * std::cos(theta), 0.8 * std::cos(phi) * std::sin(theta),
                                0.8 * std::sin(phi)),
                            expected);
      EXPECT_LT((V3d(s.P) - expected).length(), 1e-4);
    }
}

}  // namespace
}  // namespace patina::test
