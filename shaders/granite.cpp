// SPDX-License-Identifier: Apache-2.0
// granite: crystals of three minerals, grown into each other.
#include <patina/sdk.h>
#include <patina/sdk/cells.h>
#include <patina/sdk/fractals.h>

#include "polished.h"

using namespace patina::sdk;

namespace {

struct Granite {
  struct Parameters : patina::shaders::PolishParameters {
    constexpr Parameters() : PolishParameters(0.2f, 0.1f) {}
    float frequency = 12, quartz = 0.3f, mica = 0.2f, variation = 0.35f;
    Color feldsparcolor{0.72f, 0.5f, 0.42f}, quartzcolor{0.6f, 0.58f, 0.55f}, micacolor{0.06f, 0.06f, 0.07f};
  };
  static constexpr auto kInfo = describe(
      "granite",
      "Polished granite, in shader space: Ci = Os * (Cs * C * (Ka * ambient() + Kd * diffuse(N)) + "
      "specularcolor "
      "* Ks * specular(N, V, roughness)), where C is constant in each crystal",
      patina::shaders::polishParameters<Parameters>(),
      uniform("frequency", &Parameters::frequency, "crystals in one unit of shader space", {0, 1e6}),
      uniform("quartz", &Parameters::quartz, "share of crystals of quartz", kUnitRange),
      uniform("mica", &Parameters::mica, "share of crystals of mica; the rest is feldspar", kUnitRange),
      uniform("variation", &Parameters::variation,
              "how much darker than their mineral the darkest crystals are", kUnitRange),
      uniform("feldsparcolor", &Parameters::feldsparcolor, "colour of feldspar", kUnitRange),
      uniform("quartzcolor", &Parameters::quartzcolor, "colour of quartz", kUnitRange),
      uniform("micacolor", &Parameters::micacolor, "colour of mica", kUnitRange));
  static constexpr uint64_t kTraits = PATINA_TRAIT_OPACITY_IS_OS;

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    toShader_ = Matrix(context.worldToShader());
    const float mica = clamp(p.mica, 0, 1), quartz = clamp(p.quartz, 0, 1 - mica);
    mean_ = (p.micacolor * mica + p.quartzcolor * quartz + p.feldsparcolor * (1 - mica - quartz)) *
            (1 - 0.5f * p.variation);
    context.weights(p.Ka, p.Kd, p.specularcolor * p.Ks);
    return PATINA_OK;
  }

  Radiosity radiosity(const Parameters& p, const Surface<kP | kFootprint | kCs | kOs>& at) const {
    const Vector q = toShader_.point(at.P) * p.frequency;
    const float width = at.footprint * toShader_.scale() * p.frequency;
    // Straight faces would look like broken glass, and flat colours like paper.
    const Worley crystal = worley(q + vsnoise(q * 1.7f) * 0.25f);
    const float clouding = 0.5f + 0.5f * filteredSnoise(q * 5, 5 * width);
    const float mineral = cellRandom(crystal.cell, 0);
    const float isMica = mineral < p.mica ? 1.0f : 0.0f, isQuartz = mineral < p.mica + p.quartz ? 1.0f : 0.0f;
    const Color pure = mix(mix(p.feldsparcolor, p.quartzcolor, isQuartz), p.micacolor, isMica);
    const Color seen = pure * (1 - p.variation * mix(cellRandom(crystal.cell, 1), clouding, 0.4f));
    return diffuseSurface(at.Cs * mix(mean_, seen, cellLeft(width)), at.Os, p.Ka, p.Kd);
  }

  View<PATINA_LOBE_RI_SPECULAR> view(const Parameters& p, const Surface<kOs>& at) const {
    return highlights(p.specularcolor * p.Ks, at.Os, p.roughness);
  }

 private:
  Matrix toShader_;
  Color mean_;
};

}  // namespace

PATINA_SHADERS(Granite)
