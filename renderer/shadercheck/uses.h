// SPDX-License-Identifier: Apache-2.0
// What a shader can be bound as: which of its entry points do something for some of its parameters.
#pragma once

#include <cstdint>

#include "patina/shader.h"

namespace patina::shadercheck {

struct Uses {
  uint32_t active = 0;      ///< bits (1 << PatinaEntry)
  uint32_t lightKinds = 0;  ///< bits (1 << PatinaLightKind); none where light is not active
  bool fromPoint = false;   ///< PATINA_TRAIT_FROM_POINT
  bool atmosphere = false;  ///< PATINA_EXTENSION_ATMOSPHERE
};

/// The union over the parameter sets of the checks (defaults, ends of ranges, with textures and without).
/// Runs the plugin's `prepare` in this process. [main]
Uses usesOf(const PatinaShader& shader);

}  // namespace patina::shadercheck
