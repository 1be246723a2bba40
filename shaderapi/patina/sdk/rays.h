// SPDX-License-Identifier: Apache-2.0
// Rays to what is near a point: how much of its surroundings is covered, or how far away it is.
//
//   std::array<RayQuery, 16> rays(const Parameters&, const Surface<kN>& at) const;          where to look
//   Radiosity radiosity(const Parameters&, const Surface<kCs | kOs>&, const Occluded<16>&) const;
//
// The last argument of `radiosity` or `view` is what the rays of `rays` have met, behind the texels if there
// are any: Occluded<N>, or Distances<N>, which costs more. N is at most PATINA_MAX_RAYS. `uint32_t rayCount()
// const`, optional, says after `prepare` how many of them are in use, from the first; the others meet
// nothing. What rays see, and what they cost: PATINA_EXTENSION_RAYS in patina/shader.h. An example is
// shaders/dirt.cpp.
#pragma once

#include "lanes.h"

namespace patina::sdk {

/// A ray from P of the point, which does not meet the surface there.
struct RayQuery {
  Vector direction;   ///< world space, of any length but zero
  float maximum = 0;  ///< world units; 0 or less: the ray is not traced
};
/// A ray from anywhere.
struct RayQueryFrom {
  Vector origin, direction;
  float maximum = 0;
};

/// By ray: 1 = it has met something, else 0.
template <size_t N>
struct Occluded {
  static constexpr size_t kRays = N;
  std::array<float, N> ray{};
};
/// By ray: world units to what it has met; PATINA_INFINITE_DISTANCE = nothing.
template <size_t N>
struct Distances {
  static constexpr size_t kRays = N;
  std::array<float, N> ray{};
};

/// Point k of N that lie evenly on the unit sphere, a spiral by the golden angle (R. Swinbank and R. J.
/// Purser, "Fibonacci grids", 2006). n + spherePoint(k, N) are directions about the unit vector n with the
/// density of the cosine.
PATINA_INLINE Vector spherePoint(int k, int N) {
  constexpr float kGoldenAngle = 2.39996323f;
  const float z = 1 - (2 * static_cast<float>(k) + 1) / static_cast<float>(N);
  const float radius = std::sqrt(std::max(1 - z * z, 0.0f)), phi = kGoldenAngle * static_cast<float>(k);
  return {radius * cos(phi), radius * sin(phi), z};
}

namespace detail {

/// The rays of one block of points, and what they met. `Met`: Occluded<N> or Distances<N>.
template <class Met, class Query>
struct RayLanes {
  static constexpr size_t N = Met::kRays;
  static constexpr bool kHasOrigin = std::is_same_v<Query, RayQueryFrom>;
  static_assert(N >= 1 && N <= PATINA_MAX_RAYS);
  struct Planes3 {
    alignas(64) float x[N * kLanes], y[N * kLanes], z[N * kLanes];
    PATINA_INLINE void set(size_t i, const Vector& v) { x[i] = v.x, y[i] = v.y, z[i] = v.z; }
    void move(size_t to, size_t from) { x[to] = x[from], y[to] = y[from], z[to] = z[from]; }
    PatinaPlane3 planes() const { return {{x, 1, 0}, {y, 1, 0}, {z, 1, 0}}; }
  };
  Planes3 direction;
  std::conditional_t<kHasOrigin, Planes3, Nothing<0>> origin;
  alignas(64) float maximum[N * kLanes], met[N * kLanes];
  uint32_t lane[N * kLanes];

  PATINA_INLINE void set(uint32_t i, const std::array<Query, N>& queries) {
    for (size_t k = 0; k < N; ++k) {
      direction.set(k * kLanes + i, queries[k].direction);
      if constexpr (kHasOrigin) origin.set(k * kLanes + i, queries[k].origin);
      maximum[k * kLanes + i] = queries[k].maximum;
    }
  }
  /// Traces the first `used` rays of each of the `count` lanes from `first` on.
  void trace(const PatinaRays* rays, void* host, uint32_t first, uint32_t count, uint32_t used) {
    constexpr bool kDistances = std::is_same_v<Met, Distances<N>>;
    std::fill_n(met, N * kLanes, kDistances ? PATINA_INFINITE_DISTANCE : 0.0f);
    if (!rays || used == 0) return;
    uint32_t total = 0;
    for (uint32_t k = 0; k < used; ++k)
      for (uint32_t i = 0; i < count; ++i, ++total) {
        const size_t from = size_t(k) * kLanes + i;
        direction.move(total, from);
        if constexpr (kHasOrigin) origin.move(total, from);
        maximum[total] = maximum[from], lane[total] = first + i;
      }
    PatinaRayIn in{};
    in.struct_size = sizeof in;
    in.count = total, in.lane = lane;
    in.direction = direction.planes();
    if constexpr (kHasOrigin) in.origin = origin.planes();
    in.maximum = {maximum, 1, 0};
    PatinaRayOut out{};
    out.struct_size = sizeof out;
    (kDistances ? out.distance : out.occluded) = met;
    if (rays->trace(host, &in, &out) != PATINA_OK || count == kLanes) return;
    for (uint32_t k = used; k-- > 0;)  // back to where their lanes are
      for (uint32_t i = kLanes; i-- > 0;)
        met[size_t(k) * kLanes + i] = met[size_t(k) * count + std::min(i, count - 1)];
  }
  PATINA_INLINE Met get(uint32_t i) const {
    Met result;
    for (size_t k = 0; k < N; ++k) result.ray[k] = met[k * kLanes + i];
    return result;
  }
};

}  // namespace detail
}  // namespace patina::sdk
