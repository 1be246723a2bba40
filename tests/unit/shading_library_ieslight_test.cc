// SPDX-License-Identifier: Apache-2.0
// ieslight: its reader of IES LM-63 on good and on hostile files, its light against the file's candela; and
// the ramps of the lights that have one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include "shaders/ies_profile.h"
#include "tests/unit/plugins/bound_shader.h"

namespace patina::test {
namespace {

using shaders::IesProfile;
using testing::HasSubstr;

constexpr float kPi = 3.14159265f;

/// Numbers behind TILT=NONE: `vertical` and `horizontal` angles, and candela.
std::string table(const std::string& vertical, const std::string& horizontal, const std::string& candela,
                  int verticals, int horizontals, const std::string& factors = "2 1 1") {
  return "IESNA:LM-63-2002\r\n[TEST] none\r\nTILT=NONE\r\n1 -1 " + factors.substr(0, 1) + " " +
         std::to_string(verticals) + " " + std::to_string(horizontals) + " 1 2 0 0 0\r\n" +
         factors.substr(2) + " 100\r\n" + vertical + "\r\n" + horizontal + "\r\n" + candela + "\r\n";
}

TEST(IesProfile, IsLinearBetweenAnglesAndFollowsItsSymmetry) {
  const IesProfile round = IesProfile::parse(table("0 30,90", "0", "100 60 0", 3, 1), "round.ies");
  EXPECT_EQ(round.most(), 200);  // by the multiplier 2
  for (const float around : {0.0f, 123.0f, -50.0f}) {
    EXPECT_FLOAT_EQ(round.at(0, around), 200);
    EXPECT_FLOAT_EQ(round.at(15, around), 160);
    EXPECT_FLOAT_EQ(round.at(60, around), 60);
    EXPECT_FLOAT_EQ(round.at(90, around), 0);
    EXPECT_EQ(round.at(90.1f, around), 0);
  }
  // Quadrants, halves and all around: at(90, a) of what is a at the file's angles.
  const IesProfile quarter =
      IesProfile::parse(table("0 90", "0 45 90", "1 0  1 45  1 90", 2, 3, "1 1 1"), "q");
  for (const auto& [angle, candela] :
       {std::pair(20, 20), {90, 90}, {120, 60}, {180, 0}, {200, 20}, {300, 60}, {-10, 10}})
    EXPECT_NEAR(quarter.at(90, float(angle)), float(candela), 1e-4f) << angle;
  const IesProfile half = IesProfile::parse(table("0 90", "0 180", "1 0  1 180", 2, 2, "1 1 1"), "h");
  for (const auto& [angle, candela] : {std::pair(20, 20), {180, 180}, {200, 160}, {350, 10}})
    EXPECT_NEAR(half.at(90, float(angle)), float(candela), 1e-4f) << angle;
  const IesProfile across =
      IesProfile::parse(table("0 90", "90 180 270", "1 0  1 90  1 180", 2, 3, "1 1 1"), "a");
  for (const auto& [angle, candela] :
       {std::pair(90, 0), {180, 90}, {250, 160}, {0, 90}, {45, 45}, {300, 150}})
    EXPECT_NEAR(across.at(90, float(angle)), float(candela), 1e-4f) << angle;
  const IesProfile open =
      IesProfile::parse(table("0 90", "0 90 180 270", "1 0  1 90  1 180  1 270", 2, 4, "1 1 1"), "o");
  EXPECT_NEAR(open.at(90, 225), 225, 1e-3f);
  EXPECT_NEAR(open.at(90, 315), 135, 1e-3f);  // on its way back to 0
}

TEST(IesProfile, FluxIsTheIntegral) {
  // cos(theta) of 1 cd sends pi lumens; steps of a degree are linear to 4e-5.
  std::string vertical, candela;
  for (int k = 0; k <= 90; ++k) {
    vertical += std::to_string(k) + "\n";
    candela += std::to_string(std::cos(k * double(kPi) / 180)) + "\n";
  }
  EXPECT_NEAR(IesProfile::parse(table(vertical, "0", candela, 91, 1, "1 1 1"), "c").flux(), kPi, 1e-3f);
}

TEST(IesProfile, TiltIncludedIsSkippedAndTheBallastCounts) {
  const IesProfile p = IesProfile::parse(
      "IESNA91\nTILT=INCLUDE\n1\n3\n0 45 90\n1 .9 .8\n1 1000 1 2 1 1 1 0 0 0\n.5 1 60\n0 90\n0\n10 20\n",
      "t");
  EXPECT_FLOAT_EQ(p.at(0, 0), 5);
  EXPECT_FLOAT_EQ(p.at(90, 0), 10);
}

TEST(IesProfile, WhatIsWrongIsNamedWithItsLine) {
  const auto says = [](const std::string& text) {
    try {
      IesProfile::parse(text, "x.ies");
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string("nothing");
  };
  EXPECT_THAT(says(""), HasSubstr("x.ies:1: no line TILT="));
  EXPECT_THAT(says("IESNA91\n[A] b\n"), HasSubstr("x.ies:3: no line TILT="));
  EXPECT_THAT(says("TILT=other.tlt\n"), HasSubstr("x.ies:2: TILT is to be NONE or INCLUDE"));
  EXPECT_THAT(says("TILT=INCLUDE\n1\n-3\n"),
              HasSubstr("x.ies:3: the number of tilt angles is to be 0 to 10000"));
  EXPECT_THAT(says("TILT=NONE\n1 1000 1 nan 1"),
              HasSubstr("x.ies:2: the number of vertical angles is not a number"));
  EXPECT_THAT(says("TILT=NONE\n1 1000 1 1 1 1"),
              HasSubstr("the number of vertical angles is to be 2 to 10000"));
  EXPECT_THAT(says("TILT=NONE\n1 1000 1 1e9 1"),
              HasSubstr("the number of vertical angles is to be 2 to 10000"));
  EXPECT_THAT(says("TILT=NONE\n1 1000 1 2 1.5 1"),
              HasSubstr("the number of horizontal angles is to be 1 to 10000"));
  EXPECT_THAT(says("TILT=NONE\n1 1000 1 2 1 3 1 0 0 0 1 1 1"),
              HasSubstr("only profiles of the photometric type 1"));
  EXPECT_THAT(says("TILT=NONE\n1 1000 -1 2 1 1 1 0 0 0 1 1 1"), HasSubstr("are to be 0 or more"));
  EXPECT_THAT(says("TILT=NONE\n1 1000 1 9999 9999 1 1 0 0 0 1 1 1\n0 1"),
              HasSubstr("too short for its number"));
  EXPECT_THAT(says(table("0 0", "0", "1 1", 2, 1)),
              HasSubstr("x.ies:6: a vertical angle is not above the one before"));
  EXPECT_THAT(says(table("0 181", "0", "1 1", 2, 1)), HasSubstr("a vertical angle is out of its range"));
  EXPECT_THAT(says(table("0 90", "5", "1 1", 2, 1)), HasSubstr("x.ies:7: horizontal angles are to be"));
  EXPECT_THAT(says(table("0 90", "0 100", "1 1 1 1", 2, 2)), HasSubstr("horizontal angles are to be"));
  EXPECT_THAT(says(table("0 90", "0", "1 -1", 2, 1)), HasSubstr("x.ies:8: a candela value is negative"));
  EXPECT_THAT(says(table("0 90", "0", "1e300 1", 2, 1)),
              HasSubstr("a candela value is not a number that makes sense"));
  EXPECT_THAT(says(table("0 90", "0", "1", 2, 1)), HasSubstr("the file ends before a candela value"));
}

TEST(IesProfile, HostileFilesAreRefusedOrRead) {
  const std::string good = table("0 30 90", "0 90", "100 60 0  50 40 1e2", 3, 2);
  std::mt19937 random(1);
  int refused = 0;
  for (int k = 0; k < 20000; ++k) {
    std::string text = good;
    for (int change = 0; change < 1 + k % 3; ++change) {
      const size_t at = random() % text.size();
      switch (random() % 3) {
        case 0:
          text[at] = static_cast<char>(random() % 256);
          break;
        case 1:
          text.erase(at, 1 + random() % 8);
          break;
        default:
          text.insert(at, 1, "0123456789.-+e \n,"[random() % 17]);
      }
      if (text.empty()) text = " ";
    }
    try {
      const IesProfile p = IesProfile::parse(text, "h.ies");
      for (const float vertical : {0.0f, 17.0f, 90.0f, 180.0f})
        for (const float horizontal : {-400.0f, 0.0f, 77.0f, 360.0f}) {
          const float candela = p.at(vertical, horizontal);
          ASSERT_TRUE(candela >= 0 && candela <= p.most() * 1.0001f) << text;
        }
    } catch (const std::runtime_error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 1000);
  EXPECT_LT(refused, 19000);
  EXPECT_THROW(IesProfile::read("/nowhere.ies"), std::runtime_error);
  EXPECT_THROW(IesProfile::read("/dev/zero"), std::runtime_error);
}

/// Cl for a point.
Triple lit(const BoundShader& shader, const Triple& P) {
  Batch batch = shader.batch(1);
  batch.lightIn.task = PATINA_LIGHT_SAMPLE;
  batch.lightIn.P = batch.uniform(P);
  PatinaLightOut out = batch.lightOut();
  EXPECT_EQ(shader->light(batch.lightIn, out), PATINA_OK);
  return get(out.radiance, 0);
}

class IesLight : public testing::Test {
 protected:
  IesLight() {
    std::string name = testing::TempDir() + "patina-ies-XXXXXX";
    folder_ = mkdtemp(name.data());
    file_ = folder_ + "/lamp.ies";
    std::ofstream(file_) << table("0 90 180", "0 90 180 270 360", "10 2 0  10 4 0  10 6 0  10 8 0  10 2 0", 3,
                                  5, "1 1 1");
  }
  ~IesLight() override { std::filesystem::remove_all(folder_); }
  std::string folder_, file_;
};

TEST_F(IesLight, ShinesByTheFile) {
  // Down along -z; horizontal angles from x to y of shader space, seen from the lamp as any handedness has
  // them.
  const auto lamp = [&](int normalize, const M44d& space = M44d()) {
    return BoundShader(
        "ieslight",
        {text("profile", file_), integer("normalize", normalize), number("intensity", 3),
         triple("from", ValueType::Point, {0, 0, 0}), triple("to", ValueType::Point, {0, 0, 1})},
        space);
  };
  const BoundShader one = lamp(1);
  expectNear(lit(one, {0, 0, 2}), {0.75f, 0.75f, 0.75f}, 1e-5f);  // 3 / 2^2
  for (const auto& [P, candela] : {std::pair(Triple{1, 0, 0}, 2.0f),
                                   {Triple{0, 1, 0}, 4.0f},
                                   {Triple{-1, 0, 0}, 6.0f},
                                   {Triple{0, -1, 0}, 8.0f},
                                   {Triple{1, 0, 1}, 6.0f},
                                   {Triple{1, 1, 0}, 3.0f},
                                   {Triple{0, 1, -1}, 2.0f}}) {
    const float square = P[0] * P[0] + P[1] * P[1] + P[2] * P[2], cl = 0.3f * candela / square;
    expectNear(lit(one, P), {cl, cl, cl}, 1e-4f);
    const float unnormalized = 3 * candela / (kPi * square);
    expectNear(lit(lamp(0), P), {unnormalized, unnormalized, unnormalized}, 1e-4f);
  }
  // A mirrored space mirrors the profile.
  M44d mirror;
  mirror[1][1] = -1;
  const float cl = 0.3f * 8;
  expectNear(lit(lamp(1, mirror), {0, 1, 0}), {cl, cl, cl}, 1e-4f);
}

TEST(DistanceRamps, GoFromOneColourToTheOther) {
  for (const char* name : {"pointlight", "spotlight", "ieslight"}) {
    const BoundShader lamp(name, {number("rampbegin", 2), number("rampend", 4),
                                  triple("rampbegincolor", ValueType::Color, {1, 0.5f, 0}),
                                  triple("rampendcolor", ValueType::Color, {0, 0.5f, 2})});
    for (const auto& [distance, t] :
         {std::pair(1.0f, 0.0f), {2.0f, 0.0f}, {2.5f, 0.25f}, {4.0f, 1.0f}, {9.0f, 1.0f}}) {
      const float s = 1 / (distance * distance);
      expectNear(lit(lamp, {0, 0, distance}), {(1 - t) * s, 0.5f * s, 2 * t * s}, 1e-5f);
    }
    EXPECT_EQ(lamp->traits().flags & PATINA_TRAIT_FROM_POINT, 0u) << "it falls off otherwise";
    const BoundShader plain(name);
    expectNear(lit(plain, {0, 0, 9}), {1 / 81.0f, 1 / 81.0f, 1 / 81.0f}, 1e-5f);
    EXPECT_NE(plain->traits().flags & PATINA_TRAIT_FROM_POINT, 0u);
    // A step.
    const BoundShader step(name, {number("rampbegin", 3), number("rampend", 3)});
    expectNear(lit(step, {0, 0, 2.99f}), {1 / 8.9401f, 1 / 8.9401f, 1 / 8.9401f}, 1e-5f);
    EXPECT_EQ(lit(step, {0, 0, 3.01f})[1], 0) << name;
  }
}

}  // namespace
}  // namespace patina::test
