// SPDX-License-Identifier: Apache-2.0
// Checks of results: finite, within what physics and the traits allow, nothing where nothing is promised.
#include <fmt/format.h>

#include <cmath>

#include "renderer/shadercheck/checks.h"

namespace patina::shadercheck {
namespace {

constexpr uint32_t kLanes = 64;
constexpr float kSlack = 1e-4f;  // of sums of products of floats in [0, 1]

std::string text(const V3f& v) { return fmt::format("({}, {}, {})", v.x, v.y, v.z); }
std::string inLane(uint32_t lane, const std::string& what) {
  return fmt::format("lane {}{}{}", lane, what.empty() ? "" : ": ", what);
}

bool differs(const V3f& a, const V3f& b, float slack) {
  return !(std::abs(a.x - b.x) <= slack && std::abs(a.y - b.y) <= slack && std::abs(a.z - b.z) <= slack);
}

// `body` sees the results for ordinary lanes, with parameters uniform, and with primitive variables for those
// that may have them.
void forEachOutput(const Context& context, Call call,
                   const std::function<void(Subject&, const std::vector<Lane>&, const Output&)>& body) {
  const std::vector<Lane> lanes = makeLanes(kLanes, 7);
  forEachSubject(context, [&](Subject& subject) {
    if (!subject.calls(call)) return;
    Layout layout = subject.layout(call);
    for (const auto parameters : {Layout::Uniform, Layout::Varying}) {
      layout.parameters = parameters;
      body(subject, lanes, subject.run(call, lanes, layout));
    }
  });
}

void expectFinite(Subject& subject, Call call, const Output& output, const char* lanes) {
  for (uint32_t i = 0; i < output.lanes; ++i)
    for (uint32_t c = 0; c < output.columns; ++c)
      if (!std::isfinite(output.at(i, c))) {
        subject.fault(call, fmt::format("gives a value that is not finite: {}", columnName(call, c)),
                      fmt::format("{} lane {}: {}", lanes, i, output.at(i, c)));
        return;
      }
}

void expectShares(Subject& subject, const Output& output, uint32_t lane) {
  const V3f reflected = output.triple(lane, kReflectance), let = output.triple(lane, kTransmittance);
  const V3f opacity = output.triple(lane, kOpacity);
  const auto fault = [&](const char* what) {
    subject.fault(Call::Radiosity, what,
                  inLane(lane, fmt::format("reflectance {}, transmittance {}, opacity {}", text(reflected),
                                           text(let), text(opacity))));
  };
  for (int k = 0; k < 3; ++k) {
    if (opacity[k] < -kSlack || opacity[k] > 1 + kSlack) fault("gives an opacity outside of [0, 1]");
    if (reflected[k] + let[k] > 1 + kSlack)
      fault("makes energy: reflectance + transmittance is more than 1");
    else if (reflected[k] + let[k] > opacity[k] + kSlack)
      fault(
          "makes energy: reflectance + transmittance is more than the opacity, by which they are to be "
          "multiplied");
  }
  for (uint32_t c = kEmission; c < kOpacity; ++c)
    if (output.at(lane, c) < -1e-6f)
      subject.fault(Call::Radiosity, "gives a negative " + columnName(Call::Radiosity, c),
                    inLane(lane, fmt::format("{}", output.at(lane, c))));
}

void expectLobe(Subject& subject, const Output& output, uint32_t lane, uint32_t k) {
  const uint32_t type = output.lobeTypes[k], first = kFirstLobe + kLobeColumns * k;
  const auto fault = [&](const char* what, double value) {
    subject.fault(Call::View, fmt::format("lobe {}: {}", k, what), inLane(lane, fmt::format("{}", value)));
  };
  const bool custom = type >= PATINA_LOBE_CUSTOM && type - PATINA_LOBE_CUSTOM < subject.customLobes().size();
  if (!custom && (type < PATINA_LOBE_RI_SPECULAR || type > PATINA_LOBE_DIELECTRIC))
    return fault("there is no such type of lobes", type);
  // All the types reflect at most their weight, and let through at most their transmission.
  for (uint32_t c = kLobeWeight; c < kLobeAlpha; ++c)
    if (const float share = output.at(lane, first + c); share < -1e-6f || share > 1 + kSlack)
      fault(
          c < kLobeTransmission ? "the weight is outside of [0, 1]" : "the transmission is outside of [0, 1]",
          double(share));
  const float alpha = output.at(lane, first + kLobeAlpha), eta = output.at(lane, first + kLobeEta);
  if (!(alpha >= 0 && alpha < 1e6f)) fault("the roughness alpha is not in [0, 1e6)", double(alpha));
  if (type == PATINA_LOBE_RI_SPECULAR && !(alpha > 0))
    fault("RI's specular() is given a roughness of zero", double(alpha));
  if (!(eta > 1e-3f && eta < 1e3f)) fault("the index of refraction eta is not in (0.001, 1000)", double(eta));
}

void expectFlags(Subject& subject, const Lane& lane, const Output& output, uint32_t i) {
  const V3f opacity = output.triple(i, kOpacity), emission = output.triple(i, kEmission);
  const V3f reflected = output.triple(i, kReflectance), let = output.triple(i, kTransmittance);
  const auto expect = [&](bool good, const char* what, const V3f& value) {
    if (!good) subject.fault(Call::Radiosity, what, inLane(i, text(value)));
  };
  if (subject.has(PATINA_TRAIT_OPAQUE))
    expect(!differs(opacity, V3f(1), 0), "is not opaque, though its traits say OPAQUE", opacity);
  if (subject.has(PATINA_TRAIT_OPACITY_IS_OS))
    expect(!differs(opacity, lane.Os, 1e-6f),
           "has another opacity than Os, though its traits say OPACITY_IS_OS", opacity);
  if (subject.has(PATINA_TRAIT_TRANSPARENT)) {
    expect(isBlack(opacity), "is opaque, though its traits say TRANSPARENT", opacity);
    expect(isBlack(emission), "emits, though its traits say TRANSPARENT", emission);
  }
  if (subject.has(PATINA_TRAIT_BLACK)) {
    expect(isBlack(reflected), "reflects, though its traits say BLACK", reflected);
    expect(isBlack(let), "transmits, though its traits say BLACK", let);
  }
  if (!subject.has(PATINA_TRAIT_EMITS))
    expect(isBlack(emission), "emits, though its traits lack EMITS", emission);
  if (!subject.has(PATINA_TRAIT_TRANSMITS))
    expect(isBlack(let), "transmits, though its traits lack TRANSMITS", let);
}

// What an entry point that is said to do nothing does when it is called; empty = nothing.
std::string findDeed(const Subject& subject, Call call, const Lane& lane, const Output& output, uint32_t i) {
  if (call == Call::Displacement) {
    if (output.triple(i, kMovedP) != lane.P) return "moves P";
    return output.writesNormal && output.triple(i, kMovedN) != lane.N ? "changes N" : "";
  }
  if (call == Call::Radiosity) {
    for (uint32_t c = kEmission; c < kOpacity; ++c)
      if (output.at(i, c) != 0) return "gives " + columnName(call, c);
    const V3f opacity = output.triple(i, kOpacity);
    const bool isOs = subject.has(PATINA_TRAIT_OPACITY_IS_OS);
    return opacity == V3f(1) || (isOs && !differs(opacity, lane.Os, 1e-6f)) ? "" : "gives an opacity";
  }
  if (call == Call::View) {
    for (uint32_t c = 0; c < std::min(output.columns, kFirstLobeData); ++c) {
      const uint32_t part = c < kFirstLobe ? 0 : (c - kFirstLobe) % kLobeColumns;
      if (part < kLobeAlpha && output.at(i, c) != 0) return "gives " + columnName(call, c);
    }
    return "";
  }
  return isBlack(output.triple(i, kLightRadiance)) ? "" : "gives light";
}

}  // namespace

void checkFinite(const Context& context) {
  const std::vector<Lane> ordinary = makeLanes(kLanes, 8), hostile = makeHostileLanes(2 * kLanes, 9);
  forEachSubject(context, [&](Subject& subject) {
    for (const Call call : subject.calls()) {
      Layout layout = subject.layout(call);
      for (const auto parameters : {Layout::Uniform, Layout::Varying}) {
        layout.parameters = parameters;
        expectFinite(subject, call, subject.run(call, ordinary, layout), "ordinary");
        expectFinite(subject, call, subject.run(call, hostile, layout, "hostile inputs"), "hostile");
      }
    }
  });
}

void checkEnergy(const Context& context) {
  forEachOutput(context, Call::Radiosity,
                [](Subject& subject, const std::vector<Lane>&, const Output& output) {
                  for (uint32_t i = 0; i < output.lanes; ++i) expectShares(subject, output, i);
                });
}

void checkLobes(const Context& context) {
  forEachOutput(context, Call::View, [](Subject& subject, const std::vector<Lane>&, const Output& output) {
    if (output.claimedLobes > PATINA_MAX_LOBES)
      subject.fault(Call::View, fmt::format("says that it filled {} lobes; there are {}", output.claimedLobes,
                                            PATINA_MAX_LOBES));
    for (uint32_t i = 0; i < output.lanes; ++i)
      for (uint32_t k = 0; k < output.lobeCount; ++k) expectLobe(subject, output, i, k);
  });
}

void checkFlags(const Context& context) {
  forEachOutput(context, Call::Radiosity,
                [](Subject& subject, const std::vector<Lane>& lanes, const Output& output) {
                  for (uint32_t i = 0; i < output.lanes; ++i) expectFlags(subject, lanes[i], output, i);
                });
}

void checkInactive(const Context& context) {
  const std::vector<Lane> lanes = makeLanes(kLanes, 10);
  forEachSubject(context, [&](Subject& subject) {
    for (const Call call : kAllCalls) {
      if (subject.active(entryOf(call))) continue;
      // It never said what it reads, so it is given everything.
      Layout layout = subject.layout(call);
      if (entryOf(call) != PATINA_ENTRY_LIGHT)
        layout.channels = call == Call::View ? kSurfaceChannels : kSurfaceChannels & ~PATINA_CHANNEL_I;
      const Output output = subject.run(call, lanes, layout, "inactive");
      for (uint32_t i = 0; i < output.lanes; ++i)
        if (const std::string deed = findDeed(subject, call, lanes[i], output, i); !deed.empty()) {
          subject.fault(call, deed + ", though its traits say that it does nothing", inLane(i, ""));
          break;
        }
    }
  });
}

void checkDisplacement(const Context& context) {
  forEachOutput(context, Call::Displacement,
                [](Subject& subject, const std::vector<Lane>& lanes, const Output& output) {
                  const float bound = subject.traits().displacement_bound;
                  for (uint32_t i = 0; i < output.lanes; ++i) {
                    const float moved = (output.triple(i, kMovedP) - lanes[i].P).length();
                    // 0 = the shader does not say. P itself is rounded.
                    if (bound > 0 && moved > bound * (1 + kSlack) + 1e-5f * lanes[i].P.length())
                      subject.fault(Call::Displacement, "moves P further than its displacement_bound",
                                    inLane(i, fmt::format("by {}, the bound is {}", moved, bound)));
                    const float length = output.triple(i, kMovedN).length();
                    if (output.writesNormal && !(std::abs(length - 1) < 1e-3f))
                      subject.fault(Call::Displacement, "writes normals that are not of unit length",
                                    inLane(i, fmt::format("the length is {}", length)));
                  }
                });
}

}  // namespace patina::shadercheck
