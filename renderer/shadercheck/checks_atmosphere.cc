// SPDX-License-Identifier: Apache-2.0
// The function that a shader for RI's Atmosphere hands over.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "renderer/shadercheck/checks.h"

namespace patina::shadercheck {
namespace {

constexpr const char* kEntry = "atmosphere";
constexpr uint32_t kLanes = 37;

/// A segment of a ray: short and long ones, from the eye and from behind surfaces.
struct Segment {
  V3f origin, direction;
  float length, depthOrigin, depth;
};

std::vector<Segment> makeSegments() {
  constexpr std::array<float, 6> kLengths{0, 1e-30f, 1e-3f, 1, 1e6f, 1e15f};
  std::vector<Segment> segments;
  for (const Lane& lane : makeLanes(kLanes, 11)) {
    const size_t k = segments.size();
    const float from = k % 3 == 0 ? -PATINA_INFINITE_DISTANCE : k % 5 == 0 ? 0 : lane.u;
    segments.push_back({lane.P, lane.direction, k % 2 ? 10 * lane.v : kLengths[k / 2 % kLengths.size()], from,
                        k % 7 == 0 ? 1 : std::max(from, lane.u + lane.randomX)});
  }
  return segments;
}

/// Transmittance and radiance by segment.
using Airs = std::vector<std::array<float, 6>>;

Airs call(Subject& subject, std::span<const Segment> segments) {
  const auto count = static_cast<uint32_t>(segments.size());
  const uint32_t padded = (count + PATINA_LANES - 1) / PATINA_LANES * PATINA_LANES;
  GuardedMemory memory;
  const auto plane = [&](const char* name, const auto& value) {
    std::vector<float> numbers(padded);
    for (uint32_t i = 0; i < padded; ++i) numbers[i] = value(segments[std::min(i, count - 1)]);
    return PatinaPlane{memory.input(numbers, name), 1, 0};
  };
  const auto planes = [&](const char* name, V3f Segment::*member) {
    const auto part = [&](int c) { return plane(name, [=](const Segment& s) { return (s.*member)[c]; }); };
    return PatinaPlane3{part(0), part(1), part(2)};
  };
  const auto number = [&](const char* name, float Segment::*member) {
    return plane(name, [=](const Segment& s) { return s.*member; });
  };
  PatinaAtmosphereIn in{sizeof in,
                        count,
                        padded,
                        0,
                        planes("origin", &Segment::origin),
                        planes("direction", &Segment::direction),
                        number("length", &Segment::length),
                        number("depth_origin", &Segment::depthOrigin),
                        number("depth", &Segment::depth)};
  std::array<float*, 6> outputs;
  for (size_t c = 0; c < outputs.size(); ++c) {
    outputs[c] = memory.output(padded, c < 3 ? "transmittance" : "radiance");
    std::fill_n(outputs[c], padded, c < 3 ? 1.0f : 0.0f);
  }
  PatinaAtmosphereOut out{
      sizeof out, 0, {outputs[0], outputs[1], outputs[2]}, {outputs[3], outputs[4], outputs[5]}};
  if (const PatinaStatus status = subject.atmosphere()(subject.instance(), &in, &out); status != PATINA_OK)
    subject.fault(kEntry, fmt::format("returned the status {} for arguments that make sense", status));
  if (const auto [what, where] = memory.findDamage(); !what.empty()) subject.fault(kEntry, what, where);
  subject.reportComplaints(kEntry);
  Airs airs(count);
  for (uint32_t i = 0; i < count; ++i)
    for (size_t c = 0; c < outputs.size(); ++c) airs[i][c] = outputs[c][i];
  return airs;
}

}  // namespace

void checkAtmosphere(const Context& context) {
  const std::vector<Segment> segments = makeSegments();
  forEachSubject(context, [&](Subject& subject) {
    if (!subject.atmosphere()) return;
    context.findings.progress().set(kEntry, subject.parametersName());
    const Airs all = call(subject, segments);
    for (uint32_t i = 0; i < kLanes; ++i) {
      const auto fault = [&](const char* what, float value) {
        subject.fault(kEntry, what, fmt::format("segment {} of length {}: {}", i, segments[i].length, value));
      };
      for (size_t c = 0; c < 6; ++c) {
        const float value = all[i][c];
        if (!std::isfinite(value)) fault("gives a value that is not finite", value);
        if (c < 3 && (value < 0 || value > 1)) fault("gives a transmittance outside of [0, 1]", value);
        if (c >= 3 && value < 0) fault("gives a negative radiance", value);
      }
      const Airs alone = call(subject, std::span(segments).subspan(i, 1));
      for (size_t c = 0; c < 6; ++c)
        if (std::bit_cast<uint32_t>(alone[0][c]) != std::bit_cast<uint32_t>(all[i][c]))
          fault("gives a segment other results in a batch of one", alone[0][c]);
    }
  });
}

}  // namespace patina::shadercheck
