// SPDX-License-Identifier: Apache-2.0
// spotlight: the light of RI 3.2 that shines from a point into a cone.
#include <patina/sdk.h>

using namespace patina::sdk;

namespace {

struct SpotLight {
  struct Parameters {
    float intensity = 1;
    Color lightcolor = 1;
    Point from{0, 0, 0}, to{0, 0, 1};
    float coneangle = radians(30), conedeltaangle = radians(5), beamdistribution = 2;
  };
  static constexpr auto kInfo =
      describe("spotlight",
               "Spotlight: Cl = intensity * lightcolor / (L.L) * cosangle^beamdistribution * smoothstep("
               "cos(coneangle), cos(coneangle - conedeltaangle), cosangle)",
               uniform("intensity", &Parameters::intensity,
                       "scale of lightcolor; Cl on the axis at a distance of 1", kPositive),
               uniform("lightcolor", &Parameters::lightcolor, "colour of the light", kPositive),
               uniform("from", &Parameters::from, "position of the light"),
               uniform("to", &Parameters::to, "a point on the axis of the cone"),
               uniform("coneangle", &Parameters::coneangle, "from the axis to the edge of the cone", {0, 3.2},
                       "radian"),
               uniform("conedeltaangle", &Parameters::conedeltaangle,
                       "width of the soft edge, inside the cone", {0, 3.2}, "radian"),
               uniform("beamdistribution", &Parameters::beamdistribution,
                       "exponent of the fall-off from the axis", {0, 1e4}));
  static constexpr uint64_t kTraits = 0;

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    const Vector axis = p.to - p.from;
    if (dot(axis, axis) == 0)
      context.report(PATINA_REPORT_WARNING, 1, "from and to are the same point: no light");
    axis_ = normalize(axis);
    edge_ = std::cos(p.coneangle);
    full_ = std::cos(p.coneangle - p.conedeltaangle);
    const bool aimed = dot(axis, axis) > 0;
    context.lightPower(p.intensity * p.lightcolor * (aimed ? 2 * kPi * (1 - edge_) : 0));
    context.lightFrom(p.from, axis_, p.coneangle);
    return PATINA_OK;
  }

  LightSample sample(const Parameters& p, const LightQuery& at) const {
    const Vector L = p.from - at.P;
    const float square = dot(L, L);
    const bool lit = square > 1e-30f;
    LightSample out;
    out.distance = sqrt(square);
    out.direction = lit ? L / out.distance : Vector(0, 0, 1);
    const float cosangle = -dot(out.direction, axis_);
    const float beam = pow(std::max(cosangle, 0.0f), p.beamdistribution) * smoothstep(edge_, full_, cosangle);
    out.radiance = p.lightcolor * (lit ? p.intensity * beam / square : 0.0f);
    return out;
  }

 private:
  Vector axis_;
  float edge_ = 0, full_ = 0;  // cosines
};

}  // namespace

PATINA_SHADERS(SpotLight)
