// SPDX-License-Identifier: Apache-2.0
// The units that surfaces are made and traced in, and their facets.
#include <fmt/format.h>

#include <tuple>

#include "renderer/base/statistics.h"
#include "renderer/geometry/bounds.h"
#include "renderer/geometry/face_order.h"
#include "renderer/geometry/geometry.h"

namespace patina {
namespace {

STAT_COUNTER("Geometry/facets of curved surfaces", facetCount);
STAT_COUNTER("Geometry/chunks of dense meshes", chunkCount);

/// Faces in a unit of a dense mesh: few enough that one is made in some ten milliseconds and is small against
/// any budget, many enough that rays meet few bounds. Meshes of at least kDenseFaces are dense.
constexpr size_t kChunkFaces = size_t{1} << 16, kDenseFaces = 2 * kChunkFaces;

/// Ten bits of each coordinate, interleaved (Morton 1966).
uint32_t mortonCode(const V3f& p, const Box3f& box) {
  uint32_t code = 0;
  for (int k = 0; k < 3; ++k) {
    const float extent = box.max[k] - box.min[k];
    const float t = extent > 0 ? (p[k] - box.min[k]) / extent : 0;
    const auto cell = static_cast<uint32_t>(std::clamp(t, 0.0f, 1.0f) * 1023);
    for (uint32_t bit = 0; bit < 10; ++bit)
      code |= (cell >> bit & 1u) << (3 * bit + static_cast<uint32_t>(k));
  }
  return code;
}

/// Roughly how many facets a surface will have: only the size of units depends on it.
float guessFacets(const Primitive& primitive, const Box3f& world, const RasterCamera& camera,
                  std::optional<float> shadingRate) {
  float faces = 0;
  if (const auto* polygons = std::get_if<PolygonMesh>(&primitive.shape)) {
    faces = static_cast<float>(polygons->loopCount());
    if (!shadingRate) return faces;
  }
  const float radius = world.size().length() / 2;
  const float distance = std::max(camera.nearestDistance(world.center(), radius), 0.25f * radius);
  const float pixels = 2 * radius * camera.pixelsPerUnit(std::max(distance, 1e-30f));
  if (shadingRate) return std::max(faces, std::min(pixels * pixels / *shadingRate, 4e6f));
  float least = 8;
  if (const auto* mesh = std::get_if<SubdivisionMesh>(&primitive.shape))
    least = 4 * static_cast<float>(mesh->vertsPerFace.size());
  // Chords within an eightieth of a pixel of a sphere, rounded up to powers of two.
  return std::max(least, std::min(96 * pixels, 16384.0f));
}

}  // namespace

void Geometry::makeUnits(uint32_t firstTraced, uint32_t firstSolid) const {
  // Facets wanted in a unit: enough that its structure is not mostly overhead, few enough that a small budget
  // holds several.
  constexpr float kMostFacets = 2048, kLeastFacets = 64, kFacetBytes = 64, kUnitsInBudget = 16;
  const float budget = 1024 * static_cast<float>(std::max(scene_.options.geometryCacheKb, 0));
  const float wanted = std::clamp(budget / (kFacetBytes * kUnitsInBudget), kLeastFacets, kMostFacets);
  struct Key {
    uint32_t group, visibility;
    bool oneSided;
    uint32_t segments;
    bool sampleMotion;
    uint32_t code, traced;
    auto operator<=>(const Key&) const = default;
  };
  Box3f all;
  for (uint32_t k = firstTraced; k < traced_.size(); ++k) all.extendBy(boundInMesh(traced_[k]));
  std::vector<Key> keys;
  std::vector<uint32_t> dense;
  for (uint32_t k = firstTraced; k < traced_.size(); ++k) {
    const TracedSurface& traced = traced_[k];
    if (traced.solid != kNone) continue;
    const bool isStiff = !traced.isDisplaced && traced.segments == 0;
    if (isStiff && made_[k] && made_[k]->isFlat() && made_[k]->faceCount() <= kFewFaces) continue;
    const auto* polygons = std::get_if<PolygonMesh>(&traced.primitive->shape);
    if (isStiff && polygons && polygons->loopCount() >= kDenseFaces &&
        surface(k).faceCount() >= kDenseFaces) {
      dense.push_back(k);
      continue;
    }
    const Attributes* own = attributes(traced);
    const bool sampled = traced.segments > 0 && own && own->sampleMotion && own->areaLight == kNone;
    keys.push_back({traced.group, own ? own->visibility : uint32_t{kAnyRay}, own && own->oneSided,
                    traced.segments, sampled,
                    mortonCode(transformed(traced.bound, traced.toMesh).center(), all), k});
  }
  std::sort(keys.begin(), keys.end());
  float facets = wanted;
  for (size_t i = 0; i < keys.size(); ++i) {
    const Key& key = keys[i];
    TracedSurface& traced = traced_[key.traced];
    const auto kind = [](const Key& a) {
      return std::tie(a.group, a.visibility, a.oneSided, a.segments, a.sampleMotion);
    };
    if (facets >= wanted || kind(keys[i - 1]) != kind(key)) {
      units_.push_back({{}, {}, key.visibility, key.oneSided, key.segments, key.sampleMotion, {}});
      facets = 0;
    }
    SurfaceUnit& unit = units_.back();
    const Box3f box = boundInMesh(traced);
    const Attributes* own = attributes(traced);
    facets += guessFacets(*traced.primitive, box, camera_,
                          traced.isDisplaced ? std::optional(own->shadingRate) : std::nullopt);
    if (traced.segments > 0) addStepBounds(unit, key.traced, box);
    unit.bound.extendBy(box);
    traced.unit = static_cast<uint32_t>(units_.size() - 1);
    traced.member = static_cast<uint32_t>(unit.members.size());
    unit.members.push_back(key.traced);
  }
  // Each solid is a unit of its own.
  const auto firstUnit = static_cast<uint32_t>(units_.size());
  for (uint32_t solid = firstSolid; solid < solids_.size(); ++solid) {
    units_.push_back({{}, {}, 0, false});
    units_.back().solid = solid;
  }
  for (uint32_t k = firstTraced; k < traced_.size() && solids_.size() > firstSolid; ++k) {
    TracedSurface& traced = traced_[k];
    if (traced.solid == kNone) continue;
    traced.unit = firstUnit + traced.solid - firstSolid;
    SurfaceUnit& unit = units_[traced.unit];
    unit.bound.extendBy(boundInMesh(traced));
    const Attributes* own = attributes(traced);
    unit.visibility |= own ? own->visibility : uint32_t{kAnyRay};
    traced.member = static_cast<uint32_t>(unit.members.size());
    unit.members.push_back(k);
  }
  for (const uint32_t k : dense) makeChunks(k);
}

void Geometry::makeChunks(uint32_t k) const {
  TracedSurface& traced = traced_[k];
  traced.order = static_cast<uint32_t>(faceOrders_.size());
  faceOrders_.push_back(mortonOrder(surface(k)));
  const std::vector<uint32_t>& order = faceOrders_[traced.order];
  const std::vector<Box3f> bounds = boundsOfParts(surface(k), order, kChunkFaces);
  const Attributes* own = attributes(traced);
  traced.unit = static_cast<uint32_t>(units_.size());
  traced.chunks = static_cast<uint32_t>(bounds.size());
  for (size_t c = 0; c < bounds.size(); ++c) {
    const size_t first = c * kChunkFaces;
    units_.push_back({{k},
                      padded(transformed(padded(bounds[c]), traced.toMesh)),
                      own ? own->visibility : uint32_t{kAnyRay},
                      own && own->oneSided});
    units_.back().faces = std::span(order).subspan(first, std::min(kChunkFaces, order.size() - first));
  }
  chunkCount += traced.chunks;
  orderBytes_ += order.capacity() * sizeof(uint32_t);
}

std::vector<M44f> Geometry::placesOf(uint32_t traced) const {
  const uint32_t group = traced_[traced].group;
  std::vector<M44f> places;
  if (group == kNone) {
    places = {placements_[traced_[traced].placement].objectToWorld};
  } else {
    for (const uint32_t instance : groups_[group].instances)
      places.push_back(placements_[placementOf(traced, instance)].objectToWorld);
  }
  if (moves_) addPlacesInTime(traced, places);
  return places;
}

// Called while the unit is being made, which one thread does at a time.
const SurfaceRates& Geometry::rates(uint32_t k) const {
  if (!rates_[k]) {
    const TracedSurface& traced = traced_[k];
    const auto shadingRate =
        traced.isDisplaced ? std::optional(attributes(traced)->shadingRate) : std::nullopt;
    rates_[k] = std::make_unique<const SurfaceRates>(
        traced.segments > 0 ? ratesInTime(k, shadingRate)
                            : traceRates(camera_, surface(k), placesOf(k), shadingRate));
    surfaceBytes_ += rates_[k]->memory();
    if (rates_[k]->limited) facetsLimited_ = true;
  }
  return *rates_[k];
}

Geometry::UnitSize Geometry::sizeOf(uint32_t index) const {
  const SurfaceUnit& unit = units_[index];
  UnitSize size;
  for (const uint32_t k : unit.members) {
    if (!isTessellated(k)) {
      size.faces += unit.faces.empty() ? surface(k).faceCount() : unit.faces.size();
      continue;
    }
    for (const TileRates& r : rates(k).tiles) {
      size.facets += size_t{1} << (r.u + r.v);
      size.vertices += r.vertices() * (unit.segments + 1);
    }
  }
  return size;
}

std::unique_ptr<Tessellation> Geometry::tessellate(uint32_t index) const {
  const SurfaceUnit& unit = units_[index];
  auto result = std::make_unique<Tessellation>();
  size_t vertices = 1, tiles = 0;
  for (const uint32_t k : unit.members) {
    Tessellation::Member& member = result->members.emplace_back();
    member.firstTile = tiles;
    if (!isTessellated(k)) continue;
    member.rates = &rates(k);
    tiles += member.rates->tiles.size();
    for (const TileRates& r : member.rates->tiles) {
      vertices += r.vertices();
      facetCount += int64_t{1} << (r.u + r.v);
    }
  }
  if (tiles == 0) return result;
  result->first.reserve(tiles);
  result->vertices.reserve((vertices - 1) * (unit.segments + 1) + 1);
  for (size_t m = 0; m < unit.members.size(); ++m) {
    const SurfaceRates* known = result->members[m].rates;
    if (!known) continue;
    const uint32_t k = unit.members[m];
    const size_t begin = result->vertices.size();
    patina::tessellate(surface(k), *known, result->first, result->vertices);
    const std::span<const uint32_t> own = std::span(result->first).subspan(result->members[m].firstTile);
    if (traced_[k].isDisplaced) {
      const DisplacementResult displaced = displace(k, *known, own, result->vertices);
      checkDisplacement(k, displaced.moved);
      result->members[m].firstNormal = result->normals.size();
      result->normals.insert(result->normals.end(), displaced.normals.begin(), displaced.normals.end());
      continue;
    }
    thinSides(*known, own, std::span(result->vertices));
    for (V3f& p : std::span(result->vertices).subspan(begin)) p = transformPoint(p, traced_[k].toMesh);
  }
  if (unit.segments > 0) addSteps(unit, *result);
  return result;
}

std::unique_ptr<Tessellation> Geometry::leaveOut(uint32_t index, std::string_view why) const {
  const SurfaceUnit& unit = units_[index];
  errors_.report(Severity::Error, RiError::OutOfMemory, traced_[unit.members.front()].primitive->where,
                 fmt::format("{} primitive(s) from here on are left out: {}", unit.members.size(), why));
  auto result = std::make_unique<Tessellation>();
  result->members.resize(unit.members.size());
  result->isLeftOut = true;
  return result;
}

}  // namespace patina
