// SPDX-License-Identifier: Apache-2.0
// Intervals and weights of splines.
#include "renderer/geometry/spline_direction.h"

#include <algorithm>

namespace patina {

SplineDirection::SplineDirection(const SplineKnots& spline)
    : knots_(spline.knots.begin(), spline.knots.end()), degree_(static_cast<size_t>(spline.order) - 1) {
  const double min = static_cast<double>(spline.min), max = static_cast<double>(spline.max);
  for (size_t span = degree_; span < static_cast<size_t>(spline.count); ++span) {
    const double low = std::max(knots_[span], min), high = std::min(knots_[span + 1], max);
    if (!(low < high)) continue;
    if (breaks_.empty()) breaks_.push_back(low);
    breaks_.push_back(high);
    spans_.push_back(span);
  }
}

double SplineDirection::parameter(uint32_t interval, double x) const {
  if (x == 1) return breaks_[interval + 1];
  return breaks_[interval] + x * length(interval);
}

SplineDirection::Weights SplineDirection::at(uint32_t interval, double x) const {
  Weights weights;
  weights.first = spans_[interval] - degree_;
  splineBasis(knots_, spans_[interval], degree_, parameter(interval, x), weights.w.data());
  return weights;
}

SplineDirection::Weights SplineDirection::positionAt(uint32_t interval, double x) const {
  if (x == 1) {
    if (interval + 1 == intervals()) return closed_ ? at(0, 0) : at(interval, x);
    const size_t next = spans_[interval + 1];
    if (knots_[next - degree_] < knots_[next]) return at(interval + 1, 0);
  }
  return at(interval, x);
}

SplineDirection::Weights SplineDirection::slopeAt(uint32_t interval, double x) const {
  Weights weights;
  weights.first = spans_[interval] - degree_;
  splineSlopes(knots_, spans_[interval], degree_, parameter(interval, x), length(interval), weights.w.data());
  return weights;
}

// Coefficient k of the part over [a, b] is the blossom at degree - k times a and k times b (L. Ramshaw 1989),
// by the recurrence of de Boor with an argument of its own for each step; means of means.
std::vector<double> SplineDirection::halvesAsBezier(uint32_t interval) const {
  const size_t n = order(), span = spans_[interval];
  std::vector<double> rows(2 * n * n, 0.0), blossom(n * n);
  for (size_t half = 0; half < 2; ++half)
    for (size_t k = 0; k < n; ++k) {
      std::fill(blossom.begin(), blossom.end(), 0.0);
      for (size_t i = 0; i < n; ++i) blossom[i * n + i] = 1;
      for (size_t r = 1; r <= degree_; ++r) {
        const double x =
            parameter(interval, (static_cast<double>(half) + (r <= degree_ - k ? 0.0 : 1.0)) / 2);
        for (size_t i = degree_; i >= r; --i) {
          const double low = knots_[span - degree_ + i], high = knots_[span + 1 + i - r];
          const double share = std::clamp((x - low) / (high - low), 0.0, 1.0);
          for (size_t c = 0; c < n; ++c)
            blossom[i * n + c] = (1 - share) * blossom[(i - 1) * n + c] + share * blossom[i * n + c];
        }
      }
      std::copy_n(&blossom[degree_ * n], n, &rows[(half * n + k) * n]);
    }
  return rows;
}

double SplineDirection::inSegment(uint32_t interval, double x) const {
  const double low = knots_[spans_[interval]], high = knots_[spans_[interval] + 1];
  return (parameter(interval, x) - low) / (high - low);
}

std::optional<SplineDirection::Seam> SplineDirection::seam() const {
  // The last knots of the value at either end; around them lie the knots that the weights there depend on.
  const size_t first = spans_.front();
  size_t last = spans_.back() + 1;
  if (knots_[first] != begin() || knots_[last] != end()) return std::nullopt;
  while (last + 1 < knots_.size() && knots_[last + 1] == end()) ++last;
  const size_t multiplicity = last - spans_.back();
  if (multiplicity >= degree_ || last + degree_ > knots_.size()) return std::nullopt;
  const double tolerance = 1e-5 * (end() - begin());
  for (size_t k = 0; k + 1 < 2 * degree_; ++k) {
    const double a = knots_[first + 1 - degree_ + k] - begin(), b = knots_[last + 1 - degree_ + k] - end();
    if (!(std::abs(a - b) <= tolerance)) return std::nullopt;
  }
  return Seam{first - degree_, last - degree_, degree_ - multiplicity + 1};
}

}  // namespace patina
