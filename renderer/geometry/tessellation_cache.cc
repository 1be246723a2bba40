// SPDX-License-Identifier: Apache-2.0
// Making, meeting and dropping of tessellations.
#include "renderer/geometry/tessellation_cache.h"

#include <linux/membarrier.h>
#include <sys/syscall.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include <algorithm>
#include <deque>
#include <thread>

#include "renderer/base/statistics.h"

namespace patina {
namespace {

STAT_COUNTER("Geometry/units tessellated", unitsMade);
STAT_COUNTER("Geometry/units tessellated again", unitsMadeAgain);
STAT_COUNTER("Geometry/units dropped", unitsDropped);

// membarrier(2), command PRIVATE_EXPEDITED: all threads of the process pass a fence.
bool fenceAllThreads(int command) { return syscall(SYS_membarrier, command, 0, 0) == 0; }

}  // namespace

// Sanitizers do not know membarrier.
#if defined(__SANITIZE_THREAD__)
const bool TessellationCache::ordersReaders = true;
#else
const bool TessellationCache::ordersReaders = !fenceAllThreads(MEMBARRIER_CMD_REGISTER_PRIVATE_EXPEDITED);
#endif

/// When the Reader of each thread began. Slots of threads that have ended are used again.
class Epochs {
 public:
  struct alignas(64) Slot {
    std::atomic<uint64_t> began = 0;
    bool taken = false;
  };
  static Epochs& all() {
    static Epochs* const epochs = new Epochs;  // never destroyed: threads end after main()
    return *epochs;
  }
  Slot* take() {
    const std::scoped_lock lock(mutex_);
    const auto free = std::find_if(slots_.begin(), slots_.end(), [](const Slot& s) { return !s.taken; });
    Slot& slot = free == slots_.end() ? slots_.emplace_back() : *free;
    slot.taken = true;
    return &slot;
  }
  void giveBack(Slot* slot) {
    const std::scoped_lock lock(mutex_);
    slot->taken = false;
  }
  /// Returns when no Reader is left that began before the call. What the caller wrote before is seen by all
  /// Readers that begin later: either they have passed the fence here, or their epoch is seen below.
  void waitForReaders() {
    const uint64_t epoch = TessellationCache::currentEpoch.fetch_add(1) + 1;
    if (!TessellationCache::ordersReaders) fenceAllThreads(MEMBARRIER_CMD_PRIVATE_EXPEDITED);
    const std::scoped_lock lock(mutex_);
    for (const Slot& slot : slots_)
      for (uint64_t began = slot.began.load(); began != 0 && began < epoch; began = slot.began.load())
        std::this_thread::yield();
  }

 private:
  std::mutex mutex_;
  std::deque<Slot> slots_;  // slots never move
};

std::atomic<uint64_t>& TessellationCache::takeEpoch() {
  struct Owner {
    Epochs::Slot* slot = Epochs::all().take();
    ~Owner() { Epochs::all().giveBack(slot); }
  };
  thread_local const Owner owner;
  return *(threadEpoch = &owner.slot->began);
}

TessellationCache::TessellationCache(size_t units, size_t budget) : units_(units), budget_(budget) {}

TessellationCache::~TessellationCache() { clear(); }

void TessellationCache::clear() {
  for (Unit& unit : units_) delete unit.resident.exchange(nullptr);
  resident_.clear();
  bytes_ = 0;
  make_ = nullptr;
  measure_ = nullptr;
}

void TessellationCache::setMaker(Make make, Measure measure) {
  make_ = std::move(make);
  measure_ = std::move(measure);
}

size_t TessellationCache::bytesOfAll() const {
  size_t sum = 0;
  for (const Unit& unit : units_) sum += unit.bytes;
  return sum;
}

void TessellationCache::load(uint32_t index) const {
  Unit& unit = units_[index];
  const std::scoped_lock lock(unit.mutex);
  if (unit.resident.load()) return;
  makeRoom(unit.bytes);
  const size_t before = measure_();
  std::unique_ptr<Tessellation> made;
  // Tasks of others must not run here meanwhile: they might want this very unit.
  tbb::this_task_arena::isolate([&] { made = make_(index); });
  bytes_ += made->bytes();
  unit.bytes = std::max(measure_(), before) - before + made->bytes();
  size_t peak = peak_;
  for (const size_t now = used(); now > peak && !peak_.compare_exchange_weak(peak, now);) {
  }
  const bool again = unit.made.exchange(true);
  ++(again ? unitsMadeAgain : unitsMade);
  madeAgain_ += again;
  unit.lastMet = ++clock_;
  unit.resident.store(made.release());
  {
    const std::scoped_lock evictLock(evictMutex_);
    resident_.push_back(index);
  }
  makeRoom(0);
}

// Drops what was met least recently until `bytes` more fit; a little more than that, so that it is not done
// for every unit.
void TessellationCache::makeRoom(size_t bytes) const {
  while (used() + bytes > budget_) {
    std::vector<std::unique_ptr<const Tessellation>> dropped;
    {
      const std::scoped_lock lock(evictMutex_);
      if (resident_.size() <= 1) return;  // the last one is being asked for
      const size_t count = std::max<size_t>(resident_.size() / 16, 1);
      // By a copy of when they were met: Readers go on writing that.
      std::vector<std::pair<uint32_t, uint32_t>> order;
      for (const uint32_t unit : resident_) order.emplace_back(units_[unit].lastMet, unit);
      std::nth_element(order.begin(), order.begin() + static_cast<ptrdiff_t>(count) - 1, order.end());
      for (size_t k = 0; k < count; ++k)
        dropped.emplace_back(units_[order[k].second].resident.exchange(nullptr));
      resident_.clear();
      for (size_t k = count; k < order.size(); ++k) resident_.push_back(order[k].second);
    }
    unitsDropped += static_cast<int64_t>(dropped.size());
    Epochs::all().waitForReaders();
    for (const auto& tessellation : dropped) bytes_ -= tessellation->bytes();
  }
}

}  // namespace patina
