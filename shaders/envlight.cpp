// SPDX-License-Identifier: Apache-2.0
// envlight: light from every direction, of one colour or of a latitude-longitude picture.
#include <patina/sdk.h>
#include <patina/sdk/distribution.h>

#include <vector>

using namespace patina::sdk;

namespace {

struct EnvLight {
  struct Parameters {
    float intensity = 1;
    Color lightcolor = 1;
    const char* texturename = "";
    int32_t camera = 1;
  };
  static constexpr auto kInfo = describe(
      "envlight", "Light from every direction: radiance intensity * lightcolor (* texture)",
      uniform("intensity", &Parameters::intensity, "scale of lightcolor", kPositive),
      uniform("lightcolor", &Parameters::lightcolor, "colour of the light", kPositive, "W/(m^2 sr)"),
      uniform(
          "texturename", &Parameters::texturename,
          "latitude-longitude picture that lightcolor is multiplied by, +z of shader space up; \"\" = none"),
      uniform("camera", &Parameters::camera, "1 = the camera sees the light as a background", {0, 1}));
  static constexpr PatinaLightKind kLight = PATINA_LIGHT_INFINITE;
  static constexpr uint64_t kTraits = 0;

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    if (p.camera) context.set(PATINA_TRAIT_CAMERA_VISIBLE);
    scale_ = p.intensity * p.lightcolor;
    context.lightPower(scale_ * kPi);
    if (isBlack(scale_)) return PATINA_OK;
    host_ = &context.host;
    axes_ = Axes(context.shaderToWorld());
    picture_ = context.openTexture(p.texturename);
    if (!picture_) {
      context.set(PATINA_TRAIT_SMOOTH);
      return PATINA_OK;
    }
    const PatinaStatus status = buildTable();
    context.lightPower(kPi * directions_.mean());
    return status;
  }

  PatinaStatus lightBatch(const PatinaLightIn& in, PatinaLightOut& out) const {
    PatinaStatus status = PATINA_OK;
    for (uint32_t first = 0; first < in.count; first += PATINA_LANES) {
      const uint32_t count = std::min(PATINA_LANES, in.count - first);
      const PatinaStatus result = in.task == PATINA_LIGHT_SAMPLE     ? sample(in, first, count, out)
                                  : in.task == PATINA_LIGHT_EVALUATE ? evaluate(in, first, count, out)
                                                                     : PATINA_OK;
      if (result != PATINA_OK) status = result;
    }
    return status;
  }

 private:
  static constexpr uint32_t kLeastHeight = 256, kMostHeight = 1024;  // of the table; it is twice as wide

  static float at(const PatinaPlane& plane, uint32_t i) { return plane.data[size_t(i) * plane.stride]; }

  // Draws directions by how bright the picture is, in cells half as wide as its pixels as long as the table
  // stays small.
  PatinaStatus buildTable() {
    uint32_t pictureWidth = 0, pictureHeight = 0, channels = 0;
    PatinaStatus status =
        host_->texture_size(host_->host, picture_, &pictureWidth, &pictureHeight, &channels);
    if (status != PATINA_OK) return status;
    const uint32_t pixels = std::max(pictureWidth / 2, pictureHeight);
    const uint32_t height = std::clamp(2 * std::min(pixels, kMostHeight), kLeastHeight, kMostHeight);
    const uint32_t width = 2 * height;
    std::vector<float> brightness(size_t(width) * height);
    std::vector<float> x(width), y(width), z(width), red(width), green(width), blue(width);
    for (uint32_t row = 0; row < height; ++row) {
      const float theta = kPi * (float(row) + 0.5f) / float(height), sine = std::sin(theta);
      for (uint32_t i = 0; i < width; ++i) {
        const float phi = 2 * kPi * ((float(i) + 0.5f) / float(width) - 0.5f);
        x[i] = sine * std::cos(phi), y[i] = sine * std::sin(phi), z[i] = std::cos(theta);
      }
      // About the poles a circle of that size would hold the whole row.
      const float region = kPi / float(height) * std::max(sine, 0.25f);
      status = host_->environment(host_->host, picture_, width,
                                  {{x.data(), 1, 0}, {y.data(), 1, 0}, {z.data(), 1, 0}}, {&region, 0, 0},
                                  {red.data(), green.data(), blue.data()});
      if (status != PATINA_OK) return status;
      for (uint32_t i = 0; i < width; ++i)
        brightness[size_t(row) * width + i] = luminance(scale_ * Color(red[i], green[i], blue[i]));
    }
    if (height < 2 * pixels)
      spread(brightness, width, height, std::min(float(height) / float(pixels), 1.0f) / 8);
    directions_ = SphereDistribution(brightness, width, height);
    return PATINA_OK;
  }

  // Look-ups are interpolated between pixels, which brings `share` of a cell's light to each cell beside it:
  // an eighth where cells are pixels.
  static void spread(std::vector<float>& brightness, size_t width, size_t height, float share) {
    const auto along = [&](size_t start, size_t step, size_t count, bool around, std::vector<float>& line) {
      line.resize(count);
      for (size_t i = 0; i < count; ++i) line[i] = brightness[start + i * step];
      for (size_t i = 0; i < count; ++i) {
        const float before = i > 0 ? line[i - 1] : line[around ? count - 1 : 0];
        const float after = i + 1 < count ? line[i + 1] : line[around ? 0 : count - 1];
        brightness[start + i * step] = line[i] + share * (before + after - 2 * line[i]);
      }
    };
    std::vector<float> line;
    for (size_t row = 0; row < height; ++row) along(row * width, 1, width, true, line);
    for (size_t column = 0; column < width; ++column) along(column, width, height, false, line);
  }

  // Radiance from `count` directions in the picture's axes.
  PatinaStatus look(const Vector* local, uint32_t count, uint32_t first, PatinaLightOut& out) const {
    float x[PATINA_LANES], y[PATINA_LANES], z[PATINA_LANES];
    float red[PATINA_LANES], green[PATINA_LANES], blue[PATINA_LANES];
    PatinaStatus status = PATINA_OK;
    for (uint32_t i = 0; i < count; ++i) x[i] = local[i].x, y[i] = local[i].y, z[i] = local[i].z;
    std::fill(red, red + count, 1.0f), std::fill(green, green + count, 1.0f),
        std::fill(blue, blue + count, 1.0f);
    const float width = 0;
    if (picture_)
      status = host_->environment(host_->host, picture_, count, {{x, 1, 0}, {y, 1, 0}, {z, 1, 0}},
                                  {&width, 0, 0}, {red, green, blue});
    for (uint32_t i = 0; i < count; ++i) {
      out.radiance.x[first + i] = scale_.r * red[i];
      out.radiance.y[first + i] = scale_.g * green[i];
      out.radiance.z[first + i] = scale_.b * blue[i];
    }
    return status;
  }

  PatinaStatus sample(const PatinaLightIn& in, uint32_t first, uint32_t count, PatinaLightOut& out) const {
    Vector local[PATINA_LANES];
    for (uint32_t i = 0; i < count; ++i) {
      const uint32_t lane = first + i;
      local[i] = directions_.draw(at(in.random_x, lane), at(in.random_y, lane), out.pdf[lane]);
      const Vector world = axes_.toWorld(local[i]);
      out.direction.x[lane] = world.x, out.direction.y[lane] = world.y, out.direction.z[lane] = world.z;
      out.distance[lane] = PATINA_INFINITE_DISTANCE;
    }
    return look(local, count, first, out);
  }

  PatinaStatus evaluate(const PatinaLightIn& in, uint32_t first, uint32_t count, PatinaLightOut& out) const {
    Vector local[PATINA_LANES];
    for (uint32_t i = 0; i < count; ++i) {
      const uint32_t lane = first + i;
      local[i] =
          axes_.toLocal({at(in.direction.x, lane), at(in.direction.y, lane), at(in.direction.z, lane)});
      out.pdf[lane] = directions_.density(local[i]);
    }
    return look(local, count, first, out);
  }

  const PatinaHost* host_ = nullptr;
  PatinaTexture* picture_ = nullptr;
  Color scale_;
  Axes axes_;
  SphereDistribution directions_;
};

}  // namespace

PATINA_SHADERS(EnvLight)
