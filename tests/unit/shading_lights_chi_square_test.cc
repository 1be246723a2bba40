// SPDX-License-Identifier: Apache-2.0
// Chi-square tests of the lights that have a density of their own: suns and environments. Point, spot and
// distant lights are deltas, which have none; points on area lights are tested with the emitters.
#include <filesystem>
#include <fstream>

#include "tests/unit/chi_square.h"
#include "tests/unit/plugins/bound_shader.h"

namespace patina::test {
namespace {

constexpr uint32_t kBatch = 1 << 12;

/// Directions that the light draws, a batch at a time.
class Drawn {
 public:
  explicit Drawn(const BoundShader& shader) : shader_(shader) {}
  V3f next(Independent& random) {
    if (used_ == directions_.size()) draw(random);
    return directions_[used_++];
  }

 private:
  void draw(Independent& random) {
    Batch batch = shader_.batch(kBatch);
    batch.lightIn.task = PATINA_LIGHT_SAMPLE;
    batch.lightIn.P = batch.uniform({0, 0, 0});
    batch.lightIn.random_x = batch.varying([&](uint32_t) { return random.next(); });
    batch.lightIn.random_y = batch.varying([&](uint32_t) { return random.next(); });
    PatinaLightOut out = batch.lightOut();
    ASSERT_EQ(shader_->light(batch.lightIn, out), PATINA_OK);
    directions_.clear();
    for (uint32_t i = 0; i < kBatch; ++i)
      directions_.emplace_back(out.direction.x[i], out.direction.y[i], out.direction.z[i]);
    used_ = 0;
  }
  const BoundShader& shader_;
  std::vector<V3f> directions_;
  size_t used_ = 0;
};

std::vector<float> densities(const BoundShader& shader, const std::vector<V3f>& directions) {
  const auto count = static_cast<uint32_t>(directions.size());
  Batch batch = shader.batch(count);
  batch.lightIn.task = PATINA_LIGHT_EVALUATE;
  batch.lightIn.P = batch.uniform({0, 0, 0});
  batch.lightIn.direction = batch.varying3([&](uint32_t i) {
    return Triple{directions[i].x, directions[i].y, directions[i].z};
  });
  PatinaLightOut out = batch.lightOut();
  EXPECT_EQ(shader->light(batch.lightIn, out), PATINA_OK);
  return {out.pdf, out.pdf + count};
}

TEST(LightsChiSquare, Sun) {
  Fits fits;
  for (const float angle : {0.53f, 5.0f, 90.0f, 180.0f}) {
    const BoundShader shader("distantlight",
                             {number("angle", angle), triple("to", ValueType::Point, {1, 2, 3})});
    const double sine = std::sin(static_cast<double>(angle) * std::numbers::pi / 720);
    Drawn drawn(shader);
    fitDirections(
        fits, "sun " + std::to_string(angle), SphereGrid::cone(-V3f(1, 2, 3).normalized(), 2 * sine * sine),
        [&](Independent& random) { return std::optional(drawn.next(random)); },
        [&](const V3f& w) { return densities(shader, {w})[0]; });
  }
}

TEST(LightsChiSquare, ConstantEnvironment) {
  const BoundShader shader("envlight");
  Fits fits;
  Drawn drawn(shader);
  fitDirections(
      fits, "envlight", SphereGrid::even(V3f(0.6f, 0, 0.8f)),
      [&](Independent& random) { return std::optional(drawn.next(random)); },
      [&](const V3f& w) { return densities(shader, {w})[0]; });
}

/// Temporary pictures and the service that reads them.
class EnvironmentMap : public testing::Test {
 protected:
  EnvironmentMap() {
    std::string name = testing::TempDir() + "patina-environment-XXXXXX";
    folder_ = mkdtemp(name.data());
    textures_ = std::make_unique<TextureService>(
        std::vector<std::string>{folder_}, std::map<std::string, std::string>{}, size_t{64} << 20, errors_);
  }
  ~EnvironmentMap() override {
    textures_.reset();
    std::filesystem::remove_all(folder_);
  }

  /// `pixel(x, y)` is the grey of an 8-bit picture of 64 x 32 pixels.
  void fit(Fits& fits, const std::string& name, const std::function<int(int, int)>& pixel) {
    std::ofstream file(folder_ + "/" + name + ".ppm", std::ios::binary);
    file << "P6 64 32 255\n";
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < 64; ++x)
        for (int c = 0; c < 3; ++c) file.put(static_cast<char>(pixel(x, y)));
    file.close();
    M44d turned;
    turned.setEulerAngles(V3d(0.3, 0.5, 0.7));
    const BoundShader shader("envlight", {text("texturename", name + ".ppm")}, turned, textures_.get());

    // The density over the angles, pdf * sin(theta), is constant in 256 x 512 steps of theta and phi: each
    // cell of the test holds 4 x 8 of these, and its integral is a sum.
    constexpr size_t kRows = 64, kColumns = 64, kAlong = 4, kAround = 8;
    const auto axis = [&](int k) { return V3f(V3d(turned[k][0], turned[k][1], turned[k][2])); };
    const auto cellOf = [&](const V3f& d) {
      const double x = static_cast<double>(d.dot(axis(0))), y = static_cast<double>(d.dot(axis(1))),
                   z = static_cast<double>(d.dot(axis(2)));
      const double s = std::atan2(y, x) / (2 * std::numbers::pi) + 0.5,
                   t = std::atan2(std::hypot(x, y), z) / std::numbers::pi;
      return std::min(static_cast<size_t>(t * kRows), kRows - 1) * kColumns +
             std::min(static_cast<size_t>(s * kColumns), kColumns - 1);
    };
    std::vector<double> counts(kRows * kColumns), chances(counts.size());
    Independent random(seedOf(name));
    Drawn drawn(shader);
    for (uint32_t k = 0; k < kChiSquareSamples; ++k) ++counts[cellOf(drawn.next(random))];
    for (size_t row = 0; row < kRows * kAlong; ++row) {
      constexpr size_t kAll = kColumns * kAround;
      const double theta = (static_cast<double>(row) + 0.5) * std::numbers::pi / (kRows * kAlong);
      std::vector<V3f> directions;
      for (size_t column = 0; column < kAll; ++column) {
        const double phi = ((static_cast<double>(column) + 0.5) / kAll - 0.5) * 2 * std::numbers::pi;
        directions.push_back(axis(0) * static_cast<float>(std::sin(theta) * std::cos(phi)) +
                             axis(1) * static_cast<float>(std::sin(theta) * std::sin(phi)) +
                             axis(2) * static_cast<float>(std::cos(theta)));
      }
      const std::vector<float> pdf = densities(shader, directions);
      const double step = std::sin(theta) * std::numbers::pi / (kRows * kAlong) * 2 * std::numbers::pi / kAll;
      for (size_t column = 0; column < kAll; ++column)
        chances[row / kAlong * kColumns + column / kAround] += static_cast<double>(pdf[column]) * step;
    }
    fits.add(name, std::move(counts), std::move(chances));
  }

  ErrorHandler errors_{[](Severity, std::string_view message) { ADD_FAILURE() << message; }};
  std::string folder_;
  std::unique_ptr<TextureService> textures_;
};

TEST_F(EnvironmentMap, ChiSquare) {
  Fits fits;
  fit(fits, "gradient", [](int x, int y) { return 20 + 3 * y + 2 * x; });
  fit(fits, "sun", [](int x, int y) { return x == 40 && y == 9 ? 255 : 1; });
  fit(fits, "sun in a black sky", [](int x, int y) { return x == 40 && y == 9 ? 255 : 0; });
  fit(fits, "suns at the poles", [](int x, int y) { return y == 0 || (y == 31 && x == 5) ? 255 : 1; });
  fit(fits, "checks", [](int x, int y) { return (x / 4 + y / 4) % 2 ? 200 : 10; });
}

// A sun of one pixel in a large picture: the irradiance of a surface that faces it is that of the picture,
// and little depends on which samples are drawn.
TEST_F(EnvironmentMap, SmallSunIsSampledWell) {
  constexpr int kWidth = 1024, kHeight = 512, kSunX = 300, kSunY = 200;
  {
    std::ofstream file(folder_ + "/sun.hdr", std::ios::binary);
    file << "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y " << kHeight << " +X " << kWidth << "\n";
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {  // mantissa 128: 2^(exponent - 129), that is 1 and 2^17
        const bool sun = x == kSunX && y == kSunY;
        for (const int byte : {128, 128, 128, sun ? 146 : 129}) file.put(static_cast<char>(byte));
      }
  }
  const BoundShader shader("envlight", {text("texturename", "sun.hdr")}, M44d(), textures_.get());
  constexpr double pi = std::numbers::pi;
  const double theta = pi * (kSunY + 0.5) / kHeight, phi = 2 * pi * ((kSunX + 0.5) / kWidth - 0.5);
  const V3d normal(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
  // Interpolation between pixels keeps their sum; over its two pixels the cosine to the sun is 1 to 2e-5.
  const double expected = pi + (std::ldexp(1.0, 17) - 1) * std::sin(theta) * pi / kHeight * 2 * pi / kWidth;

  constexpr uint32_t kCount = 1 << 17;
  Independent random(seedOf("small sun"));
  Batch batch = shader.batch(kCount);
  batch.lightIn.task = PATINA_LIGHT_SAMPLE;
  batch.lightIn.P = batch.uniform({0, 0, 0});
  batch.lightIn.random_x = batch.varying([&](uint32_t) { return random.next(); });
  batch.lightIn.random_y = batch.varying([&](uint32_t) { return random.next(); });
  PatinaLightOut out = batch.lightOut();
  ASSERT_EQ(shader->light(batch.lightIn, out), PATINA_OK);
  double sum = 0, squares = 0;
  for (uint32_t i = 0; i < kCount; ++i) {
    const V3d d(static_cast<double>(out.direction.x[i]), static_cast<double>(out.direction.y[i]),
                static_cast<double>(out.direction.z[i]));
    const double value = static_cast<double>(out.radiance.x[i]) * std::max(d.dot(normal), 0.0) /
                         static_cast<double>(out.pdf[i]);
    sum += value, squares += value * value;
  }
  const double mean = sum / kCount, deviation = std::sqrt(squares / kCount - mean * mean);
  EXPECT_NEAR(mean, expected, 4 * deviation / std::sqrt(double(kCount)));
  // Of one sample: 1.14 was measured. Cells of a pixel's size give 1.5, and a table that leaves out what
  // interpolation brings to the cells beside the sun's misses 15 % of the light in as many samples.
  EXPECT_LT(deviation, 1.2 * mean);
  RecordProperty("deviation", std::to_string(deviation / mean));
  RecordProperty("mean", std::to_string(mean / expected));
}

}  // namespace
}  // namespace patina::test
