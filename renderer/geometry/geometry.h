// SPDX-License-Identifier: Apache-2.0
// All geometry of a frame: the surface of every primitive, its facets for tracing, and where each is placed.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "renderer/base/stable_vector.h"
#include "renderer/geometry/delayed_geometry.h"
#include "renderer/geometry/displacement.h"
#include "renderer/geometry/motion_geometry.h"
#include "renderer/geometry/patches.h"
#include "renderer/geometry/solids.h"
#include "renderer/geometry/surface.h"
#include "renderer/geometry/tessellation_cache.h"

namespace patina {

/// A surface as it is traced: by its faces where they are flat, else by facets that are made when a ray comes
/// near.
struct TracedSurface {
  const Primitive* primitive = nullptr;
  M44f toMesh;             ///< primitive space to mesh space: world space, or the object's inside an object
  Box3f bound;             ///< primitive space, before displacement
  uint32_t group = kNone;  ///< the object that it belongs to; kNone = the world
  uint32_t unit = kNone;   ///< index of Geometry::units; kNone: traced from the beginning
  uint32_t member = 0;     ///< of the unit
  uint32_t attributes = kNone;  ///< as Geometry numbers them; kNone: those of the instances
  uint32_t placement = kNone;   ///< of a surface of the world
  bool isReversed = false;      ///< the outside is opposite to dPdu x dPdv of primitive space
  bool isDisplaced = false;
  float reach = 0;         ///< of displacement, mesh space
  uint32_t segments = 0;   ///< its facets move in mesh space, in so many steps in time; 0 = they do not
  bool isTurned = false;   ///< of a part of a solid: the solid's outside is the other side
  uint32_t solid = kNone;  ///< index of Geometry::solids()
  uint32_t leaf = 0;       ///< node of the solid that it bounds
  float leafSign = 1;      ///< -1: the cross product of a facet's edges in mesh space points into that leaf
  uint32_t chunks = 0;     ///< > 0: a dense mesh, whose faces are in so many units from `unit` on
  uint32_t order = kNone;  ///< of a dense mesh: index of Geometry's orders of faces
};

/// Surfaces near each other, of one group, that are made, tessellated and given a structure for rays
/// together, when the first ray meets their bound; or all surfaces of a solid. A dense mesh is cut into units
/// of its own, which hold some of its faces each.
struct SurfaceUnit {
  std::vector<uint32_t> members;         ///< indices of Geometry::traced()
  Box3f bound;                           ///< mesh space, at the opening of the shutter
  uint32_t visibility;                   ///< RayMask of all members; of a solid: of any of them
  bool oneSided;                         ///< all members are; of a solid: not known
  uint32_t segments = 0;                 ///< of all members
  bool sampleMotion = false;             ///< other rays than the camera's see the motion of its facets, too
  std::vector<Box3f> stepBounds = {};    ///< at the time steps; empty where there are none
  uint32_t solid = kNone;                ///< index of Geometry::solids()
  std::span<const uint32_t> faces = {};  ///< of the only member that are here; empty = all
};

/// A primitive at its place in the world; instances of an object have one for each primitive of it.
struct Placement {
  uint32_t traced;                    ///< index of Geometry::traced
  uint32_t attributes;                ///< as Geometry numbers them: those of Scene first
  uint32_t instance;                  ///< index of Geometry::instances; kNone = the world
  M44f objectToWorld, worldToObject;  ///< primitive space
  uint64_t seed;     ///< of its random numbers, whatever the order in which delayed archives are read
  float normalSign;  ///< -1: the outside is opposite to dPdu x dPdv of primitive space
  float facetSign;   ///< the same for the cross product of edges taken in world space
  float meshSign;  ///< the same for the cross product taken in mesh space, brought to world space as a normal
  bool moves;      ///< while the shutter is open: all else here is as it is at its opening
};

/// Primitives that share a place: an instance of an object, or what shares a moving transformation.
struct PlacedInstance {
  uint32_t object;  ///< a group of surfaces, see Geometry::groupRange
  uint32_t firstPlacement;
  uint32_t visibility;            ///< RayMask
  M44f meshToWorld, worldToMesh;  ///< at the opening of the shutter
  uint32_t movement = kNone;      ///< index of Geometry::movements(); kNone: it stands still
};

/// Where an instance is at equally distant times from the opening of the shutter to its closing.
struct InstanceMovement {
  std::vector<TransformParts> steps;  ///< of meshToWorld; two or more; rotations in between turn
  bool sampleMotion;                  ///< other rays than the camera's see it move, too
};

/// The point of a facet that a ray met, in world space.
struct Facet {
  V3f P;
  V3f N;        ///< unit, outside
  float error;  ///< bound on the distance between P and the plane that rays meet, world units
};

class Geometry {
 public:
  /// Bounds and places everything in `scene` that some ray may meet; surfaces, facets and patches are made
  /// when they are asked for. Errors are reported per primitive and leave it out; those of meshes when they
  /// are made. `scene` and `errors` must outlive the geometry.
  /// With a displacer, surfaces with displacement shaders are displaced when they are tessellated, those that
  /// say no bound at once. Surfaces of objects, which instances share, are displaced in the object's space;
  /// instances whose own attributes displace have surfaces of their own, in world space.
  Geometry(const Scene& scene, const RasterCamera& camera, ErrorHandler& errors,
           const Displacer* displacer = nullptr);
  ~Geometry();

  const Scene& scene() const { return scene_; }
  // Tables that grow when delayed archives are read.
  const StableVector<TracedSurface>& traced() const { return traced_; }
  const StableVector<SurfaceUnit>& units() const { return units_; }
  const StableVector<Placement>& placements() const { return placements_; }
  const StableVector<PlacedInstance>& instances() const { return instances_; }
  const StableVector<SolidTree>& solids() const { return solids_; }
  const StableVector<InstanceMovement>& movements() const { return movements_; }
  /// Something moves, or a delayed archive may have what does.
  bool moves() const { return moves_; }
  /// Other rays than the camera's see something move; or a delayed archive, by the attributes of its request.
  bool samplesMotion() const { return samplesMotion_; }
  const PatchTable& patches() const { return *patches_; }
  /// First traced surface of a group and the one behind the last. Those of Scene::objects come first, in
  /// their order, then those of primitives of the world that move as one.
  std::pair<uint32_t, uint32_t> groupRange(uint32_t group) const { return groups_[group].range; }
  const Box3f& bound() const { return bound_; }  ///< world space; of delayed archives, what they say

  /// What is there from the beginning. [any thread]
  const GeometryPart& mainPart() const { return main_; }
  bool hasDelayed() const { return main_.firstDelayed < main_.endDelayed; }
  const DelayedPlace& delayed(uint32_t index) const { return delayed_[index]; }
  /// Cuts [tNear, tFar] of a ray to where it is within the bound of a delayed archive. False: it is not. As
  /// rays are traced against the archive in that part only, what sticks out of a bound that is too small is
  /// never seen, from wherever and in whatever order rays come. [any thread]
  bool clipToBound(uint32_t delayed, const V3f& origin, const V3f& direction, float& tNear,
                   float& tFar) const;
  /// A delayed archive, read if nobody met it before; it stays. What is wrong with it is reported. Throws
  /// nothing. [any thread, without a Reader of tessellations]
  const GeometryPart& part(uint32_t delayed) const {
    const GeometryPart* known = delayed_[delayed].loaded.load(std::memory_order_acquire);
    return known ? *known : load(delayed);
  }
  /// Of each part that is read `listener` is told, a part at a time; then `make` is asked for what rays are
  /// traced against, several parts at a time. Each to be said before the first ray. [main]
  void setListener(GeometryListener* listener) const { listener_ = listener; }
  void setTracerMaker(std::function<std::unique_ptr<GeometryPart::Tracer>(const GeometryPart&)> make) const {
    makeTracer_ = std::move(make);
  }
  /// Forgets both, and what rays are traced against: nobody may trace any more. [main]
  void dropTracers() const;

  /// A traced surface, made if nobody asked for it before; it stays. One that turns out to make no sense has
  /// no faces. [any thread]
  const Surface& surface(uint32_t traced) const {
    const Surface* known = surfaces_[traced].load(std::memory_order_acquire);
    return known ? *known : makeSurface(traced);
  }
  const Surface& surface(const Placement& p) const { return surface(p.traced); }
  const Attributes& attributes(const Placement& p) const { return *attributes_[p.attributes]; }
  const Attributes* attributes(const TracedSurface& t) const {  ///< null: those of the instances
    return t.attributes == kNone ? nullptr : attributes_[t.attributes];
  }

  /// The placement of a traced surface in an instance of its object (kNone: in the world).
  uint32_t placementOf(uint32_t traced, uint32_t instance) const {
    if (instance == kNone) return traced_[traced].placement;
    const PlacedInstance& placed = instances_[instance];
    return placed.firstPlacement + traced - groups_[placed.object].range.first;
  }
  /// Whether Sides is 1 somewhere for a surface: in its own attributes, or in those of an instance.
  bool maybeOneSided(const TracedSurface& t) const {
    const Attributes* own = attributes(t);
    return own ? own->oneSided : groups_[t.group].oneSided;
  }

  /// Facets of the units. renderer/accel says with its setMaker() how their tracers are made out of what
  /// tessellate() gives, before anyone reads. [any thread]
  TessellationCache& tessellations() const { return *tessellations_; }
  /// The facets of a unit, without a tracer. [any thread]
  std::unique_ptr<Tessellation> tessellate(uint32_t unit) const;
  /// Puts what is going to be looked at in the order of the units that hold it, when facets have to go and
  /// come back: then each is made once. `placementOf` an element. [any thread]
  template <class PlacementOf>
  void orderByUnit(std::span<uint32_t> which, PlacementOf placementOf) const {
    if (!tessellations_->isTight()) return;
    const auto key = [&](uint32_t k) {
      return uint64_t{traced_[placements_[placementOf(k)].traced].unit} << 32 | k;
    };
    std::sort(which.begin(), which.end(), [&](uint32_t a, uint32_t b) { return key(a) < key(b); });
  }
  /// How large the tessellation of a unit will be; by the thread that is about to make it.
  struct UnitSize {
    size_t facets = 0, vertices = 0;
    size_t faces = 0;  ///< flat ones, which are traced as they are
  };
  UnitSize sizeOf(uint32_t unit) const;
  /// Says that a unit could not be made and is left out; returns what stands for it. [any thread]
  std::unique_ptr<Tessellation> leaveOut(uint32_t unit, std::string_view why) const;

  /// Normal (unit, either side) and derivatives by the face's u and v of a displaced surface, world space.
  struct DisplacedPoint {
    V3f N, dPdu, dPdv;
  };
  /// A point of a displaced surface near (u, v) that is well within a facet: rays that leave the edge of one
  /// may begin behind its neighbour.
  V2f insideFacet(uint32_t placement, uint32_t face, float u, float v) const;
  DisplacedPoint displacedPoint(uint32_t placement, uint32_t face, float u, float v) const;

  Facet facet(uint32_t placement, uint32_t face, float u, float v) const;
  /// Corners of the two triangles of a facet cell are those of Embree: (00, 10, 01) and (11, 01, 10).
  void facetCorners(uint32_t placement, uint32_t face, float u, float v, V3f out[3], V2f& weights) const;
  /// Whether rays meet facets that are made on demand, in place of the surface's own flat faces.
  bool isTessellated(uint32_t traced) const {
    return traced_[traced].unit != kNone &&
           (traced_[traced].isDisplaced || !surface(traced).isFlat() || bends(traced));
  }
  /// A surface that moves in mesh space as it is at a time step, in primitive space; its faces are those of
  /// surface(). [any thread]
  PosedSurface posed(uint32_t traced, uint32_t step) const;
  /// Primitive space to mesh space at a time step.
  M44f toMeshAt(uint32_t traced, uint32_t step) const;
  /// All that rays may meet of a placement, by quads of two triangles each: (00, 10, 01) and (11, 01, 10), or
  /// single triangles.
  struct FacetQuad {
    uint32_t face;
    bool isTriangle;
    V2f uv[4];    ///< of the face; order 00, 10, 01, 11
    V3f P[4];     ///< world space
    float error;  ///< see Facet
  };
  void forEachFacet(uint32_t placement, const std::function<void(const FacetQuad&)>& visit) const;

  /// Sets the statistics that are known at the end of a frame. [main]
  void reportMemory() const;

 private:
  void append(GeometryPart& part) const;
  void appendSurfaces(GeometryPart& part, std::vector<M44d>& toWorld) const;
  bool add(const Primitive& primitive, const M44d& toMesh, uint32_t group, uint32_t attributes,
           bool isReversed) const;
  bool ownsSurfaces(const GeometryPart& part, const Instance& instance) const;
  void place(const GeometryPart& part, const Instance& instance) const;
  void addDelayed(GeometryPart& part) const;
  const GeometryPart& load(uint32_t delayed) const;
  void grow(GeometryPart& part) const;
  void warnOfBound(const DelayedPlace& place, const GeometryPart& part) const;
  void boundDisplacements(uint32_t firstTraced) const;
  Box3f boundInMesh(const TracedSurface& traced) const;
  DisplacementResult displace(uint32_t traced, const SurfaceRates& rates, std::span<const uint32_t> first,
                              std::span<V3f> vertices) const;
  void checkDisplacement(uint32_t traced, float moved) const;
  /// Places a group; `movement` null: it stands still. `attributes` kNone: its primitives have their own.
  void place(uint32_t group, const M44d& meshToWorld, uint32_t attributes, uint32_t visibility, bool reversed,
             const Movement* movement, bool sampleMotion) const;
  static Placement makePlacement(uint32_t traced, uint32_t attributes, uint32_t instance,
                                 const M44d& objectToWorld, const M44d& toMesh, bool reversed);
  void addMovingGroups(const GeometryPart& part) const;
  void placeMovingGroups(const GeometryPart& part) const;
  void findMotion(const GeometryPart& part) const;
  void addPlacesInTime(uint32_t traced, std::vector<M44f>& places) const;
  SurfaceRates ratesInTime(uint32_t traced, std::optional<float> shadingRate) const;
  bool movesAsWhole(const Primitive& primitive) const;
  bool movesAsWhole(const Instance& instance) const;
  PosedPrimitive posing(uint32_t traced) const;
  std::vector<DicePose> dicePoses(uint32_t placement) const;
  /// Of a surface at a time step, in primitive space, before displacement.
  Box3f boundAt(uint32_t traced, uint32_t step) const;
  void addStepBounds(SurfaceUnit& unit, uint32_t traced, const Box3f& opening) const;
  void addSteps(const SurfaceUnit& unit, Tessellation& tessellation) const;
  /// Whether a flat surface moves in a way that does not keep it flat.
  bool bends(uint32_t traced) const {
    return traced_[traced].segments > 0 &&
           !std::holds_alternative<PolygonMesh>(traced_[traced].primitive->shape);
  }
  void makeUnits(uint32_t firstTraced, uint32_t firstSolid) const;
  /// Finds out about solids, whose traced surfaces begin at `first` and are the last so far. Those that are
  /// no part of a result go, and with them their entries in `toWorld`, whose last is that of the last traced
  /// surface; it may be null.
  void makeSolids(const std::vector<Solid>& solids, uint32_t first, std::vector<M44d>* toWorld) const;
  void makeChunks(uint32_t traced) const;
  std::vector<M44f> placesOf(uint32_t traced) const;
  const Surface& makeSurface(uint32_t traced) const;
  const SurfaceRates& rates(uint32_t traced) const;
  float facetError(const Placement& p, const V3f& point, const V3f& edge1, const V3f& edge2) const;
  Viewpoint viewpoint(const M44d& toWorld) const;
  Viewpoint viewpoint(const Primitive& primitive, const M44d& toMesh, uint32_t group) const;

  static constexpr size_t kMutexes = 64;

  const Scene& scene_;
  const RasterCamera camera_;
  ErrorHandler& errors_;
  const Displacer* displacer_;
  /// Surfaces of an object at the places of the instances of one part; or those of a part that move as one.
  struct Group {
    std::pair<uint32_t, uint32_t> range;  ///< traced surfaces
    const Scene* scene = nullptr;         ///< that has the instances
    uint32_t object = kNone;              ///< as `scene` numbers it; kNone: they move as one
    uint32_t moving = kNone;              ///< then: index of movingGroups_
    bool oneSided = false;                ///< some instance has Sides 1
    std::vector<uint32_t> instances;      ///< indices of instances_
  };
  struct MovingGroup {
    Movement movement;  ///< mesh space to world
    bool sampleMotion;
    struct Member {
      const Primitive* primitive;
      M44d toMesh;
      uint32_t attributes;  ///< as Geometry numbers them
      bool isReversed;
    };
    std::vector<Member> members;
    std::vector<M44d> toMesh;  ///< of those that could be added
    uint32_t group = kNone;    ///< index of groups_
  };
  // Grown by append(), which is called by one thread at a time: in the beginning, then under growMutex_.
  mutable StableVector<TracedSurface> traced_;
  mutable StableVector<std::unique_ptr<const Surface>> made_;        ///< by traced surface; see surfaces_
  mutable StableVector<std::atomic<const Surface*>> surfaces_;       ///< made_, for readers without a lock
  mutable StableVector<std::unique_ptr<const SurfaceRates>> rates_;  ///< by traced surface; null = not known
  mutable StableVector<std::atomic<bool>> displacementChecked_;      ///< by traced surface
  mutable StableVector<Placement> placements_;
  mutable StableVector<PlacedInstance> instances_;
  mutable StableVector<InstanceMovement> movements_;
  mutable StableVector<Group> groups_;
  mutable StableVector<MovingGroup> movingGroups_;
  mutable StableVector<SurfaceUnit> units_;
  mutable StableVector<SolidTree> solids_;
  mutable StableVector<std::vector<uint32_t>> faceOrders_;  ///< mortonOrder() of dense meshes
  mutable StableVector<const Attributes*> attributes_;      ///< those of the scene, then of parts
  mutable StableVector<DelayedPlace> delayed_;
  mutable std::mutex growMutex_;
  mutable bool full_ = false;                              ///< guarded by growMutex_; see grow()
  mutable std::array<std::mutex, kMutexes> surfaceMutex_;  ///< by traced surface
  mutable std::atomic<size_t> surfaceBytes_ = 0, orderBytes_ = 0;
  mutable std::atomic<bool> facetsLimited_ = false, posesFailed_ = false;
  mutable std::atomic<int64_t> loadingTime_ = 0;  ///< nanoseconds, of all threads
  mutable GeometryListener* listener_ = nullptr;
  mutable std::function<std::unique_ptr<GeometryPart::Tracer>(const GeometryPart&)> makeTracer_;
  GeometryPart main_;
  std::unique_ptr<TessellationCache> tessellations_;
  std::unique_ptr<PatchTable> patches_;
  // Known when the scene's own content is there, and the same from then on.
  mutable bool moves_ = false, samplesMotion_ = false;
  mutable Box3f bound_;
};

}  // namespace patina
