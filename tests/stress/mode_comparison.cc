// SPDX-License-Identifier: Apache-2.0
// Welch's test with a bias that is allowed, and as many samples as it takes.
#include "tests/stress/mode_comparison.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <set>

#include "tools/patina-bench/statistics.h"

namespace patina::stress {

using bench::Summary;

namespace {

constexpr int kLeastPictures = 4;
constexpr double kStep = 4;  // in effort

Summary column(const Blocks& blocks, size_t k) {
  std::vector<double> values;
  for (const auto& picture : blocks) values.push_back(picture[k]);
  return bench::summarize(values);
}

Summary wholePicture(const Blocks& blocks) {
  std::vector<double> values;
  for (const auto& picture : blocks) {
    double sum = 0;
    for (const double v : picture) sum += v;
    values.push_back(sum / static_cast<double>(picture.size()));
  }
  return bench::summarize(values);
}

}  // namespace

Agreement agreementOf(const Blocks& mode, const Blocks& path, double bias) {
  Agreement result;
  if (path.empty() || path[0].empty()) return result;
  const Summary a = wholePicture(mode), b = wholePicture(path);
  if (b.mean > 0) {
    result.pictureBias = a.mean / b.mean - 1;
    result.pictureError = std::hypot(a.standardError(), b.standardError()) / b.mean;
  }
  result.isBlack = true;
  double loudest = -1;
  for (size_t k = 0; k < path[0].size(); ++k) {
    const Summary m = column(mode, k), p = column(path, k);
    result.isBlack &= p.mean == 0 && p.variance == 0;
    const double allowed = bias * (std::abs(p.mean) + 0.2 * std::abs(b.mean));
    const auto noiseOf = [&](const Summary& s) {
      return s.variance == 0 ? 0
             : allowed > 0   ? s.standardError() / allowed
                             : std::numeric_limits<double>::infinity();
    };
    result.noise = std::max(result.noise, noiseOf(m)),
    result.pathNoise = std::max(result.pathNoise, noiseOf(p));
    // What floats of pictures are good for is no difference.
    const double error = std::hypot(m.standardError(), p.standardError()) + 1e-6 * std::abs(b.mean) + 1e-12;
    const double excess = (std::abs(m.mean - p.mean) - allowed) / error;
    const double chance = excess > 0 ? bench::studentTails(excess, bench::welchTest(m, p).freedom) : 1;
    if (chance > result.chance || (chance == result.chance && excess <= loudest)) continue;
    loudest = excess;
    result.chance = chance, result.difference = m.mean - p.mean;
    result.reference = p.mean, result.standardError = error;
  }
  result.tests = path[0].size();
  return result;
}

Comparison compareModes(const std::vector<std::string>& modes, const RenderBlocks& render,
                        const ComparisonSettings& settings) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  const auto since = [](Clock::time_point from) {
    return std::chrono::duration<double>(Clock::now() - from).count();
  };
  const auto left = [&] { return settings.seconds - since(start); };
  const std::string path = "path";
  struct Series {
    Blocks blocks;
    double effort = 0, seconds = 0;
  };
  std::map<std::string, Series> all;
  int seed = 0;
  /// New pictures of a mode, of more samples. False: there are none.
  const auto raise = [&](const std::string& mode) {
    Series& series = all[mode];
    const double effort = series.effort > 0 ? kStep * series.effort : 1;
    if (effort > settings.mostEffort || kStep * series.seconds > left()) return false;
    const auto begin = Clock::now();
    Series next{{}, effort, 0};
    while (static_cast<int>(next.blocks.size()) < settings.pictures && left() > 0) {
      auto picture = render(mode, effort, ++seed, left());
      if (!picture) break;
      next.blocks.push_back(std::move(*picture));
    }
    next.seconds = since(begin);
    if (static_cast<int>(next.blocks.size()) < kLeastPictures) return false;
    series = std::move(next);
    return true;
  };

  Comparison result;
  bool isComplete = raise(path);
  for (const std::string& mode : modes)
    if (isComplete) raise(mode);
  std::set<std::string> confirmed;
  while (isComplete) {
    result.agreements.clear();
    std::set<std::string> wanted;
    const double enough = settings.noise / std::sqrt(2.0);
    for (const std::string& mode : modes) {
      if (all[mode].blocks.empty()) continue;
      const Agreement& found = result.agreements[mode] =
          agreementOf(all[mode].blocks, all[path].blocks, settings.bias);
      if (found.noise > enough) wanted.insert(mode);
      if (found.pathNoise > enough) wanted.insert(path);
      if (found.noise > enough || found.pathNoise > enough) continue;
      if (found.differs(1e-3 / static_cast<double>(std::max<size_t>(found.tests, 1))) &&
          confirmed.insert(mode).second)
        wanted.insert({mode, path});
    }
    if (wanted.empty()) break;
    bool raised = false;
    for (const std::string& mode : wanted) raised |= raise(mode);
    if (!raised) {
      result.isOutOfTime = true;
      break;
    }
  }
  result.isOutOfTime |= result.agreements.size() < modes.size();
  for (const auto& [mode, series] : all) result.efforts[mode] = series.effort;
  result.seconds = since(start);
  return result;
}

}  // namespace patina::stress
