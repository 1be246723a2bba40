// SPDX-License-Identifier: Apache-2.0
// Scattering at a shaded point: diffuse reflection and transmission, and the lobes that `view` gave.
#pragma once

#include <span>

#include "renderer/shading/custom_lobe.h"
#include "renderer/shading/light_bounds.h"
#include "renderer/shading/shading_point.h"

namespace patina {

/// The cosine lobe about a shading normal N reaches below the facet, whose normal Ng is another one, and
/// light from there is lost: a share of (1 - N.Ng) / 2, which adds up over bounces. So the lobe is folded:
/// what reaches below is mirrored in the facet's plane. The folded lobe integrates to pi over the facet's
/// hemisphere, and differs from N.w near its horizon only.
inline V3f foldDirection(const V3f& w, const V3f& Ng) {
  const float height = w.dot(Ng);
  return height < 0 ? w - Ng * (2 * height) : w;
}
/// The density of the folded lobe times pi; w is above the facet.
inline float foldedCosine(const V3f& w, const V3f& N, const V3f& Ng) {
  const float cosine = w.dot(N), image = cosine - 2 * w.dot(Ng) * N.dot(Ng);
  return std::max(cosine, 0.0f) + std::max(image, 0.0f);
}

/// A direction chosen in proportion to a BSDF, roughly.
struct BsdfSample {
  V3f direction{0, 0, 1};    ///< unit, away from the point
  Rgb weight{0, 0, 0};       ///< f |cos| / pdf
  float pdf = 0;             ///< per solid angle; 0 = nothing to follow. Of delta lobes: 1
  bool delta = false;        ///< a mirror or smooth glass
  bool diffuse = false;      ///< by what scatters there, not by which lobe drew it
  bool transmitted = false;  ///< to the other side
  float alpha = 0;           ///< roughness of the lobe, for the ray's spread
};

/// The BSDF of one point. Directions point away from the surface; `wo` is to the viewer. Directions count as
/// reflected or transmitted by the geometric normal, and lobes are shaded with N. [one thread]
class Bsdf {
 public:
  /// `parts` selects among diffuse and specular lobes. The lobes must outlive the BSDF.
  Bsdf(const ShadingPoint& point, const SurfaceTerms& terms, std::span<const Lobe> lobes);

  /// f |cos| and the density of sample() for a given direction, without delta lobes.
  struct Value {
    Rgb f{0, 0, 0};
    float pdf = 0;
  };
  /// Light of a delta light, which no sample() finds, is weighted with the plain cosine of N.
  Value evaluate(const V3f& wi, bool deltaLight = false) const { return evaluate(wi, true, deltaLight); }
  /// The lobes alone, without the diffuse terms; densities are those of sampleSpecular().
  Value evaluateSpecular(const V3f& wi) const { return evaluate(wi, false, false); }

  BsdfSample sample(float choice, const V2f& random) const { return sample(choice, random, true); }
  BsdfSample sampleSpecular(float choice, const V2f& random) const { return sample(choice, random, false); }

  /// Whether light from behind the facet may scatter to the viewer.
  bool transmits() const;
  /// As lights see the point.
  LightReceiver receiver() const { return {point_.P, point_.Ng, transmits()}; }

  bool hasLobes() const { return !lobes_.empty(); }
  bool isBlack() const { return total_ <= 0; }
  /// Whether anything but delta lobes scatters: whether lights are worth sampling.
  bool scattersSmoothly(bool withDiffuse) const;

 private:
  Value evaluate(const V3f& wi, bool withDiffuse, bool deltaLight) const;
  BsdfSample sample(float choice, const V2f& random, bool withDiffuse) const;
  BsdfSample weighed(BsdfSample s, bool withDiffuse, float u) const;
  float cosineAt(const V3f& wi, bool deltaLight) const;
  Rgb diffuseAt(const V3f& wi, bool deltaLight) const;  ///< f |cos| of the diffuse terms
  CustomLobe::At customAt(const Lobe& lobe) const;
  float lobeChance(const Lobe& lobe) const;

  const ShadingPoint& point_;
  const SurfaceTerms& terms_;
  std::span<const Lobe> lobes_;
  V3f wo_;
  Frame frame_;
  float reflectChance_, transmitChance_, total_;  ///< relative probabilities
};

/// Fresnel reflectance of a dielectric for unpolarised light; `cosine` on the side of incidence, eta = n_t /
/// n_i.
float fresnelDielectric(float cosine, float eta);

}  // namespace patina
