// SPDX-License-Identifier: Apache-2.0
// Surfaces as Embree geometries.
#include "renderer/accel/embree_scene.h"

#include <bit>

#include "renderer/accel/part_tracer.h"

namespace patina {
namespace {

/// Where the points of a surface are among an Embree geometry's vertices: an open hash table.
class VertexMap {
 public:
  /// For the points of so many faces.
  explicit VertexMap(size_t faces) : slots_(faces ? std::bit_ceil(2 * faces) : 0) {}
  /// The vertex of a point; `next` if the point is new, and then that is its vertex.
  uint32_t find(uint32_t point, uint32_t next) {
    if (2 * used_ >= slots_.size()) grow();
    Slot& slot = slotOf(point);
    if (slot.vertex == kNone) slot = {point, next}, ++used_;
    return slot.vertex;
  }

 private:
  struct Slot {
    uint32_t point = kNone, vertex = kNone;
  };
  Slot& slotOf(uint32_t point) {
    constexpr uint32_t kGoldenRatio = 2654435769;  // multiplicative hashing (Knuth, vol. 3, section 6.4)
    size_t k = (point * kGoldenRatio >> 7) & (slots_.size() - 1);
    while (slots_[k].vertex != kNone && slots_[k].point != point) k = (k + 1) & (slots_.size() - 1);
    return slots_[k];
  }
  void grow() {
    std::vector<Slot> old(std::max<size_t>(64, 2 * slots_.size()));
    old.swap(slots_);
    for (const Slot& slot : old)
      if (slot.vertex != kNone) slotOf(slot.point) = slot;
  }

  std::vector<Slot> slots_;
  size_t used_ = 0;
};

}  // namespace

EmbreeScene::EmbreeScene(RTCDevice device, const Geometry& geometry, RTCBuildQuality quality,
                         const Kinds& kinds)
    : device_(device),
      geometry_(geometry),
      everyHit_(kinds.everyHit),
      scene_(rtcNewScene(device)),
      segments_(kinds.segments) {
  rtcSetSceneFlags(scene_,
                   kinds.compact ? RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_COMPACT : RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene_, quality);
}

EmbreeScene::~EmbreeScene() { rtcReleaseScene(scene_); }

EmbreeScene::Part& EmbreeScene::part(uint32_t traced, Kind kind) {
  const Attributes* own = everyHit_ ? nullptr : geometry_.attributes(geometry_.traced()[traced]);
  const bool oneSided = !everyHit_ && geometry_.maybeOneSided(geometry_.traced()[traced]),
             hasHoles = geometry_.surface(traced).hasHoles();
  std::unique_ptr<Part>& part = open_[{kind, own ? own->visibility : uint32_t{kAnyRay}, oneSided, hasHoles}];
  if (!part) {
    part = std::make_unique<Part>();
    part->scene = this, part->oneSided = oneSided, part->hasHoles = hasHoles;
    part->laterVertices.resize(segments_);
  }
  return *part;
}

void EmbreeScene::addFlat(uint32_t traced, std::span<const uint32_t> faces) {
  const Surface& surface = geometry_.surface(traced);
  const M44f& toMesh = geometry_.traced()[traced].toMesh;
  // What moves has its points apart, at every step alike.
  const PointView points = segments_ > 0 ? PointView() : surface.sharedPoints();
  const auto count = static_cast<uint32_t>(faces.empty() ? surface.faceCount() : faces.size());
  const auto faceAt = [&](uint32_t k) { return faces.empty() ? k : faces[k]; };
  const auto isQuad = [&](uint32_t k) { return surface.faceShape(faceAt(k)) == FaceShape::Quad; };
  const auto partOf = [&](bool quad) { return &part(traced, quad ? Kind::Quads : Kind::Triangles); };
  Part* parts[2] = {};
  VertexMap known[2] = {VertexMap(points.size() > 0 ? count : 0), VertexMap(0)};
  bool alike = !faces.empty();
  for (uint32_t k = 1; k < count && alike; ++k) alike = isQuad(k) == isQuad(0);
  for (uint32_t k = 0; k < count; ++k) {
    const bool quad = isQuad(k);
    Part*& to = parts[quad];
    if (!to) to = partOf(quad);
    V3f c[4];
    uint32_t at[4], index[4];
    surface.corners(faceAt(k), c);
    if (points.size() > 0) surface.cornerPoints(faceAt(k), at);
    for (int i = 0; i < (quad ? 4 : 3); ++i) {
      const auto next = static_cast<uint32_t>(to->vertices.size());
      index[i] = points.size() > 0 ? known[quad].find(at[i], next) : next;
      if (index[i] == next) to->vertices.push_back(transformPoint(c[i], toMesh));
    }
    if (quad)
      to->indices.insert(to->indices.end(), {index[0], index[1], index[3], index[2]});
    else
      to->indices.insert(to->indices.end(), {index[0], index[1], index[2]});
    if (!alike) to->owners.push_back({traced, faceAt(k)});
  }
  if (alike && count > 0) parts[isQuad(0)]->traced = traced, parts[isQuad(0)]->faces = faces;
  for (uint32_t step = 1; step <= segments_; ++step) {
    const PosedSurface posed = geometry_.posed(traced, step);
    const Surface& at = posed.surface ? *posed.surface : surface;
    const M44f place = geometry_.toMeshAt(traced, step);
    for (uint32_t face = 0; face < surface.faceCount(); ++face) {
      const bool quad = surface.faceShape(face) == FaceShape::Quad;
      V3f c[4];
      at.corners(face, c);
      std::vector<V3f>& vertices = part(traced, quad ? Kind::Quads : Kind::Triangles).laterVertices[step - 1];
      for (int i = 0; i < (quad ? 4 : 3); ++i) vertices.push_back(transformPoint(c[i], place));
    }
  }
}

void EmbreeScene::addFacets(uint32_t traced, const Tessellation::Member& member,
                            const Tessellation& tessellation) {
  const Surface& surface = geometry_.surface(traced);
  Part& to = part(traced, Kind::Grids);
  to.shared = tessellation.vertices;
  if (segments_ > 0) to.shared = to.shared.first(to.stride = tessellation.stride);
  const SurfaceRates& rates = *member.rates;
  for (uint32_t tile = 0; tile < rates.tiles.size(); ++tile) {
    const TileRates& r = rates.tiles[tile];
    const auto row = static_cast<uint16_t>(r.cellsU() + 1);
    to.grids.push_back(
        {tessellation.first[member.firstTile + tile], row, row, static_cast<uint16_t>(r.cellsV() + 1)});
    to.owners.push_back({traced, tile});
    const bool thinned = r.isThinned(0) || r.isThinned(1) || r.isThinned(2) || r.isThinned(3);
    if (rates.tiling > 0 || thinned || surface.faceShape(rates.faceOf(tile)) != FaceShape::Quad) {
      to.rates.resize(to.owners.size());
      to.rates.back() = &rates;
    }
  }
}

void EmbreeScene::addUnit(uint32_t index, const Tessellation& tessellation) {
  const SurfaceUnit& unit = geometry_.units()[index];
  for (size_t m = 0; m < unit.members.size(); ++m) {
    if (tessellation.members[m].rates)
      addFacets(unit.members[m], tessellation.members[m], tessellation);
    else if (!tessellation.isLeftOut)
      addFlat(unit.members[m], unit.faces);
  }
  attach();
}

FaceOwner EmbreeScene::ownerOf(const Part& part, uint32_t primitive, float& u, float& v) {
  FaceOwner owner = part.owner(primitive);
  if (primitive >= part.rates.size() || !part.rates[primitive]) return owner;
  const SurfaceRates& rates = *part.rates[primitive];
  const uint32_t face = rates.faceOf(owner.face);
  const V2f uv = tileToFace(rates, part.scene->geometry_.surface(owner.traced).faceShape(face), owner.face,
                            gridToTile(rates.tiles[owner.face], {u, v}));
  u = uv.x, v = uv.y;
  owner.face = face;
  return owner;
}

void EmbreeScene::attach() {
  for (auto& [key, part] : open_) {
    RTCGeometry shape;
    if (key.kind == Kind::Grids) {
      shape = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_GRID);
      if (segments_ > 0) rtcSetGeometryTimeStepCount(shape, segments_ + 1);
      for (uint32_t step = 1; step <= segments_; ++step)
        rtcSetSharedGeometryBuffer(shape, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT3,
                                   part->shared.data() + step * part->stride, 0, sizeof(V3f),
                                   part->shared.size());
      rtcSetSharedGeometryBuffer(shape, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, part->shared.data(), 0,
                                 sizeof(V3f), part->shared.size());
      auto* grids = static_cast<RTCGrid*>(rtcSetNewGeometryBuffer(
          shape, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, sizeof(RTCGrid), part->grids.size()));
      std::copy(part->grids.begin(), part->grids.end(), grids);
    } else {
      const bool quads = key.kind == Kind::Quads;
      shape = rtcNewGeometry(device_, quads ? RTC_GEOMETRY_TYPE_QUAD : RTC_GEOMETRY_TYPE_TRIANGLE);
      if (segments_ > 0) rtcSetGeometryTimeStepCount(shape, segments_ + 1);
      for (uint32_t step = 1; step <= segments_; ++step) {
        const std::vector<V3f>& later = part->laterVertices[step - 1];
        auto* to = static_cast<V3f*>(rtcSetNewGeometryBuffer(shape, RTC_BUFFER_TYPE_VERTEX, step,
                                                             RTC_FORMAT_FLOAT3, sizeof(V3f), later.size()));
        std::copy(later.begin(), later.end(), to);
      }
      auto* vertices = static_cast<V3f*>(rtcSetNewGeometryBuffer(
          shape, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(V3f), part->vertices.size()));
      std::copy(part->vertices.begin(), part->vertices.end(), vertices);
      auto* indices = static_cast<uint32_t*>(rtcSetNewGeometryBuffer(
          shape, RTC_BUFFER_TYPE_INDEX, 0, quads ? RTC_FORMAT_UINT4 : RTC_FORMAT_UINT3,
          sizeof(uint32_t) * (quads ? 4 : 3), part->indices.size() / (quads ? 4 : 3)));
      std::copy(part->indices.begin(), part->indices.end(), indices);
    }
    part->vertices = {}, part->indices = {}, part->grids = {}, part->laterVertices = {};
    part->owners.shrink_to_fit();
    rtcSetGeometryMask(shape, key.visibility);
    if (everyHit_) {
      rtcSetGeometryUserData(shape, this);
      rtcSetGeometryIntersectFilterFunction(shape, everyHit_);
    } else if (key.oneSided || key.hasHoles) {
      rtcSetGeometryUserData(shape, part.get());
      rtcSetGeometryIntersectFilterFunction(shape, filterHits);
      rtcSetGeometryOccludedFilterFunction(shape, filterHits);
    }
    rtcCommitGeometry(shape);
    rtcAttachGeometry(scene_, shape);  // numbers them from 0 on
    rtcReleaseGeometry(shape);
    parts_.push_back(std::move(part));
  }
  open_.clear();
}

/// RI Sides 1: only the outside of a surface is met. Nor are the holes of trimmed surfaces.
void EmbreeScene::filterHits(const RTCFilterFunctionNArguments* args) {
  const Part& part = *static_cast<const Part*>(args->geometryUserPtr);
  for (unsigned k = 0; k < args->N; ++k) {
    if (args->valid[k] == 0) continue;
    V2f uv(RTCHitN_u(args->hit, args->N, k), RTCHitN_v(args->hit, args->N, k));
    const FaceOwner owner = ownerOf(part, RTCHitN_primID(args->hit, args->N, k), uv.x, uv.y);
    const Geometry& geometry = part.scene->geometry_;
    const Surface& surface = geometry.surface(owner.traced);
    if (part.hasHoles && surface.isHole(owner.face, uv.x, uv.y)) {
      args->valid[k] = 0;
      continue;
    }
    if (!part.oneSided) continue;
    // By the facet, as Hit::front has it: near a silhouette the smooth surface may face the other way.
    const Placement& placement =
        part.scene->placement(owner.traced, QueryContext::of(args->context).instance());
    if (!geometry.attributes(placement).oneSided) continue;
    const V3f normal(RTCHitN_Ng_x(args->hit, args->N, k), RTCHitN_Ng_y(args->hit, args->N, k),
                     RTCHitN_Ng_z(args->hit, args->N, k));
    const V3f direction(RTCRayN_dir_x(args->ray, args->N, k), RTCRayN_dir_y(args->ray, args->N, k),
                        RTCRayN_dir_z(args->ray, args->N, k));
    if (normal.dot(direction) * placement.meshSign > 0) args->valid[k] = 0;
  }
}

}  // namespace patina
