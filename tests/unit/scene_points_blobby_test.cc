// SPDX-License-Identifier: Apache-2.0
// Points and Blobby: what of the request reaches the scene, and what is refused with which words.
#include "scene_fixture.h"

namespace patina {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

const std::string kMatrix = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1";

Built inWorld(std::string_view requests) {
  return build("WorldBegin\n" + std::string(requests) + "\nWorldEnd\n");
}

TEST(PointsRequest, CountsItsPoints) {
  const Built built = inWorld(
      "Points \"P\" [0 0 0 1 2 3] \"width\" [.1 .2] \"uniform float k\" 7 \"vertex color Cs\" [1 0 0 0 1 0]\n"
      "Points \"Pw\" [2 4 6 2]");
  EXPECT_THAT(built.messages, IsEmpty());
  const Primitive& points = built.world().primitives.at(0);
  EXPECT_EQ(std::get<PointSet>(points.shape).count, 2u);
  ASSERT_THAT(points.variables, SizeIs(4));
  EXPECT_THAT(points.variables[1].floats, ElementsAre(.1f, .2f));
  EXPECT_EQ(std::get<PointSet>(built.world().primitives.at(1).shape).count, 1u);
  EXPECT_THAT(built.world().primitives[1].variables[0].floats, ElementsAre(1, 2, 3));
}

TEST(PointsRequest, IsRefusedWithoutWholePoints) {
  const Built built = inWorld(
      "Points \"width\" [1]\nPoints \"P\" []\nPoints \"P\" [1 2 3 4]\nPoints \"P\" [0 0 0 1 1 1] \"width\" "
      "[1 "
      "2 3]");
  EXPECT_THAT(
      built.messages,
      ElementsAre(
          "t.rib:2:1: error: badargument: Points are left out: they need \"P\"",
          "t.rib:3:1: error: badargument: Points are left out: they need \"P\"",
          HasSubstr("t.rib:4:1: error: badargument: Points is left out: \"P\" has 4 numbers"),
          HasSubstr("t.rib:5:26: warning: badparamlist: Points: \"width\" has 3 values, expected 2")));
  EXPECT_THAT(built.world().primitives, SizeIs(1));
}

TEST(BlobbyRequest, BecomesAProgram) {
  const Built built =
      inWorld("Blobby 3 [1001 0 1000 16 1003 0 17 0 3 0 1 2 4 3 0 6 4] [" + kMatrix +
              " .5 .4 .01 .3 .08] [\"flat.zfile\"] \"varying float a\" [1 2 3] \"uniform float b\" 4");
  EXPECT_THAT(built.messages,
              ElementsAre("t.rib:2:1: warning: unimplemented: Blobby: depth files of repelling planes are "
                          "not read; the plane z = 0 takes their place"));
  const Primitive& primitive = built.world().primitives.at(0);
  const auto& blobby = std::get<Blobby>(primitive.shape);
  ASSERT_THAT(blobby.instructions, SizeIs(6));
  using Op = Blobby::Op;
  const Op ops[] = {Op::Ellipsoid, Op::Constant, Op::Plane, Op::Add, Op::Divide, Op::Negate};
  for (size_t k = 0; k < 6; ++k) EXPECT_EQ(blobby.instructions[k].op, ops[k]) << k;
  EXPECT_EQ(blobby.instructions[2].first, 17u);
  EXPECT_THAT(blobby.operands, ElementsAre(0, 1, 2, 3, 0, 4));
  EXPECT_THAT(blobby.floats, SizeIs(21));
  EXPECT_EQ(blobby.leaves, 3u);
  EXPECT_THAT(primitive.variables, SizeIs(2));
}

TEST(BlobbyRequest, MayHaveMoreFieldsThanItSays) {
  const Built built = inWorld("Blobby 1 [1001 0 1001 0 0 2 0 1] [" + kMatrix + "] \"vertex float a\" [1]");
  EXPECT_THAT(built.messages,
              ElementsAre("t.rib:2:1: warning: consistency: Blobby has 1 leaves, its code has 2 "
                          "fields; the code holds"));
  EXPECT_THAT(built.world().primitives.at(0).variables, SizeIs(1));
}

TEST(BlobbyRequest, BadCodeIsRefused) {
  const auto report = [](const std::string& arguments) {
    const Built built = inWorld("Blobby " + arguments);
    EXPECT_THAT(built.world().primitives, IsEmpty());
    EXPECT_THAT(built.messages, SizeIs(1));
    return built.messages.empty() ? std::string() : built.messages[0];
  };
  const std::string start = "t.rib:2:1: error: badargument: Blobby is left out: ";
  EXPECT_EQ(report("1 [] []"), start + "its code array is empty");
  EXPECT_EQ(report("1 [8] []"), start + "instruction 0 has opcode 8, expected 0 to 7 or 1000 to 1003");
  EXPECT_EQ(report("1 [-1] []"), start + "instruction 0 has opcode -1, expected 0 to 7 or 1000 to 1003");
  EXPECT_EQ(report("1 [1001] [1]"),
            start + "instruction 0 (ellipsoid) wants 1 operands, the code array has 0 more");
  EXPECT_EQ(report("1 [1001 1] [" + kMatrix + "]"),
            start + "instruction 0 (ellipsoid) wants 16 floats from number 1, there are 16");
  EXPECT_EQ(report("1 [1002 -1] [" + kMatrix + "]"),
            start + "instruction 0 (segment) wants 23 floats from number -1, there are 16");
  EXPECT_EQ(report("1 [1003 1 0] [1 2 3 4] [\"a\"]"),
            start + "instruction 0 (repelling plane) wants string number 1, there are 1");
  EXPECT_EQ(report("1 [1000 0 0 2 0 1] [1]"),
            start + "instruction 1 (add) has operand 1, expected the number of an earlier instruction");
  EXPECT_EQ(report("1 [1000 0 6 -1] [1]"),
            start + "instruction 1 (negate) has operand -1, expected the number of an earlier instruction");
  EXPECT_EQ(report("1 [1000 0 0 2000000000 0] [1]"),
            start + "instruction 1 (add) wants 2000000000 operands, the code array has 1 more");
  EXPECT_EQ(report("1 [1000 0 2 0] [1]"),
            start + "instruction 1 (maximum) has no operands, expected their number, at least 1");
  EXPECT_EQ(report("-2 [1000 0] [1]"),
            "t.rib:2:1: error: range: Blobby is left out: -2 leaves, expected 0 or more");
  EXPECT_EQ(report("1 [1004 0 0 0 0 0] [1] [\"x.so\"]"),
            "t.rib:2:1: warning: unimplemented: Blobby is left out: instruction 0 has opcode 1004, expected "
            "0 to 7 or "
            "1000 to 1003");
}

TEST(BlobbyRequest, UnderAPerspectiveTransformationIsRefused) {
  const Built built = inWorld("Perspective 40\nBlobby 1 [1001 0] [" + kMatrix + "]");
  EXPECT_THAT(
      built.messages,
      ElementsAre("t.rib:3:1: error: math: Blobby under a perspective transformation cannot be drawn"));
}

}  // namespace
}  // namespace patina
