// SPDX-License-Identifier: Apache-2.0
// Progress on a terminal or as lines.
#include "tools/patina/progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <string>

namespace patina {
namespace {

std::string minutes(double seconds) {
  const auto whole = static_cast<long>(std::min(seconds, 1e9) + 0.5);
  if (whole < 3600) return fmt::format("{}:{:02}", whole / 60, whole % 60);
  return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

}  // namespace

Progress::Progress(Style style)
    : style_(style), start_(Clock::now()), printed_(start_ - std::chrono::seconds(1)) {
  update(0);
}

Progress::~Progress() {
  if (style_ == Style::Terminal) fmt::print("\r\033[K");
  std::fflush(stdout);
}

void Progress::update(double fraction) {
  const int percent = static_cast<int>(std::clamp(fraction, 0.0, 1.0) * 100);
  if (style_ == Style::Lines && percent > percent_) {
    fmt::print("R90000 {:4}\n", percent);
    std::fflush(stdout);
  }
  const Clock::time_point now = Clock::now();
  if (style_ == Style::Terminal && (percent > percent_ || now - printed_ > std::chrono::milliseconds(500))) {
    const double elapsed = std::chrono::duration<double>(now - start_).count();
    const std::string left = fraction > 0.01 ? "  left " + minutes(elapsed * (1 - fraction) / fraction) : "";
    fmt::print("\r{:3} %  elapsed {}{}\033[K", percent, minutes(elapsed), left);
    std::fflush(stdout);
    printed_ = now;
  }
  percent_ = std::max(percent_, percent);
}

}  // namespace patina
