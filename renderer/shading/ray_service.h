// SPDX-License-Identifier: Apache-2.0
// Rays that plugins trace: PATINA_EXTENSION_RAYS. Who calls an entry point says for which points; the plugin
// then gets no more rays for each than it has declared.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "patina/shader.h"
#include "renderer/accel/accel.h"

namespace patina {

class ShaderInstance;

/// The call of an entry point that may trace rays: of the calling thread, for as long as it lives. Calls of
/// shaders that have declared no rays need none.
class RayCall {
 public:
  /// Where a lane's rays begin if they do not say; asked for once per ray.
  using FacetOf = std::function<Facet(uint32_t lane)>;

  /// Everything outlives it. `accel` may be nullptr: then rays meet nothing.
  RayCall(const ShaderInstance& shader, PatinaEntry entry, uint32_t lanes, const Accel* accel,
          const FacetOf& facetOf);
  /// One lane of the thread's present call, called again by itself with as many rays; without a present call
  /// it does nothing.
  explicit RayCall(uint32_t lane);
  ~RayCall();
  RayCall(const RayCall&) = delete;
  RayCall& operator=(const RayCall&) = delete;

  int64_t traced() const { return traced_; }  ///< rays so far

  /// PatinaRays.trace of `shader`; what is refused is reported as an error of the plugin. [any thread]
  static PatinaStatus trace(const ShaderInstance& shader, const PatinaRayIn* in, PatinaRayOut* out);

 private:
  const char* refusal(const PatinaRayIn& in);
  void makeRays(const PatinaRayIn& in);

  RayCall* before_;
  const ShaderInstance* shader_ = nullptr;
  PatinaEntry entry_ = PATINA_ENTRY_RADIOSITY;
  const Accel* accel_ = nullptr;
  const FacetOf* facetOf_ = nullptr;
  uint32_t firstLane_ = 0, most_ = 0;
  std::vector<uint32_t> used_;  ///< rays, by lane
  int64_t traced_ = 0, strange_ = 0;
};

}  // namespace patina
