// SPDX-License-Identifier: Apache-2.0
// patina as a child process, and what no input may make it do.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "renderer/film/image.h"

namespace patina::stress {

struct RenderSettings {
  std::filesystem::path patina;  ///< the program
  std::filesystem::path work;    ///< folder for pictures and logs, which are named by mode
  double seconds = 60;           ///< limit of one render
};

struct Judged {
  /// Crash, hang, report of a sanitizer, pixels that are not finite, or an exit status that does not tell
  /// whether there were errors; "" = none of these.
  std::string wrong;
  std::string said;    ///< what it printed
  int status = 0;      ///< 0 or 1, where nothing is wrong
  ImageData picture;   ///< empty: none was written
  double seconds = 0;  ///< from its start to its end
  bool isOutOfTime = false;
};

/// Renders once to an EXR of floats.
Judged judgedRender(const RenderSettings& settings, const std::filesystem::path& rib, const std::string& mode,
                    const std::vector<std::string>& more);

/// All of a file; "" if it cannot be read.
std::string contentsOf(const std::filesystem::path& path);

}  // namespace patina::stress
