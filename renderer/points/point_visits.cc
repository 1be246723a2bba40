// SPDX-License-Identifier: Apache-2.0
// Which nodes of an octree a raster looks at: from near to far, but for what is hidden.
#include <bit>

#include "renderer/points/point_raster.h"

namespace patina {
namespace {

/// Shells are quarters of octaves: the exponent's bits and two of the mantissa's. What is nearer than 2^-40
/// is in the first.
constexpr uint32_t kBits = 21, kFirst = (127 - 40) << 2;
/// What is behind a pixel that is covered so far is not looked for: it would add no more than the rest.
constexpr float kHides = 0.99f;
/// The solid angle of a node that is drawn as a square, in pixels of the top's middle.
constexpr float kOutline = 2;
/// ... and of one that stands for what is lit and what is dark, where walls meet.
constexpr float kPart = 0.25f;

}  // namespace

/// Below the horizon, or in the plane of it.
bool PointRaster::isBelow(const PointTree& tree, const PointTree::Node& node) const {
  const V3f& up = frame_.z;
  if (up.dot(node.center - P_) + std::min(abs(up).dot(node.half), node.radius) <= nearest_) return true;
  if (node.planeCount != 1) return false;
  const PointTree::Plane& plane = tree.planes()[node.firstPlane];
  const float sine = up.cross(plane.N).length();
  return up.dot(plane.P - P_) + 2 * node.radius * sine + plane.height <= nearest_;
}

size_t PointRaster::shellOf(float distance) {
  const uint32_t at = std::bit_cast<uint32_t>(std::max(distance, 0.0f)) >> kBits;
  return std::min<size_t>(at > kFirst ? at - kFirst : 0, kShells - 1);
}

void PointRaster::push(const PointTree& tree, uint32_t index, size_t shell) {
  const PointTree::Node& node = tree.nodes()[index];
  if (isBelow(tree, node)) return;
  const V3f local = frame_.toLocal(node.center - P_);
  const float distance2 = local.length2();
  const float near = std::sqrt(distance2) - node.radius;
  shells_[std::max(shell, shellOf(near))].nodes.push_back({index, distance2, local});
}

/// Shell by shell from the place on, so that what stands behind full pixels is not looked at; the distance of
/// the nearest that is drawn.
float PointRaster::lookAround(const PointTree& tree) {
  float nearest = kInfinity;
  if (tree.empty()) return nearest;
  push(tree, 0, 0);
  // Masks of full pixels are worth their time where many nodes are left.
  constexpr size_t kManyNodes = 16;
  for (size_t k = 0; k < kShells; ++k) {
    Shell& shell = shells_[k];
    const bool mayCull = shell.nodes.size() >= kManyNodes;
    if (mayCull) findFull(k);
    while (!shell.nodes.empty()) {
      const Visit visit = shell.nodes.back();
      shell.nodes.pop_back();
      if (mayCull && isHidden(visit, tree.nodes()[visit.node].radius)) continue;
      look(tree, visit, k);
      ++looked_;
    }
    if (shell.items.empty()) continue;
    std::sort(shell.items.begin(), shell.items.end(), [](const Item& a, const Item& b) {
      return std::pair(a.distance, a.isInner) < std::pair(b.distance, b.isInner);
    });
    nearest = std::min(nearest, shell.items.front().distance);
    for (const Item& item : shell.items) draw(item);
    shell.items.clear();
  }
  return nearest;
}

/// Marks pixels that nothing in a shell, or farther, can be seen in.
void PointRaster::findFull(size_t shell) {
  const float from = shell == 0 ? 0 : std::bit_cast<float>((static_cast<uint32_t>(shell) + kFirst) << kBits);
  size_t word = 0;
  for (int face = 0; face < 5; ++face)
    for (int row = 0; row < rowsOf(face); ++row)
      for (int first = 0; first < resolution_; first += 64, ++word) {
        uint64_t bits = 0;
        const size_t start = at(face, row, first);
        for (int k = 0; k < std::min(64, resolution_ - first); ++k) {
          const size_t pixel = start + static_cast<size_t>(k);
          bits |= uint64_t{content_[pixel].covered > kHides || t_[pixel] < from} << k;
        }
        full_[word] = bits;
      }
}

/// Whether all pixels in which something of a sphere may be seen are full.
bool PointRaster::isHidden(const Visit& visit, float radius) const {
  const float r2 = radius * radius;
  const float toPixels = static_cast<float>(resolution_) / 2;
  const size_t words = static_cast<size_t>(resolution_ + 63) / 64;
  size_t firstRow = 0;
  for (int face = 0; face < 5; firstRow += static_cast<size_t>(rowsOf(face)), ++face) {
    const auto& [out, uAxis, vAxis] = axes_[static_cast<size_t>(face)];
    const float w = out.dot(visit.local);
    if (w <= -radius) continue;
    const float u = uAxis.dot(visit.local), v = vAxis.dot(visit.local);
    // Outside of the planes through the place and the edges of the face, whose normals are root of 2 long.
    constexpr float kRoot2 = 1.4142136f;
    if (std::abs(u) - w > kRoot2 * radius || v - w > kRoot2 * radius) continue;
    if (face == 0 ? -v - w > kRoot2 * radius : v < -radius) continue;
    if (w <= radius * 1.01f) return false;
    // Tangents from the place to the sphere, as slopes in the planes of u and w, and of v and w.
    const float scale = 1 / (w * w - r2);
    const auto span = [&](float x) {
      const float middle = x * w, half = radius * std::sqrt(x * x + w * w - r2);
      return std::pair((middle - half) * scale, (middle + half) * scale);
    };
    const auto [u0, u1] = span(u);
    const auto [v0, v1] = span(v);
    const float bottom = face == 0 ? 1 : 0;
    const int rows = rowsOf(face);
    const auto pixel = [&](float x, int most) {
      return static_cast<int>(std::clamp(std::floor(x * toPixels), 0.0f, static_cast<float>(most)));
    };
    // Squares of a node's area stay within its sphere's but for one pixel.
    const int column0 = pixel(u0 + 1, resolution_ - 1), column1 = pixel(u1 + 1, resolution_ - 1),
              row0 = pixel(v0 + bottom, rows - 1), row1 = pixel(v1 + bottom, rows - 1);
    for (int row = row0; row <= row1; ++row)
      for (int c = column0; c <= column1;) {
        const int end = std::min(column1 + 1, (c / 64 + 1) * 64), count = end - c;
        const uint64_t wanted = (count == 64 ? ~uint64_t{0} : (uint64_t{1} << count) - 1) << (c % 64);
        const uint64_t full =
            full_[(firstRow + static_cast<size_t>(row)) * words + static_cast<size_t>(c / 64)];
        if ((wanted & ~full) != 0) return false;
        c = end;
      }
  }
  return true;
}

void PointRaster::look(const PointTree& tree, const Visit& visit, size_t shell) {
  const auto& [index, distance2, local] = visit;
  const PointTree::Node& node = tree.nodes()[index];
  // Of a sphere with the radius r at the distance d: 2 pi (1 - root(1 - r^2 / d^2)), about pi r^2 / d^2.
  // What lies in no planes has an outline that its square does not follow: it is no larger than kOutline.
  const float pixel = 2 / static_cast<float>(resolution_);
  const float most = node.planeCount == 0 || !node.isCovered
                         ? std::min(maxSolidAngle_, kOutline * pixel * pixel)
                     : node.isParted ? std::min(maxSolidAngle_, kPart * pixel * pixel)
                                     : maxSolidAngle_;
  const bool isFar =
      distance2 * most > kPi * node.radius * node.radius && distance2 > 4 * node.radius * node.radius;
  if (isFar && node.isCovered && node.planeCount > 0) {
    for (uint32_t k = node.firstPlane; k < node.firstPlane + node.planeCount; ++k) tracePlane(tree, k, node);
    return;
  }
  if (isFar && local.z > node.radius) {
    const float distance = std::sqrt(distance2);
    const V3f direction = (P_ - node.center) / distance;
    const float largest = kPi * node.radius * node.radius;
    using Kind = SurfelView::Kind;
    if (node.inner == Surfel::Inner::None) {
      const PointTree::Seen seen = tree.lookAtBoth(index, direction);
      add(local, std::min(seen.area, largest), seen.radiance, false, Kind::NodeBoth, index);
      return;
    }
    for (const bool back : {false, true}) {
      const bool gap = isGap(node.inner, node.owner, !back);
      const PointTree::Seen seen =
          gap ? tree.lookAtGap(index, direction, back) : tree.look(index, direction, back);
      add(local, std::min(seen.area, largest), seen.radiance, seen.isInner,
          gap    ? Kind::NodeGap
          : back ? Kind::NodeBack
                 : Kind::NodeFront,
          index);
    }
    return;
  }
  if (!node.isLeaf()) {
    for (uint32_t child = node.children + node.childCount; child-- > node.children;) push(tree, child, shell);
    return;
  }
  for (uint32_t k = node.first; k < node.first + node.count; ++k) {
    const Surfel& s = tree.surfels()[k];
    const V3f at = frame_.toLocal(s.P - P_);
    if (at.z <= -s.radius) continue;
    const float d2 = at.length2();
    const float cosine = s.N.dot(P_ - s.P);  // times the distance
    if (cosine < 0 && !s.hasBack) continue;
    if (isOwn(s, d2, cosine)) continue;
    // Traced where it is part of a surface, larger than a pixel, or cut by the horizon.
    if (node.planeCount > 0 || s.radius * s.radius * kPi > d2 * pixel * pixel || at.z < s.radius) {
      traceSurfel(tree, k);
    } else {
      const float d = std::sqrt(d2);
      const bool front = cosine > 0;
      const bool shown = isGap(s.inner, s.owner, front) ? !front || !s.hasBack : front;
      add(at, s.area * std::abs(cosine) / d, shown ? s.front : s.back,
          s.inner == (front ? Surfel::Inner::Front : Surfel::Inner::Back),
          shown ? SurfelView::Kind::SurfelFront : SurfelView::Kind::SurfelBack, k);
    }
  }
}

}  // namespace patina
