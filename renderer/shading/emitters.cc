// SPDX-License-Identifier: Apache-2.0
// Sampling of area lights.
#include "renderer/shading/emitters.h"

#include "renderer/base/sampling.h"

namespace patina {
namespace {

constexpr float kSmallestSolidAngle = 3e-3f;  // below, area sampling is as good, and the angles cancel

/// The rectangle as seen from a point (Urena, Fajardo and King 2013, "An Area-Preserving Parametrization for
/// Spherical Rectangles"), in the notation of that paper.
struct SphericalRectangle {
  V3f x, y, z;
  float x0, y0, z0, x1, y1;
  float b0, b1, k, solidAngle;

  SphericalRectangle(const V3f& corner, const V3f& ex, const V3f& ey, const V3f& from) {
    const float lengthX = ex.length(), lengthY = ey.length();
    x = ex / lengthX, y = ey / lengthY;
    z = x.cross(y);
    const V3f d = corner - from;
    z0 = d.dot(z);
    if (z0 > 0) z = -z, z0 = -z0;
    x0 = d.dot(x), y0 = d.dot(y), x1 = x0 + lengthX, y1 = y0 + lengthY;
    // z components of the unit normals of the four side planes; the normals are perpendicular to one axis
    // each.
    const auto planeZ = [&](float a) { return a / std::sqrt(z0 * z0 + a * a); };
    const float n0 = -planeZ(y0), n1 = planeZ(x1), n2 = planeZ(y1), n3 = -planeZ(x0);
    const auto angle = [](float c) { return std::acos(std::clamp(c, -1.0f, 1.0f)); };
    const float g0 = angle(-n0 * n1), g1 = angle(-n1 * n2), g2 = angle(-n2 * n3), g3 = angle(-n3 * n0);
    b0 = n0, b1 = n2;
    k = 2 * kPi - g2 - g3;
    solidAngle = z0 == 0 ? 0 : std::max(0.0f, g0 + g1 - k);
  }
  V3f sample(const V3f& from, const V2f& random) const {
    const float au = random.x * solidAngle + k;
    const float fu = (std::cos(au) * b0 - b1) / std::sin(au);
    float cu = std::copysign(1.0f, fu) / std::sqrt(fu * fu + b0 * b0);
    cu = std::clamp(cu, -kOneMinusEpsilon, kOneMinusEpsilon);
    const float xu = std::clamp(-(cu * z0) / std::max(std::sqrt(1 - cu * cu), 1e-30f), x0, x1);
    const float d = std::sqrt(xu * xu + z0 * z0);
    const float h0 = y0 / std::sqrt(d * d + y0 * y0), h1 = y1 / std::sqrt(d * d + y1 * y1);
    const float hv = h0 + random.y * (h1 - h0), hv2 = hv * hv;
    const float yv = hv2 < 1 - 1e-6f ? std::clamp(hv * d / std::sqrt(1 - hv2), y0, y1) : y1;
    return from + x * xu + y * yv + z * z0;
  }
};

}  // namespace

void Emitters::add(const Geometry& geometry, uint32_t index) {
  const Placement& placement = geometry.placements()[index];
  const Surface& surface = geometry.surface(placement);
  const TracedSurface& traced = geometry.traced()[placement.traced];
  const auto first = static_cast<uint32_t>(shapes_.size());

  // A whole sphere that is not squashed is sampled as what it is.
  if (const Quadric* quadric = std::get_if<Quadric>(&traced.primitive->shape);
      !traced.isDisplaced && quadric && quadric->kind == Quadric::Kind::Sphere && quadric->thetaMax == 360) {
    const float r = quadric->values[0];
    const V3f c = transformPoint({0, 0, 0}, placement.objectToWorld);
    float lengths[3];
    for (int k = 0; k < 3; ++k) {
      V3f axis(0, 0, 0);
      axis[k] = r;
      lengths[k] = transformVector(axis, placement.objectToWorld).length();
    }
    const float scale = *std::max_element(lengths, lengths + 3),
                least = *std::min_element(lengths, lengths + 3);
    const M44f& m = placement.objectToWorld;
    const auto row = [&](int k) { return V3f(m[k][0], m[k][1], m[k][2]); };
    const float shear =
        std::max({std::abs(row(0).dot(row(1))), std::abs(row(0).dot(row(2))), std::abs(row(1).dot(row(2)))});
    const bool whole = quadric->values[1] <= -r * 0.999999f && quadric->values[2] >= r * 0.999999f;
    if (whole && r > 0 && scale - least < 1e-5f * scale && shear < 1e-5f * row(0).length2()) {
      Shape s;
      s.kind = Shape::Kind::Sphere;
      s.corner = c, s.edge1 = V3f(scale, 0, 0);
      s.error = roundingBound(16) * (maxAbsComponent(c) + scale);
      s.area = 4 * kPi * scale * scale;
      s.sign = placement.normalSign;
      s.axes[0] = row(0).normalized(), s.axes[1] = row(1).normalized(), s.axes[2] = row(2).normalized();
      shapes_.push_back(s);
      owners_[index] = {first, 0};
      return;
    }
  }

  const auto parameters = [&](uint32_t face, const V2f& uv) {
    return surface.surfaceParameters(face, uv.x, uv.y);
  };
  bool rectangles = !geometry.isTessellated(placement.traced);
  if (rectangles)
    geometry.forEachFacet(index, [&](const Geometry::FacetQuad& q) {
      const V3f e1 = q.P[1] - q.P[0], e2 = q.P[2] - q.P[0];
      const float size = std::max(e1.length(), e2.length());
      rectangles = rectangles && !q.isTriangle && (q.P[3] - q.P[0] - e1 - e2).length() < 1e-5f * size &&
                   std::abs(e1.dot(e2)) < 1e-5f * size * size;
    });
  geometry.forEachFacet(index, [&](const Geometry::FacetQuad& q) {
    const auto push = [&](Shape::Kind kind, int corner, int along1, int along2) {
      const V3f &p = q.P[corner], e1 = q.P[along1] - p, e2 = q.P[along2] - p;
      const V2f at = parameters(q.face, q.uv[corner]), d1 = parameters(q.face, q.uv[along1]) - at,
                d2 = parameters(q.face, q.uv[along2]) - at;
      const V3f cross = e1.cross(e2);
      const float area = cross.length() * (kind == Shape::Kind::Triangle ? 0.5f : 1.0f);
      if (area > 0)
        shapes_.push_back(
            {kind, p, e1, e2, cross / cross.length() * placement.facetSign, at, d1, d2, q.error, area});
      else if (rectangles)
        shapes_.push_back({kind, p, e1, e2, V3f(0, 0, 1), at, d1, d2, q.error, 0});
    };
    if (rectangles) {
      push(Shape::Kind::Rectangle, 0, 1, 2);
      return;
    }
    push(Shape::Kind::Triangle, 0, 1, 2);
    if (!q.isTriangle) push(Shape::Kind::Triangle, 3, 2, 1);
  });
  owners_[index] = {first, rectangles ? 1 : kNone};
}

void Emitters::finish() {
  std::vector<double> sums;
  double sum = 0;
  for (const Shape& s : shapes_) sums.push_back(sum += s.area);
  total_ = static_cast<float>(sum);
  if (!(total_ > 0)) {
    shapes_.clear();
    return;
  }
  for (const double s : sums) cumulative_.push_back(static_cast<float>(s / sum));
}

LightBounds Emitters::bounds() const {
  LightBounds all;
  bool first = true;
  for (const Shape& s : shapes_) {
    if (!(s.area > 0)) continue;
    LightCone cone{s.normal, 0, kPi / 2};
    const V3f around(s.error, s.error, s.error);
    const auto reach = [&](const V3f& p) {
      all.box.extendBy(p - around);
      all.box.extendBy(p + around);
    };
    if (s.kind == Shape::Kind::Sphere) {
      const V3f r(s.edge1.x, s.edge1.x, s.edge1.x);
      reach(s.corner - r), reach(s.corner + r);
      cone = LightCone::everywhere();
    } else {
      reach(s.corner), reach(s.corner + s.edge1), reach(s.corner + s.edge2);
      if (s.kind == Shape::Kind::Rectangle) reach(s.corner + s.edge1 + s.edge2);
    }
    all.cone = first ? cone : LightCone::merged(all.cone, cone);
    first = false;
  }
  return all;
}

float Emitters::rectangleSolidAngle(const Shape& s, const V3f& from) {
  return SphericalRectangle(s.corner, s.edge1, s.edge2, from).solidAngle;
}

void Emitters::sampleRectangle(const Shape& s, const V3f& from, V2f random, EmitterSample& out) {
  // Many samples of one point follow each other.
  struct Last {
    V3f corner, edge1, edge2, from;
    SphericalRectangle rectangle;
  };
  thread_local Last last{
      {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}}};
  if (last.from != from || last.corner != s.corner || last.edge1 != s.edge1 || last.edge2 != s.edge2)
    last = {s.corner, s.edge1, s.edge2, from, SphericalRectangle(s.corner, s.edge1, s.edge2, from)};
  const SphericalRectangle& rectangle = last.rectangle;
  if (rectangle.solidAngle < kSmallestSolidAngle) {
    out.P = s.corner + s.edge1 * random.x + s.edge2 * random.y;
    const V3f d = out.P - from;
    const float cosine = std::abs(s.normal.dot(d)) / std::max(d.length(), 1e-30f);
    out.pdf = cosine > 0 ? d.length2() / (s.area * cosine) : 0;
  } else {
    out.P = rectangle.sample(from, random);
    out.pdf = 1 / rectangle.solidAngle;
    random = {(out.P - s.corner).dot(s.edge1) / s.edge1.length2(),
              (out.P - s.corner).dot(s.edge2) / s.edge2.length2()};
  }
  const V2f uv = s.uv0 + s.duv1 * random.x + s.duv2 * random.y;
  out.u = uv.x, out.v = uv.y;
}

/// The cone of directions to a sphere; from inside, every direction (PBR 4th ed. section 6.2.4).
float Emitters::spherePdf(const Shape& s, const V3f& from) {
  const float r = s.edge1.x, squared = (s.corner - from).length2();
  if (squared <= r * r) return 1 / (4 * kPi);
  const float sin2 = r * r / squared;
  // 1 - cos without cancellation.
  const float oneMinusCos = sin2 / (1 + std::sqrt(std::max(0.0f, 1 - sin2)));
  return 1 / (2 * kPi * oneMinusCos);
}

void Emitters::sampleSphere(const Shape& s, const V3f& from, V2f random, EmitterSample& out) {
  const float r = s.edge1.x;
  const V3f toCenter = s.corner - from;
  const float squared = toCenter.length2();
  out.pdf = spherePdf(s, from);
  V3f direction;
  if (squared <= r * r) {
    const float z = 1 - 2 * random.x, radius = std::sqrt(std::max(0.0f, 1 - z * z));
    direction = {radius * std::cos(2 * kPi * random.y), radius * std::sin(2 * kPi * random.y), z};
  } else {
    const float oneMinusCos = random.x / (2 * kPi * out.pdf);
    const float sine = std::sqrt(std::max(0.0f, oneMinusCos * (2 - oneMinusCos)));
    const Frame frame(toCenter / std::sqrt(squared));
    direction = frame.toWorld(
        {sine * std::cos(2 * kPi * random.y), sine * std::sin(2 * kPi * random.y), 1 - oneMinusCos});
  }
  const float middle = toCenter.dot(direction);
  const V3f closest = toCenter - direction * middle;
  const float half = std::sqrt(std::max(0.0f, r * r - closest.length2()));
  const float t = squared <= r * r ? middle + half : middle - half;
  const V3f outward = normalizedOr(direction * t - toCenter, -direction);
  out.P = s.corner + outward * r;
  out.N = outward * s.sign;
  // As RI has them of a whole sphere: u around the z axis from x, v up from -z, each from 0 to 1.
  const float x = outward.dot(s.axes[0]), y = outward.dot(s.axes[1]), z = outward.dot(s.axes[2]);
  const float turn = std::atan2(y, x) / (2 * kPi);
  out.u = turn < 0 ? turn + 1 : turn;
  out.v = 0.5f + std::atan2(z, std::hypot(x, y)) / kPi;
}

EmitterSample Emitters::sample(const V3f& from, V2f random) const {
  EmitterSample out;
  if (shapes_.empty()) return out;
  const auto found = std::upper_bound(cumulative_.begin(), cumulative_.end(), random.x);
  const size_t k = std::min<size_t>(static_cast<size_t>(found - cumulative_.begin()), shapes_.size() - 1);
  const Shape& s = shapes_[k];
  // Of many shapes each is chosen as often as rounded sums say, which differs by more than its area is known
  // to; what one has too much its neighbours lack, so the density is that of the areas.
  const float low = k ? cumulative_[k - 1] : 0, width = cumulative_[k] - low, chance = s.area / total_;
  if (width > 0) random.x = std::clamp((random.x - low) / width, 0.0f, kOneMinusEpsilon);
  out.N = s.normal;
  out.error = s.error;
  switch (s.kind) {
    case Shape::Kind::Rectangle:
      sampleRectangle(s, from, random, out);
      break;
    case Shape::Kind::Sphere:
      sampleSphere(s, from, random, out);
      break;
    case Shape::Kind::Triangle: {
      const V2f b = sampleTriangle(random);
      out.P = s.corner + s.edge1 * b.x + s.edge2 * b.y;
      const V3f d = out.P - from;
      const float cosine = std::abs(s.normal.dot(d)) / std::max(d.length(), 1e-30f);
      out.pdf = cosine > 0 ? d.length2() / (s.area * cosine) : 0;
      const V2f uv = s.uv0 + s.duv1 * b.x + s.duv2 * b.y;
      out.u = uv.x, out.v = uv.y;
    }
  }
  out.pdf *= chance;
  if (!std::isfinite(out.pdf)) out.pdf = 0;
  return out;
}

float Emitters::pdf(uint32_t placement, uint32_t face, const V3f& from, const V3f& point,
                    const V3f& normal) const {
  const auto owner = owners_.find(placement);
  if (owner == owners_.end() || shapes_.empty()) return 0;
  const V3f d = point - from;
  const float cosine = std::abs(normal.dot(d)) / std::max(d.length(), 1e-30f);
  const float byArea = cosine > 0 ? d.length2() / (total_ * cosine) : 0;
  if (owner->second.perFace == kNone) return byArea;
  const Shape& s = shapes_[owner->second.first + (owner->second.perFace ? face : 0)];
  const float chance = s.area / total_;
  if (s.kind == Shape::Kind::Sphere) return chance * spherePdf(s, from);
  const float solidAngle = rectangleSolidAngle(s, from);
  return solidAngle < kSmallestSolidAngle ? byArea : chance / solidAngle;
}

}  // namespace patina
