// SPDX-License-Identifier: Apache-2.0
// Interpolation of transformations, and their sampling at equal distances in time.
#include "renderer/scene/motion.h"

#include <Imath/ImathMatrixAlgo.h>

#include <array>

#include "renderer/scene/matrices.h"

namespace patina {
namespace {

using Imath::M33d;
using Imath::Quatd;

M33d upper(const M44d& m) {
  return {m[0][0], m[0][1], m[0][2], m[1][0], m[1][1], m[1][2], m[2][0], m[2][1], m[2][2]};
}

V3d row(const M33d& m, int k) { return {m[k][0], m[k][1], m[k][2]}; }

/// Of a matrix whose rows are orthonormal up to rounding, with determinant 1.
Quatd quaternion(const M33d& m) {
  return Imath::extractQuat(M44d(m[0][0], m[0][1], m[0][2], 0, m[1][0], m[1][1], m[1][2], 0, m[2][0], m[2][1],
                                 m[2][2], 0, 0, 0, 0, 1))
      .normalized();
}

TransformParts parts(M33d stretch, M33d rotation, const M44d& matrix) {
  if (rotation.determinant() < 0) stretch *= -1.0, rotation *= -1.0;
  return {stretch, quaternion(rotation), {matrix[3][0], matrix[3][1], matrix[3][2]}};
}

}  // namespace

M44d TransformParts::matrix() const {
  const M33d m = stretch * rotation.toMatrix33();
  return {m[0][0], m[0][1], m[0][2], 0, m[1][0],       m[1][1],       m[1][2],       0,
          m[2][0], m[2][1], m[2][2], 0, translation.x, translation.y, translation.z, 1};
}

TransformParts polarParts(const M44d& matrix) {
  // With M = U S V^T the nearest orthogonal matrix is U V^T, and the stretch on its left is U S U^T.
  M33d u, v;
  V3d s;
  Imath::jacobiSVD(upper(matrix), u, s, v);
  const M33d scale(s.x, 0, 0, 0, s.y, 0, 0, 0, s.z), back = u.transposed();
  return parts(u * scale * back, u * v.transposed(), matrix);
}

TransformParts triangularParts(const M44d& matrix) {
  const M33d m = upper(matrix);
  M33d stretch(0, 0, 0, 0, 0, 0, 0, 0, 0), rotation;
  for (int i = 0; i < 3; ++i) {
    V3d rest = row(m, i);
    for (int j = 0; j < i; ++j) {
      stretch[i][j] = rest.dot(row(rotation, j));
      rest -= row(rotation, j) * stretch[i][j];
    }
    stretch[i][i] = rest.length();
    for (int k = 0; k < 3; ++k) rotation[i][k] = rest[k] / stretch[i][i];
  }
  return parts(stretch, rotation, matrix);
}

TransformParts interpolate(const TransformParts& a, const TransformParts& b, double s) {
  TransformParts result;
  result.stretch = a.stretch * (1 - s) + b.stretch * s;
  result.rotation =
      a.rotation == b.rotation ? a.rotation : Imath::slerpShortestArc(a.rotation, b.rotation, s).normalized();
  result.translation = a.translation * (1 - s) + b.translation * s;
  return result;
}

// ---- Motion -----------------------------------------------------------------------------------------------

Motion::Motion(std::vector<MotionKey> keys, const M44d& inner, std::shared_ptr<const Motion> outer)
    : keys_(std::move(keys)), inner_(inner), outer_(std::move(outer)) {
  for (const MotionKey& key : keys_) parts_.push_back(polarParts(key.matrix));
  if (outer_) nested_ = outer_->nested_ + 1;
}

M44d Motion::keyAt(double time) const {
  const auto later = std::upper_bound(keys_.begin(), keys_.end(), time,
                                      [](double t, const MotionKey& key) { return t < key.time; });
  if (later == keys_.begin()) return keys_.front().matrix;
  const MotionKey& before = *std::prev(later);
  if (later == keys_.end() || time == before.time || before.matrix == later->matrix) return before.matrix;
  const auto k = static_cast<size_t>(later - keys_.begin());
  return interpolate(parts_[k - 1], parts_[k], (time - before.time) / (later->time - before.time)).matrix();
}

M44d Motion::at(double time) const {
  const M44d inside = keyAt(time) * inner_;
  return outer_ ? inside * outer_->at(time) : inside;
}

bool Motion::movesWithin(double open, double close) const {
  if (!(open < close)) return false;
  for (size_t k = 1; k < keys_.size(); ++k)
    if (keys_[k - 1].time < close && keys_[k].time > open && keys_[k - 1].matrix != keys_[k].matrix)
      return true;
  return outer_ && outer_->movesWithin(open, close);
}

size_t Motion::keysWithin(double open, double close) const {
  const auto inside = std::count_if(
      keys_.begin(), keys_.end(), [&](const MotionKey& key) { return key.time > open && key.time < close; });
  return static_cast<size_t>(inside) + (outer_ ? outer_->keysWithin(open, close) : 0);
}

// ---- Keys and steps ---------------------------------------------------------------------------------------

std::vector<MotionKey> keysOfTurns(const std::vector<Turn>& turns) {
  std::vector<MotionKey> keys;
  for (size_t k = 0; k < turns.size(); ++k) {
    const Turn& to = turns[k];
    if (k > 0) {
      const Turn& from = turns[k - 1];
      const V3d a = from.axis.normalized(), b = to.axis.normalized();
      const double end = a.dot(b) < 0 ? -to.degrees : to.degrees, turn = end - from.degrees;
      if (!(std::abs(turn) <= 360 * kMostTurns)) return {};
      if (a.cross(b).length() < 1e-6) {
        const double count = std::max(1.0, std::ceil(std::abs(turn) / 90));
        for (double i = 1; i < count; ++i)
          keys.push_back({from.time + (to.time - from.time) * i / count,
                          rotation(from.degrees + turn * i / count, from.axis)});
      }
    }
    keys.push_back({to.time, rotation(to.degrees, to.axis)});
  }
  return keys;
}

std::vector<TransformParts> sampleMovement(const Movement& movement, double open, double close,
                                           const Box3f& bound) {
  const auto at = [&](double s) { return movement.at(open + (close - open) * s); };
  std::array<V3d, 8> corner;
  for (unsigned c = 0; c < 8; ++c)
    corner[c] = {static_cast<double>(c & 1 ? bound.max.x : bound.min.x),
                 static_cast<double>(c & 2 ? bound.max.y : bound.min.y),
                 static_cast<double>(c & 4 ? bound.max.z : bound.min.z)};
  const auto fits = [&](const std::vector<TransformParts>& steps) {
    const auto n = static_cast<double>(steps.size() - 1);
    for (size_t k = 0; k + 1 < steps.size(); ++k)
      // Fractions without a common measure: no periodic motion hides between them.
      for (const double s : {0.2113, 0.5, 0.8277}) {
        const M44d exact = at((static_cast<double>(k) + s) / n),
                   near = interpolate(steps[k], steps[k + 1], s).matrix();
        double deviation = 0, most = 0;
        for (const V3d& c : corner) {
          const V3d p = c * exact;
          deviation = std::max(deviation, (p - c * near).length());
          most = std::max(most, (p - corner[0] * exact).length());
        }
        // A part of the size, or what rounding to float leaves of it.
        const double rounding = 1e-6 * (corner[0] * exact).length();
        if (!(deviation <= std::max(most / 4096, rounding))) return false;
      }
    return true;
  };
  const size_t keys = movement.outer->keysWithin(open, close);
  std::vector<TransformParts> steps;
  for (const size_t segments : MotionSteps::kCandidates) {
    if (segments < std::min(keys + 1, MotionSteps::kMost)) continue;
    steps.clear();
    for (size_t k = 0; k <= segments; ++k)
      steps.push_back(triangularParts(at(static_cast<double>(k) / static_cast<double>(segments))));
    if (fits(steps)) break;
  }
  return steps;
}

}  // namespace patina
