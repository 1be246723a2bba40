// SPDX-License-Identifier: Apache-2.0
// From a primitive's parameter list to checked primitive variables.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "renderer/scene/scene.h"
#include "rib/params.h"

namespace patina {

/// The variables of a primitive, each with as many values as its class asks for. Pw and Pz become P; Pw stays
/// as well when a weight differs from 1. A variable with a wrong count is left out with a warning. nullopt
/// after an error has been reported: P is missing or too short, or a value is not finite. `shape` must be
/// consistent (see shapeProblem).
std::optional<std::vector<PrimVar>> readVariables(const Shape& shape, const ParamList& params,
                                                  std::string_view request, const Location& at,
                                                  ErrorHandler& errors);

/// Moves "P" by a perspective matrix, with division; N is left out, as it has no simple image. False if a
/// point has none.
bool projectVariables(const M44d& matrix, std::vector<PrimVar>& variables);

}  // namespace patina
