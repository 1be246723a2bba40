// SPDX-License-Identifier: Apache-2.0
// Who gets how much of the time that there is.
#pragma once

#include <algorithm>
#include <chrono>
#include <map>
#include <string>
#include <vector>

#include "tools/patina-bench/scenes.h"

namespace patina::bench {

/// What is left of a number of wall seconds; 0 = there is no limit.
class Budget {
 public:
  explicit Budget(double seconds) : limited_(seconds > 0), seconds_(seconds), start_(Clock::now()) {}
  bool limited() const { return limited_; }
  double elapsed() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  double left() const { return std::max(seconds_ - elapsed(), 0.0); }

 private:
  using Clock = std::chrono::steady_clock;
  bool limited_;
  double seconds_;
  Clock::time_point start_;
};

/// The settings of all modes by turns, the first of each mode first: quick ones come before slow ones when
/// each mode's are in that order, and a budget that ends too early ends all modes alike.
std::vector<Setting> byTurns(const std::vector<Setting>& settings);

/// Shares the time of one scene among its modes. Each setting of a mode is taken to need twice the time of
/// the one before at least; a mode ends with the first setting that has no room.
class Shares {
 public:
  explicit Shares(const std::vector<Setting>& settings);
  /// Seconds that the next setting of a mode may take, of those that the scene has left; 0 = it is not to
  /// begin.
  double allow(const std::string& mode, double left);
  /// What it took, or that it had to be ended: nothing slower is tried then.
  void took(const std::string& mode, double seconds, bool ended);
  /// One setting of the mode is done with, begun or not; what a mode does not need goes to the others.
  void pass(const std::string& mode);

 private:
  struct Mode {
    int settings = 0;  // to come
    double last = 0;   // seconds
    bool ended = false;
  };
  std::map<std::string, Mode> modes_;
};

}  // namespace patina::bench
