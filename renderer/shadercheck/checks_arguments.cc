// SPDX-License-Identifier: Apache-2.0
// Checks of what results may depend on: the arguments of the call that are declared, lane by lane.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <numeric>
#include <optional>

#include "renderer/shadercheck/checks.h"

namespace patina::shadercheck {
namespace {

constexpr uint32_t kLanes = 37;  // two blocks and a part of one

// The first lane whose result is another: which, and how.
std::optional<std::string> findDifference(Call call, const Output& a, const Output& b) {
  for (uint32_t i = 0; i < a.lanes; ++i)
    if (const std::string text = difference(call, a, i, b, i); !text.empty())
      return fmt::format("lane {}: {}", i, text);
  return std::nullopt;
}

// Where the same call gives the same results, checks can tell what else changes them. (Where it does not,
// checkHistory says so.)
bool isRepeatable(Subject& subject, Call call, const std::vector<Lane>& lanes, const Layout& layout,
                  const Output& first) {
  return !findDifference(call, first, subject.run(call, lanes, layout));
}

uint64_t allChannels(Call call) {
  return entryOf(call) == PATINA_ENTRY_LIGHT ? kLightChannels : kSurfaceChannels;
}

// With every channel there, what is in an undeclared one may change nothing; nor may its absence.
void checkUndeclared(Subject& subject, Call call, uint64_t channel, const std::vector<Lane>& lanes,
                     const Output& expected) {
  const std::string name(channelName(channel));
  Layout changed = subject.layout(call), poisoned = changed, absent = changed;
  changed.channels = poisoned.channels = allChannels(call);
  absent.channels = allChannels(call) & ~channel;
  changed.foreign = poisoned.nan = channel;
  const std::pair<const Layout&, const char*> runs[] = {
      {changed, "other values"}, {poisoned, "NaN"}, {absent, "NULL"}};
  for (const auto& [layout, what] : runs) {
    const Output result =
        subject.run(call, lanes, layout, fmt::format("{}, which it does not declare, is {}", name, what));
    if (const auto found = findDifference(call, expected, result))
      subject.fault(call, fmt::format("reads {}, which it does not declare", name),
                    fmt::format("{} when {} is {}", *found, name, what));
  }
}

// Lane `order[i]` of the first batch is lane i of the second.
void expectLanes(Subject& subject, Call call, const Output& all, const Output& some,
                 std::span<const uint32_t> order, const char* how) {
  for (uint32_t i = 0; i < order.size(); ++i)
    if (const std::string text = difference(call, all, order[i], some, i); !text.empty()) {
      subject.fault(call, fmt::format("gives a lane other results {}", how),
                    fmt::format("lane {} of {}: {}", order[i], all.lanes, text));
      return;
    }
}

void runReordered(Subject& subject, Call call, const std::vector<Lane>& lanes, const Output& all,
                  const std::vector<uint32_t>& order, const Layout& layout, const char* how) {
  std::vector<Lane> chosen;
  for (const uint32_t k : order) chosen.push_back(lanes[k]);
  expectLanes(subject, call, all, subject.run(call, chosen, layout, how), order, how);
}

void checkLanesOf(Subject& subject, Call call) {
  const std::vector<Lane> lanes = makeLanes(kLanes, 3);
  Layout layout = subject.layout(call);
  layout.parameters = Layout::Varying;
  const Output all = subject.run(call, lanes, layout);
  if (!isRepeatable(subject, call, lanes, layout, all)) return;
  for (uint32_t k = 0; k < kLanes; k += 3)
    runReordered(subject, call, lanes, all, {k}, layout, "in a batch of one");

  std::vector<uint32_t> order(kLanes);
  std::iota(order.begin(), order.end(), 0u);
  std::reverse(order.begin(), order.end());
  runReordered(subject, call, lanes, all, order, layout, "in another order");
  order.resize(PATINA_LANES);
  runReordered(subject, call, lanes, all, order, layout, "beside other lanes");
  order.assign(kLanes, 5);
  order.resize(260, 9);
  runReordered(subject, call, lanes, all, order, layout, "in a long batch");

  Layout padded = layout;
  padded.padding = 99;
  runReordered(subject, call, lanes, all, {0, 1, 2}, padded, "when the padding holds other values");
}

}  // namespace

void checkUndeclaredChannels(const Context& context) {
  const std::vector<Lane> lanes = makeLanes(kLanes, 1);
  forEachSubject(context, [&](Subject& subject) {
    for (const Call call : subject.calls()) {
      Layout whole = subject.layout(call);
      const uint64_t undeclared = allChannels(call) & ~whole.channels;
      whole.channels = allChannels(call);
      const Output expected = subject.run(call, lanes, whole);
      if (!isRepeatable(subject, call, lanes, whole, expected)) continue;
      for (uint64_t rest = undeclared; rest; rest &= rest - 1)
        checkUndeclared(subject, call, uint64_t{1} << std::countr_zero(rest), lanes, expected);
      if (!undeclared) continue;
      const Output bare = subject.run(call, lanes, subject.layout(call),
                                      channelNames(undeclared) + ", which it does not declare, are NULL");
      if (const auto found = findDifference(call, expected, bare))
        subject.fault(call, "has other results when all channels that it does not declare are NULL", *found);
    }
  });
}

void checkLanes(const Context& context) {
  forEachSubject(context, [&](Subject& subject) {
    for (const Call call : subject.calls()) checkLanesOf(subject, call);
  });
}

void checkStrides(const Context& context) {
  forEachSubject(context, [&](Subject& subject) {
    for (const Call call : subject.calls()) {
      const std::vector<Lane> lanes(PATINA_LANES + 1, makeLanes(1, 4)[0]);
      const Output planes = subject.run(call, lanes);
      Layout layout = subject.layout(call);
      if (!isRepeatable(subject, call, lanes, layout, planes)) continue;
      layout.oneForAll = true;
      if (const auto found =
              findDifference(call, planes, subject.run(call, lanes, layout, "planes of stride 0")))
        subject.fault(call, "has other results when channels are planes of stride 0", *found);
      layout = subject.layout(call);
      layout.parameters = Layout::Spread;
      if (const auto found =
              findDifference(call, planes, subject.run(call, lanes, layout, "parameters of stride 1")))
        subject.fault(call, "has other results when parameters are planes of stride 1", *found);
    }
  });
}

void checkHistory(const Context& context) {
  const std::vector<Lane> lanes = makeLanes(kLanes, 5), others = makeLanes(kLanes + 30, 6);
  forEachSubject(context, [&](Subject& subject) {
    for (const Call call : subject.calls()) {
      for (const Call other : subject.calls()) subject.run(other, others);
      const Output first = subject.run(call, lanes);
      if (const auto found = findDifference(call, first, subject.run(call, lanes))) {
        subject.fault(call, "depends on earlier calls", *found);
        continue;
      }
      Subject neighbour(context, context.sets.back());
      if (neighbour.status() == PATINA_OK)
        for (const Call other : neighbour.calls()) neighbour.run(other, others);
      if (const auto found = findDifference(call, first, subject.run(call, lanes)))
        subject.fault(call, "depends on other instances of the shader", *found);
    }
  });
}

}  // namespace patina::shadercheck
