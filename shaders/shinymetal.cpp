// SPDX-License-Identifier: Apache-2.0
// shinymetal: the metal of RI 3.2 that mirrors, either the scene or a picture of an environment.
#include <patina/sdk.h>

using namespace patina::sdk;

namespace {

struct ShinyMetal {
  struct Parameters {
    float Ka = 1, Ks = 1, Kr = 1, roughness = 0.1f;
    const char* texturename = "";
  };
  static constexpr auto kInfo = describe(
      "shinymetal",
      "Metal with reflections: Ci = Os * Cs * (Ka * ambient() + Ks * specular() + Kr * environment())",
      uniform("Ka", &Parameters::Ka, "weight of ambient lights", kUnitRange),
      uniform("Ks", &Parameters::Ks, "weight of highlights", kUnitRange),
      uniform("Kr", &Parameters::Kr, "weight of reflections", kUnitRange),
      uniform("roughness", &Parameters::roughness, "size of highlights: the exponent is 8 / roughness",
              {1e-4, 10}),
      uniform("texturename", &Parameters::texturename,
              "latitude-longitude picture, +z up in world space, reflected instead of the scene; \"\" = the "
              "scene"));
  static constexpr uint64_t kTraits = PATINA_TRAIT_OPACITY_IS_OS | PATINA_TRAIT_BLACK;

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    mirrors_ = !*p.texturename;
    if (p.Kr != 0) environment_ = context.openTexture(p.texturename);
    if (p.Ka == 0) context.disable(PATINA_ENTRY_RADIOSITY);
    if (p.Ks == 0 && p.Kr == 0) context.disable(PATINA_ENTRY_VIEW);
    return PATINA_OK;
  }

  Radiosity radiosity(const Parameters& p, const Surface<kCs | kOs>& at) const {
    Radiosity out;
    out.ambient = at.Os * at.Cs * p.Ka;
    out.opacity = at.Os;
    return out;
  }

  // The picture is read where the mirrored ray points.
  PatinaTexture* texture(uint32_t) const { return environment_; }
  std::array<EnvironmentLookup, 1> lookups(const Parameters&, const Surface<kN | kI>& at) const {
    return {{{reflect(at.I, at.N), 0}}};
  }

  using Lobes = View<PATINA_LOBE_RI_SPECULAR, PATINA_LOBE_GGX>;
  uint32_t lobeCount() const { return mirrors_ ? 2 : 1; }

  Lobes view(const Parameters& p, const Surface<kCs | kOs>& at, const Texels<1>& texels) const {
    const Color color = at.Os * at.Cs;
    Lobes out;
    out.lobes[0].weight = color * p.Ks;
    out.lobes[0].alpha = std::max(p.roughness, 1e-4f);
    out.lobes[1].weight = color * p.Kr;
    out.emission = mirrors_ || !environment_ ? Color(0) : color * p.Kr * texels[0].color;
    return out;
  }

 private:
  PatinaTexture* environment_ = nullptr;
  bool mirrors_ = true;
};

}  // namespace

PATINA_SHADERS(ShinyMetal)
