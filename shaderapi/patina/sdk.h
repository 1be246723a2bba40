// SPDX-License-Identifier: Apache-2.0
// The C++ side of the shader ABI: a shader is a class with a description and those kernels that do something.
//
// A shader class S has
//   struct Parameters { float Kd = 1; ... };      plain data; members' initialisers are the defaults
//   static constexpr auto kInfo = describe("name", "doc",
//       uniform("Kd", &Parameters::Kd, "doc", kUnitRange), ...);
// and any of these kernels, written for one point and compiled to code for PATINA_LANES at once:
//   Radiosity radiosity(const Parameters&, const Surface<kCs | kOs>&) const;
//   View<PATINA_LOBE_GGX> view(const Parameters&, const Surface<kN | kI>&) const;
//   Displaced displacement(const Parameters&, const Surface<kP | kN>&) const;
//   LightSample sample(const Parameters&, const LightQuery&) const;
//   LightSample evaluate(const Parameters&, const LightQuery&) const;
//   Color emit(const Parameters&, const LightQuery&) const;
//   Air atmosphere(const Parameters&, const AirQuery&) const;      RI's Atmosphere
// An entry point without kernels is never called. Further, all optional:
//   PatinaStatus prepare(const Parameters&, Prepare&);
//       once per binding; may compute members and refine the traits
//   static constexpr uint64_t kTraits
//       PATINA_TRAIT_ flags that hold for every parameter value
//   static constexpr PatinaLightKind kLight
//       where it does not follow from the kernels
//   lookups(), texture()           textures (TextureLookup)
//   rays(), rayCount()             what is near the point (sdk/rays.h)
//   uint32_t lobeCount() const     lobes in use
//   PatinaStatus lightBatch(const PatinaLightIn&, PatinaLightOut&) const
//       in the place of the light's kernels
// Lobes that the host does not have are classes, too: see sdk/lobes.h; sdk/microfacets.h has some.
//
// What patterns are made of has headers of its own: sdk/noise.h (gradient noise of one to four variables),
// sdk/cells.h (cell noise, Worley), sdk/fractals.h (fBm and turbulence), sdk/filter.h (steps, pulses and
// checks), sdk/spline.h and sdk/color.h; sdk/math.h (vectors, mix, smoothstep) and sdk/matrix.h
// (Prepare::transform) are part of this one. All of it becomes vector code within a kernel, and patterns are
// to be filtered by the footprint: no supersampling hides it, for what `radiosity` gives is cached. An
// example is shaders/marble.cpp.
//
// A kernel must be a function of its arguments and of what `prepare` stored: it runs in several threads at
// once. At the file's end: PATINA_SHADERS(S, ...). The smallest example is shaders/matte.cpp.
#pragma once

#if __cplusplus < 202002L
#error "patina/sdk.h needs C++20; patina/shader.h is for C11 and C++17"
#endif

#include <cstddef>
#include <memory>
#include <new>

#include "sdk/kernels.h"
#include "sdk/matrix.h"

namespace patina::sdk {

/// What `prepare` may use and refine.
class Prepare {
 public:
  PatinaTraits& traits;  ///< filled in from the kernels' signatures before the call
  const PatinaHost& host;

  Prepare(const PatinaPrepare& in, PatinaTraits& traits_) : traits(traits_), host(*in.host), in_(in) {}

  /// The entry point has nothing to do with these parameters, and is not called.
  void disable(PatinaEntry entry) { traits.active &= ~(1u << entry); }
  /// Of a surface with uniform weights as RI's standard ones have them: what they make do nothing is not
  /// called.
  void weights(float Ka, float Kd, const Color& specular) {
    if (Kd == 0) set(PATINA_TRAIT_BLACK);
    if (Ka == 0 && Kd == 0) disable(PATINA_ENTRY_RADIOSITY);
    if (isBlack(specular)) disable(PATINA_ENTRY_VIEW);
  }
  /// Of a light: a guess at its power, for all colours to be weighed alike; a light of power 0 is switched
  /// off.
  void lightPower(const Color& power) {
    traits.light_power = std::max(luminance(power), 0.0f);
    if (isBlack(power)) disable(PATINA_ENTRY_LIGHT);
  }
  /// Of a delta light that falls off with the square of the distance: where it shines from, in world space.
  /// Many lights are then told apart by their distance. Beyond `cone` radians from `axis` there is no light.
  void lightFrom(const Point& from, const Vector& axis = Vector(0, 0, 0), float cone = kPi) {
    // Hosts of minor version 0 have no room for it.
    if (traits.struct_size < offsetof(PatinaTraits, light_cone) + sizeof(float)) return;
    traits.light_from[0] = from.x, traits.light_from[1] = from.y, traits.light_from[2] = from.z;
    traits.light_axis[0] = axis.x, traits.light_axis[1] = axis.y, traits.light_axis[2] = axis.z;
    traits.light_cone = cone;
    set(PATINA_TRAIT_FROM_POINT);
  }
  void set(uint64_t flags) { traits.flags |= flags; }
  void clear(uint64_t flags) { traits.flags &= ~flags; }

  /// nullptr for "" (nothing is asked for) and where there is no such texture (which the host has reported).
  PatinaTexture* openTexture(const char* name) const {
    return name && *name ? host.open_texture(host.host, name) : nullptr;
  }
  /// The same for values that are no colours, as heights or weights: they come as they are in the file, where
  /// openTexture() gives linear Rec.709 whatever the file's colour space is.
  PatinaTexture* openData(const char* name) const {
    if (!name || !*name) return nullptr;
    const auto* data =
        static_cast<const PatinaDataTextures*>(host.extension(host.host, PATINA_EXTENSION_DATA_TEXTURES));
    return data ? data->open(host.host, name) : openTexture(name);
  }
  void report(PatinaReport severity, int32_t code, const char* message) const {
    host.report(host.host, severity, code, message);
  }
  /// The value that the scene has given the user attribute `name` (RI: Attribute "user") where the request
  /// binds the shader. False, and `value` is as it was: there is none of its type (a parameter's, see
  /// uniform()).
  template <class T>
  bool attribute(const char* name, T& value) const {
    using Type = detail::TypeOf<T>;
    const auto* attributes =
        static_cast<const PatinaAttributes*>(host.extension(host.host, PATINA_EXTENSION_ATTRIBUTES));
    PatinaValue found{};
    if (!attributes || !attributes->get(host.host, name, Type::kId, Type::kArrayLength, &found)) return false;
    detail::readUniform(found, value);
    return true;
  }
  /// On primitives that have the user attribute `name` it takes the place of the varying parameter
  /// `parameter`, where no primitive variable does. "" = none. False: there is no such parameter, or no host
  /// that can.
  bool bindAttribute(const char* name, const char* parameter) const {
    const auto* attributes =
        static_cast<const PatinaAttributes*>(host.extension(host.host, PATINA_EXTENSION_ATTRIBUTES));
    return attributes && name && *name && attributes->bind(host.host, name, parameter) != 0;
  }
  /// From one coordinate system to another: "world", "camera", "shader", "object" or a name given by RI's
  /// CoordinateSystem. Kernels are given world space. Of a name that is not known a warning is reported, and
  /// nothing is transformed.
  Matrix transform(const char* from, const char* to) const {
    float m[16] = {};
    if (host.transform(host.host, from, to, m)) return Matrix(m);
    constexpr int32_t kUnknownSystem = -1;
    report(PATINA_REPORT_WARNING, kUnknownSystem, "a coordinate system that it names is not known");
    return Matrix();
  }
  /// Row-vector matrices between world space and that of the request which named the shader.
  const float* worldToShader() const { return in_.world_to_shader; }
  const float* shaderToWorld() const { return in_.shader_to_world; }

 private:
  const PatinaPrepare& in_;
};

/// A segment of a ray on its way from the eye: see PatinaAtmosphereIn.
struct AirQuery {
  float length;                ///< world units
  float depthAtOrigin, depth;  ///< RI's depth() at both ends; the eye's is -PATINA_INFINITE_DISTANCE
};
/// What is seen over the segment: transmittance * Ci + radiance.
struct Air {
  Color transmittance = 1, radiance = 0;
};

namespace detail {

/// The C side of shader class S: the ABI's functions and its descriptor.
template <class S>
struct Plugin {
  static constexpr bool kHasDisplacement = requires { &S::displacement; };
  static constexpr bool kHasRadiosity = requires { &S::radiosity; };
  static constexpr bool kHasView = requires { &S::view; };
  static constexpr bool kHasBatch = requires { &S::lightBatch; };
  static constexpr bool kHasSample = requires { &S::sample; };
  static constexpr bool kHasEvaluate = requires { &S::evaluate; };
  static constexpr bool kHasEmit = requires { &S::emit; };
  static constexpr bool kHasAtmosphere = requires { &S::atmosphere; };

  template <class K>
  static constexpr uint64_t reads() {
    uint64_t channels = K::kChannels;
    if constexpr (K::kTexels > 0) channels |= Kernel<decltype(&S::lookups)>::kChannels;
    if constexpr (K::kRays > 0) channels |= Kernel<decltype(&S::rays)>::kChannels;
    return channels;
  }

  static void describeKernels(PatinaTraits& traits) {
    if constexpr (kHasDisplacement) {
      using K = Kernel<decltype(&S::displacement)>;
      static_assert(!(reads<K>() & kI), "displacement does not depend on the view: it is not given I");
      static_assert(K::kRays == 0, "displacement traces no rays: it makes what they meet");
      traits.active |= 1u << PATINA_ENTRY_DISPLACEMENT;
      traits.reads[PATINA_ENTRY_DISPLACEMENT] = reads<K>();
    }
    if constexpr (kHasRadiosity) {
      using K = Kernel<decltype(&S::radiosity)>;
      static_assert(!(reads<K>() & kI), "radiosity does not depend on the view: it is not given I");
      traits.active |= 1u << PATINA_ENTRY_RADIOSITY;
      traits.reads[PATINA_ENTRY_RADIOSITY] = reads<K>();
      traits.flags = PATINA_TRAIT_EMITS | PATINA_TRAIT_TRANSMITS;
    }
    if constexpr (kHasView) {
      traits.active |= 1u << PATINA_ENTRY_VIEW;
      traits.reads[PATINA_ENTRY_VIEW] = reads<Kernel<decltype(&S::view)>>();
    }
    if constexpr (kHasBatch || kHasSample || kHasEmit) {
      traits.active |= 1u << PATINA_ENTRY_LIGHT;
      if constexpr (requires { S::kLight; })
        traits.light_kind = S::kLight;
      else
        traits.light_kind = kHasEmit       ? PATINA_LIGHT_AREA
                            : kHasEvaluate ? PATINA_LIGHT_INFINITE
                                           : PATINA_LIGHT_DELTA;
    }
    if constexpr (requires { S::kTraits; }) traits.flags = S::kTraits;
  }

  template <class Own>
  static bool registerLobes([[maybe_unused]] Instance<S>& made, [[maybe_unused]] const PatinaHost& host) {
    if constexpr (Own::kCount > 0) {
      const auto* lobes =
          static_cast<const PatinaLobeRegistry*>(host.extension(host.host, PATINA_EXTENSION_CUSTOM_LOBES));
      if (!lobes) {
        constexpr int32_t kNoCustomLobes = -2;
        host.report(
            host.host, PATINA_REPORT_ERROR, kNoCustomLobes,
            "it has lobes of its own, which this renderer does not know (" PATINA_EXTENSION_CUSTOM_LOBES ")");
        return false;
      }
      for (uint32_t k = 0; k < Own::kCount; ++k) made.ownTypes[k] = lobes->add(host.host, Own::kTables[k]);
    }
    return true;
  }

  // What an entry point traces for each point at most is the N of its last argument, or rayCount().
  template <class K>
  static bool declareRays([[maybe_unused]] Instance<S>& made, [[maybe_unused]] const PatinaHost& host,
                          [[maybe_unused]] PatinaEntry entry) {
    if constexpr (K::kRays > 0) {
      made.rays = static_cast<const PatinaRays*>(host.extension(host.host, PATINA_EXTENSION_RAYS));
      made.rayCount = K::kRays;
      if constexpr (requires { made.shader.rayCount(); })
        made.rayCount = std::min(made.rayCount, uint32_t(made.shader.rayCount()));
      constexpr int32_t kNoRays = -3;
      if (!made.rays)
        host.report(host.host, PATINA_REPORT_WARNING, kNoRays,
                    "it traces rays, which this renderer does not: they meet nothing");
      else if (made.rayCount > 0)
        return made.rays->declare(host.host, entry, made.rayCount) != 0;
    }
    return true;
  }

  // Runs `body`, and turns what it throws into a status.
  template <class Body>
  static PatinaStatus guarded(const Body& body) noexcept {
    try {
      return body();
    } catch (const std::bad_alloc&) {
      return PATINA_ERROR_RESOURCE;
    } catch (...) {
      return PATINA_ERROR_INTERNAL;
    }
  }

  template <class In, class Body>
  static PatinaStatus eachBlock(const In* in, const Body& body) noexcept {
    return guarded([&] {
      for (uint32_t first = 0; first < in->count; first += kLanes) body(first);
      return PATINA_OK;
    });
  }

  static PatinaStatus prepare(const PatinaPrepare* in, void** instance, PatinaTraits* traits) {
    return guarded([&]() -> PatinaStatus {
      std::unique_ptr<Instance<S>> made(
          new Instance<S>{S{}, ParameterTable<S>::read(in->values, in->value_stride), in->host});
      describeKernels(*traits);
      if constexpr (kHasView) {
        if (!registerLobes<OwnLobesOf<typename Kernel<decltype(&S::view)>::Result>>(*made, *in->host))
          return PATINA_ERROR_RESOURCE;
      }
      if constexpr (requires(Prepare & p) { made->shader.prepare(made->parameters, p); }) {
        Prepare context(*in, *traits);
        const PatinaStatus status = made->shader.prepare(made->parameters, context);
        if (status != PATINA_OK) return status;
      }
      const auto isActive = [&](PatinaEntry entry) { return (traits->active >> entry & 1u) != 0; };
      if constexpr (kHasRadiosity) {
        if (isActive(PATINA_ENTRY_RADIOSITY) &&
            !declareRays<Kernel<decltype(&S::radiosity)>>(*made, *in->host, PATINA_ENTRY_RADIOSITY))
          return PATINA_ERROR_RESOURCE;
      }
      if constexpr (kHasView) {
        if (isActive(PATINA_ENTRY_VIEW) &&
            !declareRays<Kernel<decltype(&S::view)>>(*made, *in->host, PATINA_ENTRY_VIEW))
          return PATINA_ERROR_RESOURCE;
      }
      if constexpr (kHasAtmosphere) {
        const auto* air = static_cast<const PatinaAtmospheres*>(
            in->host->extension(in->host->host, PATINA_EXTENSION_ATMOSPHERE));
        if (air) air->set(in->host->host, atmosphere);
      }
      *instance = made.release();
      return PATINA_OK;
    });
  }
  static PatinaStatus atmosphere(void* instance, const PatinaAtmosphereIn* in, PatinaAtmosphereOut* out) {
    return guarded([&] {
      if constexpr (kHasAtmosphere) {
        const auto at = [](const PatinaPlane& plane, uint32_t i) { return plane.data[i * plane.stride]; };
        for (uint32_t i = 0; i < in->count; ++i) {
          const Air air = self(instance).shader.atmosphere(
              self(instance).parameters, {at(in->length, i), at(in->depth_origin, i), at(in->depth, i)});
          const Color &t = air.transmittance, &r = air.radiance;
          out->transmittance.x[i] = t.r, out->transmittance.y[i] = t.g, out->transmittance.z[i] = t.b;
          out->radiance.x[i] = r.r, out->radiance.y[i] = r.g, out->radiance.z[i] = r.b;
        }
      }
      return PATINA_OK;
    });
  }
  static void release(void* instance) { delete static_cast<Instance<S>*>(instance); }

  static const Instance<S>& self(const void* instance) { return *static_cast<const Instance<S>*>(instance); }

  static PatinaStatus displacement([[maybe_unused]] void* instance, const PatinaPoints* in,
                                   [[maybe_unused]] PatinaDisplacementOut* out) {
    return eachBlock(in, [&]([[maybe_unused]] uint32_t first) {
      if constexpr (kHasDisplacement) displacementBlock<S>(self(instance), *in, first, *out);
    });
  }
  static PatinaStatus light([[maybe_unused]] void* instance, const PatinaLightIn* in,
                            [[maybe_unused]] PatinaLightOut* out) {
    if constexpr (kHasBatch)
      return guarded([&] { return self(instance).shader.lightBatch(*in, *out); });
    else
      return eachBlock(in, [&]([[maybe_unused]] uint32_t first) {
        if constexpr (kHasSample || kHasEmit) lightBlock<S>(self(instance), *in, first, *out);
      });
  }
  static PatinaStatus radiosity([[maybe_unused]] void* instance, const PatinaPoints* in,
                                [[maybe_unused]] PatinaRadiosityOut* out) {
    return eachBlock(in, [&]([[maybe_unused]] uint32_t first) {
      if constexpr (kHasRadiosity) radiosityBlock<S>(self(instance), *in, first, *out);
    });
  }
  static PatinaStatus view([[maybe_unused]] void* instance, const PatinaPoints* in,
                           [[maybe_unused]] PatinaViewOut* out) {
    return eachBlock(in, [&]([[maybe_unused]] uint32_t first) {
      if constexpr (kHasView) viewBlock<S>(self(instance), *in, first, *out);
    });
  }

  static constexpr PatinaShader kShader = {sizeof(PatinaShader),
                                           PATINA_ABI_MINOR,
                                           S::kInfo.name,
                                           S::kInfo.doc,
                                           ParameterTable<S>::kTable.data(),
                                           ParameterTable<S>::kCount,
                                           sizeof(PatinaParameter),
                                           prepare,
                                           release,
                                           displacement,
                                           light,
                                           radiosity,
                                           view};
};

}  // namespace detail
}  // namespace patina::sdk

// Exports shader classes: PATINA_SHADERS(First, Second, ...), once per plugin, outside of any namespace.
#define PATINA_SHADERS(...) \
  extern "C" const PatinaShader* const patina_shaders_v1[] = {PATINA_SDK_EACH(__VA_ARGS__) nullptr};

#define PATINA_SDK_PARENTHESES ()
#define PATINA_SDK_RESCAN(...) PATINA_SDK_RESCAN1(PATINA_SDK_RESCAN1(PATINA_SDK_RESCAN1(__VA_ARGS__)))
#define PATINA_SDK_RESCAN1(...) PATINA_SDK_RESCAN2(PATINA_SDK_RESCAN2(PATINA_SDK_RESCAN2(__VA_ARGS__)))
#define PATINA_SDK_RESCAN2(...) PATINA_SDK_RESCAN3(PATINA_SDK_RESCAN3(PATINA_SDK_RESCAN3(__VA_ARGS__)))
#define PATINA_SDK_RESCAN3(...) __VA_ARGS__
#define PATINA_SDK_EACH(...) PATINA_SDK_RESCAN(PATINA_SDK_ONE(__VA_ARGS__))
#define PATINA_SDK_ONE(shader, ...)                \
  &::patina::sdk::detail::Plugin<shader>::kShader, \
      __VA_OPT__(PATINA_SDK_AGAIN PATINA_SDK_PARENTHESES(__VA_ARGS__))
#define PATINA_SDK_AGAIN() PATINA_SDK_ONE
