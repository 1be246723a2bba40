// SPDX-License-Identifier: Apache-2.0
// Drawing surfels and nodes into a hemicube.
#include "renderer/points/point_raster.h"

#include <cassert>

namespace patina {
namespace {

/// A pixel that is covered so far counts as full: squares in place of pieces do not fit without gaps.
constexpr float kFull = 0.95f;
/// ... and one that is covered so far, between two that are full.
constexpr float kSeam = 0.3f;
/// ... and one where so much of the pixels around is covered, on average.
constexpr float kAmong = 0.9f;
/// Of a pixel that is covered by less nothing is guessed.
constexpr float kThin = 0.1f;
/// What is farther than the first in a pixel by so many pixels, and halves of its size, is another layer: it
/// is seen through what is open, where pieces of one layer lie beside each other.
constexpr float kLayer = 2;
/// Surfels of the surface that the place is on: so many radii away, a part of a radius above or below it,
/// with normals at most so far apart.
constexpr float kOwnReach = 2, kOwnHeight = 0.3f, kOwnCosine = 0.7f;
/// ... of rough pieces, whose parts are not turned as the whole is.
constexpr float kRoughCosine = 0.2f;
/// ... and in which the place is not in a hollow by so much of a radius.
constexpr float kHollow = 1e-3f;

/// The faces are the top and the sides towards x, y, -x, -y; v, from 0 on, is up on the sides.
V3f fromFace(int face, float u, float v) {
  switch (face) {
    case 0:
      return {u, v, 1};
    case 1:
      return {1, u, v};
    case 2:
      return {-u, 1, v};
    case 3:
      return {-1, -u, v};
    default:
      return {u, -1, v};
  }
}

/// Pixels are looked at so many at a time.
constexpr int kLanes = 8;

}  // namespace

PointRaster::PointRaster(const Settings& settings)
    : resolution_(settings.resolution),
      stride_((settings.resolution + kLanes - 1) / kLanes * kLanes),
      maxSolidAngle_(settings.maxSolidAngle) {
  assert(resolution_ >= 2 && resolution_ % 2 == 0);
  const float size = 2 / static_cast<float>(resolution_);
  float sum = 0;
  for (int face = 0; face < 5; ++face)
    for (int row = 0; row < rowsOf(face); ++row)
      for (int column = 0; column < stride_; ++column) {
        const float u = -1 + (static_cast<float>(column) + 0.5f) * size;
        const float v = (face == 0 ? -1 : 0) + (static_cast<float>(row) + 0.5f) * size;
        const V3f d = fromFace(face, u, v);
        const float length2 = d.length2();
        const float weight = column < resolution_ ? d.z * size * size * kInvPi / (length2 * length2) : 0;
        pixels_.push_back({weight, d / std::sqrt(length2)});
        sum += weight;
      }
  for (Pixel& pixel : pixels_) pixel.weight /= sum;
  for (auto* of : {&dx_, &dy_, &dz_, &t_}) of->resize(pixels_.size());
  met_.resize(pixels_.size()), scale_.resize(pixels_.size()), content_.resize(pixels_.size());
  shells_.resize(kShells);
  full_.resize(static_cast<size_t>(3 * resolution_) * static_cast<size_t>((resolution_ + 63) / 64));
  for (int face = 0; face < 5; ++face) {
    const V3f out = fromFace(face, 0, 0);
    axes_[static_cast<size_t>(face)] = {out, fromFace(face, 1, 0) - out, fromFace(face, 0, 1) - out};
  }
}

PointRaster::Estimate PointRaster::gather(const PointTree& tree, const V3f& P, const V3f& N, float turn,
                                          float nearest, const Environment& environment, bool lit,
                                          uint32_t outside, SurfelView* view) {
  std::fill(content_.begin(), content_.end(), Content());
  std::fill(t_.begin(), t_.end(), kInfinity);
  traced_.clear(), drawn_.clear(), parts_.clear();
  isViewed_ = view != nullptr && lit;
  P_ = P, nearest_ = nearest, outside_ = outside, looked_ = 0;
  frame_ = Frame(N);
  const float angle = 2 * kPi * turn;
  const V3f x = frame_.x * std::cos(angle) + frame_.y * std::sin(angle);
  frame_.y = N.cross(x), frame_.x = x;
  for (size_t k = 0; k < pixels_.size(); ++k) {
    const V3f d = frame_.toWorld(pixels_[k].direction);
    dx_[k] = d.x, dy_[k] = d.y, dz_[k] = d.z;
  }
  Estimate result;
  result.nearest = lookAround(tree), result.looked = looked_;
  openDirections_.clear(), openWeights_.clear();
  float light = 0, near = 0;  // sums of radiance, and of that over the distance
  for (int face = 0; face < 5; ++face)
    for (int row = 0; row < rowsOf(face); ++row)
      for (int column = 0; column < resolution_; ++column) {
        const size_t k = at(face, row, column);
        Content& c = content_[k];
        Rgb radiance = c.radiance;
        float covered = c.covered;
        if (isViewed_) scale_[k] = pixels_[k].weight * kPi;
        if (t_[k] < kInfinity) {
          radiance += radianceMet(k) * (1 - covered);
          if (isViewed_)
            drawn_.push_back(
                {traced_[static_cast<size_t>(met_[k])].part, static_cast<uint32_t>(k), 1 - covered});
          if (covered < 1)
            c.inverse += (1 - covered) / t_[k], result.nearest = std::min(result.nearest, t_[k]);
          covered = 1;
        } else if (covered > 0) {
          const float whole = wholeOf(face, row, column);
          if (whole > covered) {
            const float scale = whole / covered;
            radiance *= scale, c.inverse *= scale, covered = whole;
            if (isViewed_) scale_[k] *= scale;
          }
        }
        if (covered < 1 && environment) {
          openDirections_.push_back({dx_[k], dy_[k], dz_[k]});
          openWeights_.push_back((1 - covered) * pixels_[k].weight);
        }
        if (lit) {
          result.irradiance += radiance * (pixels_[k].weight * kPi);
          const float shines = maxComponent(radiance) * pixels_[k].weight * kPi;
          light += shines;
          if (covered > 0) near += shines * c.inverse / covered;
        }
        result.covered += covered * pixels_[k].weight;
        result.inverseDistance += c.inverse * pixels_[k].weight;
      }
  Rgb sky(0, 0, 0);
  if (!openDirections_.empty()) {
    openRadiance_.assign(openDirections_.size(), Rgb(0, 0, 0));
    environment(openDirections_, openRadiance_);
    for (size_t k = 0; k < openRadiance_.size(); ++k) sky += openRadiance_[k] * (openWeights_[k] * kPi);
  }
  result.irradiance += sky;
  light += maxComponent(sky);
  // Not of views: they are asked again in the light of other bounces, and must say the same as if drawn anew.
  if (!view && light > 0) result.inverseDistance = std::max(result.inverseDistance, near / light);
  if (view) {
    view->P = P, view->sky = sky, view->covered = result.covered;
    view->inverseDistance = result.inverseDistance, view->nearest = result.nearest;
    write(*view);
    result.irradiance = view->irradiance(tree);
  }
  return result;
}

Rgb PointRaster::radianceMet(size_t pixel) const {
  const Traced& met = traced_[static_cast<size_t>(met_[pixel])];
  if (!met.slope) return met.radiance;
  const V3f along = V3f(dx_[pixel], dy_[pixel], dz_[pixel]) * t_[pixel] - met.P;
  const auto& [r, g, b] = *met.slope;
  const Rgb change(r.dot(along), g.dot(along), b.dot(along));
  const Rgb sum = met.radiance + change;
  return {std::max(sum.x, 0.0f), std::max(sum.y, 0.0f), std::max(sum.z, 0.0f)};
}

bool PointRaster::isFull(size_t pixel) const {
  return t_[pixel] < kInfinity || content_[pixel].covered > kFull;
}

/// Of a pixel that is covered in part: whether pixels on two opposite sides of it are full, so that it is
/// rather a seam of a surface than its border. Beyond a face's edge there is nothing to be told.
bool PointRaster::isBetweenFull(int face, int row, int column) const {
  const int rows = rowsOf(face);
  const auto fullAt = [&](int r, int c) {
    if (r < 0 || c < 0 || r >= rows || c >= resolution_) return true;
    return isFull(at(face, r, c));
  };
  for (const auto& [dr, dc] : {std::pair{0, 1}, {1, 0}, {1, 1}, {1, -1}})
    if (fullAt(row + dr, column + dc) && fullAt(row - dr, column - dc)) return true;
  return false;
}

/// How much of a pixel that is covered in part counts as covered. Squares that stand for a curved surface
/// overlap here and leave gaps there: within it, where something is in all pixels around, as much as they
/// would cover all in all; and where that is nearly everything, or the pixel is in a seam, all.
float PointRaster::wholeOf(int face, int row, int column) const {
  const size_t pixel = at(face, row, column);
  const float covered = content_[pixel].covered;
  if (covered <= kThin) return covered;
  const int rows = rowsOf(face);
  float sum = 0;
  int count = 0;
  bool isWithin = true;
  for (int r = std::max(row - 1, 0); r <= std::min(row + 1, rows - 1); ++r)
    for (int c = std::max(column - 1, 0); c <= std::min(column + 1, resolution_ - 1); ++c, ++count) {
      const size_t k = at(face, r, c);
      sum += t_[k] < kInfinity ? 1 : content_[k].sum;
      isWithin = isWithin && (t_[k] < kInfinity || content_[k].covered > 0);
    }
  const float mean = sum / static_cast<float>(count);
  if (covered > kSeam && (isFull(pixel) || isBetweenFull(face, row, column) || mean > kAmong)) return 1;
  return isWithin ? std::max(covered, std::min(mean, 1.0f)) : covered;
}

uint32_t PointRaster::addPart(SurfelView::Kind kind, uint32_t index) {
  if (isViewed_) parts_.push_back({kind, index, 0, V3f(0)});
  return static_cast<uint32_t>(parts_.size()) - 1;
}

void PointRaster::add(const V3f& local, float area, const Rgb& radiance, bool isInner, SurfelView::Kind kind,
                      uint32_t index) {
  const float distance2 = local.length2();
  if (!(area > 0) || !(distance2 > nearest_ * nearest_)) return;
  const float distance = std::sqrt(distance2);
  const size_t shell = shellOf(distance);
  const V3f d = local / distance;
  const float toPixels = static_cast<float>(resolution_) / 2;
  const uint32_t part = addPart(kind, index);
  for (int face = 0; face < 5; ++face) {
    const auto& [axis, uAxis, vAxis] = axes_[static_cast<size_t>(face)];
    const float w = axis.dot(d);
    if (w < 0.5f) continue;  // farther than 55 degrees from the axis there is nothing of the face
    const float u = uAxis.dot(d) / w, v = vAxis.dot(d) / w;
    // On the plane at distance 1 a solid angle covers its share over the cube of the cosine.
    const float half = std::min(std::sqrt(area / distance2 / (w * w * w)) / 2, 1.0f);
    if (std::abs(u) >= 1 + half || v >= 1 + half || v <= (face == 0 ? -1 : 0) - half) continue;
    shells_[shell].items.push_back({distance, (u + 1) * toPixels, (face == 0 ? v + 1 : v) * toPixels,
                                    half * toPixels, static_cast<uint8_t>(face), isInner, part, radiance});
  }
}

/// Whether the side of a piece is an inner one that the place does not see.
bool PointRaster::isGap(Surfel::Inner inner, uint32_t owner, bool front) const {
  return owner != Surfel::kNobody && owner == outside_ &&
         inner == (front ? Surfel::Inner::Front : Surfel::Inner::Back);
}

void PointRaster::traceSurfel(const PointTree& tree, uint32_t index) {
  const Surfel& s = tree.surfels()[index];
  const V3f center = s.P - P_;
  const float slack = 0.005f * s.radius;
  bool front = s.N.dot(center) < 0;
  if (isGap(s.inner, s.owner, front)) front = !front || !s.hasBack;
  traced_.push_back({front ? s.front : s.back, center, nullptr,
                     addPart(front ? SurfelView::Kind::SurfelFront : SurfelView::Kind::SurfelBack, index)});
  Target target{s.N,
                s.U,
                s.N.cross(s.U),
                center,
                std::min(s.halfU, s.radius) + slack,
                std::min(s.halfV, s.radius) + slack,
                s.radius * s.radius,
                V3f(0),
                V3f(0),
                {}};
  if (!s.isTriangle()) {
    trace<Shape::Disc>(target);
    return;
  }
  const auto corners = s.corners();
  for (size_t k = 0; k < 3; ++k) {
    const V2f &from = corners[k], along = corners[(k + 1) % 3] - from;
    const float length = along.length();
    V2f out = length > 0 ? V2f(along.y, -along.x) / length : V2f(0);
    if (out.dot(from) < 0) out = -out;
    target.sides[k] = {out.x, out.y, out.dot(from) + slack};
  }
  trace<Shape::Triangle>(target);
}

void PointRaster::tracePlane(const PointTree& tree, uint32_t index, const PointTree::Node& node) {
  const PointTree::Plane& plane = tree.planes()[index];
  const V3f center = plane.center - P_;
  bool front = plane.N.dot(center) < 0;
  if (!front && plane.backArea == 0) return;
  if (isGap(node.inner, node.owner, front)) front = !front || plane.backArea == 0;
  traced_.push_back({front ? plane.front : plane.back, plane.P - P_,
                     front ? &plane.frontSlope : &plane.backSlope,
                     addPart(front ? SurfelView::Kind::PlaneFront : SurfelView::Kind::PlaneBack, index)});
  trace<Shape::Boxed>({plane.N,
                       plane.U,
                       plane.V,
                       center,
                       plane.halfU + plane.slack,
                       plane.halfV + plane.slack,
                       kInfinity,
                       plane.box.center() - P_,
                       plane.box.size() / 2 + V3f(plane.slack),
                       {}});
}

/// Pieces around the place, of the surface that it is on: where that bends away they do not stand above it,
/// but discs in their place would. Where it is hollow they are seen.
bool PointRaster::isOwn(const Surfel& s, float distance2, float height) const {
  const float cosine = frame_.z.dot(s.N);
  const float above = cosine > 0 ? height : -height;  // of the place over the piece
  return distance2 < kOwnReach * kOwnReach * s.radius * s.radius && above < kHollow * s.radius &&
         above > -kOwnHeight * s.radius - s.thickness &&
         std::abs(cosine) > (s.thickness > 0 ? kRoughCosine : kOwnCosine);
}

/// Of a place in the raster's frame: along a face's axis, u and v, which are those of the raster or their
/// opposites.
template <int kFace>
V3f PointRaster::onFace(const V3f& p) {
  if constexpr (kFace == 0)
    return {p.z, p.x, p.y};
  else if constexpr (kFace == 1)
    return p;
  else if constexpr (kFace == 2)
    return {p.y, -p.x, p.z};
  else if constexpr (kFace == 3)
    return {-p.x, -p.y, p.z};
  else
    return {-p.y, p.x, p.z};
}

template <int kFace>
PointRaster::Pixels PointRaster::pixelsOf(const LocalRectangle& rectangle) const {
  constexpr int face = kFace;
  const V3f c = onFace<face>(rectangle.center), reach = onFace<face>(rectangle.reach);
  const float w = c.x, u = c.y, v = c.z;
  const float dw = std::abs(reach.x), du = std::abs(reach.y), dv = std::abs(reach.z);
  const float farthest = w + dw, closest = w - dw, bottom = face == 0 ? 1 : 0;
  // Behind the place, or outside of one of the planes through it and an edge of the face.
  if (farthest <= 0 || std::abs(u) - du > farthest || v - dv > farthest || v + dv < -bottom * farthest)
    return {};
  float u0 = kInfinity, u1 = -kInfinity, v0 = kInfinity, v1 = -kInfinity;
  constexpr float kNear = 1e-4f;
  if (closest > kNear * farthest) {
    const V3f x = onFace<face>(rectangle.a), y = onFace<face>(rectangle.b);
    for (int k = 0; k < 4; ++k) {
      const float i = k & 1 ? 1 : -1, j = k & 2 ? 1 : -1;
      const float scale = 1 / (w + i * x.x + j * y.x);
      const float cu = (u + i * x.y + j * y.y) * scale, cv = (v + i * x.z + j * y.z) * scale;
      u0 = std::min(u0, cu), u1 = std::max(u1, cu), v0 = std::min(v0, cv), v1 = std::max(v1, cv);
    }
  } else {  // parts are beside the place: of what is on one side the slope is at least that at the far end
    u0 = u - du > 0 ? (u - du) / farthest : -1, u1 = u + du < 0 ? (u + du) / farthest : 1;
    v0 = v - dv > 0 ? (v - dv) / farthest : -1, v1 = v + dv < 0 ? (v + dv) / farthest : 1;
  }
  const int rows = rowsOf(face);
  const float toPixels = static_cast<float>(resolution_) / 2;
  // Centres of pixels are what rays go through; a thousandth of a pixel is more than rounding.
  constexpr float kRounding = 1e-3f;
  const auto from = [&](float at, int most) {
    return static_cast<int>(
        std::clamp(std::ceil(at * toPixels - 0.5f - kRounding), 0.0f, static_cast<float>(most)));
  };
  const auto to = [&](float at, int most) {
    return static_cast<int>(
        std::clamp(std::floor(at * toPixels + 0.5f + kRounding), 0.0f, static_cast<float>(most)));
  };
  return {from(u0 + 1, resolution_), to(u1 + 1, resolution_), from(v0 + bottom, rows), to(v1 + bottom, rows)};
}

template <PointRaster::Shape kShape>
void PointRaster::trace(const Target& target) {
  const auto id = static_cast<int32_t>(traced_.size() - 1);
  const auto [nx, ny, nz] = std::array{target.N.x, target.N.y, target.N.z};
  const auto [ux, uy, uz] = std::array{target.U.x, target.U.y, target.U.z};
  const auto [vx, vy, vz] = std::array{target.V.x, target.V.y, target.V.z};
  const auto [cx, cy, cz] = std::array{target.boxCenter.x, target.boxCenter.y, target.boxCenter.z};
  const auto [hx, hy, hz] = std::array{target.half.x, target.half.y, target.half.z};
  const auto [ax, ay, az] = std::array{target.sides[0].x, target.sides[0].y, target.sides[0].z};
  const auto [bx, by, bz] = std::array{target.sides[1].x, target.sides[1].y, target.sides[1].z};
  const auto [ox, oy, oz] = std::array{target.sides[2].x, target.sides[2].y, target.sides[2].z};
  const float plane = target.N.dot(target.center), cu = target.U.dot(target.center),
              cv = target.V.dot(target.center), hu = target.halfU, hv = target.halfV;
  const float radius2 = target.radius2, nearest = nearest_;
  LocalRectangle rectangle{frame_.toLocal(target.center), frame_.toLocal(target.U * target.halfU),
                           frame_.toLocal(target.V * target.halfV), V3f(0)};
  rectangle.reach = abs(rectangle.a) + abs(rectangle.b);
  const auto traceOn = [&](int face, const Pixels& pixels) {
    if (pixels.column0 >= pixels.column1) return;
    for (int row = pixels.row0; row < pixels.row1; ++row)
      for (int column = pixels.column0 / kLanes * kLanes; column < pixels.column1; column += kLanes) {
        const size_t first = at(face, row, column);
        const float *dx = &dx_[first], *dy = &dy_[first], *dz = &dz_[first];
        float* t = &t_[first];
        int32_t* met = &met_[first];
#pragma GCC ivdep
        for (int k = 0; k < kLanes; ++k) {
          const float along = plane / (nx * dx[k] + ny * dy[k] + nz * dz[k]);
          const float u = (ux * dx[k] + uy * dy[k] + uz * dz[k]) * along - cu,
                      v = (vx * dx[k] + vy * dy[k] + vz * dz[k]) * along - cv;
          bool isMet = (along > nearest) & (along < t[k]) & (std::abs(u) <= hu) & (std::abs(v) <= hv);
          if constexpr (kShape == Shape::Boxed)
            isMet = isMet & (std::abs(dx[k] * along - cx) <= hx) & (std::abs(dy[k] * along - cy) <= hy) &
                    (std::abs(dz[k] * along - cz) <= hz);
          else if constexpr (kShape == Shape::Triangle)
            isMet = isMet & (u * ax + v * ay <= az) & (u * bx + v * by <= bz) & (u * ox + v * oy <= oz);
          else
            isMet = isMet & (u * u + v * v <= radius2);
          t[k] = isMet ? along : t[k];
          met[k] = isMet ? id : met[k];
        }
      }
  };
  traceOn(0, pixelsOf<0>(rectangle)), traceOn(1, pixelsOf<1>(rectangle)), traceOn(2, pixelsOf<2>(rectangle)),
      traceOn(3, pixelsOf<3>(rectangle)), traceOn(4, pixelsOf<4>(rectangle));
}

/// Covers what the square covers of each pixel, as far as that is not covered yet nor stands behind what the
/// pixel's ray meets.
void PointRaster::draw(const Item& item) {
  const int rows = rowsOf(item.face);
  const float x = item.x, y = item.y;
  const float thickness = kLayer * (item.half + 1) * item.distance * 2 / static_cast<float>(resolution_);
  const int x0 = std::max(0, static_cast<int>(std::floor(x - item.half))),
            x1 = std::min(resolution_, static_cast<int>(std::floor(x + item.half)) + 1),
            y0 = std::max(0, static_cast<int>(std::floor(y - item.half))),
            y1 = std::min(rows, static_cast<int>(std::floor(y + item.half)) + 1);
  for (int j = y0; j < y1; ++j) {
    const float across =
        std::min(y + item.half, static_cast<float>(j + 1)) - std::max(y - item.half, static_cast<float>(j));
    for (int i = x0; i < x1; ++i) {
      const float along =
          std::min(x + item.half, static_cast<float>(i + 1)) - std::max(x - item.half, static_cast<float>(i));
      const size_t k = at(item.face, j, i);
      Content& c = content_[k];
      if (item.distance >= t_[k]) continue;
      float share = std::max(along, 0.0f) * std::max(across, 0.0f);
      if (c.covered == 0) c.layer = item.distance, c.startsOutside = !item.isInner;
      // The far side of what is closed is behind the near one, not beside it.
      if (item.isInner && c.startsOutside) continue;
      const float open = 1 - c.covered;
      if (item.distance > c.layer + thickness)
        share *= open;
      else
        c.sum += share, share = std::min(share, open);
      if (!(share > 0)) continue;
      if (isViewed_) drawn_.push_back({item.part, static_cast<uint32_t>(k), share});
      c.covered += share;
      c.inverse += share / item.distance;
      c.radiance += item.radiance * share;
    }
  }
}

}  // namespace patina
