// SPDX-License-Identifier: Apache-2.0
// Rays of a batch that wait for units of geometry that are not there.
#pragma once

#include <embree3/rtcore.h>

#include <span>
#include <vector>

#include "renderer/accel/accel.h"

namespace patina {

class PartTracer;

/// When facets have to go and come back, rays of a batch leave out the units that are not there. Then each of
/// these is made once for all rays that have met its bound and found nothing nearer (M. Pharr, C. Kolb,
/// R. Gershbein, P. Hanrahan 1997, "Rendering Complex Scenes with Memory-Coherent Ray Tracing", section 4).
class DeferredUnits {
 public:
  /// A ray as it is at the unit's place: mesh space.
  struct LocalRay {
    const PartTracer* part;  ///< that has the unit
    uint32_t instance;       ///< Embree's number in that part, or RTC_INVALID_GEOMETRY_ID
    V3f origin, direction;
    float tNear, tFar, time;  ///< in a delayed archive within its bound
  };
  struct Meeting {
    uint32_t unit;
    uint32_t ray;    ///< index in the batch
    uint32_t local;  ///< index of a LocalRay; kNone: the ray as it is in the batch
  };

  /// Forgets everything; the rays of the batch that follows, which must stay, and where they begin.
  void begin(std::span<const Ray> rays, const PartTracer& part) {
    rays_ = rays, part_ = &part;
    clear();
  }
  bool isEmpty() const { return meetings_.empty(); }
  /// There are so many that the batch had better go on with what it has.
  bool isFull() const { return meetings_.size() >= kMost; }
  /// `ray.id` is its index in the batch; `instance`: Embree's number in `part`.
  void add(uint32_t unit, const RTCRay& ray, const PartTracer& part, uint32_t instance);
  LocalRay localRay(const Meeting& m) const {
    if (m.local != kNone) return locals_[m.local];
    const Ray& ray = rays_[m.ray];
    return {part_, RTC_INVALID_GEOMETRY_ID, ray.origin, ray.direction, ray.tNear, ray.tFar, ray.time};
  }
  /// Whether the bound of the unit is nearer than `tFar`, as far as can be said. What moves always is.
  static bool mayMeet(const LocalRay& ray, const SurfaceUnit& unit, float tFar);
  /// Visits the units, those of most rays first, with all meetings of each, and forgets them.
  template <class Visit>
  void forEachUnit(Visit visit) {
    for (const std::span<const Meeting> of : sorted()) visit(of);
    clear();
  }

 private:
  static constexpr size_t kMost = size_t{1} << 20;  // 12 MB
  const std::vector<std::span<const Meeting>>& sorted();
  void clear() { meetings_.clear(), locals_.clear(); }

  std::span<const Ray> rays_;
  const PartTracer* part_ = nullptr;
  std::vector<Meeting> meetings_, ordered_;
  std::vector<LocalRay> locals_;
  std::vector<uint32_t> counts_, met_;  ///< by unit: how often it was met, else 0; those that were
  std::vector<std::span<const Meeting>> units_;
};

}  // namespace patina
