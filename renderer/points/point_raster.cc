// SPDX-License-Identifier: Apache-2.0
// Drawing surfels and nodes into a hemicube.
#include "renderer/points/point_raster.h"

#include <cassert>

namespace patina {
namespace {

/// A pixel that is covered so far counts as full: squares in place of pieces do not fit without gaps.
constexpr float kFull = 0.95f;
/// ... and one that is covered so far, between two that are full.
constexpr float kSeam = 0.5f;
/// The solid angle of a node that is drawn as a square, in pixels of the top's middle.
constexpr float kOutline = 1;
/// Surfels of the surface that the place is on: so many radii away, a part of a radius above or below it,
/// with normals at most so far apart.
constexpr float kOwnReach = 2, kOwnHeight = 0.3f, kOwnCosine = 0.7f;

/// The faces are the top and the sides towards x, y, -x, -y; v, from 0 on, is up on the sides.
V3f fromFace(int face, float u, float v) {
  switch (face) {
    case 0:
      return {u, v, 1};
    case 1:
      return {1, u, v};
    case 2:
      return {-u, 1, v};
    case 3:
      return {-1, -u, v};
    default:
      return {u, -1, v};
  }
}

std::array<V3f, 3> axesOf(int face) {
  const V3f out = fromFace(face, 0, 0);
  return {out, fromFace(face, 1, 0) - out, fromFace(face, 0, 1) - out};
}

}  // namespace

PointRaster::PointRaster(const Settings& settings)
    : resolution_(settings.resolution), maxSolidAngle_(settings.maxSolidAngle) {
  assert(resolution_ >= 2 && resolution_ % 2 == 0);
  const float size = 2 / static_cast<float>(resolution_);
  float sum = 0;
  for (int face = 0; face < 5; ++face)
    for (int row = 0; row < rowsOf(face); ++row)
      for (int column = 0; column < resolution_; ++column) {
        const float u = -1 + (static_cast<float>(column) + 0.5f) * size;
        const float v = (face == 0 ? -1 : 0) + (static_cast<float>(row) + 0.5f) * size;
        const V3f d = fromFace(face, u, v);
        const float length2 = d.length2();
        pixels_.push_back({d.z * size * size * kInvPi / (length2 * length2), d / std::sqrt(length2)});
        sum += pixels_.back().weight;
      }
  for (Pixel& pixel : pixels_) pixel.weight /= sum;
  content_.resize(pixels_.size());
  directions_.resize(pixels_.size());
  for (int face = 0; face < 5; ++face) axes_[static_cast<size_t>(face)] = axesOf(face);
}

PointRaster::Estimate PointRaster::gather(const PointTree& tree, const V3f& P, const V3f& N, float turn,
                                          float nearest, const Environment& environment, bool lit) {
  std::fill(content_.begin(), content_.end(), Content());
  items_.clear();
  P_ = P, nearest_ = nearest;
  frame_ = Frame(N);
  const float angle = 2 * kPi * turn;
  const V3f x = frame_.x * std::cos(angle) + frame_.y * std::sin(angle);
  frame_.y = N.cross(x), frame_.x = x;
  for (size_t k = 0; k < pixels_.size(); ++k) directions_[k] = frame_.toWorld(pixels_[k].direction);
  if (!tree.empty()) look(tree, 0);
  std::sort(items_.begin(), items_.end(),
            [](const Item& a, const Item& b) { return a.distance < b.distance; });
  for (const Item& item : items_) draw(item);
  Estimate result;
  openDirections_.clear(), openWeights_.clear();
  if (!items_.empty()) result.nearest = items_.front().distance;
  for (int face = 0; face < 5; ++face)
    for (int row = 0; row < rowsOf(face); ++row)
      for (int column = 0; column < resolution_; ++column) {
        const size_t k = firstOf(face) + static_cast<size_t>(row * resolution_ + column);
        Content& c = content_[k];
        Rgb radiance = c.radiance;
        float covered = c.covered;
        if (c.t < kInfinity) {
          radiance += c.met * (1 - covered);
          if (covered < 1) c.inverse += (1 - covered) / c.t, result.nearest = std::min(result.nearest, c.t);
          covered = 1;
        } else if (covered > kSeam && (isFull(c) || isBetweenFull(face, row, column))) {
          radiance /= covered;
          covered = 1;
        } else if (environment) {
          openDirections_.push_back(directions_[k]);
          openWeights_.push_back((1 - covered) * pixels_[k].weight);
        }
        if (lit) result.irradiance += radiance * (pixels_[k].weight * kPi);
        result.covered += covered * pixels_[k].weight;
        result.inverseDistance += c.inverse * pixels_[k].weight;
      }
  if (!openDirections_.empty()) {
    openRadiance_.assign(openDirections_.size(), Rgb(0, 0, 0));
    environment(openDirections_, openRadiance_);
    for (size_t k = 0; k < openRadiance_.size(); ++k)
      result.irradiance += openRadiance_[k] * (openWeights_[k] * kPi);
  }
  return result;
}

bool PointRaster::isFull(const Content& c) { return c.t < kInfinity || c.covered > kFull; }

/// Of a pixel that is covered in part: whether pixels on two opposite sides of it are full, so that it is
/// rather a seam of a surface than its border. Beyond a face's edge there is nothing to be told.
bool PointRaster::isBetweenFull(int face, int row, int column) const {
  const int rows = rowsOf(face);
  const auto fullAt = [&](int r, int c) {
    if (r < 0 || c < 0 || r >= rows || c >= resolution_) return true;
    return isFull(content_[firstOf(face) + static_cast<size_t>(r * resolution_ + c)]);
  };
  for (const auto& [dr, dc] : {std::pair{0, 1}, {1, 0}, {1, 1}, {1, -1}})
    if (fullAt(row + dr, column + dc) && fullAt(row - dr, column - dc)) return true;
  return false;
}

void PointRaster::look(const PointTree& tree, uint32_t index) {
  const PointTree::Node& node = tree.nodes()[index];
  const V3f local = frame_.toLocal(node.center - P_);
  if (local.z <= -node.radius) return;  // below the horizon
  const float distance2 = local.length2();
  // Of a sphere with the radius r at the distance d: 2 pi (1 - root(1 - r^2 / d^2)), about pi r^2 / d^2.
  // What lies in no planes has an outline that its square does not follow: it is no larger than a pixel.
  const float pixel = 2 / static_cast<float>(resolution_);
  const float most =
      node.planeCount > 0 ? maxSolidAngle_ : std::min(maxSolidAngle_, kOutline * pixel * pixel);
  const bool isFar =
      distance2 * most > kPi * node.radius * node.radius && distance2 > 4 * node.radius * node.radius;
  if (isFar && node.planeCount > 0) {
    for (uint32_t k = node.firstPlane; k < node.firstPlane + node.planeCount; ++k) trace(tree.planes()[k]);
    return;
  }
  if (isFar && local.z > node.radius) {
    const float distance = std::sqrt(distance2);
    const PointTree::Seen seen = tree.look(index, (P_ - node.center) / distance);
    add(local, std::min(seen.area, kPi * node.radius * node.radius), seen.radiance);
    return;
  }
  if (!node.isLeaf()) {
    for (uint32_t child = node.children; child < node.children + node.childCount; ++child) look(tree, child);
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
      trace(s);
    } else {
      const float d = std::sqrt(d2);
      add(at, s.area * std::abs(cosine) / d, cosine > 0 ? s.front : s.back);
    }
  }
}

void PointRaster::add(const V3f& local, float area, const Rgb& radiance) {
  const float distance2 = local.length2();
  if (!(area > 0) || !(distance2 > nearest_ * nearest_)) return;
  const float distance = std::sqrt(distance2);
  const V3f d = local / distance;
  const float toPixels = static_cast<float>(resolution_) / 2;
  for (int face = 0; face < 5; ++face) {
    const auto [axis, uAxis, vAxis] = axes_[static_cast<size_t>(face)];
    const float w = axis.dot(d);
    if (w < 0.5f) continue;  // farther than 55 degrees from the axis there is nothing of the face
    const float u = uAxis.dot(d) / w, v = vAxis.dot(d) / w;
    // On the plane at distance 1 a solid angle covers its share over the cube of the cosine.
    const float half = std::min(std::sqrt(area / distance2 / (w * w * w)) / 2, 1.0f);
    if (std::abs(u) >= 1 + half || v >= 1 + half || v <= (face == 0 ? -1 : 0) - half) continue;
    items_.push_back({distance, (u + 1) * toPixels, (face == 0 ? v + 1 : v) * toPixels, half * toPixels,
                      static_cast<uint8_t>(face), radiance});
  }
}

void PointRaster::trace(const Surfel& s) {
  const V3f center = s.P - P_;
  const float r2 = s.radius * s.radius;
  constexpr float kSlack = 0.01f;
  const V3f most = s.bound() + V3f(kSlack * s.radius);
  trace(center, s.radius, center, s.N, s.N.dot(center) < 0 ? s.front : s.back, [&](const V3f& p) {
    const V3f d = p - center;
    return d.length2() <= r2 && std::abs(d.x) <= most.x && std::abs(d.y) <= most.y && std::abs(d.z) <= most.z;
  });
}

void PointRaster::trace(const PointTree::Plane& plane) {
  const V3f on = plane.P - P_;
  const bool front = plane.N.dot(on) < 0;
  if (!front && plane.backArea == 0) return;
  const V3f least = plane.reach.min - P_, most = plane.reach.max - P_;
  trace(plane.reach.center() - P_, plane.reach.size().length() / 2, on, plane.N,
        front ? plane.front : plane.back, [&](const V3f& p) {
          return p.x >= least.x && p.x <= most.x && p.y >= least.y && p.y <= most.y && p.z >= least.z &&
                 p.z <= most.z;
        });
}

/// Pieces around the place, of the surface that it is on, bend away from it and do not stand above it: discs
/// in their place would.
bool PointRaster::isOwn(const Surfel& s, float distance2, float height) const {
  return distance2 < kOwnReach * kOwnReach * s.radius * s.radius &&
         std::abs(height) < kOwnHeight * s.radius && std::abs(frame_.z.dot(s.N)) > kOwnCosine;
}

/// Only pixels are looked at that are within the bound of the sphere on each face.
template <class IsMet>
void PointRaster::trace(const V3f& center, float radius, const V3f& on, const V3f& N, const Rgb& radiance,
                        IsMet isMet) {
  const V3f local = frame_.toLocal(center);
  const float plane = N.dot(on), toPixels = static_cast<float>(resolution_) / 2;
  for (int face = 0; face < 5; ++face) {
    const auto [axis, uAxis, vAxis] = axes_[static_cast<size_t>(face)];
    const float w = axis.dot(local), u = uAxis.dot(local), v = vAxis.dot(local);
    // Outside of one of the planes through the place and an edge of the face, or below the horizon.
    const float reach = std::numbers::sqrt2_v<float> * radius;
    if (std::abs(u) - w > reach || v - w > reach || (face == 0 ? -v - w > reach : v < -radius)) continue;
    // A box around the sphere is seen between these slopes; one that the place is in, or beside, everywhere.
    const float farthest = w + radius, closest = w - radius;
    float u0 = -1, u1 = 1, v0 = -1, v1 = 1;
    if (closest > 0) {
      u0 = std::min((u - radius) / closest, (u - radius) / farthest);
      u1 = std::max((u + radius) / closest, (u + radius) / farthest);
      v0 = std::min((v - radius) / closest, (v - radius) / farthest);
      v1 = std::max((v + radius) / closest, (v + radius) / farthest);
    }
    const float bottom = face == 0 ? 1 : 0;
    const int rows = rowsOf(face);
    const auto limit = [](float x, int most) {
      return std::clamp(static_cast<int>(std::clamp(x, -1.0f, 1e4f)), 0, most);
    };
    const int c0 = limit((u0 + 1) * toPixels, resolution_), c1 = limit((u1 + 1) * toPixels + 1, resolution_);
    const int y0 = limit((v0 + bottom) * toPixels, rows), y1 = limit((v1 + bottom) * toPixels + 1, rows);
    for (int y = y0; y < y1; ++y)
      for (int c = c0; c < c1; ++c) {
        const size_t k = firstOf(face) + static_cast<size_t>(y) * static_cast<size_t>(resolution_) +
                         static_cast<size_t>(c);
        const V3f& d = directions_[k];
        const float slope = N.dot(d);
        const float t = plane / slope;
        if (!(t > nearest_) || !(t < content_[k].t)) continue;
        if (!isMet(d * t)) continue;
        content_[k].t = t, content_[k].met = radiance;
      }
  }
}

/// Covers what the square covers of each pixel, as far as that is not covered yet nor stands behind what the
/// pixel's ray meets.
void PointRaster::draw(const Item& item) {
  const int rows = rowsOf(item.face);
  const float x = item.x, y = item.y;
  const int x0 = std::max(0, static_cast<int>(std::floor(x - item.half))),
            x1 = std::min(resolution_, static_cast<int>(std::floor(x + item.half)) + 1),
            y0 = std::max(0, static_cast<int>(std::floor(y - item.half))),
            y1 = std::min(rows, static_cast<int>(std::floor(y + item.half)) + 1);
  const size_t first = firstOf(item.face);
  for (int j = y0; j < y1; ++j) {
    const float across =
        std::min(y + item.half, static_cast<float>(j + 1)) - std::max(y - item.half, static_cast<float>(j));
    for (int i = x0; i < x1; ++i) {
      const float along =
          std::min(x + item.half, static_cast<float>(i + 1)) - std::max(x - item.half, static_cast<float>(i));
      Content& c = content_[first + static_cast<size_t>(j) * static_cast<size_t>(resolution_) +
                            static_cast<size_t>(i)];
      if (item.distance >= c.t) continue;
      const float share = std::min(std::max(along, 0.0f) * std::max(across, 0.0f), 1 - c.covered);
      if (!(share > 0)) continue;
      c.covered += share;
      c.inverse += share / item.distance;
      c.radiance += item.radiance * share;
    }
  }
}

}  // namespace patina
