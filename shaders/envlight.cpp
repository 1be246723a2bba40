// SPDX-License-Identifier: Apache-2.0
// envlight: light from every direction, of one colour or of a latitude-longitude picture.
#include <patina/sdk.h>

#include <vector>

using namespace patina::sdk;

namespace {

// Draws cells of a table with a probability in proportion to their weight.
class Distribution {
 public:
  explicit Distribution(const std::vector<float>& weights) : cumulative_(weights.size() + 1) {
    double sum = 0;
    for (size_t i = 0; i < weights.size(); ++i) cumulative_[i + 1] = float(sum += double(weights[i]));
    sum_ = float(sum);
  }
  float sum() const { return sum_; }
  float probability(size_t cell) const { return (cumulative_[cell + 1] - cumulative_[cell]) / sum_; }
  // The cell that the random number falls into; `rest` is where in the cell, in [0, 1).
  size_t draw(float random, float& rest) const {
    const float target = random * sum_;
    const auto above = std::upper_bound(cumulative_.begin() + 1, cumulative_.end() - 1, target);
    const auto cell = size_t(above - cumulative_.begin()) - 1;
    const float width = cumulative_[cell + 1] - cumulative_[cell];
    rest = width > 0 ? clamp((target - cumulative_[cell]) / width, 0, 0.9999999f) : 0.5f;
    return cell;
  }

 private:
  std::vector<float> cumulative_;
  float sum_ = 0;
};

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
    setAxes(context.shaderToWorld());
    picture_ = context.openTexture(p.texturename);
    if (!picture_) {
      context.set(PATINA_TRAIT_SMOOTH);
      return PATINA_OK;
    }
    const PatinaStatus status = buildTable();
    const float mean = columns_.empty() ? 0 : rows_[0].sum() * kPi / (2 * kHeight * kWidth);
    context.lightPower(scale_ * (kPi * mean));
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
  static constexpr uint32_t kHeight = 256, kWidth = 2 * kHeight;  // of the table
  static constexpr float kUniformDensity = 1 / (4 * kPi);

  static float at(const PatinaPlane& plane, uint32_t i) { return plane.data[size_t(i) * plane.stride]; }

  // The picture's axes in world space, square to each other whatever the transformation is.
  void setAxes(const float* m) {
    const Vector x(m[0], m[1], m[2]), y(m[4], m[5], m[6]), z(m[8], m[9], m[10]);
    const float handedness = dot(cross(x, y), z) < 0 ? -1.0f : 1.0f;
    z_ = normalize(z);
    if (dot(z_, z_) < 0.5f) z_ = {0, 0, 1};
    x_ = normalize(x - z_ * dot(x, z_));
    if (dot(x_, x_) < 0.5f) x_ = frameAround(z_).x;
    y_ = cross(z_, x_) * handedness;
  }

  // How bright the picture is in each cell of a coarser grid, by which directions are drawn. A little is
  // added to each, so that no light between its samples is missed.
  PatinaStatus buildTable() {
    std::vector<float> brightness(kWidth * kHeight), rowSums(kHeight);
    double total = 0;
    for (uint32_t row = 0; row < kHeight; ++row) {
      const float theta = kPi * (float(row) + 0.5f) / kHeight, sine = std::sin(theta);
      std::vector<float> s(kWidth), red(kWidth), green(kWidth), blue(kWidth);
      for (uint32_t i = 0; i < kWidth; ++i) s[i] = (float(i) + 0.5f) / kWidth;
      const float t = (float(row) + 0.5f) / kHeight, width = 1.0f / kHeight;
      const PatinaStatus status =
          host_->texture(host_->host, picture_, kWidth, {s.data(), 1, 0}, {&t, 0, 0}, {&width, 0, 0},
                         {red.data(), green.data(), blue.data()}, nullptr);
      if (status != PATINA_OK) return status;
      for (uint32_t i = 0; i < kWidth; ++i) {
        const float value = luminance(scale_ * Color(red[i], green[i], blue[i]));
        brightness[row * kWidth + i] = (std::isfinite(value) ? std::max(value, 0.0f) : 0.0f) * sine;
        total += double(brightness[row * kWidth + i]);
      }
    }
    if (total == 0) return PATINA_OK;  // drawn uniformly: it is black wherever it was looked at
    for (uint32_t row = 0; row < kHeight; ++row) {
      const float sine = std::sin(kPi * (float(row) + 0.5f) / kHeight);
      const float added = 0.05f * float(total) / (kWidth * kHeight) * sine * (kPi / 2);
      std::vector<float> cells(&brightness[row * kWidth], &brightness[row * kWidth] + kWidth);
      for (float& cell : cells) cell += added;
      columns_.emplace_back(cells);
      rowSums[row] = columns_.back().sum();
    }
    rows_.emplace_back(rowSums);
    return PATINA_OK;
  }

  float density(const Vector& local) const {
    if (columns_.empty()) return kUniformDensity;
    const float around = std::hypot(local.x, local.y);
    const float s = 0.5f + std::atan2(local.y, local.x) / (2 * kPi), t = std::atan2(around, local.z) / kPi;
    const auto column = std::min(size_t(std::max(s, 0.0f) * kWidth), size_t(kWidth - 1));
    const auto row = std::min(size_t(std::max(t, 0.0f) * kHeight), size_t(kHeight - 1));
    return cellDensity(row, column, around);
  }
  float cellDensity(size_t row, size_t column, float sine) const {
    const float probability = rows_[0].probability(row) * columns_[row].probability(column);
    return probability * (kWidth * kHeight) / (2 * kPi * kPi * std::max(sine, 1e-6f));
  }

  // A direction in the picture's axes, and its density.
  Vector draw(float randomX, float randomY, float& pdf) const {
    if (columns_.empty()) {
      const float z = 1 - 2 * randomX, radius = std::sqrt(std::max(0.0f, 1 - z * z)), phi = 2 * kPi * randomY;
      pdf = kUniformDensity;
      return {radius * std::cos(phi), radius * std::sin(phi), z};
    }
    float inRow = 0, inColumn = 0;
    const size_t row = rows_[0].draw(randomX, inRow);
    const size_t column = columns_[row].draw(randomY, inColumn);
    const float theta = kPi * (float(row) + inRow) / kHeight;
    const float phi = 2 * kPi * ((float(column) + inColumn) / kWidth - 0.5f);
    const float sine = std::sin(theta);
    pdf = cellDensity(row, column, sine);
    return {sine * std::cos(phi), sine * std::sin(phi), std::cos(theta)};
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
      local[i] = draw(at(in.random_x, lane), at(in.random_y, lane), out.pdf[lane]);
      const Vector world = x_ * local[i].x + y_ * local[i].y + z_ * local[i].z;
      out.direction.x[lane] = world.x, out.direction.y[lane] = world.y, out.direction.z[lane] = world.z;
      out.distance[lane] = PATINA_INFINITE_DISTANCE;
    }
    return look(local, count, first, out);
  }

  PatinaStatus evaluate(const PatinaLightIn& in, uint32_t first, uint32_t count, PatinaLightOut& out) const {
    Vector local[PATINA_LANES];
    for (uint32_t i = 0; i < count; ++i) {
      const uint32_t lane = first + i;
      const Vector world(at(in.direction.x, lane), at(in.direction.y, lane), at(in.direction.z, lane));
      local[i] = {dot(world, x_), dot(world, y_), dot(world, z_)};
      out.pdf[lane] = density(local[i]);
    }
    return look(local, count, first, out);
  }

  const PatinaHost* host_ = nullptr;
  PatinaTexture* picture_ = nullptr;
  Color scale_;
  Vector x_{1, 0, 0}, y_{0, 1, 0}, z_{0, 0, 1};
  std::vector<Distribution> rows_;     // one, of the rows' sums; none: directions are drawn uniformly
  std::vector<Distribution> columns_;  // one per row
};

}  // namespace

PATINA_SHADERS(EnvLight)
