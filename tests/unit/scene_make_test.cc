// SPDX-License-Identifier: Apache-2.0
// Make requests, as they are handed on, and what textures' names stand for after them; Atmosphere.
#include "scene_fixture.h"

namespace patina {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

struct Made {
  Built built;
  std::vector<MakeRequest> requests;
};

/// Every texture is made as "/made/NAME", but for those named "bad".
Made make(const std::string& rib) {
  Made made;
  SceneBuilderSettings settings;
  settings.makeTexture = [&](const MakeRequest& request) {
    made.requests.push_back(request);
    return request.texture == "bad" ? std::string() : "/made/" + request.texture;
  };
  made.built = build(rib + "\nWorldBegin Sphere 1 -1 1 360 WorldEnd\n", settings);
  return made;
}

TEST(MakeRequests, AreHandedOnAsTheyStand) {
  const Made made = make(
      "Option \"searchpath\" \"string texture\" [\"maps\"]\n"
      "MakeTexture \"a.tif\" \"a.tx\" \"black\" \"clamp\" \"gaussian\" 2 2 \"string colorspace\" [\"raw\"]\n"
      "MakeCubeFaceEnvironment \"a\" \"b\" \"c\" \"d\" \"e\" \"f\" \"cube\" 95 \"box\" 1 1\n"
      "MakeShadow \"z\" \"bad\"");
  EXPECT_THAT(made.built.messages, testing::IsEmpty());
  ASSERT_EQ(made.requests.size(), 3u);
  const MakeRequest& texture = made.requests[0];
  EXPECT_EQ(texture.kind, MakeRequest::Kind::Texture);
  EXPECT_THAT(texture.pictures, ElementsAre("a.tif"));
  EXPECT_EQ(texture.sWrap + texture.tWrap + texture.filter, "blackclampgaussian");
  EXPECT_EQ(texture.colorSpace, "raw");
  EXPECT_THAT(texture.searchPath, HasSubstr("maps"));
  EXPECT_EQ(toString(texture.where), "t.rib:2:1");
  EXPECT_EQ(made.requests[1].kind, MakeRequest::Kind::CubeFace);
  EXPECT_THAT(made.requests[1].pictures, ElementsAre("a", "b", "c", "d", "e", "f"));
  EXPECT_EQ(made.requests[1].fov, 95);
  const auto& names = made.built.world().options.madeTextures;
  EXPECT_EQ(names.at("a.tx"), "/made/a.tx");
  EXPECT_EQ(names.at("cube"), "/made/cube");
  EXPECT_EQ(names.at("bad"), "z");  // what could not be made stands for its picture
}

TEST(MakeRequests, WhatMakesNoSenseIsReported) {
  const Made made = make(
      "MakeTexture \"a\" \"t\" \"clamp\" \"clamp\" \"box\" 1 1 \"string colorspace\" [\"rgb\"]\n"
      "MakeCubeFaceEnvironment \"a\" \"b\" \"c\" \"d\" \"e\" \"f\" \"t\" 60 \"box\" 1 1\n"
      "MakeTexture \"a\" \"\" \"clamp\" \"clamp\" \"box\" 1 1");
  EXPECT_THAT(made.built.messages,
              ElementsAre("t.rib:1:1: error: badtoken: \"colorspace\" \"rgb\": expected srgb, linear or raw",
                          "t.rib:2:1: error: range: field of view 60: expected 90 to 179 degrees",
                          "t.rib:3:1: error: badargument: a texture and its picture need names"));
}

TEST(MakeRequests, WithoutAMakerNamesStandForTheirPictures) {
  const Built built = build(
      "MakeBump \"a.tif\" \"a.tx\" \"clamp\" \"clamp\" \"box\" 1 1\nWorldBegin Sphere 1 -1 1 360 WorldEnd\n");
  EXPECT_EQ(built.world().options.madeTextures.at("a.tx"), "a.tif");
}

TEST(Atmosphere, IsAnAttribute) {
  const Built built = buildClean(
      "WorldBegin AttributeBegin Atmosphere \"fog\" \"float distance\" [7] Sphere 1 -1 1 360 AttributeEnd\n"
      "Sphere 1 -1 1 360 WorldEnd\n");
  const uint32_t fog = built.attributesOf(0).atmosphere;
  ASSERT_LT(fog, built.world().shaders.size());
  EXPECT_EQ(built.world().shaders[fog].name, "fog");
  EXPECT_EQ(built.attributesOf(1).atmosphere, kNone);
}

}  // namespace
}  // namespace patina
