// SPDX-License-Identifier: Apache-2.0
// Ribbons.
#include "renderer/geometry/curves_surface.h"

#include "renderer/scene/value_count.h"

namespace patina {

std::unique_ptr<CurvesSurface> CurvesSurface::make(const CurveSet& curves, const Primitive& primitive,
                                                   const Viewpoint& view, ErrorHandler& errors) {
  auto surface = std::unique_ptr<CurvesSurface>(new CurvesSurface);
  const auto points = findPoints(primitive);
  const auto fail = [&](std::string_view message) {
    errors.report(Severity::Error, RiError::BadArgument, primitive.where, message);
    return nullptr;
  };
  if (!points) return fail("Curves are left out: they need \"P\"");
  surface->points_ = *points;
  surface->periodic_ = curves.periodic;
  surface->view_ = view;
  if (curves.cubic) {
    surface->basis_ = SplineBasis(curves.basis);
    surface->step_ = static_cast<uint32_t>(std::max(curves.basis.step, 1));
  }
  size_t first = 0, varying = 0;
  for (uint32_t curve = 0; curve < curves.vertexCounts.size(); ++curve) {
    const int count = curves.vertexCounts[curve];
    const int segments = patchCount(curves.cubic, count, static_cast<int>(surface->step_), curves.periodic);
    for (int k = 0; k < segments; ++k)
      surface->segments_.push_back({curve, static_cast<uint32_t>(first), static_cast<uint32_t>(count),
                                    static_cast<uint32_t>(varying), static_cast<uint32_t>(segments),
                                    static_cast<uint32_t>(k)});
    first += static_cast<size_t>(std::max(count, 0));
    varying += static_cast<size_t>(segments + (curves.periodic ? 0 : 1));
  }
  if (first > points->size()) return fail("Curves are left out: fewer points than their vertex counts say");
  for (size_t k = 0; k < first; ++k)
    if (!usable((*points)[k])) return fail("Curves are left out: a point is not finite, or beyond 1e18");
  if (surface->segments_.empty()) return fail("Curves are left out: no curve has enough points");

  for (const PrimVar& variable : primitive.variables) {
    if (variable.components == 1 && variable.name == "width") surface->width_ = &variable;
    if (variable.components == 1 && variable.name == "constantwidth" && !variable.floats.empty())
      surface->constantWidth_ = variable.floats[0];
    if (variable.components == 3 && variable.name == "N") surface->normal_ = &variable;
  }
  // Bezier hulls hold the curves; widths widen them.
  float widest = std::abs(surface->constantWidth_);
  if (surface->width_) {
    widest = 0;
    for (const float w : surface->width_->floats) widest = std::max(widest, std::abs(w));
  }
  if (!(widest <= kLargestCoordinate))
    return fail("Curves are left out: a width is not finite, or beyond 1e18");
  const auto hull = surface->basis_.bezier();
  const int n = surface->basis_.points();
  for (const Segment& segment : surface->segments_)
    for (int row = 0; row < n; ++row) {
      V3d p(0, 0, 0);
      for (int k = 0; k < n; ++k)
        p += V3d(surface->points_[surface->point(segment, static_cast<uint32_t>(k))]) *
             hull[static_cast<size_t>(row)][static_cast<size_t>(k)];
      surface->bound_.extendBy(V3f(p));
    }
  surface->bound_.min -= V3f(widest / 2);
  surface->bound_.max += V3f(widest / 2);
  surface->memory_ = surface->segments_.capacity() * sizeof(Segment);
  return surface;
}

void CurvesSurface::weigh(const PrimVar& variable, const Segment& segment, float v, float* out) const {
  switch (variable.storage) {
    case StorageClass::Constant:
      copyValue(variable, 0, out);
      return;
    case StorageClass::Uniform:
      copyValue(variable, segment.curve, out);
      return;
    case StorageClass::Vertex: {
      const auto w = basis_.at(static_cast<double>(v));
      std::array<uint32_t, 4> index{};
      const auto n = static_cast<size_t>(basis_.points());
      for (size_t k = 0; k < n; ++k) index[k] = point(segment, static_cast<uint32_t>(k));
      blendValues(variable, std::span(index).first(n), std::span(w).first(n), out);
      return;
    }
    default: {
      const uint32_t ends = segment.inCurve + (periodic_ ? 0 : 1);
      const std::array<uint32_t, 2> index{segment.firstVarying + segment.index,
                                          segment.firstVarying + (segment.index + 1) % ends};
      const std::array<double, 2> w{1 - static_cast<double>(v), static_cast<double>(v)};
      blendValues(variable, index, w, out);
    }
  }
}

CurvesSurface::Line CurvesSurface::line(const Segment& segment, float v) const {
  Line line{{0, 0, 0}, {0, 0, 0}, constantWidth_, {0, 0, 0}};
  const auto w = basis_.at(static_cast<double>(v)), d = basis_.derivative(static_cast<double>(v));
  for (int k = 0; k < basis_.points(); ++k) {
    const V3d p(points_[point(segment, static_cast<uint32_t>(k))]);
    line.P += p * w[static_cast<size_t>(k)];
    line.tangent += p * d[static_cast<size_t>(k)];
  }
  if (basis_.points() == 2) line.tangent = V3d(points_[point(segment, 1)]) - V3d(points_[point(segment, 0)]);
  if (line.tangent.length2() == 0)  // doubled control points: the chord has the direction
    line.tangent = V3d(points_[point(segment, static_cast<uint32_t>(basis_.points() - 1))]) -
                   V3d(points_[point(segment, 0)]);
  if (width_) weigh(*width_, segment, v, &line.width);
  line.normal = view_.perspective ? view_.eye - V3f(line.P) : -view_.direction;
  if (normal_) weigh(*normal_, segment, v, &line.normal.x);
  return line;
}

SurfacePoint CurvesSurface::evaluate(uint32_t face, float u, float v) const {
  const Line l = line(segments_[face], v);
  const V3f tangent = normalizedOr(V3f(l.tangent), V3f(0, 0, 1));
  V3f facing = l.normal - tangent * l.normal.dot(tangent);
  facing = normalizedOr(facing, Frame(tangent).x);
  const V3f side = tangent.cross(facing);  // side x tangent = facing
  SurfacePoint p;
  p.P = V3f(l.P) + side * ((u - 0.5f) * l.width);
  p.dPdu = side * l.width;
  p.dPdv = V3f(l.tangent);
  p.N = facing;
  return p;
}

void CurvesSurface::corners(uint32_t face, V3f out[4]) const {
  out[0] = evaluate(face, 0, 0).P, out[1] = evaluate(face, 1, 0).P;
  out[2] = evaluate(face, 0, 1).P, out[3] = evaluate(face, 1, 1).P;
}

void CurvesSurface::interpolate(const PrimVar& variable, uint32_t face, float, float v, float* out) const {
  weigh(variable, segments_[face], v, out);
}

V2f CurvesSurface::surfaceParameters(uint32_t face, float u, float v) const {
  const Segment& segment = segments_[face];
  return {u, (static_cast<float>(segment.index) + v) / static_cast<float>(segment.inCurve)};
}

}  // namespace patina
