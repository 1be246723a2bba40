// SPDX-License-Identifier: Apache-2.0
// First bytes of the tokens of binary RIB (RI 3.2, table C.1). Numbers behind a code are big-endian.
#pragma once

namespace patina::binary_code {

inline constexpr unsigned kInteger = 0200;      // + 4 d + w: w + 1 bytes, d of them behind the point
inline constexpr unsigned kShortString = 0220;  // + length, up to 15
inline constexpr unsigned kString = 0240;       // + w: length in w + 1 bytes
inline constexpr unsigned kFloat32 = 0244, kFloat64 = 0245;
inline constexpr unsigned kRequest = 0246;        // code in 1 byte
inline constexpr unsigned kFloatArray = 0310;     // + w: count in w + 1 bytes, then floats of 4
inline constexpr unsigned kDefineRequest = 0314;  // code in 1 byte, then a string
inline constexpr unsigned kDefineString = 0315;   // + w: code in w + 1 bytes, then a string
inline constexpr unsigned kDefinedString = 0317;  // + w: code in w + 1 bytes
inline constexpr unsigned kEndOfBlock = 0377;

}  // namespace patina::binary_code
