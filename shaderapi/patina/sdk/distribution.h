// SPDX-License-Identifier: Apache-2.0
// Densities of directions for lights from infinity: a cone, and a table over the whole sphere. What `draw`
// gives comes with the density per solid angle that `density` has for it, so that a host can weigh a light's
// samples against others that meet it by chance.
#pragma once

#include <vector>

#include "math.h"

namespace patina::sdk {

/// Directions within an angle of an axis, all alike: the disc of a sun.
class Cone {
 public:
  Cone() = default;
  /// `axis` of unit length; `angle` in radians from it to the rim, 0 to pi.
  Cone(const Vector& axis, float angle) : axis_(axis), frame_(frameAround(axis)) {
    const float halfSine = std::sin(angle / 2);
    height_ = 2 * halfSine * halfSine;
    density_ = height_ > 0 ? 1 / (2 * kPi * height_) : 0;
  }
  const Vector& axis() const { return axis_; }
  float solidAngle() const { return 2 * kPi * height_; }
  /// 1 / solidAngle(); 0 of a cone without width.
  float density() const { return density_; }
  /// Of a unit vector. Half the square of the chord is 1 - cos, and keeps its digits near the axis.
  PATINA_INLINE bool holds(const Vector& direction) const {
    const Vector off = direction - axis_;
    return dot(off, off) <= 2 * height_;
  }
  /// A unit direction by two uniform random numbers in [0, 1).
  PATINA_INLINE Vector draw(float randomX, float randomY) const {
    const float below = randomX * height_;  // 1 - cos
    const float radius = sqrt(below * (2 - below)), phi = 2 * kPi * randomY;
    return normalize(axis_ * (1 - below) + frame_.x * (radius * cos(phi)) + frame_.y * (radius * sin(phi)));
  }

 private:
  Vector axis_{0, 0, 1};
  Frame frame_{{1, 0, 0}, {0, 1, 0}};
  float height_ = 0, density_ = 0;  // 1 - cos(angle) keeps its digits where the cosine would lose them
};

/// Directions by a table of cells in latitude and longitude (PBR 4th ed., sections 12.5.2 and A.5): the
/// density is constant over s and t within a cell, with s and t as PatinaHost::environment has them.
class SphereDistribution {
 public:
  /// All directions alike.
  SphereDistribution() = default;
  /// `radiance[row * width + column]` is that of a cell; rows go from +z to -z, columns once around. What is
  /// negative or not finite counts as nothing. `added`, a share of the mean, is put into each cell, so that
  /// no light is missed which the table does not know of. A black table is one of all directions alike.
  SphereDistribution(const std::vector<float>& radiance, uint32_t width, uint32_t height, float added = 0.05f)
      : width_(width), height_(height) {
    const auto of = [&](size_t cell) {
      return std::isfinite(radiance[cell]) ? std::max(radiance[cell], 0.0f) : 0.0f;
    };
    const auto sineOf = [&](uint32_t row) { return std::sin(kPi * (float(row) + 0.5f) / float(height)); };
    double total = 0, sines = 0;
    for (uint32_t row = 0; row < height; ++row) {
      double sum = 0;
      for (uint32_t column = 0; column < width; ++column) sum += double(of(size_t(row) * width + column));
      total += sum * double(sineOf(row)), sines += double(sineOf(row)) * width;
    }
    mean_ = sines > 0 ? float(total / sines) : 0;
    if (!(mean_ > 0)) return;
    rows_.push_back(0);
    columns_.reserve((size_t(width) + 1) * height);
    double all = 0;
    for (uint32_t row = 0; row < height; ++row) {
      double sum = 0;
      columns_.push_back(0);
      for (uint32_t column = 0; column < width; ++column)
        columns_.push_back(float(sum += double(of(size_t(row) * width + column)) + double(added * mean_)));
      rows_.push_back(float(all += sum * double(sineOf(row))));
    }
  }

  /// Of the radiance over all directions.
  float mean() const { return mean_; }

  /// A unit direction by two uniform random numbers in [0, 1), and its density.
  Vector draw(float randomX, float randomY, float& pdf) const {
    if (rows_.empty()) {
      const float z = 1 - 2 * randomX, radius = std::sqrt(std::max(0.0f, 1 - z * z)), phi = 2 * kPi * randomY;
      pdf = kUniform;
      return {radius * std::cos(phi), radius * std::sin(phi), z};
    }
    float inRow = 0, inColumn = 0;
    const size_t row = pick(rows_.data(), height_, randomX, inRow);
    const size_t column = pick(columnsOf(row), width_, randomY, inColumn);
    const float theta = kPi * (float(row) + inRow) / float(height_);
    const float phi = 2 * kPi * ((float(column) + inColumn) / float(width_) - 0.5f);
    const float sine = std::sin(theta);
    pdf = cellDensity(row, column, sine);
    return {sine * std::cos(phi), sine * std::sin(phi), std::cos(theta)};
  }

  /// Of a unit direction.
  float density(const Vector& direction) const {
    if (rows_.empty()) return kUniform;
    const float around = std::hypot(direction.x, direction.y);
    const float s = 0.5f + std::atan2(direction.y, direction.x) / (2 * kPi);
    const float t = std::atan2(around, direction.z) / kPi;
    const auto cell = [](float x, uint32_t count) {
      return std::min(size_t(std::max(x, 0.0f) * float(count)), size_t(count - 1));
    };
    return cellDensity(cell(t, height_), cell(s, width_), around);
  }

 private:
  static constexpr float kUniform = 1 / (4 * kPi);

  const float* columnsOf(size_t row) const { return &columns_[row * (size_t(width_) + 1)]; }
  // Of cells by their running sums: the one that the random number falls into, and where, in [0, 1).
  static size_t pick(const float* sums, uint32_t count, float random, float& rest) {
    const float target = random * sums[count];
    const auto cell = size_t(std::upper_bound(sums + 1, sums + count, target) - sums) - 1;
    const float width = sums[cell + 1] - sums[cell];
    rest = width > 0 ? clamp((target - sums[cell]) / width, 0, 0.9999999f) : 0.5f;
    return cell;
  }
  float cellDensity(size_t row, size_t column, float sine) const {
    const float* const columns = columnsOf(row);
    const float probability = (rows_[row + 1] - rows_[row]) / rows_[height_] *
                              ((columns[column + 1] - columns[column]) / columns[width_]);
    return probability * (float(width_) * float(height_)) / (2 * kPi * kPi * std::max(sine, 1e-6f));
  }

  uint32_t width_ = 0, height_ = 0;
  float mean_ = 0;
  std::vector<float> rows_;     // running sums; none: all directions are alike
  std::vector<float> columns_;  // running sums of one row after the other, each with its leading 0
};

/// The axes of a light's own space in world space, square to each other whatever its transformation is.
struct Axes {
  Vector x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};

  Axes() = default;
  /// `m`: Prepare::shaderToWorld(). z keeps its direction, x as much as it can.
  explicit Axes(const float* m) {
    const Vector ofX(m[0], m[1], m[2]), ofY(m[4], m[5], m[6]), ofZ(m[8], m[9], m[10]);
    const float handedness = dot(cross(ofX, ofY), ofZ) < 0 ? -1.0f : 1.0f;
    z = normalize(ofZ);
    if (dot(z, z) < 0.5f) z = {0, 0, 1};
    x = normalize(ofX - z * dot(ofX, z));
    if (dot(x, x) < 0.5f) x = frameAround(z).x;
    y = cross(z, x) * handedness;
  }
  PATINA_INLINE Vector toWorld(const Vector& v) const { return x * v.x + y * v.y + z * v.z; }
  PATINA_INLINE Vector toLocal(const Vector& v) const { return {dot(v, x), dot(v, y), dot(v, z)}; }
};

}  // namespace patina::sdk
