// SPDX-License-Identifier: Apache-2.0
// A vector that grows while it is read: its elements never move.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <new>
#include <stdexcept>
#include <type_traits>
#include <utility>

namespace patina {

/// Address space that is taken at once, and memory in it when it is needed.
class AddressRange {
 public:
  /// Takes room for `bytes`. Throws std::bad_alloc.
  explicit AddressRange(size_t bytes);
  ~AddressRange();
  AddressRange(const AddressRange&) = delete;
  AddressRange& operator=(const AddressRange&) = delete;

  /// Bytes for as many elements as a table is ever wanted to have, or fewer where the process may not take so
  /// much (setrlimit RLIMIT_AS): a small part of what it may.
  static size_t most(size_t elementBytes);

  void* data() const { return data_; }
  size_t size() const { return size_; }  ///< bytes of address space
  /// Makes the first `bytes` usable. Throws std::bad_alloc when that is more than there is room for.
  void use(size_t bytes) {
    if (bytes > used_) useMore(bytes);
  }

 private:
  void useMore(size_t bytes);

  void* data_;
  size_t size_, used_ = 0;
};

/// Reads cost what those of an array cost, which is why this is no tbb::concurrent_vector (whose elements lie
/// in segments). Once makeRoom() was called, one thread at a time may grow it, while others read elements
/// that they learned of behind an acquire of what the growing thread released; size(), begin() and end() are
/// for the thread that grows it. Without makeRoom() it is an ordinary vector, which takes no address space
/// beyond its elements and moves them when it grows; elements that cannot be moved come by one growTo() then.
template <typename T>
class StableVector {
 public:
  StableVector() = default;
  ~StableVector() { std::destroy_n(data_, size_); }
  StableVector(const StableVector&) = delete;
  StableVector& operator=(const StableVector&) = delete;

  /// Elements never move from here on. To be called while it is empty.
  void makeRoom() {
    if (!range_) take(AddressRange::most(sizeof(T)));
    fixed_ = true;
  }

  template <typename... Arguments>
  T& emplace_back(Arguments&&... arguments) {
    if (size_ == capacity()) grow();
    range_->use((size_ + 1) * sizeof(T));
    T* const made = new (data_ + size_) T(std::forward<Arguments>(arguments)...);
    ++size_;
    return *made;
  }
  void push_back(T value) { emplace_back(std::move(value)); }
  /// Appends elements T() until there are `size`.
  void growTo(size_t size) {
    if (!range_ && size > 0) take(size * sizeof(T));
    while (size_ < size) emplace_back();
  }

  /// Takes away the last elements, which nobody else may know of.
  void shrinkTo(size_t size) {
    while (size_ > size) std::destroy_at(data_ + --size_);
  }

  T& operator[](size_t k) { return data_[k]; }
  const T& operator[](size_t k) const { return data_[k]; }
  T& back() { return data_[size_ - 1]; }
  size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const T* begin() const { return data_; }
  const T* end() const { return data_ + size_; }

 private:
  size_t capacity() const { return range_ ? range_->size() / sizeof(T) : 0; }
  void take(size_t bytes) {
    range_ = std::make_unique<AddressRange>(bytes);
    data_ = static_cast<T*>(range_->data());
  }
  void grow() {
    constexpr size_t kFirst = 64;
    const size_t wanted = std::max(2 * size_, kFirst) * sizeof(T);
    if (!range_) return take(wanted);
    if constexpr (std::is_move_constructible_v<T>) {
      if (!fixed_) {
        auto larger = std::make_unique<AddressRange>(wanted);
        larger->use(size_ * sizeof(T));
        T* const moved = static_cast<T*>(larger->data());
        std::uninitialized_move_n(data_, size_, moved);
        std::destroy_n(data_, size_);
        range_ = std::move(larger);
        data_ = moved;
        return;
      }
    }
    throw std::length_error("there is no room for more geometry");
  }

  std::unique_ptr<AddressRange> range_;
  T* data_ = nullptr;
  size_t size_ = 0;
  bool fixed_ = false;
};

}  // namespace patina
