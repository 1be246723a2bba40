// SPDX-License-Identifier: Apache-2.0
// --sandbox: which files a RIB of unknown origin may make this process read and write.
#pragma once

#include <string>
#include <vector>

namespace patina {

/// Closes the sandbox for the rest of the process: what RIBs name is then read in and below the folders
/// `readable` and in and below `writable`, and written in and below `writable`. Where a path leads is found
/// with ".." and symbolic links resolved, when it is asked about: nobody else may change the folders'
/// links meanwhile. [main, before any RIB is read]
void closeSandbox(const std::vector<std::string>& readable, const std::string& writable);
bool isSandboxed();  ///< [any thread]

/// Why a RIB may not read this file, or give a file this name (the last part may be a link, which is replaced
/// and not followed), in words for a user; empty if it may, and always without a sandbox. [any thread]
std::string readProblem(const std::string& path);
std::string writeProblem(const std::string& path);

}  // namespace patina
