// SPDX-License-Identifier: Apache-2.0
// sunsky: daylight, by the model of Preetham, Shirley and Smits, "A Practical Analytic Model for Daylight",
// SIGGRAPH 1999: the sky of their appendix A.2, and a sun dimmed by the air as in their appendix A.1.
#include <patina/sdk.h>
#include <patina/sdk/color.h>
#include <patina/sdk/distribution.h>

#include <vector>

using namespace patina::sdk;

namespace {

// ---- Where the sun is ------------------------------------------------------------------------------------

// Towards the sun, with x to the east, y to the north and z up. Angles in radians, east is positive; `day`
// counts from 1, `time` is standard time in hours, `zone` its hours ahead of UTC. Solar time and declination
// are the paper's (A.6), good to about a quarter of a degree; the direction is spherical astronomy's.
Vector sunAt(float latitude, float longitude, float zone, float day, float time) {
  const float solar = time + 0.170f * std::sin(4 * kPi * (day - 80) / 373) -
                      0.129f * std::sin(2 * kPi * (day - 8) / 355) + longitude * 12 / kPi - zone;
  const float declination = 0.4093f * std::sin(2 * kPi * (day - 81) / 368);
  const float hour = kPi * (solar - 12) / 12;
  const float cl = std::cos(latitude), sl = std::sin(latitude);
  const float cd = std::cos(declination), sd = std::sin(declination);
  return {-cd * std::sin(hour), sd * cl - cd * std::cos(hour) * sl, sd * sl + cd * std::cos(hour) * cl};
}

// ---- The sun's light -------------------------------------------------------------------------------------

constexpr float kDegree = kPi / 180;
constexpr float kSunAngle = 0.533f;  // degrees across, seen from the earth

// From 380 nm in steps of 10 nm. Radiance of the sun outside of the atmosphere in 100 W/(m^2 sr nm), and
// absorption of ozone per cm (table 2 of the paper).
constexpr float kSunRadiance[] = {
    165.5f, 162.3f, 211.2f, 258.8f, 258.2f, 242.3f, 267.6f, 296.6f, 305.4f, 300.6f, 306.6f, 288.3f, 287.1f,
    278.2f, 271.0f, 272.3f, 263.6f, 255.0f, 250.6f, 253.1f, 253.5f, 251.3f, 246.3f, 241.7f, 236.8f, 232.1f,
    228.2f, 223.4f, 219.7f, 215.3f, 211.0f, 207.3f, 202.4f, 198.7f, 194.3f, 190.7f, 186.3f, 182.6f};
constexpr float kOzone[] = {0,     0,     0,     0,     0,     0,     0,     .003f, .006f, .009f,
                            .014f, .021f, .030f, .040f, .048f, .063f, .075f, .085f, .103f, .120f,
                            .120f, .115f, .125f, .120f, .105f, .090f, .079f, .067f, .057f, .048f,
                            .036f, .028f, .023f, .018f, .014f, .011f, .010f, .009f};

// CIE 1931 matching functions at a wavelength in nm: Wyman, Sloan and Shirley, "Simple Analytic
// Approximations to the CIE XYZ Color Matching Functions", JCGT 2(2), 2013, listing 1.
Color matching(float wavelength) {
  const auto lobe = [&](float middle, float below, float above) {
    const float t = (wavelength - middle) * (wavelength < middle ? below : above);
    return std::exp(-0.5f * t * t);
  };
  return {0.362f * lobe(442.0f, 0.0624f, 0.0374f) + 1.056f * lobe(599.8f, 0.0264f, 0.0323f) -
              0.065f * lobe(501.1f, 0.0490f, 0.0382f),
          0.821f * lobe(568.8f, 0.0213f, 0.0247f) + 0.286f * lobe(530.9f, 0.0613f, 0.0322f),
          1.217f * lobe(437.0f, 0.0845f, 0.0278f) + 0.681f * lobe(459.0f, 0.0385f, 0.0725f)};
}

// XYZ of the sun's disc through the atmosphere; Y in kcd/m^2. The absorption of oxygen and water vapour,
// beyond 690 nm where the eye sees next to nothing, is left out.
Color sunXyz(float turbidity, float zenithAngle) {
  const float degrees = std::min(zenithAngle / kDegree, 90.0f);
  const float mass = 1 / (std::cos(degrees * kDegree) + 0.15f * std::pow(93.885f - degrees, -1.253f));
  const float beta = 0.04608365822050f * turbidity - 0.04586025928522f;
  Color sum;
  for (size_t i = 0; i < std::size(kSunRadiance); ++i) {
    const float nanometres = 380 + 10 * float(i), micrometres = nanometres / 1000;
    const float rayleigh = 0.008735f * std::pow(micrometres, -4.08f);
    const float aerosols = beta * std::pow(micrometres, -1.3f);
    const float ozone = kOzone[i] * 0.35f;
    sum = sum + matching(nanometres) * (kSunRadiance[i] * std::exp(-mass * (rayleigh + aerosols + ozone)));
  }
  // 683 lm/W, steps of 10 nm, and kilo.
  return sum * (683 * 100 * 10 / 1000.0f);
}

// ---- The sky's light -------------------------------------------------------------------------------------

// Perez's five parameters for luminance and chromaticities Y, x, y, and their values at the zenith.
class Sky {
 public:
  Sky() = default;
  Sky(float turbidity, float sunAngle) {
    const float T = turbidity, a = sunAngle, a2 = a * a, a3 = a * a2;
    const float chi = (4 / 9.0f - T / 120) * (kPi - 2 * a);
    const auto zenith = [&](const float(&m)[12]) {
      const auto row = [&](int k) { return m[k] * a3 + m[k + 1] * a2 + m[k + 2] * a + m[k + 3]; };
      return T * T * row(0) + T * row(4) + row(8);
    };
    channels_[0] = {{0.1787f * T - 1.4630f, -0.3554f * T + 0.4275f, -0.0227f * T + 5.3251f,
                     0.1206f * T - 2.5771f, -0.0670f * T + 0.3703f},
                    (4.0453f * T - 4.9710f) * std::tan(chi) - 0.2155f * T + 2.4192f};
    channels_[1] = {{-0.0193f * T - 0.2592f, -0.0665f * T + 0.0008f, -0.0004f * T + 0.2125f,
                     -0.0641f * T - 0.8989f, -0.0033f * T + 0.0452f},
                    zenith({0.00166f, -0.00375f, 0.00209f, 0, -0.02903f, 0.06377f, -0.03202f, 0.00394f,
                            0.11693f, -0.21196f, 0.06052f, 0.25886f})};
    channels_[2] = {{-0.0167f * T - 0.2608f, -0.0950f * T + 0.0092f, -0.0079f * T + 0.2102f,
                     -0.0441f * T - 1.6537f, -0.0109f * T + 0.0529f},
                    zenith({0.00275f, -0.00610f, 0.00317f, 0, -0.04214f, 0.08970f, -0.04153f, 0.00516f,
                            0.15346f, -0.26756f, 0.06670f, 0.26688f})};
    for (Channel& c : channels_) c.zenith /= perez(c, 1, a);
  }

  // Radiance with its luminance in kcd/m^2, from a height (cosine to the zenith, above 0) and a cosine to
  // the sun. Blue that Rec.709 has no place for loses what lies below zero.
  PATINA_INLINE Color radiance(float height, float cosSun) const {
    const float angle = std::acos(clamp(cosSun, -1, 1));
    const float Y = channels_[0].zenith * perez(channels_[0], height, angle);
    const float x = channels_[1].zenith * perez(channels_[1], height, angle);
    const float y = std::max(channels_[2].zenith * perez(channels_[2], height, angle), 0.01f);
    const Color c = xyzToLinear({Y * x / y, Y, Y * (1 - x - y) / y});
    return {std::max(c.r, 0.0f), std::max(c.g, 0.0f), std::max(c.b, 0.0f)};
  }

 private:
  struct Channel {
    float p[5] = {0, 0, 0, 0, 0};
    float zenith = 0;  // divided by the formula's value there
  };
  PATINA_INLINE static float perez(const Channel& c, float height, float angle) {
    const float cosine = std::cos(angle);
    return (1 + c.p[0] * exp(c.p[1] / std::max(height, 1e-3f))) *
           (1 + c.p[2] * exp(c.p[3] * angle) + c.p[4] * cosine * cosine);
  }
  Channel channels_[3];
};

// ---- The light -------------------------------------------------------------------------------------------

struct SunSky {
  struct Parameters {
    float intensity = 0.03f;
    Color lightcolor = 1;
    float turbidity = 3;
    Vector sundirection{0, -1, 1};
    float latitude = 50, longitude = 0, zone = 0, day = 172, time = -1;
    float sun = 1, sky = 1, sunangle = kSunAngle;
    Color groundalbedo = 0.2f;
    int32_t camera = 1;
  };
  static constexpr auto kInfo = describe(
      "sunsky", "Daylight from sun, sky and the ground below the horizon; z of shader space is up",
      uniform("intensity", &Parameters::intensity,
              "scale: 1 gives radiance whose luminance is in kcd/m^2; white in full sun is then about 35",
              kPositive),
      uniform("lightcolor", &Parameters::lightcolor, "tint of all of it", kPositive),
      uniform("turbidity", &Parameters::turbidity,
              "haze: 2 = very clear, 3 = clear, 6 = light haze, 10 = haze", {2, 10}),
      uniform("sundirection", &Parameters::sundirection, "towards the sun, where time is not given"),
      uniform("latitude", &Parameters::latitude, "north of the equator", {-90, 90}, "degree"),
      uniform("longitude", &Parameters::longitude, "east of Greenwich", {-180, 180}, "degree"),
      uniform("zone", &Parameters::zone, "standard time ahead of UTC", {-14, 14}, "hour"),
      uniform("day", &Parameters::day, "day of the year, 1 = the first of January", {1, 366}),
      uniform(
          "time", &Parameters::time,
          "standard time; sets the sun by place and day, y of shader space is north. Below 0: sundirection",
          {-1, 24}, "hour"),
      uniform("sun", &Parameters::sun, "scale of the sun's disc; 0 = none", kPositive),
      uniform("sky", &Parameters::sky, "scale of the sky", kPositive),
      uniform("sunangle", &Parameters::sunangle, "full angle of the disc, whose light stays the same",
              {0.1, 90}, "degree"),
      uniform("groundalbedo", &Parameters::groundalbedo,
              "of the ground below the horizon, lit by sun and sky", kUnitRange),
      uniform("camera", &Parameters::camera, "1 = the camera sees the light as a background", {0, 1}));
  static constexpr uint64_t kTraits = 0;

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    if (p.camera) context.set(PATINA_TRAIT_CAMERA_VISIBLE);
    const float turbidity = clamp(p.turbidity, 2, 10);
    if (turbidity != p.turbidity)
      context.report(PATINA_REPORT_WARNING, 1, "turbidity is from 2 to 10: the nearest is taken");
    axes_ = Axes(context.shaderToWorld());
    const Vector sun = towardsSun(p, context);
    const float zenithAngle = std::acos(clamp(sun.z, -1, 1));
    const Color scale = p.intensity * p.lightcolor;

    // The model ends with a sun on the horizon. Below, its sky fades as illuminance does in twilight: from
    // 400 lx to 3.4 lx at 6 degrees, where civil twilight ends.
    const float below = std::max(zenithAngle - kPi / 2, 0.0f) / kDegree;
    sky_ = Sky(turbidity, std::min(zenithAngle, kPi / 2));
    skyScale_ = scale * (p.sky * std::pow(10.0f, -0.345f * below));

    const float half = clamp(p.sunangle, 0.1f, 90) / 2 * kDegree;
    disc_ = Cone(sun, half);
    const float trueSize = Cone(sun, kSunAngle / 2 * kDegree).solidAngle();
    const Color sunlight = xyzToLinear(sunXyz(turbidity, zenithAngle));
    const bool up = sun.z > -std::sin(half);
    sunRadiance_ = scale *
                   Color(std::max(sunlight.r, 0.0f), std::max(sunlight.g, 0.0f), std::max(sunlight.b, 0.0f)) *
                   (up ? p.sun * trueSize / disc_.solidAngle() : 0.0f);

    // The sky in cells, for its irradiance on the ground and to draw directions by.
    std::vector<float> brightness(kWidth * kHeight);
    Color irradiance = sunRadiance_ * (disc_.solidAngle() * std::max(sun.z, 0.0f));
    for (uint32_t row = 0; row < kHeight / 2; ++row) {
      const float theta = kPi * (float(row) + 0.5f) / kHeight, sine = std::sin(theta);
      for (uint32_t column = 0; column < kWidth; ++column) {
        const float phi = 2 * kPi * ((float(column) + 0.5f) / kWidth - 0.5f);
        const Color c = skyAt({sine * std::cos(phi), sine * std::sin(phi), std::cos(theta)});
        brightness[row * kWidth + column] = luminance(c);
        irradiance = irradiance + c * (std::cos(theta) * sine * (kPi / kHeight) * (2 * kPi / kWidth));
      }
    }
    ground_ = p.groundalbedo * irradiance * (1 / kPi);
    std::fill(brightness.begin() + kWidth * kHeight / 2, brightness.end(), luminance(ground_));
    directions_ = SphereDistribution(brightness, kWidth, kHeight);

    // The disc gets its share of the samples, and leaves some to the rest.
    const float sunFlux = luminance(sunRadiance_) * disc_.solidAngle();
    const float rest = 4 * kPi * directions_.mean();
    sunShare_ = sunFlux > 0 ? std::min(sunFlux / (sunFlux + rest), rest > 0 ? 0.8f : 1.0f) : 0;
    context.lightPower((sunFlux + rest) / 4);
    return PATINA_OK;
  }

  LightSample sample(const Parameters&, const LightQuery& at) const {
    const bool inDisc = at.random_x < sunShare_;
    const float x = inDisc ? at.random_x / sunShare_ : (at.random_x - sunShare_) / (1 - sunShare_);
    float density = 0;
    Vector local = directions_.draw(clamp(x, 0, 0.9999999f), at.random_y, density);
    if (inDisc) {
      local = disc_.draw(std::min(x, 0.9999999f), at.random_y);
      density = directions_.density(local);
    }
    LightSample out = light(local, density);
    out.direction = axes_.toWorld(local);
    return out;
  }

  LightSample evaluate(const Parameters&, const LightQuery& at) const {
    const Vector local = axes_.toLocal(at.direction);
    return light(local, directions_.density(local));
  }

 private:
  static constexpr uint32_t kHeight = 256, kWidth = 2 * kHeight;  // the horizon is between two rows

  // In the light's own space.
  Vector towardsSun(const Parameters& p, const Prepare& context) const {
    if (p.time < 0) {
      const Vector sun = axes_.toLocal(normalize(p.sundirection));
      if (dot(sun, sun) > 0.5f) return sun;
      context.report(PATINA_REPORT_WARNING, 2, "sundirection has no length: the sun is at the zenith");
      return {0, 0, 1};
    }
    Vector sun = sunAt(p.latitude * kDegree, p.longitude * kDegree, p.zone, p.day, p.time);
    // East is to the right of who looks north, as the picture shows it: where x of the light's space is to
    // the left, as in RI's left-handed spaces, it points west.
    const Matrix toCamera = context.transform("shader", "camera");
    const Vector x = toCamera.vector({1, 0, 0}), y = toCamera.vector({0, 1, 0}),
                 z = toCamera.vector({0, 0, 1});
    if (dot(cross(x, y), z) > 0) sun.x = -sun.x;
    return normalize(sun);
  }

  PATINA_INLINE Color skyAt(const Vector& local) const {
    return skyScale_ * sky_.radiance(local.z, dot(local, disc_.axis()));
  }

  PATINA_INLINE LightSample light(const Vector& local, float density) const {
    const bool inDisc = sunShare_ > 0 && disc_.holds(local);
    const Color sky = skyAt(local) + sunRadiance_ * (inDisc ? 1.0f : 0.0f);
    LightSample out;
    out.radiance = local.z > 0 ? sky : ground_;
    out.pdf = density * (1 - sunShare_) + (inDisc ? disc_.density() * sunShare_ : 0.0f);
    return out;
  }

  Axes axes_;
  Cone disc_;
  Sky sky_;
  SphereDistribution directions_;
  Color skyScale_, sunRadiance_, ground_;
  float sunShare_ = 0;  // of the samples
};

}  // namespace

PATINA_SHADERS(SunSky)
