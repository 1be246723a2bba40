// SPDX-License-Identifier: Apache-2.0
// What moves, as geometry: groups that share a moving place, and facets at time steps.
#include <map>
#include <tuple>

#include "renderer/base/statistics.h"
#include "renderer/geometry/bounds.h"
#include "renderer/geometry/geometry.h"
#include "renderer/scene/shape_motion.h"

namespace patina {
namespace {

STAT_COUNTER("Motion/moving placements", movingPlacements);
STAT_COUNTER("Motion/deforming surfaces", deformingSurfaces);
STAT_COUNTER("Motion/time segments of surfaces", surfaceSegments);
STAT_COUNTER("Motion/time segments of places", placeSegments);

constexpr size_t kPoses = 5;  // at which what moves is measured, beside the opening

/// Steps 1 to `segments`, or a few of them at about equal distances; the last one is among them.
std::vector<uint32_t> someSteps(uint32_t segments) {
  std::vector<uint32_t> steps;
  const auto count = std::min<uint32_t>(segments, kPoses);
  for (uint32_t k = 1; k <= count; ++k) steps.push_back(segments * k / count);
  return steps;
}

}  // namespace

// ---- Places that move -------------------------------------------------------------------------------------

bool Geometry::movesAsWhole(const Primitive& primitive) const {
  return primitive.motion && primitive.solid == kNone &&
         primitive.motion->place.movesWithin(static_cast<double>(scene_.camera.shutterOpen),
                                             static_cast<double>(scene_.camera.shutterClose));
}

bool Geometry::movesAsWhole(const Instance& instance) const {
  return instance.motion && instance.motion->movesWithin(static_cast<double>(scene_.camera.shutterOpen),
                                                         static_cast<double>(scene_.camera.shutterClose));
}

/// Primitives of the world that share a moving transformation are a group with one instance. Its mesh space
/// is that of the movement, so that what turns only turns; that of what is displaced, as it is where things
/// stand still, the world's at the opening.
void Geometry::addMovingGroups(const GeometryPart& part) const {
  const double open = static_cast<double>(scene_.camera.shutterOpen);
  const size_t firstMoving = movingGroups_.size();
  std::map<std::tuple<const Motion*, bool, bool>, size_t> known;
  const auto addMember = [&](const std::shared_ptr<const Motion>& outer, MovingGroup::Member member,
                             const M44d& inner) {
    const Attributes& attributes = *attributes_[member.attributes];
    if (attributes.visibility == 0 && attributes.areaLight == kNone) return;
    const bool sampleMotion = attributes.sampleMotion && attributes.areaLight == kNone;
    const bool isDisplaced = displacer_ && displacer_->boundOf(attributes);
    const auto [found, isNew] =
        known.try_emplace({outer.get(), sampleMotion, isDisplaced}, movingGroups_.size());
    if (isNew)
      movingGroups_.push_back(
          {{isDisplaced ? outer->at(open).inverse() : M44d(), outer}, sampleMotion, {}, {}, kNone});
    if (!isDisplaced) member.toMesh = inner;
    movingGroups_[found->second].members.push_back(member);
  };
  for (const Primitive& p : part.scene->primitives)
    if (movesAsWhole(p))
      addMember(p.motion->place.outer, {&p, p.objectToWorld, part.firstAttributes + p.attributes, p.reversed},
                p.motion->place.inner);
  for (const Instance& instance : part.scene->instances) {
    if (!movesAsWhole(instance) || !ownsSurfaces(part, instance)) continue;
    uint32_t object = instance.object;
    const GeometryPart& owner = part.ofObject(object);
    for (const Primitive& p : owner.scene->objects[object].primitives)
      addMember(instance.motion->outer,
                {&p, p.objectToWorld * instance.objectToWorld,
                 p.attributes == kNone ? part.firstAttributes + instance.attributes
                                       : owner.firstAttributes + p.attributes,
                 p.reversed != instance.reversed},
                p.objectToWorld * instance.motion->inner);
  }
  for (auto k = static_cast<uint32_t>(firstMoving); k < movingGroups_.size(); ++k) {
    MovingGroup& moving = movingGroups_[k];
    const auto first = static_cast<uint32_t>(traced_.size());
    moving.group = static_cast<uint32_t>(groups_.size());
    groups_.emplace_back().moving = k;
    for (const MovingGroup::Member& m : moving.members)
      if (add(*m.primitive, m.toMesh, moving.group, m.attributes, m.isReversed))
        moving.toMesh.push_back(m.toMesh);
    groups_[moving.group].range = {first, static_cast<uint32_t>(traced_.size())};
  }
}

void Geometry::placeMovingGroups(const GeometryPart& part) const {
  for (uint32_t k = part.firstGroup; k < part.endGroup; ++k) {
    if (groups_[k].moving == kNone) continue;
    const MovingGroup& group = movingGroups_[groups_[k].moving];
    uint32_t visibility = 0;
    for (const MovingGroup::Member& m : group.members) visibility |= attributes_[m.attributes]->visibility;
    place(k, group.movement.at(static_cast<double>(scene_.camera.shutterOpen)), kNone, visibility, false,
          &group.movement, group.sampleMotion);
  }
}

void Geometry::place(uint32_t group, const M44d& meshToWorld, uint32_t attributes, uint32_t visibility,
                     bool reversed, const Movement* movement, bool sampleMotion) const {
  Group& of = groups_[group];
  const auto [first, end] = of.range;
  if (first == end) return;
  const auto index = static_cast<uint32_t>(instances_.size());
  of.instances.push_back(index);
  if (attributes != kNone && attributes_[attributes]->oneSided) of.oneSided = true;
  instances_.push_back({group, static_cast<uint32_t>(placements_.size()), visibility, M44f(meshToWorld),
                        M44f(meshToWorld.inverse())});
  const double open = static_cast<double>(scene_.camera.shutterOpen),
               close = static_cast<double>(scene_.camera.shutterClose);
  if (movement && movement->movesWithin(open, close)) {
    Box3f bound;
    for (uint32_t k = first; k < end; ++k) bound.extendBy(transformed(traced_[k].bound, traced_[k].toMesh));
    instances_.back().movement = static_cast<uint32_t>(movements_.size());
    movements_.push_back({sampleMovement(*movement, open, close, bound), sampleMotion});
    placeSegments += static_cast<int64_t>(movements_.back().steps.size()) - 1;
  }
  for (uint32_t k = first; k < end; ++k) {
    const TracedSurface& traced = traced_[k];
    const M44d& toMesh =
        of.moving == kNone ? traced.primitive->objectToWorld : movingGroups_[of.moving].toMesh[k - first];
    placements_.push_back(makePlacement(
        k, traced.attributes == kNone ? attributes : traced.attributes, index, toMesh * meshToWorld, toMesh,
        traced.isReversed != (traced.solid == kNone ? reversed : traced.isTurned)));
  }
}

/// What of a part moves. Whether anything does, for which rays have times, is known of the scene's own
/// content from the beginning, and supposed of delayed archives: pictures do not depend on who reads them
/// when.
void Geometry::findMotion(const GeometryPart& part) const {
  bool moves = false, samplesMotion = false;
  for (uint32_t k = part.firstTraced; k < traced_.size(); ++k) {
    const TracedSurface& traced = traced_[k];
    if (traced.segments == 0) continue;
    ++deformingSurfaces;
    surfaceSegments += traced.segments;
    const Attributes* own = attributes(traced);
    samplesMotion |= own && own->sampleMotion && own->areaLight == kNone;
  }
  for (uint32_t k = part.firstPlacement; k < part.endPlacement; ++k) {
    Placement& p = placements_[k];
    p.moves =
        traced_[p.traced].segments > 0 || (p.instance != kNone && instances_[p.instance].movement != kNone);
    if (!p.moves) continue;
    moves = true;
    ++movingPlacements;
  }
  for (uint32_t k = part.firstMovement; k < part.endMovement; ++k)
    samplesMotion |= movements_[k].sampleMotion;
  if (part.seed == 0) {
    const bool mayMove = scene_.camera.shutterOpen < scene_.camera.shutterClose;
    for (const DelayedArchive& archive : scene_.delayed)
      moves |= mayMove, samplesMotion |= mayMove && archive.sampleMotion;
    moves_ = moves, samplesMotion_ = samplesMotion;
  } else if (samplesMotion && !samplesMotion_) {
    errors_.reportOnce(Severity::Warning, RiError::IllState, {}, "samplemotion in a delayed archive",
                       "Attribute \"trace\" \"samplemotion\" within a delayed archive has no effect: it is "
                       "to be set before its request, as rays have a time from the beginning or never");
  }
}

void Geometry::addPlacesInTime(uint32_t traced, std::vector<M44f>& places) const {
  const auto add = [&](const M44f& place) {
    for (const uint32_t step : someSteps(traced_[traced].segments))
      places.push_back(toMeshAt(traced, step) * place);
  };
  const uint32_t group = traced_[traced].group;
  if (group == kNone) return add(M44f());
  for (const uint32_t index : groups_[group].instances) {
    const PlacedInstance& instance = instances_[index];
    add(instance.meshToWorld);
    if (instance.movement == kNone) continue;
    const std::vector<TransformParts>& steps = movements_[instance.movement].steps;
    for (const uint32_t step : someSteps(static_cast<uint32_t>(steps.size() - 1)))
      places.push_back(traced_[traced].toMesh * M44f(steps[step].matrix()));
  }
}

std::vector<DicePose> Geometry::dicePoses(uint32_t index) const {
  const Placement& p = placements_[index];
  const PlacedInstance* instance = p.instance == kNone ? nullptr : &instances_[p.instance];
  const std::vector<TransformParts>* places =
      instance && instance->movement != kNone ? &movements_[instance->movement].steps : nullptr;
  const uint32_t segments = traced_[p.traced].segments;
  std::vector<DicePose> poses;
  for (size_t k = 1; k <= kPoses; ++k) {
    const auto step = static_cast<uint32_t>(segments * k / kPoses);
    DicePose pose{nullptr, toMeshAt(p.traced, step)};
    if (places)
      pose.objectToWorld = pose.objectToWorld * M44f((*places)[(places->size() - 1) * k / kPoses].matrix());
    else if (instance)
      pose.objectToWorld = pose.objectToWorld * instance->meshToWorld;
    if (segments > 0 && step > 0) {
      auto posed = std::make_shared<PosedSurface>(this->posed(p.traced, step));
      if (posed->surface) pose.surface = {posed, posed->surface.get()};
    }
    poses.push_back(std::move(pose));
  }
  return poses;
}

// ---- Facets that move -------------------------------------------------------------------------------------

PosedPrimitive Geometry::posing(uint32_t traced) const {
  const TracedSurface& t = traced_[traced];
  const bool inObject = t.group != kNone && groups_[t.group].moving == kNone;
  return {t.primitive, static_cast<double>(scene_.camera.shutterOpen),
          static_cast<double>(scene_.camera.shutterClose), t.segments,
          inObject && t.primitive->motion && t.primitive->motion->place.outer};
}

M44f Geometry::toMeshAt(uint32_t traced, uint32_t step) const {
  if (traced_[traced].segments == 0 || step == 0) return traced_[traced].toMesh;
  const PosedPrimitive posing = this->posing(traced);
  return posing.placeMoves ? M44f(traced_[traced].primitive->motion->place.at(posing.time(step)))
                           : traced_[traced].toMesh;
}

PosedSurface Geometry::posed(uint32_t traced, uint32_t step) const {
  const PosedPrimitive posing = this->posing(traced);
  const Surface& base = surface(traced);
  PosedSurface result;
  Primitive primitive = posing.at(step);
  if (std::holds_alternative<PolygonMesh>(primitive.shape)) {
    result.surface = std::make_unique<PosedPolygons>(base, std::move(primitive));
    return result;
  }
  // What is wrong with it has been said of the opening.
  ErrorHandler quiet([](Severity, std::string_view) {});
  result.primitive = std::make_unique<const Primitive>(std::move(primitive));
  result.surface =
      patina::makeSurface(*result.primitive, quiet,
                          viewpoint(*result.primitive, M44d(traced_[traced].toMesh), traced_[traced].group));
  if (result.surface && result.surface->faceCount() == base.faceCount()) return result;
  result.surface = nullptr;
  if (!posesFailed_.exchange(true))
    errors_.report(Severity::Warning, RiError::BadMotion, traced_[traced].primitive->where,
                   "the pieces of this primitive are not the same while the shutter is open: it keeps its "
                   "shape (as do others like it)");
  return result;
}

/// The rates of the step that wants most.
SurfaceRates Geometry::ratesInTime(uint32_t traced, std::optional<float> shadingRate) const {
  const auto facets = [](const SurfaceRates& rates) {
    size_t sum = 0;
    for (const TileRates& r : rates.tiles) sum += size_t{1} << (r.u + r.v);
    return sum;
  };
  const std::vector<M44f> places = placesOf(traced);
  SurfaceRates best = traceRates(camera_, surface(traced), places, shadingRate);
  for (const uint32_t step : someSteps(traced_[traced].segments)) {
    const PosedSurface at = posed(traced, step);
    if (!at.surface) break;
    SurfaceRates rates = traceRates(camera_, *at.surface, places, shadingRate);
    if (facets(rates) > facets(best)) best = std::move(rates);
  }
  return best;
}

Box3f Geometry::boundAt(uint32_t k, uint32_t step) const {
  const TracedSurface& traced = traced_[k];
  if (step == 0 || traced.primitive->motion->shapes.empty()) return traced.bound;
  if (const Box3f box = meshBound(posing(k).at(step)); !box.isEmpty()) return box;
  const PosedSurface at = posed(k, step);
  return at.surface ? at.surface->bound() : traced.bound;
}

void Geometry::addStepBounds(SurfaceUnit& unit, uint32_t traced, const Box3f& opening) const {
  unit.stepBounds.resize(unit.segments + 1);
  unit.stepBounds[0].extendBy(opening);
  for (uint32_t step = 1; step <= unit.segments; ++step) {
    const M44f toMesh = toMeshAt(traced, step);
    Box3f box = padded(transformed(padded(boundAt(traced, step)), toMesh));
    box.min -= V3f(traced_[traced].reach), box.max += V3f(traced_[traced].reach);
    unit.stepBounds[step].extendBy(box);
  }
}

void Geometry::addSteps(const SurfaceUnit& unit, Tessellation& tessellation) const {
  tessellation.stride = tessellation.vertices.size();
  std::vector<uint32_t> first;
  std::vector<V3f> vertices;
  for (uint32_t step = 1; step <= unit.segments; ++step)
    for (size_t m = 0; m < unit.members.size(); ++m) {
      const SurfaceRates* rates = tessellation.members[m].rates;
      if (!rates) continue;
      const uint32_t k = unit.members[m];
      const PosedSurface at = posed(k, step);
      const Surface& shape = at.surface ? *at.surface : surface(k);
      const M44f toMesh = toMeshAt(k, step);
      first.clear(), vertices.clear();
      patina::tessellate(shape, *rates, first, vertices);
      if (const TracedSurface& traced = traced_[k]; traced.isDisplaced) {
        displaceFacets(shape, *traced.primitive, *attributes(traced), toMesh, traced.isReversed, *displacer_,
                       *rates, first, vertices);
        tessellation.vertices.insert(tessellation.vertices.end(), vertices.begin(), vertices.end());
        continue;
      }
      thinSides(*rates, std::span<const uint32_t>(first), std::span(vertices));
      for (const V3f& p : vertices) tessellation.vertices.push_back(transformPoint(p, toMesh));
    }
}

}  // namespace patina
