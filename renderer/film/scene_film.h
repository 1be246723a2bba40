// SPDX-License-Identifier: Apache-2.0
// The film and the files that a scene's options ask for.
#pragma once

#include <vector>

#include "renderer/film/film.h"
#include "renderer/film/output.h"
#include "renderer/scene/scene.h"

namespace patina {

// The film of a scene: raster, crop window, filter, bucket size; channels r g b a z. An unknown filter is
// reported and replaced by RI's default, gaussian 2 2. The result may still have a Film::problem().
FilmSettings filmSettings(const Options& options, ErrorHandler& errors);

// One entry per Display request of the scene, in their order.
std::vector<OutputSettings> outputSettings(const Scene& scene);

}  // namespace patina
