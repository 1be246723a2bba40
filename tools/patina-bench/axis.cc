// SPDX-License-Identifier: Apache-2.0
// Ranges and ticks.
#include "tools/patina-bench/axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace patina::bench {
namespace {

constexpr double kLabelAll = 2.2;  // decades up to which 2 and 5 have labels

// The next of 1, 2, 5 times a power of ten below a value, or above it.
double rounded(double value, bool up) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  constexpr double kSteps[] = {1, 2, 5, 10};
  const double part = value / power;
  if (up) return power * *std::ranges::find_if(kSteps, [&](double s) { return part <= s * (1 + 1e-9); });
  return power * *std::ranges::find_if(std::rbegin(kSteps), std::rend(kSteps),
                                       [&](double s) { return s <= part * (1 + 1e-9); });
}

}  // namespace

LogAxis::LogAxis(double least, double most, double pageFrom, double pageTo)
    : low_(rounded(least, false)), high_(rounded(most, true)), from_(pageFrom), to_(pageTo) {
  // A decade at least, so that noise does not fill the plot.
  while (high_ < low_ * 9.99) high_ = rounded(high_ * 1.01, true);
}

double LogAxis::at(double value) const {
  return from_ + std::log(value / low_) / std::log(high_ / low_) * (to_ - from_);
}

std::vector<LogAxis::Tick> LogAxis::ticks() const {
  const bool all = std::log10(high_ / low_) <= kLabelAll;
  std::vector<Tick> found;
  for (double power = std::floor(std::log10(low_) + 1e-9); power <= std::log10(high_) + 1e-9; ++power)
    for (int k = 1; k < 10; ++k) {
      const double value = k * std::pow(10.0, power);
      if (value < low_ * (1 - 1e-9) || value > high_ * (1 + 1e-9)) continue;
      found.push_back({value, k == 1, k == 1 || (all && (k == 2 || k == 5))});
    }
  return found;
}

std::string svgNumber(double value) {
  if (value >= 0.000999 && value < 9999.5) return fmt::format("{:.4g}", value);
  const double power = std::floor(std::log10(value) + 1e-9);
  const double part = value / std::pow(10.0, power);
  const std::string factor = std::abs(part - 1) < 1e-6 ? "" : fmt::format("{:.3g}·", part);
  return fmt::format("{}10<tspan dy=\"-4\" font-size=\"9\">{}{:g}</tspan>", factor, power < 0 ? "−" : "",
                     std::abs(power));
}

}  // namespace patina::bench
