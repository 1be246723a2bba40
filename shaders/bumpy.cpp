// SPDX-License-Identifier: Apache-2.0
// bumpy: the displacement shader of RI 3.2 (appendix A): a texture says how far the surface is moved.
#include <patina/sdk.h>

using namespace patina::sdk;

namespace {

struct Bumpy {
  struct Parameters {
    float Km = 1;
    const char* texturename = "";
  };
  static constexpr auto kInfo = describe(
      "bumpy", "Displacement by a texture: P += Km * texture(texturename) * N, with its first channel",
      uniform("Km", &Parameters::Km, "displacement where the texture is 1, world units"),
      uniform("texturename", &Parameters::texturename, "texture of heights; \"\" = nothing is moved"));

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    heights_ = context.openData(p.texturename);
    if (!heights_ || p.Km == 0) context.disable(PATINA_ENTRY_DISPLACEMENT);
    return PATINA_OK;
  }

  PatinaTexture* texture(uint32_t) const { return heights_; }
  std::array<TextureLookup, 1> lookups(const Parameters&, const Surface<kST | kFootprint>& at) const {
    return {{{at.s, at.t, at.footprint_st}}};
  }

  Displaced displacement(const Parameters& p, const Surface<kP | kN>& at, const Texels<1>& texels) const {
    return {at.P + at.N * (heights_ ? p.Km * texels[0].color.r : 0.0f)};
  }

 private:
  PatinaTexture* heights_ = nullptr;
};

}  // namespace

PATINA_SHADERS(Bumpy)
