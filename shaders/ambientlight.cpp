// SPDX-License-Identifier: Apache-2.0
// ambientlight: the light of RI 3.2 that comes from everywhere and is never in shadow.
#include <patina/sdk.h>

using namespace patina::sdk;

namespace {

struct AmbientLight {
  struct Parameters {
    float intensity = 1;
    Color lightcolor = 1;
  };
  static constexpr auto kInfo =
      describe("ambientlight", "Ambient light: Cl = intensity * lightcolor",
               uniform("intensity", &Parameters::intensity, "scale of lightcolor", kPositive),
               uniform("lightcolor", &Parameters::lightcolor, "colour of the light", kPositive));
  static constexpr PatinaLightKind kLight = PATINA_LIGHT_AMBIENT;
  static constexpr uint64_t kTraits = PATINA_TRAIT_UNSHADOWED;

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    context.lightPower(p.intensity * p.lightcolor);
    return PATINA_OK;
  }

  LightSample sample(const Parameters& p, const LightQuery&) const {
    LightSample out;
    out.radiance = p.intensity * p.lightcolor;
    return out;
  }
};

}  // namespace

PATINA_SHADERS(AmbientLight)
