// SPDX-License-Identifier: Apache-2.0
// Files that appear whole or not at all: written under another name in the same folder, renamed when
// complete.
#pragma once

#include <string>

namespace patina {

class AtomicFile {
 public:
  explicit AtomicFile(std::string path);
  ~AtomicFile();  // removes what was not committed
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  // Creates the temporary file with these bytes. Returns the reason if that fails (no such folder, no
  // permission, disk full ...), else an empty text.
  std::string write(const std::string& bytes);
  // Gives the temporary file its final name, replacing a former file. Returns as write() does.
  std::string commit();

  // Why no file of this name can be made, without making one; empty if it can.
  static std::string problem(const std::string& path);

 private:
  std::string path_;
  std::string temporary_;
  bool committed_ = false;
};

}  // namespace patina
