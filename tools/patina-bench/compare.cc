// SPDX-License-Identifier: Apache-2.0
// Tests of old against new, and of one setting against another.
#include "tools/patina-bench/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

namespace patina::bench {
namespace {

constexpr const char* kAllSettings = "all settings";

using Value = double (*)(const Run&);
struct Quantity {
  const char* name;
  Value value;
  enum Kind { Time, Memory, Exact, Error } kind;  // Exact: equal seeds give equal values
};
constexpr Quantity kQuantities[] = {
    {"wall s", [](const Run& r) { return r.wallSeconds; }, Quantity::Time},
    {"CPU s", [](const Run& r) { return r.cpuSeconds; }, Quantity::Time},
    {"peak MB", [](const Run& r) { return r.peakMb; }, Quantity::Memory},
    {"rays", [](const Run& r) { return r.rays; }, Quantity::Exact},
    {"shader points", [](const Run& r) { return r.shaderPoints; }, Quantity::Exact},
    {"relMSE", [](const Run& r) { return r.errors.relMse; }, Quantity::Error},
};
using Logarithms = std::map<int, double>;  // by seed

Logarithms logarithms(const Point& point, Value value) {
  Logarithms logs;
  for (const Run* run : point.runs)
    if (value(*run) > 0) logs[run->seed] = std::log(value(*run));
  return logs;
}

Summary summarizeLogs(const Logarithms& logs) {
  std::vector<double> values;
  for (const auto& [seed, value] : logs) values.push_back(value);
  return summarize(values);
}

bool haveEqualSeeds(const Logarithms& a, const Logarithms& b) {
  return std::ranges::equal(
      a, b, {}, [](const auto& e) { return e.first; }, [](const auto& e) { return e.first; });
}

Logarithms differences(const Logarithms& before, const Logarithms& after) {
  Logarithms result;
  for (const auto& [seed, value] : before) result[seed] = after.at(seed) - value;
  return result;
}

// Sets ratio, its error and whether it is judged; returns the chance of such a ratio.
double test(const Logarithms& before, const Logarithms& after, Change& change) {
  const Summary a = summarizeLogs(before), b = summarizeLogs(after);
  change.before = std::exp(a.mean), change.after = std::exp(b.mean);
  change.ratio = std::exp(b.mean - a.mean);
  change.judged = a.count > 1 && b.count > 1;
  if (haveEqualSeeds(before, after)) {
    const Summary pairs = summarizeLogs(differences(before, after));
    change.ratioError = change.ratio * pairs.standardError();
    return studentTest(pairs).p;
  }
  change.ratioError = change.ratio * std::hypot(a.standardError(), b.standardError());
  return welchTest(a, b).p;
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

// Of the seeds that all settings have.
Summary meanOver(const std::vector<Logarithms>& settings) {
  std::vector<double> means;
  for (const auto& [seed, first] : settings[0]) {
    double sum = 0;
    size_t count = 0;
    for (const Logarithms& one : settings)
      if (const auto found = one.find(seed); found != one.end()) sum += found->second, ++count;
    if (count == settings.size()) means.push_back(sum / static_cast<double>(count));
  }
  return summarize(means);
}

}  // namespace

std::vector<Change> compareRuns(std::span<const Point> before, std::span<const Point> after) {
  std::vector<Change> changes;
  size_t tests = 0;
  std::map<std::string, std::vector<Logarithms>> times;  // differences of all settings, by quantity
  for (const Point& old : before) {
    const auto found = std::ranges::find_if(after, [&](const Point& p) {
      return p.scene == old.scene && p.mode == old.mode && p.setting == old.setting;
    });
    if (found == after.end() || old.runs.empty() || found->runs.empty()) continue;
    const std::optional<bool> same = samePictures(old, *found);
    for (const Quantity& q : kQuantities) {
      const Logarithms a = logarithms(old, q.value), b = logarithms(*found, q.value);
      if (a.empty() || b.empty()) continue;
      Change change{old.scene, old.mode, old.setting, q.name};
      change.chance = test(a, b, change);
      if (q.kind == Quantity::Exact) {
        // Other scenes or seeds need not have the same counts.
        change.judged = same.has_value();
        change.changed = change.judged && std::abs(change.ratio - 1) > kTolerance;
        change.chance = 1;
      } else if (q.kind == Quantity::Error && same == true) {
        change.judged = true, change.chance = 1;
      } else if (change.judged) {
        ++tests;
      }
      if (q.kind == Quantity::Time && haveEqualSeeds(a, b)) times[q.name].push_back(differences(a, b));
      changes.push_back(change);
    }
    if (same) {
      changes.push_back({old.scene, old.mode, old.setting, "picture", 0, 0, 1, 0, true, !*same});
    }
  }
  for (const auto& [name, settings] : times) {
    const Summary pairs = meanOver(settings);
    if (settings.size() < 2 || pairs.count < 2) continue;
    const double ratio = std::exp(pairs.mean);
    changes.push_back({kAllSettings, "", "", name, 1, ratio, ratio, ratio * pairs.standardError(), true,
                       false, studentTest(pairs).p});
    ++tests;
  }
  const double threshold = sidak(kSignificance, tests);
  for (Change& c : changes)
    if (c.chance < threshold && std::abs(c.ratio - 1) > kTolerance) c.changed = true;
  return changes;
}

std::string describeChanges(std::span<const Change> changes) {
  if (changes.empty()) return "Nothing to compare: no setting of a scene was measured in both.\n";
  const auto name = [](const Change& c) {
    return c.mode.empty() ? c.scene : fmt::format("{}/{}/{}", c.scene, c.mode, c.setting);
  };
  const auto value = [](const Change& c) {
    if (c.quantity == "picture") return std::string(c.changed ? "other bits" : "the same bits");
    std::string text = c.mode.empty() ? "" : fmt::format("{:.4g} -> {:.4g}, ", c.before, c.after);
    text += fmt::format("ratio {:.4f} ± {:.4f}", c.ratio, c.ratioError);
    return c.chance < 1 ? text + fmt::format(", p {:.2g}", c.chance) : text;
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
