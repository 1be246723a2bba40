// SPDX-License-Identifier: Apache-2.0
// Renders of scenes by patina, and references made of them.
#pragma once

#include <span>

#include "tools/patina-bench/results.h"
#include "tools/patina-bench/scenes.h"

namespace patina::bench {

/// A patina program.
struct Build {
  std::string name;
  std::filesystem::path program;  ///< absolute
  uint64_t hash = 0;              ///< of its file
};
/// From "NAME=PATH" or a path, which is its own name. Throws std::runtime_error if there is no such program.
Build findBuild(const std::string& text);
/// The program patina beside this one.
Build defaultBuild();

struct RenderOptions {
  std::filesystem::path folder;  ///< for pictures, logs and references; absolute
  int threads = 0;               ///< 0 = one per processor
  double timeoutSeconds = 0;     ///< of one render; 0 = none
};

/// Renders once. Cost, rays and shader points are set in the run, errors are not; a failure is told there.
/// Returns the picture's pixels; empty after a failure.
ImageData render(const Build& build, const Scene& scene, const RenderOptions& options, Run& run);
/// With other characters than letters, digits and "._-" replaced: part of a file's name.
std::string safe(std::string text);
/// The EXR that render() writes for a run.
std::filesystem::path pictureOf(const Run& run, const std::filesystem::path& folder);

struct Reference {
  ReferenceInfo info;
  ImageData picture;
};
struct ReferenceOptions {
  std::filesystem::path cache;  ///< folder where references are kept, by the hash of the scene
  int samples = 4096;           ///< per pixel and picture
  int seeds = 4;                ///< pictures; 2 at least, as their spread says how exact the mean is
  double seconds = 0;  ///< for all of it; 0 = as long as it takes. Fewer samples, or more pictures, to fit
  bool keep = false;   ///< of those made in limited time any one will do that is kept
};
/// The scene's given reference, or the mean of pictures of path mode. Throws std::runtime_error with the
/// reason.
Reference findReference(const Build& build, const Scene& scene, const RenderOptions& options,
                        const ReferenceOptions& wanted);

/// Mean of pictures, and the share of noise in relMSE when it serves as reference: mean over pixels and
/// channels of the mean's variance / (mean^2 + 0.01).
Reference averageOf(std::span<const ImageData> pictures);

/// First three channels of an EXR or other picture, all finite. Throws std::runtime_error with the reason.
ImageData loadPicture(const std::filesystem::path& path);

}  // namespace patina::bench
