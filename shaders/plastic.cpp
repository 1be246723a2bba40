// SPDX-License-Identifier: Apache-2.0
// plastic: the plastic of RI 3.2.
#include <patina/sdk.h>

using namespace patina::sdk;

namespace {

struct Plastic {
  struct Parameters {
    float Ka = 1, Kd = 0.5f, Ks = 0.5f, roughness = 0.1f;
    Color specularcolor = 1;
  };
  static constexpr auto kInfo =
      describe("plastic",
               "Plastic: Ci = Os * (Cs * (Ka * ambient() + Kd * diffuse(N)) + specularcolor * Ks * "
               "specular(N, V, roughness))",
               uniform("Ka", &Parameters::Ka, "weight of ambient lights", kUnitRange),
               uniform("Kd", &Parameters::Kd, "weight of diffuse reflection", kUnitRange),
               uniform("Ks", &Parameters::Ks, "weight of highlights", kUnitRange),
               uniform("roughness", &Parameters::roughness,
                       "size of highlights: the exponent is 8 / roughness", {1e-4, 10}),
               uniform("specularcolor", &Parameters::specularcolor, "colour of highlights", kUnitRange));
  static constexpr uint64_t kTraits = PATINA_TRAIT_OPACITY_IS_OS;

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    if (p.Kd == 0) context.set(PATINA_TRAIT_BLACK);
    if (p.Ka == 0 && p.Kd == 0) context.disable(PATINA_ENTRY_RADIOSITY);
    if (p.Ks == 0 || isBlack(p.specularcolor)) context.disable(PATINA_ENTRY_VIEW);
    return PATINA_OK;
  }

  Radiosity radiosity(const Parameters& p, const Surface<kCs | kOs>& at) const {
    const Color color = at.Os * at.Cs;
    Radiosity out;
    out.reflectance = color * p.Kd;
    out.ambient = color * p.Ka;
    out.opacity = at.Os;
    return out;
  }

  View<PATINA_LOBE_RI_SPECULAR> view(const Parameters& p, const Surface<kOs>& at) const {
    View<PATINA_LOBE_RI_SPECULAR> out;
    out.lobes[0].weight = at.Os * p.specularcolor * p.Ks;
    out.lobes[0].alpha = std::max(p.roughness, 1e-4f);
    return out;
  }
};

}  // namespace

PATINA_SHADERS(Plastic)
