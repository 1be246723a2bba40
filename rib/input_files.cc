// SPDX-License-Identifier: Apache-2.0
// The list of files, and how each is told from another of its name.
#include "rib/input_files.h"

#include <sys/stat.h>
#include <zlib.h>

#include <algorithm>
#include <atomic>
#include <mutex>

#include "rib/parser.h"
#include "rib/source.h"

namespace patina {
namespace {

std::atomic<bool> keeps{false};
std::mutex mutex;

std::vector<InputFile>& known() {
  static std::vector<InputFile> files;
  return files;
}

void note(InputFile file) {
  const std::lock_guard lock(mutex);
  if (std::ranges::find(known(), file) == known().end()) known().push_back(std::move(file));
}

InputFile ofText(std::string_view name, std::string_view text) {
  const auto* bytes = reinterpret_cast<const Bytef*>(text.data());
  return {std::string(name), InputFile::Kind::Text, text.size(),
          static_cast<int64_t>(crc32_z(crc32_z(0, nullptr, 0), bytes, text.size()))};
}

bool ofFile(const std::string& path, InputFile& file) {
  struct stat status;
  if (stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return false;
  file = {path, InputFile::Kind::File, static_cast<uint64_t>(status.st_size),
          int64_t{status.st_mtim.tv_sec} * 1'000'000'000 + status.st_mtim.tv_nsec};
  return true;
}

}  // namespace

void keepInputFiles(bool on) { keeps = on; }

void noteInputText(std::string_view name, std::string_view text) {
  if (keeps) note(ofText(name, text));
}

void noteInputFile(const std::string& path) {
  if (!keeps) return;
  InputFile file;
  if (ofFile(path, file)) note(std::move(file));
}

std::vector<InputFile> inputFiles() {
  const std::lock_guard lock(mutex);
  return known();
}

bool describeInput(const std::string& path, InputFile::Kind kind, InputFile& now) {
  if (kind == InputFile::Kind::File) return ofFile(path, now);
  if (InputFile file; !ofFile(path, file)) return false;  // nor a pipe, which would be waited for
  ErrorHandler silent([](Severity, std::string_view) {});
  Source source;
  if (!source.openFile(path, ParserLimits{}, silent)) return false;
  now = ofText(path, source.text());
  return true;
}

}  // namespace patina
