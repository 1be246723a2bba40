// SPDX-License-Identifier: Apache-2.0
// The rare cases of reading numbers: long mantissas, extreme exponents, and what is no number at all.
#include "rib/number.h"

#include <cctype>
#include <charconv>
#include <limits>
#include <string_view>

namespace patina {
namespace {

using namespace number_detail;

bool equalsNoCase(std::string_view word, std::string_view lower) {
  if (word.size() != lower.size()) return false;
  for (size_t i = 0; i < word.size(); ++i) {
    if (std::tolower(static_cast<unsigned char>(word[i])) != lower[i]) return false;
  }
  return true;
}

}  // namespace

Number scanNumber(const char* const first, const char* const last) {
  Number result;
  double value;
  if (const char* const end = scanSimpleNumber(first, last, value, result.integral)) {
    result.value = static_cast<float>(value);
    result.exact = value;
    result.status = NumberStatus::Ok;
    result.end = end;
    return result;
  }
  result.integral = false;

  // The word, and its number without the sign, which from_chars takes only if it is a minus.
  const char* p = first;
  while (p != last && !isDelimiter(*p)) ++p;
  result.end = p;
  const bool negative = *first == '-';
  const bool sign = negative || *first == '+';
  const char* const digits = first + sign;
  const std::string_view word(digits, static_cast<size_t>(p - digits));
  if (word.empty() || !(isDigit(word[0]) || word[0] == '.')) {
    const bool odd = equalsNoCase(word, "nan") || equalsNoCase(word, "inf") || equalsNoCase(word, "infinity");
    result.status = odd ? NumberStatus::NotFinite : sign ? NumberStatus::Malformed : NumberStatus::NotANumber;
    return result;
  }

  const auto [end, error] = std::from_chars(digits, p, result.value);
  result.status = end == p ? NumberStatus::Ok : NumberStatus::Malformed;
  if (error == std::errc::result_out_of_range && end == p) {
    // Which end of the range was missed? The order of magnitude is far from 1 either way.
    int64_t order = 0;
    bool point = false, significant = false;
    const char* q = digits;
    for (; q != p && (isDigit(*q) || *q == '.'); ++q) {
      significant |= *q != '.' && *q != '0';
      if (*q == '.') {
        point = true;
      } else if (!point) {
        order += significant;
      } else if (!significant) {
        --order;
      }
    }
    int64_t written = 0;
    const bool minus = q != p && q + 1 != p && q[1] == '-';
    for (; q != p; ++q) {
      if (isDigit(*q) && written < int64_t{1} << 50) written = written * 10 + (*q - '0');
    }
    const bool large = order + (minus ? -written : written) > 0;
    result.value = large ? std::numeric_limits<float>::max() : 0.0f;
    if (large) result.status = NumberStatus::TooLarge;
  } else if (error != std::errc()) {
    result.status = NumberStatus::Malformed;
  }
  if (negative) result.value = -result.value;
  return result;
}

}  // namespace patina
