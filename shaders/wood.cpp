// SPDX-License-Identifier: Apache-2.0
// wood: a trunk's annual rings around the z axis of shader space, and its fibres.
#include <patina/sdk.h>
#include <patina/sdk/cells.h>
#include <patina/sdk/filter.h>
#include <patina/sdk/fractals.h>

#include "polished.h"

using namespace patina::sdk;

namespace {

struct Wood {
  struct Parameters : patina::shaders::PolishParameters {
    constexpr Parameters() : PolishParameters(0.15f, 0.2f) {}
    float frequency = 8, distortion = 0.6f, grain = 0.35f;
    Color lightcolor{0.7f, 0.41f, 0.18f}, darkcolor{0.34f, 0.15f, 0.05f};
  };
  static constexpr auto kInfo = describe(
      "wood",
      "Wood, cut from a trunk along the z axis of shader space: Ci = Os * (Cs * C * (Ka * ambient() + Kd * "
      "diffuse(N)) + specularcolor * Ks * specular(N, V, roughness)), where C goes from lightcolor to "
      "darkcolor "
      "within each annual ring",
      patina::shaders::polishParameters<Parameters>(),
      uniform("frequency", &Parameters::frequency, "annual rings in one unit of shader space", {0, 1e6}),
      uniform("distortion", &Parameters::distortion, "how far rings stray from circles, in rings", {0, 10}),
      uniform("grain", &Parameters::grain, "how dark the darkest fibres are", kUnitRange),
      uniform("lightcolor", &Parameters::lightcolor, "of wood that grew in spring", kUnitRange),
      uniform("darkcolor", &Parameters::darkcolor, "of wood that grew in late summer", kUnitRange));
  static constexpr uint64_t kTraits = PATINA_TRAIT_OPACITY_IS_OS;

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    toShader_ = Matrix(context.worldToShader());
    context.weights(p.Ka, p.Kd, p.specularcolor * p.Ks);
    return PATINA_OK;
  }

  Radiosity radiosity(const Parameters& p, const Surface<kP | kFootprint | kCs | kOs>& at) const {
    const Vector q = toShader_.point(at.P) * p.frequency;
    const float width = at.footprint * toShader_.scale() * p.frequency;

    // Trunks are not straight, and their rings wobble; both change slowly along the trunk.
    const Vector slow(0.12f * q.x, 0.12f * q.y, 0.03f * q.z);
    const Vector bend = vsnoise(Vector(0.5f, 1.5f, 0.03f * q.z)) * (2 * p.distortion);
    constexpr float kFarthest = 1e15f;  // whose square is finite
    const float x = clamp(q.x + bend.x, -kFarthest, kFarthest),
                y = clamp(q.y + bend.y, -kFarthest, kFarthest);
    const float ring = std::sqrt(x * x + y * y) + p.distortion * 1.5f * fbm<3>(slow, 0.12f * width, 2.3f);

    // Within a ring: darker and darker, then at once light again; some years are darker than others.
    const float year = mix(0.5f, cellnoise(ring, 3.5f), cellLeft(width));
    const float late = ringMean(ring, width) * (0.55f + 0.45f * year);

    // Fibres: noise that is long along the trunk.
    const Vector fibre(4 * q.x, 4 * q.y, 0.15f * q.z);
    const float dark = p.grain * (0.5f - 0.5f * fbm<2>(fibre, 4 * width) * (1 / amplitudes<2>()));
    return diffuseSurface(at.Cs * mix(p.lightcolor, p.darkcolor, late) * (1 - dark), at.Os, p.Ka, p.Kd);
  }

  View<PATINA_LOBE_RI_SPECULAR> view(const Parameters& p, const Surface<kOs>& at) const {
    return highlights(p.specularcolor * p.Ks, at.Os, p.roughness);
  }

 private:
  // The profile of a ring: up from 0.2 to 0.85 and down to 1. Its integral, and its mean over a box.
  static float ringIntegral(float x) {
    const float f = fraction(x);
    return (x - f) * kRingMean + smoothstepIntegral(0.2f, 0.85f, f) - smoothstepIntegral(0.85f, 1, f);
  }
  static float ringMean(float x, float width) {
    const float w = clamp(width, 0.01f, 1e6f), from = fraction(x - 0.5f * w);
    return clamp((ringIntegral(from + w) - ringIntegral(from)) / w, 0, 1);
  }
  static constexpr float kRingMean = smoothstepIntegral(0.2f, 0.85f, 1) - smoothstepIntegral(0.85f, 1, 1);

  Matrix toShader_;
};

}  // namespace

PATINA_SHADERS(Wood)
