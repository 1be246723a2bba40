// SPDX-License-Identifier: Apache-2.0
// One frame, from scene to film: the entry to everything that renders.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "renderer/film/film.h"
#include "renderer/scene/scene.h"
#include "rib/error.h"

namespace patina {

/// What the command line says; where it is silent the RIB's options hold, then the defaults.
struct RenderSettings {
  std::string mode;            ///< "radiosity", "distribution", "path", "points", "direct"; "" = not said
  int threads = 0;             ///< 0 = as many as the machine has
  std::optional<int> samples;  ///< camera samples per pixel, in every mode
  std::optional<int> rays;     ///< diffuse rays per shading point at diffuse depth 0
  std::optional<int> lightSamples;  ///< shadow rays per area light and shading point at depth 0
  std::optional<double> cacheMemoryMb;
  PointOptions points;  ///< of mode points: what is said here holds in place of the RIB's
  /// Which of 2^31 independent pictures of the same scene, in every mode: all random numbers depend on it.
  std::optional<int> seed;
  /// Diffuse rays see what lobes reflect, refract and emit (entry point `view`). Without, indirect light
  /// comes from diffuse scattering and emission alone, in every mode. Not said: the RIB's Option "trace".
  std::optional<bool> caustics;
  bool classic = false;  ///< RI 3.2 alone: direct light, no shadows unless a shader asks, ambient light
  /// Mode distribution: what gather rays hit is shaded as a vertex of the cache's fine level is, with as many
  /// rays on and to all lights, in place of one ray on and the lights that are picked: what the cache saves.
  bool fullHits = false;
  bool unbiased = false;     ///< --unbiased: samples of the truth correct the cache, at every camera sample
  bool shadeAtHits = false;  ///< --shading hit: no decoupling of shading from visibility
  std::string shaderPath, texturePath;  ///< searched before the RIB's, RI path syntax
  bool allowShaderPaths = false;
  /// Samples in passes over the whole picture, so that a coarse one comes first. Not said: the RIB's Hider.
  std::optional<bool> progressive;
  std::string replay;  ///< arguments that render this again, for messages; "" = not known
  std::function<void(double)>
      progress;  ///< fraction of the samples done, 0 to 1; called from any thread, serialised
  /// Between passes: the picture that is there. Always after the first, then not more often than every
  /// `showSeconds`, nor so often that a tenth of the time went into it; the last is renderFrame()'s. 0
  /// seconds: after every pass. [the caller of renderFrame()]
  std::function<void(const Film&)> show;
  double showSeconds = 3;
  /// Keeps what a later call needs to go on from here: `save` writes it. Called not more often than every
  /// `checkpointSeconds`, nor so often that a tenth of the time went into it, and in any case at the end,
  /// which may be an interruption. Threads pause at their next buckets meanwhile. [the caller of
  /// renderFrame()]
  std::function<void(const std::function<void(ByteWriter&)>& save)> checkpoint;
  double checkpointSeconds = 60;
  /// What an earlier call for the same scene, settings and build of the program has saved: the film gets the
  /// same bits as if one call had made it all. nullptr: all is made anew.
  ByteReader* resume = nullptr;
  std::function<bool()> interrupted;  ///< true = stop after the buckets in work; the film holds what is there

  /// A render that cannot be ended in order, as a thread is in a call that does not return.
  struct Abandoned {
    std::string why;
    Location where;    ///< a request in the RIB; no file: none
    const Film* film;  ///< the buckets that are finished; nullptr: none is
  };
  /// Ends the process, after it has saved what it wants: called when an entry point of a shader has not
  /// returned for `shaderSeconds` (0: however long it takes), and when what is in work goes on for
  /// `graceSeconds` after an interruption. Not set: nobody watches. [a thread of its own]
  std::function<void(const Abandoned&)> abandon;
  double shaderSeconds = 0, graceSeconds = 10;
};

/// Renders `scene` and returns its film, or nullptr when nothing could be rendered (which has been reported).
/// [One call at a time in a process: Embree and the thread pool are shared.]
std::unique_ptr<Film> renderFrame(const Scene& scene, const RenderSettings& settings, ErrorHandler& errors);

}  // namespace patina
