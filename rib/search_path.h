// SPDX-License-Identifier: Apache-2.0
// RI's search paths: folders between colons, "&" for what was there before, "@" for the standard places,
// $NAME or
// ${NAME} for a variable of the environment.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace patina {

/// `path` with each element "&" replaced by `previous`.
std::string expandSearchPath(std::string_view path, std::string_view previous);

/// The folders of a path in order, without repetitions; each element "@" gives way to `standard`, and
/// variables to their values, which may be paths of several folders. An element with a variable that is not
/// set is left out.
std::vector<std::string> searchFolders(std::string_view path, const std::vector<std::string>& standard);

/// The first regular file `name` in `folders` (an absolute name is taken as it is), or its twin with ".gz"
/// added or taken away. `tried` gets every path looked at. What lies outside of the sandbox is passed over.
std::optional<std::string> findFile(std::string_view name, const std::vector<std::string>& folders,
                                    std::vector<std::string>& tried);

/// One path per file, however it is spelt: symbolic links and ".." resolved.
std::string canonicalPath(const std::string& path);

}  // namespace patina
