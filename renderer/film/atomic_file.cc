// SPDX-License-Identifier: Apache-2.0
// Temporary names, checked writes and the final rename.
#include "renderer/film/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

namespace patina {

namespace fs = std::filesystem;

namespace {

std::string reason(const std::string& path, int error) {
  return "cannot write " + path + ": " + std::generic_category().message(error);
}

fs::path folderOf(const std::string& path) {
  const fs::path folder = fs::path(path).parent_path();
  return folder.empty() ? fs::path(".") : folder;
}

}  // namespace

AtomicFile::AtomicFile(std::string path) : path_(std::move(path)) {
  static std::atomic<unsigned> serial{0};
  const fs::path target(path_);
  const std::string hidden = "." + target.filename().string() + "." + std::to_string(getpid()) + "-" +
                             std::to_string(serial++) + ".part";
  temporary_ = (target.parent_path() / hidden).string();
}

AtomicFile::~AtomicFile() {
  if (file_ >= 0) close(file_);
  if (!committed_) std::remove(temporary_.c_str());
}

std::string AtomicFile::write(std::string_view bytes) {
  if (file_ < 0) {
    // Where the system can, the file has no name at first: a killed program leaves nothing behind.
    if (access("/proc/self/fd", X_OK) == 0)
      file_ = open(folderOf(path_).c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
    isNamed_ = file_ < 0;
    if (isNamed_) file_ = open(temporary_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  }
  if (file_ < 0) return reason(path_, errno);
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t n = ::write(file_, bytes.data() + done, bytes.size() - done);
    if (n > 0) {
      done += static_cast<std::size_t>(n);
    } else if (n == 0 || errno != EINTR) {
      return reason(path_, n == 0 ? ENOSPC : errno);
    }
  }
  return {};
}

std::string AtomicFile::commit() {
  if (file_ < 0)
    if (std::string problem = write({}); !problem.empty()) return problem;
  // Some file systems report a full disk only here; some know no synchronising.
  if (fsync(file_) != 0 && errno != EINVAL && errno != ENOSYS) return reason(path_, errno);
  if (!isNamed_) {
    const std::string self = "/proc/self/fd/" + std::to_string(file_);
    if (linkat(AT_FDCWD, self.c_str(), AT_FDCWD, temporary_.c_str(), AT_SYMLINK_FOLLOW) != 0)
      return reason(path_, errno);
  }
  if (close(std::exchange(file_, -1)) != 0) return reason(path_, errno);
  if (std::rename(temporary_.c_str(), path_.c_str()) != 0) return reason(path_, errno);
  committed_ = true;
  return {};
}

std::string AtomicFile::problem(const std::string& path) {
  std::error_code error;
  const fs::path folder = folderOf(path);
  const fs::file_status status = fs::status(folder, error);
  if (!fs::exists(status)) return "cannot write " + path + ": there is no folder " + folder.string();
  if (!fs::is_directory(status)) return "cannot write " + path + ": " + folder.string() + " is no folder";
  if (access(folder.c_str(), W_OK | X_OK) != 0) return reason(path, errno);
  if (fs::is_directory(path, error)) return "cannot write " + path + ": it is a folder";
  return {};
}

}  // namespace patina
