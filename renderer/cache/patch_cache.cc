// SPDX-License-Identifier: Apache-2.0
// Tables of the multiresolution cache.
#include "renderer/cache/patch_cache.h"

#include <sys/mman.h>
#include <unistd.h>

#include <bit>
#include <new>
#include <thread>

#include "renderer/base/sampling.h"

namespace patina {
namespace {

__extension__ using Wide = unsigned __int128;

// A tag: patch 32 | front 1 | depth 4 | block 5 | bounces 4 | valid 1 | used 1 | locked 1 | version 15. Zero
// is an empty slot. Block 0 is the coarse or medium level's only one; the fine level has 1 to 16. A slot that
// is locked is being written: if it is valid, what it holds stays, and more is added to it.
constexpr uint64_t kVersionMask = (uint64_t{1} << 15) - 1;
constexpr uint64_t kLocked = uint64_t{1} << 15;
constexpr uint64_t kUsed = uint64_t{1} << 16;
constexpr uint64_t kValid = uint64_t{1} << 17;
constexpr int kBouncesShift = 18, kBlockShift = 22, kDepthShift = 27, kFrontShift = 31, kPatchShift = 32;
constexpr uint64_t kKeyMask = ~(kVersionMask | kLocked | kUsed);

constexpr std::array<uint32_t, 2> kWords{4, kMaxBlockVertices};
constexpr std::array<double, 2> kShare{0.25, 0.75};  // of the budget

template <class Word>
constexpr size_t bytesOfSlot(uint32_t words) {
  return sizeof(uint64_t) + words * sizeof(Word);
}

bool isFine(uint64_t tag) { return (tag >> kBlockShift & 31) != 0; }

/// Of a key's 16 slots, so many are kept for fine blocks when space is short; beyond, they give way to medium
/// entries. To make a medium entry anew takes 25 vertices, and whatever those look up is made anew, too, if
/// it is gone, so few misses become many.
constexpr uint32_t kFineFloor = 4;

}  // namespace

template <class Word>
uint64_t PatchCacheOf<Word>::keyBits(const CacheKey& key, Level level) {
  return uint64_t{key.patch} << kPatchShift | uint64_t{key.front} << kFrontShift |
         uint64_t{key.depth & 15u} << kDepthShift |
         (level == Level::Fine ? (key.block & 15u) + uint64_t{1} : 0) << kBlockShift |
         uint64_t{key.bounces & 15u} << kBouncesShift | kValid;
}

template <class Word>
PatchCacheOf<Word>::PatchCacheOf(size_t bytes) {
  for (size_t which = 0; which < tables_.size(); ++which) {
    Table& table = tables_[which];
    table.words = kWords[which];
    const size_t perSet = kWays * bytesOfSlot<Word>(table.words);
    table.sets = static_cast<size_t>(static_cast<double>(bytes) * kShare[which]) / perSet;
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
    // Codes may be smaller than tags, which come first.
    table.data = static_cast<std::atomic<Word>*>(static_cast<void*>(table.tags + table.sets * kWays));
    capacity_ += table.bytes;
  }
}

template <class Word>
PatchCacheOf<Word>::~PatchCacheOf() {
  for (Table& table : tables_)
    if (table.memory) munmap(table.memory, table.bytes);
}

/// Where a key may be: the ways of two sets.
template <class Word>
typename PatchCacheOf<Word>::Places PatchCacheOf<Word>::placesOf(const Table& table, uint64_t keyBits) {
  const uint64_t hash = mixBits(keyBits);
  const auto slotOf = [&](uint64_t h) { return static_cast<uint64_t>((Wide{h} * table.sets) >> 64) * kWays; };
  return {{slotOf(hash), slotOf(std::rotl(hash, 32))}, static_cast<uint32_t>(hash)};
}

template <class Word>
bool PatchCacheOf<Word>::find(const CacheKey& key, Level level, std::span<const uint32_t> which,
                              Word* codes) const {
  Probe at = probe(key, level);
  locate(at, which);
  return read(at, which, codes);
}

template <class Word>
typename PatchCacheOf<Word>::Probe PatchCacheOf<Word>::probe(const CacheKey& key, Level level) const {
  const Table& table = this->table(level);
  Probe at{keyBits(key, level), {0, 0}, kNoSlot, level};
  if (table.sets == 0) return at;
  at.first = placesOf(table, at.wanted).first;
  for (const uint64_t first : at.first) __builtin_prefetch(&table.tags[first]);
  return at;
}

template <class Word>
void PatchCacheOf<Word>::locate(Probe& at, std::span<const uint32_t> which) const {
  const Table& table = this->table(at.level);
  if (table.sets == 0) return;
  for (const uint64_t first : at.first)
    for (uint64_t slot = first; slot < first + kWays; ++slot) {
      if ((table.tags[slot].load(std::memory_order_relaxed) & kKeyMask) != at.wanted) continue;
      at.slot = slot;
      const std::atomic<Word>* data = table.data + slot * table.words;
      __builtin_prefetch(&data[which.front()]);
      __builtin_prefetch(&data[which.back()]);
      return;
    }
}

template <class Word>
bool PatchCacheOf<Word>::read(const Probe& at, std::span<const uint32_t> which, Word* codes) const {
  if (at.slot == kNoSlot) return false;
  const Table& table = this->table(at.level);
  std::atomic<uint64_t>& its = table.tags[at.slot];
  const uint64_t tag = its.load(std::memory_order_acquire);
  if ((tag & kKeyMask) != at.wanted) return false;  // it was evicted meanwhile
  const std::atomic<Word>* data = table.data + at.slot * table.words;
  for (size_t k = 0; k < which.size(); ++k) codes[k] = data[which[k]].load(std::memory_order_acquire);
  const uint64_t after = its.load(std::memory_order_relaxed);
  if ((after & ~(kUsed | kLocked)) != (tag & ~(kUsed | kLocked))) return false;
  if (!(after & kUsed)) {
    uint64_t expected = after;
    its.compare_exchange_strong(expected, after | kUsed, std::memory_order_relaxed);
  }
  return true;
}

template <class Word>
void PatchCacheOf<Word>::store(const CacheKey& key, Level level, std::span<const Word> codes) {
  const Table& table = this->table(level);
  if (table.sets == 0) return;
  while (!tryStore(table, key, level, codes)) std::this_thread::yield();
}

/// False: another thread was faster, or is at it.
template <class Word>
bool PatchCacheOf<Word>::tryStore(const Table& table, const CacheKey& key, Level level,
                                  std::span<const Word> codes) {
  const uint64_t wanted = keyBits(key, level);
  const Places places = placesOf(table, wanted);
  const auto write = [&](uint64_t slot, bool all) {
    std::atomic<Word>* const data = table.data + slot * table.words;
    for (size_t k = 0; k < codes.size(); ++k)
      if (all || codes[k] != kMissing) data[k].store(codes[k], std::memory_order_release);
  };
  // The entry itself, an empty slot, or the first slot that was not used since the hand last passed (CLOCK).
  uint64_t victim = kNoSlot, tag = 0;
  for (uint32_t way = 0; way < 2 * kWays; ++way) {
    const uint64_t slot = places.slot(way);
    tag = table.tags[slot].load(std::memory_order_acquire);
    if (tag == 0 || ((tag ^ wanted) & kKeyMask & ~kValid) != 0) continue;
    if ((tag & kLocked) ||
        !table.tags[slot].compare_exchange_strong(tag, tag | kLocked, std::memory_order_acq_rel))
      return false;
    write(slot, false);
    table.tags[slot].fetch_and(~kLocked, std::memory_order_release);
    return true;
  }
  for (uint32_t way = 0; way < 2 * kWays && victim == kNoSlot; ++way) {
    tag = table.tags[places.slot(way)].load(std::memory_order_acquire);
    if (tag == 0) victim = places.slot(way);
  }
  // Whether a fine block gives way, or another kind of entry.
  uint32_t fine = level == Level::Fine ? 1 : 0;
  for (uint32_t way = 0; way < 2 * kWays && victim == kNoSlot; ++way)
    fine += isFine(table.tags[places.slot(way)].load(std::memory_order_relaxed));
  const bool fineGives = fine > kFineFloor;
  for (uint32_t step = 0; step < 4 * kWays && victim == kNoSlot; ++step) {
    const uint64_t slot = places.slot((places.start + step) % (2 * kWays));
    tag = table.tags[slot].load(std::memory_order_acquire);
    if (!(tag & kValid) || (tag & kLocked) || isFine(tag) != fineGives) continue;  // or the other kind
    if (tag & kUsed)
      table.tags[slot].compare_exchange_strong(tag, tag & ~kUsed, std::memory_order_relaxed);
    else
      victim = slot;
  }
  if (victim == kNoSlot) return true;
  // Vertices at depth 0 are used by one bucket and its neighbours: they are the first to go.
  const uint64_t used = level == Level::Fine && key.depth == 0 ? 0 : kUsed;
  const uint64_t version = (tag + 1) & kVersionMask;
  // Who wants to store the same sees that it is being done.
  const uint64_t busy = (wanted & ~kValid) | kLocked | version;
  if (!table.tags[victim].compare_exchange_strong(tag, busy, std::memory_order_acq_rel)) return false;
  write(victim, true);
  table.tags[victim].store(wanted | used | version, std::memory_order_release);
  const auto depthOf = [](uint64_t t) { return static_cast<size_t>(t >> kDepthShift & 15); };
  counts_[static_cast<size_t>(level)].entries[depthOf(wanted)].fetch_add(1, std::memory_order_relaxed);
  if (tag == 0) return true;
  const Level evicted = level == Level::Coarse ? Level::Coarse : isFine(tag) ? Level::Fine : Level::Medium;
  Counts& counts = counts_[static_cast<size_t>(evicted)];
  counts.entries[depthOf(tag)].fetch_sub(1, std::memory_order_relaxed);
  counts.evictions[depthOf(tag)].fetch_add(1, std::memory_order_relaxed);
  return true;
}

template <class Word>
size_t PatchCacheOf<Word>::bytesPerSlot(Level level) const {
  return bytesOfSlot<Word>(table(level).words);
}

template <class Word>
size_t PatchCacheOf<Word>::resident() const {
  const auto page = static_cast<size_t>(sysconf(_SC_PAGESIZE));
  size_t pages = 0;
  std::array<unsigned char, 4096> chunk;
  for (const Table& table : tables_)
    for (size_t first = 0; first < table.bytes; first += chunk.size() * page) {
      const size_t bytes = std::min(chunk.size() * page, table.bytes - first),
                   count = (bytes + page - 1) / page;
      if (mincore(static_cast<char*>(table.memory) + first, bytes, chunk.data()) != 0) continue;
      for (size_t k = 0; k < count; ++k) pages += chunk[k] & 1u;
    }
  return pages * page;
}

template <class Word>
typename PatchCacheOf<Word>::Use PatchCacheOf<Word>::use(Level level, int depth) const {
  const Counts& counts = counts_[static_cast<size_t>(level)];
  const auto d = static_cast<size_t>(depth);
  const size_t entries = counts.entries[d].load();
  return {entries, counts.evictions[d].load(), entries * bytesPerSlot(level)};
}

template class PatchCacheOf<uint64_t>;
template class PatchCacheOf<uint32_t>;

}  // namespace patina
