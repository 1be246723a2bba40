// SPDX-License-Identifier: Apache-2.0
// The library's pattern shaders: facts in closed form, what holds for all parameters in range, and what
// filtering must not change.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/unit/plugins/bound_shader.h"

namespace patina::test {
namespace {

/// `side` * `side` points in the middles of a grid's cells over s and t (and x and y) from 0 to 1.
Batch gridOver(const BoundShader& shader, uint32_t side, float footprint) {
  Batch batch = shader.batch(side * side);
  const auto along = [&](uint32_t i) { return (float(i) + 0.5f) / float(side); };
  batch.points.s = batch.varying([&](uint32_t i) { return along(i % side); });
  batch.points.t = batch.varying([&](uint32_t i) { return along(i / side); });
  batch.points.P = batch.varying3([&](uint32_t i) {
    return Triple{along(i % side), along(i / side), 0.37f};
  });
  batch.points.N = batch.uniform({0, 0, 1});
  batch.points.footprint = batch.points.footprint_st = batch.uniform(footprint);
  batch.points.Cs = batch.points.Os = batch.uniform({1, 1, 1});
  return batch;
}

struct Seen {
  Triple mean{}, least{1e30f, 1e30f, 1e30f}, most{};
};
Seen seenOf(const PatinaOut3& out, uint32_t count) {
  Seen seen;
  for (size_t c = 0; c < 3; ++c) {
    double sum = 0;
    for (uint32_t i = 0; i < count; ++i) {
      const float v = get(out, i)[c];
      sum += double(v);
      seen.least[c] = std::min(seen.least[c], v), seen.most[c] = std::max(seen.most[c], v);
    }
    seen.mean[c] = float(sum / count);
  }
  return seen;
}

Seen reflectanceOf(const BoundShader& shader, uint32_t side, float footprint) {
  Batch batch = gridOver(shader, side, footprint);
  PatinaRadiosityOut out = batch.radiosityOut();
  EXPECT_EQ(shader->radiosity(batch.points, out), PATINA_OK);
  return seenOf(out.reflectance, side * side);
}

// Whatever the footprint: half of the squares of each pair is white.
TEST(LibraryShaders, CheckerReflectsHalf) {
  const BoundShader shader("checker", {number("Kd", 0.8f), number("frequency", 4),
                                       triple("blackcolor", ValueType::Color, {0.1f, 0, 0})});
  for (const float footprint : {0.0f, 0.01f, 0.06f, 0.3f, 5.0f}) {
    const Seen seen = reflectanceOf(shader, 64, footprint);
    expectNear(seen.mean, {0.8f * 0.55f, 0.8f * 0.5f, 0.8f * 0.5f}, 1e-3f);
  }
  EXPECT_NEAR(reflectanceOf(shader, 64, 0).most[0], 0.8f, 1e-3f);
  EXPECT_NEAR(reflectanceOf(shader, 64, 0).least[0], 0.08f, 1e-3f);
}

// Bricks of colour 1 and black mortar of an eighth of the height, a third of that of the length: over whole
// bricks and courses the mean is the bricks' share, 7/8 * 23/24, at each footprint.
TEST(LibraryShaders, BricksCoverTheirShare) {
  const BoundShader shader("brick", {number("frequency", 4), number("aspect", 3), number("mortar", 0.125f),
                                     number("jitter", 0), triple("brickcolor", ValueType::Color, {1, 1, 1}),
                                     triple("mortarcolor", ValueType::Color, {0, 0, 0})});
  // The grid has 8 points to a joint along t and along s: an edge is misplaced by one at most.
  for (const float footprint : {0.0f, 0.003f, 0.02f, 1.0f, 20.0f})
    EXPECT_NEAR(reflectanceOf(shader, 768, footprint).mean[0], 7.0f / 8 * 23 / 24, 4e-3f) << footprint;
}

TEST(LibraryShaders, BricksDifferByJitter) {
  const BoundShader shader("brick", {number("frequency", 16), number("mortar", 0), number("jitter", 0.6f),
                                     triple("brickcolor", ValueType::Color, {0.5f, 0.5f, 0.5f}),
                                     triple("mortarcolor", ValueType::Color, {0.3f, 0.3f, 0.3f})});
  const Seen sharp = reflectanceOf(shader, 384, 0), wide = reflectanceOf(shader, 16, 3);
  for (size_t c = 0; c < 3; ++c) {
    EXPECT_LE(sharp.most[c], 0.5f);
    EXPECT_GE(sharp.least[c], 0.2f);
    EXPECT_GT(sharp.most[c] - sharp.least[c], 0.2f);
    EXPECT_NEAR(sharp.mean[c], 0.35f, 0.015f);  // five deviations: 768 bricks, uniform over 0.3
    EXPECT_NEAR(wide.least[c], 0.35f, 1e-5f);
    EXPECT_NEAR(wide.most[c], 0.35f, 1e-5f);
  }
}

// What is filtered keeps its mean: a pattern far away is neither darker nor brighter than the same near by.
// The bound: four deviations of the sum over some 4000 cells.
TEST(LibraryShaders, FootprintsKeepTheMean) {
  for (const char* name : {"wood", "marble", "granite"}) {
    const BoundShader shader(name, {number("frequency", 64)});
    const Seen sharp = reflectanceOf(shader, 512, 0.001f), wide = reflectanceOf(shader, 64, 2);
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(wide.mean[c] / sharp.mean[c], 1, 0.04) << name << ' ' << c;
    EXPECT_GT(sharp.most[1] - sharp.least[1], 0.15f) << name;
    EXPECT_LT(wide.most[1] - wide.least[1], 1e-3f) << name;
  }
}

// Numbers and colours anywhere in the ranges that the shader's own table states.
std::vector<ShaderArgument> randomArguments(const char* name, std::mt19937& random) {
  PluginLoader loader{ShaderPaths{}};
  const PatinaShader& shader = *loader.find(name).shader;
  std::vector<ShaderArgument> arguments;
  for (uint32_t i = 0; i < shader.parameter_count; ++i) {
    const PatinaParameter& p = shader.parameters[i];
    const auto draw = [&] {
      const double low = p.minimum, high = std::min(p.maximum, 30.0);
      return static_cast<float>(low + (high - low) * static_cast<double>(random() >> 8) / 0xffffff);
    };
    if (p.minimum > p.maximum) continue;
    if (p.type == PATINA_FLOAT) arguments.push_back(number(p.name, draw()));
    if (p.type == PATINA_COLOR)
      arguments.push_back(triple(p.name, ValueType::Color, {draw(), draw(), draw()}));
  }
  return arguments;
}

TEST(LibraryShaders, ReflectNoMoreThanTheyGet) {
  std::mt19937 random(3);
  for (const char* name : {"checker", "brick", "wood", "marble", "granite", "texturedmatte", "cutout"})
    for (int round = 0; round < 20; ++round) {
      const BoundShader shader(name, randomArguments(name, random));
      if (!shader->active(PATINA_ENTRY_RADIOSITY)) continue;
      Batch batch = gridOver(shader, 24, round % 3 ? 0.02f * float(round) : 0);
      PatinaRadiosityOut out = batch.radiosityOut();
      ASSERT_EQ(shader->radiosity(batch.points, out), PATINA_OK);
      for (uint32_t i = 0; i < 24 * 24; ++i)
        for (size_t c = 0; c < 3; ++c) {
          const float rho = get(out.reflectance, i)[c], tau = get(out.transmittance, i)[c];
          ASSERT_GE(rho, 0) << name;
          ASSERT_GE(tau, 0) << name;
          ASSERT_LE(rho + tau, get(out.opacity, i)[c] + 1e-5f) << name;
          ASSERT_GE(get(out.opacity, i)[c], 0) << name;
          ASSERT_LE(get(out.opacity, i)[c], 1) << name;
        }
    }
}

TEST(LibraryShaders, NoisebumpStaysWithinItsBound) {
  std::mt19937 random(4);
  for (int round = 0; round < 30; ++round) {
    const float height = 0.01f * float(round + 1) * (round % 2 ? -1.0f : 1.0f);
    std::vector<ShaderArgument> arguments = randomArguments("noisebump", random);
    arguments.push_back(number("Km", height));
    const BoundShader shader("noisebump", arguments);
    Batch batch = gridOver(shader, 48, 0);
    PatinaDisplacementOut out = batch.displacementOut();
    ASSERT_EQ(shader->displacement(batch.points, out), PATINA_OK);
    EXPECT_FLOAT_EQ(shader->traits().displacement_bound, std::abs(height));
    float furthest = 0;
    for (uint32_t i = 0; i < 48 * 48; ++i) {
      furthest = std::max(furthest, std::abs(get(out.P, i)[2] - 0.37f));
      ASSERT_EQ(get(out.P, i)[0], get(batch.points.P, i)[0]);
    }
    EXPECT_LE(furthest, std::abs(height) + 1e-6f);
    EXPECT_GT(furthest, 0.05f * std::abs(height));
  }
}

TEST(LibraryShaders, NoisebumpIsFlatForWideFootprints) {
  const BoundShader shader("noisebump", {number("Km", 1), number("frequency", 4)});
  Batch batch = gridOver(shader, 16, 0.5f);
  PatinaDisplacementOut out = batch.displacementOut();
  ASSERT_EQ(shader->displacement(batch.points, out), PATINA_OK);
  for (uint32_t i = 0; i < 16 * 16; ++i) EXPECT_EQ(get(out.P, i)[2], 0.37f);
}

TEST(LibraryShaders, CutoutHasRoundHoles) {
  const BoundShader shader("cutout", {number("frequency", 4), number("radius", 0.4f), number("Kd", 0.5f)});
  const auto opacity = [&](float footprint) {
    Batch batch = gridOver(shader, 256, footprint);
    PatinaRadiosityOut out = batch.radiosityOut();
    EXPECT_EQ(shader->radiosity(batch.points, out), PATINA_OK);
    return seenOf(out.opacity, 256 * 256);
  };
  const float solid = 1 - std::acos(-1.0f) * 0.16f;
  EXPECT_NEAR(opacity(0).mean[0], solid, 5e-3);  // 64 points across a hole's cell
  EXPECT_EQ(opacity(0).least[0], 0);
  EXPECT_EQ(opacity(0).most[0], 1);
  EXPECT_NEAR(opacity(0.02f).mean[0], solid, 5e-3);
  EXPECT_NEAR(opacity(1).least[0], solid, 1e-5);
  EXPECT_FALSE(shader->traits().flags & PATINA_TRAIT_OPACITY_IS_OS);
}

TEST(LibraryShaders, WhatDoesNothingIsNotCalled) {
  EXPECT_FALSE(BoundShader("noisebump", {number("Km", 0)})->active(PATINA_ENTRY_DISPLACEMENT));
  EXPECT_FALSE(BoundShader("displace")->active(PATINA_ENTRY_DISPLACEMENT));
  EXPECT_FLOAT_EQ(
      BoundShader("displace", {number("Km", -2), number("middle", 0.25f)})->traits().displacement_bound,
      1.5f);
  EXPECT_TRUE(BoundShader("cutout", {number("radius", 0)})->traits().flags & PATINA_TRAIT_OPACITY_IS_OS);
  for (const char* name : {"wood", "marble", "granite"}) {
    const BoundShader dull(name, {number("Ks", 0)}), dark(name, {number("Ka", 0), number("Kd", 0)});
    EXPECT_TRUE(dull->active(PATINA_ENTRY_RADIOSITY));
    EXPECT_FALSE(dull->active(PATINA_ENTRY_VIEW));
    EXPECT_FALSE(dark->active(PATINA_ENTRY_RADIOSITY));
    EXPECT_TRUE(dark->traits().flags & PATINA_TRAIT_BLACK);
    EXPECT_TRUE(dark->active(PATINA_ENTRY_VIEW));
  }
}

// Patterns in shader space move with it.
TEST(LibraryShaders, SolidPatternsAreInShaderSpace) {
  M44d moved;
  moved[3][0] = 5, moved[3][1] = -3;
  for (const char* name : {"wood", "marble", "granite"}) {
    const BoundShader here(name), there(name, {}, moved);
    Batch a = gridOver(here, 8, 0), b = gridOver(there, 8, 0);
    b.points.P = b.varying3([&](uint32_t i) {
      const Triple p = get(a.points.P, i);
      return Triple{p[0] + 5, p[1] - 3, p[2]};
    });
    PatinaRadiosityOut first = a.radiosityOut(), second = b.radiosityOut();
    ASSERT_EQ(here->radiosity(a.points, first), PATINA_OK);
    ASSERT_EQ(there->radiosity(b.points, second), PATINA_OK);
    for (uint32_t i = 0; i < 64; ++i)
      expectNear(get(second.reflectance, i), get(first.reflectance, i), 1e-3f);
  }
}

}  // namespace
}  // namespace patina::test
