// SPDX-License-Identifier: Apache-2.0
// The little language of IfBegin: "$user:pass == 'beauty' && !defined(user:fast)".
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace patina {

/// The value of a variable named without its "$" ("user:pass", "Frame"), or nullopt when it is not set.
using ConditionVariables = std::function<std::optional<std::string>(std::string_view name)>;

/// Words, quoted strings, numbers, $name or ${name}, defined(name), == != < <= > >= (numbers compare as
/// such), =~ (the right side occurs in the left; "*" at either end is dropped), && || ! and parentheses. A
/// lone value is true unless it is empty, "0" or unset. nullopt: not an expression.
std::optional<bool> evaluateCondition(std::string_view text, const ConditionVariables& variables);

}  // namespace patina
