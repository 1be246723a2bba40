// SPDX-License-Identifier: Apache-2.0
// A shader's parameter table as text: for RIB files and for documentation. Runs no code of the plugin.
#pragma once

#include <string>

#include "patina/shader.h"

namespace patina {

/// A comment and one Declare line per parameter, with the default as an in-line declaration behind it.
std::string ribListing(const PatinaShader& shader);

/// A heading, the line of documentation, and a table of the parameters.
std::string markdownListing(const PatinaShader& shader);

}  // namespace patina
