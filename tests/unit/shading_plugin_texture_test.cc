// SPDX-License-Identifier: Apache-2.0
// Textures: where they are found, which texel a coordinate reads, and shaders that use them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <barrier>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <numbers>
#include <random>
#include <thread>

#include "tests/unit/plugins/bound_shader.h"

namespace patina::test {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;
/// Colour spaces are the matter of another test.
const TextureColors kAsInFile{true, {}, {}};

class TextureTest : public testing::Test {
 protected:
  TextureTest() : errors_([this](Severity, std::string_view text) { messages_.emplace_back(text); }) {
    std::string name = testing::TempDir() + "patina-textures-XXXXXX";
    folder_ = mkdtemp(name.data());
    textures_ = std::make_unique<TextureService>(std::vector<std::string>{folder_},
                                                 std::map<std::string, std::string>{{"made.txt", "ramp.ppm"}},
                                                 size_t(64) << 20, errors_, kAsInFile);
  }
  ~TextureTest() override {
    textures_.reset();
    std::filesystem::remove_all(folder_);
  }

  // An 8-bit picture in the portable pixmap format: `pixel(x, y)` gives three bytes; row 0 is the top.
  void writePicture(const std::string& name, int width, int height,
                    const std::function<std::array<int, 3>(int, int)>& pixel) const {
    std::ofstream file(folder_ + "/" + name, std::ios::binary);
    file << "P6 " << width << ' ' << height << " 255\n";
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        for (const int value : pixel(x, y)) file.put(static_cast<char>(value));
  }

  Triple read(PatinaTexture* texture, float s, float t, float width = 0) {
    Batch batch(1);
    PatinaOut3 color = batch.out3(-1);
    EXPECT_EQ(TextureService::texture(texture, 1, batch.uniform(s), batch.uniform(t), batch.uniform(width),
                                      color, nullptr),
              PATINA_OK);
    return get(color, 0);
  }

  std::vector<std::string> messages_;
  ErrorHandler errors_;
  std::string folder_;
  std::unique_ptr<TextureService> textures_;
};

// Red grows with the column, green with the row.
std::array<int, 3> ramp(int x, int y) { return {40 * x, 60 * y, 128}; }

// Frame after frame in one process, whose threads outlive what each frame knows of textures: a thread must be
// given the picture that is there now, and no memory of former systems.
TEST_F(TextureTest, SystemsFollowEachOtherWhileThreadsLive) {
  constexpr int kSystems = 12;
  std::barrier turn(2);
  PatinaTexture* texture = nullptr;
  std::array<Triple, kSystems> fromWorker;
  std::thread worker([&] {
    for (Triple& color : fromWorker) {
      turn.arrive_and_wait();
      if (texture) color = read(texture, 0.5f, 0.5f);
      turn.arrive_and_wait();
    }
  });
  for (int k = 0; k < kSystems; ++k) {
    writePicture("changing.ppm", 2 + k, 2, [&](int, int) { return std::array<int, 3>{20 * k, 255 - k, 7}; });
    textures_ = std::make_unique<TextureService>(std::vector<std::string>{folder_},
                                                 std::map<std::string, std::string>{}, size_t(64) << 20,
                                                 errors_, kAsInFile);
    texture = textures_->open("changing.ppm", {});
    turn.arrive_and_wait();
    turn.arrive_and_wait();
    EXPECT_NE(texture, nullptr);
    if (!texture) continue;
    const Triple expected{static_cast<float>(20 * k) / 255, static_cast<float>(255 - k) / 255, 7.0f / 255};
    for (const Triple& color : {fromWorker[static_cast<size_t>(k)], read(texture, 0.5f, 0.5f)})
      for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(color[c], expected[c], 1e-6f) << k;
  }
  worker.join();
  EXPECT_THAT(messages_, testing::IsEmpty());
}

TEST_F(TextureTest, TheFirstRowIsAtTZeroAndValuesAreAsInTheFile) {
  writePicture("ramp.ppm", 4, 4, ramp);
  EXPECT_FALSE(textures_->loaded());
  PatinaTexture* texture = textures_->open("ramp.ppm", {});
  ASSERT_NE(texture, nullptr);
  EXPECT_TRUE(textures_->loaded());
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x)
      expectNear(read(texture, (float(x) + 0.5f) / 4, (float(y) + 0.5f) / 4),
                 {40 * float(x) / 255, 60 * float(y) / 255, 128.0f / 255}, 1e-5f);
  uint32_t width = 0, height = 0, channels = 0;
  EXPECT_EQ(TextureService::size(texture, &width, &height, &channels), PATINA_OK);
  EXPECT_EQ(width, 4u);
  EXPECT_EQ(height, 4u);
  EXPECT_EQ(channels, 3u);
  EXPECT_EQ(textures_->open("ramp.ppm", {}), texture);
}

TEST_F(TextureTest, WrapsAroundAndFiltersToTheMean) {
  writePicture("ramp.ppm", 4, 4, ramp);
  PatinaTexture* texture = textures_->open("ramp.ppm", {});
  ASSERT_NE(texture, nullptr);
  expectNear(read(texture, 1.125f, -0.875f), read(texture, 0.125f, 0.125f), 1e-5f);
  expectNear(read(texture, 0.5f, 0.5f, 1), {60.0f / 255, 90.0f / 255, 128.0f / 255}, 0.02f);
}

TEST_F(TextureTest, AMissingTextureIsReportedOnceWithEveryPathAndReadsOne) {
  const Location where{internFileName("t.rib"), 2, 4};
  EXPECT_EQ(textures_->open("nowhere.tx", where), nullptr);
  EXPECT_EQ(textures_->open("nowhere.tx", where), nullptr);
  ASSERT_EQ(messages_.size(), 1u);
  EXPECT_THAT(messages_[0],
              testing::StartsWith(
                  "t.rib:2:4: error: nofile: texture \"nowhere.tx\" is not found, it reads 1; tried:\n  " +
                  folder_ + "/nowhere.tx: no such file\n"));
  EXPECT_THAT(messages_[0], testing::HasSubstr(folder_ + "/nowhere.tif: no such file"));
  EXPECT_FALSE(textures_->loaded());
  expectNear(read(nullptr, 0.3f, 0.4f), {1, 1, 1});
}

TEST_F(TextureTest, AFileThatIsNoPictureIsReported) {
  std::ofstream(folder_ + "/text.png") << "not a picture";
  std::ofstream(folder_ + "/empty.tif") << "";
  EXPECT_EQ(textures_->open("text.png", {}), nullptr);
  EXPECT_EQ(textures_->open("empty.tif", {}), nullptr);
  EXPECT_EQ(messages_.size(), 2u);
}

TEST_F(TextureTest, FindsThePictureThatATextureWasMadeFrom) {
  writePicture("wood.tif", 2, 2, ramp);  // the suffix does not matter to the reader
  EXPECT_NE(textures_->open("textures/wood.tx", {}), nullptr);
  EXPECT_NE(textures_->open("wood.tif.tx", {}), nullptr);
  EXPECT_TRUE(messages_.empty());
}

TEST_F(TextureTest, ANameOfMakeTextureStandsForItsPicture) {
  writePicture("ramp.ppm", 4, 4, ramp);
  PatinaTexture* texture = textures_->open("made.txt", {});
  ASSERT_NE(texture, nullptr);
  expectNear(read(texture, 0.875f, 0.125f), {120.0f / 255, 0, 128.0f / 255}, 1e-5f);
}

TEST_F(TextureTest, TexturesBesideTheRibAreFound) {
  std::filesystem::create_directory(folder_ + "/scene");
  writePicture("scene/beside.ppm", 4, 4, ramp);
  EXPECT_NE(textures_->open("beside.ppm", {internFileName(folder_ + "/scene/a.rib"), 1, 1}), nullptr);
}

// The mapping of PatinaHost: +z is the top row, s = 0.5 + atan2(y, x) / 2 pi.
TEST_F(TextureTest, EnvironmentsAreLookedUpByDirection) {
  writePicture("sky.ppm", 64, 32, [](int x, int y) { return std::array<int, 3>{x * 4, y * 8, 0}; });
  PatinaTexture* sky = textures_->open("sky.ppm", {});
  ASSERT_NE(sky, nullptr);
  const std::pair<Triple, Triple> cases[] = {{{0, 0, 2}, {-1, 0, 0}},                 // the top row
                                             {{0, 0, -1}, {-1, 31 * 8, 0}},           // the bottom row
                                             {{1, 0, 0}, {31.5f * 4, 15.5f * 8, 0}},  // the middle
                                             {{0, 1, 0}, {47.5f * 4, 15.5f * 8, 0}},  // three quarters
                                             {{0, -3, 0}, {15.5f * 4, 15.5f * 8, 0}}};
  for (const auto& [direction, expected] : cases) {
    Batch batch(1);
    PatinaOut3 color = batch.out3();
    ASSERT_EQ(TextureService::environment(sky, 1, batch.uniform(direction), batch.uniform(0.0f), color),
              PATINA_OK);
    if (expected[0] >= 0) {
      EXPECT_NEAR(color.x[0], expected[0] / 255, 1e-4f);
    }
    EXPECT_NEAR(color.y[0], expected[1] / 255, 1e-4f);
  }
}

TEST_F(TextureTest, PaintedPlasticMultipliesCsByItsTexture) {
  writePicture("ramp.ppm", 4, 4, ramp);
  const BoundShader shader("paintedplastic", {text("texturename", "ramp.ppm"), number("Kd", 0.5f)}, M44d(),
                           textures_.get());
  EXPECT_EQ(shader->reads(PATINA_ENTRY_RADIOSITY),
            PATINA_CHANNEL_CS | PATINA_CHANNEL_OS | PATINA_CHANNEL_ST | PATINA_CHANNEL_FOOTPRINT);
  Batch batch = shader.batch(20);
  batch.points.Cs = batch.uniform({1, 0.5f, 0.25f});
  batch.points.Os = batch.uniform({1, 1, 1});
  batch.points.s = batch.varying([](uint32_t i) { return (float(i % 4) + 0.5f) / 4; });
  batch.points.t = batch.varying([](uint32_t i) { return (float(i / 4 % 4) + 0.5f) / 4; });
  batch.points.footprint_st = batch.uniform(0.0f);
  batch.points.footprint = batch.uniform(0.0f);
  PatinaRadiosityOut out = batch.radiosityOut();
  ASSERT_EQ(shader->radiosity(batch.points, out), PATINA_OK);
  for (uint32_t i = 0; i < 20; ++i)
    expectNear(get(out.reflectance, i),
               {0.5f * 40 * float(i % 4) / 255, 0.25f * 60 * float(i / 4 % 4) / 255, 0.125f * 128 / 255},
               1e-5f);
}

TEST_F(TextureTest, ShinyMetalReflectsItsPictureInsteadOfTheScene) {
  writePicture("sky.ppm", 64, 32, [](int, int y) { return std::array<int, 3>{y < 16 ? 255 : 0, 0, 51}; });
  const BoundShader shader("shinymetal", {text("texturename", "sky.ppm"), number("Kr", 0.5f)}, M44d(),
                           textures_.get());
  Batch batch = shader.batch(1);
  batch.points.Cs = batch.uniform({1, 1, 0.5f});
  batch.points.Os = batch.uniform({1, 1, 1});
  batch.points.N = batch.uniform({0, 0, 1});
  batch.points.I = batch.uniform({0.6f, 0, -0.8f});  // reflected upwards
  PatinaViewOut out = batch.viewOut();
  ASSERT_EQ(shader->view(batch.points, out), PATINA_OK);
  EXPECT_EQ(out.lobe_count, 1u);
  expectNear(get(out.emission, 0), {0.5f, 0, 0.05f}, 1e-5f);
}

TEST_F(TextureTest, LibraryShadersReadTheirTextures) {
  writePicture("steps.ppm", 4, 1, [](int x, int) { return std::array<int, 3>{85 * x, 51, 0}; });
  const auto bound = [&](const char* name, std::vector<ShaderArgument> arguments) {
    arguments.push_back(text("texturename", "steps.ppm"));
    return BoundShader(name, std::move(arguments), M44d(), textures_.get());
  };
  const BoundShader paint = bound("texturedmatte", {number("Kd", 0.5f)});
  const BoundShader relief = bound(
      "displace", {number("Km", 2), number("middle", 0.5f), number("low", 0.25f), number("high", 0.9f)});
  const BoundShader sheet = bound("cutout", {number("radius", 0.5f)});
  Batch batch = paint.batch(4);
  batch.points.s = batch.varying([](uint32_t i) { return (float(i) + 0.5f) / 4; });
  batch.points.t = batch.uniform(0.5f);
  batch.points.footprint = batch.points.footprint_st = batch.uniform(0);
  batch.points.P = batch.uniform({0, 0, 0});
  batch.points.N = batch.uniform({0, 0, 1});
  batch.points.Cs = batch.uniform({1, 0.5f, 1});
  batch.points.Os = batch.uniform({1, 1, 1});
  PatinaRadiosityOut painted = batch.radiosityOut(), cut = batch.radiosityOut();
  PatinaDisplacementOut moved = batch.displacementOut();
  ASSERT_EQ(paint->radiosity(batch.points, painted), PATINA_OK);
  batch.points.values = relief->values().data();
  ASSERT_EQ(relief->displacement(batch.points, moved), PATINA_OK);
  batch.points.values = sheet->values().data();
  ASSERT_EQ(sheet->radiosity(batch.points, cut), PATINA_OK);
  EXPECT_FLOAT_EQ(relief->traits().displacement_bound, 0.8f);
  for (uint32_t i = 0; i < 4; ++i) {
    const float value = float(i) / 3;
    expectNear(get(painted.reflectance, i), {0.5f * value, 0.05f, 0}, 1e-5f);
    EXPECT_NEAR(get(moved.P, i)[2], 2 * (std::clamp(value, 0.25f, 0.9f) - 0.5f), 1e-5);
    EXPECT_EQ(cut.opacity.x[i], 1);  // a picture without alpha has no holes, round ones are not asked for
  }
}

// A bright square in a dark sky: the estimate of the sky's mean radiance agrees with the sum over the
// picture, `evaluate` with `sample`, and the density integrates to one.
TEST_F(TextureTest, EnvironmentLightIsDrawnByItsPicture) {
  const int width = 128, height = 64;
  const auto pixel = [](int x, int y) {
    const bool bright = x >= 40 && x < 44 && y >= 10 && y < 13;
    return bright ? std::array<int, 3>{255, 255, 255} : std::array<int, 3>{2, 2, 2};
  };
  writePicture("sky.ppm", width, height, pixel);
  M44d turned;
  turned.setEulerAngles(V3d(0.3, 0.5, 0.7));
  const BoundShader shader("envlight", {text("texturename", "sky.ppm"), number("intensity", 10)}, turned,
                           textures_.get());
  constexpr uint32_t kCount = 40000;
  Batch batch = shader.batch(kCount);
  std::mt19937 random(11);
  std::uniform_real_distribution<float> uniform(0, 1);
  batch.lightIn.task = PATINA_LIGHT_SAMPLE;
  batch.lightIn.P = batch.uniform({0, 0, 0});
  batch.lightIn.random_x = batch.varying([&](uint32_t) { return uniform(random); });
  batch.lightIn.random_y = batch.varying([&](uint32_t) { return uniform(random); });
  PatinaLightOut sampled = batch.lightOut();
  ASSERT_EQ(shader->light(batch.lightIn, sampled), PATINA_OK);
  double mean = 0, square = 0;
  for (uint32_t i = 0; i < kCount; ++i) {
    const double value = double(sampled.radiance.x[i]) / double(sampled.pdf[i]);
    mean += value / kCount;
    square += value * value / kCount;
  }
  double expected = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      expected += 10.0 * pixel(x, y)[0] / 255 * (2 * kPi / width) *
                  (std::cos(kPi * double(y) / height) - std::cos(kPi * double(y + 1) / height));
  const double sigma = std::sqrt((square - mean * mean) / kCount);
  EXPECT_LT(sigma, 0.01 * mean);                             // drawn uniformly it would be 0.03
  EXPECT_NEAR(mean, expected, 5 * sigma + 0.01 * expected);  // bilinear look-up blurs the square's edge

  Batch again = shader.batch(kCount);
  again.lightIn.task = PATINA_LIGHT_EVALUATE;
  again.lightIn.P = again.uniform({0, 0, 0});
  again.lightIn.direction = again.varying3([&](uint32_t i) { return get(sampled.direction, i); });
  PatinaLightOut evaluated = again.lightOut();
  ASSERT_EQ(shader->light(again.lightIn, evaluated), PATINA_OK);
  uint32_t neighbours = 0;
  for (uint32_t i = 0; i < kCount; ++i) {
    EXPECT_NEAR(evaluated.radiance.x[i], sampled.radiance.x[i], 1e-3 * sampled.radiance.x[i] + 1e-3);
    neighbours += std::abs(evaluated.pdf[i] - sampled.pdf[i]) > 0.01f * sampled.pdf[i];
  }
  EXPECT_LT(neighbours, kCount / 1000);  // on the edge of two cells, by rounding

  // Uniform directions: the mean density is 1 / 4 pi.
  Batch sphere = shader.batch(kCount);
  sphere.lightIn.task = PATINA_LIGHT_EVALUATE;
  sphere.lightIn.P = sphere.uniform({0, 0, 0});
  sphere.lightIn.direction = sphere.varying3([](uint32_t i) {  // a spherical Fibonacci lattice
    const double z = 1 - (2.0 * i + 1) / kCount, phi = i * 2.399963229728653, r = std::sqrt(1 - z * z);
    return Triple{float(r * std::cos(phi)), float(r * std::sin(phi)), float(z)};
  });
  PatinaLightOut densities = sphere.lightOut();
  ASSERT_EQ(shader->light(sphere.lightIn, densities), PATINA_OK);
  double total = 0;
  for (uint32_t i = 0; i < kCount; ++i) total += double(densities.pdf[i]) * 4 * double(kPi) / kCount;
  EXPECT_NEAR(total, 1, 0.02);
  EXPECT_TRUE(messages_.empty());
}

}  // namespace
}  // namespace patina::test
