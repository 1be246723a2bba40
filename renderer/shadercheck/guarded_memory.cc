// SPDX-License-Identifier: Apache-2.0
// Guard zones of a value that no shader writes by chance.
#include "renderer/shadercheck/guarded_memory.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace patina::shadercheck {
namespace {

constexpr size_t kGuard = 64;              // floats on each side
constexpr uint32_t kPattern = 0x7fc5a5a5;  // a NaN

void fill(float* begin) {
  for (size_t i = 0; i < kGuard; ++i) std::memcpy(begin + i, &kPattern, sizeof kPattern);
}
// The first float that is not the pattern any more, or kGuard.
size_t firstChanged(const float* begin) {
  for (size_t i = 0; i < kGuard; ++i)
    if (std::memcmp(begin + i, &kPattern, sizeof kPattern) != 0) return i;
  return kGuard;
}

}  // namespace

GuardedMemory::Block& GuardedMemory::add(size_t size, std::string name) {
  const size_t floats = size + 2 * kGuard;
  blocks_.push_back(
      {std::unique_ptr<float[], Free>(new (std::align_val_t{64}) float[floats]), size, {}, std::move(name)});
  Block& block = blocks_.back();
  fill(block.data.get());
  fill(block.data.get() + kGuard + size);
  return block;
}

const float* GuardedMemory::input(std::span<const float> values, std::string name) {
  Block& block = add(values.size(), std::move(name));
  block.original.assign(values.begin(), values.end());
  std::copy(values.begin(), values.end(), block.data.get() + kGuard);
  return block.data.get() + kGuard;
}

float* GuardedMemory::output(size_t size, std::string name) {
  return add(size, std::move(name)).data.get() + kGuard;
}

GuardedMemory::Damage GuardedMemory::findDamage() const {
  for (const Block& block : blocks_) {
    const float* plane = block.data.get() + kGuard;
    if (const size_t at = firstChanged(plane + block.size); at < kGuard)
      return {"wrote behind the end of " + block.name,
              fmt::format("index {} of a plane of {}", block.size + at, block.size)};
    if (const size_t at = firstChanged(block.data.get()); at < kGuard)
      return {"wrote before the beginning of " + block.name, fmt::format("{} floats before", kGuard - at)};
    if (!block.original.empty() && std::memcmp(plane, block.original.data(), block.size * sizeof(float)) != 0)
      return {"wrote into its input " + block.name, ""};
  }
  return {};
}

}  // namespace patina::shadercheck
