// SPDX-License-Identifier: Apache-2.0
// What a RIB's Display asks for, and the file that answers it.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "renderer/film/film.h"
#include "renderer/film/tone.h"
#include "rib/error.h"

namespace patina {

// One Display request with the options that apply to it.
struct OutputSettings {
  std::string name;           // a leading '+' (RI's additional display) means nothing here
  std::string type = "file";  // file tiff openexr exr png framebuffer ...; see formatFor() in output.cc
  std::string mode = "rgba";  // rgb rgba rgbz rgbaz a az z, or the name of one of the film's channels
  float gain = 1, gamma = 1;  // Exposure
  // Imager "background": colour behind what is transparent, as it looks after Exposure (RI 3.2,
  // section 4.1.2); alpha becomes 1. On edges it is mixed in before gamma.
  std::optional<std::array<float, 3>> background;
  Quantizer colour;                // Quantize "rgba"
  Quantizer depth = {0, 0, 0, 0};  // Quantize "z"
  std::string displayView;         // OpenColorIO view for what is made for looking at; empty = sRGB
  // Display's own parameters as text: "compression" or "exrcompression", "exrpixeltype" ("half" or "float").
  std::vector<std::pair<std::string, std::string>> parameters;
  std::optional<std::array<float, 16>> worldToCamera,
      worldToScreen;  // row vectors; -1..1 over the screen window
  Location at;        // of the Display request, for messages
};

// How values reach a file, by format and type:
// * `file`, `tiff`: RI to the letter. Exposure, then Quantize: 8 bits up to 255, 16 bits up to 65535, floats
// for 0.
// * `openexr`, `exr`: linear floats times Exposure's gain; gamma and Quantize do not apply.
// * `png` and what is made for looking at: Exposure; a display transform (sRGB or displayView) unless
// Exposure has a
//   gamma; then Quantize. Alpha is stored unassociated.
// * types that need a window (framebuffer, it ...) and unknown types: a PNG (EXR for depth), and a warning
// says so. A name without the format's extension gets it; `file` follows a known extension.

// The path that writeImage() would write.
std::string outputPath(const OutputSettings& settings);

// Reports what stands against the output, before a long render: odd type or mode (warnings), a folder that
// cannot be written (error: returns false). writeImage() does not repeat the warnings of the same handler.
bool checkOutput(const OutputSettings& settings, const Film& film, ErrorHandler& errors);

// Writes the picture whole or not at all. Returns the path written; empty after an error has been reported.
// The file depends on film and settings only: no dates, no random numbers.
std::string writeImage(const Film& film, const OutputSettings& settings, ErrorHandler& errors);

// The Display type for a file name by its extension ("exr" -> "openexr"); empty if unknown. For `-o FILE`.
std::string_view displayTypeFor(std::string_view fileName);

}  // namespace patina
