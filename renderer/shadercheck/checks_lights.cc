// SPDX-License-Identifier: Apache-2.0
// Checks of light samples, and of what lights claim that shine from a point.
#include <fmt/format.h>

#include <cmath>

#include "renderer/base/sampling.h"
#include "renderer/shadercheck/checks.h"

namespace patina::shadercheck {
namespace {

constexpr uint32_t kLanes = 128;

std::string text(const V3f& v) { return fmt::format("({}, {}, {})", v.x, v.y, v.z); }

void expectSample(Subject& subject, const Output& output, uint32_t i) {
  const auto fault = [&](const std::string& what, const std::string& value) {
    subject.fault(Call::LightSample, what, fmt::format("lane {}: {}", i, value));
  };
  const V3f direction = output.triple(i, kLightDirection);
  if (std::abs(direction.length() - 1) > 1e-3f)
    fault("gives directions that are not of unit length", text(direction));
  const float distance = output.at(i, kLightDistance), pdf = output.at(i, kLightPdf);
  if (!(distance >= 0)) fault("gives a distance that is not 0 or more", fmt::format("{}", distance));
  if (subject.traits().light_kind == PATINA_LIGHT_INFINITE && !(pdf >= 0))
    fault("gives a density that is not 0 or more", fmt::format("{}", pdf));
}

// A point at a distance from the light, the same direction for the same id.
Lane lit(const V3f& from, uint64_t id, float distance) {
  Lane lane = makeLanes(1, id)[0];
  lane.P = from + lane.direction * distance;
  return lane;
}

void expectFromPoint(Subject& subject, const V3f& from, const Lane& lane, const Output& output, uint32_t i) {
  const V3f towards = from - lane.P, direction = output.triple(i, kLightDirection);
  const V3f radiance = output.triple(i, kLightRadiance);
  if (isBlack(radiance)) return;
  const float distance = towards.length();
  const auto fault = [&](const char* what, const std::string& value) {
    subject.fault(Call::LightSample, what, fmt::format("at {}: {}", text(lane.P), value));
  };
  if ((direction * distance - towards).length() > 1e-3f * distance)
    fault("shines from elsewhere, though its traits say FROM_POINT", text(direction));
  if (std::abs(output.at(i, kLightDistance) - distance) > 1e-3f * distance)
    fault("gives another distance than that of light_from", fmt::format("{}", output.at(i, kLightDistance)));
  const V3f axis = normalizedOr(V3f(subject.traits().light_axis), V3f(0, 0, 0));
  // Angles of floats are exact to 1e-3 at worst, where the cosine is one.
  const float angle = std::acos(std::clamp(axis.dot(-towards) / distance, -1.0f, 1.0f));
  if (!isBlack(axis) && angle > subject.traits().light_cone + 1e-3f)
    fault("shines beyond its light_cone", fmt::format("{} radians from the axis", angle));
}

void checkPointLight(Subject& subject) {
  constexpr uint32_t kDirections = 64;
  const V3f from(subject.traits().light_from);
  std::vector<Lane> lanes;
  for (uint32_t k = 0; k < kDirections; ++k)
    for (const float distance : {1.5f, 3.0f}) lanes.push_back(lit(from, 100 + k, distance));
  const Output output = subject.run(Call::LightSample, lanes);
  for (uint32_t i = 0; i < output.lanes; ++i) expectFromPoint(subject, from, lanes[i], output, i);
  for (uint32_t i = 0; i < output.lanes; i += 2) {
    const V3f near = output.triple(i, kLightRadiance), far = output.triple(i + 1, kLightRadiance);
    if (near.length() < 1e-30f) continue;  // what is left of it has no digits
    // Wide enough for steep beams, whose rounded cosine is raised to a high power; 1/r and no fall-off at all
    // are off by a factor of 2 and 4.
    if ((near - far * 4.0f).length() > 0.05f * near.length())
      subject.fault(Call::LightSample,
                    "does not fall off with the square of the distance, as FROM_POINT says",
                    fmt::format("Cl is {} at 1.5 and {} at 3", text(near), text(far)));
  }
}

}  // namespace

void checkLightSamples(const Context& context) {
  const std::vector<Lane> lanes = makeLanes(kLanes, 11);
  forEachSubject(context, [&](Subject& subject) {
    if (!subject.calls(Call::LightSample) || subject.traits().light_kind == PATINA_LIGHT_AMBIENT) return;
    const Output output = subject.run(Call::LightSample, lanes);
    for (uint32_t i = 0; i < output.lanes; ++i) expectSample(subject, output, i);
    if (subject.traits().light_kind != PATINA_LIGHT_DELTA) return;
    Layout layout = subject.layout(Call::LightSample);
    layout.foreign = kChannelRandom;
    const Output again = subject.run(Call::LightSample, lanes, layout);
    for (uint32_t i = 0; i < output.lanes; ++i)
      if (const std::string found = difference(Call::LightSample, output, i, again, i); !found.empty()) {
        subject.fault(Call::LightSample, "depends on random numbers, though it is a DELTA light",
                      fmt::format("lane {}: {}", i, found));
        break;
      }
  });
}

void checkPointLights(const Context& context) {
  forEachSubject(context, [&](Subject& subject) {
    if (!subject.has(PATINA_TRAIT_FROM_POINT) || !subject.active(PATINA_ENTRY_LIGHT)) return;
    if (subject.traits().light_kind != PATINA_LIGHT_DELTA)
      subject.fault("prepare", "says FROM_POINT of a light that is not DELTA");
    else
      checkPointLight(subject);
  });
}

}  // namespace patina::shadercheck
