// SPDX-License-Identifier: Apache-2.0
// displace: displacement by a texture with a bound and a height that stays where it is.
#include <patina/sdk.h>

using namespace patina::sdk;

namespace {

struct Displace {
  struct Parameters {
    float Km = 0.1f, middle = 0.5f, low = 0, high = 1;
    const char* texturename = "";
  };
  static constexpr auto kInfo = describe(
      "displace",
      "Displacement by a texture: P += Km * (clamp(texture(texturename), low, high) - middle) * N, with its "
      "first "
      "channel",
      uniform("Km", &Parameters::Km, "displacement where the texture is middle + 1, world units"),
      uniform("middle", &Parameters::middle, "what the texture is where nothing is moved"),
      uniform("low", &Parameters::low, "lower heights of the texture are taken for this one"),
      uniform("high", &Parameters::high, "higher heights of the texture are taken for this one"),
      uniform("texturename", &Parameters::texturename, "texture of heights; \"\" = nothing is moved"));

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    heights_ = context.openData(p.texturename);
    // How far the texture may go is not known before it has been read: hence low and high.
    const float furthest = std::max(std::abs(p.low - p.middle), std::abs(p.high - p.middle));
    context.traits.displacement_bound = std::abs(p.Km) * furthest;
    if (heights_) height_ = p.Km;
    if (height_ == 0) context.disable(PATINA_ENTRY_DISPLACEMENT);
    return PATINA_OK;
  }

  PatinaTexture* texture(uint32_t) const { return heights_; }
  std::array<TextureLookup, 1> lookups(const Parameters&, const Surface<kST | kFootprint>& at) const {
    return {{{at.s, at.t, at.footprint_st}}};
  }

  Displaced displacement(const Parameters& p, const Surface<kP | kN>& at, const Texels<1>& texels) const {
    return {at.P + at.N * (height_ * (clamp(texels[0].color.r, p.low, p.high) - p.middle))};
  }

 private:
  PatinaTexture* heights_ = nullptr;
  float height_ = 0;  // Km where there is a texture
};

}  // namespace

PATINA_SHADERS(Displace)
