// SPDX-License-Identifier: Apache-2.0
// arealight: makes the geometry of an AreaLightSource shine.
#include <patina/sdk.h>

using namespace patina::sdk;

namespace {

struct AreaLight {
  struct Parameters {
    float intensity = 1;
    Color lightcolor = 1;
    int32_t sides = 1;
  };
  static constexpr auto kInfo =
      describe("arealight", "The geometry that it is bound to emits the radiance intensity * lightcolor",
               uniform("intensity", &Parameters::intensity, "scale of lightcolor", kPositive),
               uniform("lightcolor", &Parameters::lightcolor, "colour of the light", kPositive, "W/(m^2 sr)"),
               uniform("sides", &Parameters::sides, "1 = only the outside shines, 2 = both sides", {1, 2}));
  static constexpr uint64_t kTraits = 0;

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    if (p.sides == 2) context.set(PATINA_TRAIT_TWO_SIDED);
    context.lightPower(p.intensity * p.lightcolor * float(p.sides));
    return PATINA_OK;
  }

  Color emit(const Parameters& p, const LightQuery& at) const {
    const bool shines = p.sides == 2 || dot(at.N, at.direction) > 0;
    return p.lightcolor * (shines ? p.intensity : 0.0f);
  }
};

}  // namespace

PATINA_SHADERS(AreaLight)
