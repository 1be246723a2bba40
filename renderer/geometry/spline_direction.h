// SPDX-License-Identifier: Apache-2.0
// B-splines along one direction of a NURBS surface, knot interval by knot interval.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "renderer/base/bspline.h"
#include "renderer/scene/scene.h"

namespace patina {

/// The intervals are those between neighbouring different knots, as far as they lie within [min, max]; the
/// first and the last may be cut. Each has its own parameter x from 0 to 1.
class SplineDirection {
 public:
  /// Of the control points `first` and those after it, `order()` in all.
  struct Weights {
    size_t first;
    std::array<double, kMaxSplineOrder> w;  ///< only the first order() are set
  };

  SplineDirection() = default;
  /// `spline` must be without a splineProblem.
  explicit SplineDirection(const SplineKnots& spline);

  size_t order() const { return degree_ + 1; }
  uint32_t intervals() const { return static_cast<uint32_t>(spans_.size()); }
  size_t firstPoint() const { return spans_.front() - degree_; }  ///< of those that matter
  size_t lastPoint() const { return spans_.back(); }

  Weights at(uint32_t interval, double x) const;
  /// The same for positions. What two intervals share is evaluated by one rule, with the same bits: at a knot
  /// where the spline is continuous, the end of an interval is the beginning of the next one. (Knots of full
  /// multiplicity are met exactly by the control points at their two sides.)
  Weights positionAt(uint32_t interval, double x) const;
  Weights slopeAt(uint32_t interval, double x) const;  ///< derivatives by x

  /// The two halves of an interval as Bezier curves: row k < order() has the weights of the order() control
  /// points in coefficient k of the first half, the next order() rows those of the second. None is negative.
  std::vector<double> halvesAsBezier(uint32_t interval) const;

  double parameter(uint32_t interval, double x) const;  ///< in units of the knots
  double length(uint32_t interval) const { return breaks_[interval + 1] - breaks_[interval]; }
  double begin() const { return breaks_.front(); }
  double end() const { return breaks_.back(); }

  /// RI's segments are the intervals between all neighbouring knots, empty ones included: the one that an
  /// interval is (a part) of, counted from the beginning of the knots, and where in it x lies.
  uint32_t segment(uint32_t interval) const { return static_cast<uint32_t>(spans_[interval] - degree_); }
  double inSegment(uint32_t interval, double x) const;

  /// A spline that ends as it begins, so that it is closed if control points end + k equal begin + k for all
  /// k < count. Knot intervals around the two ends may differ by what printing them with six digits does.
  /// nullopt where the ends differ, and where they lie on control points (full multiplicity), which needs no
  /// rule.
  struct Seam {
    size_t begin, end, count;
  };
  std::optional<Seam> seam() const;
  /// The last position is from now on the first one.
  void close() { closed_ = true; }

 private:
  std::vector<double> knots_;
  size_t degree_ = 1;
  std::vector<size_t> spans_;   ///< knots_[span] begins the interval that an interval is (a part) of
  std::vector<double> breaks_;  ///< ends of intervals, one more than there are
  bool closed_ = false;
};

}  // namespace patina
