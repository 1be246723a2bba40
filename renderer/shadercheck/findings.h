// SPDX-License-Identifier: Apache-2.0
// What a check finds, and where it is in its work, written down so that it outlives the process that finds
// it.
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace patina::shadercheck {

/// "radiosity reads I, which it does not declare".
struct Fault {
  std::string check;   ///< name of the check
  std::string entry;   ///< entry point, or "prepare"
  std::string text;    ///< what it does wrong, as the rest of a sentence that begins with the entry point
  std::string detail;  ///< parameters, lanes and values of the first case
};

/// What the checking process does at the moment, in memory that its parent sees after its death.
struct Progress {
  char entry[64];
  char detail[192];
  void set(std::string_view entry, std::string_view detail);
};

/// Where checks write to. Each fault of an entry point is written once, with its first case. [one thread]
class Findings {
 public:
  /// `pipe` is a file descriptor, to which faults are written as they are found.
  Findings(int pipe, Progress& progress) : pipe_(pipe), progress_(progress) {}

  void fault(std::string_view entry, const std::string& text, const std::string& detail);
  Progress& progress() { return progress_; }

 private:
  int pipe_;
  Progress& progress_;
  std::set<std::string> known_;
};

/// Reads what Findings wrote.
std::vector<Fault> parseFindings(std::string_view text, const std::string& check);

}  // namespace patina::shadercheck
