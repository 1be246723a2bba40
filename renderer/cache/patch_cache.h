// SPDX-License-Identifier: Apache-2.0
// The multiresolution cache (Christensen et al. 2012, section 3): values at the vertices of patches, by
// patch, side, level and diffuse depth, in a fixed number of bytes.
//
// Each level has its own table, as its entries have their own size: the fine table is small and serves
// coherent look-ups, the medium and coarse tables hold many entries. A table is set-associative: a key may
// live in any of eight slots, whose tags share a cache line. All memory is reserved at once and touched as it
// is needed, so the budget holds at every moment.
//
// Hits take no lock: a reader copies the words that it wants and then checks that the tag is still the one it
// found; a writer makes the tag invalid first. A value depends on its key alone, so it does not matter who
// writes it, how often it is evicted, or that two threads may compute it at once.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <span>

#include "renderer/base/math.h"
#include "renderer/cache/packed_rgb.h"
#include "renderer/geometry/patches.h"

namespace patina {

struct CacheKey {
  uint32_t patch;
  bool front;
  uint8_t depth;  ///< diffuse depth of the hit; at most 15
};

class PatchCache {
 public:
  static constexpr int kDepths = 16;

  /// `bytes` for all three tables together. [main]
  explicit PatchCache(size_t bytes);
  ~PatchCache();
  PatchCache(const PatchCache&) = delete;
  PatchCache& operator=(const PatchCache&) = delete;

  /// Copies the codes of vertices `which` of an entry. False: the entry is not there. Missing vertices of
  /// entries that were stored in part read PackedRgb::kMissing. [any thread]
  bool find(const CacheKey& key, Level level, std::span<const uint32_t> which, uint64_t* codes) const;

  /// Stores an entry, in the place of one that has not been used for a while. `codes` holds all vertices of
  /// the level, in order; kMissing leaves what is there. May do nothing when the slot is being written by
  /// another thread. [any thread]
  void store(const CacheKey& key, Level level, std::span<const uint64_t> codes);

  struct Use {
    size_t entries, evictions, bytes;
  };
  Use use(Level level, int depth) const;
  size_t slots(Level level) const { return tables_[static_cast<size_t>(level)].sets * kWays; }
  size_t bytesPerSlot(Level level) const;
  size_t capacity() const { return capacity_; }  ///< bytes reserved in all, never more than asked for

 private:
  static constexpr uint32_t kWays = 8;
  struct Table {
    uint32_t words = 0;  ///< per slot
    uint64_t sets = 0;
    std::atomic<uint64_t>* tags = nullptr;
    std::atomic<uint64_t>* data = nullptr;
    size_t bytes = 0;
    void* memory = nullptr;
    std::array<std::atomic<uint64_t>, kDepths> entries{}, evictions{};  // by depth
  };
  static uint64_t keyBits(const CacheKey& key);

  std::array<Table, kLevels> tables_;
  size_t capacity_ = 0;
};

}  // namespace patina
