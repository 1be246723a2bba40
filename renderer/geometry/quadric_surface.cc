// SPDX-License-Identifier: Apache-2.0
// The seven quadrics: closed forms of position, derivatives and normal.
#include "renderer/geometry/quadric_surface.h"

#include <fmt/format.h>

#include <array>

#include "renderer/geometry/primvar.h"

namespace patina {
namespace {

constexpr double kRadians = std::numbers::pi / 180;
constexpr double kNearTip = 1e-3;  // of a paraboloid: sqrt(z / zmax) below which dPdv is held

struct SinCos {
  double sin, cos;
};

/// Exact at multiples of 90 degrees and equal for angles that differ by 360.
SinCos sinCosDegrees(double degrees) {
  const double turned = std::fmod(degrees, 360.0);
  const double quarter = std::nearbyint(turned / 90);
  const double rest = (turned - quarter * 90) * kRadians;
  const double s = std::sin(rest), c = std::cos(rest);
  switch ((static_cast<int>(quarter) + 8) % 4) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

/// A sweep cut to one turn; what misses a turn by no more than float's rounding is meant as one.
constexpr double kTurnTolerance = 1e-4;
double wholeTurn(double degrees) {
  return std::abs(degrees) > 360 - kTurnTolerance ? std::copysign(360.0, degrees) : degrees;
}

double mix(double t, double a, double b) { return a * (1 - t) + b * t; }

/// Rotated about z; adding zero makes -0 into 0, so that equal points have equal bits.
V3d rotate(const V3d& p, const SinCos& theta) {
  return {p.x * theta.cos - p.y * theta.sin + 0.0, p.x * theta.sin + p.y * theta.cos + 0.0, p.z + 0.0};
}

double sign(double x) { return x < 0 ? -1 : 1; }

constexpr std::array<const char*, 7> kNames{"Sphere",     "Cone", "Cylinder", "Hyperboloid",
                                            "Paraboloid", "Disk", "Torus"};
constexpr std::array<size_t, 7> kValues{3, 2, 3, 6, 3, 2, 4};

}  // namespace

/// n is dPdu x dPdv divided by what vanishes at poles, for a sweep of positive theta.
QuadricSurface::Profile QuadricSurface::profile(double v) const {
  switch (kind_) {
    case Kind::Sphere: {  // radius, phimin, phimax
      const SinCos phi = sinCosDegrees(mix(v, a_[1], a_[2]));
      const double span = (a_[2] - a_[1]) * kRadians, turn = sign(span);
      return {V3d(phi.cos, 0, phi.sin) * a_[0], V3d(-phi.sin, 0, phi.cos) * (a_[0] * span),
              V3d(phi.cos, 0, phi.sin) * turn};
    }
    case Kind::Cone:  // height, radius
      return {{a_[1] * (1 - v), 0, a_[0] * v}, {-a_[1], 0, a_[0]}, V3d(a_[0], 0, a_[1]) * sign(a_[1])};
    case Kind::Cylinder:  // radius, zmin, zmax
      return {{a_[0], 0, mix(v, a_[1], a_[2])}, {0, 0, a_[2] - a_[1]}, {sign(a_[0]) * (a_[2] - a_[1]), 0, 0}};
    case Kind::Hyperboloid: {  // p1, p2
      const V3d p1(a_[0], a_[1], a_[2]), p2(a_[3], a_[4], a_[5]), d = p2 - p1;
      const V3d p(mix(v, p1.x, p2.x), mix(v, p1.y, p2.y), mix(v, p1.z, p2.z));
      V3d n(p.x * d.z, p.y * d.z, -(p.x * d.x + p.y * d.y));
      // On the axis, and where the segment touches its circle, the limit from the inside of the domain.
      const double scale = std::max(std::hypot(p1.x, p1.y), std::hypot(p2.x, p2.y)) * d.length();
      if (n.length() <= 1e-12 * scale)
        n = V3d(d.x * d.z, d.y * d.z, -(d.x * d.x + d.y * d.y)) * (v < 1 ? 1.0 : -1.0);
      return {p, d, n};
    }
    case Kind::Paraboloid: {  // rmax, zmin, zmax
      const double z = mix(v, a_[1], a_[2]), s = std::sqrt(std::max(z / a_[2], 0.0)), dz = a_[2] - a_[1];
      const double slope = a_[0] / (2 * a_[2] * std::max(s, kNearTip));
      return {{a_[0] * s, 0, z},
              {slope * dz, 0, dz},
              V3d(2 * a_[2] * s, 0, -a_[0]) * (sign(a_[0]) * sign(a_[2] * dz))};
    }
    case Kind::Disk:  // height, radius
      return {{a_[1] * (1 - v), 0, a_[0]}, {-a_[1], 0, 0}, {0, 0, 1}};
    case Kind::Torus: {  // major, minor, phimin, phimax
      const SinCos phi = sinCosDegrees(mix(v, a_[2], a_[3]));
      const double r = a_[0] + a_[1] * phi.cos, span = (a_[3] - a_[2]) * kRadians;
      return {{r, 0, a_[1] * phi.sin},
              V3d(-phi.sin, 0, phi.cos) * (a_[1] * span),
              V3d(phi.cos, 0, phi.sin) * (sign(r) * sign(a_[1] * span))};
    }
  }
  return {};
}

SurfacePoint QuadricSurface::evaluate(uint32_t, float u, float v) const {
  const SinCos theta = sinCosDegrees(static_cast<double>(u) * theta_);
  const Profile f = profile(static_cast<double>(v));
  const double turn = theta_ * kRadians;
  const V3d n = rotate(f.n, theta) * sign(turn);
  return {V3f(rotate(f.p, theta)), V3f(n / n.length()), V3f(rotate({-f.p.y, f.p.x, 0}, theta) * turn),
          V3f(rotate(f.dv, theta))};
}

void QuadricSurface::corners(uint32_t, V3f out[4]) const {
  for (int k = 0; k < 4; ++k) out[k] = evaluate(0, static_cast<float>(k % 2), static_cast<float>(k / 2)).P;
}

void QuadricSurface::evaluateGrid(uint32_t, std::span<const double> u, std::span<const double> v,
                                  std::span<V3f> out) const {
  thread_local std::vector<SinCos> theta;
  theta.clear();
  for (const double x : u) theta.push_back(sinCosDegrees(x * theta_));
  auto next = out.begin();
  for (const double y : v) {
    const V3d p = profile(y).p;
    for (const SinCos& t : theta) *next++ = V3f(rotate(p, t));
  }
}

void QuadricSurface::interpolate(const PrimVar& variable, uint32_t, float u, float v, float* out) const {
  if (variable.storage == StorageClass::Constant || variable.storage == StorageClass::Uniform)
    return copyValue(variable, 0, out);
  const auto x = static_cast<double>(u), y = static_cast<double>(v);
  blendValues(variable, std::array<uint32_t, 4>{0, 1, 2, 3},
              std::array<double, 4>{(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y}, out);
}

/// From the range of radii and heights of the profile and the quarters that the sweep passes.
Box3f QuadricSurface::computeBound() const {
  // Extremes of the profile: its ends and the places where radius or height turns.
  std::array<double, 14> at{0, 1};
  size_t count = 2;
  const auto add = [&](double v) {
    if (v > 0 && v < 1) at[count++] = v;
  };
  if (kind_ == Kind::Sphere) add(a_[1] / (a_[1] - a_[2]));
  if (kind_ == Kind::Hyperboloid) {
    const double dx = a_[3] - a_[0], dy = a_[4] - a_[1];
    add(-(a_[0] * dx + a_[1] * dy) / std::max(dx * dx + dy * dy, 1e-300));
  }
  if (kind_ == Kind::Torus && a_[3] != a_[2])
    for (int k = -4; k <= 4; ++k) add((90.0 * k - a_[2]) / (a_[3] - a_[2]));

  // The profile turns about the axis from its own angle; a hyperboloid's angle varies, so its whole circle
  // counts.
  V3d low(std::numeric_limits<double>::infinity()), high(-low);
  const auto extend = [&](const V3d& p) {
    for (int c = 0; c < 3; ++c) low[c] = std::min(low[c], p[c]), high[c] = std::max(high[c], p[c]);
  };
  for (size_t i = 0; i < count; ++i) {
    const V3d p = profile(at[i]).p;
    const double r = std::hypot(p.x, p.y);
    if (kind_ == Kind::Hyperboloid) {
      extend({r, r, p.z});
      extend({-r, -r, p.z});
      continue;
    }
    extend(p);
    extend(rotate(p, sinCosDegrees(theta_)));
    for (int quarter = 1; 90 * quarter <= std::abs(theta_); ++quarter)
      extend(rotate(p, sinCosDegrees(90.0 * quarter * sign(theta_))));
  }
  Box3f box;
  for (int c = 0; c < 3; ++c) {
    box.min[c] = std::nextafter(static_cast<float>(low[c]), -kInfinity);
    box.max[c] = std::nextafter(static_cast<float>(high[c]), kInfinity);
  }
  return box;
}

std::unique_ptr<QuadricSurface> QuadricSurface::make(const Quadric& quadric, const Primitive& primitive,
                                                     ErrorHandler& errors) {
  const auto index = static_cast<size_t>(quadric.kind);
  const char* const name = kNames[index];
  const auto fail = [&](RiError code, std::string_view why) {
    errors.report(Severity::Error, code, primitive.where, fmt::format("{}: {}", name, why));
    return nullptr;
  };
  const auto warn = [&](std::string_view what) {
    errors.report(Severity::Warning, RiError::Range, primitive.where, fmt::format("{}: {}", name, what));
  };
  std::unique_ptr<QuadricSurface> surface(new QuadricSurface);
  surface->kind_ = quadric.kind;
  double* const a = surface->a_;
  for (size_t i = 0; i < kValues[index]; ++i) {
    if (!(std::abs(quadric.values[i]) <= kLargestCoordinate))
      return fail(RiError::Range, "a value is not finite");
    a[i] = static_cast<double>(quadric.values[i]);
  }
  if (!std::isfinite(quadric.thetaMax)) return fail(RiError::Range, "thetamax is not finite");
  surface->theta_ = wholeTurn(static_cast<double>(quadric.thetaMax));

  bool area = surface->theta_ != 0;
  switch (quadric.kind) {
    case Kind::Sphere: {
      const double r = a[0];
      const auto latitude = [&](double z) {
        const double sine = r == 0 ? 0 : z / r;
        return std::abs(sine) >= 1 ? std::copysign(90.0, sine) : std::asin(sine) / kRadians;
      };
      const double low = latitude(a[1]), high = latitude(a[2]);
      a[1] = low, a[2] = high;
      area = area && r != 0 && low != high;
      break;
    }
    case Kind::Cone:
      area = area && a[1] != 0;
      break;
    case Kind::Cylinder:
      area = area && a[0] != 0 && a[1] != a[2];
      break;
    case Kind::Hyperboloid: {
      const V3d p(a[0], a[1], 0), d(a[3] - a[0], a[4] - a[1], a[5] - a[2]);
      const bool onAxis = a[0] == 0 && a[1] == 0 && a[3] == 0 && a[4] == 0;
      area = area && d.length2() > 0 && !onAxis;
      break;
    }
    case Kind::Paraboloid:
      if (a[2] != 0 && a[1] / a[2] < 0) {
        warn("zmin and zmax lie on different sides of 0; the part without a radius is left out");
        a[1] = 0;
      }
      area = area && a[0] != 0 && a[2] != 0 && a[1] != a[2];
      break;
    case Kind::Disk:
      area = area && a[1] != 0;
      break;
    case Kind::Torus:
      if (std::abs(a[3] - a[2]) > 360 + kTurnTolerance)
        warn("phimin and phimax are more than 360 degrees apart; cut to one turn");
      a[3] = a[2] + wholeTurn(a[3] - a[2]);
      a[3] -= 360 * std::trunc(a[2] / 360);
      a[2] = std::fmod(a[2], 360.0);
      area = area && a[1] != 0 && a[2] != a[3];
      break;
  }
  if (!area) return fail(RiError::BadArgument, "has no area; left out");
  surface->bound_ = surface->computeBound();
  surface->memory_ = sizeof(QuadricSurface);
  return surface;
}

}  // namespace patina
