// SPDX-License-Identifier: Apache-2.0
// Points as balls: the equiangular cubed sphere in double.
#include "renderer/geometry/points_surface.h"

#include <fmt/format.h>

namespace patina {
namespace {

constexpr double kQuarter = std::numbers::pi / 2;

/// Axes of the six faces: outwards, of u, of v; u x v = outwards.
struct Face {
  int out;
  double sign;
  int u, v;
};
constexpr Face kFaces[6] = {{0, 1, 1, 2},  {0, -1, 2, 1}, {1, 1, 2, 0},
                            {1, -1, 0, 2}, {2, 1, 0, 1},  {2, -1, 1, 0}};

/// tan of the angle from -45 to 45 degrees that u in [0, 1] stands for. Odd about the middle and exactly 1 at
/// the ends, so that faces agree on their edges in either direction.
double tangent(double u) {
  const double x = std::abs(u - 0.5);
  return std::copysign(x == 0.5 ? 1.0 : std::tan(x * kQuarter), u - 0.5);
}

/// |(1, x, y)|. Ordered, so that the two faces at an edge, where (1, y) meets (y, 1), round alike, also with
/// fused multiplications.
double lengthOf(double x, double y) {
  const double more = std::max(std::abs(x), std::abs(y)), less = std::min(std::abs(x), std::abs(y));
  return std::sqrt(1 + (more * more + less * less));
}

/// The unit vector through (1, x, y) of a face.
V3d direction(const Face& face, double x, double y) {
  const double length = lengthOf(x, y);
  V3d d;
  d[face.out] = face.sign / length, d[face.u] = x / length, d[face.v] = y / length;
  return d;
}

V3f onBall(const V3f& center, double radius, const V3d& d) { return V3f(V3d(center) + d * radius); }

}  // namespace

SurfacePoint PointsSurface::evaluate(uint32_t face, float u, float v) const {
  const Face& f = kFaces[face % 6];
  const uint32_t point = pointOf(face);
  const double x = tangent(static_cast<double>(u)), y = tangent(static_cast<double>(v));
  const double r = radius(point), length = lengthOf(x, y);
  const V3d d = direction(f, x, y);
  // d = q / |q| with q = (1, x, y) changes by (q' - d (d . q')) / |q|; x' = (1 + x^2) pi/2.
  const auto derivative = [&](int axis, double t) {
    V3d change(0, 0, 0);
    change[axis] = (1 + t * t) * kQuarter;
    return (change - d * (d[axis] * change[axis])) * (r / length);
  };
  return {onBall(points_[point], r, d), V3f(d), V3f(derivative(f.u, x)), V3f(derivative(f.v, y))};
}

void PointsSurface::corners(uint32_t face, V3f out[4]) const {
  const uint32_t point = pointOf(face);
  for (int k = 0; k < 4; ++k)
    out[k] = onBall(points_[point], radius(point),
                    direction(kFaces[face % 6], k % 2 == 0 ? -1.0 : 1.0, k / 2 == 0 ? -1.0 : 1.0));
}

void PointsSurface::evaluateGrid(uint32_t face, std::span<const double> u, std::span<const double> v,
                                 std::span<V3f> out) const {
  thread_local std::vector<double> x;
  x.clear();
  for (const double s : u) x.push_back(tangent(s));
  const uint32_t point = pointOf(face);
  const V3f center = points_[point];
  const double r = radius(point);
  auto next = out.begin();
  for (const double t : v) {
    const double y = tangent(t);
    for (const double a : x) *next++ = onBall(center, r, direction(kFaces[face % 6], a, y));
  }
}

void PointsSurface::interpolate(const PrimVar& variable, uint32_t face, float, float, float* out) const {
  const bool whole = variable.storage == StorageClass::Constant || variable.storage == StorageClass::Uniform;
  copyValue(variable, whole ? 0 : pointOf(face), out);
}

std::unique_ptr<PointsSurface> PointsSurface::make(const PointSet& points, const Primitive& primitive,
                                                   ErrorHandler& errors) {
  const auto fail = [&](RiError code, std::string_view why) {
    errors.report(Severity::Error, code, primitive.where, fmt::format("Points are left out: {}", why));
    return nullptr;
  };
  std::unique_ptr<PointsSurface> s(new PointsSurface);
  const auto found = findPoints(primitive);
  if (!found) return fail(RiError::MissingData, "they need \"P\"");
  if (found->size() < points.count)
    return fail(RiError::MissingData,
                fmt::format("\"P\" has {} points, expected {}", found->size(), points.count));
  constexpr size_t kMost = 0xffffffffu / 6;
  if (points.count > kMost)
    return fail(RiError::LimitCheck, fmt::format("{} points, expected at most {}", points.count, kMost));
  s->points_ = *found;
  for (const PrimVar& variable : primitive.variables) {
    if (variable.components != 1 || variable.floats.empty()) continue;
    if (variable.name == "constantwidth") s->constantWidth_ = variable.floats[0];
    if (variable.name != "width") continue;
    if (variable.floats.size() == 1)
      s->constantWidth_ = variable.floats[0];
    else if (variable.floats.size() >= points.count)
      s->widths_ = variable.floats;
  }
  if (s->widths_.empty() && !(s->constantWidth_ > 0 && s->constantWidth_ <= kLargestCoordinate))
    return fail(RiError::Range, fmt::format("their width is {}, expected more than 0", s->constantWidth_));

  // Which points are drawn, and what holds them.
  size_t withoutWidth = 0;
  for (uint32_t point = 0; point < points.count; ++point) {
    const V3f p = s->points_[point];
    if (!usable(p)) return fail(RiError::Range, fmt::format("point {} is not finite, or beyond 1e18", point));
    const double r = s->radius(point);
    if (!(r <= static_cast<double>(kLargestCoordinate)))
      return fail(RiError::Range, fmt::format("the width of point {} is not finite, or beyond 1e18", point));
    if (r <= 0) {
      if (withoutWidth++ == 0)
        for (uint32_t earlier = 0; earlier < point; ++earlier) s->kept_.push_back(earlier);
      continue;
    }
    if (withoutWidth > 0) s->kept_.push_back(point);
    ++s->count_;
    for (int c = 0; c < 3; ++c) {
      const auto x = static_cast<double>(p[c]);
      s->bound_.min[c] = std::min(s->bound_.min[c], std::nextafter(static_cast<float>(x - r), -kInfinity));
      s->bound_.max[c] = std::max(s->bound_.max[c], std::nextafter(static_cast<float>(x + r), kInfinity));
    }
  }
  if (s->count_ == 0) return fail(RiError::Range, "no width is more than 0");
  if (withoutWidth > 0)
    errors.report(Severity::Warning, RiError::Range, primitive.where,
                  fmt::format("Points: {} of {} have a width that is not more than 0; they are left out",
                              withoutWidth, points.count));
  s->kept_.shrink_to_fit();
  s->memory_ = sizeof(PointsSurface) + s->kept_.capacity() * sizeof(uint32_t);
  return s;
}

}  // namespace patina
