// SPDX-License-Identifier: Apache-2.0
// Embree scenes of a part of the geometry, and what happens where rays meet units and delayed archives.
#include "renderer/accel/part_tracer.h"

#include <array>
#include <map>

#include "renderer/accel/solid_walk.h"
#include "renderer/base/statistics.h"

namespace patina {
namespace {

STAT_COUNTER("Motion/Embree geometries with time steps", timedGeometries);

const EmbreeScene& sceneOf(const Tessellation& tessellation) {
  return static_cast<const UnitTracer&>(*tessellation.tracer).scene;
}

/// Steps of a movement, in the terms of Embree: translation * rotation * scale and skew, for columns.
void setSteps(RTCGeometry shape, const std::vector<TransformParts>& steps) {
  rtcSetGeometryTimeStepCount(shape, static_cast<unsigned>(steps.size()));
  for (size_t k = 0; k < steps.size(); ++k) {
    const Imath::M33f s(steps[k].stretch);
    const Imath::Quatf q(steps[k].rotation);
    const V3f t(steps[k].translation);
    RTCQuaternionDecomposition parts;
    rtcInitQuaternionDecomposition(&parts);
    rtcQuaternionDecompositionSetScale(&parts, s[0][0], s[1][1], s[2][2]);
    rtcQuaternionDecompositionSetSkew(&parts, s[1][0], s[2][0], s[2][1]);
    rtcQuaternionDecompositionSetQuaternion(&parts, q.r, q.v.x, q.v.y, q.v.z);
    rtcQuaternionDecompositionSetTranslation(&parts, t.x, t.y, t.z);
    rtcSetGeometryTransformQuaternion(shape, static_cast<unsigned>(k), &parts);
  }
}

/// The largest coordinate of a ray's origin that stays below kLargestOrigin in the space behind a matrix.
float reachThrough(const M44f& worldToMesh) {
  const M44d m(worldToMesh);
  double reach = static_cast<double>(kLargestOrigin);
  for (int k = 0; k < 3; ++k) {
    const double sum = std::abs(m[0][k]) + std::abs(m[1][k]) + std::abs(m[2][k]);
    reach = std::min(reach, (static_cast<double>(kLargestOrigin) - std::abs(m[3][k])) / sum);
  }
  return reach > 0 ? static_cast<float>(reach) : 0;
}

/// A query within a delayed archive.
class Within {
 public:
  Within(QueryContext& query, const PartTracer& part) : query_(query), before_(query.part) {
    query.part = &part;
  }
  ~Within() { query_.part = before_; }

 private:
  QueryContext& query_;
  const PartTracer* before_;
};

}  // namespace

UnitTracer::UnitTracer(RTCDevice device, const Geometry& geometry, uint32_t unit)
    : scene(device, geometry, RTC_BUILD_QUALITY_MEDIUM,
            {.segments = geometry.units()[unit].segments,
             .compact = !geometry.units()[unit].faces.empty(),
             .everyHit = geometry.units()[unit].solid == kNone ? nullptr : collectCrossings}) {}

// ---- Scenes -----------------------------------------------------------------------------------------------

PartTracer::PartTracer(RTCDevice device, const Geometry& geometry, const GeometryPart& part,
                       const std::vector<bool>& native)
    : device_(device),
      geometry_(geometry),
      firstTraced_(part.firstTraced),
      firstPlacement_(part.firstPlacement),
      firstGroup_(part.firstGroup),
      firstMovement_(part.firstMovement),
      delayed_{&geometry, part.firstDelayed},
      movingShapes_(part.endMovement - part.firstMovement) {
  world_ = makeGroup(part.firstTraced, part.endTraced, native);
  if (part.firstDelayed < part.endDelayed) attachDelayed(part.endDelayed - part.firstDelayed);
  // Behind the numbers that Embree has given.
  instances_.first = world_->geometries() + static_cast<uint32_t>(lists_.size()) + 2;
  instances_.base = part.firstInstance;
  instances_.count = part.endInstance - part.firstInstance;
  groups_.resize(part.endGroup - part.firstGroup);
  for (uint32_t k = 0; k < groups_.size(); ++k) {
    const auto [first, end] = geometry.groupRange(firstGroup_ + k);
    if (first == end) continue;
    groups_[k] = makeGroup(first, end, native);
    rtcCommitScene(groups_[k]->scene());
  }
  attachInstances();
  rtcCommitScene(world_->scene());
}

PartTracer::~PartTracer() {
  world_.reset();  // before the lists that scenes point to, and instances before what they are of
  groups_.clear();
  for (RTCGeometry shape : movingShapes_)
    if (shape) rtcReleaseGeometry(shape);
}

std::unique_ptr<EmbreeScene> PartTracer::makeGroup(uint32_t first, uint32_t end,
                                                   const std::vector<bool>& native) {
  auto scene = std::make_unique<EmbreeScene>(device_, geometry_, RTC_BUILD_QUALITY_MEDIUM);
  UnitList list{&geometry_};
  std::vector<uint32_t> moving, natives;
  for (uint32_t k = first; k < end; ++k) {
    const TracedSurface& traced = geometry_.traced()[k];
    if (traced.unit == kNone)
      scene->addFlat(k);
    else if (traced.member == 0)  // all members are of one group
      for (uint32_t unit = traced.unit; unit < traced.unit + std::max(traced.chunks, 1u); ++unit)
        (!native.empty() && native[unit] ? natives
         : traced.segments > 0           ? moving
                                         : list.units)
            .push_back(unit);
  }
  scene->attach();
  for (const uint32_t unit : natives) scene->addUnit(unit, *geometry_.tessellations().resident(unit));
  attachUnits(*scene, std::move(list));
  // Units that move: with their motion for the camera's rays, as they are at the opening for others.
  std::map<uint32_t, std::array<UnitList, 3>> bySegments;
  for (const uint32_t unit : moving) {
    const SurfaceUnit& u = geometry_.units()[unit];
    std::array<UnitList, 3>& to = bySegments[u.segments];
    if (u.sampleMotion) {
      to[0].units.push_back(unit);
      continue;
    }
    if (u.visibility & kCameraRay) to[1].units.push_back(unit);
    if (u.visibility & ~uint32_t{kCameraRay}) to[2].units.push_back(unit);
  }
  for (auto& [segments, byRays] : bySegments)
    for (size_t k = 0; k < byRays.size(); ++k) {
      static constexpr uint32_t kMasks[] = {kAnyRay, kCameraRay, kAnyRay & ~kCameraRay};
      UnitList& units = byRays[k];
      units.geometry = &geometry_, units.mask = kMasks[k], units.frozen = k == 2;
      units.segments = k == 2 ? 0 : segments;
      attachUnits(*scene, std::move(units));
    }
  return scene;
}

/// Primitives that are made when rays meet them. `list` must outlive the scene.
template <class List>
RTCGeometry PartTracer::newUserGeometry(List& list, size_t count) const {
  RTCGeometry shape = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(shape, static_cast<unsigned>(count));
  rtcSetGeometryUserData(shape, &list);
  list.made.give();
  rtcSetGeometryMask(shape, kAnyRay);
  return shape;
}

void PartTracer::attachUnits(EmbreeScene& scene, UnitList units) {
  if (units.units.empty()) return;
  const UnitList& list = lists_.emplace_back(std::move(units));
  RTCGeometry shape = newUserGeometry(lists_.back(), list.units.size());
  if (list.segments > 0) {
    rtcSetGeometryTimeStepCount(shape, list.segments + 1);
    ++timedGeometries;
  }
  rtcSetGeometryBoundsFunction(shape, boundUnit, nullptr);
  rtcSetGeometryIntersectFunction(shape, intersectUnit);
  rtcSetGeometryOccludedFunction(shape, occludeUnit);
  rtcCommitGeometry(shape);
  rtcAttachGeometry(scene.scene(), shape);
  rtcReleaseGeometry(shape);
}

void PartTracer::attachDelayed(uint32_t count) {
  RTCGeometry shape = newUserGeometry(delayed_, count);
  rtcSetGeometryBoundsFunction(shape, boundDelayed, nullptr);
  rtcSetGeometryIntersectFunction(shape, intersectDelayed);
  rtcSetGeometryOccludedFunction(shape, occludeDelayed);
  rtcCommitGeometry(shape);
  rtcAttachGeometry(world_->scene(), shape);
  rtcReleaseGeometry(shape);
}

void PartTracer::attachInstances() {
  const auto attach = [&](const PlacedInstance& instance, uint32_t mask, uint32_t id, const auto& setPlace) {
    RTCGeometry shape = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(shape, groups_[instance.object - firstGroup_]->scene());
    setPlace(shape);
    rtcSetGeometryMask(shape, mask);
    rtcCommitGeometry(shape);
    rtcAttachGeometryByID(world_->scene(), shape, id);
    return shape;
  };
  const auto stillAt = [](const PlacedInstance& instance) {
    return [&](RTCGeometry shape) {
      rtcSetGeometryTimeStepCount(shape, 1);
      rtcSetGeometryTransform(shape, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, instance.meshToWorld.getValue());
    };
  };
  const auto& [first, base, count, ignored] = instances_;
  std::vector<uint32_t>& twins = instances_.twins;
  for (uint32_t k = 0; k < count; ++k) {
    const PlacedInstance& instance = geometry_.instances()[base + k];
    reach_ = std::min(reach_, reachThrough(instance.worldToMesh));
    if (instance.movement == kNone) {
      rtcReleaseGeometry(attach(instance, instance.visibility, first + k, stillAt(instance)));
      continue;
    }
    const InstanceMovement& movement = geometry_.movements()[instance.movement];
    for (const TransformParts& step : movement.steps)
      reach_ = std::min(reach_, reachThrough(M44f(step.matrix().inverse())));
    const uint32_t moving = movement.sampleMotion ? instance.visibility : instance.visibility & kCameraRay;
    if (moving != 0) {
      ++timedGeometries;
      movingShapes_[instance.movement - firstMovement_] =
          attach(instance, moving, first + k, [&](RTCGeometry shape) { setSteps(shape, movement.steps); });
    }
    if (const uint32_t rest = instance.visibility & ~moving; rest != 0) {
      twins.push_back(base + k);
      const auto id = first + count + static_cast<uint32_t>(twins.size()) - 1;
      rtcReleaseGeometry(attach(instance, rest, id, stillAt(instance)));
    }
  }
}

// ---- Hits -------------------------------------------------------------------------------------------------

/// Of an instance that moves, as Embree has it.
M44f PartTracer::worldToMesh(uint32_t movement, float time) const {
  M44f toWorld;
  rtcGetGeometryTransform(movingShapes_[movement - firstMovement_], time, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR,
                          toWorld.getValue());
  return toWorld.inverse();
}

MetFace PartTracer::met(uint32_t geometry, uint32_t primitive, uint32_t number, const V3f& normal, float time,
                        float& u, float& v) const {
  const uint32_t instance = instances_.indexOf(number);
  if (instance == kNone) {
    const FaceOwner owner = geometry >= kFirstTraced ? FaceOwner{geometry - kFirstTraced, primitive}
                                                     : world_->ownerOf(geometry, primitive, u, v);
    return {owner.traced - firstTraced_ + firstPlacement_, owner.face, kNone, normal};
  }
  const PlacedInstance& placed = geometry_.instances()[instance];
  const FaceOwner owner = geometry >= kFirstTraced
                              ? FaceOwner{geometry - kFirstTraced, primitive}
                              : groups_[placed.object - firstGroup_]->ownerOf(geometry, primitive, u, v);
  const bool isTwin = number - instances_.first != instance - instances_.base;
  const bool turns = placed.movement != kNone && !isTwin && time > 0;
  return {geometry_.placementOf(owner.traced, instance), owner.face, instance,
          transformNormal(normal, turns ? worldToMesh(placed.movement, time) : placed.worldToMesh)};
}

// ---- Callbacks: nothing may be thrown ---------------------------------------------------------------------

void PartTracer::boundUnit(const RTCBoundsFunctionArguments* args) {
  const auto& list = *static_cast<const UnitList*>(args->geometryUserPtr);
  list.made.take();
  const SurfaceUnit& unit = list.geometry->units()[list.units[args->primID]];
  const Box3f& box = list.segments > 0 ? unit.stepBounds[args->timeStep] : unit.bound;
  *args->bounds_o = {box.min.x, box.min.y, box.min.z, 0, box.max.x, box.max.y, box.max.z, 0};
}

bool intersectFacets(const Geometry& geometry, uint32_t unit, const Tessellation& met, QueryContext& query,
                     RTCRayHit& ray) {
  const EmbreeScene& scene = sceneOf(met);
  const uint32_t solid = geometry.units()[unit].solid;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  FaceOwner owner;
  if (solid == kNone) {
    rtcIntersect1(scene.scene(), &query.embree, &ray);
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    owner = scene.ownerOf(ray.hit.geomID, ray.hit.primID, ray.hit.u, ray.hit.v);
  } else if (!intersectSolid(scene, solid, query, ray, owner)) {
    return false;
  }
  ray.hit.geomID = kFirstTraced + owner.traced;
  ray.hit.primID = owner.face;
  return true;
}

void occludeFacets(const Geometry& geometry, uint32_t unit, const Tessellation& met, QueryContext& query,
                   RTCRay& ray) {
  const EmbreeScene& scene = sceneOf(met);
  const uint32_t solid = geometry.units()[unit].solid;
  if (solid == kNone)
    rtcOccluded1(scene.scene(), &query.embree, &ray);
  else
    occludeBySolid(scene, solid, query, ray);
}

void PartTracer::intersectUnit(const RTCIntersectFunctionNArguments* args) {
  const auto& list = *static_cast<const UnitList*>(args->geometryUserPtr);
  const uint32_t unit = list.units[args->primID];
  const uint32_t visibility = list.geometry->units()[unit].visibility & list.mask;
  QueryContext& query = QueryContext::of(args->context);
  for (unsigned k = 0; k < args->N; ++k) {
    if (args->valid[k] == 0) continue;
    if ((RTCRayN_mask(RTCRayHitN_RayN(args->rayhit, args->N), args->N, k) & visibility) == 0) continue;
    RTCRayHit ray = rtcGetRayHitFromRayHitN(args->rayhit, args->N, k);
    if (list.frozen) ray.ray.time = 0;
    const Tessellation* const met = query.unit(unit, ray.ray);
    if (!met || !intersectFacets(*list.geometry, unit, *met, query, ray)) continue;
    RTCRayN_tfar(RTCRayHitN_RayN(args->rayhit, args->N), args->N, k) = ray.ray.tfar;
    rtcCopyHitToHitN(RTCRayHitN_HitN(args->rayhit, args->N), &ray.hit, args->N, k);
  }
}

void PartTracer::occludeUnit(const RTCOccludedFunctionNArguments* args) {
  const auto& list = *static_cast<const UnitList*>(args->geometryUserPtr);
  const uint32_t unit = list.units[args->primID];
  const uint32_t visibility = list.geometry->units()[unit].visibility & list.mask;
  QueryContext& query = QueryContext::of(args->context);
  for (unsigned k = 0; k < args->N; ++k) {
    if (args->valid[k] == 0) continue;
    RTCRay ray = rtcGetRayFromRayN(args->ray, args->N, k);
    if ((ray.mask & visibility) == 0) continue;
    if (list.frozen) ray.time = 0;
    const Tessellation* const met = query.unit(unit, ray);
    if (!met) continue;
    occludeFacets(*list.geometry, unit, *met, query, ray);
    RTCRayN_tfar(args->ray, args->N, k) = ray.tfar;
  }
}

void PartTracer::boundDelayed(const RTCBoundsFunctionArguments* args) {
  const auto& list = *static_cast<const DelayedList*>(args->geometryUserPtr);
  list.made.take();
  const Box3f& box = list.geometry->delayed(list.first + args->primID).worldBound;
  *args->bounds_o = {box.min.x, box.min.y, box.min.z, 0, box.max.x, box.max.y, box.max.z, 0};
}

/// Cuts a ray to the bound of a delayed archive and has the archive read. Null: the ray meets nothing of it.
const PartTracer* PartTracer::meetDelayed(const DelayedList& list, uint32_t index, QueryContext& query,
                                          RTCRay& ray) {
  if (!list.geometry->clipToBound(index, {ray.org_x, ray.org_y, ray.org_z}, {ray.dir_x, ray.dir_y, ray.dir_z},
                                  ray.tnear, ray.tfar))
    return nullptr;
  const GeometryPart* part = list.geometry->delayed(index).loaded.load(std::memory_order_acquire);
  if (!part)
    part = &query.reader->whileHoldingNothing(
        [&]() -> const GeometryPart& { return list.geometry->part(index); });
  return static_cast<const PartTracer*>(part->tracer.get());
}

void PartTracer::intersectDelayed(const RTCIntersectFunctionNArguments* args) {
  const auto& list = *static_cast<const DelayedList*>(args->geometryUserPtr);
  QueryContext& query = QueryContext::of(args->context);
  for (unsigned k = 0; k < args->N; ++k) {
    if (args->valid[k] == 0) continue;
    RTCRayHit ray = rtcGetRayHitFromRayHitN(args->rayhit, args->N, k);
    if (ray.ray.mask == 0) continue;  // a lane of a packet that is not full
    const PartTracer* const part = meetDelayed(list, list.first + args->primID, query, ray.ray);
    if (!part || !part->traces(ray.ray)) continue;
    RTCHit& hit = ray.hit;
    hit.geomID = hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    const Within within(query, *part);
    rtcIntersect1(part->scene(), args->context, &ray);
    if (hit.geomID == RTC_INVALID_GEOMETRY_ID) continue;
    if (hit.geomID < kFirstResolved) {  // else it is in an archive within this one
      const MetFace met = part->met(hit.geomID, hit.primID, hit.instID[0], {hit.Ng_x, hit.Ng_y, hit.Ng_z},
                                    ray.ray.time, hit.u, hit.v);
      hit.geomID = kFirstResolved + met.placement, hit.primID = met.face, hit.instID[0] = met.instance;
      hit.Ng_x = met.normal.x, hit.Ng_y = met.normal.y, hit.Ng_z = met.normal.z;
    }
    RTCRayN_tfar(RTCRayHitN_RayN(args->rayhit, args->N), args->N, k) = ray.ray.tfar;
    rtcCopyHitToHitN(RTCRayHitN_HitN(args->rayhit, args->N), &hit, args->N, k);
  }
}

void PartTracer::occludeDelayed(const RTCOccludedFunctionNArguments* args) {
  const auto& list = *static_cast<const DelayedList*>(args->geometryUserPtr);
  QueryContext& query = QueryContext::of(args->context);
  for (unsigned k = 0; k < args->N; ++k) {
    if (args->valid[k] == 0) continue;
    RTCRay ray = rtcGetRayFromRayN(args->ray, args->N, k);
    const PartTracer* const part = meetDelayed(list, list.first + args->primID, query, ray);
    if (!part || !part->traces(ray)) continue;
    const Within within(query, *part);
    rtcOccluded1(part->scene(), args->context, &ray);
    if (ray.tfar < 0) RTCRayN_tfar(args->ray, args->N, k) = ray.tfar;
  }
}

}  // namespace patina
