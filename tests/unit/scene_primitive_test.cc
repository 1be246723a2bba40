// SPDX-License-Identifier: Apache-2.0
// Primitives and their variables: counts by RI 3.2, section 5, objects, detail.
#include "renderer/scene/matrices.h"
#include "renderer/scene/teapot.h"
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

std::vector<std::string> namesOf(const Primitive& primitive) {
  std::vector<std::string> names;
  for (const PrimVar& variable : primitive.variables) names.push_back(variable.name);
  return names;
}

TEST(ValueCounts, ByKindOfPrimitive) {
  const auto expect = [](const Shape& shape, size_t vertices, std::array<size_t, 4> expected) {
    const ValueCounts counts = valueCounts(shape, vertices);
    EXPECT_THAT((std::array{counts.uniform, counts.varying, counts.vertex, counts.faceVarying}),
                testing::ElementsAreArray(expected));
  };
  expect(PolygonMesh{{2, 1}, {4, 3, 3}, {0, 1, 2, 3, 4, 5, 6, 0, 1, 2}}, 7, {2, 7, 7, 10});
  expect(SubdivisionMesh{"catmull-clark", {4, 3}, {0, 1, 2, 3, 0, 1, 4}, {}}, 5, {2, 5, 5, 7});
  expect(Quadric{}, 0, {1, 4, 4, 4});
  expect(ParametricMesh{}, 0, {1, 4, 4, 4});
  // 7 x 4 Bezier points: two patches, 3 x 2 corners.
  expect(ParametricMesh{true, 7, 4, false, false, {{}, 3}, {{}, 3}}, 0, {2, 6, 28, 8});
  // Periodic B-spline of 6 points: six patches that share six corners.
  expect(ParametricMesh{true, 6, 4, true, false, {{}, 1}, {{}, 1}}, 0, {6, 12, 24, 24});
  expect(ParametricMesh{false, 5, 3, true, false, {}, {}}, 0, {10, 15, 15, 40});
  expect(PointSet{5}, 0, {1, 5, 5, 5});
  Blobby blobby;
  blobby.leaves = 3;
  expect(blobby, 0, {1, 3, 3, 3});
}

TEST(ValueCounts, PatchesAlongASide) {
  EXPECT_EQ(patchCount(true, 7, 3, false), 2);
  EXPECT_EQ(patchCount(true, 8, 3, false), 0);  // one point left over
  EXPECT_EQ(patchCount(true, 6, 3, true), 2);
  EXPECT_EQ(patchCount(true, 4, 2, false), 1);  // Hermite
  EXPECT_EQ(patchCount(false, 1, 1, false), 0);
  EXPECT_EQ(patchCount(false, 2, 1, false), 1);
}

TEST(Primitives, VariablesWithWrongCountsAreLeftOut) {
  const Built built = inWorld(
      "Polygon \"P\" [0 0 0 1 0 0 0 1 0] \"Cs\" [1 0 0 0 1 0] \"constant float k\" 3 \"uniform string name\" "
      "\"x\" \"st\" [0 0 1 0 0 1]");
  EXPECT_THAT(built.messages,
              ElementsAre("t.rib:2:33: warning: badparamlist: polygon: \"Cs\" has 6 values, expected 9 "
                          "(varying color Cs): variable left out"));
  EXPECT_EQ(built.status, 0);
  EXPECT_THAT(namesOf(built.world().primitives.at(0)), ElementsAre("P", "k", "name", "st"));
  EXPECT_EQ(built.world().primitives[0].variables[3].components, 2);
}

TEST(Primitives, NeedTheirPoints) {
  const Built built = inWorld(
      "Polygon \"N\" [0 0 1 0 0 1 0 0 1]\nPointsPolygons [3] [0 1 3] \"P\" [0 0 0 1 0 0 0 1 0]\nPatch "
      "\"bilinear\" \"P\" [0 0 0]\n"
      "PointsPolygons [3 3] [0 1 2] \"P\" [0 0 0 1 0 0 0 1 0]\nPointsPolygons [3] [0 1 -2] \"P\" [0 0 0 1 0 "
      "0 0 1 0]\n"
      "Sphere 1 -1 1 360");
  EXPECT_THAT(
      built.messages,
      ElementsAre(
          "t.rib:2:1: error: badargument: Polygon is left out: it needs \"P\"",
          "t.rib:3:1: error: badargument: polygon is left out: \"P\" has 9 numbers, expected 12 (4 points)",
          "t.rib:4:1: error: badargument: Patch is left out: \"P\" has 3 numbers, expected 12 (4 points)",
          "t.rib:5:1: error: consistency: polygons are left out: the counts ask for 6 vertices, there are 3",
          "t.rib:6:1: error: consistency: polygons are left out: a negative vertex index"));
  EXPECT_THAT(built.world().primitives, SizeIs(1));
}

TEST(Primitives, PointsThatNoFaceNamesAreDroppedWithTheirValues) {
  const Built built = inWorld(
      "PointsPolygons [3] [0 1 2] \"P\" [0 0 0 1 0 0 0 1 0 9 9 9] \"vertex float a\" [1 2 3 4] \"varying "
      "float b\" [1 2 3]");
  EXPECT_THAT(built.messages, IsEmpty());
  const Primitive& mesh = built.world().primitives.at(0);
  EXPECT_THAT(mesh.variables.at(0).floats, SizeIs(9));
  EXPECT_THAT(mesh.variables.at(1).floats, ElementsAre(1, 2, 3));
  EXPECT_THAT(mesh.variables.at(2).floats, ElementsAre(1, 2, 3));
}

TEST(Primitives, HomogeneousPoints) {
  const Built built = inWorld(
      "Patch \"bilinear\" \"Pw\" [0 0 0 2  2 0 0 2  0 2 0 2  4 4 0 2]\nPatch \"bilinear\" \"Pw\" [0 0 0 1 1 "
      "0 0 1 0 1 0 1 1 1 0 1]\n"
      "Patch \"bilinear\" \"Pw\" [0 0 0 1 1 0 0 0 0 1 0 1 1 1 0 1]");
  EXPECT_THAT(namesOf(built.world().primitives.at(0)), ElementsAre("P", "Pw"));
  EXPECT_THAT(built.world().primitives[0].variables[0].floats,
              ElementsAre(0, 0, 0, 1, 0, 0, 0, 1, 0, 2, 2, 0));
  EXPECT_THAT(namesOf(built.world().primitives.at(1)), ElementsAre("P"));
  EXPECT_THAT(built.messages, ElementsAre(HasSubstr("t.rib:4:1: error: badargument: Patch is left out")));
}

TEST(Primitives, HeightFields) {
  const Built built = inWorld("PatchMesh \"bilinear\" 3 \"nonperiodic\" 2 \"nowrap\" \"Pz\" [1 2 3 4 5 6]");
  EXPECT_THAT(built.messages, IsEmpty());
  EXPECT_THAT(built.world().primitives.at(0).variables.at(0).floats,
              ElementsAre(0, 0, 1, .5f, 0, 2, 1, 0, 3, 0, 1, 4, .5f, 1, 5, 1, 1, 6));
}

TEST(Primitives, PatchMeshesMustComeOut) {
  const Built built = inWorld(
      "PatchMesh \"bicubic\" 8 \"nonperiodic\" 4 \"nonperiodic\" \"P\" []\nPatchMesh \"bicubic\" 7 "
      "\"around\" 4 \"nonperiodic\" \"P\" []");
  EXPECT_THAT(built.messages, ElementsAre("t.rib:2:1: error: consistency: PatchMesh is left out: 8 points "
                                          "along u make no whole number of bicubic patches at the "
                                          "basis' step of 3",
                                          HasSubstr("t.rib:3:1: error: badtoken: PatchMesh \"around\" "
                                                    "\"nonperiodic\": expected periodic or nonperiodic")));
}

TEST(Primitives, BasisIsAnAttribute) {
  const Built built = inWorld(
      "AttributeBegin Basis \"b-spline\" 1 \"b-spline\" 1 PatchMesh \"bicubic\" 5 \"nonperiodic\" 4 "
      "\"nonperiodic\" \"P\" "
      "[0 0 0 1 0 0 2 0 0 3 0 0 4 0 0  0 1 0 1 1 0 2 1 0 3 1 0 4 1 0  0 2 0 1 2 0 2 2 0 3 2 0 4 2 0  0 3 0 1 "
      "3 0 2 3 0 3 3 0 4 3 0] "
      "AttributeEnd Patch \"bicubic\" \"P\" [0 0 0 1 0 0 2 0 0 3 0 0 0 1 0 1 1 0 2 1 0 3 1 0 0 2 0 1 2 0 2 2 "
      "0 3 2 0 0 3 0 1 3 0 2 3 0 3 3 0]");
  EXPECT_THAT(built.messages, IsEmpty());
  const auto& mesh = std::get<ParametricMesh>(built.world().primitives.at(0).shape);
  EXPECT_EQ(mesh.basisU.step, 1);
  EXPECT_NEAR(mesh.basisU.matrix[0][0], -1.0 / 6, 1e-6);
  EXPECT_EQ(std::get<ParametricMesh>(built.world().primitives.at(1).shape).basisU.step, 3);
}

TEST(Primitives, CurvesMustComeOut) {
  const Built built = inWorld(
      "Curves \"cubic\" [4 6] \"nonperiodic\" \"P\" []\nCurves \"linear\" [1] \"periodic\" \"P\" []\n"
      "Curves \"quadratic\" [3] \"nonperiodic\" \"P\" []\nCurves \"linear\" [2] \"around\" \"P\" []\n"
      "Curves \"linear\" [2 2] \"nonperiodic\" \"P\" [0 0 0 1 1 1]\nCurves \"linear\" [] \"nonperiodic\" "
      "\"P\" []\n"
      "Basis \"b-spline\" 1 \"b-spline\" 1 Curves \"cubic\" [-2147483648] \"nonperiodic\" \"P\" []");
  EXPECT_THAT(
      built.messages,
      ElementsAre("t.rib:2:1: error: consistency: Curves are left out: 6 points make no whole number of "
                  "cubic segments at the basis' step of 3 (curve 1)",
                  "t.rib:3:1: error: consistency: Curves are left out: 1 points make no whole number of "
                  "linear segments (curve 0)",
                  HasSubstr("t.rib:4:1: error: badtoken: Curves \"quadratic\": expected linear or cubic"),
                  HasSubstr("Curves \"around\": expected periodic or nonperiodic"),
                  HasSubstr("\"P\" has 6 numbers, expected 12 (4 points)"),
                  HasSubstr("-2147483648 points make no whole number")));
}

TEST(Primitives, RoundCurvesAreAnAttribute) {
  const Built built = buildClean(
      "WorldBegin Curves \"linear\" [2] \"nonperiodic\" \"P\" [0 0 0 1 0 0] AttributeBegin "
      "Attribute \"dice\" \"int roundcurve\" [1] \"int hair\" [1] "
      "Curves \"linear\" [2] \"nonperiodic\" \"P\" [0 0 0 1 0 0] Attribute \"dice\" \"int binary\" [1] "
      "Curves \"linear\" [2] \"nonperiodic\" \"P\" [0 0 0 1 0 0] AttributeEnd "
      "Curves \"linear\" [2] \"nonperiodic\" \"P\" [0 0 0 1 0 0] WorldEnd");
  std::vector<bool> round;
  for (const Primitive& p : built.world().primitives) round.push_back(std::get<CurveSet>(p.shape).round);
  EXPECT_THAT(round, ElementsAre(false, true, true, false));
}

TEST(Primitives, SubdivisionTagsTakeTheirShares) {
  const Built built = inWorld(
      "SubdivisionMesh \"catmull-clark\" [4] [0 1 2 3] [\"crease\" \"interpolateboundary\" \"corner\"] [2 1 "
      "0 0 1 1] [0 1 3] [2.5 4] "
      "\"P\" [0 0 0 1 0 0 1 1 0 0 1 0]\nSubdivisionMesh \"catmull-clark\" [4] [0 1 2 3] \"P\" [0 0 0 1 0 0 1 "
      "1 0 0 1 0]\n"
      "SubdivisionMesh \"none\" [4] [0 1 2 3] \"P\" [0 0 0 1 0 0 1 1 0 0 1 0]");
  EXPECT_THAT(built.messages, IsEmpty());
  const auto& mesh = std::get<SubdivisionMesh>(built.world().primitives.at(0).shape);
  ASSERT_THAT(mesh.tags, SizeIs(3));
  EXPECT_THAT(mesh.tags[0].ints, ElementsAre(0, 1));
  EXPECT_THAT(mesh.tags[0].floats, ElementsAre(2.5f));
  EXPECT_THAT(mesh.tags[1].ints, IsEmpty());
  EXPECT_THAT(mesh.tags[2].ints, ElementsAre(3));
  EXPECT_THAT(mesh.tags[2].floats, ElementsAre(4));
  EXPECT_THAT(std::get<SubdivisionMesh>(built.world().primitives.at(1).shape).tags, IsEmpty());
  EXPECT_TRUE(std::holds_alternative<PolygonMesh>(built.world().primitives.at(2).shape));
}

TEST(Primitives, QuadricsKeepTheOrderOfTheRequest) {
  const Built built = inWorld("Hyperboloid 1 2 3 4 5 6 270 Torus [5 1 10 20 30]");
  const auto& hyperboloid = std::get<Quadric>(built.world().primitives.at(0).shape);
  EXPECT_THAT(hyperboloid.values, ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_EQ(hyperboloid.thetaMax, 270);
  EXPECT_THAT(std::get<Quadric>(built.world().primitives.at(1).shape).values,
              ElementsAre(5, 1, 10, 20, 0, 0));
}

TEST(Primitives, OutsideOfTheWorldTheyAreAnError) {
  const Built built = build("Sphere 1 -1 1 360\nSphere 1 -1 1 360\n");
  EXPECT_THAT(
      built.messages,
      ElementsAre(
          "t.rib:1:1: error: illstate: primitives outside of WorldBegin and ObjectBegin are ignored"));
}

TEST(Primitives, WhatIsNotCarriedOutIsCounted) {
  const Built built = inWorld("Volume \"box\" [-1 1 -1 1 -1 1] [0 0 0]\nInterior \"fog\"\nInterior \"fog\"");
  EXPECT_THAT(built.messages,
              testing::UnorderedElementsAre(
                  "t.rib:2:1: warning: unimplemented: request Volume is not carried out yet (once)",
                  "t.rib:3:1: warning: unimplemented: request Interior is not carried out yet (2 times)"));
}

TEST(Primitives, TheTeapotIsClosedAroundItsAxisAndFacesOut) {
  const std::vector<TeapotPart> parts = teapot();
  ASSERT_THAT(parts, SizeIs(4));
  float lowest = 100, highest = -100;
  for (const TeapotPart& part : parts) {
    const auto nu = static_cast<size_t>(part.mesh.nu), nv = static_cast<size_t>(part.mesh.nv);
    ASSERT_EQ(part.points.size(), nu * nv * 3);
    const auto point = [&](size_t u, size_t v) {
      return V3f(part.points[(v * nu + u) * 3], part.points[(v * nu + u) * 3 + 1],
                 part.points[(v * nu + u) * 3 + 2]);
    };
    // Bezier tangents at the start of the second row of patches, against the direction away from the row's
    // middle.
    V3f middle(0);
    for (size_t u = 0; u + 1 < nu; ++u) middle += point(u, 3) / static_cast<float>(nu - 1);
    EXPECT_EQ(point(0, 3), point(nu - 1, 3));
    const V3f normal = (point(1, 3) - point(0, 3)).cross(point(0, 4) - point(0, 3));
    EXPECT_GT(normal.dot(point(0, 3) - middle), 0);
    for (size_t i = 2; i < part.points.size(); i += 3) {
      lowest = std::min(lowest, part.points[i]);
      highest = std::max(highest, part.points[i]);
    }
  }
  EXPECT_FLOAT_EQ(lowest, 0);
  EXPECT_FLOAT_EQ(highest, 3);
  EXPECT_THAT(inWorld("Geometry \"teapot\"").world().primitives, SizeIs(4));
}

// ---- Objects, detail
// ---------------------------------------------------------------------------------------

TEST(Objects, TakeAttributesAndPlaceOfTheInstance) {
  const Built built = buildClean(
      "ObjectBegin \"o\" Translate 1 0 0 Sphere 1 -1 1 360 Color 0 0 1 Sphere 1 -1 1 360 ObjectEnd Translate "
      "0 0 5 WorldBegin "
      "Color 1 0 0 Translate 0 2 0 ObjectInstance \"o\" ObjectBegin 2 Sphere 1 -1 1 360 ObjectEnd "
      "ObjectInstance 2 WorldEnd");
  const Scene& scene = built.world();
  ASSERT_THAT(scene.objects, SizeIs(2));
  EXPECT_EQ(scene.objects[0].primitives.at(0).attributes, kNone);
  EXPECT_EQ(scene.attributes.at(scene.objects[0].primitives.at(1).attributes).color, Rgb(0, 0, 1));
  expectMatrix(scene.objects[0].primitives[0].objectToWorld, translation(1, 0, 0), 0);
  expectMatrix(scene.instances.at(0).objectToWorld, translation(0, 2, 0), 0);
  EXPECT_EQ(scene.attributes.at(scene.instances[0].attributes).color, Rgb(1, 0, 0));
  EXPECT_EQ(scene.instances.at(1).object, 1u);
  EXPECT_THAT(scene.primitives, IsEmpty());
}

TEST(Objects, UnknownAndNested) {
  const Built built = build(
      "WorldBegin\nObjectInstance 3\nObjectBegin 1\nObjectBegin 2\nObjectInstance 1\nObjectEnd\nWorldEnd");
  EXPECT_THAT(
      built.messages,
      ElementsAre("t.rib:2:1: error: badhandle: ObjectInstance: no object has the handle \"3\"",
                  "t.rib:4:1: error: nesting: ObjectBegin inside ObjectBegin",
                  HasSubstr("request ObjectInstance inside ObjectBegin is not carried out yet (once)")));
}

TEST(Detail, OfAllLevelsOneIsDrawnAtEverySize) {
  // In perspective at distance d a square of side 1 across the view covers (50 / d)^2 of 100 x 100 pixels
  // over 90 degrees. Levels change in the middle of their transitions: at 150 and 1100 pixels.
  for (const double relative : {1.0, 0.25})
    for (double pixels = 20; pixels < 2500; pixels *= 1.07) {
      const std::string text =
          "RelativeDetail " + std::to_string(relative) +
          " Format 100 100 1 Projection \"perspective\" \"fov\" 90 WorldBegin Translate 0 0 " +
          std::to_string(50 / std::sqrt(pixels)) +
          " Detail [-.5 .5 -.5 .5 0 0] DetailRange 0 0 100 200 Sphere 1 -1 1 360 "
          "DetailRange 100 200 1000 1200 Sphere 2 -2 2 360 DetailRange 1000 1200 1e38 1e38 Sphere 3 -3 3 360 "
          "WorldEnd";
      const double size = pixels * relative;
      if (std::abs(size / 150 - 1) < 1e-3 || std::abs(size / 1100 - 1) < 1e-3) continue;
      const Built built = buildClean(text);
      ASSERT_THAT(built.world().primitives, SizeIs(1)) << size;
      EXPECT_EQ(std::get<Quadric>(built.world().primitives[0].shape).values[0], size < 150    ? 1
                                                                                : size < 1100 ? 2
                                                                                              : 3)
          << size;
    }
}

TEST(Detail, IsTheAreaAroundThePictureOfTheBox) {
  // Orthographic, 200 x 100 pixels over [-2, 2] x [-1, 1]: a unit cube turned by 45 degrees about z is
  // sqrt(2) wide and high: 2 * 50 * 50 pixels. A box that reaches behind the eye is as large as can be.
  const auto drawn = [](const std::string& where, const std::string& range) {
    return !buildClean("Format 200 100 1 " + where + " DetailRange " + range + " Sphere 1 -1 1 360 WorldEnd")
                .world()
                .primitives.empty();
  };
  const std::string turned = "WorldBegin Translate 0 0 2 Rotate 45 0 0 1 Detail [-.5 .5 -.5 .5 -.5 .5]";
  EXPECT_TRUE(drawn(turned, "4990 4990 5010 5010"));
  EXPECT_FALSE(drawn(turned, "5010 5010 1e38 1e38"));
  const std::string around =
      "Projection \"perspective\" WorldBegin Translate 0 0 .1 Detail [-.5 .5 -.5 .5 -.5 .5]";
  EXPECT_TRUE(drawn(around, "1e9 1e10 1e38 1e38"));
  // Without Detail the highest level is drawn, and ranges that are not in order are not taken.
  EXPECT_TRUE(drawn("WorldBegin", "100 200 1e38 1e38"));
  EXPECT_FALSE(drawn("WorldBegin", "0 0 100 200"));
}

TEST(Detail, DrawsTheLevelOfItsSize) {
  // Orthographic, 100 x 100 pixels over [-1, 1]: a box of half the width covers 50 x 50 = 2500 pixels.
  const std::string head = "Format 100 100 1 WorldBegin Translate 0 0 2 Detail [-.5 .5 -.5 .5 -.5 .5] ";
  EXPECT_THAT(buildClean(head + "DetailRange 0 0 1000 2000 Sphere 1 -1 1 360 WorldEnd").world().primitives,
              IsEmpty());
  EXPECT_THAT(
      buildClean(head + "DetailRange 1000 2000 1e38 1e38 Sphere 1 -1 1 360 WorldEnd").world().primitives,
      SizeIs(1));
  EXPECT_THAT(
      buildClean(head + "DetailRange 2000 2400 4000 5000 Sphere 1 -1 1 360 WorldEnd").world().primitives,
      SizeIs(1));
  EXPECT_THAT(
      buildClean("RelativeDetail .5 " + head + "DetailRange 1000 2000 1e38 1e38 Sphere 1 -1 1 360 WorldEnd")
          .world()
          .primitives,
      IsEmpty());
}

TEST(Primitives, DenseMeshesKeepNoCountsThatAreEqual) {
  const auto mesh = [](int triangles, const std::string& counts, const std::string& more) {
    std::string text = counts.empty() ? "PointsPolygons [" : "PointsGeneralPolygons [" + counts + "] [",
                points;
    for (int k = 0; k < triangles; ++k) text += "3 ";
    text += "] [";
    for (int k = 0; k < triangles; ++k)
      text += std::to_string(k) + ' ' + std::to_string(k + 1) + ' ' + std::to_string(k + 2) + ' ';
    for (int k = 0; k < triangles + 2; ++k) points += std::to_string(k) + ' ' + std::to_string(k % 2) + " 0 ";
    return text + "] \"P\" [" + points + "]" + more;
  };
  std::string ones;
  for (int k = 0; k < 2000; ++k) ones += "1 ";
  const std::string numbers = " \"uniform float number\" [" + ones + "]";
  const Built built =
      inWorld(mesh(2000, "", numbers) + "\n" + mesh(2000, ones, "") + "\n" + mesh(3, "1 1 1", ""));
  EXPECT_THAT(built.messages, IsEmpty());
  ASSERT_THAT(built.world().primitives, SizeIs(3));
  for (size_t k = 0; k < 3; ++k) {
    const auto& polygons = std::get<PolygonMesh>(built.world().primitives[k].shape);
    const bool dense = k < 2;
    EXPECT_EQ(polygons.faceCount(), dense ? 2000u : 3u);
    EXPECT_EQ(polygons.loopsPerFace.capacity(), dense ? 0u : 3u);
    EXPECT_EQ(polygons.vertsPerLoop.capacity(), dense ? 0u : 3u);
    EXPECT_EQ(polygons.sides, dense ? 3 : 0);
  }
  EXPECT_THAT(built.world().primitives[0].variables, SizeIs(2));  // the values were counted
  EXPECT_THAT(inWorld("PointsGeneralPolygons [] [3] [0 1 2] \"P\" [0 0 0 1 0 0 0 1 0]").messages,
              ElementsAre(HasSubstr("polygons are left out: the counts ask for 0 loops, there are 1")));
}

}  // namespace
}  // namespace patina
