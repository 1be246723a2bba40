// SPDX-License-Identifier: Apache-2.0
// Emits what its rays find: red, the share of the hemisphere, by the cosine, that is covered up to `maximum`;
// green, the distance along the normal, 4 at most; blue, whether a ray from `origin` along z meets something.
// The tests judge it by closed forms.
#include <patina/sdk.h>
#include <patina/sdk/rays.h>

using namespace patina::sdk;

namespace {

struct Parameters {
  float maximum = 1e6f;
  Point origin{0, 0, 0};
};

struct Surroundings {
  static constexpr int kRays = 254;
  using Parameters = ::Parameters;
  static constexpr auto kInfo =
      describe("surroundings", "for tests", uniform("maximum", &Parameters::maximum, "of rays"),
               uniform("origin", &Parameters::origin, "where one ray begins"));
  static constexpr uint64_t kTraits = PATINA_TRAIT_OPAQUE | PATINA_TRAIT_EMITS | PATINA_TRAIT_BLACK;

  std::array<RayQuery, kRays + 1> rays(const Parameters& p, const Surface<kN>& at) const {
    std::array<RayQuery, kRays + 1> all;
    for (int k = 0; k < kRays; ++k) all[size_t(k)] = {(at.N + spherePoint(k, kRays)) * 3.0f, p.maximum};
    all[kRays] = {at.N * 0.5f, 1e6f};
    return all;
  }
  Radiosity radiosity(const Parameters&, const Surface<kN>&, const Distances<kRays + 1>& met) const {
    float covered = 0;
    for (int k = 0; k < kRays; ++k) covered += met.ray[size_t(k)] < PATINA_INFINITE_DISTANCE;
    Radiosity out;
    out.emission = Color(covered / kRays, std::min(met.ray[kRays], 4.0f), 0);
    return out;
  }
};

// The same of occlusion, from `view`, with a ray that begins elsewhere.
struct Elsewhere {
  using Parameters = ::Parameters;
  static constexpr auto kInfo =
      describe("elsewhere", "for tests", uniform("maximum", &Parameters::maximum, "of the ray"),
               uniform("origin", &Parameters::origin, "where it begins"));
  static constexpr uint64_t kTraits = PATINA_TRAIT_OPAQUE | PATINA_TRAIT_BLACK;

  std::array<RayQueryFrom, 2> rays(const Parameters& p, const Surface<kP>& at) const {
    return {{{p.origin, Vector(0, 0, 1), p.maximum}, {at.P, Vector(0, 0, 1), -1}}};
  }
  View<> view(const Parameters&, const Surface<kN>&, const Occluded<2>& met) const {
    View<> out;
    out.emission = Color(met.ray[1], 1, met.ray[0]);
    return out;
  }
};

}  // namespace

PATINA_SHADERS(Surroundings, Elsewhere)
