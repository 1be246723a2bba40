// SPDX-License-Identifier: Apache-2.0
// Where and with what something was measured: what a reader needs to judge the numbers.
#pragma once

#include <map>
#include <string>

namespace patina::bench {

struct Environment {
  std::string cpu;                            ///< model
  int processors = 0;                         ///< that programs may use
  double memoryGb = 0;                        ///< of the machine
  double load = 0;                            ///< average of the minute before; 0 = the machine was idle
  std::string system;                         ///< kernel and its release
  std::string date;                           ///< UTC, ISO 8601
  std::string command;                        ///< of patina-bench
  std::map<std::string, std::string> builds;  ///< what each program's --version says, by name
};

/// This machine, now; without command and builds.
Environment describeMachine();
/// What PROGRAM --version prints, lines joined by "; "; "" if it does not.
std::string versionOf(const std::string& program);
/// Words as one would type them in a shell.
std::string commandLine(int argc, const char* const* argv);

}  // namespace patina::bench
