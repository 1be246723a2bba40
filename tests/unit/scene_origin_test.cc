// SPDX-License-Identifier: Apache-2.0
// The origin of the space that is rendered in.
#include "renderer/scene/origin.h"

#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "tests/unit/scene_fixture.h"

namespace patina {
namespace {

/// Two spheres and a triangle around (far, 0, 0), the camera 5 before it.
std::string world(double far, const std::string& more = "") {
  const std::string x = std::to_string(far);
  return "Translate 0 0 5 Translate -" + x + " 0 0 WorldBegin LightSource \"pointlight\" 1 \"from\" [" + x +
         " 3 0]\nTransformBegin Translate " + x +
         " 0 0 Sphere 1 -1 1 360 Translate 1 2 3 CoordinateSystem \"there\" Sphere 1 -1 1 360 TransformEnd\n"
         "Polygon \"P\" [" +
         x + " 0 0 " + x + " 1 0 " + x + " 0 1]\n" + more + "WorldEnd";
}

TEST(Origin, StaysWhereTheSceneIsAroundIt) {
  EXPECT_FALSE(betterOrigin(buildClean(world(0)).world()));
  EXPECT_FALSE(betterOrigin(buildClean(world(10)).world()));
  EXPECT_FALSE(betterOrigin(buildClean(world(100000, "Sphere 1 -1 1 360\n")).world()));
  EXPECT_FALSE(betterOrigin(buildClean("WorldBegin WorldEnd").world()));
}

TEST(Origin, IsMovedToTheMiddleOfWhatIsFarAway) {
  const auto origin = betterOrigin(buildClean(world(100000)).world());
  ASSERT_TRUE(origin);
  EXPECT_NEAR(origin->x, 100000.5, 1e-9);
  EXPECT_NEAR(origin->y, 1, 1e-9);
  EXPECT_NEAR(origin->z, 1.5, 1e-9);
}

TEST(Origin, StaysWhereSomethingIsUnderAMovingTransformation) {
  const std::string moving =
      "MotionBegin [0 1] Translate 100000 0 0 Translate 100001 0 0 MotionEnd Sphere 1 -1 1 360\n";
  EXPECT_FALSE(betterOrigin(buildClean("Shutter 0 1 " + world(100000, moving)).world()));
}

TEST(Origin, MovesAllButWhatTheCameraSees) {
  Built built = buildClean(world(100000));
  Scene& scene = built.worlds[0];
  const Scene before = scene;
  const V3d origin(100000, -7, 3);
  moveOrigin(scene, origin);
  for (size_t k = 0; k < scene.primitives.size(); ++k)
    expectMatrix(scene.primitives[k].objectToWorld * scene.camera.worldToCamera,
                 before.primitives[k].objectToWorld * before.camera.worldToCamera);
  for (size_t k = 0; k < scene.shaders.size(); ++k)
    expectMatrix(scene.shaders[k].shaderToWorld * scene.camera.worldToCamera,
                 before.shaders[k].shaderToWorld * before.camera.worldToCamera);
  for (const char* system : {"camera", "world", "there"})
    expectMatrix(scene.coordinateSystems.at(system) * scene.camera.worldToCamera,
                 before.coordinateSystems.at(system) * before.camera.worldToCamera);
  expectMatrix(scene.coordinateSystems.at("camera") * scene.camera.worldToCamera, M44d());
  EXPECT_EQ(V3d(0, 0, 0) * scene.primitives[0].objectToWorld, V3d(0, 7, -3));
}

TEST(Origin, IsThatOfDelayedArchivesToo) {
  const auto file =
      std::filesystem::temp_directory_path() / ("patina_origin_" + std::to_string(getpid()) + ".rib");
  std::ofstream(file)
      << "Sphere 1 -1 1 360 AttributeBegin Identity Sphere 2 -2 2 360 AttributeEnd\n"
         "AttributeBegin Transform [1 0 0 0 0 1 0 0 0 0 1 0 8 0 0 1] Sphere 2 -2 2 360 AttributeEnd\n"
         "AttributeBegin CoordSysTransform \"world\" Sphere 2 -2 2 360 AttributeEnd\n"
         "ObjectBegin 1 Identity Sphere 3 -3 3 360 ObjectEnd\n";
  ErrorHandler errors([](Severity, std::string_view message) { ADD_FAILURE() << message; });
  SceneBuilder builder({}, errors, [&](Scene& scene) {
    ASSERT_EQ(scene.delayed.size(), 1u);
    moveOrigin(scene, {1000, 0, 0});
    const auto inner = scene.readDelayed(scene.delayed[0], errors);
    ASSERT_TRUE(inner);
    ASSERT_EQ(inner->primitives.size(), 4u);
    const double expected[] = {20, -1000, -992, -1000};
    for (size_t k = 0; k < 4; ++k) EXPECT_EQ(inner->primitives[k].objectToWorld[3][0], expected[k]) << k;
    ASSERT_EQ(inner->objects.size(), 1u);
    EXPECT_EQ(inner->objects[0].primitives.at(0).objectToWorld[3][0], 0);
  });
  builder.readText("WorldBegin Translate 1020 0 0 Procedural \"DelayedReadArchive\" [\"" + file.string() +
                       "\"] [-3 3 -3 3 -3 3] WorldEnd",
                   "t.rib");
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace patina
