// SPDX-License-Identifier: Apache-2.0
// A shader's parameters: members of a plain struct, described once, from which the ABI's table is made at
// compile time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <tuple>
#include <type_traits>
#include <utility>

#include "../shader.h"
#include "math.h"

namespace patina::sdk {

struct Range {
  double minimum = 1, maximum = 0;  ///< minimum > maximum: any value
};
inline constexpr Range kAnyRange{};
inline constexpr Range kUnitRange{0, 1};
inline constexpr Range kPositive{0, 1e30};

/// The description of one parameter; see uniform() and varying().
template <class P, class T>
struct Parameter {
  T P::*member;
  const char* name;
  const char* doc;
  Range range;
  const char* unit;
  uint32_t storage;
};

/// A parameter with one value per binding. Its type is the member's: float, int32_t, const char*, Color,
/// Point, Vector, Normal, or std::array of one of them; its default is the member's initialiser.
template <class P, class T>
constexpr Parameter<P, T> uniform(const char* name, T P::*member, const char* doc, Range range = kAnyRange,
                                  const char* unit = "") {
  return {member, name, doc, range, unit, PATINA_UNIFORM};
}

/// A parameter whose place a primitive variable of the same name may take, point by point.
template <class P, class T>
constexpr Parameter<P, T> varying(const char* name, T P::*member, const char* doc, Range range = kAnyRange,
                                  const char* unit = "") {
  return {member, name, doc, range, unit, PATINA_VARYING};
}

/// Name, one line of documentation and parameters of a shader.
template <class P, class... T>
struct Description {
  const char* name;
  const char* doc;
  std::tuple<Parameter<P, T>...> parameters;
};

struct NoParameters {};

namespace detail {
template <class P, class T>
constexpr std::tuple<Parameter<P, T>> partOf(const Parameter<P, T>& one) {
  return {one};
}
template <class... All>
constexpr std::tuple<All...> partOf(const std::tuple<All...>& group) {
  return group;
}
template <class P, class... T>
constexpr Description<P, T...> describeAll(const char* name, const char* doc,
                                           const std::tuple<Parameter<P, T>...>& all) {
  return {name, doc, all};
}
}  // namespace detail

/// Each part is a parameter, or a std::tuple of some, as shaders have in common (sdk/light_filters.h).
template <class... Part>
constexpr auto describe(const char* name, const char* doc, const Part&... parts) {
  return detail::describeAll(name, doc, std::tuple_cat(detail::partOf(parts)...));
}
constexpr Description<NoParameters> describe(const char* name, const char* doc) { return {name, doc, {}}; }

namespace detail {

// ---- Types ----------------------------------------------------------------------------------------------

template <class T>
struct TypeOf;
template <class T, uint32_t Id, uint32_t Components>
struct TypeIs {
  static constexpr uint32_t kId = Id, kComponents = Components, kArrayLength = 0;
};
template <>
struct TypeOf<float> : TypeIs<float, PATINA_FLOAT, 1> {};
template <>
struct TypeOf<int32_t> : TypeIs<int32_t, PATINA_INT, 1> {};
template <>
struct TypeOf<const char*> : TypeIs<const char*, PATINA_STRING, 1> {};
template <>
struct TypeOf<Color> : TypeIs<Color, PATINA_COLOR, 3> {};
template <>
struct TypeOf<Point> : TypeIs<Point, PATINA_POINT, 3> {};
template <>
struct TypeOf<Vector> : TypeIs<Vector, PATINA_VECTOR, 3> {};
template <>
struct TypeOf<Normal> : TypeIs<Normal, PATINA_NORMAL, 3> {};
template <class T, size_t N>
struct TypeOf<std::array<T, N>> {
  static constexpr uint32_t kId = TypeOf<T>::kId, kComponents = TypeOf<T>::kComponents * uint32_t(N),
                            kArrayLength = N;
};

template <class T>
inline constexpr bool kIsFloats = TypeOf<T>::kId != PATINA_INT&& TypeOf<T>::kId != PATINA_STRING;

// Writes the components of a value one after the other.
template <class Out>
constexpr Out* flatten(float v, Out* out) {
  return *out = v, out + 1;
}
template <class Out>
constexpr Out* flatten(int32_t v, Out* out) {
  return *out = v, out + 1;
}
template <class Out>
constexpr Out* flatten(const char* v, Out* out) {
  return *out = v, out + 1;
}
template <class Out>
constexpr Out* flatten(const Color& v, Out* out) {
  return out[0] = v.r, out[1] = v.g, out[2] = v.b, out + 3;
}
template <class Out>
constexpr Out* flatten(const Vector& v, Out* out) {
  return out[0] = v.x, out[1] = v.y, out[2] = v.z, out + 3;
}
template <class T, size_t N, class Out>
constexpr Out* flatten(const std::array<T, N>& v, Out* out) {
  for (const T& element : v) out = flatten(element, out);
  return out;
}

// The reverse: a value from component c = at(c).
template <class At>
PATINA_INLINE void gather(float& v, uint32_t c, const At& at) {
  v = at(c);
}
template <class At>
PATINA_INLINE void gather(Color& v, uint32_t c, const At& at) {
  v = Color(at(c), at(c + 1), at(c + 2));
}
template <class At>
PATINA_INLINE void gather(Vector& v, uint32_t c, const At& at) {
  v = Vector(at(c), at(c + 1), at(c + 2));
}
template <class T, size_t N, class At>
PATINA_INLINE void gather(std::array<T, N>& v, uint32_t c, const At& at) {
  for (size_t i = 0; i < N; ++i) gather(v[i], c + uint32_t(i) * TypeOf<T>::kComponents, at);
}

PATINA_INLINE const PatinaValue& valueAt(const PatinaValue* values, uint32_t stride, uint32_t index) {
  return *reinterpret_cast<const PatinaValue*>(reinterpret_cast<const std::byte*>(values) +
                                               size_t(index) * stride);
}

// A uniform value into a variable of its type.
template <class T>
void readUniform(const PatinaValue& value, T& to) {
  if constexpr (kIsFloats<T>)
    gather(to, 0, [&](uint32_t c) { return value.floats[c * value.plane]; });
  else if constexpr (TypeOf<T>::kArrayLength != 0)
    for (size_t k = 0; k < to.size(); ++k) {
      if constexpr (TypeOf<typename T::value_type>::kId == PATINA_INT)
        to[k] = value.ints[k];
      else
        to[k] = value.strings[k];
    }
  else if constexpr (TypeOf<T>::kId == PATINA_INT)
    to = value.ints[0];
  else
    to = value.strings[0];
}

// ---- The ABI's table ------------------------------------------------------------------------------------

// Everything about the parameters of shader class S that is known at compile time.
template <class S>
struct ParameterTable {
  template <class P, class... T>
  static constexpr P structOf(const Description<P, T...>&);
  using Info = std::remove_cvref_t<decltype(S::kInfo)>;
  using Struct = decltype(structOf(S::kInfo));
  static constexpr uint32_t kCount = std::tuple_size_v<decltype(Info::parameters)>;

  template <uint32_t I>
  using Type = std::remove_cvref_t<decltype(std::declval<Struct>().*
                                            (std::get<I>(std::declval<Info>().parameters).member))>;

  // Calls f(std::integral_constant<uint32_t, i>, parameter i) for each parameter.
  template <class F>
  PATINA_INLINE static constexpr void each(const F& f) {
    [&]<uint32_t... I>(std::integer_sequence<uint32_t, I...>) {
      (f(std::integral_constant<uint32_t, I>(), std::get<I>(S::kInfo.parameters)), ...);
    }
    (std::make_integer_sequence<uint32_t, kCount>());
  }

  // How many components those parameters have whose type is like `like`.
  static constexpr uint32_t total(uint32_t like) {
    uint32_t sum = 0;
    each([&](auto i, const auto&) {
      using T = Type<i>;
      const uint32_t kind = kIsFloats<T> ? uint32_t(PATINA_FLOAT) : TypeOf<T>::kId;
      if (kind == like) sum += TypeOf<T>::kComponents;
    });
    return sum;
  }

  struct Storage {
    std::array<float, total(PATINA_FLOAT) + 1> floats{};
    std::array<int32_t, total(PATINA_INT) + 1> ints{};
    std::array<const char*, total(PATINA_STRING) + 1> strings{};
  };
  static constexpr Storage makeDefaults() {
    Storage storage;
    const Struct defaults{};
    float* floats = storage.floats.data();
    int32_t* ints = storage.ints.data();
    const char** strings = storage.strings.data();
    each([&](auto i, const auto& parameter) {
      using T = Type<i>;
      if constexpr (kIsFloats<T>)
        floats = flatten(defaults.*(parameter.member), floats);
      else if constexpr (TypeOf<T>::kId == PATINA_INT)
        ints = flatten(defaults.*(parameter.member), ints);
      else
        strings = flatten(defaults.*(parameter.member), strings);
    });
    return storage;
  }
  static constexpr Storage kDefaults = makeDefaults();

  static constexpr std::array<PatinaParameter, kCount + 1> makeTable() {
    std::array<PatinaParameter, kCount + 1> table{};
    uint32_t floats = 0, ints = 0, strings = 0;
    each([&](auto i, const auto& parameter) {
      using T = Type<i>;
      PatinaParameter& p = table[i];
      p.struct_size = sizeof(PatinaParameter);
      p.type = TypeOf<T>::kId;
      p.storage = parameter.storage;
      p.array_length = TypeOf<T>::kArrayLength;
      p.name = parameter.name;
      p.doc = parameter.doc;
      p.unit = parameter.unit;
      p.minimum = parameter.range.minimum;
      p.maximum = parameter.range.maximum;
      if constexpr (kIsFloats<T>) {
        p.default_floats = &kDefaults.floats[floats];
        floats += TypeOf<T>::kComponents;
      } else if constexpr (TypeOf<T>::kId == PATINA_INT) {
        p.default_ints = &kDefaults.ints[ints];
        ints += TypeOf<T>::kComponents;
      } else {
        p.default_strings = &kDefaults.strings[strings];
        strings += TypeOf<T>::kComponents;
      }
    });
    return table;
  }
  static constexpr std::array<PatinaParameter, kCount + 1> kTable = makeTable();

  // The struct as `prepare` is given it.
  static Struct read(const PatinaValue* values, uint32_t stride) {
    Struct result{};
    each([&](auto i, const auto& parameter) {
      readUniform(valueAt(values, stride, i), result.*(parameter.member));
    });
    return result;
  }
};

}  // namespace detail
}  // namespace patina::sdk
