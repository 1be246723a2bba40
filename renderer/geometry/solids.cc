// SPDX-License-Identifier: Apache-2.0
// Trees of solids: what counts of them, and where points are.
#include "renderer/geometry/solids.h"

namespace patina {

void SolidState::begin(const SolidTree& tree) {
  tree_ = &tree;
  counts_.assign(tree.nodes.size(), 0);
  inside_ = false;
}

void SolidState::setLeaf(uint32_t leaf, bool inside) {
  if (insideLeaf(leaf) == inside) return;
  counts_[leaf] = inside ? 1 : 0;
  // Upwards as long as something changes.
  for (uint32_t node = leaf;;) {
    const uint32_t parent = tree_->nodes[node].parent;
    if (parent == kNone) {
      inside_ = inside;
      return;
    }
    const SolidTree::Node& above = tree_->nodes[parent];
    const bool before = SolidTree::inside(above, counts_[parent]);
    counts_[parent] += inside ? tree_->nodes[node].step : 0u - tree_->nodes[node].step;
    inside = SolidTree::inside(above, counts_[parent]);
    if (inside == before) return;
    node = parent;
  }
}

PrunedSolid pruneSolid(const Solid& solid, std::span<const LeafContent> content) {
  using Operation = Solid::Operation;
  using Fate = PrunedSolid::Fate;
  enum class Value : uint8_t { Empty, Absent, There };
  const auto count = static_cast<uint32_t>(solid.nodes.size());
  struct Operands {
    uint32_t all = 0, there = 0, empty = 0;
    uint32_t first = kNone;
  };
  std::vector<Operands> operands(count);
  std::vector<Value> value(count);
  // Operands come behind their operation: they are judged first.
  for (uint32_t k = count; k-- > 0;) {
    const Solid::Node& node = solid.nodes[k];
    const Operands& o = operands[k];
    if (node.operation == Operation::Primitive) {
      value[k] = node.absent || content[k] == LeafContent::Open ? Value::Absent
                 : content[k] == LeafContent::Empty             ? Value::Empty
                                                                : Value::There;
    } else if (o.all == 0) {
      value[k] = Value::Empty;
    } else if (node.operation == Operation::Difference) {
      value[k] = value[o.first];
    } else {
      const bool emptied = o.empty > 0 && (node.operation == Operation::Intersection || o.there == 0);
      value[k] = emptied ? Value::Empty : o.there > 0 ? Value::There : Value::Absent;
    }
    if (node.parent == kNone) continue;
    Operands& above = operands[node.parent];
    ++above.all;
    above.there += value[k] == Value::There;
    above.empty += value[k] == Value::Empty;
    above.first = k;
  }

  // Downwards: what is there below what is there. An operation of one operand is that operand.
  PrunedSolid result;
  result.fates.assign(count, Fate::Removed);
  result.leaf.assign(count, kNone);
  struct Slot {
    uint32_t parent = kNone;  // of result.tree
    uint32_t step = 1;
    bool live = false, subtracted = false;
  };
  std::vector<Slot> slots(count);
  std::vector<SolidTree::Node>& nodes = result.tree.nodes;
  std::vector<uint32_t> made(count, kNone);  // node of the tree
  bool removed = false;
  for (uint32_t k = 0; k < count; ++k) {
    const Solid::Node& node = solid.nodes[k];
    Slot& slot = slots[k];
    if (node.parent == kNone) {
      slot.live = value[k] == Value::There;
    } else {
      const uint32_t parent = node.parent;
      const bool other =
          solid.nodes[parent].operation == Operation::Difference && operands[parent].first != k;
      const Slot& above = slots[parent];
      slot = above;
      slot.live = above.live && value[k] == Value::There;
      slot.subtracted = above.subtracted != other;
      if (operands[parent].there > 1) slot.parent = made[parent], slot.step = other ? 2 : 1;
    }
    if (node.operation == Operation::Primitive) {
      if (value[k] == Value::Absent) result.fates[k] = Fate::Absent;
      removed |= value[k] == Value::There && !slot.live;
      if (!slot.live) continue;
      result.fates[k] = Fate::Kept;
      result.leaf[k] = static_cast<uint32_t>(nodes.size());
      nodes.push_back({slot.parent, slot.step, 1, SolidTree::Rule::Facing, slot.subtracted});
    } else if (slot.live && operands[k].there > 1) {
      made[k] = static_cast<uint32_t>(nodes.size());
      const uint32_t full = node.operation == Operation::Union          ? 0
                            : node.operation == Operation::Intersection ? operands[k].there
                                                                        : 1;
      nodes.push_back({slot.parent, slot.step, full});
    }
  }
  result.emptied = removed;
  if (nodes.size() == 1) {  // a leaf alone
    nodes.clear();
    for (Fate& fate : result.fates)
      if (fate == Fate::Kept) fate = Fate::Absent;
  }
  return result;
}

}  // namespace patina
