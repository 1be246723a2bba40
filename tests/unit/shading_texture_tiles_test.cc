// SPDX-License-Identifier: Apache-2.0
// Sets of tiles: which one a coordinate chooses, and filters over their edges.
#include "tests/unit/texture_files.h"

namespace patina::test {
namespace {

class TextureTilesTest : public TextureFilesTest {
 protected:
  TextureTilesTest() { serve({true, {}, {}}); }
  void writeTile(const std::string& name, int value) const {
    writeTiff8(folder_ + '/' + name, 16, 16, [&](int, int) { return std::array<int, 3>{value, 0, 255}; });
  }
  // 1001 1002 above 1011 1012: values 0, 51, 102, 255.
  void writeSquare() const {
    writeTile("skin.1001.tif", 0), writeTile("skin.1002.tif", 51);
    writeTile("skin.1011.tif", 102), writeTile("skin.1012.tif", 255);
  }
};

TEST_F(TextureTilesTest, CoordinatesChooseTheTile) {
  writeSquare();
  PatinaTexture* const skin = textures_->open("skin.<UDIM>.tif", {});
  ASSERT_NE(skin, nullptr);
  EXPECT_NEAR(read(skin, 0.5f, 0.5f)[0], 0, 1e-5f);
  EXPECT_NEAR(read(skin, 1.5f, 0.5f)[0], 0.2f, 1e-5f);
  EXPECT_NEAR(read(skin, 0.5f, 1.5f)[0], 0.4f, 1e-5f);
  EXPECT_NEAR(read(skin, 1.5f, 1.5f)[0], 1, 1e-5f);
  EXPECT_NEAR(read(skin, 1.5f, -0.5f)[0], 1, 1e-5f);  // t = 1 - v of v = 1.5: the second row
  uint32_t width = 0, height = 0, channels = 0;
  EXPECT_EQ(TextureService::size(skin, &width, &height, &channels), PATINA_OK);
  EXPECT_EQ(width, 16u);
  EXPECT_THAT(messages_, testing::IsEmpty());
}

// A filter of width w whose middle is d before the edge covers the next tile by (w / 2 - d) / w.
TEST_F(TextureTilesTest, FiltersReachOverTheEdgesOfTiles) {
  writeSquare();
  PatinaTexture* const skin = textures_->open("skin.<UDIM>.tif", {});
  ASSERT_NE(skin, nullptr);
  EXPECT_NEAR(read(skin, 0.95f, 0.5f, 0.4f)[0], 0.2f * (0.15f / 0.4f), 1e-4f);
  EXPECT_NEAR(read(skin, 1.05f, 0.5f, 0.4f)[0], 0.2f * (0.25f / 0.4f), 1e-4f);
  EXPECT_NEAR(read(skin, 0.5f, 0.9f, 0.4f)[0], 0.4f * (0.1f / 0.4f), 1e-4f);
  EXPECT_NEAR(read(skin, 1, 1, 0.2f)[0], (0 + 0.2f + 0.4f + 1) / 4, 1e-4f);  // all four
  EXPECT_NEAR(read(skin, 1, 0.5f, 0)[0], 0.1f, 1e-4f);                       // as texels are interpolated
  EXPECT_NEAR(read(skin, 1.5f, -0.05f, 0.4f)[0], 0.2f * 0.375f + 1 * 0.625f, 1e-4f);
  EXPECT_NEAR(read(skin, 1.9f, 0.1f, 0.4f)[0], 0.2f, 1e-5f);  // beyond the outermost there is nothing
}

TEST_F(TextureTilesTest, TilesThatAreNotThereAreCountedAndReportedOnce) {
  writeTile("skin.1001.tif", 0);
  writeTile("skin.1012.tif", 255);
  const Location where{internFileName("t.rib"), 7, 2};
  PatinaTexture* const skin = textures_->open("skin.<UDIM>.tif", where);
  ASSERT_NE(skin, nullptr);
  EXPECT_NEAR(read(skin, 1.5f, 0.5f)[0], 1, 1e-5f);  // red of the tiles that are there is 0 or 1, blue 1
  EXPECT_NEAR(read(skin, 1.5f, 0.25f)[2], 1, 1e-5f);
  EXPECT_NEAR(read(skin, -0.5f, 0.5f)[2], 1, 1e-5f);
  EXPECT_NEAR(read(skin, std::nanf(""), 0.5f)[2], 1, 1e-5f);
  EXPECT_NEAR(read(skin, 3e38f, 0.5f)[2], 1, 1e-5f);
  EXPECT_NEAR(read(skin, 0.9f, 0.5f, 0.4f)[0], 0, 1e-5f);  // its neighbour is no part of the filter
  EXPECT_THAT(messages_, testing::IsEmpty());
  textures_->summarize();
  textures_->summarize();
  EXPECT_THAT(messages_, testing::ElementsAre("t.rib:7:2: error: nofile: texture \"skin.<UDIM>.tif\" lacks "
                                              "tiles, 5 look-ups read 1: column -1 row 0 (3), "
                                              "column 1 row 0 (2)"));
}

TEST_F(TextureTilesTest, OtherPatternsOfOpenImageIO) {
  writeTile("a_u1_v1.tif", 51), writeTile("a_u2_v1.tif", 102);
  PatinaTexture* const tiles = textures_->open("a_<UVTILE>.tif", {});
  ASSERT_NE(tiles, nullptr);
  EXPECT_NEAR(read(tiles, 0.5f, 0.5f)[0], 0.2f, 1e-5f);
  EXPECT_NEAR(read(tiles, 1.5f, 0.5f)[0], 0.4f, 1e-5f);
}

TEST_F(TextureTilesTest, PatternsWithoutFilesAndWithAbsurdNumbersAreReported) {
  EXPECT_EQ(textures_->open("none.<UDIM>.tif", {}), nullptr);
  ASSERT_EQ(messages_.size(), 1u);
  EXPECT_THAT(messages_[0], testing::HasSubstr("/none.<UDIM>.tif: no such files"));
  writeTile("b_u2000000000_v2000000000.tif", 51);
  EXPECT_EQ(textures_->open("b_<UVTILE>.tif", {}), nullptr);
  ASSERT_EQ(messages_.size(), 2u);
  EXPECT_THAT(messages_[1], testing::HasSubstr("a file of that pattern has a number above 999"));
}

// A file that ends in the middle of its texels: every look-up fails and is counted, one message says so.
TEST_F(TextureTilesTest, LookUpsThatFailAreCountedAndReportedOncePerFile) {
  writeHdr(folder_ + "/cut.hdr", 128, 128);
  std::filesystem::resize_file(folder_ + "/cut.hdr", std::filesystem::file_size(folder_ + "/cut.hdr") - 12);
  PatinaTexture* const cut = textures_->open("cut.hdr", {internFileName("t.rib"), 1, 1});
  ASSERT_NE(cut, nullptr);
  Batch batch(3);
  PatinaOut3 color = batch.out3(-1);
  EXPECT_EQ(TextureService::texture(cut, 3, batch.uniform(0.5f), batch.uniform(0.5f), batch.uniform(0.0f),
                                    color, nullptr),
            PATINA_ERROR_RESOURCE);
  EXPECT_EQ(color.x[2], 1);
  textures_->summarize();
  ASSERT_EQ(messages_.size(), 1u);
  EXPECT_THAT(messages_[0], testing::StartsWith("t.rib:1:1: error: badfile: texture \"cut.hdr\" cannot be "
                                                "read, 3 look-ups read 1: "));
}

}  // namespace
}  // namespace patina::test
