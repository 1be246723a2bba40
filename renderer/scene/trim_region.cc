// SPDX-License-Identifier: Apache-2.0
// From trim curves to line segments, and the crossing test.
#include "renderer/scene/trim_region.h"

#include "renderer/base/bspline.h"

namespace patina {
namespace {

constexpr double kTolerance = 1e-6;        // of the extent of all loops, between a curve and its chords
constexpr double kGap = 1e-4;              // of the extent: ends that are farther apart leave a loop open
constexpr int kMostHalvings = 10;          // of a piece of a knot interval
constexpr size_t kManySegments = 1 << 18;  // from here on, one segment per piece has to do

struct Point {
  double u, v;
  bool operator==(const Point&) const = default;
};

/// The loops' segments, one after the other.
class Flattener {
 public:
  explicit Flattener(std::span<const TrimLoop> loops) {
    Point low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    Point high{-low.u, -low.v};
    for (const TrimLoop& loop : loops)
      for (const TrimCurve& curve : loop)
        for (size_t k = 0; k < curve.u.size(); ++k) {
          const double w = curve.w[k], u = curve.u[k] / w, v = curve.v[k] / w;
          low = {std::min(low.u, u), std::min(low.v, v)};
          high = {std::max(high.u, u), std::max(high.v, v)};
        }
    scale_ = {high.u > low.u ? 1 / (high.u - low.u) : 0, high.v > low.v ? 1 / (high.v - low.v) : 0};
  }

  size_t openLoops = 0;
  std::vector<std::pair<Point, Point>> segments;

  void add(const TrimLoop& loop) {
    if (loop.empty()) return;
    bool first = true, open = false;
    Point start{}, end{};
    const auto join = [&](const Point& to) {
      open = open || distance(end, to) > kGap;
      if (end != to) segments.emplace_back(end, to);
    };
    for (const TrimCurve& curve : loop) {
      const Point begin = load(curve);
      if (first)
        start = begin;
      else
        join(begin);
      first = false;
      end = flatten(curve, begin);
    }
    join(start);
    openLoops += open;
  }

 private:
  double distance(const Point& a, const Point& b) const {
    return std::hypot((a.u - b.u) * scale_.u, (a.v - b.v) * scale_.v);
  }
  double distance(const Point& p, const Point& a, const Point& b) const {
    const double x = (b.u - a.u) * scale_.u, y = (b.v - a.v) * scale_.v;
    const double px = (p.u - a.u) * scale_.u, py = (p.v - a.v) * scale_.v;
    const double length2 = x * x + y * y;
    const double t = length2 > 0 ? std::clamp((px * x + py * y) / length2, 0.0, 1.0) : 0;
    return std::hypot(px - t * x, py - t * y);
  }

  /// Makes `curve` the one that at() evaluates; its first point.
  Point load(const TrimCurve& curve) {
    curve_ = &curve;
    knots_.assign(curve.spline.knots.begin(), curve.spline.knots.end());
    degree_ = static_cast<size_t>(curve.spline.order) - 1;
    span_ = degree_;
    while (knots_[span_ + 1] <= static_cast<double>(curve.spline.min)) ++span_;
    return at(static_cast<double>(curve.spline.min));
  }
  Point at(double t) const {
    double basis[kMaxSplineOrder];
    splineBasis(knots_, span_, degree_, t, basis);
    double u = 0, v = 0, w = 0;
    for (size_t k = 0; k <= degree_; ++k) {
      const size_t i = span_ - degree_ + k;
      u += basis[k] * static_cast<double>(curve_->u[i]);
      v += basis[k] * static_cast<double>(curve_->v[i]);
      w += basis[k] * static_cast<double>(curve_->w[i]);
    }
    return {u / w, v / w};
  }

  /// Segments of the loaded curve; its last point.
  Point flatten(const TrimCurve& curve, Point from) {
    const double min = static_cast<double>(curve.spline.min), max = static_cast<double>(curve.spline.max);
    bool straight = degree_ == 1;
    for (size_t k = 1; k < curve.w.size(); ++k) straight = straight && curve.w[k] == curve.w[0];
    const size_t count = static_cast<size_t>(curve.spline.count);
    for (; span_ < count && knots_[span_] < max; ++span_) {
      if (knots_[span_] == knots_[span_ + 1]) continue;
      const double begin = std::max(min, knots_[span_]), end = std::min(max, knots_[span_ + 1]);
      // A curve of degree n has up to n - 1 bends in a knot interval: begin with so many pieces that points
      // between the ends show them.
      const size_t pieces = straight || segments.size() >= kManySegments ? 1 : degree_ + 1;
      if (begin > min && knots_[span_ - degree_] == knots_[span_]) {  // the curve may jump here
        const Point landing = at(begin);
        segments.emplace_back(from, landing);
        from = landing;
      }
      double t0 = begin;
      for (size_t k = 1; k <= pieces; ++k) {
        const double t1 =
            k == pieces ? end : begin + (end - begin) * static_cast<double>(k) / static_cast<double>(pieces);
        const Point to = at(t1);
        if (straight)
          segments.emplace_back(from, to);
        else
          divide(t0, from, t1, to, kMostHalvings);
        from = to, t0 = t1;
      }
    }
    return from;
  }
  void divide(double t0, const Point& from, double t1, const Point& to, int halvings) {
    const double middle = t0 + (t1 - t0) / 2;
    const Point m = at(middle);
    if (halvings == 0 || segments.size() >= kManySegments ||
        (distance(m, from, to) < kTolerance && distance(at(t0 + (t1 - t0) / 4), from, to) < kTolerance &&
         distance(at(t1 - (t1 - t0) / 4), from, to) < kTolerance)) {
      segments.emplace_back(from, to);
      return;
    }
    divide(t0, from, middle, m, halvings - 1);
    divide(middle, m, t1, to, halvings - 1);
  }

  Point scale_{0, 0};
  const TrimCurve* curve_ = nullptr;
  std::vector<double> knots_;
  size_t degree_ = 1, span_ = 1;
};

}  // namespace

TrimRegion::TrimRegion(std::span<const TrimLoop> loops) {
  Flattener flattener(loops);
  for (const TrimLoop& loop : loops) flattener.add(loop);
  openLoops_ = flattener.openLoops;
  for (const auto& [a, b] : flattener.segments) {
    if (a.v < b.v) segments_.push_back({a.u, a.v, b.u, b.v});
    if (b.v < a.v) segments_.push_back({b.u, b.v, a.u, a.v});
  }
  segments_.shrink_to_fit();
  sortIntoRows();
}

size_t TrimRegion::rowOf(double v) const {
  return std::min(static_cast<size_t>(std::max((v - low_) * rowsPerV_, 0.0)), rowBegin_.size() - 2);
}

void TrimRegion::sortIntoRows() {
  if (segments_.empty()) return;
  low_ = std::numeric_limits<double>::infinity(), high_ = -low_;
  for (const Segment& s : segments_) low_ = std::min(low_, s.v0), high_ = std::max(high_, s.v1);
  // As many rows as segments, but few enough that each segment is in a few rows on average.
  size_t rows = std::min(segments_.size(), size_t{1} << 16), total = 0;
  for (;; rows = (rows + 1) / 2) {
    rowBegin_.assign(rows + 1, 0);
    rowsPerV_ = static_cast<double>(rows) / (high_ - low_);
    if (!std::isfinite(rowsPerV_)) rowsPerV_ = 0;  // no height to speak of: all in the first row
    total = 0;
    for (const Segment& s : segments_) total += rowOf(s.v1) - rowOf(s.v0) + 1;
    if (rows == 1 || total <= 8 * segments_.size()) break;
  }
  for (const Segment& s : segments_)
    for (size_t row = rowOf(s.v0), last = rowOf(s.v1); row <= last; ++row) ++rowBegin_[row + 1];
  for (size_t row = 0; row < rows; ++row) rowBegin_[row + 1] += rowBegin_[row];
  entries_.resize(total);
  std::vector<uint32_t> next(rowBegin_.begin(), rowBegin_.end() - 1);
  for (uint32_t k = 0; k < segments_.size(); ++k)
    for (size_t row = rowOf(segments_[k].v0), last = rowOf(segments_[k].v1); row <= last; ++row)
      entries_[next[row]++] = k;
  const auto largest = [&](uint32_t k) { return std::max(segments_[k].u0, segments_[k].u1); };
  for (size_t row = 0; row < rows; ++row)
    std::sort(entries_.begin() + rowBegin_[row], entries_.begin() + rowBegin_[row + 1],
              [&](uint32_t a, uint32_t b) { return largest(a) > largest(b); });
}

bool TrimRegion::contains(double u, double v) const {
  if (!(v >= low_ && v < high_)) return false;
  // A line towards larger u. Segments hold their lower ends and not their upper ones, so that a line through
  // a vertex crosses once where the loop goes on upwards, and twice or never where it turns.
  bool odd = false;
  const size_t row = rowOf(v);
  for (size_t k = rowBegin_[row]; k < rowBegin_[row + 1]; ++k) {
    const Segment& s = segments_[entries_[k]];
    if (std::max(s.u0, s.u1) <= u) break;
    if (v >= s.v0 && v < s.v1 && s.u0 + (v - s.v0) / (s.v1 - s.v0) * (s.u1 - s.u0) > u) odd = !odd;
  }
  return odd;
}

size_t TrimRegion::memory() const {
  return sizeof(TrimRegion) + segments_.capacity() * sizeof(Segment) +
         (rowBegin_.capacity() + entries_.capacity()) * sizeof(uint32_t);
}

}  // namespace patina
