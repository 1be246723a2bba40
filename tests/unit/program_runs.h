// SPDX-License-Identifier: Apache-2.0
// The program patina as its users have it: started in a folder of its own, killed, limited.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace patina {

class ProgramRuns : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = testing::TempDir() + "patina-runs-XXXXXX";
    folder_ = std::filesystem::canonical(mkdtemp(pattern.data()));
  }
  void TearDown() override {
    std::error_code ignored;
    std::filesystem::permissions(folder_, std::filesystem::perms::owner_all, ignored);
    std::filesystem::remove_all(folder_, ignored);
  }

  struct Outcome {
    int status = -1;  ///< exit status; -1: ended by a signal
    int signal = 0;
    std::string errors;  ///< standard error
    std::string output;  ///< standard output
    long peakKb = 0;     ///< of memory that was in use
  };

  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  void write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  /// The bytes of a file; nullopt: there is none.
  std::optional<std::string> bytes(const std::string& name) const {
    std::ifstream in(folder_ / name, std::ios::binary);
    if (!in) return std::nullopt;
    return std::string(std::istreambuf_iterator<char>(in), {});
  }

  /// Starts patina in the folder. `prepare` is called in the new process before.
  pid_t start(const std::vector<std::string>& arguments, const std::function<void()>& prepare = {}) const {
    const pid_t child = fork();
    if (child != 0) return child;
    if (chdir(folder_.c_str()) != 0) _exit(126);
    const int out = open("out.txt", O_CREAT | O_WRONLY | O_TRUNC, 0600);
    const int err = open("err.txt", O_CREAT | O_WRONLY | O_TRUNC, 0600);
    dup2(out, STDOUT_FILENO), dup2(err, STDERR_FILENO);
    if (prepare) prepare();
    std::vector<char*> pointers;
    std::string program = PATINA_BINARY_DIR "/bin/patina";
    std::vector<std::string> copies = arguments;
    pointers.push_back(program.data());
    for (std::string& argument : copies) pointers.push_back(argument.data());
    pointers.push_back(nullptr);
    execv(pointers[0], pointers.data());
    _exit(127);
  }
  static bool hasEnded(pid_t child) {
    siginfo_t info{};
    return waitid(P_PID, static_cast<id_t>(child), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
           info.si_pid == child;
  }
  Outcome wait(pid_t child) const {
    int status = 0;
    struct rusage usage {};
    EXPECT_EQ(wait4(child, &status, 0, &usage), child);
    Outcome outcome;
    outcome.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    outcome.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    outcome.errors = bytes("err.txt").value_or("");
    outcome.output = bytes("out.txt").value_or("");
    outcome.peakKb = usage.ru_maxrss;
    return outcome;
  }
  Outcome run(const std::vector<std::string>& arguments, const std::function<void()>& prepare = {}) const {
    return wait(start(arguments, prepare));
  }
  /// Kills it after so many seconds, or finds it ended before.
  Outcome runAndKill(const std::vector<std::string>& arguments, double seconds) const {
    const pid_t child = start(arguments);
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
    kill(child, SIGKILL);
    return wait(child);
  }

  std::filesystem::path folder_;
};

}  // namespace patina
