// SPDX-License-Identifier: Apache-2.0
// posix_spawn, a pidfd to wait with a time limit, wait4 for the costs.
#include "tools/patina-bench/child.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>

namespace patina::bench {
namespace {

std::string lastLine(const std::string& path) {
  std::ifstream in(path);
  std::string line, last;
  while (std::getline(in, line))
    if (!line.empty()) last = line;
  return last;
}

double seconds(const timeval& t) {
  return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
}

// Waits for the end of a child for so long at most; whether it has ended.
bool endsWithin(pid_t child, double timeoutSeconds) {
  const int handle = static_cast<int>(syscall(SYS_pidfd_open, child, 0));
  if (handle < 0) return true;  // no such call: wait without limit
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeoutSeconds);
  int ready = 0;
  do {
    const std::chrono::duration<double, std::milli> left = end - std::chrono::steady_clock::now();
    pollfd poll{handle, POLLIN, 0};
    ready = ::poll(&poll, 1, static_cast<int>(std::clamp(left.count() + 1, 0.0, 1e9)));
  } while (ready < 0 || (ready == 0 && std::chrono::steady_clock::now() < end));
  close(handle);
  return ready > 0;
}

}  // namespace

ChildUsage runChild(const std::vector<std::string>& command, const ChildSettings& settings) {
  std::vector<char*> argv;
  for (const std::string& word : command) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  const std::string log = settings.log.empty() ? "/dev/null" : settings.log;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
  posix_spawn_file_actions_adddup2(&actions, 1, 2);
  if (!settings.folder.empty()) posix_spawn_file_actions_addchdir_np(&actions, settings.folder.c_str());

  ChildUsage usage;
  const auto start = std::chrono::steady_clock::now();
  pid_t child = 0;
  const int problem = posix_spawn(&child, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (problem != 0) {
    usage.failure = fmt::format("{} cannot be started: {}", command[0], std::strerror(problem));
    return usage;
  }
  const bool ended = settings.timeoutSeconds <= 0 || endsWithin(child, settings.timeoutSeconds);
  if (!ended) kill(child, SIGKILL);
  int status = 0;
  rusage costs{};
  while (wait4(child, &status, 0, &costs) < 0 && errno == EINTR) {
  }
  usage.wallSeconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  usage.cpuSeconds = seconds(costs.ru_utime) + seconds(costs.ru_stime);
  usage.peakMb = static_cast<double>(costs.ru_maxrss) / 1024;
  if (!ended) {
    usage.failure = fmt::format("took more than {:.3g} s", settings.timeoutSeconds), usage.outOfTime = true;
  } else if (WIFSIGNALED(status)) {
    usage.failure = fmt::format("ended by signal {}", WTERMSIG(status));
  } else if (WEXITSTATUS(status) != 0) {
    usage.failure = fmt::format("ended with status {}", WEXITSTATUS(status));
    if (const std::string said = lastLine(log); !said.empty()) usage.failure += ": " + said;
  }
  return usage;
}

}  // namespace patina::bench
