// SPDX-License-Identifier: Apache-2.0
// Buffers between values and files.
#include "renderer/film/byte_stream.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

namespace patina {
namespace {

constexpr size_t kBlock = size_t{1} << 20;

std::string reason() { return std::generic_category().message(errno); }

uint32_t crcOf(uint32_t before, const char* data, size_t size) {
  return static_cast<uint32_t>(crc32_z(before, reinterpret_cast<const Bytef*>(data), size));
}

/// As many bytes as there are, up to `size`; -1: cannot be read.
ssize_t readAll(int file, char* to, size_t size) {
  size_t done = 0;
  while (done < size) {
    const ssize_t n = ::read(file, to + done, size - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return -1;
    if (n == 0) break;
    done += static_cast<size_t>(n);
  }
  return static_cast<ssize_t>(done);
}

}  // namespace

// ---- ByteWriter

void ByteWriter::add(const void* data, size_t size) {
  count_ += size;
  buffer_.append(static_cast<const char*>(data), size);
  if (buffer_.size() >= kBlock) flush();
}

void ByteWriter::flush() {
  crc_ = crcOf(crc_, buffer_.data(), buffer_.size());
  if (problem_.empty()) problem_ = sink_(buffer_);
  buffer_.clear();
}

void ByteWriter::putText(std::string_view text) {
  put(uint64_t{text.size()});
  add(text.data(), text.size());
}

std::string ByteWriter::finish() {
  flush();
  const uint32_t crc = crc_;
  add(&crc, sizeof crc);
  flush();
  return problem_;
}

// ---- ByteReader

ByteReader::~ByteReader() {
  if (file_ >= 0) close(file_);
}

std::string ByteReader::open(const std::string& path) {
  // A pipe is opened without waiting for its writer, and then refused.
  file_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file_ < 0) return reason();
  struct stat status;
  if (fstat(file_, &status) != 0) return reason();
  if (!S_ISREG(status.st_mode)) return "it is no file";
  size_ = static_cast<uint64_t>(status.st_size);
  uint32_t crc = 0, said = 0;
  if (size_ < sizeof said) return "it is cut off";
  remaining_ = size_ - sizeof said;
  for (uint64_t left = remaining_; left > 0;) {
    buffer_.resize(static_cast<size_t>(std::min<uint64_t>(left, kBlock)));
    const ssize_t n = readAll(file_, buffer_.data(), buffer_.size());
    if (n < 0) return reason();
    if (n == 0) return "it is cut off";
    crc = crcOf(crc, buffer_.data(), static_cast<size_t>(n));
    left -= static_cast<uint64_t>(n);
  }
  if (readAll(file_, reinterpret_cast<char*>(&said), sizeof said) != sizeof said) return "it is cut off";
  if (crc != said) return "it is damaged or cut off: its check sum is wrong";
  if (lseek(file_, 0, SEEK_SET) != 0) return reason();
  buffer_.clear();
  return {};
}

bool ByteReader::fill() {
  buffer_.resize(static_cast<size_t>(std::min<uint64_t>(remaining_, kBlock)));
  next_ = 0;
  const ssize_t n = readAll(file_, buffer_.data(), buffer_.size());
  buffer_.resize(static_cast<size_t>(std::max<ssize_t>(n, 0)));
  return n > 0;
}

bool ByteReader::take(void* data, size_t size) {
  if (size > remaining_) return false;
  auto* to = static_cast<char*>(data);
  while (size > 0) {
    if (next_ == buffer_.size() && !fill()) return false;
    const size_t n = std::min(size, buffer_.size() - next_);
    std::memcpy(to, buffer_.data() + next_, n);
    next_ += n, to += n, size -= n, remaining_ -= n;
  }
  return true;
}

bool ByteReader::getText(std::string& text) {
  uint64_t size = 0;
  if (!get(size) || size > remaining_) return false;
  text.resize(static_cast<size_t>(size));
  return take(text.data(), text.size());
}

}  // namespace patina
