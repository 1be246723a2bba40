// SPDX-License-Identifier: Apache-2.0
// Registry of counters: every thread has an array of slots, which it hands to the registry when it ends.
#include "renderer/base/statistics.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>

namespace patina {
namespace {

constexpr size_t kMaxCounters = 2048;
/// A scene of hundreds of shaders has more names than there is room for: the last counter is the sum of
/// those.
constexpr std::string_view kOthers = "Statistics/counts of names that there was no room for";
using Slots = std::array<std::atomic<int64_t>, kMaxCounters>;

struct Registry {
  std::mutex mutex;
  std::vector<std::string> names;
  std::vector<Slots*> threads;
  Slots ended{};
  std::map<std::string, double> values;
  std::map<std::string, std::pair<double, double>> phases;  // wall, CPU seconds

  static Registry& get() {
    static Registry* registry = new Registry;  // outlives every thread and static counter
    return *registry;
  }
  int64_t total(size_t index) {
    int64_t sum = ended[index].load(std::memory_order_relaxed);
    for (const Slots* slots : threads) sum += (*slots)[index].load(std::memory_order_relaxed);
    return sum;
  }
};

struct ThreadSlots {
  std::unique_ptr<Slots> slots = std::make_unique<Slots>();
  ThreadSlots() {
    Registry& registry = Registry::get();
    std::lock_guard lock(registry.mutex);
    registry.threads.push_back(slots.get());
  }
  ~ThreadSlots() {
    Registry& registry = Registry::get();
    std::lock_guard lock(registry.mutex);
    for (size_t i = 0; i < kMaxCounters; ++i)
      registry.ended[i].fetch_add((*slots)[i].load(std::memory_order_relaxed), std::memory_order_relaxed);
    std::erase(registry.threads, slots.get());
  }
};

double processCpuSeconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace

StatCounter::StatCounter(std::string_view name) {
  Registry& registry = Registry::get();
  std::lock_guard lock(registry.mutex);
  // Two files may count under one name: they share the slot.
  const auto find = [&](std::string_view wanted) {
    return std::find(registry.names.begin(), registry.names.end(), wanted);
  };
  auto found = find(name);
  if (found == registry.names.end() && registry.names.size() >= kMaxCounters - 1)
    found = find(name = kOthers);
  index_ = static_cast<uint32_t>(found - registry.names.begin());
  if (found == registry.names.end()) registry.names.emplace_back(name);
}

std::atomic<int64_t>* StatCounter::slots() {
  thread_local ThreadSlots thread;
  return thread.slots->data();
}

int64_t StatCounter::total() const {
  Registry& registry = Registry::get();
  std::lock_guard lock(registry.mutex);
  return registry.total(index_);
}

namespace {

constexpr std::string_view kSeconds = " s";  // ends the names of counters of nanoseconds

/// What a thread's time counts for, and since when.
struct Running {
  StatTime* share = nullptr;
  std::chrono::steady_clock::time_point since;
};
thread_local Running running;

}  // namespace

StatTime::StatTime(std::string_view name) : nanoseconds_(std::string(name) + std::string(kSeconds)) {}

TimeShare::TimeShare(StatTime& to) : before_(running.share) {
  const auto now = std::chrono::steady_clock::now();
  if (before_) before_->nanoseconds_ += std::chrono::nanoseconds(now - running.since).count();
  running = {&to, now};
}

TimeShare::~TimeShare() {
  const auto now = std::chrono::steady_clock::now();
  running.share->nanoseconds_ += std::chrono::nanoseconds(now - running.since).count();
  running = {before_, now};
}

PhaseTimer::PhaseTimer(const char* phase)
    : phase_(phase), wall_(std::chrono::steady_clock::now()), cpu_(processCpuSeconds()) {}

PhaseTimer::~PhaseTimer() {
  const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_).count();
  const double cpu = processCpuSeconds() - cpu_;
  Registry& registry = Registry::get();
  std::lock_guard lock(registry.mutex);
  registry.phases[phase_].first += wall;
  registry.phases[phase_].second += cpu;
}

void setStatistic(const std::string& name, double value) {
  Registry& registry = Registry::get();
  std::lock_guard lock(registry.mutex);
  registry.values[name] = value;
}

std::vector<StatEntry> statistics() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  setStatistic("Memory/peak resident MB", static_cast<double>(usage.ru_maxrss) / 1024);
  Registry& registry = Registry::get();
  std::lock_guard lock(registry.mutex);
  std::vector<StatEntry> entries;
  for (size_t i = 0; i < registry.names.size(); ++i)
    if (const int64_t n = registry.total(i)) {
      const bool isTime = registry.names[i].ends_with(kSeconds);
      entries.push_back({registry.names[i], static_cast<double>(n) * (isTime ? 1e-9 : 1), !isTime});
    }
  for (const auto& [name, value] : registry.values) entries.push_back({name, value, false});
  for (const auto& [name, seconds] : registry.phases) {
    entries.push_back({"Time/" + name + "/wall s", seconds.first, false});
    entries.push_back({"Time/" + name + "/CPU s", seconds.second, false});
  }
  std::sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return entries;
}

std::string statisticsTree() {
  std::string text;
  std::vector<std::string> path;
  for (const StatEntry& entry : statistics()) {
    std::vector<std::string> parts;
    for (size_t from = 0, slash = 0; slash != std::string::npos; from = slash + 1) {
      slash = entry.name.find('/', from);
      parts.push_back(entry.name.substr(from, slash - from));
    }
    // Print the headings that differ from those of the entry before.
    size_t common = 0;
    while (common + 1 < parts.size() && common < path.size() && path[common] == parts[common]) ++common;
    for (size_t i = common; i + 1 < parts.size(); ++i) text += fmt::format("{:{}}{}\n", "", 2 * i, parts[i]);
    const size_t indent = 2 * (parts.size() - 1);
    const std::string value = entry.isInteger ? fmt::format("{}", static_cast<int64_t>(entry.value))
                                              : fmt::format("{:.4g}", entry.value);
    text += fmt::format("{:{}}{:<{}}{:>16}\n", "", indent, parts.back(), 52 - std::min<size_t>(indent, 40),
                        value);
    path.assign(parts.begin(), parts.end() - 1);
  }
  return text;
}

std::string statisticsJson() {
  nlohmann::ordered_json root = nlohmann::ordered_json::object();
  for (const StatEntry& entry : statistics()) {
    auto& value = root[nlohmann::ordered_json::json_pointer("/" + entry.name)];
    if (entry.isInteger)
      value = static_cast<int64_t>(entry.value);
    else
      value = entry.value;
  }
  return root.dump(2) + "\n";
}

void resetStatistics() {
  Registry& registry = Registry::get();
  std::lock_guard lock(registry.mutex);
  for (auto& slot : registry.ended) slot.store(0, std::memory_order_relaxed);
  for (Slots* slots : registry.threads)
    for (auto& slot : *slots) slot.store(0, std::memory_order_relaxed);
  registry.values.clear();
  registry.phases.clear();
}

}  // namespace patina
