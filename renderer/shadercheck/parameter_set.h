// SPDX-License-Identifier: Apache-2.0
// Values for all parameters of a shader: defaults, the ends of each range, and some drawn within them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "patina/shader.h"

namespace patina::shadercheck {

/// Ends of what is tried for a parameter. A range without an end is cut where pictures are still sensible.
struct TriedRange {
  double low, high;
};
TriedRange triedRange(const PatinaParameter& parameter);

/// A number of the parameter's range, by `hash`.
float drawWithin(const PatinaParameter& parameter, uint64_t hash);

/// Owns the values that `prepare` and batches are given, all uniform. Movable, not copied: values point
/// inside.
class ParameterSet {
 public:
  explicit ParameterSet(const PatinaShader& shader);
  ParameterSet(ParameterSet&&) = default;
  ParameterSet& operator=(ParameterSet&&) = default;

  /// Every component of the parameter.
  void setNumbers(uint32_t parameter, double value);
  void setText(uint32_t parameter, const char* text);  ///< `text` outlives the set
  void setRandom(uint64_t seed);
  /// What messages call it: "defaults", "Kd = 1" ...
  void setName(std::string name) { name_ = std::move(name); }

  const std::string& name() const { return name_; }
  std::span<const PatinaValue> values() const { return values_; }

 private:
  void point(uint32_t parameter);

  const PatinaShader* shader_;
  std::string name_ = "defaults";
  std::vector<PatinaValue> values_;
  std::vector<std::vector<float>> floats_;  // by parameter, as the others
  std::vector<std::vector<int32_t>> ints_;
  std::vector<std::vector<const char*>> strings_;
};

/// A string that the checker's host takes for a texture.
inline constexpr const char* kTextureName = "checker.tx";

/// Defaults; each parameter by itself at both ends of its range, strings as "" and kTextureName; and `random`
/// sets drawn.
std::vector<ParameterSet> makeParameterSets(const PatinaShader& shader, uint32_t random);

}  // namespace patina::shadercheck
