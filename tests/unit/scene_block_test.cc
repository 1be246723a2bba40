// SPDX-License-Identifier: Apache-2.0
// Blocks: nesting, its errors, and what survives them.
#include "scene_fixture.h"

namespace patina {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

TEST(Blocks, StrayEnds) {
  const Built built =
      build("AttributeEnd\nWorldBegin\nTransformEnd\nSphere 1 -1 1 360\nWorldEnd\nWorldEnd\nFrameEnd\n");
  EXPECT_THAT(built.messages, ElementsAre("t.rib:1:1: error: nesting: AttributeEnd without AttributeBegin",
                                          "t.rib:3:1: error: nesting: TransformEnd without TransformBegin; "
                                          "the open block is WorldBegin of t.rib:2:1",
                                          "t.rib:6:1: error: nesting: WorldEnd without WorldBegin",
                                          "t.rib:7:1: error: nesting: FrameEnd without FrameBegin"));
  EXPECT_THAT(built.world().primitives, SizeIs(1));
}

TEST(Blocks, EndsThatCross) {
  const Built built = build(
      "WorldBegin\nAttributeBegin\nColor 1 0 0\nTransformBegin\nAttributeEnd\nSphere 1 -1 1 "
      "360\nTransformEnd\nWorldEnd\n");
  EXPECT_THAT(
      built.messages,
      ElementsAre(
          "t.rib:5:1: error: nesting: AttributeEnd closes TransformBegin of t.rib:4:1, which is still open",
          HasSubstr("t.rib:7:1: error: nesting: TransformEnd without TransformBegin")));
  EXPECT_EQ(built.attributesOf(0).color, Rgb(1, 1, 1));
}

TEST(Blocks, HoudinisWorldInsideATransformBlock) {
  const Built built =
      buildClean("TransformBegin Translate 0 0 3 WorldBegin Sphere 1 -1 1 360 WorldEnd TransformEnd");
  EXPECT_EQ(built.world().camera.worldToCamera[3][2], 3);
}

TEST(Blocks, AFileThatEndsInsideAWorldIsRenderedAsFarAsItGoes) {
  const Built built = build("FrameBegin 1\nWorldBegin\nSphere 1 -1 1 360\nAttributeBegin\n");
  EXPECT_THAT(built.messages,
              ElementsAre("t.rib:4:1: error: nesting: the file ends inside this AttributeBegin",
                          "t.rib:2:1: error: nesting: the file ends inside this WorldBegin",
                          "t.rib:1:1: error: nesting: the file ends inside this FrameBegin"));
  EXPECT_THAT(built.worlds, SizeIs(1));
  EXPECT_THAT(built.world().primitives, SizeIs(1));
}

TEST(Blocks, WorldsDoNotLeak) {
  const Built built = build(
      "WorldBegin Color 1 0 0 Surface \"a\" LightSource \"b\" 1 ObjectBegin 1 Sphere 1 -1 1 360 ObjectEnd "
      "Sphere 1 -1 1 360 WorldEnd "
      "WorldBegin Sphere 1 -1 1 360 WorldEnd");
  ASSERT_THAT(built.worlds, SizeIs(2));
  const Scene& second = built.worlds[1];
  EXPECT_THAT(second.primitives, SizeIs(1));
  EXPECT_THAT(second.attributes, SizeIs(1));
  EXPECT_THAT(second.shaders, IsEmpty());
  EXPECT_THAT(second.lights, IsEmpty());
  EXPECT_THAT(second.objects, IsEmpty());
  EXPECT_EQ(second.attributes[0].color, Rgb(1, 1, 1));
}

TEST(Blocks, AWorldInsideAWorldOrAnObject) {
  const Built built = build("WorldBegin\nWorldBegin\nObjectBegin 1\nFrameBegin 1\nObjectEnd\nWorldEnd\n");
  EXPECT_THAT(built.messages, ElementsAre("t.rib:2:1: error: nesting: WorldBegin inside WorldBegin",
                                          "t.rib:4:1: error: nesting: FrameBegin inside WorldBegin"));
  EXPECT_THAT(built.worlds, SizeIs(1));
}

TEST(Blocks, DeepNestingHasALimitAndTakesLinearTime) {
  std::string text = "WorldBegin\n";
  for (int i = 0; i < 100000; ++i) text += "TransformBegin\n";
  for (int i = 0; i < 100000; ++i) text += "AttributeEnd\n";
  text += "Sphere 1 -1 1 360\nWorldEnd\n";
  const Built built = build(text);
  EXPECT_THAT(built.world().primitives, SizeIs(1));
  EXPECT_THAT(
      built.messages.at(0),
      HasSubstr("AttributeEnd without AttributeBegin; the open block is TransformBegin of t.rib:100001:1"));

  SceneBuilderSettings settings;
  settings.blockDepth = 3;
  const Built limited = build(
      "WorldBegin AttributeBegin AttributeBegin\nAttributeBegin Color 1 0 0 AttributeEnd Sphere 1 -1 1 360 "
      "AttributeEnd AttributeEnd WorldEnd",
      settings);
  EXPECT_THAT(limited.messages,
              ElementsAre("t.rib:2:1: error: limitcheck: more than 3 blocks within each other"));
  EXPECT_THAT(limited.worlds, SizeIs(1));
}

TEST(Blocks, ErrorHandlerAbortStopsBeforeTheWorldIsDrawn) {
  const Built built = build("ErrorHandler \"abort\" WorldBegin Sides 9 Sphere 1 -1 1 360 WorldEnd");
  EXPECT_THAT(built.worlds, IsEmpty());
  EXPECT_EQ(built.status, 1);
  EXPECT_THAT(build("ErrorHandler \"shout\"").messages,
              ElementsAre(HasSubstr("ErrorHandler: unknown style \"shout\"")));
}

}  // namespace
}  // namespace patina
