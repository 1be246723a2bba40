// SPDX-License-Identifier: Apache-2.0
// Runs all checks on a shader, each in a process of its own: what a plugin does wrong cannot hurt the caller.
#pragma once

#include <string>
#include <vector>

#include "patina/shader.h"
#include "renderer/shadercheck/findings.h"

namespace patina::shadercheck {

struct Verdict {
  std::string shader;
  int checks = 0;  ///< that were run
  std::vector<Fault> faults;
};

struct CheckOptions {
  /// Of one check, in seconds of its own CPU time (of all its threads), however busy the machine is; then it
  /// is stopped, which is a fault.
  int cpuSeconds = 20;
  /// The same by the clock on the wall: for shaders that wait for what does not come.
  int wallSeconds = 300;
};

/// The shader's plugin stays open meanwhile. Call it while the process has one thread: it forks. [main]
Verdict checkShader(const PatinaShader& shader, const CheckOptions& options = {});

/// "matte: radiosity reads I, which it does not declare (...) [undeclared channels]".
std::string toString(const std::string& shader, const Fault& fault);

}  // namespace patina::shadercheck
