// SPDX-License-Identifier: Apache-2.0
// defaultsurface: what a scene shows that names no surface, or no light: lit by a lamp on the viewer's head.
#include <patina/sdk.h>

using namespace patina::sdk;

namespace {

struct DefaultSurface {
  struct Parameters {
    float Ka = 0.2f, Kd = 0.8f;
  };
  static constexpr auto kInfo = describe(
      "defaultsurface", "Needs no light: Ci = Os * Cs * (Ka + Kd * (I.N)^2)",
      uniform("Ka", &Parameters::Ka, "radiance of a face that is seen edge-on", kUnitRange),
      uniform("Kd", &Parameters::Kd, "radiance that a face has more when it is seen head-on", kUnitRange));
  static constexpr uint64_t kTraits = PATINA_TRAIT_OPACITY_IS_OS | PATINA_TRAIT_BLACK;

  View<> view(const Parameters& p, const Surface<kN | kI | kCs | kOs>& at) const {
    const float cosine = dot(at.I, at.N);
    View<> out;
    out.emission = at.Os * at.Cs * (p.Ka + p.Kd * (cosine * cosine));
    return out;
  }
};

}  // namespace

PATINA_SHADERS(DefaultSurface)
