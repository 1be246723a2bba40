// SPDX-License-Identifier: Apache-2.0
// Building the hierarchy of lights, from the top.
#include <algorithm>
#include <array>
#include <numeric>

#include "renderer/shading/light_tree.h"

namespace patina {
namespace {

constexpr int kBuckets = 12;
/// Below this depth halves of equal number are made: the way down stays short whatever the lights are like.
constexpr int kMostUneven = 40;
/// Powers are guesses: no light counts for less than this share of the mean.
constexpr float kLeastPower = 1.0f / 16;
/// Beyond, squares of floats overflow; and such a light is as good as anywhere.
constexpr float kFarAway = 1e18f;

/// Bounds of several lights.
struct Group {
  Box3f box;
  LightCone cone;
  bool twoSided = false;
  double power = 0;
  uint32_t count = 0;

  void add(const Group& g) {
    if (g.count == 0) return;
    cone = count == 0 ? g.cone : LightCone::merged(cone, g.cone);
    box.extendBy(g.box);
    twoSided |= g.twoSided;
    power += g.power;
    count += g.count;
  }
  /// What the paper's surface area orientation heuristic sums up. In place of the area, which is zero of
  /// lamps in a row, it is the square of the diagonal.
  double cost() const { return count ? power * (cone.measure() + 1e-3) * V3d(box.size()).length2() : 0; }
  LightBounds bounds() const { return {box, cone, twoSided, static_cast<float>(std::min(power, 1e37))}; }
};

Group groupOf(const LightBounds& light) {
  return {light.box, light.cone, light.twoSided, static_cast<double>(light.power), 1};
}

}  // namespace

struct LightTree::Builder {
  LightTree& tree;
  std::vector<LightBounds> lights;
  std::vector<uint32_t> order;  // of those with a place

  V3f centerOf(uint32_t light) const { return lights[light].box.min * 0.5f + lights[light].box.max * 0.5f; }

  /// Powers that are all known and above zero.
  void completePowers() {
    const auto isKnown = [](float s) { return s > 0 && std::isfinite(s); };
    double sums[2] = {}, counts[2] = {};
    for (const LightBounds& light : lights)
      if (isKnown(light.power))
        sums[light.isPlaced()] += static_cast<double>(light.power), ++counts[light.isPlaced()];
    for (LightBounds& light : lights) {
      const double n = counts[light.isPlaced()];
      const auto mean = n > 0 ? static_cast<float>(sums[light.isPlaced()] / n) : 1;
      if (!isKnown(light.power))
        light.power = mean;
      else
        light.power = std::max(light.power, kLeastPower * mean);
      light.power = std::clamp(light.power, 1e-30f, 1e30f);
    }
  }

  void build() {
    for (LightBounds& light : lights) {
      const bool isNear = light.isPlaced() && isFinite(light.box.min) && isFinite(light.box.max) &&
                          maxAbsComponent(light.box.min) < kFarAway &&
                          maxAbsComponent(light.box.max) < kFarAway;
      if (isNear) continue;
      // Its power is spread over a sphere of any size, and says nothing here.
      if (light.isPlaced()) light.power = 0;
      light.box.makeEmpty();
    }
    completePowers();
    const auto n = static_cast<uint32_t>(lights.size());
    std::vector<uint32_t> beside;
    for (uint32_t k = 0; k < n; ++k) (lights[k].isPlaced() ? order : beside).push_back(k);
    if (!order.empty()) {
      tree.nodes_.emplace_back();
      split(0, 0, static_cast<uint32_t>(order.size()), 0);
    }
    tree.lightAt_ = order;
    for (const uint32_t k : order) tree.leaves_.emplace_back(lights[k]);
    // Those beside the tree: half fairly, half by power.
    for (const uint32_t k : beside) tree.beside_ += static_cast<double>(lights[k].power);
    double upTo = 0;
    for (const uint32_t k : beside) {
      upTo += 0.5 / static_cast<double>(beside.size()) +
              0.5 * static_cast<double>(lights[k].power) / tree.beside_;
      tree.besideUpTo_.push_back(upTo);
      tree.lightAt_.push_back(k);
    }
    if (!beside.empty()) tree.besideUpTo_.back() = 1;
    tree.placeOf_.resize(n);
    for (uint32_t place = 0; place < n; ++place) tree.placeOf_[tree.lightAt_[place]] = place;
  }

  void split(uint32_t node, uint32_t begin, uint32_t end, int depth) {
    Group all;
    Box3f centers;
    for (uint32_t k = begin; k < end; ++k) {
      all.add(groupOf(lights[order[k]]));
      centers.extendBy(centerOf(order[k]));
    }
    tree.nodes_[node].cluster = Cluster(all.bounds());
    tree.nodes_[node].first = begin, tree.nodes_[node].count = end - begin;
    if (end - begin <= kFew) return;
    const uint32_t middle = partition(begin, end, all, centers, depth);
    const auto child = static_cast<uint32_t>(tree.nodes_.size());
    tree.nodes_[node].child = child;
    tree.nodes_.resize(child + 2);
    split(child, begin, middle, depth + 1);
    split(child + 1, middle, end, depth + 1);
  }

  /// Sorts part of `order` into two; gives the first of the second.
  uint32_t partition(uint32_t begin, uint32_t end, const Group& all, const Box3f& centers, int depth) {
    const V3f size = centers.size();
    const auto from = order.begin() + begin, to = order.begin() + end;
    int bestAxis = -1, bestBucket = 0;
    double best = std::numeric_limits<double>::infinity();
    const auto bucketOf = [&](uint32_t light, int axis) {
      const float t = (centerOf(light)[axis] - centers.min[axis]) / size[axis];
      return std::clamp(static_cast<int>(t * kBuckets), 0, kBuckets - 1);
    };
    for (int axis = 0; axis < 3 && depth < kMostUneven; ++axis) {
      if (!(size[axis] > 0)) continue;
      std::array<Group, kBuckets> buckets;
      for (auto k = from; k != to; ++k)
        buckets[static_cast<size_t>(bucketOf(*k, axis))].add(groupOf(lights[*k]));
      std::array<double, kBuckets> above{};
      Group sum;
      for (size_t b = kBuckets - 1; b > 0; --b) sum.add(buckets[b]), above[b] = sum.cost();
      sum = Group();
      // Thin slices are better than thin slabs: the paper's factor of the lengths.
      const auto thin = static_cast<double>(maxComponent(all.box.size()) / size[axis]);
      for (int b = 0; b + 1 < kBuckets; ++b) {
        sum.add(buckets[static_cast<size_t>(b)]);
        if (sum.count == 0 || sum.count == all.count) continue;
        const double cost = thin * (sum.cost() + above[static_cast<size_t>(b) + 1]);
        if (cost < best) best = cost, bestAxis = axis, bestBucket = b;
      }
    }
    if (bestAxis >= 0) {
      const auto middle = std::stable_partition(
          from, to, [&](uint32_t light) { return bucketOf(light, bestAxis) <= bestBucket; });
      return begin + static_cast<uint32_t>(middle - from);
    }
    const int longest = size.x >= size.y ? (size.x >= size.z ? 0 : 2) : size.y >= size.z ? 1 : 2;
    std::sort(from, to, [&](uint32_t a, uint32_t b) {
      const float x = centerOf(a)[longest], y = centerOf(b)[longest];
      return x != y ? x < y : a < b;
    });
    return begin + (end - begin) / 2;
  }
};

LightTree::LightTree(std::span<const LightBounds> lights) {
  Builder{*this, {lights.begin(), lights.end()}, {}}.build();
}

}  // namespace patina
