// SPDX-License-Identifier: Apache-2.0
// A file of its own, as it is compiled anew for every commit.
#include "tools/patina/version.h"

#include "patina_commit.h"

namespace patina {

std::string versionText() { return "patina " PATINA_VERSION "\ncommit " PATINA_COMMIT "\n" PATINA_COMPILER; }

}  // namespace patina
