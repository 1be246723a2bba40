// SPDX-License-Identifier: Apache-2.0
// Batches of light samples.
#include "renderer/shading/lights.h"

#include <fmt/format.h>

#include <string>

#include "renderer/base/statistics.h"
#include "renderer/shading/light_validation.h"
#include "renderer/shading/planes.h"
#include "renderer/shading/shader_validation.h"

namespace patina {
namespace {

STAT_TIME("Time of threads/lights", lightTime);

constexpr size_t kBatch = 256;
constexpr int32_t kShadowColor = -400;  // the code of a message

Rgb at(const PatinaOut3& out, size_t i) { return {out.x[i], out.y[i], out.z[i]}; }
bool isSane(const Rgb& c) {  // negative light is odd, but a way to take some away
  return std::abs(c.x) < 1e30f && std::abs(c.y) < 1e30f && std::abs(c.z) < 1e30f;
}

/// The value of the shader's parameter "shadowcolor"; black where it has none.
Rgb shadowColorOf(const ShaderInstance& shader) {
  const PatinaShader& table = shader.shader();
  for (uint32_t k = 0; k < table.parameter_count; ++k) {
    const auto& parameter = *reinterpret_cast<const PatinaParameter*>(
        reinterpret_cast<const std::byte*>(table.parameters) + size_t(k) * table.parameter_stride);
    if (parameter.type != PATINA_COLOR || parameter.array_length != 0 ||
        std::string_view(parameter.name) != "shadowcolor")
      continue;
    const PatinaValue& value = shader.values()[k];
    Rgb color(0, 0, 0);
    for (int c = 0; c < 3; ++c) color[c] = std::clamp(value.floats[size_t(c) * value.plane], 0.0f, 1.0f);
    return color;
  }
  return {0, 0, 0};
}

}  // namespace

struct Lights::Statistics {
  StatCounter calls, points, replaced;
  std::unique_ptr<LightValidation> validation;  // where it is asked for
  explicit Statistics(const std::string& shader)
      : calls("Shaders/" + shader + "/light/calls"),
        points("Shaders/" + shader + "/light/points"),
        replaced("Shaders/" + shader + "/light/points with values replaced") {}
};

/// Takes what a light's shader gave; what makes no sense is no light, and is reported in the end.
class Lights::Checked {
 public:
  explicit Checked(const Entry& light) : light_(light) {}
  ~Checked() {
    if (count_ == 0) return;
    light_.statistics->replaced += static_cast<int64_t>(count_);
    light_.shader->fault(ShaderHost::kBadLight, count_, first_, [&] {
      return fmt::format(
          "light gave directions, radiance or densities that are not finite or too large; they count as no "
          "light. "
          "The first is for the point ({}, {}, {})",
          first_.x, first_.y, first_.z);
    });
  }
  Checked(const Checked&) = delete;
  Checked& operator=(const Checked&) = delete;

  Rgb color(const Rgb& c, const V3f& P) {
    if (isSane(c)) return c;
    note(P);
    return {0, 0, 0};
  }
  float density(float pdf, const V3f& P) {
    if (pdf >= 0 && std::isfinite(pdf)) return pdf;
    note(P);
    return 0;
  }

 private:
  void note(const V3f& P) {
    if (count_++ == 0) first_ = P;
  }
  const Entry& light_;
  uint64_t count_ = 0;
  V3f first_{0, 0, 0};
};

Lights::~Lights() = default;

Lights::Lights(const Geometry& geometry, std::span<const ShaderInstance* const> shaders) {
  const Scene& scene = geometry.scene();
  for (const Light& light : scene.lights) {
    Entry entry;
    entry.shader = light.shader == kNone ? nullptr : shaders[light.shader];
    if (entry.shader && entry.shader->active(PATINA_ENTRY_LIGHT)) {
      entry.kind = static_cast<PatinaLightKind>(entry.shader->traits().light_kind);
      // An area light without geometry, and a light from nowhere bound to geometry, give no light.
      if (light.isArea != (entry.kind == PATINA_LIGHT_AREA)) entry.kind = PATINA_LIGHT_NONE;
      entry.castsShadows = light.castsShadows && !entry.shader->has(PATINA_TRAIT_UNSHADOWED);
      entry.smooth = entry.shader->has(PATINA_TRAIT_SMOOTH);
      entry.twoSided = entry.shader->has(PATINA_TRAIT_TWO_SIDED);
      entry.cameraVisible = entry.shader->has(PATINA_TRAIT_CAMERA_VISIBLE);
      entry.power = entry.shader->traits().light_power;
      entry.shadowColor = shadowColorOf(*entry.shader);
      if (!isBlack(entry.shadowColor) && entry.kind != PATINA_LIGHT_DELTA) {
        const PatinaHost& host = entry.shader->host();
        host.report(host.host, PATINA_REPORT_WARNING, kShadowColor,
                    "shadowcolor is for lights without a size: these shadows are black");
        entry.shadowColor = Rgb(0, 0, 0);
      }
      if (entry.shadowColor == Rgb(1, 1, 1)) entry.castsShadows = false;
      hasShadowColors_ |= entry.castsShadows && !isBlack(entry.shadowColor);
      entry.statistics = std::make_unique<Statistics>(std::string(entry.shader->name()));
      if (validatesShaders()) entry.statistics->validation = std::make_unique<LightValidation>(*entry.shader);
    }
    if (entry.kind == PATINA_LIGHT_AREA) entry.emitters = std::make_unique<Emitters>();
    if (entry.kind == PATINA_LIGHT_INFINITE) infinite_.push_back(static_cast<uint32_t>(lights_.size()));
    lights_.push_back(std::move(entry));
  }
  for (uint32_t k = 0; k < geometry.placements().size(); ++k) {
    const uint32_t light = geometry.attributes(geometry.placements()[k]).areaLight;
    if (light != kNone && lights_[light].emitters) lights_[light].emitters->add(geometry, k);
  }
  for (Entry& light : lights_)
    if (light.emitters) {
      light.emitters->finish();
      if (light.emitters->empty())
        light.kind = PATINA_LIGHT_NONE;
      else if (light.shader->has(PATINA_TRAIT_PER_AREA))
        light.scale = 1 / light.emitters->totalArea();
      light.power *= light.emitters->totalArea() * kPi * light.scale;
    }
}

LightBounds Lights::bounds(uint32_t index) const {
  const Entry& light = lights_[index];
  LightBounds bounds;
  if (light.kind == PATINA_LIGHT_AREA) {
    bounds = light.emitters->bounds();
    bounds.twoSided = light.twoSided;
    bounds.power = light.power;
    return bounds;
  }
  bounds.power = light.power;
  if (light.kind != PATINA_LIGHT_DELTA || !light.shader->has(PATINA_TRAIT_FROM_POINT)) return bounds;
  const PatinaTraits& traits = light.shader->traits();
  const V3f from(traits.light_from), axis(traits.light_axis);
  if (!isFinite(from)) return bounds;
  bounds.box = Box3f(from);
  // The cone is passed as a spread with no light beyond: inside it is taken to be as bright as on the axis.
  const float cone = traits.light_cone;
  const V3f unit = normalizedOr(axis, V3f(0, 0, 0));
  if (!isBlack(unit) && cone >= 0 && cone < kPi) bounds.cone = {unit, cone, 0};
  bounds.power *= kPi;  // as all of delta lights: see LightSample::radiance
  return bounds;
}

PatinaStatus Lights::call(const Entry& light, const PatinaLightIn& in, Planes& planes,
                          PatinaLightOut& out) const {
  ++light.statistics->calls;
  light.statistics->points += in.count;
  const auto place = [&] {
    const auto at = [](const PatinaPlane& plane) { return plane.data ? plane.data[0] : 0; };
    return fmt::format("({}, {}, {})", at(in.P.x), at(in.P.y), at(in.P.z));
  };
  const CallPlace called(place);
  const PatinaStatus status = light.shader->light(in, out);
  if (light.statistics->validation) {
    reportDamage(*light.shader, "light", planes, [&](size_t) { return place(); });
    if (status == PATINA_OK) light.statistics->validation->check(in, out);
  }
  return status;
}

namespace {

PatinaLightIn makeIn(const ShaderInstance& shader, Planes& planes, size_t n, PatinaLightTask task) {
  planes.begin(n, validatesShaders());
  PatinaLightIn in{};
  in.struct_size = sizeof(in);
  in.count = static_cast<uint32_t>(n);
  in.padded = static_cast<uint32_t>(planes.padded());
  in.task = task;
  in.values = shader.values().data();
  in.value_stride = sizeof(PatinaValue);
  in.time = planes.uniform(0);
  return in;
}

PatinaLightOut makeOut(Planes& planes) {
  PatinaLightOut out{};
  out.struct_size = sizeof(out);
  out.direction = planes.out3(0);
  out.distance = planes.out(PATINA_INFINITE_DISTANCE);
  out.radiance = planes.out3(0);
  out.pdf = planes.out(0);
  return out;
}

}  // namespace

void Lights::sample(uint32_t index, std::span<const V3f> points, std::span<const V2f> random,
                    std::span<LightSample> out) const {
  const TimeShare share(lightTime);
  const Entry& light = lights_[index];
  std::fill(out.begin(), out.end(), LightSample{});
  if (light.kind == PATINA_LIGHT_NONE || light.kind == PATINA_LIGHT_AMBIENT) return;
  thread_local Planes planes;
  thread_local std::vector<EmitterSample> chosen;
  for (size_t base = 0; base < points.size(); base += kBatch) {
    const size_t n = std::min(kBatch, points.size() - base);
    const auto p = points.subspan(base, n);
    const auto r = random.subspan(base, n);
    const auto o = out.subspan(base, n);
    if (light.kind == PATINA_LIGHT_AREA) {
      chosen.resize(n);
      bool any = false;
      for (size_t i = 0; i < n; ++i) {
        EmitterSample& e = chosen[i] = light.emitters->sample(p[i], r[i]);
        const V3f d = p[i] - e.P;
        if (!light.twoSided && !(d.dot(e.N) > 0)) e.pdf = 0;
        any |= e.pdf > 0;
        LightSample& s = o[i];
        s.distance = d.length();
        s.direction = s.distance > 0 ? -d / s.distance : V3f(0, 0, 1);
        s.target = leave({e.P, e.N, e.error}, d);
        s.pdf = e.pdf;
      }
      if (!any) continue;
      PatinaLightIn in = makeIn(*light.shader, planes, n, PATINA_LIGHT_EMIT);
      in.P = planes.fill3(n, [&](size_t i) { return chosen[i].P; });
      in.N = planes.fill3(n, [&](size_t i) { return chosen[i].N; });
      in.direction = planes.fill3(n, [&](size_t i) { return -o[i].direction; });
      in.u = planes.fill(n, [&](size_t i) { return chosen[i].u; });
      in.v = planes.fill(n, [&](size_t i) { return chosen[i].v; });
      PatinaLightOut result = makeOut(planes);
      Checked checked(light);
      if (call(light, in, planes, result) == PATINA_OK)
        for (size_t i = 0; i < n; ++i)
          o[i].radiance = checked.color(at(result.radiance, i) * light.scale, chosen[i].P);
    } else {
      PatinaLightIn in = makeIn(*light.shader, planes, n, PATINA_LIGHT_SAMPLE);
      in.P = planes.fill3(n, [&](size_t i) { return p[i]; });
      in.random_x = planes.fill(n, [&](size_t i) { return r[i].x; });
      in.random_y = planes.fill(n, [&](size_t i) { return r[i].y; });
      PatinaLightOut result = makeOut(planes);
      Checked checked(light);
      if (call(light, in, planes, result) != PATINA_OK) continue;
      for (size_t i = 0; i < n; ++i) {
        LightSample& s = o[i];
        s.direction = checked.color(at(result.direction, i), p[i]);
        s.radiance = checked.color(at(result.radiance, i), p[i]);
        s.delta = light.kind == PATINA_LIGHT_DELTA;
        if (s.delta) s.radiance *= kPi;
        s.pdf = s.delta ? 1 : checked.density(result.pdf[i], p[i]);
        const float distance = result.distance[i];
        if (distance < 0.5f * PATINA_INFINITE_DISTANCE) {
          s.distance = distance;
          s.target = p[i] + s.direction * distance;
        }
      }
    }
    for (size_t i = 0; i < n; ++i)
      if (!(o[i].pdf > 0) || !std::isfinite(o[i].pdf) || isBlack(o[i].radiance)) o[i].pdf = 0;
  }
}

void Lights::ambient(uint32_t index, std::span<const V3f> points, std::span<Rgb> out) const {
  const TimeShare share(lightTime);
  const Entry& light = lights_[index];
  std::fill(out.begin(), out.end(), Rgb(0, 0, 0));
  if (light.kind != PATINA_LIGHT_AMBIENT) return;
  thread_local Planes planes;
  for (size_t base = 0; base < points.size(); base += kBatch) {
    const size_t n = std::min(kBatch, points.size() - base);
    PatinaLightIn in = makeIn(*light.shader, planes, n, PATINA_LIGHT_SAMPLE);
    in.P = planes.fill3(n, [&](size_t i) { return points[base + i]; });
    in.random_x = in.random_y = planes.uniform(0.5f);
    PatinaLightOut result = makeOut(planes);
    Checked checked(light);
    if (call(light, in, planes, result) == PATINA_OK)
      for (size_t i = 0; i < n; ++i) out[base + i] = checked.color(at(result.radiance, i), points[base + i]);
  }
}

void Lights::evaluate(uint32_t index, std::span<const V3f> points, std::span<const V3f> directions,
                      std::span<Rgb> radiance, std::span<float> pdf) const {
  const TimeShare share(lightTime);
  const Entry& light = lights_[index];
  std::fill(radiance.begin(), radiance.end(), Rgb(0, 0, 0));
  std::fill(pdf.begin(), pdf.end(), 0.0f);
  if (light.kind != PATINA_LIGHT_INFINITE) return;
  thread_local Planes planes;
  for (size_t base = 0; base < points.size(); base += kBatch) {
    const size_t n = std::min(kBatch, points.size() - base);
    PatinaLightIn in = makeIn(*light.shader, planes, n, PATINA_LIGHT_EVALUATE);
    in.P = planes.fill3(n, [&](size_t i) { return points[base + i]; });
    in.direction = planes.fill3(n, [&](size_t i) { return directions[base + i]; });
    PatinaLightOut result = makeOut(planes);
    Checked checked(light);
    if (call(light, in, planes, result) != PATINA_OK) continue;
    for (size_t i = 0; i < n; ++i) {
      radiance[base + i] = checked.color(at(result.radiance, i), points[base + i]);
      pdf[base + i] = checked.density(result.pdf[i], points[base + i]);
    }
  }
}

Rgb Lights::emitted(uint32_t index, const ShadingPoint& point, const V3f& direction, const V2f& uv) const {
  const Entry& light = lights_[index];
  if (light.kind != PATINA_LIGHT_AREA || (!light.twoSided && !point.front)) return {0, 0, 0};
  thread_local Planes planes;
  PatinaLightIn in = makeIn(*light.shader, planes, 1, PATINA_LIGHT_EMIT);
  const V3f outside = point.front ? point.Ng : -point.Ng;
  in.P = planes.fill3(1, [&](size_t) { return point.P; });
  in.N = planes.fill3(1, [&](size_t) { return outside; });
  in.direction = planes.fill3(1, [&](size_t) { return direction; });
  in.u = planes.fill(1, [&](size_t) { return uv.x; });
  in.v = planes.fill(1, [&](size_t) { return uv.y; });
  PatinaLightOut result = makeOut(planes);
  Checked checked(light);
  if (call(light, in, planes, result) != PATINA_OK) return {0, 0, 0};
  return checked.color(at(result.radiance, 0) * light.scale, point.P);
}

float Lights::areaPdf(uint32_t index, const V3f& from, const ShadingPoint& onLight) const {
  const Entry& light = lights_[index];
  return light.emitters ? light.emitters->pdf(onLight.placement, onLight.face, from, onLight.P, onLight.Ng)
                        : 0;
}

}  // namespace patina
