// SPDX-License-Identifier: Apache-2.0
// Starts patina, and looks at what it says, how it ends and what it writes.
#include "tests/stress/judged_render.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <optional>
#include <sstream>

#include "tools/patina-bench/child.h"

namespace patina::stress {

namespace fs = std::filesystem;

std::string contentsOf(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

Judged judgedRender(const RenderSettings& settings, const fs::path& rib, const std::string& mode,
                    const std::vector<std::string>& more) {
  const fs::path picture = settings.work / (mode + ".exr"), log = settings.work / (mode + ".log");
  fs::remove(picture);
  std::vector<std::string> command = {settings.patina, "--mode", mode, "-o", picture};
  command.insert(command.end(), more.begin(), more.end());
  command.push_back(rib);
  const bench::ChildUsage usage = bench::runChild(command, {settings.work, log, settings.seconds});
  Judged judged;
  judged.seconds = usage.wallSeconds, judged.isOutOfTime = usage.outOfTime, judged.said = contentsOf(log);
  const auto says = [&](const char* text) { return judged.said.find(text) != std::string::npos; };
  const bool hasErrors = says("error: ") || says("severe: ");
  judged.status = usage.failure.starts_with("ended with status 1");
  if (says("Sanitizer") || says("runtime error:"))
    judged.wrong = "a sanitizer reports";
  else if (!usage.failure.empty() && judged.status == 0)
    judged.wrong = usage.failure;
  else if (judged.status == 1 && !hasErrors)
    judged.wrong = "exit status 1, though no error was told";
  else if (judged.status == 0 && hasErrors)
    judged.wrong = "exit status 0, though an error was told";
  if (!judged.wrong.empty()) return judged;
  std::string problem;
  std::optional<ImageData> read = readImage(picture.string(), problem);
  if (!read) {
    if (judged.status == 0) judged.wrong = "no picture, and no error: " + problem;
    return judged;
  }
  for (size_t k = 0; k < read->pixels.size(); ++k)
    if (!std::isfinite(read->pixels[k])) {
      const size_t pixel = k / static_cast<size_t>(read->channels), width = static_cast<size_t>(read->width);
      judged.wrong = fmt::format("pixel ({}, {}) is not finite", pixel % width, pixel / width);
      return judged;
    }
  judged.picture = std::move(*read);
  return judged;
}

}  // namespace patina::stress
