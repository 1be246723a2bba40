// SPDX-License-Identifier: Apache-2.0
// The jobs of patina-bench.
#pragma once

#include "tools/patina-bench/render.h"

namespace patina::bench {

struct BenchOptions {
  std::vector<std::string> scenes;  ///< see findScenes()
  std::filesystem::path output;     ///< folder of results.json, report.md, plots, sheets and pictures
  std::vector<std::string> builds;  ///< see findBuild(); none = defaultBuild()
  std::string settingsFile;         ///< JSON of parseSettings(); "" = defaultSettings()
  std::vector<std::string> only;    ///< patterns of isWanted()
  int repeats = 1;                  ///< pictures of each setting, of seeds 1, 2 ...
  int threads = 0;                  ///< 0 = one per processor
  double timeoutSeconds = 0;        ///< of a render; 0 = none
  double minutes = 36;              ///< for all; 0 = as long as it takes
  std::string command;              ///< as it was typed, for the report
  bool resume = false;              ///< what results.json holds already is not measured again
  bool list = false;                ///< say what would be run, and nothing else
  ReferenceOptions reference;       ///< its cache "" = a folder in `output`
  std::vector<double> targets = {1e-2, 1e-3, 3e-4};  ///< relMSE
};

// Each prints what it does and returns the exit status; they throw std::runtime_error when they cannot begin.

/// Measures all settings of all scenes and writes the report. 1 = some render failed, other than for want of
/// time.
int measure(const BenchOptions& options);
/// Renders two settings, each "MODE ARGUMENT ...", with `seeds` independent seeds each, and tests whether the
/// means of blocks of `block` x `block` pixels agree. 1 = some differ, or a render failed.
int testAgreement(const BenchOptions& options, const std::string& first, const std::string& second, int seeds,
                  int block);
/// Compares two files of results; see compareRuns(). 1 = something has changed.
int compareFiles(const std::string& before, const std::string& after);

}  // namespace patina::bench
