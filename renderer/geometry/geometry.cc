// SPDX-License-Identifier: Apache-2.0
// From the primitives of a scene to bounded and placed surfaces; their facets and patches on demand.
#include "renderer/geometry/geometry.h"

#include <fmt/format.h>

#include <map>
#include <tuple>

#include "renderer/base/sampling.h"
#include "renderer/base/statistics.h"
#include "renderer/geometry/bounds.h"
#include "renderer/geometry/face_order.h"
#include "renderer/geometry/primvar.h"

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

/// Whether rays can be taken to the space of an instance: what is smaller or flatter than a part in 1e12 of
/// the world's unit, or larger than 1e15 of them, is not to be met by single-precision rays.
bool isOfRaysSize(const M44d& toWorld) {
  const M44d back = toWorld.inverse();
  double largest = 0, smallest = 0;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
      largest = std::max(largest, std::abs(toWorld[i][k])),
      smallest = std::max(smallest, std::abs(back[i][k]));
  for (int k = 0; k < 3; ++k) largest = std::max(largest, std::abs(toWorld[3][k]));
  return largest <= 1e15 && smallest <= 1e12;
}

/// Whether Embree takes a box: it ignores those that reach beyond 1.8e18, and all that is in them.
bool isTraceable(const Box3f& box) { return box.isEmpty() || (usable(box.min) && usable(box.max)); }

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
  // Chords within an eightieth of a pixel of a sphere, rounded up to powers of two.
  return std::max(least, std::min(96 * pixels, 16384.0f));
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
  if (group != kNone && groups_[group].moving != kNone)
    return viewpoint(toMesh * movingGroups_[groups_[group].moving].movement.at(
                                  static_cast<double>(scene_.camera.shutterOpen)));
  Viewpoint view = viewpoint(toMesh);
  if (group == kNone || !std::holds_alternative<Blobby>(primitive.shape)) return view;
  float nearest = kInfinity;
  const Group& of = groups_[group];
  for (const Instance& instance : of.scene->instances) {
    if (instance.object != of.object || !invertible(toMesh * instance.objectToWorld)) continue;
    const Viewpoint from = viewpoint(toMesh * instance.objectToWorld);
    const float distance = from.perspective ? from.eye.length2() : 1 / from.pixels;
    if (distance < nearest) nearest = distance, view = from;
  }
  return view;
}

bool Geometry::add(const Primitive& primitive, const M44d& toMesh, uint32_t group, uint32_t attributes,
                   bool isReversed) const {
  if (!invertible(toMesh)) {
    errors_.report(Severity::Error, RiError::Math, primitive.where,
                   "the transformation of this primitive is singular");
    return false;
  }
  TracedSurface traced{&primitive, M44f(toMesh), meshBound(primitive), group};
  traced.attributes = attributes, traced.isReversed = isReversed;
  std::unique_ptr<Surface> surface;
  if (traced.bound.isEmpty() || primitive.solid != kNone) {
    surface = patina::makeSurface(primitive, errors_, viewpoint(primitive, toMesh, group));
    if (!surface || surface->faceCount() == 0) return false;
    ++surfaceCount;
    faceCount += surface->faceCount();
    surfaceBytes_ += surface->memory();
    traced.bound = surface->bound();
  }
  if (!isTraceable(transformed(traced.bound, traced.toMesh))) {
    errors_.report(Severity::Error, RiError::Range, primitive.where,
                   "this primitive is left out: with its transformation it reaches beyond 1e18");
    return false;
  }
  ++primitiveCount;
  if (primitive.motion && primitive.solid != kNone)
    errors_.report(Severity::Warning, RiError::Unimplemented, primitive.where,
                   "what a solid is made of does not move by itself: it stands where it is at the opening of "
                   "the shutter",
                   "moving operand");
  else if (primitive.motion) {
    const bool inObject = group != kNone && groups_[group].moving == kNone;
    traced.segments = poseSegments(primitive, static_cast<double>(scene_.camera.shutterOpen),
                                   static_cast<double>(scene_.camera.shutterClose), inObject, traced.bound);
  }
  traced_.push_back(traced);
  made_.push_back(std::move(surface));
  return true;
}

/// Whether the attributes of an instance displace: its surfaces then have a shape of their own.
bool Geometry::ownsSurfaces(const GeometryPart& part, const Instance& instance) const {
  if (!displacer_ || !displacer_->boundOf(*attributes_[part.firstAttributes + instance.attributes]))
    return false;
  uint32_t object = instance.object;
  const std::vector<Primitive>& all = part.ofObject(object).scene->objects[object].primitives;
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

void Geometry::place(const GeometryPart& part, const Instance& instance) const {
  if (ownsSurfaces(part, instance)) return;
  if (!invertible(instance.objectToWorld)) {
    errors_.report(Severity::Error, RiError::Math, instance.where,
                   "the transformation of this instance is singular");
    return;
  }
  if (!isOfRaysSize(instance.objectToWorld)) {
    errors_.report(Severity::Error, RiError::Math, instance.where,
                   "this instance is left out: its transformation makes it smaller or flatter than 1e-12, or "
                   "larger or further away than 1e15");
    return;
  }
  const uint32_t group = part.groups.at(instance.object);
  const auto [first, end] = groups_[group].range;
  if (first == end) return;
  Box3f box;
  for (uint32_t k = first; k < end; ++k) box.extendBy(boundInMesh(traced_[k]));
  if (!isTraceable(transformed(box, M44f(instance.objectToWorld)))) {
    errors_.report(Severity::Error, RiError::Range, instance.where,
                   "this instance is left out: it reaches beyond 1e18");
    return;
  }
  ++instanceCount;
  const uint32_t index = part.firstAttributes + instance.attributes;
  const Attributes& attributes = *attributes_[index];
  place(group, instance.objectToWorld, index, attributes.visibility, instance.reversed, instance.motion.get(),
        attributes.sampleMotion && attributes.areaLight == kNone);
}

Geometry::Geometry(const Scene& scene, const RasterCamera& camera, ErrorHandler& errors,
                   const Displacer* displacer)
    : scene_(scene), camera_(camera), errors_(errors), displacer_(displacer) {
  tessellations_ = std::make_unique<TessellationCache>(
      static_cast<size_t>(std::max(scene_.options.geometryCacheKb, 0)) * 1024);
  patches_ = std::make_unique<PatchTable>(camera_, 0, [this](uint32_t placement) {
    const Placement& p = placements_[placement];
    const Attributes& a = attributes(p);
    const uint32_t order = traced_[p.traced].order;
    return DiceInput{&surface(p),
                     p.objectToWorld,
                     a.shadingRate,
                     a.diceLength,
                     a.diceInObjectSpace,
                     a.foreshorten,
                     p.moves ? dicePoses(placement) : std::vector<DicePose>(),
                     order == kNone ? std::span<const uint32_t>() : faceOrders_[order]};
  });
  if (!scene.delayed.empty()) {
    traced_.makeRoom(), made_.makeRoom(), surfaces_.makeRoom(), rates_.makeRoom();
    displacementChecked_.makeRoom(), placements_.makeRoom(), instances_.makeRoom(), movements_.makeRoom();
    groups_.makeRoom(), movingGroups_.makeRoom(), units_.makeRoom(), solids_.makeRoom();
    faceOrders_.makeRoom(), attributes_.makeRoom(), delayed_.makeRoom();
    tessellations_->makeRoom();
    patches_->makeRoom();
  }
  main_.scene = std::shared_ptr<const Scene>(std::shared_ptr<void>(), &scene);  // not ours
  append(main_);
}

/// Puts the surfaces of a part behind those that are there: the world's first, with their places in
/// `toWorld`, then object by object. Parts share no groups: how a surface is tessellated depends on its
/// instances, and must not depend on which parts are read already.
void Geometry::appendSurfaces(GeometryPart& part, std::vector<M44d>& toWorld) const {
  const Scene& scene = *part.scene;
  part.firstTraced = static_cast<uint32_t>(traced_.size());
  const auto addToWorld = [&](const Primitive& primitive, const M44d& matrix, uint32_t attributes,
                              bool isReversed) {
    const Attributes& a = *attributes_[attributes];
    if (a.visibility == 0 && a.areaLight == kNone && primitive.solid == kNone) return;
    if (add(primitive, matrix, kNone, attributes, isReversed)) toWorld.push_back(matrix);
  };
  for (const Primitive& primitive : scene.primitives)
    if (!movesAsWhole(primitive))
      addToWorld(primitive, primitive.objectToWorld, part.firstAttributes + primitive.attributes,
                 primitive.reversed);
  makeSolids(scene.solids, part.firstTraced, &toWorld);
  std::map<uint32_t, bool> objects;  // whether instances share their surfaces
  if (part.seed == 0)
    for (uint32_t object = 0; object < scene.objects.size(); ++object) objects[object] = false;
  for (const Instance& instance : scene.instances) {
    if (!ownsSurfaces(part, instance)) {
      objects[instance.object] = true;
      continue;
    }
    if (movesAsWhole(instance)) continue;
    uint32_t index = instance.object;
    const GeometryPart& owner = part.ofObject(index);
    const ObjectDefinition& object = owner.scene->objects[index];
    const auto first = static_cast<uint32_t>(traced_.size());
    for (const Primitive& p : object.primitives)
      addToWorld(p, p.objectToWorld * instance.objectToWorld,
                 p.attributes == kNone ? part.firstAttributes + instance.attributes
                                       : owner.firstAttributes + p.attributes,
                 p.reversed != instance.reversed);
    makeSolids(object.solids, first, &toWorld);
  }
  part.endTraced = static_cast<uint32_t>(traced_.size());
  part.firstGroup = static_cast<uint32_t>(groups_.size());
  for (const auto& [number, used] : objects) {
    const auto first = static_cast<uint32_t>(traced_.size());
    const auto group = static_cast<uint32_t>(groups_.size());
    Group& made = groups_.emplace_back();
    made.range = {first, first}, made.scene = &scene, made.object = number;
    part.groups[number] = group;
    uint32_t index = number;
    const GeometryPart& owner = part.ofObject(index);
    const ObjectDefinition& object = owner.scene->objects[index];
    if (used)
      for (const Primitive& p : object.primitives)
        add(p, p.objectToWorld, group, p.attributes == kNone ? kNone : owner.firstAttributes + p.attributes,
            p.reversed);
    makeSolids(object.solids, first, nullptr);
    groups_[group].range.second = static_cast<uint32_t>(traced_.size());
  }
  addMovingGroups(part);
  part.endGroup = static_cast<uint32_t>(groups_.size());
  surfaces_.growTo(traced_.size());
  rates_.growTo(traced_.size());
  if (displacer_) displacementChecked_.growTo(traced_.size());
  for (size_t k = part.firstTraced; k < traced_.size(); ++k) surfaces_[k] = made_[k].get();
}

/// Puts the content of a part's scene behind what is in the tables.
void Geometry::append(GeometryPart& part) const {
  const bool isMain = part.seed == 0;
  part.firstAttributes = static_cast<uint32_t>(attributes_.size());
  for (const Attributes& a : isMain ? part.scene->attributes : part.attributes) attributes_.push_back(&a);
  const auto firstSolid = static_cast<uint32_t>(solids_.size());
  std::vector<M44d> toWorld;
  appendSurfaces(part, toWorld);

  part.firstPlacement = static_cast<uint32_t>(placements_.size());
  for (uint32_t k = part.firstTraced; k < part.endTraced; ++k) {
    const M44d& matrix = toWorld[k - part.firstTraced];
    traced_[k].placement = static_cast<uint32_t>(placements_.size());
    placements_.push_back(makePlacement(k, traced_[k].attributes, kNone, matrix, matrix,
                                        traced_[k].isReversed != traced_[k].isTurned));
  }
  part.firstInstance = static_cast<uint32_t>(instances_.size());
  part.firstMovement = static_cast<uint32_t>(movements_.size());
  for (const Instance& instance : part.scene->instances) place(part, instance);
  placeMovingGroups(part);
  part.endInstance = static_cast<uint32_t>(instances_.size());
  part.endMovement = static_cast<uint32_t>(movements_.size());
  part.endPlacement = static_cast<uint32_t>(placements_.size());
  findMotion(part);
  if (displacer_) boundDisplacements(part.firstTraced);
  for (uint32_t k = part.firstPlacement; k < part.endPlacement; ++k) {
    Placement& p = placements_[k];
    p.seed = isMain ? k : hashOf(part.seed, k - part.firstPlacement) | uint64_t{1} << 63;
    if (!isMain) continue;  // it is within the bound of its request, for rays at least
    const TracedSurface& traced = traced_[p.traced];
    if (!traced.isDisplaced)
      bound_.extendBy(transformed(traced.bound, p.objectToWorld));
    else if (p.instance == kNone)
      bound_.extendBy(boundInMesh(traced));
    else
      bound_.extendBy(transformed(boundInMesh(traced), instances_[p.instance].meshToWorld));
  }
  makeUnits(part.firstTraced, firstSolid);
  tessellations_->growTo(units_.size());
  patches_->growTo(placements_.size());
  addDelayed(part);
}

Geometry::~Geometry() = default;

Box3f Geometry::boundInMesh(const TracedSurface& traced) const {
  Box3f box = padded(transformed(padded(traced.bound), traced.toMesh));
  box.min -= V3f(traced.reach), box.max += V3f(traced.reach);
  return box;
}

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

void Geometry::reportMemory() const {
  constexpr double kMegabyte = 1048576;
  setStatistic("Memory/surfaces MB", static_cast<double>(surfaceBytes_) / kMegabyte);
  setStatistic("Memory/face orders MB", static_cast<double>(orderBytes_) / kMegabyte);
  setStatistic("Memory/patches MB", static_cast<double>(patches_->memory()) / kMegabyte);
  setStatistic("Memory/tessellations, most MB", static_cast<double>(tessellations_->peak()) / kMegabyte);
  setStatistic("Memory/tessellations, budget MB", static_cast<double>(tessellations_->budget()) / kMegabyte);
  setStatistic("Geometry/units", static_cast<double>(units_.size()));
  if (loadingTime_ > 0)
    setStatistic("Delayed archives/seconds of all threads", static_cast<double>(loadingTime_) * 1e-9);
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
