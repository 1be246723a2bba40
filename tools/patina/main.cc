// SPDX-License-Identifier: Apache-2.0
// patina: RIB files in, pictures out.
#include <fmt/format.h>

#include <csignal>
#include <cstdlib>
#include <exception>
#include <new>
#include <string>
#include <system_error>
#include <vector>

#include "tools/patina/session.h"

namespace {

constexpr const char* kNoMemory = "patina: there is not enough memory\n";

/// Libraries that find no memory or no thread where nobody can catch it end the program: with a reason, and
/// not as by a fault of the program. Everything else is one.
[[noreturn]] void onTerminate() {
  try {
    if (const std::exception_ptr problem = std::current_exception()) std::rethrow_exception(problem);
  } catch (const std::bad_alloc&) {
    std::fputs(kNoMemory, stderr);
    std::_Exit(1);
  } catch (const std::system_error& problem) {
    if (problem.code() == std::errc::resource_unavailable_try_again) {
      std::fputs("patina: there is not enough memory for another thread\n", stderr);
      std::_Exit(1);
    }
    std::fprintf(stderr, "patina: %s\n", problem.what());
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "patina: %s\n", problem.what());
  } catch (...) {
  }
  // Embree ends the program without an exception of ours when it finds no memory to clear up with.
  constexpr std::size_t kLittle = std::size_t{1} << 26;
  if (void* volatile const some = std::malloc(kLittle)) {
    std::free(some);
    std::abort();
  }
  std::fputs(kNoMemory, stderr);
  std::_Exit(1);
}

}  // namespace

int main(int argc, char** argv) {
  std::set_terminate(onTerminate);
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow further is an error of that file
  try {
    const std::vector<std::string> arguments(argv + 1, argv + argc);
    int status = 0;
    auto commandLine = patina::parseCommandLine(arguments, status);
    if (!commandLine) return status;
    patina::catchInterrupts();
    return patina::Session(std::move(*commandLine)).run();
  } catch (const std::bad_alloc&) {
    std::fputs(kNoMemory, stderr);
  } catch (const std::exception& problem) {
    fmt::print(stderr, "patina: {}\n", problem.what());
  }
  return 1;
}
