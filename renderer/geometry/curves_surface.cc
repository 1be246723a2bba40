// SPDX-License-Identifier: Apache-2.0
// Curves: construction, points of ribbons and tubes, variables.
#include "renderer/geometry/curves_surface.h"

#include <fmt/format.h>

#include "renderer/scene/value_count.h"

namespace patina {
namespace {

struct SinCos {
  double sin, cos;
};

/// Of u turns: exact at quarters, the same at 0 and 1.
SinCos sinCosTurns(double u) {
  const double quarter = std::nearbyint(4 * u);
  const double rest = (u - quarter / 4) * (2 * std::numbers::pi);
  const double s = std::sin(rest), c = std::cos(rest);
  switch (static_cast<int>(quarter) & 3) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

}  // namespace

// ---- Segments and variables -------------------------------------------------------------------------------

CurvesSurface::Place CurvesSurface::placeOf(uint32_t face) const {
  const uint32_t curve = curveOf(face);
  const Curve &c = curves_[curve], &next = curves_[curve + 1];
  return {curve, c.firstPoint, next.firstPoint - c.firstPoint, face - c.firstSegment,
          next.firstSegment - c.firstSegment};
}

/// Which varying value belongs to an end of a segment.
uint32_t CurvesSurface::varying(const Place& place, uint32_t end) const {
  const uint32_t first = curves_[place.curve].firstSegment;
  if (periodic_) return first + (place.index + end) % place.count;
  return first + place.curve + place.index + end;
}

/// One component of a variable, with its derivative by v.
Dual CurvesSurface::blend(const PrimVar& variable, const Place& place, double v, size_t component) const {
  const auto n = static_cast<size_t>(variable.components);
  const auto value = [&](size_t index) {
    const size_t i = index * n + component;
    return i < variable.floats.size() ? static_cast<double>(variable.floats[i]) : 0.0;
  };
  switch (variable.storage) {
    case StorageClass::Constant:
      return {value(0), 0};
    case StorageClass::Uniform:
      return {value(place.curve), 0};
    case StorageClass::Vertex: {
      const auto w = basis_.at(v), d = basis_.derivative(v);
      Dual sum;
      for (size_t k = 0; k < static_cast<size_t>(basis_.points()); ++k) {
        const double x = value(point(place, static_cast<uint32_t>(k)));
        sum.x += w[k] * x, sum.d += d[k] * x;
      }
      return sum;
    }
    default: {
      const double a = value(varying(place, 0)), b = value(varying(place, 1));
      return {v == 1 ? b : a * (1 - v) + b * v, b - a};
    }
  }
}

void CurvesSurface::interpolate(const PrimVar& variable, uint32_t face, float, float v, float* out) const {
  const Place place = placeOf(face);
  for (size_t c = 0; c < static_cast<size_t>(variable.components); ++c)
    out[c] = static_cast<float>(blend(variable, place, static_cast<double>(v), c).x);
}

V2f CurvesSurface::surfaceParameters(uint32_t face, float u, float v) const {
  const Place place = placeOf(face);
  return {u, (static_cast<float>(place.index) + v) / static_cast<float>(place.count)};
}

V2f CurvesSurface::parameterScale(uint32_t face) const {
  return {1, 1 / static_cast<float>(placeOf(face).count)};
}

// ---- Points -----------------------------------------------------------------------------------------------

[[gnu::noinline]] SurfacePoint CurvesSurface::pointOn(const Section& s, double u) const {
  V3d around, limit;  // unit: along dPdu; the normal where dPdv vanishes
  DualV3 offset;
  double perU;
  if (round_) {
    const SinCos turn = sinCosTurns(u);
    const DualV3 out = s.across * Dual{turn.cos, 0} + s.up * Dual{turn.sin, 0};
    around = s.up.x * turn.cos - s.across.x * turn.sin;
    limit = out.x;
    offset = out * (s.width * Dual{0.5, 0});
    perU = s.width.x * std::numbers::pi;
  } else {
    around = s.across.x;
    limit = around.cross(s.direction.x);
    offset = s.across * (s.width * Dual{u - 0.5, 0});
    perU = s.width.x;
  }
  const V3d dPdv = s.P.d + offset.d;
  V3d n = around.cross(dPdv);
  const double length = std::sqrt(n.dot(n));
  n = length > 1e-9 * std::max(s.scale, std::abs(s.width.d)) ? n / length : limit;
  return {V3f(s.P.x + offset.x), V3f(n), V3f(around * perU), V3f(dPdv)};
}

SurfacePoint CurvesSurface::evaluate(uint32_t face, float u, float v) const {
  return pointOn(section(open(placeOf(face)), static_cast<double>(v)), static_cast<double>(u));
}

void CurvesSurface::evaluateMany(uint32_t face, std::span<const V2f> uv, std::span<SurfacePoint> out) const {
  if (uv.empty()) return;
  const Segment segment = open(placeOf(face));
  Section s;
  for (size_t i = 0; i < uv.size(); ++i) {
    if (i == 0 || uv[i].y != uv[i - 1].y) s = section(segment, static_cast<double>(uv[i].y));
    out[i] = pointOn(s, static_cast<double>(uv[i].x));
  }
}

void CurvesSurface::corners(uint32_t face, V3f out[4]) const {
  const Segment segment = open(placeOf(face));
  for (int end = 0; end < 2; ++end) {
    const Section s = section(segment, end);
    out[2 * end] = pointOn(s, 0).P, out[2 * end + 1] = pointOn(s, 1).P;
  }
}

// ---- Construction -----------------------------------------------------------------------------------------

/// Of the Bezier hulls of all segments, each widened by half of what its width is at most.
Box3f CurvesSurface::computeBound() const {
  const auto rows = basis_.bezier();
  const auto n = static_cast<size_t>(basis_.points());
  V3d low(std::numeric_limits<double>::infinity()), high(-low);
  for (uint32_t face = 0; face < faces_; ++face) {
    const Place place = placeOf(face);
    double widest = width_ ? 0 : 1;
    const bool hull = width_ && width_->storage == StorageClass::Vertex;
    if (width_ && !hull) widest = std::max(blend(*width_, place, 0, 0).x, blend(*width_, place, 1, 0).x);
    V3d from(std::numeric_limits<double>::infinity()), to(-from);
    for (size_t row = 0; row < n; ++row) {
      V3d p(0);
      double w = 0, width = 0;
      for (size_t k = 0; k < n; ++k) {
        const uint32_t index = point(place, static_cast<uint32_t>(k));
        const float* q = points_ + size_t{index} * (rational_ ? 4 : 3);
        p += V3d(V3f(q[0], q[1], q[2])) * rows[row][k];
        if (rational_) w += static_cast<double>(q[3]) * rows[row][k];
        if (hull) width += static_cast<double>(width_->floats[index]) * rows[row][k];
      }
      if (rational_) p /= w > 0 ? w : 0;  // a weight that may reach 0 leaves no bound
      widest = std::max(widest, width);
      for (int c = 0; c < 3; ++c) from[c] = std::min(from[c], p[c]), to[c] = std::max(to[c], p[c]);
    }
    for (int c = 0; c < 3; ++c) {
      low[c] = std::min(low[c], from[c] - widest / 2);
      high[c] = std::max(high[c], to[c] + widest / 2);
    }
  }
  Box3f box;
  double size = 0;
  for (int c = 0; c < 3; ++c) size = std::max({size, std::abs(low[c]), std::abs(high[c])});
  const double margin = 2 * static_cast<double>(kMachineEpsilon) * size;
  for (int c = 0; c < 3; ++c) {
    box.min[c] = std::nextafter(static_cast<float>(low[c] - margin), -kInfinity);
    box.max[c] = std::nextafter(static_cast<float>(high[c] + margin), kInfinity);
  }
  return box;
}

std::unique_ptr<CurvesSurface> CurvesSurface::make(const CurveSet& curves, const Primitive& primitive,
                                                   const Viewpoint& view, ErrorHandler& errors) {
  const auto fail = [&](RiError code, std::string_view why) {
    errors.report(Severity::Error, code, primitive.where, fmt::format("Curves are left out: {}", why));
    return nullptr;
  };
  std::unique_ptr<CurvesSurface> s(new CurvesSurface);
  s->periodic_ = curves.periodic;
  s->view_ = view;
  if (curves.cubic) {
    for (int i = 0; i < 16; ++i)
      if (!(std::abs(curves.basis.matrix[i / 4][i % 4]) <= 1e6f))
        return fail(RiError::BadBasis, "the basis matrix has entries that are not finite or far too large");
    s->basis_ = SplineBasis(curves.basis);
    s->step_ = static_cast<uint32_t>(std::max(curves.basis.step, 1));
  }

  // Counts, before anything is made of them.
  size_t points = 0, segments = 0;
  for (size_t k = 0; k < curves.vertexCounts.size(); ++k) {
    const int count = curves.vertexCounts[k];
    const int n = patchCount(curves.cubic, count, curves.basis.step, curves.periodic);
    if (n == 0)
      return fail(RiError::Range, fmt::format("{} points make no whole number of {} segments (curve {})",
                                              count, curves.cubic ? "cubic" : "linear", k));
    points += static_cast<size_t>(count), segments += static_cast<size_t>(n);
  }
  if (segments == 0) return fail(RiError::BadArgument, "there is no curve");
  const PrimVar* P = findVariable(primitive, "Pw");
  s->rational_ = P != nullptr && P->components == 4;
  if (!s->rational_) P = findVariable(primitive, "P");
  if (!P || (!s->rational_ && P->components != 3)) return fail(RiError::MissingData, "they need \"P\"");
  const size_t given = P->floats.size() / static_cast<size_t>(P->components);
  if (points > given)
    return fail(RiError::MissingData, fmt::format("they need {} points, not {}", points, given));
  if (points > size_t{1} << 31) return fail(RiError::LimitCheck, "they have more than 2147483648 points");
  s->points_ = P->floats.data();
  for (size_t k = 0; k < points; ++k) {
    const float* p = s->points_ + k * static_cast<size_t>(P->components);
    if (!usable({p[0], p[1], p[2]}))
      return fail(RiError::Range, fmt::format("point {} is not finite, or beyond 1e18", k));
    if (s->rational_ && !(p[3] > 0 && p[3] <= kLargestCoordinate))
      return fail(RiError::Range, fmt::format("the weight of point {} is not positive", k));
  }

  for (const PrimVar& variable : primitive.variables) {
    if (variable.floats.empty()) continue;
    if (variable.components == 1 && variable.name == "width") s->width_ = &variable;
    if (variable.components == 1 && variable.name == "constantwidth" && !s->width_) s->width_ = &variable;
    if (variable.components == 3 && variable.name == "N") s->normal_ = &variable;
  }
  const ValueCounts counts = valueCounts(primitive.shape, 0);
  const auto enough = [&](const PrimVar* v) {
    return !v || v->floats.size() >= counts.of(v->storage) * static_cast<size_t>(v->components);
  };
  if (!enough(s->width_) || !enough(s->normal_))
    return fail(RiError::MissingData, "\"width\" or \"N\" has too few values");
  if (s->width_)
    for (const float w : s->width_->floats)
      if (!(std::abs(w) <= kLargestCoordinate))
        return fail(RiError::Range, "a width is not finite, or beyond 1e18");
  if (s->normal_)
    for (const float x : s->normal_->floats)
      if (!(std::abs(x) <= kLargestCoordinate))
        return fail(RiError::Range, "a normal is not finite, or beyond 1e18");
  s->round_ = curves.round && !s->normal_;

  s->faces_ = static_cast<uint32_t>(segments);
  s->curves_.reserve(curves.vertexCounts.size() + 1);
  s->curves_.push_back({0, 0});
  const bool single = segments == curves.vertexCounts.size();
  if (!single) s->curveOf_.reserve(segments);
  for (uint32_t curve = 0; curve < curves.vertexCounts.size(); ++curve) {
    const int count = curves.vertexCounts[curve];
    const auto n = static_cast<uint32_t>(patchCount(curves.cubic, count, curves.basis.step, curves.periodic));
    const Curve& c = s->curves_.back();
    if (!single) s->curveOf_.insert(s->curveOf_.end(), n, curve);
    s->curves_.push_back({c.firstPoint + static_cast<uint32_t>(count), c.firstSegment + n});
  }
  s->bound_ = s->computeBound();
  if (!usable(s->bound_.min) || !usable(s->bound_.max)) return fail(RiError::Range, "they reach beyond 1e18");
  s->makeTurns();
  s->memory_ = sizeof(CurvesSurface) + s->curves_.capacity() * sizeof(Curve) +
               s->curveOf_.capacity() * sizeof(uint32_t) + s->turns_.capacity() * sizeof(Turn);
  return s;
}

}  // namespace patina
