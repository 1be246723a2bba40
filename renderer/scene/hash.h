// SPDX-License-Identifier: Apache-2.0
// A hash over the members of a value, to find equal ones among many.
#pragma once

#include <cstdint>
#include <cstring>
#include <string_view>
#include <type_traits>

namespace patina {

/// FNV-1a over the bytes that are added. Equal values must have equal bytes: -0 and 0 count as different.
class Hasher {
 public:
  template <class T>
  Hasher& add(const T& value) {
    if constexpr (requires { value.data(), value.size(); }) {
      using Element = std::remove_cvref_t<decltype(*value.data())>;
      static_assert(std::is_trivially_copyable_v<Element>);
      const size_t count = value.size();
      return bytes(&count, sizeof count).bytes(value.data(), count * sizeof(Element));
    } else {
      static_assert(!std::is_pointer_v<T>);
      return bytes(&value, sizeof value);
    }
  }
  size_t value() const { return state_; }

 private:
  Hasher& bytes(const void* data, size_t size) {
    const auto* p = static_cast<const unsigned char*>(data);
    for (size_t i = 0; i < size; ++i) state_ = (state_ ^ p[i]) * 0x100000001b3u;
    return *this;
  }

  uint64_t state_ = 0xcbf29ce484222325u;
};

}  // namespace patina
