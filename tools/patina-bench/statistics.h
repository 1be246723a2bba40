// SPDX-License-Identifier: Apache-2.0
// The numbers of a benchmark: errors of pictures, tests of means, time at equal error.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "renderer/film/image.h"

namespace patina::bench {

/// How far a picture is from its reference, over all pixels and the first three channels.
struct ImageErrors {
  double relMse = 0;                      ///< mean of (x - r)^2 / (r^2 + 0.01)
  std::array<double, 3> meanError{};      ///< mean of x - r
  std::array<double, 3> meanReference{};  ///< mean of r
  double percentile99 = 0;                ///< of |x - r| / sqrt(r^2 + 0.01)
};
/// The pictures have the same size and at least three channels; std::runtime_error says so if not, and if a
/// value of the first is not finite.
ImageErrors imageErrors(const ImageData& picture, const ImageData& reference);

/// What one pixel's squared error is divided by: see ImageErrors::relMse.
inline double relMseWeight(double reference) { return 1 / (reference * reference + 0.01); }

/// Mean of each block of size x size pixels and each of three channels, row by row; blocks at the right and
/// lower edge hold what is left.
std::vector<double> blockMeans(const ImageData& picture, int size);

struct Summary {
  size_t count = 0;
  double mean = 0;
  double variance = 0;  ///< of one value, unbiased; 0 for fewer than two
  double standardError() const;
};
Summary summarize(std::span<const double> values);

struct TTest {
  double t = 0;
  double freedom = 0;
  double p = 1;  ///< chance of such a |t| or a larger one if the means were the same
};
/// Welch's test of two means of unequal variances ("The generalization of 'Student's' problem when several
/// different population variances are involved", Biometrika 34, 1947). Two values without variance differ for
/// certain or not at all. Both need two values at least; else p is 1.
TTest welchTest(const Summary& a, const Summary& b);
/// Student's test of whether the mean of values, such as differences of pairs, is 0. Two values at least;
/// else p is 1.
TTest studentTest(const Summary& values);
/// Two-sided: chance of |t| or more by Student's distribution.
double studentTails(double t, double freedom);
/// Significance of each of `count` independent tests of which all together have `significance` (Sidak, 1967).
double sidak(double significance, size_t count);

struct CurvePoint {
  double seconds = 0, error = 0;  ///< both positive
};
/// The settings that no other one beats in both time and error, by rising time.
std::vector<CurvePoint> lowerEnvelope(std::vector<CurvePoint> points);

struct EqualError {
  enum Kind {
    Interpolated,
    AtMost,       ///< the quickest setting has a smaller error: these are its seconds
    Extrapolated  ///< beyond the best setting, along the last two or, of one alone, as 1 / seconds
  } kind = Interpolated;
  double seconds = 0;
};
/// Seconds that the lower envelope of the points needs for an error: straight lines from log time to log
/// error. Nothing when the points say nothing of it: there are none, or the best is more than a factor of
/// kFurthest away in time.
std::optional<EqualError> secondsAtError(std::vector<CurvePoint> points, double error);
inline constexpr double kFurthest = 30;

}  // namespace patina::bench
