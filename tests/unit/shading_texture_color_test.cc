// SPDX-License-Identifier: Apache-2.0
// Which colour spaces texture files are taken to be in.
#include "tests/unit/texture_files.h"

namespace patina::test {
namespace {

// IEC 61966-2-1: ((128 / 255 + 0.055) / 1.055)^2.4; halves have steps of 2^-13 there.
constexpr float kLinear128 = 0.215861f, kEncoded128 = 128.0f / 255, kHalf = 2e-4f;

using TextureColorTest = TextureFilesTest;

TEST_F(TextureColorTest, EightBitsAreSrgbUnlessTheyAreDataOrTaggedOtherwise) {
  const auto grey = [](int, int) { return std::array<int, 3>{128, 128, 128}; };
  writeTiff8(folder_ + "/untagged.tif", 4, 4, grey);
  writePng(folder_ + "/srgb.png", 128, 0);
  writePng(folder_ + "/linear.png", 128, 100000);
  writePng(folder_ + "/gamma.png", 128, 50000);
  EXPECT_NEAR(middle("untagged.tif"), kLinear128, kHalf);
  EXPECT_NEAR(middle("untagged.tif", TextureService::kData), kEncoded128, 1e-5f);
  EXPECT_NEAR(middle("srgb.png"), kLinear128, kHalf);
  EXPECT_NEAR(middle("linear.png"), kEncoded128, kHalf);
  EXPECT_NEAR(middle("gamma.png"), kEncoded128 * kEncoded128, kHalf);
  EXPECT_THAT(messages_, testing::IsEmpty());
}

TEST_F(TextureColorTest, FloatsAreLinear) {
  writeHdr(folder_ + "/sky.hdr", 128, 129);  // 128 / 256 * 2
  EXPECT_NEAR(middle("sky.hdr"), 1, 1e-2f);
  writeHdr(folder_ + "/sky_srgb.hdr", 128, 128);  // one half, of the curve by the name's last word
  EXPECT_NEAR(middle("sky_srgb.hdr"), 0.214041f, 2e-3f);
}

TEST_F(TextureColorTest, TheLastWordOfANameDecidesBeforeTheTag) {
  for (const char* name : {"a_raw.png", "a.lin.png", "a_linear_2.png", "a-data.1001.png", "a_lin_srgb.png"}) {
    writePng(folder_ + '/' + name, 128, 0);
    EXPECT_NEAR(middle(name), kEncoded128, 1e-5f) << name;
  }
  for (const char* name : {"raw.png", "raw_a.png", "draw.png"}) {
    writePng(folder_ + '/' + name, 128, 0);
    EXPECT_NEAR(middle(name), kLinear128, kHalf) << name;
  }
  writePng(folder_ + "/b_srgb.png", 128, 100000);
  EXPECT_NEAR(middle("b_srgb.png"), kLinear128, kHalf);
}

// A checker of black and white seen from afar is half as bright as white: texels are linear before they are
// filtered.
TEST_F(TextureColorTest, TexelsAreFilteredWhenTheyAreLinear) {
  writeTiff8(folder_ + "/checks.tif", 64, 64, [](int x, int y) {
    const int v = (x + y) % 2 * 128;
    return std::array<int, 3>{v, v, v};
  });
  PatinaTexture* const checks = textures_->open("checks.tif", {});
  ASSERT_NE(checks, nullptr);
  EXPECT_NEAR(read(checks, 0.5f, 0.5f, 1)[1], kLinear128 / 2, 2e-3f);
}

TEST_F(TextureColorTest, ClassicValuesAreAsInTheFile) {
  writePng(folder_ + "/srgb.png", 128, 0);
  serve({true, {}, {}});
  EXPECT_NEAR(middle("srgb.png"), kEncoded128, 1e-5f);
}

// A configuration whose rules find its own space by the file's name: 4 * x^2, by hand.
TEST_F(TextureColorTest, AnOcioConfigurationsRulesDecide) {
  std::ofstream(folder_ + "/config.ocio") << R"(ocio_profile_version: 2
roles: {default: plain, scene_linear: lin, data: plain}
file_rules:
  - !<Rule> {name: photos, pattern: "*photo*", extension: "*", colorspace: photo}
  - !<Rule> {name: maps, pattern: "*map*", extension: "*", colorspace: plain}
  - !<Rule> {name: Default, colorspace: default}
displays: {d: [!<View> {name: v, colorspace: plain}]}
colorspaces:
  - !<ColorSpace> {name: lin}
  - !<ColorSpace> {name: plain, isdata: true}
  - !<ColorSpace>
    name: photo
    to_scene_reference: !<GroupTransform>
      children:
        - !<ExponentTransform> {value: [2, 2, 2, 1]}
        - !<MatrixTransform> {matrix: [4, 0, 0, 0, 0, 4, 0, 0, 0, 0, 4, 0, 0, 0, 0, 1]}
)";
  for (const char* name : {"photo.png", "map.png", "other.png", "photo_raw.png"})
    writePng(folder_ + '/' + name, 128, 0);
  serve({false, folder_ + "/config.ocio", {}});
  EXPECT_NEAR(middle("photo.png"), 4 * kEncoded128 * kEncoded128, 1e-3f);
  EXPECT_NEAR(middle("map.png"), kEncoded128, 1e-5f);
  EXPECT_NEAR(middle("other.png"), kLinear128, kHalf);  // the rule for all the rest says nothing
  EXPECT_NEAR(middle("photo_raw.png"), kEncoded128, 1e-5f);
  EXPECT_THAT(messages_, testing::IsEmpty());
}

TEST_F(TextureColorTest, AConfigurationThatIsNoneIsReportedAtItsPlace) {
  writePng(folder_ + "/srgb.png", 128, 0);
  std::ofstream(folder_ + "/bad.ocio") << "this is no configuration";
  serve({false, folder_ + "/bad.ocio", {internFileName("t.rib"), 3, 1}});
  EXPECT_THAT(messages_, testing::IsEmpty());  // nothing is opened before a texture is
  EXPECT_NEAR(middle("srgb.png"), kLinear128, kHalf);
  ASSERT_EQ(messages_.size(), 1u);
  EXPECT_THAT(messages_[0], testing::StartsWith("t.rib:3:1: error: badfile: OpenColorIO configuration " +
                                                folder_ + "/bad.ocio cannot be used: "));
}

}  // namespace
}  // namespace patina::test
