// SPDX-License-Identifier: Apache-2.0
// Bounds of NURBS surfaces, with control points at infinity, too.
#include "renderer/geometry/nurbs_surface.h"
#include "renderer/scene/spline_knots.h"

namespace patina {
namespace {

/// A box around points of a surface, and what is added to it for rounding.
struct Hull {
  V3d low{std::numeric_limits<double>::infinity()}, high{-std::numeric_limits<double>::infinity()};
  double size = 0;

  void add(const V3d& p) {
    for (int c = 0; c < 3; ++c) low[c] = std::min(low[c], p[c]), high[c] = std::max(high[c], p[c]);
    size = std::max({size, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  }
  Box3f box() const {
    Box3f box;
    const double margin = 2 * static_cast<double>(kMachineEpsilon) * size;
    for (int c = 0; c < 3; ++c) {
      box.min[c] = std::nextafter(static_cast<float>(low[c] - margin), -kInfinity);
      box.max[c] = std::nextafter(static_cast<float>(high[c] + margin), kInfinity);
    }
    return box;
  }
};

}  // namespace

/// Where no weight is negative, and those at the corners of a face are not zero, no weight inside of it or
/// along its sides is: what vanishes at a point vanishes wherever fewer basis functions are left.
std::optional<Imath::V2d> NurbsSurface::vanishingWeight() const {
  for (uint32_t face = 0; face < faceCount(); ++face)
    for (int k = 0; k < 4; ++k) {
      const double x = k % 2, y = k / 2;
      // A seam's two ends are one point, which at() does not know.
      const Hpoint h = sum(u_.at(column(face), x), v_.at(row(face), y));
      if (!(h.w >= static_cast<double>(kSmallestWeight)))
        return V2d(u_.parameter(column(face), x), v_.parameter(row(face), y));
    }
  return std::nullopt;
}

/// With positive weights the surface lies in the convex hull of its control points (the NURBS Book, P4.10).
Box3f NurbsSurface::computeBound() const {
  Hull hull;
  if (infinite_) {
    for (uint32_t face = 0; face < faceCount(); ++face)
      forEachBezierPoint(face, [&](const Hpoint& h) { hull.add({h.x / h.w, h.y / h.w, h.z / h.w}); });
    return hull.box();
  }
  for (size_t row = v_.firstPoint(); row <= v_.lastPoint(); ++row)
    for (size_t column = u_.firstPoint(); column <= u_.lastPoint(); ++column) {
      const Hpoint h = control(column, row);
      hull.add({h.x / h.w, h.y / h.w, h.z / h.w});
    }
  return hull.box();
}

/// Control points of the four Bezier surfaces that a face is in its quarters. Of a polynomial that is
/// positive at both ends and has no negative coefficient, those of the two halves are all positive: each of
/// them is a mean that has a share of the end's.
template <class Visit>
void NurbsSurface::forEachBezierPoint(uint32_t face, const Visit& visit) const {
  const size_t nu = u_.order(), nv = v_.order();
  const std::vector<double> mu = u_.halvesAsBezier(column(face)), mv = v_.halvesAsBezier(row(face));
  const size_t firstU = u_.at(column(face), 0).first, firstV = v_.at(row(face), 0).first;
  std::vector<Hpoint> line(2 * nu * nv);  // by row of control points: coefficients along u
  for (size_t j = 0; j < nv; ++j)
    for (size_t a = 0; a < 2 * nu; ++a) {
      Hpoint& h = line[j * 2 * nu + a] = {0, 0, 0, 0};
      for (size_t i = 0; i < nu; ++i) {
        const Hpoint p = control(firstU + i, firstV + j);
        const double w = mu[a * nu + i];
        h.x += w * p.x, h.y += w * p.y, h.z += w * p.z, h.w += w * p.w;
      }
    }
  for (size_t b = 0; b < 2 * nv; ++b)
    for (size_t a = 0; a < 2 * nu; ++a) {
      Hpoint h{0, 0, 0, 0};
      for (size_t j = 0; j < nv; ++j) {
        const Hpoint& p = line[j * 2 * nu + a];
        const double w = mv[b * nv + j];
        h.x += w * p.x, h.y += w * p.y, h.z += w * p.z, h.w += w * p.w;
      }
      visit(h);
    }
}

}  // namespace patina
