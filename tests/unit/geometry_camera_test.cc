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

/// A view of 178 degrees, and points all over its raster at a distance of 3.
template <class Visit>
void inAWideView(Visit visit) {
  Camera camera;
  camera.perspective = true;
  camera.fov = 178;
  M44d turn;
  turn.setAxisAngle(V3d(1, 2, -1).normalized(), 0.7);
  camera.worldToCamera = turn;
  Options options;
  options.xResolution = 400, options.yResolution = 300;
  const RasterCamera raster(camera, options);
  for (const float x : {200.0f, 201.0f, 230.0f, 20.0f, 398.0f})
    for (const float y : {150.0f, 150.5f, 260.0f, 2.0f}) visit(raster, x, y);
}

// The width of a camera ray is that of a square with the solid angle of its pixel.
TEST(CameraRays, AreAsWideAsTheirPixelsAllOverAWideView) {
  inAWideView([](const RasterCamera& camera, float x, float y) {
    const auto direction = [&](float px, float py) { return V3d(camera.ray(px, py, {0, 0}).direction); };
    const V3d across = (direction(x + 0.5f, y) - direction(x - 0.5f, y)),
              along = (direction(x, y + 0.5f) - direction(x, y - 0.5f));
    const double solidAngle = across.cross(along).length();
    const double spread = static_cast<double>(camera.ray(x, y, {0, 0}).footprintSpread);
    EXPECT_NEAR(spread * spread, solidAngle, 0.03 * solidAngle) << x << ' ' << y;
  });
}

// Lengths near a point cover as many pixels, as a mean of both directions, as pixelsPerUnit says; a ball that
// the eye is in is taken at the corner, and what is outside of the picture is not stretched.
TEST(CameraRays, LengthsAreStretchedOffTheAxis) {
  inAWideView([](const RasterCamera& camera, float x, float y) {
    const RasterCamera::Ray ray = camera.ray(x, y, {0, 0});
    const V3f p = ray.origin + ray.direction * 3;
    const V3f any = std::abs(ray.direction.x) < 0.7f ? V3f(1, 0, 0) : V3f(0, 1, 0);
    const V3f u = ray.direction.cross(any).normalized(), v = ray.direction.cross(u);
    const float step = 1e-3f * camera.toCamera(p).z;
    const auto move = [&](const V3f& d) {
      return (camera.toRaster(camera.toCamera(p + d * step)) -
              camera.toRaster(camera.toCamera(p - d * step))) /
             (2 * step);
    };
    const float expected = std::sqrt(std::abs(move(u).cross(move(v))));
    EXPECT_NEAR(camera.pixelsPerUnit(p, 0), expected, 0.02f * expected) << x << ' ' << y;
    EXPECT_GE(camera.pixelsPerUnit(p, 0.1f), camera.pixelsPerUnit(p, 0) * 0.999f);
    EXPECT_GT(camera.pixelsPerUnit(camera.eye(), 3), camera.pixelsPerUnit(p, 0));
    EXPECT_FLOAT_EQ(camera.pixelsPerUnit(-p, 0), camera.pixelsPerUnit(3)) << "behind the eye";
  });
}

}  // namespace
}  // namespace patina
