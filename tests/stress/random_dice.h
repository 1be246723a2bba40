// SPDX-License-Identifier: Apache-2.0
// Random choices that are the same each time, and numbers that nobody should write into a RIB.
#pragma once

#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "renderer/base/sampling.h"

namespace patina::stress {

class Dice {
 public:
  explicit Dice(uint64_t seed) : seed_(seed) {}
  uint32_t bits() { return static_cast<uint32_t>(hashOf(seed_, count_++) >> 32); }
  double unit() { return bits() * 0x1p-32; }
  double range(double low, double high) { return low + (high - low) * unit(); }
  int below(int count) { return static_cast<int>(unit() * count); }
  bool chance(double p) { return unit() < p; }
  template <class T>
  T pick(std::initializer_list<T> list) {
    return list.begin()[below(static_cast<int>(list.size()))];
  }

 private:
  uint64_t seed_, count_ = 0;
};

/// A float as RIB text; NaN and infinities, which text cannot have, as RIB's binary floats.
inline std::string number(double value) {
  const float f = static_cast<float>(value);
  if (f - f == 0) return fmt::format("{}", f);
  const auto bits = std::bit_cast<uint32_t>(f);
  std::string text = " \xa4";
  for (int shift = 24; shift >= 0; shift -= 8) text += static_cast<char>(bits >> shift);
  return text;
}

template <class Range>
std::string numbers(const Range& values) {
  std::string text = "[";
  for (const auto v : values) text += (text.size() > 1 ? " " : "") + number(v);
  return text + "]";
}

/// Zeros, denormals, the tiny and the huge; at times what is no number.
inline double oddNumber(Dice& dice) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInf = std::numeric_limits<double>::infinity();
  if (dice.chance(0.1)) return dice.pick({kNan, kInf, -kInf});
  return dice.pick({0.0, -0.0, 1e-45, -1e-40, 1e-30, -1e-10, 1e-6, 1e6, -1e10, 1e17, 1e20, -1e30, 3.4e38});
}

}  // namespace patina::stress
