// SPDX-License-Identifier: Apache-2.0
// Camera rays between the near and far planes, and ClippingPlane's.
#include <gtest/gtest.h>

#include <random>

#include "renderer/geometry/raster_camera.h"

namespace patina {
namespace {

Camera cameraOf(bool perspective, double scale) {
  Camera camera;
  camera.perspective = perspective;
  camera.fov = 70;
  camera.nearPlane = 0.5f, camera.farPlane = 30;
  M44d turn, grow, move;
  turn.setAxisAngle(V3d(1, 2, -1).normalized(), 0.7);
  grow.setScale(V3d(-scale, scale, 1.5 * scale));
  move.setTranslation(V3d(3, -2, 8));
  camera.worldToCamera = turn * grow * move;
  return camera;
}

/// Visits rays of a camera with the camera-space z of their ends, and what they are at in camera space.
template <class Visit>
void forRays(const Camera& camera, Visit visit) {
  const RasterCamera raster(camera, Options());
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (int k = 0; k < 500; ++k) {
    const RasterCamera::Ray ray =
        raster.ray(640 * uniform(random), 480 * uniform(random), {uniform(random), uniform(random)});
    const auto at = [&](float t) { return V3d(ray.origin + ray.direction * t) * camera.worldToCamera; };
    visit(ray, at);
  }
}

TEST(CameraRays, BeginAndEndAtTheNearAndFarPlanes) {
  for (const bool perspective : {true, false})
    for (const double scale : {1.0, 0.01, 40.0})
      for (const float fStop : {kInfinity, 4.0f}) {
        Camera camera = cameraOf(perspective, scale);
        camera.fStop = fStop, camera.focalLength = 1, camera.focalDistance = 5;
        forRays(camera, [&](const RasterCamera::Ray& ray, const auto& at) {
          EXPECT_NEAR(at(ray.tNear).z, 0.5, 1e-4);
          EXPECT_NEAR(at(ray.tFar).z, 30, 1e-3);
        });
      }
}

TEST(CameraRays, EndWhereClippingPlanesCutThem) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const bool perspective : {true, false})
    for (int trial = 0; trial < 20; ++trial) {
      Camera camera = cameraOf(perspective, 2);
      for (int k = 0; k < 3; ++k)
        camera.clippingPlanes.push_back(
            {V3d(uniform(random), uniform(random), uniform(random)).normalized(), 10 * uniform(random)});
      forRays(camera, [&](const RasterCamera::Ray& ray, const auto& at) {
        const auto kept = [&](const V3d& p) {
          double beyond = std::max(0.5 - p.z, p.z - 30);
          for (const ClippingPlane& plane : camera.clippingPlanes)
            beyond = std::max(beyond, plane.normal.dot(p) - plane.offset);
          return beyond;  // < 0: seen
        };
        for (int k = 0; k <= 40; ++k) {
          const float t = 20 * static_cast<float>(k) / 40;
          const double beyond = kept(at(t));
          if (std::abs(beyond) <= 1e-4) continue;
          EXPECT_EQ(beyond<0, t> ray.tNear && t < ray.tFar) << beyond;
        }
      });
    }
}

TEST(CameraRays, AlongAPlaneAreSeenWholeOrNotAtAll) {
  for (const double offset : {-1.0, 1.0}) {
    Camera camera;
    camera.perspective = false;
    camera.clippingPlanes = {{V3d(1, 0, 0), 2 * offset}};
    forRays(camera,
            [&](const RasterCamera::Ray& ray, const auto&) { EXPECT_EQ(ray.tNear<ray.tFar, offset> 0); });
  }
}

}  // namespace
}  // namespace patina
