// SPDX-License-Identifier: Apache-2.0
// Tables of the multiresolution cache.
#include "renderer/cache/patch_cache.h"

#include <sys/mman.h>

#include <new>

#include "renderer/base/sampling.h"

namespace patina {
namespace {

__extension__ using Wide = unsigned __int128;

// A tag: patch 32 | front 1 | depth 4 | valid 1 | used 1 | version 25. Zero is an empty slot.
constexpr uint64_t kVersionMask = (uint64_t{1} << 25) - 1;
constexpr uint64_t kUsed = uint64_t{1} << 25;
constexpr uint64_t kValid = uint64_t{1} << 26;
constexpr uint64_t kKeyMask = ~(kVersionMask | kUsed);

constexpr std::array<uint32_t, kLevels> kWords{4, 25,
                                               kMaxVertices};   // vertices of the largest patch per level
constexpr std::array<double, kLevels> kShare{0.25, 0.25, 0.5};  // of the budget: coarse, medium, fine

}  // namespace

uint64_t PatchCache::keyBits(const CacheKey& key) {
  return uint64_t{key.patch} << 32 | uint64_t{key.front} << 31 | uint64_t{key.depth & 15u} << 27 | kValid;
}

PatchCache::PatchCache(size_t bytes) {
  for (int level = 0; level < kLevels; ++level) {
    Table& table = tables_[static_cast<size_t>(level)];
    table.words = kWords[static_cast<size_t>(level)];
    const size_t perSet = kWays * (table.words + 1) * sizeof(uint64_t);
    table.sets =
        static_cast<size_t>(static_cast<double>(bytes) * kShare[static_cast<size_t>(level)]) / perSet;
    if (table.sets == 0) continue;
    table.bytes = table.sets * perSet;
    table.memory = mmap(nullptr, table.bytes, PROT_READ | PROT_WRITE,
                        MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (table.memory == MAP_FAILED) {
      table.memory = nullptr;
      throw std::bad_alloc();
    }
    // Zeroed pages are valid atomics of value zero: empty slots.
    table.tags = static_cast<std::atomic<uint64_t>*>(table.memory);
    table.data = table.tags + table.sets * kWays;
    capacity_ += table.bytes;
  }
}

PatchCache::~PatchCache() {
  for (Table& table : tables_)
    if (table.memory) munmap(table.memory, table.bytes);
}

bool PatchCache::find(const CacheKey& key, Level level, std::span<const uint32_t> which,
                      uint64_t* codes) const {
  const Table& table = tables_[static_cast<size_t>(level)];
  if (table.sets == 0) return false;
  const uint64_t wanted = keyBits(key);
  const uint64_t set = static_cast<uint64_t>((Wide{mixBits(wanted)} * table.sets) >> 64);
  std::atomic<uint64_t>* tags = table.tags + set * kWays;
  for (uint32_t way = 0; way < kWays; ++way) {
    const uint64_t tag = tags[way].load(std::memory_order_acquire);
    if ((tag & kKeyMask) != wanted) continue;
    const std::atomic<uint64_t>* data = table.data + (set * kWays + way) * table.words;
    for (size_t k = 0; k < which.size(); ++k) codes[k] = data[which[k]].load(std::memory_order_acquire);
    const uint64_t after = tags[way].load(std::memory_order_relaxed);
    if ((after & ~kUsed) != (tag & ~kUsed)) return false;
    if (!(after & kUsed)) {
      uint64_t expected = after;
      tags[way].compare_exchange_strong(expected, after | kUsed, std::memory_order_relaxed);
    }
    return true;
  }
  return false;
}

void PatchCache::store(const CacheKey& key, Level level, std::span<const uint64_t> codes) {
  Table& table = tables_[static_cast<size_t>(level)];
  if (table.sets == 0) return;
  const uint64_t wanted = keyBits(key);
  const uint64_t hash = mixBits(wanted);
  const uint64_t set = static_cast<uint64_t>((Wide{hash} * table.sets) >> 64);
  std::atomic<uint64_t>* tags = table.tags + set * kWays;

  // The entry itself, an empty slot, or the first slot that was not used since the hand last passed (CLOCK).
  uint32_t victim = kWays;
  uint64_t tag = 0;
  for (uint32_t way = 0; way < kWays && victim == kWays; ++way) {
    tag = tags[way].load(std::memory_order_acquire);
    if ((tag & kKeyMask) == wanted) victim = way;
  }
  for (uint32_t way = 0; way < kWays && victim == kWays; ++way) {
    tag = tags[way].load(std::memory_order_acquire);
    if (tag == 0) victim = way;
  }
  const auto start = static_cast<uint32_t>(hash & (kWays - 1));
  for (uint32_t step = 0; step < 2 * kWays && victim == kWays; ++step) {
    const uint32_t way = (start + step) & (kWays - 1);
    tag = tags[way].load(std::memory_order_acquire);
    if (!(tag & kValid)) continue;  // being written
    if (tag & kUsed) {
      tags[way].compare_exchange_strong(tag, tag & ~kUsed, std::memory_order_relaxed);
      continue;
    }
    victim = way;
  }
  if (victim == kWays) return;
  const bool same = (tag & kKeyMask) == wanted;
  const uint64_t version = (tag + 1) & kVersionMask;
  // While it is written the tag is neither valid nor zero.
  const uint64_t busy = version | (version == 0 ? 1 : 0);
  if (!tags[victim].compare_exchange_strong(tag, busy, std::memory_order_acq_rel)) return;
  std::atomic<uint64_t>* data = table.data + (set * kWays + victim) * table.words;
  for (size_t k = 0; k < codes.size(); ++k)
    if (!same || codes[k] != PackedRgb::kMissing) data[k].store(codes[k], std::memory_order_release);
  tags[victim].store(wanted | kUsed | ((busy + 1) & kVersionMask), std::memory_order_release);
  if (same) return;
  const auto depthOf = [](uint64_t t) { return static_cast<size_t>(t >> 27 & 15); };
  table.entries[depthOf(wanted)].fetch_add(1, std::memory_order_relaxed);
  if (tag == 0) return;
  table.entries[depthOf(tag)].fetch_sub(1, std::memory_order_relaxed);
  table.evictions[depthOf(tag)].fetch_add(1, std::memory_order_relaxed);
}

size_t PatchCache::bytesPerSlot(Level level) const {
  return (tables_[static_cast<size_t>(level)].words + 1) * sizeof(uint64_t);
}

PatchCache::Use PatchCache::use(Level level, int depth) const {
  const Table& table = tables_[static_cast<size_t>(level)];
  const auto d = static_cast<size_t>(depth);
  const size_t entries = table.entries[d].load();
  return {entries, table.evictions[d].load(), entries * bytesPerSlot(level)};
}

}  // namespace patina
