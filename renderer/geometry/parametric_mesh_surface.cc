// SPDX-License-Identifier: Apache-2.0
// Patch and PatchMesh: evaluation in double, limits of the normal, bounds by Bezier hulls.
#include "renderer/geometry/parametric_mesh_surface.h"

#include <fmt/format.h>

#include "renderer/geometry/surface_normal.h"
#include "renderer/scene/value_count.h"

namespace patina {

// ---- The basis of one direction
// ----------------------------------------------------------------------------------

SplineBasis::SplineBasis() : points_(2), power_{{{}, {}, {-1, 1, 0, 0}, {1, 0, 0, 0}}}, end_{0, 1, 0, 0} {}

SplineBasis::SplineBasis(const CubicBasis& basis) : points_(4) {
  for (size_t row = 0; row < 4; ++row)
    for (size_t k = 0; k < 4; ++k) {
      const auto m = static_cast<double>(basis.matrix[static_cast<int>(row)][static_cast<int>(k)]);
      const double sixths = std::nearbyint(6 * m);
      power_[row][k] = std::abs(6 * m - sixths) < 1e-5 ? sixths / 6 : m;
    }
  // The end is the neighbour's beginning, if the spline is continuous.
  for (size_t k = 0; k < 4; ++k) end_[k] = power_[0][k] + power_[1][k] + power_[2][k] + power_[3][k];
  const auto step = static_cast<size_t>(std::clamp(basis.step, 1, 4));
  bool& continuous = continuous_;
  const auto next = [&](size_t k) { return k < step ? 0 : power_[3][k - step]; };
  for (size_t k = 0; k < 4; ++k) continuous = continuous && std::abs(end_[k] - next(k)) < 1e-6;
  for (size_t k = 4 - step; k < 4; ++k) continuous = continuous && std::abs(power_[3][k]) < 1e-6;
  if (continuous)
    for (size_t k = 0; k < 4; ++k) end_[k] = next(k);
}

SplineBasis::Weights SplineBasis::at(double t) const {
  if (t == 1) return end_;
  Weights w;
  for (size_t k = 0; k < 4; ++k)
    w[k] = ((power_[0][k] * t + power_[1][k]) * t + power_[2][k]) * t + power_[3][k];
  return w;
}

SplineBasis::Weights SplineBasis::derivative(double t) const {
  Weights w;
  for (size_t k = 0; k < 4; ++k) w[k] = (3 * power_[0][k] * t + 2 * power_[1][k]) * t + power_[2][k];
  return w;
}

SplineBasis::Weights SplineBasis::secondDerivative(double t) const {
  Weights w;
  for (size_t k = 0; k < 4; ++k) w[k] = 6 * power_[0][k] * t + 2 * power_[1][k];
  return w;
}

std::array<SplineBasis::Weights, 4> SplineBasis::bezier() const {
  // From the power form: b0 = d, b1 = d + c/3, b2 = d + 2c/3 + b/3, b3 = a + b + c + d.
  std::array<Weights, 4> out{};
  for (size_t k = 0; k < 4; ++k) {
    const double a = power_[0][k], b = power_[1][k], c = power_[2][k], d = power_[3][k];
    out[0][k] = d;
    out[1][k] = d + c / 3;
    out[2][k] = d + 2 * c / 3 + b / 3;
    out[3][k] = a + b + c + d;
  }
  return out;
}

// ---- Evaluation
// --------------------------------------------------------------------------------------------------

uint32_t ParametricMeshSurface::pointIndex(uint32_t face, int column, int row) const {
  const int i = static_cast<int>(face) % patchesU_, j = static_cast<int>(face) / patchesU_;
  return static_cast<uint32_t>(((j * stepV_ + row) % nv_) * nu_ + (i * stepU_ + column) % nu_);
}

ParametricMeshSurface::Control ParametricMeshSurface::gather(uint32_t face) const {
  Control control;
  for (int row = 0; row < v_.points(); ++row)
    for (int column = 0; column < u_.points(); ++column) {
      const float* p = points_ + size_t{pointIndex(face, column, row)} * (rational_ ? 4 : 3);
      control.point[static_cast<size_t>(4 * row + column)] = {
          static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2]),
          rational_ ? static_cast<double>(p[3]) : 1.0};
    }
  return control;
}

// The order of the additions is the same for the two patches at an edge: terms of weight zero change nothing.
ParametricMeshSurface::Rows ParametricMeshSurface::alongU(const Control& control, const Weights& u) const {
  Rows rows{};
  const auto columns = static_cast<size_t>(u_.points()), count = static_cast<size_t>(v_.points());
  for (size_t row = 0; row < count; ++row)
    for (size_t column = 0; column < columns; ++column) {
      const Hpoint& p = control.point[4 * row + column];
      rows[row].x += u[column] * p.x;
      rows[row].y += u[column] * p.y;
      rows[row].z += u[column] * p.z;
      rows[row].w += u[column] * p.w;
    }
  return rows;
}

ParametricMeshSurface::Hpoint ParametricMeshSurface::alongV(const Rows& rows, const Weights& v) const {
  Hpoint total{0, 0, 0, 0};
  for (size_t row = 0; row < static_cast<size_t>(v_.points()); ++row) {
    total.x += v[row] * rows[row].x;
    total.y += v[row] * rows[row].y;
    total.z += v[row] * rows[row].z;
    total.w += v[row] * rows[row].w;
  }
  return total;
}

ParametricMeshSurface::Jet ParametricMeshSurface::jet(const Control& control, double u, double v) const {
  const Rows rows = alongU(control, u_.at(u)), slopes = alongU(control, u_.derivative(u));
  const Weights wv = v_.at(v);
  const Hpoint h = alongV(rows, wv), du = alongV(slopes, wv), dv = alongV(rows, v_.derivative(v));
  const V3d P = project(h);
  if (!rational_) return {P, {du.x, du.y, du.z}, {dv.x, dv.y, dv.z}};
  return {P, (V3d(du.x, du.y, du.z) - P * du.w) / h.w, (V3d(dv.x, dv.y, dv.z) - P * dv.w) / h.w};
}

SurfacePoint ParametricMeshSurface::evaluate(const Control& control, double u, double v) const {
  const Jet j = jet(control, u, v);
  const V3d n = limitNormal(j.du, j.dv, u, v, [&](double s, double t) {
    const Jet near = jet(control, s, t);
    return near.du.cross(near.dv);
  });
  return {V3f(j.P), V3f(n), V3f(j.du), V3f(j.dv)};
}

SurfacePoint ParametricMeshSurface::evaluate(uint32_t face, float u, float v) const {
  return evaluate(gather(face), static_cast<double>(u), static_cast<double>(v));
}

void ParametricMeshSurface::evaluateMany(uint32_t face, std::span<const V2f> uv,
                                         std::span<SurfacePoint> out) const {
  const Control control = gather(face);
  for (size_t i = 0; i < uv.size(); ++i)
    out[i] = evaluate(control, static_cast<double>(uv[i].x), static_cast<double>(uv[i].y));
}

void ParametricMeshSurface::corners(uint32_t face, V3f out[4]) const {
  const Control control = gather(face);
  for (int k = 0; k < 4; ++k) out[k] = V3f(project(alongV(alongU(control, u_.at(k % 2)), v_.at(k / 2))));
}

void ParametricMeshSurface::evaluateGrid(uint32_t face, std::span<const double> u, std::span<const double> v,
                                         std::span<V3f> out) const {
  thread_local std::vector<Weights> wv;
  wv.resize(v.size());
  for (size_t j = 0; j < v.size(); ++j) wv[j] = v_.at(v[j]);
  const Control control = gather(face);
  for (size_t i = 0; i < u.size(); ++i) {
    const Rows rows = alongU(control, u_.at(u[i]));
    for (size_t j = 0; j < v.size(); ++j) out[j * u.size() + i] = V3f(project(alongV(rows, wv[j])));
  }
}

V2f ParametricMeshSurface::surfaceParameters(uint32_t face, float u, float v) const {
  const auto i = static_cast<float>(static_cast<int>(face) % patchesU_);
  const auto j = static_cast<float>(static_cast<int>(face) / patchesU_);
  return {(i + u) / static_cast<float>(patchesU_), (j + v) / static_cast<float>(patchesV_)};
}

void ParametricMeshSurface::interpolate(const PrimVar& variable, uint32_t face, float u, float v,
                                        float* out) const {
  const auto x = static_cast<double>(u), y = static_cast<double>(v);
  const std::array bilinear{(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y};
  switch (variable.storage) {
    case StorageClass::Constant:
      return copyValue(variable, 0, out);
    case StorageClass::Uniform:
      return copyValue(variable, face, out);
    case StorageClass::Varying: {
      const int rowLength = patchesU_ + (periodicU_ ? 0 : 1), rows = patchesV_ + (periodicV_ ? 0 : 1);
      const int i = static_cast<int>(face) % patchesU_, j = static_cast<int>(face) / patchesU_;
      const int right = (i + 1) % rowLength, up = (j + 1) % rows;
      const auto at = [&](int column, int row) { return static_cast<uint32_t>(row * rowLength + column); };
      return blendValues(variable, std::array{at(i, j), at(right, j), at(i, up), at(right, up)}, bilinear,
                         out);
    }
    case StorageClass::FaceVarying:
    case StorageClass::FaceVertex:
      return blendValues(variable, std::array{4 * face, 4 * face + 1, 4 * face + 2, 4 * face + 3}, bilinear,
                         out);
    case StorageClass::Vertex:
      break;
  }
  const Weights wu = u_.at(x), wv = v_.at(y);
  std::array<uint32_t, 16> index;
  std::array<double, 16> weight;
  size_t n = 0;
  for (int row = 0; row < v_.points(); ++row)
    for (int column = 0; column < u_.points(); ++column, ++n) {
      index[n] = pointIndex(face, column, row);
      weight[n] = wu[static_cast<size_t>(column)] * wv[static_cast<size_t>(row)];
    }
  blendValues(variable, std::span(index).first(n), std::span(weight).first(n), out);
}

// ---- Construction
// ------------------------------------------------------------------------------------------------

bool ParametricMeshSurface::isParallelogram(uint32_t face) const {
  const Control c = gather(face);
  const auto at = [&](size_t k) { return V3d(c.point[k].x, c.point[k].y, c.point[k].z); };
  const V3d twist = at(0) + at(5) - at(1) - at(4);
  const double size = std::max({at(0).length(), at(1).length(), at(4).length(), at(5).length()});
  return twist.length() <= 4 * static_cast<double>(kMachineEpsilon) * size;
}

Box3f ParametricMeshSurface::computeBound() const {
  const auto bu = u_.bezier(), bv = v_.bezier();
  V3d low(std::numeric_limits<double>::infinity()), high(-low);
  double size = 0;
  const auto extend = [&](const V3d& p) {
    for (int c = 0; c < 3; ++c) low[c] = std::min(low[c], p[c]), high[c] = std::max(high[c], p[c]);
    size = std::max({size, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  };
  for (uint32_t face = 0; face < faceCount(); ++face) {
    const Control control = gather(face);
    for (const Weights& u : bu) {
      const Rows rows = alongU(control, u);
      for (const Weights& v : bv) extend(project(alongV(rows, v)));
    }
  }
  Box3f box;
  const double margin = 2 * static_cast<double>(kMachineEpsilon) * size;
  for (int c = 0; c < 3; ++c) {
    box.min[c] = std::nextafter(static_cast<float>(low[c] - margin), -kInfinity);
    box.max[c] = std::nextafter(static_cast<float>(high[c] + margin), kInfinity);
  }
  return box;
}

std::unique_ptr<ParametricMeshSurface> ParametricMeshSurface::make(const ParametricMesh& mesh,
                                                                   const Primitive& primitive,
                                                                   ErrorHandler& errors) {
  const auto fail = [&](RiError code, std::string_view why) {
    errors.report(Severity::Error, code, primitive.where, why);
    return nullptr;
  };
  std::unique_ptr<ParametricMeshSurface> s(new ParametricMeshSurface);
  s->nu_ = mesh.nu;
  s->nv_ = mesh.nv;
  s->periodicU_ = mesh.periodicU;
  s->periodicV_ = mesh.periodicV;
  if (mesh.bicubic) {
    s->u_ = SplineBasis(mesh.basisU);
    s->v_ = SplineBasis(mesh.basisV);
    s->stepU_ = mesh.basisU.step;
    s->stepV_ = mesh.basisV.step;
  }
  s->patchesU_ = patchCount(mesh.bicubic, mesh.nu, s->stepU_, mesh.periodicU);
  s->patchesV_ = patchCount(mesh.bicubic, mesh.nv, s->stepV_, mesh.periodicV);
  if (s->patchesU_ == 0 || s->patchesV_ == 0)
    return fail(RiError::Range,
                fmt::format("{} x {} points make no whole number of {} patches{}", mesh.nu, mesh.nv,
                            mesh.bicubic ? "bicubic" : "bilinear",
                            mesh.bicubic ? fmt::format(" (basis steps {} and {})", s->stepU_, s->stepV_)
                                         : std::string()));

  // Plain or rational points, as many as the mesh has.
  const size_t count = static_cast<size_t>(mesh.nu) * static_cast<size_t>(mesh.nv);
  const PrimVar* points = findVariable(primitive, "Pw");
  s->rational_ = points != nullptr && points->components == 4;
  if (!s->rational_) points = findVariable(primitive, "P");
  if (!points || (!s->rational_ && points->components != 3))
    return fail(RiError::MissingData, "a patch needs \"P\" or \"Pw\"");
  if (points->floats.size() / static_cast<size_t>(points->components) < count || count > size_t{1} << 31)
    return fail(RiError::MissingData,
                fmt::format("a mesh of {} x {} needs {} points, not {}", mesh.nu, mesh.nv, count,
                            points->floats.size() / static_cast<size_t>(points->components)));
  s->points_ = points->floats.data();
  bool allEqual = true;
  for (size_t i = 0; i < count; ++i) {
    const float* p = s->points_ + i * static_cast<size_t>(points->components);
    if (!usable({p[0], p[1], p[2]})) return fail(RiError::Range, fmt::format("point {} is not finite", i));
    if (s->rational_ && !(p[3] > 0 && p[3] <= kLargestCoordinate))
      return fail(RiError::Range, fmt::format("the weight of point {} is not positive", i));
    allEqual = allEqual && std::equal(p, p + points->components, s->points_);
  }
  if (allEqual) return fail(RiError::BadArgument, "the patch has no area; left out");
  for (const CubicBasis* basis : {&mesh.basisU, &mesh.basisV})
    for (int i = 0; i < 16 && mesh.bicubic; ++i)
      if (!(std::abs(basis->matrix[i / 4][i % 4]) <= 1e6f))
        return fail(RiError::BadBasis, "the basis matrix has entries that are not finite or far too large");

  s->bound_ = s->computeBound();
  if (!usable(s->bound_.min) || !usable(s->bound_.max) || s->bound_.isEmpty())
    return fail(RiError::Range, "the patch has points that are not finite");
  s->flat_ = !mesh.bicubic && !s->rational_;
  for (uint32_t face = 0; s->flat_ && face < s->faceCount(); ++face) s->flat_ = s->isParallelogram(face);
  s->memory_ = sizeof(ParametricMeshSurface);
  return s;
}

}  // namespace patina
