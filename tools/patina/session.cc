// SPDX-License-Identifier: Apache-2.0
// From files to pictures.
#include "tools/patina/session.h"

#include <fmt/format.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "renderer/film/scene_film.h"
#include "renderer/scene/camera.h"
#include "renderer/scene/scene_builder.h"
#include "renderer/shading/shader_validation.h"
#include "renderer/shading/texture_maker.h"
#include "tools/patina/progress.h"

namespace patina {
namespace {

volatile std::sig_atomic_t interruptSignal = 0;

void onInterrupt(int signal) { interruptSignal = signal; }

}  // namespace

void catchInterrupts() {
  struct sigaction action = {};
  action.sa_handler = onInterrupt;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool interrupted() { return interruptSignal != 0; }

Session::Session(CommandLine commandLine) : commandLine_(std::move(commandLine)) {
  if (commandLine_.quiet) errors_.setQuiet(Severity::Error);
  errors_.setShowLines(true);
  if (commandLine_.strict) errors_.setStyle(ErrorStyle::Abort);
}

int Session::run() {
  for (const std::string& path : commandLine_.files) {
    if (interrupted() || errors_.aborted()) break;
    readFile(path);
  }
  errors_.summarize();
  if (!commandLine_.statistics.empty() && commandLine_.statistics != "-" && !jsonReports_.empty()) {
    // One object for one world, else an array.
    const std::string text = jsonReports_.size() == 1 ? jsonReports_.front()
                                                      : fmt::format("[\n{}]\n", fmt::join(jsonReports_, ","));
    writeText(commandLine_.statistics, text);
  }
  return failed_ || interrupted() ? 1 : errors_.exitStatus();
}

void Session::readFile(const std::string& path) {
  file_ = path;
  setShaderValidation(commandLine_.validateShaders);
  reading_.emplace("Reading RIB");
  SceneBuilderSettings settings;
  settings.archivePath = commandLine_.archivePath;
  settings.allowPrograms = commandLine_.allowPrograms;
  if (!commandLine_.check)
    settings.makeTexture = [this](const MakeRequest& request) {
      TextureMaking making;
      making.texturePath = commandLine_.render.texturePath;
      making.allowPaths = commandLine_.allowTexturePaths;
      making.asInFile = commandLine_.render.classic;
      making.ocioConfig = request.ocioConfig;
      if (const char* ocio = std::getenv("OCIO"); ocio && making.ocioConfig.empty()) making.ocioConfig = ocio;
      return makeTexture(request, making, errors_);
    };
  SceneBuilder builder(std::move(settings), errors_, [this](Scene& scene) { renderWorld(scene); });
  if (!builder.readFile(path)) failed_ = true;
  reading_.reset();
}

bool Session::mayRender(const Scene& scene) {
  if (interrupted()) return false;
  if (commandLine_.frames && scene.frame != 0) {
    const auto [first, last] = *commandLine_.frames;
    if (scene.frame < first || scene.frame > last) return false;
  }
  if (commandLine_.strict && errors_.exitStatus() != 0) return false;
  return true;
}

void Session::applyOverrides(Scene& scene) const {
  Options& options = scene.options;
  if (commandLine_.resolution) {
    options.xResolution = (*commandLine_.resolution)[0];
    options.yResolution = (*commandLine_.resolution)[1];
    options.frameAspect.reset();
  }
  if (commandLine_.crop) options.crop = *commandLine_.crop;
  if (commandLine_.variance) options.pixelVariance = *commandLine_.variance;
  if (!commandLine_.displayView.empty()) options.displayView = commandLine_.displayView;
  if (options.displays.empty()) {
    // RI leaves the default Display to the renderer: the picture lies beside the RIB under its name.
    const std::string stem = file_ == "-" ? "patina" : std::filesystem::path(file_).stem().stem().string();
    options.displays.push_back({.name = stem + ".exr",
                                .type = "openexr",
                                .mode = "rgba",
                                .strings = {},
                                .numbers = {},
                                .where = {}});
  }
  if (!commandLine_.output.empty()) {
    // Further worlds must not overwrite the first: "x.exr", then "x.2.exr" by frame or count.
    std::filesystem::path path = commandLine_.output;
    if (worlds_ > 0) {
      const int number = scene.frame > 0 ? scene.frame : worlds_ + 1;
      path.replace_extension(fmt::format("{}{}", number, path.extension().string()));
    }
    options.displays.front().name = path.string();
    if (const auto type = displayTypeFor(commandLine_.output); !type.empty())
      options.displays.front().type = type;
  }
  resolveFrame(options, scene.camera);
}

void Session::renderWorld(Scene& scene) {
  if (!mayRender(scene)) return;
  applyOverrides(scene);
  ++worlds_;
  if (commandLine_.check) return checkDelayed(scene, errors_);
  reading_.reset();

  // A folder that cannot be written to is better known now than after the render.
  const std::vector<OutputSettings> outputs = outputSettings(scene);
  const Film probe(FilmSettings{.width = 1, .height = 1, .filter = {}});
  bool writable = true;
  for (const OutputSettings& output : outputs) writable &= checkOutput(output, probe, errors_);
  if (writable) {
    Progress::Style style = Progress::Style::None;
    if (commandLine_.progressLines) {
      style = Progress::Style::Lines;
    } else if (!commandLine_.quiet && isatty(STDOUT_FILENO)) {
      style = Progress::Style::Terminal;
    }
    std::unique_ptr<Film> film;
    {
      Progress progress(style);
      RenderSettings settings = commandLine_.render;
      settings.progress = [&](double fraction) { progress.update(fraction); };
      settings.interrupted = interrupted;
      // What cannot be written on the way is not tried again before the end.
      settings.show = [&](const Film& picture) {
        if (writable) writable = writeDisplays(scene, picture, false);
      };
      film = renderFrame(scene, settings, errors_);
      if (film && !interrupted()) progress.update(1);
    }
    if (film) {
      writeDisplays(scene, *film, true);
    } else {
      failed_ = true;
    }
  }
  reportStatistics(scene);
  resetStatistics();
  reading_.emplace("Reading RIB");
}

bool Session::writeDisplays(const Scene& scene, const Film& film, bool isLast) {
  const PhaseTimer timer("Writing pictures");
  bool all = true;
  for (const OutputSettings& output : outputSettings(scene)) {
    const std::string path = writeImage(film, output, errors_);
    all &= !path.empty();
    if (isLast && !path.empty() && !commandLine_.quiet && !commandLine_.progressLines) {
      fmt::print("{}\n", path);
    }
  }
  if (!all) failed_ = true;
  return all;
}

void Session::reportStatistics(const Scene& scene) {
  const bool asked = commandLine_.statistics == "-";
  if (!commandLine_.statistics.empty() && !asked) jsonReports_.push_back(statisticsJson());
  const std::string& file = scene.options.statisticsFile;
  if (asked || (scene.options.statistics && (file.empty() || file == "stdout"))) {
    fmt::print("{}", statisticsTree());
  } else if (scene.options.statistics) {
    writeText(file, statisticsTree());
  }
}

void Session::writeText(const std::string& path, const std::string& text) {
  std::FILE* file = std::fopen(path.c_str(), "w");
  const bool written = file && std::fwrite(text.data(), 1, text.size(), file) == text.size();
  if (!(file && std::fclose(file) == 0 && written)) {
    errors_.report(Severity::Error, RiError::System, {},
                   fmt::format("statistics cannot be written to {}", path));
  }
}

}  // namespace patina
