// SPDX-License-Identifier: Apache-2.0
// pointlight: the light of RI 3.2 that shines from a point, the same in every direction.
#include <patina/sdk.h>
#include <patina/sdk/light_filters.h>

using namespace patina::sdk;

namespace {

struct PointLight {
  struct Parameters {
    float intensity = 1;
    Color lightcolor = 1, shadowcolor = 0;
    Point from{0, 0, 0};
    float rampbegin = 0, rampend = 0;
    Color rampbegincolor = 1, rampendcolor = 0;
  };
  static constexpr auto kInfo = describe(
      "pointlight", "Point light: Cl = intensity * lightcolor / (L.L) (* ramp)",
      uniform("intensity", &Parameters::intensity, "scale of lightcolor; Cl at a distance of 1", kPositive),
      uniform("lightcolor", &Parameters::lightcolor, "colour of the light", kPositive),
      uniform("from", &Parameters::from, "position of the light"),
      uniform("shadowcolor", &Parameters::shadowcolor,
              "share of the light that gets into its shadows; the renderer sees to it", kUnitRange),
      uniform("rampbegin", &Parameters::rampbegin,
              "where a ramp over the distance begins, which the light is multiplied by", kPositive),
      uniform("rampend", &Parameters::rampend, "where it ends, world units; 0 = no ramp", kPositive),
      uniform("rampbegincolor", &Parameters::rampbegincolor, "the factor up to rampbegin", kPositive),
      uniform("rampendcolor", &Parameters::rampendcolor, "the factor from rampend on", kPositive));
  static constexpr uint64_t kTraits = 0;

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    const DistanceRamp ramp = rampOf(p);
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
    out.radiance = p.lightcolor * rampOf(p)(out.distance) * (lit ? p.intensity / square : 0.0f);
    return out;
  }

 private:
  PATINA_INLINE static DistanceRamp rampOf(const Parameters& p) {
    return {p.rampbegin, p.rampend, p.rampbegincolor, p.rampendcolor};
  }
};

}  // namespace

PATINA_SHADERS(PointLight)
