// SPDX-License-Identifier: Apache-2.0
// checker: two colours in squares along the texture coordinates.
#include <patina/sdk.h>
#include <patina/sdk/filter.h>

using namespace patina::sdk;

namespace {

struct Checker {
  struct Parameters {
    float Ka = 1, Kd = 1, frequency = 4;
    Color blackcolor = 0;
  };
  static constexpr auto kInfo = describe(
      "checker",
      "A diffuse checkerboard in s and t: Ci = Os * C * (Ka * ambient() + Kd * diffuse(N)), where C is Cs in "
      "the square from (0, 0), blackcolor in its neighbours",
      varying("Ka", &Parameters::Ka, "weight of ambient lights", kUnitRange),
      varying("Kd", &Parameters::Kd, "weight of diffuse reflection", kUnitRange),
      uniform("frequency", &Parameters::frequency, "pairs of squares along one unit of s and of t", {0, 1e6}),
      varying("blackcolor", &Parameters::blackcolor, "colour of every other square", kUnitRange));
  static constexpr uint64_t kTraits = PATINA_TRAIT_OPACITY_IS_OS;

  Radiosity radiosity(const Parameters& p, const Surface<kST | kFootprint | kCs | kOs>& at) const {
    const float white =
        filteredChecker(p.frequency * at.s, p.frequency * at.t, p.frequency * at.footprint_st);
    return diffuseSurface(mix(p.blackcolor, at.Cs, white), at.Os, p.Ka, p.Kd);
  }
};

}  // namespace

PATINA_SHADERS(Checker)
