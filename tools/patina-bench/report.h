// SPDX-License-Identifier: Apache-2.0
// What people read of results: tables, plots, pictures.
#pragma once

#include <array>
#include <filesystem>
#include <string>

#include "tools/patina-bench/results.h"

namespace patina::bench {

/// Markdown: seconds at equal relMSE by scene and mode, then for each scene all settings, with links to
/// plotFile() and sheetFile() beside it.
std::string markdownReport(const Results& results, std::span<const double> targets);

/// SVG: relMSE over wall seconds, both logarithmic, a line per mode and a mark per setting, with standard
/// errors where there are repeats; settings that another one beats in time and error are hollow. Two lines to
/// compare with: error in inverse proportion to time, and `referenceNoise`, if it lies among the errors: what
/// is below it is not known well. Points are those of one scene and build.
std::string svgPlot(const std::string& title, std::span<const Point* const> points,
                    double referenceNoise = 0);

/// A picture of a contact sheet and two lines above it; without pixels, or with others than the reference
/// has, there is a gap.
struct SheetPicture {
  ImageData picture;
  std::array<std::string, 2> caption;
};
/// Writes a PNG: in the first row the reference and the scale of errors; then for each row of settings one of
/// pictures and below it one of their errors (x - r) / sqrt(r^2 + 0.01): red what is too bright, blue what is
/// too dark, white 50 %. Throws std::runtime_error with the reason.
void writeSheet(const std::filesystem::path& path, const ImageData& reference,
                const std::vector<std::vector<SheetPicture>>& rows);
/// The size of one cell of a sheet whose pictures have so many pixels, and the height of its captions.
inline constexpr int kSheetGap = 4, kSheetCaption = 22;

/// File names of a scene's plot and sheet by one build, without folder.
std::string plotFile(const std::string& scene, const std::string& build);
std::string sheetFile(const std::string& scene, const std::string& build);

}  // namespace patina::bench
