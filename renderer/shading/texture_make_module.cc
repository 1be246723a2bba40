// SPDX-License-Identifier: Apache-2.0
// Pictures through their colour conversion, six of them to one of latitude and longitude, and
// OpenImageIO's make_texture.
#include "renderer/shading/texture_make_module.h"

#include <OpenImageIO/filter.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>

#include <fcntl.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "renderer/shading/texture_color_module.h"
#include "renderer/shading/texture_input_module.h"

namespace patina::textures {
namespace {

using OIIO::ImageBuf;
using OIIO::ImageInput;
using OIIO::ImageSpec;
using OIIO::TypeDesc;

constexpr int64_t kMostValues = int64_t{1} << 28;  // of a picture in memory: 1 GB

struct Picture {
  int width = 0, height = 0, channels = 0;
  TypeDesc type;  // that is fine enough for what was read
  ImageSpec spec;
  std::vector<float> values;
};

/// Throws std::runtime_error with the reason.
Picture readPicture(const std::string& path, std::string_view space,
                    const OCIO_NAMESPACE::ConstConfigRcPtr& config) {
  std::unique_ptr<ImageInput> input = ImageInput::open(path);
  if (!input) throw std::runtime_error(OIIO::geterror());
  if (const std::string problem = sizeProblem(path, input->spec()); !problem.empty())
    throw std::runtime_error(problem);
  if (const std::string problem = endProblem(*input); !problem.empty()) throw std::runtime_error(problem);
  const ColorConversion* conversion = nullptr;
  if (space == "srgb")
    conversion = srgb();
  else if (space.empty())
    conversion = conversionOf(path, input->spec(), config);
  if (conversion) {
    const ImageSpec how = converterConfig(*conversion);
    ImageSpec opened;
    input.reset(makeConvertingInput());
    if (!input->open(convertedName(path, *conversion), opened, how))
      throw std::runtime_error(input->geterror());
  }
  const ImageSpec& spec = input->spec();
  if (spec.deep || spec.depth > 1) throw std::runtime_error("volumes and deep images are no textures");
  const int64_t values = int64_t{spec.width} * spec.height;
  if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1 || values > kMostValues / spec.nchannels)
    throw std::runtime_error("the picture is empty or too large");
  Picture picture{spec.width, spec.height, spec.nchannels, spec.format, spec, {}};
  if (spec.format.size() == 1) picture.type = TypeDesc::HALF;
  picture.values.resize(static_cast<size_t>(values * spec.nchannels));
  if (!input->read_image(0, 0, 0, -1, TypeDesc::FLOAT, picture.values.data()))
    throw std::runtime_error(input->geterror());
  return picture;
}

/// The channels of a picture at x, y in pixels, bilinear, its edge beyond its edge.
void readAt(const Picture& picture, double x, double y, float* value) {
  const double left = std::floor(x - 0.5), top = std::floor(y - 0.5);
  const auto fx = static_cast<float>(x - 0.5 - left), fy = static_cast<float>(y - 0.5 - top);
  const auto texel = [&](double column, double row) {
    const auto c = static_cast<size_t>(std::clamp(column, 0.0, double(picture.width - 1)));
    const auto r = static_cast<size_t>(std::clamp(row, 0.0, double(picture.height - 1)));
    return &picture
                .values[(r * static_cast<size_t>(picture.width) + c) * static_cast<size_t>(picture.channels)];
  };
  const float *a = texel(left, top), *b = texel(left + 1, top), *c = texel(left, top + 1),
              *d = texel(left + 1, top + 1);
  for (int i = 0; i < picture.channels; ++i)
    value[i] += (1 - fy) * ((1 - fx) * a[i] + fx * b[i]) + fy * ((1 - fx) * c[i] + fx * d[i]);
}

using Axis = std::array<double, 3>;
double dot(const Axis& a, const Axis& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// How RI's six pictures look: along, to the right and upwards, in the order px nx py ny pz nz.
struct Face {
  Axis forward, right, up;
};
constexpr std::array<Face, 6> kFaces = {{{{1, 0, 0}, {0, 0, -1}, {0, 1, 0}},
                                         {{-1, 0, 0}, {0, 0, 1}, {0, 1, 0}},
                                         {{0, 1, 0}, {1, 0, 0}, {0, 0, -1}},
                                         {{0, -1, 0}, {1, 0, 0}, {0, 0, 1}},
                                         {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}},
                                         {{0, 0, -1}, {-1, 0, 0}, {0, 1, 0}}}};

/// Latitude and longitude as PatinaHost.environment has them: s = 0.5 + atan2(y, x) / 2 pi, t = acos(z) / pi.
Picture latLongOf(const std::vector<Picture>& faces, float fov) {
  for (const Picture& face : faces)
    if (face.channels != faces[0].channels)
      throw std::runtime_error("the six pictures have different channels");
  Picture result = faces[0];
  const int64_t side = std::max(faces[0].width, faces[0].height);
  if (8 * side * side > kMostValues / result.channels) throw std::runtime_error("the pictures are too large");
  result.width = static_cast<int>(4 * side), result.height = static_cast<int>(2 * side);
  result.values.assign(static_cast<size_t>(8 * side * side * result.channels), 0);
  result.spec = ImageSpec(result.width, result.height, result.channels, TypeDesc::FLOAT);
  const double scale = std::tan(static_cast<double>(fov) * std::numbers::pi / 360);
  constexpr int kSamples = 2;  // along each side of a pixel
  for (int y = 0; y < result.height; ++y)
    for (int x = 0; x < result.width; ++x) {
      float* const value =
          &result
               .values[(static_cast<size_t>(y) * static_cast<size_t>(result.width) + static_cast<size_t>(x)) *
                       static_cast<size_t>(result.channels)];
      for (int k = 0; k < kSamples * kSamples; ++k) {
        const double s = (x + (k % kSamples + 0.5) / kSamples) / result.width;
        const double t = (y + (k / kSamples + 0.5) / kSamples) / result.height;
        const double phi = 2 * std::numbers::pi * (s - 0.5), theta = std::numbers::pi * t;
        const Axis d{std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
        size_t best = 0;
        for (size_t f = 1; f < 6; ++f)
          if (dot(d, kFaces[f].forward) > dot(d, kFaces[best].forward)) best = f;
        const double depth = dot(d, kFaces[best].forward) * scale;
        readAt(faces[best], (0.5 + 0.5 * dot(d, kFaces[best].right) / depth) * faces[best].width,
               (0.5 - 0.5 * dot(d, kFaces[best].up) / depth) * faces[best].height, value);
      }
      for (int c = 0; c < result.channels; ++c) value[c] /= kSamples * kSamples;
    }
  return result;
}

/// Why there is no room for a file of so many bytes at `path`; "" = there is. OpenImageIO 2.4 and libtiff do
/// not come to an end on a full disk: directories that could not be written lead in circles. So it is found
/// out before, for the file without compression.
std::string roomProblem(const char* path, size_t bytes) {
  const int file = open(path, O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
  if (file < 0) return std::generic_category().message(errno);
  int error = fallocate(file, 0, 0, static_cast<off_t>(bytes)) == 0 ? 0 : errno;
  if (error == EOPNOTSUPP || error == ENOSYS) {
    struct statvfs system {};
    error = fstatvfs(file, &system) != 0 || system.f_bavail > bytes / std::max<size_t>(system.f_frsize, 1)
                ? 0
                : ENOSPC;
  }
  close(file);
  unlink(path);
  if (error == 0) return {};
  return std::generic_category().message(error) + " for up to " + std::to_string((bytes >> 20) + 1) + " MB";
}

std::string made(const PatinaTextureToMake& what) {
  OCIO_NAMESPACE::ConstConfigRcPtr config;
  if (*what.ocio_config) config = OCIO_NAMESPACE::Config::CreateFromFile(what.ocio_config);
  std::vector<Picture> pictures;
  for (uint32_t i = 0; i < what.picture_count; ++i) {
    try {
      pictures.push_back(readPicture(what.pictures[i], what.color_space, config));
    } catch (const std::exception& e) {
      return std::string(what.pictures[i]) + ": " + e.what();
    }
  }
  Picture picture =
      what.kind == PATINA_MAKE_CUBE_FACES ? latLongOf(pictures, what.fov) : std::move(pictures.front());
  pictures.clear();

  ImageSpec spec(picture.width, picture.height, picture.channels, TypeDesc::FLOAT);
  spec.channelnames = picture.spec.channelnames;
  spec.alpha_channel = picture.spec.alpha_channel, spec.z_channel = picture.spec.z_channel;
  for (const char* matrix : {"worldtocamera", "worldtoscreen"})  // of MakeShadow
    if (const OIIO::ParamValue* value = picture.spec.find_attribute(matrix))
      spec.attribute(matrix, value->type(), value->data());
  spec.attribute("oiio:ColorSpace", "Linear");
  const ImageBuf pixels(spec, picture.values.data());

  // All levels together have a third more than the first; tiles at edges are whole ones.
  constexpr size_t kHead = size_t{1} << 18;
  const size_t bytes = picture.values.size() * picture.type.size() * 3 / 2 + kHead;
  if (const std::string problem = roomProblem(what.output, bytes); !problem.empty()) return problem;

  ImageSpec how;
  how.set_format(picture.type);
  how.tile_width = how.tile_height = 64, how.tile_depth = 1;
  how.attribute("compression", "zip");
  how.attribute("tiff:half", 1);
  how.attribute("oiio:ColorSpace", "Linear");
  how.attribute("wrapmodes", what.wrap_modes);
  how.attribute("maketx:fileformatname", what.format);
  how.attribute("maketx:filtername", what.filter);
  const auto mode = what.kind == PATINA_MAKE_SHADOW    ? OIIO::ImageBufAlgo::MakeTxShadow
                    : what.kind == PATINA_MAKE_TEXTURE ? OIIO::ImageBufAlgo::MakeTxTexture
                                                       : OIIO::ImageBufAlgo::MakeTxEnvLatl;
  if (OIIO::ImageBufAlgo::make_texture(mode, pixels, what.output, how)) return {};
  const std::string reason = OIIO::geterror();
  return reason.empty() ? "OpenImageIO gives no reason" : reason;
}

}  // namespace

int isPicture(const char* path) {
  const auto input = ImageInput::open(path);
  if (!input) OIIO::geterror();
  return input != nullptr;
}

int make(const PatinaTextureToMake* what, char* error, size_t errorSize) {
  std::string reason;
  try {
    reason = made(*what);
  } catch (const std::exception& e) {
    reason = e.what();
  }
  if (errorSize) std::snprintf(error, errorSize, "%s", reason.c_str());
  return reason.empty();
}

}  // namespace patina::textures
