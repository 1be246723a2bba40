// SPDX-License-Identifier: Apache-2.0
// Embree scenes: one for the world, one per instanced object. Flat faces of all primitives share a few
// geometries, by shape, visibility and sidedness; every curved surface is a grid geometry.
#include "renderer/accel/accel.h"

#include <embree3/rtcore.h>
#include <tbb/parallel_for.h>

#include <map>
#include <stdexcept>

#include "renderer/base/statistics.h"

namespace patina {
namespace {

STAT_COUNTER("Rays/camera", cameraRays);
STAT_COUNTER("Rays/diffuse", diffuseRays);
STAT_COUNTER("Rays/specular", specularRays);
STAT_COUNTER("Rays/transmission", transmissionRays);

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

struct FaceOwner {
  uint32_t member;  ///< traced surface, relative to its group's first
  uint32_t face;
};

/// What an Embree geometry stands for.
struct GeometryRecord {
  std::vector<FaceOwner>
      owners;  ///< of a shared geometry, by primID; empty: `member`, and primID is the face
  uint32_t member = 0;
  uint32_t firstTraced = 0;  ///< of the group that members count from
  const Geometry* geometry = nullptr;
};

struct SceneRecord {
  RTCScene scene = nullptr;
  std::vector<std::unique_ptr<GeometryRecord>> records;  ///< by geomID
};

RTCRayHit toEmbree(const Ray& ray) {
  RTCRayHit r;
  r.ray.org_x = ray.origin.x, r.ray.org_y = ray.origin.y, r.ray.org_z = ray.origin.z;
  r.ray.dir_x = ray.direction.x, r.ray.dir_y = ray.direction.y, r.ray.dir_z = ray.direction.z;
  r.ray.tnear = ray.tNear, r.ray.tfar = ray.tFar;
  r.ray.time = 0, r.ray.mask = ray.mask, r.ray.id = 0, r.ray.flags = 0;
  r.hit.geomID = r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return r;
}

}  // namespace

struct Accel::Scenes {
  const Geometry* geometry = nullptr;
  RTCDevice device = nullptr;
  SceneRecord world;
  std::vector<SceneRecord> objects;
  std::vector<RTCScene> owned;
  uint32_t firstInstanceId = 0;

  ~Scenes() {
    for (RTCScene scene : owned) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }
  RTCScene makeScene() {
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
    owned.push_back(scene);
    return scene;
  }
  uint32_t placementOf(uint32_t instance, const GeometryRecord& record, uint32_t primitive) const {
    const uint32_t member = record.owners.empty() ? record.member : record.owners[primitive].member;
    return instance == kNone ? member : geometry->instances()[instance].firstPlacement + member;
  }
  /// `normal` is Embree's: in mesh space, the cross product of a facet's first two edges.
  Hit toHit(float t, float u, float v, uint32_t geomId, uint32_t primId, uint32_t instId, const V3f& normal,
            const V3f& direction) const {
    if (geomId == RTC_INVALID_GEOMETRY_ID) return {};
    const uint32_t instance = instId == RTC_INVALID_GEOMETRY_ID ? kNone : instId - firstInstanceId;
    const SceneRecord& scene = instance == kNone ? world : objects[geometry->instances()[instance].object];
    const GeometryRecord& record = *scene.records[geomId];
    const uint32_t index = placementOf(instance, record, primId);
    const Placement& placement = geometry->placements()[index];
    const V3f inWorld =
        instance == kNone ? normal : transformNormal(normal, geometry->instances()[instance].worldToMesh);
    return {t, index, record.owners.empty() ? primId : record.owners[primId].face,
            u, v,     inWorld.dot(direction) * placement.meshSign <= 0};
  }
  void addSurfaces(SceneRecord& record, uint32_t first, uint32_t end);
};

namespace {

/// RI Sides 1: only the outside of a surface is met.
void cullBackFaces(const RTCFilterFunctionNArguments* args) {
  const auto& record = *static_cast<const GeometryRecord*>(args->geometryUserPtr);
  for (unsigned k = 0; k < args->N; ++k) {
    if (args->valid[k] == 0) continue;
    const uint32_t primitive = RTCHitN_primID(args->hit, args->N, k);
    const uint32_t member = record.owners.empty() ? record.member : record.owners[primitive].member;
    const uint32_t face = record.owners.empty() ? primitive : record.owners[primitive].face;
    const TracedSurface& traced = record.geometry->traced()[record.firstTraced + member];
    const V2f uv(RTCHitN_u(args->hit, args->N, k), RTCHitN_v(args->hit, args->N, k));
    const V3f normal =
        transformNormal(traced.surface->evaluate(face, uv.x, uv.y).N, traced.toMesh.inverse()) *
        (traced.primitive->reversed ? -1.0f : 1.0f);
    const V3f direction(RTCRayN_dir_x(args->ray, args->N, k), RTCRayN_dir_y(args->ray, args->N, k),
                        RTCRayN_dir_z(args->ray, args->N, k));
    if (normal.dot(direction) >= 0) args->valid[k] = 0;
  }
}

}  // namespace

void Accel::Scenes::addSurfaces(SceneRecord& record, uint32_t first, uint32_t end) {
  struct Soup {
    std::vector<V3f> vertices;
    std::vector<uint32_t> indices;
    std::vector<FaceOwner> owners;
  };
  std::map<std::tuple<int, uint32_t, bool>, Soup> soups;
  const auto attach = [&](RTCGeometry shape, std::unique_ptr<GeometryRecord> data, uint32_t mask,
                          bool oneSided) {
    data->geometry = geometry;
    data->firstTraced = first;
    rtcSetGeometryMask(shape, mask);
    if (oneSided) {
      rtcSetGeometryUserData(shape, data.get());
      rtcSetGeometryIntersectFilterFunction(shape, cullBackFaces);
      rtcSetGeometryOccludedFilterFunction(shape, cullBackFaces);
    }
    rtcCommitGeometry(shape);
    const unsigned id = rtcAttachGeometry(record.scene, shape);
    rtcReleaseGeometry(shape);
    if (record.records.size() <= id) record.records.resize(id + 1);
    record.records[id] = std::move(data);
  };

  for (uint32_t k = first; k < end; ++k) {
    const TracedSurface& traced = geometry->traced()[k];
    const uint32_t attributeIndex = traced.primitive->attributes;
    const Attributes* attributes =
        attributeIndex == kNone ? nullptr : &geometry->scene().attributes[attributeIndex];
    const uint32_t mask = attributes ? attributes->visibility : uint32_t{kAnyRay};
    const bool oneSided = attributes && attributes->oneSided;
    const uint32_t faces = traced.surface->faceCount();
    if (traced.cells == 0) {
      for (uint32_t face = 0; face < faces; ++face) {
        const bool quad = traced.surface->faceShape(face) == FaceShape::Quad;
        Soup& soup = soups[{quad ? 4 : 3, mask, oneSided}];
        V3f c[4];
        traced.surface->corners(face, c);
        const auto base = static_cast<uint32_t>(soup.vertices.size());
        for (int i = 0; i < (quad ? 4 : 3); ++i) soup.vertices.push_back(transformPoint(c[i], traced.toMesh));
        if (quad)
          soup.indices.insert(soup.indices.end(), {base, base + 1, base + 3, base + 2});
        else
          soup.indices.insert(soup.indices.end(), {base, base + 1, base + 2});
        soup.owners.push_back({k - first, face});
      }
      continue;
    }
    RTCGeometry shape = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_GRID);
    const uint32_t row = traced.cells + 1;
    rtcSetSharedGeometryBuffer(shape, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, traced.grid.data(), 0,
                               sizeof(V3f), traced.grid.size());
    auto* grids = static_cast<RTCGrid*>(
        rtcSetNewGeometryBuffer(shape, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, sizeof(RTCGrid), faces));
    for (uint32_t face = 0; face < faces; ++face)
      grids[face] = {face * row * row, row, static_cast<uint16_t>(row), static_cast<uint16_t>(row)};
    auto data = std::make_unique<GeometryRecord>();
    data->member = k - first;
    attach(shape, std::move(data), mask, oneSided);
  }
  for (auto& [key, soup] : soups) {
    const auto [corners, mask, oneSided] = key;
    RTCGeometry shape =
        rtcNewGeometry(device, corners == 4 ? RTC_GEOMETRY_TYPE_QUAD : RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<V3f*>(rtcSetNewGeometryBuffer(
        shape, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(V3f), soup.vertices.size()));
    std::copy(soup.vertices.begin(), soup.vertices.end(), vertices);
    auto* indices = static_cast<uint32_t*>(rtcSetNewGeometryBuffer(
        shape, RTC_BUFFER_TYPE_INDEX, 0, corners == 4 ? RTC_FORMAT_UINT4 : RTC_FORMAT_UINT3,
        sizeof(uint32_t) * static_cast<size_t>(corners), soup.owners.size()));
    std::copy(soup.indices.begin(), soup.indices.end(), indices);
    auto data = std::make_unique<GeometryRecord>();
    data->owners = std::move(soup.owners);
    soup = {};
    attach(shape, std::move(data), mask, oneSided);
  }
}

Accel::Accel(const Geometry& geometry) : scenes_(std::make_unique<Scenes>()) {
  Scenes& s = *scenes_;
  s.geometry = &geometry;
  s.device = rtcNewDevice(nullptr);
  if (!s.device) throw std::runtime_error("Embree could not be started");
  s.objects.resize(geometry.scene().objects.size());
  s.world.scene = s.makeScene();
  uint32_t worldEnd = 0;
  while (worldEnd < geometry.traced().size() && geometry.traced()[worldEnd].group == kNone) ++worldEnd;
  s.addSurfaces(s.world, 0, worldEnd);
  for (uint32_t object = 0; object < s.objects.size(); ++object) {
    const auto [first, end] = geometry.groupRange(object);
    if (first == end) continue;
    s.objects[object].scene = s.makeScene();
    s.addSurfaces(s.objects[object], first, end);
    rtcCommitScene(s.objects[object].scene);
  }
  s.firstInstanceId = static_cast<uint32_t>(s.world.records.size());
  for (uint32_t k = 0; k < geometry.instances().size(); ++k) {
    const PlacedInstance& instance = geometry.instances()[k];
    RTCGeometry shape = rtcNewGeometry(s.device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(shape, s.objects[instance.object].scene);
    rtcSetGeometryTimeStepCount(shape, 1);
    rtcSetGeometryTransform(shape, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, instance.meshToWorld.getValue());
    rtcSetGeometryMask(shape, instance.visibility);
    rtcCommitGeometry(shape);
    rtcAttachGeometryByID(s.world.scene, shape, s.firstInstanceId + k);
    rtcReleaseGeometry(shape);
  }
  rtcCommitScene(s.world.scene);
}

Accel::~Accel() = default;

Hit Accel::intersect(const Ray& ray) const {
  count(ray.mask, 1);
  RTCRayHit r = toEmbree(ray);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scenes_->world.scene, &context, &r);
  return scenes_->toHit(r.ray.tfar, r.hit.u, r.hit.v, r.hit.geomID, r.hit.primID, r.hit.instID[0],
                        {r.hit.Ng_x, r.hit.Ng_y, r.hit.Ng_z}, ray.direction);
}

bool Accel::occluded(const Ray& ray) const {
  count(ray.mask, 1);
  RTCRayHit r = toEmbree(ray);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scenes_->world.scene, &context, &r.ray);
  return r.ray.tfar < 0;
}

void Accel::intersectMany(std::span<const Ray> rays, std::span<Hit> hits) const {
  if (rays.empty()) return;
  count(rays[0].mask, static_cast<int64_t>(rays.size()));
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  alignas(64) int valid[16];
  RTCRayHit16 p;
  for (size_t base = 0; base < rays.size(); base += 16) {
    const size_t n = std::min<size_t>(16, rays.size() - base);
    for (size_t k = 0; k < 16; ++k) {
      const Ray& ray = rays[base + std::min(k, n - 1)];
      valid[k] = k < n ? -1 : 0;
      p.ray.org_x[k] = ray.origin.x, p.ray.org_y[k] = ray.origin.y, p.ray.org_z[k] = ray.origin.z;
      p.ray.dir_x[k] = ray.direction.x, p.ray.dir_y[k] = ray.direction.y, p.ray.dir_z[k] = ray.direction.z;
      p.ray.tnear[k] = ray.tNear, p.ray.tfar[k] = ray.tFar, p.ray.time[k] = 0;
      p.ray.mask[k] = ray.mask, p.ray.id[k] = 0, p.ray.flags[k] = 0;
      p.hit.geomID[k] = p.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect16(valid, scenes_->world.scene, &context, &p);
    for (size_t k = 0; k < n; ++k)
      hits[base + k] = scenes_->toHit(p.ray.tfar[k], p.hit.u[k], p.hit.v[k], p.hit.geomID[k], p.hit.primID[k],
                                      p.hit.instID[0][k], {p.hit.Ng_x[k], p.hit.Ng_y[k], p.hit.Ng_z[k]},
                                      rays[base + k].direction);
  }
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
