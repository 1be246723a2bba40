// SPDX-License-Identifier: Apache-2.0
// Numbers as RIB writes them in ASCII, read exactly rounded at the speed of the digits.
#pragma once

#ifdef __SSE4_1__
#include <immintrin.h>
#endif

#include <bit>
#include <cstdint>
#include <cstring>

namespace patina {

enum class NumberStatus : uint8_t {
  Ok,
  NotANumber,  // no number starts here
  Malformed,   // a number runs into something else ("12ab", "1.2.3", "-")
  NotFinite,   // nan, inf, infinity
  TooLarge     // beyond the range of float: the value is the largest float with its sign
};

struct Number {
  float value = 0;        // the float nearest to the text, as strtof gives it
  double exact = 0;       // the same as a double when integral is set
  bool integral = false;  // written without point and exponent, |value| < 2^53
  NumberStatus status = NumberStatus::NotANumber;
  const char* end = nullptr;  // behind the number, or behind the malformed word
};

// The number at first < last. Accepts "1", "-1.", "+.5", "1e+05"; the token must end at a delimiter.
Number scanNumber(const char* first, const char* last);

namespace number_detail {

inline constexpr double kPowersOf10[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                         1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                         1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
inline constexpr uint64_t kIntegerPowersOf10[] = {1,      10,      100,      1000,     10000,
                                                  100000, 1000000, 10000000, 100000000};

inline bool isDigit(char c) { return static_cast<unsigned char>(c - '0') < 10; }

// Bytes that may follow a token: blanks and controls, brackets, quotes, comments, binary tokens.
inline bool isDelimiter(char c) {
  const auto u = static_cast<unsigned char>(c);
  return u <= ' ' || u >= 0x80 || c == '[' || c == ']' || c == '"' || c == '#';
}

// Appends the decimal digits at p to `mantissa` (modulo 2^64) and returns the position behind them. Eight at
// a time, without a branch for each: how many digits a number has cannot be predicted.
inline const char* scanDigits(const char* p, const char* last, uint64_t& mantissa) {
  if constexpr (std::endian::native == std::endian::little) {
    while (last - p >= 8) {
      uint64_t bytes;
      std::memcpy(&bytes, p, 8);
      bytes ^= 0x3030303030303030;  // digits become 0 to 9
      const uint64_t others = ((bytes + 0x7676767676767676) | bytes) & 0x8080808080808080;
      const int n = others ? std::countr_zero(others) >> 3 : 8;
      // Shift the n digits to the end, zeros before them, and add them up in pairs, fours and eights.
      uint64_t v = n == 8 ? bytes : (bytes << (8 * (7 - n))) << 8;
      v = v * 10 + (v >> 8);
      v = ((v & 0x000000ff000000ff) * 0x000f424000000064 +
           (v >> 16 & 0x000000ff000000ff) * 0x0000271000000001) >>
          32;
      mantissa = mantissa * kIntegerPowersOf10[n] + v;
      p += n;
      if (n < 8) return p;
    }
  }
  while (p != last && isDigit(*p)) mantissa = mantissa * 10 + static_cast<uint64_t>(*p++ - '0');
  return p;
}

#ifdef __SSE4_1__

/// Shuffles of 16 bytes: `drop[k]` leaves out byte k (16: none), `last[n]` moves the first n bytes to the
/// end, behind zeros.
struct Shuffles {
  alignas(16) uint8_t drop[17][16], last[17][16];
};
inline constexpr Shuffles kShuffles = [] {
  Shuffles s{};
  for (int k = 0; k <= 16; ++k)
    for (int i = 0; i < 16; ++i) {
      s.drop[k][i] = static_cast<uint8_t>(i < k ? i : i + 1 < 16 ? i + 1 : 0x80);
      s.last[k][i] = static_cast<uint8_t>(i < 16 - k ? 0x80 : i - (16 - k));
    }
  return s;
}();
inline constexpr double kInversePowersOf10[] = {1e0,  1e-1, 1e-2,  1e-3,  1e-4,  1e-5,  1e-6,  1e-7,
                                                1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14, 1e-15};

/// A number of up to 15 digits with or without a point, no exponent, within the first 16 bytes behind the
/// sign: what nearly all numbers are. Its digits are found, brought together and added up at once (Lemire
/// 2021, section 9, has the eight-byte way). Null when it is not of this kind; else as scanSimpleNumber.
/// Needs 17 bytes to read.
inline const char* scanShortNumber(const char* p, double& value, bool& integral) {
  const bool negative = *p == '-';
  p += negative || *p == '+';
  const __m128i text = _mm_loadu_si128(reinterpret_cast<const __m128i*>(p));
  const __m128i digits = _mm_sub_epi8(text, _mm_set1_epi8('0'));
  const __m128i isDigits = _mm_cmpeq_epi8(_mm_min_epu8(digits, _mm_set1_epi8(9)), digits);
  const auto digitMask = static_cast<unsigned>(_mm_movemask_epi8(isDigits));
  const auto pointMask = static_cast<unsigned>(_mm_movemask_epi8(_mm_cmpeq_epi8(text, _mm_set1_epi8('.'))));
  const auto length = static_cast<unsigned>(std::countr_zero(~(digitMask | pointMask)));
  const unsigned points = pointMask & ((1u << length) - 1);
  // 1 to 15 digits, at most one point, and the end of the token in sight.
  if (length > 15 || (points & (points - 1)) != 0 || !isDelimiter(p[length])) return nullptr;
  const auto point = static_cast<unsigned>(std::countr_zero(points | 0x10000u));
  const unsigned count = length - (points != 0);
  if (count == 0) return nullptr;
  const auto shuffle = [](const __m128i& bytes, const uint8_t* order) {
    return _mm_shuffle_epi8(bytes, _mm_load_si128(reinterpret_cast<const __m128i*>(order)));
  };
  const __m128i aligned = shuffle(shuffle(digits, kShuffles.drop[point]), kShuffles.last[count]);
  const __m128i pairs =
      _mm_maddubs_epi16(aligned, _mm_setr_epi8(10, 1, 10, 1, 10, 1, 10, 1, 10, 1, 10, 1, 10, 1, 10, 1));
  const __m128i fours = _mm_madd_epi16(pairs, _mm_setr_epi16(100, 1, 100, 1, 100, 1, 100, 1));
  const __m128i packed = _mm_packus_epi32(fours, fours);
  const __m128i eights = _mm_madd_epi16(packed, _mm_setr_epi16(10000, 1, 10000, 1, 10000, 1, 10000, 1));
  const auto both = static_cast<uint64_t>(_mm_cvtsi128_si64(eights));
  const auto mantissa = static_cast<double>((both & 0xffffffffu) * 100000000 + (both >> 32));
  const unsigned fraction = points ? length - point - 1 : 0;
  integral = points == 0;
  // The product is within two units of the last place of the exact double; so is the float that it is rounded
  // to the right one unless it lies that near to the middle between two floats.
  const double magnitude = mantissa * kInversePowersOf10[fraction];
  const uint64_t rest = std::bit_cast<uint64_t>(magnitude) & ((uint64_t{1} << 29) - 1);
  if (fraction > 0 && rest - ((uint64_t{1} << 28) - 4) <= 8) return nullptr;
  // No branch: signs cannot be predicted.
  value = std::bit_cast<double>(std::bit_cast<uint64_t>(magnitude) | static_cast<uint64_t>(negative) << 63);
  return p + length;
}

#endif

}  // namespace number_detail

// The fast way for nearly all numbers: null when it does not apply, else the position behind the number. Then
// float(value) is the float nearest to the text, and value is exact if `integral`.
inline const char* scanSimpleNumber(const char* p, const char* last, double& value, bool& integral) {
  using namespace number_detail;
#ifdef __SSE4_1__
  if (last - p >= 17)
    if (const char* const end = scanShortNumber(p, value, integral)) return end;
#endif
  const bool negative = *p == '-';
  p += negative || *p == '+';

  // Digits and point.
  const char* const digits = p;
  uint64_t mantissa = 0;
  p = scanDigits(p, last, mantissa);
  int64_t count = p - digits;
  int64_t exponent = 0;
  integral = true;
  if (p != last && *p == '.') {
    const char* const fraction = ++p;
    p = scanDigits(p, last, mantissa);
    exponent = fraction - p;
    count -= exponent;
    integral = false;
  }
  if (count == 0 || count > 19) return nullptr;

  if (p != last && !isDelimiter(*p)) [[unlikely]] {
    if ((*p | 0x20) != 'e') return nullptr;
    const char* q = p + 1;
    const bool minus = q != last && *q == '-';
    q += minus || (q != last && *q == '+');
    uint64_t written = 0;
    const char* const start = q;
    q = scanDigits(q, last, written);
    if (q == start || q - start > 8 || (q != last && !isDelimiter(*q))) return nullptr;
    exponent += minus ? -static_cast<int64_t>(written) : static_cast<int64_t>(written);
    p = q;
    integral = false;
  }

  // Clinger's fast path: mantissa and power of ten are exact doubles, so the double is correctly rounded, and
  // so is the float made of it unless the double lies just between two floats.
  if (mantissa >= (uint64_t{1} << 53) || exponent < -22 || exponent > 22) return nullptr;
  const double magnitude = exponent < 0 ? static_cast<double>(mantissa) / kPowersOf10[-exponent]
                                        : static_cast<double>(mantissa) * kPowersOf10[exponent];
  constexpr uint64_t kBelowFloat = (uint64_t{1} << 29) - 1, kMiddle = uint64_t{1} << 28;
  const bool middle = (std::bit_cast<uint64_t>(magnitude) & kBelowFloat) == kMiddle && exponent != 0;
  constexpr double kLeast = 0x1p-126, kMost = 3e38;  // normal floats
  if (middle || magnitude > kMost || (magnitude < kLeast && mantissa != 0)) return nullptr;
  value = negative ? -magnitude : magnitude;
  return p;
}

}  // namespace patina
