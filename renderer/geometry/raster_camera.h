// SPDX-License-Identifier: Apache-2.0
// The camera as geometry sees it: how many pixels a length covers, and where points fall on the raster.
#pragma once

#include "renderer/scene/scene.h"

namespace patina {

/// Maps world space to raster space: x right, y down, one unit per pixel, pixel (i, j) covering [i, i+1) x
/// [j, j+1).
class RasterCamera {
 public:
  RasterCamera(const Camera& camera, const Options& options);

  int xResolution() const { return xResolution_; }
  int yResolution() const { return yResolution_; }
  const V3f& eye() const { return eye_; }
  V3f viewDirection() const;  ///< unit, world space
  const M44d& worldToCamera() const { return camera_.worldToCamera; }
  bool singular() const { return singular_; }  ///< worldToCamera has no inverse: nothing can be rendered

  /// A camera ray in world space: unit direction; `t` runs from tNear to tFar, which clipping may put before
  /// tNear: then there is nothing to be seen. `lens` is in [0,1)^2 and is
  /// used with depth of field only.
  struct Ray {
    V3f origin, direction;
    float tNear, tFar;
    float footprintAtOrigin;  ///< width of a pixel at t = 0, world units
    float footprintSpread;    ///< growth of that width per unit of t
    float depthPerT;          ///< camera-space z gained per unit of t
    float originDepth;        ///< camera-space z of the origin
  };
  /// `time` runs from 0, the opening of the shutter, to 1, its closing; it says where a moving camera is.
  Ray ray(float x, float y, const V2f& lens, float time = 0) const;

  /// The camera moves while the shutter is open. All else that is said here is then said of its opening, but
  /// for nearestDistance() and mayBeVisible(), which look at the whole of it.
  bool moves() const { return !laterEyes_.empty(); }

  /// Pixels per world unit for a length across the view at camera distance `distance` (perspective) from the
  /// eye, on the axis.
  float pixelsPerUnit(float distance) const;
  /// The same for a ball in world space, where it is nearest, and with the most that the part of it in the
  /// picture is stretched off the axis (mean of both directions). A quarter of the radius is the least
  /// distance.
  float pixelsPerUnit(const V3f& center, float radius) const;
  float pixelCount() const {  ///< of the whole picture
    return static_cast<float>(xResolution_) * static_cast<float>(yResolution_);
  }

  V3f toCamera(const V3f& world) const { return transformPoint(world, worldToCamera_); }
  /// Raster position of a point in camera space; its z must be positive for perspective.
  V2f toRaster(const V3f& camera) const;

  /// Whether a sphere in world space may be inside the view volume widened by `margin` pixels.
  bool mayBeVisible(const V3f& center, float radius, float margin) const;
  /// Distance from the eye (perspective) to the nearest point of a sphere; 0 when the eye is inside.
  float nearestDistance(const V3f& center, float radius) const;
  bool perspective() const { return camera_.perspective; }
  float nearPlane() const { return camera_.nearPlane; }

 private:
  bool mayBeVisible(const V3f& center, float radius, float margin, const M44f& worldToCamera) const;
  float stretch(const V3f& center, float radius) const;

  Camera camera_;
  int xResolution_, yResolution_;
  M44f worldToCamera_;
  M44d cameraToWorld_;
  V3f eye_;
  std::vector<V3f> laterEyes_;     // of a moving camera, at times behind the opening
  std::vector<M44f> laterPlaces_;  // worldToCamera at the same times
  float tanHalf_;                  // half the unit screen window at z = 1 (1 for orthographic)
  float left_, bottom_;            // screen window
  float width_, height_;           // of the screen window
  float focalPixels_;              // pixels per unit at z = 1 (orthographic: per unit)
  float lensRadius_ = 0;
  float cosCorner_ = 1;    // of the angle between the axis and the farthest corner; perspective
  float cameraScale_ = 1;  // world units to camera units, geometric mean
  bool singular_ = false;
};

}  // namespace patina
