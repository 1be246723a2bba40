// SPDX-License-Identifier: Apache-2.0
// EXR files through OpenEXR alone.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "renderer/film/film.h"
#include "renderer/film/image.h"

namespace patina {

struct ExrSettings {
  int fullWidth = 0, fullHeight = 0;  // display window
  int x = 0, y = 0;                   // data window's first pixel
  bool half = false;                  // 16-bit floats; depth stays 32-bit
  std::string compression = "zip";    // none rle zips zip piz pxr24 b44 b44a dwaa dwab
  std::vector<std::pair<std::string, std::string>> attributes;
  std::optional<std::array<float, 16>> worldToCamera, worldToScreen;  // row vectors
};

// Writes `image` whole or not at all (see atomic_file.h). Returns the reason if that fails, else an empty
// text.
std::string writeExr(const std::string& path, const ImageData& image, const ExrSettings& settings);

// As readImage(), for a file that is known to be EXR. Channels come in the order R G B A, then the others by
// name.
std::optional<ImageData> readExr(const std::string& path, std::string& error);

}  // namespace patina
