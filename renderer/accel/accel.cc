// SPDX-License-Identifier: Apache-2.0
// Rays in, hits out; and the Embree scenes of units, which are made when rays meet them.
#include "renderer/accel/accel.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <limits>
#include <stdexcept>

#include "renderer/accel/deferred_units.h"
#include "renderer/accel/part_tracer.h"
#include "renderer/base/statistics.h"

namespace patina {
namespace {

STAT_TIME("Time of threads/rays", rayTime);
STAT_TIME("Time of threads/facets and their BVHs, made on demand", makingTime);
STAT_COUNTER("Rays/camera", cameraRays);
STAT_COUNTER("Rays/diffuse", diffuseRays);
STAT_COUNTER("Rays/specular", specularRays);
STAT_COUNTER("Rays/transmission", transmissionRays);
STAT_COUNTER("Rays/with a time", timedRays);
STAT_COUNTER("Rays/that cannot be traced: beyond 1e18, or that in an instance's space", lostRays);
STAT_COUNTER("Rays/units waited for by batches", waitedUnits);
STAT_COUNTER("Rays/meetings that waited", waitedMeetings);
STAT_COUNTER("Geometry/units moved into the scene's own structure", settledUnits);

bool canTrace(const PartTracer& part, const Ray& ray) {
  return part.traces(ray.origin, ray.direction, ray.tNear, ray.tFar);
}

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

}  // namespace

struct Accel::Scenes {
  const Geometry* geometry = nullptr;
  RTCDevice device = nullptr;          ///< for what is traced from the beginning
  RTCDevice unitDevice = nullptr;      ///< for tessellated units: its bytes are counted
  std::atomic<int64_t> unitBytes = 0;  ///< Embree's, for units
  std::atomic<int64_t> mainBytes = 0;  ///< Embree's, for `main`
  int64_t settledBytes = 0;            ///< of mainBytes, for units that have settled
  std::unique_ptr<PartTracer> main;
  uint32_t mainUnits = 0;  ///< units from here on are of delayed archives
  bool hasUnits = false;   ///< or delayed archives: queries need a Reader
  Handover begun;          ///< to Embree's threads, which count its bytes

  ~Scenes() {
    main.reset();  // may view vertices of tessellations
    if (geometry) {
      geometry->tessellations().clear();  // their tracers are of unitDevice
      geometry->dropTracers();            // of `device`
    }
    if (unitDevice) rtcReleaseDevice(unitDevice);
    if (device) rtcReleaseDevice(device);
  }
  /// `normal` is Embree's: in mesh space, the cross product of a facet's first two edges. `part`: whose
  /// numbers the hit has, unless they are Geometry's already.
  Hit toHit(float t, float u, float v, uint32_t geomId, uint32_t primId, uint32_t instId, const V3f& normal,
            const Ray& ray, const PartTracer& part) const {
    if (geomId == RTC_INVALID_GEOMETRY_ID) return {};
    const MetFace met = geomId >= kFirstResolved ? MetFace{geomId - kFirstResolved, primId, instId, normal}
                                                 : part.met(geomId, primId, instId, normal, ray.time, u, v);
    const Placement& placement = geometry->placements()[met.placement];
    const bool front = met.normal.dot(ray.direction) * placement.meshSign <= 0;
    if (!placement.moves) return {t, met.placement, met.face, u, v, front};
    const PlacedInstance* placed = met.instance == kNone ? nullptr : &geometry->instances()[met.instance];
    return {t, met.placement, met.face, u, v, front, beyond(t, met.normal, ray, placed)};
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
  Hit toHit(const RTCRayHit& r, const Ray& ray, const PartTracer& part) const {
    return toHit(r.ray.tfar, r.hit.u, r.hit.v, r.hit.geomID, r.hit.primID, r.hit.instID[0],
                 {r.hit.Ng_x, r.hit.Ng_y, r.hit.Ng_z}, ray, part);
  }
  template <class Trace>
  void traceBatch(std::span<const Ray> rays, size_t step, std::span<Hit> hits, Trace trace) const;
  void resolve(std::span<const Ray> rays, std::span<Hit> hits, std::vector<uint32_t>& ties) const;
  void resolve(std::span<const Ray> rays, std::span<uint8_t> occluded) const;
  /// Batches leave units for later.
  bool defers() const { return hasUnits && geometry->tessellations().isTight(); }
  std::unique_ptr<Tessellation> tessellate(uint32_t unit) const;
  void trace(uint32_t unit, std::unique_ptr<Tessellation>& made) const;
  size_t guessBytes(uint32_t unit) const;
};

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
    auto tracer = std::make_unique<UnitTracer>(unitDevice, *geometry, unit);
    tracer->scene.addUnit(unit, *made);
    rtcCommitScene(tracer->scene.scene());
    if (rtcGetDeviceError(unitDevice) != RTC_ERROR_NONE) trouble = "Embree has no memory for them";
    made->tracer = std::move(tracer);
  } catch (const std::exception& error) {
    trouble = error.what();
  }
  if (trouble.empty()) return;
  made = geometry->leaveOut(unit, trouble);
  auto tracer = std::make_unique<UnitTracer>(unitDevice, *geometry, unit);
  rtcCommitScene(tracer->scene.scene());
  made->tracer = std::move(tracer);
}

Accel::Accel(const Geometry& geometry) : scenes_(std::make_unique<Scenes>()) {
  Scenes& s = *scenes_;
  s.geometry = &geometry;
  s.device = rtcNewDevice(nullptr);
  s.unitDevice = rtcNewDevice(nullptr);
  if (!s.device || !s.unitDevice) throw std::runtime_error("Embree could not be started");
  geometry.tessellations().setMaker({[&s](uint32_t unit) {
                                       const TimeShare share(makingTime);
                                       return s.tessellate(unit);
                                     },
                                     [&s](uint32_t unit, std::unique_ptr<Tessellation>& made) {
                                       const TimeShare share(makingTime);
                                       s.trace(unit, made);
                                     },
                                     [&s] {
                                       const int64_t bytes = s.unitBytes + s.settledBytes;
                                       return static_cast<size_t>(std::max<int64_t>(bytes, 0));
                                     },
                                     [&s](uint32_t unit) { return s.guessBytes(unit); }});
  s.begun.give();
  rtcSetDeviceMemoryMonitorFunction(
      s.unitDevice,
      [](void* scenes, ssize_t bytes, bool) {
        auto& own = *static_cast<Scenes*>(scenes);
        own.begun.take();
        own.unitBytes += bytes;
        if (bytes > 0) own.geometry->tessellations().notePeak();
        return true;
      },
      &s);
  rtcSetDeviceMemoryMonitorFunction(
      s.device,
      [](void* scenes, ssize_t bytes, bool) {
        auto& own = *static_cast<Scenes*>(scenes);
        own.begun.take();
        own.mainBytes += bytes;
        return true;
      },
      &s);

  s.main = std::make_unique<PartTracer>(s.device, geometry, geometry.mainPart());
  s.mainUnits = static_cast<uint32_t>(geometry.units().size());
  s.hasUnits = s.main->hasUnits() || geometry.hasDelayed();
  geometry.setTracerMaker([&s](const GeometryPart& part) -> std::unique_ptr<GeometryPart::Tracer> {
    auto tracer = std::make_unique<PartTracer>(s.device, *s.geometry, part);
    if (rtcGetDeviceError(s.device) != RTC_ERROR_NONE)
      throw std::runtime_error("Embree has no memory for it");
    return tracer;
  });
}

Accel::~Accel() = default;

void Accel::settle() {
  Scenes& s = *scenes_;
  const Geometry& geometry = *s.geometry;
  const TessellationCache& cache = geometry.tessellations();
  if (cache.isTight()) return;
  const PhaseTimer timer("Acceleration structures");
  std::vector<std::pair<size_t, uint32_t>> bySize;
  for (uint32_t k = 0; k < s.mainUnits; ++k) {
    const SurfaceUnit& unit = geometry.units()[k];
    const Tessellation* const made = cache.resident(k);
    if (made && made->tracer && !made->isLeftOut && unit.segments == 0 && unit.solid == kNone)
      bySize.emplace_back(s.guessBytes(k), k);
  }
  std::sort(bySize.begin(), bySize.end());
  std::vector<uint32_t> settled;
  std::vector<bool> native(s.mainUnits);
  for (size_t sum = 0; const auto& [bytes, unit] : bySize) {
    if ((sum += bytes) > cache.budget() / 2) break;
    settled.push_back(unit), native[unit] = true;
  }
  if (settled.empty()) return;
  const int64_t before = s.mainBytes;
  s.main.reset();
  cache.pin(settled);
  s.main = std::make_unique<PartTracer>(s.device, geometry, geometry.mainPart(), native);
  if (rtcGetDeviceError(s.device) != RTC_ERROR_NONE)
    throw std::runtime_error("Embree has no memory for the facets");
  s.settledBytes = std::max<int64_t>(0, s.mainBytes - before);
  cache.notePeak();
  s.hasUnits = s.main->hasUnits() || geometry.hasDelayed();
  settledUnits += static_cast<int64_t>(settled.size());
}

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
    QueryContext context(nullptr, *main);
    for (size_t k = 0; k < rays.size(); k += step) trace(k, context);
    return;
  }
  const auto traceNow = [&](size_t k, DeferredUnits* deferred) {
    TessellationCache::Reader reader(geometry->tessellations());
    QueryContext context(&reader, *main, deferred);
    trace(k, context);
  };
  if (!defers() || rays.size() == 1) {
    for (size_t k = 0; k < rays.size(); k += step) traceNow(k, nullptr);
    return;
  }
  thread_local std::vector<uint32_t> ties;
  ties.clear(), deferredUnits.begin(rays, *main);
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
    QueryContext context(&reader, *main);
    const Tessellation& met = reader.get(unit);
    for (const DeferredUnits::Meeting& m : meetings) {
      Hit& hit = hits[m.ray];
      if (!reaches(m)) continue;
      const DeferredUnits::LocalRay at = deferredUnits.localRay(m);
      RTCRayHit r = toEmbree({at.origin, at.direction, at.tNear, std::min({hit.t, at.tFar, rays[m.ray].tFar}),
                              rays[m.ray].mask, at.time});
      context.embree.instID[0] = at.instance;
      context.part = at.part;
      if (!intersectFacets(*geometry, unit, met, context, r)) continue;
      if (hit.valid() && r.ray.tfar == hit.t)
        ties.push_back(m.ray);
      else
        hit = toHit(r, rays[m.ray], *at.part);
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
    QueryContext context(&reader, *main);
    const Tessellation& met = reader.get(unit);
    for (const DeferredUnits::Meeting& m : meetings) {
      if (!isOpen(m)) continue;
      const DeferredUnits::LocalRay at = deferredUnits.localRay(m);
      RTCRayHit r = toEmbree({at.origin, at.direction, at.tNear, std::min(at.tFar, rays[m.ray].tFar),
                              rays[m.ray].mask, at.time});
      context.embree.instID[0] = at.instance;
      context.part = at.part;
      occludeFacets(*geometry, unit, met, context, r.ray);
      occluded[m.ray] = r.ray.tfar < 0;
    }
  });
}

void Accel::intersect(std::span<const Ray> rays, std::span<Hit> hits) const {
  const TimeShare share(rayTime);
  count(rays);
  scenes_->traceBatch(rays, 1, hits, [&](size_t k, QueryContext& context) {
    if (!canTrace(*scenes_->main, rays[k])) {
      ++lostRays, hits[k] = {};
      return;
    }
    RTCRayHit r = toEmbree(rays[k], static_cast<uint32_t>(k));
    rtcIntersect1(scenes_->main->scene(), &context.embree, &r);
    hits[k] = scenes_->toHit(r, rays[k], *scenes_->main);
  });
}

void Accel::occluded(std::span<const Ray> rays, std::span<uint8_t> occluded) const {
  const TimeShare share(rayTime);
  count(rays);
  const Scenes& s = *scenes_;
  const bool defers = s.defers() && rays.size() > 1;
  const auto trace = [&](size_t k, TessellationCache::Reader* reader) {
    if (!canTrace(*s.main, rays[k])) {
      ++lostRays, occluded[k] = false;
      return;
    }
    QueryContext context(reader, *s.main, defers ? &deferredUnits : nullptr);
    RTCRayHit r = toEmbree(rays[k], static_cast<uint32_t>(k));
    rtcOccluded1(s.main->scene(), &context.embree, &r.ray);
    occluded[k] = r.ray.tfar < 0;
  };
  deferredUnits.begin(rays, *s.main);
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
  const TimeShare share(rayTime);
  count(rays);
  scenes_->traceBatch(rays, 16, hits, [&](size_t base, QueryContext& context) {
    context.embree.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    alignas(64) int valid[16];
    RTCRayHit16 p;
    const size_t n = std::min<size_t>(16, rays.size() - base);
    for (size_t k = 0; k < 16; ++k) {
      const Ray& given = rays[base + std::min(k, n - 1)];
      static constexpr Ray kNowhere{};  // Embree looks at lanes that are not valid, too
      const bool traced = canTrace(*scenes_->main, given);
      const Ray& ray = traced ? given : kNowhere;
      lostRays += k < n && !traced;
      valid[k] = k < n && traced ? -1 : 0;
      p.ray.org_x[k] = ray.origin.x, p.ray.org_y[k] = ray.origin.y, p.ray.org_z[k] = ray.origin.z;
      p.ray.dir_x[k] = ray.direction.x, p.ray.dir_y[k] = ray.direction.y, p.ray.dir_z[k] = ray.direction.z;
      p.ray.tnear[k] = ray.tNear, p.ray.tfar[k] = ray.tFar, p.ray.time[k] = ray.time;
      p.ray.mask[k] = valid[k] != 0 ? ray.mask : 0, p.ray.id[k] = static_cast<uint32_t>(base + k),
      p.ray.flags[k] = 0;
      p.hit.geomID[k] = p.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
    }
    // Lanes that are not valid come to user geometry all the same: those have no mask.
    rtcIntersect16(valid, scenes_->main->scene(), &context.embree, &p);
    for (size_t k = 0; k < n; ++k)
      hits[base + k] = scenes_->toHit(p.ray.tfar[k], p.hit.u[k], p.hit.v[k], p.hit.geomID[k], p.hit.primID[k],
                                      p.hit.instID[0][k], {p.hit.Ng_x[k], p.hit.Ng_y[k], p.hit.Ng_z[k]},
                                      rays[base + k], *scenes_->main);
  });
}

namespace {
/// The next finite or infinite number above or below `x`, as std::nextafter, which is a call.
float nextBeside(float x, bool above) {
  if (!std::isfinite(x)) return x;
  if (x == 0) return std::copysign(std::numeric_limits<float>::denorm_min(), above ? 1.0f : -1.0f);
  // The bits of floats of one sign are in the order of their magnitudes.
  const auto bits = std::bit_cast<uint32_t>(x);
  const bool grows = ((bits >> 31) ^ uint32_t{above}) != 0;
  return std::bit_cast<float>(bits + 2 * uint32_t{grows} - 1);
}
}  // namespace

V3f leave(const Facet& facet, const V3f& direction) {
  const float side = facet.N.dot(direction) < 0 ? -1.0f : 1.0f;
  const V3f offset = facet.N * (side * facet.error);
  V3f origin = facet.P + offset;
  // The addition rounds: take the next number away from the plane in every component that moved.
  for (int k = 0; k < 3; ++k) {
    const float next = nextBeside(origin[k], offset[k] > 0);
    origin[k] = offset[k] != 0 ? next : origin[k];
  }
  return origin;
}

}  // namespace patina
