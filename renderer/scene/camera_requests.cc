// SPDX-License-Identifier: Apache-2.0
// Options of the camera: Format to Shutter.
#include <fmt/format.h>

#include <algorithm>

#include "renderer/scene/matrices.h"
#include "renderer/scene/scene_builder.h"

namespace patina {
namespace {

constexpr int kLargestResolution = 1 << 16;  // pixels along a side

}  // namespace

void SceneBuilder::format(int xResolution, int yResolution, float pixelAspect, const Location& at) {
  const Options defaults;
  if (xResolution > kLargestResolution || yResolution > kLargestResolution) {
    return error(RiError::LimitCheck, at,
                 fmt::format("Format {} {}: at most {} pixels along a side", xResolution, yResolution,
                             kLargestResolution));
  }
  // RI: what is not positive stands for the display's own.
  options_.xResolution = xResolution > 0 ? xResolution : defaults.xResolution;
  options_.yResolution = yResolution > 0 ? yResolution : defaults.yResolution;
  if (pixelAspect > 0 && !(pixelAspect >= 1e-3f && pixelAspect <= 1e3f)) {
    return error(RiError::Range, at,
                 fmt::format("Format: pixel aspect {} is not between 0.001 and 1000", pixelAspect));
  }
  options_.pixelAspect = pixelAspect > 0 ? pixelAspect : 1;
}

void SceneBuilder::frameAspectRatio(float aspect, const Location& at) {
  if (!(aspect >= 1e-3f && aspect <= 1e3f)) {
    return error(RiError::Range, at, fmt::format("FrameAspectRatio {}: expected 0.001 to 1000", aspect));
  }
  options_.frameAspect = aspect;
}

void SceneBuilder::screenWindow(float left, float right, float bottom, float top, const Location& at) {
  const float width = right - left, height = top - bottom;
  if (!std::isfinite(width) || !std::isfinite(height) || width == 0 || height == 0) {
    return error(RiError::Range, at,
                 fmt::format("ScreenWindow {} {} {} {}: expected left < right and bottom < top", left, right,
                             bottom, top));
  }
  options_.screenWindow = {left, right, bottom, top};
}

void SceneBuilder::cropWindow(float xmin, float xmax, float ymin, float ymax, const Location& at) {
  const auto inOrder = [](float low, float high) { return low >= 0 && low <= high && high <= 1; };
  if (!inOrder(xmin, xmax) || !inOrder(ymin, ymax)) {
    return error(RiError::Range, at,
                 fmt::format("CropWindow {} {} {} {}: expected 0 <= xmin <= xmax <= 1 and the same for y",
                             xmin, xmax, ymin, ymax));
  }
  options_.crop = {xmin, xmax, ymin, ymax};
}

void SceneBuilder::projection(std::string_view name, const ParamList& params, const Location& at) {
  if (inWorld()) return error(RiError::IllState, at, "Projection inside the world block is ignored");
  if (state_.ctm != M44d()) {
    warning(RiError::Unimplemented, at, "transformations before Projection (in screen space) are ignored");
    state_.ctm = M44d();
    state_.moving = {};
  }
  static constexpr std::string_view kKnown[] = {"fov"};
  if (name == "perspective" || name == "PxrPerspective" || name == "PxrCamera") {
    const float fov = params.floatValue("fov", 90);
    if (!(fov > 0 && fov < 180)) {
      return error(RiError::Range, at,
                   fmt::format("Projection: fov {} is not between 0 and 180 degrees", fov));
    }
    camera_.perspective = true;
    camera_.fov = fov;
  } else if (name == "orthographic" || name == "PxrOrthographic") {
    camera_.perspective = false;
  } else if (name.empty() || name == "null") {
    camera_.perspective = false;
  } else {
    warning(RiError::BadToken, at,
            fmt::format(
                "Projection \"{}\" is unknown (expected perspective or orthographic): \"{}\" stays in force",
                name, camera_.perspective ? "perspective" : "orthographic"));
    for (const Param& param : params) param.used = true;
  }
  params.reportUnread(errors_, "Projection", kKnown);
}

void SceneBuilder::clipping(float near, float far, const Location& at) {
  if (!(far > near) || !(far > 0) || !std::isfinite(near)) {
    return error(RiError::Range, at, fmt::format("Clipping {} {}: expected 0 < near < far", near, far));
  }
  camera_.nearPlane = std::max(near, 1e-10f);  // RI_EPSILON
  camera_.farPlane = std::min(far, 1e38f);     // RI_INFINITY
}

void SceneBuilder::clippingPlane(const std::array<float, 6>& v, const Location& at) {
  if (inWorld()) return error(RiError::IllState, at, "ClippingPlane inside the world block is ignored");
  const V3d point(v[0], v[1], v[2]), normal(v[3], v[4], v[5]);
  if (!std::ranges::all_of(v, [](float x) { return std::isfinite(x); }) || normal == V3d(0, 0, 0))
    return error(RiError::Range, at,
                 "ClippingPlane: expected a point and a normal that is not 0, both finite");
  // The current space is on its way to the camera; normals go there by the inverse, transposed.
  const auto toCurrent = inverted(state_.ctm);
  if (!toCurrent || !isAffine(state_.ctm))
    return error(RiError::Math, at,
                 "ClippingPlane under a transformation that has no inverse, or a perspective one");
  V3d inCamera;
  toCurrent->transposed().multDirMatrix(normal, inCamera);
  inCamera.normalize();
  camera_.clippingPlanes.push_back({inCamera, inCamera.dot(point * state_.ctm)});
}

void SceneBuilder::depthOfField(float fStop, float focalLength, float focalDistance, const Location& at) {
  if (!(fStop > 0))
    return error(RiError::Range, at, fmt::format("DepthOfField: f-stop {} is not positive", fStop));
  if (fStop >= 1e37f) {
    camera_.fStop = kInfinity;
    return;
  }
  if (!(focalLength > 0) || !(focalDistance > 0)) {
    return error(RiError::Range, at,
                 fmt::format("DepthOfField {} {} {}: focal length and distance must be positive", fStop,
                             focalLength, focalDistance));
  }
  camera_.fStop = fStop;
  camera_.focalLength = focalLength;
  camera_.focalDistance = focalDistance;
}

void SceneBuilder::shutter(float open, float close, const Location& at) {
  if (!(close >= open)) {
    return error(RiError::Range, at, fmt::format("Shutter {} {}: expected opening <= closing", open, close));
  }
  camera_.shutterOpen = open;
  camera_.shutterClose = close;
  if (state_.moving.outer) state_.ctm = state_.moving.at(static_cast<double>(open));
}

}  // namespace patina
