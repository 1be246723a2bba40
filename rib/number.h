// SPDX-License-Identifier: Apache-2.0
// Numbers as RIB writes them in ASCII, read exactly rounded at the speed of the digits.
#pragma once

#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>

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

namespace number_detail {

inline constexpr double kPowersOf10[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                         1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                         1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

inline bool isDigit(char c) { return static_cast<unsigned char>(c - '0') < 10; }

// Bytes that may follow a token: blanks and controls, brackets, quotes, comments, binary tokens.
inline bool isDelimiter(char c) {
  const auto u = static_cast<unsigned char>(c);
  return u <= ' ' || u >= 0x80 || c == '[' || c == ']' || c == '"' || c == '#';
}

// The slow way, for long mantissas and large exponents. `first` is behind the sign; all digits read as one
// integer are to be multiplied by 10^exponent.
Number scanExactly(const char* first, const char* last, bool negative, int64_t exponent);
// What is at `first` when it is not a number: nan and inf, or a sign or point without digits.
Number scanOddity(const char* first, const char* last);

}  // namespace number_detail

// The number at first < last. Accepts "1", "-1.", "+.5", "1e+05"; the token must end at a delimiter.
inline Number scanNumber(const char* const first, const char* const last) {
  using namespace number_detail;
  Number result;
  const char* p = first;
  const bool negative = *p == '-';
  if (negative || *p == '+') ++p;

  // Digits and point. At most 19 digits go into the mantissa; more, and the slow way reads them all.
  const char* const digits = p;
  uint64_t mantissa = 0;
  while (p != last && isDigit(*p)) mantissa = mantissa * 10 + static_cast<uint64_t>(*p++ - '0');
  int64_t count = p - digits;
  int64_t exponent = 0;
  result.integral = true;
  if (p != last && *p == '.') {
    const char* const fraction = ++p;
    while (p != last && isDigit(*p)) mantissa = mantissa * 10 + static_cast<uint64_t>(*p++ - '0');
    exponent = fraction - p;
    count -= exponent;
    result.integral = false;
  }
  if (count == 0) return scanOddity(first, last);

  if (p != last && (*p == 'e' || *p == 'E')) {
    const char* q = p + 1;
    const bool minus = q != last && *q == '-';
    if (minus || (q != last && *q == '+')) ++q;
    int64_t written = 0;
    const char* const start = q;
    while (q != last && isDigit(*q)) {
      if (written < 100000000) written = written * 10 + (*q - '0');
      ++q;
    }
    if (q != start) {
      exponent += minus ? -written : written;
      p = q;
      result.integral = false;
    }
  }
  if (p != last && !isDelimiter(*p)) {
    while (p != last && !isDelimiter(*p)) ++p;
    result.status = NumberStatus::Malformed;
    result.end = p;
    return result;
  }

  // Clinger's fast path: mantissa and power of ten are exact doubles, so the double is correctly rounded, and
  // so is the float made of it unless the double lies just between two floats.
  if (count <= 19 && mantissa < (uint64_t{1} << 53) && exponent >= -22 && exponent <= 22) {
    double d = static_cast<double>(mantissa);
    d = exponent < 0 ? d / kPowersOf10[-exponent] : d * kPowersOf10[exponent];
    constexpr uint64_t kBelowFloat = (uint64_t{1} << 29) - 1, kMiddle = uint64_t{1} << 28;
    const bool middle = (std::bit_cast<uint64_t>(d) & kBelowFloat) == kMiddle && exponent != 0;
    if (!middle && ((d >= std::numeric_limits<float>::min() && d < 3e38) || d == 0)) {
      result.exact = negative ? -d : d;
      result.value = static_cast<float>(result.exact);
      result.status = NumberStatus::Ok;
      result.end = p;
      return result;
    }
  }
  result = scanExactly(digits, p, negative, exponent);
  result.end = p;
  return result;
}

}  // namespace patina
