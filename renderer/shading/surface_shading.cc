// SPDX-License-Identifier: Apache-2.0
// Batches of points through the entry points `radiosity` and `view`.
#include "renderer/shading/surface_shading.h"

#include <array>
#include <numeric>
#include <string>

#include "renderer/base/statistics.h"
#include "renderer/shading/planes.h"

namespace patina {
namespace {

STAT_COUNTER("Shaders/values that were not finite", badValues);
constexpr size_t kBatch = 256;

/// NaN, infinity and what would overflow a sum of squares do not leave a shader.
bool repair(Rgb& c) {
  if (std::abs(c.x) < 1e18f && std::abs(c.y) < 1e18f && std::abs(c.z) < 1e18f) return false;
  c = Rgb(0, 0, 0);
  return true;
}

struct OutPlanes {
  PatinaOut3 out;
  Rgb operator[](size_t i) const { return {out.x[i], out.y[i], out.z[i]}; }
};

}  // namespace

struct SurfaceShading::Statistics {
  std::array<std::string, 4> names;
  StatCounter radiosityCalls, radiosityPoints, viewCalls, viewPoints;
  explicit Statistics(const std::string& shader)
      : names{"Shaders/" + shader + "/radiosity/calls", "Shaders/" + shader + "/radiosity/points",
              "Shaders/" + shader + "/view/calls", "Shaders/" + shader + "/view/points"},
        radiosityCalls(names[0]),
        radiosityPoints(names[1]),
        viewCalls(names[2]),
        viewPoints(names[3]) {}
};

SurfaceShading::~SurfaceShading() = default;

SurfaceShading::SurfaceShading(const Geometry& geometry, std::vector<const ShaderInstance*> surfaces)
    : geometry_(geometry), surfaces_(std::move(surfaces)) {
  for (const ShaderInstance* shader : surfaces_)
    statistics_.push_back(shader ? std::make_unique<Statistics>(std::string(shader->name())) : nullptr);
  for (const TracedSurface& traced : geometry.traced()) {
    Variables v;
    for (const PrimVar& variable : traced.primitive->variables) {
      if (variable.name == "N" || variable.name == "Np") {
        if (variable.components == 3) v.N = &variable;
      } else if (variable.name == "Cs") {
        if (variable.components == 3) v.Cs = &variable;
      } else if (variable.name == "Os") {
        if (variable.components == 3) v.Os = &variable;
      } else if (variable.name == "s") {
        if (variable.components == 1) v.s = &variable;
      } else if (variable.name == "t") {
        if (variable.components == 1) v.t = &variable;
      } else if (variable.name == "st") {
        if (variable.components >= 2) v.st = &variable;
      } else if (variable.name != "P" && variable.name != "Pw") {
        v.others = true;
      }
    }
    variables_.push_back(v);
  }
  const auto fallback = static_cast<uint32_t>(surfaces_.size() - 1);
  for (const Placement& placement : geometry.placements()) {
    const Attributes& attributes = geometry.attributes(placement);
    const uint32_t wanted = attributes.surface;
    const uint32_t shader = wanted == kNone || !surfaces_[wanted] ? fallback : wanted;
    shaderIndex_.push_back(shader);
    const bool isOs = surfaces_[shader]->has(PATINA_TRAIT_OPACITY_IS_OS);
    const bool opaque = surfaces_[shader]->has(PATINA_TRAIT_OPAQUE) ||
                        (isOs && !variables_[placement.traced].Os && attributes.opacity == Rgb(1, 1, 1)) ||
                        (!isOs && !surfaces_[shader]->active(PATINA_ENTRY_RADIOSITY));
    opaque_.push_back(opaque);
    allOpaque_ = allOpaque_ && opaque;
  }
}

void SurfaceShading::orient(ShadingPoint& p) const {
  const Placement& placement = geometry_.placements()[p.placement];
  const Surface& surface = geometry_.surface(placement);
  const PrimVar* given = variables_[placement.traced].N;
  V3f normal = p.Ng;
  if (given) {
    surface.interpolate(*given, p.face, p.u, p.v, &normal.x);
    normal = normalizedOr(transformNormal(normal, placement.worldToObject), p.Ng);
  } else if (surface.hasSmoothNormals()) {
    normal =
        normalizedOr(transformNormal(surface.evaluate(p.face, p.u, p.v).N, placement.worldToObject), p.Ng);
  }
  p.N = normal.dot(p.Ng) < 0 ? -normal : normal;
}

ShadingPoint SurfaceShading::at(const Hit& hit, const V3f& direction, float footprint) const {
  const Facet facet = geometry_.facet(hit.placement, hit.face, hit.u, hit.v);
  ShadingPoint p;
  p.placement = hit.placement, p.face = hit.face, p.u = hit.u, p.v = hit.v;
  p.front = hit.front;
  p.P = facet.P, p.Ng = p.front ? facet.N : -facet.N, p.error = facet.error;
  p.I = direction;
  p.footprint = footprint;
  orient(p);
  return p;
}

ShadingPoint SurfaceShading::at(uint32_t placement, uint32_t face, float u, float v, bool front,
                                float footprint) const {
  const Facet facet = geometry_.facet(placement, face, u, v);
  ShadingPoint p;
  p.placement = placement, p.face = face, p.u = u, p.v = v;
  p.front = front;
  p.P = facet.P, p.Ng = front ? facet.N : -facet.N, p.error = facet.error;
  p.footprint = footprint;
  orient(p);
  return p;
}

void SurfaceShading::shade(std::span<const ShadingPoint> points, ShadingParts parts,
                           ShadedPoints& out) const {
  out.terms.assign(points.size(), SurfaceTerms{});
  out.lobes.clear();
  thread_local std::vector<uint32_t> order;
  order.resize(points.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto shaderAt = [&](uint32_t k) { return shaderIndex_[points[k].placement]; };
  if (!std::all_of(order.begin(), order.end(), [&](uint32_t k) { return shaderAt(k) == shaderAt(0); }))
    std::stable_sort(order.begin(), order.end(),
                     [&](uint32_t a, uint32_t b) { return shaderAt(a) < shaderAt(b); });
  for (size_t begin = 0; begin < order.size();) {
    size_t end = begin + 1;
    while (end < order.size() && end - begin < kBatch && shaderAt(order[end]) == shaderAt(order[begin]))
      ++end;
    shadeBatch(shaderAt(order[begin]), points, std::span(order).subspan(begin, end - begin), parts, out);
    begin = end;
  }
}

void SurfaceShading::shadeBatch(uint32_t shaderIndex, std::span<const ShadingPoint> points,
                                std::span<const uint32_t> which, ShadingParts parts,
                                ShadedPoints& out) const {
  const ShaderInstance& shader = *surfaces_[shaderIndex];
  const bool view = parts == ShadingParts::RadiosityAndView && shader.active(PATINA_ENTRY_VIEW);
  const bool radiosity = shader.active(PATINA_ENTRY_RADIOSITY);
  if (!radiosity && shader.has(PATINA_TRAIT_OPACITY_IS_OS))
    for (const uint32_t k : which) {
      const ShadingPoint& p = points[k];
      const Placement& placement = geometry_.placements()[p.placement];
      out.terms[k].opacity = geometry_.attributes(placement).opacity;
      if (const PrimVar* given = variables_[placement.traced].Os)
        geometry_.surface(placement).interpolate(*given, p.face, p.u, p.v, &out.terms[k].opacity.x);
    }
  if (!radiosity && !view) return;
  const uint64_t reads =
      (radiosity ? shader.reads(PATINA_ENTRY_RADIOSITY) : 0) | (view ? shader.reads(PATINA_ENTRY_VIEW) : 0);
  const size_t n = which.size();
  thread_local Planes planes;
  planes.begin(n);

  PatinaPoints in{};
  in.struct_size = sizeof(in);
  in.count = static_cast<uint32_t>(n);
  in.padded = static_cast<uint32_t>(planes.padded());
  const auto point = [&](size_t i) -> const ShadingPoint& { return points[which[i]]; };
  const auto traced = [&](size_t i) { return geometry_.placements()[point(i).placement].traced; };
  const auto fill3 = [&](auto value) { return planes.fill3(n, value); };
  const auto fill1 = [&](auto value) { return planes.fill(n, value); };

  if (reads & PATINA_CHANNEL_P) in.P = fill3([&](size_t i) { return point(i).P; });
  if (reads & PATINA_CHANNEL_N) in.N = fill3([&](size_t i) { return point(i).N; });
  if (reads & PATINA_CHANNEL_NG) in.Ng = fill3([&](size_t i) { return point(i).Ng; });
  if (reads & PATINA_CHANNEL_FOOTPRINT) in.footprint = fill1([&](size_t i) { return point(i).footprint; });
  if (reads & PATINA_CHANNEL_TIME) in.time = planes.uniform(0);
  if (reads & (PATINA_CHANNEL_DPDU | PATINA_CHANNEL_DPDV | PATINA_CHANNEL_FOOTPRINT)) {
    thread_local std::vector<V3f> du, dv;
    du.resize(n), dv.resize(n);
    for (size_t i = 0; i < n; ++i) {
      const ShadingPoint& p = point(i);
      const Placement& placement = geometry_.placements()[p.placement];
      const SurfacePoint s = geometry_.surface(placement).evaluate(p.face, p.u, p.v);
      du[i] = transformVector(s.dPdu, placement.objectToWorld);
      dv[i] = transformVector(s.dPdv, placement.objectToWorld);
    }
    in.dPdu = fill3([&](size_t i) { return du[i]; });
    in.dPdv = fill3([&](size_t i) { return dv[i]; });
    // Texture coordinates run along the surface's own parameters unless variables say otherwise.
    in.footprint_st = fill1([&](size_t i) {
      const V2f scale =
          geometry_.surface(geometry_.placements()[point(i).placement]).parameterScale(point(i).face);
      const float perU = scale.x / std::max(du[i].length(), 1e-20f),
                  perV = scale.y / std::max(dv[i].length(), 1e-20f);
      return std::min(point(i).footprint * std::max(perU, perV), 1.0f);
    });
  }
  if (reads & (PATINA_CHANNEL_UV | PATINA_CHANNEL_ST)) {
    thread_local std::vector<V2f> uv, st;
    uv.resize(n), st.resize(n);
    for (size_t i = 0; i < n; ++i) {
      const ShadingPoint& p = point(i);
      const Placement& placement = geometry_.placements()[p.placement];
      const Surface& surface = geometry_.surface(placement);
      const Variables& variables = variables_[placement.traced];
      uv[i] = surface.surfaceParameters(p.face, p.u, p.v);
      const std::array<float, 8>& c = geometry_.attributes(placement).textureCoordinates;
      const auto [a, b] = surface.textureParameters(p.face, p.u, p.v);
      st[i] = V2f(c[0], c[1]) * ((1 - a) * (1 - b)) + V2f(c[2], c[3]) * (a * (1 - b)) +
              V2f(c[4], c[5]) * ((1 - a) * b) + V2f(c[6], c[7]) * (a * b);
      if (variables.st) {
        float value[16];
        if (variables.st->components <= 16) surface.interpolate(*variables.st, p.face, p.u, p.v, value);
        st[i] = {value[0], value[1]};
      }
      if (variables.s) surface.interpolate(*variables.s, p.face, p.u, p.v, &st[i].x);
      if (variables.t) surface.interpolate(*variables.t, p.face, p.u, p.v, &st[i].y);
    }
    in.u = fill1([&](size_t i) { return uv[i].x; });
    in.v = fill1([&](size_t i) { return uv[i].y; });
    in.s = fill1([&](size_t i) { return st[i].x; });
    in.t = fill1([&](size_t i) { return st[i].y; });
  }
  const auto color = [&](const PrimVar* Variables::*variable, Rgb Attributes::*fallback) {
    return fill3([&](size_t i) {
      const ShadingPoint& p = point(i);
      const Placement& placement = geometry_.placements()[p.placement];
      Rgb c = geometry_.attributes(placement).*fallback;
      if (const PrimVar* given = variables_[placement.traced].*variable)
        geometry_.surface(placement).interpolate(*given, p.face, p.u, p.v, &c.x);
      return c;
    });
  };
  if (reads & PATINA_CHANNEL_CS) in.Cs = color(&Variables::Cs, &Attributes::color);
  if (reads & PATINA_CHANNEL_OS) in.Os = color(&Variables::Os, &Attributes::opacity);

  // Parameters: the instance's values, those of primitive variables in their place.
  std::span<const PatinaValue> values = shader.values();
  thread_local std::vector<PatinaValue> changed;
  const bool mayVary =
      !shader.varyingParameters().empty() && std::any_of(which.begin(), which.end(), [&](uint32_t k) {
        return variables_[geometry_.placements()[points[k].placement].traced].others;
      });
  if (mayVary) {
    changed.assign(values.begin(), values.end());
    for (const ShaderInstance::VaryingParameter& parameter : shader.varyingParameters()) {
      const auto variableOf = [&](size_t i) -> const PrimVar* {
        if (!variables_[traced(i)].others) return nullptr;
        const PrimVar* found = findVariable(*geometry_.traced()[traced(i)].primitive, parameter.name);
        return found && found->floats.size() && found->components == static_cast<int>(parameter.components)
                   ? found
                   : nullptr;
      };
      bool any = false;
      for (size_t i = 0; i < n && !any; ++i) any = variableOf(i) != nullptr;
      if (!any) continue;
      const PatinaValue& constant = values[parameter.index];
      float* block = planes.take(parameter.components);
      std::array<float, 64> value{};
      for (size_t i = 0; i < planes.padded(); ++i) {
        const ShadingPoint& p = point(std::min(i, n - 1));
        const PrimVar* variable =
            parameter.components <= value.size() ? variableOf(std::min(i, n - 1)) : nullptr;
        if (variable)
          geometry_.surface(geometry_.placements()[p.placement])
              .interpolate(*variable, p.face, p.u, p.v, value.data());
        for (uint32_t c = 0; c < parameter.components; ++c)
          block[c * planes.padded() + i] = variable ? value[c] : constant.floats[c * constant.plane];
      }
      PatinaValue& varying = changed[parameter.index];
      varying.floats = block;
      varying.stride = 1;
      varying.plane = static_cast<uint32_t>(planes.padded());
    }
    values = changed;
  }
  in.values = values.data();
  in.value_stride = sizeof(PatinaValue);

  Statistics& statistics = *statistics_[shaderIndex];
  bool bad = false;
  if (radiosity) {
    PatinaRadiosityOut result{};
    result.struct_size = sizeof(result);
    result.emission = planes.out3(0), result.reflectance = planes.out3(0),
    result.transmittance = planes.out3(0);
    result.ambient = planes.out3(0), result.opacity = planes.out3(1);
    ++statistics.radiosityCalls;
    statistics.radiosityPoints += static_cast<int64_t>(n);
    if (shader.radiosity(in, result) == PATINA_OK)
      for (size_t i = 0; i < n; ++i) {
        SurfaceTerms& t = out.terms[which[i]];
        t.emission = OutPlanes{result.emission}[i], t.reflectance = OutPlanes{result.reflectance}[i];
        t.transmittance = OutPlanes{result.transmittance}[i], t.ambient = OutPlanes{result.ambient}[i];
        t.opacity = OutPlanes{result.opacity}[i];
        const bool wrong =
            repair(t.emission) | repair(t.reflectance) | repair(t.transmittance) | repair(t.ambient);
        if (repair(t.opacity)) t.opacity = Rgb(1, 1, 1), bad = true;
        bad |= wrong;
      }
  }
  if (view) {
    in.I = planes.fill3(n, [&](size_t i) { return point(i).I; });
    std::array<PatinaLobe, PATINA_MAX_LOBES> lobes{};
    for (PatinaLobe& lobe : lobes) {
      lobe.struct_size = sizeof(PatinaLobe);
      lobe.weight = planes.out3(0), lobe.transmission = planes.out3(0);
      lobe.alpha = planes.out(0), lobe.eta = planes.out(1);
    }
    PatinaViewOut result{};
    result.struct_size = sizeof(result);
    result.emission = planes.out3(0);
    result.lobes = lobes.data();
    result.lobe_stride = sizeof(PatinaLobe);
    ++statistics.viewCalls;
    statistics.viewPoints += static_cast<int64_t>(n);
    if (shader.view(in, result) == PATINA_OK)
      for (size_t i = 0; i < n; ++i) {
        SurfaceTerms& t = out.terms[which[i]];
        Rgb emission = OutPlanes{result.emission}[i];
        bad |= repair(emission);
        t.viewEmission = emission;
        t.firstLobe = static_cast<uint32_t>(out.lobes.size());
        for (uint32_t k = 0; k < std::min(result.lobe_count, PATINA_MAX_LOBES); ++k) {
          Lobe lobe{lobes[k].type, OutPlanes{lobes[k].weight}[i], OutPlanes{lobes[k].transmission}[i],
                    lobes[k].alpha[i], lobes[k].eta[i]};
          const bool wrong = repair(lobe.weight) | repair(lobe.transmission);
          if (!(lobe.alpha >= 0 && lobe.alpha < 1e6f)) lobe.alpha = 0, bad = true;
          if (!(lobe.eta > 1e-3f && lobe.eta < 1e3f)) lobe.eta = 1, bad = true;
          if (!point(i).front) lobe.eta = 1 / lobe.eta;  // plugins say inside over outside
          bad |= wrong;
          if (lobe.type != PATINA_LOBE_NONE && !(isBlack(lobe.weight) && isBlack(lobe.transmission)))
            out.lobes.push_back(lobe);
        }
        t.lobeCount = static_cast<uint32_t>(out.lobes.size()) - t.firstLobe;
      }
  }
  if (bad) {
    ++badValues;
    shader.host().report(shader.host().host, PATINA_REPORT_WARNING, -1,
                         "returned values that are not finite; they count as zero");
  }
}

}  // namespace patina
