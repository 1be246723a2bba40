// SPDX-License-Identifier: Apache-2.0
// Walls in an octree of surfels: planes that rays can be traced against, with radiance that is linear in
// them.
#include "renderer/base/sampling.h"
#include "renderer/points/point_tree.h"

namespace patina {
namespace {

/// A plane's normals are within 2.6 degrees, and its surfels no farther from it than this part of the node's
/// radius.
constexpr float kPlaneSpread = 0.045f, kThick = 0.02f;
/// Part of a node's radius by which rays may be beside what is in it.
constexpr float kSlack = 1e-3f;
/// A plane is covered when the pieces' areas are this part of its region's; beside the border, where pieces
/// reach out by parts of their size.
constexpr float kCovered = 0.95f, kBorder = 0.75f, kCurvedBorder = -0.1f, kFlat = 2e-3f;
/// ... which at the border of triangles is no more than this part of the region.
constexpr float kTornBorder = 0.3f;

PointTree::Plane planeOf(const Surfel& s) {
  PointTree::Plane plane;
  plane.P = plane.center = s.P, plane.N = s.N, plane.U = s.U, plane.V = s.N.cross(s.U);
  plane.halfU = std::min(s.halfU, s.radius), plane.halfV = std::min(s.halfV, s.radius);
  plane.box = Box3f(s.P - s.bound(), s.P + s.bound());
  plane.hasTriangles = s.isTriangle();
  if (plane.hasTriangles) {
    Imath::Box2f range;
    plane.box.makeEmpty();
    for (const V2f& corner : s.corners()) {
      range.extendBy(corner);
      plane.box.extendBy(s.P + plane.U * corner.x + plane.V * corner.y);
    }
    const V2f middle = range.center(), half = range.size() / 2;
    plane.center = s.P + plane.U * middle.x + plane.V * middle.y;
    plane.halfU = half.x, plane.halfV = half.y;
  }
  plane.piece = std::sqrt(s.area);
  plane.frontArea = s.area, plane.backArea = s.hasBack ? s.area : 0;
  plane.front = s.front, plane.back = s.back;
  return plane;
}

std::array<V3f, 4> cornersOf(const PointTree::Plane& plane) {
  const V3f u = plane.U * plane.halfU, v = plane.V * plane.halfV;
  return {plane.center - u - v, plane.center + u - v, plane.center + u + v, plane.center - u + v};
}

/// Two planes as one; false: they are not.
bool unite(PointTree::Plane& a, const PointTree::Plane& b, float thickness) {
  constexpr float kQuick = 0.99f;
  if (a.N.dot(b.N) < kQuick) return false;
  PointTree::Plane sum;
  sum.frontArea = a.frontArea + b.frontArea, sum.backArea = a.backArea + b.backArea;
  sum.piece = std::max(a.piece, b.piece);
  sum.hasTriangles = a.hasTriangles || b.hasTriangles;
  const float share = b.frontArea / sum.frontArea;
  sum.N = normalizedOr(lerp(share, a.N, b.N), a.N);
  sum.P = lerp(share, a.P, b.P);
  for (const PointTree::Plane* of : {static_cast<const PointTree::Plane*>(&a), &b}) {
    const float sine = of->N.cross(sum.N).length();  // of small angles, where the arc cosine is rounded off
    sum.spread = std::max(sum.spread, sine + of->spread);
    sum.height = std::max(sum.height, std::abs((of->P - sum.P).dot(sum.N)) + of->height);
  }
  if (sum.spread > kPlaneSpread || sum.height > thickness) return false;
  sum.front = lerp(share, a.front, b.front);
  if (sum.backArea > 0) sum.back = lerp(b.backArea / sum.backArea, a.back, b.back);
  sum.U = normalizedOr(a.U - sum.N * sum.N.dot(a.U), a.U);
  sum.V = sum.N.cross(sum.U);
  float u0 = kInfinity, u1 = -kInfinity, v0 = kInfinity, v1 = -kInfinity;
  for (const PointTree::Plane* of : {static_cast<const PointTree::Plane*>(&a), &b})
    for (const V3f& corner : cornersOf(*of)) {
      const float u = (corner - sum.P).dot(sum.U), v = (corner - sum.P).dot(sum.V);
      u0 = std::min(u0, u), u1 = std::max(u1, u), v0 = std::min(v0, v), v1 = std::max(v1, v);
    }
  sum.center = sum.P + sum.U * ((u0 + u1) / 2) + sum.V * ((v0 + v1) / 2);
  sum.halfU = (u1 - u0) / 2, sum.halfV = (v1 - v0) / 2;
  sum.box = a.box;
  sum.box.extendBy(b.box);
  a = sum;
  return true;
}

/// Whether pieces are everywhere in the region that rays meet: the rectangle as far as it is in the box.
bool isCovered(const PointTree::Plane& plane) {
  std::vector<V3f> region, rest;
  for (const V3f& corner : cornersOf(plane)) region.push_back(corner);
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0f, 1.0f}) {
      const float border = side * (side < 0 ? plane.box.min : plane.box.max)[axis] + plane.slack;
      rest.clear();
      for (size_t k = 0; k < region.size(); ++k) {  // Sutherland and Hodgman 1974
        const V3f &p = region[k], &q = region[(k + 1) % region.size()];
        const float a = border - side * p[axis], b = border - side * q[axis];
        if (a >= 0) rest.push_back(p);
        if ((a < 0) != (b < 0)) rest.push_back(lerp(a / (a - b), p, q));
      }
      region.swap(rest);
    }
  V3f cross(0);
  float around = 0;
  for (size_t k = 0; k < region.size(); ++k) {
    const V3f &p = region[k], &q = region[(k + 1) % region.size()];
    cross += (p - plane.center).cross(q - plane.center);
    around += (q - p).length();
  }
  // Beside a cut through a flat wall there is more of it; a curved surface may end there, seen from its side.
  const float border = plane.spread < kFlat ? kBorder : kCurvedBorder;
  const float area = cross.length() / 2;
  float missing = border * around * plane.piece;
  // A rectangle around a triangle is half empty.
  if (plane.hasTriangles) missing = std::min(missing, kTornBorder * area);
  return plane.frontArea >= kCovered * area - missing;
}

/// Part of a plane's mean radiance by which its surfels' is off what is linear, all in all, where it jumps.
constexpr double kJump = 0.1;

}  // namespace

void PointTree::findPlanes(Node& node, bool isFirst) {
  std::array<Plane, kMostPlanes> found;
  uint8_t count = 0;
  const float thickness = kThick * node.radius;
  const auto add = [&](const Plane& plane) {
    for (uint8_t k = 0; k < count; ++k)
      if (unite(found[k], plane, thickness)) return true;
    if (count == kMostPlanes) return false;
    found[count++] = plane;
    return true;
  };
  node.planeCount = 0, node.isCovered = true;
  if (node.isLeaf()) {
    for (uint32_t k = node.first; k < node.first + node.count; ++k) {
      if (!add(planeOf(surfels_[k]))) return;
    }
  } else {
    for (uint32_t child = node.children; child < node.children + node.childCount; ++child) {
      const Node& c = nodes_[child];
      if (c.planeCount == 0) return;
      for (uint32_t k = c.firstPlane; k < c.firstPlane + c.planeCount; ++k)
        if (!add(planes_[k])) return;
    }
  }
  for (uint8_t k = 0; k < count; ++k) {
    found[k].slack = found[k].height + kSlack * node.radius;
    node.isCovered = node.isCovered && isCovered(found[k]);
  }
  const auto planes = std::span(found).first(count);
  fitSlopes(node, planes);
  if (isFirst) node.isParted = count > 1 && jumps(node, planes);
  node.firstPlane = static_cast<uint32_t>(planes_.size()), node.planeCount = count;
  planes_.insert(planes_.end(), found.begin(), found.begin() + count);
}

/// The plane that a surfel of a node is in.
size_t PointTree::planeWith(const Node& node, std::span<const Plane> planes, const Surfel& s) {
  size_t of = 0;
  float best = kInfinity;
  for (size_t k = 0; k < planes.size(); ++k) {
    const float off = (1 - planes[k].N.dot(s.N)) * node.radius + std::abs(planes[k].N.dot(s.P - planes[k].P));
    if (off < best) best = off, of = k;
  }
  return of;
}

/// Least squares, weighted with areas. A wall's radiance is seldom constant over what is one node from afar,
/// and what is near counts for more: its mean alone would be wrong by as much as it changes.
void PointTree::fitSlopes(const Node& node, std::span<Plane> planes) const {
  struct Sums {
    Frame frame{V3f(0, 0, 1)};
    double xx = 0, xy = 0, yy = 0;
    std::array<V3d, 2> x{V3d(0), V3d(0)}, y{V3d(0), V3d(0)};  ///< times radiance of both sides
    float reachX = 0, reachY = 0;                             ///< of surfels' middles
    int count = 0;
  };
  std::array<Sums, kMostPlanes> all;
  for (size_t k = 0; k < planes.size(); ++k) all[k].frame = Frame(planes[k].N);
  const auto own = std::span(surfels_).subspan(node.first, node.count);
  for (const Surfel& s : own) {
    const size_t of = planeWith(node, planes, s);
    Sums& sums = all[of];
    const V3f d = sums.frame.toLocal(s.P - planes[of].P);
    const double a = s.area, x = d.x, y = d.y;
    sums.xx += a * x * x, sums.xy += a * x * y, sums.yy += a * y * y;
    sums.x[0] += V3d(s.front - planes[of].front) * (a * x),
        sums.y[0] += V3d(s.front - planes[of].front) * (a * y);
    sums.x[1] += V3d(s.back - planes[of].back) * (a * x),
        sums.y[1] += V3d(s.back - planes[of].back) * (a * y);
    sums.reachX = std::max(sums.reachX, std::abs(d.x) + s.radius);
    sums.reachY = std::max(sums.reachY, std::abs(d.y) + s.radius);
    ++sums.count;
  }
  constexpr double kThin = 1e-3;  // part of the trace's square that the determinant has: not all on a line
  for (size_t k = 0; k < planes.size(); ++k) {
    const Sums& sums = all[k];
    const double trace = sums.xx + sums.yy, determinant = sums.xx * sums.yy - sums.xy * sums.xy;
    if (sums.count < 3 || !(determinant > kThin * trace * trace)) continue;
    for (const bool back : {false, true}) {
      const Rgb& mean = back ? planes[k].back : planes[k].front;
      const V3d &bx = sums.x[back ? 1 : 0], &by = sums.y[back ? 1 : 0];
      for (int c = 0; c < 3; ++c) {
        const auto x = static_cast<float>((sums.yy * bx[c] - sums.xy * by[c]) / determinant),
                   y = static_cast<float>((sums.xx * by[c] - sums.xy * bx[c]) / determinant);
        const float most = std::abs(x) * sums.reachX + std::abs(y) * sums.reachY;
        const float scale = most > mean[c] ? mean[c] / most : 1;
        (back ? planes[k].backSlope : planes[k].frontSlope)[static_cast<size_t>(c)] =
            (sums.frame.x * x + sums.frame.y * y) * scale;
      }
    }
  }
}

/// Whether the radiance of a node's planes is far from linear.
bool PointTree::jumps(const Node& node, std::span<const Plane> planes) const {
  std::array<double, kMostPlanes> off{}, total{};  // squares, of the larger side; times areas
  for (const Surfel& s : std::span(surfels_).subspan(node.first, node.count)) {
    const size_t of = planeWith(node, planes, s);
    const Plane& plane = planes[of];
    const V3f d = s.P - plane.P;
    for (const bool back : {false, true}) {
      if (back && !s.hasBack) continue;
      const Rgb& mean = back ? plane.back : plane.front;
      const auto& slope = back ? plane.backSlope : plane.frontSlope;
      const Rgb fit = mean + Rgb(slope[0].dot(d), slope[1].dot(d), slope[2].dot(d));
      off[of] += static_cast<double>(s.area * ((back ? s.back : s.front) - fit).length2());
      total[of] += static_cast<double>(s.area * mean.length2());
    }
  }
  for (size_t k = 0; k < planes.size(); ++k)
    if (off[k] > kJump * kJump * total[k]) return true;
  return false;
}

}  // namespace patina
