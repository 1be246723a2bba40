// SPDX-License-Identifier: Apache-2.0
// The standard surfaces against the formulas of RI 3.2, section A: Ci with each light term apart.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/unit/plugins/bound_shader.h"

namespace patina::test {
namespace {

constexpr Triple kCs{0.8f, 0.5f, 0.2f}, kOs{1, 0.5f, 0.25f};

Triple times(const Triple& a, const Triple& b, float f = 1) {
  return {a[0] * b[0] * f, a[1] * b[1] * f, a[2] * b[2] * f};
}

// Twenty points of different colours and directions; the first has kCs, kOs and is seen head-on.
Batch surfacePoints(const BoundShader& shader) {
  Batch batch = shader.batch(20);
  batch.points.Cs = batch.varying3([](uint32_t i) { return times(kCs, {1, 1, 1}, 1 - 0.04f * float(i)); });
  batch.points.Os = batch.uniform(kOs);
  batch.points.N = batch.uniform({0, 0, -1});
  batch.points.I = batch.varying3([](uint32_t i) {
    const float a = 0.07f * float(i);
    return Triple{std::sin(a), 0, std::cos(a)};
  });
  return batch;
}

const Triple kBlack{0, 0, 0};

TEST(StandardSurfaces, Constant) {
  const BoundShader shader("constant");
  Batch batch = surfacePoints(shader);
  PatinaRadiosityOut out = batch.radiosityOut();
  ASSERT_EQ(shader->radiosity(batch.points, out), PATINA_OK);
  for (uint32_t i = 0; i < 20; ++i) {
    expectNear(get(out.emission, i), times(kOs, get(batch.points.Cs, i)));
    expectNear(get(out.opacity, i), kOs);
    expectNear(get(out.reflectance, i), kBlack);
  }
  EXPECT_FALSE(shader->active(PATINA_ENTRY_VIEW));
}

TEST(StandardSurfaces, ShowSt) {
  const BoundShader shader("showst");
  Batch batch = surfacePoints(shader);
  const auto s = [](uint32_t i) { return 0.125f * float(i) - 0.5f; };  // -0.5 to 1.875
  batch.points.s = batch.varying(s);
  batch.points.t = batch.varying([](uint32_t i) { return 0.05f * float(i); });
  PatinaRadiosityOut out = batch.radiosityOut();
  ASSERT_EQ(shader->radiosity(batch.points, out), PATINA_OK);
  for (uint32_t i = 0; i < 20; ++i) {
    const float shown = s(i) >= 0 && s(i) <= 1 ? s(i) : s(i) - std::floor(s(i));
    expectNear(get(out.emission, i), times({shown, 0.05f * float(i), 0}, kOs));
    expectNear(get(out.reflectance, i), kBlack);
    expectNear(get(out.opacity, i), kOs);
  }
}

TEST(StandardSurfaces, Matte) {
  const Triple emission{3, 2, 1};
  const BoundShader shader(
      "matte", {number("Ka", 0.25f), number("Kd", 0.5f), triple("emission", ValueType::Color, emission)});
  Batch batch = surfacePoints(shader);
  PatinaRadiosityOut out = batch.radiosityOut();
  ASSERT_EQ(shader->radiosity(batch.points, out), PATINA_OK);
  for (uint32_t i = 0; i < 20; ++i) {
    const Triple color = times(kOs, get(batch.points.Cs, i));
    expectNear(get(out.reflectance, i), times(color, {1, 1, 1}, 0.5f));
    expectNear(get(out.ambient, i), times(color, {1, 1, 1}, 0.25f));
    expectNear(get(out.emission, i), times(emission, kOs));
    expectNear(get(out.transmittance, i), kBlack);
    expectNear(get(out.opacity, i), kOs);
  }
}

TEST(StandardSurfaces, Plastic) {
  const Triple highlight{1, 0.5f, 0.1f};
  const BoundShader shader(
      "plastic", {number("Ka", 0.3f), number("Kd", 0.6f), number("Ks", 0.4f), number("roughness", 0.2f),
                  triple("specularcolor", ValueType::Color, highlight)});
  Batch batch = surfacePoints(shader);
  PatinaRadiosityOut out = batch.radiosityOut();
  PatinaViewOut view = batch.viewOut();
  ASSERT_EQ(shader->radiosity(batch.points, out), PATINA_OK);
  ASSERT_EQ(shader->view(batch.points, view), PATINA_OK);
  ASSERT_EQ(view.lobe_count, 1u);
  EXPECT_EQ(view.lobes[0].type, PATINA_LOBE_RI_SPECULAR);
  for (uint32_t i = 0; i < 20; ++i) {
    const Triple color = times(kOs, get(batch.points.Cs, i));
    expectNear(get(out.reflectance, i), times(color, {1, 1, 1}, 0.6f));
    expectNear(get(out.ambient, i), times(color, {1, 1, 1}, 0.3f));
    expectNear(get(view.lobes[0].weight, i), times(kOs, highlight, 0.4f));
    EXPECT_FLOAT_EQ(view.lobes[0].alpha[i], 0.2f);
    expectNear(get(view.emission, i), kBlack);
  }
}

TEST(StandardSurfaces, Metal) {
  const BoundShader shader("metal", {number("Ka", 0.3f), number("Ks", 0.7f)});
  Batch batch = surfacePoints(shader);
  PatinaRadiosityOut out = batch.radiosityOut();
  PatinaViewOut view = batch.viewOut();
  ASSERT_EQ(shader->radiosity(batch.points, out), PATINA_OK);
  ASSERT_EQ(shader->view(batch.points, view), PATINA_OK);
  const Triple color = times(kOs, get(batch.points.Cs, 3));
  expectNear(get(out.reflectance, 3), kBlack);
  expectNear(get(out.ambient, 3), times(color, {1, 1, 1}, 0.3f));
  expectNear(get(view.lobes[0].weight, 3), times(color, {1, 1, 1}, 0.7f));
  EXPECT_FLOAT_EQ(view.lobes[0].alpha[3], 0.1f);
}

TEST(StandardSurfaces, ShinyMetalMirrorsTheSceneWithoutAPicture) {
  const BoundShader shader("shinymetal", {number("Ks", 0.7f), number("Kr", 0.9f)});
  Batch batch = surfacePoints(shader);
  PatinaViewOut view = batch.viewOut();
  ASSERT_EQ(shader->view(batch.points, view), PATINA_OK);
  ASSERT_EQ(view.lobe_count, 2u);
  EXPECT_EQ(view.lobes[1].type, PATINA_LOBE_GGX);
  const Triple color = times(kOs, get(batch.points.Cs, 5));
  expectNear(get(view.lobes[0].weight, 5), times(color, {1, 1, 1}, 0.7f));
  expectNear(get(view.lobes[1].weight, 5), times(color, {1, 1, 1}, 0.9f));
  EXPECT_EQ(view.lobes[1].alpha[5], 0);
  expectNear(get(view.emission, 5), kBlack);
}

TEST(StandardSurfaces, DefaultSurfaceIsLitByTheViewer) {
  const BoundShader shader("defaultsurface");
  Batch batch = surfacePoints(shader);
  PatinaViewOut view = batch.viewOut();
  ASSERT_EQ(shader->view(batch.points, view), PATINA_OK);
  EXPECT_EQ(view.lobe_count, 0u);
  for (uint32_t i = 0; i < 20; ++i) {
    const float cosine = std::cos(0.07f * float(i));
    expectNear(get(view.emission, i), times(kOs, get(batch.points.Cs, i), 0.2f + 0.8f * cosine * cosine),
               1e-5f);
  }
}

TEST(StandardSurfaces, Conductor) {
  const Triple reflectance{0.9f, 0.6f, 0.3f};
  const BoundShader shader("conductor",
                           {triple("reflectance", ValueType::Color, reflectance), number("alpha", 0.3f)});
  Batch batch = surfacePoints(shader);
  PatinaViewOut view = batch.viewOut();
  ASSERT_EQ(shader->view(batch.points, view), PATINA_OK);
  ASSERT_EQ(view.lobe_count, 1u);
  EXPECT_EQ(view.lobes[0].type, PATINA_LOBE_GGX);
  expectNear(get(view.lobes[0].weight, 7), times(kOs, reflectance));
  EXPECT_FLOAT_EQ(view.lobes[0].alpha[7], 0.3f);
}

TEST(StandardSurfaces, Dielectric) {
  const Triple tint{0.9f, 1, 0.8f};
  const BoundShader shader("dielectric",
                           {number("ior", 1.33f), triple("transmittance", ValueType::Color, tint)});
  Batch batch = surfacePoints(shader);
  PatinaViewOut view = batch.viewOut();
  ASSERT_EQ(shader->view(batch.points, view), PATINA_OK);
  ASSERT_EQ(view.lobe_count, 1u);
  EXPECT_EQ(view.lobes[0].type, PATINA_LOBE_DIELECTRIC);
  expectNear(get(view.lobes[0].weight, 7), {1, 1, 1});
  expectNear(get(view.lobes[0].transmission, 7), tint);
  EXPECT_FLOAT_EQ(view.lobes[0].eta[7], 1.33f);
  EXPECT_EQ(view.lobes[0].alpha[7], 0);
}

TEST(StandardSurfaces, NullIsNotThere) {
  const BoundShader shader("null");
  EXPECT_TRUE(shader->has(PATINA_TRAIT_TRANSPARENT));
  Batch batch = surfacePoints(shader);
  PatinaRadiosityOut out = batch.radiosityOut();
  ASSERT_EQ(shader->radiosity(batch.points, out), PATINA_OK);
  for (uint32_t i = 0; i < 20; ++i) expectNear(get(out.opacity, i), kBlack);
}

// A primitive variable in the place of a varying parameter.
// Kd and Kt are each in [0, 1], and together they share out all the light at most.
TEST(StandardSurfaces, LeafSharesOutNoMoreLightThanItGets) {
  for (const auto& [kd, kt, reflected, transmitted] :
       {std::array{0.5f, 0.25f, 0.5f, 0.25f}, std::array{1.0f, 1.0f, 0.5f, 0.5f},
        std::array{1.0f, 0.0f, 1.0f, 0.0f}, std::array{0.9f, 0.6f, 0.6f, 0.4f}}) {
    const BoundShader shader("leaf", {number("Kd", kd), number("Kt", kt)});
    Batch batch = surfacePoints(shader);
    batch.points.s = batch.points.t = batch.uniform(0.5f);  // well inside
    batch.points.footprint = batch.points.footprint_st = batch.uniform(0.01f);
    PatinaRadiosityOut out = batch.radiosityOut();
    ASSERT_EQ(shader->radiosity(batch.points, out), PATINA_OK);
    for (uint32_t i = 0; i < 20; ++i) {
      const Triple color = times(kOs, get(batch.points.Cs, i));
      expectNear(get(out.reflectance, i), times(color, {1, 1, 1}, reflected), 1e-5f);
      expectNear(get(out.transmittance, i), times(color, {1, 1, 1}, transmitted), 1e-5f);
    }
  }
}

TEST(StandardDisplacements, BumpyMovesNothingWithoutATexture) {
  const BoundShader shader("bumpy", {number("Km", 2)});
  EXPECT_FALSE(shader->active(PATINA_ENTRY_DISPLACEMENT));
  Batch batch = surfacePoints(shader);
  batch.points.P = batch.uniform({1, 2, 3});
  batch.points.s = batch.points.t = batch.points.footprint_st = batch.uniform(0.5f);
  PatinaDisplacementOut out = batch.displacementOut();
  ASSERT_EQ(shader->displacement(batch.points, out), PATINA_OK);
  for (uint32_t i = 0; i < 20; ++i) expectNear(get(out.P, i), {1, 2, 3});
}

// At coordinates that have no whole number of 32 bits, noise() is finite all the same.
TEST(StandardDisplacements, DentedStaysWithinItsBoundFarAway) {
  const BoundShader shader("dented", {number("Km", 0.5f)});
  for (const float far : {1e3f, 3e9f, 5e14f}) {
    Batch batch = surfacePoints(shader);
    batch.points.P = batch.uniform({far, -far, 0.25f});
    PatinaDisplacementOut out = batch.displacementOut();
    ASSERT_EQ(shader->displacement(batch.points, out), PATINA_OK);
    for (uint32_t i = 0; i < 20; ++i) EXPECT_LE(std::abs(get(out.P, i)[2] - 0.25f), 0.5f) << far;
  }
}

TEST(StandardSurfaces, VaryingParametersAreReadPerPoint) {
  const BoundShader shader("matte");
  Batch batch = surfacePoints(shader);
  std::vector<PatinaValue> values(shader->values().begin(), shader->values().end());
  const auto kd = [](uint32_t i) { return 0.05f * float(i); };
  for (const ShaderInstance::VaryingParameter& p : shader->varyingParameters())
    if (p.name == "Kd") values[p.index] = {batch.varying(kd).data, nullptr, nullptr, 1, 0, 1, 1};
  batch.points.values = values.data();
  PatinaRadiosityOut out = batch.radiosityOut();
  ASSERT_EQ(shader->radiosity(batch.points, out), PATINA_OK);
  for (uint32_t i = 0; i < 20; ++i)
    expectNear(get(out.reflectance, i), times(kOs, get(batch.points.Cs, i), kd(i)));
}

}  // namespace
}  // namespace patina::test
