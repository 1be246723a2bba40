// SPDX-License-Identifier: Apache-2.0
// From the primitives of a scene to bounded and placed surfaces; their facets and patches on demand.
#include "renderer/geometry/geometry.h"

#include <fmt/format.h>

#include <map>

#include "renderer/base/sampling.h"
#include "renderer/base/statistics.h"
#include "renderer/geometry/bounds.h"
#include "renderer/geometry/primvar.h"

namespace patina {
namespace {

STAT_COUNTER("Geometry/primitives", primitiveCount);
STAT_COUNTER("Geometry/surfaces made", surfaceCount);
STAT_COUNTER("Geometry/faces", faceCount);
STAT_COUNTER("Geometry/instances", instanceCount);

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
  view.pixelCount = camera_.pixelCount();
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
