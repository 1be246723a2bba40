// SPDX-License-Identifier: Apache-2.0
// Which arguments a shader takes, and the messages about those that it does not.
#include "renderer/shading/shader_argument.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderer/shading/plugin_file.h"
#include "rib/params.h"

namespace patina {
namespace {

std::string described(std::string_view type, size_t arrayLength) {
  return arrayLength ? fmt::format("{}[{}]", type, arrayLength) : std::string(type);
}

bool isTriple(uint32_t type) {
  return type == PATINA_COLOR || type == PATINA_POINT || type == PATINA_VECTOR || type == PATINA_NORMAL;
}

// Whether values of a RIB's type can stand for the parameter's: the same, an int for a float and the reverse,
// any triple for another, and plain floats (what an undeclared name is taken for) for everything made of
// floats.
bool converts(ValueType from, uint32_t to) {
  switch (from) {
    case ValueType::String:
      return to == PATINA_STRING;
    case ValueType::Integer:
      return to == PATINA_INT || to == PATINA_FLOAT;
    case ValueType::Float:
      return to != PATINA_STRING;
    case ValueType::Color:
    case ValueType::Point:
    case ValueType::Vector:
    case ValueType::Normal:
      return isTriple(to);
    case ValueType::HPoint:
      return to == PATINA_HPOINT;
    case ValueType::Matrix:
    case ValueType::MPoint:
      return to == PATINA_MATRIX;
  }
  return false;
}

std::string outOfRange(const PatinaParameter& parameter, double value) {
  if (parameter.minimum > parameter.maximum || (value >= parameter.minimum && value <= parameter.maximum))
    return {};
  return fmt::format("{:g} is outside of its range [{:g}, {:g}]", value, parameter.minimum,
                     parameter.maximum);
}

}  // namespace

uint32_t typeOf(ValueType type) {
  switch (type) {
    case ValueType::Float:
      return PATINA_FLOAT;
    case ValueType::Integer:
      return PATINA_INT;
    case ValueType::String:
      return PATINA_STRING;
    case ValueType::Color:
      return PATINA_COLOR;
    case ValueType::Point:
      return PATINA_POINT;
    case ValueType::Vector:
      return PATINA_VECTOR;
    case ValueType::Normal:
      return PATINA_NORMAL;
    case ValueType::HPoint:
      return PATINA_HPOINT;
    case ValueType::Matrix:
      return PATINA_MATRIX;
    case ValueType::MPoint:
      return 0;
  }
  return 0;
}

uint32_t valueCountOf(const PatinaParameter& parameter) {
  return componentsOf(parameter.type) * std::max(parameter.array_length, 1u);
}

int findParameter(const PatinaShader& shader, const ShaderArgument& argument, ErrorHandler& errors) {
  std::vector<std::string_view> names;
  for (uint32_t i = 0; i < shader.parameter_count; ++i) {
    names.emplace_back(parameterOf(shader, i).name);
    if (names.back() == argument.name) return static_cast<int>(i);
  }
  std::string text = fmt::format("shader \"{}\" has no parameter \"{}\"", shader.name, argument.name);
  if (const std::string_view near = nearestName(argument.name, names); !near.empty())
    text += fmt::format(" (did you mean \"{}\"?)", near);
  errors.report(Severity::Warning, RiError::BadToken, argument.where, text,
                fmt::format("{}.{}", shader.name, argument.name));
  return -1;
}

bool bindArgument(const PatinaShader& shader, const PatinaParameter& parameter,
                  const ShaderArgument& argument, const ArgumentSlot& slot, ErrorHandler& errors) {
  const std::string subject = fmt::format("parameter \"{}\" of shader \"{}\"", parameter.name, shader.name);
  const auto refuse = [&](RiError code, const std::string& text) {
    errors.report(Severity::Error, code, argument.where,
                  fmt::format("{} {}; its default is used", subject, text),
                  fmt::format("{}.{}", shader.name, parameter.name));
    return false;
  };

  if (!converts(argument.type, parameter.type))
    return refuse(RiError::BadParamList,
                  fmt::format("is {}, not {}", described(typeName(parameter.type), parameter.array_length),
                              described(name(argument.type), static_cast<size_t>(argument.arrayLength))));
  const bool isString = parameter.type == PATINA_STRING;
  const size_t given =
      isString ? argument.strings.size() : std::max(argument.floats.size(), argument.ints.size());
  const size_t wanted = valueCountOf(parameter);
  if (given != wanted)
    return refuse(RiError::BadArray, fmt::format("is {}: {} value{} expected, {} given",
                                                 described(typeName(parameter.type), parameter.array_length),
                                                 wanted, wanted == 1 ? " is" : "s are", given));
  if (isString) {
    slot.strings = argument.strings;
    return true;
  }

  // Numbers: finite, integral where the parameter is, and with a warning when they make no sense.
  std::vector<double> numbers(argument.floats.begin(), argument.floats.end());
  if (argument.floats.empty()) numbers.assign(argument.ints.begin(), argument.ints.end());
  std::string strange;
  for (const double value : numbers) {
    if (!std::isfinite(value)) return refuse(RiError::BadArgument, "is given a value that is not finite");
    const auto limit = static_cast<double>(std::numeric_limits<int32_t>::max());
    if (parameter.type == PATINA_INT && (value != std::trunc(value) || std::abs(value) > limit))
      return refuse(RiError::BadArgument, fmt::format("is int, and {:g} is none", value));
    if (strange.empty()) strange = outOfRange(parameter, value);
  }
  if (!strange.empty())
    errors.report(Severity::Warning, RiError::Range, argument.where, fmt::format("{}: {}", subject, strange),
                  fmt::format("{}.{}", shader.name, parameter.name));
  if (parameter.type == PATINA_INT)
    std::transform(numbers.begin(), numbers.end(), slot.ints.begin(),
                   [](double x) { return static_cast<int>(x); });
  else
    std::transform(numbers.begin(), numbers.end(), slot.floats.begin(), [](double x) { return float(x); });
  return true;
}

}  // namespace patina
