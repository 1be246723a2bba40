// SPDX-License-Identifier: Apache-2.0
// Planes in and out of an entry point.
#include "renderer/shadercheck/batch.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "renderer/base/sampling.h"
#include "renderer/shadercheck/check_host.h"
#include "renderer/shadercheck/parameter_set.h"
#include "renderer/shading/plugin_file.h"

namespace patina::shadercheck {
namespace {

uint32_t columnsOf(Call call) {
  switch (call) {
    case Call::Displacement:
      return 6;
    case Call::Radiosity:
      return 15;
    case Call::View:
      return kFirstLobe + kLobeColumns * PATINA_MAX_LOBES;
    default:
      return 8;
  }
}

// What the renderer fills outputs with before the call; of displacement, see reset().
float initialOf(Call call, uint32_t column) {
  if (call == Call::Radiosity) return column >= kOpacity ? 1.0f : 0.0f;
  if (call == Call::View)
    return column >= kFirstLobe && column < kFirstLobeData && (column - kFirstLobe) % kLobeColumns == kLobeEta
               ? 1.0f
               : 0.0f;
  return column == kLightDistance ? PATINA_INFINITE_DISTANCE : 0.0f;
}

std::string component(std::string_view name, uint32_t index) {
  return fmt::format("{}.{}", name, "xyz"[index]);
}

std::string lobeColumnName(uint32_t column) {
  if (column >= kFirstLobeData) return fmt::format("lobe data {}", column - kFirstLobeData);
  const uint32_t lobe = (column - kFirstLobe) / kLobeColumns, part = (column - kFirstLobe) % kLobeColumns;
  const std::string what = part >= kLobeEta            ? "eta"
                           : part >= kLobeAlpha        ? "alpha"
                           : part >= kLobeTransmission ? component("transmission", part - kLobeTransmission)
                                                       : component("weight", part);
  return fmt::format("lobe {} {}", lobe, what);
}

bool sameBits(float a, float b) {
  return std::bit_cast<uint32_t>(a) == std::bit_cast<uint32_t>(b) || (std::isnan(a) && std::isnan(b));
}

}  // namespace

std::string_view callName(Call call) {
  static constexpr std::string_view kNames[] = {"displacement",   "radiosity",        "view",
                                                "light (sample)", "light (evaluate)", "light (emit)"};
  return kNames[static_cast<size_t>(call)];
}

PatinaEntry entryOf(Call call) {
  switch (call) {
    case Call::Displacement:
      return PATINA_ENTRY_DISPLACEMENT;
    case Call::Radiosity:
      return PATINA_ENTRY_RADIOSITY;
    case Call::View:
      return PATINA_ENTRY_VIEW;
    default:
      return PATINA_ENTRY_LIGHT;
  }
}

std::string columnName(Call call, uint32_t column) {
  static constexpr std::string_view kTerms[] = {"emission", "reflectance", "transmittance", "ambient",
                                                "opacity"};
  if (call == Call::Displacement) return component(column < kMovedN ? "P" : "N", column % 3);
  if (call == Call::Radiosity) return component(kTerms[column / 3], column % 3);
  if (call == Call::View) return column < kFirstLobe ? component("emission", column) : lobeColumnName(column);
  if (column < kLightDistance) return component("direction", column);
  if (column == kLightDistance) return "distance";
  return column < kLightPdf ? component("radiance", column - kLightRadiance) : "pdf";
}

std::string difference(Call call, const Output& a, uint32_t laneA, const Output& b, uint32_t laneB) {
  if (a.status != b.status) return fmt::format("the status is {} and {}", a.status, b.status);
  if (a.lobeCount != b.lobeCount || a.lobeTypes != b.lobeTypes) return "the lobes are others";
  if (a.writesNormal != b.writesNormal) return "normals are written once, and once not";
  for (uint32_t c = 0; c < a.columns; ++c)
    if (!sameBits(a.at(laneA, c), b.at(laneB, c)))
      return fmt::format("{} is {} and {}", columnName(call, c), a.at(laneA, c), b.at(laneB, c));
  return {};
}

Batch::Batch(const PatinaShader& shader, const PatinaTraits& traits, Call call,
             std::span<const PatinaValue> values, std::span<const Lane> lanes, const Layout& layout,
             uint32_t lobeData)
    : shader_(shader),
      call_(call),
      lightKind_(traits.light_kind),
      lobeData_(call == Call::View ? lobeData : 0),
      lanes_(lanes.begin(), lanes.end()),
      count_(static_cast<uint32_t>(lanes.size())),
      padded_((count_ + PATINA_LANES - 1) / PATINA_LANES * PATINA_LANES) {
  const std::vector<Lane> filler = makeLanes(padded_ - count_, layout.padding);
  for (const Lane& other : filler) lanes_.push_back(layout.padding ? other : lanes.back());
  fillParameters(layout, values);
  if (entryOf(call) == PATINA_ENTRY_LIGHT)
    fillLight(layout);
  else
    fillSurface(layout);
  makeOutputs();
  reset();
}

// Values of another lane stand for "something else that is valid".
template <class Value>
PatinaPlane Batch::plane(const Layout& layout, uint64_t channel, const char* name, Value value) {
  if (!(layout.channels & channel)) return {};
  const uint32_t length = layout.oneForAll ? 1 : padded_;
  std::vector<float> numbers(length);
  for (uint32_t i = 0; i < length; ++i) {
    const Lane other = layout.foreign & channel ? makeLanes(1, hashOf(lanes_[i].id, 77u))[0] : lanes_[i];
    numbers[i] = layout.nan & channel ? std::numeric_limits<float>::quiet_NaN() : value(other);
  }
  return {memory_.input(numbers, name), layout.oneForAll ? 0u : 1u, 0};
}

template <class Value>
PatinaPlane3 Batch::plane3(const Layout& layout, uint64_t channel, const char* name, Value value) {
  return {plane(layout, channel, name, [&](const Lane& lane) { return value(lane).x; }),
          plane(layout, channel, name, [&](const Lane& lane) { return value(lane).y; }),
          plane(layout, channel, name, [&](const Lane& lane) { return value(lane).z; })};
}

void Batch::fillSurface(const Layout& layout) {
  const auto vector = [&](uint64_t channel, const char* name, V3f Lane::*member) {
    return plane3(layout, channel, name, [member](const Lane& lane) { return lane.*member; });
  };
  const auto number = [&](uint64_t channel, const char* name, float Lane::*member) {
    return plane(layout, channel, name, [member](const Lane& lane) { return lane.*member; });
  };
  points_.struct_size = sizeof points_;
  points_.count = count_, points_.padded = padded_;
  points_.value_stride = sizeof(PatinaValue);
  points_.values = values_.data();
  points_.P = vector(PATINA_CHANNEL_P, "P", &Lane::P);
  points_.N = vector(PATINA_CHANNEL_N, "N", &Lane::N);
  points_.Ng = vector(PATINA_CHANNEL_NG, "Ng", &Lane::Ng);
  points_.dPdu = vector(PATINA_CHANNEL_DPDU, "dPdu", &Lane::dPdu);
  points_.dPdv = vector(PATINA_CHANNEL_DPDV, "dPdv", &Lane::dPdv);
  points_.u = number(PATINA_CHANNEL_UV, "u", &Lane::u), points_.v = number(PATINA_CHANNEL_UV, "v", &Lane::v);
  points_.s = number(PATINA_CHANNEL_ST, "s", &Lane::s), points_.t = number(PATINA_CHANNEL_ST, "t", &Lane::t);
  points_.footprint = number(PATINA_CHANNEL_FOOTPRINT, "footprint", &Lane::footprint);
  points_.footprint_st = number(PATINA_CHANNEL_FOOTPRINT, "footprint_st", &Lane::footprintSt);
  points_.Cs = vector(PATINA_CHANNEL_CS, "Cs", &Lane::Cs);
  points_.Os = vector(PATINA_CHANNEL_OS, "Os", &Lane::Os);
  points_.time = number(PATINA_CHANNEL_TIME, "time", &Lane::time);
  points_.I = vector(PATINA_CHANNEL_I, "I", &Lane::I);
  points_.dPds = vector(PATINA_CHANNEL_DPDS, "dPds", &Lane::dPds);
  points_.dPdt = vector(PATINA_CHANNEL_DPDT, "dPdt", &Lane::dPdt);
}

void Batch::fillLight(const Layout& layout) {
  const auto vector = [&](uint64_t channel, const char* name, V3f Lane::*member) {
    return plane3(layout, channel, name, [member](const Lane& lane) { return lane.*member; });
  };
  const auto number = [&](uint64_t channel, const char* name, float Lane::*member) {
    return plane(layout, channel, name, [member](const Lane& lane) { return lane.*member; });
  };
  lightIn_.struct_size = sizeof lightIn_;
  lightIn_.count = count_, lightIn_.padded = padded_;
  lightIn_.task = call_ == Call::LightSample     ? PATINA_LIGHT_SAMPLE
                  : call_ == Call::LightEvaluate ? PATINA_LIGHT_EVALUATE
                                                 : PATINA_LIGHT_EMIT;
  lightIn_.values = values_.data();
  lightIn_.value_stride = sizeof(PatinaValue);
  lightIn_.P = vector(PATINA_CHANNEL_P, "P", &Lane::P);
  lightIn_.N = vector(PATINA_CHANNEL_N, "N", &Lane::N);
  lightIn_.direction = vector(kChannelDirection, "direction", &Lane::direction);
  lightIn_.u = number(PATINA_CHANNEL_UV, "u", &Lane::u),
  lightIn_.v = number(PATINA_CHANNEL_UV, "v", &Lane::v);
  lightIn_.random_x = number(kChannelRandom, "random_x", &Lane::randomX);
  lightIn_.random_y = number(kChannelRandom, "random_y", &Lane::randomY);
  lightIn_.time = number(PATINA_CHANNEL_TIME, "time", &Lane::time);
}

// Only surfaces and displacements have primitive variables to replace parameters.
void Batch::fillParameters(const Layout& layout, std::span<const PatinaValue> values) {
  values_.assign(values.begin(), values.end());
  if (layout.parameters == Layout::Uniform || entryOf(call_) == PATINA_ENTRY_LIGHT) return;
  for (uint32_t k = 0; k < values_.size(); ++k) {
    const PatinaParameter& parameter = parameterOf(shader_, k);
    if (parameter.storage != PATINA_VARYING) continue;
    PatinaValue& value = values_[k];
    std::vector<float> numbers(size_t(value.count) * padded_);
    for (uint32_t c = 0; c < value.count; ++c)
      for (uint32_t i = 0; i < padded_; ++i)
        numbers[size_t(c) * padded_ + i] = layout.parameters == Layout::Spread
                                               ? values[k].floats[c * values[k].plane]
                                               : drawWithin(parameter, hashOf(lanes_[i].id, k, c));
    value.floats = memory_.input(numbers, parameter.name);
    value.stride = 1, value.plane = padded_, value.is_set = 1;
  }
}

void Batch::makeOutputs() {
  for (uint32_t c = 0; c < columnsOf(call_) + lobeData_ * PATINA_MAX_LOBES; ++c)
    columns_.push_back(memory_.output(padded_, columnName(call_, c)));
  const auto triple = [&](uint32_t c) { return PatinaOut3{columns_[c], columns_[c + 1], columns_[c + 2]}; };
  switch (call_) {
    case Call::Displacement:
      displaced_ = {sizeof displaced_, 0, triple(kMovedP), triple(kMovedN)};
      break;
    case Call::Radiosity:
      radiosity_ = {sizeof radiosity_,      0,
                    triple(kEmission),      triple(kReflectance),
                    triple(kTransmittance), triple(kAmbient),
                    triple(kOpacity)};
      break;
    case Call::View:
      for (uint32_t k = 0; k < PATINA_MAX_LOBES; ++k) {
        const uint32_t c = kFirstLobe + kLobeColumns * k;
        lobes_[k] = {sizeof(PatinaLobe),
                     0,
                     triple(c + kLobeWeight),
                     triple(c + kLobeTransmission),
                     columns_[c + kLobeAlpha],
                     columns_[c + kLobeEta],
                     nullptr,
                     lobeData_,
                     0};
        if (lobeData_) lobes_[k].data = &columns_[kFirstLobeData + k * lobeData_];
      }
      view_ = {sizeof view_, 0, triple(kEmission), lobes_.data(), sizeof(PatinaLobe), 0};
      break;
    default:
      lightOut_ = {sizeof lightOut_,        0,
                   triple(kLightDirection), columns_[kLightDistance],
                   triple(kLightRadiance),  columns_[kLightPdf]};
  }
}

void Batch::reset() {
  displaced_.writes_normal = 0;
  view_.lobe_count = 0;
  for (PatinaLobe& lobe : lobes_) lobe.type = PATINA_LOBE_NONE;
  for (uint32_t c = 0; c < columns_.size(); ++c) {
    if (call_ != Call::Displacement) {
      std::fill_n(columns_[c], padded_, initialOf(call_, c));
      continue;
    }
    const V3f Lane::*member = c < kMovedN ? &Lane::P : &Lane::N;
    for (uint32_t i = 0; i < padded_; ++i) columns_[c][i] = (lanes_[i].*member)[static_cast<int>(c % 3)];
  }
}

PatinaStatus Batch::call(void* instance) {
  const HostCall running(entryOf(call_), std::span(lanes_).first(count_));
  switch (call_) {
    case Call::Displacement:
      return status_ = shader_.displacement(instance, &points_, &displaced_);
    case Call::Radiosity:
      return status_ = shader_.radiosity(instance, &points_, &radiosity_);
    case Call::View:
      return status_ = shader_.view(instance, &points_, &view_);
    default:
      return status_ = shader_.light(instance, &lightIn_, &lightOut_);
  }
}

bool Batch::isShown(const Output& output, uint32_t column) const {
  const bool ambient = lightKind_ == PATINA_LIGHT_AMBIENT;
  switch (call_) {
    case Call::Displacement:
      return column < kMovedN || output.writesNormal;
    case Call::Radiosity:
      return true;
    case Call::View:
      return column < kFirstLobeData ? column < kFirstLobe + kLobeColumns * output.lobeCount
                                     : column < kFirstLobeData + lobeData_ * output.lobeCount;
    case Call::LightSample:
      return column == kLightPdf ? lightKind_ == PATINA_LIGHT_INFINITE : column >= kLightRadiance || !ambient;
    case Call::LightEvaluate:
      return column >= kLightRadiance;
    case Call::LightEmit:
      return column >= kLightRadiance && column < kLightPdf;
  }
  return true;
}

Output Batch::output() const {
  Output output;
  output.status = status_;
  output.writesNormal = displaced_.writes_normal != 0;
  output.claimedLobes = view_.lobe_count;
  output.lobeCount = std::min(view_.lobe_count, PATINA_MAX_LOBES);
  for (uint32_t k = 0; k < output.lobeCount; ++k) output.lobeTypes[k] = lobes_[k].type;
  output.lanes = count_;
  output.columns = static_cast<uint32_t>(columns_.size());
  output.values.assign(size_t(count_) * columns_.size(), 0.0f);
  for (uint32_t c = 0; c < output.columns; ++c)
    if (isShown(output, c))
      for (uint32_t i = 0; i < count_; ++i) output.values[size_t(i) * output.columns + c] = columns_[c][i];
  return output;
}

bool Batch::hasSamePlanes(const Batch& other) const {
  if (count_ != other.count_ || status_ != other.status_ || view_.lobe_count != other.view_.lobe_count)
    return false;
  for (uint32_t c = 0; c < columns_.size(); ++c)
    if (std::memcmp(columns_[c], other.columns_[c], count_ * sizeof(float)) != 0) return false;
  return true;
}

}  // namespace patina::shadercheck
