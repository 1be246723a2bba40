// SPDX-License-Identifier: Apache-2.0
// RI's transformations as matrices.
#include "renderer/scene/matrices.h"

namespace patina {
namespace {

using V4 = Imath::Vec4<double>;

constexpr double kRadians = std::numbers::pi / 180;

bool isFiniteMatrix(const M44d& matrix) {
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      if (!std::isfinite(matrix[row][column])) return false;
    }
  }
  return true;
}

}  // namespace

M44d toMatrix(const RibMatrix& values) {
  M44d matrix;
  for (size_t i = 0; i < 16; ++i) matrix[static_cast<int>(i / 4)][static_cast<int>(i % 4)] = values[i];
  return matrix;
}

M44d translation(double x, double y, double z) { return {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1}; }

M44d scaling(double x, double y, double z) { return {x, 0, 0, 0, 0, y, 0, 0, 0, 0, z, 0, 0, 0, 0, 1}; }

M44d rotation(double degrees, const V3d& axis) {
  const V3d a = axis.normalized();
  // Whole quarter turns are exact, so that axis-aligned scenes stay so.
  const double turn = std::remainder(degrees, 360.0);
  double s = std::sin(turn * kRadians);
  double c = std::cos(turn * kRadians);
  if (turn == 0) s = 0, c = 1;
  if (std::abs(turn) == 90) s = std::copysign(1.0, turn), c = 0;
  if (std::abs(turn) == 180) s = 0, c = -1;
  const double k = 1 - c;
  return {a.x * a.x * k + c,
          a.x * a.y * k + a.z * s,
          a.x * a.z * k - a.y * s,
          0,
          a.x * a.y * k - a.z * s,
          a.y * a.y * k + c,
          a.y * a.z * k + a.x * s,
          0,
          a.x * a.z * k + a.y * s,
          a.y * a.z * k - a.x * s,
          a.z * a.z * k + c,
          0,
          0,
          0,
          0,
          1};
}

std::optional<M44d> skew(double degrees, const V3d& from, const V3d& to) {
  if (from.length() == 0 || to.length() == 0) return std::nullopt;
  const V3d a = from.normalized();
  const V3d b = to.normalized();
  const V3d across = a - b * a.dot(b);
  const double sine = across.length();
  if (sine < 1e-12) return std::nullopt;
  const double between = std::atan2(sine, a.dot(b));
  const double rest = between - degrees * kRadians;
  if (!(rest > 0 && rest < std::numbers::pi)) return std::nullopt;
  // In the plane of both axes `from` is (sine, cosine) over (across, to); the shear adds the difference of
  // cotangents.
  const V3d e = across / sine;
  const double k = 1 / std::tan(rest) - a.dot(b) / sine;
  M44d matrix;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) matrix[row][column] += k * e[row] * b[column];
  }
  return matrix;
}

M44d perspectiveMatrix(double degrees) {
  const double c = 1 / std::tan(degrees * kRadians / 2);
  return {c, 0, 0, 0, 0, c, 0, 0, 0, 0, 1, 1, 0, 0, -1, 0};
}

bool isAffine(const M44d& m) { return m[0][3] == 0 && m[1][3] == 0 && m[2][3] == 0 && m[3][3] == 1; }

double determinant3(const M44d& m) {
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
         m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

double largestStretch(const M44d& m) {
  // Gershgorin's bound on the eigenvalues of M M^T.
  double largest = 0;
  for (int i = 0; i < 3; ++i) {
    double sum = 0;
    for (int j = 0; j < 3; ++j) sum += std::abs(m[i][0] * m[j][0] + m[i][1] * m[j][1] + m[i][2] * m[j][2]);
    largest = std::max(largest, sum);
  }
  return std::sqrt(largest);
}

std::optional<M44d> inverted(const M44d& matrix) {
  if (!isFiniteMatrix(matrix)) return std::nullopt;
  const bool affine = isAffine(matrix);
  M44d scaled = matrix;
  if (affine) scaled[3][0] = scaled[3][1] = scaled[3][2] = 0;
  // Rows scaled to unit size: singular is a matter of directions, not of lengths.
  V4 sizes(0.0);
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column)
      sizes[row] = std::max(sizes[row], std::abs(scaled[row][column]));
    if (sizes[row] == 0) return std::nullopt;
    for (int column = 0; column < 4; ++column) scaled[row][column] /= sizes[row];
  }
  if (!(std::abs(scaled.determinant()) > 1e-14)) return std::nullopt;
  M44d inverse = scaled.gjInverse();
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) inverse[row][column] /= sizes[column];
  }
  if (affine) {
    for (int row = 0; row < 4; ++row) inverse[row][3] = row == 3;
    const V3d moved = V3d(matrix[3][0], matrix[3][1], matrix[3][2]) * inverse;
    for (int column = 0; column < 3; ++column) inverse[3][column] = -moved[column];
  }
  if (!isFiniteMatrix(inverse)) return std::nullopt;
  return inverse;
}

}  // namespace patina
