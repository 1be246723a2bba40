// SPDX-License-Identifier: Apache-2.0
// Batches of the ABI, cut into blocks of PATINA_LANES points that lie in local arrays: what kernels are
// looped over.
#pragma once

#include <cstring>

#include "parameters.h"

namespace patina::sdk {

/// What a kernel is told about the point that it shades: exactly the channels that its signature names, as in
/// `Radiosity radiosity(const Parameters&, const Surface<kCs | kOs>& at) const`. Others do not exist, and are
/// not computed.
inline constexpr uint64_t kP = PATINA_CHANNEL_P, kN = PATINA_CHANNEL_N, kNg = PATINA_CHANNEL_NG,
                          kDPdu = PATINA_CHANNEL_DPDU, kDPdv = PATINA_CHANNEL_DPDV, kUV = PATINA_CHANNEL_UV,
                          kST = PATINA_CHANNEL_ST, kFootprint = PATINA_CHANNEL_FOOTPRINT,
                          kCs = PATINA_CHANNEL_CS, kOs = PATINA_CHANNEL_OS, kI = PATINA_CHANNEL_I,
                          kTime = PATINA_CHANNEL_TIME, kDPds = PATINA_CHANNEL_DPDS,
                          kDPdt = PATINA_CHANNEL_DPDT;

namespace detail {

struct HasP {
  Point P;
};
struct HasN {
  Normal N;
};
struct HasNg {
  Normal Ng;
};
struct HasDPdu {
  Vector dPdu;
};
struct HasDPdv {
  Vector dPdv;
};
struct HasDPds {
  Vector dPds;
};
struct HasDPdt {
  Vector dPdt;
};
struct HasUV {
  float u, v;
};
struct HasST {
  float s, t;
};
struct HasFootprint {
  float footprint, footprint_st;
};
struct HasCs {
  Color Cs;
};
struct HasOs {
  Color Os;
};
struct HasI {
  Vector I;
};
struct HasTime {
  float time;
};

template <uint64_t Bit>
struct Nothing {};
template <uint64_t Channels, uint64_t Bit, class T>
using If = std::conditional_t<(Channels & Bit) != 0, T, Nothing<Bit>>;

}  // namespace detail

template <uint64_t Channels>
struct Surface : detail::If<Channels, kP, detail::HasP>,
                 detail::If<Channels, kN, detail::HasN>,
                 detail::If<Channels, kNg, detail::HasNg>,
                 detail::If<Channels, kDPdu, detail::HasDPdu>,
                 detail::If<Channels, kDPdv, detail::HasDPdv>,
                 detail::If<Channels, kUV, detail::HasUV>,
                 detail::If<Channels, kST, detail::HasST>,
                 detail::If<Channels, kFootprint, detail::HasFootprint>,
                 detail::If<Channels, kCs, detail::HasCs>,
                 detail::If<Channels, kOs, detail::HasOs>,
                 detail::If<Channels, kI, detail::HasI>,
                 detail::If<Channels, kTime, detail::HasTime>,
                 detail::If<Channels, kDPds, detail::HasDPds>,
                 detail::If<Channels, kDPdt, detail::HasDPdt> {
  static constexpr uint64_t kChannels = Channels;
};

namespace detail {

inline constexpr uint32_t kLanes = PATINA_LANES;

/// One number per lane.
struct alignas(64) Lanes {
  float v[kLanes];

  PATINA_INLINE void load(const PatinaPlane& plane, uint32_t first) {
    if (plane.data && plane.stride)
      std::memcpy(v, plane.data + first, sizeof v);
    else
      fill(plane.data ? *plane.data : 0.0f);
  }
  PATINA_INLINE void fill(float value) {
    for (float& lane : v) lane = value;
  }
  PATINA_INLINE void store(float* plane, uint32_t first) const {
    if (plane) std::memcpy(plane + first, v, sizeof v);
  }
};

struct Lanes3 {
  Lanes x, y, z;

  PATINA_INLINE void load(const PatinaPlane3& planes, uint32_t first) {
    x.load(planes.x, first), y.load(planes.y, first), z.load(planes.z, first);
  }
  PATINA_INLINE void store(const PatinaOut3& planes, uint32_t first) const {
    x.store(planes.x, first), y.store(planes.y, first), z.store(planes.z, first);
  }
  PATINA_INLINE Vector vector(uint32_t i) const { return {x.v[i], y.v[i], z.v[i]}; }
  PATINA_INLINE Color color(uint32_t i) const { return {x.v[i], y.v[i], z.v[i]}; }
  PATINA_INLINE void set(uint32_t i, const Vector& v) { x.v[i] = v.x, y.v[i] = v.y, z.v[i] = v.z; }
  PATINA_INLINE void set(uint32_t i, const Color& c) { x.v[i] = c.r, y.v[i] = c.g, z.v[i] = c.b; }
};

/// The channels of a kernel for one block of points.
template <uint64_t C>
struct SurfaceBlock {
  If<C, kP, Lanes3> P;
  If<C, kN, Lanes3> N;
  If<C, kNg, Lanes3> Ng;
  If<C, kDPdu, Lanes3> dPdu;
  If<C, kDPdv, Lanes3> dPdv;
  If<C, kUV, Lanes> u, v;
  If<C, kST, Lanes> s, t;
  If<C, kFootprint, Lanes> footprint, footprint_st;
  If<C, kCs, Lanes3> Cs;
  If<C, kOs, Lanes3> Os;
  If<C, kI, Lanes3> I;
  If<C, kTime, Lanes> time;
  If<C, kDPds, Lanes3> dPds;
  If<C, kDPdt, Lanes3> dPdt;

  PATINA_INLINE void load(const PatinaPoints& in, uint32_t first) {
    if constexpr (C & kP) P.load(in.P, first);
    if constexpr (C & kN) N.load(in.N, first);
    if constexpr (C & kNg) Ng.load(in.Ng, first);
    if constexpr (C & kDPdu) dPdu.load(in.dPdu, first);
    if constexpr (C & kDPdv) dPdv.load(in.dPdv, first);
    if constexpr (C & kUV) u.load(in.u, first), v.load(in.v, first);
    if constexpr (C & kST) s.load(in.s, first), t.load(in.t, first);
    if constexpr (C & kFootprint)
      footprint.load(in.footprint, first), footprint_st.load(in.footprint_st, first);
    if constexpr (C & kCs) Cs.load(in.Cs, first);
    if constexpr (C & kOs) Os.load(in.Os, first);
    if constexpr (C & kI) I.load(in.I, first);
    if constexpr (C & kTime) time.load(in.time, first);
    if constexpr (C & kDPds) dPds.load(in.dPds, first);
    if constexpr (C & kDPdt) dPdt.load(in.dPdt, first);
  }

  PATINA_INLINE Surface<C> get(uint32_t i) const {
    Surface<C> at;
    if constexpr (C & kP) at.P = P.vector(i);
    if constexpr (C & kN) at.N = N.vector(i);
    if constexpr (C & kNg) at.Ng = Ng.vector(i);
    if constexpr (C & kDPdu) at.dPdu = dPdu.vector(i);
    if constexpr (C & kDPdv) at.dPdv = dPdv.vector(i);
    if constexpr (C & kUV) at.u = u.v[i], at.v = v.v[i];
    if constexpr (C & kST) at.s = s.v[i], at.t = t.v[i];
    if constexpr (C & kFootprint) at.footprint = footprint.v[i], at.footprint_st = footprint_st.v[i];
    if constexpr (C & kCs) at.Cs = Cs.color(i);
    if constexpr (C & kOs) at.Os = Os.color(i);
    if constexpr (C & kI) at.I = I.vector(i);
    if constexpr (C & kTime) at.time = time.v[i];
    if constexpr (C & kDPds) at.dPds = dPds.vector(i);
    if constexpr (C & kDPdt) at.dPdt = dPdt.vector(i);
    return at;
  }
};

/// The varying parameters of shader class S for one block of points; uniform ones are those of the instance.
template <class S>
struct ParameterBlock {
  using Table = ParameterTable<S>;
  using Struct = typename Table::Struct;

  template <uint32_t I>
  static constexpr bool kVaries = std::get<I>(S::kInfo.parameters).storage
                                  == PATINA_VARYING&& kIsFloats<typename Table::template Type<I>>;
  static constexpr uint32_t count() {
    uint32_t sum = 0;
    Table::each([&](auto i, const auto&) {
      if (kVaries<i>) sum += TypeOf<typename Table::template Type<i>>::kComponents;
    });
    return sum;
  }
  Lanes planes[count() + 1];

  template <class In>
  PATINA_INLINE void load(const In& in, uint32_t first) {
    uint32_t k = 0;
    Table::each([&](auto i, const auto&) {
      if constexpr (kVaries<i>) {
        const PatinaValue& value = valueAt(in.values, in.value_stride, i);
        for (uint32_t c = 0; c < TypeOf<typename Table::template Type<i>>::kComponents; ++c)
          planes[k++].load({value.floats + size_t(c) * value.plane, value.stride, 0}, first);
      }
    });
  }

  PATINA_INLINE Struct get(uint32_t lane, const Struct& uniforms) const {
    Struct result = uniforms;
    uint32_t k = 0;
    Table::each([&](auto i, const auto& parameter) {
      if constexpr (kVaries<i>) {
        gather(result.*(parameter.member), k, [&](uint32_t c) { return planes[c].v[lane]; });
        k += TypeOf<typename Table::template Type<i>>::kComponents;
      }
    });
    return result;
  }
};

}  // namespace detail
}  // namespace patina::sdk
