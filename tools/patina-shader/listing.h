// SPDX-License-Identifier: Apache-2.0
// A shader's parameter table as text: for RIB files, for documentation and for programs. Runs no code of the
// plugin.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "patina/shader.h"
#include "renderer/shadercheck/uses.h"

namespace patina {

/// A comment and one Declare line per parameter, with the default as an in-line declaration behind it.
std::string ribListing(const PatinaShader& shader);

/// A heading, the line of documentation, and a table of the parameters.
std::string markdownListing(const PatinaShader& shader);

/// {"shader", "doc", "abi_minor", "parameters": [{"name", "type", "array_length" (0 = none), "storage",
/// "default": [numbers or texts], "minimum", "maximum" (absent: any value), "unit", "doc"}]}.
nlohmann::ordered_json jsonListing(const PatinaShader& shader);

/// What running it tells, to be added to that: {"entries": ["radiosity" ...], "light": ["delta" ...],
/// "from_point": bool}.
void addUses(nlohmann::ordered_json& listing, const shadercheck::Uses& uses);

}  // namespace patina
