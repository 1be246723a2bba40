// SPDX-License-Identifier: Apache-2.0
// Small picture files, written byte by byte, and a service that looks them up.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "renderer/shading/texture_service.h"
#include "tests/unit/plugins/batch.h"

namespace patina::test {

using Pixel8 = std::function<std::array<int, 3>(int x, int y)>;

/// Eight bits without a tag: an uncompressed TIFF of one strip. Row 0 is the top.
inline void writeTiff8(const std::string& path, int width, int height, const Pixel8& pixel) {
  std::string file("II*\0", 4);
  const auto put16 = [&](unsigned v) {
    file += static_cast<char>(v & 255), file += static_cast<char>(v >> 8);
  };
  const auto put32 = [&](unsigned v) { put16(v & 65535), put16(v >> 16); };
  const auto bytes = static_cast<unsigned>(3 * width * height), at = 8 + bytes + bytes % 2;
  put32(at);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (const int v : pixel(x, y)) file += static_cast<char>(v);
  file.resize(at);
  constexpr unsigned kShort = 3, kLong = 4;
  const unsigned entries[][4] = {{256, kShort, 1, static_cast<unsigned>(width)},
                                 {257, kShort, 1, static_cast<unsigned>(height)},
                                 {258, kShort, 3, at + 2 + 12 * 9 + 4},  // bits per sample, behind the table
                                 {259, kShort, 1, 1},                    // not compressed
                                 {262, kShort, 1, 2},                    // RGB
                                 {273, kLong, 1, 8},
                                 {277, kShort, 1, 3},
                                 {278, kShort, 1, static_cast<unsigned>(height)},
                                 {279, kLong, 1, bytes}};
  put16(9);
  for (const auto& e : entries) put16(e[0]), put16(e[1]), put32(e[2]), put32(e[3]);
  put32(0);
  for (int c = 0; c < 3; ++c) put16(8);
  std::ofstream(path, std::ios::binary) << file;
}

using Pixel32 = std::function<std::array<float, 3>(int x, int y)>;

/// Floats: an uncompressed TIFF of one strip. Row 0 is the top.
inline void writeTiff32(const std::string& path, int width, int height, const Pixel32& pixel) {
  std::string file("II*\0", 4);
  const auto put16 = [&](unsigned v) {
    file += static_cast<char>(v & 255), file += static_cast<char>(v >> 8);
  };
  const auto put32 = [&](unsigned v) { put16(v & 65535), put16(v >> 16); };
  const auto bytes = static_cast<unsigned>(12 * width * height), at = 8 + bytes;
  put32(at);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (const float v : pixel(x, y)) put32(std::bit_cast<uint32_t>(v));
  constexpr unsigned kShort = 3, kLong = 4, kBehind = 2 + 12 * 10 + 4;
  const unsigned entries[][4] = {{256, kShort, 1, static_cast<unsigned>(width)},
                                 {257, kShort, 1, static_cast<unsigned>(height)},
                                 {258, kShort, 3, at + kBehind},  // bits per sample
                                 {259, kShort, 1, 1},             // not compressed
                                 {262, kShort, 1, 2},             // RGB
                                 {273, kLong, 1, 8},
                                 {277, kShort, 1, 3},
                                 {278, kShort, 1, static_cast<unsigned>(height)},
                                 {279, kLong, 1, bytes},
                                 {339, kShort, 3, at + kBehind + 6}};  // format of samples
  put16(10);
  for (const auto& e : entries) put16(e[0]), put16(e[1]), put32(e[2]), put32(e[3]);
  put32(0);
  for (int c = 0; c < 3; ++c) put16(32);
  for (int c = 0; c < 3; ++c) put16(3);  // floats
  std::ofstream(path, std::ios::binary) << file;
}

/// PNG of one grey of eight bits and 1x1 pixels, with the chunk gAMA unless `gamma` (file gamma times 100000)
/// is 0.
inline void writePng(const std::string& path, int value, uint32_t gamma) {
  std::string file("\x89PNG\r\n\x1a\n", 8);
  const auto big = [](uint32_t v) {
    return std::string{static_cast<char>(v >> 24), static_cast<char>(v >> 16), static_cast<char>(v >> 8),
                       static_cast<char>(v)};
  };
  const auto chunk = [&](const std::string& type, const std::string& data) {
    uint32_t crc = ~0u;
    for (const char c : type + data) {
      crc ^= static_cast<uint8_t>(c);
      for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0u);
    }
    file += big(static_cast<uint32_t>(data.size())) + type + data + big(~crc);
  };
  chunk("IHDR", big(1) + big(1) + std::string("\x08\x02\0\0\0", 5));
  if (gamma) chunk("gAMA", big(gamma));
  // A stored block: filter 0 and three bytes, then their Adler-32.
  const std::string row = std::string(1, '\0') + std::string(3, static_cast<char>(value));
  uint32_t a = 1, b = 0;
  for (const char c : row) a = (a + static_cast<uint8_t>(c)) % 65521, b = (b + a) % 65521;
  chunk("IDAT", std::string("\x78\x01\x01\x04\0\xfb\xff", 7) + row + big(b << 16 | a));
  chunk("IEND", "");
  std::ofstream(path, std::ios::binary) << file;
}

/// Radiance's format, of one colour: floats. `mantissa` and `exponent`: value mantissa / 256 * 2^(exponent -
/// 128).
inline void writeHdr(const std::string& path, int mantissa, int exponent) {
  std::ofstream file(path, std::ios::binary);
  file << "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 2\n";
  for (int i = 0; i < 4; ++i)
    for (const int v : {mantissa, mantissa, mantissa, exponent}) file.put(static_cast<char>(v));
}

class TextureFilesTest : public testing::Test {
 protected:
  TextureFilesTest() : errors_([this](Severity, std::string_view text) { messages_.emplace_back(text); }) {
    std::string name = testing::TempDir() + "patina-texture-files-XXXXXX";
    folder_ = mkdtemp(name.data());
    serve({});
  }
  ~TextureFilesTest() override {
    textures_.reset();
    std::filesystem::remove_all(folder_);
  }

  void serve(TextureColors colors) {
    textures_ = std::make_unique<TextureService>(std::vector<std::string>{folder_},
                                                 std::map<std::string, std::string>{}, size_t(64) << 20,
                                                 errors_, std::move(colors));
  }

  Triple read(PatinaTexture* texture, float s, float t, float width = 0) {
    Batch batch(1);
    PatinaOut3 color = batch.out3(-1);
    EXPECT_EQ(TextureService::texture(texture, 1, batch.uniform(s), batch.uniform(t), batch.uniform(width),
                                      color, nullptr),
              PATINA_OK);
    return get(color, 0);
  }
  /// The middle of a texture that is there.
  float middle(const std::string& name, TextureService::Values values = TextureService::kColors) {
    PatinaTexture* const texture = textures_->open(name, {}, values);
    EXPECT_NE(texture, nullptr) << name;
    return texture ? read(texture, 0.5f, 0.5f)[0] : -1;
  }

  std::vector<std::string> messages_;
  ErrorHandler errors_;
  std::string folder_;
  std::unique_ptr<TextureService> textures_;
};

}  // namespace patina::test
