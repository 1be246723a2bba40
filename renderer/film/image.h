// SPDX-License-Identifier: Apache-2.0
// Image files: EXR by OpenEXR, everything else by a module that is loaded when first needed.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/film/image_module.h"

namespace patina {

// An image in memory: floats, rows from the top, channels interleaved.
struct ImageData {
  int width = 0, height = 0, channels = 0;
  std::vector<std::string> channelNames;  // e.g. R G B A; those of EXR as they are in the file
  bool srgb = false;                      // values carry the sRGB curve
  std::vector<float> pixels;

  const float* pixel(int x, int y) const {
    return &pixels[(static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                    static_cast<std::size_t>(x)) *
                   static_cast<std::size_t>(channels)];
  }
};

// Largest image that readImage() accepts, in floats (pixels times channels).
inline constexpr std::size_t kLargestImage = std::size_t{1} << 30;

// Reads an image of any known format; nullopt, and the reason in `error`, if that fails. The file may be
// hostile: its size is checked before memory is taken. EXR needs no module. [any thread]
std::optional<ImageData> readImage(const std::string& path, std::string& error);

// The image module, loaded at the first call; null, and every place tried in `error`, if that fails. It is
// looked for in $PATINA_MODULE_PATH (folders separated by ':') and in the build tree's or the installation's
// own folder, found from the place of the running program. [any thread]
const PatinaImageModule* imageModule(std::string& error);

// Whether imageModule() has loaded it.
bool imageModuleLoaded();

}  // namespace patina
