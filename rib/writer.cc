// SPDX-License-Identifier: Apache-2.0
// The two encodings of RIB, from the writer's side.
#include "rib/writer.h"

#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include "rib/binary_codes.h"

namespace patina {
namespace {

using namespace binary_code;

constexpr size_t kPiece = size_t{1} << 20;  // bytes handed to the sink at a time
constexpr size_t kMostCodes = 65536;        // strings that binary RIB can define
constexpr size_t kDefinable = 255;          // bytes of a string that is worth it
constexpr int kExact = 1 << 24;             // up to here every integer is a float

bool opensBlock(std::string_view request) {
  return request.ends_with("Begin") || request == "ElseIf" || request == "Else";
}
bool closesBlock(std::string_view request) {
  return request.ends_with("End") || request == "ElseIf" || request == "Else";
}

unsigned bytesOf(uint64_t value) { return value < 256 ? 1 : value < 65536 ? 2 : value < 16777216 ? 3 : 4; }

/// Quoted, with the escapes of RI 3.2 for what must not stand in a string as it is.
void appendQuoted(std::string& out, std::string_view text) {
  out += '"';
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    switch (c) {
      case '"':
      case '\\':
        out += '\\';
        out += c;
        break;
      case '\n':
        out += "\\n";
        break;
      case '\r':
        out += "\\r";
        break;
      case '\t':
        out += "\\t";
        break;
      default:
        if (byte < ' ' || byte == 0177)
          out += fmt::format("\\{:03o}", byte);
        else
          out += c;
    }
  }
  out += '"';
}

}  // namespace

RibWriter::RibWriter(Sink sink, const RibWriterSettings& settings)
    : sink_(std::move(sink)), settings_(settings), binary_(settings.encoding == RibEncoding::Binary) {}

RibWriter::~RibWriter() { flush(); }

bool RibWriter::flush() {
  drain();
  return !failed_;
}

void RibWriter::drain() {
  if (!failed_ && !out_.empty()) failed_ = !sink_(out_);
  out_.clear();
  lineBegin_ = 0;
}

void RibWriter::newLine() {
  out_ += '\n';
  if (out_.size() >= kPiece) drain();
  lineBegin_ = out_.size();
}

void RibWriter::comment(std::string_view text, const Location&) {
  if (!settings_.comments) return;
  out_.append(static_cast<size_t>(settings_.indent * depth_), ' ').append("#").append(text);
  newLine();
}

void RibWriter::structure(std::string_view text, const Location&) {
  if (!settings_.structure) return;
  out_.append("##").append(text);
  newLine();
}

void RibWriter::declare(std::string_view name, std::string_view declaration, const Location& at) {
  dictionary_.declare(name, declaration);
  each("Declare", at, name, declaration);
}

// ---- Requests ---------------------------------------------------------------------------------------------

void RibWriter::begin(std::string_view request) {
  if (closesBlock(request) && depth_ > 0) --depth_;
  first_ = false;
  if (!binary_) {
    out_.append(static_cast<size_t>(settings_.indent * depth_), ' ').append(request);
    return;
  }
  // A request that comes again gets a code.
  const auto [found, isNew] = requestCodes_.emplace(request, -1);
  if (isNew) {
    out_.append(request) += ' ';
    return;
  }
  if (found->second < 0) {
    found->second = nextRequest_++;
    out_ += static_cast<char>(kDefineRequest);
    bigEndian(static_cast<uint64_t>(found->second), 1);
    binaryString(request);
  }
  out_ += static_cast<char>(kRequest);
  bigEndian(static_cast<uint64_t>(found->second), 1);
}

void RibWriter::end(std::string_view request) {
  if (opensBlock(request)) ++depth_;
  if (!binary_) return newLine();
  if (out_.size() >= kPiece) drain();
}

// ---- Values -----------------------------------------------------------------------------------------------

/// Before a value of that many bytes: a blank, or a new line that goes on with the request.
void RibWriter::space(size_t length) {
  if (out_.size() - lineBegin_ + length + 1 > settings_.lineWidth && out_.size() > lineBegin_) {
    newLine();
    out_.append(static_cast<size_t>(settings_.indent * (depth_ + 2)), ' ');
  } else if (!first_) {
    out_ += ' ';
  }
  first_ = false;
}

void RibWriter::openArray() {
  if (!binary_) space(1);
  out_ += '[';
  first_ = true;
}

void RibWriter::closeArray() {
  out_ += ']';
  first_ = false;
}

template <typename Number>
void RibWriter::asciiNumber(Number value) {
  char text[32];  // the shortest text that reads as the same bits
  const char* const last = std::to_chars(text, text + sizeof text, value).ptr;
  const auto length = static_cast<size_t>(last - text);
  space(length);
  out_.append(text, length);
}

void RibWriter::put(float value) {
  if (binary_)
    binaryFloat(value);
  else
    asciiNumber(value);
}

void RibWriter::put(int value) {
  if (binary_)
    binaryInteger(value);
  else
    asciiNumber(value);
}

void RibWriter::put(std::string_view value) {
  if (!binary_) {
    space(value.size() + 2);
    return appendQuoted(out_, value);
  }
  // A string that comes again is defined: then it takes two or three bytes.
  const auto found = stringCodes_.find(value);
  if (found == stringCodes_.end()) {
    if (value.size() > 2 && value.size() <= kDefinable && stringCodes_.size() < kMostCodes)
      stringCodes_.emplace(value, -1);
    return binaryString(value);
  }
  int& code = found->second;
  if (code < 0) {
    code = nextString_++;
    out_ += static_cast<char>(kDefineString + (code > 255 ? 1 : 0));
    bigEndian(static_cast<uint64_t>(code), code > 255 ? 2 : 1);
    binaryString(value);
  }
  out_ += static_cast<char>(kDefinedString + (code > 255 ? 1 : 0));
  bigEndian(static_cast<uint64_t>(code), code > 255 ? 2 : 1);
}

void RibWriter::put(const Handle& value) {
  if (!value.given()) return;
  int number = 0;
  const char* const last = value.text.data() + value.text.size();
  const auto read = std::from_chars(value.text.data(), last, number);
  if (read.ec == std::errc() && read.ptr == last && fmt::format_int(number).str() == value.text)
    put(number);
  else
    put(value.text);
}

void RibWriter::put(Floats values) {
  if (binary_ && !values.empty()) return binaryFloatArray(values.data(), nullptr, values.size());
  openArray();
  for (const float value : values) put(value);
  closeArray();
}

void RibWriter::put(Ints values) {
  bool exact = !values.empty();
  for (const int value : values) exact &= value >= -kExact && value <= kExact;
  if (binary_ && exact) return binaryFloatArray(nullptr, values.data(), values.size());
  openArray();
  for (const int value : values) put(value);
  closeArray();
}

void RibWriter::put(Strings values) {
  openArray();
  for (const std::string_view value : values) put(value);
  closeArray();
}

void RibWriter::put(const RibBasis& value) {
  if (value.name.empty())
    put(value.matrix);
  else
    put(value.name);
}

void RibWriter::put(const SubdivisionTags& tags) {
  put(tags.names);
  put(tags.counts);
  put(tags.ints);
  put(tags.floats);
  if (tags.countsPerTag == 3) put(tags.strings);
}

void RibWriter::put(const ParamList& params) {
  for (const Param& param : params) {
    const Declaration& d = param.declaration;
    const auto known = dictionary_.find(d.name);
    const bool byName =
        !d.declared || (known && known->storage == d.storage && known->type == d.type &&
                        known->arrayLength == d.arrayLength && known->reference == d.reference);
    put(byName ? d.name : std::string_view(toString(d)));
    if (!param.strings.empty())
      put(param.strings);
    else if (!param.ints.empty())
      put(param.ints);
    else
      put(param.floats);
  }
}

// ---- Binary tokens ----------------------------------------------------------------------------------------

void RibWriter::bigEndian(uint64_t value, unsigned bytes) {
  while (bytes-- > 0) out_ += static_cast<char>(value >> (8 * bytes) & 255);
}

void RibWriter::binaryInteger(int value) {
  const unsigned bytes = value >= -128 && value < 128           ? 1
                         : value >= -32768 && value < 32768     ? 2
                         : value >= -8388608 && value < 8388608 ? 3
                                                                : 4;
  out_ += static_cast<char>(kInteger + bytes - 1);
  bigEndian(static_cast<uint32_t>(value), bytes);
}

void RibWriter::binaryFloat(float value) {
  if (std::abs(value) <= static_cast<float>(kExact) && value == std::trunc(value) &&
      !(value == 0 && std::signbit(value)))
    return binaryInteger(static_cast<int>(value));
  out_ += static_cast<char>(kFloat32);
  bigEndian(std::bit_cast<uint32_t>(value), 4);
}

void RibWriter::binaryString(std::string_view value) {
  if (value.size() < 16) {
    out_ += static_cast<char>(kShortString + value.size());
  } else {
    const unsigned bytes = bytesOf(value.size());
    out_ += static_cast<char>(kString + bytes - 1);
    bigEndian(value.size(), bytes);
  }
  out_ += value;
}

void RibWriter::binaryFloatArray(const float* floats, const int* ints, size_t count) {
  const unsigned bytes = bytesOf(count);
  out_ += static_cast<char>(kFloatArray + bytes - 1);
  bigEndian(count, bytes);
  const size_t first = out_.size();
  out_.resize(first + 4 * count);
  for (size_t i = 0; i < count; ++i) {
    const auto value = floats ? floats[i] : static_cast<float>(ints[i]);
    const uint32_t bits = __builtin_bswap32(std::bit_cast<uint32_t>(value));
    std::memcpy(out_.data() + first + 4 * i, &bits, 4);
  }
}

}  // namespace patina
