// SPDX-License-Identifier: Apache-2.0
// Arguments and parameter lists out of a request's values.
#include "rib/arguments.h"

#include <charconv>
#include <cstring>
#include <new>

#include <fmt/format.h>

namespace patina {
namespace {

// How a value looks to the user, for "expected ..., found ...".
std::string describe(const Value& value, const ValuePool& pool) {
  if (value.kind == Value::Kind::Mixed) return "an array of numbers and strings";
  if (value.kind == Value::Kind::Empty) return "an empty array";
  const bool number = value.kind == Value::Kind::Number;
  if (value.array) return number ? "an array of numbers" : "an array of strings";
  if (!number) return fmt::format("\"{}\"", pool.strings[value.first].substr(0, 40));
  return value.count == 1 ? "a number" : fmt::format("{} numbers", value.count);
}

}  // namespace

void Arguments::fail(RiError code, std::string_view message) {
  if (ok_) session_.error(code, session_.nameBegin(), message);
  ok_ = false;
}

void Arguments::failAt(RiError code, const Value& value, std::string_view message) {
  if (ok_) session_.error(code, value.begin, message);
  ok_ = false;
}

void Arguments::warn(RiError code, const Location& at, std::string_view message) {
  const std::string text = fmt::format("{}: {}", session_.requestName(), message);
  session_.errors().reportOnce(Severity::Warning, code, at, text, text);
}

void Arguments::unexpected(std::string_view expected) {
  const std::string_view usage = session_.request()->usage;
  const auto message = [&](std::string_view found) {
    return fmt::format("expected {}, found {} (usage: {} {})", expected, found, session_.requestName(),
                       usage);
  };
  if (!more()) return fail(RiError::BadArgument, message("nothing more"));
  const Value& value = pool_.values[index_];
  const RiError code = value.kind == Value::Kind::Mixed ? RiError::BadArray : RiError::BadArgument;
  failAt(code, value, message(describe(value, pool_)));
}

inline const Value* Arguments::next(std::string_view expected, Value::Kind kind) {
  if (!ok_) return nullptr;
  if (more()) {
    const Value& value = pool_.values[index_];
    if (value.bad) return ok_ = false, nullptr;  // reported when it was read
    if (value.kind == kind && offset_ < value.count) return &value;
  }
  return unexpected(expected), nullptr;
}

inline void Arguments::advance(const Value& value, size_t by) {
  offset_ += by;
  if (offset_ < value.count) return;
  ++index_;
  offset_ = 0;
}

float Arguments::number() {
  const Value* value = next("a number", Value::Kind::Number);
  if (!value) return 0;
  const float result = pool_.floats.data()[value->first + offset_];
  advance(*value, 1);
  return result;
}

int Arguments::integer() {
  const Value* value = next("an integer", Value::Kind::Number);
  if (!value) return 0;
  const auto ints = toInts(value->first + offset_, 1);
  if (!ints) {
    failAt(RiError::BadArgument, *value, "expected an integer, found a fraction or a number beyond 32 bits");
    return 0;
  }
  advance(*value, 1);
  return ints->front();
}

std::string_view Arguments::string() {
  const Value* value = next("a string", Value::Kind::String);
  if (!value) return {};
  const std::string_view result = pool_.strings[value->first + offset_];
  if (firstString_.data() == nullptr) firstString_ = result;
  advance(*value, 1);
  return result;
}

// Numbers or strings that are left of the value under way; an empty array is one too.
const Value* Arguments::whole(std::string_view expected, Value::Kind kind) {
  if (ok_ && more() && offset_ == 0 && pool_.values[index_].kind == Value::Kind::Empty) {
    return &pool_.values[index_];
  }
  return next(expected, kind);
}

Floats Arguments::floats() {
  const Value* value = whole("an array of numbers", Value::Kind::Number);
  if (!value) return {};
  const Floats result = pool_.floats.view(value->first + offset_, value->count - offset_);
  advance(*value, result.size());
  return result;
}

Ints Arguments::ints() {
  const Value* value = whole("an array of integers", Value::Kind::Number);
  if (!value) return {};
  const auto result = toInts(value->first + offset_, value->count - offset_);
  if (!result) {
    failAt(RiError::BadArgument, *value, "expected integers, found a fraction or a number beyond 32 bits");
    return {};
  }
  advance(*value, result->size());
  return *result;
}

Strings Arguments::strings() {
  const Value* value = whole("an array of strings", Value::Kind::String);
  if (!value) return {};
  const Strings result{pool_.strings.data() + value->first + offset_, value->count - offset_};
  advance(*value, result.size());
  return result;
}

// The numbers become ints where they stand: both have four bytes, and each value is taken once.
std::optional<Ints> Arguments::toInts(size_t first, size_t count) {
  static_assert(sizeof(int) == sizeof(float));
  float* const data = pool_.floats.data() + first;
  constexpr float kLimit = 2147483648.0f;
  bool exact = true;
  for (size_t i = 0; i < count; ++i) {
    float f;
    std::memcpy(&f, data + i, sizeof f);
    const bool fits = f >= -kLimit && f < kLimit;
    const int n = static_cast<int>(fits ? f : 0.0f);
    exact &= fits && static_cast<float>(n) == f;
    new (data + i) int(n);
  }
  // Beyond 2^24 a float may be a rounded integer: the exact ones were kept aside.
  int* const ints = std::launder(reinterpret_cast<int*>(data));
  const auto& wide = pool_.wide;
  auto it = std::lower_bound(wide.begin(), wide.end(), first,
                             [](const ValuePool::WideInteger& w, size_t index) { return w.index < index; });
  if (it != wide.end() && it->index < first + count) {
    exact = true;
    for (; it != wide.end() && it->index < first + count; ++it) {
      const bool fits = it->value >= -2147483648.0 && it->value <= 2147483647.0;
      const int n = fits ? static_cast<int>(it->value) : 0;
      exact &= static_cast<double>(n) == it->value;
      ints[it->index - first] = n;
    }
  }
  if (!exact) return std::nullopt;
  return Ints{ints, count};
}

Handle Arguments::handle() {
  if (!nextIsNumber()) {
    const Value* value = next("a handle (an integer or a string)", Value::Kind::String);
    if (!value) return {};
    const std::string_view text = pool_.strings[value->first + offset_];
    advance(*value, 1);
    return {text};
  }
  const int number = integer();
  constexpr size_t kDigits = 12;
  char* const digits = pool_.text(kDigits);
  const char* const end = std::to_chars(digits, digits + kDigits, number).ptr;
  return {ok_ ? std::string_view(digits, static_cast<size_t>(end - digits)) : std::string_view()};
}

// Many files leave handles out. A number is one; so is a string that is no parameter's name: it has no value
// behind it, or is followed by a name that has one.
Handle Arguments::optionalHandle() {
  if (!ok_ || !more()) return {};
  if (nextIsNumber()) return handle();
  if (!isBareString(index_)) return {};
  const bool nameOfNext =
      isBareString(index_ + 1) && index_ + 2 < pool_.values.size() && !isBareString(index_ + 2);
  const auto known = session_.dictionary().find(text(index_));
  const bool typed = known && (known->type == ValueType::String || known->reference);
  if (index_ + 1 == pool_.values.size() || nameOfNext || (isBareString(index_ + 1) && !typed))
    return handle();
  return {};
}

bool Arguments::isBareString(size_t value) const {
  return value < pool_.values.size() && pool_.values[value].kind == Value::Kind::String &&
         !pool_.values[value].array;
}

bool Arguments::finish() {
  if (!ok_) return false;
  if (!more()) return true;
  const RibRequest& request = *session_.request();
  const Value& value = pool_.values[index_];
  if (value.bad) return request.usage.empty();
  if (request.usage.empty()) {
    warn(RiError::BadArgument, session_.locate(value.begin),
         fmt::format("{} behind a request without arguments is ignored", describe(value, pool_)));
    return true;
  }
  size_t numbers = 0;
  for (const Value& v : pool_.values) numbers += v.kind == Value::Kind::Number ? v.count : 0;
  const bool matrix =
      numbers == 16 && (request.name == "Translate" || request.name == "Scale" || request.name == "Rotate");
  failAt(RiError::BadArgument, value,
         fmt::format("more arguments than expected{} (usage: {} {})",
                     matrix ? ", 16 numbers in all: is ConcatTransform meant?" : "", request.name,
                     request.usage));
  return false;
}

const ParamList& Arguments::params() {
  if (!ok_) return params_;
  if (offset_ > 0) {  // some of the numbers before the parameters were not asked for
    finish();
    return params_;
  }
  while (more()) {
    if (isBareString(index_)) {
      index_ = addParam(index_);
      continue;
    }
    const Value& value = pool_.values[index_++];
    if (!value.bad) {
      warn(RiError::BadParamList, session_.locate(value.begin),
           fmt::format("{} where a parameter's name is expected is ignored", describe(value, pool_)));
    }
  }
  params_ = ParamList(pool_.params);
  return params_;
}

// The parameter whose name is the value at `token`; returns the index behind its value. What cannot be used
// is reported and left out.
size_t Arguments::addParam(size_t token) {
  const std::string_view name = text(token);
  const Location at = session_.locate(pool_.values[token].begin);
  auto declaration = session_.dictionary().find(name);
  const bool badDeclaration = !declaration && name.find_first_of(" \t\n\r") != std::string_view::npos;
  if (!declaration && !badDeclaration) {
    declaration = handler().declarationOf(session_.requestName(), firstString_, name);
    if (declaration) declaration->name = name;
  }

  // Which value is it, if any? A bare string may be the value or the next parameter's name.
  const size_t next = token + 1;
  bool hasValue = next < pool_.values.size();
  if (hasValue && isBareString(next)) {
    const bool isName = next + 1 < pool_.values.size() && !isBareString(next + 1);
    hasValue = declaration ? declaration->type == ValueType::String || declaration->reference : !isName;
  }
  if (!hasValue) {
    warn(RiError::BadParamList, at, fmt::format("parameter \"{}\" has no value and is ignored", name));
    return next;
  }
  const Value& value = pool_.values[next];
  if (value.bad) return next + 1;
  if (!declaration && session_.dictionary().refused(name)) return next + 1;  // reported at its Declare
  if (badDeclaration) {
    warn(RiError::BadToken, at, fmt::format("\"{}\" is not a declaration; the parameter is ignored", name));
    return next + 1;
  }
  if (value.kind == Value::Kind::Mixed) {
    warn(RiError::BadArray, at,
         fmt::format("the value of parameter \"{}\" mixes numbers and strings and is ignored", name));
    return next + 1;
  }
  if (!declaration) declaration = guess(name, value, at);

  Param param{*declaration, {}, {}, {}, at};
  const bool wantsStrings = declaration->reference || declaration->type == ValueType::String;
  const bool fits = value.kind == Value::Kind::Empty || wantsStrings == (value.kind == Value::Kind::String);
  bool integral = true;
  if (fits && wantsStrings) {
    param.strings = {pool_.strings.data() + value.first, value.count};
  } else if (fits && declaration->type == ValueType::Integer && value.kind == Value::Kind::Number) {
    const auto ints = toInts(value.first, value.count);
    integral = ints.has_value();
    if (ints) param.ints = *ints;
  } else if (fits) {
    param.floats = pool_.floats.view(value.first, value.count);
  }
  if (!fits || !integral) {
    warn(RiError::BadArgument, at,
         fmt::format("parameter \"{}\" is declared \"{}\" but its value is {}; it is ignored", name,
                     toString(*declaration), integral ? describe(value, pool_) : "not integral"));
    return next + 1;
  }
  pool_.params.push_back(param);
  return next + 1;
}

// The type of an undeclared parameter, after its value.
Declaration Arguments::guess(std::string_view name, const Value& value, const Location& at) {
  Declaration result;
  result.type = value.kind == Value::Kind::String ? ValueType::String : ValueType::Float;
  result.declared = false;
  result.name = name;
  const std::string_view request = session_.requestName();
  const std::string_view near =
      session_.firstTime(name) ? session_.dictionary().nearest(name) : std::string_view();
  const std::string hint = near.empty() ? std::string() : fmt::format(" (did you mean \"{}\"?)", near);
  // Options and attributes of other renderers are no one's mistake.
  const bool foreign = request == "Option" || request == "Attribute" || request == "Hider";
  session_.errors().reportOnce(foreign ? Severity::Info : Severity::Warning, RiError::BadToken, at,
                               fmt::format("undeclared {}", name),
                               fmt::format("{}: parameter \"{}\" is not declared{}; taken as {}", request,
                                           name, hint, patina::name(result.type)));
  return result;
}

}  // namespace patina
