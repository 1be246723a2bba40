// SPDX-License-Identifier: Apache-2.0
// production: painted metal that has been outdoors for years, as heavy as film shaders are: six textures and
// eight fractal patterns at each point. For benchmarks, and as an example of layers.
#include <patina/sdk.h>
#include <patina/sdk/cells.h>
#include <patina/sdk/filter.h>
#include <patina/sdk/fractals.h>

using namespace patina::sdk;

namespace {

struct Production {
  struct Parameters {
    Color paintcolor{0.1f, 0.32f, 0.3f}, secondcolor{0.75f, 0.7f, 0.58f}, primercolor{0.42f, 0.16f, 0.1f};
    Color metalcolor{0.56f, 0.55f, 0.53f}, rustcolor{0.29f, 0.1f, 0.03f}, dirtcolor{0.09f, 0.07f, 0.05f};
    Color dustcolor{0.42f, 0.37f, 0.3f};
    float frequency = 1, wear = 0.45f, rust = 0.5f, dirt = 0.5f, dust = 0.4f, streaks = 0.5f,
          scratches = 0.4f;
    float gloss = 0.8f, roughness = 0.35f;
    const char *paintmap = "", *secondmask = "", *decalmap = "", *wearmask = "", *dirtmask = "",
               *glossmap = "";
  };
  static constexpr auto kInfo = describe(
      "production",
      "Weathered painted metal in shader space, z up: two paints, decal, scratches and chips down to primer "
      "and metal, "
      "rust, dirt, streaks, dust",
      uniform("paintcolor", &Parameters::paintcolor, "the paint, times Cs", kUnitRange),
      uniform("secondcolor", &Parameters::secondcolor, "paint where secondmask is bright", kUnitRange),
      uniform("primercolor", &Parameters::primercolor, "below the paint, at the rims of chips", kUnitRange),
      uniform("metalcolor", &Parameters::metalcolor, "reflectance of bare metal", kUnitRange),
      uniform("rustcolor", &Parameters::rustcolor, "metal where it has rusted", kUnitRange),
      uniform("dirtcolor", &Parameters::dirtcolor, "dirt and streaks", kUnitRange),
      uniform("dustcolor", &Parameters::dustcolor, "what lies on what faces up", kUnitRange),
      uniform("frequency", &Parameters::frequency, "of the largest patterns, in one unit of shader space",
              {0, 1e6}),
      uniform("wear", &Parameters::wear, "how much of the paint has gone", kUnitRange),
      uniform("rust", &Parameters::rust, "how much of the bare metal has rusted", kUnitRange),
      uniform("dirt", &Parameters::dirt, "how much dirt there is", kUnitRange),
      uniform("dust", &Parameters::dust, "how much dust there is", kUnitRange),
      uniform("streaks", &Parameters::streaks, "how far rain has carried dirt down", kUnitRange),
      uniform("scratches", &Parameters::scratches, "how scratched the paint is", kUnitRange),
      uniform("gloss", &Parameters::gloss,
              "of fresh paint: weight of its reflection, 1 = that of an index of 1.5", kUnitRange),
      uniform("roughness", &Parameters::roughness, "GGX alpha of fresh paint", {0.01, 1}),
      uniform("paintmap", &Parameters::paintmap, "texture that the paint is multiplied by"),
      uniform("secondmask", &Parameters::secondmask,
              "texture whose first channel says where the second paint is"),
      uniform("decalmap", &Parameters::decalmap, "texture over both paints, by its alpha"),
      uniform("wearmask", &Parameters::wearmask, "texture whose first channel scales wear"),
      uniform("dirtmask", &Parameters::dirtmask, "texture whose first channel scales dirt"),
      uniform("glossmap", &Parameters::glossmap, "texture whose first channel scales gloss"));
  static constexpr uint64_t kTraits = PATINA_TRAIT_OPACITY_IS_OS;

  enum Map { kPaint, kSecond, kDecal, kWear, kDirt, kGloss, kMaps };

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    toShader_ = Matrix(context.worldToShader());
    const char* const names[] = {p.paintmap, p.secondmask, p.decalmap, p.wearmask, p.dirtmask, p.glossmap};
    for (size_t k = 0; k < kMaps; ++k)
      maps_[k] = k == kPaint || k == kDecal ? context.openTexture(names[k]) : context.openData(names[k]);
    // Without a mask there is one paint, and no decal.
    second_ = maps_[kSecond] ? 1.0f : 0.0f, decal_ = maps_[kDecal] ? 1.0f : 0.0f;
    return PATINA_OK;
  }

  PatinaTexture* texture(uint32_t k) const { return maps_[k]; }
  std::array<TextureLookup, kMaps> lookups(const Parameters&, const Surface<kST | kFootprint>& at) const {
    const TextureLookup here{at.s, at.t, at.footprint_st};
    return {{here, here, here, here, here, here}};
  }

  Radiosity radiosity(const Parameters& p, const Surface<kP | kN | kFootprint | kCs | kOs>& at,
                      const Texels<kMaps>& texels) const {
    const Layers is = layersOf(p, at.P, at.footprint, texels);
    // Paint: faded in clouds, the second one and the decal upon it, scratches lighter.
    const Color paint = mix(at.Cs * p.paintcolor, p.secondcolor, second_ * unit(texels[kSecond].color.r)) *
                        (0.85f + 0.25f * fbm<6>(is.q * 1.7f + Vector(3, 1, 4), 1.7f * is.width));
    Color color = mix(clamped(paint * clamped(texels[kPaint].color)), clamped(texels[kDecal].color),
                      decal_ * unit(texels[kDecal].alpha));
    color = mix(color, color * 0.5f + Color(0.4f), 0.7f * is.scratch);
    // Chips: primer at their rims, metal inside, which is no diffuse reflector, and rust.
    color = mix(color, p.primercolor, is.primer);
    const Color rust = p.rustcolor * (1 + 0.5f * fbm<5>(is.q * 23, 23 * is.width));
    color = mix(color, clamped(rust), is.bare * is.rust);
    color = color * (1 - is.bare * (1 - is.rust));
    color = mix(color, p.dirtcolor, is.dirt);
    color = mix(color, p.dustcolor, dustOn(p, is, at.N));
    // What the gloss reflects does not get in.
    return diffuseSurface(clamped(color), at.Os, 1, 1 - kNormalReflectance);
  }

  View<PATINA_LOBE_GGX, PATINA_LOBE_GGX> view(const Parameters& p,
                                              const Surface<kP | kN | kI | kFootprint | kOs>& at,
                                              const Texels<kMaps>& texels) const {
    const Layers is = layersOf(p, at.P, at.footprint, texels);
    const float clean = (1 - is.dirt) * (1 - dustOn(p, is, at.N));
    const float painted = clean * (1 - is.bare) * (1 - is.primer);
    View<PATINA_LOBE_GGX, PATINA_LOBE_GGX> out;
    // Paint's reflection is bound by what the body leaves, whatever the angle.
    out.lobes[0].weight = at.Os * (kNormalReflectance * p.gloss * unit(texels[kGloss].color.r) * painted);
    const float peel = 0.08f * turbulence<3>(is.q * 41, 41 * is.width);
    out.lobes[0].alpha = clamp(p.roughness + peel + 0.3f * is.scratch, 0.01f, 1);
    out.lobes[1].weight = at.Os * p.metalcolor * (clean * is.bare * (1 - is.rust));
    out.lobes[1].alpha = clamp(0.25f + 0.2f * fbm<3>(is.q * 13, 13 * is.width), 0.05f, 1);
    return out;
  }

 private:
  static constexpr float kNormalReflectance = 0.04f;  // of an index of 1.5

  /// How much of each there is, in [0, 1]; q: shader space in units of the largest patterns.
  struct Layers {
    Vector q;
    float width, scratch, primer, bare, rust, dirt;
  };
  PATINA_INLINE static float unit(float x) { return clamp(x, 0, 1); }
  PATINA_INLINE static Color clamped(const Color& c) { return {unit(c.r), unit(c.g), unit(c.b)}; }

  PATINA_INLINE Layers layersOf(const Parameters& p, const Vector& P, float footprint,
                                const Texels<kMaps>& texels) const {
    Layers is;
    is.q = toShader_.point(P) * p.frequency;
    is.width = footprint * toShader_.scale() * p.frequency;
    // Fine lines, long in x.
    const Vector fine(is.q.x * 2, is.q.y * 60, is.q.z * 60);
    is.scratch = p.scratches * smoothstep(0.25f, 0.6f, fbm<4>(fine, 60 * is.width));
    // Paint comes off in patches with ragged edges.
    const float patches =
        fbm<7>(is.q * 1.3f, 1.3f * is.width) + 0.35f * turbulence<5>(is.q * 7, 7 * is.width) - 0.2f;
    const float off = patches + 2 * p.wear * unit(texels[kWear].color.r) - 1.1f;
    is.bare = smoothstep(0, 0.06f, off);
    is.primer = smoothstep(-0.06f, 0, off) * (1 - is.bare);
    // Rust in cells that have grown together.
    const float cells = worley(is.q * 9).f1 * cellLeft(9 * is.width);
    is.rust = smoothstep(
        -0.2f, 0.3f, fbm<5>(is.q * 4 + Vector(5, 9, 2), 4 * is.width) - 0.3f * cells + 1.6f * p.rust - 0.8f);
    // Dirt, and what rain has drawn out along z.
    const Vector drawn(is.q.x * 12, is.q.y * 12, is.q.z * 0.7f);
    const float streak = p.streaks * smoothstep(0, 0.7f, fbm<5>(drawn, 12 * is.width));
    const float grime = smoothstep(-0.3f, 0.8f, fbm<6>(is.q * 2.3f + Vector(8, 2, 7), 2.3f * is.width));
    is.dirt = 0.9f * unit(p.dirt * unit(texels[kDirt].color.r) * (grime + streak));
    return is;
  }
  PATINA_INLINE float dustOn(const Parameters& p, const Layers& is, const Vector& N) const {
    const float up = normalize(toShader_.normal(N)).z;
    return 0.95f * p.dust * smoothstep(0.2f, 0.95f, up) * (0.7f + 0.3f * fbm<4>(is.q * 5, 5 * is.width));
  }

  Matrix toShader_;
  std::array<PatinaTexture*, kMaps> maps_{};
  float second_ = 0, decal_ = 0;
};

}  // namespace

PATINA_SHADERS(Production)
