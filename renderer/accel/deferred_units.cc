// SPDX-License-Identifier: Apache-2.0
// Meetings by unit.
#include "renderer/accel/deferred_units.h"

#include <algorithm>

namespace patina {

void DeferredUnits::add(uint32_t unit, const RTCRay& ray, const PartTracer& part, uint32_t instance) {
  uint32_t local = kNone;
  const bool isDelayed = &part != part_;
  if (instance != RTC_INVALID_GEOMETRY_ID || isDelayed || ray.time != rays_[ray.id].time) {
    // Of the scene's own things it is known later how far rays go, and better.
    const float tFar = isDelayed ? ray.tfar : rays_[ray.id].tFar;
    const LocalRay* const last = locals_.empty() ? nullptr : &locals_.back();
    const bool isSame = !meetings_.empty() && meetings_.back().ray == ray.id &&
                        meetings_.back().local != kNone && last->part == &part &&
                        last->instance == instance && last->time == ray.time && last->tFar == tFar;
    if (!isSame)
      locals_.push_back({&part,
                         instance,
                         {ray.org_x, ray.org_y, ray.org_z},
                         {ray.dir_x, ray.dir_y, ray.dir_z},
                         ray.tnear,
                         tFar,
                         ray.time});
    local = static_cast<uint32_t>(locals_.size() - 1);
  }
  meetings_.push_back({unit, ray.id, local});
}

// Slabs, wide enough for their rounding (PBR 4th ed. section 6.8.2). NaN, of a ray within a slab's plane,
// compares false.
bool DeferredUnits::mayMeet(const LocalRay& ray, const SurfaceUnit& unit, float tFar) {
  if (unit.segments > 0) return true;
  float from = ray.tNear, to = tFar;
  for (int k = 0; k < 3; ++k) {
    const float inverse = 1 / ray.direction[k];
    float a = (unit.bound.min[k] - ray.origin[k]) * inverse,
          b = (unit.bound.max[k] - ray.origin[k]) * inverse;
    if (a > b) std::swap(a, b);
    a -= std::abs(a) * 2 * roundingBound(3), b += std::abs(b) * 2 * roundingBound(3);
    if (a > from) from = a;
    if (b < to) to = b;
  }
  return from <= to;
}

const std::vector<std::span<const DeferredUnits::Meeting>>& DeferredUnits::sorted() {
  // By counting: there are many more meetings than units.
  met_.clear();
  for (const Meeting& m : meetings_) {
    if (m.unit >= counts_.size()) counts_.resize(m.unit + 1, 0);
    if (counts_[m.unit]++ == 0) met_.push_back(m.unit);
  }
  // What units of many rays find makes fewer of the others necessary.
  std::sort(met_.begin(), met_.end(),
            [&](uint32_t a, uint32_t b) { return std::pair(counts_[b], a) < std::pair(counts_[a], b); });
  ordered_.resize(meetings_.size());
  units_.clear();
  uint32_t next = 0;
  for (const uint32_t unit : met_) {
    const uint32_t count = counts_[unit];
    units_.push_back(std::span(ordered_).subspan(next, count));
    counts_[unit] = next;
    next += count;
  }
  for (const Meeting& m : meetings_) ordered_[counts_[m.unit]++] = m;
  for (const uint32_t unit : met_) counts_[unit] = 0;
  return units_;
}

}  // namespace patina
