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

TessellationCache::TessellationCache(size_t budget) : budget_(budget) {}

TessellationCache::~TessellationCache() { clear(); }

void TessellationCache::clear() {
  for (size_t k = 0; k < units_.size(); ++k) delete units_[k].resident.exchange(nullptr);
  resident_.clear();
  bytes_ = 0;
  maker_ = {};
}

void TessellationCache::setMaker(Maker maker) { maker_ = std::move(maker); }

void TessellationCache::pin(std::span<const uint32_t> units) const {
  const std::scoped_lock lock(evictMutex_);
  std::vector<bool> pinned(units_.size());
  for (const uint32_t unit : units) {
    pinned[unit] = true;
    if (Tessellation* const known = units_[unit].resident.load()) known->tracer.reset();
  }
  std::erase_if(resident_, [&](uint32_t unit) { return pinned[unit]; });
}

void TessellationCache::notePeak() const {
  size_t peak = peak_;
  for (const size_t now = used(); now > peak && !peak_.compare_exchange_weak(peak, now);) {
  }
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
  const size_t wanted = maker_.guess(index);
  reserve(wanted);
  const size_t before = maker_.measure();
  std::unique_ptr<Tessellation> made;
  // Tasks of others must not run here meanwhile: they might want this very unit.
  tbb::this_task_arena::isolate([&] {
    made = maker_.make(index);
    const size_t vertices = made->bytes();
    bytes_ += vertices;
    notePeak();
    maker_.trace(index, made);
    bytes_ += made->bytes() - vertices;
  });
  notePeak();
  unit.bytes = std::max(maker_.measure(), before) - before + made->bytes();
  const bool again = unit.made.exchange(true);
  ++(again ? unitsMadeAgain : unitsMade);
  madeAgain_ += again;
  unit.lastMet = ++clock_;
  unit.resident.store(made.release());
  {
    const std::scoped_lock evictLock(evictMutex_);
    resident_.push_back(index);
  }
  {
    const std::scoped_lock reserveLock(reserveMutex_);
    reserved_ -= wanted;
    --makings_;
  }
  makingEnded_.notify_all();
}

/// Waits until a unit of so many bytes may be made, and drops others for it.
void TessellationCache::reserve(size_t bytes) const {
  std::unique_lock lock(reserveMutex_);
  while (makings_ > 0 || used() > 0) {
    if (used() + reserved_ + bytes <= budget_) break;
    // Who makes room has the lock: two would drop twice as much as is needed.
    if (dropSome()) continue;
    if (makings_ == 0) break;
    makingEnded_.wait(lock);
  }
  reserved_ += bytes;
  ++makings_;
}

/// Drops what was met least recently; a little more than the last one, so that it is not done for every unit.
bool TessellationCache::dropSome() const {
  std::vector<std::unique_ptr<const Tessellation>> dropped;
  {
    const std::scoped_lock lock(evictMutex_);
    if (resident_.empty()) return false;
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
  tight_ = true;
  unitsDropped += static_cast<int64_t>(dropped.size());
  Epochs::all().waitForReaders();
  for (const auto& tessellation : dropped) bytes_ -= tessellation->bytes();
  return true;
}

}  // namespace patina
