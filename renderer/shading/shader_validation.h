// SPDX-License-Identifier: Apache-2.0
// --validate-shaders: what renderer/shadercheck asks of a shader by itself, asked of the batches of a render.
//
// Of every batch: reflectance and transmittance make no energy, nothing is negative, traits are true, weights
// of lobes are at most one, displacement stays within its bound, and nothing is written outside of planes, as
// far as the guard zones around them tell. Of every seventh batch of a thread one lane
// is called again, alone, and with NaN in the channels that the entry point has not declared: it must give
// the same bits. What is found is reported as an error of the plugin: once for each kind of fault, with the
// first point, the number of times and the RIB's line. That values are finite is looked after in every
// render.
//
// The picture is the same with and without. Without, it costs one test of a flag per batch.
#pragma once

#include <atomic>
#include <functional>
#include <span>
#include <string>

#include "renderer/shading/shader_instance.h"

namespace patina {

/// Of the whole process, as statistics are. Set before rendering begins. [main]
void setShaderValidation(bool on);
namespace detail {
extern std::atomic<bool> shaderValidation;
}
inline bool validatesShaders() { return detail::shaderValidation.load(std::memory_order_relaxed); }

/// Where lane i is, for messages.
using LanePlace = std::function<std::string(size_t lane)>;

class Planes;
/// Reports that a call has written outside of planes that were begun with guard zones. [any thread]
void reportDamage(const ShaderInstance& shader, const char* entry, Planes& planes, const LanePlace& place);

// After a call that gave PATINA_OK, with what it was given and gave, before anything is repaired. [any
// thread]
void validateRadiosity(const ShaderInstance& shader, const PatinaPoints& in, const PatinaRadiosityOut& out,
                       const LanePlace& place);
void validateView(const ShaderInstance& shader, const PatinaPoints& in, const PatinaViewOut& out,
                  const LanePlace& place);
/// `P`, `N`: of the vertices before the call, world space.
void validateDisplacement(const ShaderInstance& shader, const PatinaPoints& in,
                          const PatinaDisplacementOut& out, std::span<const V3f> P, std::span<const V3f> N,
                          const LanePlace& place);

}  // namespace patina
