// SPDX-License-Identifier: Apache-2.0
// Lobes of a shader's own: values that can be used, densities that integrate to one and that samples follow,
// no energy made, and the same seen from both ends.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "renderer/base/sampling.h"
#include "renderer/shadercheck/checks.h"

namespace patina::shadercheck {
namespace {

constexpr uint32_t kSide = 64;     // samples along each random number
constexpr uint32_t kStrata = 128;  // of integrals, along each coordinate
constexpr uint32_t kCells = 8;     // along each coordinate, that samples are counted in
constexpr uint32_t kPoints = 3;    // points of each lobe whose densities are integrated
constexpr float kLeastCosine =
    0.15f;  // of their viewers: lower ones squeeze lobes into bands along the horizon
constexpr double kIntegralSlack = 0.02;  // some five times the error of the strata
constexpr double kCellSlack = 0.02;      // as much, of a cell's share of 64 x 64 samples in a grid
constexpr float kReciprocalSlack = 0.01f;

float jitter(uint64_t k, uint64_t dimension) {
  return toUnit(static_cast<uint32_t>(hashOf(k, dimension, 0x10beu) >> 32));
}

struct Value {
  V3f f;
  float pdf;
};

// One lobe at one point, as `view` gave it.
class LobeAt {
 public:
  LobeAt(Subject& subject, uint32_t which, const Output& view, uint32_t lane, const Lane& at)
      : subject_(subject),
        which_(which),
        lane_(lane),
        table_(*subject.customLobes()[view.lobeTypes[which] - PATINA_LOBE_CUSTOM]),
        wo_(-at.I) {
    // As the renderer bends normals that face away.
    const float facing = wo_.dot(at.N);
    N_ = facing < 1e-3f ? (at.N + wo_ * (1e-3f - facing)).normalized() : at.N;
    const uint32_t stride = (view.columns - kFirstLobeData) / PATINA_MAX_LOBES;
    for (uint32_t c = 0; c < table_.data_count; ++c)
      data_.push_back(view.at(lane, kFirstLobeData + which * stride + c));
    const uint32_t first = kFirstLobe + kLobeColumns * which;
    alpha_ = view.at(lane, first + kLobeAlpha), eta_ = view.at(lane, first + kLobeEta);
  }

  const V3f& N() const { return N_; }
  const V3f& wo() const { return wo_; }
  bool has(uint32_t flag) const { return (table_.flags & flag) != 0; }
  bool asks(const V3f& wi) const {
    const float cosine = wi.dot(N_);
    return (cosine > 0 && has(PATINA_LOBE_REFLECTS)) || (cosine < 0 && has(PATINA_LOBE_TRANSMITS));
  }
  LobeAt seenFrom(const V3f& wo) const {
    LobeAt other = *this;
    other.wo_ = wo;
    return other;
  }

  void fault(const std::string& text, const std::string& detail) const {
    subject_.fault(Call::View, fmt::format("lobe \"{}\" {}", table_.name, text),
                   fmt::format("lane {}, wo.N = {:.3g}: {}", lane_, wo_.dot(N_), detail));
  }

  std::vector<Value> evaluate(std::span<const V3f> wi, bool uniform = true) const {
    const auto n = static_cast<uint32_t>(wi.size());
    GuardedMemory memory;
    Arguments arguments(*this, memory, n, uniform);
    arguments.in.wi = planes(memory, wi, "wi");
    run(table_.evaluate, arguments, memory, "evaluate");
    std::vector<Value> values(n);
    for (uint32_t i = 0; i < n; ++i)
      values[i] = {V3f(arguments.out.f.x[i], arguments.out.f.y[i], arguments.out.f.z[i]),
                   arguments.out.pdf[i]};
    return values;
  }
  std::vector<V3f> sample(std::span<const V2f> random) const {
    const auto n = static_cast<uint32_t>(random.size());
    GuardedMemory memory;
    Arguments arguments(*this, memory, n, true);
    std::vector<float> x(padded(n)), y(padded(n));
    for (uint32_t i = 0; i < x.size(); ++i)
      x[i] = random[std::min(i, n - 1)].x, y[i] = random[std::min(i, n - 1)].y;
    arguments.in.random_x = {memory.input(x, "random_x"), 1, 0};
    arguments.in.random_y = {memory.input(y, "random_y"), 1, 0};
    run(table_.sample, arguments, memory, "sample");
    std::vector<V3f> wi(n);
    for (uint32_t i = 0; i < n; ++i)
      wi[i] = {arguments.out.wi.x[i], arguments.out.wi.y[i], arguments.out.wi.z[i]};
    return wi;
  }

 private:
  static uint32_t padded(uint32_t n) { return (n + PATINA_LANES - 1) / PATINA_LANES * PATINA_LANES; }
  static PatinaPlane plane(GuardedMemory& memory, float value, uint32_t n, bool uniform, const char* name) {
    const std::vector<float> values(uniform ? 1 : padded(n), value);
    return {memory.input(values, name), uniform ? 0u : 1u, 0};
  }
  static PatinaPlane3 planes(GuardedMemory& memory, std::span<const V3f> v, const char* name) {
    const auto n = static_cast<uint32_t>(v.size());
    PatinaPlane3 made;
    PatinaPlane* const parts[] = {&made.x, &made.y, &made.z};
    for (int c = 0; c < 3; ++c) {
      std::vector<float> values(padded(n));
      for (uint32_t i = 0; i < values.size(); ++i) values[i] = v[std::min(i, n - 1)][c];
      *parts[c] = {memory.input(values, name), 1, 0};
    }
    return made;
  }

  struct Arguments {
    std::vector<PatinaPlane> data;
    PatinaLobeIn in{};
    PatinaLobeOut out{};

    Arguments(const LobeAt& lobe, GuardedMemory& memory, uint32_t n, bool uniform) {
      const auto all = [&](float value, const char* name) { return plane(memory, value, n, uniform, name); };
      const auto all3 = [&](const V3f& v, const char* name) {
        return PatinaPlane3{all(v.x, name), all(v.y, name), all(v.z, name)};
      };
      in.struct_size = sizeof in;
      in.count = n, in.padded = padded(n);
      in.data_count = static_cast<uint32_t>(lobe.data_.size());
      for (const float number : lobe.data_) data.push_back(all(number, "data"));
      in.data = data.data();
      in.N = all3(lobe.N_, "N"), in.wo = all3(lobe.wo_, "wo");
      in.alpha = all(lobe.alpha_, "alpha"), in.eta = all(lobe.eta_, "eta");
      const auto plane0 = [&](const char* name) {
        float* const made = memory.output(padded(n), name);
        std::fill_n(made, padded(n), 0.0f);
        return made;
      };
      out.struct_size = sizeof out;
      out.f = {plane0("f.x"), plane0("f.y"), plane0("f.z")};
      out.pdf = plane0("pdf");
      out.wi = {plane0("wi.x"), plane0("wi.y"), plane0("wi.z")};
    }
  };

  template <class Function>
  void run(Function function, Arguments& arguments, const GuardedMemory& memory, const char* name) const {
    if (const PatinaStatus status = function(subject_.instance(), &arguments.in, &arguments.out);
        status != PATINA_OK)
      fault(fmt::format("returned the status {} from {}", status, name), "for arguments that make sense");
    if (const auto [what, where] = memory.findDamage(); !what.empty()) fault(what, where);
  }

  Subject& subject_;
  uint32_t which_, lane_;
  const PatinaCustomLobe& table_;
  V3f wo_, N_;
  std::vector<float> data_;
  float alpha_ = 0, eta_ = 1;
};

std::vector<V2f> stratifiedSquare() {
  std::vector<V2f> random(kSide * kSide);
  for (uint32_t k = 0; k < random.size(); ++k)
    random[k] = {std::min((float(k % kSide) + jitter(k, 0)) / kSide, kOneMinusEpsilon),
                 std::min((float(k / kSide) + jitter(k, 1)) / kSide, kOneMinusEpsilon)};
  return random;
}

// Directions that a formula may stumble over, and ordinary ones.
std::vector<V3f> awkwardDirections(const LobeAt& lobe) {
  const Frame frame(lobe.N());
  const V3f mirrored = lobe.N() * (2 * lobe.wo().dot(lobe.N())) - lobe.wo();
  std::vector<V3f> all{lobe.N(), -lobe.N(), lobe.wo(), -lobe.wo(), mirrored, -mirrored, frame.x, -frame.y};
  for (const float height : {1e-7f, -1e-7f, 1e-4f, -1e-4f})
    all.push_back((frame.x * 0.6f + frame.y * 0.8f + frame.z * height).normalized());
  for (uint32_t k = 0; k < 64; ++k) {
    const float z = 2 * jitter(k, 4) - 1, radius = std::sqrt(1 - z * z), phi = 2 * kPi * jitter(k, 5);
    all.push_back(V3f(radius * std::cos(phi), radius * std::sin(phi), z).normalized());
  }
  return all;
}

void expectUsable(const LobeAt& lobe) {
  std::vector<V3f> asked;
  for (const V3f& wi : awkwardDirections(lobe))
    if (lobe.asks(wi)) asked.push_back(wi);
  const std::vector<Value> values = lobe.evaluate(asked);
  for (size_t i = 0; i < asked.size(); ++i) {
    const auto [f, pdf] = values[i];
    const std::string detail =
        fmt::format("wi.N = {:.3g}: f = ({}, {}, {}), pdf = {}", asked[i].dot(lobe.N()), f.x, f.y, f.z, pdf);
    if (!isFinite(f) || !std::isfinite(pdf)) return lobe.fault("gives a value that is not finite", detail);
    if (std::min({f.x, f.y, f.z, pdf}) < -1e-6f) return lobe.fault("gives a negative value", detail);
  }
  // A batch of one, and planes in place of one value for all, change nothing.
  const std::vector<Value> spread = lobe.evaluate(asked, false);
  for (size_t i = 0; i < asked.size(); ++i)
    for (const Value& other : {spread[i], lobe.evaluate({&asked[i], 1})[0]})
      if (other.f != values[i].f || other.pdf != values[i].pdf)
        return lobe.fault("gives other values in another batch",
                          fmt::format("direction {}: f.x {} and {}", i, values[i].f.x, other.f.x));
}

void expectReciprocal(const LobeAt& lobe) {
  if (lobe.has(PATINA_LOBE_NOT_RECIPROCAL)) return;
  for (const V3f& wi : awkwardDirections(lobe)) {
    const float cosine = wi.dot(lobe.N()), other = lobe.wo().dot(lobe.N());
    if (!(lobe.has(PATINA_LOBE_REFLECTS) && cosine > 0.02f && other > 0.02f)) continue;
    const V3f back = lobe.wo();
    const float there = lobe.evaluate({&wi, 1})[0].f.y / cosine,
                again = lobe.seenFrom(wi).evaluate({&back, 1})[0].f.y / other;
    if (std::abs(there - again) > kReciprocalSlack * std::max(there, again) + 1e-5f)
      return lobe.fault("is not reciprocal, and does not say NOT_RECIPROCAL",
                        fmt::format("f / |wi.N| is {} and {}", there, again));
  }
}

// The sphere in rows about the middle of the samples that grow from their width: narrow lobes have long
// tails.
class Rows {
 public:
  explicit Rows(std::vector<V3f> samples) : frame_(middleOf(samples)) {
    std::vector<double> heights;
    for (const V3f& s : samples) heights.push_back(heightOf(s));
    std::nth_element(heights.begin(), heights.begin() + heights.size() / 2, heights.end());
    scale_ = std::max(heights[heights.size() / 2], 1e-9);
    growth_ = std::log1p(2 / scale_);
  }
  V3f at(double row, double turn) const {
    const double height = std::min(scale_ * std::expm1(growth_ * row), 2.0),
                 phi = 2 * std::numbers::pi * turn;
    const double radius = std::sqrt(std::max(height * (2 - height), 0.0));
    const V3d x(frame_.x), y(frame_.y), z(frame_.z);
    const V3d d = x * (radius * std::cos(phi)) + y * (radius * std::sin(phi)) + z * (1 - height);
    return V3f(d).normalized();
  }
  /// Solid angle for each unit of row times turn.
  double measure(double row) const {
    return 2 * std::numbers::pi * scale_ * growth_ * std::exp(growth_ * row);
  }
  size_t cellOf(const V3f& d) const {
    const double row = std::log1p(heightOf(d) / scale_) / growth_;
    const V3f local = frame_.toLocal(d);
    double turn = std::atan2(double(local.y), double(local.x)) / (2 * std::numbers::pi);
    if (turn < 0) turn += 1;
    const auto cell = [](double x) { return std::min(static_cast<size_t>(x * kCells), size_t(kCells - 1)); };
    return cell(row) * kCells + cell(turn);
  }

 private:
  double heightOf(const V3f& d) const { return double((d - frame_.z).length2()) / 2; }
  // The densest place: that of the samples from which half of them is least far.
  static V3f middleOf(const std::vector<V3f>& samples) {
    V3f best(0, 0, 1);
    double least = 1e30;
    for (size_t i = 0; i < samples.size(); i += std::max<size_t>(samples.size() / 32, 1)) {
      std::vector<double> heights;
      for (size_t j = 0; j < samples.size(); j += 7)
        heights.push_back(double((samples[j] - samples[i]).length2()));
      const auto quarter = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 4);
      std::nth_element(heights.begin(), quarter, heights.end());
      if (*quarter < least) least = *quarter, best = samples[i];
    }
    return best;
  }

  Frame frame_;
  double scale_ = 1, growth_ = 1;
};

void expectDensity(const LobeAt& lobe) {
  const std::vector<V2f> random = stratifiedSquare();
  std::vector<V3f> samples;
  for (const V3f& wi : lobe.sample(random)) {
    if (isBlack(wi)) continue;
    if (!(std::abs(wi.length() - 1) < 1e-3f))
      return lobe.fault("gives directions that are not of unit length",
                        fmt::format("the length is {}", wi.length()));
    if (!lobe.asks(wi) && std::abs(wi.dot(lobe.N())) > 1e-5f)
      return lobe.fault("samples a side that its flags do not name",
                        fmt::format("wi.N = {}", wi.dot(lobe.N())));
    samples.push_back(wi);
  }
  if (samples.empty()) return lobe.fault("gives no samples", "");
  const Rows rows(samples);
  const double share = 1.0 / (kSide * kSide), found = double(samples.size()) * share;
  std::array<double, kCells * kCells> drawn{}, expected{};
  for (const V3f& wi : samples) drawn[rows.cellOf(wi)] += share;

  std::vector<V3f> directions;
  std::vector<double> measures;
  for (uint32_t k = 0; k < kStrata * kStrata; ++k) {
    const double row = (k % kStrata + double(jitter(k, 2))) / kStrata;
    const V3f wi = rows.at(row, (k / kStrata + double(jitter(k, 3))) / kStrata);
    if (!lobe.asks(wi)) continue;
    directions.push_back(wi), measures.push_back(rows.measure(row) / (kStrata * kStrata));
  }
  const std::vector<Value> values = lobe.evaluate(directions);
  double total = 0;
  V3d energy(0, 0, 0);
  for (size_t i = 0; i < values.size(); ++i) {
    total += double(values[i].pdf) * measures[i];
    energy += V3d(values[i].f) * measures[i];
    expected[rows.cellOf(directions[i])] += double(values[i].pdf) * measures[i];
  }
  if (std::abs(total - found) > kIntegralSlack)
    return lobe.fault("has a wrong pdf: it does not integrate to the share of samples that are directions",
                      fmt::format("the integral is {:.4f}, the share {:.4f}", total, found));
  for (uint32_t c = 0; c < expected.size(); ++c)
    if (std::abs(drawn[c] - expected[c]) > kCellSlack)
      return lobe.fault("has a wrong pdf: directions are not drawn by it",
                        fmt::format("of samples {:.4f} are in row {}, column {}, by the pdf {:.4f}", drawn[c],
                                    c / kCells, c % kCells, expected[c]));
  if (const double most = std::max({energy.x, energy.y, energy.z}); most > 1 + kIntegralSlack)
    lobe.fault("makes energy: its f integrates to more than 1", fmt::format("the integral is {:.4f}", most));
}

}  // namespace

void checkCustomLobes(const Context& context) {
  std::vector<Lane> lanes = makeLanes(32, 14);
  const std::vector<Lane> hostile = makeHostileLanes(32, 15);
  lanes.insert(lanes.end(), hostile.begin(), hostile.end());
  forEachSubject(context, [&](Subject& subject) {
    if (subject.customLobes().empty() || !subject.calls(Call::View)) return;
    const Output view = subject.run(Call::View, lanes);
    for (uint32_t which = 0; which < view.lobeCount; ++which) {
      const uint32_t type = view.lobeTypes[which];
      if (type < PATINA_LOBE_CUSTOM || type - PATINA_LOBE_CUSTOM >= subject.customLobes().size()) continue;
      uint32_t integrated = 0;
      for (uint32_t lane = 0; lane < lanes.size(); ++lane) {
        if (isBlack(view.triple(lane, kFirstLobe + kLobeColumns * which + kLobeWeight))) continue;
        const LobeAt lobe(subject, which, view, lane, lanes[lane]);
        expectUsable(lobe);
        if (lane >= 32 || lobe.wo().dot(lobe.N()) < kLeastCosine || integrated == kPoints) continue;
        ++integrated;
        expectReciprocal(lobe);
        expectDensity(lobe);
      }
    }
    subject.reportComplaints(callName(Call::View));
  });
}

}  // namespace patina::shadercheck
