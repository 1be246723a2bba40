// SPDX-License-Identifier: Apache-2.0
// What came of random scenes, as lines to go on from and as tables to read.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "tests/stress/mode_comparison.h"

namespace patina::stress {

/// What came of one scene.
struct Row {
  uint64_t number = 0;
  std::vector<std::string> ingredients;
  bool isComparable = false;              ///< RandomScene::comparable
  std::vector<std::string> wrong;         ///< what no scene may do
  std::map<std::string, double> seconds;  ///< by mode
  bool areSamplesRefused = false;
  Comparison comparison;  ///< without agreements: there is none
};

nlohmann::json asJson(const Row& row);
/// nlohmann::json::exception where something is missing.
Row rowOf(const nlohmann::json& json);

/// For a terminal.
std::string asLine(const Row& row);

struct Summary {
  std::string table, text;  ///< Markdown
  int bad = 0;              ///< scenes that do what none may, or differ
};
/// Differences are judged at a significance of 1e-3 of all comparisons together (Sidak).
Summary summaryOf(std::span<const Row> rows, std::span<const std::string> modes, double bias);

}  // namespace patina::stress
