// SPDX-License-Identifier: Apache-2.0
// metal: the metal of RI 3.2.
#include <patina/sdk.h>

using namespace patina::sdk;

namespace {

struct Metal {
  struct Parameters {
    float Ka = 1, Ks = 1, roughness = 0.1f;
  };
  static constexpr auto kInfo =
      describe("metal", "Metal: Ci = Os * Cs * (Ka * ambient() + Ks * specular(N, V, roughness))",
               uniform("Ka", &Parameters::Ka, "weight of ambient lights", kUnitRange),
               uniform("Ks", &Parameters::Ks, "weight of highlights", kUnitRange),
               uniform("roughness", &Parameters::roughness,
                       "size of highlights: the exponent is 8 / roughness", {1e-4, 10}));
  static constexpr uint64_t kTraits = PATINA_TRAIT_OPACITY_IS_OS | PATINA_TRAIT_BLACK;

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    if (p.Ka == 0) context.disable(PATINA_ENTRY_RADIOSITY);
    if (p.Ks == 0) context.disable(PATINA_ENTRY_VIEW);
    return PATINA_OK;
  }

  Radiosity radiosity(const Parameters& p, const Surface<kCs | kOs>& at) const {
    Radiosity out;
    out.ambient = at.Os * at.Cs * p.Ka;
    out.opacity = at.Os;
    return out;
  }

  View<PATINA_LOBE_RI_SPECULAR> view(const Parameters& p, const Surface<kCs | kOs>& at) const {
    View<PATINA_LOBE_RI_SPECULAR> out;
    out.lobes[0].weight = at.Os * at.Cs * p.Ks;
    out.lobes[0].alpha = std::max(p.roughness, 1e-4f);
    return out;
  }
};

}  // namespace

PATINA_SHADERS(Metal)
