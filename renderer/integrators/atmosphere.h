// SPDX-License-Identifier: Apache-2.0
// RI's Atmosphere: what lies between the eye and the surfaces that it sees.
#pragma once

#include <span>
#include <vector>

#include "renderer/accel/accel.h"
#include "renderer/integrators/world.h"

namespace patina {

/// What is seen over a segment of a camera ray: transmittance * Ci + radiance.
struct Air {
  Rgb transmittance{1, 1, 1}, radiance{0, 0, 0};
};

/// A segment that ended on a surface. The first of a camera ray begins at the eye, others at the surface that
/// the ray went through.
struct AirSegment {
  const Ray* ray;
  const Hit* hit;
  bool fromEye;
};

/// `air` of every segment, by the Atmosphere of the surface that it ended on; clear air where there is none.
/// Values that cannot be used count as clear air and are reported. [any thread]
void airOf(const World& world, std::span<const AirSegment> segments, std::span<Air> air);

}  // namespace patina
