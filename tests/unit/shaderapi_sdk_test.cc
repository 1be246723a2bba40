// SPDX-License-Identifier: Apache-2.0
// The C++ SDK: what it makes of a shader class, and that a batch computes what its points would one by one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <patina/sdk.h>

#include <cmath>
#include <cstring>
#include <new>
#include <stdexcept>

#include "tests/unit/plugins/batch.h"

namespace patina::test {
namespace {

using namespace patina::sdk;
using patina::sdk::detail::Plugin;

// Every kind of parameter and every surface kernel, with functions that have vector variants.
struct Everything {
  struct Parameters {
    float gain = 0.5f;
    Color tint{1, 0.5f, 0.25f};
    float bump = 0.1f;
    std::array<float, 3> weights{3, 2, 1};
    Point centre{1, 2, 3};
    int32_t mode = 4;
    std::array<int32_t, 2> pair{5, 6};
    const char* title = "none";
  };
  static constexpr auto kInfo =
      describe("everything", "for tests", uniform("gain", &Parameters::gain, "scale", kUnitRange, "m"),
               varying("tint", &Parameters::tint, "colour"), varying("bump", &Parameters::bump, "height"),
               varying("weights", &Parameters::weights, "three"),
               uniform("centre", &Parameters::centre, "place"), uniform("mode", &Parameters::mode, "which"),
               uniform("pair", &Parameters::pair, "two"), uniform("title", &Parameters::title, "text"));

  PatinaStatus prepare(const Parameters& p, Prepare& context) {
    offset_ = float(p.mode + p.pair[1]);
    context.traits.displacement_bound = 3;
    return PATINA_OK;
  }

  Radiosity radiosity(const Parameters& p, const Surface<kP | kN | kCs | kST>& at) const {
    Radiosity out;
    const float wave = p.gain * pow(std::abs(at.s) + 0.1f, 1.5f) + sin(at.t * 3) + exp(-at.s);
    out.reflectance = at.Cs * p.tint * wave;
    out.emission = p.tint * (dot(at.N, at.P - p.centre) * p.weights[2] + p.weights[0]);
    out.opacity = clamp(at.s, 0, 1);
    return out;
  }
  View<PATINA_LOBE_GGX, PATINA_LOBE_DIELECTRIC> view(const Parameters& p, const Surface<kN | kI>& at) const {
    View<PATINA_LOBE_GGX, PATINA_LOBE_DIELECTRIC> out;
    const float cosine = std::abs(dot(at.N, at.I));
    out.emission = p.tint * (1 - cosine);
    out.lobes[0].weight = p.tint * cosine;
    out.lobes[0].alpha = p.bump;
    out.lobes[1].transmission = p.tint;
    out.lobes[1].eta = 1 + p.weights[1];
    return out;
  }
  Displaced displacement(const Parameters& p, const Surface<kP | kN>& at) const {
    return {at.P + at.N * (p.bump * sin(at.P.x) + offset_)};
  }

  float offset_ = 0;
};

// The values that `prepare` and batches get: the table's defaults.
std::vector<PatinaValue> defaultsOf(const PatinaShader& shader) {
  std::vector<PatinaValue> values;
  for (uint32_t i = 0; i < shader.parameter_count; ++i) {
    const PatinaParameter& p = shader.parameters[i];
    const uint32_t components = p.type == PATINA_COLOR || p.type == PATINA_POINT ? 3 : 1;
    values.push_back({p.default_floats, p.default_ints, p.default_strings, 0, 1,
                      components * std::max(p.array_length, 1u), 0});
  }
  return values;
}

template <class S>
class Made {
 public:
  explicit Made(const PatinaHost* host = nullptr) : values(defaultsOf(Plugin<S>::kShader)) {
    static const PatinaHost kNoHost{};
    PatinaPrepare in{};
    in.struct_size = sizeof in;
    in.value_stride = sizeof(PatinaValue);
    in.host = host ? host : &kNoHost;
    in.values = values.data();
    traits.struct_size = sizeof traits;
    status = Plugin<S>::kShader.prepare(&in, &instance, &traits);
  }
  ~Made() {
    if (instance) Plugin<S>::kShader.release(instance);
  }
  Made(const Made&) = delete;
  Made& operator=(const Made&) = delete;

  std::vector<PatinaValue> values;
  PatinaTraits traits{};
  void* instance = nullptr;
  PatinaStatus status;
};

float noise(uint32_t i, uint32_t salt) {  // in [-1, 1]
  uint32_t h = (i * 747796405u + salt * 2891336453u) ^ 0x9e3779b9u;
  h = ((h >> 16) ^ h) * 0x45d9f3bu;
  h = ((h >> 16) ^ h) * 0x45d9f3bu;
  return float(h & 0xffffffu) / float(0x7fffff) - 1;
}

// A batch of `count` points which are those from `first` on of an endless list.
Batch points(uint32_t count, uint32_t first, std::vector<PatinaValue>& values) {
  Batch batch(count);
  const auto plane = [&](uint32_t salt) {
    return batch.varying([&](uint32_t i) { return noise(first + i, salt); });
  };
  batch.points.P = {plane(1), plane(2), plane(3)};
  batch.points.N = {plane(4), plane(5), plane(6)};
  batch.points.I = {plane(7), plane(8), plane(9)};
  batch.points.Cs = {plane(10), plane(11), plane(12)};
  batch.points.s = plane(13);
  batch.points.t = plane(14);
  const PatinaPlane height = plane(15);
  values[2].floats = height.data;  // bump varies
  values[2].stride = 1;
  values[2].plane = 0;
  batch.points.values = values.data();
  return batch;
}

bool same(const PatinaOut3& a, uint32_t i, const PatinaOut3& b, uint32_t j) {
  return std::memcmp(&a.x[i], &b.x[j], 4) == 0 && std::memcmp(&a.y[i], &b.y[j], 4) == 0 &&
         std::memcmp(&a.z[i], &b.z[j], 4) == 0;
}

TEST(ShaderSdk, DescribesItsParametersAtCompileTime) {
  static constexpr const PatinaShader& shader = Plugin<Everything>::kShader;
  static_assert(shader.parameter_count == 8 && shader.struct_size == sizeof(PatinaShader));
  const auto& p = shader.parameters;
  EXPECT_STREQ(shader.name, "everything");
  EXPECT_STREQ(p[0].name, "gain");
  EXPECT_STREQ(p[0].unit, "m");
  EXPECT_EQ(p[0].maximum, 1);
  EXPECT_EQ(p[0].storage, uint32_t(PATINA_UNIFORM));
  EXPECT_EQ(*p[0].default_floats, 0.5f);
  EXPECT_EQ(p[1].type, uint32_t(PATINA_COLOR));
  EXPECT_EQ(p[1].storage, uint32_t(PATINA_VARYING));
  EXPECT_THAT(std::vector<float>(p[1].default_floats, p[1].default_floats + 3),
              testing::ElementsAre(1, 0.5f, 0.25f));
  EXPECT_GT(p[1].minimum, p[1].maximum);
  EXPECT_EQ(p[3].array_length, 3u);
  EXPECT_EQ(p[3].default_floats[2], 1);
  EXPECT_EQ(p[4].type, uint32_t(PATINA_POINT));
  EXPECT_EQ(p[4].default_floats[1], 2);
  EXPECT_EQ(p[5].type, uint32_t(PATINA_INT));
  EXPECT_EQ(*p[5].default_ints, 4);
  EXPECT_EQ(p[6].default_ints[1], 6);
  EXPECT_STREQ(*p[7].default_strings, "none");
}

TEST(ShaderSdk, DerivesTraitsFromTheKernels) {
  const Made<Everything> made;
  ASSERT_EQ(made.status, PATINA_OK);
  EXPECT_EQ(made.traits.active,
            1u << PATINA_ENTRY_DISPLACEMENT | 1u << PATINA_ENTRY_RADIOSITY | 1u << PATINA_ENTRY_VIEW);
  EXPECT_EQ(made.traits.reads[PATINA_ENTRY_RADIOSITY],
            PATINA_CHANNEL_P | PATINA_CHANNEL_N | PATINA_CHANNEL_CS | PATINA_CHANNEL_ST);
  EXPECT_EQ(made.traits.reads[PATINA_ENTRY_VIEW], PATINA_CHANNEL_N | PATINA_CHANNEL_I);
  EXPECT_EQ(made.traits.reads[PATINA_ENTRY_LIGHT], 0u);
  EXPECT_EQ(made.traits.displacement_bound, 3);
}

TEST(ShaderSdk, ABatchIsItsPointsOneByOneBitForBit) {
  Made<Everything> made;
  const PatinaShader& shader = Plugin<Everything>::kShader;
  constexpr uint32_t kCount = 67;
  Batch whole = points(kCount, 0, made.values);
  PatinaRadiosityOut radiosity = whole.radiosityOut();
  PatinaViewOut view = whole.viewOut();
  PatinaDisplacementOut moved = whole.displacementOut();
  ASSERT_EQ(shader.radiosity(made.instance, &whole.points, &radiosity), PATINA_OK);
  ASSERT_EQ(shader.view(made.instance, &whole.points, &view), PATINA_OK);
  ASSERT_EQ(shader.displacement(made.instance, &whole.points, &moved), PATINA_OK);
  EXPECT_EQ(view.lobe_count, 2u);
  EXPECT_EQ(view.lobes[1].type, uint32_t(PATINA_LOBE_DIELECTRIC));
  EXPECT_EQ(moved.writes_normal, 0u);
  for (uint32_t i = 0; i < kCount; ++i) {
    Batch one = points(1, i, made.values);
    PatinaRadiosityOut a = one.radiosityOut();
    PatinaViewOut b = one.viewOut();
    const Batch& viewed = one;
    PatinaDisplacementOut c = one.displacementOut();
    ASSERT_EQ(shader.radiosity(made.instance, &viewed.points, &a), PATINA_OK);
    ASSERT_EQ(shader.view(made.instance, &one.points, &b), PATINA_OK);
    ASSERT_EQ(shader.displacement(made.instance, &one.points, &c), PATINA_OK);
    EXPECT_TRUE(same(radiosity.emission, i, a.emission, 0)) << i;
    EXPECT_TRUE(same(radiosity.reflectance, i, a.reflectance, 0)) << i;
    EXPECT_TRUE(same(radiosity.opacity, i, a.opacity, 0)) << i;
    EXPECT_TRUE(same(moved.P, i, c.P, 0)) << i;
    EXPECT_TRUE(same(view.emission, i, b.emission, 0)) << i;
  }
}

TEST(ShaderSdk, UniformAndVaryingValuesGiveTheSameBits) {
  Made<Everything> made;
  const PatinaShader& shader = Plugin<Everything>::kShader;
  constexpr uint32_t kCount = 40;
  Batch batch = points(kCount, 5, made.values);
  PatinaRadiosityOut uniforms = batch.radiosityOut();
  ASSERT_EQ(shader.radiosity(made.instance, &batch.points, &uniforms), PATINA_OK);

  // The default colour and weights, spelt out for every lane: components lie padded lanes apart.
  std::vector<PatinaValue> values = made.values;
  alignas(64) float tint[3][48], weights[3][48];
  for (uint32_t c = 0; c < 3; ++c)
    for (uint32_t i = 0; i < 48; ++i) tint[c][i] = values[1].floats[c], weights[c][i] = values[3].floats[c];
  values[1] = {tint[0], nullptr, nullptr, 1, 48, 3, 1};
  values[3] = {weights[0], nullptr, nullptr, 1, 48, 3, 1};
  batch.points.values = values.data();
  PatinaRadiosityOut varyings = batch.radiosityOut();
  ASSERT_EQ(shader.radiosity(made.instance, &batch.points, &varyings), PATINA_OK);
  for (uint32_t i = 0; i < kCount; ++i) {
    EXPECT_TRUE(same(uniforms.reflectance, i, varyings.reflectance, i)) << i;
    EXPECT_TRUE(same(uniforms.emission, i, varyings.emission, i)) << i;
  }
}

// The kernels' formulas in double precision.
TEST(ShaderSdk, KernelsComputeWhatTheySay) {
  Made<Everything> made;
  const PatinaShader& shader = Plugin<Everything>::kShader;
  constexpr uint32_t kCount = 33;
  Batch batch = points(kCount, 0, made.values);
  PatinaRadiosityOut radiosity = batch.radiosityOut();
  PatinaDisplacementOut moved = batch.displacementOut();
  ASSERT_EQ(shader.radiosity(made.instance, &batch.points, &radiosity), PATINA_OK);
  ASSERT_EQ(shader.displacement(made.instance, &batch.points, &moved), PATINA_OK);
  for (uint32_t i = 0; i < kCount; ++i) {
    const double s = noise(i, 13), t = noise(i, 14), cs = noise(i, 12), bump = noise(i, 15);
    const double wave = 0.5 * std::pow(std::abs(s) + double(0.1f), 1.5) + std::sin(3 * t) + std::exp(-s);
    EXPECT_NEAR(radiosity.reflectance.z[i], cs * 0.25 * wave, 2e-6);
    EXPECT_NEAR(moved.P.y[i], noise(i, 2) + noise(i, 5) * (bump * std::sin(double(noise(i, 1))) + 10), 1e-5);
  }
}

struct ThrowsInKernel {
  static constexpr auto kInfo = describe("throws", "for tests");
  Radiosity radiosity(const NoParameters&, const Surface<kCs>& at) const {
    if (at.Cs.r > 0) throw std::runtime_error("no");
    return {};
  }
};
struct ThrowsInPrepare {
  static constexpr auto kInfo = describe("throws", "for tests");
  PatinaStatus prepare(const NoParameters&, Prepare&) { throw std::bad_alloc(); }
};

TEST(ShaderSdk, NoExceptionLeavesAPlugin) {
  const Made<ThrowsInKernel> made;
  Batch batch(3);
  batch.points.Cs = batch.uniform({1, 1, 1});
  PatinaRadiosityOut out = batch.radiosityOut();
  EXPECT_EQ(Plugin<ThrowsInKernel>::kShader.radiosity(made.instance, &batch.points, &out),
            PATINA_ERROR_INTERNAL);
  const Made<ThrowsInPrepare> failed;
  EXPECT_EQ(failed.status, PATINA_ERROR_RESOURCE);
  EXPECT_EQ(failed.instance, nullptr);
}

// A light of each task; each answers with what it was asked.
struct EchoLight {
  static constexpr auto kInfo = describe("echo", "for tests");
  LightSample sample(const NoParameters&, const LightQuery& at) const {
    return {at.P, at.random_x, {at.random_y, 0, 0}, 1};
  }
  LightSample evaluate(const NoParameters&, const LightQuery& at) const {
    LightSample out;
    out.radiance = {at.direction.x, at.direction.y, at.direction.z};
    out.pdf = at.P.y;
    return out;
  }
};
struct EchoArea {
  static constexpr auto kInfo = describe("echoarea", "for tests");
  Color emit(const NoParameters&, const LightQuery& at) const {
    return {at.u, at.v, dot(at.N, at.direction)};
  }
};

TEST(ShaderSdk, LightsAnswerTheTaskTheyAreGiven) {
  const Made<EchoLight> light;
  const Made<EchoArea> area;
  EXPECT_EQ(light.traits.light_kind, uint32_t(PATINA_LIGHT_INFINITE));
  EXPECT_EQ(area.traits.light_kind, uint32_t(PATINA_LIGHT_AREA));
  EXPECT_EQ(area.traits.active, 1u << PATINA_ENTRY_LIGHT);
  Batch batch(20);
  const auto lane = [](float f) { return [f](uint32_t i) { return f + float(i); }; };
  PatinaLightIn& in = batch.lightIn;
  in.P = {batch.varying(lane(0)), batch.varying(lane(100)), batch.varying(lane(200))};
  in.random_x = batch.varying(lane(300));
  in.random_y = batch.varying(lane(400));
  in.task = PATINA_LIGHT_SAMPLE;
  PatinaLightOut out = batch.lightOut();
  ASSERT_EQ(Plugin<EchoLight>::kShader.light(light.instance, &in, &out), PATINA_OK);
  EXPECT_EQ(get(out.direction, 17), (Triple{17, 117, 217}));
  EXPECT_EQ(out.distance[17], 317);
  EXPECT_EQ(out.radiance.x[17], 417);
  EXPECT_EQ(out.pdf[17], 1);

  in.task = PATINA_LIGHT_EVALUATE;
  in.direction = {batch.varying(lane(1)), batch.varying(lane(2)), batch.varying(lane(3))};
  ASSERT_EQ(Plugin<EchoLight>::kShader.light(light.instance, &in, &out), PATINA_OK);
  EXPECT_EQ(get(out.radiance, 3), (Triple{4, 5, 6}));
  EXPECT_EQ(out.pdf[3], 103);

  in.task = PATINA_LIGHT_EMIT;
  in.N = batch.uniform({0, 0, 1});
  in.u = batch.varying(lane(7));
  in.v = batch.uniform(8);
  ASSERT_EQ(Plugin<EchoArea>::kShader.light(area.instance, &in, &out), PATINA_OK);
  EXPECT_EQ(get(out.radiance, 19), (Triple{26, 8, 22}));
}

// Two look-ups per point, through a host whose "textures" answer with their own address and coordinates.
struct Textured {
  static constexpr auto kInfo = describe("textured", "for tests");
  PatinaTexture* texture(uint32_t i) const { return i == 0 ? reinterpret_cast<PatinaTexture*>(8) : nullptr; }
  std::array<TextureLookup, 2> lookups(const NoParameters&, const Surface<kST>& at) const {
    return {{{at.s, at.t, 0.5f}, {at.t, at.s, 0}}};
  }
  Radiosity radiosity(const NoParameters&, const Surface<kCs>& at, const Texels<2>& texels) const {
    Radiosity out;
    out.reflectance = at.Cs * texels[0].color;
    out.emission = texels[1].color;
    out.opacity = texels[0].alpha;
    return out;
  }
};

TEST(ShaderSdk, TexturesAreLookedUpBeforeTheKernelRuns) {
  PatinaHost host{};
  host.texture = [](void*, PatinaTexture* texture, uint32_t count, PatinaPlane s, PatinaPlane t,
                    PatinaPlane width, PatinaOut3 color, float* alpha) -> PatinaStatus {
    EXPECT_EQ(texture, reinterpret_cast<PatinaTexture*>(8));
    EXPECT_LE(count, PATINA_LANES);
    for (uint32_t i = 0; i < count; ++i)
      color.x[i] = s.data[i], color.y[i] = t.data[i], color.z[i] = width.data[i], alpha[i] = 0.25f;
    return PATINA_OK;
  };
  const Made<Textured> made(&host);
  EXPECT_EQ(made.traits.reads[PATINA_ENTRY_RADIOSITY], PATINA_CHANNEL_CS | PATINA_CHANNEL_ST);
  Batch batch(20);
  batch.points.Cs = batch.uniform({2, 2, 2});
  batch.points.s = batch.varying([](uint32_t i) { return float(i); });
  batch.points.t = batch.varying([](uint32_t i) { return 100 + float(i); });
  PatinaRadiosityOut out = batch.radiosityOut();
  ASSERT_EQ(Plugin<Textured>::kShader.radiosity(made.instance, &batch.points, &out), PATINA_OK);
  for (uint32_t i = 0; i < 20; ++i) {
    EXPECT_EQ(get(out.reflectance, i), (Triple{2 * float(i), 200 + 2 * float(i), 1}));
    EXPECT_EQ(get(out.emission, i), (Triple{1, 1, 1}));  // no texture
    EXPECT_EQ(out.opacity.x[i], 0.25f);
  }
}

TEST(ShaderSdk, SmoothstepIsThatOfRi) {
  EXPECT_EQ(smoothstep(1, 2, 0.9f), 0);
  EXPECT_EQ(smoothstep(1, 2, 2.5f), 1);
  EXPECT_FLOAT_EQ(smoothstep(1, 2, 1.25f), 0.15625f);
  EXPECT_EQ(smoothstep(1, 1, 1.1f), 1);
  EXPECT_EQ(smoothstep(1, 1, 0.9f), 0);
}

}  // namespace
}  // namespace patina::test
