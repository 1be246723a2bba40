// SPDX-License-Identifier: Apache-2.0
// Transformations, spaces and orientation against matrices worked out by hand (RI 3.2, sections 4.6 and 4.7).
#include "renderer/scene/matrices.h"
#include "scene_fixture.h"

namespace patina {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

constexpr std::string_view kSphere = "Sphere 1 -1 1 360\n";

M44d placeOf(std::string_view requests) {
  return buildClean("WorldBegin\n" + std::string(requests) + "\n" + std::string(kSphere) + "WorldEnd\n")
      .world()
      .primitives.at(0)
      .objectToWorld;
}

TEST(Transform, NewestIsAppliedFirst) {
  // (x, y, z) -> scaled by 2 -> moved by (1, 2, 3).
  expectMatrix(placeOf("Translate 1 2 3 Scale 2 2 2"), {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 1, 2, 3, 1});
}

TEST(Transform, RotateTurnsXToYAboutZ) {
  expectMatrix(placeOf("Rotate 90 0 0 1"), {0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, 0);
  expectMatrix(placeOf("Rotate 90 2 0 0"), {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1}, 0);
  // About the diagonal, a third of a turn takes x to y to z.
  expectMatrix(placeOf("Rotate 120 1 1 1"), {0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0, 1});
}

TEST(Transform, SkewLeansTheFirstAxisByTheAngle) {
  // tan 45 = 1: y goes to (1, 1, 0).
  expectMatrix(placeOf("Skew 45 0 1 0 1 0 0"), {1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
  const Built built = build("WorldBegin\nSkew 90 0 1 0 1 0 0\nWorldEnd\n");
  EXPECT_THAT(built.messages, ElementsAre(StartsWith("t.rib:2:1: error: math: Skew: 90 degrees reach")));
}

TEST(Transform, IdentityAndTransformInsideTheWorldMeanWorldSpace) {
  const Built built = buildClean(
      "Translate 0 0 5 WorldBegin Translate 9 9 9 Identity Sphere 1 -1 1 360\n"
      "Transform [1 0 0 0 0 1 0 0 0 0 1 0 7 0 0 1] Sphere 1 -1 1 360 WorldEnd");
  expectMatrix(built.world().primitives[0].objectToWorld, M44d(), 0);
  expectMatrix(built.world().primitives[1].objectToWorld, translation(7, 0, 0), 0);
  expectMatrix(built.world().camera.worldToCamera, translation(0, 0, 5), 0);
}

TEST(Transform, SingularMatricesAreRefused) {
  const Built built = build(
      "WorldBegin\nScale 1 0 1\n  Rotate 30 0 0 0\nConcatTransform [1 0 0 0 1 0 0 0 0 0 1 0 0 0 0 1]\n"
      "Scale 1e-8 1e-8 1e-8\nSphere 1 -1 1 360\nWorldEnd\n");
  EXPECT_THAT(built.messages,
              ElementsAre("t.rib:2:1: error: math: Scale 1 0 1: no factor may be 0",
                          "t.rib:3:3: error: math: Rotate about an axis of no length",
                          HasSubstr("t.rib:4:1: error: math: the current transformation would be singular")));
  expectMatrix(built.world().primitives.at(0).objectToWorld, scaling(1e-8, 1e-8, 1e-8), 1e-15);
}

TEST(Transform, OverflowIsRefused) {
  std::string text = "WorldBegin\n";
  for (int i = 0; i < 20; ++i) text += "Scale 1e30 1e30 1e30\n";
  const Built built = build(text + std::string(kSphere) + "WorldEnd");
  EXPECT_EQ(built.status, 1);
  EXPECT_TRUE(std::isfinite(built.world().primitives.at(0).objectToWorld[0][0]));
}

TEST(Transform, BlocksRestore) {
  const Built built = buildClean(
      "WorldBegin TransformBegin Translate 1 0 0 TransformEnd Sphere 1 -1 1 360 "
      "AttributeBegin Translate 2 0 0 TransformBegin Translate 3 0 0 Sphere 1 -1 1 360 TransformEnd "
      "Sphere 1 -1 1 360 AttributeEnd Sphere 1 -1 1 360 WorldEnd");
  const auto x = [&](size_t i) { return built.world().primitives.at(i).objectToWorld[3][0]; };
  EXPECT_EQ(x(0), 0);
  EXPECT_EQ(x(1), 5);
  EXPECT_EQ(x(2), 2);
  EXPECT_EQ(x(3), 0);
}

TEST(Transform, NamedSpaces) {
  const Built built = build(
      "Translate 0 0 10 CoordinateSystem \"lens\" WorldBegin Translate 1 2 3 CoordinateSystem \"here\" "
      "Identity\n"
      "CoordSysTransform \"here\" Sphere 1 -1 1 360 CoordSysTransform \"camera\" Sphere 1 -1 1 360\n"
      "CoordSysTransform \"there\"\nWorldEnd");
  EXPECT_THAT(
      built.messages,
      ElementsAre("t.rib:3:1: error: badtoken: CoordSysTransform: no coordinate system is named \"there\""));
  expectMatrix(built.world().primitives.at(0).objectToWorld, translation(1, 2, 3), 0);
  expectMatrix(built.world().primitives.at(1).objectToWorld, translation(0, 0, -10), 0);
  // What stood where the camera's own requests had led to is world space itself.
  expectMatrix(built.world().coordinateSystems.at("lens"), M44d(), 0);
}

TEST(Transform, ScopedSpacesEndWithTheirBlock) {
  const Built built = buildClean(
      "WorldBegin CoordinateSystem \"a\" AttributeBegin Translate 1 0 0 ScopedCoordinateSystem \"a\" "
      "AttributeEnd "
      "CoordSysTransform \"a\" Sphere 1 -1 1 360 WorldEnd");
  expectMatrix(built.world().primitives.at(0).objectToWorld, M44d(), 0);
}

TEST(Transform, PerspectiveMovesPointsThemselves) {
  // fov 90: (x, y, z) -> (x/z, y/z, (z-1)/z).
  const Built built = buildClean("WorldBegin Perspective 90 Polygon \"P\" [0 0 2  1 0 2  1 1 4] WorldEnd");
  const Primitive& polygon = built.world().primitives.at(0);
  expectMatrix(polygon.objectToWorld, M44d(), 0);
  EXPECT_THAT(polygon.variables.at(0).floats, ElementsAre(0, 0, .5f, .5f, 0, .5f, .25f, .25f, .75f));
}

TEST(Transform, InverseOfFarAndSmall) {
  const M44d matrix = scaling(1e-9, 2e-9, 1e-9) * rotation(33, V3d(1, 2, 3)) * translation(1e7, -3, 1e5);
  expectMatrix(matrix * inverted(matrix).value(), M44d(), 1e-9);
  EXPECT_FALSE(inverted(scaling(1, 0, 1)));
}

TEST(Transform, LargestStretchOfScaledRotation) {
  EXPECT_NEAR(largestStretch(scaling(2, 5, 3) * rotation(40, V3d(1, 2, 3))), 5, 1e-12);
}

// ---- Orientation
// ---------------------------------------------------------------------------------------------------

std::vector<bool> reversedOf(std::string_view text) {
  const Built built = buildClean(text);
  std::vector<bool> reversed;
  for (const Primitive& primitive : built.world().primitives) reversed.push_back(primitive.reversed);
  return reversed;
}

TEST(Orientation, FollowsMirroringOfTheSpace) {
  // "The current orientation is ... reversed whenever the determinant of a transformation is negative": so is
  // the space's own handedness, and "outside" stays outside.
  EXPECT_THAT(
      reversedOf("WorldBegin Sphere 1 -1 1 360 Scale 1 1 -1 Sphere 1 -1 1 360 Identity Sphere 1 -1 1 360 "
                 "TransformBegin Scale -1 1 1 TransformEnd Sphere 1 -1 1 360 WorldEnd"),
      ElementsAre(false, false, false, false));
}

TEST(Orientation, InsideReverseAndScope) {
  EXPECT_THAT(
      reversedOf(
          "WorldBegin AttributeBegin Orientation \"inside\" Sphere 1 -1 1 360 Scale -1 1 1 Sphere 1 -1 1 360 "
          "ReverseOrientation Sphere 1 -1 1 360 Orientation \"inside\" AttributeEnd Sphere 1 -1 1 360 "
          "WorldEnd"),
      ElementsAre(true, true, false, false));
}

TEST(Orientation, ExplicitHandednessIsAgainstThatOfTheSpace) {
  // Camera space is left-handed.
  EXPECT_THAT(
      reversedOf(
          "WorldBegin Orientation \"lh\" Sphere 1 -1 1 360 Orientation \"rh\" Sphere 1 -1 1 360 WorldEnd"),
      ElementsAre(false, true));
  // A camera that mirrors makes the world right-handed, a second mirror makes it left-handed again.
  EXPECT_THAT(reversedOf("Scale 1 1 -1 WorldBegin Orientation \"rh\" Sphere 1 -1 1 360 Scale -1 1 1 "
                         "Orientation \"rh\" Sphere 1 -1 1 360 WorldEnd"),
              ElementsAre(false, true));
}

TEST(Orientation, ObjectsTakeTheInstance) {
  const Built built = buildClean(
      "WorldBegin ReverseOrientation ObjectBegin 1 Sphere 1 -1 1 360 ReverseOrientation Sphere 1 -1 1 360 "
      "ObjectEnd "
      "ObjectInstance 1 ReverseOrientation ObjectInstance 1 WorldEnd");
  const ObjectDefinition& object = built.world().objects.at(0);
  EXPECT_FALSE(object.primitives.at(0).reversed);
  EXPECT_TRUE(object.primitives.at(1).reversed);
  EXPECT_TRUE(built.world().instances.at(0).reversed);
  EXPECT_FALSE(built.world().instances.at(1).reversed);
}

}  // namespace
}  // namespace patina
