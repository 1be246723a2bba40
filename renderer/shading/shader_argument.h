// SPDX-License-Identifier: Apache-2.0
// Fits the arguments of a RIB request to the parameters of a shader: types, lengths, ranges, names.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "patina/shader.h"
#include "renderer/scene/scene.h"
#include "rib/error.h"

namespace patina {

/// Where the values of one parameter go: `floats`, `ints` or `strings` by its type, as long as it needs.
struct ArgumentSlot {
  std::vector<float>& floats;
  std::vector<int32_t>& ints;
  std::vector<std::string>& strings;
};

/// The PatinaType of a RIB's type; 0 = there is none.
uint32_t typeOf(ValueType type);
/// Numbers in all in a value of the parameter: 1, 3, 4 or 16 times the array length.
uint32_t valueCountOf(const PatinaParameter& parameter);

/// Index of the parameter that an argument is for, or -1: reported as a warning with the nearest known name.
int findParameter(const PatinaShader& shader, const ShaderArgument& argument, ErrorHandler& errors);

/// Copies the argument's values. False: they do not fit, which is reported, and `slot` is unchanged. Values
/// out of the parameter's range are taken, with a warning.
bool bindArgument(const PatinaShader& shader, const PatinaParameter& parameter,
                  const ShaderArgument& argument, const ArgumentSlot& slot, ErrorHandler& errors);

}  // namespace patina
