// SPDX-License-Identifier: Apache-2.0
// The command line by CLI11, which is slow to compile and stays in this file.
#include "tools/patina/command_line.h"

#include <fmt/format.h>
#include <unistd.h>
#include <cmath>

#include <CLI/CLI.hpp>
#include <charconv>
#include <limits>

#include "renderer/scene/request_support.h"
#include "tools/patina/version.h"

namespace patina {
namespace {

/// Two whole numbers with `separator` between them, or one number where `single` allows.
std::optional<std::array<int, 2>> parsePair(const std::string& text, char separator, bool single) {
  const auto number = [](std::string_view digits) -> std::optional<int> {
    int value = 0;
    const auto [end, code] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (code != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
    return value;
  };
  const size_t middle = text.find(separator);
  const auto first = number(std::string_view(text).substr(0, middle));
  const auto second = middle == std::string::npos ? (single ? first : std::nullopt)
                                                  : number(std::string_view(text).substr(middle + 1));
  if (!first || !second) return std::nullopt;
  return std::array{*first, *second};
}

}  // namespace

std::optional<CommandLine> parseCommandLine(std::span<const std::string> arguments, int& exitStatus) {
  CommandLine line;
  RenderSettings& render = line.render;
  CLI::App app("Patina renders RIB files with global illumination.", "patina");
  app.set_version_flag("--version", versionText());
  app.footer(
      "Exit status: 0 all is well, 1 rendered with errors or not at all, 2 wrong usage.\n"
      "Also understood: -Progress -progress -p, -t:N, -res X Y, -crop X0 X1 Y0 Y1, -frames A B, -silent;\n"
      "-d [N] and -fb (a window) are ignored: every picture goes to a file.");

  std::string resolution, frames, shading;
  std::optional<double> pointsMegabytes;
  std::array<float, 4> crop{};
  app.add_option("files", line.files, "RIB files; - is standard input")->type_name("FILE");
  app.add_option("-o,--output", line.output,
                 "Picture file in place of the first Display's (.exr .tif .png ...)");
  app.add_option("--mode", render.mode, "How light is found")
      ->check(CLI::IsMember({"radiosity", "distribution", "path", "points", "direct"}));
  app.add_option("-t,--threads", render.threads, "Threads; 0 = one per processor")
      ->check(CLI::Range(0, 4096));
  app.add_option("--res", resolution, "Resolution in pixels, e.g. 640x480");
  const CLI::Option* cropped = app.add_option("--crop", crop, "Part of the picture as fractions: x0 x1 y0 y1")
                                   ->check(CLI::Range(0.0, 1.0));
  app.add_option("--frames", frames, "Frames to render, e.g. 3-7");
  app.add_option("--samples", render.samples, "Camera samples per pixel")->check(CLI::Range(1, 1 << 24));
  app.add_option("--rays", render.rays, "Diffuse rays per shading point")->check(CLI::Range(0, 1 << 24));
  app.add_option("--light-samples", render.lightSamples, "Shadow rays per area light")
      ->check(CLI::Range(1, 1 << 20));
  app.add_option("--variance", line.variance, "PixelVariance: stop sampling a pixel below it")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--cache-memory", render.cacheMemoryMb, "Radiosity cache in MB")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--points-maxsolidangle", render.points.maxSolidAngle,
                 "Mode points: steradians above which a group of points is taken apart")
      ->check(CLI::Range(PointOptions::kLeastAngle, PointOptions::kMostAngle));
  app.add_option("--points-resolution", render.points.resolution,
                 "Mode points: pixels along an edge of each raster, even")
      ->check(CLI::Range(PointOptions::kLeastResolution, PointOptions::kMostResolution))
      ->check([](const std::string& said) {
        return said.find_last_of("13579") + 1 == said.size() && !said.empty() ? "expected an even number"
                                                                              : "";
      });
  app.add_option("--points-bounces", render.points.bounces, "Mode points: bounces of diffuse light")
      ->check(CLI::Range(1, PointOptions::kMostBounces));
  app.add_option("--points-surfelsize", render.points.surfelSize,
                 "Mode points: pixels that a point covers at least, of what has more micropolygons")
      ->check(CLI::Range(0.0f, PointOptions::kMostSurfelSize));
  app.add_option("--points-memory", pointsMegabytes, "Mode points: MB of the points' octree")
      ->check(CLI::Range(0.001, 1e6));
  app.add_option("--seed", render.seed, "Of random numbers: others give independent noise")
      ->check(CLI::Range(0, std::numeric_limits<int>::max()));
  app.add_option("--shading", shading,
                 "Camera shading: at micropolygon vertices (vertex), or at every hit (hit)")
      ->check(CLI::IsMember({"hit", "vertex"}));
  app.add_flag("--unbiased", render.unbiased,
               "Radiosity: correct the cache by samples of the truth, at every camera sample");
  app.add_flag(
      "--full-hits", render.fullHits,
      "Mode distribution: shade hits with as many rays as the cache's vertices have, to compare with");
  bool caustics = false;
  const CLI::Option* causticsSaid = app.add_flag(
      "--caustics,!--no-caustics", caustics,
      "Diffuse rays see what lobes reflect and refract, or not; not said: as the RIB's Option \"trace\"");
  app.add_flag("--classic", render.classic, "RI 3.2 alone: direct light, shadows only where a shader asks");
  app.add_option("--shader-path", render.shaderPath, "Folders of shaders, before the RIB's");
  app.add_option("--texture-path", render.texturePath, "Folders of textures, before the RIB's");
  app.add_option("--archive-path", line.archivePath, "Folders of archives, before the RIB's");
  app.add_flag("--allow-shader-paths", render.allowShaderPaths, "Let RIBs name shaders by path");
  app.add_option("--display-view", line.displayView, "OpenColorIO view for pictures made for looking at");
  app.add_option("--stats", line.statistics, "Write statistics as JSON; - prints them readably")
      ->type_name("FILE");
  app.add_option("--checkpoint", line.checkpoint,
                 "Keep what is rendered in this file, for --resume; removed when all is written")
      ->type_name("FILE");
  app.add_option("--checkpoint-interval", line.checkpointSeconds,
                 "Seconds between checkpoints, 60 if not said")
      ->check(CLI::Range(0.0, 1e9));
  app.add_option("--resume", line.resume, "Go on from this checkpoint, and go on keeping it")
      ->type_name("FILE");
  bool progressive = false;
  const CLI::Option* progressiveSaid =
      app.add_flag("--progressive,!--no-progressive", progressive,
                   "A coarse picture of the whole first, then finer ones; without: as the RIB's Hider says");
  app.add_flag("--progress", line.progressLines, "Print progress as lines \"R90000 <percent>\"");
  app.add_flag("--allow-texture-paths", line.allowTexturePaths,
               "Let RIBs write textures (MakeTexture ...) outside of the working folder");
  app.add_flag("--allow-programs", line.allowPrograms, "Let RIBs start programs (Procedural \"RunProgram\")");
  app.add_flag(
      "--sandbox", line.sandbox,
      "For RIBs of unknown origin: they read below their own folder, that of the output and the paths "
      "of the command line, write below the output's folder (-o, or the working folder), and bring "
      "no shaders, programs or colour configurations");
  app.add_flag("--validate-shaders", line.validateShaders,
               "Check what shaders give while rendering: energy, traits, bounds, channels, one point alone, "
               "what they write to");
  app.add_option(
         "--shader-seconds", render.shaderSeconds,
         "End the render, with what is there written, when a call of a shader takes longer; 0 = never")
      ->check(CLI::Range(0.0, 1e6));
  app.add_flag("--requests", line.requests, "Print what becomes of each request, as Markdown, and exit");
  app.add_flag("--strict", line.strict, "Render nothing if the RIB has an error");
  app.add_flag("--check", line.check, "Read and check only");
  app.add_flag("-q,--quiet", line.quiet, "Print errors only");

  const auto usage = [&](std::string_view problem) {
    fmt::print(stderr, "patina: {}\nRun patina --help for more information.\n", problem);
    exitStatus = 2;
    return std::nullopt;
  };
  try {
    std::vector<std::string> reversed = normalizedArguments(arguments);
    std::ranges::reverse(reversed);
    app.parse(reversed);
  } catch (const CLI::Success& asked) {  // --help, --version
    app.exit(asked);
    exitStatus = 0;
    return std::nullopt;
  } catch (const CLI::ParseError& wrong) {
    return usage(wrong.what());
  }

  if (line.requests) {
    fmt::print("{}", requestTable());
    exitStatus = 0;
    return std::nullopt;
  }
  if (!resolution.empty()) {
    line.resolution = parsePair(resolution, 'x', false);
    if (!line.resolution || (*line.resolution)[0] < 1 || (*line.resolution)[1] < 1 ||
        (*line.resolution)[0] > 65536 || (*line.resolution)[1] > 65536) {
      return usage(fmt::format("--res {}: expected WIDTHxHEIGHT", resolution));
    }
  }
  if (!frames.empty()) {
    line.frames = parsePair(frames, '-', true);
    if (!line.frames || (*line.frames)[0] > (*line.frames)[1])
      return usage(fmt::format("--frames {}: expected FIRST-LAST", frames));
  }
  if (cropped->count() > 0) {
    if (crop[0] > crop[1] || crop[2] > crop[3]) return usage("--crop: expected x0 <= x1 and y0 <= y1");
    line.crop = crop;
  }
  if (line.sandbox && (line.allowPrograms || line.allowTexturePaths || render.allowShaderPaths))
    return usage("--sandbox: what the --allow options allow, it forbids");
  if (progressiveSaid->count() > 0) render.progressive = progressive;
  if (causticsSaid->count() > 0) render.caustics = caustics;
  if (pointsMegabytes) render.points.memoryKb = static_cast<int>(std::ceil(*pointsMegabytes * 1024));
  if (line.checkpoint.empty()) line.checkpoint = line.resume;
  render.checkpointSeconds = line.checkpointSeconds;
  render.shadeAtHits = shading == "hit" || render.unbiased;
  render.replay = replayArguments(arguments);
  if (line.files.empty()) {
    if (isatty(STDIN_FILENO)) return usage("no RIB file is named");
    line.files.emplace_back("-");
  }
  return line;
}

}  // namespace patina
