// SPDX-License-Identifier: Apache-2.0
// Motion blocks: keys, what lies between them in closed form, and what is refused.
#include <cmath>

#include "renderer/scene/matrices.h"
#include "renderer/scene/motion.h"
#include "renderer/scene/shape_motion.h"
#include "scene_fixture.h"

namespace patina {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

/// The only primitive of a world with a shutter from 0 to 1.
Built moving(std::string_view block) {
  return buildClean("Shutter 0 1 WorldBegin " + std::string(block) + " Sphere 1 -1 1 360 WorldEnd");
}

M44d placeAt(const Built& built, double time, size_t primitive = 0) {
  const auto& motion = built.world().primitives.at(primitive).motion;
  EXPECT_TRUE(motion && motion->place.outer);
  return motion && motion->place.outer ? motion->place.at(time) : M44d();
}

TEST(Motion, TranslationIsLinearAndHeldOutside) {
  const Built built = moving("MotionBegin [0.25 0.75] Translate 1 0 0 Translate 3 0 4 MotionEnd");
  expectMatrix(placeAt(built, 0), translation(1, 0, 0), 0);
  expectMatrix(placeAt(built, 0.25), translation(1, 0, 0), 0);
  expectMatrix(placeAt(built, 0.375), translation(1.5, 0, 1));
  expectMatrix(placeAt(built, 0.5), translation(2, 0, 2));
  expectMatrix(placeAt(built, 2), translation(3, 0, 4), 0);
  expectMatrix(built.world().primitives[0].objectToWorld, translation(1, 0, 0), 0);
}

TEST(Motion, RotationsTurnAllTheWayRound) {
  for (const double degrees : {90.0, 180.0, 270.0, 720.0, -450.0}) {
    const Built built = moving("MotionBegin [0 1] Rotate 10 1 2 3 Rotate " + std::to_string(10 + degrees) +
                               " 1 2 3 MotionEnd");
    for (double t = 0; t <= 1; t += 1.0 / 16)
      expectMatrix(placeAt(built, t), rotation(10 + degrees * t, V3d(1, 2, 3)), 1e-7);  // RIB holds floats
  }
}

TEST(Motion, AnAxisThatIsTurnedRoundTurnsTheOtherWay) {
  const Built built = moving("MotionBegin [0 1] Rotate 0 0 0 1 Rotate 270 0 0 -1 MotionEnd");
  expectMatrix(placeAt(built, 1.0 / 3), rotation(-90, V3d(0, 0, 1)), 1e-12);
}

TEST(Motion, MatricesTurnTheShortWayAndStretchLinearly) {
  // Polar decomposition: rotation of 0 to 90 degrees about z, stretch 1 to 3 along x before it.
  const Built built = moving(
      "MotionBegin [0 1] ConcatTransform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1] "
      "ConcatTransform [0 3 0 0 -1 0 0 0 0 0 1 0 0 0 0 1] MotionEnd");
  expectMatrix(placeAt(built, 0.5), scaling(2, 1, 1) * rotation(45, V3d(0, 0, 1)));
}

TEST(Motion, PolarAndTriangularPartsMakeTheMatrix) {
  const M44d skewed = *skew(30, V3d(0, 1, 0), V3d(1, 0, 0));
  for (const M44d& m : {scaling(1, 2, 3) * rotation(100, V3d(1, -1, 2)) * skewed * translation(5, 6, 7),
                        scaling(-1, 1e-3, 20) * skewed * rotation(250, V3d(0, 1, 2))}) {
    expectMatrix(polarParts(m).matrix(), m, 1e-12);
    expectMatrix(triangularParts(m).matrix(), m, 1e-12);
    const Imath::M33d s = polarParts(m).stretch, t = triangularParts(m).stretch;
    EXPECT_NEAR(s[0][1], s[1][0], 1e-12);
    EXPECT_NEAR(s[0][2], s[2][0], 1e-12);
    EXPECT_EQ(t[0][1], 0);
    EXPECT_EQ(t[0][2], 0);
    EXPECT_EQ(t[1][2], 0);
    EXPECT_NEAR(polarParts(m).rotation.length(), 1, 1e-12);
  }
}

TEST(Motion, NestedMotionsMakeOnePath) {
  // A point on a wheel: it turns about an axle that moves along x. Interpolating the products would cut the
  // arcs short.
  const Built built = moving(
      "MotionBegin [0 1] Translate 0 0 0 Translate 10 0 0 MotionEnd "
      "MotionBegin [0 0.5 1] Rotate 0 0 0 1 Rotate 90 0 0 1 Rotate 360 0 0 1 MotionEnd Translate 2 0 0");
  for (double t = 0; t <= 1; t += 0.0625) {
    const double angle = (t < 0.5 ? 180 * t : 90 + 540 * (t - 0.5)) * std::numbers::pi / 180;
    const V3d center = V3d(0, 0, 0) * placeAt(built, t);
    EXPECT_NEAR(center.x, 10 * t + 2 * std::cos(angle), 1e-9) << t;
    EXPECT_NEAR(center.y, 2 * std::sin(angle), 1e-9) << t;
  }
}

TEST(Motion, StillTransformationsInsideAndBlocksAround) {
  const Built built = buildClean(
      "Shutter 0 1 WorldBegin TransformBegin MotionBegin [0 1] Translate 0 0 0 Translate 4 0 0 MotionEnd "
      "Scale 2 2 2 Sphere 1 -1 1 360 TransformEnd Sphere 1 -1 1 360 "
      "AttributeBegin MotionBegin [0 1] Transform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1] "
      "Transform [1 0 0 0 0 1 0 0 0 0 1 0 0 8 0 1] MotionEnd Sphere 1 -1 1 360 Identity Sphere 1 -1 1 360 "
      "AttributeEnd WorldEnd");
  expectMatrix(placeAt(built, 0.5), scaling(2, 2, 2) * translation(2, 0, 0));
  EXPECT_EQ(built.world().primitives[1].motion, nullptr);
  expectMatrix(placeAt(built, 0.5, 2), translation(0, 4, 0));
  EXPECT_EQ(built.world().primitives[3].motion, nullptr);
}

TEST(Motion, CameraAndInstances) {
  const Built built = buildClean(
      "Shutter 1 2 MotionBegin [0 4] Translate 0 0 0 Translate 0 0 8 MotionEnd WorldBegin ObjectBegin 1 "
      "Sphere 1 -1 1 360 ObjectEnd MotionBegin [0 2] Translate 0 0 0 Translate 2 0 0 MotionEnd "
      "ObjectInstance 1 WorldEnd");
  const Scene& scene = built.world();
  // What is drawn of a shutter that is shut is the state of its opening, so that is what stands there.
  expectMatrix(scene.camera.worldToCamera, translation(0, 0, 2));
  ASSERT_TRUE(scene.camera.motion && scene.instances.at(0).motion);
  expectMatrix(scene.camera.motion->at(2), translation(0, 0, 4));
  expectMatrix(scene.instances[0].objectToWorld, translation(1, 0, 0));
  expectMatrix(scene.instances[0].motion->at(2), translation(2, 0, 0));
  EXPECT_EQ(scene.objects.at(0).primitives.at(0).motion, nullptr);
}

TEST(Motion, TheOpeningCountsWherever) {
  // Shutter behind the motion; nothing moves while it is shut.
  const Built built = buildClean(
      "MotionBegin [0 1] Translate 0 0 0 Translate 0 0 8 MotionEnd Shutter 0.5 0.5 WorldBegin "
      "MotionBegin [0 1] Sphere 1 -1 1 360 Sphere 3 -3 3 360 MotionEnd WorldEnd");
  expectMatrix(built.world().camera.worldToCamera, translation(0, 0, 4));
  EXPECT_FALSE(built.world().camera.motion->movesWithin(0.5, 0.5));
  EXPECT_EQ(std::get<Quadric>(built.world().primitives.at(0).shape).values[0], 2);
  EXPECT_FALSE(deformsWithin(*built.world().primitives[0].motion, 0.5, 0.5));
}

TEST(Motion, ShapesAreLinearInTheirPointsAndDimensions) {
  const Built built = buildClean(
      "Shutter 0.25 1 WorldBegin MotionBegin [0 0.5 1] Polygon \"P\" [0 0 0 1 0 0 0 1 0] "
      "Polygon \"P\" [0 0 4 1 0 0 0 1 0] Polygon \"P\" [0 0 4 1 0 2 0 1 0] MotionEnd "
      "MotionBegin [0 1] Points \"P\" [0 0 0] \"constantwidth\" [1] Points \"P\" [0 0 8] \"constantwidth\" "
      "[2] "
      "MotionEnd WorldEnd");
  Primitive polygon = built.world().primitives.at(0);
  EXPECT_THAT(polygon.variables[0].floats, ElementsAre(0, 0, 2, 1, 0, 0, 0, 1, 0));  // at the opening
  setShape(polygon, *polygon.motion, 0.75);
  EXPECT_THAT(polygon.variables[0].floats, ElementsAre(0, 0, 4, 1, 0, 1, 0, 1, 0));
  setShape(polygon, *polygon.motion, 7);
  EXPECT_THAT(polygon.variables[0].floats, ElementsAre(0, 0, 4, 1, 0, 2, 0, 1, 0));
  EXPECT_TRUE(deformsWithin(*polygon.motion, 0.25, 1));
  EXPECT_FALSE(deformsWithin(*polygon.motion, 1, 2));
  Primitive points = built.world().primitives.at(1);
  setShape(points, *points.motion, 0.5);
  EXPECT_THAT(points.variables[0].floats, ElementsAre(0, 0, 4));
  EXPECT_THAT(points.variables[1].floats, ElementsAre(1.5f));
}

TEST(Motion, WeightedPointsMoveWithTheirWeights) {
  const Built built = buildClean(
      "WorldBegin MotionBegin [0 1] Patch \"bilinear\" \"P\" [0 0 0 1 0 0 0 1 0 1 1 0] "
      "Patch \"bilinear\" \"Pw\" [6 0 0 3 1 0 0 1 0 1 0 1 1 1 0 1] MotionEnd WorldEnd");
  Primitive patch = built.world().primitives.at(0);
  setShape(patch, *patch.motion, 0.5);
  // (0 0 0 1) and (6 0 0 3): half-way (3 0 0 2).
  EXPECT_FLOAT_EQ(patch.variables[0].floats[0], 1.5f);
}

TEST(Motion, OfOtherRequestsTheFirstHolds) {
  const Built built = build(
      "WorldBegin\nMotionBegin [0 1]\nColor 1 0 0\nColor 0 1 0\nMotionEnd\nSphere 1 -1 1 360\nWorldEnd");
  EXPECT_THAT(built.messages, ElementsAre("t.rib:3:1: warning: unimplemented: Color does not change over a "
                                          "motion block: its first values hold (once)"));
  EXPECT_EQ(built.attributesOf(0).color, Rgb(1, 0, 0));
  EXPECT_EQ(built.world().primitives[0].motion, nullptr);
}

struct Refusal {
  const char* block;
  const char* message;
};

TEST(Motion, ErrorsHoldTheFirst) {
  const Refusal refusals[] = {
      {"MotionBegin [0 1]\nTranslate 1 0 0\nMotionEnd",
       "t.rib:2:1: error: badmotion: MotionBegin: 1 requests for 2 times; the first holds throughout"},
      {"MotionBegin [0 1]\nTranslate 1 0 0\nTranslate 2 0 0\nTranslate 3 0 0\nMotionEnd",
       "t.rib:2:1: error: badmotion: MotionBegin: 3 requests for 2 times; the first holds throughout"},
      {"MotionBegin [0 1]\nTranslate 1 0 0\nScale 2 2 2\nMotionEnd",
       "t.rib:4:1: error: badmotion: Scale among the Translate of MotionBegin of t.rib:2:1: expected "
       "Translate "
       "once for each of the 2 times; the first holds throughout"},
      {"MotionBegin [1 0]\nTranslate 1 0 0\nTranslate 2 0 0\nMotionEnd",
       "t.rib:2:1: error: badmotion: MotionBegin: expected finite times, each greater than the one before; "
       "the "
       "first of the requests holds throughout"},
      {"MotionBegin [0 0]\nTranslate 1 0 0\nTranslate 2 0 0\nMotionEnd",
       "t.rib:2:1: error: badmotion: MotionBegin: expected finite times"},
      {"MotionBegin [0 1]\nTranslate 1 0 0\nMotionBegin [0 1]\nMotionEnd\nTranslate 2 0 0\nMotionEnd",
       "t.rib:4:1: error: nesting: MotionBegin inside MotionBegin of t.rib:2:1"},
      {"MotionBegin [0 1]\nConcatTransform [1 0 0 0 0 1 0 0 0 0 1 0 1 0 0 1]\n"
       "ConcatTransform [-1 0 0 0 0 1 0 0 0 0 1 0 1 0 0 1]\nMotionEnd",
       "t.rib:2:1: error: math: MotionBegin: a movement into the mirror image passes through nothing; the "
       "first ConcatTransform holds throughout"},
      {"Translate 1 0 0\nMotionBegin [0 1]\nRotate 0 0 0 1\nRotate 1e9 0 0 1\nMotionEnd",
       "t.rib:3:1: error: limitcheck: MotionBegin: more than 256 turns from one of its times to the next"},
      {"Translate 1 0 0\nMotionBegin [0 1]\nScale 1 1 1\nScale 0 1 1\nMotionEnd",
       "t.rib:5:1: error: math: Scale 0 1 1: no factor may be 0"},
      {"Translate 1 0 0\nMotionBegin [0 1]\nPerspective 30\nPerspective 40\nMotionEnd",
       "t.rib:4:1: error: badmotion: Perspective in a motion block: projections do not move; request "
       "ignored"},
  };
  for (const Refusal& refusal : refusals) {
    const Built built = build("WorldBegin\n" + std::string(refusal.block) + "\nSphere 1 -1 1 360\nWorldEnd");
    ASSERT_FALSE(built.messages.empty()) << refusal.block;
    EXPECT_THAT(built.messages[0], HasSubstr(refusal.message));
    ASSERT_THAT(built.world().primitives, SizeIs(1)) << refusal.block;
    EXPECT_EQ(built.world().primitives[0].motion, nullptr) << refusal.block;
    expectMatrix(built.world().primitives[0].objectToWorld, translation(1, 0, 0), 0);
    EXPECT_EQ(built.status, 1);
  }
}

TEST(Motion, ShapesThatDoNotGoTogether) {
  const Refusal refusals[] = {
      {"Polygon \"P\" [0 0 0 1 0 0 0 1 0]\nPolygon \"P\" [0 0 0 1 0 0 0 1 0 1 1 1]",
       "the polygons are not the same"},
      {"Points \"P\" [0 0 0]\nPoints \"P\" [0 0 0 1 1 1]", "the numbers of points differ"},
      {"Points \"P\" [0 0 0] \"constantwidth\" [1]\nPoints \"P\" [0 0 0]",
       "\"constantwidth\" has 1 numbers at the first of the times, 0 at another"},
      {"Curves \"linear\" [2] \"nonperiodic\" \"P\" [0 0 0 1 1 1]\nCurves \"linear\" [3] \"nonperiodic\" "
       "\"P\" [0 0 "
       "0 1 1 1 2 2 2]",
       "the curves are not the same"}};
  for (const Refusal& refusal : refusals) {
    const Built built =
        build("WorldBegin\nMotionBegin [0 1]\n" + std::string(refusal.block) + "\nMotionEnd\nWorldEnd");
    ASSERT_THAT(built.messages, SizeIs(1)) << refusal.block;
    EXPECT_THAT(built.messages[0], HasSubstr("t.rib:4:1: error: consistency: "));
    EXPECT_THAT(built.messages[0], HasSubstr(refusal.message));
    ASSERT_THAT(built.world().primitives, SizeIs(1));
    EXPECT_EQ(built.world().primitives[0].motion, nullptr);
  }
}

TEST(Motion, ManyOnTopOfEachOtherAreRefused) {
  std::string text = "WorldBegin ";
  for (size_t k = 0; k < Motion::kMostNested + 2; ++k)
    text += "MotionBegin [0 1] Translate 0 0 0 Translate 1 0 0 MotionEnd ";
  const Built built = build(text + "Sphere 1 -1 1 360 WorldEnd");
  ASSERT_THAT(built.messages, SizeIs(2));
  EXPECT_THAT(built.messages[0], HasSubstr("limitcheck: MotionBegin: more than 256 moving transformations"));
  EXPECT_NEAR(placeAt(built, 1)[3][0], static_cast<double>(Motion::kMostNested), 1e-9);
}

TEST(Motion, ArchivesAndConditionsAreNoSamples) {
  const Built built = build(
      "WorldBegin MotionBegin [0 1] IfBegin \"1\" Sphere 1 -1 1 360 IfEnd Sphere 2 -2 2 360 MotionEnd "
      "WorldEnd");
  EXPECT_THAT(built.messages, IsEmpty());
  ASSERT_TRUE(built.world().primitives.at(0).motion);
  EXPECT_THAT(built.world().primitives[0].motion->shapes, SizeIs(2));
}

TEST(Motion, SampleMotionIsAnAttribute) {
  const Built built = buildClean(
      "WorldBegin Sphere 1 -1 1 360 Attribute \"trace\" \"int samplemotion\" [1] Sphere 1 -1 1 360 WorldEnd");
  EXPECT_FALSE(built.attributesOf(0).sampleMotion);
  EXPECT_TRUE(built.attributesOf(1).sampleMotion);
}

/// The steps that stand for a movement are near to it everywhere, not at the steps alone.
TEST(Motion, StepsFollowThePath) {
  for (const char* block : {"MotionBegin [0 1] Translate 0 0 0 Translate 5 0 0 MotionEnd",
                            "MotionBegin [0 1] Rotate 0 0 1 0 Rotate 720 0 1 0 MotionEnd Translate 3 0 0",
                            "MotionBegin [0 1] Translate 0 0 0 Translate 5 0 0 MotionEnd "
                            "MotionBegin [0 1] Rotate 0 0 0 1 Rotate 270 0 0 1 MotionEnd",
                            "MotionBegin [0 0.3 1] Translate 0 0 0 Translate 1 0 0 Translate 1 4 0 MotionEnd",
                            "MotionBegin [0 1] Scale 1 1 1 Scale 1 -3 -1 MotionEnd"}) {
    const Built built = moving(block);
    const Movement& movement = built.world().primitives.at(0).motion->place;
    const Box3f box(V3f(-1), V3f(1));
    const std::vector<TransformParts> steps = sampleMovement({M44d(), movement.outer}, 0, 1, box);
    ASSERT_GE(steps.size(), 2u);
    const auto n = static_cast<double>(steps.size() - 1);
    for (int k = 0; k < 1000; ++k) {
      const double t = k / 1000.0 * n, s = t - std::floor(t);
      const auto at = static_cast<size_t>(t);
      const M44d near = interpolate(steps[at], steps[at + 1], s).matrix(),
                 exact = movement.outer->at(k / 1000.0);
      // The size of the box is 3.5; kinks that fall on no step, at 0.3 of 64, cost a little more.
      const double bound = std::string_view(block).find("0.3") == std::string_view::npos ? 1.2e-3 : 2e-2;
      EXPECT_LT((V3d(1, 1, -1) * near - V3d(1, 1, -1) * exact).length(), bound) << block << " at " << k;
    }
  }
}

}  // namespace
}  // namespace patina
