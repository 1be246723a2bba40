// SPDX-License-Identifier: Apache-2.0
// The stack of open blocks.
#include "renderer/scene/graphics_state.h"

namespace patina {

std::string_view name(BlockKind kind) {
  static constexpr std::array<std::string_view, kBlockKinds> kNames = {
      "Frame", "World", "Attribute", "Transform", "Solid", "Object", "Motion", "Resource"};
  return kNames[static_cast<size_t>(kind)];
}

void BlockStack::push(BlockKind kind, const Location& where) {
  int& last = last_[static_cast<size_t>(kind)];
  blocks_.push_back({kind, where, last});
  last = static_cast<int>(blocks_.size()) - 1;
}

BlockStack::Block BlockStack::pop() {
  const Block block = blocks_.back();
  blocks_.pop_back();
  last_[static_cast<size_t>(block.kind)] = block.outer;
  return block;
}

bool BlockStack::mayClose(BlockKind kind) const {
  const int begin = last(kind);
  if (begin < 0 || kind == BlockKind::Frame) return begin >= 0;
  if (begin < last(BlockKind::Frame)) return false;
  return kind == BlockKind::World || (begin >= last(BlockKind::World) && begin >= last(BlockKind::Object));
}

}  // namespace patina
