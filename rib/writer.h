// SPDX-License-Identifier: Apache-2.0
// Writes requests as RIB, ASCII or binary. What it wrote reads as the same requests with the same bits.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <string_view>
#include <unordered_map>

#include "rib/every_request.h"
#include "rib/params.h"

namespace patina {

enum class RibEncoding : uint8_t {
  Ascii,  ///< one request a line, indented by blocks
  Binary  ///< the tokens of RI 3.2 appendix C.2: float arrays as they are in memory, big-endian
};

struct RibWriterSettings {
  RibEncoding encoding = RibEncoding::Ascii;
  bool comments = true;    ///< keep "#" comments
  bool structure = true;   ///< keep "##" comments
  int indent = 2;          ///< blanks per block
  size_t lineWidth = 110;  ///< ASCII: arrays are broken so that lines stay within it, where that can be
};

/// A handler that writes whatever it is given. Parameters whose type the reader would know otherwise
/// (predeclared, declared by Declare, or guessed from the values) are written by name, others with their
/// type. One thread.
class RibWriter : public EveryRequest<RibWriter> {
 public:
  /// Takes a piece of the text; false: it cannot be written, and nothing more is asked of it.
  using Sink = std::function<bool(std::string_view)>;

  explicit RibWriter(Sink sink, const RibWriterSettings& settings = {});
  ~RibWriter() override;  // flushes

  bool wantsComments() const override { return settings_.comments; }
  void comment(std::string_view text, const Location& at) override;
  void structure(std::string_view text, const Location& at) override;
  void declare(std::string_view name, std::string_view declaration, const Location& at) override;

  template <typename... A>
  void each(std::string_view request, const Location&, const A&... arguments) {
    begin(request);
    (put(arguments), ...);
    end(request);
  }

  /// Hands what is left to the sink. False: some of it could not be written.
  bool flush();

 private:
  void begin(std::string_view request);
  void end(std::string_view request);
  void put(float value);
  void put(int value);
  void put(bool value) { put(value ? 1 : 0); }
  void put(std::string_view value);
  void put(const Handle& value);
  void put(Floats values);
  void put(Ints values);
  void put(Strings values);
  void put(const RibBasis& value);
  void put(const SubdivisionTags& value);
  void put(const ParamList& params);
  template <size_t N>
  void put(const std::array<float, N>& values) {
    put(Floats(values));
  }
  template <size_t N>
  void put(const std::array<std::string_view, N>& values) {
    for (const std::string_view value : values) put(value);
  }

  void space(size_t length);
  template <typename Number>
  void asciiNumber(Number value);
  void openArray();
  void closeArray();
  void binaryInteger(int value);
  void binaryFloat(float value);
  void binaryString(std::string_view value);
  void binaryFloatArray(const float* values, const int* ints, size_t count);
  void bigEndian(uint64_t value, unsigned bytes);
  void newLine();
  void drain();

  Sink sink_;
  RibWriterSettings settings_;
  bool binary_;
  bool failed_ = false;
  std::string out_;
  size_t lineBegin_ = 0;  // in out_: of the line under way
  bool first_ = false;    // nothing stands between here and the bracket
  int depth_ = 0;
  Dictionary dictionary_;

  // What the binary output has defined.
  struct Hash {
    using is_transparent = void;
    size_t operator()(std::string_view s) const { return std::hash<std::string_view>{}(s); }
  };
  template <typename T>
  using ByText = std::unordered_map<std::string, T, Hash, std::equal_to<>>;
  ByText<int> requestCodes_, stringCodes_;  // -1: seen once, not defined
  int nextRequest_ = 0, nextString_ = 0;
};

}  // namespace patina
