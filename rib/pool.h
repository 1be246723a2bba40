// SPDX-License-Identifier: Apache-2.0
// The values of one request, in memory that is reused from request to request.
#pragma once

#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory_resource>
#include <new>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "rib/params.h"

namespace patina {

// One argument or parameter value as the grammar sees it: a bare number, a run of bare numbers, a bare
// string, or an array. The values lie in the pool's `floats` or `strings`.
struct Value {
  enum class Kind : uint8_t { Empty, Number, String, Mixed };
  Kind kind = Kind::Empty;
  bool array = false;  // in brackets, or a binary float array
  bool bad = false;    // holds a token that was reported already
  size_t first = 0, count = 0;
  const char* begin = nullptr;  // in the source
  const char* end = nullptr;
};

// A vector of plain values that does not clear what it grows by. Large ones grow by moving pages, so that
// growing neither copies nor leaves anything behind, and memory that was never used is never there.
template <typename T>
class Pool {
 public:
  Pool() = default;
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;
  ~Pool() { release(); }

  void push(T value) {
    if (size_ == capacity_) grow(size_ + 1);
    data_[size_++] = value;
  }
  // Room for n more values, to be filled by the caller.
  T* extend(size_t n) {
    if (capacity_ - size_ < n) grow(size_ + n);
    size_ += n;
    return data_ + size_ - n;
  }
  // Keeps its memory for the next values, but not what one huge request took: that would stay while a frame
  // is rendered.
  void clear() {
    size_ = 0;
    if (capacity_ * sizeof(T) <= kKept) return;
    release();
    data_ = nullptr;
    capacity_ = 0;
  }
  size_t size() const { return size_; }
  T* data() { return data_; }
  std::span<const T> view(size_t first, size_t count) const { return {data_ + first, count}; }

 private:
  void grow(size_t atLeast) {
    const size_t wanted = std::max({capacity_ * 2, atLeast, size_t{1024}});
    const size_t bytes = wanted * sizeof(T), before = capacity_ * sizeof(T);
    void* grown = nullptr;
    if (bytes < kMapped) {
      grown = std::realloc(data_, bytes);
      if (!grown) throw std::bad_alloc();
    } else {
      grown = before < kMapped
                  ? mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0)
                  : mremap(data_, before, bytes, MREMAP_MAYMOVE);
      if (grown == MAP_FAILED) throw std::bad_alloc();
      madvise(grown, bytes, MADV_HUGEPAGE);  // a wish: fewer page faults
      if (before < kMapped) {
        if (size_ > 0) std::memcpy(grown, data_, size_ * sizeof(T));
        std::free(data_);
      }
    }
    data_ = static_cast<T*>(grown);
    capacity_ = wanted;
  }
  void release() {
    if (capacity_ * sizeof(T) < kMapped)
      std::free(data_);
    else
      munmap(data_, capacity_ * sizeof(T));
  }

  static constexpr size_t kMapped = size_t{1} << 20, kKept = size_t{64} << 20;
  static_assert(std::is_trivially_copyable_v<T>);
  T* data_ = nullptr;
  size_t size_ = 0, capacity_ = 0;
};

class ValuePool {
 public:
  void clear() {
    values.clear();
    floats.clear();
    wide.clear();
    strings.clear();
    params.clear();
    comments.clear();
    if (textUsed_) text_.release();
    textUsed_ = false;
  }
  // Bytes that live until clear(); they never move.
  char* text(size_t bytes) {
    textUsed_ = true;
    return static_cast<char*>(text_.allocate(std::max<size_t>(bytes, 1), 1));
  }

  // Integers that a float cannot hold exactly, beside the rounded value in `floats`.
  struct WideInteger {
    size_t index;
    double value;
  };
  struct Comment {
    const char* begin;  // at the '#'
    const char* end;
  };

  std::vector<Value> values;
  Pool<float> floats;
  std::vector<WideInteger> wide;  // ascending by index
  std::vector<std::string_view> strings;
  std::vector<Param> params;
  std::vector<Comment> comments;

 private:
  std::array<char, 4096> buffer_;
  std::pmr::monotonic_buffer_resource text_{buffer_.data(), buffer_.size()};
  bool textUsed_ = false;
};

}  // namespace patina
