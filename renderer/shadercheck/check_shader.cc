// SPDX-License-Identifier: Apache-2.0
// A process per check: faults come through a pipe, the place of a crash through shared memory.
#include "renderer/shadercheck/check_shader.h"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <exception>
#include <new>
#include <set>

#include "renderer/shadercheck/checks.h"

namespace patina::shadercheck {
namespace {

constexpr uint32_t kRandomSets = 5;
constexpr int kFinished = 113;  // exit status of a check that came to its end

// Lies where a child's writes are seen.
class SharedProgress {
 public:
  SharedProgress()
      : memory_(mmap(nullptr, sizeof(Progress), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)) {
    if (memory_ == MAP_FAILED) throw std::bad_alloc();
    new (memory_) Progress{};
  }
  ~SharedProgress() { munmap(memory_, sizeof(Progress)); }
  SharedProgress(const SharedProgress&) = delete;
  SharedProgress& operator=(const SharedProgress&) = delete;
  Progress& operator*() const { return *static_cast<Progress*>(memory_); }

 private:
  void* memory_;
};

[[noreturn]] void runChild(const PatinaShader& shader, const Check& check, int pipe, Progress& progress) {
  const rlimit none{0, 0};
  setrlimit(RLIMIT_CORE, &none);
  for (const int fatal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) signal(fatal, SIG_DFL);
  try {
    Findings findings(pipe, progress);
    const std::vector<ParameterSet> sets = makeParameterSets(shader, kRandomSets);
    check.run({shader, sets, findings});
  } catch (const std::exception& error) {
    Findings(pipe, progress)
        .fault(progress.entry, fmt::format("threw an exception: {}", error.what()), progress.detail);
  } catch (...) {
    Findings(pipe, progress).fault(progress.entry, "threw an exception", progress.detail);
  }
  _exit(kFinished);
}

// CPU time of a process and its threads so far.
double cpuSecondsOf(pid_t process) {
  clockid_t clock;
  timespec used{};
  if (clock_getcpuclockid(process, &clock) != 0 || clock_gettime(clock, &used) != 0) return 0;
  return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
}

enum class End { Closed, OutOfCpuTime, OutOfTime };

// All that comes out of the pipe until `child`, which has its other end, closes it or is out of time.
End readAll(int pipe, pid_t child, const CheckOptions& options, std::string& text) {
  using Clock = std::chrono::steady_clock;
  constexpr int kLookMilliseconds = 100;
  const auto end = Clock::now() + std::chrono::seconds(options.wallSeconds);
  for (;;) {
    pollfd waiting{pipe, POLLIN, 0};
    if (poll(&waiting, 1, kLookMilliseconds) > 0) {
      char buffer[4096];
      const ssize_t size = read(pipe, buffer, sizeof buffer);
      if (size <= 0) return End::Closed;
      text.append(buffer, static_cast<size_t>(size));
    }
    if (cpuSecondsOf(child) > options.cpuSeconds) return End::OutOfCpuTime;
    if (Clock::now() > end) return End::OutOfTime;
  }
}

std::string describeEnd(int status, End end, const CheckOptions& options) {
  if (end == End::OutOfCpuTime)
    return fmt::format("did not return within {} s of CPU time", options.cpuSeconds);
  if (end == End::OutOfTime) return fmt::format("did not return within {} s", options.wallSeconds);
  if (WIFSIGNALED(status))
    return fmt::format("crashed: signal {}, {}", WTERMSIG(status), strsignal(WTERMSIG(status)));
  if (WIFEXITED(status) && WEXITSTATUS(status) != kFinished)
    return fmt::format("ended the process, with exit status {}", WEXITSTATUS(status));
  return {};
}

std::vector<Fault> runCheck(const PatinaShader& shader, const Check& check, const CheckOptions& options) {
  const SharedProgress progress;
  int ends[2];
  if (pipe(ends) != 0) return {{check.name, "the check", "cannot be run: no pipe", ""}};
  const pid_t child = fork();
  if (child == 0) {
    close(ends[0]);
    runChild(shader, check, ends[1], *progress);
  }
  close(ends[1]);
  if (child < 0) {
    close(ends[0]);
    return {{check.name, "the check", "cannot be run: no process", ""}};
  }
  std::string text;
  const End ended = readAll(ends[0], child, options, text);
  close(ends[0]);
  if (ended != End::Closed) kill(child, SIGKILL);
  int status = 0;
  waitpid(child, &status, 0);
  std::vector<Fault> faults = parseFindings(text, check.name);
  const Progress& last = *progress;
  if (const std::string end = describeEnd(status, ended, options); !end.empty())
    faults.push_back({check.name, last.entry, end, last.detail});
  return faults;
}

}  // namespace

std::span<const Check> allChecks() {
  static constexpr Check kChecks[] = {{"parameter table", checkTable},
                                      {"prepare", checkPrepare},
                                      {"undeclared channels", checkUndeclaredChannels},
                                      {"lanes", checkLanes},
                                      {"strides", checkStrides},
                                      {"history", checkHistory},
                                      {"finite", checkFinite},
                                      {"energy", checkEnergy},
                                      {"lobes", checkLobes},
                                      {"custom lobes", checkCustomLobes},
                                      {"traits", checkFlags},
                                      {"inactive entry points", checkInactive},
                                      {"displacement", checkDisplacement},
                                      {"atmosphere", checkAtmosphere},
                                      {"light samples", checkLightSamples},
                                      {"point lights", checkPointLights},
                                      {"infinite lights", checkInfiniteLights},
                                      {"threads", checkThreads}};
  return kChecks;
}

Verdict checkShader(const PatinaShader& shader, const CheckOptions& options) {
  Verdict verdict;
  verdict.shader = shader.name;
  std::set<std::string> known;  // what several checks find is said once
  for (const Check& check : allChecks()) {
    ++verdict.checks;
    for (Fault& fault : runCheck(shader, check, options))
      if (known.insert(fault.entry + '\n' + fault.text).second) verdict.faults.push_back(std::move(fault));
  }
  return verdict;
}

std::string toString(const std::string& shader, const Fault& fault) {
  const std::string detail = fault.detail.empty() ? "" : " (" + fault.detail + ")";
  return fmt::format("{}: {} {}{} [{}]", shader, fault.entry, fault.text, detail, fault.check);
}

}  // namespace patina::shadercheck
