// SPDX-License-Identifier: Apache-2.0
// Densities of lights from infinity: they integrate to one over the sphere, and samples come by them.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "renderer/base/sampling.h"
#include "renderer/shadercheck/checks.h"

namespace patina::shadercheck {
namespace {

constexpr uint32_t kSide = 64;           // samples along each random number
constexpr uint32_t kStrata = 128;        // of the integral, along each coordinate, in each of its parts
constexpr double kRingGrowth = 8;        // of a part's 1 - cos
constexpr double kIntegralSlack = 0.02;  // some ten times the error of the strata where a light has edges
constexpr double kMomentSlack = 0.03;    // as much, of 64 x 64 samples in a grid
constexpr float kSampleSlack = 0.01f;    // relative, and the share of samples on edges

// Functions of a direction in the frame of the samples' mean, scaled to the samples' spread.
constexpr size_t kMoments = 5;
using Moments = std::array<double, kMoments>;
constexpr const char* kMomentNames[kMoments] = {"across", "up", "out", "across x up", "across^2 - up^2"};

struct Spread {
  Frame frame{V3f(0, 0, 1)};
  double height = 2;  // of the cap around frame.z that holds every sample: 1 - cos

  Moments moments(const V3f& d) const {
    const double half = std::min(height, 1.0), width = std::sqrt(half * (2 - half));
    const double x = double(frame.x.dot(d)) / width, y = double(frame.y.dot(d)) / width;
    const double z = double((d - frame.z).length2()) / (2 * height);
    return {x, y, z, x * y, x * x - y * y};
  }
};

struct Samples {
  std::vector<Lane> lanes;
  Output output;
};

float jitter(uint64_t k, uint64_t dimension) {
  return toUnit(static_cast<uint32_t>(hashOf(k, dimension, 0x5u) >> 32));
}

Samples drawSamples(Subject& subject) {
  Samples samples;
  samples.lanes.assign(kSide * kSide, makeLanes(1, 12)[0]);
  for (uint32_t k = 0; k < kSide * kSide; ++k) {
    samples.lanes[k].randomX = std::min((float(k % kSide) + jitter(k, 0)) / kSide, kOneMinusEpsilon);
    samples.lanes[k].randomY = std::min((float(k / kSide) + jitter(k, 1)) / kSide, kOneMinusEpsilon);
  }
  samples.output = subject.run(Call::LightSample, samples.lanes);
  return samples;
}

// Of the samples with at least `share` of the highest density: of a sky with a sun, those in its disc.
Spread spreadOf(const Output& samples, float share) {
  float most = 0;
  for (uint32_t i = 0; i < samples.lanes; ++i) most = std::max(most, samples.at(i, kLightPdf));
  const auto forEach = [&](const auto& add) {
    for (uint32_t i = 0; i < samples.lanes; ++i)
      if (samples.at(i, kLightPdf) >= share * most) add(samples.triple(i, kLightDirection));
  };
  V3f sum(0, 0, 0);
  forEach([&](const V3f& d) { sum += d; });
  Spread spread;
  spread.frame = Frame(normalizedOr(sum, V3f(0, 0, 1)));
  double height = 0;
  forEach([&](const V3f& d) { height = std::max(height, double((d - spread.frame.z).length2()) / 2); });
  spread.height = std::min(2.0, height * 1.2 + 1e-7);
  return spread;
}

// Adds the integrals of the density and its moments over the part of the sphere with `low` <= 1 - cos <
// `high` from the peak's middle.
void integrate(Subject& subject, const Spread& spread, const Spread& peak, double low, double high,
               double& total, Moments& sums) {
  if (!(high > low)) return;
  std::vector<Lane> lanes(kStrata * kStrata, makeLanes(1, 12)[0]);
  for (uint32_t k = 0; k < kStrata * kStrata; ++k) {
    const double below = low + (high - low) * (k % kStrata + double(jitter(k, 2))) / kStrata;
    const double phi = 2 * std::numbers::pi * (k / kStrata + double(jitter(k, 3))) / kStrata;
    const double radius = std::sqrt(std::max(below * (2 - below), 0.0));
    const V3f local(float(radius * std::cos(phi)), float(radius * std::sin(phi)), float(1 - below));
    lanes[k].direction = peak.frame.toWorld(local).normalized();
  }
  const Output output = subject.run(Call::LightEvaluate, lanes);
  const double area = 2 * std::numbers::pi * (high - low) / (kStrata * kStrata);
  for (uint32_t k = 0; k < output.lanes; ++k) {
    const double share = double(output.at(k, kLightPdf)) * area;
    total += share;
    const Moments at = spread.moments(lanes[k].direction);
    for (size_t m = 0; m < kMoments; ++m) sums[m] += share * at[m];
  }
}

// evaluate() of the sampled directions is what sample() said.
void expectSame(Subject& subject, const Samples& samples) {
  std::vector<Lane> lanes = samples.lanes;
  for (uint32_t i = 0; i < lanes.size(); ++i)
    lanes[i].direction = samples.output.triple(i, kLightDirection).normalized();
  const Output evaluated = subject.run(Call::LightEvaluate, lanes);
  const auto expect = [&](uint32_t first, uint32_t last, const char* what) {
    uint32_t wrong = 0, example = 0;
    for (uint32_t i = 0; i < lanes.size(); ++i)
      for (uint32_t c = first; c <= last; ++c) {
        const float a = samples.output.at(i, c), b = evaluated.at(i, c);
        if (samples.output.at(i, kLightPdf) > 0 &&
            std::abs(a - b) > kSampleSlack * std::max(std::abs(a), std::abs(b))) {
          ++wrong, example = i;
          break;
        }
      }
    if (static_cast<float>(wrong) > kSampleSlack * static_cast<float>(lanes.size()))
      subject.fault(Call::LightEvaluate, fmt::format("gives another {} than sample for its directions", what),
                    fmt::format("{} of {} samples; lane {}: {} and {}", wrong, lanes.size(), example,
                                samples.output.at(example, first), evaluated.at(example, first)));
  };
  expect(kLightPdf, kLightPdf, "pdf");
  expect(kLightRadiance, kLightRadiance + 2, "radiance");
}

void expectDensity(Subject& subject, const Samples& samples) {
  const Spread spread = spreadOf(samples.output, 0);
  double total = 0;
  Moments expected{}, drawn{};
  // The peak, and rings around it that grow with their distance.
  const Spread peak = spreadOf(samples.output, 0.5f);
  integrate(subject, spread, peak, 0, peak.height, total, expected);
  for (double low = peak.height, high; low < 2; low = high) {
    high = std::min(low * kRingGrowth, 2.0);
    integrate(subject, spread, peak, low, high, total, expected);
  }
  if (std::abs(total - 1) > kIntegralSlack) {
    subject.fault(Call::LightEvaluate, "has a wrong pdf: it does not integrate to 1 over the sphere",
                  fmt::format("the integral is {:.4f}", total));
    return;
  }
  for (uint32_t i = 0; i < samples.output.lanes; ++i) {
    if (!(samples.output.at(i, kLightPdf) > 0)) return;  // samples without light follow no density
    const Moments at = spread.moments(samples.output.triple(i, kLightDirection));
    for (size_t m = 0; m < kMoments; ++m) drawn[m] += at[m] / samples.output.lanes;
  }
  for (size_t m = 0; m < kMoments; ++m)
    if (std::abs(drawn[m] - expected[m]) > kMomentSlack) {
      subject.fault(Call::LightSample, "has a wrong pdf: directions are not drawn by it",
                    fmt::format("the mean of '{}' is {:.4f} and by the pdf {:.4f}", kMomentNames[m], drawn[m],
                                expected[m]));
      return;
    }
}

}  // namespace

void checkInfiniteLights(const Context& context) {
  forEachSubject(context, [](Subject& subject) {
    if (!subject.calls(Call::LightEvaluate)) return;
    const Samples samples = drawSamples(subject);
    expectSame(subject, samples);
    expectDensity(subject, samples);
  });
}

}  // namespace patina::shadercheck
