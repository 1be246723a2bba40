// SPDX-License-Identifier: Apache-2.0
// The raster and the camera in force.
#include "renderer/scene/camera.h"

namespace patina {

void resolveFrame(Options& options, Camera& camera) {
  const double pixelAspect = options.pixelAspect;
  double aspect = options.xResolution * pixelAspect / options.yResolution;
  if (options.frameAspect) {
    const double wanted = *options.frameAspect;
    if (wanted < aspect) {
      options.xResolution =
          std::max(1, static_cast<int>(std::lround(options.yResolution * wanted / pixelAspect)));
    } else if (wanted > aspect) {
      options.yResolution =
          std::max(1, static_cast<int>(std::lround(options.xResolution * pixelAspect / wanted)));
    }
    aspect = wanted;
  }
  const float wide = static_cast<float>(std::max(aspect, 1.0));
  const float high = static_cast<float>(std::max(1 / aspect, 1.0));
  camera.screenWindow = options.screenWindow.value_or(std::array<float, 4>{-wide, wide, -high, high});
}

M44d cameraToScreen(const Camera& camera) {
  // Far planes as far as RI_INFINITY leave 1 in the quotient.
  const double nearPlane = camera.nearPlane;
  const double farPlane = camera.farPlane;
  const double depth = 1 / (farPlane - nearPlane);
  if (!camera.perspective) return {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, depth, 0, 0, 0, -nearPlane * depth, 1};
  const double c = 1 / std::tan(static_cast<double>(camera.fov) * std::numbers::pi / 360);
  const double k = farPlane * depth;
  return {c, 0, 0, 0, 0, c, 0, 0, 0, 0, k, 1, 0, 0, -nearPlane * k, 0};
}

M44d worldToNormalizedScreen(const Camera& camera) {
  const auto [left, right, bottom, top] = camera.screenWindow;
  const double w = 2.0 / (right - left);
  const double h = 2.0 / (top - bottom);
  const M44d window(w, 0, 0, 0, 0, h, 0, 0, 0, 0, 1, 0, -(left + right) * w / 2, -(bottom + top) * h / 2, 0,
                    1);
  return camera.worldToCamera * cameraToScreen(camera) * window;
}

float rasterArea(const std::array<float, 6>& bound, const M44d& boundToWorld, const Options& options,
                 const Camera& camera) {
  const M44d toScreen = boundToWorld * worldToNormalizedScreen(camera);
  Imath::Box<Imath::V2d> box;
  for (unsigned corner = 0; corner < 8; ++corner) {
    const double x = bound[corner & 1], y = bound[2 + (corner >> 1 & 1)], z = bound[4 + (corner >> 2 & 1)];
    const double w = x * toScreen[0][3] + y * toScreen[1][3] + z * toScreen[2][3] + toScreen[3][3];
    if (!(w > 0)) return kInfinity;
    const double sx = x * toScreen[0][0] + y * toScreen[1][0] + z * toScreen[2][0] + toScreen[3][0];
    const double sy = x * toScreen[0][1] + y * toScreen[1][1] + z * toScreen[2][1] + toScreen[3][1];
    box.extendBy(Imath::V2d(sx / w, sy / w));
  }
  const Imath::V2d size = box.size();
  return static_cast<float>(size.x * size.y / 4 * options.xResolution * options.yResolution);
}

}  // namespace patina
