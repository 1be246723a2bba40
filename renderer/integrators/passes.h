// SPDX-License-Identifier: Apache-2.0
// The loop over buckets: once, or again and again so that a coarse picture of the whole comes first.
#pragma once

#include <vector>

#include "renderer/integrators/integrator.h"

namespace patina {

/// The samples of each pass, of so many per pixel: all at once, or 1, 1, 2, 4, 8 ... of them.
std::vector<SampleRange> passesOf(int samplesPerPixel, bool progressive);

/// Fills the film. With several passes every tile is kept open to the end, in double precision (about 90
/// bytes for a pixel of the film's five channels), and RenderSettings::show is called between them.
/// An interruption leaves what is there. [main]
void renderPasses(Film& film, const World& world, const Integrator& integrator, bool progressive);

}  // namespace patina
