// SPDX-License-Identifier: Apache-2.0
// What the jobs of patina-bench share: the folder, the programs, the scenes.
#pragma once

#include "tools/patina-bench/bench.h"

namespace patina::bench {

/// On standard output, at once.
void say(const std::string& text);

struct Session {
  /// Throws std::runtime_error if a program is missing or two have one name.
  explicit Session(const BenchOptions& options);
  /// All scenes of all paths, see findScenes() and loadScene(); names are unique.
  std::vector<Scene> load(const std::vector<std::string>& paths) const;

  std::filesystem::path folder;  ///< absolute
  RenderOptions render;
  std::vector<Build> builds;  ///< one at least
};

/// What is to be measured, with nothing measured yet.
Run plan(const Session& session, const Scene& scene, const Setting& setting, const Build& build, int repeat);

}  // namespace patina::bench
