// SPDX-License-Identifier: Apache-2.0
// Radiance in 64 bits: three 18-bit mantissas under one 10-bit exponent.
//
// Values from 2^-500 to 2^500 of the largest component survive; each component is off by at most 2^-18 of the
// largest, four millionths. Negative components are kept as zero. One word can be read and written without a
// lock.
#pragma once

#include <bit>

#include "renderer/base/math.h"

namespace patina {

class PackedRgb {
 public:
  static constexpr uint64_t kMissing = ~uint64_t{0};  ///< not the code of any colour

  static uint64_t pack(const Rgb& c) {
    const float largest = maxComponent(c);
    if (!(largest > 0)) return 0;
    int exponent;
    std::frexp(largest, &exponent);  // largest < 2^exponent
    uint64_t m[3];
    const double scale = std::ldexp(1.0, kBits - exponent);
    for (int k = 0; k < 3; ++k) {
      const double scaled = std::max(0.0, static_cast<double>(c[k])) * scale + 0.5;
      m[k] = std::min(static_cast<uint64_t>(scaled), kMask);
    }
    return m[0] | m[1] << kBits | m[2] << (2 * kBits) |
           static_cast<uint64_t>(exponent + kBias) << (3 * kBits);
  }
  static Rgb unpack(uint64_t code) {
    const auto exponent = static_cast<int>(code >> (3 * kBits)) - kBias;
    // 2^(exponent - kBits) as a float; the exponent of a float fits, denormals included, by two factors.
    const float scale =
        std::bit_cast<float>(static_cast<uint32_t>(std::clamp(exponent - kBits + 127 + 24, 1, 254)) << 23) *
        0x1p-24f;
    return Rgb(static_cast<float>(code & kMask), static_cast<float>((code >> kBits) & kMask),
               static_cast<float>((code >> (2 * kBits)) & kMask)) *
           scale;
  }

 private:
  static constexpr int kBits = 18, kBias = 511;
  static constexpr uint64_t kMask = (uint64_t{1} << kBits) - 1;
};

}  // namespace patina
