// SPDX-License-Identifier: Apache-2.0
// What nodes of the octree of surfels stand for.
#include "renderer/points/point_tree.h"

#include <gtest/gtest.h>

#include <random>

#include "points_shapes.h"

namespace patina {
namespace {

std::vector<Surfel> cloud(uint32_t count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(-1, 1);
  std::vector<Surfel> surfels(count);
  for (Surfel& s : surfels) {
    s.P = V3f(uniform(random), 3 * uniform(random), uniform(random));
    s.N = normalizedOr(V3f(uniform(random), uniform(random), uniform(random)), V3f(0, 0, 1));
    s.area = 0.001f * (1.5f + uniform(random)), s.radius = std::sqrt(s.area / kPi);
    s.front = Rgb(1 + uniform(random), 2, 0.5f), s.back = Rgb(0.25f);
  }
  return surfels;
}

TEST(PointTree, HarmonicsAreOrthonormal) {
  constexpr int kSamples = 1 << 16;
  std::array<std::array<double, 9>, 9> products{};
  for (uint32_t k = 0; k < kSamples; ++k) {
    const V2f u = sobol2(k, 3);
    const float z = 1 - 2 * u.x, r = std::sqrt(std::max(0.0f, 1 - z * z));
    const ShBasis b = shBasis({r * std::cos(2 * kPi * u.y), r * std::sin(2 * kPi * u.y), z});
    for (size_t i = 0; i < 9; ++i)
      for (size_t j = 0; j < 9; ++j) products[i][j] += 4 * kPi * b[i] * b[j] / kSamples;
  }
  for (size_t i = 0; i < 9; ++i)
    for (size_t j = 0; j < 9; ++j) EXPECT_NEAR(products[i][j], i == j ? 1 : 0, 1e-3) << i << ' ' << j;
}

TEST(PointTree, NodesHoldWhatIsInThem) {
  const std::vector<Surfel> surfels = cloud(5000);
  const PointTree tree(surfels);
  ASSERT_EQ(tree.surfels().size(), surfels.size());
  for (uint32_t k = 0; k < surfels.size(); ++k) ASSERT_EQ(tree.surfels()[tree.places()[k]].P, surfels[k].P);
  for (const PointTree::Node& node : tree.nodes()) {
    double area = 0;
    for (uint32_t k = node.first; k < node.first + node.count; ++k) {
      const Surfel& s = tree.surfels()[k];
      area += s.area;
      ASSERT_LE((s.P - node.center).length() + s.radius, node.radius * 1.0001f);
    }
    ASSERT_NEAR(node.frontArea, area, 1e-4 * area);
    if (node.isLeaf()) {
      ASSERT_LE(node.count, PointTree::kLeafSize);
    }
    uint32_t sum = 0;
    for (uint32_t child = node.children; child < node.children + node.childCount; ++child) {
      ASSERT_EQ(tree.nodes()[child].first, node.first + sum);
      sum += tree.nodes()[child].count;
    }
    ASSERT_EQ(node.isLeaf() ? node.count : sum, node.count);
  }
}

/// Both sides of a node beside each other.
PointTree::Seen lookAt(const PointTree& tree, uint32_t node, const V3f& direction) {
  PointTree::Seen sum;
  for (const bool back : {false, true}) {
    const PointTree::Seen seen = tree.look(node, direction, back);
    if (sum.area + seen.area > 0)
      sum.radiance = lerp(seen.area / (sum.area + seen.area), sum.radiance, seen.radiance);
    sum.area += seen.area;
  }
  return sum;
}

TEST(PointTree, ANodeLooksAsTheSumOfItsSurfels) {
  // Of a ball from any side a disc; of a cloud the sum of clamped cosines, to the error of three bands.
  const PointTree ball(sphere({0, 0, 0}, 1, 4000, Rgb(2, 1, 0.5f), false, false));
  const PointTree mixed(cloud(4000));
  for (uint32_t k = 0; k < 50; ++k) {
    const V2f u = sobol2(k, 1);
    const float z = 1 - 2 * u.x, r = std::sqrt(std::max(0.0f, 1 - z * z));
    const V3f d(r * std::cos(2 * kPi * u.y), r * std::sin(2 * kPi * u.y), z);
    const PointTree::Seen seen = lookAt(ball, 0, d);
    EXPECT_NEAR(seen.area, kPi, 0.01f);
    EXPECT_NEAR(seen.radiance.x, 2, 0.01f);
    EXPECT_NEAR(seen.radiance.z, 0.5f, 0.01f);
    double area = 0, green = 0;
    for (const Surfel& s : mixed.surfels()) {
      const float cosine = s.N.dot(d);
      area += s.area * std::abs(cosine);
      green += s.area * std::abs(cosine) * (cosine > 0 ? s.front : s.back).y;
    }
    const PointTree::Seen all = lookAt(mixed, 0, d);
    EXPECT_NEAR(all.area, area, 0.03 * area);
    EXPECT_NEAR(all.radiance.y, green / area, 0.05 * green / area);
  }
}

TEST(PointTree, AWallShowsNothingOfItsOtherSide) {
  std::vector<Surfel> wall;
  addQuad(wall, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 32, Rgb(1), Rgb(0));
  const PointTree tree(wall);
  ASSERT_TRUE(tree.nodes()[0].isFlat);
  for (const float cosine : {0.01f, 0.2f, 0.9f}) {
    const float sine = std::sqrt(1 - cosine * cosine);
    EXPECT_EQ(lookAt(tree, 0, {sine, 0, -cosine}).radiance, Rgb(0));
    EXPECT_NEAR(lookAt(tree, 0, {sine, 0, -cosine}).area, 4 * cosine, 1e-3f);
    EXPECT_NEAR(lookAt(tree, 0, {sine, 0, cosine}).radiance.x, 1, 1e-5f);
  }
}

TEST(PointTree, RadiancesOfAnotherBounceReachAllNodes) {
  const std::vector<Surfel> surfels = cloud(3000);
  PointTree tree(surfels);
  std::vector<Rgb> front, back;
  for (const Surfel& s : tree.surfels()) front.push_back(s.front * 3), back.push_back(s.back * 2);
  tree.setRadiance(front, back);
  std::vector<Surfel> changed = surfels;
  for (Surfel& s : changed) s.front *= 3, s.back *= 2;
  const PointTree fresh(changed);
  ASSERT_EQ(tree.nodes().size(), fresh.nodes().size());
  for (uint32_t k = 0; k < tree.nodes().size(); ++k) {
    const PointTree::Seen a = lookAt(tree, k, V3f(0.6f, 0, 0.8f)), b = lookAt(fresh, k, V3f(0.6f, 0, 0.8f));
    ASSERT_EQ(a.area, b.area);
    ASSERT_EQ(a.radiance, b.radiance);
  }
}

TEST(PointTree, HostileSurfelsAreLeftOut) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::vector<Surfel> surfels = cloud(100);
  surfels[3].P.x = nan;
  surfels[4].N = V3f(0);
  surfels[5].area = kInfinity;
  surfels[6].area = 0;
  surfels[7].radius = nan;
  surfels[8].P = V3f(kInfinity, 0, 0);
  const PointTree tree(surfels);
  EXPECT_EQ(tree.refused(), 6u);
  EXPECT_EQ(tree.places()[3], PointTree::kRefused);
  EXPECT_EQ(tree.surfels().size(), 94u);
  EXPECT_TRUE(PointTree({}).empty());
  // All in one place: the depth ends it.
  std::vector<Surfel> heap = cloud(10000);
  for (Surfel& s : heap) s.P = V3f(1, 2, 3);
  const PointTree one(heap);
  EXPECT_LE(one.nodes().size(), 64u);
  EXPECT_TRUE(std::isfinite(lookAt(one, 0, {0, 0, 1}).area));
  // Far apart, or too far away to be told from where.
  heap[0].P = V3f(1e14f), heap[1].P = V3f(-1e14f), heap[2].P = V3f(1e30f);
  const PointTree wide(heap);
  EXPECT_EQ(wide.refused(), 1u);
  EXPECT_TRUE(std::isfinite(wide.nodes()[0].radius));
}

TEST(PointTree, MemoryIsCounted) {
  const PointTree tree(cloud(20000));
  const double perSurfel = static_cast<double>(tree.memory()) / 20000;
  EXPECT_GT(perSurfel, sizeof(Surfel));
  EXPECT_LT(perSurfel, 320);
}

}  // namespace
}  // namespace patina
