// SPDX-License-Identifier: Apache-2.0
// Two sets of measurements, or two kinds of pictures, against each other.
#pragma once

#include "tools/patina-bench/render.h"

namespace patina::bench {

inline constexpr double kSignificance = 0.01;  ///< of all tests of a comparison together
/// Ratios that nobody minds. Threads may make an entry of the cache twice, too: counts agree to within it.
inline constexpr double kTolerance = 1e-3;

/// One quantity of one setting, old against new.
struct Change {
  std::string scene, mode, setting, quantity;
  double before = 0, after = 0;      ///< means
  double ratio = 1, ratioError = 0;  ///< after / before and its standard error, of repeats
  bool judged = false;               ///< both have repeats, or no noise to speak of
  bool changed = false;
  double chance = 1;  ///< of such a ratio if nothing had changed; 1 where nothing is left to chance
};
/// Compares wall and CPU time, memory and relMSE of what both have by their logarithms over repeats, at
/// kSignificance over all (Sidak). When both have the same seeds, by Student's test of the differences of the
/// pairs: neither the noise of a seed nor, if they were measured by turns, what disturbed the machine
/// meanwhile counts then; else by Welch's test. Times are also compared for all settings together, whose
/// chances are better: by the mean over settings of each repeat. Rays, shader points and pictures are
/// compared by their values, as equal seeds give equal ones. Ratios within kTolerance of 1 are no change.
/// Those of one build each.
std::vector<Change> compareRuns(std::span<const Point> before, std::span<const Point> after);
/// As Markdown: what has changed by more than chance, or that nothing did; then all ratios.
std::string describeChanges(std::span<const Change> changes);

/// Whether the means of blocks of pixels agree between two settings.
struct Agreement {
  std::string scene, failure;
  size_t blocks = 0;     ///< of pixels
  size_t differing = 0;  ///< blocks with a channel that differs
  double largestT = 0;   ///< |t|, over blocks and channels
  double threshold = 0;  ///< p below which one test says that it differs
  double smallestP = 1;
  double meanDifference = 0;  ///< of the whole picture, in units of the first setting's mean
};
/// Welch's test of each block and channel over pictures of independent seeds; pictures[k]: blockMeans() of
/// one. At kSignificance over all tests (Sidak).
Agreement compareBlocks(std::span<const std::vector<double>> a, std::span<const std::vector<double>> b);
std::string describeAgreements(std::span<const Agreement> agreements);

}  // namespace patina::bench
