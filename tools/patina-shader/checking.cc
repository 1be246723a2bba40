// SPDX-License-Identifier: Apache-2.0
// Verdicts as text and as JSON.
#include "tools/patina-shader/checking.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace patina {

std::string textReport(const shadercheck::Verdict& verdict) {
  std::string text;
  for (const shadercheck::Fault& fault : verdict.faults) text += toString(verdict.shader, fault) + '\n';
  const size_t count = verdict.faults.size();
  return text + fmt::format("{}: {} checks, {} fault{}\n", verdict.shader, verdict.checks, count,
                            count == 1 ? "" : "s");
}

std::string jsonReport(const std::vector<shadercheck::Verdict>& verdicts) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const shadercheck::Verdict& verdict : verdicts) {
    nlohmann::ordered_json faults = nlohmann::ordered_json::array();
    for (const shadercheck::Fault& f : verdict.faults)
      faults.push_back({{"check", f.check}, {"entry", f.entry}, {"text", f.text}, {"detail", f.detail}});
    all.push_back({{"shader", verdict.shader}, {"checks", verdict.checks}, {"faults", faults}});
  }
  return all.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + '\n';
}

}  // namespace patina
