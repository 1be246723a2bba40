// SPDX-License-Identifier: Apache-2.0
// Lobes that plugins bring, as the renderer evaluates and samples them: those of `principled`, and such as
// misbehave.
#include <gmock/gmock.h>

#include "renderer/shading/bsdf.h"
#include "tests/unit/chi_square.h"
#include "tests/unit/plugins/bound_shader.h"

namespace patina::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// A surface seen `degrees` from its normal +z, along +x.
struct Seen {
  ShadingPoint point;
  SurfaceTerms terms;
  std::vector<CustomLobeLane> lanes;
  std::vector<Lobe> lobes;

  Seen(const ShaderInstance& shader, Batch batch, double degrees) {
    const auto angle = float(degrees * std::numbers::pi / 180);
    point.I = -V3f(std::sin(angle), 0, std::cos(angle));
    batch.points.Cs = batch.points.Os = batch.uniform({1, 1, 1});
    batch.points.N = batch.uniform({0, 0, 1});
    batch.points.dPds = batch.uniform({0.6f, 0.8f, 0});
    batch.points.I = batch.uniform({point.I.x, point.I.y, point.I.z});
    PatinaRadiosityOut radiosity = batch.radiosityOut();
    if (shader.active(PATINA_ENTRY_RADIOSITY)) {
      EXPECT_EQ(shader.radiosity(batch.points, radiosity), PATINA_OK);
    }
    const Triple rho = get(radiosity.reflectance, 0);
    terms.reflectance = {rho[0], rho[1], rho[2]};
    PatinaViewOut view = batch.viewOut();
    EXPECT_EQ(shader.view(batch.points, view), PATINA_OK);
    lanes.resize(PATINA_MAX_LOBES);
    for (uint32_t k = 0; k < view.lobe_count; ++k) {
      const PatinaLobe& from = view.lobes[k];
      const Triple weight = get(from.weight, 0), through = get(from.transmission, 0);
      Lobe lobe{from.type,
                {weight[0], weight[1], weight[2]},
                {through[0], through[1], through[2]},
                from.alpha[0],
                from.eta[0]};
      if (isBlack(lobe.weight) && isBlack(lobe.transmission)) continue;
      if ((lanes[k].lobe = shader.customLobe(from.type))) lobe.custom = &lanes[k];
      for (uint32_t c = 0; lobe.custom && c < lanes[k].lobe->dataCount(); ++c)
        lanes[k].data[c] = from.data[c][0];
      lobes.push_back(lobe);
    }
  }
  Seen(const Seen&) = delete;
  Bsdf bsdf() const { return {point, terms, lobes}; }
};

struct Look {
  const char* name;
  std::vector<ShaderArgument> arguments;
};
const Look kLooks[] = {
    {"plastic", {number("roughness", 0.4f)}},
    {"brushed", {number("metallic", 1), number("roughness", 0.5f), number("anisotropy", 0.8f)}},
    {"coated", {number("roughness", 0.8f), number("coat", 1), number("coatroughness", 0.3f)}},
    {"cloth", {number("specular", 0), number("sheen", 1), number("sheenroughness", 0.4f)}}};

TEST(CustomLobes, AreSampledByTheirDensities) {
  Fits fits;
  for (const Look& look : kLooks) {
    const BoundShader shader("principled", look.arguments);
    for (const double degrees : {0.0, 45.0, 80.0}) {
      const Seen seen(*shader, shader.batch(1), degrees);
      ASSERT_FALSE(seen.lobes.empty());
      const Bsdf bsdf = seen.bsdf();
      const V3f mirrored(seen.point.I.x, seen.point.I.y, -seen.point.I.z);
      fitDirections(
          fits, look.name + std::to_string(degrees), SphereGrid::narrow(mirrored, 0.1),
          [&](Independent& random) -> std::optional<V3f> {
            const float choice = random.next();
            const BsdfSample s = bsdf.sample(choice, random.next2());
            return s.pdf > 0 ? std::optional(s.direction) : std::nullopt;
          },
          [&](const V3f& wi) { return bsdf.evaluate(wi).pdf; });
    }
  }
}

/// What becomes of light from everywhere, by channel.
Rgb albedoOf(const Seen& seen) {
  constexpr uint32_t kSamples = 1 << 14;
  const Bsdf bsdf = seen.bsdf();
  Independent random(7);
  V3d sum(0, 0, 0);
  for (uint32_t k = 0; k < kSamples; ++k) {
    const float choice = (float(k) + random.next()) / kSamples;
    const BsdfSample s = bsdf.sample(std::min(choice, kOneMinusEpsilon), random.next2());
    // Refraction squeezes radiance, not power.
    if (s.pdf > 0) sum += V3d(s.weight) * (s.transmitted ? 1.5 * 1.5 : 1.0);
  }
  return Rgb(sum / kSamples);
}

constexpr double kAngles[] = {0, 30, 60, 80, 87};
// Of the means of 16384 samples, and of the tables of albedos, which are good to a half per cent.
constexpr float kSlack = 0.012f;

TEST(CustomLobes, PrincipledMakesNoEnergy) {
  for (const float metallic : {0.0f, 0.5f, 1.0f})
    for (const float roughness : {0.0f, 0.2f, 0.5f, 1.0f})
      for (const float coat : {0.0f, 1.0f})
        for (const float other : {0.0f, 1.0f}) {
          const BoundShader shader(
              "principled", {number("metallic", metallic), number("roughness", roughness),
                             number("coat", coat), number("sheen", other), number("anisotropy", 0.7f * other),
                             number("transmission", 0.5f * other)});
          for (const double degrees : kAngles) {
            const Rgb albedo = albedoOf(Seen(*shader, shader.batch(1), degrees));
            EXPECT_LE(maxComponent(albedo), 1 + kSlack)
                << "metallic " << metallic << " roughness " << roughness << " coat " << coat
                << " sheen, anisotropy, " << other << " at " << degrees;
          }
        }
}

// White metal loses nothing, however rough; a white body under gloss next to nothing.
TEST(CustomLobes, PrincipledLosesLittle) {
  for (const float metallic : {0.0f, 1.0f})
    for (const float roughness : {0.1f, 0.5f, 0.8f, 1.0f}) {
      const BoundShader shader("principled", {number("metallic", metallic), number("roughness", roughness)});
      for (const double degrees : kAngles) {
        const Rgb albedo = albedoOf(Seen(*shader, shader.batch(1), degrees));
        EXPECT_GE(maxComponent(albedo), metallic > 0 ? 1 - 2 * kSlack : 0.93f)
            << metallic << ' ' << roughness << ' ' << degrees;
      }
    }
}

// A mirror of gold: what Schlick's formula says, by channel.
TEST(CustomLobes, MetalReflectsByFresnel) {
  const Triple gold{1, 0.71f, 0.29f};
  const BoundShader shader("principled", {number("metallic", 1), number("roughness", 0.1f),
                                          triple("basecolor", ValueType::Color, gold)});
  for (const double degrees : {0.0, 60.0, 80.0}) {
    const Rgb albedo = albedoOf(Seen(*shader, shader.batch(1), degrees));
    const double part = std::pow(1 - std::cos(degrees * std::numbers::pi / 180), 5);
    for (int c = 0; c < 3; ++c) {
      const auto head = double(gold[size_t(c)]);
      EXPECT_NEAR(double(albedo[c]), head + (1 - head) * part, 0.02) << degrees << ' ' << c;
    }
  }
}

/// Binds a plugin of the tests and evaluates its only lobe; what was reported about it.
std::vector<std::string> reportsOf(const std::string& name, Bsdf::Value* value,
                                   const V3f& wi = V3f(1, 0, 1).normalized()) {
  PluginLoader loader({{}, PATINA_BINARY_DIR "/tests/plugins", false});
  std::vector<std::string> messages;
  ErrorHandler errors([&](Severity, std::string_view text) { messages.emplace_back(text); });
  ShaderHost host(nullptr, nullptr);
  const PluginLoader::Result& found = loader.find(name);
  EXPECT_NE(found.shader, nullptr) << found.error;
  if (!found.shader) return messages;
  const auto shader = ShaderInstance::create(*found.shader, {name, {}, M44d(), {}}, host, errors);
  if (!shader) return messages;
  Batch batch(1);
  batch.points.values = shader->values().data();
  const Seen seen(*shader, std::move(batch), 30);
  *value = seen.bsdf().evaluate(wi);
  seen.bsdf().sample(0.5f, {0.3f, 0.6f});
  host.summarize(errors);
  return messages;
}

TEST(CustomLobes, WhatCannotBeUsedIsBlackAndCounted) {
  Bsdf::Value value;
  EXPECT_THAT(reportsOf("right_lobe", &value, V3f(1, 0, 1e-6f).normalized()), ElementsAre());
  EXPECT_NEAR(value.f.x, 0.5f * 1e-6f / kPi,
              1e-9f);  // 0.5 is the parameter, which reaches the lobe as its data
  EXPECT_NEAR(value.pdf, 1e-6f / kPi, 1e-9f);
  // One is wrong at the horizon, the other everywhere but there, where rounding might be meant.
  for (const auto& [name, height] : {std::pair("nan_lobe", 1e-6f), std::pair("negative_lobe", 1.0f)}) {
    EXPECT_THAT(
        reportsOf(name, &value, V3f(1, 0, height).normalized()),
        ElementsAre(HasSubstr("its lobe \"cosine\" gave values that are not finite, negative or too large")));
    EXPECT_EQ(value.f, Rgb(0, 0, 0));
    EXPECT_EQ(value.pdf, 0);
  }
  EXPECT_THAT(reportsOf("long_lobe_samples", &value),
              ElementsAre(HasSubstr("its lobe \"cosine\" gave directions that are not of unit length")));
}

TEST(CustomLobes, ThoseThatCannotBeUsedAreRefused) {
  Bsdf::Value value;
  EXPECT_THAT(
      reportsOf("nameless_lobe", &value),
      ElementsAre(HasSubstr("shader \"nameless_lobe\": its lobe \"\" has no name or no documentation")));
}

}  // namespace
}  // namespace patina::test
