// SPDX-License-Identifier: Apache-2.0
// The multiresolution cache (Christensen et al. 2012, section 3): values at the vertices of patches, by
// patch, side, level and diffuse depth, in a fixed number of bytes.
//
// There are two tables: one of coarse entries (4 vertices), and one that medium entries and blocks of fine
// entries share, which both have up to 25 vertices: a patch of 16x16 micropolygons has one medium entry and
// 16 fine blocks of 4x4 cells with their rims, of which only those are kept that someone looked at. A key may
// live in any of the eight slots of two sets, each of which has its tags in one cache line. What was not used
// for a while gives way (CLOCK), fine blocks before medium entries. All memory is reserved at once and
// touched as it is needed, so the budget holds at every moment.
//
// Hits take no lock: a reader copies the words that it wants and then checks that the tag is still the one it
// found; who takes a slot for another key makes the tag invalid first. A value depends on its key alone, so
// it does not matter who writes it, how often it is evicted, or that two threads may compute it at once.
//
// What a value is, is the user's affair: a code of one word, 64 bits for radiosity (packed_rgb.h), 32 bits
// for opacity (packed_opacity.h). The code of all ones means that there is none.
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
  uint8_t depth;        ///< diffuse depth of the hit; at most 15
  uint8_t block = 0;    ///< of the fine level: 0 to 15; the other levels have one block
  uint8_t bounces = 0;  ///< of light that may still follow; at most 15
};

/// `Word`: uint64_t or uint32_t.
template <class Word>
class PatchCacheOf {
 public:
  static constexpr int kDepths = 16;
  static constexpr Word kMissing = static_cast<Word>(~Word{0});  ///< not the code of any value

  /// `bytes` for all tables together: nothing is kept when they hold no set. Throws std::bad_alloc.
  explicit PatchCacheOf(size_t bytes);
  ~PatchCacheOf();
  PatchCacheOf(const PatchCacheOf&) = delete;
  PatchCacheOf& operator=(const PatchCacheOf&) = delete;

  /// Copies the codes of vertices `which` of a block. False: the block is not there. Missing vertices of
  /// blocks that were stored in part read kMissing. [any thread]
  bool find(const CacheKey& key, Level level, std::span<const uint32_t> which, Word* codes) const;

  /// find() in three steps, for many keys at a time: each step asks memory for what the next one needs, and
  /// other keys' steps pass the time until it is there.
  struct Probe {
    uint64_t wanted;
    std::array<uint64_t, 2> first;  // slots of two sets
    uint64_t slot;
    Level level;
  };
  Probe probe(const CacheKey& key, Level level) const;               ///< [any thread]
  void locate(Probe& probe, std::span<const uint32_t> which) const;  ///< [any thread]
  /// What find() gives. [any thread]
  bool read(const Probe& probe, std::span<const uint32_t> which, Word* codes) const;

  /// Stores a block, in the place of one that has not been used for a while. `codes` holds all vertices of
  /// the block, in order; kMissing leaves what is there. Waits while another thread writes the same block;
  /// does nothing when all slots that it might take are being written. [any thread]
  void store(const CacheKey& key, Level level, std::span<const Word> codes);

  struct Use {
    size_t entries, evictions, bytes;
  };
  Use use(Level level, int depth) const;
  size_t slots(Level level) const { return table(level).sets * kWays; }  ///< medium and fine share theirs
  size_t bytesPerSlot(Level level) const;
  size_t capacity() const { return capacity_; }  ///< bytes reserved in all, never more than asked for
  /// Bytes of that which are in memory now, as the system counts them: whole pages. [any thread]
  size_t resident() const;

 private:
  static constexpr uint64_t kNoSlot = ~uint64_t{0};
  static constexpr uint32_t kWays = 8;
  struct Table {
    uint32_t words = 0;  ///< per slot
    uint64_t sets = 0;
    std::atomic<uint64_t>* tags = nullptr;
    std::atomic<Word>* data = nullptr;
    size_t bytes = 0;
    void* memory = nullptr;
  };
  struct Counts {
    std::array<std::atomic<uint64_t>, kDepths> entries{}, evictions{};  // by depth
  };
  struct Places {
    std::array<uint64_t, 2> first;  // slots of two sets
    uint32_t start;                 // where the hand is set
    uint64_t slot(uint32_t way) const { return first[way / kWays] + way % kWays; }
  };
  bool tryStore(const Table& table, const CacheKey& key, Level level, std::span<const Word> codes);
  static Places placesOf(const Table& table, uint64_t keyBits);
  static uint64_t keyBits(const CacheKey& key, Level level);
  const Table& table(Level level) const { return tables_[level == Level::Coarse ? 0 : 1]; }

  std::array<Table, 2> tables_;  // coarse; medium and fine
  std::array<Counts, kLevels> counts_;
  size_t capacity_ = 0;
};

using PatchCache = PatchCacheOf<uint64_t>;
extern template class PatchCacheOf<uint64_t>;
extern template class PatchCacheOf<uint32_t>;

}  // namespace patina
