// SPDX-License-Identifier: Apache-2.0
// Pictures of RIB text for the programs of this folder, and their tables in README.md.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "renderer/integrators/render.h"

namespace patina::stress {

/// The red channel, row by row from the top.
struct Picture {
  int width = 0, height = 0;
  std::vector<double> values;

  double mean() const;
};

/// Changes a scene before it is rendered.
using Adjust = std::function<void(Scene&)>;

/// The one picture of `rib`, linear, before Exposure. Any message of Patina is a std::runtime_error with its
/// text.
Picture render(const std::string& rib, const RenderSettings& settings, const Adjust& adjust = {});

/// Means over blocks of size x size pixels, row by row; blocks at the right and lower edge hold what is left.
std::vector<double> blockMeans(const std::vector<double>& values, int width, int height, int size);

/// Replaces what stands in `file` between the lines `<!-- name -->` and `<!-- end of name -->`.
/// std::runtime_error if one of them is not there.
void replaceSection(const std::string& file, const std::string& name, const std::string& text);

/// The contents of a file; std::runtime_error if it cannot be read.
std::string contents(const std::string& file);

}  // namespace patina::stress
