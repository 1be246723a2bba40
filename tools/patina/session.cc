// SPDX-License-Identifier: Apache-2.0
// From files to pictures.
#include "tools/patina/session.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "renderer/film/scene_film.h"
#include "renderer/scene/camera.h"
#include "renderer/scene/origin.h"
#include "renderer/scene/scene_builder.h"
#include "renderer/shading/shader_validation.h"
#include "renderer/shading/texture_maker.h"
#include "rib/sandbox.h"
#include "rib/search_path.h"
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

Session::Session(CommandLine commandLine)
    : commandLine_(std::move(commandLine)),
      checkpoint_(commandLine_.checkpoint, commandLine_.resume, errors_) {
  if (commandLine_.quiet) errors_.setQuiet(Severity::Error);
  errors_.setShowLines(true);
  if (commandLine_.strict) errors_.setStyle(ErrorStyle::Abort);
}

void Session::enterSandbox() const {
  const auto folderOf = [](const std::string& file) {
    return std::filesystem::path(file).parent_path().string();
  };
  std::vector<std::string> readable;
  for (const std::string& file : commandLine_.files) readable.push_back(file == "-" ? "" : folderOf(file));
  for (const std::string& path : {commandLine_.archivePath, commandLine_.render.texturePath})
    for (std::string& folder : searchFolders(path, {})) readable.push_back(std::move(folder));
  closeSandbox(readable, folderOf(commandLine_.output));
}

int Session::run() {
  if (commandLine_.sandbox) enterSandbox();
  if (!checkpoint_.open()) return 1;
  for (const std::string& path : commandLine_.files) {
    if (interrupted() || errors_.aborted()) break;
    readFile(path);
  }
  if (!failed_ && !interrupted() && worlds_ > 0) checkpoint_.remove();
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
  if (interrupted() || refused_) return false;
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

PictureSettings Session::pictureSettings(const Scene& scene) const {
  const RenderSettings& render = commandLine_.render;
  const Options& options = scene.options;
  PictureSettings settings;
  const auto add = [&]<class T>(const char* name, const T& value) {
    if constexpr (requires { value.has_value(); })
      settings.emplace_back(name, value ? fmt::format("{}", *value) : "");
    else
      settings.emplace_back(name, fmt::format("{}", value));
  };
  const auto environment = [](const char* name) {
    const char* const value = std::getenv(name);
    return value ? value : "";
  };
  add("frame", scene.frame);
  add("resolution", fmt::format("{}x{}", options.xResolution, options.yResolution));
  add("crop", fmt::format("{}", fmt::join(options.crop, " ")));
  add("--mode", render.mode);
  add("--classic", render.classic);
  add("--caustics", render.caustics);
  add("--full-hits", render.fullHits);
  add("--samples", render.samples);
  add("--variance", commandLine_.variance);
  add("--rays", render.rays);
  add("--light-samples", render.lightSamples);
  add("--seed", render.seed);
  add("--unbiased", render.unbiased);
  add("--shading at hits", render.shadeAtHits);
  add("--progressive", render.progressive);
  add("--points-maxsolidangle", render.points.maxSolidAngle);
  add("--points-resolution", render.points.resolution);
  add("--points-bounces", render.points.bounces);
  add("--points-surfelsize", render.points.surfelSize);
  add("--points-memory in kB", render.points.memoryKb);
  add("--shader-path", render.shaderPath);
  add("--texture-path", render.texturePath);
  add("--archive-path", commandLine_.archivePath);
  add("--allow-shader-paths", render.allowShaderPaths);
  add("--allow-programs", commandLine_.allowPrograms);
  add("$OCIO", environment("OCIO"));
  add("$PATINA_SHADER_PATH", environment("PATINA_SHADER_PATH"));
  return settings;
}

bool Session::isSettled(const Scene& scene) {
  switch (checkpoint_.beginWorld(pictureSettings(scene))) {
    case Checkpoint::Found::Nothing:
    case Checkpoint::Found::Begun:
      return false;
    case Checkpoint::Found::Other:
      failed_ = refused_ = true;
      return true;
    case Checkpoint::Found::Finished:
      break;
  }
  // A picture that has gone since is made again.
  for (const OutputSettings& output : outputSettings(scene))
    if (std::error_code gone; !std::filesystem::exists(outputPath(output), gone)) return false;
  checkpoint_.finishWorld();
  return true;
}

void Session::sayHowToGoOn(double fraction) const {
  if (commandLine_.quiet) return;
  fmt::print(stderr, "patina: interrupted at {:.0f} %: what is there has been written. ", fraction * 100);
  if (checkpoint_.isWritten())
    fmt::print(stderr, "To go on, give the same arguments and --resume {}\n", checkpoint_.path());
  else
    fmt::print(stderr, "Renders with --checkpoint FILE can be gone on with.\n");
}

void Session::renderWorld(Scene& scene) {
  if (!mayRender(scene)) return;
  applyOverrides(scene);
  ++worlds_;
  if (commandLine_.check) return checkDelayed(scene, errors_);
  if (isSettled(scene)) return;
  reading_.reset();

  if (const auto origin = betterOrigin(scene)) moveOrigin(scene, *origin);

  // A folder that cannot be written to is better known now than after the render.
  const std::vector<OutputSettings> outputs = outputSettings(scene);
  const Film probe(FilmSettings{.width = 1, .height = 1, .filter = {}});
  bool writable = true;
  for (const OutputSettings& output : outputs) writable &= checkOutput(output, probe, errors_);
  if (!writable && checkpoint_.isWritten()) failed_ = refused_ = true;  // it is the first to be made again
  if (writable) {
    Progress::Style style = Progress::Style::None;
    if (commandLine_.progressLines) {
      style = Progress::Style::Lines;
    } else if (!commandLine_.quiet && isatty(STDOUT_FILENO)) {
      style = Progress::Style::Terminal;
    }
    std::unique_ptr<Film> film;
    double fraction = 0;
    {
      Progress progress(style);
      RenderSettings settings = commandLine_.render;
      settings.progress = [&](double done) {
        fraction = done;
        progress.update(done);
      };
      settings.resume = checkpoint_.film();
      if (checkpoint_.isWritten())
        settings.checkpoint = [&](const std::function<void(ByteWriter&)>& save) { checkpoint_.write(save); };
      settings.interrupted = interrupted;
      // What cannot be written on the way is not tried again before the end.
      std::atomic<bool> isShown{false};
      settings.show = [&](const Film& picture) {
        isShown = true;
        if (writable) writable = writeDisplays(scene, picture, false);
      };
      settings.abandon = [&](const RenderSettings::Abandoned& render) { giveUp(scene, render, isShown); };
      film = renderFrame(scene, settings, errors_);
      if (film && !interrupted()) progress.update(1);
    }
    if (!film) {
      failed_ = true;
      refused_ =
          checkpoint_.film() != nullptr;  // what follows must not take the place of what cannot be read
    } else if (const bool written = writeDisplays(scene, *film, true); interrupted()) {
      sayHowToGoOn(fraction);
    } else if (written) {
      checkpoint_.finishWorld();
    } else {
      refused_ = checkpoint_.isWritten();  // it holds what could not be written, and must go on holding it
    }
  }
  reportStatistics(scene);
  resetStatistics();
  reading_.emplace("Reading RIB");
}

void Session::giveUp(const Scene& scene, const RenderSettings::Abandoned& render, bool isShown) {
  errors_.report(Severity::Severe, RiError::System, render.where, render.why);
  // Pictures that were shown on the way are whole, which what is finished of the last pass is not.
  bool isWritten = isShown;
  if (!isShown && render.film)
    for (const OutputSettings& output : outputSettings(scene))
      isWritten |= !writeImage(*render.film, output, errors_).empty();
  errors_.summarize();
  fmt::print(stderr, "patina: the render is given up: {}\n",
             isShown     ? "the picture is as it was shown last"
             : isWritten ? "the buckets that were finished have been written"
                         : "nothing was finished, and nothing has been written");
  if (checkpoint_.isWritten())
    fmt::print(stderr, "patina: the checkpoint is as it was written last, if it was: {}\n",
               checkpoint_.path());
  std::fflush(nullptr);
  std::_Exit(1);
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
