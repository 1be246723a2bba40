// SPDX-License-Identifier: Apache-2.0
// Tests of old against new, and of one setting against another.
#include "tools/patina-bench/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

namespace patina::bench {
namespace {

using Value = double (*)(const Run&);
struct Quantity {
  const char* name;
  Value value;
  bool exact;  // equal seeds give equal values
};
constexpr Quantity kQuantities[] = {
    {"wall s", [](const Run& r) { return r.wallSeconds; }, false},
    {"CPU s", [](const Run& r) { return r.cpuSeconds; }, false},
    {"peak MB", [](const Run& r) { return r.peakMb; }, false},
    {"rays", [](const Run& r) { return r.rays; }, true},
    {"shader points", [](const Run& r) { return r.shaderPoints; }, true},
    {"relMSE", [](const Run& r) { return r.errors.relMse; }, false},
};
// Threads may make an entry of the cache twice: counts agree to within this part.
constexpr double kCountTolerance = 1e-3;

std::vector<double> logarithms(const Point& point, Value value) {
  std::vector<double> logs;
  for (const Run* run : point.runs)
    if (value(*run) > 0) logs.push_back(std::log(value(*run)));
  return logs;
}

// Whether the pictures of equal seeds have the same bits; nothing is known without such.
std::optional<bool> samePictures(const Point& before, const Point& after) {
  std::optional<bool> same;
  for (const Run* a : before.runs)
    for (const Run* b : after.runs)
      if (a->seed == b->seed && a->sceneHash == b->sceneHash && a->args == b->args)
        same = same.value_or(true) && a->picture == b->picture;
  return same;
}

}  // namespace

std::vector<Change> compareRuns(std::span<const Point> before, std::span<const Point> after) {
  std::vector<Change> changes;
  std::vector<double> chances;  // of each change that is tested, else 1
  size_t tests = 0;
  for (const Point& old : before) {
    const auto found = std::ranges::find_if(after, [&](const Point& p) {
      return p.scene == old.scene && p.mode == old.mode && p.setting == old.setting;
    });
    if (found == after.end() || old.runs.empty() || found->runs.empty()) continue;
    const std::optional<bool> same = samePictures(old, *found);
    for (const Quantity& q : kQuantities) {
      const std::vector<double> a = logarithms(old, q.value), b = logarithms(*found, q.value);
      if (a.empty() || b.empty()) continue;
      const Summary sa = summarize(a), sb = summarize(b);
      Change change{old.scene,         old.mode, old.setting, q.name, std::exp(sa.mean),
                    std::exp(sb.mean), 1,        0,           false,  false};
      change.ratio = std::exp(sb.mean - sa.mean);
      change.ratioError = change.ratio * std::hypot(sa.standardError(), sb.standardError());
      double chance = 1;
      if (q.exact) {
        // Other scenes or seeds need not have the same counts.
        change.judged = same.has_value();
        change.changed = change.judged && std::abs(change.ratio - 1) > kCountTolerance;
      } else if (same == true && std::string_view(q.name) == "relMSE") {
        change.judged = true;
      } else if (a.size() > 1 && b.size() > 1) {
        change.judged = true;
        chance = welchTest(sa, sb).p;
        ++tests;
      }
      changes.push_back(change), chances.push_back(chance);
    }
    if (same) {
      changes.push_back({old.scene, old.mode, old.setting, "picture", 0, 0, 1, 0, true, !*same});
      chances.push_back(1);
    }
  }
  const double threshold = sidak(kSignificance, tests);
  for (size_t i = 0; i < changes.size(); ++i)
    if (chances[i] < threshold) changes[i].changed = true;
  return changes;
}

std::string describeChanges(std::span<const Change> changes) {
  if (changes.empty()) return "Nothing to compare: no setting of a scene was measured in both.\n";
  const auto name = [](const Change& c) { return fmt::format("{}/{}/{}", c.scene, c.mode, c.setting); };
  const auto value = [](const Change& c) {
    if (c.quantity == "picture") return std::string(c.changed ? "other bits" : "the same bits");
    return fmt::format("{:.4g} -> {:.4g}, ratio {:.4f} ± {:.4f}", c.before, c.after, c.ratio, c.ratioError);
  };
  std::string text;
  size_t unjudged = 0;
  for (const Change& c : changes) {
    if (c.changed) text += fmt::format("* {}: {}: {}\n", name(c), c.quantity, value(c));
    unjudged += !c.judged;
  }
  text = text.empty() ? "No difference.\n" : "Changed:\n\n" + text;
  if (unjudged > 0) {
    text += fmt::format(
        "\n{} of {} could not be judged: times and errors need two repeats at least on both sides.\n",
        unjudged, changes.size());
  }
  text += "\n| run | quantity | before -> after |\n| --- | --- | --- |\n";
  for (const Change& c : changes)
    text += fmt::format("| {} | {} | {}{} |\n", name(c), c.quantity, value(c),
                        c.changed ? " **changed**" : (c.judged ? "" : " (not judged)"));
  return text;
}

Agreement compareBlocks(std::span<const std::vector<double>> a, std::span<const std::vector<double>> b) {
  if (a.size() < 2 || b.size() < 2)
    throw std::runtime_error("two pictures of each setting are needed at least");
  const size_t tests = a[0].size();
  for (const auto pictures : {a, b})
    for (const std::vector<double>& means : pictures)
      if (means.size() != tests) throw std::runtime_error("the pictures differ in size");
  Agreement result;
  result.blocks = tests / 3;
  result.threshold = sidak(kSignificance, tests);
  std::set<size_t> differing;
  double sumA = 0, sumB = 0;
  for (size_t i = 0; i < tests; ++i) {
    std::vector<double> va, vb;
    for (const std::vector<double>& means : a) va.push_back(means[i]);
    for (const std::vector<double>& means : b) vb.push_back(means[i]);
    const Summary sa = summarize(va), sb = summarize(vb);
    const TTest test = welchTest(sa, sb);
    sumA += sa.mean, sumB += sb.mean;
    result.largestT = std::max(result.largestT, std::abs(test.t));
    result.smallestP = std::min(result.smallestP, test.p);
    if (test.p < result.threshold) differing.insert(i / 3);
  }
  result.differing = differing.size();
  result.meanDifference = sumA != 0 ? sumB / sumA - 1 : 0;
  return result;
}

std::string describeAgreements(std::span<const Agreement> agreements) {
  std::string text =
      "| scene | blocks that differ | largest abs(t) | smallest p | p that counts | mean |\n"
      "| --- | --- | --- | --- | --- | --- |\n";
  for (const Agreement& a : agreements) {
    if (!a.failure.empty()) {
      text += fmt::format("| {} | failed: {} | | | | |\n", a.scene, a.failure);
    } else {
      text += fmt::format("| {} | {} of {} | {:.2f} | {:.2g} | {:.2g} | {:+.3f} % |\n", a.scene, a.differing,
                          a.blocks, a.largestT, a.smallestP, a.threshold, 100 * a.meanDifference);
    }
  }
  return text;
}

}  // namespace patina::bench
