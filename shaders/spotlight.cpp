// SPDX-License-Identifier: Apache-2.0
// spotlight: the light of RI 3.2 that shines from a point into a cone.
#include <patina/sdk.h>
#include <patina/sdk/light_filters.h>

using namespace patina::sdk;

namespace {

struct SpotLight {
  static constexpr Range kDoor{-1.6, 1.6};
  struct Parameters : FilterParameters {
    float intensity = 1;
    Color lightcolor = 1;
    Point from{0, 0, 0}, to{0, 0, 1};
    float coneangle = radians(30), conedeltaangle = radians(5), beamdistribution = 2;
    const char* texturename = "";
    float doorleft = kPi / 2, doorright = kPi / 2, doortop = kPi / 2, doorbottom = kPi / 2, doorsoftness = 0;
  };
  static constexpr auto kInfo = describe(
      "spotlight",
      "Spotlight: Cl = intensity * lightcolor / (L.L) * cosangle^beamdistribution * smoothstep("
      "cos(coneangle), cos(coneangle - conedeltaangle), cosangle) (* texture * barn doors * ramp)",
      uniform("intensity", &Parameters::intensity, "scale of lightcolor; Cl on the axis at a distance of 1",
              kPositive),
      uniform("lightcolor", &Parameters::lightcolor, "colour of the light", kPositive),
      uniform("from", &Parameters::from, "position of the light"),
      uniform("to", &Parameters::to, "a point on the axis of the cone"),
      uniform("coneangle", &Parameters::coneangle, "from the axis to the edge of the cone", {0, 3.2},
              "radian"),
      uniform("conedeltaangle", &Parameters::conedeltaangle, "width of the soft edge, inside the cone",
              {0, 3.2}, "radian"),
      uniform("beamdistribution", &Parameters::beamdistribution, "exponent of the fall-off from the axis",
              {0, 1e4}),
      uniform("texturename", &Parameters::texturename,
              "slide that the light shines through, as wide as the cone, y of shader space up; \"\" = none"),
      uniform("doorleft", &Parameters::doorleft,
              "barn door on the side of -x: where it cuts the light off, from the axis; pi/2 = open", kDoor,
              "radian"),
      uniform("doorright", &Parameters::doorright, "the same on the side of x", kDoor, "radian"),
      uniform("doortop", &Parameters::doortop, "the same on the side of y", kDoor, "radian"),
      uniform("doorbottom", &Parameters::doorbottom, "the same on the side of -y", kDoor, "radian"),
      uniform("doorsoftness", &Parameters::doorsoftness, "width of the doors' soft edges, inside of them",
              {0, 1.6}, "radian"),
      filterParameters<Parameters>());
  static constexpr uint64_t kTraits = 0;

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    const Vector axis = p.to - p.from;
    if (dot(axis, axis) == 0)
      context.report(PATINA_REPORT_WARNING, 1, "from and to are the same point: no light");
    axis_ = normalize(axis);
    edge_ = std::cos(p.coneangle);
    full_ = std::cos(p.coneangle - p.conedeltaangle);
    const bool aimed = dot(axis, axis) > 0;
    setFrame(context.shaderToWorld());
    slide_ = context.openTexture(p.texturename);
    halfWidth_ = std::tan(clamp(p.coneangle, 1e-3f, 1.5f));
    const float doors[] = {p.doorleft, p.doorright, p.doortop, p.doorbottom};
    for (int k = 0; k < 4; ++k) {
      doors_ |= doors[k] < 1.5707f;
      outer_[k] = tangent(doors[k]), inner_[k] = tangent(doors[k] - p.doorsoftness);
    }
    ramp_ = DistanceRamp(p);
    context.lightPower(p.intensity * p.lightcolor * ramp_.most() * (aimed ? 2 * kPi * (1 - edge_) : 0));
    if (!ramp_.filters()) context.lightFrom(p.from, axis_, p.coneangle);
    return PATINA_OK;
  }

  PatinaTexture* texture(uint32_t) const { return slide_; }
  std::array<TextureLookup, 1> lookups(const Parameters& p, const LightQuery& at) const {
    const Vector d = inFrame(at.P - p.from);
    const float scale = 0.5f / (std::max(d.z, 1e-20f) * halfWidth_);
    return {{{clamp(0.5f + d.x * scale, 0, 1), clamp(0.5f - d.y * scale, 0, 1), 0}}};
  }

  LightSample sample(const Parameters& p, const LightQuery& at, const Texels<1>& texels) const {
    const Vector L = p.from - at.P;
    const float square = dot(L, L);
    const bool lit = square > 1e-30f;
    LightSample out;
    out.distance = sqrt(square);
    out.direction = lit ? L / out.distance : Vector(0, 0, 1);
    const float cosangle = -dot(out.direction, axis_);
    const float beam = pow(std::max(cosangle, 0.0f), p.beamdistribution) * smoothstep(edge_, full_, cosangle);
    const float through = doors_ ? pastDoors(inFrame(out.direction * -1)) : 1.0f;
    out.radiance = p.lightcolor * ramp_(out.distance) * texels[0].color *
                   (lit ? p.intensity * beam * through / square : 0.0f);
    return out;
  }

 private:
  // x to the right of the axis and y up, as shader space has them, mirrored where it is.
  void setFrame(const float* m) {
    const Vector x(m[0], m[1], m[2]), y(m[4], m[5], m[6]), z(m[8], m[9], m[10]);
    const float handedness = dot(cross(x, y), z) < 0 ? -1.0f : 1.0f;
    right_ = normalize(cross(y, axis_));
    if (dot(right_, right_) < 0.5f) right_ = normalize(cross(z, axis_));  // it shines straight up or down
    right_ = right_ * handedness;
    up_ = cross(axis_, right_) * handedness;
  }
  PATINA_INLINE Vector inFrame(const Vector& d) const { return {dot(d, right_), dot(d, up_), dot(d, axis_)}; }
  static float tangent(float angle) { return std::tan(clamp(angle, -1.5707f, 1.5707f)); }
  PATINA_INLINE float pastDoors(const Vector& d) const {
    const float scale = 1 / std::max(d.z, 1e-6f), x = d.x * scale, y = d.y * scale;
    const float side = (1 - smoothstep(inner_[0], outer_[0], -x)) * (1 - smoothstep(inner_[1], outer_[1], x));
    return side * (1 - smoothstep(inner_[2], outer_[2], y)) * (1 - smoothstep(inner_[3], outer_[3], -y));
  }

  Vector axis_, right_, up_;
  PatinaTexture* slide_ = nullptr;
  DistanceRamp ramp_;
  float halfWidth_ = 1;  // tangent of half the slide's angle
  bool doors_ = false;
  float outer_[4]{}, inner_[4]{};  // tangents where light ends, and begins to
  float edge_ = 0, full_ = 0;      // cosines
};

}  // namespace

PATINA_SHADERS(SpotLight)
