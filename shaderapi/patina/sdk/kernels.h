// SPDX-License-Identifier: Apache-2.0
// What kernels return and are asked, and the loops that run them over a batch.
#pragma once

#include "lobes.h"
#include "rays.h"

namespace patina::sdk {

// ---- Surfaces -------------------------------------------------------------------------------------------

/// Result of `radiosity`; see PatinaRadiosityOut.
struct Radiosity {
  Color emission{}, reflectance{}, transmittance{}, ambient{};
  Color opacity{1};
};

struct Lobe {
  Color weight{}, transmission{};
  float alpha = 0;  ///< roughness of RI's specular(), or GGX's alpha
  float eta = 1;
};

/// Result of `view`: lobes of the types given, in their order; see PatinaViewOut.
template <PatinaLobeType... Types>
struct View {
  static constexpr std::array<PatinaLobeType, sizeof...(Types)> kTypes{Types...};
  static_assert(sizeof...(Types) <= PATINA_MAX_LOBES);
  Color emission{};
  std::array<Lobe, sizeof...(Types)> lobes{};
};

/// A lobe of class L (sdk/lobes.h): what it knows of the point, and its weight; see PATINA_LOBE_CUSTOM.
template <class L>
struct OwnLobe {
  Color weight{};
  float alpha = 1;  ///< how wide it is, as GGX's alpha
  float eta = 1;
  L lobe{};
};

/// Result of `view` with lobes of the shader's own behind those of `Standard`, a View<...>.
template <class Standard, class... L>
struct ViewWith : Standard {
  static_assert(Standard::kTypes.size() + sizeof...(L) <= PATINA_MAX_LOBES);
  std::tuple<OwnLobe<L>...> own;
};

/// What RI's standard surfaces have in common: Os * color * (Ka * ambient() + Kd * diffuse(N)) ...
PATINA_INLINE Radiosity diffuseSurface(const Color& color, const Color& Os, float Ka, float Kd) {
  const Color premultiplied = Os * color;
  Radiosity out;
  out.reflectance = premultiplied * Kd;
  out.ambient = premultiplied * Ka;
  out.opacity = Os;
  return out;
}
/// ... + Os * color * specular(N, V, roughness).
PATINA_INLINE View<PATINA_LOBE_RI_SPECULAR> highlights(const Color& color, const Color& Os, float roughness) {
  View<PATINA_LOBE_RI_SPECULAR> out;
  out.lobes[0].weight = Os * color;
  out.lobes[0].alpha = std::max(roughness, 1e-4f);
  return out;
}

/// Result of `displacement`. With DisplacedNormal the shader gives the normal too, else the host computes it.
struct Displaced {
  Vector P;
};
struct DisplacedNormal {
  Vector P, N;
};

// ---- Textures -------------------------------------------------------------------------------------------

/// Result of `lookups` is a std::array of one of these: where texture i (that of `texture(i)`) is read for a
/// point. A kernel that takes `const Texels<N>&` as its last argument gets what was found there. Those of a
/// light are given its LightQuery in the place of a Surface.
struct TextureLookup {
  float s, t, width;
};
struct EnvironmentLookup {
  Vector direction;
  float width;
};
struct Texel {
  Color color{1};
  float alpha = 1;
};
template <size_t N>
using Texels = std::array<Texel, N>;

// ---- Lights ---------------------------------------------------------------------------------------------

/// Asked of `sample`, `evaluate` and `emit`; see PatinaLightIn.
struct LightQuery {
  Vector P;                  ///< to be lit; of `emit`: on the light
  Vector N;                  ///< `emit`: outside normal of the light
  Vector direction;          ///< `evaluate`: towards the light; `emit`: from the light
  float u, v;                ///< `emit`
  float random_x, random_y;  ///< `sample`
  float time;
};

/// Result of `sample` (all of it) and of `evaluate` (radiance and pdf).
struct LightSample {
  Vector direction{};
  float distance = PATINA_INFINITE_DISTANCE;
  Color radiance{};
  float pdf = 0;
};

// ---- Loops ----------------------------------------------------------------------------------------------

namespace detail {

#if defined(__clang__)
#define PATINA_VECTOR_LOOP
#else
#define PATINA_VECTOR_LOOP _Pragma("GCC ivdep")
#endif

// The lobes of their own of a kernel's result.
template <class Result>
struct OwnLobesOf {
  static constexpr uint32_t kCount = 0, kNumbers = 0;
};
template <class Standard, class... L>
struct OwnLobesOf<ViewWith<Standard, L...>> {
  static constexpr uint32_t kCount = sizeof...(L), kNumbers = std::max({LobeTable<L>::kNumbers...});
  static constexpr std::array<const PatinaCustomLobe*, kCount> kTables{&LobeTable<L>::kTable...};
};

template <class S>
struct Instance {
  S shader;
  typename ParameterTable<S>::Struct parameters;
  const PatinaHost* host;
  std::array<uint32_t, PATINA_MAX_LOBES> ownTypes{};  // of the lobes of its own
  const PatinaRays* rays = nullptr;                   // nullptr: the host has none
  uint32_t rayCount = 0;                              // that are in use
};

// The signature of a kernel: the channels of its Surface argument, its result, how many texels and rays it
// takes.
template <class... Args>
struct ChannelsOf {
  static constexpr uint64_t kValue = 0;
};
template <uint64_t C, class... Rest>
struct ChannelsOf<Surface<C>, Rest...> {
  static constexpr uint64_t kValue = C;
};
template <class First, class... Rest>
struct ChannelsOf<First, Rest...> : ChannelsOf<Rest...> {};

template <class... Args>
struct TexelsOf {
  static constexpr size_t kValue = 0;
};
template <size_t N, class... Rest>
struct TexelsOf<Texels<N>, Rest...> {
  static constexpr size_t kValue = N;
};
template <class First, class... Rest>
struct TexelsOf<First, Rest...> : TexelsOf<Rest...> {};

template <class... Args>
struct RaysOf {
  struct Met {
    static constexpr size_t kRays = 0;
  };
};
template <size_t N, class... Rest>
struct RaysOf<Occluded<N>, Rest...> {
  using Met = Occluded<N>;
};
template <size_t N, class... Rest>
struct RaysOf<Distances<N>, Rest...> {
  using Met = Distances<N>;
};
template <class First, class... Rest>
struct RaysOf<First, Rest...> : RaysOf<Rest...> {};

template <class F>
struct Kernel;
template <class R, class... Args>
struct Kernel<R (*)(Args...)> {
  using Result = R;
  static constexpr uint64_t kChannels = ChannelsOf<std::remove_cvref_t<Args>...>::kValue;
  static constexpr size_t kTexels = TexelsOf<std::remove_cvref_t<Args>...>::kValue;
  using Met = typename RaysOf<std::remove_cvref_t<Args>...>::Met;
  static constexpr size_t kRays = Met::kRays;
};
template <class R, class... Args>
struct Kernel<R (*)(Args...) noexcept> : Kernel<R (*)(Args...)> {};
template <class R, class S, class... Args>
struct Kernel<R (S::*)(Args...) const> : Kernel<R (*)(Args...)> {};
template <class R, class S, class... Args>
struct Kernel<R (S::*)(Args...) const noexcept> : Kernel<R (*)(Args...)> {};

// Looks the textures of a block up, before the kernel that uses them runs.
template <class S, size_t N>
struct TexelBlock {
  Lanes3 color[N];
  Lanes alpha[N];

  PATINA_INLINE void load(const Instance<S>& self, const ParameterBlock<S>& parameters,
                          const PatinaPoints& in, uint32_t first) {
    SurfaceBlock<Kernel<decltype(&S::lookups)>::kChannels> surface;
    surface.load(in, first);
    load(self, parameters, in.count - first, [&](uint32_t lane) { return surface.get(lane); });
  }

  // `at(lane)`: what lookups() is given of the first `count` lanes, a Surface or a LightQuery.
  template <class At>
  PATINA_INLINE void load(const Instance<S>& self, const ParameterBlock<S>& parameters, uint32_t count,
                          const At& at) {
    using K = Kernel<decltype(&S::lookups)>;
    using Lookup = typename K::Result::value_type;
    static_assert(std::tuple_size_v<typename K::Result> == N, "lookups() and Texels<> disagree");
    Lanes3 where[N];
    Lanes width[N];
    PATINA_VECTOR_LOOP
    for (uint32_t lane = 0; lane < kLanes; ++lane) {
      const auto lookups = self.shader.lookups(parameters.get(lane, self.parameters), at(lane));
      for (size_t k = 0; k < N; ++k) {
        if constexpr (std::is_same_v<Lookup, TextureLookup>)
          where[k].set(lane, Vector(lookups[k].s, lookups[k].t, 0));
        else
          where[k].set(lane, lookups[k].direction);
        width[k].v[lane] = lookups[k].width;
      }
    }
    count = std::min(kLanes, count);
    for (size_t k = 0; k < N; ++k) {
      alpha[k].fill(1);
      for (Lanes* plane : {&color[k].x, &color[k].y, &color[k].z}) plane->fill(1);
      PatinaTexture* texture = self.shader.texture(static_cast<uint32_t>(k));
      if (!texture) continue;
      const auto plane = [](const Lanes& lanes) { return PatinaPlane{lanes.v, 1, 0}; };
      const PatinaOut3 out{color[k].x.v, color[k].y.v, color[k].z.v};
      if constexpr (std::is_same_v<Lookup, TextureLookup>)
        self.host->texture(self.host->host, texture, count, plane(where[k].x), plane(where[k].y),
                           plane(width[k]), out, alpha[k].v);
      else
        self.host->environment(self.host->host, texture, count,
                               {plane(where[k].x), plane(where[k].y), plane(where[k].z)}, plane(width[k]),
                               out);
    }
  }
  PATINA_INLINE Texels<N> get(uint32_t lane) const {
    Texels<N> texels;
    for (size_t k = 0; k < N; ++k) texels[k] = {color[k].color(lane), alpha[k].v[lane]};
    return texels;
  }
};
template <class S>
struct TexelBlock<S, 0> {
  PATINA_INLINE void load(const Instance<S>&, const ParameterBlock<S>&, const PatinaPoints&, uint32_t) {}
};

// Traces the rays of a block, before the kernel that looks at them runs.
template <class S, class Met, size_t N = Met::kRays>
struct RayBlock {
  using K = Kernel<decltype(&S::rays)>;
  static_assert(std::tuple_size_v<typename K::Result> == N, "rays() and Occluded<> or Distances<> disagree");
  RayLanes<Met, typename K::Result::value_type> lanes;

  PATINA_INLINE void load(const Instance<S>& self, const ParameterBlock<S>& parameters,
                          const PatinaPoints& in, uint32_t first) {
    SurfaceBlock<K::kChannels> surface;
    surface.load(in, first);
    PATINA_VECTOR_LOOP
    for (uint32_t lane = 0; lane < kLanes; ++lane)
      lanes.set(lane, self.shader.rays(parameters.get(lane, self.parameters), surface.get(lane)));
    lanes.trace(self.rays, self.host->host, first, std::min(kLanes, in.count - first), self.rayCount);
  }
  PATINA_INLINE Met get(uint32_t lane) const { return lanes.get(lane); }
};
template <class S, class Met>
struct RayBlock<S, Met, 0> {
  PATINA_INLINE void load(const Instance<S>&, const ParameterBlock<S>&, const PatinaPoints&, uint32_t) {}
};

// Runs a surface kernel over one block: `call` is given parameters, surface [, texels] [and what rays met],
// `set` the lane and the result.
template <class K, class S, class Call, class Set>
PATINA_INLINE void runSurface(const Instance<S>& self, const PatinaPoints& in, uint32_t first,
                              const Call& call, const Set& set) {
  ParameterBlock<S> parameters;
  SurfaceBlock<K::kChannels> surface;
  TexelBlock<S, K::kTexels> texels;
  RayBlock<S, typename K::Met> rays;
  parameters.load(in, first);
  surface.load(in, first);
  texels.load(self, parameters, in, first);
  rays.load(self, parameters, in, first);
  PATINA_VECTOR_LOOP
  for (uint32_t lane = 0; lane < kLanes; ++lane) {
    if constexpr (K::kTexels == 0 && K::kRays == 0)
      set(lane, call(parameters.get(lane, self.parameters), surface.get(lane)));
    else if constexpr (K::kRays == 0)
      set(lane, call(parameters.get(lane, self.parameters), surface.get(lane), texels.get(lane)));
    else if constexpr (K::kTexels == 0)
      set(lane, call(parameters.get(lane, self.parameters), surface.get(lane), rays.get(lane)));
    else
      set(lane,
          call(parameters.get(lane, self.parameters), surface.get(lane), texels.get(lane), rays.get(lane)));
  }
}

template <class S>
__attribute__((flatten)) void displacementBlock(const Instance<S>& self, const PatinaPoints& in,
                                                uint32_t first, PatinaDisplacementOut& out) {
  using K = Kernel<decltype(&S::displacement)>;
  constexpr bool kNormal = std::is_same_v<typename K::Result, DisplacedNormal>;
  Lanes3 P, N;
  runSurface<K>(
      self, in, first, [&](const auto&... args) { return self.shader.displacement(args...); },
      [&](uint32_t lane, const auto& result) {
        P.set(lane, result.P);
        if constexpr (kNormal) N.set(lane, result.N);
      });
  P.store(out.P, first);
  if constexpr (kNormal) N.store(out.N, first);
  out.writes_normal = kNormal;
}

template <class S>
__attribute__((flatten)) void radiosityBlock(const Instance<S>& self, const PatinaPoints& in, uint32_t first,
                                             PatinaRadiosityOut& out) {
  using K = Kernel<decltype(&S::radiosity)>;
  Lanes3 emission, reflectance, transmittance, ambient, opacity;
  runSurface<K>(
      self, in, first, [&](const auto&... args) { return self.shader.radiosity(args...); },
      [&](uint32_t lane, const Radiosity& result) {
        emission.set(lane, result.emission);
        reflectance.set(lane, result.reflectance);
        transmittance.set(lane, result.transmittance);
        ambient.set(lane, result.ambient);
        opacity.set(lane, result.opacity);
      });
  emission.store(out.emission, first);
  reflectance.store(out.reflectance, first);
  transmittance.store(out.transmittance, first);
  ambient.store(out.ambient, first);
  opacity.store(out.opacity, first);
}

template <class S>
__attribute__((flatten)) void viewBlock(const Instance<S>& self, const PatinaPoints& in, uint32_t first,
                                        PatinaViewOut& out) {
  using K = Kernel<decltype(&S::view)>;
  using Result = typename K::Result;
  using Own = OwnLobesOf<Result>;
  constexpr size_t kStandard = Result::kTypes.size(), kLobes = kStandard + Own::kCount;
  Lanes data[Own::kCount + 1][Own::kNumbers + 1];
  Lanes3 emission, weight[kLobes + 1], transmission[kLobes + 1];
  Lanes alpha[kLobes + 1], eta[kLobes + 1];
  runSurface<K>(
      self, in, first, [&](const auto&... args) { return self.shader.view(args...); },
      [&](uint32_t lane, const Result& result) {
        emission.set(lane, result.emission);
        for (size_t k = 0; k < kStandard; ++k) {
          weight[k].set(lane, result.lobes[k].weight);
          transmission[k].set(lane, result.lobes[k].transmission);
          alpha[k].v[lane] = result.lobes[k].alpha;
          eta[k].v[lane] = result.lobes[k].eta;
        }
        if constexpr (Own::kCount > 0)
          unrolled<int(Own::kCount)>([&](auto own) PATINA_INLINE_LAMBDA {
            const auto& from = std::get<size_t(own)>(result.own);
            constexpr size_t kNumbers = sizeof(from.lobe) / sizeof(float), k = kStandard + size_t(own);
            weight[k].set(lane, from.weight);
            transmission[k].set(lane, Color());
            alpha[k].v[lane] = from.alpha, eta[k].v[lane] = from.eta;
            float numbers[kNumbers];
            std::memcpy(numbers, &from.lobe, sizeof numbers);
            for (size_t c = 0; c < kNumbers; ++c) data[size_t(own)][c].v[lane] = numbers[c];
          });
      });
  emission.store(out.emission, first);
  uint32_t used = kLobes;
  if constexpr (requires { self.shader.lobeCount(); })
    used = std::min(used, uint32_t(self.shader.lobeCount()));
  for (uint32_t k = 0; k < used; ++k) {
    auto& lobe =
        *reinterpret_cast<PatinaLobe*>(reinterpret_cast<std::byte*>(out.lobes) + size_t(k) * out.lobe_stride);
    if constexpr (Own::kCount > 0) {
      if (k >= kStandard) {
        const PatinaCustomLobe& own = *Own::kTables[k - kStandard];
        for (uint32_t c = 0; c < own.data_count; ++c) data[k - kStandard][c].store(lobe.data[c], first);
      }
    }
    lobe.type = k < kStandard ? uint32_t(Result::kTypes[std::min<size_t>(k, kStandard - 1)])
                              : self.ownTypes[k - kStandard];
    weight[k].store(lobe.weight, first);
    transmission[k].store(lobe.transmission, first);
    alpha[k].store(lobe.alpha, first);
    eta[k].store(lobe.eta, first);
  }
  out.lobe_count = used;
}

// Runs a light's kernel over one block: `call` is given parameters, query [and texels], `set` the lane and
// the result.
template <class K, class S, class Query, class Call, class Set>
PATINA_INLINE void runLight(const Instance<S>& self, const ParameterBlock<S>& parameters, uint32_t count,
                            const Query& query, const Call& call, const Set& set) {
  [[maybe_unused]] TexelBlock<S, K::kTexels> texels;
  if constexpr (K::kTexels > 0) texels.load(self, parameters, count, query);
  PATINA_VECTOR_LOOP
  for (uint32_t lane = 0; lane < kLanes; ++lane) {
    if constexpr (K::kTexels == 0)
      set(lane, call(parameters.get(lane, self.parameters), query(lane)));
    else
      set(lane, call(parameters.get(lane, self.parameters), query(lane), texels.get(lane)));
  }
}

template <class S>
__attribute__((flatten)) void lightBlock(const Instance<S>& self, const PatinaLightIn& in, uint32_t first,
                                         PatinaLightOut& out) {
  ParameterBlock<S> parameters;
  Lanes3 P, N, direction;
  Lanes u, v, randomX, randomY, time;
  parameters.load(in, first);
  P.load(in.P, first), N.load(in.N, first), direction.load(in.direction, first);
  u.load(in.u, first), v.load(in.v, first), time.load(in.time, first);
  randomX.load(in.random_x, first), randomY.load(in.random_y, first);
  const auto query = [&](uint32_t i) {
    return LightQuery{P.vector(i), N.vector(i),  direction.vector(i), u.v[i],
                      v.v[i],      randomX.v[i], randomY.v[i],        time.v[i]};
  };
  Lanes3 towards, radiance;
  Lanes distance, pdf;
  const uint32_t count = in.count - first;
  if (in.task == PATINA_LIGHT_SAMPLE) {
    if constexpr (requires { &S::sample; }) {
      runLight<Kernel<decltype(&S::sample)>>(
          self, parameters, count, query, [&](const auto&... args) { return self.shader.sample(args...); },
          [&](uint32_t lane, const LightSample& sample) {
            towards.set(lane, sample.direction);
            distance.v[lane] = sample.distance;
            radiance.set(lane, sample.radiance);
            pdf.v[lane] = sample.pdf;
          });
      towards.store(out.direction, first);
      distance.store(out.distance, first);
      radiance.store(out.radiance, first);
      pdf.store(out.pdf, first);
    }
  } else if (in.task == PATINA_LIGHT_EVALUATE) {
    if constexpr (requires { &S::evaluate; }) {
      runLight<Kernel<decltype(&S::evaluate)>>(
          self, parameters, count, query, [&](const auto&... args) { return self.shader.evaluate(args...); },
          [&](uint32_t lane, const LightSample& sample) {
            radiance.set(lane, sample.radiance);
            pdf.v[lane] = sample.pdf;
          });
      radiance.store(out.radiance, first);
      pdf.store(out.pdf, first);
    }
  } else if (in.task == PATINA_LIGHT_EMIT) {
    if constexpr (requires { &S::emit; }) {
      runLight<Kernel<decltype(&S::emit)>>(
          self, parameters, count, query, [&](const auto&... args) { return self.shader.emit(args...); },
          [&](uint32_t lane, const Color& emitted) { radiance.set(lane, emitted); });
      radiance.store(out.radiance, first);
    }
  }
}

}  // namespace detail
}  // namespace patina::sdk
