// SPDX-License-Identifier: Apache-2.0
// Reads a scene's options into film and output settings.
#include "renderer/film/scene_film.h"

#include <algorithm>

#include "renderer/scene/camera.h"

namespace patina {

namespace {

Quantizer quantizer(const Quantization& q) {
  return {static_cast<float>(q.one), static_cast<float>(q.minimum), static_cast<float>(q.maximum), q.dither};
}

std::array<float, 16> elements(const M44f& m) {
  std::array<float, 16> result;
  std::copy_n(m.getValue(), result.size(), result.begin());
  return result;
}

}  // namespace

FilmSettings filmSettings(const Options& options, ErrorHandler& errors) {
  FilmSettings film;
  film.width = options.xResolution;
  film.height = options.yResolution;
  film.crop = options.crop;
  film.filter.xWidth = options.filterWidthX;
  film.filter.yWidth = options.filterWidthY;
  film.bucketWidth = options.bucketSize[0];
  film.bucketHeight = options.bucketSize[1];
  if (const auto kind = PixelFilter::fromName(options.filter)) {
    film.filter.kind = *kind;
  } else {
    film.filter = PixelFilter{};
    errors.report(Severity::Warning, RiError::BadToken, {},
                  "unknown pixel filter \"" + options.filter +
                      "\": gaussian 2 2 is used (known are box, triangle, catmull-rom, sinc, gaussian)");
  }
  return film;
}

std::vector<OutputSettings> outputSettings(const Scene& scene) {
  const Options& options = scene.options;
  const auto world = scene.coordinateSystems.find("world");  // its origin may have been moved: see origin.h
  const M44d moved = world == scene.coordinateSystems.end() ? M44d() : world->second;
  const M44f worldToCamera(moved * scene.camera.worldToCamera);
  const M44f worldToScreen(moved * worldToNormalizedScreen(scene.camera));
  std::vector<OutputSettings> outputs;
  for (const DisplayRequest& request : options.displays) {
    OutputSettings& output = outputs.emplace_back();
    output.name = request.name;
    output.type = request.type;
    output.mode = request.mode;
    output.gain = options.exposureGain;
    output.gamma = options.exposureGamma;
    if (options.background)
      output.background = {options.background->x, options.background->y, options.background->z};
    if (options.colorQuantization) output.colour = quantizer(*options.colorQuantization);
    if (options.depthQuantization) output.depth = quantizer(*options.depthQuantization);
    if (options.displayView) output.displayView = *options.displayView;
    output.parameters.assign(request.strings.begin(), request.strings.end());
    output.worldToCamera = elements(worldToCamera);
    output.worldToScreen = elements(worldToScreen);
    output.at = request.where;
  }
  return outputs;
}

}  // namespace patina
