// SPDX-License-Identifier: Apache-2.0
// Random RIB scenes that are made to break a renderer: each is a function of its number.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace patina::stress {

/// What a plugin says of a parameter that a random scene may set.
struct ShaderParameter {
  std::string name, type;           ///< type as in RIB: float, color, int ...
  double minimum = 0, maximum = 1;  ///< equal, or not finite: no range is known
};
struct LibraryShader {
  std::string name;
  std::vector<ShaderParameter> parameters;  ///< those without arrays
};

struct RandomScene {
  std::string rib;                       ///< ASCII, and binary where a number is NaN or infinite
  std::vector<std::string> ingredients;  ///< what is nasty in it, in words
  /// Light is sane: intensities, reflectances, colours and shader parameters are what their documentation
  /// allows. Then all modes but `direct` show the same picture, however odd the geometry is.
  bool comparable = true;
};

enum class RandomLight {
  Any,
  Sane  ///< the scene is lit, and comparable: other scenes than with Any, with geometry as odd, but without
        ///< micropolygons larger than pixels
};

/// Scene number `number`, with shaders of `library`: the same text each time for the same library and
/// compiler.
RandomScene makeRandomScene(uint64_t number, const std::vector<LibraryShader>& library,
                            RandomLight light = RandomLight::Any);

}  // namespace patina::stress
