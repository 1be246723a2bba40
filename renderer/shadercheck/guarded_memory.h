// SPDX-License-Identifier: Apache-2.0
// Planes with guard zones around them, which tell afterwards whether anybody wrote where nothing was asked
// for.
#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <span>
#include <string>
#include <vector>

namespace patina::shadercheck {

/// [one thread] Pointers stay valid as long as it lives. Planes are 64-byte aligned; what lies before and
/// behind them is a NaN, so that reading it shows too.
class GuardedMemory {
 public:
  /// A plane that is only read.
  const float* input(std::span<const float> values, std::string name);
  /// A plane to be written, `size` floats; not initialised.
  float* output(size_t size, std::string name);

  struct Damage {
    std::string what;   ///< "wrote behind the end of reflectance.x"; empty = nothing was touched but outputs
    std::string where;  ///< "index 48 of a plane of 48"
  };
  Damage findDamage() const;

 private:
  struct Free {
    void operator()(float* p) const { ::operator delete[](p, std::align_val_t{64}); }
  };
  struct Block {
    std::unique_ptr<float[], Free> data;
    size_t size;
    std::vector<float> original;  // of inputs
    std::string name;
  };
  Block& add(size_t size, std::string name);

  std::vector<Block> blocks_;
};

}  // namespace patina::shadercheck
