// SPDX-License-Identifier: Apache-2.0
// What a texture look-up costs: by Patina's service in batches of 1 to 1024, next to OpenImageIO called for
// each point. The counter "point" is the time of one. Both read the same file, untiled and of eight bits; the
// service also as colour, that is from linear halves, and as a set of tiles.
#include <OpenImageIO/texture.h>
#include <benchmark/benchmark.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "renderer/shading/texture_service.h"

namespace patina {
namespace {

constexpr int kSide = 1024;
constexpr uint32_t kPoints = 1024;

/// A folder with a picture of noise, under a plain name and as two tiles; removed at the end.
struct Files {
  std::string folder;
  Files() {
    std::string name = (std::filesystem::temp_directory_path() / "patina-texture-bench-XXXXXX").string();
    if (!mkdtemp(name.data())) std::abort();
    folder = name;
    for (const char* file : {"/noise.ppm", "/tiles.1001.ppm", "/tiles.1002.ppm"}) {
      std::ofstream out(folder + file, std::ios::binary);
      out << "P6 " << kSide << ' ' << kSide << " 255\n";
      uint32_t state = 1;
      for (int i = 0; i < 3 * kSide * kSide; ++i)
        out.put(static_cast<char>((state = state * 1664525u + 1013904223u) >> 24));
    }
  }
  ~Files() { std::filesystem::remove_all(folder); }
};
const std::string& folder() {
  static const Files files;
  return files.folder;
}

/// Points that lie near each other, as those of a batch do; the filter is 2 texels wide.
struct Points {
  alignas(64) float s[kPoints], t[kPoints];
  float width = 2.0f / kSide;
  Points() {
    for (uint32_t i = 0; i < kPoints; ++i)
      s[i] = 0.1f + 0.0007f * static_cast<float>(i % 32), t[i] = 0.3f + 0.0007f * static_cast<float>(i / 32);
  }
};

void perPoint(benchmark::State& state) {
  state.counters["point"] = benchmark::Counter(double(state.iterations()) * kPoints,
                                               benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void direct(benchmark::State& state) {
  OIIO::TextureSystem* const system = OIIO::TextureSystem::create(false);
  system->attribute("autotile", 64);
  system->attribute("automip", 1);
  auto* const file = system->get_texture_handle(OIIO::ustring(folder() + "/noise.ppm"));
  auto* const thread = system->get_perthread_info();
  const Points points;
  OIIO::TextureOpt options;
  options.swrap = options.twrap = OIIO::TextureOpt::WrapPeriodic;
  options.interpmode = OIIO::TextureOpt::InterpBilinear;
  float color[3] = {};
  for (auto _ : state)
    for (uint32_t i = 0; i < kPoints; ++i) {
      benchmark::DoNotOptimize(system->texture(file, thread, options, points.s[i], points.t[i], points.width,
                                               0, 0, points.width, 3, color));
    }
  perPoint(state);
  OIIO::TextureSystem::destroy(system);
}

void service(benchmark::State& state, const char* name, TextureService::Values values) {
  const auto size = static_cast<uint32_t>(state.range(0));
  ErrorHandler errors;
  TextureService textures({folder()}, {}, size_t(64) << 20, errors);
  PatinaTexture* const texture = textures.open(name, {}, values);
  const Points points;
  alignas(64) static float color[3][kPoints];
  for (auto _ : state)
    for (uint32_t i = 0; i < kPoints; i += size)
      benchmark::DoNotOptimize(TextureService::texture(texture, size, {points.s + i, 1, 0},
                                                       {points.t + i, 1, 0}, {&points.width, 0, 0},
                                                       {color[0] + i, color[1] + i, color[2] + i}, nullptr));
  perPoint(state);
}
void asData(benchmark::State& state) { service(state, "noise.ppm", TextureService::kData); }
void asColor(benchmark::State& state) { service(state, "noise.ppm", TextureService::kColors); }
void ofTiles(benchmark::State& state) { service(state, "tiles.<UDIM>.ppm", TextureService::kData); }

void sizes(benchmark::internal::Benchmark* b) {
  for (const int size : {1, 16, 64, 256, 1024}) b->Arg(size);
}
BENCHMARK(direct)->Name("OpenImageIO");
BENCHMARK(asData)->Name("service")->Apply(sizes);
BENCHMARK(asColor)->Name("service, colour")->Apply(sizes);
BENCHMARK(ofTiles)->Name("service, tiles")->Apply(sizes);

}  // namespace
}  // namespace patina

BENCHMARK_MAIN();
