// SPDX-License-Identifier: Apache-2.0
// NuPatch and TrimCurve: counts, ranges, the attribute and its blocks, every message.
#include "renderer/scene/trim_region.h"
#include "renderer/scene/value_count.h"
#include "scene_fixture.h"

namespace patina {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

Built inWorld(std::string_view requests) {
  return build("WorldBegin\n" + std::string(requests) + "\nWorldEnd\n");
}

constexpr const char* kSquare =
    "NuPatch 2 2 [0 0 1 1] 0 1 2 2 [0 0 1 1] 0 1 \"P\" [0 0 0 1 0 0 0 1 0 1 1 0]\n";
constexpr const char* kTriangle =
    "TrimCurve [1] [2] [0 0 1 2 3 3] [0] [3] [4] [.1 .9 .1 .1] [.1 .1 .9 .1] [1 1 1 1]\n";

const NurbsPatch& patchOf(const Built& built, size_t primitive) {
  return std::get<NurbsPatch>(built.world().primitives.at(primitive).shape);
}

TEST(NuPatch, KeepsItsNumbersAndVariables) {
  const Built built = inWorld(
      "NuPatch 4 3 [0 0 0 1 2 2 2] 0 2 2 2 [0 0 1 1] .25 1 \"Pw\" [0 0 0 1 1 0 0 2 2 0 0 1 3 0 0 1 0 1 0 1 1 "
      "1 "
      "0 1 2 1 0 1 3 1 0 1] \"uniform float k\" [1 2] \"varying float s\" [1 2 3 4 5 6] \"vertex float t\" "
      "[1 2 "
      "3 4 5 6 7 8] \"facevarying float f\" [1 2 3 4 5 6 7 8]");
  EXPECT_THAT(built.messages, IsEmpty());
  const NurbsPatch& patch = patchOf(built, 0);
  EXPECT_EQ(patch.u.count, 4);
  EXPECT_EQ(patch.u.order, 3);
  EXPECT_THAT(patch.u.knots, ElementsAre(0, 0, 0, 1, 2, 2, 2));
  EXPECT_EQ(patch.u.max, 2);
  EXPECT_EQ(patch.v.min, 0.25f);
  EXPECT_EQ(patch.trim, nullptr);
  EXPECT_THAT(built.world().primitives[0].variables, SizeIs(6));  // P, Pw and the four
}

TEST(NuPatch, RangesAreCutToTheKnots) {
  const Built built =
      inWorld("NuPatch 2 2 [0 0 1 1] -.5 2 2 2 [0 0 1 1] 0 1 \"P\" [0 0 0 1 0 0 0 1 0 1 1 0]");
  EXPECT_THAT(built.messages,
              ElementsAre("t.rib:2:1: warning: range: NuPatch: umin and umax are cut to 0 and 1, "
                          "between which the knots define something"));
  EXPECT_EQ(patchOf(built, 0).u.min, 0);
  EXPECT_EQ(patchOf(built, 0).u.max, 1);
}

TEST(NuPatch, WhatIsWrongIsNamed) {
  const Built built = inWorld(
      "NuPatch 2 3 [0 0 1 1] 0 1 2 2 [0 0 1 1] 0 1 \"P\" []\n"
      "NuPatch 2 2 [0 0 1 1] 0 1 2 2 [0 1 0 1] 0 1 \"P\" []\n"
      "NuPatch 2 2 [0 0 1 1] 2 3 2 2 [0 0 1 1] 0 1 \"P\" []\n"
      "NuPatch 2 2 [0 0 1 1] 0 1 2 2 [0 0 1 1] 0 1 \"P\" [0 0 0]\n"
      "NuPatch 2 2 [0 0 1 1] 0 1 2 2 [0 0 1 1] 0 1 \"Pw\" [0 0 0 1 1 0 0 1e-30 0 1 0 1 1 1 0 1]\n"
      "NuPatch 2 2 [0 0 1 1] 0 1 2 2 [0 0 1 1] 0 1 \"Pw\" [0 0 0 1 1 0 0 1 0 1 0 -1 1 1 0 1]\n"
      "NuPatch 2000000000 2 [0 0 1 1] 0 1 2000000000 2 [0 0 1 1] 0 1 \"P\" [0 0 0]\n"
      "Perspective 50 NuPatch 2 2 [0 0 1 1] 0 1 2 2 [0 0 1 1] 0 1 \"P\" [0 0 0 1 0 0 0 1 0 1 1 0]");
  EXPECT_THAT(
      built.messages,
      ElementsAre(
          "t.rib:2:1: error: consistency: NuPatch is left out: along u, 2 control points, expected at least "
          "the "
          "order, 3",
          "t.rib:3:1: error: range: NuPatch is left out: along v, knots must not fall; knot 2 (0) comes "
          "after 1",
          "t.rib:4:1: error: range: NuPatch is left out: along u, the range 2 to 3 is empty or outside of 0 "
          "to 1, "
          "where the knots define something",
          "t.rib:5:1: error: badargument: NuPatch is left out: \"P\" has 3 numbers, expected 12 (4 points)",
          "t.rib:6:1: error: range: NuPatch is left out: the weight of point 1 is not 0, or between 1e-18 "
          "and "
          "1e+18",
          "t.rib:7:1: error: range: NuPatch is left out: the weight of point 2 is not 0, or between 1e-18 "
          "and "
          "1e+18",
          "t.rib:8:1: error: consistency: NuPatch is left out: along u, 4 knots, expected 2000000002 "
          "(control "
          "points plus order)",
          "t.rib:9:16: error: math: NuPatch under a perspective transformation cannot be drawn"));
  EXPECT_THAT(built.world().primitives, IsEmpty());
}

TEST(TrimCurve, IsAnAttribute) {
  const Built built = inWorld(std::string(kSquare) + "AttributeBegin\n" + kTriangle +
                              "Attribute \"trimcurve\" \"string sense\" \"outside\"\n" + kSquare +
                              "TrimCurve [] [] [] [] [] [] [] [] []\n" + kSquare + "AttributeEnd\n" +
                              kSquare + kTriangle + kSquare + kSquare);
  EXPECT_THAT(built.messages, IsEmpty());
  EXPECT_EQ(patchOf(built, 0).trim, nullptr);
  ASSERT_NE(patchOf(built, 1).trim, nullptr);
  EXPECT_TRUE(patchOf(built, 1).keepInside);
  EXPECT_TRUE(patchOf(built, 1).trim->contains(0.2, 0.2));
  EXPECT_FALSE(patchOf(built, 1).trim->contains(0.7, 0.7));
  EXPECT_EQ(patchOf(built, 2).trim, nullptr);
  EXPECT_EQ(patchOf(built, 3).trim, nullptr);
  ASSERT_NE(patchOf(built, 4).trim, nullptr);
  EXPECT_FALSE(patchOf(built, 4).keepInside);
  EXPECT_EQ(patchOf(built, 4).trim, patchOf(built, 5).trim);  // shared
}

TEST(TrimCurve, LoopsOfSeveralCurves) {
  // A triangle of three lines, and within it a square of one curve.
  const Built built = inWorld(
      std::string(
          "TrimCurve [3 1] [2 2 2 2] [0 0 1 1 0 0 1 1 0 0 1 1 0 0 1 2 3 4 4] [0 0 0 0] [1 1 1 4] [2 2 2 5] "
          "[0 1 1 0 0 0 .2 .3 .3 .2 .2] [0 0 0 1 1 0 .2 .2 .3 .3 .2] [1 1 1 1 1 1 1 1 1 1 1]\n") +
      kSquare);
  EXPECT_THAT(built.messages, IsEmpty());
  const TrimRegion& region = *patchOf(built, 0).trim;
  EXPECT_TRUE(region.contains(0.1, 0.1));
  EXPECT_FALSE(region.contains(0.25, 0.25));
  EXPECT_FALSE(region.contains(0.6, 0.6));
}

TEST(TrimCurve, OpenLoopsWarnOnce) {
  const std::string open = "TrimCurve [1] [2] [0 0 1 2 2] [0] [2] [3] [.1 .9 .1] [.1 .1 .9] [1 1 1]\n";
  const Built built = inWorld(open + kSquare + open + kSquare);
  EXPECT_THAT(
      built.messages,
      ElementsAre("t.rib:2:1: warning: consistency: TrimCurve: loops must be closed; a straight line joins "
                  "the ends of this one"));
  EXPECT_TRUE(patchOf(built, 0).trim->contains(0.2, 0.2));
}

TEST(TrimCurve, WhatIsWrongIsNamedAndChangesNothing) {
  const std::string tail = " [.1 .9 .1] [.1 .1 .9] [1 1 1]\n";
  for (const auto& [request, message] : std::vector<std::pair<std::string, std::string>>{
           {"[-1] [2] [0 0 1 2 2] [0] [2] [3]" + tail,
            "consistency: TrimCurve is left out: an order or a number"},
           {"[0] [] [] [] [] [] [] [] []\n", "a loop has no curve"},
           {"[2] [2] [0 0 1 2 2] [0] [2] [3]" + tail, "1 orders, 1 min, 1 max and 1 n, expected 2 (curves)"},
           {"[1] [2] [0 0 1 2] [0] [2] [3]" + tail, "4 knots, expected 5 (points plus orders of all curves)"},
           {"[1] [2] [0 0 1 2 2] [0] [2] [3] [0 1] [0 1 2] [1 1 1]\n", "2 u, 3 v and 3 w, expected 3"},
           {"[1] [2] [0 0 1 2 2] [0] [2] [3] [0 1 2] [0 1 2] [1 0 1]\n",
            "range: TrimCurve is left out: the weight "
            "of point 1 is 0, expected 1e-18 to 1e+18"},
           {"[1] [1] [0 0 1 2] [0] [2] [3]" + tail, "curve 0: order 1, expected 2 to 32"},
           {"[1] [2] [0 0 3 2 2] [0] [2] [3]" + tail, "curve 0: knots must not fall"},
           {"[1] [2] [0 0 1 2 2] [5] [6] [3]" + tail, "curve 0: the range 5 to 6 is empty"}}) {
    const Built built = inWorld(kTriangle + ("TrimCurve " + request) + kSquare);
    EXPECT_THAT(built.messages, ElementsAre(HasSubstr(message))) << request;
    EXPECT_EQ(built.status, 1);
    EXPECT_NE(patchOf(built, 0).trim, nullptr);  // the one before holds
  }
  EXPECT_THAT(inWorld("TrimCurve [1] [2] [0 0 1 2 3 3] [-1] [5] [4] [0 1 0 0] [0 0 1 0] [1 1 1 1]").messages,
              ElementsAre(HasSubstr("warning: range: TrimCurve: min and max are cut")));
  EXPECT_THAT(inWorld("Attribute \"trimcurve\" \"string sense\" \"left\"").messages,
              ElementsAre(HasSubstr("\"sense\" \"left\": expected inside or outside")));
}

}  // namespace
}  // namespace patina
