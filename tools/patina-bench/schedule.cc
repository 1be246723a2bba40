// SPDX-License-Identifier: Apache-2.0
// Order and time of what is measured.
#include "tools/patina-bench/schedule.h"

#include <algorithm>

namespace patina::bench {
namespace {

constexpr double kGrowth = 2;  // least growth of time from one setting of a mode to the next

}  // namespace

std::vector<Setting> byTurns(const std::vector<Setting>& settings) {
  std::map<std::string, int> count;
  std::vector<std::pair<int, Setting>> ranked;
  for (const Setting& s : settings) ranked.emplace_back(count[s.mode]++, s);
  std::ranges::stable_sort(ranked, {}, &std::pair<int, Setting>::first);
  std::vector<Setting> result;
  for (const auto& [rank, setting] : ranked) result.push_back(setting);
  return result;
}

Shares::Shares(const std::vector<Setting>& settings) {
  for (const Setting& s : settings) ++modes_[s.mode].settings;
}

double Shares::allow(const std::string& mode, double left) {
  const auto going =
      std::ranges::count_if(modes_, [](const auto& m) { return !m.second.ended && m.second.settings > 0; });
  Mode& own = modes_[mode];
  if (own.ended || going == 0) return 0;
  const double share = left / static_cast<double>(going);
  if (share <= 0 || kGrowth * own.last > share) {
    own.ended = true;
    return 0;
  }
  return share;
}

void Shares::took(const std::string& mode, double seconds, bool ended) {
  modes_[mode].last = seconds, modes_[mode].ended |= ended;
}

void Shares::pass(const std::string& mode) { --modes_[mode].settings; }

}  // namespace patina::bench
