// SPDX-License-Identifier: Apache-2.0
// A program as a child process, with what it cost.
#pragma once

#include <string>
#include <vector>

namespace patina::bench {

struct ChildUsage {
  double wallSeconds = 0;  ///< from its start to its end
  double cpuSeconds = 0;   ///< user and system, all threads
  double peakMb = 0;       ///< resident at most; never less than what this process held when it began
  std::string failure;     ///< why it did not end with status 0; "" = it did
  bool outOfTime = false;  ///< it was killed at its time limit
};

struct ChildSettings {
  std::string folder;         ///< to run in; "" = this process's
  std::string log;            ///< file for what it prints
  double timeoutSeconds = 0;  ///< it is killed then; 0 = never
};

/// Runs a program to its end; command[0] is its path. What goes wrong is told by `failure`, with the last
/// line of the log.
ChildUsage runChild(const std::vector<std::string>& command, const ChildSettings& settings);

}  // namespace patina::bench
