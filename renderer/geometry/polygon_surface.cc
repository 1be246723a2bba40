// SPDX-License-Identifier: Apache-2.0
// Polygon meshes: evaluation, and primitive variables by the rule of their class.
#include "renderer/geometry/polygon_surface.h"

namespace patina {
namespace {

/// a + (b - a) u + (c - a) v as barycentric sum. In double the products are exact, so that the two ends of an
/// edge are equal partners and the rounded sum does not depend on the direction.
V3f barycentric(const V3f& a, const V3f& b, const V3f& c, double u, double v) {
  const double w = (1 - u) - v;
  return V3f(V3d(a) * w + V3d(b) * u + V3d(c) * v);
}

}  // namespace

uint32_t PolygonSurface::faceCount() const {
  return static_cast<uint32_t>(!sides_ ? faces_.size() : kept_.empty() ? arrays_.faceCount() : kept_.size());
}

FaceShape PolygonSurface::faceShape(uint32_t face) const {
  const bool quad = sides_ ? sides_ == 4 : faces_[face].corner[1] == kQuad;
  return quad ? FaceShape::Quad : FaceShape::Triangle;
}

PolygonSurface::Corners PolygonSurface::cornersOf(uint32_t face) const {
  if (sides_) {
    const uint32_t first = polygonOf(face) * sides_;
    return {{first, first + 1, first + 2, first + 3}, static_cast<int>(sides_)};
  }
  const Face& f = faces_[face];
  if (f.corner[1] != kQuad) return {{f.corner[0], f.corner[1], f.corner[2], 0}, 3};
  const uint32_t first = f.corner[0], turn = f.corner[2];
  return {{first + turn, first + (1 + turn) % 4, first + (2 + turn) % 4, first + (3 + turn) % 4}, 4};
}

void PolygonSurface::corners(uint32_t face, V3f out[4]) const {
  const Corners c = cornersOf(face);
  out[0] = point(c.index[0]);
  out[1] = point(c.index[1]);
  out[2] = point(c.index[c.count == 4 ? 3 : 2]);
  if (c.count == 4) out[3] = point(c.index[2]);
}

void PolygonSurface::cornerPoints(uint32_t face, uint32_t out[4]) const {
  const Corners c = cornersOf(face);
  constexpr int kOrder[4] = {0, 1, 3, 2};
  for (int i = 0; i < c.count; ++i)
    out[i] = static_cast<uint32_t>(arrays_.vertices[c.index[c.count == 4 ? kOrder[i] : i]]);
}

SurfacePoint PolygonSurface::evaluate(uint32_t face, float u, float v) const {
  V3f p[4];
  corners(face, p);
  const bool first = faceShape(face) == FaceShape::Triangle || u + v <= 1;
  const auto x = static_cast<double>(u), y = static_cast<double>(v);
  const V3f P = first ? barycentric(p[0], p[1], p[2], x, y) : barycentric(p[3], p[2], p[1], 1 - x, 1 - y);
  // Slivers need the digits of double; faces without any area were left out when the surface was made.
  const V3d du = first ? V3d(p[1]) - V3d(p[0]) : V3d(p[3]) - V3d(p[2]);
  const V3d dv = first ? V3d(p[2]) - V3d(p[0]) : V3d(p[3]) - V3d(p[1]);
  const V3d n = du.cross(dv);
  return {P, V3f(n / n.length()), V3f(du), V3f(dv)};
}

void PolygonSurface::interpolate(const PrimVar& variable, uint32_t face, float u, float v, float* out) const {
  if (variable.storage == StorageClass::Constant) return copyValue(variable, 0, out);
  if (variable.storage == StorageClass::Uniform) return copyValue(variable, uniformIndex(face), out);
  Corners c = cornersOf(face);
  if (variable.storage == StorageClass::Varying || variable.storage == StorageClass::Vertex)
    for (int i = 0; i < c.count; ++i) c.index[i] = static_cast<uint32_t>(arrays_.vertices[c.index[i]]);
  const auto x = static_cast<double>(u), y = static_cast<double>(v);
  const double triangle[3] = {1 - x - y, x, y};
  const double quad[4] = {(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y};
  const auto count = static_cast<size_t>(c.count);
  blendValues(variable, std::span(c.index, count), std::span(count == 3 ? triangle : quad, count), out);
}

uint32_t PolygonSurface::uniformIndex(uint32_t face) const { return polygonOf(face); }

V2f PolygonSurface::surfaceParameters(uint32_t face, float u, float v) const {
  const V3f p = evaluate(face, u, v).P;
  return {p.x, p.y};
}

V2f PolygonSurface::parameterScale(uint32_t face) const {
  V3f p[4];
  corners(face, p);
  const V3f du = p[1] - p[0], dv = p[2] - p[0];
  return {std::hypot(du.x, du.y), std::hypot(dv.x, dv.y)};
}

}  // namespace patina
