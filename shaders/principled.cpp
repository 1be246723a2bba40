// SPDX-License-Identifier: Apache-2.0
// principled: paint, plastic, metal, cloth, glass and what lies between, by parameters that mean the same
// everywhere.
//
// Layers, from the outside: sheen, clear coat, and a base that is metallic or not; what is not metallic is
// glossy over a diffuse body, or lets light through. Each layer gets the light that those above do not
// reflect: the directional albedos of sdk/microfacets.h say how much that is (after Kulla and Conty,
// "Revisiting Physically Based Shading at Imageworks", SIGGRAPH 2017 course; rough gloss gets back what it
// loses after Turquin, "Practical Multiple Scattering Compensation for Microfacet Models", 2019).
//
// The diffuse body is seen from no direction in particular: `radiosity` takes the layers' albedos averaged
// over the hemisphere (by the cosine). Seen at grazing angles gloss may reflect more than that leaves; there
// `view` scales all lobes down to the share that the body does not reflect, so that no direction gets more
// light than there is.
#include <patina/sdk.h>
#include <patina/sdk/microfacets.h>

using namespace patina::sdk;

namespace {

struct Principled {
  struct Parameters {
    Color basecolor = 1;
    float metallic = 0, roughness = 0.5f, specular = 1, ior = 1.5f, anisotropy = 0;
    float transmission = 0, coat = 0, coatroughness = 0.1f, coatior = 1.5f;
    float sheen = 0, sheenroughness = 0.3f, subsurface = 0, emissionstrength = 1, bumpdepth = 0.01f;
    Color sheencolor = 1, subsurfacecolor = 1, emission = 0, opacity = 1;
    const char *basecolormap = "", *metallicmap = "", *roughnessmap = "", *emissionmap = "", *opacitymap = "",
               *normalmap = "", *bumpmap = "";
  };
  static constexpr auto kInfo = describe(
      "principled",
      "Layers of sheen, clear coat, gloss or metal, and a diffuse or clear body, that make no energy; as "
      "Displacement: "
      "normals by normalmap and bumpmap",
      varying("basecolor", &Parameters::basecolor, "colour of the body, and of metal seen head-on; times Cs",
              kUnitRange),
      varying("metallic", &Parameters::metallic, "1 = metal: all gloss has the colour of the base",
              kUnitRange),
      varying("roughness", &Parameters::roughness, "of the base: the square root of GGX's alpha", kUnitRange),
      uniform("specular", &Parameters::specular, "weight of the gloss of what is not metal", kUnitRange),
      uniform("ior", &Parameters::ior, "index of refraction of what is not metal, inside relative to outside",
              {1, 4}),
      uniform("anisotropy", &Parameters::anisotropy, "how far gloss is drawn out along s, as by a brush",
              kUnitRange),
      uniform("transmission", &Parameters::transmission,
              "share of what is not metal that is clear, as glass coloured by basecolor", kUnitRange),
      uniform("coat", &Parameters::coat, "how much of the surface has a clear coat", kUnitRange),
      uniform("coatroughness", &Parameters::coatroughness, "of the coat, as roughness", kUnitRange),
      uniform("coatior", &Parameters::coatior, "index of refraction of the coat", {1, 4}),
      uniform("sheen", &Parameters::sheen, "weight of the sheen of cloth or dust", kUnitRange),
      uniform("sheencolor", &Parameters::sheencolor, "colour of the sheen", kUnitRange),
      uniform("sheenroughness", &Parameters::sheenroughness, "how far fibres stand off", kUnitRange),
      uniform("subsurface", &Parameters::subsurface,
              "share of the body that has subsurfacecolor; diffuse, for now", kUnitRange),
      uniform("subsurfacecolor", &Parameters::subsurfacecolor, "tint of light that went through the body",
              kUnitRange),
      uniform("emission", &Parameters::emission, "radiance that is added", kPositive),
      uniform("emissionstrength", &Parameters::emissionstrength, "times emission", kPositive),
      uniform("opacity", &Parameters::opacity, "times Os; 0 = cut out", kUnitRange),
      uniform("basecolormap", &Parameters::basecolormap, "texture, times basecolor"),
      uniform("metallicmap", &Parameters::metallicmap,
              "texture whose first channel is multiplied by metallic"),
      uniform("roughnessmap", &Parameters::roughnessmap,
              "texture whose first channel is multiplied by roughness"),
      uniform("emissionmap", &Parameters::emissionmap, "texture, times emission"),
      uniform("opacitymap", &Parameters::opacitymap, "texture, times opacity"),
      uniform("normalmap", &Parameters::normalmap,
              "as Displacement: texture of normals, 0.5 + 0.5 n, x along s and y along t, down the picture"),
      uniform("bumpmap", &Parameters::bumpmap,
              "as Displacement: texture of heights in its first channel, that normals follow"),
      uniform("bumpdepth", &Parameters::bumpdepth, "height where bumpmap is 1, world units"));

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    albedo_ = &LobeAlbedo::get();
    const char* const names[] = {p.basecolormap, p.metallicmap, p.roughnessmap, p.emissionmap,
                                 p.opacitymap,   p.normalmap,   p.bumpmap};
    bool any = false;
    for (size_t k = 0; k < std::size(names); ++k) {
      const bool isColor = k == kBase || k == kEmission;
      maps_[k] = isColor ? context.openTexture(names[k]) : context.openData(names[k]);
      any |= maps_[k] != nullptr;
    }
    for (int k = 1; k < kBumps; ++k) maps_[kBump + k] = maps_[kBump];
    PatinaTraits& traits = context.traits;
    for (uint64_t& reads : traits.reads)
      if (!any) reads &= ~(kST | kFootprint);
    if (p.anisotropy == 0) traits.reads[PATINA_ENTRY_VIEW] &= ~kDPds;
    traits.flags = 0;
    if (isBlack(p.opacity - Color(1)) && !maps_[kOpacity]) context.set(PATINA_TRAIT_OPACITY_IS_OS);
    if (!isBlack(p.emission * p.emissionstrength)) context.set(PATINA_TRAIT_EMITS);
    // Normals only: P stays where it is.
    if (maps_[kNormal] || maps_[kBump])
      traits.displacement_bound = 1e-6f;
    else
      context.disable(PATINA_ENTRY_DISPLACEMENT);
    return PATINA_OK;
  }

  enum Map { kBase, kMetallic, kRoughness, kEmission, kOpacity, kNormal, kBump };
  static constexpr int kBumps = 4, kMaps = kBump + kBumps;  // heights on both sides, along s and along t
  PatinaTexture* texture(uint32_t k) const { return maps_[k]; }
  std::array<TextureLookup, kMaps> lookups(const Parameters&, const Surface<kST | kFootprint>& at) const {
    const TextureLookup here{at.s, at.t, at.footprint_st};
    const float step = bumpStep(at.footprint_st);
    return {{here,
             here,
             here,
             here,
             here,
             here,
             {at.s - step, at.t, at.footprint_st},
             {at.s + step, at.t, at.footprint_st},
             {at.s, at.t - step, at.footprint_st},
             {at.s, at.t + step, at.footprint_st}}};
  }

  Radiosity radiosity(const Parameters& p, const Surface<kCs | kOs>& at, const Texels<kMaps>& texels) const {
    const Base base = baseOf(p, at.Cs, texels);
    const Color opacity = opacityOf(p, at.Os, texels);
    Radiosity out;
    out.opacity = opacity;
    out.reflectance = out.ambient = opacity * diffuse(p, base);
    out.emission = opacity * p.emission * texels[kEmission].color * p.emissionstrength;
    return out;
  }

  ViewWith<View<PATINA_LOBE_DIELECTRIC>, Gloss, Gloss, Sheen> view(
      const Parameters& p, const Surface<kN | kI | kCs | kOs | kDPds>& at,
      const Texels<kMaps>& texels) const {
    const Base base = baseOf(p, at.Cs, texels);
    const float cosine = std::max(-dot(at.N, at.I), 1e-3f);

    // Each layer's share of light, from the outside to the inside.
    const float sheenRoughness = std::max(p.sheenroughness, Sheen::kLeastRoughness);
    const float sheenAlbedo = std::max(albedo_->sheen(cosine, sheenRoughness), 1e-3f);
    const Color sheen = p.sheencolor * (p.sheen * sheenAlbedo);
    float left = 1 - largest(sheen);
    const float coatAlpha = alphaOf(p.coatroughness);
    const Layer coat = layer(Color(normalReflectance(p.coatior)), cosine, coatAlpha);
    const float coated = p.coat * left;
    left -= largest(coat.share) * coated;
    const Layer gloss = layer(base.gloss, cosine, base.alpha);
    const float opaque = left * (1 - base.clear), clear = left * base.clear;

    // No more than the body leaves.
    const float all = largest(sheen) + largest(coat.share) * coated + largest(gloss.share) * opaque + clear;
    const float scale = std::min(1.0f, (1 - largest(diffuse(p, base))) / std::max(all, 1e-6f));
    const Color weight = opacityOf(p, at.Os, texels) * scale;

    ViewWith<View<PATINA_LOBE_DIELECTRIC>, Gloss, Gloss, Sheen> out;
    Lobe& glass = out.lobes[0];
    glass.weight = weight * clear, glass.transmission = weight * base.color * clear;
    glass.alpha = base.alpha, glass.eta = p.ior;
    const Vector along = p.anisotropy > 0 ? at.dPds : Vector(1, 0, 0);
    const float stretch = std::sqrt(1 - 0.9f * p.anisotropy);  // Burley, SIGGRAPH 2012 course, section 5.4
    setGloss(std::get<0>(out.own), gloss, weight * opaque, base.gloss,
             std::max(base.alpha / stretch, Gloss::kLeastAlpha),
             std::max(base.alpha * stretch, Gloss::kLeastAlpha), along);
    setGloss(std::get<1>(out.own), coat, weight * coated, Color(normalReflectance(p.coatior)), coatAlpha,
             coatAlpha, along);
    OwnLobe<Sheen>& cloth = std::get<2>(out.own);
    cloth.weight = weight * sheen;
    cloth.alpha = 1;
    cloth.lobe.roughness = sheenRoughness, cloth.lobe.scale = 1 / sheenAlbedo;
    return out;
  }

  DisplacedNormal displacement(const Parameters& p,
                               const Surface<kP | kN | kST | kFootprint | kDPds | kDPdt>& at,
                               const Texels<kMaps>& texels) const {
    const Vector s = at.dPds - at.N * dot(at.N, at.dPds), t = at.dPdt - at.N * dot(at.N, at.dPdt);
    const Color& c = texels[kNormal].color;
    const Vector mapped =
        normalize(s) * (2 * c.r - 1) + normalize(t) * (2 * c.g - 1) + at.N * std::max(2 * c.b - 1, 0.05f);
    const Vector n = maps_[kNormal] ? normalize(mapped) : Vector(at.N);
    if (!maps_[kBump]) return {at.P, n};
    // Heights bend the normal by their gradient on the surface: Blinn, "Simulation of Wrinkled Surfaces",
    // SIGGRAPH 1978, section 2, for s and t at any angle. What was really stepped, rounding included,
    // divides.
    const float step = bumpStep(at.footprint_st);
    const float ds = (at.s + step) - (at.s - step), dt = (at.t + step) - (at.t - step);
    const float alongS =
                    p.bumpdepth * (texels[kBump + 1].color.r - texels[kBump].color.r) / std::max(ds, step),
                alongT = p.bumpdepth * (texels[kBump + 3].color.r - texels[kBump + 2].color.r) /
                         std::max(dt, step);
    // By unit vectors along s and t, whose lengths may differ by any factor.
    const float lengthS = length(s), lengthT = length(t);
    const Vector unitS = normalize(s), unitT = normalize(t);
    const float sine = dot(at.N, cross(unitS, unitT));
    constexpr float kSteepest = 20, kLeastSine = 1e-3f;
    const float perS = clamp(alongS / std::max(lengthS, 1e-12f), -1e6f, 1e6f),
                perT = clamp(alongT / std::max(lengthT, 1e-12f), -1e6f, 1e6f);
    const bool spans = std::abs(sine) > kLeastSine;  // else there is no telling which way it leans
    const Vector gradient =
        (cross(unitT, at.N) * perS + cross(at.N, unitS) * perT) * (spans ? 1 / (spans ? sine : 1.0f) : 0.0f);
    const float limit = std::min(1.0f, kSteepest / std::max(length(gradient), 1e-6f));
    return {at.P, normalize(n - gradient * limit)};
  }

 private:
  /// What lies under coat and sheen.
  struct Base {
    Color color, gloss;  ///< gloss: reflectance head-on
    float metallic, alpha, clear;
  };
  /// Gloss with what it loses given back: the share that it reflects, that of its largest channel before, and
  /// what the lobe, which has Fresnel's colour itself and a largest albedo of one, is to be weighted with.
  struct Layer {
    Color share, weight;
    float albedo;
  };

  /// Half a difference of heights, in s and t: as fine as the texture is seen.
  PATINA_INLINE static float bumpStep(float footprint) {
    return clamp(0.5f * footprint, 1.0f / 16384, 1.0f / 512);
  }
  PATINA_INLINE static float largest(const Color& c) { return std::max(c.r, std::max(c.g, c.b)); }
  PATINA_INLINE static Color clamped(const Color& c) {
    return {clamp(c.r, 0, 1), clamp(c.g, 0, 1), clamp(c.b, 0, 1)};
  }
  PATINA_INLINE static float alphaOf(float roughness) {
    return clamp(roughness * roughness, Gloss::kLeastAlpha, 1);
  }
  PATINA_INLINE static Color opacityOf(const Parameters& p, const Color& Os, const Texels<kMaps>& texels) {
    return Os * clamped(p.opacity * texels[kOpacity].color);
  }
  PATINA_INLINE static Base baseOf(const Parameters& p, const Color& Cs, const Texels<kMaps>& texels) {
    Base base;
    base.color = clamped(Cs * p.basecolor * texels[kBase].color);
    base.metallic = clamp(p.metallic * texels[kMetallic].color.r, 0, 1);
    base.alpha = alphaOf(clamp(p.roughness * texels[kRoughness].color.r, 0, 1));
    base.gloss = mix(Color(p.specular * normalReflectance(p.ior)), base.color, base.metallic);
    base.clear = p.transmission * (1 - base.metallic);
    return base;
  }
  PATINA_INLINE Layer layer(const Color& reflectance, float cosine, float alpha) const {
    const Color share = albedo_->gloss(reflectance, cosine, alpha);
    const float lost = 1 / std::max(albedo_->whole(cosine, alpha), 0.1f) - 1,
                albedo = std::max(largest(share), 1e-3f);
    const Color given = Color(1) + reflectance * lost;
    return {clamped(share * given), clamped(given * albedo), albedo};
  }
  /// Seen from no direction in particular: what sheen, coat and gloss leave to the body.
  PATINA_INLINE Color diffuse(const Parameters& p, const Base& base) const {
    const float body = (1 - base.metallic) * (1 - p.transmission);
    const float dielectric = p.specular * normalReflectance(p.ior);
    const float gloss = albedo_->glossMean(Color(dielectric), base.alpha).r;
    const float coat =
        p.coat * albedo_->glossMean(Color(normalReflectance(p.coatior)), alphaOf(p.coatroughness)).r;
    const float sheen = p.sheen * largest(p.sheencolor) *
                        albedo_->sheenMean(std::max(p.sheenroughness, Sheen::kLeastRoughness));
    return mix(base.color, p.subsurfacecolor * base.color, p.subsurface) *
           (body * (1 - gloss) * (1 - coat) * (1 - sheen));
  }
  PATINA_INLINE static void setGloss(OwnLobe<Gloss>& to, const Layer& layer, const Color& scale,
                                     const Color& reflectance, float alphaX, float alphaY,
                                     const Vector& along) {
    to.weight = scale * layer.weight;
    to.alpha = std::sqrt(alphaX * alphaY);
    to.lobe.reflectance = reflectance;
    to.lobe.scale = 1 / layer.albedo;
    to.lobe.alphaX = alphaX, to.lobe.alphaY = alphaY;
    to.lobe.along = along;
  }

  const LobeAlbedo* albedo_ = nullptr;
  std::array<PatinaTexture*, kMaps> maps_{};
};

}  // namespace

PATINA_SHADERS(Principled)
