// SPDX-License-Identifier: Apache-2.0
// A slot for each thread that calls plugins.
#include "renderer/shading/shader_watch.h"

#include <unistd.h>

#include <deque>
#include <mutex>

#include "renderer/shading/shader_instance.h"

namespace patina {

std::atomic<bool> detail::shaderWatch{false};

namespace {

/// Even: in no call; odd: in one; kLate: in one that does not come back.
constexpr uint64_t kLate = ~uint64_t{0};

struct alignas(64) Slot {
  std::atomic<uint64_t> state = 0;
  bool taken = false;
  // Of the call under way.
  const ShaderInstance* shader = nullptr;
  const char* entry = nullptr;
  const CallPlace* place = nullptr;
  const WorkPlace* pixels = nullptr;
  // Of the watch.
  uint64_t seen = 0;
  uint32_t rounds = 0;
};

class Slots {
 public:
  static Slots& all() {
    static Slots* const slots = new Slots;  // never destroyed: threads end after main()
    return *slots;
  }
  Slot* take() {
    const std::scoped_lock lock(mutex_);
    for (Slot& slot : slots_)
      if (!slot.taken) {
        slot.taken = true;
        return &slot;
      }
    Slot& slot = slots_.emplace_back();
    slot.taken = true;
    return &slot;
  }
  void giveBack(Slot* slot) {
    const std::scoped_lock lock(mutex_);
    slot->taken = false;
  }
  template <class Visit>
  void forEach(const Visit& visit) {
    const std::scoped_lock lock(mutex_);
    for (Slot& slot : slots_) visit(slot);
  }

 private:
  std::mutex mutex_;
  std::deque<Slot> slots_;  // slots never move
};

Slot& ownSlot() {
  struct Owner {
    Slot* slot = Slots::all().take();
    ~Owner() { Slots::all().giveBack(slot); }
  };
  thread_local const Owner owner;
  return *owner.slot;
}

}  // namespace

ShaderWatch::ShaderWatch() { detail::shaderWatch = true; }
ShaderWatch::~ShaderWatch() { detail::shaderWatch = false; }

std::optional<ShaderWatch::Late> ShaderWatch::findLate(uint32_t rounds) {
  Slot* late = nullptr;
  Slots::all().forEach([&](Slot& slot) {
    uint64_t state = slot.state.load(std::memory_order_acquire);
    if (state != slot.seen) slot.seen = state, slot.rounds = 0;
    if (state % 2 == 0 || state == kLate || ++slot.rounds <= rounds || late) return;
    // From here on the thread cannot leave the call, and what it was called with stays.
    if (slot.state.compare_exchange_strong(state, kLate, std::memory_order_acq_rel)) late = &slot;
  });
  if (!late) return std::nullopt;
  return Late{std::string(late->shader->name()), late->entry, late->shader->where(),
              late->place ? late->place->text() : "", *late->pixels};
}

WatchedCall::WatchedCall(const ShaderInstance& shader, const char* entry) {
  Slot& slot = ownSlot();
  slot.shader = &shader, slot.entry = entry;
  slot.place = CallPlace::current(), slot.pixels = &WorkPlace::current();
  slot.state.store(slot.state.load(std::memory_order_relaxed) + 1, std::memory_order_release);
}

WatchedCall::~WatchedCall() {
  Slot& slot = ownSlot();
  uint64_t state = slot.state.load(std::memory_order_relaxed);
  if (state != kLate && slot.state.compare_exchange_strong(state, state + 1, std::memory_order_acq_rel))
    return;
  for (;;) pause();
}

}  // namespace patina
