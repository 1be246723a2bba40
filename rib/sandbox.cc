// SPDX-License-Identifier: Apache-2.0
// Folders, and what lies in them.
#include "rib/sandbox.h"

#include <algorithm>
#include <filesystem>
#include <memory>

namespace patina {
namespace {

namespace fs = std::filesystem;

struct Folders {
  std::vector<fs::path> readable;  // canonical
  fs::path writable;
};
std::unique_ptr<const Folders> sandbox;

/// Absolute, without links and "..", for what exists and what does not; empty: it cannot be told.
fs::path resolved(const fs::path& path) {
  std::error_code failed;
  fs::path result = fs::weakly_canonical(fs::absolute(path, failed), failed);
  if (failed) return {};
  return result.has_filename() ? result : result.parent_path();
}

bool isWithin(const fs::path& path, const fs::path& folder) {
  if (folder.empty()) return false;
  const auto [inFolder, inPath] = std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
  return inFolder == folder.end();
}

}  // namespace

void closeSandbox(const std::vector<std::string>& readable, const std::string& writable) {
  auto folders = std::make_unique<Folders>();
  const auto orHere = [](const std::string& folder) {
    return folder.empty() ? fs::path(".") : fs::path(folder);
  };
  for (const std::string& folder : readable) folders->readable.push_back(resolved(orHere(folder)));
  folders->writable = resolved(orHere(writable));
  folders->readable.push_back(folders->writable);
  sandbox = std::move(folders);
}

bool isSandboxed() { return sandbox != nullptr; }

std::string readProblem(const std::string& path) {
  if (!sandbox) return {};
  const fs::path where = resolved(path);
  if (!where.empty() &&
      std::ranges::any_of(sandbox->readable, [&](const fs::path& f) { return isWithin(where, f); }))
    return {};
  return "outside of the sandbox, which is the folders of the RIB, of the output and of the command line";
}

std::string writeProblem(const std::string& path) {
  if (!sandbox) return {};
  const fs::path name(path);
  const fs::path folder = resolved(name.has_parent_path() ? name.parent_path() : fs::path("."));
  const bool isName = name.has_filename() && name.filename() != ".." && name.filename() != ".";
  if (isName && !folder.empty() && isWithin(folder, sandbox->writable)) return {};
  return "outside of the sandbox, which writes in and below " + sandbox->writable.string() + " only";
}

}  // namespace patina
