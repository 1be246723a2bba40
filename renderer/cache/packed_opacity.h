// SPDX-License-Identifier: Apache-2.0
// Opacity in 32 bits: three components in [0, 1], 10 bits each.
//
// 0 and 1 are exact, which most points of cut-outs are; what lies between is off by at most 1/2046, half a
// thousandth. What is beyond counts as the nearer end.
#pragma once

#include "renderer/base/math.h"

namespace patina {

class PackedOpacity {
 public:
  static constexpr uint32_t kMissing = ~uint32_t{0};  ///< not the code of any opacity

  static uint32_t pack(const Rgb& opacity) {
    uint32_t code = 0;
    for (int c = 2; c >= 0; --c) {
      const float inRange = opacity[c] > 0 ? std::min(opacity[c], 1.0f) : 0;  // NaN counts as 0
      code = code << kBits | static_cast<uint32_t>(inRange * kMost + 0.5f);
    }
    return code;
  }
  static Rgb unpack(uint32_t code) {
    constexpr uint32_t kMask = (1u << kBits) - 1;
    return Rgb(static_cast<float>(code & kMask), static_cast<float>(code >> kBits & kMask),
               static_cast<float>(code >> (2 * kBits) & kMask)) /
           kMost;
  }

 private:
  static constexpr int kBits = 10;
  static constexpr float kMost = (1 << kBits) - 1;
};

}  // namespace patina
