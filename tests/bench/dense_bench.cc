// SPDX-License-Identifier: Apache-2.0
// What Embree alone takes for a dense mesh, in bytes per triangle and time: the measure for how Patina keeps
// one (render what tests/bench/dense_mesh.py writes, and look at --stats).
//
//   bench_dense                              a million triangles
//   PATINA_BENCH_TRIANGLES=10000000 bench_dense
#include <benchmark/benchmark.h>
#include <embree3/rtcore.h>

#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <vector>

namespace {

size_t wantedTriangles() {
  const char* const wanted = std::getenv("PATINA_BENCH_TRIANGLES");
  return static_cast<size_t>(wanted ? std::max(2LL, std::atoll(wanted)) : 1000000);
}

/// A sheet of 2 n^2 triangles with bumps; behind the last point is what Embree reads beyond it.
struct Sheet {
  std::vector<float> points;
  std::vector<uint32_t> indices;
  explicit Sheet(size_t n) {
    for (size_t j = 0; j <= n; ++j)
      for (size_t i = 0; i <= n; ++i) {
        const float x = static_cast<float>(i) / static_cast<float>(n),
                    y = static_cast<float>(j) / static_cast<float>(n);
        points.insert(points.end(), {x, y, 0.1f * std::sin(20 * x) * std::sin(17 * y)});
      }
    points.push_back(0);
    const auto row = static_cast<uint32_t>(n + 1);
    for (uint32_t j = 0; j < n; ++j)
      for (uint32_t i = 0; i < n; ++i) {
        const uint32_t a = j * row + i;
        indices.insert(indices.end(), {a, a + 1, a + row, a + row + 1, a + row, a + 1});
      }
  }
};

void embreeAlone(benchmark::State& state, RTCSceneFlags flags) {
  const Sheet sheet(static_cast<size_t>(std::sqrt(static_cast<double>(wantedTriangles()) / 2)));
  const size_t triangles = sheet.indices.size() / 3;
  std::atomic<int64_t> bytes = 0, most = 0;
  for ([[maybe_unused]] auto _ : state) {
    struct Count {
      std::atomic<int64_t>&bytes, &most;
    } count{bytes, most};
    const RTCDevice device = rtcNewDevice(nullptr);
    rtcSetDeviceMemoryMonitorFunction(
        device,
        [](void* user, ssize_t change, bool) {
          auto& c = *static_cast<Count*>(user);
          const int64_t now = c.bytes += change;
          if (now > c.most) c.most = now;
          return true;
        },
        &count);
    const RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, flags);
    const RTCGeometry shape = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(shape, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sheet.points.data(), 0,
                               12, sheet.points.size() / 3);
    rtcSetSharedGeometryBuffer(shape, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sheet.indices.data(), 0, 12,
                               triangles);
    rtcCommitGeometry(shape);
    rtcAttachGeometry(scene, shape);
    rtcReleaseGeometry(shape);
    rtcCommitScene(scene);
    state.counters["bytes/triangle"] = static_cast<double>(bytes) / static_cast<double>(triangles);
    state.counters["at most"] = static_cast<double>(most) / static_cast<double>(triangles);
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
  state.counters["mesh itself"] =
      static_cast<double>(4 * (sheet.points.size() + sheet.indices.size())) / static_cast<double>(triangles);
}

BENCHMARK_CAPTURE(embreeAlone, robust, RTC_SCENE_FLAG_ROBUST)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(embreeAlone, compact,
                  static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_COMPACT))
    ->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
