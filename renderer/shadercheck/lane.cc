// SPDX-License-Identifier: Apache-2.0
// Lanes drawn from hashes, ordinary and hostile.
#include "renderer/shadercheck/lane.h"

#include <array>
#include <utility>

#include "renderer/base/sampling.h"

namespace patina::shadercheck {
namespace {

constexpr std::pair<uint64_t, std::string_view> kNames[] = {
    {PATINA_CHANNEL_P, "P"},          {PATINA_CHANNEL_N, "N"},
    {PATINA_CHANNEL_NG, "Ng"},        {PATINA_CHANNEL_DPDU, "dPdu"},
    {PATINA_CHANNEL_DPDV, "dPdv"},    {PATINA_CHANNEL_UV, "u and v"},
    {PATINA_CHANNEL_ST, "s and t"},   {PATINA_CHANNEL_FOOTPRINT, "footprint"},
    {PATINA_CHANNEL_CS, "Cs"},        {PATINA_CHANNEL_OS, "Os"},
    {PATINA_CHANNEL_I, "I"},          {PATINA_CHANNEL_TIME, "time"},
    {PATINA_CHANNEL_DPDS, "dPds"},    {PATINA_CHANNEL_DPDT, "dPdt"},
    {kChannelDirection, "direction"}, {kChannelRandom, "random numbers"}};

// Numbers in [0, 1) in a row.
class Draw {
 public:
  explicit Draw(uint64_t seed) : seed_(seed) {}
  float unit() { return toUnit(static_cast<uint32_t>(hashOf(seed_, next_++) >> 32)); }
  float between(float low, float high) { return low + (high - low) * unit(); }
  V3f unit3() { return {unit(), unit(), unit()}; }
  V3f direction() {
    const float z = between(-1, 1), radius = std::sqrt(std::max(0.0f, 1 - z * z)), phi = 2 * kPi * unit();
    return V3f(radius * std::cos(phi), radius * std::sin(phi), z).normalized();
  }

 private:
  uint64_t seed_, next_ = 0;
};

Lane makeLane(uint64_t id) {
  Draw draw(id);
  Lane lane{};
  lane.id = id;
  lane.P = (draw.unit3() - V3f(0.5f)) * 8;
  lane.Ng = draw.direction();
  lane.N = (lane.Ng + draw.direction() * 0.5f).normalized();
  const Frame frame(lane.Ng);
  lane.dPdu = frame.x * draw.between(0.1f, 2), lane.dPdv = frame.y * draw.between(0.1f, 2);
  lane.u = draw.unit(), lane.v = draw.unit();
  lane.s = draw.between(-1, 2), lane.t = draw.between(-1, 2);
  lane.footprint = draw.between(0.001f, 0.2f), lane.footprintSt = draw.between(0.001f, 0.2f);
  lane.Cs = draw.unit3();
  lane.Os = draw.unit() < 0.3f ? V3f(1) : draw.unit3();
  lane.time = draw.unit();
  const V3f viewer = draw.direction();
  lane.I = viewer.dot(lane.Ng) > 0 ? -viewer : viewer;
  lane.direction = draw.direction();
  lane.randomX = draw.unit(), lane.randomY = draw.unit();
  const float turned = draw.between(0, 2 * kPi);
  lane.dPds = lane.dPdu * std::cos(turned) + lane.dPdv * std::sin(turned);
  lane.dPdt = lane.dPdv * std::cos(turned) - lane.dPdu * std::sin(turned);
  return lane;
}

// Half of the largest coordinate at which the renderer still takes vertices for being somewhere.
constexpr float kFar = 5e14f;

void makeHostile(Lane& lane, uint64_t which) {
  Draw draw(hashOf(lane.id, 1));
  constexpr std::array<float, 6> kWidths{0, 1e-30f, 1e-6f, 1, 1e6f, 1e15f};
  constexpr std::array<float, 8> kCoordinates{0, 1, -1, 0.5f, 1e-30f, 1e6f, -1e6f, 1e9f};
  constexpr std::array<float, 6> kPlaces{0, 1e-30f, -1, kFar, -kFar, 1};
  const auto pick = [&](const auto& list) {
    return list[std::min(static_cast<size_t>(draw.unit() * static_cast<float>(list.size())),
                         list.size() - 1)];
  };
  lane.footprint = pick(kWidths);
  lane.footprintSt = std::min(pick(kWidths), 1.0f);
  lane.s = pick(kCoordinates), lane.t = pick(kCoordinates);
  lane.u = draw.unit() < 0.5f ? 0.0f : 1.0f, lane.v = draw.unit() < 0.5f ? 0.0f : 1.0f;
  if (which % 2 == 0) lane.P = {pick(kPlaces), pick(kPlaces), pick(kPlaces)};
  if (which % 16 == 0) lane.P = V3f(0, 0, 0);
  if (which % 3 == 0) lane.dPdu = V3f(0, 0, 0);
  if (which % 4 == 0) lane.dPdv = V3f(0, 0, 0);
  if (which % 5 == 0) lane.dPdv = lane.dPdu;
  if (which % 7 == 0) lane.dPdu *= 1e12f, lane.dPdv *= 1e-12f;
  if (which % 3 == 1) lane.dPds = V3f(0, 0, 0);
  if (which % 4 == 1) lane.dPdt = V3f(0, 0, 0);
  if (which % 5 == 1) lane.dPdt = lane.dPds;
  if (which % 7 == 1) lane.dPds *= 1e12f, lane.dPdt *= 1e-12f;
  if (which % 4 == 1) {  // along an axis, where frames degenerate
    lane.N = lane.Ng = lane.direction = V3f(0, 0, which % 8 == 1 ? 1.0f : -1.0f);
    lane.I = -lane.N;
  }
  if (which % 4 == 2) lane.I = Frame(lane.N).x;  // grazing
  if (which % 6 == 0) lane.Os = V3f(0, 0, 0);
  if (which % 6 == 1) lane.Cs = V3f(0, 0, 0);
  if (which % 6 == 2) lane.Cs = lane.Os = V3f(1, 1, 1);
  lane.time = which % 3 == 0 ? 0.0f : 1e6f;
  if (which % 4 == 0) lane.randomX = 0;
  if (which % 4 == 1) lane.randomX = kOneMinusEpsilon;
  if (which % 8 < 4) lane.randomY = which % 8 < 2 ? 0 : kOneMinusEpsilon;
}

}  // namespace

std::string_view channelName(uint64_t channel) {
  for (const auto& [bit, name] : kNames)
    if (bit == channel) return name;
  return "?";
}

std::string channelNames(uint64_t channels) {
  std::string text;
  for (const auto& [bit, name] : kNames)
    if (channels & bit) (text += text.empty() ? "" : ", ") += name;
  return text;
}

std::vector<Lane> makeLanes(uint32_t count, uint64_t seed) {
  std::vector<Lane> lanes;
  for (uint32_t i = 0; i < count; ++i) lanes.push_back(makeLane(hashOf(seed, i)));
  return lanes;
}

std::vector<Lane> makeHostileLanes(uint32_t count, uint64_t seed) {
  std::vector<Lane> lanes = makeLanes(count, seed);
  for (uint32_t i = 0; i < count; ++i) makeHostile(lanes[i], i);
  return lanes;
}

}  // namespace patina::shadercheck
