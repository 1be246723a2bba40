// SPDX-License-Identifier: Apache-2.0
// dielectric: glass, water and the like: Fresnel reflection and refraction, smooth or rough.
#include <patina/sdk.h>

using namespace patina::sdk;

namespace {

struct Dielectric {
  struct Parameters {
    float ior = 1.5f, alpha = 0;
    Color transmittance = 1;
  };
  static constexpr auto kInfo =
      describe("dielectric", "Fresnel reflection and refraction at a smooth or GGX-rough boundary",
               varying("ior", &Parameters::ior, "index of refraction, inside relative to outside", {0.1, 10}),
               varying("alpha", &Parameters::alpha, "GGX roughness; 0 = smooth", kUnitRange),
               varying("transmittance", &Parameters::transmittance, "tint of refracted light at each passage",
                       kUnitRange));
  static constexpr uint64_t kTraits =
      PATINA_TRAIT_OPAQUE | PATINA_TRAIT_BLACK;  // light is bent, not let through

  View<PATINA_LOBE_DIELECTRIC> view(const Parameters& p, const Surface<0>&) const {
    View<PATINA_LOBE_DIELECTRIC> out;
    out.lobes[0].weight = 1;
    out.lobes[0].transmission = p.transmittance;
    out.lobes[0].alpha = std::max(p.alpha, 0.0f);
    out.lobes[0].eta = std::max(p.ior, 0.1f);
    return out;
  }
};

}  // namespace

PATINA_SHADERS(Dielectric)
