// SPDX-License-Identifier: Apache-2.0
// Curves: points, tangents, directions that neighbouring segments share, and the frames of tubes.
//
// Functions whose results have to agree bit for bit for two segments at their common end are not inlined:
// every call runs the same instructions, whatever sums the compiler contracts.
#include <tbb/task_arena.h>

#include "renderer/base/parallel.h"
#include "renderer/geometry/curves_surface.h"

namespace patina {
namespace {

constexpr uint32_t kStations = 4;  // of a segment, between which frames are carried by one rotation

/// A unit vector across a unit vector.
V3d perpendicular(const V3d& n) {
  const V3d a(std::abs(n.x), std::abs(n.y), std::abs(n.z));
  const V3d axis = a.x <= a.y && a.x <= a.z ? V3d(1, 0, 0) : a.y <= a.z ? V3d(0, 1, 0) : V3d(0, 0, 1);
  const V3d c = n.cross(axis);
  return c / std::sqrt(c.dot(c));
}

/// The unit vector across `direction` at an angle to a fixed one.
[[gnu::noinline]] V3d axisAt(const V3d& direction, double angle) {
  const V3d x = perpendicular(direction), y = direction.cross(x);
  return x * std::cos(angle) + y * std::sin(angle);
}

double angleOf(const V3d& direction, const V3d& axis) {
  const V3d x = perpendicular(direction), y = direction.cross(x);
  return std::atan2(axis.dot(y), axis.dot(x));
}

/// `axis`, across `from`, by the smallest rotation that takes `from` to `to`.
DualV3 rotated(const V3d& axis, const V3d& from, const DualV3& to) {
  const DualV3 a{axis, V3d(0)}, f{from, V3d(0)};
  const Dual cosine = dot(f, to);
  if (cosine.x > -1 + 1e-9) return a - (f + to) * (dot(to, a) / (Dual{1, 0} + cosine));
  return a;  // half a turn about the axis itself
}

/// Double reflection (Wang et al. 2008, section 3, algorithm of table I): the frame's axis r at the point p
/// with the tangent t, carried to the next point.
V3d doubleReflection(const V3d& r, const V3d& t, const V3d& p, const V3d& nextT, const V3d& nextP) {
  const V3d v1 = nextP - p;
  const double c1 = v1.dot(v1);
  if (c1 > 0) {
    const V3d left = r - v1 * (2 / c1 * v1.dot(r)), leftT = t - v1 * (2 / c1 * v1.dot(t));
    const V3d v2 = nextT - leftT;
    const double c2 = v2.dot(v2);
    if (c2 > 1e-12) {
      const V3d next = left - v2 * (2 / c2 * v2.dot(left));
      const V3d across = next - nextT * nextT.dot(next);  // rounding must not add up
      return across / std::sqrt(across.dot(across));
    }
  }
  return rotated(r, t, {nextT, V3d(0)}).x;
}

double wrapped(double angle) { return std::remainder(angle, 2 * std::numbers::pi); }

}  // namespace

[[gnu::noinline]] CurvesSurface::Jet CurvesSurface::jet(const Place& place, double v) const {
  const auto w = basis_.at(v), d = basis_.derivative(v), e = basis_.secondDerivative(v);
  Jet j{V3d(0), V3d(0), V3d(0)};
  double h = 0, h1 = 0, h2 = 0;
  for (size_t k = 0; k < static_cast<size_t>(basis_.points()); ++k) {
    const float* p = points_ + size_t{point(place, static_cast<uint32_t>(k))} * (rational_ ? 4 : 3);
    const V3d P(V3f(p[0], p[1], p[2]));
    j.P += P * w[k], j.d1 += P * d[k], j.d2 += P * e[k];
    if (!rational_) continue;
    const auto weight = static_cast<double>(p[3]);
    h += weight * w[k], h1 += weight * d[k], h2 += weight * e[k];
  }
  if (rational_) {
    j.P /= h;
    j.d1 = (j.d1 - j.P * h1) / h;
    j.d2 = (j.d2 - j.d1 * (2 * h1) - j.P * h2) / h;
  }
  return j;
}

double CurvesSurface::sizeOf(const Place& place) const {
  double squared = 0;
  const auto at = [&](uint32_t k) {
    const float* p = points_ + size_t{point(place, k)} * (rational_ ? 4 : 3);
    return V3d(V3f(p[0], p[1], p[2])) / (rational_ ? static_cast<double>(p[3]) : 1.0);
  };
  for (uint32_t k = 1; k < static_cast<uint32_t>(basis_.points()); ++k)
    squared = std::max(squared, (at(k) - at(0)).length2());
  return std::sqrt(squared);
}

/// Unit. Where the derivative vanishes (doubled control points, cusps), its limit from the inside of the
/// segment: two directions near by are extrapolated.
[[gnu::noinline]] DualV3 CurvesSurface::tangent(const Place& place, double v) const {
  constexpr double kVanishing = 1e-7, kStep = 1.0 / 4096;
  const double smallest = kVanishing * sizeOf(place);
  const auto at = [&](double t, DualV3& out) {
    const Jet j = jet(place, t);
    if (!(j.d1.length2() > smallest * smallest)) return false;
    out = unit({j.d1, j.d2});
    return true;
  };
  DualV3 t, near, far;
  if (at(v, t)) return t;
  const double inward = v < 0.5 ? kStep : -kStep;
  if (at(v + inward, near) && at(v + 2 * inward, far)) {
    const V3d limit = near.x * 2.0 - far.x;
    return {limit / std::sqrt(limit.dot(limit)), (far.x - near.x) / inward};
  }
  const V3d chord = jet(place, 1).P - jet(place, 0).P;
  if (chord.length2() > 0) return unit({chord, V3d(0)});
  return {V3d(0, 0, 1), V3d(0)};  // a point
}

/// The direction of cross-sections at an end: half-way between the tangents of the segments that meet there.
[[gnu::noinline]] V3d CurvesSurface::endDirection(const Place& place, uint32_t end) const {
  const uint32_t joint = place.index + end;
  const bool before = periodic_ || joint > 0, after = periodic_ || joint < place.count;
  if (!basis_.continuous() || !before || !after) return tangent(place, end).x;
  Place previous = place, next = place;
  previous.index = (joint + place.count - 1) % place.count;
  next.index = joint % place.count;
  const V3d in = tangent(previous, 1).x, out = tangent(next, 0).x, sum = in + out;
  const double length2 = sum.dot(sum);
  return length2 > 1e-12 ? sum / std::sqrt(length2) : perpendicular(out);  // turns straight back
}

CurvesSurface::Segment CurvesSurface::open(const Place& place) const {
  Segment s{place, {}, {}, sizeOf(place)};
  for (uint32_t end = 0; end < 2; ++end) {
    s.direction[end] = endDirection(place, end);
    s.lean[end] = s.direction[end] - tangent(place, end).x;
  }
  return s;
}

/// The unit normal of the cross-section at v: the tangent, bent towards the shared directions of the ends.
DualV3 CurvesSurface::direction(const Segment& segment, double v) const {
  const DualV3 t = tangent(segment.place, v);
  const V3d *lean = segment.lean, *ends = segment.direction;
  const DualV3 bent{t.x + lean[0] * (1 - v) + lean[1] * v, t.d - lean[0] + lean[1]};
  DualV3 out = bent.x.length2() > 1e-12 ? unit(bent) : t;
  if (v == 0) out.x = ends[0];
  if (v == 1) out.x = ends[1];
  return out;
}

/// The axis of a frame from the start of a segment to the last station before v, whose direction is `at`.
V3d CurvesSurface::carry(const Segment& segment, V3d axis, double v, V3d& at) const {
  at = segment.direction[0];
  for (uint32_t k = 1; k < kStations && k < v * kStations; ++k) {
    const DualV3 next = direction(segment, static_cast<double>(k) / kStations);
    axis = rotated(axis, at, {next.x, V3d(0)}).x;
    at = next.x;
  }
  return axis;
}

[[gnu::noinline]] CurvesSurface::Section CurvesSurface::section(const Segment& segment, double v) const {
  const Place& place = segment.place;
  const Jet j = jet(place, v);
  Section s{{j.P, j.d1}, direction(segment, v), {1, 0}, {}, {}, segment.scale};
  if (width_) s.width = blend(*width_, place, v, 0);
  if (!(s.width.x > 0)) s.width = {0, s.width.x < 0 ? 0 : s.width.d};
  const DualV3& D = s.direction;

  if (!round_) {
    DualV3 facing{view_.perspective ? V3d(view_.eye) - j.P : -V3d(view_.direction),
                  view_.perspective ? -j.d1 : V3d(0)};
    for (size_t c = 0; normal_ && c < 3; ++c) {
      const Dual n = blend(*normal_, place, v, c);
      facing.x[static_cast<int>(c)] = n.x, facing.d[static_cast<int>(c)] = n.d;
    }
    const DualV3 across = cross(D, facing);  // across x D = facing
    if (across.x.length2() > 1e-16 * facing.x.length2())
      s.across = unit(across);
    else
      s.across = {perpendicular(D.x), V3d(0)};  // seen along the curve: any side will do
    // Where the line of sight all but meets the tangent, the ribbon flips over at a point.
    constexpr double kFlip = 1e4;  // radians per segment
    if (!(s.across.d.length2() < kFlip * kFlip)) s.across.d = V3d(0);
    return s;
  }

  const Turn start = turns_.empty() ? Turn{0, 0} : turns_[varying(place, 0)];
  V3d from;
  const V3d axis = carry(segment, axisAt(segment.direction[0], static_cast<double>(start.angle)), v, from);
  const DualV3 x = rotated(axis, from, D), y = cross(D, x);
  const Dual twist{static_cast<double>(start.twist) * v, static_cast<double>(start.twist)};
  s.across = x * cos(twist) + y * sin(twist);
  if (v == 0 || (v == 1 && !turns_.empty()))
    s.across.x = axisAt(D.x, v == 0 ? static_cast<double>(start.angle)
                                    : static_cast<double>(turns_[varying(place, 1)].angle));
  s.up = cross(D, s.across);
  return s;
}

// ---- Frames of tubes --------------------------------------------------------------------------------------

void CurvesSurface::makeTurns() {
  if (!round_ || !basis_.continuous()) return;  // segments that do not join have frames of their own
  const auto count = static_cast<uint32_t>(curves_.size() - 1);
  turns_.assign(size_t{faces_} + (periodic_ ? 0 : count), Turn{0, 0});
  // Whoever waits here holds a lock: tasks of others, which may want the same one, must not run meanwhile.
  tbb::this_task_arena::isolate(
      [&] { parallelFor(uint32_t{0}, count, [&](uint32_t curve) { makeTurns(curve); }); });
}

void CurvesSurface::makeTurns(uint32_t curve) {
  const uint32_t first = curves_[curve].firstSegment, end = curves_[curve + 1].firstSegment;
  if (first == end) return;
  Turn* const turn = &turns_[varying(placeOf(first), 0)];
  const uint32_t count = end - first;
  V3d axis, last;
  for (uint32_t k = 0; k < count; ++k) {
    const Segment segment = open(placeOf(first + k));
    if (k == 0) axis = axisAt(segment.direction[0], 0);
    V3d at = segment.direction[0], P = jet(segment.place, 0).P;
    for (uint32_t station = 1; station <= kStations; ++station) {
      const double v = static_cast<double>(station) / kStations;
      const V3d next = direction(segment, v).x, nextP = jet(segment.place, v).P;
      axis = doubleReflection(axis, at, P, next, nextP);
      at = next, P = nextP;
    }
    last = at;
    if (k + 1 < count || !periodic_) turn[k + 1].angle = static_cast<float>(angleOf(at, axis));
  }
  if (periodic_) {  // back at the first end, whose angle is 0
    const double lack = -angleOf(last, axis);
    for (uint32_t k = 1; k < count; ++k)
      turn[k].angle = static_cast<float>(wrapped(static_cast<double>(turn[k].angle) +
                                                 lack * static_cast<double>(k) / static_cast<double>(count)));
  }
  for (uint32_t k = 0; k < count; ++k) {
    const Segment segment = open(placeOf(first + k));
    V3d at;
    const V3d end0 = axisAt(segment.direction[0], static_cast<double>(turn[k].angle));
    const V3d carried = carry(segment, end0, 1, at);
    const V3d& there = segment.direction[1];
    const uint32_t next = periodic_ ? (k + 1) % count : k + 1;
    turn[k].twist = static_cast<float>(wrapped(static_cast<double>(turn[next].angle) -
                                               angleOf(there, rotated(carried, at, {there, V3d(0)}).x)));
  }
}

}  // namespace patina
