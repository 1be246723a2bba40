// SPDX-License-Identifier: Apache-2.0
// What an entry point costs per point: a kernel of noise through the shader ABI in batches of 1 to 1024, next
// to a loop over plain arrays and to a function that is called for each point. The counter "point" is the
// time of one. The kernel that does nothing shows what the ABI adds.
#include <benchmark/benchmark.h>
#include <patina/sdk.h>
#include <patina/sdk/fractals.h>

#include "tests/unit/plugins/batch.h"

namespace patina::test {
namespace {

using namespace patina::sdk;

constexpr uint32_t kPoints = 1024;

PATINA_INLINE float pattern(const Vector& p, float width) { return 0.5f + 0.25f * fbm<4>(p * 7, width * 7); }

struct Noise {
  static constexpr auto kInfo = describe("noise", "for benchmarks");
  Radiosity radiosity(const NoParameters&, const Surface<kP | kFootprint>& at) const {
    Radiosity out;
    out.reflectance = pattern(at.P, at.footprint);
    return out;
  }
};
struct Nothing {
  static constexpr auto kInfo = describe("nothing", "for benchmarks");
  Radiosity radiosity(const NoParameters&, const Surface<kP | kFootprint>& at) const {
    Radiosity out;
    out.reflectance = Color(at.P.x, at.P.y, at.P.z) * at.footprint;
    return out;
  }
};

Triple place(uint32_t i) {
  const auto x = float(i);
  return {0.013f * x, 0.37f + 0.0071f * x, 2.1f - 0.0037f * x};
}

void perPoint(benchmark::State& state) {
  state.counters["point"] = benchmark::Counter(double(state.iterations()) * kPoints,
                                               benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

template <class S>
void batches(benchmark::State& state) {
  const auto size = static_cast<uint32_t>(state.range(0));
  const PatinaShader& shader = patina::sdk::detail::Plugin<S>::kShader;
  const PatinaHost host{};
  PatinaPrepare in{};
  in.host = &host;
  PatinaTraits traits{};
  void* instance = nullptr;
  shader.prepare(&in, &instance, &traits);
  Batch batch(size);
  batch.points.P = batch.varying3(place);
  batch.points.footprint = batch.uniform(0.001f);
  PatinaRadiosityOut out = batch.radiosityOut();
  auto* volatile radiosity = shader.radiosity;  // as the host calls it: by a pointer
  for ([[maybe_unused]] auto _ : state) {
    for (uint32_t done = 0; done < kPoints; done += size) radiosity(instance, &batch.points, &out);
    benchmark::DoNotOptimize(out.reflectance.x[0]);
    benchmark::ClobberMemory();
  }
  shader.release(instance);
  perPoint(state);
}
BENCHMARK(batches<Noise>)->Name("noise/batch")->Arg(1)->Arg(16)->Arg(64)->Arg(256)->Arg(1024);
BENCHMARK(batches<Nothing>)->Name("nothing/batch")->Arg(1)->Arg(16)->Arg(64)->Arg(256)->Arg(1024);

/// What the loops below read and write.
struct Arrays {
  alignas(64) float x[kPoints], y[kPoints], z[kPoints], out[kPoints];
  Arrays() {
    for (uint32_t i = 0; i < kPoints; ++i) x[i] = place(i)[0], y[i] = place(i)[1], z[i] = place(i)[2];
  }
};

void loop(benchmark::State& state) {
  Arrays a;
  for ([[maybe_unused]] auto _ : state) {
    for (uint32_t i = 0; i < kPoints; ++i) a.out[i] = pattern(Vector(a.x[i], a.y[i], a.z[i]), 0.001f);
    benchmark::DoNotOptimize(a.out[0]);
    benchmark::ClobberMemory();
  }
  perPoint(state);
}
BENCHMARK(loop)->Name("noise/loop");

__attribute__((noinline)) float onePoint(float x, float y, float z, float width) {
  return pattern(Vector(x, y, z), width);
}
void scalar(benchmark::State& state) {
  Arrays a;
  for ([[maybe_unused]] auto _ : state) {
    for (uint32_t i = 0; i < kPoints; ++i) a.out[i] = onePoint(a.x[i], a.y[i], a.z[i], 0.001f);
    benchmark::DoNotOptimize(a.out[0]);
    benchmark::ClobberMemory();
  }
  perPoint(state);
}
BENCHMARK(scalar)->Name("noise/scalar");

}  // namespace
}  // namespace patina::test

BENCHMARK_MAIN();
