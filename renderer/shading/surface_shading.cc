// SPDX-License-Identifier: Apache-2.0
// Batches of points through the entry points `radiosity` and `view`.
#include "renderer/shading/surface_shading.h"

#include <fmt/format.h>

#include <array>
#include <numeric>
#include <optional>
#include <string>

#include "renderer/base/statistics.h"
#include "renderer/shading/ray_service.h"
#include "renderer/shading/shader_validation.h"
#include "renderer/shading/surface_batch.h"

namespace patina {
namespace {

STAT_TIME("Time of threads/surface shaders", shaderTime);
STAT_COUNTER("Shaders/points with values replaced", replacedPoints);
constexpr size_t kBatch = 256;

/// Light and shares of light that are NaN, infinite, negative or so large that a sum of squares would
/// overflow do not leave a shader: the colour counts as black. Rounding below zero is none of that.
bool repair(Rgb& c) {
  const auto good = [](float x) { return x >= 0 && x < 1e18f; };
  if (good(c.x) && good(c.y) && good(c.z)) return false;
  bool wrong = false;
  for (int k = 0; k < 3; ++k)
    if (c[k] < 0 && c[k] > -1e-6f)
      c[k] = 0;
    else
      wrong |= !good(c[k]);
  if (wrong) c = Rgb(0, 0, 0);
  return wrong;
}

/// Opacity that is none counts as one; larger values may be meant.
bool repairOpacity(Rgb& opacity) {
  const bool wrong = repair(opacity);
  if (wrong) opacity = Rgb(1, 1, 1);
  return wrong;
}

/// The points of a batch that had to be repaired.
struct Repaired {
  uint64_t count = 0;
  size_t first = 0;
  void note(size_t lane, bool wrong) {
    if (wrong && count++ == 0) first = lane;
  }
};

struct OutPlanes {
  PatinaOut3 out;
  Rgb operator[](size_t i) const { return {out.x[i], out.y[i], out.z[i]}; }
};

}  // namespace

struct SurfaceShading::Statistics {
  std::array<std::string, 6> names;
  StatCounter radiosityCalls, radiosityPoints, viewCalls, viewPoints, radiosityReplaced, viewReplaced;
  std::unique_ptr<StatCounter> radiosityRays, viewRays;  ///< of shaders that trace some
  explicit Statistics(const ShaderInstance& instance) : Statistics(std::string(instance.name())) {
    const std::string prefix = "Shaders/" + std::string(instance.name());
    if (instance.raysOf(PATINA_ENTRY_RADIOSITY) > 0)
      radiosityRays = std::make_unique<StatCounter>(prefix + "/radiosity/rays");
    if (instance.raysOf(PATINA_ENTRY_VIEW) > 0)
      viewRays = std::make_unique<StatCounter>(prefix + "/view/rays");
  }

 private:
  explicit Statistics(const std::string& shader)
      : names{"Shaders/" + shader + "/radiosity/calls",
              "Shaders/" + shader + "/radiosity/points",
              "Shaders/" + shader + "/view/calls",
              "Shaders/" + shader + "/view/points",
              "Shaders/" + shader + "/radiosity/points with values replaced",
              "Shaders/" + shader + "/view/points with values replaced"},
        radiosityCalls(names[0]),
        radiosityPoints(names[1]),
        viewCalls(names[2]),
        viewPoints(names[3]),
        radiosityReplaced(names[4]),
        viewReplaced(names[5]) {}
};

SurfaceShading::~SurfaceShading() = default;

SurfaceShading::SurfaceShading(const Geometry& geometry, std::vector<const ShaderInstance*> surfaces)
    : geometry_(geometry), fallback_(static_cast<uint32_t>(surfaces.size() - 1)) {
  if (geometry.hasDelayed()) {
    surfaces_.makeRoom(), statistics_.makeRoom();
    variables_.makeRoom(), shaderIndex_.makeRoom(), opacity_.makeRoom();
  }
  growTo(surfaces.size());
  for (uint32_t k = 0; k <= fallback_; ++k) setShader(k, surfaces[k]);
  append(geometry.mainPart());
}

void SurfaceShading::growTo(size_t shaders) {
  surfaces_.growTo(shaders);
  statistics_.growTo(shaders);
}

void SurfaceShading::setShader(uint32_t shader, const ShaderInstance* instance) {
  surfaces_[shader] = instance;
  statistics_[shader] = instance ? std::make_unique<Statistics>(*instance) : nullptr;
  if (instance) firstOf_.try_emplace(instance, shader);
}

void SurfaceShading::append(const GeometryPart& part) {
  for (size_t k = variables_.size(); k < geometry_.traced().size(); ++k)
    variables_.emplace_back(*geometry_.traced()[k].primitive);
  shaderIndex_.growTo(part.endPlacement);
  opacity_.growTo(part.endPlacement);
  for (uint32_t k = part.firstPlacement; k < part.endPlacement; ++k) {
    const Placement& placement = geometry_.placements()[k];
    const Attributes& attributes = geometry_.attributes(placement);
    uint32_t shader = attributes.surface;
    if (shader == kNone || !surfaces_[shader]) shader = fallback_;
    shader = firstOf_.at(surfaces_[shader]);  // requests that share an instance share batches
    shaderIndex_[k] = shader;
    const bool isOs = surfaces_[shader]->has(PATINA_TRAIT_OPACITY_IS_OS);
    const bool opaque = surfaces_[shader]->has(PATINA_TRAIT_OPAQUE) ||
                        (isOs && !variables_[placement.traced].Os && attributes.opacity == Rgb(1, 1, 1)) ||
                        (!isOs && !surfaces_[shader]->active(PATINA_ENTRY_RADIOSITY));
    opacity_[k] = opaque                                             ? OpacityKind::Opaque
                  : surfaces_[shader]->has(PATINA_TRAIT_TRANSPARENT) ? OpacityKind::Transparent
                  : isOs                                             ? OpacityKind::IsOs
                                                                     : OpacityKind::Shaded;
    if (!opaque) allOpaque_ = false;
  }
}

void SurfaceShading::orient(ShadingPoint& p) const {
  const Placement& placement = geometry_.placements()[p.placement];
  const Surface& surface = geometry_.surface(placement);
  const PrimVar* given = variables_[placement.traced].N;
  V3f normal = p.Ng;
  if (geometry_.traced()[placement.traced].isDisplaced) {
    normal = normalizedOr(geometry_.displacedPoint(p.placement, p.face, p.u, p.v).N, p.Ng);
  } else if (given) {
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
  if (geometry_.traced()[geometry_.placements()[placement].traced].isDisplaced) {
    const V2f inside = geometry_.insideFacet(placement, face, u, v);
    u = inside.x, v = inside.y;
  }
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
  const TimeShare share(shaderTime);
  out.terms.assign(points.size(), SurfaceTerms{});
  out.lobes.clear();
  out.customLanes.clear();
  thread_local std::vector<uint32_t> order;
  order.resize(points.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto shaderAt = [&](uint32_t k) { return shaderIndex_[points[k].placement]; };
  if (!std::all_of(order.begin(), order.end(), [&](uint32_t k) { return shaderAt(k) == shaderAt(0); }))
    std::stable_sort(order.begin(), order.end(),
                     [&](uint32_t a, uint32_t b) { return shaderAt(a) < shaderAt(b); });
  // Within a shader, by where facets are that it may ask about.
  if (geometry_.tessellations().isTight())
    for (size_t begin = 0, end = 0; begin < order.size(); begin = end) {
      while (end < order.size() && shaderAt(order[end]) == shaderAt(order[begin])) ++end;
      geometry_.orderByUnit(std::span(order).subspan(begin, end - begin),
                            [&](uint32_t k) { return points[k].placement; });
    }
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
  const bool onlyOpacity = parts == ShadingParts::Opacity, transparent = shader.has(PATINA_TRAIT_TRANSPARENT),
             isOs = shader.has(PATINA_TRAIT_OPACITY_IS_OS);
  const bool radiosity = shader.active(PATINA_ENTRY_RADIOSITY) && !(onlyOpacity && (transparent || isOs));
  if (onlyOpacity && transparent) {
    for (const uint32_t k : which) out.terms[k].opacity = Rgb(0, 0, 0);
    return;
  }
  if (!radiosity && isOs)
    for (const uint32_t k : which) {
      const ShadingPoint& p = points[k];
      const Placement& placement = geometry_.placements()[p.placement];
      out.terms[k].opacity = geometry_.attributes(placement).opacity;
      if (const PrimVar* given = variables_[placement.traced].Os)
        geometry_.surface(placement).interpolate(*given, p.face, p.u, p.v, &out.terms[k].opacity.x);
      repairOpacity(out.terms[k].opacity);
    }
  if (!radiosity && !view) return;
  const uint64_t reads =
      (radiosity ? shader.reads(PATINA_ENTRY_RADIOSITY) : 0) | (view ? shader.reads(PATINA_ENTRY_VIEW) : 0);
  const size_t n = which.size();
  thread_local SurfaceBatch batch;
  const auto point = [&](size_t i) -> const ShadingPoint& { return points[which[i]]; };
  std::vector<BatchPoint>& lanes = batch.begin(n);
  for (size_t i = 0; i < n; ++i) {
    const ShadingPoint& p = point(i);
    const Placement& placement = geometry_.placements()[p.placement];
    lanes[i] = {geometry_.traced()[placement.traced].primitive,
                &variables_[placement.traced],
                &geometry_.surface(placement),
                &geometry_.attributes(placement),
                p.face,
                p.u,
                p.v,
                p.P,
                p.N,
                p.Ng,
                p.footprint};
  }
  PatinaPoints in = batch.fill(shader, reads, [&](size_t i, V3f& du, V3f& dv) {
    const ShadingPoint& p = point(i);
    const Placement& placement = geometry_.placements()[p.placement];
    if (geometry_.traced()[placement.traced].isDisplaced) {
      const Geometry::DisplacedPoint at = geometry_.displacedPoint(p.placement, p.face, p.u, p.v);
      du = at.dPdu, dv = at.dPdv;
      return;
    }
    const SurfacePoint at = geometry_.surface(placement).evaluate(p.face, p.u, p.v);
    du = transformVector(at.dPdu, placement.objectToWorld);
    dv = transformVector(at.dPdv, placement.objectToWorld);
  });
  Planes& planes = batch.planes();

  Statistics& statistics = *statistics_[shaderIndex];
  const auto report = [&](const char* entry, ShaderHost::Fault fault, const Repaired& repaired,
                          StatCounter& counter) {
    if (repaired.count == 0) return;
    replacedPoints += static_cast<int64_t>(repaired.count);
    counter += static_cast<int64_t>(repaired.count);
    const ShadingPoint& first = point(repaired.first);
    shader.fault(fault, repaired.count, first.P, [&] {
      return fmt::format(
          "{} gave values that are not finite, negative or too large; they count as zero, opacity as one. "
          "The "
          "first is at {}",
          entry, placeOf(first));
    });
  };
  const auto place = [&](size_t i) { return placeOf(point(i)); };
  const RayCall::FacetOf facetOf = [&](uint32_t lane) { return point(lane).facet(); };
  const auto mayTrace = [&](std::optional<RayCall>& call, PatinaEntry entry) {
    if (shader.raysOf(entry) > 0) call.emplace(shader, entry, in.count, shader.accel(), facetOf);
  };
  const auto firstPlace = [&] { return placeOnSurface(point(0)); };
  const CallPlace called(firstPlace);
  if (radiosity) {
    Repaired repaired;
    PatinaRadiosityOut result{};
    result.struct_size = sizeof(result);
    result.emission = planes.out3(0), result.reflectance = planes.out3(0),
    result.transmittance = planes.out3(0);
    result.ambient = planes.out3(0), result.opacity = planes.out3(1);
    ++statistics.radiosityCalls;
    statistics.radiosityPoints += static_cast<int64_t>(n);
    std::optional<RayCall> rays;
    mayTrace(rays, PATINA_ENTRY_RADIOSITY);
    const PatinaStatus status = shader.radiosity(in, result);
    if (rays) *statistics.radiosityRays += rays->traced();
    if (validatesShaders()) reportDamage(shader, "radiosity", planes, place);
    if (status == PATINA_OK) {
      if (validatesShaders()) validateRadiosity(shader, in, result, place);
      for (size_t i = 0; i < n; ++i) {
        SurfaceTerms& t = out.terms[which[i]];
        t.emission = OutPlanes{result.emission}[i], t.reflectance = OutPlanes{result.reflectance}[i];
        t.transmittance = OutPlanes{result.transmittance}[i], t.ambient = OutPlanes{result.ambient}[i];
        t.opacity = OutPlanes{result.opacity}[i];
        repaired.note(i, repair(t.emission) | repair(t.reflectance) | repair(t.transmittance) |
                             repair(t.ambient) | repairOpacity(t.opacity));
      }
    }
    report("radiosity", ShaderHost::kBadValues, repaired, statistics.radiosityReplaced);
  }
  if (view) {
    Repaired repaired;
    in.I = planes.fill3(n, [&](size_t i) { return point(i).I; });
    std::array<PatinaLobe, PATINA_MAX_LOBES> lobes{};
    for (PatinaLobe& lobe : lobes) {
      lobe.struct_size = sizeof(PatinaLobe);
      lobe.weight = planes.out3(0), lobe.transmission = planes.out3(0);
      lobe.alpha = planes.out(0), lobe.eta = planes.out(1);
    }
    std::vector<CustomLobeLane>* customLanes = nullptr;
    std::array<float*, PATINA_MAX_LOBES * PATINA_LOBE_DATA> lobeData;
    if (shader.hasCustomLobes()) {
      const uint32_t each = shader.lobeDataCount();
      for (uint32_t k = 0; k < PATINA_MAX_LOBES; ++k) {
        for (uint32_t c = 0; c < each; ++c) lobeData[k * each + c] = planes.out(0);
        lobes[k].data = &lobeData[k * each], lobes[k].data_count = each;
      }
      customLanes = &out.customLanes.emplace_back();
      customLanes->reserve(n * PATINA_MAX_LOBES);  // lobes point to them
    }
    PatinaViewOut result{};
    result.struct_size = sizeof(result);
    result.emission = planes.out3(0);
    result.lobes = lobes.data();
    result.lobe_stride = sizeof(PatinaLobe);
    ++statistics.viewCalls;
    statistics.viewPoints += static_cast<int64_t>(n);
    std::optional<RayCall> rays;
    mayTrace(rays, PATINA_ENTRY_VIEW);
    const PatinaStatus status = shader.view(in, result);
    if (rays) *statistics.viewRays += rays->traced();
    if (validatesShaders()) reportDamage(shader, "view", planes, place);
    if (status == PATINA_OK) {
      if (validatesShaders()) validateView(shader, in, result, place);
      for (size_t i = 0; i < n; ++i) {
        SurfaceTerms& t = out.terms[which[i]];
        Rgb emission = OutPlanes{result.emission}[i];
        bool wrong = repair(emission);
        t.viewEmission = emission;
        t.firstLobe = static_cast<uint32_t>(out.lobes.size());
        for (uint32_t k = 0; k < std::min(result.lobe_count, PATINA_MAX_LOBES); ++k) {
          Lobe lobe{lobes[k].type, OutPlanes{lobes[k].weight}[i], OutPlanes{lobes[k].transmission}[i],
                    lobes[k].alpha[i], lobes[k].eta[i]};
          wrong |= repair(lobe.weight) | repair(lobe.transmission);
          if (!(lobe.alpha >= 0 && lobe.alpha < 1e6f)) lobe.alpha = 0, wrong = true;
          if (!(lobe.eta > 1e-3f && lobe.eta < 1e3f)) lobe.eta = 1, wrong = true;
          if (!point(i).front) lobe.eta = 1 / lobe.eta;  // plugins say inside over outside
          if (lobe.type > PATINA_LOBE_DIELECTRIC) {
            CustomLobeLane lane{shader.customLobe(lobe.type), {}};
            bool known = lane.lobe != nullptr;
            for (uint32_t c = 0; known && c < lane.lobe->dataCount(); ++c) {
              lane.data[c] = lobes[k].data[c][i];
              known = std::isfinite(lane.data[c]);
            }
            if (!known) {
              wrong = true;
              continue;
            }
            lobe.transmission = Rgb(0, 0, 0);
            if (isBlack(lobe.weight)) continue;
            customLanes->push_back(lane);
            lobe.custom = &customLanes->back();
          }
          if (lobe.type != PATINA_LOBE_NONE && !(isBlack(lobe.weight) && isBlack(lobe.transmission)))
            out.lobes.push_back(lobe);
        }
        t.lobeCount = static_cast<uint32_t>(out.lobes.size()) - t.firstLobe;
        repaired.note(i, wrong);
      }
    }
    report("view", ShaderHost::kBadView, repaired, statistics.viewReplaced);
  }
}

/// Where a point is, for messages: in the world, and on its primitive.
std::string SurfaceShading::placeOnSurface(const ShadingPoint& p) const {
  const Placement& placement = geometry_.placements()[p.placement];
  return fmt::format("({}, {}, {}), (u, v) = ({}, {}) of face {} of the primitive at {}", p.P.x, p.P.y, p.P.z,
                     p.u, p.v, p.face, toString(geometry_.traced()[placement.traced].primitive->where));
}

/// ... and the patch.
std::string SurfaceShading::placeOf(const ShadingPoint& p) const {
  const Patch& patch = geometry_.patches()[geometry_.patches().find(p.placement, p.face, p.u, p.v)];
  std::string text = placeOnSurface(p);
  const V2f end = patch.toFace(V2f(1, 1));
  text += patch.group > 0
              ? ", in a patch of many faces"
              : fmt::format(", in the patch from ({}, {}) to ({}, {})", patch.u0, patch.v0, end.x, end.y);
  return text;
}

}  // namespace patina
