// SPDX-License-Identifier: Apache-2.0
// The rare cases of reading numbers: long mantissas, extreme exponents, and what is no number at all.
#include "rib/number.h"

#include <cctype>
#include <string_view>

namespace patina::number_detail {

Number scanExactly(const char* first, const char* last, bool negative, int64_t exponent) {
  Number result;
  result.status = NumberStatus::Ok;
  const auto [end, error] = std::from_chars(first, last, result.value);
  if (error == std::errc::result_out_of_range) {
    // Which end of the range was missed? The order of magnitude is far from 1 either way.
    int64_t significant = 0;
    for (const char* p = first; p != last && (isDigit(*p) || *p == '.'); ++p) {
      if (*p != '.' && (*p != '0' || significant > 0)) ++significant;
    }
    const bool large = significant + exponent > 0;
    result.value = large ? std::numeric_limits<float>::max() : 0.0f;
    if (large) result.status = NumberStatus::TooLarge;
  } else if (error != std::errc() || end != last) {
    result.status = NumberStatus::Malformed;
  }
  if (negative) result.value = -result.value;
  return result;
}

Number scanOddity(const char* first, const char* last) {
  Number result;
  const char* p = first;
  while (p != last && !isDelimiter(*p)) ++p;
  result.end = p;
  std::string_view word(first, static_cast<size_t>(p - first));
  const bool sign = !word.empty() && (word.front() == '-' || word.front() == '+');
  if (sign) word.remove_prefix(1);
  for (std::string_view odd : {"nan", "inf", "infinity"}) {
    if (word.size() != odd.size()) continue;
    bool same = true;
    for (size_t i = 0; i < odd.size(); ++i) {
      same = same && std::tolower(static_cast<unsigned char>(word[i])) == odd[i];
    }
    if (same) {
      result.status = NumberStatus::NotFinite;
      return result;
    }
  }
  if (sign || (!word.empty() && word.front() == '.')) result.status = NumberStatus::Malformed;
  return result;
}

}  // namespace patina::number_detail
