// SPDX-License-Identifier: Apache-2.0
// Embree scenes: one for the world, one per instanced object, and one for each unit of surfaces that a ray
// has met. Small flat primitives are in the scenes of the world and the objects from the beginning; units
// stand there as user geometry that is made when a ray meets its bound (lazy geometry in Embree's words).
#include "renderer/accel/accel.h"

#include <array>
#include <atomic>
#include <deque>
#include <map>
#include <stdexcept>

#include "renderer/accel/deferred_units.h"
#include "renderer/accel/embree_scene.h"
#include "renderer/accel/solid_walk.h"
#include "renderer/base/statistics.h"

namespace patina {
namespace {

STAT_COUNTER("Rays/camera", cameraRays);
STAT_COUNTER("Rays/diffuse", diffuseRays);
STAT_COUNTER("Rays/specular", specularRays);
STAT_COUNTER("Rays/transmission", transmissionRays);
STAT_COUNTER("Rays/with a time", timedRays);
STAT_COUNTER("Rays/units waited for by batches", waitedUnits);
STAT_COUNTER("Rays/meetings that waited", waitedMeetings);
STAT_COUNTER("Motion/Embree geometries with time steps", timedGeometries);

void count(uint32_t mask, int64_t n) {
  switch (mask) {
    case kCameraRay:
      cameraRays += n;
      break;
    case kDiffuseRay:
      diffuseRays += n;
      break;
    case kSpecularRay:
      specularRays += n;
      break;
    default:
      transmissionRays += n;
      break;
  }
}

void count(std::span<const Ray> rays) {
  for (size_t begin = 0, end = 0; begin < rays.size(); begin = end) {
    while (end < rays.size() && rays[end].mask == rays[begin].mask) timedRays += rays[end++].time > 0;
    count(rays[begin].mask, static_cast<int64_t>(end - begin));
  }
}

RTCRayHit toEmbree(const Ray& ray, uint32_t id = 0) {
  RTCRayHit r;
  r.ray.org_x = ray.origin.x, r.ray.org_y = ray.origin.y, r.ray.org_z = ray.origin.z;
  r.ray.dir_x = ray.direction.x, r.ray.dir_y = ray.direction.y, r.ray.dir_z = ray.direction.z;
  r.ray.tnear = ray.tNear, r.ray.tfar = ray.tFar;
  r.ray.time = ray.time, r.ray.mask = ray.mask, r.ray.id = id, r.ray.flags = 0;
  r.hit.geomID = r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return r;
}

/// Hits in units name the traced surface from here on in place of an Embree geometry, and its face.
constexpr uint32_t kFirstTraced = 0x40000000;

struct UnitTracer final : Tessellation::Tracer {
  EmbreeScene scene;
  UnitTracer(RTCDevice device, const Geometry& geometry, uint32_t unit, const InstanceNumbers& instances)
      : scene(device, geometry, RTC_BUILD_QUALITY_MEDIUM, instances,
              {.segments = geometry.units()[unit].segments,
               .compact = !geometry.units()[unit].faces.empty(),
               .everyHit = geometry.units()[unit].solid == kNone ? nullptr : collectCrossings}) {}
};

const EmbreeScene& sceneOf(const Tessellation& tessellation) {
  return static_cast<const UnitTracer&>(*tessellation.tracer).scene;
}

/// A query's context, extended by the reader that keeps what it meets, and by what it leaves for later.
struct Context {
  RTCIntersectContext embree;
  TessellationCache::Reader* reader = nullptr;
  DeferredUnits* deferred = nullptr;  ///< null: what is not there is made at once
  explicit Context(TessellationCache::Reader* r, DeferredUnits* d = nullptr) : reader(r), deferred(d) {
    rtcInitIntersectContext(&embree);
  }
  /// Null: the ray will be tested against the unit later.
  const Tessellation* unit(uint32_t unit, const RTCRay& ray) {
    if (!deferred) return &reader->get(unit);
    const Tessellation* const known = reader->find(unit);
    if (!known) deferred->add(unit, ray, embree.instID[0]);
    return known;
  }
};

/// A ray against a unit that is there; a hit names the traced surface and its face.
bool intersectFacets(const Geometry& geometry, uint32_t unit, const Tessellation& met, Context& context,
                     RTCRayHit& ray) {
  const EmbreeScene& scene = sceneOf(met);
  const uint32_t solid = geometry.units()[unit].solid;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  FaceOwner owner;
  if (solid == kNone) {
    rtcIntersect1(scene.scene(), &context.embree, &ray);
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    owner = scene.ownerOf(ray.hit.geomID, ray.hit.primID, ray.hit.u, ray.hit.v);
  } else if (!intersectSolid(scene, solid, context.embree.instID[0], ray, owner)) {
    return false;
  }
  ray.hit.geomID = kFirstTraced + owner.traced;
  ray.hit.primID = owner.face;
  return true;
}

void occludeFacets(const Geometry& geometry, uint32_t unit, const Tessellation& met, Context& context,
                   RTCRay& ray) {
  const EmbreeScene& scene = sceneOf(met);
  const uint32_t solid = geometry.units()[unit].solid;
  if (solid == kNone)
    rtcOccluded1(scene.scene(), &context.embree, &ray);
  else
    occludeBySolid(scene, solid, context.embree.instID[0], ray);
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

/// The units of one group: the primitives of a user geometry.
struct UnitList {
  const Geometry* geometry = nullptr;
  std::vector<uint32_t> units;
  uint32_t segments = 0;    ///< time segments of all of them
  uint32_t mask = kAnyRay;  ///< the rays that meet them here
  bool frozen = false;      ///< units that move, as they are at the opening of the shutter
};

void boundUnit(const RTCBoundsFunctionArguments* args) {
  const auto& list = *static_cast<const UnitList*>(args->geometryUserPtr);
  const SurfaceUnit& unit = list.geometry->units()[list.units[args->primID]];
  const Box3f& box = list.segments > 0 ? unit.stepBounds[args->timeStep] : unit.bound;
  *args->bounds_o = {box.min.x, box.min.y, box.min.z, 0, box.max.x, box.max.y, box.max.z, 0};
}

void intersectUnit(const RTCIntersectFunctionNArguments* args) {
  const auto& list = *static_cast<const UnitList*>(args->geometryUserPtr);
  const uint32_t unit = list.units[args->primID];
  const uint32_t visibility = list.geometry->units()[unit].visibility & list.mask;
  Context& context = *reinterpret_cast<Context*>(args->context);
  for (unsigned k = 0; k < args->N; ++k) {
    if (args->valid[k] == 0) continue;
    if ((RTCRayN_mask(RTCRayHitN_RayN(args->rayhit, args->N), args->N, k) & visibility) == 0) continue;
    RTCRayHit ray = rtcGetRayHitFromRayHitN(args->rayhit, args->N, k);
    if (list.frozen) ray.ray.time = 0;
    const Tessellation* const met = context.unit(unit, ray.ray);
    if (!met || !intersectFacets(*list.geometry, unit, *met, context, ray)) continue;
    RTCRayN_tfar(RTCRayHitN_RayN(args->rayhit, args->N), args->N, k) = ray.ray.tfar;
    rtcCopyHitToHitN(RTCRayHitN_HitN(args->rayhit, args->N), &ray.hit, args->N, k);
  }
}

void occludeUnit(const RTCOccludedFunctionNArguments* args) {
  const auto& list = *static_cast<const UnitList*>(args->geometryUserPtr);
  const uint32_t unit = list.units[args->primID];
  const uint32_t visibility = list.geometry->units()[unit].visibility & list.mask;
  Context& context = *reinterpret_cast<Context*>(args->context);
  for (unsigned k = 0; k < args->N; ++k) {
    if (args->valid[k] == 0) continue;
    RTCRay ray = rtcGetRayFromRayN(args->ray, args->N, k);
    if ((ray.mask & visibility) == 0) continue;
    if (list.frozen) ray.time = 0;
    const Tessellation* const met = context.unit(unit, ray);
    if (!met) continue;
    occludeFacets(*list.geometry, unit, *met, context, ray);
    RTCRayN_tfar(args->ray, args->N, k) = ray.tfar;
  }
}

}  // namespace

struct Accel::Scenes {
  const Geometry* geometry = nullptr;
  RTCDevice device = nullptr;      ///< for what is traced from the beginning
  RTCDevice unitDevice = nullptr;  ///< for tessellated units: its bytes are counted
  std::atomic<int64_t> unitBytes = 0;
  std::unique_ptr<EmbreeScene> world;
  std::vector<std::unique_ptr<EmbreeScene>> objects;
  std::deque<UnitList> lists;
  std::vector<RTCGeometry> movingShapes;  ///< by Geometry::movements(); null = rays that move do not see it
  InstanceNumbers instanceNumbers;
  bool hasUnits = false;

  ~Scenes() {
    if (geometry) geometry->tessellations().clear();  // their tracers are of unitDevice
    world.reset();
    objects.clear();
    for (RTCGeometry shape : movingShapes)
      if (shape) rtcReleaseGeometry(shape);
    if (unitDevice) rtcReleaseDevice(unitDevice);
    if (device) rtcReleaseDevice(device);
  }
  /// `normal` is Embree's: in mesh space, the cross product of a facet's first two edges.
  Hit toHit(float t, float u, float v, uint32_t geomId, uint32_t primId, uint32_t instId, const V3f& normal,
            const Ray& ray) const {
    if (geomId == RTC_INVALID_GEOMETRY_ID) return {};
    const uint32_t instance = instanceNumbers.indexOf(instId);
    const bool isTwin = instance != kNone && instId != instanceNumbers.first + instance;
    const PlacedInstance* placed = instance == kNone ? nullptr : &geometry->instances()[instance];
    const FaceOwner owner = geomId >= kFirstTraced
                                ? FaceOwner{geomId - kFirstTraced, primId}
                                : (placed ? *objects[placed->object] : *world).owner(geomId, primId);
    const uint32_t index =
        placed ? placed->firstPlacement + owner.traced - geometry->groupRange(placed->object).first
               : owner.traced;
    V3f inWorld = placed ? transformNormal(normal, placed->worldToMesh) : normal;
    const Placement& placement = geometry->placements()[index];
    if (!placement.moves)
      return {t, index, owner.face, u, v, inWorld.dot(ray.direction) * placement.meshSign <= 0};
    if (placed && placed->movement != kNone && !isTwin && ray.time > 0)
      inWorld = transformNormal(normal, worldToMesh(placed->movement, ray.time));
    return {t,
            index,
            owner.face,
            u,
            v,
            inWorld.dot(ray.direction) * placement.meshSign <= 0,
            beyond(t, inWorld, ray, placed)};
  }
  /// Of an instance that moves, as Embree has it.
  M44f worldToMesh(uint32_t movement, float time) const {
    M44f toWorld;
    rtcGetGeometryTransform(movingShapes[movement], time, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR,
                            toWorld.getValue());
    return toWorld.inverse();
  }
  /// Behind the surface that was met at t by the error of the plane there and that of the new origin: see
  /// Geometry::facet.
  static float beyond(float t, const V3f& normal, const Ray& ray, const PlacedInstance* placed) {
    float magnitude = maxAbsComponent(ray.origin) + t * maxAbsComponent(ray.direction);
    if (placed)
      magnitude +=
          maxAbsComponent({placed->meshToWorld[3][0], placed->meshToWorld[3][1], placed->meshToWorld[3][2]});
    const float length = ray.direction.length();
    const float cosine = std::abs(normalizedOr(normal, V3f(0, 0, 0)).dot(ray.direction)) / length;
    return t + roundingBound(64) * magnitude / (length * std::max(cosine, 1.0f / 64));
  }
  Hit toHit(const RTCRayHit& r, const Ray& ray) const {
    return toHit(r.ray.tfar, r.hit.u, r.hit.v, r.hit.geomID, r.hit.primID, r.hit.instID[0],
                 {r.hit.Ng_x, r.hit.Ng_y, r.hit.Ng_z}, ray);
  }
  template <class Trace>
  void traceBatch(std::span<const Ray> rays, size_t step, std::span<Hit> hits, Trace trace) const;
  void resolve(std::span<const Ray> rays, std::span<Hit> hits, std::vector<uint32_t>& ties) const;
  void resolve(std::span<const Ray> rays, std::span<uint8_t> occluded) const;
  /// Batches leave units for later.
  bool defers() const { return hasUnits && geometry->tessellations().isTight(); }
  std::unique_ptr<EmbreeScene> makeGroup(uint32_t first, uint32_t end);
  void attachUnits(EmbreeScene& scene, UnitList list);
  void attachInstances();
  std::unique_ptr<Tessellation> tessellate(uint32_t unit) const;
  void trace(uint32_t unit, std::unique_ptr<Tessellation>& made) const;
  size_t guessBytes(uint32_t unit) const;
};

std::unique_ptr<EmbreeScene> Accel::Scenes::makeGroup(uint32_t first, uint32_t end) {
  auto scene = std::make_unique<EmbreeScene>(device, *geometry, RTC_BUILD_QUALITY_MEDIUM, instanceNumbers);
  UnitList list{geometry, {}};
  std::vector<uint32_t> moving;
  for (uint32_t k = first; k < end; ++k) {
    const TracedSurface& traced = geometry->traced()[k];
    if (traced.unit == kNone)
      scene->addFlat(k);
    else if (traced.member == 0)  // all members are of one group
      for (uint32_t c = 0; c < std::max(traced.chunks, 1u); ++c)
        (traced.segments > 0 ? moving : list.units).push_back(traced.unit + c);
  }
  scene->attach();
  attachUnits(*scene, std::move(list));
  // Units that move: with their motion for the camera's rays, as they are at the opening for others.
  std::map<uint32_t, std::array<UnitList, 3>> bySegments;
  for (const uint32_t unit : moving) {
    const SurfaceUnit& u = geometry->units()[unit];
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
      units.geometry = geometry, units.mask = kMasks[k], units.frozen = k == 2;
      units.segments = k == 2 ? 0 : segments;
      attachUnits(*scene, std::move(units));
    }
  return scene;
}

void Accel::Scenes::attachUnits(EmbreeScene& scene, UnitList list) {
  if (list.units.empty()) return;
  hasUnits = true;
  lists.push_back(std::move(list));
  RTCGeometry shape = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(shape, static_cast<unsigned>(lists.back().units.size()));
  rtcSetGeometryUserData(shape, &lists.back());
  if (lists.back().segments > 0) {
    rtcSetGeometryTimeStepCount(shape, lists.back().segments + 1);
    ++timedGeometries;
  }
  rtcSetGeometryBoundsFunction(shape, boundUnit, nullptr);
  rtcSetGeometryIntersectFunction(shape, intersectUnit);
  rtcSetGeometryOccludedFunction(shape, occludeUnit);
  rtcSetGeometryMask(shape, kAnyRay);
  rtcCommitGeometry(shape);
  rtcAttachGeometry(scene.scene(), shape);
  rtcReleaseGeometry(shape);
}

void Accel::Scenes::attachInstances() {
  const auto attach = [&](const PlacedInstance& instance, uint32_t mask, uint32_t id, const auto& setPlace) {
    RTCGeometry shape = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(shape, objects[instance.object]->scene());
    setPlace(shape);
    rtcSetGeometryMask(shape, mask);
    rtcCommitGeometry(shape);
    rtcAttachGeometryByID(world->scene(), shape, id);
    return shape;
  };
  const auto stillAt = [](const PlacedInstance& instance) {
    return [&](RTCGeometry shape) {
      rtcSetGeometryTimeStepCount(shape, 1);
      rtcSetGeometryTransform(shape, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, instance.meshToWorld.getValue());
    };
  };
  movingShapes.resize(geometry->movements().size());
  const auto& [first, count, ignored] = instanceNumbers;
  std::vector<uint32_t>& twins = instanceNumbers.twins;
  for (uint32_t k = 0; k < count; ++k) {
    const PlacedInstance& instance = geometry->instances()[k];
    if (instance.movement == kNone) {
      rtcReleaseGeometry(attach(instance, instance.visibility, first + k, stillAt(instance)));
      continue;
    }
    const InstanceMovement& movement = geometry->movements()[instance.movement];
    const uint32_t moving = movement.sampleMotion ? instance.visibility : instance.visibility & kCameraRay;
    if (moving != 0) {
      ++timedGeometries;
      movingShapes[instance.movement] =
          attach(instance, moving, first + k, [&](RTCGeometry shape) { setSteps(shape, movement.steps); });
    }
    if (const uint32_t rest = instance.visibility & ~moving; rest != 0) {
      twins.push_back(k);
      const auto id = first + count + static_cast<uint32_t>(twins.size()) - 1;
      rtcReleaseGeometry(attach(instance, rest, id, stillAt(instance)));
    }
  }
}

// Called from within a traversal: nothing may be thrown.
std::unique_ptr<Tessellation> Accel::Scenes::tessellate(uint32_t unit) const {
  try {
    return geometry->tessellate(unit);
  } catch (const std::exception& error) {
    return geometry->leaveOut(unit, error.what());
  }
}

// Embree takes about so many bytes for a facet of a grid and for a triangle or quad of its own while it
// builds, and half of them afterwards. Measured on grids of 1 to 256 facets; triangles: bench_dense.
size_t Accel::Scenes::guessBytes(uint32_t unit) const {
  constexpr size_t kGridFacet = 36, kFace = 120, kScene = 12288;
  try {
    const auto [facets, vertices, faces] = geometry->sizeOf(unit);
    return kScene + kGridFacet * facets + sizeof(V3f) * vertices + kFace * faces;
  } catch (const std::exception&) {
    return 0;  // making it will fail in the same way, and say so
  }
}

// Called from within a traversal: nothing may be thrown.
void Accel::Scenes::trace(uint32_t unit, std::unique_ptr<Tessellation>& made) const {
  std::string trouble;
  try {
    auto tracer = std::make_unique<UnitTracer>(unitDevice, *geometry, unit, instanceNumbers);
    const std::vector<uint32_t>& members = geometry->units()[unit].members;
    const std::span<const uint32_t> faces = geometry->units()[unit].faces;
    for (size_t m = 0; m < members.size(); ++m) {
      if (made->members[m].rates)
        tracer->scene.addFacets(members[m], made->members[m], *made);
      else if (!made->isLeftOut)
        tracer->scene.addFlat(members[m], faces);
    }
    tracer->scene.attach();
    rtcCommitScene(tracer->scene.scene());
    if (rtcGetDeviceError(unitDevice) != RTC_ERROR_NONE) trouble = "Embree has no memory for them";
    made->tracer = std::move(tracer);
  } catch (const std::exception& error) {
    trouble = error.what();
  }
  if (trouble.empty()) return;
  made = geometry->leaveOut(unit, trouble);
  auto tracer = std::make_unique<UnitTracer>(unitDevice, *geometry, unit, instanceNumbers);
  rtcCommitScene(tracer->scene.scene());
  made->tracer = std::move(tracer);
}

Accel::Accel(const Geometry& geometry) : scenes_(std::make_unique<Scenes>()) {
  Scenes& s = *scenes_;
  s.geometry = &geometry;
  s.device = rtcNewDevice(nullptr);
  s.unitDevice = rtcNewDevice(nullptr);
  if (!s.device || !s.unitDevice) throw std::runtime_error("Embree could not be started");
  geometry.tessellations().setMaker(
      {[&s](uint32_t unit) { return s.tessellate(unit); },
       [&s](uint32_t unit, std::unique_ptr<Tessellation>& made) { s.trace(unit, made); },
       [&s] { return static_cast<size_t>(std::max<int64_t>(s.unitBytes, 0)); },
       [&s](uint32_t unit) { return s.guessBytes(unit); }});
  rtcSetDeviceMemoryMonitorFunction(
      s.unitDevice,
      [](void* scenes, ssize_t bytes, bool) {
        auto& own = *static_cast<Scenes*>(scenes);
        own.unitBytes += bytes;
        if (bytes > 0) own.geometry->tessellations().notePeak();
        return true;
      },
      &s);

  uint32_t worldEnd = 0;
  while (worldEnd < geometry.traced().size() && geometry.traced()[worldEnd].group == kNone) ++worldEnd;
  s.world = s.makeGroup(0, worldEnd);
  s.instanceNumbers.first = s.world->geometries() + static_cast<uint32_t>(s.lists.size()) + 1;
  s.instanceNumbers.count = static_cast<uint32_t>(geometry.instances().size());
  s.objects.resize(geometry.groupCount());
  for (uint32_t object = 0; object < s.objects.size(); ++object) {
    const auto [first, end] = geometry.groupRange(object);
    if (first == end) continue;
    s.objects[object] = s.makeGroup(first, end);
    rtcCommitScene(s.objects[object]->scene());
  }
  s.attachInstances();
  rtcCommitScene(s.world->scene());
}

Accel::~Accel() = default;

Hit Accel::intersect(const Ray& ray) const {
  Hit hit;
  intersect({&ray, 1}, {&hit, 1});
  return hit;
}

bool Accel::occluded(const Ray& ray) const {
  uint8_t met;
  occluded({&ray, 1}, {&met, 1});
  return met != 0;
}

namespace {
/// Of the batch that a thread traces.
thread_local DeferredUnits deferredUnits;
}  // namespace

/// trace(k, context) traces the `step` rays from k on. Whether units are deferred makes no difference to what
/// is found: among surfaces at exactly the same distance the traversal chooses, so there it is repeated.
template <class Trace>
void Accel::Scenes::traceBatch(std::span<const Ray> rays, size_t step, std::span<Hit> hits,
                               Trace trace) const {
  if (!hasUnits) {
    Context context(nullptr);
    for (size_t k = 0; k < rays.size(); k += step) trace(k, context);
    return;
  }
  const auto traceNow = [&](size_t k, DeferredUnits* deferred) {
    TessellationCache::Reader reader(geometry->tessellations());
    Context context(&reader, deferred);
    trace(k, context);
  };
  if (!defers() || rays.size() == 1) {
    for (size_t k = 0; k < rays.size(); k += step) traceNow(k, nullptr);
    return;
  }
  thread_local std::vector<uint32_t> ties;
  ties.clear(), deferredUnits.begin(rays);
  for (size_t k = 0; k < rays.size(); k += step) {
    traceNow(k, &deferredUnits);
    if (deferredUnits.isFull()) resolve(rays, hits, ties);
  }
  resolve(rays, hits, ties);
  for (const uint32_t k : ties) traceNow(k / step * step, nullptr);
}

void Accel::Scenes::resolve(std::span<const Ray> rays, std::span<Hit> hits,
                            std::vector<uint32_t>& ties) const {
  deferredUnits.forEachUnit([&](std::span<const DeferredUnits::Meeting> meetings) {
    const uint32_t unit = meetings[0].unit;
    const auto reaches = [&](const DeferredUnits::Meeting& m) {
      return DeferredUnits::mayMeet(deferredUnits.localRay(m), geometry->units()[unit],
                                    std::min(hits[m.ray].t, rays[m.ray].tFar));
    };
    if (std::none_of(meetings.begin(), meetings.end(), reaches)) return;
    ++waitedUnits;
    waitedMeetings += static_cast<int64_t>(meetings.size());
    TessellationCache::Reader reader(geometry->tessellations());
    Context context(&reader);
    const Tessellation& met = reader.get(unit);
    for (const DeferredUnits::Meeting& m : meetings) {
      Hit& hit = hits[m.ray];
      if (!reaches(m)) continue;
      const DeferredUnits::LocalRay at = deferredUnits.localRay(m);
      RTCRayHit r = toEmbree(
          {at.origin, at.direction, at.tNear, std::min(hit.t, rays[m.ray].tFar), rays[m.ray].mask, at.time});
      context.embree.instID[0] = at.instance;
      if (!intersectFacets(*geometry, unit, met, context, r)) continue;
      if (hit.valid() && r.ray.tfar == hit.t)
        ties.push_back(m.ray);
      else
        hit = toHit(r, rays[m.ray]);
    }
  });
}

void Accel::Scenes::resolve(std::span<const Ray> rays, std::span<uint8_t> occluded) const {
  deferredUnits.forEachUnit([&](std::span<const DeferredUnits::Meeting> meetings) {
    const uint32_t unit = meetings[0].unit;
    const auto isOpen = [&](const DeferredUnits::Meeting& m) { return occluded[m.ray] == 0; };
    if (std::none_of(meetings.begin(), meetings.end(), isOpen)) return;
    ++waitedUnits;
    waitedMeetings += static_cast<int64_t>(meetings.size());
    TessellationCache::Reader reader(geometry->tessellations());
    Context context(&reader);
    const Tessellation& met = reader.get(unit);
    for (const DeferredUnits::Meeting& m : meetings) {
      if (!isOpen(m)) continue;
      const DeferredUnits::LocalRay at = deferredUnits.localRay(m);
      RTCRayHit r =
          toEmbree({at.origin, at.direction, at.tNear, rays[m.ray].tFar, rays[m.ray].mask, at.time});
      context.embree.instID[0] = at.instance;
      occludeFacets(*geometry, unit, met, context, r.ray);
      occluded[m.ray] = r.ray.tfar < 0;
    }
  });
}

void Accel::intersect(std::span<const Ray> rays, std::span<Hit> hits) const {
  count(rays);
  scenes_->traceBatch(rays, 1, hits, [&](size_t k, Context& context) {
    RTCRayHit r = toEmbree(rays[k], static_cast<uint32_t>(k));
    rtcIntersect1(scenes_->world->scene(), &context.embree, &r);
    hits[k] = scenes_->toHit(r, rays[k]);
  });
}

void Accel::occluded(std::span<const Ray> rays, std::span<uint8_t> occluded) const {
  count(rays);
  const Scenes& s = *scenes_;
  const bool defers = s.defers() && rays.size() > 1;
  const auto trace = [&](size_t k, TessellationCache::Reader* reader) {
    Context context(reader, defers ? &deferredUnits : nullptr);
    RTCRayHit r = toEmbree(rays[k], static_cast<uint32_t>(k));
    rtcOccluded1(s.world->scene(), &context.embree, &r.ray);
    occluded[k] = r.ray.tfar < 0;
  };
  deferredUnits.begin(rays);
  for (size_t k = 0; k < rays.size(); ++k) {
    if (!s.hasUnits) {
      trace(k, nullptr);
      continue;
    }
    {
      TessellationCache::Reader reader(s.geometry->tessellations());
      trace(k, &reader);
    }
    if (deferredUnits.isFull()) s.resolve(rays, occluded);
  }
  if (!deferredUnits.isEmpty()) s.resolve(rays, occluded);
}

void Accel::intersectMany(std::span<const Ray> rays, std::span<Hit> hits) const {
  count(rays);
  scenes_->traceBatch(rays, 16, hits, [&](size_t base, Context& context) {
    context.embree.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    alignas(64) int valid[16];
    RTCRayHit16 p;
    const size_t n = std::min<size_t>(16, rays.size() - base);
    for (size_t k = 0; k < 16; ++k) {
      const Ray& ray = rays[base + std::min(k, n - 1)];
      valid[k] = k < n ? -1 : 0;
      p.ray.org_x[k] = ray.origin.x, p.ray.org_y[k] = ray.origin.y, p.ray.org_z[k] = ray.origin.z;
      p.ray.dir_x[k] = ray.direction.x, p.ray.dir_y[k] = ray.direction.y, p.ray.dir_z[k] = ray.direction.z;
      p.ray.tnear[k] = ray.tNear, p.ray.tfar[k] = ray.tFar, p.ray.time[k] = ray.time;
      p.ray.mask[k] = k < n ? ray.mask : 0, p.ray.id[k] = static_cast<uint32_t>(base + k), p.ray.flags[k] = 0;
      p.hit.geomID[k] = p.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
    }
    // Lanes that are not valid come to user geometry all the same: those have no mask.
    rtcIntersect16(valid, scenes_->world->scene(), &context.embree, &p);
    for (size_t k = 0; k < n; ++k)
      hits[base + k] =
          scenes_->toHit(p.ray.tfar[k], p.hit.u[k], p.hit.v[k], p.hit.geomID[k], p.hit.primID[k],
                         p.hit.instID[0][k], {p.hit.Ng_x[k], p.hit.Ng_y[k], p.hit.Ng_z[k]}, rays[base + k]);
  });
}

V3f leave(const Facet& facet, const V3f& direction) {
  const float side = facet.N.dot(direction) < 0 ? -1.0f : 1.0f;
  const V3f offset = facet.N * (side * facet.error);
  V3f origin = facet.P + offset;
  // The addition rounds: take the next number away from the plane in every component that moved.
  for (int k = 0; k < 3; ++k) {
    if (offset[k] > 0) origin[k] = std::nextafter(origin[k], kInfinity);
    if (offset[k] < 0) origin[k] = std::nextafter(origin[k], -kInfinity);
  }
  return origin;
}

}  // namespace patina
