// SPDX-License-Identifier: Apache-2.0
// Faults as records in a pipe.
#include "renderer/shadercheck/findings.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace patina::shadercheck {
namespace {

constexpr char kFieldEnd = '\x1f', kRecordEnd = '\x1e';

void copyInto(char* to, size_t size, std::string_view text) {
  const size_t length = std::min(text.size(), size - 1);
  std::memcpy(to, text.data(), length);
  to[length] = 0;
}

}  // namespace

void Progress::set(std::string_view newEntry, std::string_view newDetail) {
  copyInto(entry, sizeof entry, newEntry);
  copyInto(detail, sizeof detail, newDetail);
}

void Findings::fault(std::string_view entry, const std::string& text, const std::string& detail) {
  if (!known_.insert(std::string(entry) + kFieldEnd + text).second) return;
  const std::string record = std::string(entry) + kFieldEnd + text + kFieldEnd + detail + kRecordEnd;
  for (size_t done = 0; done < record.size();) {
    const ssize_t written = write(pipe_, record.data() + done, record.size() - done);
    if (written <= 0) return;
    done += static_cast<size_t>(written);
  }
}

std::vector<Fault> parseFindings(std::string_view text, const std::string& check) {
  std::vector<Fault> faults;
  for (size_t end; (end = text.find(kRecordEnd)) != text.npos; text.remove_prefix(end + 1)) {
    std::string_view record = text.substr(0, end);
    std::array<std::string, 3> fields;
    for (std::string& field : fields) {
      const size_t length = std::min(record.find(kFieldEnd), record.size());
      field = record.substr(0, length);
      record.remove_prefix(std::min(length + 1, record.size()));
    }
    faults.push_back({check, fields[0], fields[1], fields[2]});
  }
  return faults;
}

}  // namespace patina::shadercheck
