// SPDX-License-Identifier: Apache-2.0
// SolidBegin: trees, and what is done about those that are none.
#include "scene_fixture.h"

namespace patina {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using Operation = Solid::Operation;

constexpr const char* kOne = "SolidBegin \"primitive\" Sphere 1 -1 1 360 SolidEnd\n";

std::vector<Operation> operations(const Solid& solid) {
  std::vector<Operation> all;
  for (const Solid::Node& node : solid.nodes) all.push_back(node.operation);
  return all;
}

std::vector<uint32_t> parents(const Solid& solid) {
  std::vector<uint32_t> all;
  for (const Solid::Node& node : solid.nodes) all.push_back(node.parent);
  return all;
}

TEST(SolidRequests, ATreeOfOperations) {
  const std::string one = kOne;
  const Built built =
      buildClean("WorldBegin Sphere 1 -1 1 360 SolidBegin \"difference\" SolidBegin \"union\" " + one + one +
                 "SolidEnd SolidBegin \"intersection\" " + one +
                 "AttributeBegin Color 1 0 0 SolidBegin \"primitive\" Disk 0 1 360 Cone 1 1 360 "
                 "SolidEnd AttributeEnd SolidEnd SolidEnd Sphere 1 -1 1 360 WorldEnd");
  const Scene& scene = built.world();
  ASSERT_THAT(scene.solids, SizeIs(1));
  EXPECT_THAT(operations(scene.solids[0]),
              ElementsAre(Operation::Difference, Operation::Union, Operation::Primitive, Operation::Primitive,
                          Operation::Intersection, Operation::Primitive, Operation::Primitive));
  EXPECT_THAT(parents(scene.solids[0]), ElementsAre(kNone, 0, 1, 1, 0, 4, 4));
  std::vector<uint32_t> solids, leaves;
  for (const Primitive& primitive : scene.primitives)
    solids.push_back(primitive.solid), leaves.push_back(primitive.operand);
  EXPECT_THAT(solids, ElementsAre(kNone, 0, 0, 0, 0, 0, kNone));
  EXPECT_THAT(leaves, ElementsAre(0, 2, 3, 5, 6, 6, 0));
  EXPECT_EQ(built.attributesOf(5).color, Rgb(1, 0, 0));
  EXPECT_EQ(built.attributesOf(6).color, Rgb(1, 1, 1)) << "the block saves attributes";
}

TEST(SolidRequests, ThoseOfOneOperandAreNone) {
  const std::string one = kOne;
  const Built built = buildClean("WorldBegin " + one + "SolidBegin \"difference\" SolidBegin \"union\" " +
                                 one + "SolidEnd SolidEnd SolidBegin \"union\" SolidEnd WorldEnd");
  EXPECT_THAT(built.world().solids, IsEmpty());
  ASSERT_THAT(built.world().primitives, SizeIs(2));
  for (const Primitive& primitive : built.world().primitives) EXPECT_EQ(primitive.solid, kNone);
}

TEST(SolidRequests, ObjectsHaveTheirOwn) {
  const std::string one = kOne;
  const Built built =
      buildClean("WorldBegin SolidBegin \"union\" " + one +
                 "ObjectBegin \"o\" Sphere 1 -1 1 360 SolidBegin \"difference\" " + one + one +
                 "SolidEnd ObjectEnd " + one + "SolidEnd ObjectInstance \"o\" WorldEnd");
  const Scene& scene = built.world();
  ASSERT_THAT(scene.solids, SizeIs(1));
  EXPECT_THAT(operations(scene.solids[0]),
              ElementsAre(Operation::Union, Operation::Primitive, Operation::Primitive));
  ASSERT_THAT(scene.objects.at(0).solids, SizeIs(1));
  EXPECT_THAT(operations(scene.objects[0].solids[0]),
              ElementsAre(Operation::Difference, Operation::Primitive, Operation::Primitive));
  ASSERT_THAT(scene.objects[0].primitives, SizeIs(3));
  EXPECT_EQ(scene.objects[0].primitives[0].solid, kNone);
  EXPECT_EQ(scene.objects[0].primitives[1].solid, 0u);
}

TEST(SolidRequests, WrongNestingLosesNothing) {
  const std::string one = kOne;
  const Built built =
      build("WorldBegin\nSolidBegin \"difference\"\nSphere 1 -1 1 360\nSolidBegin \"sum\"\n" + one +
            "SolidBegin \"primitive\"\nSolidBegin \"union\"\nSphere 1 -1 1 360 SolidEnd SolidEnd\n"
            "SolidEnd SolidEnd WorldEnd");
  EXPECT_THAT(
      built.messages,
      ElementsAre(
          "t.rib:3:1: error: badsolid: Sphere straight inside SolidBegin \"difference\" of t.rib:2:1: "
          "expected SolidBegin \"primitive\" around it; it is taken as an operand of its own",
          "t.rib:4:1: error: badtoken: SolidBegin \"sum\": expected primitive, union, intersection or "
          "difference",
          "t.rib:7:1: error: badsolid: SolidBegin \"union\" inside SolidBegin \"primitive\" of "
          "t.rib:6:1: its surfaces are taken as a part of that one"));
  ASSERT_THAT(built.world().solids, SizeIs(1));
  EXPECT_THAT(operations(built.world().solids[0]),
              ElementsAre(Operation::Difference, Operation::Primitive, Operation::Union, Operation::Primitive,
                          Operation::Primitive));
  EXPECT_THAT(built.world().primitives, SizeIs(3));
  EXPECT_EQ(built.world().primitives[2].operand, 4u);
  EXPECT_EQ(built.status, 1);

  const Built outside =
      build("SolidBegin \"union\"\nSolidEnd SolidEnd WorldBegin SolidBegin \"union\" " + one + "WorldEnd");
  EXPECT_THAT(outside.messages,
              ElementsAre(HasSubstr("t.rib:1:1: error: illstate: SolidBegin outside of WorldBegin"),
                          HasSubstr("SolidEnd without SolidBegin"),
                          HasSubstr("WorldEnd closes SolidBegin of t.rib:2:30, which is still open")));
  EXPECT_THAT(outside.world().primitives, SizeIs(1));
}

TEST(SolidRequests, AreaLightsAndInstancesStayOutside) {
  const std::string one = kOne;
  const Built built = build(
      "WorldBegin ObjectBegin \"o\" SolidBegin \"union\" " + one + one + "SolidEnd ObjectEnd\n" +
      "SolidBegin \"difference\" " + one + one +
      "SolidBegin \"primitive\" AreaLightSource \"arealight\" 1\nSphere 1 -1 1 360 SolidEnd\nObjectInstance "
      "\"o\" SolidEnd AreaLightSource \"arealight\" 2\nObjectInstance \"o\" WorldEnd");
  EXPECT_THAT(
      built.messages,
      testing::UnorderedElementsAre(
          "t.rib:7:1: warning: incapable: an area light inside SolidBegin is no part of the solid: its "
          "operand "
          "is drawn whole",
          "t.rib:9:1: warning: incapable: an area light on solids of an ObjectInstance gives no light",
          "t.rib:8:1: warning: unimplemented: ObjectInstance inside SolidBegin is drawn whole beside the "
          "solid (once)"));
  const Scene& scene = built.world();
  ASSERT_THAT(scene.solids, SizeIs(1));
  EXPECT_TRUE(scene.solids[0].nodes.back().absent);
  EXPECT_EQ(scene.primitives.back().solid, kNone);
  EXPECT_NE(scene.attributes[scene.primitives.back().attributes].areaLight, kNone);
  EXPECT_EQ(scene.attributes[scene.instances.back().attributes].areaLight, kNone);
}

TEST(SolidRequests, SavedAttributesDoNotMoveIntoASolid) {
  const std::string one = kOne;
  const Built built = buildClean(
      "WorldBegin Resource \"r\" \"attributes\" \"string operation\" \"save\" SolidBegin "
      "\"union\" " +
      one +
      "SolidBegin \"primitive\" Resource \"r\" \"attributes\" \"string operation\" "
      "\"restore\" Sphere 1 -1 1 360 SolidEnd SolidEnd WorldEnd");
  EXPECT_EQ(built.world().primitives.at(1).solid, 0u);
}

TEST(SolidRequests, WorldsDoNotLeak) {
  const std::string one = kOne;
  const std::string world = "WorldBegin SolidBegin \"union\" " + one + one + "SolidEnd WorldEnd ";
  const Built built = build(world + world);
  ASSERT_THAT(built.worlds, SizeIs(2));
  for (const Scene& scene : built.worlds) EXPECT_THAT(scene.solids, SizeIs(1));
}

}  // namespace
}  // namespace patina
