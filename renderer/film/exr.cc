// SPDX-License-Identifier: Apache-2.0
// EXR files: channels to and from interleaved floats.
#include "renderer/film/exr.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfCompression.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "renderer/film/atomic_file.h"

namespace patina {

namespace {

constexpr float kLargestHalf = 65504;

// Collects a file in memory: OpenEXR's own file streams lose the error of a last, buffered write.
class MemoryStream : public Imf::OStream {
 public:
  MemoryStream() : OStream("picture") {}
  void write(const char bytes[], int count) override {
    const auto n = static_cast<std::size_t>(count);
    if (bytes_.size() < position_ + n) bytes_.resize(position_ + n);
    std::memcpy(bytes_.data() + position_, bytes, n);
    position_ += n;
  }
  std::uint64_t tellp() override { return position_; }
  void seekp(std::uint64_t position) override { position_ = position; }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  std::size_t position_ = 0;
};

Imf::Compression compressionFor(const std::string& name) {
  static constexpr std::pair<std::string_view, Imf::Compression> kNames[] = {
      {"none", Imf::NO_COMPRESSION},  {"rle", Imf::RLE_COMPRESSION},   {"zips", Imf::ZIPS_COMPRESSION},
      {"zip", Imf::ZIP_COMPRESSION},  {"piz", Imf::PIZ_COMPRESSION},   {"pxr24", Imf::PXR24_COMPRESSION},
      {"b44", Imf::B44_COMPRESSION},  {"b44a", Imf::B44A_COMPRESSION}, {"dwaa", Imf::DWAA_COMPRESSION},
      {"dwab", Imf::DWAB_COMPRESSION}};
  for (const auto& [text, value] : kNames)
    if (text == name) return value;
  throw std::invalid_argument("unknown EXR compression \"" + name +
                              "\"; known are none rle zips zip piz pxr24 " + "b44 b44a dwaa dwab");
}

Imath::M44f matrix(const std::array<float, 16>& m) {
  Imath::M44f result;
  for (int i = 0; i < 16; ++i) result[i / 4][i % 4] = m[static_cast<std::size_t>(i)];
  return result;
}

// R G B A first, whatever their alphabet, then the others as they come.
int rank(const std::string& name) {
  static constexpr std::string_view kOrder = "RGBA";
  const auto at = name.size() == 1 ? kOrder.find(name[0]) : std::string_view::npos;
  return at == std::string_view::npos ? 4 : static_cast<int>(at);
}

std::string encode(const ImageData& image, const ExrSettings& s) {
  const Imath::Box2i data({s.x, s.y}, {s.x + image.width - 1, s.y + image.height - 1});
  const Imath::Box2i display({0, 0}, {s.fullWidth - 1, s.fullHeight - 1});
  Imf::Header header(display, data, 1, {0, 0}, 1, Imf::INCREASING_Y, compressionFor(s.compression));
  for (const auto& [name, value] : s.attributes) header.insert(name, Imf::StringAttribute(value));
  if (s.worldToCamera) header.insert("worldToCamera", Imf::M44fAttribute(matrix(*s.worldToCamera)));
  if (s.worldToScreen) header.insert("worldToScreen", Imf::M44fAttribute(matrix(*s.worldToScreen)));

  const auto channels = static_cast<std::size_t>(image.channels);
  const auto width = static_cast<std::size_t>(image.width), height = static_cast<std::size_t>(image.height);
  const std::size_t xStride = channels * sizeof(float), yStride = width * xStride;
  std::vector<std::vector<half>> halves;
  halves.reserve(channels);
  Imf::FrameBuffer buffer;
  for (std::size_t c = 0; c < channels; ++c) {
    const std::string& name = image.channelNames[c];
    if (s.half && name != "Z") {
      auto& plane = halves.emplace_back(width * height);
      for (std::size_t i = 0; i < plane.size(); ++i)
        plane[i] = std::clamp(image.pixels[i * channels + c], -kLargestHalf, kLargestHalf);
      header.channels().insert(name, Imf::Channel(Imf::HALF));
      buffer.insert(name,
                    Imf::Slice::Make(Imf::HALF, plane.data(), data, sizeof(half), width * sizeof(half)));
    } else {
      header.channels().insert(name, Imf::Channel(Imf::FLOAT));
      buffer.insert(name, Imf::Slice::Make(Imf::FLOAT, image.pixels.data() + c, data, xStride, yStride));
    }
  }
  MemoryStream stream;
  {
    Imf::OutputFile file(stream, header);
    file.setFrameBuffer(buffer);
    file.writePixels(image.height);
  }
  return stream.bytes();
}

ImageData decode(const std::string& path) {
  Imf::InputFile file(path.c_str());
  const Imath::Box2i data = file.header().dataWindow();
  const std::int64_t width = std::int64_t{data.max.x} - data.min.x + 1;
  const std::int64_t height = std::int64_t{data.max.y} - data.min.y + 1;
  ImageData image;
  for (auto c = file.header().channels().begin(); c != file.header().channels().end(); ++c) {
    if (c.channel().xSampling != 1 || c.channel().ySampling != 1)
      throw std::runtime_error("channel " + std::string(c.name()) + " is subsampled, which is not supported");
    image.channelNames.emplace_back(c.name());
  }
  const auto channels = image.channelNames.size();
  constexpr auto kLargest = static_cast<std::int64_t>(kLargestImage);
  if (channels == 0 || width < 1 || height < 1 || width > kLargest / height ||
      width * height > kLargest / static_cast<std::int64_t>(channels))
    throw std::runtime_error("the image is empty or too large");
  std::stable_sort(image.channelNames.begin(), image.channelNames.end(),
                   [](const std::string& a, const std::string& b) { return rank(a) < rank(b); });

  image.width = static_cast<int>(width);
  image.height = static_cast<int>(height);
  image.channels = static_cast<int>(channels);
  image.pixels.resize(static_cast<std::size_t>(width * height) * channels);
  const std::size_t xStride = channels * sizeof(float), yStride = static_cast<std::size_t>(width) * xStride;
  Imf::FrameBuffer buffer;
  for (std::size_t c = 0; c < channels; ++c)
    buffer.insert(image.channelNames[c],
                  Imf::Slice::Make(Imf::FLOAT, image.pixels.data() + c, data, xStride, yStride));
  file.setFrameBuffer(buffer);
  file.readPixels(data.min.y, data.max.y);
  return image;
}

}  // namespace

std::string writeExr(const std::string& path, const ImageData& image, const ExrSettings& settings) {
  try {
    AtomicFile file(path);
    std::string problem = file.write(encode(image, settings));
    return problem.empty() ? file.commit() : problem;
  } catch (const std::exception& e) {
    return "cannot write " + path + ": " + e.what();
  }
}

std::optional<ImageData> readExr(const std::string& path, std::string& error) {
  try {
    return decode(path);
  } catch (const std::exception& e) {
    error = "cannot read " + path + ": " + e.what();
    return std::nullopt;
  }
}

}  // namespace patina
