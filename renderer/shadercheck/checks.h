// SPDX-License-Identifier: Apache-2.0
// The checks that every shader has to pass, one function each. They run the shader's code: see check_shader.h
// for how a process survives that.
#pragma once

#include <span>

#include "renderer/shadercheck/subject.h"

namespace patina::shadercheck {

struct Check {
  const char* name;
  void (*run)(const Context& context);
};
std::span<const Check> allChecks();

// The table and `prepare` (checks_prepare.cc).
void checkTable(const Context& context);    ///< names, docs, ranges, defaults
void checkPrepare(const Context& context);  ///< any values in range are taken, twice alike; release frees

// What results may depend on (checks_arguments.cc).
void checkUndeclaredChannels(const Context& context);
void checkLanes(const Context& context);    ///< each by itself: neighbours, order, padding, memory
void checkStrides(const Context& context);  ///< one value for all lanes is that value in every lane
void checkHistory(const Context& context);  ///< earlier calls, other instances
void checkThreads(const Context& context);  ///< several threads on one instance (checks_threads.cc)

// What results may be (checks_values.cc).
void checkFinite(const Context& context);
void checkEnergy(const Context& context);  ///< reflectance + transmittance <= opacity <= 1
void checkLobes(const Context& context);
void checkCustomLobes(const Context& context);  ///< formulas of the shader's own (checks_lobes.cc)
void checkFlags(const Context& context);  ///< OPAQUE, BLACK, EMITS, TRANSMITS, OPACITY_IS_OS, TRANSPARENT
void checkInactive(const Context& context);
void checkDisplacement(const Context& context);
void checkAtmosphere(const Context& context);  ///< checks_atmosphere.cc

// Lights (checks_lights.cc, checks_sphere.cc).
void checkLightSamples(const Context& context);
void checkPointLights(const Context& context);
void checkInfiniteLights(const Context& context);  ///< densities, over the sphere

}  // namespace patina::shadercheck
