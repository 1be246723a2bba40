// SPDX-License-Identifier: Apache-2.0
// Carries out RI's Make requests: finds their pictures, and writes textures where a RIB may write.
#pragma once

#include <string>

#include "renderer/scene/make_request.h"

namespace patina {

struct TextureMaking {
  std::string texturePath;  ///< searched for pictures before the RIB's own, RI path syntax
  std::string ocioConfig;   ///< path, "" = none: see TextureColors
  /// Textures may be named by absolute paths and with "..": else they stay in the working folder and those
  /// below it.
  bool allowPaths = false;
  bool asInFile = false;  ///< colours are not made linear
};

/// Makes the texture unless there is one that is newer than its pictures, and returns its absolute path.
/// "": there is none, which has been reported. The texture appears whole or not at all, in place of a former
/// one; other files than pictures are never replaced. [one thread]
std::string makeTexture(const MakeRequest& request, const TextureMaking& settings, ErrorHandler& errors);

}  // namespace patina
