// SPDX-License-Identifier: Apache-2.0
// Checks of a batch's results, and one of its lanes called again by itself.
#include "renderer/shading/shader_validation.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "renderer/shading/planes.h"
#include "renderer/shading/ray_service.h"

namespace patina {

std::atomic<bool> detail::shaderValidation{false};
void setShaderValidation(bool on) { detail::shaderValidation.store(on, std::memory_order_relaxed); }

namespace {

constexpr float kSlack = 1e-4f;   // of sums of products of floats in [0, 1]
constexpr uint32_t kSampled = 7;  // of so many batches of a thread one is looked at more closely

// What is handed over again is copied member by member: new ones are to be copied as well.
static_assert(sizeof(PatinaPoints) == 616, "SingleLane copies every plane of a batch");
static_assert(sizeof(PatinaValue) == 40, "SingleLane copies every value of a batch");
static_assert(sizeof(PatinaRadiosityOut) == 128,
              "radiosityAlone() fills every plane, and numbersOf() compares it");
static_assert(sizeof(PatinaLobe) == 88 && sizeof(PatinaViewOut) == 48,
              "viewAlone() fills every plane, and numbersOf() compares it");
static_assert(sizeof(PatinaDisplacementOut) == 56, "so does validateDisplacement()");

// The codes of messages; see ShaderHost::Fault for others.
enum Kind : int32_t {
  kEnergy = -100,
  kOpacity,
  kNegative,
  kTraits,
  kLobe,
  kBound,
  kUndeclared = -200,  // minus the entry point
  kAlone = -300,
  kDamage = -350
};

constexpr const char* kEntries[] = {"displacement", "light", "radiosity", "view"};

void fault(const ShaderInstance& shader, int32_t kind, const std::string& what) {
  const PatinaHost& host = shader.host();
  host.report(host.host, PATINA_REPORT_ERROR, kind, what.c_str());
}

V3f triple(const PatinaOut3& out, size_t i) { return {out.x[i], out.y[i], out.z[i]}; }
std::string text(const V3f& v) { return fmt::format("({}, {}, {})", v.x, v.y, v.z); }
bool isFinite3(const V3f& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }
bool isZero(const V3f& v) { return v.x == 0 && v.y == 0 && v.z == 0; }
float least(const V3f& v) { return std::min({v.x, v.y, v.z}); }
float greatest(const V3f& v) { return std::max({v.x, v.y, v.z}); }

// ---- One lane again -------------------------------------------------------------------------------------

/// The channels of a batch by their bits.
struct Channel {
  uint64_t bit;
  const char* name;
  std::array<PatinaPlane PatinaPoints::*, 2> planes;
  std::array<PatinaPlane3 PatinaPoints::*, 1> triples;
};
constexpr Channel kChannels[] = {
    {PATINA_CHANNEL_P, "P", {}, {&PatinaPoints::P}},
    {PATINA_CHANNEL_N, "N", {}, {&PatinaPoints::N}},
    {PATINA_CHANNEL_NG, "Ng", {}, {&PatinaPoints::Ng}},
    {PATINA_CHANNEL_DPDU, "dPdu", {}, {&PatinaPoints::dPdu}},
    {PATINA_CHANNEL_DPDV, "dPdv", {}, {&PatinaPoints::dPdv}},
    {PATINA_CHANNEL_UV, "u, v", {&PatinaPoints::u, &PatinaPoints::v}, {}},
    {PATINA_CHANNEL_ST, "s, t", {&PatinaPoints::s, &PatinaPoints::t}, {}},
    {PATINA_CHANNEL_FOOTPRINT, "footprint", {&PatinaPoints::footprint, &PatinaPoints::footprint_st}, {}},
    {PATINA_CHANNEL_CS, "Cs", {}, {&PatinaPoints::Cs}},
    {PATINA_CHANNEL_OS, "Os", {}, {&PatinaPoints::Os}},
    {PATINA_CHANNEL_I, "I", {}, {&PatinaPoints::I}},
    {PATINA_CHANNEL_TIME, "time", {&PatinaPoints::time}, {}},
    {PATINA_CHANNEL_DPDS, "dPds", {}, {&PatinaPoints::dPds}},
    {PATINA_CHANNEL_DPDT, "dPdt", {}, {&PatinaPoints::dPdt}},
};

/// A batch of one lane of another one.
class SingleLane {
 public:
  /// Channels in `poisoned` are NaN.
  SingleLane(const ShaderInstance& shader, const PatinaPoints& in, uint32_t lane, uint64_t poisoned)
      : points(in) {
    planes.begin(1);
    points.count = 1, points.padded = static_cast<uint32_t>(planes.padded());
    for (const Channel& channel : kChannels) {
      const bool poison = (poisoned & channel.bit) != 0;
      for (const auto member : channel.planes)
        if (member) points.*member = plane(in.*member, lane, poison);
      for (const auto member : channel.triples)
        if (member) {
          const PatinaPlane3& from = in.*member;
          points.*member = {plane(from.x, lane, poison), plane(from.y, lane, poison),
                            plane(from.z, lane, poison)};
        }
    }
    for (size_t k = 0; k < shader.values().size(); ++k) {
      PatinaValue value = *reinterpret_cast<const PatinaValue*>(
          reinterpret_cast<const std::byte*>(in.values) + k * in.value_stride);
      if (value.floats && value.stride == 1) {
        float* floats = planes.take(value.count);
        for (uint32_t c = 0; c < value.count; ++c)
          std::fill_n(floats + c * planes.padded(), planes.padded(),
                      value.floats[size_t(c) * value.plane + lane]);
        value.floats = floats, value.plane = points.padded;
      }
      values_.push_back(value);
    }
    points.values = values_.data(), points.value_stride = sizeof(PatinaValue);
  }

  PatinaPoints points;
  Planes planes;

 private:
  PatinaPlane plane(const PatinaPlane& from, uint32_t lane, bool poison) {
    if (poison) return planes.uniform(std::numeric_limits<float>::quiet_NaN());
    if (!from.data) return from;
    return planes.fill(1, [&](size_t) { return from.data[size_t(lane) * from.stride]; });
  }
  std::vector<PatinaValue> values_;
};

/// What a lane gives: all its numbers, one after the other.
using Numbers = std::vector<float>;
void append(Numbers& to, const PatinaOut3& out, size_t lane) {
  for (const float* plane : {out.x, out.y, out.z}) to.push_back(plane[lane]);
}
bool same(const Numbers& a, const Numbers& b) {
  if (a.size() != b.size()) return false;
  for (size_t i = 0; i < a.size(); ++i)
    if (std::bit_cast<uint32_t>(a[i]) != std::bit_cast<uint32_t>(b[i]) &&
        !(std::isnan(a[i]) && std::isnan(b[i])))
      return false;
  return true;
}

Numbers numbersOf(const PatinaRadiosityOut& out, size_t lane) {
  Numbers numbers;
  for (const PatinaOut3* part :
       {&out.emission, &out.reflectance, &out.transmittance, &out.ambient, &out.opacity})
    append(numbers, *part, lane);
  return numbers;
}
const PatinaLobe& lobeOf(const PatinaViewOut& out, uint32_t k) {
  return *reinterpret_cast<const PatinaLobe*>(reinterpret_cast<const std::byte*>(out.lobes) +
                                              size_t(k) * out.lobe_stride);
}
uint32_t lobeCount(const PatinaViewOut& out) { return std::min(out.lobe_count, PATINA_MAX_LOBES); }
Numbers numbersOf(const PatinaViewOut& out, size_t lane) {
  Numbers numbers;
  append(numbers, out.emission, lane);
  for (uint32_t k = 0; k < lobeCount(out); ++k) {
    const PatinaLobe& lobe = lobeOf(out, k);
    append(numbers, lobe.weight, lane), append(numbers, lobe.transmission, lane);
    numbers.push_back(lobe.alpha[lane]), numbers.push_back(lobe.eta[lane]);
    numbers.push_back(static_cast<float>(lobe.type));
    for (uint32_t c = 0; c < lobe.data_count; ++c) numbers.push_back(lobe.data[c][lane]);
  }
  return numbers;
}
Numbers numbersOf(const PatinaDisplacementOut& out, size_t lane) {
  Numbers numbers;
  append(numbers, out.P, lane);
  if (out.writes_normal) append(numbers, out.N, lane);
  return numbers;
}

Numbers radiosityAlone(const ShaderInstance& shader, SingleLane& single) {
  Planes& planes = single.planes;
  PatinaRadiosityOut out{};
  out.struct_size = sizeof out;
  out.emission = planes.out3(0), out.reflectance = planes.out3(0), out.transmittance = planes.out3(0);
  out.ambient = planes.out3(0), out.opacity = planes.out3(1);
  return shader.radiosity(single.points, out) == PATINA_OK ? numbersOf(out, 0) : Numbers();
}
Numbers viewAlone(const ShaderInstance& shader, SingleLane& single) {
  Planes& planes = single.planes;
  std::array<PatinaLobe, PATINA_MAX_LOBES> lobes{};
  std::array<std::array<float*, PATINA_LOBE_DATA>, PATINA_MAX_LOBES> data;
  for (size_t k = 0; k < lobes.size(); ++k) {
    PatinaLobe& lobe = lobes[k];
    lobe.struct_size = sizeof lobe;
    lobe.data_count = shader.lobeDataCount();
    for (uint32_t c = 0; c < lobe.data_count; ++c) data[k][c] = planes.out(0);
    if (lobe.data_count > 0) lobe.data = data[k].data();
    lobe.weight = planes.out3(0), lobe.transmission = planes.out3(0);
    lobe.alpha = planes.out(0), lobe.eta = planes.out(1);
  }
  PatinaViewOut out{};
  out.struct_size = sizeof out;
  out.emission = planes.out3(0);
  out.lobes = lobes.data(), out.lobe_stride = sizeof(PatinaLobe);
  return shader.view(single.points, out) == PATINA_OK ? numbersOf(out, 0) : Numbers();
}

/// Calls a lane of some of the batches again.
template <class Out, class Call>
void callAgain(const ShaderInstance& shader, PatinaEntry entry, const PatinaPoints& in, const Out& out,
               const LanePlace& place, const Call& call) {
  thread_local uint32_t batches = 0;
  const uint32_t batch = batches++;
  if (batch % kSampled != 0 || in.count == 0) return;
  const uint32_t lane = (batch / kSampled) % in.count;
  const Numbers together = numbersOf(out, lane);
  const auto alone = [&](uint64_t poisoned) {
    SingleLane single(shader, in, lane, poisoned);
    const RayCall rays(lane);
    return call(single, lane);
  };
  if (!same(alone(0), together))
    return fault(shader, kAlone - static_cast<int32_t>(entry),
                 fmt::format("{} gives a point other values alone than in a batch of {}. The first is at {}",
                             kEntries[entry], in.count, place(lane)));
  const uint64_t undeclared = ~shader.reads(entry);
  if (same(alone(undeclared), together)) return;
  for (const Channel& channel : kChannels)
    if ((undeclared & channel.bit) && !same(alone(channel.bit), together))
      fault(shader, kUndeclared - static_cast<int32_t>(entry),
            fmt::format("{} reads {}, which its traits do not declare. The first point is at {}",
                        kEntries[entry], channel.name, place(lane)));
}

}  // namespace

void reportDamage(const ShaderInstance& shader, const char* entry, Planes& planes, const LanePlace& place) {
  const Planes::Damage damage = planes.takeDamage();
  if (!damage.plane) return;
  fault(shader, kDamage,
        damage.index < 0
            ? fmt::format("{} writes {} floats before the beginning of a plane. The first point is at {}",
                          entry, -damage.index, place(0))
            : fmt::format("{} writes behind the end of a plane: to index {} of {}. The first point is at {}",
                          entry, damage.index, damage.size, place(0)));
}

void validateRadiosity(const ShaderInstance& shader, const PatinaPoints& in, const PatinaRadiosityOut& out,
                       const LanePlace& place) {
  for (uint32_t i = 0; i < in.count; ++i) {
    const V3f emission = triple(out.emission, i), reflected = triple(out.reflectance, i);
    const V3f let = triple(out.transmittance, i), ambient = triple(out.ambient, i),
              opacity = triple(out.opacity, i);
    if (!(isFinite3(emission) && isFinite3(reflected) && isFinite3(let) && isFinite3(ambient) &&
          isFinite3(opacity)))
      continue;  // which is reported elsewhere
    const auto wrong = [&](Kind kind, const char* what, const V3f& value) {
      fault(shader, kind, fmt::format("radiosity {}: {}. The first is at {}", what, text(value), place(i)));
    };
    if (greatest(reflected + let) > 1 + kSlack)
      wrong(kEnergy, "makes energy: reflectance + transmittance is more than 1", reflected + let);
    else if (greatest(reflected + let - opacity) > kSlack)
      wrong(kEnergy,
            "makes energy: reflectance + transmittance is more than the opacity, by which they are to be "
            "multiplied",
            reflected + let);
    if (least(opacity) < -kSlack || greatest(opacity) > 1 + kSlack)
      wrong(kOpacity, "gives an opacity outside of [0, 1]", opacity);
    if (least(emission) < -1e-6f || least(reflected) < -1e-6f || least(let) < -1e-6f ||
        least(ambient) < -1e-6f)
      wrong(kNegative, "gives a negative emission, reflectance, transmittance or ambient; the emission is",
            emission);
    if (shader.has(PATINA_TRAIT_OPAQUE) && opacity != V3f(1))
      wrong(kTraits, "is not opaque, though its traits say OPAQUE", opacity);
    if (shader.has(PATINA_TRAIT_TRANSPARENT) && !(isZero(opacity) && isZero(emission)))
      wrong(kTraits, "is opaque or emits, though its traits say TRANSPARENT", opacity);
    if (shader.has(PATINA_TRAIT_BLACK) && !(isZero(reflected) && isZero(let)))
      wrong(kTraits, "reflects or transmits, though its traits say BLACK", reflected + let);
    if (!shader.has(PATINA_TRAIT_EMITS) && !isZero(emission))
      wrong(kTraits, "emits, though its traits do not say EMITS", emission);
    if (!shader.has(PATINA_TRAIT_TRANSMITS) && !isZero(let))
      wrong(kTraits, "transmits, though its traits do not say TRANSMITS", let);
    if (shader.has(PATINA_TRAIT_OPACITY_IS_OS) && in.Os.x.data) {
      const auto at = [&](const PatinaPlane& plane) { return plane.data[size_t(i) * plane.stride]; };
      const V3f Os(at(in.Os.x), at(in.Os.y), at(in.Os.z));
      if (greatest(opacity - Os) > 1e-6f || greatest(Os - opacity) > 1e-6f)
        wrong(kTraits, "has another opacity than Os, though its traits say OPACITY_IS_OS", opacity);
    }
  }
  callAgain(shader, PATINA_ENTRY_RADIOSITY, in, out, place,
            [&](SingleLane& single, uint32_t) { return radiosityAlone(shader, single); });
}

void validateView(const ShaderInstance& shader, const PatinaPoints& in, const PatinaViewOut& out,
                  const LanePlace& place) {
  for (uint32_t k = 0; k < lobeCount(out); ++k) {
    const PatinaLobe& lobe = lobeOf(out, k);
    for (uint32_t i = 0; i < in.count; ++i) {
      const V3f weight = triple(lobe.weight, i), let = triple(lobe.transmission, i);
      if (!isFinite3(weight) || !isFinite3(let)) continue;
      if (std::min(least(weight), least(let)) < -1e-6f ||
          std::max(greatest(weight), greatest(let)) > 1 + kSlack)
        fault(shader, kLobe,
              fmt::format("view gives lobe {} a weight {} or a transmission {} outside of [0, 1]. The "
                          "first is at {}",
                          k, text(weight), text(let), place(i)));
    }
  }
  callAgain(shader, PATINA_ENTRY_VIEW, in, out, place,
            [&](SingleLane& single, uint32_t) { return viewAlone(shader, single); });
}

void validateDisplacement(const ShaderInstance& shader, const PatinaPoints& in,
                          const PatinaDisplacementOut& out, std::span<const V3f> P, std::span<const V3f> N,
                          const LanePlace& place) {
  if (const float bound = shader.traits().displacement_bound; bound > 0)
    for (uint32_t i = 0; i < in.count; ++i) {
      const V3f moved = triple(out.P, i) - P[i];
      const float rounding = 1e-6f * (std::abs(P[i].x) + std::abs(P[i].y) + std::abs(P[i].z));
      if (isFinite3(moved) && moved.length() > bound * (1 + kSlack) + rounding)
        fault(shader, kBound,
              fmt::format(
                  "displacement moves P by {}, further than its displacement_bound {}. The first is at {}",
                  moved.length(), bound, place(i)));
    }
  callAgain(shader, PATINA_ENTRY_DISPLACEMENT, in, out, place, [&](SingleLane& single, uint32_t lane) {
    Planes& planes = single.planes;
    const auto fill = [&](const V3f& v) {
      return PatinaOut3{planes.out(v.x), planes.out(v.y), planes.out(v.z)};
    };
    PatinaDisplacementOut again{};
    again.struct_size = sizeof again;
    again.P = fill(P[lane]), again.N = fill(N[lane]);
    return shader.displacement(single.points, again) == PATINA_OK ? numbersOf(again, 0) : Numbers();
  });
}

}  // namespace patina
