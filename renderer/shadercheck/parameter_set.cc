// SPDX-License-Identifier: Apache-2.0
// Parameters at their defaults, at the ends of their ranges, and drawn.
#include "renderer/shadercheck/parameter_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "renderer/base/sampling.h"
#include "renderer/shading/plugin_file.h"
#include "renderer/shading/shader_argument.h"

namespace patina::shadercheck {
namespace {

constexpr double kEndless = 1e30;  // what the SDK and the listing take for no end

}  // namespace

TriedRange triedRange(const PatinaParameter& parameter) {
  if (parameter.minimum > parameter.maximum) return {0, 4};
  const double low =
      parameter.minimum <= -kEndless ? std::min(-1000.0, parameter.maximum) : parameter.minimum;
  const double high = parameter.maximum >= kEndless ? std::max(1000.0, low) : parameter.maximum;
  return {low, high};
}

float drawWithin(const PatinaParameter& parameter, uint64_t hash) {
  TriedRange range = triedRange(parameter);
  if (parameter.minimum > parameter.maximum) range.low = -range.high;
  if (parameter.maximum >= kEndless) range.high = std::min(range.high, std::max(range.low, 0.0) + 4);
  const double x = toUnit(static_cast<uint32_t>(hash >> 32));
  if (parameter.type == PATINA_INT)
    return static_cast<float>(std::min(std::floor(range.low + (range.high - range.low + 1) * x), range.high));
  return static_cast<float>(range.low + (range.high - range.low) * x);
}

ParameterSet::ParameterSet(const PatinaShader& shader)
    : shader_(&shader),
      values_(shader.parameter_count),
      floats_(shader.parameter_count),
      ints_(shader.parameter_count),
      strings_(shader.parameter_count) {
  for (uint32_t i = 0; i < shader.parameter_count; ++i) {
    const PatinaParameter& p = parameterOf(shader, i);
    const uint32_t count = valueCountOf(p);
    if (p.type == PATINA_STRING)
      strings_[i].assign(p.default_strings, p.default_strings + count);
    else if (p.type == PATINA_INT)
      ints_[i].assign(p.default_ints, p.default_ints + count);
    else
      floats_[i].assign(p.default_floats, p.default_floats + count);
    point(i);
  }
}

void ParameterSet::point(uint32_t i) {
  PatinaValue& value = values_[i];
  value.floats = floats_[i].empty() ? nullptr : floats_[i].data();
  value.ints = ints_[i].empty() ? nullptr : ints_[i].data();
  value.strings = strings_[i].empty() ? nullptr : strings_[i].data();
  value.plane = 1;
  value.count = valueCountOf(parameterOf(*shader_, i));
}

void ParameterSet::setNumbers(uint32_t i, double number) {
  std::fill(floats_[i].begin(), floats_[i].end(), static_cast<float>(number));
  std::fill(ints_[i].begin(), ints_[i].end(), static_cast<int32_t>(number));
  values_[i].is_set = 1;
}

void ParameterSet::setText(uint32_t i, const char* text) {
  std::fill(strings_[i].begin(), strings_[i].end(), text);
  values_[i].is_set = 1;
}

void ParameterSet::setRandom(uint64_t seed) {
  for (uint32_t i = 0; i < shader_->parameter_count; ++i) {
    const PatinaParameter& p = parameterOf(*shader_, i);
    uint64_t k = 0;
    for (float& number : floats_[i]) number = drawWithin(p, hashOf(seed, i, k++));
    for (int32_t& number : ints_[i]) number = static_cast<int32_t>(drawWithin(p, hashOf(seed, i, k++)));
    for (const char*& text : strings_[i]) text = hashOf(seed, i, k++) & 1 ? kTextureName : "";
    values_[i].is_set = 1;
  }
}

std::vector<ParameterSet> makeParameterSets(const PatinaShader& shader, uint32_t random) {
  std::vector<ParameterSet> sets;
  sets.emplace_back(shader);
  const auto add = [&](uint32_t i, const auto& change, std::string name) {
    ParameterSet set(shader);
    change(set, i);
    set.setName(std::move(name));
    sets.push_back(std::move(set));
  };
  for (uint32_t i = 0; i < shader.parameter_count; ++i) {
    const PatinaParameter& p = parameterOf(shader, i);
    if (p.type == PATINA_STRING) {
      for (const char* text : {"", kTextureName})
        add(
            i, [&](ParameterSet& set, uint32_t k) { set.setText(k, text); },
            fmt::format("{} = \"{}\"", p.name, text));
    } else if (p.type != PATINA_MATRIX) {  // of which not every one makes sense
      const TriedRange range = triedRange(p);
      for (const double number : {range.low, range.high})
        add(
            i, [&](ParameterSet& set, uint32_t k) { set.setNumbers(k, number); },
            fmt::format("{} = {:g}", p.name, number));
    }
  }
  for (uint32_t k = 0; shader.parameter_count > 0 && k < random; ++k) {
    ParameterSet set(shader);
    set.setRandom(hashOf(0x7a11u, k));
    set.setName(fmt::format("random parameters {}", k));
    sets.push_back(std::move(set));
  }
  return sets;
}

}  // namespace patina::shadercheck
