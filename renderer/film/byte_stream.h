// SPDX-License-Identifier: Apache-2.0
// Values to bytes of a file and back, for files that this program writes for itself: in the machine's own
// order of bytes, which the file's head tells.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace patina {

/// Hands what is put to a sink, a block at a time. [one thread]
class ByteWriter {
 public:
  /// The sink returns why the bytes cannot be kept, else an empty text.
  using Sink = std::function<std::string(const std::string& bytes)>;
  explicit ByteWriter(Sink sink) : sink_(std::move(sink)) {}

  template <class T>
  void put(const T& value) {
    putArray(std::span<const T>(&value, 1));
  }
  /// The elements alone: how many there are is told elsewhere.
  template <class T>
  void putArray(std::span<const T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    add(values.data(), values.size_bytes());
  }
  void putText(std::string_view text);
  /// Adds the CRC-32 of all that has been put, and empties the buffer. Returns the first problem.
  std::string finish();
  uint64_t count() const { return count_; }  ///< bytes

 private:
  void add(const void* data, size_t size);
  void flush();

  Sink sink_;
  std::string buffer_, problem_;
  uint64_t count_ = 0;
  uint32_t crc_ = 0;
};

/// Reads such a file, which may be hostile: no size in it is believed before as many bytes are known to be
/// there. [one thread]
class ByteReader {
 public:
  ByteReader() = default;
  ~ByteReader();
  ByteReader(const ByteReader&) = delete;
  ByteReader& operator=(const ByteReader&) = delete;

  /// Opens a regular file and reads it once for its check sum. Returns why it cannot be used, else "".
  std::string open(const std::string& path);

  /// False: the file has ended before; the value is what it was.
  template <class T>
  bool get(T& value) {
    return getArray(std::span<T>(&value, 1));
  }
  template <class T>
  bool getArray(std::span<T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    return take(values.data(), values.size_bytes());
  }
  /// Makes the vector one of `count` elements.
  template <class T>
  bool getVector(std::vector<T>& values, uint64_t count) {
    if (count > remaining_ / sizeof(T)) return false;
    values.resize(static_cast<size_t>(count));
    return getArray(std::span<T>(values));
  }
  bool getText(std::string& text);
  uint64_t remaining() const { return remaining_; }  ///< bytes, without the check sum
  uint64_t size() const { return size_; }            ///< of the file

 private:
  bool take(void* data, size_t size);
  bool fill();

  int file_ = -1;
  uint64_t size_ = 0, remaining_ = 0;
  std::string buffer_;
  size_t next_ = 0;
};

}  // namespace patina
