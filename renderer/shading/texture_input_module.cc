// SPDX-License-Identifier: Apache-2.0
// Passes requests on to the file's own reader, and what that gives through a colour conversion.
#include "renderer/shading/texture_input_module.h"

#include <cstring>
#include <filesystem>
#include <memory>
#include <string_view>
#include <vector>

namespace patina::textures {
namespace {

using OIIO::ImageInput;
using OIIO::ImageSpec;
using OIIO::TypeDesc;

constexpr const char* kConversion = "patina:conversion";

class ConvertingInput final : public ImageInput {
 public:
  const char* format_name() const override { return "converted"; }
  int supports(OIIO::string_view) const override { return 0; }
  bool open(const std::string&, ImageSpec&) override { return false; }

  bool open(const std::string& name, ImageSpec& newspec, const ImageSpec& config) override {
    void* conversion = nullptr;
    if (!config.getattribute(kConversion, TypeDesc::PTR, &conversion) || !conversion) return false;
    conversion_ = static_cast<const ColorConversion*>(conversion);
    ImageSpec unassociated;
    unassociated.attribute("oiio:UnassociatedAlpha", 1);
    file_ = ImageInput::open(name.substr(0, name.rfind('\n')), &unassociated);
    if (!file_) {
      errorf("%s", OIIO::geterror());
      return false;
    }
    takeSpec();
    newspec = m_spec;
    return true;
  }

  bool close() override { return !file_ || std::exchange(file_, nullptr)->close(); }
  int current_subimage() const override { return file_ ? file_->current_subimage() : 0; }
  int current_miplevel() const override { return file_ ? file_->current_miplevel() : 0; }

  bool seek_subimage(int subimage, int miplevel) override {
    if (!file_ || !file_->seek_subimage(subimage, miplevel)) return false;
    takeSpec();
    return true;
  }
  ImageSpec spec(int subimage, int miplevel) override {
    return file_ ? converted(file_->spec(subimage, miplevel)) : ImageSpec();
  }
  ImageSpec spec_dimensions(int subimage, int miplevel) override { return spec(subimage, miplevel); }

  bool read_native_scanline(int subimage, int miplevel, int y, int z, void* data) override {
    return read_native_scanlines(subimage, miplevel, y, y + 1, z, data);
  }

  bool read_native_scanlines(int subimage, int miplevel, int yBegin, int yEnd, int z, void* data) override {
    const ImageSpec in = file_->spec_dimensions(subimage, miplevel);
    const auto pixels = static_cast<size_t>(in.width) * static_cast<size_t>(yEnd - yBegin);
    std::vector<float> values(pixels * static_cast<size_t>(in.nchannels));
    if (!file_->read_scanlines(subimage, miplevel, yBegin, yEnd, z, 0, in.nchannels, TypeDesc::FLOAT,
                               values.data()))
      return refuse();
    return give(subimage, miplevel, values, pixels, data);
  }

  bool read_native_tile(int subimage, int miplevel, int x, int y, int z, void* data) override {
    const ImageSpec in = file_->spec_dimensions(subimage, miplevel);
    const auto pixels = static_cast<size_t>(in.tile_pixels());
    std::vector<float> values(pixels * static_cast<size_t>(in.nchannels));
    // The reader gives no tile's part beyond the picture: rows of the part are spread over the tile's.
    const int width = std::min(in.tile_width, in.x + in.width - x);
    const int height = std::min(in.tile_height, in.y + in.height - y);
    const auto pixelBytes = static_cast<OIIO::stride_t>(sizeof(float)) * in.nchannels;
    if (!file_->read_tiles(subimage, miplevel, x, x + width, y, y + height, z, z + 1, 0, in.nchannels,
                           TypeDesc::FLOAT, values.data(), pixelBytes, pixelBytes * in.tile_width))
      return refuse();
    return give(subimage, miplevel, values, pixels, data);
  }

 private:
  bool refuse() {
    errorf("%s", file_->geterror());
    return false;
  }

  // Eight bits become halves, whose steps are finer than the curve's; all else floats.
  static ImageSpec converted(ImageSpec spec) {
    spec.set_format(spec.format.size() == 1 || spec.format == TypeDesc::HALF ? TypeDesc::HALF
                                                                             : TypeDesc::FLOAT);
    spec.channelformats.clear();
    spec.erase_attribute("oiio:UnassociatedAlpha");
    spec.erase_attribute("oiio:SHA-1");  // the same file unconverted is another texture
    spec.erase_attribute("ImageDescription");
    spec.attribute("oiio:ColorSpace", "Linear");
    return spec;
  }
  void takeSpec() {
    isUnassociated_ = file_->spec().get_int_attribute("oiio:UnassociatedAlpha") != 0;
    m_spec = converted(file_->spec());
  }

  bool give(int subimage, int miplevel, std::vector<float>& values, size_t pixels, void* data) {
    const ImageSpec in = file_->spec_dimensions(subimage, miplevel);
    const auto channels = static_cast<size_t>(in.nchannels);
    const size_t colors = channels < 3 ? 1 : 3;
    const bool hasAlpha = in.alpha_channel >= 0 && static_cast<size_t>(in.alpha_channel) >= colors;
    std::vector<float> rgb(3 * pixels);
    for (size_t i = 0; i < pixels; ++i) {
      const float* v = &values[i * channels];
      const float alpha = hasAlpha ? v[in.alpha_channel] : 1;
      const float scale = isUnassociated_ || alpha == 0 ? 1 : 1 / alpha;
      for (size_t c = 0; c < 3; ++c) rgb[3 * i + c] = v[colors == 1 ? 0 : c] * scale;
    }
    conversion_->apply(rgb.data(), pixels);
    for (size_t i = 0; i < pixels; ++i) {
      float* v = &values[i * channels];
      const float alpha = hasAlpha ? v[in.alpha_channel] : 1;
      const float scale = isUnassociated_ || alpha != 0 ? alpha : 1;
      for (size_t c = 0; c < colors; ++c) v[c] = rgb[3 * i + c] * scale;
    }
    const TypeDesc type = converted(in).format;
    return OIIO::convert_types(TypeDesc::FLOAT, values.data(), type, data, static_cast<int>(values.size()));
  }

  const ColorConversion* conversion_ = nullptr;
  std::unique_ptr<ImageInput> file_;
  bool isUnassociated_ = false;
};

}  // namespace

std::string convertedName(const std::string& path, const ColorConversion& conversion) {
  return path + '\n' + conversion.name;
}

ImageInput* makeConvertingInput() { return new ConvertingInput; }

ImageSpec converterConfig(const ColorConversion& conversion) {
  ImageSpec config;
  const void* pointer = &conversion;
  config.attribute(kConversion, TypeDesc::PTR, &pointer);
  return config;
}

std::string sizeProblem(const std::string& path, const ImageSpec& spec) {
  constexpr double kMostSide = 1 << 20, kMostTiled = 0x1p36, kMostUntiled = 0x1p30;  // values
  // DEFLATE makes at most 1032 bytes of one; a picture of one colour may do better for a while.
  constexpr double kMostRatio = 2000, kFreely = 1 << 26;  // bytes
  const double values = static_cast<double>(spec.width) * spec.height * spec.depth * spec.nchannels;
  if (spec.width < 1 || spec.height < 1 || spec.depth < 1 || spec.nchannels < 1) return "it has no pixels";
  if (spec.width > kMostSide || spec.height > kMostSide ||
      values > (spec.tile_width > 0 ? kMostTiled : kMostUntiled))
    return "it says that it has " + std::to_string(spec.width) + " x " + std::to_string(spec.height) +
           " pixels of " + std::to_string(spec.nchannels) + " values, which is too large" +
           (spec.tile_width > 0 ? "" : " for a picture without tiles (MakeTexture makes them)");
  std::error_code failed;
  const auto bytes = static_cast<double>(std::filesystem::file_size(path, failed));
  const double wanted = values * static_cast<double>(spec.channel_bytes());
  if (!failed && wanted > kFreely && wanted > bytes * kMostRatio)
    return "it says that it has " + std::to_string(spec.width) + " x " + std::to_string(spec.height) +
           " pixels, which its " + std::to_string(static_cast<uint64_t>(bytes)) + " bytes cannot hold";
  return {};
}

std::string endProblem(ImageInput& file) {
  constexpr double kMostValues = 1 << 26;  // of a tile
  if (std::string_view(file.format_name()) != "tiff") return {};
  const ImageSpec spec = file.spec();
  std::vector<float> values;
  bool isRead = true;
  if (spec.tile_width > 0) {
    if (static_cast<double>(spec.tile_width) * spec.tile_height * spec.tile_depth * spec.nchannels >
        kMostValues)
      return "its tiles are too large";
    values.resize(static_cast<size_t>(spec.tile_pixels()) * static_cast<size_t>(spec.nchannels));
    const int x = spec.x + (spec.width - 1) / spec.tile_width * spec.tile_width,
              y = spec.y + (spec.height - 1) / spec.tile_height * spec.tile_height;
    isRead = file.read_tile(x, y, spec.z, TypeDesc::FLOAT, values.data());
  } else {
    values.resize(static_cast<size_t>(spec.width) * static_cast<size_t>(spec.nchannels));
    isRead = file.read_scanlines(0, 0, spec.y + spec.height - 1, spec.y + spec.height, spec.z, 0,
                                 spec.nchannels, TypeDesc::FLOAT, values.data());
  }
  const std::string reason = file.geterror();  // warnings, too
  return isRead ? "" : "it ends before its pixels do: " + reason;
}

}  // namespace patina::textures
