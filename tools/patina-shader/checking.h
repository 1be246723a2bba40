// SPDX-License-Identifier: Apache-2.0
// What --check prints of a shader.
#pragma once

#include <string>
#include <vector>

#include "renderer/shadercheck/check_shader.h"

namespace patina {

/// A line per fault, and "matte: 16 checks, 0 faults".
std::string textReport(const shadercheck::Verdict& verdict);

/// An array of {"shader", "checks", "faults": [{"check", "entry", "text", "detail"}]}.
std::string jsonReport(const std::vector<shadercheck::Verdict>& verdicts);

}  // namespace patina
