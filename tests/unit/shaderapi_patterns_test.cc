// SPDX-License-Identifier: Apache-2.0
// Filtered steps and pulses against numerical integration, splines, colours, and transforms.
#include <gtest/gtest.h>
#include <patina/sdk.h>
#include <patina/sdk/color.h>
#include <patina/sdk/filter.h>
#include <patina/sdk/spline.h>

#include <cmath>
#include <string>
#include <string_view>

namespace patina::test {
namespace {

using namespace patina::sdk;

/// The mean of f over x +- width / 2 by the midpoint rule: a jump of 1 is misplaced by half a step at most.
constexpr int kSteps = 2000;
template <class F>
float integrated(const F& f, float x, float width) {
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) sum += f(x + width * ((float(i) + 0.5f) / kSteps - 0.5f));
  return float(sum / kSteps);
}

TEST(ShaderFilter, IsTheMeanOverTheFootprint) {
  for (const float width : {0.05f, 0.3f, 0.9f, 1.7f, 4.2f})
    for (float x = -3.03f; x < 3; x += 0.171f) {
      const float jump = 1.5f * std::ceil(width + 1) * 2 / kSteps;  // of each edge met
      EXPECT_NEAR(filteredStep(0.4f, x, width),
                  integrated([](float y) { return y < 0.4f ? 0.0f : 1.0f; }, x, width), jump);
      EXPECT_NEAR(filteredPulse(-0.5f, 0.4f, x, width),
                  integrated([](float y) { return y < -0.5f || y > 0.4f ? 0.0f : 1.0f; }, x, width), jump);
      EXPECT_NEAR(filteredPulseTrain(0.3f, x, width),
                  integrated([](float y) { return y - std::floor(y) < 0.3f ? 1.0f : 0.0f; }, x, width), jump);
      EXPECT_NEAR(filteredSmoothstep(-1, 0.5f, x, width),
                  integrated([](float y) { return smoothstep(-1, 0.5f, y); }, x, width), 1e-4);
      const float white =
          integrated([](float y) { return y - std::floor(y) < 0.5f ? 1.0f : -1.0f; }, x, width);
      const float other =
          integrated([](float y) { return y - std::floor(y) < 0.5f ? 1.0f : -1.0f; }, 0.3f, width);
      EXPECT_NEAR(filteredChecker(x, 0.3f, width), 0.5f + 0.5f * white * other, 2 * jump);
    }
}

TEST(ShaderFilter, WithoutAFootprintIsTheFunctionItself) {
  EXPECT_EQ(filteredStep(2, 1.999f, 0), 0);
  EXPECT_EQ(filteredStep(2, 2.001f, 0), 1);
  EXPECT_EQ(filteredSmoothstep(1, 2, 1.25f, 0), smoothstep(1, 2, 1.25f));
  EXPECT_NEAR(filteredPulseTrain(0.3f, -6.8f, 0), 1, 2e-3);
  EXPECT_NEAR(filteredPulseTrain(0.3f, -6.6f, 0), 0, 2e-3);
  EXPECT_NEAR(filteredChecker(0.2f, 0.2f, 0), 1, 4e-3);
  EXPECT_NEAR(filteredChecker(0.7f, 0.2f, 0), 0, 4e-3);
  EXPECT_NEAR(filteredChecker(-0.3f, -0.2f, 0), 1, 4e-3);
}

TEST(ShaderFilter, WideFootprintsSeeTheMean) {
  EXPECT_NEAR(filteredPulseTrain(0.3f, 5.1f, 1000), 0.3f, 1e-3);
  EXPECT_NEAR(filteredChecker(1.2f, 0.2f, 64), 0.5f, 1e-4);
}

TEST(ShaderSpline, HitsItsKnots) {
  const std::array<float, 7> values{9, 1, -2, 3, 0.5f, 4, -9};
  for (int i = 0; i <= 4; ++i) EXPECT_NEAR(spline(float(i) / 4, values), values[size_t(i) + 1], 1e-5);
  EXPECT_EQ(spline(-3, values), 1);
  EXPECT_EQ(spline(7, values), 4);
}

// The matrix of RI 3.2's "catmull-rom" basis (section 5), written out.
TEST(ShaderSpline, IsCatmullRom) {
  const std::array<Color, 5> values{Color(1, 0, 2), Color(0, 5, 1), Color(2, 2, 2), Color(4, 1, 0),
                                    Color(1, 1, 1)};
  for (int segment = 0; segment < 2; ++segment)
    for (float t = 0; t < 1; t += 0.125f) {
      const Color *p = &values[size_t(segment)], seen = spline((float(segment) + t) / 2, values);
      const Color expected = (p[0] * (-t * t * t + 2 * t * t - t) + p[1] * (3 * t * t * t - 5 * t * t + 2) +
                              p[2] * (-3 * t * t * t + 4 * t * t + t) + p[3] * (t * t * t - t * t)) *
                             0.5f;
      EXPECT_NEAR(seen.r, expected.r, 1e-5);
      EXPECT_NEAR(seen.g, expected.g, 1e-5);
      EXPECT_NEAR(seen.b, expected.b, 1e-5);
    }
}

TEST(ShaderColor, SrgbIsThatOfTheStandard) {
  EXPECT_NEAR(srgbToLinear(0.5f), 0.2140411, 1e-6);
  EXPECT_NEAR(srgbToLinear(0.04f), 0.04 / 12.92, 1e-7);
  EXPECT_NEAR(linearToSrgb(0.18f), 0.4613561, 1e-6);
  for (int i = 0; i <= 255; ++i)
    EXPECT_NEAR(linearToSrgb(srgbToLinear(float(i) / 255)), float(i) / 255, 2e-6);
}

TEST(ShaderColor, HsvGoesThereAndBack) {
  const auto expectColor = [](const Color& a, const Color& b) {
    EXPECT_NEAR(a.r, b.r, 2e-6);
    EXPECT_NEAR(a.g, b.g, 2e-6);
    EXPECT_NEAR(a.b, b.b, 2e-6);
  };
  expectColor(hsvToRgb({0, 1, 1}), {1, 0, 0});
  expectColor(hsvToRgb({1.0f / 6, 1, 0.5f}), {0.5f, 0.5f, 0});
  expectColor(hsvToRgb({1.0f / 3, 1, 1}), {0, 1, 0});
  expectColor(hsvToRgb({2.0f / 3, 0.5f, 1}), {0.5f, 0.5f, 1});
  expectColor(rgbToHsv({0.2f, 0.2f, 0.2f}), {0, 0, 0.2f});
  expectColor(rgbToHsv({0, 0, 0}), {0, 0, 0});
  for (int i = 0; i < 1000; ++i) {
    const Color c(float(i % 10) / 9, float(i / 10 % 10) / 9, float(i / 100) / 9);
    expectColor(hsvToRgb(rgbToHsv(c)), c);
  }
}

// Scaled by 2, 3 and 4, sheared, mirrored and moved.
constexpr float kM[16] = {2, 0, 0, 0, 1, 3, 0, 0, 0, 0, -4, 0, 5, 6, 7, 1};

TEST(ShaderMatrix, MovesPointsVectorsAndNormals) {
  const Matrix m(kM);
  const Vector p = m.point({1, 1, 1}), v = m.vector({1, 1, 1});
  EXPECT_EQ(length(p - Vector(8, 9, 3)), 0);
  EXPECT_EQ(length(v - Vector(3, 3, -4)), 0);
  EXPECT_NEAR(m.scale(), std::cbrt(24.0), 1e-6);
  const Vector a(1, 2, -1), b(0.5f, -1, 3), n = m.normal(cross(a, b));
  EXPECT_NEAR(dot(n, m.vector(a)), 0, 1e-4);
  EXPECT_NEAR(dot(n, m.vector(b)), 0, 1e-4);
  EXPECT_GT(dot(n, m.vector(cross(a, b))), 0);  // still on the same side
}

struct Asked {
  std::string from, to, message;
  static int32_t transform(void* host, const char* from, const char* to, float matrix[16]) {
    auto& asked = *static_cast<Asked*>(host);
    asked.from = from, asked.to = to;
    for (int i = 0; i < 16; ++i) matrix[i] = kM[i];
    return std::string_view(to) == "shop";
  }
  static void report(void* host, PatinaReport, int32_t, const char* message) {
    static_cast<Asked*>(host)->message = message;
  }
};

TEST(ShaderMatrix, PrepareAsksTheHost) {
  Asked asked;
  PatinaHost host{};
  host.struct_size = sizeof host, host.host = &asked;
  host.transform = Asked::transform, host.report = Asked::report;
  PatinaPrepare in{};
  in.host = &host;
  PatinaTraits traits{};
  const Prepare prepare(in, traits);
  EXPECT_EQ(prepare.transform("world", "shop").point({0, 0, 0}).y, 6);
  EXPECT_EQ(asked.from, "world");
  EXPECT_EQ(asked.message, "");
  EXPECT_EQ(prepare.transform("world", "nowhere").point({1, 2, 3}).y, 2);
  EXPECT_EQ(asked.message, "a coordinate system that it names is not known");
}

}  // namespace
}  // namespace patina::test
