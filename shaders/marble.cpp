// SPDX-License-Identifier: Apache-2.0
// marble: clouded stone with veins, through and through.
#include <patina/sdk.h>
#include <patina/sdk/filter.h>
#include <patina/sdk/fractals.h>

#include "polished.h"

using namespace patina::sdk;

namespace {

struct Marble {
  struct Parameters : patina::shaders::PolishParameters {
    constexpr Parameters() : PolishParameters(0.3f, 0.08f) {}
    float frequency = 1, distortion = 0.6f, veining = 0.14f;
    Color basecolor{0.86f, 0.84f, 0.8f}, cloudcolor{0.62f, 0.63f, 0.66f}, veincolor{0.16f, 0.17f, 0.2f};
  };
  static constexpr auto kInfo = describe(
      "marble",
      "Polished marble, in shader space: Ci = Os * (Cs * C * (Ka * ambient() + Kd * diffuse(N)) + "
      "specularcolor * "
      "Ks * specular(N, V, roughness)), where C is basecolor with clouds and veins",
      patina::shaders::polishParameters<Parameters>(),
      uniform("frequency", &Parameters::frequency, "of the largest clouds, in one unit of shader space",
              {0, 1e6}),
      uniform("distortion", &Parameters::distortion, "how far veins are bent, in clouds", {0, 10}),
      uniform("veining", &Parameters::veining, "how broad veins are; 0 = there are none", kUnitRange),
      uniform("basecolor", &Parameters::basecolor, "colour of the stone", kUnitRange),
      uniform("cloudcolor", &Parameters::cloudcolor, "colour of its clouds", kUnitRange),
      uniform("veincolor", &Parameters::veincolor, "colour of its veins", kUnitRange));
  static constexpr uint64_t kTraits = PATINA_TRAIT_OPACITY_IS_OS;

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    toShader_ = Matrix(context.worldToShader());
    context.weights(p.Ka, p.Kd, p.specularcolor * p.Ks);
    return PATINA_OK;
  }

  Radiosity radiosity(const Parameters& p, const Surface<kP | kFootprint | kCs | kOs>& at) const {
    const Vector q = toShader_.point(at.P) * p.frequency;
    const float width = at.footprint * toShader_.scale() * p.frequency;

    // Pressed and folded: one fBm bends the coordinates of all that follows, and makes the clouds.
    const float fold = fbm<6>(q, width);
    const Vector bent = q + Vector(1, 0.7f, -0.6f) * (p.distortion * fold);
    const float cloud = smoothstep(-0.6f, 0.6f, fold);

    // Veins run where noise changes its sign: few and broad ones, and more that are thin and faint.
    const float vein = veinMean(bent * 0.8f, p.veining, 0.8f * width);
    const float thin = 0.5f * veinMean(bent * 1.9f + Vector(7, 3, 5), 0.5f * p.veining, 1.9f * width);
    const Color stone = mix(p.basecolor, p.cloudcolor, cloud);
    return diffuseSurface(at.Cs * mix(stone, p.veincolor, 1 - (1 - 0.9f * vein) * (1 - thin)), at.Os, p.Ka,
                          p.Kd);
  }

  View<PATINA_LOBE_RI_SPECULAR> view(const Parameters& p, const Surface<kOs>& at) const {
    return highlights(p.specularcolor * p.Ks, at.Os, p.roughness);
  }

 private:
  /// 1 where noise is 0, 0 where it is beyond `breadth`, fading to its mean over space: the density of noise
  /// at 0 times the area under the ramps.
  static float veinMean(const Vector& p, float breadth, float width) {
    constexpr float kDensityAtZero = 1.4f, kSlope = 1.2f;  // measured: of snoise, and of |its gradient|
    const float size = std::max(breadth, 1e-4f);
    const float vein = 1 - filteredSmoothstep(0, size, std::abs(snoise(p)), kSlope * width);
    return mix(std::min(kDensityAtZero * size, 1.0f), vein, noiseLeft(width)) *
           std::min(breadth * 1e4f, 1.0f);
  }

  Matrix toShader_;
};

}  // namespace

PATINA_SHADERS(Marble)
