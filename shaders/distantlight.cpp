// SPDX-License-Identifier: Apache-2.0
// distantlight: the light of RI 3.2 whose rays are parallel; with an angle, a sun.
#include <patina/sdk.h>

using namespace patina::sdk;

namespace {

struct DistantLight {
  struct Parameters {
    float intensity = 1;
    Color lightcolor = 1;
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
              {0, 180}, "degree"));
  static constexpr uint64_t kTraits = 0;

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    const Vector travel = p.to - p.from;
    const bool aimed = dot(travel, travel) > 0;
    if (!aimed) context.report(PATINA_REPORT_WARNING, 1, "from and to are the same point: no light");
    const float half = radians(clamp(p.angle, 0, 180)) / 2;
    const float sine = std::sin(half), halfSine = std::sin(half / 2);
    axis_ = normalize(p.from - p.to);
    frame_ = frameAround(axis_);
    height_ = 2 * halfSine * halfSine;
    chord_ = 2 * height_;
    // Irradiance on a facing surface is pi Cl: the disc has the projected solid angle pi sin^2.
    scale_ = !aimed ? 0 : half > 0 ? 1 / (sine * sine) : 1;
    density_ = half > 0 ? 1 / (2 * kPi * height_) : 0;
    context.traits.light_kind = half > 0 ? PATINA_LIGHT_INFINITE : PATINA_LIGHT_DELTA;
    context.lightPower(p.intensity * p.lightcolor * (aimed ? kPi : 0));
    return PATINA_OK;
  }

  // Uniform over the cone; height_ = 1 - cos(angle / 2) keeps its digits where the cosine would lose them.
  LightSample sample(const Parameters& p, const LightQuery& at) const {
    const float below = at.random_x * height_;  // 1 - cos
    const float radius = sqrt(below * (2 - below));
    const float phi = 2 * kPi * at.random_y;
    LightSample out;
    out.direction =
        normalize(axis_ * (1 - below) + frame_.x * (radius * cos(phi)) + frame_.y * (radius * sin(phi)));
    out.radiance = p.intensity * p.lightcolor * scale_;
    out.pdf = density_;
    return out;
  }

  LightSample evaluate(const Parameters& p, const LightQuery& at) const {
    const Vector off = at.direction - axis_;  // its square is 2 (1 - cos)
    const bool inside = dot(off, off) <= chord_;
    LightSample out;
    out.radiance = p.lightcolor * (inside ? p.intensity * scale_ : 0.0f);
    out.pdf = inside ? density_ : 0.0f;
    return out;
  }

 private:
  Vector axis_;  // towards the light
  Frame frame_;
  float height_ = 0, chord_ = 0, scale_ = 1, density_ = 0;
};

}  // namespace

PATINA_SHADERS(DistantLight)
