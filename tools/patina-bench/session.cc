// SPDX-License-Identifier: Apache-2.0
// Programs and scenes from options.
#include "tools/patina-bench/session.h"

#include <cstdio>
#include <stdexcept>

namespace patina::bench {

namespace fs = std::filesystem;

void say(const std::string& text) {
  std::fputs(text.c_str(), stdout);
  std::fflush(stdout);
}

Session::Session(const BenchOptions& options)
    : folder(fs::absolute(options.output)), render{folder, options.threads, options.timeoutSeconds} {
  for (const std::string& text : options.builds) {
    builds.push_back(findBuild(text));
    for (size_t i = 0; i + 1 < builds.size(); ++i)
      if (builds[i].name == builds.back().name)
        throw std::runtime_error("two programs are named " + builds.back().name + ": give NAME=PATH");
  }
  if (builds.empty()) builds.push_back(defaultBuild());
  fs::create_directories(folder);
}

std::vector<Scene> Session::load(const std::vector<std::string>& paths) const {
  std::vector<Scene> scenes;
  for (const std::string& given : paths)
    for (const fs::path& path : findScenes(given)) {
      scenes.push_back(loadScene(path, folder / "scenes"));
      for (size_t i = 0; i + 1 < scenes.size(); ++i)
        if (scenes[i].name == scenes.back().name)
          throw std::runtime_error("two scenes are named " + scenes.back().name);
    }
  return scenes;
}

Run plan(const Session& session, const Scene& scene, const Setting& setting, const Build& build, int repeat) {
  Run run;
  run.scene = scene.name, run.mode = setting.mode, run.setting = setting.name, run.build = build.name;
  run.args = scene.args;
  run.args.insert(run.args.end(), setting.args.begin(), setting.args.end());
  run.repeat = repeat, run.seed = repeat + 1, run.threads = session.render.threads;
  run.sceneHash = scene.hash, run.buildHash = build.hash;
  return run;
}

}  // namespace patina::bench
