// SPDX-License-Identifier: Apache-2.0
// Make requests: what is written where, and what is read from it again.
#include "renderer/shading/texture_maker.h"

#include <chrono>
#include <cmath>

#include "tests/unit/texture_files.h"

namespace patina::test {
namespace {

namespace fs = std::filesystem;

class TextureMakerTest : public TextureFilesTest {
 protected:
  TextureMakerTest() : before_(fs::current_path()) { fs::current_path(folder_); }
  ~TextureMakerTest() override { fs::current_path(before_); }

  static MakeRequest request(MakeRequest::Kind kind, const std::string& picture, const std::string& texture) {
    MakeRequest r;
    r.kind = kind, r.pictures = {picture}, r.texture = texture;
    r.sWrap = r.tWrap = "periodic", r.filter = "box";
    r.where = {internFileName("t.rib"), 4, 1};
    return r;
  }
  std::string make(const MakeRequest& r, bool allowPaths = false) {
    TextureMaking settings;
    settings.allowPaths = allowPaths;
    return makeTexture(r, settings, errors_);
  }
  /// What a refused request says after "t.rib:4:1: error: ".
  std::string refusal(const MakeRequest& r) {
    messages_.clear();
    EXPECT_EQ(make(r), "");
    if (messages_.size() != 1) return {};
    EXPECT_THAT(messages_[0], testing::StartsWith("t.rib:4:1: error: "));
    return messages_[0].substr(18);
  }
  static size_t filesIn(const std::string& folder) {
    return static_cast<size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
  }

  fs::path before_;
};

// Left half black, right half of an encoded 128.
std::array<int, 3> halves(int x, int) {
  const int v = x < 32 ? 0 : 128;
  return {v, v, v};
}
constexpr float kLinear128 = 0.215861f;

TEST_F(TextureMakerTest, MakesALinearTextureWithItsLevelsAndWrapModes) {
  writeTiff8("halves.tif", 64, 64, halves);
  MakeRequest r = request(MakeRequest::Kind::Texture, "halves.tif", "halves.tx");
  r.sWrap = "black", r.tWrap = "clamp";
  const std::string made = make(r);
  EXPECT_EQ(made, folder_ + "/halves.tx");
  EXPECT_THAT(messages_, testing::IsEmpty());
  PatinaTexture* const texture = textures_->open("halves.tx", {});
  ASSERT_NE(texture, nullptr);
  EXPECT_NEAR(read(texture, 0.75f, 0.5f)[0], kLinear128, 2e-4f);
  EXPECT_NEAR(read(texture, 0.5f, 0.5f, 1)[0], kLinear128 / 2, 2e-3f);  // levels are of linear values
  EXPECT_EQ(read(texture, 1.75f, 0.5f)[0], 0);                          // black beyond s = 1
  EXPECT_NEAR(read(texture, 0.75f, 3.5f)[0], kLinear128, 2e-4f);        // clamped in t
}

TEST_F(TextureMakerTest, HeightsAndRawColoursKeepTheirValues) {
  writeTiff8("halves.tif", 64, 64, halves);
  ASSERT_NE(make(request(MakeRequest::Kind::Bump, "halves.tif", "heights.tx")), "");
  EXPECT_NEAR(read(textures_->open("heights.tx", {}, TextureService::kData), 0.75f, 0.5f)[0], 128.0f / 255,
              2e-4f);
  MakeRequest raw = request(MakeRequest::Kind::Texture, "halves.tif", "raw.tx");
  raw.colorSpace = "raw";
  ASSERT_NE(make(raw), "");
  EXPECT_NEAR(read(textures_->open("raw.tx", {}), 0.75f, 0.5f)[0], 128.0f / 255, 2e-4f);
}

TEST_F(TextureMakerTest, ATextureThatIsNewerThanItsPictureIsLeft) {
  writeTiff8("halves.tif", 64, 64, halves);
  const MakeRequest r = request(MakeRequest::Kind::Texture, "halves.tif", "halves.tx");
  const auto now = fs::last_write_time("halves.tif");
  fs::last_write_time("halves.tif", now - std::chrono::hours(2));
  ASSERT_NE(make(r), "");
  const auto made = now - std::chrono::hours(1);
  fs::last_write_time("halves.tx", made);
  EXPECT_NE(make(r), "");
  EXPECT_EQ(fs::last_write_time("halves.tx"), made);
  fs::last_write_time("halves.tif", now);
  EXPECT_NE(make(r), "");
  EXPECT_GT(fs::last_write_time("halves.tx"), made);
  EXPECT_EQ(filesIn(folder_), 2u);  // nothing temporary is left
}

TEST_F(TextureMakerTest, RibsWriteBelowTheWorkingFolderAndOverNoOtherFiles) {
  using Kind = MakeRequest::Kind;
  writeTiff8("halves.tif", 64, 64, halves);
  std::ofstream("text.txt") << "mine";
  fs::create_directory("sub");
  for (const std::string& name :
       {std::string("../out.tx"), std::string("sub/../../out.tx"), folder_ + "/a.tx"})
    EXPECT_THAT(refusal(request(Kind::Texture, "halves.tif", name)),
                testing::EndsWith("RIBs write textures below the working folder, but for "
                                  "--allow-texture-paths"));
  EXPECT_EQ(refusal(request(Kind::Texture, "halves.tif", "text.txt")),
            "system: MakeTexture \"text.txt\": there is such a file, which is no picture and is left");
  EXPECT_EQ(refusal(request(Kind::Texture, "halves.tif", "halves.tif")),
            "badargument: MakeTexture \"halves.tif\": a texture cannot take the place of its picture");
  EXPECT_EQ(refusal(request(Kind::Texture, "halves.tif", "none/a.tx")),
            "system: MakeTexture \"none/a.tx\": there is no folder none");
  EXPECT_EQ(refusal(request(Kind::Shadow, "no.z", "a.shd")),
            "nofile: MakeShadow \"a.shd\": there is no picture \"no.z\"");
  MakeRequest r = request(Kind::Texture, "halves.tif", "a.tx");
  r.tWrap = "mirror";
  EXPECT_THAT(refusal(r), testing::HasSubstr("wrap mode \"mirror\": expected black, periodic or clamp"));
  r.tWrap = "clamp", r.filter = "soft";
  EXPECT_THAT(refusal(r), testing::HasSubstr("filter \"soft\": expected box, triangle"));
  EXPECT_THAT(refusal(request(Kind::Texture, "text.txt", "a.tx")),
              testing::StartsWith("badfile: MakeTexture \"a.tx\": it cannot be made: "));
  messages_.clear();
  EXPECT_NE(make(request(Kind::Texture, "halves.tif", folder_ + "/sub/a.tx"), true), "");
  EXPECT_NE(make(request(Kind::Texture, "halves.tif", "sub/b.tx")), "");
  EXPECT_THAT(messages_, testing::IsEmpty());
  EXPECT_EQ(filesIn("sub"), 2u);
  EXPECT_EQ(filesIn("."), 3u);
}

TEST_F(TextureMakerTest, EveryFilterOfRiIsKnown) {
  writeTiff8("halves.tif", 64, 64, halves);
  for (const char* filter : {"box", "triangle", "catmull-rom", "b-spline", "gaussian", "sinc", "mitchell",
                             "disk", "blackman-harris"}) {
    MakeRequest r = request(MakeRequest::Kind::Texture, "halves.tif", std::string(filter) + ".tx");
    r.filter = filter;
    EXPECT_NE(make(r), "") << filter;
    PatinaTexture* const texture = textures_->open(r.texture, {});
    ASSERT_NE(texture, nullptr);
    EXPECT_NEAR(read(texture, 0.5f, 0.5f, 1)[0], kLinear128 / 2, 0.02f) << filter;
  }
  EXPECT_THAT(messages_, testing::IsEmpty());
}

TEST_F(TextureMakerTest, AnEnvironmentIsLookedUpAsItsPictureIs) {
  writeTiff8("sky.tif", 64, 32, [](int x, int y) { return std::array<int, 3>{4 * x, 8 * y, 0}; });
  MakeRequest r = request(MakeRequest::Kind::LatLong, "sky.tif", "sky.env");
  r.colorSpace = "linear";
  ASSERT_NE(make(r), "");
  PatinaTexture* const sky = textures_->open("sky.env", {});
  ASSERT_NE(sky, nullptr);
  Batch batch(1);
  PatinaOut3 color = batch.out3();
  ASSERT_EQ(TextureService::environment(sky, 1, batch.uniform(Triple{1, 0, 0}), batch.uniform(0.0f), color),
            PATINA_OK);
  EXPECT_NEAR(color.x[0], 31.5f * 4 / 255, 2e-3f);
  EXPECT_NEAR(color.y[0], 15.5f * 8 / 255, 2e-3f);
}

// A sky whose colour is (1 + direction) / 2, seen by six cameras as RI 3.2 places them.
TEST_F(TextureMakerTest, SixFacesBecomeASkyWithTheirDirections) {
  using Axis = std::array<double, 3>;
  const struct {
    const char* name;
    Axis forward, right, up;
  } faces[] = {{"px.tif", {1, 0, 0}, {0, 0, -1}, {0, 1, 0}}, {"nx.tif", {-1, 0, 0}, {0, 0, 1}, {0, 1, 0}},
               {"py.tif", {0, 1, 0}, {1, 0, 0}, {0, 0, -1}}, {"ny.tif", {0, -1, 0}, {1, 0, 0}, {0, 0, 1}},
               {"pz.tif", {0, 0, 1}, {1, 0, 0}, {0, 1, 0}},  {"nz.tif", {0, 0, -1}, {-1, 0, 0}, {0, 1, 0}}};
  constexpr int kSide = 64;
  for (const float fov : {90.0f, 100.0f}) {
    MakeRequest r = request(MakeRequest::Kind::CubeFace, "", "cube.env");
    r.pictures.clear();
    r.fov = fov, r.colorSpace = "linear";
    const double scale = std::tan(double(fov) * std::acos(-1.0) / 360);
    for (const auto& face : faces) {
      writeTiff8(face.name, kSide, kSide, [&](int x, int y) {
        const double u = scale * ((x + 0.5) / kSide * 2 - 1), v = scale * (1 - (y + 0.5) / kSide * 2);
        const double length = std::sqrt(1 + u * u + v * v);
        std::array<int, 3> color;
        for (size_t c = 0; c < 3; ++c)
          color[c] = static_cast<int>(std::lround(
              255 * (0.5 + 0.5 * (face.forward[c] + u * face.right[c] + v * face.up[c]) / length)));
        return color;
      });
      r.pictures.emplace_back(face.name);
    }
    fs::remove("cube.env");
    ASSERT_NE(make(r), "");
    serve({});
    PatinaTexture* const sky = textures_->open("cube.env", {});
    ASSERT_NE(sky, nullptr);
    for (int i = 0; i < 200; ++i) {  // a spherical Fibonacci lattice
      const double z = 1 - (2.0 * i + 1) / 200, phi = i * 2.399963229728653, radius = std::sqrt(1 - z * z);
      const Triple d{float(radius * std::cos(phi)), float(radius * std::sin(phi)), float(z)};
      Batch batch(1);
      PatinaOut3 color = batch.out3();
      ASSERT_EQ(TextureService::environment(sky, 1, batch.uniform(d), batch.uniform(0.0f), color), PATINA_OK);
      for (size_t c = 0; c < 3; ++c)  // eight bits, and the slope over a pixel
        EXPECT_NEAR(get(color, 0)[c], 0.5f + 0.5f * d[c], 0.01f) << i << ' ' << fov;
    }
  }
  EXPECT_THAT(messages_, testing::IsEmpty());
}

}  // namespace
}  // namespace patina::test
