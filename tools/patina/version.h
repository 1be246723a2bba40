// SPDX-License-Identifier: Apache-2.0
// What this program is a build of.
#pragma once

#include <string>

namespace patina {

/// Lines: name and version; commit; compiler, build type and flags.
std::string versionText();

}  // namespace patina
