// SPDX-License-Identifier: Apache-2.0
// Which bytes may begin which token: most tokens that the grammar tries are ruled out by one look.
#pragma once

#include <array>
#include <cstdint>

#include "rib/binary_codes.h"

namespace patina::first_byte {

enum Set : uint8_t {
  Blank = 1,
  Word = 2,
  Number = 4,
  String = 8,
  FloatArray = 16,
  Letter = 32,
  Stray = 64,
  StrayInArray = 128
};

// By byte. A terminal may still refuse what begins with one of its bytes; it never takes anything else.
inline constexpr std::array<uint8_t, 256> kSets = [] {
  using namespace binary_code;
  std::array<uint8_t, 256> sets{};
  const auto add = [&](Set set, unsigned from, unsigned to) {
    for (unsigned c = from; c <= to; ++c) sets[c] |= set;
  };
  for (unsigned c = 0; c < 256; ++c) {
    const unsigned lower = c | 0x20;
    const bool letter = (lower >= 'a' && lower <= 'z' && c < 0200) || c == '_';
    if (letter) sets[c] = Word | Letter;
    if (letter && (lower == 'n' || lower == 'i')) sets[c] |= Number;  // nan, inf
    if (letter || c == kRequest || c == '[') continue;
    sets[c] |= c == ']' ? Stray : Stray | StrayInArray;
  }
  add(Blank, 0, ' ');
  add(Blank, '#', '#');
  add(Blank, kEndOfBlock, kEndOfBlock);
  add(Blank, kDefineRequest, kDefinedString - 1);
  add(Word, kRequest, kRequest);
  add(Number, '+', '9');
  add(Number, kInteger, kShortString - 1);
  add(Number, kFloat32, kFloat64);
  add(String, '"', '"');
  add(String, kShortString, kFloat32 - 1);
  add(String, kDefinedString, kDefinedString + 1);
  add(FloatArray, kFloatArray, kDefineRequest - 1);
  return sets;
}();

inline bool mayBegin(Set set, char c) { return (kSets[static_cast<unsigned char>(c)] & set) != 0; }

}  // namespace patina::first_byte
