// SPDX-License-Identifier: Apache-2.0
// pointlight: the light of RI 3.2 that shines from a point, the same in every direction.
#include <patina/sdk.h>
#include <patina/sdk/light_filters.h>

using namespace patina::sdk;

namespace {

struct PointLight {
  struct Parameters : FilterParameters {
    float intensity = 1;
    Color lightcolor = 1;
    Point from{0, 0, 0};
  };
  static constexpr auto kInfo = describe(
      "pointlight", "Point light: Cl = intensity * lightcolor / (L.L) (* ramp)",
      uniform("intensity", &Parameters::intensity, "scale of lightcolor; Cl at a distance of 1", kPositive),
      uniform("lightcolor", &Parameters::lightcolor, "colour of the light", kPositive),
      uniform("from", &Parameters::from, "position of the light"), filterParameters<Parameters>());
  static constexpr uint64_t kTraits = 0;

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    const DistanceRamp ramp(p);
    context.lightPower(p.intensity * p.lightcolor * ramp.most() * (4 * kPi));
    if (!ramp.filters()) context.lightFrom(p.from);
    return PATINA_OK;
  }

  LightSample sample(const Parameters& p, const LightQuery& at) const {
    const Vector L = p.from - at.P;
    const float square = dot(L, L);
    const bool lit = square > 1e-30f;  // at the light itself there is no direction
    LightSample out;
    out.distance = sqrt(square);
    out.direction = lit ? L / out.distance : Vector(0, 0, 1);
    out.radiance = p.lightcolor * DistanceRamp(p)(out.distance) * (lit ? p.intensity / square : 0.0f);
    return out;
  }
};

}  // namespace

PATINA_SHADERS(PointLight)
