// SPDX-License-Identifier: Apache-2.0
// Values and files: Exposure, Quantize, display types and modes, EXR and the image module.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <thread>

#include "renderer/film/exr.h"
#include "renderer/film/output.h"

namespace patina {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

TEST(Tone, ExposureIsRis) {
  EXPECT_EQ(exposed(0.5f, 2, 1), 1);
  EXPECT_FLOAT_EQ(exposed(0.25f, 1, 2), 0.5f);
  EXPECT_FLOAT_EQ(exposed(0.125f, 2, 2), 0.5f);
  EXPECT_EQ(exposed(-1, 1, 2.2f), 0);
  EXPECT_EQ(exposed(-1, 1, 1), -1);
}

// IEC 61966-2-1.
TEST(Tone, SrgbCurve) {
  EXPECT_EQ(srgbEncoded(0), 0);
  EXPECT_EQ(srgbEncoded(-3), 0);
  EXPECT_NEAR(srgbEncoded(0.0031308f), 0.04045f, 1e-6);
  EXPECT_NEAR(srgbEncoded(0.214041f), 0.5f, 1e-5);
  EXPECT_NEAR(srgbEncoded(1), 1, 1e-6);
}

TEST(Tone, QuantizeWithoutDitherRoundsAndClamps) {
  const Quantizer q{255, 0, 255, 0};
  EXPECT_EQ(quantized(0.5f, q, 3, 4, 0), 128) << "127.5 rounds up";
  EXPECT_EQ(quantized(0.4999f / 255, q, 3, 4, 0), 0);
  EXPECT_EQ(quantized(2, q, 3, 4, 0), 255);
  EXPECT_EQ(quantized(-1, q, 3, 4, 0), 0);
  EXPECT_EQ(quantized(std::nanf(""), q, 3, 4, 0), 0);
  EXPECT_EQ(quantized(0.5f, {1023, 64, 940, 0}, 0, 0, 0), 512);
  EXPECT_EQ(quantized(0, {1023, 64, 940, 0}, 0, 0, 0), 64);
}

// Dither of 0.5 is uniform over one step: the mean of the quantised values is the value. 65536 values of a
// variance of at most 1/4 have a mean with sigma 0.002.
TEST(Tone, DitherKeepsTheMeanAndIsTheSameEachTime) {
  const Quantizer q{255, 0, 255, 0.5f};
  for (const float steps : {17.25f, 100.5f, 3.9f}) {
    double sum = 0;
    for (int y = 0; y < 256; ++y)
      for (int x = 0; x < 256; ++x) {
        const float value = quantized(steps / 255, q, x, y, 1);
        ASSERT_TRUE(value == std::floor(steps) || value == std::ceil(steps)) << value;
        ASSERT_EQ(value, quantized(steps / 255, q, x, y, 1));
        sum += static_cast<double>(value);
      }
    EXPECT_NEAR(sum / 65536, static_cast<double>(steps), 0.01);
  }
  EXPECT_EQ(quantized(1, q, 5, 6, 3), 255) << "a whole step is not dithered away";
}

// ---- Files

class OutputTest : public testing::Test {
 protected:
  OutputTest() : folder_(fs::temp_directory_path() / ("patina-film-" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
    FilmSettings settings;
    settings.width = 5;
    settings.height = 4;
    settings.filter = {PixelFilter::Kind::Box, 1, 1};
    film_ = std::make_unique<Film>(settings);
    for (int i = 0; i < film_->tileCount(); ++i) {
      FilmTile tile = film_->begin(i);
      const PixelRect& r = tile.samplePixels();
      for (int y = r.y0; y < r.y1; ++y)
        for (int x = r.x0; x < r.x1; ++x) {
          const float v = static_cast<float>(x + 5 * y) / 19;
          tile.addSample(x + 0.5, y + 0.5, std::array{v, v / 2, 4 * v, x == 0 ? 0.5f : 1.f, 10 + v});
        }
      film_->finish(std::move(tile));
    }
  }
  ~OutputTest() override { fs::remove_all(folder_); }

  OutputSettings request(const std::string& name, const std::string& type, const std::string& mode) const {
    OutputSettings s;
    s.name = (folder_ / name).string();
    s.type = type;
    s.mode = mode;
    s.colour.dither = 0;
    return s;
  }
  ImageData written(const OutputSettings& s) {
    path_ = writeImage(*film_, s, errors_);
    std::string error;
    const auto image = path_.empty() ? std::nullopt : readImage(path_, error);
    EXPECT_TRUE(image.has_value()) << error << messages_;
    for (const auto& entry : fs::directory_iterator(folder_))
      EXPECT_FALSE(entry.path().string().ends_with(".part")) << "left over: " << entry.path();
    return image.value_or(ImageData{});
  }

  fs::path folder_;
  std::unique_ptr<Film> film_;
  std::string messages_;
  ErrorHandler errors_{[this](Severity, std::string_view text) { messages_ += std::string(text) + "\n"; }};
  std::string path_;
};

TEST_F(OutputTest, ExrIsLinearExactAndNeedsNoModule) {
  OutputSettings s = request("a.exr", "openexr", "rgbaz");
  s.gamma = 2.2f;
  s.worldToCamera = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 3, 4, 5, 1};
  const bool loadedBefore = imageModuleLoaded();
  const ImageData image = written(s);
  EXPECT_EQ(imageModuleLoaded(), loadedBefore);
  ASSERT_EQ(image.channelNames, (std::vector<std::string>{"R", "G", "B", "A", "Z"}));
  ASSERT_EQ(image.width, 5);
  ASSERT_EQ(image.height, 4);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 5; ++x)
      for (int c = 0; c < 5; ++c) EXPECT_EQ(image.pixel(x, y)[c], film_->value(x, y, c));
}

TEST_F(OutputTest, ExrTakesTheGainAndHalfIfAsked) {
  OutputSettings s = request("a.exr", "exr", "rgb");
  s.gain = 4;
  s.parameters = {{"exrpixeltype", "half"}, {"exrcompression", "piz"}};
  const ImageData image = written(s);
  EXPECT_NEAR(image.pixel(4, 3)[2], 16, 1e-2);
  EXPECT_EQ(image.pixel(1, 0)[0], static_cast<float>(image.pixel(1, 0)[0]));
  s.parameters = {{"compression", "lzw"}};
  EXPECT_EQ(writeImage(*film_, s, errors_), "");
  EXPECT_THAT(messages_, HasSubstr("unknown EXR compression \"lzw\""));
}

TEST_F(OutputTest, SameFilmSameBytes) {
  const auto bytes = [](const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  for (const char* type : {"openexr", "tiff", "png"}) {
    const std::string a = bytes(writeImage(*film_, request("one", type, "rgba"), errors_));
    std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // TIFF files have a date
    const std::string b = bytes(writeImage(*film_, request("two", type, "rgba"), errors_));
    EXPECT_FALSE(a.empty());
    EXPECT_EQ(a, b) << type;
  }
}

// RI to the letter: (v*gain)^(1/gamma), times 255, rounded; alpha without exposure and associated.
TEST_F(OutputTest, TiffIsRisLetter) {
  OutputSettings s = request("a.tif", "tiff", "rgba");
  s.gain = 0.5f;
  s.gamma = 2;
  const ImageData image = written(s);
  ASSERT_EQ(image.channels, 4);
  for (int x = 0; x < 5; ++x) {
    const float v = static_cast<float>(x + 15) / 19;
    EXPECT_EQ(std::lround(image.pixel(x, 3)[0] * 255), std::lround(std::sqrt(v / 2) * 255));
    EXPECT_EQ(std::lround(image.pixel(x, 3)[2] * 255), std::min(255l, std::lround(std::sqrt(v * 2) * 255)));
    EXPECT_EQ(std::lround(image.pixel(x, 3)[3] * 255), x == 0 ? 128 : 255);
  }
}

TEST_F(OutputTest, TiffDepthFollowsQuantize) {
  OutputSettings s = request("sixteen", "file", "rgb");
  s.colour = {65535, 0, 65535, 0};
  EXPECT_NEAR(written(s).pixel(1, 0)[0], 1.f / 19, 0.51 / 65535);
  EXPECT_EQ(path_, (folder_ / "sixteen.tif").string());
  s = request("floats", "file", "rgb");
  s.colour.one = 0;
  EXPECT_EQ(written(s).pixel(4, 3)[2], 4) << "a float file is not clamped";
  EXPECT_EQ(written(request("depth", "file", "z")).pixel(4, 3)[0], 11)
      << "Quantize \"z\" 0 0 0 0 means floats";
}

TEST_F(OutputTest, PngIsMadeForLookingAt) {
  const ImageData image = written(request("a.png", "png", "rgb"));
  EXPECT_TRUE(image.srgb);
  for (int x = 0; x < 5; ++x)
    EXPECT_EQ(std::lround(image.pixel(x, 2)[0] * 255),
              std::lround(srgbEncoded(static_cast<float>(x + 10) / 19) * 255));
  OutputSettings s = request("b.png", "png", "rgb");
  s.gamma = 2;
  EXPECT_EQ(std::lround(written(s).pixel(0, 2)[0] * 255), std::lround(std::sqrt(10.f / 19) * 255))
      << "a gamma replaces the display transform";
}

// PNG stores colour unassociated; reading multiplies it with alpha (0.5 at x = 0) again.
TEST_F(OutputTest, PngAlphaIsUnassociated) {
  const float v = 10.f / 19;
  EXPECT_NEAR(written(request("a.png", "png", "rgba")).pixel(0, 2)[1], srgbEncoded(v) * 128 / 255, 2.0 / 255);
}

// RI's background shader: Ci + (1 - alpha) bgcolor, after Exposure.
TEST_F(OutputTest, TheBackgroundIsSeenWhereNothingCovers) {
  OutputSettings s = request("a.exr", "exr", "rgba");
  s.gain = 2, s.gamma = 2.2f;
  s.background = {0.25f, 0.5f, 1};
  const ImageData image = written(s);
  const float v = 10.f / 19;
  EXPECT_FLOAT_EQ(image.pixel(0, 2)[0], 2 * v + 0.5f * 0.25f);  // alpha 0.5
  EXPECT_FLOAT_EQ(image.pixel(0, 2)[2], 8 * v + 0.5f);
  EXPECT_EQ(image.pixel(0, 2)[3], 1);
  EXPECT_FLOAT_EQ(image.pixel(1, 2)[0], 2 * 11.f / 19);  // alpha 1
  EXPECT_EQ(image.pixel(1, 2)[3], 1);
}

// The sRGB of OpenColorIO's built-in transform and of IEC 61966-2-1 differ by its matrices' rounding only.
TEST_F(OutputTest, DisplayViewGoesThroughOpenColorIo) {
  std::string error;
  const PatinaImageModule* module = imageModule(error);
  ASSERT_NE(module, nullptr) << error;
  std::array<float, 6> rgb = {0.2f, 0.5f, 0.9f, 0.01f, 0.01f, 0.01f};
  const std::array<float, 6> before = rgb;
  std::array<char, 512> text{};
  ASSERT_EQ(module->applyView("sRGB", rgb.data(), 2, text.data(), text.size()), 1) << text.data();
  for (std::size_t i = 0; i < rgb.size(); ++i) EXPECT_NEAR(rgb[i], srgbEncoded(before[i]), 2e-3);

  OutputSettings s = request("a.png", "png", "rgb");
  s.displayView = "ACES sRGB";
  const ImageData image = written(s);
  EXPECT_LT(image.pixel(4, 3)[2], 1) << "ACES rolls highlights off";
  s.displayView = "nonsense";
  EXPECT_EQ(writeImage(*film_, s, errors_), "");
  EXPECT_THAT(messages_, HasSubstr("unknown display view \"nonsense\"; known are \"sRGB\""));
}

TEST_F(OutputTest, TypesThatNeedAWindowWriteAFileAndSaySo) {
  const auto path = [&](const char* name, const char* type, const char* mode) {
    return fs::path(outputPath(request(name, type, mode))).filename().string();
  };
  EXPECT_EQ(path("x.tif", "framebuffer", "rgb"), "x.png");
  EXPECT_EQ(path("x", "it", "rgba"), "x.png");
  EXPECT_EQ(path("x.z", "zfile", "z"), "x.z.exr");
  EXPECT_EQ(path("x.tif", "shadow", "z"), "x.tif");
  EXPECT_EQ(path("x", "framebuffer", "z"), "x.exr");
  EXPECT_EQ(path("x.0001", "file", "rgb"), "x.0001.tif");
  EXPECT_EQ(path("x.exr", "file", "rgb"), "x.exr");
  EXPECT_EQ(path("x.png", "tiff", "rgb"), "x.tif");
  EXPECT_EQ(path("x.TIFF", "tiff", "rgb"), "x.TIFF");
  OutputSettings additional;
  additional.name = "+x.tif";
  EXPECT_EQ(outputPath(additional), "x.tif");
  written(request("w.tif", "framebuffer", "rgb"));
  written(request("w.tif", "framebuffer", "rgb"));
  EXPECT_THAT(messages_, HasSubstr("Display type \"framebuffer\" needs a window"));
  EXPECT_THAT(messages_, HasSubstr("w.png is written"));
  EXPECT_EQ(std::count(messages_.begin(), messages_.end(), '\n'), 1) << "said once: " << messages_;
}

TEST_F(OutputTest, UnknownModesAreReplacedAndReported) {
  EXPECT_EQ(written(request("m.exr", "openexr", "Cs")).channels, 4);
  EXPECT_THAT(messages_, HasSubstr("unknown Display mode \"Cs\": \"rgba\" is written"));
  EXPECT_EQ(written(request("m2.exr", "openexr", "varying float z")).channelNames,
            std::vector<std::string>{"Z"});
  EXPECT_EQ(written(request("m.jpg", "jpeg", "rgba")).channels, 3);
  EXPECT_THAT(messages_, HasSubstr("holds no alpha"));
}

TEST_F(OutputTest, FailuresAreNamedAndLeaveNothing) {
  EXPECT_FALSE(checkOutput(request("none/a.exr", "openexr", "rgb"), *film_, errors_));
  EXPECT_THAT(messages_, HasSubstr("there is no folder " + (folder_ / "none").string()));
  EXPECT_EQ(writeImage(*film_, request("none/a.png", "png", "rgb"), errors_), "");
  EXPECT_EQ(errors_.count(Severity::Error), 2u);
  fs::create_directory(folder_ / "b.exr");
  EXPECT_EQ(writeImage(*film_, request("b.exr", "openexr", "rgb"), errors_), "");
  EXPECT_THAT(messages_, HasSubstr("it is a folder"));
}

// A limit on the size of files stands for a full disk: writes fail half way.
TEST_F(OutputTest, AFullDiskIsReportedAndLeavesNoHalfFile) {
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit tiny{50, before.rlim_max};
  for (const char* type : {"openexr", "tiff", "png"}) {
    const OutputSettings s = request("full", type, "rgb");
    setrlimit(RLIMIT_FSIZE, &tiny);
    const std::string path = writeImage(*film_, s, errors_);
    setrlimit(RLIMIT_FSIZE, &before);
    EXPECT_EQ(path, "") << type;
    EXPECT_THAT(messages_, HasSubstr("cannot write " + outputPath(s)));
    EXPECT_TRUE(fs::is_empty(folder_)) << type;
  }
  std::signal(SIGXFSZ, handler);
}

TEST_F(OutputTest, HostileImagesAreRefused) {
  const auto refused = [&](const std::string& name, const std::string& bytes) {
    const std::string path = (folder_ / name).string();
    std::ofstream(path, std::ios::binary) << bytes;
    std::string error;
    EXPECT_FALSE(readImage(path, error).has_value()) << name;
    EXPECT_THAT(error, HasSubstr("cannot read " + path));
  };
  refused("empty.exr", "");
  refused("magic.exr", "\x76\x2f\x31\x01");
  refused("text.tif", "this is no picture");
  std::string error;
  EXPECT_FALSE(readImage((folder_ / "missing.png").string(), error).has_value());
  EXPECT_FALSE(readImage(folder_.string(), error).has_value());

  // A whole file cut short, and one whose data window claims 2^31 pixels a side.
  const std::string path = writeImage(*film_, request("good.exr", "openexr", "rgb"), errors_);
  std::ifstream in(path, std::ios::binary);
  const std::string good(std::istreambuf_iterator<char>(in), {});
  refused("short.exr", good.substr(0, good.size() - 20));
  std::string huge = good;
  const std::size_t window = huge.find("dataWindow");
  ASSERT_NE(window, std::string::npos);
  huge.replace(window + 11 + 6 + 4 + 8, 8, "\xff\xff\xff\x7e\xff\xff\xff\x7e");
  refused("huge.exr", huge);
}

TEST(OutputName, TypeByExtension) {
  EXPECT_EQ(displayTypeFor("a/b.exr"), "openexr");
  EXPECT_EQ(displayTypeFor("b.PNG"), "png");
  EXPECT_EQ(displayTypeFor("b.tif"), "tiff");
  EXPECT_EQ(displayTypeFor("b"), "");
  EXPECT_EQ(displayTypeFor("b.rib"), "");
}

}  // namespace
}  // namespace patina
