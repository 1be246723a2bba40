// SPDX-License-Identifier: Apache-2.0
// Conditions of IfBegin by recursive descent.
#include "renderer/scene/condition.h"

#include <array>
#include <charconv>

namespace patina {
namespace {

bool isNameCharacter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == ':' ||
         c == '.' || c == '-' || c == '+';
}

std::optional<double> numberOf(std::string_view text) {
  double value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

bool truthOf(std::string_view value) {
  const auto number = numberOf(value);
  return number ? *number != 0 : !value.empty();
}

class Evaluator {
 public:
  Evaluator(std::string_view text, const ConditionVariables& variables)
      : rest_(text), variables_(variables) {}

  std::optional<bool> run() {
    const bool value = either();
    skipBlanks();
    if (failed_ || !rest_.empty()) return std::nullopt;
    return value;
  }

 private:
  static constexpr int kDeepest = 100;

  void skipBlanks() {
    while (!rest_.empty() && (rest_.front() == ' ' || rest_.front() == '\t' || rest_.front() == '\n'))
      rest_.remove_prefix(1);
  }
  bool take(std::string_view token) {
    skipBlanks();
    if (!rest_.starts_with(token)) return false;
    rest_.remove_prefix(token.size());
    return true;
  }
  std::string_view takeName() {
    size_t length = 0;
    while (length < rest_.size() && isNameCharacter(rest_[length])) ++length;
    const std::string_view name = rest_.substr(0, length);
    rest_.remove_prefix(length);
    failed_ |= name.empty();
    return name;
  }

  bool either() {
    bool value = both();
    while (!failed_ && take("||")) value = both() || value;
    return value;
  }
  bool both() {
    bool value = negated();
    while (!failed_ && take("&&")) value = negated() && value;
    return value;
  }
  bool negated() {
    bool odd = false;
    skipBlanks();
    while (rest_.starts_with('!') && !rest_.starts_with("!=")) {
      rest_.remove_prefix(1);
      odd = !odd;
      skipBlanks();
    }
    return comparison() != odd;
  }
  bool comparison() {
    if (failed_ || depth_ > kDeepest) return failed_ = true;
    if (take("(")) {
      ++depth_;
      const bool value = either();
      --depth_;
      failed_ |= !take(")");
      return value;
    }
    const std::string left = operand();
    for (const std::string_view sign : {"==", "!=", "<=", ">=", "=~", "<", ">"}) {
      if (failed_ || !take(sign)) continue;
      return compare(left, sign, operand());
    }
    return truthOf(left);
  }
  static bool compare(const std::string& left, std::string_view sign, const std::string& right) {
    if (sign == "=~") {
      std::string_view part = right;
      while (part.starts_with('*') || part.starts_with('.')) part.remove_prefix(1);
      while (part.ends_with('*') || part.ends_with('.')) part.remove_suffix(1);
      return left.find(part) != std::string::npos;
    }
    const auto a = numberOf(left), b = numberOf(right);
    const int order = a && b ? (*a > *b) - (*a < *b) : left.compare(right);
    if (sign == "==") return order == 0;
    if (sign == "!=") return order != 0;
    if (sign == "<=") return order <= 0;
    if (sign == ">=") return order >= 0;
    return sign == "<" ? order < 0 : order > 0;
  }
  std::string operand() {
    skipBlanks();
    if (rest_.empty()) return failed_ = true, "";
    if (rest_.front() == '\'' || rest_.front() == '"') {
      const size_t end = rest_.find(rest_.front(), 1);
      if (end == std::string_view::npos) return failed_ = true, "";
      const std::string text(rest_.substr(1, end - 1));
      rest_.remove_prefix(end + 1);
      return text;
    }
    if (take("$")) {
      const bool braces = take("{");
      const std::string_view name = takeName();
      if (braces) failed_ |= !take("}");
      return variables_(name).value_or("");
    }
    const std::string_view word = takeName();
    if (word == "defined" && take("(")) {
      take("$");
      skipBlanks();
      const bool defined = variables_(takeName()).has_value();
      failed_ |= !take(")");
      return defined ? "1" : "0";
    }
    return std::string(word);
  }

  std::string_view rest_;
  const ConditionVariables& variables_;
  int depth_ = 0;
  bool failed_ = false;
};

}  // namespace

std::optional<bool> evaluateCondition(std::string_view text, const ConditionVariables& variables) {
  return Evaluator(text, variables).run();
}

}  // namespace patina
