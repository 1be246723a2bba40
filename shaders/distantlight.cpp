// SPDX-License-Identifier: Apache-2.0
// distantlight: the light of RI 3.2 whose rays are parallel; with an angle, a sun.
#include <patina/sdk.h>
#include <patina/sdk/distribution.h>

using namespace patina::sdk;

namespace {

struct DistantLight {
  struct Parameters {
    float intensity = 1;
    Color lightcolor = 1, shadowcolor = 0;
    Point from{0, 0, 0}, to{0, 0, 1};
    float angle = 0;
  };
  static constexpr auto kInfo = describe(
      "distantlight", "Parallel light: Cl = intensity * lightcolor, from a disc in the sky if angle > 0",
      uniform("intensity", &Parameters::intensity, "scale of lightcolor", kPositive),
      uniform("lightcolor", &Parameters::lightcolor, "radiance of a white matte surface that faces the light",
              kPositive),
      uniform("from", &Parameters::from, "the light shines from here ..."),
      uniform("to", &Parameters::to, "... to here"),
      uniform("angle", &Parameters::angle, "full angle of the disc as seen from the scene; the sun: 0.53",
              {0, 180}, "degree"),
      uniform("shadowcolor", &Parameters::shadowcolor,
              "share of the light that gets into its shadows, where angle is 0; the renderer sees to it",
              kUnitRange));
  static constexpr uint64_t kTraits = 0;

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    const Vector travel = p.to - p.from;
    const bool aimed = dot(travel, travel) > 0;
    if (!aimed) context.report(PATINA_REPORT_WARNING, 1, "from and to are the same point: no light");
    const float half = radians(clamp(p.angle, 0, 180)) / 2;
    const float sine = std::sin(half);
    disc_ = Cone(normalize(p.from - p.to), half);
    // Irradiance on a facing surface is pi Cl: the disc has the projected solid angle pi sin^2.
    scale_ = !aimed ? 0 : half > 0 ? 1 / (sine * sine) : 1;
    context.traits.light_kind = half > 0 ? PATINA_LIGHT_INFINITE : PATINA_LIGHT_DELTA;
    context.lightPower(p.intensity * p.lightcolor * (aimed ? kPi : 0));
    return PATINA_OK;
  }

  LightSample sample(const Parameters& p, const LightQuery& at) const {
    LightSample out;
    out.direction = disc_.draw(at.random_x, at.random_y);
    out.radiance = p.intensity * p.lightcolor * scale_;
    out.pdf = disc_.density();
    return out;
  }

  LightSample evaluate(const Parameters& p, const LightQuery& at) const {
    const bool inside = disc_.holds(at.direction);
    LightSample out;
    out.radiance = p.lightcolor * (inside ? p.intensity * scale_ : 0.0f);
    out.pdf = inside ? disc_.density() : 0.0f;
    return out;
  }

 private:
  Cone disc_;
  float scale_ = 1;
};

}  // namespace

PATINA_SHADERS(DistantLight)
