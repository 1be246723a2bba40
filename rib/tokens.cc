// SPDX-License-Identifier: Apache-2.0
// The terminals of the grammar: ASCII tokens, and the binary tokens of RI 3.2 appendix C.2.
#include <bit>
#include <cstring>

#include <fmt/format.h>

#include "rib/binary_codes.h"
#include "rib/number.h"
#include "rib/session.h"

namespace patina {
namespace {

using number_detail::isDelimiter;
using number_detail::isDigit;
using namespace binary_code;

unsigned byte(const char* p) { return static_cast<unsigned char>(*p); }
bool isLetter(char c) { return static_cast<unsigned char>((c | 0x20) - 'a') < 26 || c == '_'; }

// n bytes, most significant first.
uint64_t bigEndian(const char* p, unsigned n) {
  uint64_t value = 0;
  for (unsigned i = 0; i < n; ++i) value = value << 8 | byte(p + i);
  return value;
}

float bigEndianFloat(const char* p) { return std::bit_cast<float>(static_cast<uint32_t>(bigEndian(p, 4))); }

bool isFinite(float f) { return (std::bit_cast<uint32_t>(f) & 0x7f800000u) != 0x7f800000u; }

}  // namespace

const char* ParseSession::blank(const char* p, const char* end) {
  while (p != end) {
    const unsigned c = byte(p);
    if (c <= ' ' || c == kEndOfBlock) {  // NUL and the control characters too
      ++p;
    } else if (c == '#') {
      p = comment(p, end);
    } else if (c >= kDefineRequest && c < kDefinedString) {
      p = definition(p, end);
    } else {
      break;
    }
  }
  return p;
}

const char* ParseSession::comment(const char* p, const char* end) {
  const char* q = p;
  while (q != end && *q != '\n' && *q != '\r') ++q;
  const bool structure = q - p >= 2 && p[1] == '#';
  if (!quiet() && (structure || handler().wantsComments())) {
    pool_.comments.push_back({p, q});
    if (!inRequest_) deliverComments();
  }
  return q;
}

// 0314 code string, or 0315+w code string with a code of w+1 bytes.
const char* ParseSession::definition(const char* p, const char* end) {
  const unsigned c = byte(p);
  const unsigned codeBytes = c == kDefineRequest ? 1 : c - kDefineString + 1;
  const char* q = p + 1 + codeBytes;
  std::string_view text;
  if (q >= end || p + 1 + codeBytes > end) return truncated(p, "definition", end);
  const auto code = static_cast<uint32_t>(bigEndian(p + 1, codeBytes));
  const char* next = *q == '"' ? quotedString(q, end, text) : binaryString(q, end, text);
  if (!next) {
    error(RiError::BadRipCode, p, "a definition of binary RIB must hold a string");
    return q;
  }
  // Archives recorded before keep the tables as they were; this request keeps the strings that it views.
  if (!tables_) {
    tables_ = std::make_shared<EncodingTables>();
  } else if (tables_.use_count() > 1) {
    tables_ = std::make_shared<EncodingTables>(*tables_);
  }
  if (c == kDefineRequest) {
    tables_->requests[code] = text;
  } else {
    auto& slot = tables_->strings[code];
    if (slot && *slot == text) return next;
    if (slot) retired_.push_back(std::move(slot));
    slot = std::make_shared<const std::string>(text);
  }
  return next;
}

const char* ParseSession::word(const char* p, const char* end) {
  if (byte(p) == kRequest) {
    nameBegin_ = p;
    name_ = {};
    if (end - p < 2) return end;
    const std::string* name = tables_ ? &tables_->requests[byte(p + 1)] : nullptr;
    name_ = name ? std::string_view(*name) : std::string_view();
    return p + 2;
  }
  if (!isLetter(*p)) return nullptr;
  nameBegin_ = p;
  while (p != end && (isLetter(*p) || isDigit(*p))) ++p;
  name_ = {nameBegin_, static_cast<size_t>(p - nameBegin_)};
  return p;
}

const char* ParseSession::numbers(const char* p, const char* end) {
  const char* const begin = p;
  const size_t first = pool_.floats.size();
  bool bad = false;
  while (p != end) {
    const unsigned c = byte(p);
    double value = 0;
    if (c - '+' <= '9' - '+') {
      bool integral;
      if (const char* const next = scanSimpleNumber(p, end, value, integral)) [[likely]] {
        const auto rounded = static_cast<float>(value);
        if (integral && static_cast<double>(rounded) != value)
          pool_.wide.push_back({pool_.floats.size(), value});
        pool_.floats.push(rounded);
        p = next;
      } else {
        const char* const odd = oddNumber(p, end, bad);
        if (!odd) break;
        p = odd;
      }
    } else if (c >= 0200) {
      const char* const next = binaryNumber(p, end, value);
      if (!next) break;
      const auto rounded = static_cast<float>(value);
      if (!isFinite(rounded)) {
        error(RiError::Range, p, "binary number that is infinite, not a number, or too large for a float");
        bad = true;
      } else {
        if (static_cast<double>(rounded) != value) pool_.wide.push_back({pool_.floats.size(), value});
        pool_.floats.push(rounded);
      }
      p = next;
    } else if ((c | 0x20) == 'n' || (c | 0x20) == 'i') {
      const char* const next = oddNumber(p, end, bad);
      if (!next) break;
      p = next;
    } else {
      break;
    }
    while (p != end && byte(p) <= ' ') ++p;
  }
  if (p == begin) return nullptr;
  addNumbers(first, begin, p, bad);
  return p;
}

// A number that is long, extreme, or wrong; null if there is none. What is wrong is reported and makes `bad`
// true.
const char* ParseSession::oddNumber(const char* p, const char* end, bool& bad) {
  const Number number = scanNumber(p, end);
  if (number.status == NumberStatus::NotANumber) return nullptr;
  const std::string_view text(p, static_cast<size_t>(std::min<ptrdiff_t>(number.end - p, 40)));
  if (number.status == NumberStatus::Malformed) {
    error(RiError::SyntaxError, p, fmt::format("\"{}\" is not a number", text), "malformed number");
    bad = true;
  } else if (number.status == NumberStatus::NotFinite) {
    error(RiError::Range, p, fmt::format("\"{}\" is not a finite number", text), "number not finite");
    bad = true;
  } else {
    if (number.status == NumberStatus::TooLarge && !quiet()) {
      errors().report(Severity::Warning, RiError::Range, locate(p),
                      fmt::format("{}: {} is too large for a float; {} is used", name_, text, number.value),
                      "number too large");
    }
    pool_.floats.push(number.value);
  }
  return number.end;
}

// 0200+4d+w: integer of w+1 bytes, sign-extended, d of them behind the point. 0244: float32, 0245: float64.
const char* ParseSession::binaryNumber(const char* p, const char* end, double& value) {
  const unsigned c = byte(p);
  const auto left = static_cast<size_t>(end - p) - 1;
  if (c < kShortString) {
    const unsigned bytes = (c & 3) + 1, fraction = (c - kInteger) >> 2;
    if (left < bytes) return truncated(p, "number", end);
    const unsigned shift = 64 - 8 * bytes;
    const auto integer = static_cast<int64_t>(bigEndian(p + 1, bytes) << shift) >> shift;
    value = static_cast<double>(integer) / static_cast<double>(uint64_t{1} << (8 * fraction));
    return p + 1 + bytes;
  }
  if (c == kFloat32) {
    if (left < 4) return truncated(p, "number", end);
    value = static_cast<double>(bigEndianFloat(p + 1));
    return p + 5;
  }
  if (c == kFloat64) {
    if (left < 8) return truncated(p, "number", end);
    value = std::bit_cast<double>(bigEndian(p + 1, 8));
    return p + 9;
  }
  return nullptr;
}

const char* ParseSession::floatArray(const char* p, const char* end) {
  const unsigned c = byte(p);
  if (c < kFloatArray || c >= kDefineRequest) return nullptr;
  const unsigned lengthBytes = c - kFloatArray + 1;
  const auto left = static_cast<size_t>(end - p) - 1;
  if (left < lengthBytes) return truncated(p, "array", end);
  const auto count = static_cast<size_t>(bigEndian(p + 1, lengthBytes));
  if ((left - lengthBytes) / 4 < count) return truncated(p, "array", end);

  const char* const data = p + 1 + lengthBytes;
  const size_t first = pool_.floats.size();
  float* const out = pool_.floats.extend(count);
  bool finite = true;
  for (size_t i = 0; i < count; ++i) {
    uint32_t bits;
    std::memcpy(&bits, data + 4 * i, 4);
    out[i] = std::bit_cast<float>(__builtin_bswap32(bits));
    finite &= isFinite(out[i]);
  }
  if (!finite) error(RiError::Range, p, "binary array with a number that is not finite");
  const char* const next = data + 4 * count;
  const bool outer = inArray_;
  if (!outer) beginArray(p + 1);
  addNumbers(first, p, next, !finite);
  if (!outer) endArray(next, true);
  return next;
}

const char* ParseSession::string(const char* p, const char* end) {
  std::string_view text;
  const char* const next = *p == '"' ? quotedString(p, end, text) : binaryString(p, end, text);
  if (next) addString(text, p, next);
  return next;
}

const char* ParseSession::quotedString(const char* p, const char* end, std::string_view& text) {
  // Find the end; most strings have no escapes and are viewed where they are.
  const char* const begin = p + 1;
  const char* q = begin;
  bool escapes = false;
  while (q != end && *q != '"') {
    if (*q == '\\') {
      escapes = true;
      if (++q == end) break;
    }
    ++q;
  }
  if (q == end) {
    fatal(RiError::SyntaxError, p, "unterminated string, begun here");
    return end;
  }
  text = {begin, static_cast<size_t>(q - begin)};
  if (!escapes) return q + 1;

  char* const buffer = pool_.text(text.size());
  char* out = buffer;
  for (const char* s = begin; s != q; ++s) {
    if (*s != '\\') {
      *out++ = *s;
      continue;
    }
    ++s;
    switch (*s) {
      case 'n':
        *out++ = '\n';
        break;
      case 'r':
        *out++ = '\r';
        break;
      case 't':
        *out++ = '\t';
        break;
      case 'b':
        *out++ = '\b';
        break;
      case 'f':
        *out++ = '\f';
        break;
      case '\n':
        break;  // a continued line
      case '\r':
        if (s + 1 != q && s[1] == '\n') ++s;
        break;
      default:
        if (*s < '0' || *s > '7') {
          *out++ = *s;
          break;
        }
        unsigned code = static_cast<unsigned>(*s - '0');
        for (int i = 0; i < 2 && s + 1 != q && s[1] >= '0' && s[1] <= '7'; ++i) {
          code = code * 8 + static_cast<unsigned>(*++s - '0');
        }
        *out++ = static_cast<char>(code);
    }
  }
  text = {buffer, static_cast<size_t>(out - buffer)};
  return q + 1;
}

// 0220+n: n < 16 bytes. 0240+w: length in w+1 bytes. 0317+w: a defined string, its code in w+1 bytes.
const char* ParseSession::binaryString(const char* p, const char* end, std::string_view& text) {
  const unsigned c = byte(p);
  const auto left = static_cast<size_t>(end - p) - 1;
  if (c == kDefinedString || c == kDefinedString + 1) {
    const unsigned bytes = c - kDefinedString + 1;
    if (left < bytes) return truncated(p, "string code", end);
    const auto code = static_cast<uint32_t>(bigEndian(p + 1, bytes));
    const auto found = tables_ ? tables_->strings.find(code) : decltype(tables_->strings.find(code)){};
    if (tables_ && found != tables_->strings.end()) {
      text = *found->second;
    } else {
      fatal(RiError::BadStringToken, p, fmt::format("string code {} is not defined", code));
    }
    return p + 1 + bytes;
  }
  size_t length = c - kShortString, header = 1;
  if (c >= kString && c < kFloat32) {
    const unsigned bytes = c - kString + 1;
    if (left < bytes) return truncated(p, "string", end);
    length = static_cast<size_t>(bigEndian(p + 1, bytes));
    header += bytes;
  } else if (c < kShortString || c >= kString) {
    return nullptr;
  }
  if (static_cast<size_t>(end - p) - header < length) return truncated(p, "string", end);
  text = {p + header, length};
  return p + header + length;
}

const char* ParseSession::strayWord(const char* p, const char* end) {
  if (!isLetter(*p)) return nullptr;
  const char* q = p;
  while (q != end && (isLetter(*q) || isDigit(*q))) ++q;
  const std::string_view text(p, static_cast<size_t>(q - p));
  if (findRibRequest(text)) return nullptr;  // the array was not closed
  error(RiError::SyntaxError, p,
        fmt::format("word {} in an array (strings are written in quotes)", text.substr(0, 40)),
        "word in an array");
  spoilArray();
  return q;
}

const char* ParseSession::strayByte(const char* p, const char* end) {
  const unsigned c = byte(p);
  if (isLetter(*p) || c == kRequest || (c == ']' && inArray_) || c == '[') return nullptr;
  if (c >= 0200) {
    error(RiError::BadRipCode, p, fmt::format("byte 0{:o} begins no token", c), "reserved byte");
  } else if (c == ']') {
    error(RiError::SyntaxError, p, "']' without '['");
  } else {
    error(RiError::SyntaxError, p, fmt::format("unexpected '{}'", static_cast<char>(c)));
  }
  if (inArray_) {
    spoilArray();
  } else {
    failed_ = true;
  }
  ++p;
  // The rest of the word goes with it.
  if (c < 0200 && c != ']') {
    while (p != end && !isDelimiter(*p)) ++p;
  }
  return p;
}

const char* ParseSession::truncated(const char* p, std::string_view what, const char* end) {
  fatal(RiError::SyntaxError, p, fmt::format("the input ends within a binary {}", what));
  return end;
}

}  // namespace patina
