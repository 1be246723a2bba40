// SPDX-License-Identifier: Apache-2.0
// /proc, uname and a program's own words.
#include "tools/patina-bench/environment.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sched.h>
#include <sys/sysinfo.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tools/patina-bench/child.h"
#include "tools/patina-bench/scenes.h"

namespace patina::bench {
namespace {

std::string cpuModel() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);)
    if (line.starts_with("model name")) {
      const size_t from = line.find_first_not_of(" \t:", line.find(':'));
      if (from != std::string::npos) return line.substr(from);
    }
  return "";
}

}  // namespace

Environment describeMachine() {
  Environment e;
  e.cpu = cpuModel();
  cpu_set_t allowed;
  e.processors = sched_getaffinity(0, sizeof allowed, &allowed) == 0
                     ? CPU_COUNT(&allowed)
                     : static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN));
  struct sysinfo info {};
  if (sysinfo(&info) == 0) e.memoryGb = static_cast<double>(info.totalram) * info.mem_unit / 1e9;
  if (getloadavg(&e.load, 1) < 1) e.load = 0;
  utsname name{};
  if (uname(&name) == 0) e.system = fmt::format("{} {} {}", name.sysname, name.release, name.machine);
  e.date = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  return e;
}

std::string versionOf(const std::string& program) {
  namespace fs = std::filesystem;
  std::string pattern = (fs::temp_directory_path() / "patina-version-XXXXXX").string();
  const int file = mkstemp(pattern.data());
  if (file < 0) return "";
  close(file);
  const ChildUsage usage = runChild({program, "--version"}, {"", pattern, 10});
  std::istringstream in(usage.failure.empty() ? readFile(pattern) : "");
  fs::remove(pattern);
  std::string text;
  for (std::string line; std::getline(in, line);)
    if (!line.empty()) text += (text.empty() ? "" : "; ") + line;
  return text;
}

std::string commandLine(int argc, const char* const* argv) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_./=,:+@%";
  std::string text;
  for (int i = 0; i < argc; ++i) {
    std::string word = i == 0 ? std::filesystem::path(argv[0]).filename().string() : argv[i];
    if (word.empty() || word.find_first_not_of(kPlain) != std::string::npos) {
      std::string quoted = "'";
      for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
      word = quoted + "'";
    }
    text += (i == 0 ? "" : " ") + word;
  }
  return text;
}

}  // namespace patina::bench
