// SPDX-License-Identifier: Apache-2.0
// What lights of a render do wrong.
#include "renderer/shading/light_validation.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "renderer/base/sampling.h"
#include "renderer/shading/planes.h"

namespace patina {
namespace {

constexpr uint32_t kSampled = 7;        // of so many batches of a thread one is looked at more closely
constexpr float kUnitSlack = 1e-3f;     // of lengths and places, relative
constexpr float kFallOffSlack = 0.05f;  // steep beams raise a rounded cosine to a high power
constexpr float kSameSlack = 0.01f;     // of two ways to the same radiance or density, relative

// The codes of messages.
enum Kind : int32_t {
  kNegative = -500,
  kDirection,
  kDistance,
  kFromPoint,
  kFallOff,
  kAlone,
  kRandom,
  kEvaluates,
  kDensity
};

std::string text(const V3f& v) { return fmt::format("({}, {}, {})", v.x, v.y, v.z); }
float number(const PatinaPlane& plane, size_t i) { return plane.data ? plane.data[i * plane.stride] : 0; }
V3f triple(const PatinaPlane3& planes, size_t i) {
  return {number(planes.x, i), number(planes.y, i), number(planes.z, i)};
}
V3f triple(const PatinaOut3& out, size_t i) { return {out.x[i], out.y[i], out.z[i]}; }
bool isFinite3(const V3f& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

/// The renderer's own call, without counting.
struct Called {
  Planes planes;
  PatinaLightIn in;
  PatinaLightOut out;

  /// `n` lanes with the values and the task of `like`.
  Called(const PatinaLightIn& like, size_t n) : in(like), out{} {
    planes.begin(n);
    in.count = static_cast<uint32_t>(n);
    in.padded = static_cast<uint32_t>(planes.padded());
    out.struct_size = sizeof(out);
    out.direction = planes.out3(0);
    out.distance = planes.out(PATINA_INFINITE_DISTANCE);
    out.radiance = planes.out3(0);
    out.pdf = planes.out(0);
  }
  PatinaPlane plane(const PatinaPlane& from, size_t lane) {
    return from.data ? planes.fill(1, [&](size_t) { return number(from, lane); }) : from;
  }
  PatinaPlane3 plane(const PatinaPlane3& from, size_t lane) {
    return {plane(from.x, lane), plane(from.y, lane), plane(from.z, lane)};
  }
  bool run(const ShaderInstance& shader) { return shader.light(in, out) == PATINA_OK; }
};

/// One lane of a batch by itself.
struct Single : Called {
  Single(const PatinaLightIn& from, uint32_t lane) : Called(from, 1) {
    in.P = plane(from.P, lane), in.N = plane(from.N, lane), in.direction = plane(from.direction, lane);
    in.u = plane(from.u, lane), in.v = plane(from.v, lane);
    in.random_x = plane(from.random_x, lane), in.random_y = plane(from.random_y, lane);
    in.time = plane(from.time, lane);
  }
};

/// All that the renderer looks at of a lane.
std::array<float, 8> numbersOf(const PatinaLightIn& in, const PatinaLightOut& out, uint32_t lane,
                               uint32_t kind) {
  std::array<float, 8> numbers{out.radiance.x[lane], out.radiance.y[lane], out.radiance.z[lane]};
  if (in.task != PATINA_LIGHT_EMIT && kind == PATINA_LIGHT_INFINITE) numbers[3] = out.pdf[lane];
  if (in.task == PATINA_LIGHT_SAMPLE && kind != PATINA_LIGHT_AMBIENT) {
    numbers[4] = out.direction.x[lane], numbers[5] = out.direction.y[lane],
    numbers[6] = out.direction.z[lane];
    numbers[7] = out.distance[lane];
  }
  return numbers;
}
bool same(const std::array<float, 8>& a, const std::array<float, 8>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), [](float x, float y) {
    return std::bit_cast<uint32_t>(x) == std::bit_cast<uint32_t>(y) || (std::isnan(x) && std::isnan(y));
  });
}

void fault(const ShaderInstance& shader, Kind kind, const std::string& what) {
  const PatinaHost& host = shader.host();
  host.report(host.host, PATINA_REPORT_ERROR, kind, what.c_str());
}

constexpr const char* kTasks[] = {"light", "light (sample)", "light (evaluate)", "light (emit)"};

}  // namespace

void LightValidation::check(const PatinaLightIn& in, const PatinaLightOut& out) {
  if (in.count == 0) return;
  checkLanes(in, out);
  const bool samplesSky =
      shader_.traits().light_kind == PATINA_LIGHT_INFINITE && in.task == PATINA_LIGHT_SAMPLE;
  if (samplesSky) std::call_once(density_, [&] { checkDensity(in, triple(in.P, 0)); });
  thread_local uint32_t batches = 0;
  const uint32_t batch = batches++;
  if (batch % kSampled != 0) return;
  checkAgain(in, out, (batch / kSampled) % in.count);
  if (samplesSky) checkEvaluation(in, out);
}

void LightValidation::checkLanes(const PatinaLightIn& in, const PatinaLightOut& out) const {
  const PatinaTraits& traits = shader_.traits();
  const bool samples = in.task == PATINA_LIGHT_SAMPLE && traits.light_kind != PATINA_LIGHT_AMBIENT;
  for (uint32_t i = 0; i < in.count; ++i) {
    const V3f P = triple(in.P, i), radiance = triple(out.radiance, i);
    if (!isFinite3(radiance)) continue;  // which is reported elsewhere
    const auto wrong = [&](Kind kind, const char* what, const std::string& value) {
      fault(shader_, kind,
            fmt::format("{} {}: {}. The first is for the point {}", kTasks[in.task], what, value, text(P)));
    };
    if (std::min({radiance.x, radiance.y, radiance.z}) < 0)
      wrong(kNegative, "gives a negative radiance", text(radiance));
    if (!samples || isBlack(radiance)) continue;
    if (traits.light_kind == PATINA_LIGHT_INFINITE && !(out.pdf[i] > 0)) continue;
    const V3f direction = triple(out.direction, i);
    if (!(std::abs(direction.length() - 1) <= kUnitSlack))
      wrong(kDirection, "gives directions that are not of unit length", text(direction));
    if (!(out.distance[i] >= 0))
      wrong(kDistance, "gives a distance that is not 0 or more", fmt::format("{}", out.distance[i]));
    if (traits.light_kind != PATINA_LIGHT_DELTA || !shader_.has(PATINA_TRAIT_FROM_POINT)) continue;
    const V3f towards = V3f(traits.light_from) - P;
    const float distance = towards.length();
    if ((direction * distance - towards).length() > kUnitSlack * distance ||
        std::abs(out.distance[i] - distance) > kUnitSlack * distance)
      wrong(kFromPoint, "shines from elsewhere, though its traits say FROM_POINT",
            fmt::format("{}, {} away", text(direction), out.distance[i]));
  }
}

void LightValidation::checkAgain(const PatinaLightIn& in, const PatinaLightOut& out, uint32_t lane) const {
  const uint32_t kind = shader_.traits().light_kind;
  const auto together = numbersOf(in, out, lane, kind);
  const V3f P = triple(in.P, lane);
  Single alone(in, lane);
  if (alone.run(shader_) && !same(numbersOf(alone.in, alone.out, 0, kind), together))
    fault(shader_, kAlone,
          fmt::format("{} gives a point other values alone than in a batch of {}. The first is for {}",
                      kTasks[in.task], in.count, text(P)));
  if (kind != PATINA_LIGHT_DELTA) return;
  Single other(in, lane);
  other.in.random_x = other.planes.uniform(0.25f), other.in.random_y = other.planes.uniform(0.625f);
  if (other.run(shader_) && !same(numbersOf(other.in, other.out, 0, kind), together))
    fault(shader_, kRandom,
          fmt::format("light depends on random numbers, though it is a DELTA light. The first is for {}",
                      text(P)));
  if (!shader_.has(PATINA_TRAIT_FROM_POINT)) return;
  const V3f from(shader_.traits().light_from), far = from + (P - from) * 2.0f;
  Single further(in, lane);
  further.in.P = further.planes.fill3(1, [&](size_t) { return far; });
  if (!further.run(shader_)) return;
  const V3f here = triple(out.radiance, lane), there = triple(further.out.radiance, 0);
  if (here.length() > 1e-30f && !((here - there * 4.0f).length() <= kFallOffSlack * here.length()))
    fault(shader_, kFallOff,
          fmt::format("light does not fall off with the square of the distance, as FROM_POINT says: Cl is {} "
                      "at {} and {} at twice the distance",
                      text(here), text(P), text(there)));
}

void LightValidation::checkEvaluation(const PatinaLightIn& in, const PatinaLightOut& out) {
  Called evaluated(in, in.count);
  evaluated.in.task = PATINA_LIGHT_EVALUATE;
  evaluated.in.P = evaluated.planes.fill3(in.count, [&](size_t i) { return triple(in.P, i); });
  evaluated.in.direction = evaluated.planes.fill3(
      in.count, [&](size_t i) { return normalizedOr(triple(out.direction, i), V3f(0, 0, 1)); });
  if (!evaluated.run(shader_)) return;
  uint64_t different = 0, compared = 0;
  uint32_t example = 0;
  for (uint32_t i = 0; i < in.count; ++i) {
    if (!(out.pdf[i] > 0)) continue;
    ++compared;
    const auto differ = [](float a, float b) {
      return !(std::abs(a - b) <= kSameSlack * std::max(std::abs(a), std::abs(b)));
    };
    const V3f a = triple(out.radiance, i), b = triple(evaluated.out.radiance, i);
    if (differ(out.pdf[i], evaluated.out.pdf[i]) || differ(a.x, b.x) || differ(a.y, b.y) || differ(a.z, b.z))
      ++different, example = i;
  }
  if (different == 0) {
    compared_ += compared;
    return;
  }
  // At edges, as of a sun's disc, single directions may be rounded to the other side.
  constexpr uint64_t kFew = 8;
  constexpr double kShare = 0.05;
  const uint64_t all = compared_ += compared, wrong = different_ += different;
  if (wrong < kFew || double(wrong) < kShare * double(all)) return;
  fault(shader_, kEvaluates,
        fmt::format(
            "light (evaluate) gives another radiance or pdf than sample for its directions: radiance {} "
            "and {}, pdf {} and {}. The direction is {}",
            text(triple(evaluated.out.radiance, example)), text(triple(out.radiance, example)),
            evaluated.out.pdf[example], out.pdf[example], text(triple(out.direction, example))));
}

// Samples are counted in regions, and the density is integrated over them at directions spread evenly.
// Regions are all around, and the cap around the sample of the highest density that holds a quarter of all;
// of both those directions alone where the density is at most 16 times its mean there, or small bright spots
// would make the integral noisy.
void LightValidation::checkDensity(const PatinaLightIn& in, const V3f& P) const {
  constexpr uint32_t kCount = 4096;
  constexpr float kMostOfMean = 16;
  constexpr double kErrors = 5, kSlack = 0.01;
  const auto random = [](uint32_t k, uint64_t stream) {
    return sobol2(k, hashOf(uint64_t{0x6c696768}, stream));
  };
  Called drawn(in, kCount);
  drawn.in.P = drawn.planes.fill3(kCount, [&](size_t) { return P; });
  drawn.in.random_x = drawn.planes.fill(kCount, [&](size_t k) { return random(uint32_t(k), 0).x; });
  drawn.in.random_y = drawn.planes.fill(kCount, [&](size_t k) { return random(uint32_t(k), 0).y; });
  if (!drawn.run(shader_)) return;
  uint32_t peak = 0;
  for (uint32_t i = 0; i < kCount; ++i) {
    if (!(drawn.out.pdf[i] > 0) || !std::isfinite(drawn.out.pdf[i])) return;  // these follow no density
    if (drawn.out.pdf[i] > drawn.out.pdf[peak]) peak = i;
  }
  const V3f middle = normalizedOr(triple(drawn.out.direction, peak), V3f(0, 0, 1));
  std::vector<float> heights(kCount);  // 1 - cos to the peak
  for (uint32_t i = 0; i < kCount; ++i) heights[i] = (triple(drawn.out.direction, i) - middle).length2() / 2;
  std::vector<float> sorted = heights;
  std::nth_element(sorted.begin(), sorted.begin() + kCount / 4, sorted.end());
  const Frame frame(middle);
  for (const float height : {std::min(sorted[kCount / 4], 2.0f), 2.0f}) {
    if (!(height > 1e-10f)) continue;  // floats cannot tell directions there
    Called spread(in, kCount);
    spread.in.task = PATINA_LIGHT_EVALUATE;
    spread.in.P = spread.planes.fill3(kCount, [&](size_t) { return P; });
    spread.in.direction = spread.planes.fill3(kCount, [&](size_t k) {
      const V2f r = random(uint32_t(k), 1);
      const float below = height * r.x, phi = 2 * kPi * r.y;
      const float radius = std::sqrt(std::max(below * (2 - below), 0.0f));
      return frame.toWorld(V3f(radius * std::cos(phi), radius * std::sin(phi), 1 - below)).normalized();
    });
    if (!spread.run(shader_)) return;
    double mean = 0;
    for (uint32_t k = 0; k < kCount; ++k) mean += double(spread.out.pdf[k]) / kCount;
    const auto most = static_cast<float>(mean * double(kMostOfMean));
    double sum = 0, squares = 0, count = 0;
    for (uint32_t k = 0; k < kCount; ++k) {
      if (spread.out.pdf[k] <= most) {
        sum += double(spread.out.pdf[k]) / kCount;
        squares += double(spread.out.pdf[k]) * double(spread.out.pdf[k]) / kCount;
      }
      count += heights[k] <= height && drawn.out.pdf[k] <= most;
    }
    const double area = 2 * double(kPi) * double(height), said = sum * area, share = count / kCount;
    const double variance = (squares - sum * sum) * area * area + share * (1 - share) + 1.0 / kCount;
    if (std::abs(said - share) <= kSlack + kErrors * std::sqrt(std::max(variance, 0.0) / kCount)) continue;
    fault(shader_, kDensity,
          fmt::format("light has a wrong pdf: {:.4f} of its samples fall where they should be {:.4f}, {}",
                      share, said,
                      height < 2 ? fmt::format("1 - cos up to {:.4g} from {}", height, text(middle))
                                 : std::string("all around")));
    return;
  }
}

}  // namespace patina
