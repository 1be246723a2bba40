// SPDX-License-Identifier: Apache-2.0
// Batches for tests of shaders: planes that own their memory, filled from lists, and the outputs of each
// entry point.
#pragma once

#include <array>
#include <cstring>
#include <deque>
#include <memory>
#include <vector>

#include "patina/shader.h"

namespace patina::test {

using Triple = std::array<float, 3>;

/// `count` lanes, padded as the ABI asks.
class Batch {
 public:
  explicit Batch(uint32_t count)
      : count_(count), padded_((count + PATINA_LANES - 1) / PATINA_LANES * PATINA_LANES) {
    points.struct_size = sizeof points;
    points.count = count_;
    points.padded = padded_;
    points.value_stride = sizeof(PatinaValue);
    lightIn.struct_size = sizeof lightIn;
    lightIn.count = count_;
    lightIn.padded = padded_;
    lightIn.value_stride = sizeof(PatinaValue);
  }

  PatinaPlane uniform(float value) { return {new_(&value, 1), 0, 0}; }
  PatinaPlane3 uniform(const Triple& v) { return {uniform(v[0]), uniform(v[1]), uniform(v[2])}; }
  /// One value per lane; f(lane). Lanes of the padding repeat the last.
  template <class F>
  PatinaPlane varying(const F& f) {
    std::vector<float> values(padded_);
    for (uint32_t i = 0; i < padded_; ++i) values[i] = f(i < count_ ? i : count_ - 1);
    return {new_(values.data(), padded_), 1, 0};
  }
  template <class F>
  PatinaPlane3 varying3(const F& f) {
    return {varying([&](uint32_t i) { return f(i)[0]; }), varying([&](uint32_t i) { return f(i)[1]; }),
            varying([&](uint32_t i) { return f(i)[2]; })};
  }

  float* out(float value = 0) {
    const std::vector<float> values(padded_, value);
    return new_(values.data(), padded_);
  }
  PatinaOut3 out3(float value = 0) { return {out(value), out(value), out(value)}; }

  PatinaRadiosityOut radiosityOut() {
    return {sizeof(PatinaRadiosityOut), 0, out3(), out3(), out3(), out3(), out3(1)};
  }
  PatinaViewOut viewOut() {
    for (size_t k = 0; k < lobes_.size(); ++k) {
      for (float*& plane : lobeData_[k]) plane = out();
      lobes_[k] = {sizeof(PatinaLobe), 0, out3(), out3(), out(), out(1), lobeData_[k].data(),
                   PATINA_LOBE_DATA,   0};
    }
    return {sizeof(PatinaViewOut), 0, out3(), lobes_.data(), sizeof(PatinaLobe), 0};
  }
  PatinaDisplacementOut displacementOut() { return {sizeof(PatinaDisplacementOut), 0, out3(), out3()}; }
  PatinaLightOut lightOut() { return {sizeof(PatinaLightOut), 0, out3(), out(), out3(), out()}; }

  PatinaPoints points{};
  PatinaLightIn lightIn{};

 private:
  float* new_(const float* values, uint32_t count) {
    memory_.push_back(std::make_unique<Block[]>((count + 15) / 16));
    float* const copy = memory_.back()[0].v;
    std::memcpy(copy, values, count * sizeof(float));
    return copy;
  }
  struct alignas(64) Block {
    float v[16];
  };

  uint32_t count_, padded_;
  std::vector<std::unique_ptr<Block[]>> memory_;
  std::array<PatinaLobe, PATINA_MAX_LOBES> lobes_{};
  std::array<std::array<float*, PATINA_LOBE_DATA>, PATINA_MAX_LOBES> lobeData_{};
};

inline Triple get(const PatinaOut3& planes, uint32_t lane) {
  return {planes.x[lane], planes.y[lane], planes.z[lane]};
}
inline Triple get(const PatinaPlane3& planes, uint32_t lane) {
  return {planes.x.data[lane * planes.x.stride], planes.y.data[lane * planes.y.stride],
          planes.z.data[lane * planes.z.stride]};
}

}  // namespace patina::test
