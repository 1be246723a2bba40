// SPDX-License-Identifier: Apache-2.0
// Runs a program that writes RIB: Procedural "RunProgram".
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace patina {

struct ProgramLimits {
  double seconds = 60;  ///< from start to end of output
  size_t outputBytes = size_t{256} << 20;
};

struct ProgramOutput {
  std::string text;     ///< up to the byte 0377 that ends a reply, or the end of output
  std::string problem;  ///< in words for a user; empty: the reply is whole
};

/// Starts `arguments` (found on PATH unless the first has a slash) without a shell, writes `input` to it, and
/// reads its reply. The program and what it started are killed when the reply has come or a limit is passed.
/// [any thread]
ProgramOutput runProgram(std::span<const std::string> arguments, std::string_view input,
                         const ProgramLimits& limits = {});

}  // namespace patina
