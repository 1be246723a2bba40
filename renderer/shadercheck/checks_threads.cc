// SPDX-License-Identifier: Apache-2.0
// A stress run: several threads on one instance, each with batches of its own.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <thread>

#include "renderer/shadercheck/checks.h"

namespace patina::shadercheck {
namespace {

constexpr int kThreads = 4;
constexpr uint32_t kLanes = 512;  // long enough for calls to meet
// Some ten slices of a busy machine's time, so that threads meet even if they have a single processor.
constexpr auto kDuration = std::chrono::milliseconds(50);

bool sameOutput(Call call, const Output& a, const Output& b) {
  for (uint32_t i = 0; i < a.lanes; ++i)
    if (!difference(call, a, i, b, i).empty()) return false;
  return true;
}

struct Count {
  int results = 0, wrong = 0;
};

// Calls again and again, and counts results other than the first, which was alone. As little as can be is
// done between calls.
Count stress(Batch& batch, Call call, void* instance, const Batch& alone,
             std::chrono::steady_clock::time_point end) {
  const Output expected = alone.output();
  Count count;
  do {
    batch.reset();
    batch.call(instance);
    ++count.results;
    if (!batch.hasSamePlanes(alone) && !sameOutput(call, expected, batch.output())) ++count.wrong;
  } while (std::chrono::steady_clock::now() < end);
  return count;
}

Count stressInThreads(Subject& subject, Call call) {
  std::vector<std::unique_ptr<Batch>> batches, alone;
  for (uint64_t k = 0; k < kThreads; ++k)
    for (auto* const list : {&batches, &alone}) {
      list->push_back(subject.batch(call, makeLanes(kLanes, 20 + k), subject.layout(call)));
      list->back()->call(subject.instance());
    }
  std::atomic<int> results = 0, wrong = 0;
  const auto end = std::chrono::steady_clock::now() + kDuration;
  std::vector<std::thread> threads;
  for (size_t k = 0; k < kThreads; ++k)
    threads.emplace_back([&, k] {
      const Count count = stress(*batches[k], call, subject.instance(), *alone[k], end);
      results += count.results, wrong += count.wrong;
    });
  for (std::thread& thread : threads) thread.join();
  return {results, wrong};
}

}  // namespace

void checkThreads(const Context& context) {
  // The first set is the defaults and the last one is drawn: most of what a shader can do.
  for (size_t k = 0; k < context.sets.size(); k += std::max<size_t>(context.sets.size() - 1, 1)) {
    Subject subject(context, context.sets[k]);
    if (subject.status() != PATINA_OK) continue;
    for (const Call call : subject.calls()) {
      context.findings.progress().set(callName(call), "several threads; " + context.sets[k].name());
      if (const Count count = stressInThreads(subject, call); count.wrong > 0)
        subject.fault(call, "gives other results when several threads call it at once: a race",
                      fmt::format("{} of {} results", count.wrong, count.results));
      subject.reportComplaints(callName(call));
    }
  }
}

}  // namespace patina::shadercheck
