// SPDX-License-Identifier: Apache-2.0
// conductor: a rough or mirroring metal, a single GGX microfacet lobe without Fresnel effect.
#include <patina/sdk.h>

using namespace patina::sdk;

namespace {

struct Conductor {
  struct Parameters {
    Color reflectance = 1;
    float alpha = 0.1f;
  };
  static constexpr auto kInfo =
      describe("conductor",
               "GGX reflection with height-correlated Smith shadowing; the same reflectance at every angle",
               varying("reflectance", &Parameters::reflectance,
                       "part of the light that a microfacet reflects", kUnitRange),
               varying("alpha", &Parameters::alpha, "GGX roughness; 0 = mirror", kUnitRange));
  static constexpr uint64_t kTraits = PATINA_TRAIT_OPACITY_IS_OS | PATINA_TRAIT_BLACK;

  View<PATINA_LOBE_GGX> view(const Parameters& p, const Surface<kOs>& at) const {
    View<PATINA_LOBE_GGX> out;
    out.lobes[0].weight = at.Os * p.reflectance;
    out.lobes[0].alpha = std::max(p.alpha, 0.0f);
    return out;
  }
};

}  // namespace

PATINA_SHADERS(Conductor)
