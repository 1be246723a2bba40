// SPDX-License-Identifier: Apache-2.0
// The region that the loops of a TrimCurve enclose in the parameter plane of a NuPatch.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "renderer/scene/scene.h"

namespace patina {

/// A NURBS curve in the parameter plane, homogeneous: (u/w, v/w).
struct TrimCurve {
  SplineKnots spline;
  std::vector<float> u, v, w;  ///< a control point each
};

/// Curves that follow each other head to tail.
using TrimLoop = std::vector<TrimCurve>;

/// The loops as line segments, sorted into rows of equal height. Curves are cut up until they stay within a
/// millionth of the extent of all loops of their chords, or the number of segments gets out of hand.
/// Immutable. [any thread]
class TrimRegion {
 public:
  /// The curves must be without a splineProblem, with usable weights and finite control points, as many as
  /// their splines say. Loops whose ends do not meet are closed by straight segments.
  explicit TrimRegion(std::span<const TrimLoop> loops);

  /// Whether a line from the point crosses the loops an odd number of times.
  bool contains(double u, double v) const;

  size_t openLoops() const { return openLoops_; }  ///< that had to be closed
  size_t segmentCount() const { return segments_.size(); }
  size_t memory() const;

 private:
  struct Segment {
    double u0, v0, u1, v1;  ///< v0 < v1
  };
  void sortIntoRows();
  size_t rowOf(double v) const;

  std::vector<Segment> segments_;
  std::vector<uint32_t> rowBegin_;  ///< of entries_; one more than there are rows
  std::vector<uint32_t> entries_;   ///< indices of segments, by falling largest u within a row
  double low_ = 0, high_ = 0, rowsPerV_ = 0;
  size_t openLoops_ = 0;
};

}  // namespace patina
