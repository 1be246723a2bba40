// SPDX-License-Identifier: Apache-2.0
// What rays are traced against in one part of the geometry: the scene itself, or a delayed archive.
#pragma once

#include <embree3/rtcore.h>

#include <deque>
#include <memory>
#include <vector>

#include "renderer/accel/deferred_units.h"
#include "renderer/accel/embree_scene.h"
#include "renderer/base/parallel.h"

namespace patina {

/// Hits in units name the traced surface from here on in place of an Embree geometry, and its face.
inline constexpr uint32_t kFirstTraced = 0x40000000;
/// Embree refuses coordinates of rays beyond 1.8e18, in every space that they come through.
inline constexpr float kLargestOrigin = 1e18f;

/// Hits in delayed archives name the placement from here on, its face, the index of Geometry::instances() in
/// place of Embree's number, and the normal as MetFace has it.
inline constexpr uint32_t kFirstResolved = 0x80000000;

/// The Embree scene of a unit.
struct UnitTracer final : Tessellation::Tracer {
  EmbreeScene scene;
  UnitTracer(RTCDevice device, const Geometry& geometry, uint32_t unit);
};

struct QueryContext;

/// What a ray met, as Geometry names it.
struct MetFace {
  uint32_t placement, face;
  uint32_t instance;  ///< index of Geometry::instances(); kNone: none
  V3f normal;         ///< world space, of any length; mesh space's cross product of a facet's first two edges
};

/// The Embree scenes of a part: one for what is in the world, one for each object and for each group that
/// moves as one. Small flat primitives are in them from the beginning; units stand there as user geometry
/// that is made when a ray meets its bound (lazy geometry in Embree's words), and so do delayed archives,
/// each of which has a PartTracer of its own once it is read.
class PartTracer final : public GeometryPart::Tracer {
 public:
  /// `device` and `geometry` must outlive it. `native`, by unit, those whose facets are pinned
  /// (TessellationCache::pin): they are Embree's own geometries here; empty = none. [any thread]
  PartTracer(RTCDevice device, const Geometry& geometry, const GeometryPart& part,
             const std::vector<bool>& native = {});
  ~PartTracer() override;

  RTCScene scene() const { return world_->scene(); }
  const InstanceNumbers& instances() const { return instances_; }
  /// What Embree's numbers of a hit in this part mean; `u` and `v` become those of the face. [any thread]
  MetFace met(uint32_t geometry, uint32_t primitive, uint32_t instance, const V3f& normal, float time,
              float& u, float& v) const;
  /// Rays whose origins have a coordinate beyond this cannot be traced here: in the space of some instance,
  /// which is very small or flat, Embree's numbers would not hold them.
  float reach() const { return reach_; }
  /// Whether Embree can trace a ray, here and in the spaces of all instances.
  bool traces(const V3f& origin, const V3f& direction, float tNear, float tFar) const {
    const auto within = [](const V3f& v, float most) {
      return std::abs(v.x) <= most && std::abs(v.y) <= most && std::abs(v.z) <= most;  // NaN is not
    };
    return within(origin, reach_) && within(direction, kLargestOrigin) && tNear <= kInfinity &&
           tFar <= kInfinity;
  }
  bool traces(const RTCRay& ray) const {
    return traces({ray.org_x, ray.org_y, ray.org_z}, {ray.dir_x, ray.dir_y, ray.dir_z}, ray.tnear, ray.tfar);
  }
  /// Some units stand here as bounds that are looked into when rays meet them.
  bool hasUnits() const { return !lists_.empty(); }

 private:
  /// The units of one group: the primitives of a user geometry.
  struct UnitList {
    const Geometry* geometry = nullptr;
    std::vector<uint32_t> units = {};
    uint32_t segments = 0;    ///< time segments of all of them
    uint32_t mask = kAnyRay;  ///< the rays that meet them here
    bool frozen = false;      ///< units that move, as they are at the opening of the shutter
    Handover made = {};       ///< to the threads that Embree builds with
  };
  /// The delayed archives of a part: the primitives of a user geometry.
  struct DelayedList {
    const Geometry* geometry = nullptr;
    uint32_t first = 0;
    Handover made = {};
  };
  template <class List>
  RTCGeometry newUserGeometry(List& list, size_t count) const;
  std::unique_ptr<EmbreeScene> makeGroup(uint32_t first, uint32_t end, const std::vector<bool>& native);
  void attachUnits(EmbreeScene& scene, UnitList list);
  void attachDelayed(uint32_t count);
  void attachInstances();
  M44f worldToMesh(uint32_t movement, float time) const;

  static void boundUnit(const RTCBoundsFunctionArguments* args);
  static void intersectUnit(const RTCIntersectFunctionNArguments* args);
  static void occludeUnit(const RTCOccludedFunctionNArguments* args);
  static void boundDelayed(const RTCBoundsFunctionArguments* args);
  static void intersectDelayed(const RTCIntersectFunctionNArguments* args);
  static void occludeDelayed(const RTCOccludedFunctionNArguments* args);
  static const PartTracer* meetDelayed(const DelayedList& list, uint32_t index, QueryContext& query,
                                       RTCRay& ray);

  RTCDevice device_;
  const Geometry& geometry_;
  uint32_t firstTraced_, firstPlacement_, firstGroup_, firstMovement_;
  std::unique_ptr<EmbreeScene> world_;
  std::vector<std::unique_ptr<EmbreeScene>> groups_;  ///< from firstGroup_ on; null = empty
  std::deque<UnitList> lists_;
  DelayedList delayed_;
  std::vector<RTCGeometry> movingShapes_;  ///< from firstMovement_ on; null = rays that move do not see it
  InstanceNumbers instances_;
  float reach_ = kLargestOrigin;
};

/// What a query's callbacks know beside what Embree has for them.
struct QueryContext {
  RTCIntersectContext embree;
  TessellationCache::Reader* reader;  ///< keeps what the query meets; null: there are no units
  const PartTracer* part;             ///< that the ray is in now
  DeferredUnits* deferred;            ///< null: what is not there is made at once
  QueryContext(TessellationCache::Reader* r, const PartTracer& p, DeferredUnits* d = nullptr)
      : reader(r), part(&p), deferred(d) {
    rtcInitIntersectContext(&embree);
  }
  static QueryContext& of(RTCIntersectContext* context) { return *reinterpret_cast<QueryContext*>(context); }
  /// Index of Geometry::instances() of the instance that the ray is in; kNone: none.
  uint32_t instance() const { return part->instances().indexOf(embree.instID[0]); }
  /// Null: the ray will be tested against the unit later.
  const Tessellation* unit(uint32_t unit, const RTCRay& ray) {
    if (!deferred) return &reader->get(unit);
    const Tessellation* const known = reader->find(unit);
    if (!known) deferred->add(unit, ray, *part, embree.instID[0]);
    return known;
  }
};

/// A ray against a unit that is there; a hit names the traced surface and its face.
bool intersectFacets(const Geometry& geometry, uint32_t unit, const Tessellation& met, QueryContext& query,
                     RTCRayHit& ray);
void occludeFacets(const Geometry& geometry, uint32_t unit, const Tessellation& met, QueryContext& query,
                   RTCRay& ray);

}  // namespace patina
