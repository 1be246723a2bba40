// SPDX-License-Identifier: Apache-2.0
// Attributes, light lists and shader bindings.
#include "renderer/scene/matrices.h"
#include "scene_fixture.h"

namespace patina {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

TEST(Attributes, ScopeAndSharing) {
  const Built built = buildClean(
      "ShadingRate 4 WorldBegin Color 1 0 0 Sphere 1 -1 1 360 Sphere 1 -1 1 360 AttributeBegin Color [0 1 0] "
      "Sides 1 "
      "Sphere 1 -1 1 360 AttributeEnd Sphere 1 -1 1 360 Color 0 1 0 Sides 1 Sphere 1 -1 1 360 WorldEnd");
  const Scene& scene = built.world();
  EXPECT_THAT(scene.attributes, SizeIs(2));
  EXPECT_EQ(scene.primitives[0].attributes, scene.primitives[1].attributes);
  EXPECT_EQ(scene.primitives[0].attributes, scene.primitives[3].attributes);
  EXPECT_EQ(scene.primitives[2].attributes, scene.primitives[4].attributes);
  EXPECT_EQ(built.attributesOf(2).color, Rgb(0, 1, 0));
  EXPECT_TRUE(built.attributesOf(2).oneSided);
  EXPECT_FALSE(built.attributesOf(3).oneSided);
  EXPECT_EQ(built.attributesOf(0).shadingRate, 4);
}

TEST(Attributes, RepeatedShadersAreStoredOnce) {
  std::string text = "WorldBegin\n";
  for (int i = 0; i < 1000; ++i) text += "Surface \"plastic\" \"Kd\" .5 Polygon \"P\" [0 0 0 1 0 0 0 1 0]\n";
  const Scene scene = buildClean(text +
                                 "Surface \"plastic\" \"Kd\" .6 Sphere 1 -1 1 360 Translate 1 0 0 "
                                 "Surface \"plastic\" \"Kd\" .6 Sphere 1 -1 1 360 WorldEnd")
                          .world();
  EXPECT_THAT(scene.shaders, SizeIs(3));
  EXPECT_THAT(scene.attributes, SizeIs(3));
}

TEST(Attributes, ShaderArgumentsAndSpace) {
  const Built built = build(
      "Declare \"knots\" \"uniform float[3]\"\nWorldBegin Translate 1 2 3\n"
      "Surface \"s\" \"float Kd\" 2 \"color c\" [1 2 3] \"knots\" [4 5 6] \"string n\" \"x\" \"color d\" [1 "
      "2] \"texturename\" []\n"
      "Sphere 1 -1 1 360 WorldEnd");
  EXPECT_THAT(
      built.messages,
      ElementsAre("t.rib:3:75: warning: badparamlist: parameter \"d\" of \"s\" has 2 values, expected 3 "
                  "(uniform color d): left at its default"));
  const ShaderBinding& shader = built.world().shaders.at(built.attributesOf(0).surface);
  expectMatrix(shader.shaderToWorld, translation(1, 2, 3), 0);
  ASSERT_THAT(shader.arguments, SizeIs(4));
  EXPECT_THAT(shader.arguments[1].floats, ElementsAre(1, 2, 3));
  EXPECT_EQ(shader.arguments[1].type, ValueType::Color);
  EXPECT_EQ(shader.arguments[2].arrayLength, 3);
  EXPECT_THAT(shader.arguments[3].strings, ElementsAre("x"));
  EXPECT_EQ(shader.arguments[0].where.column, 13u);
}

TEST(Attributes, VisibilityInItsSpellings) {
  const auto visibility = [](std::string_view attribute) {
    return buildClean("WorldBegin " + std::string(attribute) + " Sphere 1 -1 1 360 WorldEnd").attributesOf(0);
  };
  EXPECT_EQ(visibility("Attribute \"visibility\" \"int camera\" 0 \"int diffuse\" [0]").visibility,
            kSpecularRay | kTransmissionRay);
  EXPECT_EQ(visibility("Attribute \"visibility\" \"int trace\" 0").visibility, kCameraRay | kTransmissionRay);
  EXPECT_FALSE(visibility("Attribute \"visibility\" \"string transmission\" \"transparent\"").castsShadows);
  EXPECT_TRUE(visibility("Attribute \"visibility\" \"string transmission\" \"opaque\"").castsShadows);
  EXPECT_FALSE(visibility("Attribute \"render\" \"string casts_shadows\" \"none\"").castsShadows);
}

TEST(Attributes, TraceDepthsNamesAndBounds) {
  const Built built = buildClean(
      "WorldBegin Attribute \"trace\" \"int maxdiffusedepth\" 5 \"float bias\" .1 Attribute \"identifier\" "
      "\"name\" \"teapot\"\n"
      "Scale 2 2 2 Attribute \"displacementbound\" \"sphere\" 3 \"coordinatesystem\" \"world\" Sphere 1 -1 1 "
      "360\n"
      "Attribute \"displacementbound\" \"sphere\" [3] Sphere 1 -1 1 360 WorldEnd");
  EXPECT_EQ(built.attributesOf(0).maxDiffuseDepth, 5);
  EXPECT_EQ(built.attributesOf(0).maxSpecularDepth, 2);
  EXPECT_EQ(built.attributesOf(0).name, "teapot");
  EXPECT_FLOAT_EQ(built.attributesOf(0).displacementBound,
                  1.5f);  // 3 in the world is 1.5 in a space scaled by 2
  EXPECT_FLOAT_EQ(built.attributesOf(1).displacementBound, 3);
}

TEST(Attributes, WrongValues) {
  const Built built = build(
      "WorldBegin\nColor [1 2]\nShadingRate 0\nSides 3\nOrientation \"up\"\nShadingInterpolation \"bob\"\n"
      "DetailRange 3 2 1 0\nWorldEnd");
  EXPECT_EQ(built.status, 1);
  EXPECT_THAT(built.messages,
              ElementsAre(HasSubstr("t.rib:2:1: error: badcolor: Color has 2 values"),
                          HasSubstr("t.rib:3:1: error: range: ShadingRate 0"),
                          HasSubstr("t.rib:4:1: error: range: Sides 3"),
                          HasSubstr("t.rib:5:1: error: badtoken: Orientation \"up\""),
                          HasSubstr("t.rib:6:1: error: badtoken: ShadingInterpolation \"bob\""),
                          HasSubstr("t.rib:7:1: error: range: DetailRange")));
}

TEST(Attributes, DicingByPixelsAndBySpace) {
  const auto dice = [](std::string_view requests) {
    return buildClean("WorldBegin " + std::string(requests) + " Sphere 1 -1 1 360 WorldEnd").attributesOf(0);
  };
  EXPECT_EQ(dice("ShadingRate 9 Attribute \"dice\" \"float micropolygonlength\" [2]").shadingRate, 4);
  EXPECT_EQ(dice("ShadingRate 9 Attribute \"dice\" \"float micropolygonlength\" 0").shadingRate, 9);
  EXPECT_EQ(dice("Attribute \"dice\" \"float[2] micropolygonlength\" [3 5]").shadingRate, 9);
  EXPECT_TRUE(dice("").foreshorten);
  EXPECT_FALSE(dice("Attribute \"dice\" \"int rasterorient\" 0 \"int binary\" 1").foreshorten);
  const Attributes world =
      dice("Attribute \"dice\" \"string strategy\" \"worlddistance\" \"float worlddistancelength\" 0.25");
  EXPECT_EQ(world.diceLength, 0.25f);
  EXPECT_FALSE(world.diceInObjectSpace);
  const Attributes object =
      dice("Attribute \"dice\" \"string strategy\" \"objectdistance\" \"float micropolygonlength\" 3");
  EXPECT_EQ(object.diceLength, 3);
  EXPECT_TRUE(object.diceInObjectSpace);
  EXPECT_EQ(
      dice("Attribute \"dice\" \"string strategy\" \"worlddistance\" Attribute \"dice\" \"string strategy\" "
           "\"planarprojection\"")
          .diceLength,
      0);
  EXPECT_EQ(dice("Attribute \"dice\" \"float worlddistancelength\" 2").diceLength, 0)
      << "the strategy is another";
  // What changes nothing leaves an object's attributes to its instances.
  EXPECT_EQ(
      buildClean("WorldBegin ObjectBegin 1 Attribute \"dice\" \"int binary\" 1 Sphere 1 -1 1 360 ObjectEnd "
                 "ObjectInstance 1 WorldEnd")
          .world()
          .objects[0]
          .primitives[0]
          .attributes,
      kNone);
  const Built built = build(
      "WorldBegin\nAttribute \"dice\" \"string strategy\" \"best\"\nAttribute \"dice\" \"string "
      "referencecamera\" "
      "\"main\" \"int minsplits\" 1\nGeometricApproximation \"motionfactor\" 1\nGeometricApproximation "
      "\"flatness\" 2\n"
      "GeometricApproximation \"flatness\" -1\nWorldEnd");
  EXPECT_THAT(
      built.messages,
      ElementsAre(
          HasSubstr("t.rib:2:18: error: badtoken: Attribute \"dice\" \"strategy\" \"best\": expected "),
          "t.rib:6:1: error: range: GeometricApproximation \"flatness\" -1 is negative",
          HasSubstr("Attribute \"dice\" \"minsplits\" has no effect (once)"),
          HasSubstr("Attribute \"dice\" \"referencecamera\" has no effect (once)"),
          HasSubstr("GeometricApproximation \"motionfactor\" has no effect (once)")));
}

// ---- Attribute "user"
// ---------------------------------------------------------------------------------------------------------

TEST(UserAttributes, FollowBlocksAndAreStoredOnce) {
  const Built built = buildClean(
      "WorldBegin Attribute \"user\" \"float wet\" [0.5] \"string kind\" [\"oak\"] Sphere 1 -1 1 360 "
      "AttributeBegin Attribute \"user\" \"int wet\" [2] \"color c\" [1 2 3] Sphere 1 -1 1 360 AttributeEnd "
      "Attribute \"user\" \"string kind\" [\"oak\"] Sphere 1 -1 1 360 WorldEnd");
  const UserAttributes& first = built.attributesOf(0).user;
  ASSERT_NE(first.find("wet"), nullptr);
  EXPECT_THAT(first.find("wet")->floats, ElementsAre(0.5f));
  EXPECT_THAT(first.find("kind")->strings, ElementsAre("oak"));
  EXPECT_EQ(first.find("c"), nullptr);
  const UserAttributes& second = built.attributesOf(1).user;
  EXPECT_THAT(second.find("wet")->ints, ElementsAre(2));
  EXPECT_THAT(second.find("c")->floats, ElementsAre(1, 2, 3));
  EXPECT_THAT(second.find("kind")->strings, ElementsAre("oak"));
  EXPECT_EQ(built.world().primitives[0].attributes, built.world().primitives[2].attributes);
  EXPECT_NE(built.world().primitives[0].attributes, built.world().primitives[1].attributes);
}

TEST(UserAttributes, WithWrongValuesOrTooManyAreReported) {
  std::string many = "WorldBegin\nAttribute \"user\" \"float[2] a\" [1 2 3]\nAttribute \"user\"";
  for (int k = 0; k < 258; ++k) many += " \"int n" + std::to_string(k) + "\" [1]";
  const Built built = build(many + "\nAttribute \"user\" \"int n0\" [7] Sphere 1 -1 1 360 WorldEnd");
  EXPECT_THAT(
      built.messages,
      ElementsAre(
          HasSubstr("t.rib:2:18: warning: badparamlist: parameter \"a\" of Attribute \"user\" "
                    "has 3 values, expected 2 (uniform float[2] a): left at its default"),
          HasSubstr("t.rib:3:3748: error: limitcheck: Attribute \"user\" \"n256\": there are 256 others "
                    "already"),
          HasSubstr("t.rib:3:3763: error: limitcheck: Attribute \"user\" \"n257\": there are 256 others "
                    "already")));
  EXPECT_EQ(built.attributesOf(0).user.find("n257"), nullptr);
  EXPECT_THAT(built.attributesOf(0).user.find("n0")->ints, ElementsAre(7));  // it is known already
}

TEST(UserAttributes, TellRequestsOfShadersApart) {
  const Built built = buildClean(
      "WorldBegin Surface \"matte\" Sphere 1 -1 1 360 Attribute \"user\" \"int k\" [1] Surface \"matte\" "
      "Sphere 1 -1 1 360 Attribute \"user\" \"int k\" [2] Surface \"matte\" Sphere 1 -1 1 360 "
      "Attribute \"user\" \"int k\" [1] Surface \"matte\" Sphere 1 -1 1 360 Surface \"matte\" \"Kd\" [0.5] "
      "Sphere 1 -1 1 360 WorldEnd");
  const auto& shaders = built.world().shaders;
  ASSERT_THAT(shaders, SizeIs(4));
  EXPECT_EQ(built.attributesOf(3).surface, built.attributesOf(1).surface);
  for (size_t k = 0; k < 3; ++k) EXPECT_EQ(shaders[k].alike, 0u);
  EXPECT_EQ(shaders[3].alike, 3u);
}

// ---- Lights
// --------------------------------------------------------------------------------------------------------

TEST(Lights, ListsFollowBlocksAndIlluminate) {
  const Built built = buildClean(
      "WorldBegin LightSource \"pointlight\" 1 LightSource \"distantlight\" \"key\" Sphere 1 -1 1 360 "
      "Illuminate 1 0 "
      "Sphere 1 -1 1 360 AttributeBegin Illuminate \"key\" 0 LightSource \"ambientlight\" Sphere 1 -1 1 360 "
      "AttributeEnd "
      "Sphere 1 -1 1 360 Illuminate 1 1 Sphere 1 -1 1 360 WorldEnd");
  EXPECT_THAT(built.attributesOf(0).lights, ElementsAre(0, 1));
  EXPECT_THAT(built.attributesOf(1).lights, ElementsAre(1));
  EXPECT_THAT(built.attributesOf(2).lights, ElementsAre(2));
  EXPECT_THAT(built.attributesOf(3).lights, ElementsAre(1));
  EXPECT_THAT(built.attributesOf(4).lights, ElementsAre(0, 1));
}

TEST(Lights, AHandleUsedAgainNamesTheNewLight) {
  const Built built = buildClean(
      "WorldBegin LightSource \"pointlight\" 1 LightSource \"pointlight\" 2 LightSource \"pointlight\" 1 "
      "\"intensity\" 3 "
      "Sphere 1 -1 1 360 LightSource \"pointlight\" 1 \"intensity\" 3 Sphere 1 -1 1 360 WorldEnd");
  EXPECT_THAT(built.attributesOf(0).lights, ElementsAre(1, 2));
  EXPECT_EQ(built.world().primitives[0].attributes, built.world().primitives[1].attributes);
  EXPECT_THAT(built.world().lights, SizeIs(3));  // the fourth is the third again
}

TEST(Lights, AreaLightsEndWithTheirBlockAndIlluminateKeepsThem) {
  // The form of ../shared/reference/cornell.rib.
  const Built built = buildClean(
      "WorldBegin AttributeBegin AreaLightSource \"arealight\" \"a\" \"float intensity\" 2 Sphere 1 -1 1 360 "
      "AttributeEnd "
      "Sphere 1 -1 1 360 Illuminate \"a\" 1 Sphere 1 -1 1 360 WorldEnd");
  EXPECT_EQ(built.attributesOf(0).areaLight, 0u);
  EXPECT_THAT(built.attributesOf(0).lights, ElementsAre(0));
  EXPECT_EQ(built.attributesOf(1).areaLight, kNone);
  EXPECT_THAT(built.attributesOf(1).lights, IsEmpty());
  EXPECT_THAT(built.attributesOf(2).lights, ElementsAre(0));
  EXPECT_TRUE(built.world().lights.at(0).isArea);
}

TEST(Lights, BeforeTheWorldTheyStandInCameraSpace) {
  const Built built = build(
      "LightSource \"pointlight\" 1 Translate 0 0 5 LightSource \"pointlight\" 2 WorldBegin Sphere 1 -1 1 "
      "360 "
      "LightSource \"pointlight\" 3 WorldEnd WorldBegin Sphere 1 -1 1 360 WorldEnd");
  ASSERT_THAT(built.worlds, SizeIs(2));
  for (const Scene& scene : built.worlds) {
    expectMatrix(scene.shaders.at(scene.lights.at(0).shader).shaderToWorld, translation(0, 0, -5), 0);
    expectMatrix(scene.shaders.at(scene.lights.at(1).shader).shaderToWorld, M44d(), 0);
    EXPECT_THAT(scene.attributes.at(scene.primitives.at(0).attributes).lights, ElementsAre(0, 1));
  }
  EXPECT_THAT(built.worlds[0].lights, SizeIs(3));
  EXPECT_THAT(built.worlds[1].lights, SizeIs(2));
}

TEST(Lights, UnknownHandlesAndShadows) {
  const Built built = build(
      "WorldBegin Attribute \"light\" \"string shadows\" \"off\" LightSource \"pointlight\" 1\nIlluminate 7 "
      "1\nWorldEnd "
      "WorldBegin Illuminate 1 1 WorldEnd");
  EXPECT_THAT(
      built.messages,
      ElementsAre("t.rib:2:1: error: badhandle: Illuminate: no light has the handle \"7\"",
                  HasSubstr("t.rib:3:21: error: badhandle: Illuminate: no light has the handle \"1\"")));
  EXPECT_FALSE(built.worlds[0].lights.at(0).castsShadows);
}

}  // namespace
}  // namespace patina
