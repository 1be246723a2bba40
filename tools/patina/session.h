// SPDX-License-Identifier: Apache-2.0
// One run of the program: each file's worlds are rendered and written as they end.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "renderer/base/statistics.h"
#include "renderer/scene/scene.h"
#include "rib/error.h"
#include "tools/patina/checkpoint.h"
#include "tools/patina/command_line.h"

namespace patina {

class Session {
 public:
  explicit Session(CommandLine commandLine);

  /// Renders all files; returns the exit status: 0 or 1.
  int run();

 private:
  void enterSandbox() const;
  void readFile(const std::string& path);
  void applyOverrides(Scene& scene) const;
  void renderWorld(Scene& scene);
  bool mayRender(const Scene& scene);
  PictureSettings pictureSettings(const Scene& scene) const;
  /// Whether an earlier run has made and written this world's pictures, or can be gone on with no more.
  bool isSettled(const Scene& scene);
  void sayHowToGoOn(double fraction) const;
  /// Ends the process: the render cannot be ended. `isShown`: pictures have been written on the way.
  [[noreturn]] void giveUp(const Scene& scene, const RenderSettings::Abandoned& render, bool isShown);
  /// Whether all could be written. `isLast`: paths are printed.
  bool writeDisplays(const Scene& scene, const Film& film, bool isLast);
  void reportStatistics(const Scene& scene);
  void writeText(const std::string& path, const std::string& text);

  CommandLine commandLine_;
  ErrorHandler errors_;
  Checkpoint checkpoint_;
  std::string file_;                   // being read
  std::optional<PhaseTimer> reading_;  // runs while no world is rendered
  std::vector<std::string> jsonReports_;
  int worlds_ = 0;  // rendered or checked
  bool failed_ = false;
  bool refused_ = false;  // for the sake of the checkpoint nothing more is rendered
};

/// Makes SIGINT and SIGTERM end the render early, with what is there written; a second signal ends the
/// program.
void catchInterrupts();
bool interrupted();

}  // namespace patina
