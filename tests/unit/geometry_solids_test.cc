// SPDX-License-Identifier: Apache-2.0
// Trees of solids against their truth tables, and which surfaces count as closed.
#include "renderer/geometry/solids.h"

#include <gtest/gtest.h>

#include <random>

#include "geometry_surface_fixtures.h"

namespace patina {
namespace {

using Operation = Solid::Operation;
using Fate = PrunedSolid::Fate;

/// Whether a point is inside, straight from the definition; an absent operand is not there.
enum class Truth { Absent, Out, In };
Truth evaluate(const Solid& solid, uint32_t node, const std::vector<LeafContent>& content,
               const std::vector<bool>& inside) {
  const Solid::Node& n = solid.nodes[node];
  if (n.operation == Operation::Primitive) {
    if (content[node] == LeafContent::Open) return Truth::Absent;
    return content[node] == LeafContent::Closed && inside[node] ? Truth::In : Truth::Out;
  }
  std::vector<Truth> operands;
  for (uint32_t k = 0; k < solid.nodes.size(); ++k)
    if (solid.nodes[k].parent == node) operands.push_back(evaluate(solid, k, content, inside));
  if (operands.empty()) return Truth::Out;
  if (n.operation == Operation::Difference) {
    if (operands[0] != Truth::In) return operands[0];
    return std::count(operands.begin() + 1, operands.end(), Truth::In) > 0 ? Truth::Out : Truth::In;
  }
  std::erase(operands, Truth::Absent);
  if (operands.empty()) return Truth::Absent;
  const auto in = std::count(operands.begin(), operands.end(), Truth::In);
  const bool is = n.operation == Operation::Union ? in > 0 : in == static_cast<ptrdiff_t>(operands.size());
  return is ? Truth::In : Truth::Out;
}

TEST(SolidTree, RandomTreesAgreeWithTheDefinition) {
  std::mt19937 random(4);
  const auto upTo = [&](int n) { return std::uniform_int_distribution<int>(0, n)(random); };
  int trees = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    Solid solid;
    solid.nodes.push_back({static_cast<Operation>(1 + upTo(2)), kNone, {}});
    // Operands come after their operation, each operation's together or not.
    for (int k = upTo(14); k >= 0; --k) {
      uint32_t parent;
      do {
        parent = static_cast<uint32_t>(upTo(static_cast<int>(solid.nodes.size()) - 1));
      } while (solid.nodes[parent].operation == Operation::Primitive);
      solid.nodes.push_back({static_cast<Operation>(std::max(upTo(7) - 4, 0)), parent, {}});
    }
    const auto count = static_cast<uint32_t>(solid.nodes.size());
    std::vector<LeafContent> content(count, LeafContent::Closed);
    for (LeafContent& c : content)
      if (const int special = upTo(11); special < 2) c = static_cast<LeafContent>(special);
    const PrunedSolid pruned = pruneSolid(solid, content);
    trees += !pruned.tree.nodes.empty();
    for (uint32_t k = 0; k < pruned.tree.nodes.size(); ++k)
      ASSERT_TRUE(pruned.tree.nodes[k].parent == kNone ? k == 0 : pruned.tree.nodes[k].parent < k);

    SolidState state;
    state.begin(pruned.tree);
    std::vector<bool> inside(count, false);
    for (int step = 0; step < 40; ++step) {
      const auto leaf = static_cast<uint32_t>(upTo(static_cast<int>(count) - 1));
      if (solid.nodes[leaf].operation != Operation::Primitive) continue;
      const Truth before = evaluate(solid, 0, content, inside);
      inside[leaf] = !inside[leaf];
      const Truth after = evaluate(solid, 0, content, inside);
      if (content[leaf] == LeafContent::Closed && pruned.fates[leaf] != Fate::Kept &&
          !pruned.tree.nodes.empty()) {
        ASSERT_EQ(before, after) << "a leaf that was left out would have counted";
      }
      if (pruned.tree.nodes.empty()) continue;
      if (pruned.fates[leaf] == Fate::Kept) {
        state.setLeaf(pruned.leaf[leaf], inside[leaf]);
        if (before != after) {
          ASSERT_EQ((after == Truth::In) == inside[leaf], !pruned.tree.nodes[pruned.leaf[leaf]].subtracted);
        }
      }
      ASSERT_EQ(state.inside(), after == Truth::In);
    }
  }
  EXPECT_GT(trees, 500);
}

TEST(SolidTree, DeepNestingOfSingleOperandsTakesNoTime) {
  Solid solid;
  constexpr uint32_t kDeep = 100000;
  for (uint32_t k = 0; k < kDeep; ++k) solid.nodes.push_back({Operation::Union, k == 0 ? kNone : k - 1, {}});
  for (int k = 0; k < 2; ++k) solid.nodes.push_back({Operation::Primitive, kDeep - 1, {}});
  const PrunedSolid pruned =
      pruneSolid(solid, std::vector<LeafContent>(solid.nodes.size(), LeafContent::Closed));
  EXPECT_EQ(pruned.tree.nodes.size(), 3u);
}

Primitive quadric(Quadric::Kind kind, std::array<float, 6> values, float thetaMax = 360) {
  Quadric q;
  q.kind = kind, q.values = values, q.thetaMax = thetaMax;
  return test::primitive(q);
}

struct Part {
  Primitive primitive;
  M44f toMesh{};
  bool reversed = false;
};

LeafReport examine(std::vector<Part> parts) {
  std::vector<test::Made> made;
  std::vector<LeafSurface> surfaces;
  for (const Part& part : parts) made.push_back(test::make(part.primitive));
  for (size_t k = 0; k < parts.size(); ++k)
    surfaces.push_back({&*made[k], parts[k].toMesh, parts[k].reversed});
  return examineLeaf(surfaces);
}

Primitive box(std::vector<int> corners, size_t faces) {
  corners.resize(4 * faces);
  return test::primitive(
      test::polygons(std::vector<int>(faces, 4), corners),
      {-1, -1, -1, 1, -1, -1, -1, 1, -1, 1, 1, -1, -1, -1, 1, 1, -1, 1, -1, 1, 1, 1, 1, 1});
}
const std::vector<int> kOutward{0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};

TEST(ExamineLeaf, WhatIsClosedAndWhichWayItFaces) {
  using Kind = Quadric::Kind;
  using Rule = SolidTree::Rule;
  const Primitive sphere = quadric(Kind::Sphere, {1, -1, 1}), half = quadric(Kind::Sphere, {1, -1, 1}, 180),
                  torus = quadric(Kind::Torus, {1, 0.3f, 0, 360}), tube = quadric(Kind::Cylinder, {1, 0, 2}),
                  low = quadric(Kind::Disk, {0, 1}), high = quadric(Kind::Disk, {2, 1});
  const auto expect = [](const LeafReport& report, Rule rule, std::vector<bool> turned) {
    EXPECT_TRUE(report.closed);
    EXPECT_EQ(report.rule, rule);
    EXPECT_EQ(report.turned, turned);
  };
  expect(examine({{sphere}}), Rule::Facing, {false});
  expect(examine({{sphere, {}, true}}), Rule::Facing, {true});
  expect(examine({{torus}}), Rule::Facing, {false});
  M44f mirror, tilt, aside, inner;
  mirror.setScale(V3f(-1, 2, 1));
  tilt.setAxisAngle(V3f(1, 0, 0), kPi / 2);
  aside.setTranslation(V3f(1, 0, 0));
  inner.setScale(V3f(0.5f));
  expect(examine({{torus, mirror}}), Rule::Facing, {false});
  // The near cap of a cylinder faces in as RI's disks do.
  expect(examine({{tube}, {low}, {high}}), Rule::Facing, {false, true, false});
  expect(examine({{tube}, {low, {}, true}, {high}}), Rule::Facing, {false, false, false});
  // Half of a sphere, for y > 0, and a disk in the plane y = 0.
  EXPECT_TRUE(examine({{half}, {low, tilt}}).closed);
  expect(examine({{box(kOutward, 6)}}), Rule::Facing, {false});
  expect(examine({{sphere}, {sphere, aside}}), Rule::Winding, {false, false});
  expect(examine({{sphere}, {sphere, inner, true}}), Rule::Facing, {false, false});
  // Faces of one mesh that do not agree.
  std::vector<int> mixed = kOutward;
  std::swap(mixed[1], mixed[3]);
  expect(examine({{box(mixed, 6)}}), Rule::Parity, {false});

  for (const LeafReport& open :
       {examine({{tube}}), examine({{tube}, {low}}), examine({{half}}), examine({{low}}),
        examine({{quadric(Kind::Sphere, {1, -0.9f, 1})}}), examine({{box(kOutward, 5)}}),
        examine({{quadric(Kind::Torus, {1, 0.3f, 0, 350})}})})
    EXPECT_FALSE(open.closed);
}

}  // namespace
}  // namespace patina
