// SPDX-License-Identifier: Apache-2.0
// Starting a program, and talking to it within limits.
#include "renderer/scene/run_program.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

extern char** environ;

namespace patina {
namespace {

/// A file descriptor that closes itself.
class Descriptor {
 public:
  explicit Descriptor(int descriptor = -1) : descriptor_(descriptor) {}
  ~Descriptor() { close(); }
  Descriptor(Descriptor&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  int get() const { return descriptor_; }
  void close() {
    if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
  }

 private:
  int descriptor_;
};

/// The program at work, in a process group of its own.
class Process {
 public:
  explicit Process(pid_t id) : id_(id) {}
  ~Process() { end(); }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  /// Kills what still runs; the status of one that had ended by itself before.
  std::optional<int> end() {
    if (id_ < 0) return std::nullopt;
    int status = 0;
    const bool ended = waitpid(id_, &status, WNOHANG) == id_;
    kill(-id_, SIGKILL);
    if (!ended) waitpid(id_, nullptr, 0);
    id_ = -1;
    return ended ? std::optional(status) : std::nullopt;
  }

 private:
  pid_t id_;
};

}  // namespace

ProgramOutput runProgram(std::span<const std::string> arguments, std::string_view input,
                         const ProgramLimits& limits) {
  static std::mutex oneAtATime;
  const std::scoped_lock lock(oneAtATime);
  const auto fail = [](std::string text, const std::string& problem) {
    return ProgramOutput{std::move(text), problem};
  };
  int toProgram[2], fromProgram[2];
  if (pipe2(toProgram, O_CLOEXEC) != 0) return fail({}, std::strerror(errno));
  Descriptor childIn(toProgram[0]), in(toProgram[1]);
  if (pipe2(fromProgram, O_CLOEXEC) != 0) return fail({}, std::strerror(errno));
  Descriptor out(fromProgram[0]), childOut(fromProgram[1]);
  fcntl(in.get(), F_SETFL, O_NONBLOCK);

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, childIn.get(), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, childOut.get(), STDOUT_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t defaults;
  sigemptyset(&defaults);
  sigaddset(&defaults, SIGPIPE);
  posix_spawnattr_setsigdefault(&attributes, &defaults);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  pid_t id = -1;
  const int code = posix_spawnp(&id, argv[0], &actions, &attributes, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  if (code != 0) return fail({}, fmt::format("it does not start: {}", std::strerror(code)));
  Process process(id);
  childIn.close(), childOut.close();

  // A program that does not read what it is told must not stop us. The signal is the process's, and so one
  // program is run at a time.
  struct NoPipeSignal {
    struct sigaction before {};
    NoPipeSignal() {
      struct sigaction ignore {};
      ignore.sa_handler = SIG_IGN;
      sigaction(SIGPIPE, &ignore, &before);
    }
    ~NoPipeSignal() { sigaction(SIGPIPE, &before, nullptr); }
  } const noPipeSignal;

  const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(limits.seconds);
  std::string text;
  std::array<char, 65536> buffer;
  if (input.empty()) in.close();
  for (;;) {
    const double left = std::chrono::duration<double>(deadline - std::chrono::steady_clock::now()).count();
    if (left <= 0) return fail(std::move(text), fmt::format("it took more than {:g} s", limits.seconds));
    pollfd polled[2] = {{out.get(), POLLIN, 0}, {in.get(), POLLOUT, 0}};
    if (poll(polled, in.get() >= 0 ? 2 : 1, static_cast<int>(std::min(left * 1000 + 1, 1e6))) < 0 &&
        errno != EINTR)
      return fail(std::move(text), std::strerror(errno));
    if (in.get() >= 0 && polled[1].revents != 0) {
      const ssize_t written = write(in.get(), input.data(), input.size());
      if (written > 0) input.remove_prefix(static_cast<size_t>(written));
      if (input.empty() || (written < 0 && errno != EAGAIN && errno != EINTR)) in.close();
    }
    if (polled[0].revents == 0) continue;
    const ssize_t count = read(out.get(), buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return fail(std::move(text), std::strerror(errno));
    const std::string_view piece(buffer.data(), static_cast<size_t>(count));
    const size_t end = std::min(piece.find('\377'), piece.size());
    if (text.size() + end > limits.outputBytes)
      return fail(std::move(text), fmt::format("it wrote more than {} bytes", limits.outputBytes));
    text.append(piece.substr(0, end));
    if (end < piece.size()) return {std::move(text), {}};
    if (count > 0) continue;
    // The end without the byte that marks it is a whole reply if the program is content with itself.
    in.close();
    for (int wait = 0; wait < 50; ++wait) {
      siginfo_t information{};
      if (waitid(P_PID, static_cast<id_t>(id), &information, WEXITED | WNOHANG | WNOWAIT) != 0 ||
          information.si_pid != 0)
        break;
      usleep(20000);
    }
    const std::optional<int> status = process.end();
    if (!status) return {std::move(text), {}};
    if (WIFSIGNALED(*status))
      return fail(std::move(text), fmt::format("it was ended by signal {}", WTERMSIG(*status)));
    if (WEXITSTATUS(*status) == 127 && text.empty()) return fail({}, "it does not start");
    if (WEXITSTATUS(*status) != 0)
      return fail(std::move(text), fmt::format("it ended with status {}", WEXITSTATUS(*status)));
    return {std::move(text), {}};
  }
}

}  // namespace patina
