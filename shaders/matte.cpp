// SPDX-License-Identifier: Apache-2.0
// matte: the ideal diffuse surface of RI 3.2. It may also glow.
#include <patina/sdk.h>

using namespace patina::sdk;

namespace {

struct Matte {
  // Each parameter: a member with its default, then its name, documentation and range.
  struct Parameters {
    float Ka = 1, Kd = 1;
    Color emission = 0;
  };
  static constexpr auto kInfo = describe(
      "matte", "Ideal diffuse reflection: Ci = Os * Cs * (Ka * ambient() + Kd * diffuse(N)), plus emission",
      varying("Ka", &Parameters::Ka, "weight of ambient lights", kUnitRange),
      varying("Kd", &Parameters::Kd, "weight of diffuse reflection", kUnitRange),
      uniform("emission", &Parameters::emission, "radiance given off, the same in every direction", kPositive,
              "W/(m^2 sr)"));

  // What holds whatever the parameters are: opacity is Os, so that the renderer knows it without asking.
  static constexpr uint64_t kTraits = PATINA_TRAIT_OPACITY_IS_OS | PATINA_TRAIT_EMITS;

  // Once per binding: what only these parameters tell.
  PatinaStatus prepare(const Parameters& parameters, Prepare& context) {
    if (isBlack(parameters.emission)) context.clear(PATINA_TRAIT_EMITS);
    return PATINA_OK;
  }

  // For each point. The signature says what is read of the surface: its colour and opacity.
  Radiosity radiosity(const Parameters& parameters, const Surface<kCs | kOs>& at) const {
    Radiosity out;
    out.emission = parameters.emission * at.Os;
    out.reflectance = at.Os * at.Cs * parameters.Kd;
    out.ambient = at.Os * at.Cs * parameters.Ka;
    out.opacity = at.Os;
    return out;
  }
};

}  // namespace

PATINA_SHADERS(Matte)
