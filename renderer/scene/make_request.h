// SPDX-License-Identifier: Apache-2.0
// What RI's Make requests ask for: a texture file made of pictures.
#pragma once

#include <string>
#include <vector>

#include "rib/error.h"

namespace patina {

/// MakeTexture, MakeBump, MakeLatLongEnvironment, MakeCubeFaceEnvironment or MakeShadow, as it stands in the
/// RIB: names are not looked for yet.
struct MakeRequest {
  enum class Kind { Texture, Bump, LatLong, CubeFace, Shadow };
  Kind kind = Kind::Texture;
  std::vector<std::string> pictures;  ///< one; of CubeFace px nx py ny pz nz
  std::string texture;
  std::string sWrap, tWrap;  ///< "black", "periodic", "clamp"; Texture and Bump
  std::string filter;        ///< RI's names
  float fov = 90;            ///< degrees; CubeFace
  std::string colorSpace;  ///< parameter "colorspace": "srgb", "linear", "raw"; "" = by the rule for textures
  std::string searchPath;  ///< Option "searchpath" "texture", RI path syntax
  std::string ocioConfig;  ///< Option "patina" "ocio", "" = not said
  Location where;
};

}  // namespace patina
