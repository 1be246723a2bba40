// SPDX-License-Identifier: Apache-2.0
// Building the octree, and the harmonics of its nodes.
#include "renderer/points/point_tree.h"

#include <numeric>

namespace patina {
namespace {

/// The harmonics of max(0, N . d) in bands 0 to 2, beside those of N itself (Ramamoorthi and Hanrahan 2001,
/// equation 8): convolution with a clamped cosine.
constexpr std::array<float, 3> kCosineBands = {kPi, 2 * kPi / 3, kPi / 4};
constexpr std::array<int, 9> kBandOf = {0, 1, 1, 1, 2, 2, 2, 2, 2};
/// Normals of a flat node are at least so near to their mean: 14 degrees.
constexpr float kFlat = 0.97f;
bool isUsable(const Surfel& s) {
  constexpr float kFarthest = 1e15f;  // squares of distances do not overflow
  return isFinite(s.P) && maxAbsComponent(s.P) < kFarthest && s.radius < kFarthest && isFinite(s.N) &&
         std::isfinite(s.area) && s.area > 0 && std::isfinite(s.radius) && s.radius >= 0 &&
         s.thickness >= 0 && std::abs(s.N.length2() - 1) < 1e-2f && isFinite(s.U) && s.halfU >= 0 &&
         s.halfV >= 0;
}

Rgb finiteOr0(const Rgb& c) { return isFinite(c) ? c : Rgb(0, 0, 0); }

float dot(const ShBasis& a, const ShBasis& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0f);
}

}  // namespace

V3f Surfel::bound() const {
  const V3f V = N.cross(U);
  const float u = std::min(halfU, radius), v = std::min(halfV, radius);
  V3f half;
  for (int k = 0; k < 3; ++k) half[k] = std::min(radius, std::abs(U[k]) * u + std::abs(V[k]) * v);
  return half;
}

ShBasis shBasis(const V3f& d) {
  constexpr float k0 = 0.282095f, k1 = 0.488603f, k2 = 1.092548f, k20 = 0.315392f, k22 = 0.546274f;
  return {k0,
          k1 * d.y,
          k1 * d.z,
          k1 * d.x,
          k2 * d.x * d.y,
          k2 * d.y * d.z,
          k20 * (3 * d.z * d.z - 1),
          k2 * d.x * d.z,
          k22 * (d.x * d.x - d.y * d.y)};
}

PointTree::PointTree(std::vector<Surfel> surfels) : surfels_(std::move(surfels)) {
  places_.assign(surfels_.size(), kRefused);
  Box3f box;
  for (uint32_t k = 0; k < surfels_.size(); ++k) {
    Surfel& s = surfels_[k];
    if (!isUsable(s)) continue;
    s.N.normalize();
    s.U = normalizedOr(s.U - s.N * s.N.dot(s.U), Frame(s.N).x);
    order_.push_back(k);
    box.extendBy(s.P);
  }
  refused_ = surfels_.size() - order_.size();
  if (!order_.empty()) {
    // A cube: boxes that are long would let aggregates leave gaps between each other.
    const V3f size = box.size();
    Node root;
    root.count = static_cast<uint32_t>(order_.size());
    nodes_.push_back(root);
    split(0, box.min, std::max({size.x, size.y, size.z}) * 1.0001f, 0);
  }
  std::vector<Surfel> sorted;
  sorted.reserve(order_.size());
  for (uint32_t k = 0; k < order_.size(); ++k) {
    sorted.push_back(surfels_[order_[k]]);
    places_[order_[k]] = k;
  }
  surfels_.swap(sorted);
  order_ = {};
  summarize(true);
}

void PointTree::split(uint32_t index, const V3f& corner, float size, int depth) {
  const uint32_t first = nodes_[index].first, end = first + nodes_[index].count;
  if (end - first <= kLeafSize || depth >= kMaxDepth || !(size > 0)) return;
  const float half = size / 2;
  const auto octant = [&](uint32_t surfel) {
    const V3f p = surfels_[surfel].P - corner;
    return (p.x >= half ? 1 : 0) | (p.y >= half ? 2 : 0) | (p.z >= half ? 4 : 0);
  };
  std::array<uint32_t, 9> begin{};
  std::stable_sort(order_.begin() + first, order_.begin() + end,
                   [&](uint32_t a, uint32_t b) { return octant(a) < octant(b); });
  for (uint32_t k = first; k < end; ++k) ++begin[static_cast<size_t>(octant(order_[k])) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  const auto children = static_cast<uint32_t>(nodes_.size());
  std::array<int, 8> octantOf{};
  uint8_t count = 0;
  for (int k = 0; k < 8; ++k) {
    const auto at = static_cast<size_t>(k);
    if (begin[at] == begin[at + 1]) continue;
    Node child;
    child.first = first + begin[at], child.count = begin[at + 1] - begin[at];
    nodes_.push_back(child);
    octantOf[count++] = k;
  }
  nodes_[index].children = children, nodes_[index].childCount = count;
  for (uint32_t k = 0; k < count; ++k) {
    const int at = octantOf[k];
    split(children + k, corner + V3f(at & 1 ? half : 0, at & 2 ? half : 0, at & 4 ? half : 0), half,
          depth + 1);
  }
}

/// From the leaves up: children stand behind their parents.
void PointTree::summarize(bool isFirst) {
  harmonics_.assign(nodes_.size(), {});
  planes_.clear();
  for (size_t k = nodes_.size(); k-- > 0;) {
    Node& node = nodes_[k];
    const auto own = std::span(surfels_).subspan(node.first, node.count);
    Harmonics& h = harmonics_[k];
    if (node.isLeaf()) {
      for (const Surfel& s : own)
        for (const bool back : {false, true}) {
          if (back && !s.hasBack) continue;
          const ShBasis basis = shBasis(back ? -s.N : s.N);
          const Rgb& radiance = back ? s.back : s.front;
          Harmonics::Side& side = back ? h.back : h.front;
          for (size_t i = 0; i < 9; ++i) {
            const float area = s.area * kCosineBands[static_cast<size_t>(kBandOf[i])] * basis[i];
            side.area[i] += area;
            for (size_t c = 0; c < 3; ++c) side.power[c][i] += area * radiance[static_cast<int>(c)];
          }
        }
    } else {
      for (uint32_t child = node.children; child < node.children + node.childCount; ++child)
        for (const auto side : {&Harmonics::front, &Harmonics::back})
          for (size_t i = 0; i < 9; ++i) {
            (h.*side).area[i] += (harmonics_[child].*side).area[i];
            for (size_t c = 0; c < 3; ++c) (h.*side).power[c][i] += (harmonics_[child].*side).power[c][i];
          }
    }
    // Sums of many go through children.
    struct Sums {
      V3d N{0, 0, 0}, front{0, 0, 0}, back{0, 0, 0};
      double frontArea = 0, backArea = 0;
    } sums;
    Box3f box;
    for (const Surfel& s : own.first(node.isLeaf() ? own.size() : 0)) {
      const double area = s.area;
      sums.N += V3d(s.N) * area;
      sums.front += V3d(s.front) * area, sums.frontArea += area;
      if (s.hasBack) sums.back += V3d(s.back) * area, sums.backArea += area;
      box.extendBy(Box3f(s.P - s.bound(), s.P + s.bound()));
    }
    float least = 1;
    for (uint32_t child = node.children; child < node.children + node.childCount; ++child) {
      const Node& c = nodes_[child];
      const double front = c.frontArea, back = c.backArea;
      sums.N += V3d(c.N) * front;
      sums.front += V3d(c.front) * front, sums.frontArea += front;
      sums.back += V3d(c.back) * back, sums.backArea += back;
      box.extendBy(Box3f(c.center - c.half, c.center + c.half));
      if (!c.isFlat) least = -1;
    }
    node.inner = node.isLeaf() ? own[0].inner : nodes_[node.children].inner;
    node.owner = node.isLeaf() ? own[0].owner : nodes_[node.children].owner;
    for (const Surfel& s : own.first(node.isLeaf() ? own.size() : 0)) {
      if (s.inner != node.inner) node.inner = Surfel::Inner::None;
      if (s.owner != node.owner) node.owner = Surfel::kNobody;
    }
    for (uint32_t child = node.children; child < node.children + node.childCount; ++child) {
      if (nodes_[child].inner != node.inner) node.inner = Surfel::Inner::None;
      if (nodes_[child].owner != node.owner) node.owner = Surfel::kNobody;
    }
    node.center = box.center();
    node.half = box.size() / 2;
    node.radius = 0;
    for (const Surfel& s : own.first(node.isLeaf() ? own.size() : 0))
      node.radius = std::max(node.radius, (s.P - node.center).length() + s.radius);
    for (uint32_t child = node.children; child < node.children + node.childCount; ++child)
      node.radius =
          std::max(node.radius, (nodes_[child].center - node.center).length() + nodes_[child].radius);
    node.N = normalizedOr(V3f(sums.N), V3f(0, 0, 1));
    if (node.isLeaf())
      for (const Surfel& s : own) least = std::min(least, s.N.dot(node.N));
    for (uint32_t child = node.children; child < node.children + node.childCount; ++child)
      least = std::min(least, nodes_[child].N.dot(node.N));
    node.isFlat = least >= kFlat;
    node.frontArea = static_cast<float>(sums.frontArea), node.backArea = static_cast<float>(sums.backArea);
    node.front = sums.frontArea > 0 ? V3f(sums.front / sums.frontArea) : V3f(0);
    node.back = sums.backArea > 0 ? V3f(sums.back / sums.backArea) : V3f(0);
    findPlanes(node, isFirst);
  }
}

PointTree::Seen PointTree::look(uint32_t index, const V3f& direction, bool back) const {
  const Node& node = nodes_[index];
  const bool isInner = node.inner == (back ? Surfel::Inner::Back : Surfel::Inner::Front);
  if (node.isFlat) {
    const float cosine = node.N.dot(direction) * (back ? -1.0f : 1.0f);
    if (cosine <= 0) return {};
    return {(back ? node.backArea : node.frontArea) * cosine, back ? node.back : node.front, isInner};
  }
  const Harmonics::Side& h = back ? harmonics_[index].back : harmonics_[index].front;
  const ShBasis basis = shBasis(direction);
  const float area = dot(h.area, basis);
  if (!(area > 0)) return {};
  const auto mean = [&](size_t c) { return std::max(0.0f, dot(h.power[c], basis) / area); };
  return {area, {mean(0), mean(1), mean(2)}, isInner};
}

PointTree::Seen PointTree::lookAtGap(uint32_t index, const V3f& direction, bool back) const {
  Seen seen = look(index, direction, back);
  seen.radiance = inGap(index);
  return seen;
}

PointTree::Seen PointTree::lookAtBoth(uint32_t index, const V3f& direction) const {
  Seen seen = look(index, direction, false);
  const Seen back = look(index, direction, true);
  if (!(back.area > 0)) return seen;
  const float area = seen.area + back.area;
  seen.radiance = (seen.radiance * seen.area + back.radiance * back.area) / area;
  seen.area = area;
  return seen;
}

void PointTree::setRadiance(std::span<const Rgb> front, std::span<const Rgb> back) {
  for (size_t k = 0; k < surfels_.size(); ++k)
    surfels_[k].front = finiteOr0(front[k]), surfels_[k].back = finiteOr0(back[k]);
  summarize(false);
}

size_t PointTree::memory() const {
  return sizeof(*this) + surfels_.capacity() * sizeof(Surfel) + nodes_.capacity() * sizeof(Node) +
         planes_.capacity() * sizeof(Plane) + harmonics_.capacity() * sizeof(Harmonics) +
         places_.capacity() * sizeof(uint32_t);
}

}  // namespace patina
