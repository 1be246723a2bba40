// SPDX-License-Identifier: Apache-2.0
// Whether modes show what path mode shows, as far as noise lets one say.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace patina::stress {

/// Means of blocks of pixels and their channels: [picture][block and channel].
using Blocks = std::vector<std::vector<double>>;

/// How far a mode is from path mode. Bias is allowed: a part of each block's mean, and a fifth of that part
/// of the whole picture's, for dark blocks beside bright ones.
struct Agreement {
  // Of the block and channel that speaks loudest against the mode:
  double chance =
      1;  ///< of such a difference or a larger one, if the bias were what is allowed (Welch's test)
  double difference = 0, reference = 0, standardError = 0;

  double pictureBias = 0;   ///< relative, of the whole picture's mean
  double pictureError = 0;  ///< one standard error of that
  /// The largest standard error of a block over the bias that it is allowed, of either mode's pictures. Bias
  /// beyond what is allowed is sure to be found where the sum of their squares is well below 1.
  double noise = 0, pathNoise = 0;
  size_t tests = 0;      ///< blocks times channels
  bool isBlack = false;  ///< so is path mode's picture, all of it

  bool differs(double significance) const { return chance < significance; }
};

/// Two pictures of each at least, of as many blocks.
Agreement agreementOf(const Blocks& mode, const Blocks& path, double bias);

struct ComparisonSettings {
  double bias = 0.05;    ///< that is allowed, relative
  int pictures = 12;     ///< of each mode
  double noise = 0.15;   ///< of both modes that is aimed at, in terms of the bias that is allowed
  double seconds = 120;  ///< for all that is rendered
  double mostEffort = 1 << 14;
};

/// Renders a mode with so many times the least number of samples, with random numbers that are the seed's
/// own. Nothing: it could not, or not within so many seconds.
using RenderBlocks = std::function<std::optional<std::vector<double>>(const std::string& mode, double effort,
                                                                      int seed, double seconds)>;

struct Comparison {
  std::map<std::string, Agreement> agreements;  ///< by mode; those that were rendered in time
  std::map<std::string, double> efforts;        ///< by mode, path's too
  bool isOutOfTime = false;                     ///< noise is higher than it was to be
  double seconds = 0;
};

/// Compares each of `modes` with "path". Samples are quadrupled for whichever mode is noisy, until noise is
/// low enough or time is up: a decision that knows nothing of the differences. One that is found then must be
/// found once more in new pictures of four times the samples, if time allows: rare bright paths make the
/// means of fewer samples too low, and say nothing of it.
Comparison compareModes(const std::vector<std::string>& modes, const RenderBlocks& render,
                        const ComparisonSettings& settings);

}  // namespace patina::stress
