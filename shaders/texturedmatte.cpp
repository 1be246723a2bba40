// SPDX-License-Identifier: Apache-2.0
// texturedmatte: matte with a texture for its colour.
#include <patina/sdk.h>

using namespace patina::sdk;

namespace {

struct TexturedMatte {
  struct Parameters {
    float Ka = 1, Kd = 1;
    const char* texturename = "";
  };
  static constexpr auto kInfo = describe(
      "texturedmatte",
      "Ideal diffuse reflection by Cs * texture(texturename): Ci = Os * Cs * Ct * (Ka * ambient() + Kd * "
      "diffuse(N))",
      varying("Ka", &Parameters::Ka, "weight of ambient lights", kUnitRange),
      varying("Kd", &Parameters::Kd, "weight of diffuse reflection", kUnitRange),
      uniform("texturename", &Parameters::texturename, "texture that Cs is multiplied by; \"\" = none"));
  static constexpr uint64_t kTraits = PATINA_TRAIT_OPACITY_IS_OS;

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    color_ = context.openTexture(p.texturename);
    return PATINA_OK;
  }

  PatinaTexture* texture(uint32_t) const { return color_; }
  std::array<TextureLookup, 1> lookups(const Parameters&, const Surface<kST | kFootprint>& at) const {
    return {{{at.s, at.t, at.footprint_st}}};
  }

  Radiosity radiosity(const Parameters& p, const Surface<kCs | kOs>& at, const Texels<1>& texels) const {
    // Pictures with values above one are light, not paint.
    const Color& c = texels[0].color;
    return diffuseSurface(at.Cs * Color(clamp(c.r, 0, 1), clamp(c.g, 0, 1), clamp(c.b, 0, 1)), at.Os, p.Ka,
                          p.Kd);
  }

 private:
  PatinaTexture* color_ = nullptr;
};

}  // namespace

PATINA_SHADERS(TexturedMatte)
