// SPDX-License-Identifier: Apache-2.0
// Subdivision surfaces: evaluation of the limit and of variables.
#include "renderer/geometry/subdivision_surface.h"

#include <fmt/format.h>

#include <array>
#include <atomic>

#include "renderer/geometry/polygon_surface.h"
#include "renderer/geometry/subdivision_limit.h"
#include "renderer/geometry/surface_normal.h"

namespace patina {
namespace {

namespace Bfr = OpenSubdiv::Bfr;
using PointDescriptor = Bfr::Surface<double>::PointDescriptor;

/// Barycentric coordinates (of vertices 0, 1, 2) of the kite around vertex `k` of a triangle: its four
/// corners.
std::array<V3d, 4> kite(uint32_t k) {
  V3d corner(0), next(0), previous(0);
  corner[static_cast<int>(k)] = 1;
  next[static_cast<int>((k + 1) % 3)] = 1;
  previous[static_cast<int>((k + 2) % 3)] = 1;
  return {corner, (corner + next) * 0.5, (corner + previous) * 0.5, V3d(1.0 / 3)};
}

/// Control points of a cubic B-spline segment to coefficients of 1, t, t^2, t^3, in place.
void bsplineToPower(V3d* g, size_t stride) {
  const V3d a = g[0], b = g[stride], c = g[2 * stride], d = g[3 * stride];
  g[0] = (a + b * 4.0 + c) / 6.0;
  g[stride] = (c - a) * 0.5;
  g[2 * stride] = (a - b * 2.0 + c) * 0.5;
  g[3 * stride] = (d - a + (b - c) * 3.0) / 6.0;
}

}  // namespace

SubdivisionSurface::SubdivisionSurface(SubdivisionTopology topology, PointView points)
    : topology_(std::move(topology)),
      points_(points),
      // Level 4 keeps 2e-4 of the size of a face beside extraordinary points and 1e-3 where creases end; the
      // default is 2.
      factory_(*topology_.refiner, Bfr::SurfaceFactory::Options().SetApproxLevelSmooth(4)),
      loop_(topology_.refiner->GetSchemeType() == OpenSubdiv::Sdc::SCHEME_LOOP) {
  static std::atomic<uint64_t> lastId = 0;
  id_ = ++lastId;
  const auto level = refiner().GetLevel(0);
  const auto bases = static_cast<uint32_t>(level.GetNumFaces());
  plain_ = !loop_;
  for (uint32_t base = 0; plain_ && base < bases; ++base)
    plain_ = baseSize(base) == 4 && factory_.FaceHasLimitSurface(static_cast<int>(base));
  for (uint32_t base = 0; !plain_ && base < bases; ++base) {
    if (!factory_.FaceHasLimitSurface(static_cast<int>(base))) continue;
    const auto size = static_cast<uint32_t>(baseSize(base));
    if (!loop_ && size == 4)
      faces_.push_back({base, SubdivisionFace::kWhole});
    else
      for (uint32_t part = 0; part < size; ++part) faces_.push_back({base, part});
  }
  faces_.shrink_to_fit();
  // Limit positions are weighted means of the points.
  for (uint32_t base = 0; base < bases; ++base)
    for (int v : level.GetFaceVertices(static_cast<int>(base)))
      bound_.extendBy(points_[static_cast<size_t>(v)]);
  for (int c = 0; c < 3; ++c) {
    bound_.min[c] = std::nextafter(bound_.min[c], -kInfinity);
    bound_.max[c] = std::nextafter(bound_.max[c], kInfinity);
  }
  memory_ = sizeof(SubdivisionSurface) + topology_.memory() + faces_.capacity() * sizeof(SubdivisionFace);
}

uint32_t SubdivisionSurface::faceCount() const {
  return static_cast<uint32_t>(plain_ ? topology_.firstCorner.size() : faces_.size());
}

SubdivisionFace SubdivisionSurface::faceAt(uint32_t face) const {
  return plain_ ? SubdivisionFace{face, SubdivisionFace::kWhole} : faces_[face];
}

uint32_t SubdivisionSurface::uniformIndex(uint32_t face) const {
  const uint32_t base = faceAt(face).base;
  return topology_.requestFace.empty() ? base : topology_.requestFace[base];
}

SubdivisionSurface::Prepared& SubdivisionSurface::prepare(uint32_t base, uint32_t channel) const {
  // A regular face takes 0.5 us to prepare and another 10 us; each is nearly always asked for many times in a
  // row.
  static thread_local std::array<Prepared, 64> recent;
  Prepared& p = recent[(base * 2654435761u + channel) >> 26];
  if (p.owner == id_ && p.base == base && p.channel == channel) return p;
  p.owner = id_;
  p.base = base;
  p.channel = channel;
  p.u = p.v = -1;
  if (channel == kPositions)
    factory_.InitVertexSurface(static_cast<int>(base), &p.surface);
  else
    factory_.InitFaceVaryingSurface(static_cast<int>(base), &p.surface, static_cast<int>(channel));
  p.indices.resize(static_cast<size_t>(p.surface.GetNumControlPoints()));
  p.surface.GetControlPointIndices(p.indices.data());
  if (channel == kPositions) preparePositions(p);
  return p;
}

void SubdivisionSurface::preparePositions(Prepared& p) const {
  const auto point = [&](size_t i) { return V3d(points_[static_cast<size_t>(p.indices[i])]); };
  p.cubic = !loop_ && p.surface.IsRegular() && !p.surface.IsLinear() && p.indices.size() == 16;
  if (!p.cubic) {
    p.points.resize(3 * static_cast<size_t>(p.surface.GetNumPatchPoints()));
    for (size_t i = 0; i < p.indices.size(); ++i) std::copy_n(point(i).getValue(), 3, &p.points[3 * i]);
    return p.surface.ComputePatchPoints(p.points.data(), PointDescriptor(3));
  }
  // A B-spline. Beyond a boundary Bfr repeats point 5; what belongs there continues the inner points straight
  // on.
  std::array<V3d, 16> g;
  for (size_t i = 0; i < 16; ++i) g[i] = point(i);
  const auto phantom = [&](size_t i) { return p.indices[i] == p.indices[5]; };
  const bool low = phantom(1) && phantom(2), high = phantom(13) && phantom(14);
  const bool left = phantom(4) && phantom(8), right = phantom(7) && phantom(11);
  for (size_t i = 0; i < 4; ++i) {
    if (low) g[i] = g[4 + i] * 2.0 - g[8 + i];
    if (high) g[12 + i] = g[8 + i] * 2.0 - g[4 + i];
  }
  for (size_t j = 0; j < 16; j += 4) {
    if (left) g[j] = g[j + 1] * 2.0 - g[j + 2];
    if (right) g[j + 3] = g[j + 2] * 2.0 - g[j + 1];
  }
  for (size_t j = 0; j < 16; j += 4) bsplineToPower(&g[j], 1);
  for (size_t i = 0; i < 4; ++i) bsplineToPower(&g[i], 4);
  p.power = g;
}

SubdivisionSurface::Place SubdivisionSurface::place(const BfrSurface& surface, const SubdivisionFace& face,
                                                    double u, double v) const {
  if (face.part == SubdivisionFace::kWhole) return {{u, v}, {1, 0}, {0, 1}};
  if (!loop_) {
    Place p{{}, {0.5, 0}, {0, 0.5}};
    const double uv[2] = {u, v};
    surface.GetParameterization().ConvertNormalizedSubFaceToCoord(static_cast<int>(face.part), uv, p.uv);
    return p;
  }
  // A triangle's (u, v) are the barycentric coordinates of its second and third vertex.
  const std::array<V3d, 4> c = kite(face.part);
  const V3d at = c[0] * ((1 - u) * (1 - v)) + c[1] * (u * (1 - v)) + c[2] * ((1 - u) * v) + c[3] * (u * v);
  const V3d du = (c[1] - c[0]) * (1 - v) + (c[3] - c[2]) * v,
            dv = (c[2] - c[0]) * (1 - u) + (c[3] - c[1]) * u;
  return {{at.y, at.z}, {du.y, du.z}, {dv.y, dv.z}};
}

SubdivisionSurface::Jet SubdivisionSurface::jet(const Prepared& prepared, const SubdivisionFace& face,
                                                double u, double v) const {
  Jet out;
  if (prepared.cubic) {
    const std::array<V3d, 16>& c = prepared.power;
    std::array<V3d, 4> row, slope;
    for (size_t j = 0; j < 4; ++j) {
      const V3d* g = &c[4 * j];
      row[j] = ((g[3] * u + g[2]) * u + g[1]) * u + g[0];
      slope[j] = (g[3] * (3 * u) + g[2] * 2.0) * u + g[1];
    }
    out.P = ((row[3] * v + row[2]) * v + row[1]) * v + row[0];
    out.du = ((slope[3] * v + slope[2]) * v + slope[1]) * v + slope[0];
    out.dv = (row[3] * (3 * v) + row[2] * 2.0) * v + row[1];
    return out;
  }
  const Place p = place(prepared.surface, face, u, v);
  V3d x, y;
  prepared.surface.Evaluate(p.uv, prepared.points.data(), PointDescriptor(3), out.P.getValue(), x.getValue(),
                            y.getValue());
  out.du = x * p.du[0] + y * p.du[1];
  out.dv = x * p.dv[0] + y * p.dv[1];
  return out;
}

SurfacePoint SubdivisionSurface::evaluate(const Prepared& prepared, const SubdivisionFace& face, double u,
                                          double v) const {
  const Jet j = jet(prepared, face, u, v);
  const V3d n = limitNormal(j.du, j.dv, u, v, [&](double s, double t) {
    const Jet near = jet(prepared, face, s, t);
    return near.du.cross(near.dv);
  });
  return {V3f(j.P), V3f(n), V3f(j.du), V3f(j.dv)};
}

SurfacePoint SubdivisionSurface::evaluate(uint32_t face, float u, float v) const {
  const SubdivisionFace f = faceAt(face);
  return evaluate(prepare(f.base, kPositions), f, static_cast<double>(u), static_cast<double>(v));
}

void SubdivisionSurface::evaluateMany(uint32_t face, std::span<const V2f> uv,
                                      std::span<SurfacePoint> out) const {
  const SubdivisionFace f = faceAt(face);
  const Prepared& prepared = prepare(f.base, kPositions);
  for (size_t i = 0; i < uv.size(); ++i)
    out[i] = evaluate(prepared, f, static_cast<double>(uv[i].x), static_cast<double>(uv[i].y));
}

void SubdivisionSurface::corners(uint32_t face, V3f out[4]) const {
  for (int k = 0; k < 4; ++k) out[k] = evaluate(face, static_cast<float>(k % 2), static_cast<float>(k / 2)).P;
}

// ---- Variables
// ---------------------------------------------------------------------------------------------------

void SubdivisionSurface::interpolate(const PrimVar& variable, uint32_t face, float u, float v,
                                     float* out) const {
  const SubdivisionFace f = faceAt(face);
  const auto x = static_cast<double>(u), y = static_cast<double>(v);
  switch (variable.storage) {
    case StorageClass::Constant:
      return copyValue(variable, 0, out);
    case StorageClass::Uniform:
      return copyValue(variable, uniformIndex(face), out);
    case StorageClass::Vertex:
      return interpolateLimit(variable, kPositions, f, x, y, out);
    case StorageClass::Varying:
      break;
    case StorageClass::FaceVarying:
    case StorageClass::FaceVertex:
      for (uint32_t channel = 0; channel < topology_.channels.size(); ++channel)
        if (topology_.channels[channel].variable == &variable)
          return interpolateLimit(variable, channel, f, x, y, out);
  }
  interpolateLinear(variable, f, x, y, out);
}

void SubdivisionSurface::interpolateLimit(const PrimVar& variable, uint32_t channel,
                                          const SubdivisionFace& face, double u, double v, float* out) const {
  Prepared& p = prepare(face.base, channel);
  const Place at = place(p.surface, face, u, v);
  if (p.u != at.uv[0] || p.v != at.uv[1]) {
    p.stencil.resize(p.indices.size());
    p.surface.EvaluateStencil(at.uv, p.stencil.data());
    p.u = at.uv[0];
    p.v = at.uv[1];
  }
  const auto n = static_cast<size_t>(variable.components);
  std::array<double, 16> small;
  std::vector<double> large(n > small.size() ? n : 0);
  double* const total = large.empty() ? small.data() : large.data();
  std::fill_n(total, n, 0.0);
  for (size_t i = 0; i < p.indices.size(); ++i) {
    auto index = static_cast<size_t>(p.indices[i]);
    if (channel != kPositions) index = topology_.channels[channel].cornerOf[index];
    if ((index + 1) * n > variable.floats.size()) continue;
    for (size_t c = 0; c < n; ++c)
      total[c] += p.stencil[i] * static_cast<double>(variable.floats[index * n + c]);
  }
  for (size_t c = 0; c < n; ++c) out[c] = static_cast<float>(total[c]);
}

void SubdivisionSurface::interpolateLinear(const PrimVar& variable, const SubdivisionFace& face, double u,
                                           double v, float* out) const {
  const auto vertices = refiner().GetLevel(0).GetFaceVertices(static_cast<int>(face.base));
  const auto size = static_cast<uint32_t>(vertices.size());
  const double w[4] = {(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v};
  std::array<double, kMaxValence> weight;
  std::array<uint32_t, kMaxValence> index;
  if (face.part == SubdivisionFace::kWhole) {
    std::copy_n(std::array{w[0], w[1], w[3], w[2]}.begin(), 4, weight.begin());
  } else {
    // The vertex, the middles of its two edges, and the mean of the face.
    std::fill_n(weight.begin(), size, w[3] / size);
    weight[face.part] += w[0] + 0.5 * (w[1] + w[2]);
    weight[(face.part + 1) % size] += 0.5 * w[1];
    weight[(face.part + size - 1) % size] += 0.5 * w[2];
  }
  for (uint32_t i = 0; i < size; ++i)
    index[i] = variable.storage == StorageClass::Varying
                   ? static_cast<uint32_t>(vertices[static_cast<int>(i)])
                   : topology_.firstCorner[face.base] + i;
  blendValues(variable, std::span(index).first(size), std::span(weight).first(size), out);
}

// ---- Construction
// ------------------------------------------------------------------------------------------------

namespace {

/// A mesh that cannot be subdivided, as polygons.
std::unique_ptr<Surface> makePolygons(const SubdivisionMesh& mesh, const Primitive& primitive,
                                      ErrorHandler& errors) {
  return PolygonSurface::make({{}, mesh.vertsPerFace, mesh.vertices}, primitive, errors);
}

}  // namespace

std::unique_ptr<Surface> makeSubdivisionSurface(const SubdivisionMesh& mesh, const Primitive& primitive,
                                                ErrorHandler& errors) {
  const auto fail = [&](RiError code, std::string_view why) {
    errors.report(Severity::Error, code, primitive.where, fmt::format("SubdivisionMesh: {}", why));
    return nullptr;
  };
  const auto points = findPoints(primitive);
  if (!points) return fail(RiError::MissingData, "needs \"P\"");
  size_t corners = 0;
  for (int n : mesh.vertsPerFace) {
    if (n < 0) return fail(RiError::Range, "a face has a negative number of vertices");
    corners += static_cast<size_t>(n);
  }
  if (corners != mesh.vertices.size() || corners >= size_t{1} << 31 || points->size() >= size_t{1} << 31)
    return fail(RiError::Consistency,
                fmt::format("the faces have {} vertices, but {} are given", corners, mesh.vertices.size()));
  for (size_t i = 0; i < points->size(); ++i)
    if (!usable((*points)[i])) return fail(RiError::Range, fmt::format("point {} is not finite", i));
  if (mesh.scheme != "catmull-clark" && mesh.scheme != "loop" && mesh.scheme != "bilinear")
    errors.report(
        Severity::Warning, RiError::BadToken, primitive.where,
        fmt::format("SubdivisionMesh: scheme \"{}\" is not known; \"catmull-clark\" is used", mesh.scheme));

  SubdivisionTopology topology = buildTopology(mesh, primitive, points->size(), errors);
  if (topology.asPolygons) return makePolygons(mesh, primitive, errors);
  if (!topology.refiner) return fail(RiError::BadArgument, "no face is left");
  auto surface = std::make_unique<SubdivisionSurface>(std::move(topology), *points);
  if (surface->faceCount() == 0)
    return fail(RiError::BadArgument,
                "no face has a limit surface: all are holes, or on the boundary of a mesh without the tag "
                "\"interpolateboundary\"");
  return surface;
}

}  // namespace patina
