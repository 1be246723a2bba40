// SPDX-License-Identifier: Apache-2.0
// The loop over buckets: once, or again and again so that a coarse picture of the whole comes first.
#pragma once

#include <vector>

#include "renderer/integrators/integrator.h"
#include "renderer/integrators/render_watch.h"

namespace patina {

/// How many samples pixels get.
struct SamplePlan {
  int most = 1;        ///< --samples, Hider "maxsamples", PixelSamples
  int least = 1;       ///< Hider "minsamples", or the root of `most` and 4 at least
  float variance = 0;  ///< of a pixel's mean luminance, that ends its sampling; black to white is 1
  float white = 1;     ///< luminance above which the variance is relative: what Exposure's gain makes 1
  /// Whether pixels may have different numbers.
  bool isAdaptive() const { return least < most; }
};
/// PixelVariance 0 [default]: all pixels have `most`.
SamplePlan samplePlan(const Options& options, const RenderSettings& settings);

/// The samples of each pass, of so many per pixel: all at once, or 1, 1, 2, 4, 8 ... of them.
std::vector<SampleRange> passesOf(int samplesPerPixel, bool progressive);

/// Fills the film. With several passes every tile is kept open to the end, in double precision (about 90
/// bytes for a pixel of the film's five channels), and RenderSettings::show is called between them.
/// Where the plan is adaptive all pixels get the least number, in these passes; then every tile goes on by
/// itself, by half as many each time, with the pixels whose variance is above the plan's and those around
/// them (FilmTile::keepWanting). What a pixel stops at depends on its samples, so that means are a little
/// biased. An interruption leaves what is there. With RenderSettings::resume buckets go on where they were;
/// throws std::runtime_error if that does not fit the film. What is kept for that is whole buckets: those
/// that an interruption cuts short are made anew. `watch` is told when the last bucket has ended. [main]
void renderPasses(Film& film, const World& world, const Integrator& integrator, const SamplePlan& plan,
                  bool progressive, RenderWatch& watch);

}  // namespace patina
