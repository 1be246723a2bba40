// SPDX-License-Identifier: Apache-2.0
// Lobes of a shader's own. A lobe is a small class:
//
//   struct Velvet {
//     static constexpr LobeInfo kLobe{"velvet", "one line of documentation"};
//     float roughness = 0.3f;      // what it knows of a point: floats, vectors and colours,
//                                  // PATINA_LOBE_DATA numbers at most; filled by `view`
//     Color eval(const Vector& wo, const Vector& wi) const;       // BSDF times |cosine of wi|, sr^-1
//     float pdf(const Vector& wo, const Vector& wi) const;        // of sample(), sr^-1
//     Vector sample(const Vector& wo, float x, float y) const;    // unit; Vector() = none; x, y in [0, 1)
//     Vector tangent() const;      // optional: world space; x of the local frame
//   };
//
// Directions are unit vectors that point away from the surface, in the frame of the point: z is the shading
// normal (wo.z > 0), x the tangent without its part along z. `view` returns a ViewWith, whose `own` has one
// OwnLobe for each class; the rest is done by the SDK: registration in `prepare`, planes, types.
// patina-shader --check checks the class: that the density integrates to 1 and samples follow it, that no
// energy is made, and that it is reciprocal.
#pragma once

#include <cstring>

#include "lanes.h"

namespace patina::sdk {

/// `flags` are PATINA_LOBE_ bits: the sides that it is asked for.
struct LobeInfo {
  const char* name;
  const char* doc;
  uint32_t flags = PATINA_LOBE_REFLECTS;
};

namespace detail {

template <class L>
struct LobeTable {
  static constexpr uint32_t kNumbers = uint32_t(sizeof(L) / sizeof(float));
  static_assert(std::is_trivially_copyable_v<L> && alignof(L) == alignof(float),
                "a lobe's members are floats, vectors and colours");
  static_assert(kNumbers <= PATINA_LOBE_DATA, "a lobe knows PATINA_LOBE_DATA numbers at most");

  static float number(const PatinaPlane& plane, uint32_t i) { return plane.data[size_t(i) * plane.stride]; }
  static Vector vector(const PatinaPlane3& planes, uint32_t i) {
    return {number(planes.x, i), number(planes.y, i), number(planes.z, i)};
  }

  // A lane: the lobe, and its frame.
  struct Lane {
    L lobe;
    Vector x, y, z, wo;

    Lane(const PatinaLobeIn& in, uint32_t i) : z(vector(in.N, i)) {
      float numbers[kNumbers];
      for (uint32_t c = 0; c < kNumbers; ++c) numbers[c] = number(in.data[c], i);
      std::memcpy(static_cast<void*>(&lobe), numbers, sizeof(L));
      const Frame frame = frameAround(z);
      x = frame.x, y = frame.y;
      if constexpr (requires { lobe.tangent(); }) {
        const Vector along = lobe.tangent(), flat = along - z * dot(along, z);
        if (dot(flat, flat) > 1e-6f * dot(along, along)) x = normalize(flat), y = cross(z, x);
      }
      wo = local(vector(in.wo, i));
    }
    Vector local(const Vector& v) const { return {dot(v, x), dot(v, y), dot(v, z)}; }
    Vector world(const Vector& v) const { return x * v.x + y * v.y + z * v.z; }
  };

  static PatinaStatus evaluate(void*, const PatinaLobeIn* in, PatinaLobeOut* out) {
    for (uint32_t i = 0; i < in->count; ++i) {
      const Lane lane(*in, i);
      const Vector wi = lane.local(vector(in->wi, i));
      const Color f = lane.lobe.eval(lane.wo, wi);
      out->f.x[i] = f.r, out->f.y[i] = f.g, out->f.z[i] = f.b;
      out->pdf[i] = lane.lobe.pdf(lane.wo, wi);
    }
    return PATINA_OK;
  }
  static PatinaStatus sample(void*, const PatinaLobeIn* in, PatinaLobeOut* out) {
    for (uint32_t i = 0; i < in->count; ++i) {
      const Lane lane(*in, i);
      const Vector wi =
          lane.world(lane.lobe.sample(lane.wo, number(in->random_x, i), number(in->random_y, i)));
      out->wi.x[i] = wi.x, out->wi.y[i] = wi.y, out->wi.z[i] = wi.z;
    }
    return PATINA_OK;
  }

  static constexpr PatinaCustomLobe kTable = {
      sizeof(PatinaCustomLobe), L::kLobe.flags, L::kLobe.name, L::kLobe.doc, kNumbers, 0, evaluate, sample};
};

}  // namespace detail

/// A uniform direction of the hemisphere about z; its density is 1 / (2 pi).
PATINA_INLINE Vector uniformHemisphere(float x, float y) {
  const float radius = std::sqrt(std::max(1 - x * x, 0.0f)), phi = 2 * kPi * y;
  return {radius * cos(phi), radius * sin(phi), x};
}

}  // namespace patina::sdk
