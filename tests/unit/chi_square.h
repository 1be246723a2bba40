// SPDX-License-Identifier: Apache-2.0
// Chi-square tests of goodness of fit: whether samples are distributed as the density says that goes with
// them (PBR 4th ed. section A.1; Knuth, The Art of Computer Programming 2, section 3.3.1).
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/math/special_functions/gamma.hpp>
#include <functional>
#include <numbers>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "renderer/base/sampling.h"
#include "tools/patina-bench/statistics.h"

namespace patina::test {

/// Independent numbers. Sobol points would not do: they fall more evenly than chance allows, and the
/// statistic of evenly spread counts does not have the chi-square distribution.
class Independent {
 public:
  explicit Independent(uint64_t seed) : seed_(seed) {}
  float next() { return toUnit(static_cast<uint32_t>(hashOf(seed_, count_++) >> 32)); }
  V2f next2() {
    const float x = next();
    return {x, next()};
  }

 private:
  uint64_t seed_, count_ = 0;
};

inline constexpr uint32_t kChiSquareSamples = 1 << 18;

/// Integral of g over a rectangle by Simpson's rule on a grid, in quarters where its two parts, the midpoint
/// and the trapezoidal rule, differ by more than `tolerance` and a thousandth. The latter looks at the very
/// edge of the rectangle, so that what reaches just into it is seen.
template <class Function>
double integrate(const Function& g, double x0, double x1, double y0, double y1, double tolerance,
                 int steps = 8, int depth = 9) {
  double midpoints = 0, corners = 0;
  const auto at = [&](double i, double j) {
    return g(x0 + (x1 - x0) * i / steps, y0 + (y1 - y0) * j / steps);
  };
  for (int j = 0; j < steps; ++j)
    for (int i = 0; i < steps; ++i) midpoints += at(i + 0.5, j + 0.5);
  for (int j = 0; j <= steps; ++j)
    for (int i = 0; i <= steps; ++i) corners += at(i, j) * (i % steps ? 1 : 0.5) * (j % steps ? 1 : 0.5);
  const double area = (x1 - x0) * (y1 - y0) / (steps * steps), value = (2 * midpoints + corners) / 3 * area;
  if (depth == 0 || std::abs(midpoints - corners) * area <= tolerance + 1e-3 * std::abs(value)) return value;
  // Errors of the quarters are as good as independent: each may have half the tolerance.
  const double x = (x0 + x1) / 2, y = (y0 + y1) / 2;
  const auto quarter = [&](double left, double right, double low, double high) {
    return integrate(g, left, right, low, high, tolerance / 2, 4, depth - 1);
  };
  return quarter(x0, x, y0, y) + quarter(x, x1, y0, y) + quarter(x0, x, y, y1) + quarter(x, x1, y, y1);
}

/// What quadrature may get wrong in a cell without spoiling the test, as a probability: half a sample,
/// where cells expect hundreds and so have standard deviations of ten and more.
inline constexpr double kCellTolerance = 0.5 / kChiSquareSamples;

/// The same on every machine, as std::hash need not be.
inline uint64_t seedOf(const std::string& name) {
  uint64_t seed = name.size();
  for (const char c : name) seed = hashOf(seed, c);
  return seed;
}

/// Cells of equal height or not, around an axis: row k has 1 - cos(theta) between heights[k] and [k + 1].
class SphereGrid {
 public:
  SphereGrid(const Frame& frame, std::vector<double> heights, size_t columns)
      : frame_(frame), heights_(std::move(heights)), columns_(columns) {}
  /// Cells of equal solid angle: rows do not grow where they are low beside `height`.
  static SphereGrid even(const V3f& axis, size_t rows = 16) { return narrow(axis, 1e6, rows); }
  /// The whole sphere in rows that grow from about `height` at both ends of the axis, for densities that are
  /// narrow there.
  static SphereGrid narrow(const V3f& axis, double height, size_t rows = 20, size_t columns = 16) {
    std::vector<double> heights(rows + 1);
    const double growth = std::log1p(1 / height);
    for (size_t k = 0; k <= rows / 2; ++k) {
      heights[k] = height * std::expm1(growth * static_cast<double>(2 * k) / static_cast<double>(rows));
      heights[rows - k] = 2 - heights[k];
    }
    heights[rows / 2] = 1;
    return {Frame(axis), std::move(heights), columns};
  }

  /// Rows of equal solid angle in a cone with 1 - cos = `height` at its rim. A narrow row about the rim keeps
  /// it from the others' quadrature, as a direction on the rim is in the cone or not by rounding.
  static SphereGrid cone(const V3f& axis, double height) {
    std::vector<double> heights;
    for (int k = 0; k < 16; ++k) heights.push_back(height * k / 16);
    heights.insert(heights.end(), {height * (1 - 2e-4), height * (1 + 2e-4), 2});
    return {Frame(axis), std::move(heights), 16};
  }

  size_t cells() const { return (heights_.size() - 1) * columns_; }

  size_t cellOf(const V3f& direction) const {
    // Half the square of the chord is 1 - cos, and keeps its digits near the axis.
    const double height = V3d(direction - frame_.z).length2() / 2;
    const auto above = std::upper_bound(heights_.begin() + 1, heights_.end() - 1, height);
    const V3f local = frame_.toLocal(direction);
    const double turn =
        std::atan2(static_cast<double>(local.y), static_cast<double>(local.x)) / (2 * std::numbers::pi) + 0.5;
    const auto column = static_cast<size_t>(turn * static_cast<double>(columns_));
    return static_cast<size_t>(above - heights_.begin() - 1) * columns_ + std::min(column, columns_ - 1);
  }

  /// Integral over each cell of a function of unit directions.
  template <class Function>
  std::vector<double> integrals(const Function& f, double tolerance = kCellTolerance) const {
    std::vector<double> result;
    for (size_t row = 0; row + 1 < heights_.size(); ++row)
      for (size_t column = 0; column < columns_; ++column) {
        const auto phi = [&](size_t k) {
          return (static_cast<double>(k) / static_cast<double>(columns_) - 0.5) * 2 * std::numbers::pi;
        };
        result.push_back(integrate(
            [&](double height, double at) {
              const double sine = std::sqrt(std::max(height * (2 - height), 0.0));
              const V3d x(frame_.x), y(frame_.y), z(frame_.z);
              const V3d d = x * (sine * std::cos(at)) + y * (sine * std::sin(at)) + z * (1 - height);
              return static_cast<double>(f(V3f(d)));
            },
            heights_[row], heights_[row + 1], phi(column), phi(column + 1), tolerance));
      }
    return result;
  }

 private:
  Frame frame_;
  std::vector<double> heights_;
  size_t columns_;
};

/// Cases of all chi-square tests together, or a few more.
inline constexpr size_t kAllCases = 280;

/// The fits of one test. Each case is judged at the level that gives all of the suite together 1 % (Sidak).
class Fits {
 public:
  explicit Fits(double quadratureError = 3e-4) : quadratureError_(quadratureError) {}
  ~Fits() {
    const double level = bench::sidak(0.01, kAllCases);
    double least = 1;
    for (const Case& c : cases_) {
      least = std::min(least, c.p);
      EXPECT_GE(c.p, level) << c.name << ": chi square " << c.chi << ", freedom " << c.freedom;
    }
    testing::Test::RecordProperty("cases", static_cast<int>(cases_.size()));
    testing::Test::RecordProperty("smallest_p", std::to_string(least));
  }
  Fits(const Fits&) = delete;
  Fits& operator=(const Fits&) = delete;

  /// `counts` and `probabilities` have the same cells; the rest of kChiSquareSamples found nothing, which the
  /// probabilities must leave room for.
  void add(const std::string& name, std::vector<double> counts, std::vector<double> probabilities) {
    ASSERT_EQ(counts.size(), probabilities.size());
    const double total = std::accumulate(probabilities.begin(), probabilities.end(), 0.0);
    EXPECT_LE(total, 1 + quadratureError_) << name << ": the density integrates to more than one";
    counts.push_back(kChiSquareSamples - std::accumulate(counts.begin(), counts.end(), 0.0));
    probabilities.push_back(std::max(1 - total, 0.0));
    if (1 - total < quadratureError_ && counts.back() < quadratureError_ * kChiSquareSamples) {
      // As near to one as quadrature can tell: whether a few samples found nothing is not to be judged.
      counts.pop_back(), probabilities.pop_back();
    }
    Case c = judge(counts, probabilities);
    c.name = name;
    cases_.push_back(c);
  }

 private:
  struct Case {
    std::string name;
    double p = 1, chi = 0;
    size_t freedom = 0;
  };

  static Case judge(const std::vector<double>& counts, const std::vector<double>& probabilities) {
    // The statistic has its distribution only where enough is expected: the scarcest cells become one.
    std::vector<size_t> order(counts.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::ranges::sort(order, {}, [&](size_t k) { return probabilities[k]; });
    Case c;
    double observed = 0, expected = 0;
    size_t cells = 0;
    for (const size_t k : order) {
      observed += counts[k], expected += probabilities[k] * kChiSquareSamples;
      if (expected < kLeastExpected) continue;
      c.chi += (observed - expected) * (observed - expected) / expected;
      ++cells;
      observed = expected = 0;
    }
    EXPECT_GT(cells, 1u) << "too few samples are expected";
    c.freedom = std::max<size_t>(cells, 2) - 1;
    c.p = boost::math::gamma_q(static_cast<double>(c.freedom) / 2, c.chi / 2);
    return c;
  }

  static constexpr double kLeastExpected = 5;
  double quadratureError_;
  std::vector<Case> cases_;
};

/// Adds a test of directions. `sample(random)` gives a unit direction or nothing; `pdf(direction)` is per
/// solid angle.
template <class Sample, class Pdf>
void fitDirections(Fits& fits, const std::string& name, const SphereGrid& grid, const Sample& sample,
                   const Pdf& pdf) {
  std::vector<double> counts(grid.cells());
  Independent random(seedOf(name));
  for (uint32_t k = 0; k < kChiSquareSamples; ++k)
    if (const std::optional<V3f> direction = sample(random)) ++counts[grid.cellOf(*direction)];
  fits.add(name, std::move(counts), grid.integrals(pdf));
}

}  // namespace patina::test
