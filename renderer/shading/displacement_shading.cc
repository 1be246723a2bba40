// SPDX-License-Identifier: Apache-2.0
// Batches of vertices through the entry point `displacement`.
#include "renderer/shading/displacement_shading.h"

#include <fmt/format.h>

#include <array>
#include <string>

#include "renderer/base/statistics.h"
#include "renderer/shading/shader_validation.h"
#include "renderer/shading/surface_batch.h"

namespace patina {

struct DisplacementShading::Statistics {
  std::array<std::string, 2> names;
  StatCounter calls, points;
  explicit Statistics(const std::string& shader)
      : names{"Shaders/" + shader + "/displacement/calls", "Shaders/" + shader + "/displacement/points"},
        calls(names[0]),
        points(names[1]) {}
};

DisplacementShading::~DisplacementShading() = default;

DisplacementShading::DisplacementShading(std::span<const ShaderInstance* const> shaders, bool grows) {
  if (grows) shaders_.makeRoom(), statistics_.makeRoom();
  growTo(shaders.size());
  for (uint32_t k = 0; k < shaders.size(); ++k) setShader(k, shaders[k]);
}

void DisplacementShading::growTo(size_t shaders) {
  shaders_.growTo(shaders);
  statistics_.growTo(shaders);
}

void DisplacementShading::setShader(uint32_t shader, const ShaderInstance* instance) {
  shaders_[shader] = instance;
  statistics_[shader] = instance && instance->active(PATINA_ENTRY_DISPLACEMENT)
                            ? std::make_unique<Statistics>(std::string(instance->name()))
                            : nullptr;
}

bool DisplacementShading::isNeeded(const Scene& scene) const {
  return std::any_of(scene.attributes.begin(), scene.attributes.end(),
                     [&](const Attributes& attributes) { return boundOf(attributes).has_value(); });
}

std::optional<Displacer::Bound> DisplacementShading::boundOf(const Attributes& attributes) const {
  if (attributes.displacement == kNone || !statistics_[attributes.displacement]) return std::nullopt;
  return Bound{attributes.displacementBound, shaders_[attributes.displacement]->traits().displacement_bound};
}

bool DisplacementShading::displace(const Vertices& vertices) const {
  const ShaderInstance& shader = *shaders_[vertices.attributes.displacement];
  const SurfaceVariables variables(vertices.primitive);
  const size_t n = vertices.P.size();
  thread_local SurfaceBatch batch;
  std::vector<BatchPoint>& lanes = batch.begin(n);
  for (size_t i = 0; i < n; ++i)
    lanes[i] = {&vertices.primitive, &variables,       &vertices.surface,    &vertices.attributes,
                vertices.face,       vertices.uv[i].x, vertices.uv[i].y,     vertices.P[i],
                vertices.N[i],       vertices.Ng[i],   vertices.footprint[i]};
  const PatinaPoints in =
      batch.fill(shader, shader.reads(PATINA_ENTRY_DISPLACEMENT),
                 [&](size_t i, V3f& du, V3f& dv) { du = vertices.dPdu[i], dv = vertices.dPdv[i]; });
  Planes& planes = batch.planes();
  const auto copy = [&](std::span<const V3f> values) {
    const PatinaOut3 out = planes.out3(0);
    for (size_t i = 0; i < n; ++i) out.x[i] = values[i].x, out.y[i] = values[i].y, out.z[i] = values[i].z;
    return out;
  };
  PatinaDisplacementOut result{};
  result.struct_size = sizeof(result);
  result.P = copy(vertices.P), result.N = copy(vertices.N);
  Statistics& statistics = *statistics_[vertices.attributes.displacement];
  ++statistics.calls;
  statistics.points += static_cast<int64_t>(n);
  const auto place = [&](size_t i) {
    return fmt::format("({}, {}, {}), (u, v) = ({}, {}) of face {} of the primitive at {}", vertices.P[i].x,
                       vertices.P[i].y, vertices.P[i].z, vertices.uv[i].x, vertices.uv[i].y, vertices.face,
                       toString(vertices.primitive.where));
  };
  const auto firstPlace = [&] { return place(0); };
  const CallPlace called(firstPlace);
  if (shader.displacement(in, result) != PATINA_OK) return false;
  if (validatesShaders()) {
    reportDamage(shader, "displacement", planes, place);
    validateDisplacement(shader, in, result, vertices.P, vertices.N, place);
  }
  uint64_t bad = 0;
  size_t first = 0;
  for (size_t i = 0; i < n; ++i) {
    bool wrong = false;
    const V3f P(result.P.x[i], result.P.y[i], result.P.z[i]);
    if (isFinite(P) && maxAbsComponent(P) < 1e15f)
      vertices.P[i] = P;
    else
      wrong = true;
    if (result.writes_normal) {
      const V3f N(result.N.x[i], result.N.y[i], result.N.z[i]);
      if (const float length = N.length(); length > 0 && std::isfinite(length))
        vertices.N[i] = N / length;
      else
        wrong = true;
    }
    if (wrong && bad++ == 0) first = i;
  }
  if (bad > 0)
    shader.fault(ShaderHost::kBadDisplacement, bad, vertices.P[first], [&] {
      return "moved vertices to where nothing is (not finite, or beyond 1e15), or gave normals without a "
             "direction; those are left as they were. The first is at " +
             place(first);
    });
  return result.writes_normal != 0;
}

}  // namespace patina
