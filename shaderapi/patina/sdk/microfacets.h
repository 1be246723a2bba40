// SPDX-License-Identifier: Apache-2.0
// Lobes that the host does not have (see lobes.h): gloss with Fresnel's effect, along a grain or not, and the
// sheen of cloth; and the share of light that they reflect, by which layers are put on each other without
// making energy.
#pragma once

#include "lobes.h"

namespace patina::sdk {

/// Schlick's approximation of Fresnel's equations: `normal` is the reflectance at normal incidence.
PATINA_INLINE Color schlick(const Color& normal, float cosine) {
  const float m = clamp(1 - cosine, 0, 1), m2 = m * m, part = m2 * m2 * m;
  return normal * (1 - part) + Color(part);
}
/// The reflectance of a dielectric of that index of refraction at normal incidence.
PATINA_INLINE constexpr float normalReflectance(float ior) {
  const float r = (ior - 1) / (ior + 1);
  return r * r;
}

/// Reflection by microfacets: GGX, stretched along the tangent, with height-correlated Smith
/// masking-shadowing (Heitz, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", JCGT
/// 3(2), 2014, eqs. 85-87, 99), and Schlick's Fresnel term. Visible normals are sampled (Heitz, JCGT 7(4),
/// 2018). Light that meets the surface twice is lost: what `scale` may give back.
struct Gloss {
  static constexpr LobeInfo kLobe{"gloss", "GGX reflection with Fresnel's effect, along a grain or not"};
  Color reflectance{0.04f};            ///< at normal incidence
  float scale = 1;                     ///< of all that is reflected
  float alphaX = 0.1f, alphaY = 0.1f;  ///< roughness along the tangent and across; at least kLeastAlpha
  Vector along{1, 0, 0};               ///< world space

  /// Below, densities would exceed what floats hold.
  static constexpr float kLeastAlpha = 2e-3f;

  Vector tangent() const { return along; }

  PATINA_INLINE float lambda(const Vector& w) const {
    const float x = alphaX * w.x, y = alphaY * w.y;
    return 0.5f * (std::sqrt(1 + (x * x + y * y) / std::max(w.z * w.z, 1e-20f)) - 1);
  }
  PATINA_INLINE float density(const Vector& h) const {
    const float x = h.x / alphaX, y = h.y / alphaY, d = x * x + y * y + h.z * h.z;
    return h.z > 0 ? 1 / (kPi * alphaX * alphaY * d * d) : 0;
  }
  PATINA_INLINE Color eval(const Vector& wo, const Vector& wi) const {
    if (!(wo.z > 0 && wi.z > 0)) return Color();
    const Vector h = normalize(wo + wi);
    return schlick(reflectance, dot(wo, h)) *
           (scale * density(h) / (4 * wo.z * (1 + lambda(wo) + lambda(wi))));
  }
  PATINA_INLINE float pdf(const Vector& wo, const Vector& wi) const {
    if (!(wo.z > 0 && wi.z > 0)) return 0;
    return density(normalize(wo + wi)) / (4 * wo.z * (1 + lambda(wo)));
  }
  PATINA_INLINE Vector sample(const Vector& wo, float x, float y) const {
    const Vector v = normalize(Vector(alphaX * wo.x, alphaY * wo.y, wo.z));
    const float flat = v.x * v.x + v.y * v.y;
    const Vector t1 = flat > 0 ? Vector(-v.y, v.x, 0) * (1 / std::sqrt(flat)) : Vector(1, 0, 0);
    const Vector t2 = cross(v, t1);
    const float r = std::sqrt(x), phi = 2 * kPi * y, p1 = r * cos(phi), s = 0.5f * (1 + v.z);
    const float p2 = (1 - s) * std::sqrt(std::max(1 - p1 * p1, 0.0f)) + s * r * sin(phi);
    const Vector n = t1 * p1 + t2 * p2 + v * std::sqrt(std::max(1 - p1 * p1 - p2 * p2, 0.0f));
    const Vector h = normalize(Vector(alphaX * n.x, alphaY * n.y, std::max(n.z, 1e-6f)));
    const Vector wi = h * (2 * dot(wo, h)) - wo;
    return wi.z > 0 ? normalize(wi) : Vector();
  }
};

/// The sheen of cloth: fibres that stand off the surface (Estevez and Kulla, "Production Friendly Microfacet
/// Sheen BRDF", SIGGRAPH 2017 course "Physically Based Shading": distribution, eq. 2, and the fit of its
/// Lambda, section 3). Without their softening of the terminator, which is not reciprocal.
struct Sheen {
  static constexpr LobeInfo kLobe{"sheen", "light that fibres send back at grazing angles"};
  float roughness = 0.3f;  ///< at least kLeastRoughness
  float scale = 1;         ///< of all that is reflected

  static constexpr float kLeastRoughness = 0.07f;

  PATINA_INLINE float curve(float cosine) const {
    const float t = (1 - roughness) * (1 - roughness);
    const float a = mix(21.5473f, 25.3245f, t), b = mix(3.82987f, 3.32435f, t),
                c = mix(0.19823f, 0.16801f, t), d = mix(-1.97760f, -1.27393f, t),
                e = mix(-4.32054f, -4.85967f, t);
    return a / (1 + b * pow(std::max(cosine, 1e-6f), c)) + d * cosine + e;
  }
  PATINA_INLINE float lambda(float cosine) const {
    return exp(cosine < 0.5f ? curve(cosine) : 2 * curve(0.5f) - curve(1 - cosine));
  }
  PATINA_INLINE Color eval(const Vector& wo, const Vector& wi) const {
    if (!(wo.z > 0 && wi.z > 0)) return Color();
    const Vector h = normalize(wo + wi);
    const float sine = std::sqrt(clamp(h.x * h.x + h.y * h.y, 1e-12f, 1));
    const float density = (2 + 1 / roughness) * pow(sine, 1 / roughness) / (2 * kPi);
    return Color(scale * density / (4 * wo.z * (1 + lambda(wo.z) + lambda(wi.z))));
  }
  PATINA_INLINE float pdf(const Vector&, const Vector& wi) const { return wi.z > 0 ? 1 / (2 * kPi) : 0; }
  PATINA_INLINE Vector sample(const Vector&, float x, float y) const { return uniformHemisphere(x, y); }
};

/// Shares of light from all around that Gloss (alphaX = alphaY) and Sheen of scale 1 reflect to a viewer,
/// from tables that are integrated when they are first wanted: directional albedos, as layers are scaled by.
class LobeAlbedo {
 public:
  /// The tables, one for each plugin. [any thread]
  static const LobeAlbedo& get() {
    static const LobeAlbedo albedo;
    return albedo;
  }

  /// Of Gloss with reflectance 1 at every angle: what microfacets do not lose.
  PATINA_INLINE float whole(float cosine, float alpha) const {
    return look(normal_, cosine, std::sqrt(alpha)) + look(grazing_, cosine, std::sqrt(alpha));
  }
  /// Of Gloss.
  PATINA_INLINE Color gloss(const Color& reflectance, float cosine, float alpha) const {
    const float root = std::sqrt(alpha);
    return reflectance * look(normal_, cosine, root) + Color(look(grazing_, cosine, root));
  }
  PATINA_INLINE float sheen(float cosine, float roughness) const { return look(sheen_, cosine, roughness); }

  /// The same, averaged over all directions of view by their cosine: seen from no direction in particular.
  PATINA_INLINE Color glossMean(const Color& reflectance, float alpha) const {
    return reflectance * along(normalMean_, std::sqrt(alpha)) + Color(along(grazingMean_, std::sqrt(alpha)));
  }
  PATINA_INLINE float wholeMean(float alpha) const {
    return along(normalMean_, std::sqrt(alpha)) + along(grazingMean_, std::sqrt(alpha));
  }
  PATINA_INLINE float sheenMean(float roughness) const { return along(sheenMean_, roughness); }

 private:
  static constexpr int kSize = 24;     // entries along cosine and roughness
  static constexpr int kSamples = 16;  // along each random number

  // Row by row of roughness, from 0 to 1; columns are the square root of the cosine, as albedos bend most
  // near 0.
  using Table = std::array<float, size_t(kSize* kSize)>;
  using Row = std::array<float, size_t(kSize)>;

  static float cosineOf(int column) {
    const float root = (static_cast<float>(column) + 0.25f) / (kSize - 0.75f);
    return root * root;
  }
  PATINA_INLINE static float look(const Table& table, float cosine, float row) {
    const float x = clamp(std::sqrt(std::max(cosine, 0.0f)) * (kSize - 0.75f) - 0.25f, 0, kSize - 1.001f),
                y = clamp(row * (kSize - 1), 0, kSize - 1.001f);
    const auto i = static_cast<int32_t>(x), j = static_cast<int32_t>(y);
    const float* at = &table[size_t(j * kSize + i)];
    const float s = x - static_cast<float>(i), t = y - static_cast<float>(j);
    return mix(mix(at[0], at[1], s), mix(at[kSize], at[kSize + 1], s), t);
  }
  PATINA_INLINE static float along(const Row& row, float at) {
    const float y = clamp(at * (kSize - 1), 0, kSize - 1.001f);
    const auto j = static_cast<int32_t>(y);
    return mix(row[size_t(j)], row[size_t(j) + 1], y - static_cast<float>(j));
  }

  LobeAlbedo() {
    for (int j = 0; j < kSize; ++j) {
      const float row = static_cast<float>(j) / (kSize - 1);
      Gloss gloss;
      gloss.reflectance = Color(1);
      gloss.alphaX = gloss.alphaY = std::max(row * row, Gloss::kLeastAlpha);
      Sheen sheen;
      sheen.roughness = std::max(row, Sheen::kLeastRoughness);
      for (int i = 0; i < kSize; ++i) integrate(gloss, sheen, cosineOf(i), size_t(j * kSize + i));
    }
    for (int j = 0; j < kSize; ++j) {
      normalMean_[size_t(j)] = mean(normal_, j);
      grazingMean_[size_t(j)] = mean(grazing_, j);
      sheenMean_[size_t(j)] = mean(sheen_, j);
    }
  }
  // By the lobes' own samples, one in each cell of a grid.
  void integrate(const Gloss& gloss, const Sheen& sheen, float cosine, size_t entry) {
    const Vector wo(std::sqrt(1 - cosine * cosine), 0, cosine);
    float normal = 0, grazing = 0, cloth = 0;
    for (int k = 0; k < kSamples * kSamples; ++k) {
      const float x = (static_cast<float>(k % kSamples) + 0.5f) / kSamples,
                  y = (static_cast<float>(k / kSamples) + 0.5f) / kSamples;
      if (const Vector wi = gloss.sample(wo, x, y); wi.z > 0) {
        const float weight = gloss.eval(wo, wi).r / std::max(gloss.pdf(wo, wi), 1e-30f);
        const float part = schlick(Color(0), dot(wo, normalize(wo + wi))).r;
        normal += weight * (1 - part), grazing += weight * part;
      }
      const Vector wi = sheen.sample(wo, x, y);
      cloth += sheen.eval(wo, wi).r / sheen.pdf(wo, wi);
    }
    constexpr float kShare = 1.0f / (kSamples * kSamples);
    normal_[entry] = normal * kShare, grazing_[entry] = grazing * kShare;
    sheen_[entry] = std::min(cloth * kShare, 1.0f);
  }
  // The integral of 2 cosine dcosine.
  static float mean(const Table& table, int row) {
    constexpr int kSteps = 256;
    float sum = 0;
    for (int k = 0; k < kSteps; ++k) {
      const float cosine = (static_cast<float>(k) + 0.5f) / kSteps;
      sum += 2 * cosine * look(table, cosine, static_cast<float>(row) / (kSize - 1)) / kSteps;
    }
    return sum;
  }

  Table normal_{}, grazing_{}, sheen_{};
  Row normalMean_{}, grazingMean_{}, sheenMean_{};
};

}  // namespace patina::sdk
