// SPDX-License-Identifier: Apache-2.0
// Choosing among lights: importance, and the way down the hierarchy.
#include "renderer/shading/light_tree.h"

#include <algorithm>
#include <array>

namespace patina {
namespace {

constexpr double kTiny = 1e-60;  // square of a distance: shaders give no light from nearer than 1e-15

/// Angles are known to about 1e-4 only: what seems to be just out of reach may not be.
constexpr float kSlack = 1e-4f;
/// Where the cosines of a light that reaches the point are next to nothing, as far as bounds tell: N bends
/// away from the facet, and lights are not all alike in all directions.
constexpr float kLeastCosine = 1.0f / 16;

float sineOf(float cosine) { return std::sqrt(std::max(0.0f, 1 - cosine * cosine)); }
/// The cosine of the angle that is left of one in [0, pi] when `b` is taken off; 1 when nothing is.
float cosineLess(float cosine, float cosB, float sinB) {
  if (sinB == 0 && cosB > 0) return cosine;  // lights without extent, facets
  return cosine > cosB ? 1 : cosine * cosB + sineOf(cosine) * sinB;
}

}  // namespace

LightTree::Cluster::Cluster(const LightBounds& bounds)
    : axis(bounds.cone.axis),
      cosSpread(std::cos(bounds.cone.spread)),
      sinSpread(std::sin(std::min(bounds.cone.spread, kPi))),
      cosBeyond(std::cos(bounds.cone.beyond)),
      strength(static_cast<float>(std::clamp(bounds.strength(), 1e-35, 1e37))),
      twoSided(bounds.twoSided) {
  center = bounds.box.min * 0.5f + bounds.box.max * 0.5f;
  const V3f reach(std::max(bounds.box.max.x - center.x, center.x - bounds.box.min.x),
                  std::max(bounds.box.max.y - center.y, center.y - bounds.box.min.y),
                  std::max(bounds.box.max.z - center.z, center.z - bounds.box.min.z));
  radius = reach.length() * 1.00001f;
}

/// Section 4.2 of the paper, but for distances within the sphere: to a point there, light may come from
/// everywhere.
double LightTree::Cluster::importance(const LightReceiver& at) const {
  const V3f d = at.P - center;
  const double x = d.x, y = d.y, z = d.z, square = x * x + y * y + z * z;
  const auto r = static_cast<double>(radius);
  const auto all = static_cast<double>(strength);
  // Written so that numbers that are none end here, too.
  if (!(square > r * r)) return all / std::max(r * r, kTiny);
  if (!(square < 1e300)) return std::max(all * 1e-300, std::numeric_limits<double>::min());
  const double inverse = 1 / std::sqrt(square);
  const V3f w(static_cast<float>(x * inverse), static_cast<float>(y * inverse),
              static_cast<float>(z * inverse));
  // The cone in which the sphere is seen from the point.
  const auto sinSize = static_cast<float>(r * inverse);
  const float cosSize = sineOf(sinSize);
  float factor = 1;
  if (cosSpread > -1) {
    const float cosine = std::clamp(twoSided ? std::abs(axis.dot(w)) : axis.dot(w), -1.0f, 1.0f);
    const float beyondSpread = cosineLess(cosine, cosSpread, sinSpread);
    const float least = cosineLess(beyondSpread, cosSize, sinSize);
    if (least < cosBeyond - kSlack) return 0;
    factor = std::max(least, kLeastCosine);
  }
  const float facing = -at.normal.dot(w);
  if (!isBlack(at.normal)) {
    const float cosine = std::clamp(at.bothSides ? std::abs(facing) : facing, -1.0f, 1.0f);
    const float least = cosineLess(cosine, cosSize, sinSize);
    if (least < -kSlack) return 0;
    factor *= std::max(kLeastCosine, least);
  }
  return all * static_cast<double>(factor) / std::max(square, kTiny);
}

double LightTree::importance(const LightBounds& light, const LightReceiver& at) {
  return light.isPlaced() ? Cluster(light).importance(at) : light.strength();
}

/// Follows one random number, of which each choice uses up a part.
struct LightTree::ByNumber {
  double u;
  const LightTree& tree;

  size_t among(std::span<const double> weights, double sum, const Node*) {
    double x = u * sum;
    size_t k = 0;
    while (k + 1 < weights.size() && x >= weights[k]) x -= weights[k++];
    while (!(weights[k] > 0)) --k;  // rounding went past the last that has a chance
    u = std::clamp(x / weights[k], 0.0, 1 - 0x1p-53);
    return k;
  }
  bool isBeside(double share) {
    const bool beside = u < share;
    u = std::clamp(beside ? u / share : (u - share) / (1 - share), 0.0, 1 - 0x1p-53);
    return beside;
  }
  size_t beside() const {
    const auto& upTo = tree.besideUpTo_;
    return static_cast<size_t>(std::upper_bound(upTo.begin(), upTo.end() - 1, u) - upTo.begin());
  }
  uint32_t place = 0;
};

/// Follows the way to one light.
struct LightTree::Towards {
  uint32_t place;  ///< see lightAt_
  const LightTree& tree;

  size_t among(std::span<const double>, double, const Node* node) const {
    if (node->child == 0) return place - node->first;
    return place < tree.nodes_[node->child + 1].first ? 0 : 1;
  }
  bool isBeside(double) const { return place >= tree.leaves_.size(); }
  size_t beside() const { return place - tree.leaves_.size(); }
};

/// Of a point, how likely a light beside the tree is picked.
double LightTree::besideShare(const LightReceiver& at) const {
  if (besideUpTo_.empty() || leaves_.empty()) return leaves_.empty() ? 1 : 0;
  const double tree = nodes_[0].cluster.importance(at), fixed = static_cast<double>(besideUpTo_.size());
  return tree > 0 ? 0.5 * fixed / (fixed + 1) + 0.5 * beside_ / (beside_ + tree) : 1;
}

/// The weights of a node's lights or children, and their sum, which is above zero.
double LightTree::weigh(const Node& node, const LightReceiver& at, std::span<double> weights) const {
  const auto clusterOf = [&](size_t i) -> const Cluster& {
    return node.child == 0 ? leaves_[node.first + i] : nodes_[node.child + i].cluster;
  };
  double sum = 0;
  for (size_t i = 0; i < weights.size(); ++i) sum += weights[i] = clusterOf(i).importance(at);
  if (!(sum > 0))
    for (size_t i = 0; i < weights.size(); ++i)
      sum += weights[i] = static_cast<double>(clusterOf(i).strength);
  return sum;
}

/// The chance of what `choose` arrives at; its place is stored there.
template <class Choose>
double LightTree::descend(const LightReceiver& at, Choose& choose) const {
  double chance = 1;
  if (!besideUpTo_.empty()) {
    const double share = besideShare(at);
    if (choose.isBeside(share)) {
      const size_t k = choose.beside();
      choose.place = static_cast<uint32_t>(leaves_.size() + k);
      return share * (besideUpTo_[k] - (k ? besideUpTo_[k - 1] : 0));
    }
    if (share == 1) return 0;
    chance = 1 - share;
  }
  const Node* node = nodes_.data();
  std::array<double, kFew> room;
  for (;;) {
    const std::span<double> weights(room.data(), node->options());
    size_t k = 0;
    if (weights.size() > 1) {
      const double sum = weigh(*node, at, weights);
      k = choose.among(weights, sum, node);
      if (!(weights[k] > 0)) return 0;
      chance = std::max(chance * (weights[k] / sum), std::numeric_limits<double>::min());
    }
    if (node->child == 0) {
      choose.place = node->first + static_cast<uint32_t>(k);
      return chance;
    }
    node = &nodes_[node->child + k];
  }
}

/// Gives parts of [0, 1) to lights, and counts which of the numbers (k + offset) / n fall into each.
struct LightTree::Spreading {
  const LightTree& tree;
  const LightReceiver& at;
  double n, offset;
  std::vector<Picks>& out;

  double numbersBelow(double x) const { return std::clamp(std::ceil(x * n - offset), 0.0, n); }
  void give(uint32_t place, double chance, double low, double high) {
    const double count = numbersBelow(high) - numbersBelow(low);
    if (count > 0)
      out.push_back({tree.lightAt_[place],
                     std::max(static_cast<float>(chance), std::numeric_limits<float>::min()),
                     static_cast<uint32_t>(count)});
  }
  void beside(double high) {
    double low = 0;
    for (size_t k = 0; k < tree.besideUpTo_.size(); ++k) {
      const double end = tree.besideUpTo_[k] * high;
      give(static_cast<uint32_t>(tree.leaves_.size() + k), end - low, low, end);
      low = end;
    }
  }
  void below(const Node& node, double chance, double low, double high) {
    if (!(numbersBelow(high) > numbersBelow(low))) return;
    std::array<double, kFew> room;
    const std::span<double> weights(room.data(), node.options());
    const double sum = tree.weigh(node, at, weights);
    size_t last = weights.size() - 1;
    while (!(weights[last] > 0)) --last;
    double upTo = 0, from = low;
    for (size_t k = 0; k <= last; ++k) {
      if (!(weights[k] > 0)) continue;
      upTo += weights[k] / sum;
      const double to = k == last ? high : std::min(low + (high - low) * upTo, high);
      const double part = chance * (weights[k] / sum);
      if (node.child == 0)
        give(node.first + static_cast<uint32_t>(k), part, from, to);
      else
        below(tree.nodes_[node.child + k], part, from, to);
      from = to;
    }
  }
};

void LightTree::pickMany(const LightReceiver& at, uint32_t n, float u, std::vector<Picks>& out) const {
  out.clear();
  Spreading spreading{*this, at, static_cast<double>(n), static_cast<double>(u), out};
  const double share = besideShare(at);
  if (share > 0) spreading.beside(share);
  if (share < 1) spreading.below(nodes_[0], 1 - share, share, 1);
}

LightTree::Pick LightTree::pick(const LightReceiver& at, float u) const {
  if (placeOf_.size() == 1) return {0, 1};
  ByNumber choose{static_cast<double>(u), *this};
  const auto chance = static_cast<float>(descend(at, choose));
  return {lightAt_[choose.place], std::max(chance, std::numeric_limits<float>::min())};
}

float LightTree::chanceOf(const LightReceiver& at, uint32_t light) const {
  if (placeOf_.size() == 1) return 1;
  Towards choose{placeOf_[light], *this};
  const double chance = descend(at, choose);
  return chance > 0 ? std::max(static_cast<float>(chance), std::numeric_limits<float>::min()) : 0;
}

}  // namespace patina
