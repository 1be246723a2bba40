// SPDX-License-Identifier: Apache-2.0
// cutout: a sheet with holes: round ones in a grid, or where a texture's alpha has them.
#include <patina/sdk.h>
#include <patina/sdk/cells.h>
#include <patina/sdk/filter.h>

using namespace patina::sdk;

namespace {

struct Cutout {
  struct Parameters {
    float Ka = 1, Kd = 1, frequency = 8, radius = 0.3f;
    const char* texturename = "";
  };
  static constexpr auto kInfo = describe(
      "cutout",
      "A diffuse sheet with holes: Ci = Oi * Cs * (Ka * ambient() + Kd * diffuse(N)), Oi = Os times a "
      "texture's "
      "alpha, or else 0 in round holes",
      varying("Ka", &Parameters::Ka, "weight of ambient lights", kUnitRange),
      varying("Kd", &Parameters::Kd, "weight of diffuse reflection", kUnitRange),
      uniform("frequency", &Parameters::frequency, "round holes along one unit of s and of t", {0, 1e6}),
      uniform("radius", &Parameters::radius, "of round holes, in units of their distance", {0, 0.5}),
      uniform("texturename", &Parameters::texturename,
              "texture whose alpha is the opacity; \"\" = round holes"));
  static constexpr uint64_t kTraits = 0;

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    shape_ = context.openData(p.texturename);
    // A texture that is not there has no holes.
    isRound_ = p.radius > 0 && !(p.texturename && *p.texturename) ? 1.0f : 0.0f;
    if (!shape_ && isRound_ == 0) context.set(PATINA_TRAIT_OPACITY_IS_OS);
    return PATINA_OK;
  }

  PatinaTexture* texture(uint32_t) const { return shape_; }
  std::array<TextureLookup, 1> lookups(const Parameters&, const Surface<kST | kFootprint>& at) const {
    return {{{at.s, at.t, at.footprint_st}}};
  }

  Radiosity radiosity(const Parameters& p, const Surface<kST | kFootprint | kCs | kOs>& at,
                      const Texels<1>& texels) const {
    const float width = p.frequency * at.footprint_st;
    const float holes = outsideHoles(p.radius, p.frequency * at.s, p.frequency * at.t, width);
    const float solid = mix(clamp(texels[0].alpha, 0, 1), holes, isRound_);
    Radiosity out;
    out.opacity = at.Os * solid;
    out.reflectance = out.opacity * at.Cs * p.Kd;
    out.ambient = out.opacity * at.Cs * p.Ka;
    return out;
  }

 private:
  /// The edge is straight at the scale of a footprint that is small against the hole; one that is not sees
  /// the mean.
  static float outsideHoles(float radius, float s, float t, float width) {
    const float x = fraction(s) - 0.5f, y = fraction(t) - 0.5f;
    const float seen = filteredStep(radius, std::sqrt(x * x + y * y), width);
    return mix(1 - kPi * radius * radius, seen, cellLeft(width));
  }

  PatinaTexture* shape_ = nullptr;
  float isRound_ = 0;  // 1: it has round holes; a number, as branches stop vector code
};

}  // namespace

PATINA_SHADERS(Cutout)
