// SPDX-License-Identifier: Apache-2.0
// RI's camera (RI 3.2 section 4.1): screen window, field of view, depth of field.
#include "renderer/geometry/raster_camera.h"

#include "renderer/base/sampling.h"

namespace patina {

RasterCamera::RasterCamera(const Camera& camera, const Options& options)
    : camera_(camera),
      xResolution_(options.xResolution),
      yResolution_(options.yResolution),
      worldToCamera_(camera.worldToCamera) {
  const double determinant = camera.worldToCamera.determinant();
  singular_ = !(std::abs(determinant) > 0) || !std::isfinite(determinant);
  cameraToWorld_ = singular_ ? M44d() : camera.worldToCamera.inverse();
  cameraScale_ = singular_ ? 1.0f : static_cast<float>(std::cbrt(std::abs(determinant)));
  eye_ = V3f(V3d(0, 0, 0) * cameraToWorld_);
  tanHalf_ = camera.perspective ? std::tan(camera.fov * kPi / 360) : 1;
  left_ = camera.screenWindow[0];
  bottom_ = camera.screenWindow[2];
  width_ = camera.screenWindow[1] - camera.screenWindow[0];
  height_ = camera.screenWindow[3] - camera.screenWindow[2];
  const float perUnitX = static_cast<float>(xResolution_) / (std::abs(width_) * tanHalf_);
  const float perUnitY = static_cast<float>(yResolution_) / (std::abs(height_) * tanHalf_);
  focalPixels_ = std::sqrt(perUnitX * perUnitY);
  if (camera.perspective) {
    const float x = std::max(std::abs(left_), std::abs(left_ + width_)) * tanHalf_;
    const float y = std::max(std::abs(bottom_), std::abs(bottom_ + height_)) * tanHalf_;
    cosCorner_ = 1 / std::sqrt(1 + x * x + y * y);
  }
  if (std::isfinite(camera.fStop) && camera.fStop > 0) lensRadius_ = camera.focalLength / camera.fStop / 2;
  const double open = static_cast<double>(camera.shutterOpen),
               close = static_cast<double>(camera.shutterClose);
  if (singular_ || !camera.motion || !camera.motion->movesWithin(open, close)) return;
  constexpr int kPlaces = 8;
  for (int k = 1; k <= kPlaces; ++k) {
    const M44d place = camera.motion->at(open + (close - open) * k / kPlaces);
    laterPlaces_.emplace_back(place);
    laterEyes_.emplace_back(V3d(0, 0, 0) * place.inverse());
  }
}

RasterCamera::Ray RasterCamera::ray(float x, float y, const V2f& lens, float time) const {
  M44d later;
  if (time > 0 && moves()) {
    const double open = static_cast<double>(camera_.shutterOpen),
                 close = static_cast<double>(camera_.shutterClose);
    later = camera_.motion->at(open + (close - open) * static_cast<double>(time)).inverse();
  }
  const M44d& cameraToWorld = time > 0 && moves() ? later : cameraToWorld_;
  const double sx = (static_cast<double>(left_) + static_cast<double>(width_) * x / xResolution_) * tanHalf_;
  const double sy = (static_cast<double>(bottom_) +
                     static_cast<double>(height_) * (1 - static_cast<double>(y) / yResolution_)) *
                    tanHalf_;
  V3d origin(0, 0, 0), direction(sx, sy, 1);
  if (!camera_.perspective) {
    origin = V3d(sx, sy, 0);
    direction = V3d(0, 0, 1);
  }
  // Depth of field: rays through a point of the plane of focus from a point of the lens (PBR section 5.2.3).
  if (lensRadius_ > 0) {
    const V2f d = sampleDisk(lens);
    const V3d focus = origin + direction * static_cast<double>(camera_.focalDistance);
    origin += V3d(d.x, d.y, 0) * static_cast<double>(lensRadius_);
    direction = focus - origin;
    direction /= direction.z;
  }
  // From here `direction` gains one unit of camera z per unit of its length parameter.
  Ray ray;
  const V3d worldOrigin = origin * cameraToWorld;
  V3d worldDirection;
  cameraToWorld.multDirMatrix(direction, worldDirection);
  const double length = worldDirection.length();
  ray.origin = V3f(worldOrigin);
  ray.direction = V3f(worldDirection / length);
  const double nearZ = camera_.nearPlane, farZ = std::min(static_cast<double>(camera_.farPlane), 1e30);
  ray.tNear = static_cast<float>(nearZ * length);
  ray.tFar = static_cast<float>(std::min(farZ * length, 1e30));
  for (const ClippingPlane& plane : camera_.clippingPlanes) {
    const double beyond = plane.normal.dot(origin) - plane.offset, gained = plane.normal.dot(direction);
    const auto t = static_cast<float>(std::clamp(-beyond / gained * length, -1e30, 1e30));
    if (gained > 0)
      ray.tFar = std::min(ray.tFar, t);
    else if (gained < 0)
      ray.tNear = std::max(ray.tNear, t);
    else if (beyond > 0)
      ray.tFar = -1;  // all of it is cut off
  }
  ray.depthPerT = static_cast<float>(1 / length);
  ray.originDepth = static_cast<float>(origin.z);
  const float pixel = 1 / (focalPixels_ * cameraScale_);
  ray.footprintAtOrigin = camera_.perspective ? 0 : pixel;
  // The solid angle of a pixel falls with the third power of the cosine.
  const auto cosine = static_cast<float>(1 / direction.length());
  ray.footprintSpread = camera_.perspective ? cosine * std::sqrt(cosine) / focalPixels_ : 0;
  return ray;
}

V3f RasterCamera::viewDirection() const {
  V3d direction;
  cameraToWorld_.multDirMatrix(V3d(0, 0, 1), direction);
  return V3f(direction.normalized());
}

float RasterCamera::pixelsPerUnit(float distance) const {
  return camera_.perspective ? focalPixels_ / distance : focalPixels_ * cameraScale_;
}

float RasterCamera::pixelsPerUnit(const V3f& center, float radius) const {
  const float distance = std::max({nearestDistance(center, radius), 0.25f * radius, 1e-30f});
  return pixelsPerUnit(distance) * stretch(center, radius);
}

/// Lengths across a ray at an angle a from the axis grow by 1 / cos a in one direction and 1 / cos^2 a in the
/// other.
float RasterCamera::stretch(const V3f& center, float radius) const {
  if (!camera_.perspective) return 1;
  float cosine = cosCorner_;
  const V3f c = toCamera(center);
  const float length = c.length(), sine = radius * cameraScale_ / length;  // of the ball's half angle
  if (sine < 1) {
    const float toMiddle = c.z / length;
    const float even = toMiddle * std::sqrt(1 - sine * sine);
    const float odd = std::sqrt(std::max(0.0f, 1 - toMiddle * toMiddle)) * sine;
    if (even + odd < cosCorner_) return 1;  // nothing of it is in the picture
    cosine = std::clamp(even - odd, cosCorner_, 1.0f);
  }
  return 1 / (cosine * std::sqrt(cosine));
}

V2f RasterCamera::toRaster(const V3f& camera) const {
  const float scale = camera_.perspective ? 1 / (camera.z * tanHalf_) : 1;
  return {static_cast<float>(xResolution_) * (camera.x * scale - left_) / width_,
          static_cast<float>(yResolution_) * (1 - (camera.y * scale - bottom_) / height_)};
}

float RasterCamera::nearestDistance(const V3f& center, float radius) const {
  float distance = (center - eye_).length();
  for (const V3f& eye : laterEyes_) distance = std::min(distance, (center - eye).length());
  return std::max(0.0f, distance - radius);
}

bool RasterCamera::mayBeVisible(const V3f& center, float radius, float margin) const {
  return mayBeVisible(center, radius, margin, worldToCamera_) ||
         std::any_of(laterPlaces_.begin(), laterPlaces_.end(),
                     [&](const M44f& place) { return mayBeVisible(center, radius, margin, place); });
}

bool RasterCamera::mayBeVisible(const V3f& center, float radius, float margin,
                                const M44f& worldToCamera) const {
  const V3f c = transformPoint(center, worldToCamera);
  const float r = radius * cameraScale_ * 1.0001f;
  if (c.z + r < camera_.nearPlane || c.z - r > camera_.farPlane) return false;
  const float mx = margin * std::abs(width_) / static_cast<float>(xResolution_);
  const float my = margin * std::abs(height_) / static_cast<float>(yResolution_);
  const float x0 = std::min(left_, left_ + width_) - mx, x1 = std::max(left_, left_ + width_) + mx;
  const float y0 = std::min(bottom_, bottom_ + height_) - my, y1 = std::max(bottom_, bottom_ + height_) + my;
  if (!camera_.perspective) return c.x + r >= x0 && c.x - r <= x1 && c.y + r >= y0 && c.y - r <= y1;
  // Distances to the four side planes, which pass through the eye.
  const auto outside = [&](float position, float slope, float sign) {
    return sign * (position - slope * tanHalf_ * c.z) >
           r * std::sqrt(1 + slope * slope * tanHalf_ * tanHalf_);
  };
  return !(outside(c.x, x0, -1) || outside(c.x, x1, 1) || outside(c.y, y0, -1) || outside(c.y, y1, 1));
}

}  // namespace patina
