// SPDX-License-Identifier: Apache-2.0
// arealight: makes the geometry of an AreaLightSource shine, alike all over or as a texture has it.
#include <patina/sdk.h>

using namespace patina::sdk;

namespace {

struct AreaLight {
  struct Parameters {
    float intensity = 1;
    Color lightcolor = 1;
    int32_t sides = 1, normalize = 0;
    const char* texturename = "";
    float focus = 0, coneangle = kPi / 2, conedeltaangle = 0;
  };
  static constexpr auto kInfo = describe(
      "arealight",
      "The geometry that it is bound to emits the radiance intensity * lightcolor (* texture) [* "
      "cosangle^focus * smoothstep(cos(coneangle), cos(coneangle - conedeltaangle), cosangle)]",
      uniform("intensity", &Parameters::intensity, "scale of lightcolor", kPositive),
      uniform("lightcolor", &Parameters::lightcolor, "colour of the light", kPositive, "W/(m^2 sr)"),
      uniform("sides", &Parameters::sides, "1 = only the outside shines, 2 = both sides", {1, 2}),
      uniform(
          "normalize", &Parameters::normalize,
          "1 = radiance is divided by the light's area in world units: larger lights are no brighter ones",
          {0, 1}),
      uniform("texturename", &Parameters::texturename,
              "picture over the surface's parameters u and v that lightcolor is multiplied by; \"\" = none"),
      uniform("focus", &Parameters::focus,
              "exponent of the fall-off with the angle from the normal; 0 = none", {0, 1e4}),
      uniform("coneangle", &Parameters::coneangle, "from the normal to the edge of the light's cone",
              {0, 1.5707964}, "radian"),
      uniform("conedeltaangle", &Parameters::conedeltaangle, "width of the soft edge, inside the cone",
              {0, 1.5707964}, "radian"));
  static constexpr uint64_t kTraits = 0;

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    if (p.sides == 2) context.set(PATINA_TRAIT_TWO_SIDED);
    if (p.normalize) context.set(PATINA_TRAIT_PER_AREA);
    limited_ = p.coneangle < 1.5707f;
    edge_ = std::cos(p.coneangle), full_ = std::cos(std::max(p.coneangle - p.conedeltaangle, 0.0f));
    picture_ = context.openTexture(p.texturename);
    Color mean = 1;
    if (picture_) {
      const float middle = 0.5f, all = 1;
      const PatinaPlane at{&middle, 0, 0}, width{&all, 0, 0};
      const PatinaStatus status = context.host.texture(context.host.host, picture_, 1, at, at, width,
                                                       {&mean.r, &mean.g, &mean.b}, nullptr);
      if (status != PATINA_OK) return status;
    }
    // Of cosangle^focus over a hemisphere, weighed by the cosine, what one is of all light.
    const float inCone = limited_ ? 1 - std::pow(edge_, p.focus + 2) : 1;
    // The picture's mean may be black where it was looked at: a guess at power switches no light off.
    const Color whole = p.intensity * p.lightcolor * (float(p.sides) * 2 / (p.focus + 2) * inCone);
    context.lightPower(whole);
    if (!isBlack(whole)) context.traits.light_power *= std::max(luminance(mean), 1e-3f);
    return PATINA_OK;
  }

  PatinaTexture* texture(uint32_t) const { return picture_; }
  std::array<TextureLookup, 1> lookups(const Parameters&, const LightQuery& at) const {
    return {{{at.u, at.v, 0}}};
  }

  Color emit(const Parameters& p, const LightQuery& at, const Texels<1>& texels) const {
    const float signedCosine = dot(at.N, at.direction);
    const float cosine = p.sides == 2 ? std::abs(signedCosine) : signedCosine;
    const float beam =
        pow(std::max(cosine, 1e-6f), p.focus) * (limited_ ? smoothstep(edge_, full_, cosine) : 1.0f);
    return p.lightcolor * texels[0].color * (cosine > 0 || p.sides == 2 ? p.intensity * beam : 0.0f);
  }

 private:
  PatinaTexture* picture_ = nullptr;
  bool limited_ = false;
  float edge_ = 0, full_ = 0;  // cosines
};

}  // namespace

PATINA_SHADERS(AreaLight)
