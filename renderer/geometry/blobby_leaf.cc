// SPDX-License-Identifier: Apache-2.0
// The primitive fields of a Blobby: values, gradients and bounds in a box.
#include <limits>

#include "renderer/geometry/blobby_field.h"

namespace patina {
namespace {

constexpr double kLargest = 1e18;        // of coordinates: squares of them stay finite
constexpr double kLongLine = 35.0 / 32;  // 1 / integral of (1 - s^2)^3 ds from -1 to 1
constexpr double kLeastHeight = 1e-6;
constexpr double kRounding = 8 * std::numeric_limits<double>::epsilon();

double cube(double x) { return x * x * x; }

/// Of the ball that has the area of an ellipsoid with these half-axes, to about a hundredth: K. Thomsen's
/// formula, which holds for needles and discs, too.
double meanRadius(double a, double b, double c) {
  constexpr double kPower = 1.6075;
  const double most = std::max({a, b, c});
  const double x = std::pow(a / most, kPower), y = std::pow(b / most, kPower), z = std::pow(c / most, kPower);
  return most * std::pow((x * y + x * z + y * z) / 3, 0.5 / kPower);
}

/// The integral of (k - s^2)^3 ds from 0 to s, and that of its derivative by k.
double integral(double k, double s) {
  const double q = s * s;
  return s * (k * k * k - q * (k * k - q * (0.6 * k - q / 7)));
}
double integralByK(double k, double s) {
  const double q = s * s;
  return 3 * s * (k * k - q * (2 * k / 3 - q / 5));
}

/// Part of the line at 1 - k from the axis (squared) that lies in the bump, relative to the point's foot at
/// x.
Range inBump(double k, double x, double length) {
  const double w = std::sqrt(k);
  return {std::clamp(-x, -w, w), std::clamp(length - x, -w, w)};
}
double segmentField(double k, double x, double length) {
  if (k <= 0) return 0;
  const Range s = inBump(k, x, length);
  return s.low == s.high ? 0 : std::max(0.0, kLongLine * (integral(k, s.high) - integral(k, s.low)));
}

// The profile of a repelling plane: the curves of the Application Note as polynomials, and their derivatives.
double bump(double t) { return t <= 0 || t >= 2 ? 0 : cube(t * (2 - t)); }
double bumpSlope(double t) { return t <= 0 || t >= 2 ? 0 : 3 * t * t * (2 - t) * (2 - t) * (2 - 2 * t); }
double ease(double t) { return t <= 0 ? 0 : t >= 1 ? 1 : t * t * (3 - 2 * t); }
double easeSlope(double t) { return t <= 0 || t >= 1 ? 0 : 6 * t * (1 - t); }
double ratio(double z, double size) { return size > 0 ? z / size : 0; }

}  // namespace

bool BlobbyField::addLeaf(const Blobby& blobby, const Blobby::Instruction& instruction, uint32_t number) {
  const float* const f = &blobby.floats[instruction.first];
  const auto at = [&](size_t k) { return static_cast<double>(f[k]); };
  Leaf leaf{};
  leaf.number = number;
  if (instruction.op == Blobby::Op::Constant) {
    leaf.kind = Kind::Constant;
    leaf.profile[0] = std::clamp(at(0), -1e30, 1e30);
    leaves_.push_back(leaf);
    return true;
  }
  if (instruction.op == Blobby::Op::Plane) {
    leaf.kind = Kind::Plane;
    for (size_t k = 0; k < 4; ++k) leaf.profile[k] = std::clamp(at(k), -kLargest, kLargest);
    hasPlane_ = true;
    leaves_.push_back(leaf);
    return true;
  }

  // An affine matrix with an inverse.
  const bool segment = instruction.op == Blobby::Op::Segment;
  const size_t m = segment ? 7 : 0;
  V3d row[4];
  for (size_t k = 0; k < 4; ++k) row[k] = {at(m + 4 * k), at(m + 4 * k + 1), at(m + 4 * k + 2)};
  if (at(m + 3) != 0 || at(m + 7) != 0 || at(m + 11) != 0 || at(m + 15) != 1) return false;
  for (size_t k = 0; k < instruction.count; ++k)
    if (std::abs(at(k)) > kLargest) return false;

  // Axes of the field's space in object space: the first along a segment, all as long as its radius.
  V3d axis[3] = {row[0], row[1], row[2]}, origin = row[3];
  leaf.kind = Kind::Ellipsoid;
  if (segment) {
    const V3d p(at(0), at(1), at(2)), q(at(3), at(4), at(5));
    const double radius = at(6), length = (q - p).length();
    if (!(radius > 0)) return false;
    V3d frame[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    if (length > 0) {
      leaf.kind = Kind::Segment;
      leaf.length = length / radius;
      frame[0] = (q - p) / length;
      V3d across(0, 0, 0);  // the coordinate axis that is farthest from the segment's direction
      int least = 0;
      for (int c = 1; c < 3; ++c)
        if (std::abs(frame[0][c]) < std::abs(frame[0][least])) least = c;
      across[least] = 1;
      frame[1] = frame[0].cross(across);
      frame[1] /= frame[1].length();
      frame[2] = frame[0].cross(frame[1]);
    }
    origin = row[0] * p.x + row[1] * p.y + row[2] * p.z + row[3];
    for (V3d& a : frame) a = (row[0] * a.x + row[1] * a.y + row[2] * a.z) * radius;
    for (int k = 0; k < 3; ++k) axis[k] = frame[k];
  }
  const double volume = axis[0].dot(axis[1].cross(axis[2]));
  const double size = axis[0].length() * axis[1].length() * axis[2].length();
  if (!(std::abs(volume) > 1e-12 * size) || !std::isfinite(size)) return false;
  leaf.origin = origin;
  const V3d dual[3] = {axis[1].cross(axis[2]) / volume, axis[2].cross(axis[0]) / volume,
                       axis[0].cross(axis[1]) / volume};
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j) {
      leaf.toField[j][k] = dual[k][j];
      if (!std::isfinite(dual[k][j])) return false;
    }

  // Where it is not 0, and how fine it is.
  const V3d end = origin + axis[0] * leaf.length;
  double half[3];
  for (int c = 0; c < 3; ++c) {
    half[c] = std::sqrt(axis[0][c] * axis[0][c] + axis[1][c] * axis[1][c] + axis[2][c] * axis[2][c]);
    support_.axis[c].low = std::min({support_.axis[c].low, origin[c] - half[c], end[c] - half[c]});
    support_.axis[c].high = std::max({support_.axis[c].high, origin[c] + half[c], end[c] + half[c]});
  }
  // Heights of the parallelepiped bound the thinnest half-axis; the surface of one field is at half of it.
  const double thin = 1 / std::max({dual[0].length(), dual[1].length(), dual[2].length()});
  const double mean = meanRadius(half[0] / 2, half[1] / 2, half[2] / 2), along = (end - origin).length();
  leaf.detail = {(origin + end) * 0.5, thin / 2, along / 2 + V3d(half[0], half[1], half[2]).length(),
                 2 * std::numbers::pi * mean * (2 * mean + along)};
  leaves_.push_back(leaf);
  return true;
}

double BlobbyField::value(const Leaf& leaf, const V3d& p) const {
  if (leaf.kind == Kind::Constant) return leaf.profile[0];
  if (leaf.kind == Kind::Plane) {
    const auto [a, b, c, d] = leaf.profile;
    if (p.z >= a) return 0;
    const double z = std::max(p.z, kLeastHeight);
    return (d * bump(ratio(z, c)) - b / z) * (1 - ease(ratio(z, a)));
  }
  const V3d r = p - leaf.origin;
  double q[3];
  for (int k = 0; k < 3; ++k)
    q[k] = r.x * leaf.toField[0][k] + r.y * leaf.toField[1][k] + r.z * leaf.toField[2][k];
  if (leaf.kind == Kind::Ellipsoid) {
    const double squared = q[0] * q[0] + q[1] * q[1] + q[2] * q[2];
    return squared < 1 ? cube(1 - squared) : 0;
  }
  return segmentField(1 - (q[1] * q[1] + q[2] * q[2]), q[0], leaf.length);
}

BlobbyField::Jet BlobbyField::jet(const Leaf& leaf, const V3d& p) const {
  const double f = value(leaf, p);
  if (leaf.kind == Kind::Constant) return {f, V3d(0, 0, 0)};
  if (leaf.kind == Kind::Plane) {
    const auto [a, b, c, d] = leaf.profile;
    if (p.z >= a || p.z < kLeastHeight) return {f, V3d(0, 0, 0)};
    const double z = p.z, rise = d * bump(ratio(z, c)) - b / z, fade = 1 - ease(ratio(z, a));
    const double riseSlope = (c > 0 ? d / c * bumpSlope(z / c) : 0) + b / (z * z);
    return {f, V3d(0, 0, riseSlope * fade - rise * (a > 0 ? easeSlope(z / a) / a : 0))};
  }
  if (f == 0) return {0, V3d(0, 0, 0)};
  const V3d r = p - leaf.origin;
  double q[3], slope[3];  // by the coordinates of the field's space
  for (int k = 0; k < 3; ++k)
    q[k] = r.x * leaf.toField[0][k] + r.y * leaf.toField[1][k] + r.z * leaf.toField[2][k];
  if (leaf.kind == Kind::Ellipsoid) {
    const double t = 1 - (q[0] * q[0] + q[1] * q[1] + q[2] * q[2]);
    for (int k = 0; k < 3; ++k) slope[k] = -6 * t * t * q[k];
  } else {
    const double k = 1 - (q[1] * q[1] + q[2] * q[2]);
    const Range s = inBump(k, q[0], leaf.length);
    const double byK = kLongLine * (integralByK(k, s.high) - integralByK(k, s.low));
    slope[0] =
        -kLongLine * (cube(std::max(0.0, k - s.high * s.high)) - cube(std::max(0.0, k - s.low * s.low)));
    slope[1] = -2 * q[1] * byK;
    slope[2] = -2 * q[2] * byK;
  }
  V3d gradient;
  for (int j = 0; j < 3; ++j)
    gradient[j] =
        leaf.toField[j][0] * slope[0] + leaf.toField[j][1] * slope[1] + leaf.toField[j][2] * slope[2];
  return {f, gradient};
}

Range BlobbyField::range(const Leaf& leaf, const BlobbyBox& box) const {
  if (leaf.kind == Kind::Constant) return {leaf.profile[0], leaf.profile[0]};
  if (leaf.kind == Kind::Plane) {
    const auto [a, b, c, d] = leaf.profile;
    const Range z{std::max(box.axis[2].low, kLeastHeight), std::max(box.axis[2].high, kLeastHeight)};
    if (box.axis[2].low >= a) return {0, 0};
    const Range t{ratio(z.low, c), ratio(z.high, c)};
    const double ends[2] = {bump(t.low), bump(t.high)};
    const Range curve{std::min(ends[0], ends[1]), t.low <= 1 && t.high >= 1 ? 1 : std::max(ends[0], ends[1])};
    const Range wall{std::min(-b / z.low, -b / z.high), std::max(-b / z.low, -b / z.high)};
    const Range rise{std::min(d * curve.low, d * curve.high) + wall.low,
                     std::max(d * curve.low, d * curve.high) + wall.high};
    const Range fade{1 - ease(ratio(z.high, a)), 1 - ease(ratio(z.low, a))};
    const double ends4[4] = {rise.low * fade.low, rise.low * fade.high, rise.high * fade.low,
                             rise.high * fade.high};
    const double slack = 1e-12 * (std::abs(d) + std::max(std::abs(wall.low), std::abs(wall.high)));
    Range result{*std::min_element(ends4, ends4 + 4) - slack, *std::max_element(ends4, ends4 + 4) + slack};
    if (box.axis[2].high >= a) result = {std::min(result.low, 0.0), std::max(result.high, 0.0)};
    return result;
  }

  // Coordinates in the field's space, with what rounding may add to those of a point.
  Range q[3];
  for (int k = 0; k < 3; ++k) {
    double middle = 0, reach = 0, terms = 0;
    for (int j = 0; j < 3; ++j) {
      const double m = leaf.toField[j][k], scale = std::abs(m);
      const double center = (box.axis[j].low + box.axis[j].high) / 2 - leaf.origin[j];
      const double half = (box.axis[j].high - box.axis[j].low) / 2;
      middle += center * m;
      reach += half * scale;
      terms += (std::abs(center) + half + std::abs(leaf.origin[j]) + std::abs(box.axis[j].high)) * scale;
    }
    reach += kRounding * terms;
    q[k] = {middle - reach, middle + reach};
  }
  const auto squares = [](const Range& r) {
    const double a = std::abs(r.low), b = std::abs(r.high);
    const double least = r.low <= 0 && r.high >= 0 ? 0 : std::min(a, b), most = std::max(a, b);
    return Range{least * least, most * most};
  };
  const Range y = squares(q[1]), z = squares(q[2]);
  if (leaf.kind == Kind::Ellipsoid) {
    const Range x = squares(q[0]);
    const double near = x.low + y.low + z.low, far = x.high + y.high + z.high;
    return {far < 1 ? cube(1 - far) : 0, near < 1 ? cube(1 - near) : 0};
  }
  const Range k{1 - (y.high + z.high), 1 - (y.low + z.low)};
  // The field rises with k and towards the middle of the segment.
  const double middle = leaf.length / 2;
  const double near = std::clamp(middle, q[0].low, q[0].high);
  const double far = middle - q[0].low > q[0].high - middle ? q[0].low : q[0].high;
  const double most = segmentField(k.high, near, leaf.length);
  if (most == 0) return {0, 0};
  return {std::max(0.0, segmentField(k.low, far, leaf.length) - 1e-12), most + 1e-12};
}

}  // namespace patina
