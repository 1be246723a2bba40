// SPDX-License-Identifier: Apache-2.0
// Attribute "user" as shaders read it: of each primitive, and where a request binds them.
#include <gmock/gmock.h>

#include "tests/unit/integrators_render.h"

namespace patina {
namespace {

using testing::ElementsAre;

constexpr float kRounding = 2e-5f;  // of what the cache keeps, and of sums of weights

/// The colours of three squares side by side, of which `each` writes the requests that come before.
std::vector<Rgb> threeSquares(const std::vector<std::string>& each, const std::string& before = {}) {
  RenderSettings settings;
  settings.mode = "direct", settings.samples = 1;
  std::string rib =
      "Option \"searchpath\" \"string shader\" [\"" PATINA_BINARY_DIR
      "/tests/plugins:@\"]\nFormat 3 1 1 PixelSamples 1 1 PixelFilter \"box\" 1 1\n"
      "Projection \"orthographic\" ScreenWindow -1.5 1.5 -0.5 0.5 Translate 0 0 5\nWorldBegin\n" +
      before;
  for (size_t k = 0; k < each.size(); ++k) {
    const std::string x0 = std::to_string(double(k) - 1.5), x1 = std::to_string(double(k) - 0.5);
    rib += "AttributeBegin " + each[k] + " Patch \"bilinear\" \"P\" [" + x0 + " 1 0 " + x1 + " 1 0 " + x0 +
           " -1 0 " + x1 + " -1 0] AttributeEnd\n";
  }
  return renderPicture(rib + "WorldEnd\n", settings);
}

std::string user(const std::string& attribute) { return "Attribute \"user\" " + attribute + " "; }

TEST(UserAttributes, TakeTheirPrimitivesParameters) {
  // One request for all; primitive variables go before.
  const auto picture = threeSquares({user("\"color tint\" [0.1 0.2 0.3]") + user("\"int id\" [3]"),
                                     user("\"float id\" [0.5] \"color tint\" [1 1 1]"), ""},
                                    "Surface \"attributes\" \"color tint\" [0.25 0.5 0.75]\n");
  ASSERT_EQ(picture.size(), 3u);
  EXPECT_LT((picture[0] - Rgb(0.3f, 0.6f, 0.9f)).length(), kRounding);
  EXPECT_LT((picture[1] - Rgb(0.5f, 0.5f, 0.5f)).length(), kRounding);
  EXPECT_LT((picture[2] - Rgb(0.25f, 0.5f, 0.75f)).length(), kRounding);
}

TEST(UserAttributes, OfAnotherTypeAreLeftAlone) {
  const auto picture = threeSquares(
      {user("\"float tint\" [1]"), user("\"string tint\" [\"a\"]"), user("\"point tint\" [1 1 1]")},
      "Surface \"attributes\" \"color tint\" [0.25 0.5 0.75]\n");
  ASSERT_EQ(picture.size(), 3u);
  for (const Rgb& color : picture) EXPECT_LT((color - Rgb(0.25f, 0.5f, 0.75f)).length(), kRounding);
}

TEST(UserAttributes, AreReadWhereTheRequestBindsTheShader) {
  const std::string surface = "Surface \"attributes\" \"color tint\" [0.1 0 0] \"int reads\" [1] ";
  const auto picture =
      threeSquares({user("\"float gain\" [2]") + surface + user("\"float gain\" [100]"),
                    user("\"float[3] weights\" [1 2 3] \"string word\" [\"four\"]") + surface, surface});
  ASSERT_EQ(picture.size(), 3u);
  EXPECT_NEAR(picture[0].x, 0.2f, kRounding);
  EXPECT_NEAR(picture[1].x, 2.4f, kRounding);
  EXPECT_NEAR(picture[2].x, 0.1f, kRounding);
}

TEST(UserAttributes, ThatNobodyReadsMakeNoInstances) {
  // The same request with three sets of attributes: one instance unless it reads them, so one batch of
  // points.
  const std::string plain = "Surface \"attributes\" \"color tint\" [0.1 0.1 0.1] ";
  const std::string reading = "Surface \"attributes\" \"color tint\" [0.1 0.1 0.1] \"int reads\" [1] ";
  const auto calls = [](const std::string& surface) {
    threeSquares(
        {user("\"int k\" [1]") + surface, user("\"int k\" [2]") + surface, user("\"int k\" [3]") + surface});
    return statistic("Shaders/instances");
  };
  EXPECT_EQ(calls(plain), 2);  // and the default surface
  EXPECT_EQ(calls(reading), 4);
}

TEST(UserAttributes, OfInstancesAreThoseOfTheirPlace) {
  const std::string object =
      "ObjectBegin 1 Patch \"bilinear\" \"P\" [-0.5 1 0 0.5 1 0 -0.5 -1 0 0.5 -1 0] ObjectEnd\n";
  RenderSettings settings;
  settings.mode = "direct", settings.samples = 1;
  const auto at = [](const char* x, const char* tint) {
    return "AttributeBegin Attribute \"user\" \"color tint\" [" + std::string(tint) + "] Translate " + x +
           " 0 0 ObjectInstance 1 AttributeEnd\n";
  };
  const auto picture = renderPicture(
      "Option \"searchpath\" \"string shader\" [\"" PATINA_BINARY_DIR
      "/tests/plugins:@\"]\nFormat 2 1 1 PixelSamples 1 1 PixelFilter \"box\" 1 1\n"
      "Projection \"orthographic\" ScreenWindow -1 1 -0.5 0.5 Translate 0 0 5\nWorldBegin\n" +
          object + "Surface \"attributes\"\n" + at("-0.5", "1 0 0") + at("0.5", "0 0.5 0") + "WorldEnd\n",
      settings);
  EXPECT_THAT(picture, ElementsAre(Rgb(1, 0, 0), Rgb(0, 0.5f, 0)));
}

}  // namespace
}  // namespace patina
