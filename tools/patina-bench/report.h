// SPDX-License-Identifier: Apache-2.0
// What people read of results: tables, plots, pictures.
#pragma once

#include <filesystem>
#include <string>

#include "tools/patina-bench/results.h"

namespace patina::bench {

/// Markdown: seconds at equal relMSE by scene and mode, then for each scene all settings, with links to
/// plotFile() and sheetFile() beside it.
std::string markdownReport(const Results& results, std::span<const double> targets);

/// SVG: relMSE over wall seconds, both logarithmic, a line per mode with its name at its end and a mark per
/// setting; settings that another one beats in time and error are hollow. Points are those of one scene and
/// build.
std::string svgPlot(const std::string& title, std::span<const Point* const> points);

/// Writes a PNG: in the first row the reference; then for each row of settings one of pictures and below it
/// one of their errors (x - r) / sqrt(r^2 + 0.01): red what is too bright, blue what is too dark, white 50 %.
/// Pictures that are empty leave a gap. Throws std::runtime_error with the reason.
void writeSheet(const std::filesystem::path& path, const ImageData& reference,
                const std::vector<std::vector<ImageData>>& rows);

/// File names of a scene's plot and sheet by one build, without folder.
std::string plotFile(const std::string& scene, const std::string& build);
std::string sheetFile(const std::string& scene, const std::string& build);

}  // namespace patina::bench
