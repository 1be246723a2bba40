// SPDX-License-Identifier: Apache-2.0
// Which files a picture has been made from, so that a later run can tell whether they are still the same.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace patina {

/// One file as it was when it was read. Of RIB, whatever it came from, the text is known: its length and its
/// CRC-32 (after inflating). Of everything else (plugins, textures, colour configurations) what the file
/// system says: length, and time of the last change in nanoseconds.
struct InputFile {
  enum class Kind : uint8_t { Text, File };
  std::string path;  ///< as it was opened; of text that is no file, its name in messages
  Kind kind = Kind::File;
  uint64_t bytes = 0;
  int64_t stamp = 0;  ///< CRC-32, or time
  bool operator==(const InputFile&) const = default;
};

/// The files of this process, in the order in which each was first met, without repetitions. Nothing is
/// noted, and nothing paid, before keepInputFiles(true). [any thread]
void keepInputFiles(bool on);
void noteInputText(std::string_view name, std::string_view text);
void noteInputFile(const std::string& path);
std::vector<InputFile> inputFiles();

/// What is known of a file now; false: it cannot be read.
bool describeInput(const std::string& path, InputFile::Kind kind, InputFile& now);

}  // namespace patina
