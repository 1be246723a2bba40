// SPDX-License-Identifier: Apache-2.0
// Takes typed arguments, one after another, from the values of a request.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "rib/handler.h"
#include "rib/session.h"

namespace patina {

// Numbers may stand bare or in brackets, in any grouping ("1 2 3", "[1 2 3]", "[1] 2 3"), and so may strings.
// The first argument that does not fit is reported and spoils the request: ok() turns false, and whatever is
// taken then is empty.
class Arguments {
 public:
  explicit Arguments(ParseSession& session)
      : session_(session),
        pool_(session.pool()),
        ok_(!session.failed() || session.request()->usage.empty()) {}

  float number();
  int integer();
  bool boolean() { return integer() != 0; }
  std::string_view string();
  Floats floats();  // an array, or all the bare numbers that follow
  Ints ints();
  Strings strings();  // an array, or one bare string
  Handle handle();    // an integer or a string
  Handle optionalHandle();
  template <size_t N>
  std::array<float, N> numbers() {
    std::array<float, N> result;
    for (float& value : result) value = number();
    return result;
  }
  const ParamList& params();  // all the rest

  bool ok() const { return ok_; }
  bool more() const { return index_ < pool_.values.size(); }
  bool nextIsNumber() const { return more() && pool_.values[index_].kind == Value::Kind::Number; }
  bool nextIsArray() const { return more() && pool_.values[index_].array; }

  // To be asked once when everything is taken. False: the request must not be carried out.
  bool finish();
  // Reports the request as wrong.
  void fail(RiError code, std::string_view message);
  // Reports something of no consequence, once per message.
  void warn(RiError code, const Location& at, std::string_view message);

  ParseSession& session() { return session_; }
  RibHandler& handler() { return session_.handler(); }
  const Location& at() const { return session_.at(); }

 private:
  const Value* next(std::string_view expected, Value::Kind kind);
  const Value* whole(std::string_view expected, Value::Kind kind);
  void unexpected(std::string_view expected);
  void failAt(RiError code, const Value& value, std::string_view message);
  std::optional<Ints> toInts(size_t first, size_t count);
  void advance(const Value& value, size_t by);
  std::string_view text(size_t value) const { return pool_.strings[pool_.values[value].first]; }
  bool isBareString(size_t value) const;
  size_t addParam(size_t token);
  Declaration guess(std::string_view name, const Value& value, const Location& at);

  ParseSession& session_;
  ValuePool& pool_;
  size_t index_ = 0;   // of the value under way
  size_t offset_ = 0;  // of its elements, those that are taken
  bool ok_;
  std::string_view firstString_;
  ParamList params_;
};

}  // namespace patina
