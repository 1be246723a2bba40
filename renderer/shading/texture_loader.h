// SPDX-License-Identifier: Apache-2.0
// Loads the module that reads and makes textures, and finds texture files.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "renderer/shading/texture_module.h"

namespace patina {

/// The module, looked for in $PATINA_MODULE_PATH and the installation's folder; it stays loaded until the
/// process ends. nullptr: `tried` says where it is not, a line each. [any thread]
const PatinaTextureModule* loadTextureModule(std::string& tried);

/// Where a texture of that name may be, best first: in `folders` in their order, then as it is. Of names with
/// suffixes of other renderers' texture files also the pictures that such files are made from.
std::vector<std::string> textureCandidates(std::string_view name, const std::vector<std::string>& folders);

}  // namespace patina
