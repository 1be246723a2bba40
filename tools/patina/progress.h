// SPDX-License-Identifier: Apache-2.0
// Tells the user how far a frame is: one line rewritten on a terminal, or lines for a program that reads
// them.
#pragma once

#include <chrono>

namespace patina {

class Progress {
 public:
  enum class Style {
    None,
    Terminal,  ///< "  37 %  elapsed 0:12  left 0:20", rewritten on standard output
    Lines      ///< "R90000 37" on standard output whenever the percentage changes
  };

  explicit Progress(Style style);
  ~Progress();  ///< clears the terminal's line
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void update(double fraction);  ///< from 0 to 1 [not concurrently]

 private:
  using Clock = std::chrono::steady_clock;

  Style style_;
  Clock::time_point start_, printed_;
  int percent_ = -1;
};

}  // namespace patina
