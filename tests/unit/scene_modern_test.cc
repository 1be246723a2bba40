// SPDX-License-Identifier: Apache-2.0
// The modern dialect: materials and lights of RenderMan 19 and later as Patina's shaders.
#include <numbers>

#include "scene_fixture.h"

namespace patina {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

const ShaderBinding& surfaceOf(const Built& built, size_t primitive) {
  return built.world().shaders.at(built.attributesOf(primitive).surface);
}

const ShaderArgument* argument(const ShaderBinding& binding, std::string_view name) {
  for (const ShaderArgument& argument : binding.arguments)
    if (argument.name == name) return &argument;
  return nullptr;
}

float number(const ShaderBinding& binding, std::string_view name) {
  const ShaderArgument* const found = argument(binding, name);
  EXPECT_TRUE(found) << name;
  return found ? found->floats.at(0) : -1;
}

Rgb color(const ShaderBinding& binding, std::string_view name) {
  const ShaderArgument* const found = argument(binding, name);
  EXPECT_TRUE(found) << name;
  return found ? Rgb(found->floats.at(0), found->floats.at(1), found->floats.at(2)) : Rgb(-1, -1, -1);
}

TEST(Modern, DiffuseIsMatteInItsColour) {
  const Built built = buildClean(
      "WorldBegin Bxdf \"PxrDiffuse\" \"d\" \"color diffuseColor\" [1 0 .5] Sphere 1 -1 1 360\n"
      "Color 0 1 0 Sphere 1 -1 1 360 Surface \"matte\" Sphere 1 -1 1 360 WorldEnd");
  EXPECT_EQ(surfaceOf(built, 0).name, "matte");
  EXPECT_EQ(built.attributesOf(0).color, Rgb(1, 0, 0.5f));
  EXPECT_EQ(built.attributesOf(1).color, Rgb(1, 0, 0.5f));  // a Bxdf's colour does not listen to Color
  EXPECT_EQ(built.attributesOf(2).color, Rgb(0, 1, 0));
}

TEST(Modern, DisneyIsPlasticMetalOrGlass) {
  const Built built = build(
      "WorldBegin Bxdf \"PxrDisney\" \"a\" \"color baseColor\" [1 .5 0] \"float roughness\" .5 \"float "
      "specular\" .5 "
      "Sphere 1 -1 1 360\n"
      "Bxdf \"PxrDisney\" \"b\" \"float metallic\" 1 \"float roughness\" .4 \"color baseColor\" [.9 .8 .2] "
      "Sphere 1 -1 1 360\n"
      "Bxdf \"PxrDisneyBsdf\" \"c\" \"float specTrans\" 1 \"float ior\" 1.33 Sphere 1 -1 1 360\n"
      "Bxdf \"PxrDisney\" \"d\" \"color emitColor\" [3 3 3] Sphere 1 -1 1 360 WorldEnd");
  EXPECT_EQ(surfaceOf(built, 0).name, "plastic");
  EXPECT_EQ(built.attributesOf(0).color, Rgb(1, 0.5f, 0));
  // alpha = 0.25: Blinn exponent 30, RI roughness 8/30, Ks = 0.04 (30 + 2) / 8.
  EXPECT_NEAR(number(surfaceOf(built, 0), "roughness"), 8.0f / 30, 1e-6f);
  EXPECT_NEAR(number(surfaceOf(built, 0), "Ks"), 0.16f, 1e-6f);
  EXPECT_EQ(surfaceOf(built, 1).name, "conductor");
  EXPECT_EQ(color(surfaceOf(built, 1), "reflectance"), Rgb(0.9f, 0.8f, 0.2f));
  EXPECT_NEAR(number(surfaceOf(built, 1), "alpha"), 0.16f, 1e-6f);
  EXPECT_EQ(surfaceOf(built, 2).name, "dielectric");
  EXPECT_EQ(number(surfaceOf(built, 2), "ior"), 1.33f);
  EXPECT_EQ(surfaceOf(built, 3).name, "matte");
  EXPECT_EQ(color(surfaceOf(built, 3), "emission"), Rgb(3, 3, 3));
  EXPECT_THAT(built.messages,
              testing::UnorderedElementsAre(
                  "t.rib:1:12: warning: unimplemented: Bxdf \"PxrDisney\" is drawn as plastic (once)",
                  "t.rib:2:1: warning: unimplemented: Bxdf \"PxrDisney\" is drawn as conductor (once)",
                  "t.rib:4:1: warning: unimplemented: Bxdf \"PxrDisney\" is drawn as matte (once)",
                  "t.rib:3:1: warning: unimplemented: Bxdf \"PxrDisneyBsdf\" is drawn as dielectric (once)"));
}

TEST(Modern, SurfaceByItsStrongestLobe) {
  const Built built = build(
      "WorldBegin Bxdf \"PxrSurface\" \"a\" \"color diffuseColor\" [.2 .4 .6] \"float diffuseGain\" .5 "
      "Sphere 1 -1 1 360\n"
      "Bxdf \"PxrSurface\" \"b\" \"float diffuseGain\" 0 \"color specularFaceColor\" [.8 .7 .6] Sphere 1 -1 "
      "1 360\n"
      "Bxdf \"PxrSurface\" \"c\" \"float refractionGain\" 1 \"float glassIor\" 1.4 Sphere 1 -1 1 360 "
      "WorldEnd");
  EXPECT_EQ(surfaceOf(built, 0).name, "matte");
  EXPECT_EQ(built.attributesOf(0).color, Rgb(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(surfaceOf(built, 1).name, "conductor");
  EXPECT_EQ(color(surfaceOf(built, 1), "reflectance"), Rgb(0.8f, 0.7f, 0.6f));
  EXPECT_EQ(surfaceOf(built, 2).name, "dielectric");
  EXPECT_EQ(number(surfaceOf(built, 2), "ior"), 1.4f);
}

TEST(Modern, AConnectedTextureIsFollowedAndOtherConnectionsAreNamed) {
  const Built built = build(
      "WorldBegin Pattern \"PxrTexture\" \"wood\" \"string filename\" \"wood.tx\"\n"
      "Pattern \"PxrFractal\" \"noise\"\n"
      "Bxdf \"PxrDiffuse\" \"a\" \"reference color diffuseColor\" [\"wood:resultRGB\"] Sphere 1 -1 1 360\n"
      "Bxdf \"PxrDiffuse\" \"b\" \"reference color diffuseColor\" [\"noise:resultRGB\"] Sphere 1 -1 1 360 "
      "WorldEnd");
  EXPECT_EQ(surfaceOf(built, 0).name, "paintedplastic");
  EXPECT_EQ(argument(surfaceOf(built, 0), "texturename")->strings.at(0), "wood.tx");
  EXPECT_EQ(built.attributesOf(0).color, Rgb(1, 1, 1));
  EXPECT_EQ(number(surfaceOf(built, 0), "Ks"), 0);
  EXPECT_EQ(surfaceOf(built, 1).name, "matte");
  EXPECT_EQ(built.messages.size(), 2u);
}

TEST(Modern, LightsHaveShapesAndShineOnAllThatFollows) {
  const Built built = buildClean(
      "WorldBegin AttributeBegin Translate 0 5 0 Light \"PxrRectLight\" \"key\" \"float intensity\" 3 "
      "\"float exposure\" 2 "
      "\"color lightColor\" [1 .5 .25] AttributeEnd Sphere 1 -1 1 360 WorldEnd");
  ASSERT_EQ(built.world().primitives.size(), 2u);
  EXPECT_TRUE(std::holds_alternative<ParametricMesh>(built.world().primitives[0].shape));
  EXPECT_EQ(built.world().primitives[0].objectToWorld[3][1], 5);
  const Attributes& shape = built.attributesOf(0);
  ASSERT_EQ(shape.areaLight, 0u);
  EXPECT_EQ(shape.color, Rgb(0, 0, 0));
  EXPECT_EQ(shape.visibility & kTransmissionRay, 0u);
  const ShaderBinding& light = built.world().shaders.at(built.world().lights.at(0).shader);
  EXPECT_EQ(light.name, "arealight");
  EXPECT_EQ(color(light, "lightcolor"), Rgb(12, 6, 3));
  EXPECT_THAT(built.attributesOf(1).lights, ElementsAre(0u));
  EXPECT_EQ(built.attributesOf(1).areaLight, kNone);
}

TEST(Modern, NormalizedLightsKeepTheirPower) {
  const Built built = buildClean(
      "WorldBegin Scale 2 3 1 Light \"PxrRectLight\" \"r\" \"int areaNormalize\" 1 Light \"PxrDiskLight\" "
      "\"d\" "
      "\"int areaNormalize\" 1 Scale 1 .66666667 2 Light \"PxrSphereLight\" \"s\" \"int areaNormalize\" 1 "
      "WorldEnd");
  ASSERT_EQ(built.world().lights.size(), 3u);
  constexpr float pi = std::numbers::pi_v<float>;
  const float areas[] = {6, 6 * pi / 4, 4 * pi};
  for (size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(color(built.world().shaders.at(built.world().lights[k].shader), "lightcolor").x, 1 / areas[k],
                1e-5f);
}

TEST(Modern, DomesDistantLightsAndTheOlderAreaLights) {
  const Built built = build(
      "WorldBegin Light \"PxrDomeLight\" \"dome\" \"string lightColorMap\" \"sky.exr\" "
      "Light \"PxrDistantLight\" \"sun\" \"float intensity\" 3.14159265 "
      "AttributeBegin AreaLightSource \"PxrStdAreaLight\" \"a\" \"float intensity\" 2 Geometry \"rectlight\" "
      "AttributeEnd "
      "AreaLightSource \"PxrStdEnvMapLight\" \"e\" \"string rman__EnvMap\" \"e.exr\" Geometry \"envsphere\" "
      "Geometry \"rectlight\" Light \"PxrPortalLight\" \"p\" WorldEnd");
  ASSERT_EQ(built.world().lights.size(), 4u);
  const auto shader = [&](size_t k) -> const ShaderBinding& {
    return built.world().shaders.at(built.world().lights[k].shader);
  };
  EXPECT_EQ(shader(0).name, "envlight");
  EXPECT_EQ(argument(shader(0), "texturename")->strings.at(0), "sky.exr");
  EXPECT_EQ(shader(1).name, "distantlight");
  EXPECT_NEAR(color(shader(1), "lightcolor").x, 1, 1e-6f);
  EXPECT_EQ(shader(2).name, "arealight");
  EXPECT_EQ(color(shader(2), "lightcolor"), Rgb(2, 2, 2));
  EXPECT_EQ(shader(3).name, "envlight");
  ASSERT_EQ(built.world().primitives.size(), 1u);  // the rectangle of the area light; the other has no light
  EXPECT_EQ(built.attributesOf(0).areaLight, 2u);
  EXPECT_THAT(built.messages,
              ElementsAre("t.rib:1:351: warning: unimplemented: request Light \"PxrPortalLight\" is not "
                          "carried out yet (once)"));
}

TEST(Modern, AreaLightsKeepPicturesAndShape) {
  const Built built = build(
      "WorldBegin Light \"PxrRectLight\" \"r\" \"string lightColorMap\" \"card.exr\" \"float emissionFocus\" "
      "3 "
      "\"float coneAngle\" 45 \"float coneSoftness\" .5 \"int enableShadows\" 0\n"
      "Light \"PxrSphereLight\" \"s\" \"color shadowColor\" [.1 .2 .3] \"float coneAngle\" 20\n"
      "Light \"PxrDistantLight\" \"d\" \"float angleExtent\" 0 \"color shadowColor\" [.1 .2 .3] WorldEnd");
  ASSERT_EQ(built.world().lights.size(), 3u);
  const auto shader = [&](size_t k) -> const ShaderBinding& {
    return built.world().shaders.at(built.world().lights[k].shader);
  };
  EXPECT_EQ(argument(shader(0), "texturename")->strings.at(0), "card.exr");
  EXPECT_EQ(number(shader(0), "focus"), 3);
  constexpr float kQuarter = std::numbers::pi_v<float> / 4;
  EXPECT_FLOAT_EQ(number(shader(0), "coneangle"), kQuarter);
  EXPECT_FLOAT_EQ(number(shader(0), "conedeltaangle"), kQuarter / 2);
  EXPECT_FALSE(built.world().lights[0].castsShadows);
  EXPECT_TRUE(built.world().lights[1].castsShadows);
  EXPECT_EQ(argument(shader(1), "coneangle"), nullptr);
  EXPECT_EQ(color(shader(2), "shadowcolor"), Rgb(0.1f, 0.2f, 0.3f));
  EXPECT_THAT(
      built.messages,
      ElementsAre("t.rib:2:1: warning: unimplemented: the shadowColor of \"PxrSphereLight\" is left out: "
                  "only lights without a size have one (once)"));
}

TEST(Modern, DaylightIsThatOfItsPlaceAndDay) {
  const Built built = build(
      "WorldBegin Light \"PxrEnvDayLight\" \"a\" \"int month\" 3 \"int day\" 1 \"int year\" 2024 \"float "
      "hour\" 9.5 "
      "\"float zone\" 1 \"float latitude\" 50 \"float longitude\" 8 \"float haziness\" 4 \"float sunSize\" 2 "
      "\"float exposure\" 1\n"
      "Light \"PxrEnvDayLight\" \"b\" \"int month\" 0 \"vector sunDirection\" [1 2 3] WorldEnd");
  ASSERT_EQ(built.world().lights.size(), 2u);
  const auto shader = [&](size_t k) -> const ShaderBinding& {
    return built.world().shaders.at(built.world().lights[k].shader);
  };
  EXPECT_EQ(shader(0).name, "sunsky");
  EXPECT_EQ(color(shader(0), "lightcolor"), Rgb(2, 2, 2));
  EXPECT_EQ(number(shader(0), "day"), 61);  // of a leap year
  EXPECT_EQ(number(shader(0), "time"), 9.5f);
  EXPECT_EQ(number(shader(0), "zone"), 1);
  EXPECT_EQ(number(shader(0), "latitude"), 50);
  EXPECT_EQ(number(shader(0), "longitude"), 8);
  EXPECT_EQ(number(shader(0), "turbidity"), 4);
  EXPECT_FLOAT_EQ(number(shader(0), "sunangle"), 2 * 0.533f);
  EXPECT_EQ(argument(shader(1), "time"), nullptr);
  EXPECT_EQ(argument(shader(1), "sundirection")->floats, (std::vector<float>{1, 2, 3}));
  EXPECT_THAT(
      built.messages,
      ElementsAre("t.rib:1:12: warning: unimplemented: Light \"PxrEnvDayLight\" is drawn by sunsky, as "
                  "bright as that is (2 times)"));
}

}  // namespace
}  // namespace patina
