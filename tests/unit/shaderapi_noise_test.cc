// SPDX-License-Identifier: Apache-2.0
// Gradient noise, cell noise and Worley's points: ranges, means and variances in closed form, smoothness, and
// other ways to compute the same.
#include <gtest/gtest.h>
#include <patina/sdk/cells.h>
#include <patina/sdk/fractals.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

namespace patina::test {
namespace {

using namespace patina::sdk;

/// The same points each time, `range` around 0.
class Points {
 public:
  explicit Points(float range, uint32_t seed = 1) : generator_(seed), range_(range) {}
  float number() { return range_ * (2 * unit() - 1); }
  float unit() { return static_cast<float>(generator_() >> 8) * 0x1p-24f; }
  Vector vector() {
    const float x = number(), y = number();
    return {x, y, number()};
  }

 private:
  std::mt19937 generator_;
  float range_;
};

struct Moments {
  double mean = 0, variance = 0, meanAbs = 0;
  float least = 1e30f, most = -1e30f;
};
Moments momentsOf(int count, const std::function<float()>& draw) {
  Moments m;
  for (int i = 0; i < count; ++i) {
    const float v = draw();
    m.mean += v, m.variance += double(v) * v, m.meanAbs += std::abs(v);
    m.least = std::min(m.least, v), m.most = std::max(m.most, v);
  }
  m.mean /= count, m.meanAbs /= count;
  m.variance = m.variance / count - m.mean * m.mean;
  return m;
}

constexpr int kMany = 400'000;

// With u the quintic fade, A = integral of (1-u)^2 + u^2 and B = that of (1-u)^2 x^2 + u^2 (1-x)^2, the
// variance for n variables and gradients with component variance g is n g A^(n-1) B: corners are independent
// of each other. Values of a cell are not, so that the bounds, 3 % and 0.01, are five deviations of some 10^5
// cells.
TEST(ShaderNoise, MeansAndVariancesAreThoseOfTheFormula) {
  constexpr double kA = 0.7835498, kB = 0.0593850;
  Points far(20000), near(300), nearest(60);
  const auto check = [](const Moments& m, double variance) {
    EXPECT_NEAR(m.mean, 0, 0.01);
    EXPECT_NEAR(m.variance / variance, 1, 0.03);
    EXPECT_GE(m.least, -1);
    EXPECT_LE(m.most, 1);
    EXPECT_GT(m.most, 0.65f);  // the range is made use of
    EXPECT_LT(m.least, -0.65f);
  };
  check(momentsOf(kMany, [&] { return snoise(far.number()); }), 4.0 / 3 * kB);
  check(momentsOf(kMany, [&] { return snoise(near.number(), near.number()); }), 2 * kA * kB);
  check(momentsOf(kMany, [&] { return snoise(nearest.vector()); }), 3 * 2.0 / 3 * kA * kA * kB);
  check(momentsOf(kMany, [&] { return snoise(nearest.vector(), nearest.number()); }),
        4 * 1.0 / 3 * kA * kA * kA * kB);
}

TEST(ShaderNoise, RslNoiseIsHalfOfIt) {
  Points points(50);
  for (int i = 0; i < 1000; ++i) {
    const Vector p = points.vector();
    EXPECT_FLOAT_EQ(noise(p.x), 0.5f + 0.5f * snoise(p.x));
    EXPECT_FLOAT_EQ(noise(p.x, p.y), 0.5f + 0.5f * snoise(p.x, p.y));
    EXPECT_FLOAT_EQ(noise(p), 0.5f + 0.5f * snoise(p));
    EXPECT_FLOAT_EQ(noise(p, p.x), 0.5f + 0.5f * snoise(p, p.x));
    EXPECT_FLOAT_EQ(vnoise(p).y, 0.5f + 0.5f * vsnoise(p).y);
    EXPECT_EQ(vsnoise(p).x, snoise(p));
  }
}

TEST(ShaderNoise, IsZeroAtWholeNumbers) {
  for (int i = -9; i < 10; ++i)
    for (int j = -9; j < 10; ++j) {
      const auto x = float(i), y = float(j);
      EXPECT_EQ(snoise(x), 0);
      EXPECT_EQ(snoise(x, y), 0);
      EXPECT_EQ(snoise(Vector(x, y, x - y)), 0);
      EXPECT_EQ(snoise(Vector(x, y, 3), x + y), 0);
      EXPECT_EQ(vsnoise(x, y).z, 0);
    }
}

// Along one axis |f'| is at most g (1 + 2 * 1.875 * sqrt(n)): g bounds the gradients, 1.875 the fade's slope,
// and sqrt(n) the distance to a corner. A jump at a cell's face would exceed that many times over so small a
// step.
TEST(ShaderNoise, IsContinuous) {
  Points points(20);
  constexpr float kStep = 1.0f / 1024;
  const auto check = [&](auto f, float gradient, int n) {
    const float bound = gradient * (1 + 3.75f * std::sqrt(float(n))) * kStep + 1e-5f;
    for (int i = 0; i < 20000; ++i) {
      Vector p = points.vector();
      if (i % 2) p.x = std::round(p.x) - kStep / 2;  // across a face
      ASSERT_LE(std::abs(f(p + Vector(kStep, 0, 0)) - f(p)), bound) << p.x << ' ' << p.y << ' ' << p.z;
    }
  };
  check([](const Vector& p) { return snoise(p.x); }, 2, 1);
  check([](const Vector& p) { return snoise(p.x, p.y); }, std::sqrt(2.0f), 2);
  check([](const Vector& p) { return snoise(p); }, std::sqrt(2.0f), 3);
  check([](const Vector& p) { return snoise(Vector(p.y, p.z, 0.3f), p.x); }, 2 / std::sqrt(3.0f), 4);
}

TEST(ShaderNoise, ComponentsAreIndependent) {
  Points points(60);
  double xy = 0, xz = 0, yz = 0;
  for (int i = 0; i < kMany; ++i) {
    const Vector v = vsnoise(points.vector());
    xy += v.x * v.y, xz += v.x * v.z, yz += v.y * v.z;
  }
  // The deviation of each mean is var / sqrt(n) = 1.2e-4, of which this is five.
  for (const double sum : {xy, xz, yz}) EXPECT_NEAR(sum / kMany, 0, 6e-4);
}

// Pictures of a scene stay what they are. Another order of rounding may change the last bits.
TEST(ShaderNoise, StaysWhatItIs) {
  const Vector p(1.3f, -2.7f, 5.1f);
  EXPECT_NEAR(snoise(1.3f), -0.554950237, 1e-6);
  EXPECT_NEAR(snoise(1.3f, -2.7f), -0.115615189, 1e-6);
  EXPECT_NEAR(noise(p), 0.749388814, 1e-6);
  EXPECT_NEAR(snoise(p, 0.4f), 0.332796037, 1e-6);
  EXPECT_NEAR(vsnoise(p).z, -0.186576754, 1e-6);
  EXPECT_EQ(cellnoise(p), 0.988384902f);
  EXPECT_NEAR(worley(p).f2, 0.799612403, 1e-6);
}

TEST(ShaderCells, CellNoiseIsUniformAndConstantWithin) {
  Points points(1000);
  std::vector<int> histogram(10);
  constexpr int kCells = 100'000;
  for (int i = 0; i < kCells; ++i) {
    const Vector p = points.vector(), floor(std::floor(p.x), std::floor(p.y), std::floor(p.z));
    const float v = cellnoise(p);
    ASSERT_EQ(v, cellnoise(floor));
    ASSERT_EQ(vcellnoise(p).x, v);
    ASSERT_EQ(cellnoise(p.x, p.y), cellnoise(floor.x, floor.y));
    ASSERT_EQ(cellnoise(p, p.x), cellnoise(floor, floor.x));
    ASSERT_EQ(ccellnoise(p).b, vcellnoise(floor).z);
    ASSERT_GE(v, 0);
    ASSERT_LT(v, 1);
    ++histogram[size_t(v * 10)];
  }
  double chiSquare = 0;
  for (const int n : histogram) chiSquare += (n - kCells / 10.0) * (n - kCells / 10.0) / (kCells / 10.0);
  EXPECT_LT(chiSquare, 33.7);  // 9 degrees of freedom, 1e-4
}

// All points of the cells up to two away, sorted by distance.
TEST(ShaderCells, WorleyIsWhatAllPointsGive) {
  Points points(30);
  for (const float jitter : {1.0f, 0.5f})
    for (int i = 0; i < 2000; ++i) {
      const Vector p = points.vector();
      std::vector<std::pair<float, uint32_t>> all, flat;
      for (int c = -2; c <= 2; ++c)
        for (int b = -2; b <= 2; ++b)
          for (int a = -2; a <= 2; ++a) {
            const int x = int(std::floor(p.x)) + a, y = int(std::floor(p.y)) + b,
                      z = int(std::floor(p.z)) + c;
            const auto place = [&](int cell, uint32_t bits, float steps) {
              return float(cell) + 0.5f + jitter * (float(bits) / steps - 0.5f);
            };
            uint32_t h = detail::latticeBits(x, y, z, 0x1b873593u);
            all.emplace_back(length(p - Vector(place(x, h & 1023, 1024), place(y, h >> 10 & 1023, 1024),
                                               place(z, h >> 20 & 1023, 1024))),
                             h);
            if (c != 0) continue;
            h = detail::latticeBits(x, y, 0, 0x1b873593u);
            flat.emplace_back(std::hypot(p.x - place(x, h & 0xffff, 65536), p.y - place(y, h >> 16, 65536)),
                              h);
          }
      const float far = 1.5f - jitter / 2;  // what lies beyond is cut off
      const auto check = [&](auto& found, const Worley& w) {
        std::sort(found.begin(), found.end());
        EXPECT_NEAR(w.f1, std::min(found[0].first, far), 1e-5);
        EXPECT_NEAR(w.f2, std::min(found[1].first, far), 1e-5);
        if (found[0].first < far - 1e-4f && found[1].first - found[0].first > 1e-4f) {
          EXPECT_EQ(w.cell, found[0].second);
        }
      };
      check(all, worley(p, jitter));
      check(flat, worley(p.x, p.y, jitter));
    }
}

// Distances to points change by no more than one moves; nowhere do they jump.
TEST(ShaderCells, WorleyIsContinuous) {
  Points points(30), steps(0.01f, 2);
  for (int i = 0; i < 20000; ++i) {
    const Vector p = points.vector(), d = steps.vector();
    const Worley a = worley(p), b = worley(p + d);
    ASSERT_LE(std::abs(a.f1 - b.f1), length(d) + 1e-5f);
    ASSERT_LE(std::abs(a.f2 - b.f2), length(d) + 1e-5f);
  }
}

template <class F>
double boxMean(const F& f, const Vector& p, float width, Points& random) {
  constexpr int kSide = 10;  // jittered strata
  double sum = 0;
  for (int i = 0; i < kSide; ++i)
    for (int j = 0; j < kSide; ++j)
      for (int k = 0; k < kSide; ++k) {
        const auto place = [&](int cell) { return width * ((float(cell) + random.unit()) / kSide - 0.5f); };
        const float x = place(i), y = place(j);
        sum += f(p + Vector(x, y, place(k)));
      }
  return sum / (kSide * kSide * kSide);
}

// Filtered patterns against averages of unfiltered ones over cubes. What is left is the noise that no factor
// on its middle's value can tell: the stated bound, over the pattern's own deviation.
template <class F>
void expectFiltered(const F& f, float bound, double mean) {
  Points points(60), random(1, 3);
  const Moments own = momentsOf(20000, [&] { return f(points.vector(), 0.0f); });
  for (const float width : {0.05f, 0.2f, 0.5f, 1.0f, 1.8f}) {
    constexpr int kPlaces = 250;
    double squares = 0, unfiltered = 0, bias = 0;
    for (int i = 0; i < kPlaces; ++i) {
      const Vector p = points.vector();
      const double average = boxMean([&](const Vector& q) { return f(q, 0.0f); }, p, width, random);
      const double filtered = f(p, width);
      squares += (filtered - average) * (filtered - average);
      unfiltered += (double(f(p, 0.0f)) - average) * (double(f(p, 0.0f)) - average);
      bias += filtered - average;
    }
    const double deviation = std::sqrt(own.variance);
    EXPECT_LT(std::sqrt(squares / kPlaces) / deviation, bound) << width;
    EXPECT_LT(squares, unfiltered) << width;
    EXPECT_NEAR(bias / kPlaces / deviation, 0, 5 * bound / std::sqrt(kPlaces)) << width;
  }
  for (int i = 0; i < 100; ++i) EXPECT_FLOAT_EQ(f(points.vector(), 3.0f), float(mean));
}

TEST(ShaderFractals, FilteredFbmIsTheMeanOverABox) {
  expectFiltered([](const Vector& p, float width) { return fbm<5>(p, width); }, 0.25f, 0);
}
TEST(ShaderFractals, FilteredTurbulenceIsTheMeanOverABox) {
  expectFiltered([](const Vector& p, float width) { return turbulence<5>(p, width); }, 0.3f,
                 double(kMeanAbsNoise) * 1.9375);
}

TEST(ShaderFractals, MeanOfAbsoluteNoiseIsTheConstant) {
  Points points(100);
  const Moments m = momentsOf(1'000'000, [&] { return snoise(points.vector()); });
  EXPECT_NEAR(m.meanAbs, double(kMeanAbsNoise), 1e-3);  // deviation 1.6e-4
}

// The part of averages over a cube that follows noise at its middle, by regression.
TEST(ShaderFractals, FadesAsAveragesDo) {
  for (const float width : {0.25f, 0.5f, 0.75f, 1.0f, 1.25f, 1.5f, 1.75f, 2.0f, 2.5f}) {
    Points points(60), random(1, 3);
    double product = 0, square = 0, product2 = 0, square2 = 0;
    for (int i = 0; i < 1000; ++i) {
      const Vector p = points.vector();
      const double n = snoise(p), a = std::abs(n) - double(kMeanAbsNoise);
      product += n * boxMean([](const Vector& q) { return snoise(q); }, p, width, random), square += n * n;
      product2 += a * (boxMean([](const Vector& q) { return std::abs(snoise(q)); }, p, width, random) -
                       double(kMeanAbsNoise));
      square2 += a * a;
    }
    EXPECT_NEAR(double(noiseLeft(width)), product / square, 0.07) << width;
    EXPECT_NEAR(double(absNoiseLeft(width)), product2 / square2, 0.05) << width;
  }
}

TEST(ShaderFractals, StaysWithinItsAmplitudes) {
  Points points(100);
  EXPECT_FLOAT_EQ(amplitudes<4>(0.5f), 1.875f);
  for (int i = 0; i < 20000; ++i) {
    const Vector p = points.vector();
    ASSERT_LE(std::abs(fbm<4>(p, 0)), amplitudes<4>());
    ASSERT_GE(turbulence<4>(p, 0), 0);
    ASSERT_LE(turbulence<4>(p, 0), amplitudes<4>());
  }
}

}  // namespace
}  // namespace patina::test
