// SPDX-License-Identifier: Apache-2.0
// Displaced surfaces of a frame: their bounds, known or found out, and whether they keep to them.
#include <fmt/format.h>

#include "renderer/base/statistics.h"
#include "renderer/geometry/geometry.h"

namespace patina {
namespace {

STAT_COUNTER("Displacement/surfaces", displacedCount);
STAT_COUNTER("Displacement/surfaces without a bound", unboundedCount);

constexpr float kSlack = 1.001f;  // a bound may be missed by rounding

float largestStretch(const M44f& m) {
  float most = 0;
  for (int k = 0; k < 3; ++k) {
    V3f axis(0, 0, 0);
    axis[k] = 1;
    most = std::max(most, transformVector(axis, m).length());
  }
  return most * std::sqrt(3.0f);  // no direction is stretched more
}

}  // namespace

/// Finds which surfaces are displaced and how far at most. Those that do not say are displaced now.
void Geometry::boundDisplacements(uint32_t firstTraced) const {
  float farthest = 0;
  size_t unbounded = 0;
  const Primitive* without = nullptr;
  for (uint32_t k = firstTraced; k < traced_.size(); ++k) {
    TracedSurface& traced = traced_[k];
    const Attributes* own = attributes(traced);
    if (!own) continue;
    const auto bound = displacer_->boundOf(*own);
    if (!bound) continue;
    ++displacedCount;
    traced.isDisplaced = true;
    // Further is not where vertices are left (displacement_shading.cc), and Embree's boxes end at 1.8e18.
    traced.reach = std::min(std::max(bound->object * largestStretch(traced.toMesh), bound->world), 1e17f);
    if (traced.reach > 0 && std::isfinite(traced.reach)) continue;
    ++unboundedCount, ++unbounded;
    std::vector<uint32_t> first;
    std::vector<V3f> vertices;
    const SurfaceRates& known = rates(k);
    if (known.tiles.empty()) continue;
    patina::tessellate(surface(k), known, first, vertices);
    traced.reach = displace(k, known, first, vertices).moved * kSlack;
    farthest = std::max(farthest, traced.reach);
    if (!without) without = traced.primitive;
  }
  if (without)
    errors_.report(Severity::Warning, RiError::MissingData, without->where,
                   fmt::format("displaced surfaces without Attribute \"displacementbound\", {} from here on: "
                               "they were displaced at once to find that they move by up to {:.4g}",
                               unbounded, farthest));
}

DisplacementResult Geometry::displace(uint32_t k, const SurfaceRates& known, std::span<const uint32_t> first,
                                      std::span<V3f> vertices) const {
  const TracedSurface& traced = traced_[k];
  return displaceFacets(surface(k), *traced.primitive, *attributes(traced), traced.toMesh, traced.isReversed,
                        *displacer_, known, first.first(known.tiles.size()), vertices);
}

void Geometry::checkDisplacement(uint32_t k, float moved) const {
  const TracedSurface& traced = traced_[k];
  const bool exceeds = moved > traced.reach * kSlack;
  if ((!exceeds && moved > 0) || displacementChecked_[k].exchange(true)) return;
  if (exceeds)
    errors_.report(Severity::Warning, RiError::Range, traced.primitive->where,
                   fmt::format("the displacement of this surface reaches {:.4g}, its displacementbound is "
                               "{:.4g}: rays miss what sticks out",
                               moved, traced.reach));
  else
    errors_.report(Severity::Warning, RiError::Range, traced.primitive->where,
                   "the displacement shader of this surface moves nothing");
}

}  // namespace patina
