// SPDX-License-Identifier: Apache-2.0
// --validate-shaders of lights: see shader_validation.h.
//
// Of every batch: radiance is not negative, directions are unit vectors, distances are not negative, and what
// says FROM_POINT shines from there. Of every seventh batch of a thread one lane is called again, alone: it
// must give the same bits, without a size whatever the random numbers are, and from a point a quarter at
// twice the distance; what comes from infinity is to have the same radiance and density by `evaluate` as by
// `sample`. Once for each of these the samples are counted that fall where its density says.
#pragma once

#include <atomic>
#include <mutex>
#include <span>
#include <vector>

#include "renderer/shading/shader_instance.h"

namespace patina {

/// What is known of one light's faults. [any thread]
class LightValidation {
 public:
  explicit LightValidation(const ShaderInstance& shader) : shader_(shader) {}

  /// After a call that gave PATINA_OK, with what it was given and gave. Must not be called during itself.
  void check(const PatinaLightIn& in, const PatinaLightOut& out);

 private:
  void checkLanes(const PatinaLightIn& in, const PatinaLightOut& out) const;
  void checkAgain(const PatinaLightIn& in, const PatinaLightOut& out, uint32_t lane) const;
  void checkEvaluation(const PatinaLightIn& in, const PatinaLightOut& out);
  void checkDensity(const PatinaLightIn& in, const V3f& P) const;

  const ShaderInstance& shader_;
  std::once_flag density_;
  std::atomic<uint64_t> compared_{0}, different_{0};  // samples evaluated
};

}  // namespace patina
