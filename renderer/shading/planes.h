// SPDX-License-Identifier: Apache-2.0
// Scratch planes for one batch: 64-byte aligned, padded to whole blocks of lanes, reused from batch to batch.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <vector>

#include "patina/shader.h"
#include "renderer/base/math.h"

namespace patina {

/// [one thread] Pointers stay valid until begin() is called again.
class Planes {
 public:
  /// `guarded`: with guard zones around what is taken from here on.
  void begin(size_t lanes, bool guarded = false) {
    padded_ = (lanes + PATINA_LANES - 1) / PATINA_LANES * PATINA_LANES;
    block_ = used_ = 0;
    isGuarded_ = guarded;
    zones_.clear();
  }
  size_t padded() const { return padded_; }

  /// Where somebody wrote outside of the planes: `plane`, the nearest one that begins before, of `size`
  /// floats, and the index from there that was written to, below 0 or beyond its end. plane nullptr: nowhere,
  /// as far as guard zones reach.
  struct Damage {
    const float* plane = nullptr;
    ptrdiff_t index = 0;
    size_t size = 0;
  };
  /// It is found once: guard zones are as new afterwards.
  Damage takeDamage() {
    Damage damage;
    for (const Zone& zone : zones_)
      for (size_t i = 0; i < kGuard; ++i) {
        if (std::bit_cast<uint32_t>(zone.guard[i]) == kPattern) continue;
        if (!damage.plane && zone.plane)
          damage = {zone.plane, static_cast<ptrdiff_t>(zone.size + i), zone.size};
        else if (!damage.plane)
          damage = {zone.guard + kGuard, static_cast<ptrdiff_t>(i) - static_cast<ptrdiff_t>(kGuard), 0};
        fillZone(zone);
      }
    return damage;
  }

  /// `count` planes, one after the other; not initialised.
  float* take(size_t count) {
    const size_t floats = count * padded_ + (isGuarded_ ? 2 * kGuard : 0);
    while (block_ < blocks_.size() && used_ + floats > blocks_[block_].size) ++block_, used_ = 0;
    if (block_ == blocks_.size()) {
      const size_t size = std::max<size_t>(floats, 16384);
      blocks_.push_back({std::unique_ptr<float[], Free>(new (std::align_val_t{64}) float[size]), size});
    }
    float* plane = blocks_[block_].data.get() + used_;
    used_ += floats;
    if (isGuarded_) [[unlikely]] {
      addZone({plane, nullptr, 0});
      plane += kGuard;
      addZone({plane + count * padded_, plane, count * padded_});
    }
    return plane;
  }

  PatinaPlane uniform(float value) {
    float* plane = take(1);
    *plane = value;
    return {plane, 0, 0};
  }
  /// value(i) for lane i; lanes past the end repeat the last.
  template <class Value>
  PatinaPlane fill(size_t n, Value value) {
    float* plane = take(1);
    for (size_t i = 0; i < n; ++i) plane[i] = value(i);
    std::fill(plane + n, plane + padded_, plane[n - 1]);
    return {plane, 1, 0};
  }
  template <class Value>
  PatinaPlane3 fill3(size_t n, Value value) {
    float *x = take(1), *y = take(1), *z = take(1);
    for (size_t i = 0; i < padded_; ++i) {
      const V3f v = value(std::min(i, n - 1));
      x[i] = v.x, y[i] = v.y, z[i] = v.z;
    }
    return {{x, 1, 0}, {y, 1, 0}, {z, 1, 0}};
  }
  float* out(float initial) {
    float* plane = take(1);
    std::fill(plane, plane + padded_, initial);
    return plane;
  }
  PatinaOut3 out3(float initial) { return {out(initial), out(initial), out(initial)}; }

 private:
  struct Free {
    void operator()(float* p) const { ::operator delete[](p, std::align_val_t{64}); }
  };
  struct Block {
    std::unique_ptr<float[], Free> data;
    size_t size;
  };
  static constexpr size_t kGuard = 64;              // floats on each side
  static constexpr uint32_t kPattern = 0x7fc5a5a5;  // a NaN that no shader writes by chance
  struct Zone {
    float* guard;
    const float* plane;  // that the guard is behind; nullptr: it is before one
    size_t size;
  };
  static void fillZone(const Zone& zone) { std::fill_n(zone.guard, kGuard, std::bit_cast<float>(kPattern)); }
  void addZone(const Zone& zone) {
    fillZone(zone);
    zones_.push_back(zone);
  }

  std::vector<Zone> zones_;
  bool isGuarded_ = false;
  std::vector<Block> blocks_;
  size_t padded_ = 0, block_ = 0, used_ = 0;
};

}  // namespace patina
