// SPDX-License-Identifier: Apache-2.0
// Files that appear whole or not at all, whatever ends the program or the machine: written under another name
// in the same folder, synchronised, renamed when complete.
#pragma once

#include <string>
#include <string_view>

namespace patina {

class AtomicFile {
 public:
  explicit AtomicFile(std::string path);
  ~AtomicFile();  // removes what was not committed
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  // Appends these bytes to the temporary file, which the first call creates. Returns the reason if that fails
  // (no such folder, no permission, disk full ...), else an empty text.
  std::string write(std::string_view bytes);
  // Gives the temporary file its final name, replacing a former file, once all of it is on the disk. Returns
  // as write() does.
  std::string commit();

  // Why no file of this name can be made, without making one; empty if it can.
  static std::string problem(const std::string& path);

 private:
  std::string path_;
  std::string temporary_;
  int file_ = -1;
  bool isNamed_ = false;  // the temporary file; else it has no name before commit()
  bool committed_ = false;
};

}  // namespace patina
