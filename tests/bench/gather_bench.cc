// SPDX-License-Identifier: Apache-2.0
// What a gather costs beside its rays: the rays of gathers at what the camera sees, fired at Embree in a loop
// (all triangles in one scene of its own) and at Patina's accelerator, against whole gathers of the radiosity
// cache, while it is empty and once it holds everything. One thread.
//
//   bench_gather                                             a room of its own
//   PATINA_BENCH_RIB=scene.rib PATINA_BENCH_RES=192x144 PATINA_BENCH_RAYS=256 bench_gather
#include <benchmark/benchmark.h>
#include <embree3/rtcore.h>
#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>

#include "renderer/base/statistics.h"
#include "renderer/integrators/radiosity_engine.h"
#include "renderer/scene/scene_builder.h"

namespace patina {
namespace {

/// A grey room with balls above its floor and a lamp below its ceiling.
std::string room() {
  std::string rib = R"(Format 96 96 1 Projection "perspective" "fov" [70] Translate 0 0 .95 WorldBegin
    AttributeBegin AreaLightSource "arealight" 1 "intensity" [6]
      Polygon "P" [-.4 .98 -.4  .4 .98 -.4  .4 .98 .4  -.4 .98 .4] AttributeEnd Illuminate 1 1
    Color [.7 .7 .7] Surface "matte" "Kd" [1]
    Polygon "P" [-1 -1 -1  1 -1 -1  1 -1 1  -1 -1 1] Polygon "P" [-1 1 -1  -1 1 1  1 1 1  1 1 -1]
    Polygon "P" [-1 -1 -1  -1 -1 1  -1 1 1  -1 1 -1] Polygon "P" [1 -1 -1  1 1 -1  1 1 1  1 -1 1]
    Polygon "P" [-1 -1 1  1 -1 1  1 1 1  -1 1 1] Polygon "P" [-1 -1 -1  -1 1 -1  1 1 -1  1 -1 -1]
)";
  for (int k = 0; k < 9; ++k)
    rib +=
        fmt::format("AttributeBegin Translate {} {} {} Rotate {} 0 1 0 Sphere .2 -.2 .2 360 AttributeEnd\n",
                    -0.6 + 0.6 * (k % 3), -0.8 + 0.1 * (k % 2), 0.6 * (k / 3) - 0.4, 20 * k);
  return rib + "WorldEnd\n";
}

const char* variable(const char* name, const char* otherwise) {
  const char* const value = std::getenv(name);
  return value ? value : otherwise;
}

/// What the camera sees through the middle of each pixel.
struct Seen {
  std::vector<RadiosityEngine::Request> requests;
  std::vector<Ray> rays;  // of gathers, as RadiosityEngine::gather() draws them

  Seen(const World& world, int raysOfEach) {
    std::vector<Ray> camera;
    for (int y = 0; y < world.camera().yResolution(); ++y)
      for (int x = 0; x < world.camera().xResolution(); ++x) {
        const RasterCamera::Ray r =
            world.camera().ray(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, V2f(0.5f));
        camera.push_back({r.origin, r.direction, r.tNear, r.tFar, kCameraRay});
      }
    std::vector<Hit> hits(camera.size());
    world.accel().intersect(camera, hits);
    for (size_t k = 0; k < hits.size(); ++k) {
      if (!hits[k].valid()) continue;
      const ShadingPoint point = world.shading().at(hits[k], camera[k].direction, 0);
      const uint64_t seed = hashOf(k, 1);
      requests.push_back({point, seed, 4});
      const Frame frame(point.N);
      for (uint32_t i = 0; i < static_cast<uint32_t>(raysOfEach); ++i)
        rays.push_back({leave(point.facet(), point.Ng),
                        foldDirection(frame.toWorld(sampleCosineHemisphere(sobol2(i, seed))), point.Ng), 0,
                        kInfinity, kDiffuseRay});
    }
  }
};

/// All that rays may meet, as plain triangles.
class Plain {
 public:
  explicit Plain(const World& world) : device_(rtcNewDevice(nullptr)), scene_(rtcNewScene(device_)) {
    const auto add = [&](const V3f& a, const V3f& b, const V3f& c) {
      for (const V3f& p : {a, b, c}) points_.insert(points_.end(), {p.x, p.y, p.z});
    };
    for (uint32_t k = 0; k < world.geometry().placements().size(); ++k)
      world.geometry().forEachFacet(k, [&](const Geometry::FacetQuad& q) {
        add(q.P[0], q.P[1], q.P[2]);
        if (!q.isTriangle) add(q.P[3], q.P[2], q.P[1]);
      });
    for (uint32_t i = 0; i < points_.size() / 3; ++i) indices_.push_back(i);
    points_.push_back(0);  // Embree reads beyond the last
    const RTCGeometry shape = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(shape, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, points_.data(), 0, 12,
                               indices_.size());
    rtcSetSharedGeometryBuffer(shape, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, indices_.data(), 0, 12,
                               indices_.size() / 3);
    rtcCommitGeometry(shape);
    rtcAttachGeometry(scene_, shape);
    rtcReleaseGeometry(shape);
    rtcCommitScene(scene_);
  }
  ~Plain() { rtcReleaseScene(scene_), rtcReleaseDevice(device_); }
  Plain(const Plain&) = delete;
  Plain& operator=(const Plain&) = delete;
  size_t triangles() const { return indices_.size() / 3; }
  void trace(std::span<const Ray> rays) const {
    for (const Ray& r : rays) {
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      RTCRayHit ray{};
      ray.ray = {r.origin.x, r.origin.y, r.origin.z, r.tNear, r.direction.x, r.direction.y, r.direction.z, 0,
                 r.tFar,     ~0u,        0,          0};
      ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      rtcIntersect1(scene_, &context, &ray);
      benchmark::DoNotOptimize(ray);
    }
  }

 private:
  RTCDevice device_;
  RTCScene scene_;
  std::vector<float> points_;
  std::vector<uint32_t> indices_;
};

void gather(benchmark::State& state) {
  ErrorHandler errors([](Severity, std::string_view message) { std::cerr << message << '\n'; });
  RenderSettings settings;
  settings.threads = 1;
  settings.shaderPath = variable("PATINA_SHADER_PATH", PATINA_BINARY_DIR "/lib/patina/shaders");
  const int rays = std::max(1, std::atoi(variable("PATINA_BENCH_RAYS", "64")));
  const auto measure = [&](Scene& scene) {
    int width = 0, height = 0;
    if (std::sscanf(variable("PATINA_BENCH_RES", ""), "%dx%d", &width, &height) == 2 && width > 0 &&
        height > 0)
      scene.options.xResolution = width, scene.options.yResolution = height;
    World world(scene, settings, errors);
    world.settle({0, 0, world.camera().xResolution(), world.camera().yResolution()}, true);
    const Seen seen(world, rays);
    constexpr size_t kBatch = 4096;
    std::vector<Hit> hits(kBatch);
    RadiosityEngine::Settings of;
    of.rays.diffuse0 = rays;
    std::vector<RadiosityEngine::Irradiance> out(seen.requests.size());
    using Clock = std::chrono::steady_clock;
    const auto seconds = [](auto what) {
      const auto start = Clock::now();
      what();
      return std::chrono::duration<double>(Clock::now() - start).count();
    };
    const auto trace = [&] {
      for (size_t first = 0; first < seen.rays.size(); first += kBatch) {
        const size_t n = std::min(kBatch, seen.rays.size() - first);
        world.accel().intersect(std::span(seen.rays).subspan(first, n), std::span(hits).first(n));
        benchmark::DoNotOptimize(hits.data());
      }
    };
    trace();  // makes the facets
    const Plain plain(world);
    const RadiosityEngine engine(world, of);
    const double empty = seconds([&] { engine.indirect(seen.requests, Purpose::Vertex, out); });
    double embree = 0, traced = 0, full = 0;
    int64_t times = 0;
    for ([[maybe_unused]] auto _ : state) {
      embree += seconds([&] { plain.trace(seen.rays); });
      traced += seconds(trace);
      full += seconds([&] { engine.indirect(seen.requests, Purpose::Vertex, out); });
      ++times;
    }
    const auto all = static_cast<double>(seen.rays.size()), repeats = static_cast<double>(times);
    state.counters["triangles"] = static_cast<double>(plain.triangles());
    state.counters["rays"] = all;
    state.counters["Mrays/s: Embree"] = all * repeats / embree / 1e6;
    state.counters["accelerator"] = all * repeats / traced / 1e6;
    state.counters["gathers, cache full"] = all * repeats / full / 1e6;
    state.counters["gathers, cache empty"] = all / empty / 1e6;
  };
  const std::string path = variable("PATINA_BENCH_RIB", "");
  SceneBuilder builder({}, errors, measure);
  if (path.empty()) {
    builder.readText(room(), "room.rib");
  } else {
    std::filesystem::current_path(std::filesystem::absolute(path).parent_path());
    builder.readFile(std::filesystem::path(path).filename());
  }
}

BENCHMARK(gather)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace patina

BENCHMARK_MAIN();
