// SPDX-License-Identifier: Apache-2.0
// What was measured, in memory and as JSON.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "tools/patina-bench/environment.h"
#include "tools/patina-bench/statistics.h"

namespace patina::bench {

/// One render.
struct Run {
  std::string scene, mode, setting, build;  ///< build: name of the patina program
  std::vector<std::string> args;            ///< all of patina's but files, seed and threads
  int repeat = 0, seed = 0, threads = 0;    ///< 0 threads = one per processor
  uint64_t sceneHash = 0, buildHash = 0;    ///< see Scene; of the program's file
  std::string failure;                      ///< why there is no picture; what follows is 0 then
  bool outOfTime = false;  ///< the failure is that there was no more time: nothing is wrong with the run
  double wallSeconds = 0, cpuSeconds = 0, peakMb = 0;
  double rays = 0, shaderPoints = 0;  ///< of all kinds; points that entry points of shaders were run for
  ImageErrors errors;
  uint64_t picture = 0;  ///< hash of the pixels

  /// Whether the other one measured the same, whatever came out: for --resume.
  bool isSameWork(const Run& other) const;
};

/// The reference of a scene.
struct ReferenceInfo {
  std::string kind;            ///< "given" or "path"
  std::string file;            ///< EXR
  int samples = 0, seeds = 0;  ///< per pixel and picture; pictures
  double relMse = 0;           ///< share of relMSE of its own noise
  double seconds = 0;          ///< wall time that it took, if that was limited

  /// Whether errors against both can be compared; folders may differ.
  bool isSame(const ReferenceInfo& other) const;
};

struct Results {
  Environment environment;  ///< of the last call that measured something
  std::vector<Run> runs;
  std::map<std::string, ReferenceInfo> references;  ///< by scene
};

/// Throw std::runtime_error with the reason. A file is written whole or not at all.
Results readResults(const std::filesystem::path& path);
void writeResults(const std::filesystem::path& path, const Results& results);

/// The repeats of one setting on one scene by one build.
struct Point {
  std::string scene, mode, setting, build;
  std::vector<const Run*> runs;  ///< without those that failed
  std::string failure;           ///< of the first that did
  Summary wall, cpu, peakMb, rays, shaderPoints;
  Summary relMse;  ///< the reference's share taken off, but kept above 0
  Summary percentile99;
  Summary meanError;  ///< over channels, in units of the reference's mean
};
/// By order of first appearance. Points of which every run failed have no runs.
std::vector<Point> summarizeRuns(const Results& results);
/// Those of one scene and build, of all modes.
std::vector<const Point*> pointsOf(std::span<const Point> points, const std::string& scene,
                                   const std::string& build);
/// Different values of a member, by order of first appearance.
std::vector<std::string> namesOf(std::span<const Point> points, std::string Point::*member);
/// Time against error of one mode among such points: mean wall seconds and mean relMSE.
std::vector<CurvePoint> curveOf(std::span<const Point* const> points, const std::string& mode);

}  // namespace patina::bench
