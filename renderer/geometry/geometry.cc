// SPDX-License-Identifier: Apache-2.0
// From the primitives of a scene to bounded and placed surfaces; their facets and patches on demand.
#include "renderer/geometry/geometry.h"

#include <fmt/format.h>

#include <tuple>

#include "renderer/base/statistics.h"
#include "renderer/geometry/bounds.h"
#include "renderer/geometry/face_order.h"

namespace patina {
namespace {

STAT_COUNTER("Geometry/primitives", primitiveCount);
STAT_COUNTER("Geometry/surfaces made", surfaceCount);
STAT_COUNTER("Geometry/faces", faceCount);
STAT_COUNTER("Geometry/facets of curved surfaces", facetCount);
STAT_COUNTER("Geometry/instances", instanceCount);
STAT_COUNTER("Geometry/chunks of dense meshes", chunkCount);

/// Faces in a unit of a dense mesh: few enough that one is made in some ten milliseconds and is small against
/// any budget, many enough that rays meet few bounds. Meshes of at least kDenseFaces are dense.
constexpr size_t kChunkFaces = size_t{1} << 16, kDenseFaces = 2 * kChunkFaces;

/// Units that are made so often again, on average, cost more time than memory would.
constexpr size_t kManyMakings = 4;

bool invertible(const M44d& m) {
  const double d = m.determinant();
  return std::isfinite(d) && d != 0;
}

/// Faces of a surface that nobody makes sense of.
class NoSurface final : public Surface {
 public:
  uint32_t faceCount() const override { return 0; }
  FaceShape faceShape(uint32_t) const override { return FaceShape::Quad; }
  bool isFlat() const override { return true; }
  void corners(uint32_t, V3f*) const override {}
  SurfacePoint evaluate(uint32_t, float, float) const override { return {}; }
  void interpolate(const PrimVar&, uint32_t, float, float, float*) const override {}
  uint32_t uniformIndex(uint32_t) const override { return 0; }
  V2f surfaceParameters(uint32_t, float, float) const override { return {0, 0}; }
  V2f parameterScale(uint32_t) const override { return {1, 1}; }
  Box3f bound() const override { return {}; }
};

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
  // Chords within a twentieth of a pixel of a sphere, rounded up to powers of two.
  return std::max(least, std::min(24 * pixels, 16384.0f));
}

}  // namespace

Placement Geometry::makePlacement(uint32_t traced, uint32_t attributes, uint32_t instance,
                                  const M44d& objectToWorld, const M44d& toMesh, bool reversed) {
  Placement p{};
  p.traced = traced, p.attributes = attributes, p.instance = instance;
  p.objectToWorld = M44f(objectToWorld), p.worldToObject = M44f(objectToWorld.inverse());
  p.normalSign = reversed ? -1.0f : 1.0f;
  p.facetSign = objectToWorld.determinant() < 0 ? -p.normalSign : p.normalSign;
  p.meshSign = toMesh.determinant() < 0 ? -p.normalSign : p.normalSign;
  p.moves = false;
  return p;
}

Viewpoint Geometry::viewpoint(const M44d& toWorld) const {
  const M44d inverse = toWorld.inverse();
  Viewpoint view;
  view.perspective = camera_.perspective();
  view.eye = V3f(V3d(camera_.eye()) * inverse);
  view.direction = normalizedOr(transformVector(camera_.viewDirection(), M44f(inverse)), V3f(0, 0, 1));
  // Distances and lengths grow alike.
  view.pixels = camera_.pixelsPerUnit(1) *
                (view.perspective ? 1.0f : static_cast<float>(std::cbrt(std::abs(toWorld.determinant()))));
  return view;
}

/// What turns to the eye does so from the object's own place, as instances share their object's surfaces;
/// what chooses its facets does so for the instance that is nearest.
Viewpoint Geometry::viewpoint(const Primitive& primitive, const M44d& toMesh, uint32_t group) const {
  if (group != kNone && group >= scene_.objects.size())
    return viewpoint(toMesh * movingGroups_[group - scene_.objects.size()].movement.at(
                                  static_cast<double>(scene_.camera.shutterOpen)));
  Viewpoint view = viewpoint(toMesh);
  if (group == kNone || !std::holds_alternative<Blobby>(primitive.shape)) return view;
  float nearest = kInfinity;
  for (const Instance& instance : scene_.instances) {
    if (instance.object != group || !invertible(toMesh * instance.objectToWorld)) continue;
    const Viewpoint from = viewpoint(toMesh * instance.objectToWorld);
    const float distance = from.perspective ? from.eye.length2() : 1 / from.pixels;
    if (distance < nearest) nearest = distance, view = from;
  }
  return view;
}

bool Geometry::add(const Primitive& primitive, const M44d& toMesh, uint32_t group, uint32_t attributes,
                   bool isReversed) {
  if (!invertible(toMesh)) {
    errors_.report(Severity::Error, RiError::Math, primitive.where,
                   "the transformation of this primitive is singular");
    return false;
  }
  TracedSurface traced{&primitive, M44f(toMesh), meshBound(primitive), group, kNone,
                       0,          attributes,   isReversed,           false, 0};
  std::unique_ptr<Surface> surface;
  if (traced.bound.isEmpty() || primitive.solid != kNone) {
    surface = patina::makeSurface(primitive, errors_, viewpoint(primitive, toMesh, group));
    if (!surface || surface->faceCount() == 0) return false;
    ++surfaceCount;
    faceCount += surface->faceCount();
    surfaceBytes_ += surface->memory();
    traced.bound = surface->bound();
  }
  ++primitiveCount;
  if (primitive.motion && primitive.solid != kNone)
    errors_.report(Severity::Warning, RiError::Unimplemented, primitive.where,
                   "what a solid is made of does not move by itself: it stands where it is at the opening of "
                   "the shutter",
                   "moving operand");
  else if (primitive.motion) {
    const bool inObject = group != kNone && group < scene_.objects.size();
    traced.segments = poseSegments(primitive, static_cast<double>(scene_.camera.shutterOpen),
                                   static_cast<double>(scene_.camera.shutterClose), inObject, traced.bound);
  }
  traced_.push_back(traced);
  made_.push_back(std::move(surface));
  return true;
}

/// Whether the attributes of an instance displace: its surfaces then have a shape of their own.
bool Geometry::ownsSurfaces(const Instance& instance) const {
  if (!displacer_ || !displacer_->boundOf(scene_.attributes[instance.attributes])) return false;
  const std::vector<Primitive>& all = scene_.objects[instance.object].primitives;
  return std::any_of(all.begin(), all.end(), [](const Primitive& p) { return p.attributes == kNone; });
}

const Surface& Geometry::makeSurface(uint32_t k) const {
  const std::scoped_lock lock(surfaceMutex_[k % kMutexes]);
  if (made_[k]) return *made_[k];
  const TracedSurface& traced = traced_[k];
  made_[k] = patina::makeSurface(*traced.primitive, errors_,
                                 viewpoint(*traced.primitive, M44d(traced.toMesh), traced.group));
  if (!made_[k]) made_[k] = std::make_unique<NoSurface>();
  ++surfaceCount;
  faceCount += made_[k]->faceCount();
  surfaceBytes_ += made_[k]->memory();
  surfaces_[k].store(made_[k].get(), std::memory_order_release);
  return *made_[k];
}

void Geometry::place(const Instance& instance) {
  if (ownsSurfaces(instance)) return;
  if (!invertible(instance.objectToWorld)) {
    errors_.report(Severity::Error, RiError::Math, instance.where,
                   "the transformation of this instance is singular");
    return;
  }
  const auto [first, end] = groups_[instance.object];
  if (first == end) return;
  ++instanceCount;
  const Attributes& attributes = scene_.attributes[instance.attributes];
  place(instance.object, instance.objectToWorld, instance.attributes, attributes.visibility,
        instance.reversed, instance.motion.get(), attributes.sampleMotion && attributes.areaLight == kNone);
}

Geometry::Geometry(const Scene& scene, const RasterCamera& camera, ErrorHandler& errors,
                   const Displacer* displacer)
    : scene_(scene), camera_(camera), errors_(errors), displacer_(displacer) {
  // Surfaces: those of the world first, then object by object.
  std::vector<M44d> toWorld;
  const auto addToWorld = [&](const Primitive& primitive, const M44d& matrix, uint32_t attributes,
                              bool isReversed) {
    const Attributes& a = scene.attributes[attributes];
    if (a.visibility == 0 && a.areaLight == kNone && primitive.solid == kNone) return;
    if (add(primitive, matrix, kNone, attributes, isReversed)) toWorld.push_back(matrix);
  };
  for (const Primitive& primitive : scene.primitives)
    if (!movesAsWhole(primitive))
      addToWorld(primitive, primitive.objectToWorld, primitive.attributes, primitive.reversed);
  makeSolids(scene.solids, 0, &toWorld);
  std::vector<bool> used(scene.objects.size(), false);
  for (const Instance& instance : scene.instances) {
    if (!ownsSurfaces(instance)) {
      used[instance.object] = true;
      continue;
    }
    if (movesAsWhole(instance)) continue;
    const ObjectDefinition& object = scene.objects[instance.object];
    const auto first = static_cast<uint32_t>(traced_.size());
    for (const Primitive& p : object.primitives)
      addToWorld(p, p.objectToWorld * instance.objectToWorld,
                 p.attributes == kNone ? instance.attributes : p.attributes, p.reversed != instance.reversed);
    makeSolids(object.solids, first, &toWorld);
  }
  const auto worldCount = static_cast<uint32_t>(traced_.size());
  for (uint32_t object = 0; object < scene.objects.size(); ++object) {
    const auto first = static_cast<uint32_t>(traced_.size());
    if (used[object])
      for (const Primitive& primitive : scene.objects[object].primitives)
        add(primitive, primitive.objectToWorld, object, primitive.attributes, primitive.reversed);
    makeSolids(scene.objects[object].solids, first, nullptr);
    groups_.emplace_back(first, static_cast<uint32_t>(traced_.size()));
  }
  addMovingGroups();
  surfaces_ = std::vector<std::atomic<const Surface*>>(traced_.size());
  rates_.resize(traced_.size());
  for (size_t k = 0; k < traced_.size(); ++k) surfaces_[k] = made_[k].get();

  for (uint32_t k = 0; k < worldCount; ++k)
    placements_.push_back(makePlacement(k, traced_[k].attributes, kNone, toWorld[k], toWorld[k],
                                        traced_[k].isReversed != traced_[k].isTurned));
  instancesOf_.resize(groups_.size());
  oneSidedInstances_.resize(groups_.size(), false);
  for (const Instance& instance : scene.instances) place(instance);
  placeMovingGroups();
  findMotion();
  if (displacer_) boundDisplacements();
  for (const Placement& p : placements_) {
    const TracedSurface& traced = traced_[p.traced];
    if (!traced.isDisplaced)
      bound_.extendBy(transformed(traced.bound, p.objectToWorld));
    else if (p.instance == kNone)
      bound_.extendBy(boundInMesh(traced));
    else
      bound_.extendBy(transformed(boundInMesh(traced), instances_[p.instance].meshToWorld));
  }
  makeUnits();
  patches_ = std::make_unique<PatchTable>(camera_, placements_.size(), [this](uint32_t placement) {
    const Placement& p = placements_[placement];
    const Attributes& a = attributes(p);
    const auto order = faceOrders_.find(p.traced);
    return DiceInput{&surface(p),
                     p.objectToWorld,
                     a.shadingRate,
                     a.diceLength,
                     a.diceInObjectSpace,
                     a.foreshorten,
                     p.moves ? dicePoses(placement) : std::vector<DicePose>(),
                     order == faceOrders_.end() ? std::span<const uint32_t>() : order->second};
  });
}

Geometry::~Geometry() = default;

Box3f Geometry::boundInMesh(const TracedSurface& traced) const {
  Box3f box = padded(transformed(padded(traced.bound), traced.toMesh));
  box.min -= V3f(traced.reach), box.max += V3f(traced.reach);
  return box;
}

void Geometry::makeUnits() {
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
  for (const TracedSurface& traced : traced_) all.extendBy(boundInMesh(traced));
  std::vector<Key> keys;
  std::vector<uint32_t> dense;
  for (uint32_t k = 0; k < traced_.size(); ++k) {
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
  const auto firstSolid = static_cast<uint32_t>(units_.size());
  for (uint32_t solid = 0; solid < solids_.size(); ++solid) {
    units_.push_back({{}, {}, 0, false});
    units_.back().solid = solid;
  }
  for (uint32_t k = 0; k < traced_.size() && !solids_.empty(); ++k) {
    TracedSurface& traced = traced_[k];
    if (traced.solid == kNone) continue;
    traced.unit = firstSolid + traced.solid;
    SurfaceUnit& unit = units_[traced.unit];
    unit.bound.extendBy(boundInMesh(traced));
    const Attributes* own = attributes(traced);
    unit.visibility |= own ? own->visibility : uint32_t{kAnyRay};
    traced.member = static_cast<uint32_t>(unit.members.size());
    unit.members.push_back(k);
  }
  for (const uint32_t k : dense) makeChunks(k);
  tessellations_ = std::make_unique<TessellationCache>(
      units_.size(), static_cast<size_t>(std::max(scene_.options.geometryCacheKb, 0)) * 1024);
}

void Geometry::makeChunks(uint32_t k) {
  TracedSurface& traced = traced_[k];
  const std::vector<uint32_t>& order = faceOrders_[k] = mortonOrder(surface(k));
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
    places = {placements_[traced].objectToWorld};
  } else {
    for (const uint32_t instance : instancesOf_[group])
      places.push_back(
          placements_[instances_[instance].firstPlacement + traced - groups_[group].first].objectToWorld);
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

void Geometry::reportMemory() const {
  constexpr double kMegabyte = 1048576;
  setStatistic("Memory/surfaces MB", static_cast<double>(surfaceBytes_) / kMegabyte);
  setStatistic("Memory/face orders MB", static_cast<double>(orderBytes_) / kMegabyte);
  setStatistic("Memory/patches MB", static_cast<double>(patches_->memory()) / kMegabyte);
  setStatistic("Memory/tessellations, most MB", static_cast<double>(tessellations_->peak()) / kMegabyte);
  setStatistic("Memory/tessellations, budget MB", static_cast<double>(tessellations_->budget()) / kMegabyte);
  setStatistic("Geometry/units", static_cast<double>(units_.size()));
  if (facetsLimited_)
    errors_.report(Severity::Warning, RiError::LimitCheck, {},
                   "too many facets: some surfaces are traced coarser than their size in pixels asks");
  if (patches_->limited())
    errors_.report(Severity::Warning, RiError::LimitCheck, {},
                   "too many micropolygons: some patches stay coarser than ShadingRate asks");
  if (tessellations_->madeAgain() > kManyMakings * units_.size())
    errors_.report(
        Severity::Warning, RiError::LimitCheck, {},
        fmt::format(
            "geocachememory ({:.1f} MB) is too small for what rays meet at once: {} units of geometry "
            "were made {} times again; {:.1f} MB would hold all of them",
            static_cast<double>(tessellations_->budget()) / kMegabyte, units_.size(),
            tessellations_->madeAgain(), static_cast<double>(tessellations_->bytesOfAll()) / kMegabyte));
  if (tessellations_->peak() > tessellations_->budget() + tessellations_->budget() / 20)
    errors_.report(
        Severity::Warning, RiError::LimitCheck, {},
        fmt::format("facets took {:.1f} MB at a time, more than geocachememory ({:.1f} MB): a single "
                    "surface is larger, or those that rays meet at once are",
                    static_cast<double>(tessellations_->peak()) / kMegabyte,
                    static_cast<double>(tessellations_->budget()) / kMegabyte));
}

}  // namespace patina
