// SPDX-License-Identifier: Apache-2.0
// Contact sheets: pictures and their errors, as PNG.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "renderer/film/tone.h"
#include "tools/patina-bench/font.h"
#include "tools/patina-bench/report.h"
#include "tools/patina-bench/scenes.h"

namespace patina::bench {
namespace {

constexpr uint8_t kBackground = 48;
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

  void set(int x, int y, const std::array<float, 3>& colour) {
    const size_t at = 3 * (static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x));
    for (size_t c = 0; c < 3; ++c) bytes[at + c] = byteOf(colour[c]);
  }

  void caption(int x, int y, int cell, const std::array<std::string, 2>& lines) {
    drawText(bytes, width, x + 2, y + 3, x + cell, lines[0]);
    drawText(bytes, width, x + 2, y + 3 + kLetterHeight, x + cell, lines[1]);
  }

  // A strip of the colours of errors from -50 % to 50 %, in the place of a picture.
  void scale(int x0, int y0, int size) {
    caption(x0, y0, size, {"relative error", ""});
    const int high = std::min(12, height - y0 - kSheetCaption - 2 * kLetterHeight);
    for (int x = 0; x < size - 4; ++x)
      for (int y = 0; y < high; ++y)
        set(x0 + 2 + x, y0 + kSheetCaption + y, errorColour((x + 0.5) / (size - 4) - 0.5));
    caption(x0, y0 + kSheetCaption + high, size, {"-50%", ""});
    caption(x0 + size / 2 - kLetterWidth, y0 + kSheetCaption + high, size, {"0", ""});
    caption(x0 + size - 4 * kLetterWidth - 6, y0 + kSheetCaption + high, size, {"+50%", ""});
  }

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
        set(x0 + x, y0 + y, colour);
      }
  }
};

}  // namespace

void writeSheet(const std::filesystem::path& path, const ImageData& reference,
                const std::vector<std::vector<SheetPicture>>& rows) {
  size_t columns = 1;
  for (const std::vector<SheetPicture>& row : rows) columns = std::max(columns, row.size());
  const int w = reference.width + kSheetGap, h = reference.height + kSheetGap, high = h + kSheetCaption;
  const int width = w * static_cast<int>(columns), height = high + (high + h) * static_cast<int>(rows.size());
  const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
  if (pixels > kMostPixels) throw std::runtime_error(path.string() + ": too many pictures for a sheet");
  Canvas canvas{width, height, {}};
  canvas.bytes.assign(3 * pixels, kBackground);
  canvas.caption(0, 0, w, {"reference", ""});
  canvas.paint(0, kSheetCaption, reference, nullptr);
  if (columns > 1) canvas.scale(w, 0, reference.width);
  for (size_t row = 0; row < rows.size(); ++row)
    for (size_t k = 0; k < rows[row].size(); ++k) {
      const SheetPicture& cell = rows[row][k];
      const int x = w * static_cast<int>(k), y = high + (high + h) * static_cast<int>(row);
      canvas.caption(x, y, w, cell.caption);
      if (cell.picture.width != reference.width || cell.picture.height != reference.height) continue;
      canvas.paint(x, y + kSheetCaption, cell.picture, nullptr);
      canvas.paint(x, y + kSheetCaption + h, cell.picture, &reference);
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
