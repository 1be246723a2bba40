// SPDX-License-Identifier: Apache-2.0
// Contact sheets: pictures and their errors, as PNG.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "renderer/film/tone.h"
#include "tools/patina-bench/report.h"
#include "tools/patina-bench/scenes.h"

namespace patina::bench {
namespace {

constexpr int kGap = 4;  // pixels between pictures
constexpr size_t kMostPixels = size_t{1} << 28;

uint8_t byteOf(float v) { return static_cast<uint8_t>(std::lround(255 * std::clamp(v, 0.0f, 1.0f))); }

// Black for none, red for too bright, blue for too dark; white at the end of each.
std::array<float, 3> errorColour(double error) {
  const auto size = static_cast<float>(std::min(std::abs(error) * 2, 1.0));
  const float strong = std::min(2 * size, 1.0f), weak = std::max(2 * size - 1, 0.0f);
  return error > 0 ? std::array{strong, weak, weak} : std::array{weak, weak, strong};
}

struct Canvas {
  int width, height;
  std::vector<uint8_t> bytes;  // RGB

  void paint(int x0, int y0, const ImageData& picture, const ImageData* reference) {
    for (int y = 0; y < picture.height; ++y)
      for (int x = 0; x < picture.width; ++x) {
        const float* v = picture.pixel(x, y);
        std::array<float, 3> colour{};
        if (reference) {
          double error = 0;
          for (size_t c = 0; c < 3; ++c) {
            const auto r = static_cast<double>(reference->pixel(x, y)[c]);
            error += (static_cast<double>(v[c]) - r) * std::sqrt(relMseWeight(r)) / 3;
          }
          colour = errorColour(error);
        } else {
          for (size_t c = 0; c < 3; ++c) colour[c] = srgbEncoded(v[c]);
        }
        const size_t at =
            3 * (static_cast<size_t>(y0 + y) * static_cast<size_t>(width) + static_cast<size_t>(x0 + x));
        for (size_t c = 0; c < 3; ++c) bytes[at + c] = byteOf(colour[c]);
      }
  }
};

}  // namespace

void writeSheet(const std::filesystem::path& path, const ImageData& reference,
                const std::vector<std::vector<ImageData>>& rows) {
  size_t columns = 1;
  for (const std::vector<ImageData>& row : rows) columns = std::max(columns, row.size());
  const int w = reference.width + kGap, h = reference.height + kGap;
  const size_t pixels = columns * static_cast<size_t>(w) * (2 * rows.size() + 1) * static_cast<size_t>(h);
  if (pixels > kMostPixels) throw std::runtime_error(path.string() + ": too many pictures for a sheet");
  Canvas canvas{w * static_cast<int>(columns), h * static_cast<int>(2 * rows.size() + 1), {}};
  canvas.bytes.assign(3 * pixels, 64);
  canvas.paint(0, 0, reference, nullptr);
  for (size_t row = 0; row < rows.size(); ++row)
    for (size_t k = 0; k < rows[row].size(); ++k) {
      const ImageData& picture = rows[row][k];
      if (picture.width != reference.width || picture.height != reference.height) continue;
      const int x = w * static_cast<int>(k), y = h * static_cast<int>(2 * row + 1);
      canvas.paint(x, y, picture, nullptr);
      canvas.paint(x, y + h, picture, &reference);
    }

  std::string problem;
  const PatinaImageModule* module = imageModule(problem);
  if (!module) throw std::runtime_error(problem);
  static constexpr const char* kNames[] = {"R", "G", "B"};
  PatinaImageToWrite out{};
  out.structSize = sizeof out;
  out.width = out.fullWidth = canvas.width, out.height = out.fullHeight = canvas.height;
  out.channels = 3, out.pixelType = PATINA_PIXEL_U8, out.pixels = canvas.bytes.data();
  out.channelNames = kNames, out.alphaChannel = out.depthChannel = -1, out.srgb = 1;
  std::string bytes;
  std::array<char, 1024> error{};
  const auto append = [](void* to, const void* from, size_t size) {
    static_cast<std::string*>(to)->append(static_cast<const char*>(from), size);
  };
  if (!module->encode("png", &out, append, &bytes, error.data(), error.size()))
    throw std::runtime_error(fmt::format("{}: {}", path.string(), error.data()));
  writeText(path, bytes);
}

}  // namespace patina::bench
