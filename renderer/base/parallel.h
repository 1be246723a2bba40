// SPDX-License-Identifier: Apache-2.0
// Loops on TBB's threads whose hand-overs ThreadSanitizer sees. TBB and Embree are not built with it: what
// one thread writes before a loop and another reads within it would look like a race.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/parallel_reduce.h>

#ifdef __SANITIZE_THREAD__
#include <sanitizer/tsan_interface.h>
#endif

namespace patina {

/// A point where threads meet in a library that ThreadSanitizer does not see into: what was written before
/// give() is there after take(). Nothing at all without ThreadSanitizer; it does not synchronise.
class Handover {
 public:
#ifdef __SANITIZE_THREAD__
  void give() const { __tsan_release(address()); }
  void take() const { __tsan_acquire(address()); }

 private:
  void* address() const { return const_cast<char*>(&place_); }
  char place_ = 0;
#else
  void give() const {}
  void take() const {}
#endif
};

/// A piece of work between two hand-overs.
class HandedOver {
 public:
  explicit HandedOver(const Handover& handover) : handover_(handover) { handover_.take(); }
  ~HandedOver() { handover_.give(); }
  HandedOver(const HandedOver&) = delete;
  HandedOver& operator=(const HandedOver&) = delete;

 private:
  const Handover& handover_;
};

/// Calls of a loop that has ended are done, to whoever goes on behind it.
class LoopHandover : public Handover {
 public:
  LoopHandover() { give(); }
  ~LoopHandover() { take(); }
  LoopHandover(const LoopHandover&) = delete;
  LoopHandover& operator=(const LoopHandover&) = delete;
};

/// body(k) for k from `first` to before `end`, as tbb::parallel_for.
template <class Index, class Body, class... Partitioner>
void parallelFor(Index first, Index end, const Body& body, const Partitioner&... partitioner) {
  const LoopHandover loop;
  tbb::parallel_for(
      first, end,
      [&](Index k) {
        const HandedOver work(loop);
        body(k);
      },
      partitioner...);
}

template <class First, class Second>
void parallelInvoke(const First& first, const Second& second) {
  const LoopHandover loop;
  const auto in = [&loop](const auto& run) {
    return [&] {
      const HandedOver work(loop);
      run();
    };
  };
  tbb::parallel_invoke(in(first), in(second));
}

/// As tbb::parallel_reduce with functions.
template <class Range, class Value, class Body, class Join>
Value parallelReduce(const Range& range, const Value& identity, const Body& body, const Join& join) {
  const LoopHandover loop;
  return tbb::parallel_reduce(
      range, identity,
      [&](const Range& part, Value value) {
        const HandedOver work(loop);
        return body(part, std::move(value));
      },
      [&](Value a, const Value& b) {
        const HandedOver work(loop);
        return join(std::move(a), b);
      });
}

}  // namespace patina
