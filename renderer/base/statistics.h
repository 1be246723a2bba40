// SPDX-License-Identifier: Apache-2.0
// Counters and phase times: declared where they count, summed over threads, printed as a tree or as JSON.
//
//   STAT_COUNTER("Radiosity cache/hits", cacheHits);      at file scope
//   ++cacheHits;  cacheHits += n;                         from any thread: a thread-local addition
//   { PhaseTimer timer("Geometry"); ... }                 wall and CPU time of a phase [main thread]
//   STAT_TIME("Time of threads/rays", rayTime);           at file scope
//   { TimeShare share(rayTime); ... }                     time that this thread spends here, and not in
//                                                         other shares within; some 50 ns: for batches
//
// A name's slashes are its place in the tree. Counters of threads that have ended are kept.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace patina {

/// One counter of the process. Registered by its constructor and never destroyed before the report.
class StatCounter {
 public:
  explicit StatCounter(std::string_view name);
  void operator++() { *this += 1; }
  void operator+=(int64_t n) {
    std::atomic<int64_t>& slot = slots()[index_];  // own thread writes, the report reads
    slot.store(slot.load(std::memory_order_relaxed) + n, std::memory_order_relaxed);
  }
  int64_t total() const;

 private:
  static std::atomic<int64_t>* slots();
  uint32_t index_;
};

#define STAT_COUNTER(name, variable) static ::patina::StatCounter variable(name)

/// Time that threads spend in one kind of work, in seconds of their wall clocks.
class StatTime {
 public:
  explicit StatTime(std::string_view name);

 private:
  friend class TimeShare;
  StatCounter nanoseconds_;
};

#define STAT_TIME(name, variable) static ::patina::StatTime variable(name)

/// Its thread's time counts for `to` while it lives, but for that of shares within it.
class TimeShare {
 public:
  explicit TimeShare(StatTime& to);
  ~TimeShare();
  TimeShare(const TimeShare&) = delete;
  TimeShare& operator=(const TimeShare&) = delete;

 private:
  StatTime* const before_;
};

class PhaseTimer {
 public:
  explicit PhaseTimer(const char* phase);
  ~PhaseTimer();
  PhaseTimer(const PhaseTimer&) = delete;
  PhaseTimer& operator=(const PhaseTimer&) = delete;

 private:
  std::string phase_;
  std::chrono::steady_clock::time_point wall_;
  double cpu_;
};

/// What the report holds beside the counters: values that are set once per frame by name, last value wins.
void setStatistic(const std::string& name, double value);

struct StatEntry {
  std::string name;
  double value;
  bool isInteger;
};
std::vector<StatEntry>
statistics();                  ///< all counters that are not zero, values and phase times, sorted by name
std::string statisticsTree();  ///< for people
std::string statisticsJson();  ///< for programs: nested objects by the names' slashes
void resetStatistics();        ///< before a frame; no other thread may count meanwhile

}  // namespace patina
