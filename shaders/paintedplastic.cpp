// SPDX-License-Identifier: Apache-2.0
// paintedplastic: the plastic of RI 3.2 with a texture for its paint.
#include <patina/sdk.h>

using namespace patina::sdk;

namespace {

struct PaintedPlastic {
  struct Parameters {
    float Ka = 1, Kd = 0.5f, Ks = 0.5f, roughness = 0.1f;
    Color specularcolor = 1;
    const char* texturename = "";
  };
  static constexpr auto kInfo = describe(
      "paintedplastic",
      "Plastic whose colour is Cs * texture(texturename): Ci = Os * (Ct * (Ka * ambient() + Kd * diffuse(N)) "
      "+ "
      "specularcolor * Ks * specular(N, V, roughness))",
      uniform("Ka", &Parameters::Ka, "weight of ambient lights", kUnitRange),
      uniform("Kd", &Parameters::Kd, "weight of diffuse reflection", kUnitRange),
      uniform("Ks", &Parameters::Ks, "weight of highlights", kUnitRange),
      uniform("roughness", &Parameters::roughness, "size of highlights: the exponent is 8 / roughness",
              {1e-4, 10}),
      uniform("specularcolor", &Parameters::specularcolor, "colour of highlights", kUnitRange),
      uniform("texturename", &Parameters::texturename, "texture that Cs is multiplied by; \"\" = none"));
  static constexpr uint64_t kTraits = PATINA_TRAIT_OPACITY_IS_OS;

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    paint_ = context.openTexture(p.texturename);
    if (p.Kd == 0) context.set(PATINA_TRAIT_BLACK);
    if (p.Ka == 0 && p.Kd == 0) context.disable(PATINA_ENTRY_RADIOSITY);
    if (p.Ks == 0 || isBlack(p.specularcolor)) context.disable(PATINA_ENTRY_VIEW);
    return PATINA_OK;
  }

  PatinaTexture* texture(uint32_t) const { return paint_; }
  std::array<TextureLookup, 1> lookups(const Parameters&, const Surface<kST | kFootprint>& at) const {
    return {{{at.s, at.t, at.footprint_st}}};
  }

  Radiosity radiosity(const Parameters& p, const Surface<kCs | kOs>& at, const Texels<1>& texels) const {
    const Color color = at.Os * at.Cs * texels[0].color;
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

 private:
  PatinaTexture* paint_ = nullptr;
};

}  // namespace

PATINA_SHADERS(PaintedPlastic)
