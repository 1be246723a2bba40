// SPDX-License-Identifier: Apache-2.0
// A lobe whose formulas are a plugin's: calls it for one direction at a time, and lets nothing out that a
// renderer cannot use.
#pragma once

#include <string>

#include "patina/shader.h"
#include "renderer/base/math.h"
#include "renderer/shading/shading_point.h"

namespace patina {

class ShaderInstance;

/// Of one shader instance, which outlives it. [any thread]
class CustomLobe {
 public:
  CustomLobe(const PatinaCustomLobe& table, const ShaderInstance& shader)
      : table_(&table), shader_(&shader) {}

  const char* name() const { return table_->name; }
  uint32_t dataCount() const { return table_->data_count; }
  bool reflects() const { return (table_->flags & PATINA_LOBE_REFLECTS) != 0; }
  bool transmits() const { return (table_->flags & PATINA_LOBE_TRANSMITS) != 0; }

  /// A point that has the lobe. World space; `wo` is to the viewer, on the side of N.
  struct At {
    const CustomLobeLane& lane;
    V3f N, wo;
    float alpha, eta;
    V3f P;  ///< for messages
  };
  struct Value {
    Rgb f{0, 0, 0};  ///< times |wi . N|, sr^-1
    float pdf = 0;   ///< sr^-1
  };
  /// Black where the plugin gives what is not finite, negative or too large, which is counted.
  Value evaluate(const At& at, const V3f& wi) const;
  /// A direction of unit length; false = none.
  bool sample(const At& at, const V2f& random, V3f& wi) const;

 private:
  void complain(const At& at, const char* what) const;

  const PatinaCustomLobe* table_;
  const ShaderInstance* shader_;
};

/// Why a lobe cannot be used, as the rest of a sentence; empty = it can.
std::string findLobeFault(const PatinaCustomLobe* lobe);

}  // namespace patina
