// SPDX-License-Identifier: Apache-2.0
// patina: RIB files in, pictures out.
#include <fmt/format.h>

#include <exception>
#include <string>
#include <vector>

#include "tools/patina/session.h"

int main(int argc, char** argv) {
  try {
    const std::vector<std::string> arguments(argv + 1, argv + argc);
    int status = 0;
    auto commandLine = patina::parseCommandLine(arguments, status);
    if (!commandLine) return status;
    patina::catchInterrupts();
    return patina::Session(std::move(*commandLine)).run();
  } catch (const std::exception& problem) {  // such as no memory left
    fmt::print(stderr, "patina: {}\n", problem.what());
    return 1;
  }
}
