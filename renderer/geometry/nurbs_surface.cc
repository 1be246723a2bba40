// SPDX-License-Identifier: Apache-2.0
// NuPatch: evaluation, variables, holes.
#include "renderer/geometry/nurbs_surface.h"

#include <fmt/format.h>

#include "renderer/geometry/surface_normal.h"
#include "renderer/scene/spline_knots.h"
#include "renderer/scene/trim_region.h"
#include "renderer/scene/value_count.h"

namespace patina {

// ---- Evaluation -------------------------------------------------------------------------------------------

NurbsSurface::Hpoint NurbsSurface::control(size_t column, size_t row) const {
  const float* p = points_ + (row * nu_ + column) * (rational_ ? 4 : 3);
  return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2]),
          rational_ ? static_cast<double>(p[3]) : 1.0};
}

// One order of additions for all that evaluates points: equal weights of equal points give equal bits.
NurbsSurface::Hpoint NurbsSurface::sum(const Weights& u, const Weights& v) const {
  Hpoint total{0, 0, 0, 0};
  for (size_t j = 0; j < v_.order(); ++j) {
    Hpoint line{0, 0, 0, 0};
    for (size_t i = 0; i < u_.order(); ++i) {
      const Hpoint p = control(u.first + i, v.first + j);
      line.x += u.w[i] * p.x, line.y += u.w[i] * p.y, line.z += u.w[i] * p.z, line.w += u.w[i] * p.w;
    }
    total.x += v.w[j] * line.x, total.y += v.w[j] * line.y;
    total.z += v.w[j] * line.z, total.w += v.w[j] * line.w;
  }
  return total;
}

V3d NurbsSurface::position(const Weights& u, const Weights& v) const {
  const Hpoint h = sum(u, v);
  return rational_ ? V3d(h.x / h.w, h.y / h.w, h.z / h.w) : V3d(h.x, h.y, h.z);
}

NurbsSurface::Jet NurbsSurface::jet(uint32_t face, double u, double v) const {
  const uint32_t i = column(face), j = row(face);
  const Hpoint h = sum(u_.positionAt(i, u), v_.positionAt(j, v));
  const Hpoint du = sum(u_.slopeAt(i, u), v_.at(j, v)), dv = sum(u_.at(i, u), v_.slopeAt(j, v));
  if (!rational_) return {{h.x, h.y, h.z}, {du.x, du.y, du.z}, {dv.x, dv.y, dv.z}};
  // The NURBS Book, equation 4.20 for the first derivatives.
  const V3d P(h.x / h.w, h.y / h.w, h.z / h.w);
  return {P, (V3d(du.x, du.y, du.z) - P * du.w) / h.w, (V3d(dv.x, dv.y, dv.z) - P * dv.w) / h.w};
}

SurfacePoint NurbsSurface::evaluate(uint32_t face, float u, float v) const {
  const double x = static_cast<double>(u), y = static_cast<double>(v);
  const Jet at = jet(face, x, y);
  const V3d n = limitNormal(at.du, at.dv, x, y, [&](double s, double t) {
    const Jet near = jet(face, s, t);
    return near.du.cross(near.dv);
  });
  // Weights of very different size make derivatives that float does not hold.
  const auto toFloat = [](const V3d& d) {
    const auto cut = [](double c) {
      return static_cast<float>(std::clamp<double>(c, -static_cast<double>(kLargestCoordinate),
                                                   static_cast<double>(kLargestCoordinate)));
    };
    return V3f(cut(d.x), cut(d.y), cut(d.z));
  };
  return {V3f(at.P), V3f(n), toFloat(at.du), toFloat(at.dv)};
}

void NurbsSurface::corners(uint32_t face, V3f out[4]) const {
  for (int k = 0; k < 4; ++k)
    out[k] = V3f(position(u_.positionAt(column(face), k % 2), v_.positionAt(row(face), k / 2)));
}

void NurbsSurface::evaluateGrid(uint32_t face, std::span<const double> u, std::span<const double> v,
                                std::span<V3f> out) const {
  thread_local std::vector<Weights> wu;
  wu.resize(u.size());
  for (size_t i = 0; i < u.size(); ++i) wu[i] = u_.positionAt(column(face), u[i]);
  for (size_t j = 0; j < v.size(); ++j) {
    const Weights wv = v_.positionAt(row(face), v[j]);
    for (size_t i = 0; i < u.size(); ++i) out[j * u.size() + i] = V3f(position(wu[i], wv));
  }
}

// ---- Parameters, variables, holes -------------------------------------------------------------------------

V2f NurbsSurface::surfaceParameters(uint32_t face, float u, float v) const {
  return {static_cast<float>(u_.parameter(column(face), static_cast<double>(u))),
          static_cast<float>(v_.parameter(row(face), static_cast<double>(v)))};
}

V2f NurbsSurface::textureParameters(uint32_t face, float u, float v) const {
  const auto share = [](const SplineDirection& s, uint32_t interval, float x) {
    return static_cast<float>((s.parameter(interval, static_cast<double>(x)) - s.begin()) /
                              (s.end() - s.begin()));
  };
  return {share(u_, column(face), u), share(v_, row(face), v)};
}

V2f NurbsSurface::parameterScale(uint32_t face) const {
  return {static_cast<float>(u_.length(column(face)) / (u_.end() - u_.begin())),
          static_cast<float>(v_.length(row(face)) / (v_.end() - v_.begin()))};
}

bool NurbsSurface::isHole(uint32_t face, float u, float v) const {
  if (!trim_) return false;
  return trim_->contains(u_.parameter(column(face), static_cast<double>(u)),
                         v_.parameter(row(face), static_cast<double>(v))) != keepInside_;
}

void NurbsSurface::interpolate(const PrimVar& variable, uint32_t face, float u, float v, float* out) const {
  const uint32_t i = column(face), j = row(face);
  const double x = static_cast<double>(u), y = static_cast<double>(v);
  switch (variable.storage) {
    case StorageClass::Constant:
      return copyValue(variable, 0, out);
    case StorageClass::Uniform:
      return copyValue(variable, uniformIndex(face), out);
    case StorageClass::Vertex:
      break;
    default: {
      const double a = u_.inSegment(i, x), b = v_.inSegment(j, y);
      const std::array bilinear{(1 - a) * (1 - b), a * (1 - b), (1 - a) * b, a * b};
      std::array<uint32_t, 4> index;
      if (variable.storage == StorageClass::Varying) {
        const uint32_t corner = v_.segment(j) * (segmentsU_ + 1) + u_.segment(i);
        index = {corner, corner + 1, corner + segmentsU_ + 1, corner + segmentsU_ + 2};
      } else {
        const uint32_t first = 4 * uniformIndex(face);
        index = {first, first + 1, first + 2, first + 3};
      }
      return blendValues(variable, index, bilinear, out);
    }
  }
  const Weights wu = u_.at(i, x), wv = v_.at(j, y);
  std::array<uint32_t, kMaxSplineOrder * kMaxSplineOrder> index;
  std::array<double, kMaxSplineOrder * kMaxSplineOrder> weight;
  size_t n = 0;
  double total = 0;
  for (size_t r = 0; r < v_.order(); ++r)
    for (size_t c = 0; c < u_.order(); ++c, ++n) {
      index[n] = static_cast<uint32_t>((wv.first + r) * nu_ + wu.first + c);
      weight[n] = wu.w[c] * wv.w[r];
      if (rational_) weight[n] *= control(wu.first + c, wv.first + r).w;
      total += weight[n];
    }
  if (rational_)
    for (size_t k = 0; k < n; ++k) weight[k] /= total;
  blendValues(variable, std::span(index).first(n), std::span(weight).first(n), out);
}

// ---- Construction -----------------------------------------------------------------------------------------

void NurbsSurface::closeSeams() {
  const auto same = [&](size_t columnA, size_t rowA, size_t columnB, size_t rowB) {
    const Hpoint a = control(columnA, rowA), b = control(columnB, rowB);
    return a.x == b.x && a.y == b.y && a.z == b.z && a.w == b.w;
  };
  if (const auto seam = u_.seam()) {
    bool closed = true;
    for (size_t row = v_.firstPoint(); row <= v_.lastPoint() && closed; ++row)
      for (size_t k = 0; k < seam->count && closed; ++k)
        closed = same(seam->begin + k, row, seam->end + k, row);
    if (closed) u_.close();
  }
  if (const auto seam = v_.seam()) {
    bool closed = true;
    for (size_t k = 0; k < seam->count && closed; ++k)
      for (size_t column = u_.firstPoint(); column <= u_.lastPoint() && closed; ++column)
        closed = same(column, seam->begin + k, column, seam->end + k);
    if (closed) v_.close();
  }
}

bool NurbsSurface::isParallelogram(uint32_t face) const {
  V3d c[4];
  for (int k = 0; k < 4; ++k)
    c[k] = position(u_.positionAt(column(face), k % 2), v_.positionAt(row(face), k / 2));
  const double size = std::max({c[0].length(), c[1].length(), c[2].length(), c[3].length()});
  return (c[0] + c[3] - c[1] - c[2]).length() <= 4 * static_cast<double>(kMachineEpsilon) * size;
}

std::unique_ptr<NurbsSurface> NurbsSurface::make(const NurbsPatch& patch, const Primitive& primitive,
                                                 ErrorHandler& errors) {
  const auto fail = [&](RiError code, std::string_view why) {
    errors.report(Severity::Error, code, primitive.where, fmt::format("NuPatch is left out: {}", why));
    return nullptr;
  };
  for (const auto& [side, spline] : {std::pair('u', &patch.u), std::pair('v', &patch.v)})
    if (const auto problem = splineProblem(*spline))
      return fail(problem->code, fmt::format("along {}, {}", side, problem->text));

  // Plain or rational points, as many as the knots ask for.
  std::unique_ptr<NurbsSurface> s(new NurbsSurface);
  const PrimVar* points = findVariable(primitive, "Pw");
  s->rational_ = points != nullptr && points->components == 4;
  if (!s->rational_) points = findVariable(primitive, "P");
  if (!points || (!s->rational_ && points->components != 3))
    return fail(RiError::MissingData, "it needs \"P\" or \"Pw\"");
  const auto components = static_cast<size_t>(points->components);
  const size_t count = static_cast<size_t>(patch.u.count) * static_cast<size_t>(patch.v.count);
  if (points->floats.size() / components < count || count > size_t{1} << 29)
    return fail(RiError::MissingData, fmt::format("{} x {} control points are {}, not {}", patch.u.count,
                                                  patch.v.count, count, points->floats.size() / components));
  s->points_ = points->floats.data();
  bool allEqual = true;
  for (size_t i = 0; i < count; ++i) {
    const float* p = s->points_ + i * components;
    if (!usable({p[0], p[1], p[2]}))
      return fail(RiError::Range, fmt::format("point {} is not finite, or beyond 1e18", i));
    if (s->rational_ && p[3] != 0 && !usableWeight(p[3]))
      return fail(RiError::Range, fmt::format("the weight of point {} is not 0, or between {:g} and {:g}", i,
                                              kSmallestWeight, kLargestWeight));
    s->infinite_ = s->infinite_ || (s->rational_ && p[3] == 0);
    allEqual = allEqual && std::equal(p, p + components, s->points_);
  }
  if (allEqual) return fail(RiError::BadArgument, "it has no area");

  s->u_ = SplineDirection(patch.u);
  s->v_ = SplineDirection(patch.v);
  s->nu_ = static_cast<size_t>(patch.u.count);
  s->segmentsU_ = static_cast<uint32_t>(1 + patch.u.count - patch.u.order);
  s->trim_ = patch.trim;
  s->keepInside_ = patch.keepInside;
  if (s->infinite_)
    if (const auto at = s->vanishingWeight())
      return fail(RiError::Range,
                  fmt::format("its points are infinite at u = {:g}, v = {:g}, where only weights of 0 count",
                              at->x, at->y));
  s->closeSeams();
  s->bound_ = s->computeBound();
  if (!usable(s->bound_.min) || !usable(s->bound_.max))
    return fail(RiError::Range, "it has points beyond 1e18");
  s->flat_ = patch.u.order == 2 && patch.v.order == 2 && !s->rational_;
  for (uint32_t face = 0; s->flat_ && face < s->faceCount(); ++face) s->flat_ = s->isParallelogram(face);
  s->memory_ = sizeof(NurbsSurface) + (patch.u.knots.size() + patch.v.knots.size()) * 3 * sizeof(double);
  if (s->trim_) s->memory_ += s->trim_->memory() / static_cast<size_t>(s->trim_.use_count());
  return s;
}

}  // namespace patina
