// SPDX-License-Identifier: Apache-2.0
// What the user asks for on the command line.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/integrators/render.h"

namespace patina {

struct CommandLine {
  std::vector<std::string> files;  ///< "-" = standard input
  RenderSettings render;
  std::string output;  ///< -o: replaces the first Display; "" = not given
  std::optional<std::array<int, 2>> resolution;
  std::optional<std::array<float, 4>> crop;  ///< xmin xmax ymin ymax
  std::optional<std::array<int, 2>> frames;  ///< first and last; worlds outside of frames are always rendered
  std::optional<float> variance;
  std::string displayView;
  std::string archivePath;
  std::string statistics;      ///< JSON file, or "-": readable, on standard output
  bool progressLines = false;  ///< "R90000 <percent>" on standard output
  bool quiet = false;
  bool strict = false;
  bool allowPrograms = false;
  bool sandbox = false;  ///< see closeSandbox()
  bool validateShaders = false;
  bool allowTexturePaths = false;
  std::string checkpoint;         ///< file; "" = none is written
  double checkpointSeconds = 60;  ///< between two
  std::string resume;             ///< file that an earlier run has written; "" = from the beginning
  bool requests = false;          ///< the table of requests is printed and that is all
  bool check = false;             ///< parse and validate only
};

/// Reads the arguments (without the program's name). When there is nothing to do, because help was asked for
/// or the usage was wrong, that has been printed and `exitStatus` is set.
std::optional<CommandLine> parseCommandLine(std::span<const std::string> arguments, int& exitStatus);

/// The arguments as a shell reads them, without crop window and output: what a message says to render again.
std::string replayArguments(std::span<const std::string> arguments);

/// The spellings in which other renderers' callers start a renderer (-Progress, -t:4, -res 640 480 ...) in
/// Patina's own.
std::vector<std::string> normalizedArguments(std::span<const std::string> arguments);

}  // namespace patina
