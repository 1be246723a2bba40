// SPDX-License-Identifier: Apache-2.0
// ieslight: a point light that shines as a luminaire was measured to, by a file of IES LM-63.
#include <patina/sdk.h>
#include <patina/sdk/light_filters.h>

#include <optional>

#include "ies_profile.h"

using namespace patina::sdk;

namespace {

struct IesLight {
  struct Parameters : FilterParameters {
    float intensity = 1;
    Color lightcolor = 1;
    Point from{0, 0, 0}, to{0, 0, 1};
    const char* profile = "";
    int32_t normalize = 1;
  };
  static constexpr auto kInfo = describe(
      "ieslight",
      "Luminaire by its IES profile: Cl = intensity * lightcolor / (L.L) * profile(direction) (* ramp)",
      uniform("intensity", &Parameters::intensity, "scale of lightcolor", kPositive),
      uniform("lightcolor", &Parameters::lightcolor, "colour of the light", kPositive),
      uniform("from", &Parameters::from, "position of the light"),
      uniform(
          "to", &Parameters::to,
          "a point below it: on the axis that vertical angles are counted from; horizontal ones are counted "
          "from the x of shader space to its y"),
      uniform("profile", &Parameters::profile,
              "file of IES LM-63, type C, beside the RIB or in the working folder; \"\", or one that cannot "
              "be read: the same in all "
              "directions"),
      uniform(
          "normalize", &Parameters::normalize,
          "1 = the profile is 1 where it is brightest; 0 = it is candela, and the light's irradiance at a "
          "distance of 1 so many, if intensity is 1",
          {0, 1}),
      filterParameters<Parameters>());
  static constexpr uint64_t kTraits = 0;

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    const Vector axis = p.to - p.from;
    const bool aimed = dot(axis, axis) > 0;
    if (!aimed) context.report(PATINA_REPORT_WARNING, 1, "from and to are the same point: no light");
    axis_ = normalize(axis);
    setFrame(context.shaderToWorld());
    ramp_ = DistanceRamp(p);
    float flux = 4 * kPi;
    if (*p.profile) {
      try {
        profile_ = patina::shaders::IesProfile::read(found(p.profile, context.host));
      } catch (const std::runtime_error& error) {
        context.report(PATINA_REPORT_ERROR, 2, error.what());
      }
    }
    if (profile_) {
      // Of a point light Cl is a pi-th of the irradiance that faces it.
      scale_ = !p.normalize ? 1 / kPi : profile_->most() > 0 ? 1 / profile_->most() : 0;
      flux = profile_->flux() * scale_;
    }
    if (!aimed) scale_ = 0;
    context.lightPower(p.intensity * p.lightcolor * ramp_.most() * (aimed ? flux : 0));
    if (!ramp_.filters()) context.lightFrom(p.from);
    return PATINA_OK;
  }

  LightSample sample(const Parameters& p, const LightQuery& at) const {
    const Vector L = p.from - at.P;
    const float square = dot(L, L);
    const bool lit = square > 1e-30f;
    LightSample out;
    out.distance = sqrt(square);
    out.direction = lit ? L / out.distance : Vector(0, 0, 1);
    const float shape = (profile_ ? inDirection(out.direction * -1) : 1.0f) * scale_;
    out.radiance = p.lightcolor * ramp_(out.distance) * (lit ? p.intensity * shape / square : 0.0f);
    return out;
  }

 private:
  /// Beside the scene's file, where the host knows of files; else the name as it is.
  static std::string found(const char* name, const PatinaHost& host) {
    const auto* files = static_cast<const PatinaFiles*>(host.extension(host.host, PATINA_EXTENSION_FILES));
    if (!files) return name;
    const char* const path = files->find(host.host, name);
    if (!path) throw std::runtime_error(std::string(name) + ": there is no such file that may be read");
    return path;
  }
  // x and y of shader space, as far as they stand across the axis.
  void setFrame(const float* m) {
    const Vector axes[] = {{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}};
    const float handedness = dot(cross(axes[0], axes[1]), axes[2]) < 0 ? -1.0f : 1.0f;
    // Where it shines along x, from z.
    Vector x = normalize(axes[0]);
    if (std::abs(dot(x, axis_)) > 0.999f) x = normalize(axes[2]);
    x_ = normalize(x - axis_ * dot(x, axis_));
    y_ = cross(axis_, x_) * handedness;
  }
  float inDirection(const Vector& d) const {
    constexpr float kDegrees = 180 / kPi;
    const float vertical = std::acos(clamp(dot(d, axis_), -1, 1)) * kDegrees;
    const float horizontal = std::atan2(dot(d, y_), dot(d, x_)) * kDegrees;
    return profile_->at(vertical, horizontal);
  }

  std::optional<patina::shaders::IesProfile> profile_;
  DistanceRamp ramp_;
  Vector axis_, x_, y_;
  float scale_ = 1;
};

}  // namespace

PATINA_SHADERS(IesLight)
