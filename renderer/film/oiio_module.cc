// SPDX-License-Identifier: Apache-2.0
// The image module: OpenImageIO and OpenColorIO behind the C interface of image_module.h.
#include <OpenColorIO/OpenColorIO.h>
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <exception>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/film/image_module.h"

namespace OCIO = OCIO_NAMESPACE;

namespace {

void say(const std::string& text, char* error, std::size_t size) {
  if (size > 0) std::snprintf(error, size, "%s", text.c_str());
}

// Runs `body`, which returns a reason or an empty text; no exception passes.
template <class Body>
int guarded(char* error, std::size_t size, Body body) {
  std::string problem;
  try {
    problem = body();
    if (problem.empty()) return 1;
  } catch (const std::exception& e) {
    problem = e.what();
  } catch (...) {
    problem = "unknown failure of an image library";
  }
  say(problem, error, size);
  return 0;
}

OIIO::TypeDesc typeOf(int pixelType) {
  switch (pixelType) {
    case PATINA_PIXEL_U8:
      return OIIO::TypeDesc::UINT8;
    case PATINA_PIXEL_U16:
      return OIIO::TypeDesc::UINT16;
    default:
      return OIIO::TypeDesc::FLOAT;
  }
}

OIIO::ImageSpec specOf(const PatinaImageToWrite& image) {
  OIIO::ImageSpec spec(image.width, image.height, image.channels, typeOf(image.pixelType));
  spec.x = image.x;
  spec.y = image.y;
  spec.full_width = image.fullWidth;
  spec.full_height = image.fullHeight;
  spec.channelnames.assign(image.channelNames, image.channelNames + image.channels);
  spec.alpha_channel = image.alphaChannel;
  spec.z_channel = image.depthChannel;
  if (image.unassociatedAlpha) spec.attribute("oiio:UnassociatedAlpha", 1);
  spec.attribute("oiio:ColorSpace", image.srgb ? "sRGB" : "Linear");
  for (int i = 0; i < image.attributeCount; ++i)
    spec.attribute(image.attributeNames[i], image.attributeValues[i]);
  if (image.worldToCamera) spec.attribute("worldtocamera", OIIO::TypeMatrix, image.worldToCamera);
  if (image.worldToScreen) spec.attribute("worldtoscreen", OIIO::TypeMatrix, image.worldToScreen);
  return spec;
}

// A file in memory. Unlike OpenImageIO's own it can be read back, which libtiff does while it writes.
class MemoryFile : public OIIO::Filesystem::IOProxy {
 public:
  MemoryFile() : IOProxy("", Write) {}
  const char* proxytype() const override { return "memory"; }
  std::size_t size() const override { return bytes_.size(); }
  std::size_t pwrite(const void* from, std::size_t n, std::int64_t offset) override {
    const auto at = static_cast<std::size_t>(offset);
    if (bytes_.size() < at + n) bytes_.resize(at + n);
    std::memcpy(bytes_.data() + at, from, n);
    return n;
  }
  std::size_t pread(void* to, std::size_t n, std::int64_t offset) override {
    const auto at = static_cast<std::size_t>(offset);
    if (at >= bytes_.size()) return 0;
    n = std::min(n, bytes_.size() - at);
    std::memcpy(to, bytes_.data() + at, n);
    return n;
  }
  std::size_t write(const void* from, std::size_t n) override { return advance(pwrite(from, n, m_pos)); }
  std::size_t read(void* to, std::size_t n) override { return advance(pread(to, n, m_pos)); }
  const std::vector<char>& bytes() const { return bytes_; }

 private:
  std::size_t advance(std::size_t n) {
    m_pos += static_cast<std::int64_t>(n);
    return n;
  }
  std::vector<char> bytes_;
};

int encode(const char* format, const PatinaImageToWrite* image, PatinaByteSink sink, void* context,
           char* error, size_t size) {
  return guarded(error, size, [&]() -> std::string {
    MemoryFile file;
    const auto output = OIIO::ImageOutput::create(format);
    if (!output) return OIIO::geterror();
    OIIO::ImageSpec spec = specOf(*image);
    // Without one its writer puts the time of writing, and no two files are the same.
    if (output->format_name() == std::string_view("tiff")) spec.attribute("DateTime", "1970:01:01 00:00:00");
    if (!output->set_ioproxy(&file) || !output->open(std::string("picture.") + format, spec) ||
        !output->write_image(typeOf(image->pixelType), image->pixels) || !output->close())
      return output->geterror();
    sink(context, file.bytes().data(), file.bytes().size());
    return {};
  });
}

void* openFile(const char* path, PatinaImageInfo* info, char* error, size_t size) {
  std::unique_ptr<OIIO::ImageInput> input;
  guarded(error, size, [&]() -> std::string {
    input = OIIO::ImageInput::open(path);
    if (!input) return OIIO::geterror();
    const OIIO::ImageSpec& spec = input->spec();
    info->width = spec.width;
    info->height = spec.height;
    info->channels = spec.nchannels;
    info->srgb = spec.get_string_attribute("oiio:ColorSpace") == "sRGB";
    if (spec.depth > 1 || spec.deep) {
      input.reset();
      return "volumes and deep images are not supported";
    }
    return {};
  });
  return input.release();
}

int readFile(void* handle, float* pixels, char* error, size_t size) {
  auto* input = static_cast<OIIO::ImageInput*>(handle);
  return guarded(error, size, [&]() -> std::string {
    return input->read_image(0, 0, 0, -1, OIIO::TypeDesc::FLOAT, pixels) ? std::string() : input->geterror();
  });
}

void closeFile(void* handle) {
  std::array<char, 1> ignored{};
  guarded(ignored.data(), ignored.size(), [&]() -> std::string {
    delete static_cast<OIIO::ImageInput*>(handle);
    return {};
  });
}

// A view is a chain of OpenColorIO's built-in transforms that begins at CIE XYZ (D65) or, with `aces`, at
// ACES2065-1.
struct View {
  std::string_view name;
  bool aces;
  std::array<const char*, 2> styles;
};
constexpr std::array<View, 6> kViews = {{
    {"sRGB", false, {"DISPLAY - CIE-XYZ-D65_to_sRGB", nullptr}},
    {"Rec.709", false, {"DISPLAY - CIE-XYZ-D65_to_REC.1886-REC.709", nullptr}},
    {"P3-D65", false, {"DISPLAY - CIE-XYZ-D65_to_G2.6-P3-D65", nullptr}},
    {"ACES sRGB",
     true,
     {"ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - SDR-VIDEO_1.0", "DISPLAY - CIE-XYZ-D65_to_sRGB"}},
    {"ACES Rec.709",
     true,
     {"ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - SDR-VIDEO_1.0",
      "DISPLAY - CIE-XYZ-D65_to_REC.1886-REC.709"}},
    {"ACES P3-D65",
     true,
     {"ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - SDR-VIDEO-P3lim_1.1",
      "DISPLAY - CIE-XYZ-D65_to_G2.6-P3-D65"}},
}};

OCIO::ConstCPUProcessorRcPtr processorFor(const View& view) {
  const auto group = OCIO::GroupTransform::Create();
  const auto append = [&group](const char* style, OCIO::TransformDirection direction) {
    const auto step = OCIO::BuiltinTransform::Create();
    step->setStyle(style);
    step->setDirection(direction);
    group->appendTransform(step);
  };
  append("UTILITY - ACES-AP1_to_LINEAR-REC709_BFD", OCIO::TRANSFORM_DIR_INVERSE);
  append(view.aces ? "ACEScg_to_ACES2065-1" : "UTILITY - ACES-AP1_to_CIE-XYZ-D65_BFD",
         OCIO::TRANSFORM_DIR_FORWARD);
  for (const char* style : view.styles)
    if (style) append(style, OCIO::TRANSFORM_DIR_FORWARD);
  return OCIO::Config::CreateRaw()->getProcessor(group)->getDefaultCPUProcessor();
}

int applyView(const char* name, float* rgb, size_t count, char* error, size_t size) {
  return guarded(error, size, [&]() -> std::string {
    for (const View& view : kViews) {
      if (view.name != name) continue;
      OCIO::PackedImageDesc pixels(rgb, static_cast<long>(count), 1, 3);
      processorFor(view)->apply(pixels);
      return {};
    }
    std::string known;
    for (const View& view : kViews) known += (known.empty() ? "\"" : ", \"") + std::string(view.name) + '"';
    return "unknown display view \"" + std::string(name) + "\"; known are " + known;
  });
}

}  // namespace

extern "C" __attribute__((visibility("default"))) const PatinaImageModule patinaImageModule1 = {
    PATINA_IMAGE_MODULE_VERSION, encode, openFile, readFile, closeFile, applyView};
