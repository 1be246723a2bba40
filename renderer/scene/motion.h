// SPDX-License-Identifier: Apache-2.0
// Transformations that change over time: keys, what lies between them, and how they are stacked.
#pragma once

#include <Imath/ImathQuat.h>

#include <memory>
#include <vector>

#include "renderer/base/math.h"

namespace patina {

/// An affine transformation taken apart: p' = p * stretch * rotation + translation. The determinant of
/// `rotation` is 1; a mirroring transformation has a stretch of negative determinant.
struct TransformParts {
  Imath::M33d stretch;
  Imath::Quatd rotation;
  V3d translation{0, 0, 0};

  M44d matrix() const;
};

/// The polar decomposition (Shoemake and Duff, "Matrix Animation and Polar Decomposition", Graphics Interface
/// 1992): the stretch is symmetric, and the rotation is the one that is nearest to the matrix. `matrix` must
/// be affine and invertible.
TransformParts polarParts(const M44d& matrix);

/// The same with a stretch that is lower triangular (Gram-Schmidt), as traversal kernels want it.
TransformParts triangularParts(const M44d& matrix);

/// From a (at 0) to b (at 1): the rotation turns the short way at a constant rate, the rest is linear.
TransformParts interpolate(const TransformParts& a, const TransformParts& b, double s);

struct MotionKey {
  double time;  ///< of the RIB: in the same unit and from the same origin as Shutter's
  M44d matrix;  ///< affine, invertible
};

/// A transformation given at some times, on top of one that may move itself. Between two keys it is the
/// interpolation of their polar decompositions; before the first and behind the last they are held.
/// Immutable.
class Motion {
 public:
  /// Motions on top of each other.
  static constexpr size_t kMostNested = 256;

  /// `keys` are not empty, their times ascend. at() is the interpolated key * inner * outer->at().
  Motion(std::vector<MotionKey> keys, const M44d& inner, std::shared_ptr<const Motion> outer);

  M44d at(double time) const;
  bool movesWithin(double open, double close) const;
  /// Keys between the two times, of all nested motions: a measure of how much happens there.
  size_t keysWithin(double open, double close) const;
  size_t nested() const { return nested_; }

 private:
  M44d keyAt(double time) const;

  std::vector<MotionKey> keys_;
  std::vector<TransformParts> parts_;  ///< by key
  M44d inner_;
  std::shared_ptr<const Motion> outer_;
  size_t nested_ = 1;
};

/// A place that may move: inner * outer(time). What shares `outer` moves as one.
struct Movement {
  M44d inner;
  std::shared_ptr<const Motion> outer;  ///< null: it stands still, and `inner` means nothing

  M44d at(double time) const { return inner * outer->at(time); }
  bool movesWithin(double open, double close) const { return outer && outer->movesWithin(open, close); }
  bool operator==(const Movement&) const = default;
};

/// A request Rotate at one time.
struct Turn {
  double time, degrees;
  V3d axis;  ///< not zero
};

/// Keys of a turning motion: the angle changes at a constant rate between two of them, all the way round
/// where the request says so, and so keys are added until none is more than a quarter turn from the next.
/// Where the axis changes its direction, the motion is left to the keys that are given. Empty when the angles
/// differ by more than kMostTurns.
std::vector<MotionKey> keysOfTurns(const std::vector<Turn>& turns);
inline constexpr double kMostTurns = 256;

/// Time steps at equal distances over a shutter that stand for a movement: steps[0] at its opening, the last
/// at its closing.
struct MotionSteps {
  static constexpr size_t kMost = 64;  ///< segments between steps
  /// How many segments are tried: the first of them that is good enough is taken, else kMost.
  static constexpr size_t kCandidates[] = {1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 40, 48, 64};
};

/// The places of what moves from `open` to `close`, at equal distances in time and so near to each other that
/// interpolating their triangular parts keeps every point of `bound` (in the space of `movement`) within
/// 1/4096 of its size of where it should be, as far as MotionSteps::kMost segments allow.
std::vector<TransformParts> sampleMovement(const Movement& movement, double open, double close,
                                           const Box3f& bound);

}  // namespace patina
