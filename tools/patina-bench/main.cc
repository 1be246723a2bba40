// SPDX-License-Identifier: Apache-2.0
// patina-bench: time against error of modes and settings over scenes.
#include <CLI/CLI.hpp>

#include <array>
#include <cstdio>
#include <exception>

#include "tools/patina-bench/bench.h"

int main(int argc, char** argv) {
  using namespace patina::bench;
  BenchOptions options;
  std::string output = "bench-results", cache;
  std::array<std::string, 2> compared, agreeing;
  int seeds = 16, block = 16;
  CLI::App app("Measures modes and settings of patina over scenes: time against error.", "patina-bench");
  app.footer(
      "A scene is a folder with bench.json, a folder of such folders, or a RIB (tests/bench/README.md). "
      "Patterns are "
      "scene/mode/setting,\n"
      "with * and ?; what is missing at the end stands for all.\n"
      "Exit status: 0 all is well, 1 a render failed, something differs or nothing could be done, 2 wrong "
      "usage.");
  app.add_option("scenes", options.scenes, "Scenes")->type_name("SCENE");
  app.add_option("-o,--output", output, "Folder for results.json, report.md, plots and pictures")
      ->capture_default_str();
  app.add_option("--patina", options.builds, "Programs to measure, by turns: PATH or NAME=PATH")
      ->allow_extra_args(false);
  app.add_option("--settings", options.settingsFile,
                 "JSON of settings by mode, in place of the built-in ones");
  app.add_option("--only", options.only, "Patterns of what is measured")->allow_extra_args(false);
  app.add_option("--repeat", options.repeats, "Pictures of each setting, of different seeds")
      ->capture_default_str()
      ->check(CLI::Range(1, 10000));
  app.add_option("-t,--threads", options.threads, "Threads of patina; 0 = one per processor")
      ->capture_default_str()
      ->check(CLI::Range(0, 4096));
  app.add_option("--timeout", options.timeoutSeconds, "Seconds after which a render is given up; 0 = never")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1e6));
  app.add_option("--minutes", options.minutes,
                 "Time for all: shared among scenes, references and modes, slow settings are left out; 0 = "
                 "as long as "
                 "it takes")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1e6));
  app.add_flag("--resume", options.resume, "Keep what results.json holds and measure the rest");
  app.add_flag("--list", options.list, "List what would be measured");
  app.add_option("--reference-samples", options.reference.samples,
                 "Samples per pixel of each reference picture")
      ->capture_default_str()
      ->check(CLI::Range(1, 1 << 24));
  app.add_option("--reference-seeds", options.reference.seeds, "Pictures that a reference is the mean of")
      ->capture_default_str()
      ->check(CLI::Range(2, 1000));
  app.add_option("--reference-cache", cache, "Folder that keeps references [OUTPUT/references]");
  app.add_option("--errors", options.targets, "relMSE at which times are compared, with commas between")
      ->capture_default_str()
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::PositiveNumber);
  app.add_option("--compare", compared, "Compare two files of results")->type_name("OLD NEW");
  app.add_option("--agree", agreeing,
                 "Test whether two settings, each \"MODE ARGUMENT ...\", have the same mean")
      ->type_name("A B");
  app.add_option("--seeds", seeds, "Pictures of each setting for --agree")
      ->capture_default_str()
      ->check(CLI::Range(2, 10000));
  app.add_option("--block", block, "Pixels along each block for --agree")
      ->capture_default_str()
      ->check(CLI::Range(1, 65536));
  try {
    app.parse(argc, argv);
    if (compared[0].empty() && options.scenes.empty()) throw CLI::RequiredError("SCENE");
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    options.command = commandLine(argc, argv);
    options.output = output, options.reference.cache = cache.empty() ? "" : std::filesystem::absolute(cache);
    if (!compared[0].empty()) return compareFiles(compared[0], compared[1]);
    if (!agreeing[0].empty()) return testAgreement(options, agreeing[0], agreeing[1], seeds, block);
    return measure(options);
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "patina-bench: %s\n", problem.what());
    return 1;
  }
}
