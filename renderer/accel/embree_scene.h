// SPDX-License-Identifier: Apache-2.0
// An Embree scene of surfaces, and what its geometries stand for.
#pragma once

#include <embree3/rtcore.h>

#include <map>
#include <memory>
#include <vector>

#include "renderer/geometry/geometry.h"

namespace patina {

/// A face of an Embree geometry's primitive.
struct FaceOwner {
  uint32_t traced;  ///< index of Geometry::traced()
  uint32_t face;    ///< in an EmbreeScene's lists: of tessellated surfaces the tile
};

/// Embree's numbers of the instances of a part of the geometry. Those that move for some rays only have a
/// twin that stands still for the others.
struct InstanceNumbers {
  uint32_t first = 0;           ///< of the part's first instance
  uint32_t base = 0;            ///< that one's index of Geometry::instances()
  uint32_t count = 0;           ///< instances; twins come behind them
  std::vector<uint32_t> twins;  ///< whose: indices of Geometry::instances()
  /// Index of Geometry::instances(); kNone: no instance.
  uint32_t indexOf(unsigned number) const {
    if (number == RTC_INVALID_GEOMETRY_ID) return kNone;
    const uint32_t k = number - first;
    return k < count ? base + k : twins[k - count];
  }
};

/// The faces of some surfaces: triangles, quads and grids of facets, those of one visibility and sidedness
/// together. Holds an Embree scene; views the vertices of tessellations.
class EmbreeScene {
 public:
  struct Kinds {
    uint32_t segments = 0;  ///< of the unit whose facets move, in time; 0 = they do not
    bool compact = false;   ///< triangles stay indices: half the memory, and somewhat more time per ray
    /// A filter that is called with every hit of all surfaces, whoever sees them; its user data is this
    /// scene.
    RTCFilterFunctionN everyHit = nullptr;
  };
  EmbreeScene(RTCDevice device, const Geometry& geometry, RTCBuildQuality quality, const Kinds& kinds);
  EmbreeScene(RTCDevice device, const Geometry& geometry, RTCBuildQuality quality)
      : EmbreeScene(device, geometry, quality, Kinds()) {}
  ~EmbreeScene();
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  /// All faces of a surface, or those that `faces` names, which must outlive the scene.
  void addFlat(uint32_t traced, std::span<const uint32_t> faces = {});
  /// The facets of a member of a tessellation, which must outlive the scene.
  void addFacets(uint32_t traced, const Tessellation::Member& member, const Tessellation& tessellation);
  /// All of a unit, and attaches it.
  void addUnit(uint32_t unit, const Tessellation& tessellation);
  /// Makes the geometries of what was added since the last time, numbered from where those before end.
  void attach();

  RTCScene scene() const { return scene_; }
  const Geometry& geometry() const { return geometry_; }
  /// The placement of a traced surface in an instance (index of Geometry::instances(); kNone: in the world).
  const Placement& placement(uint32_t traced, uint32_t instance) const {
    return geometry_.placements()[geometry_.placementOf(traced, instance)];
  }
  uint32_t geometries() const { return static_cast<uint32_t>(parts_.size()); }
  /// The face that was met; `u` and `v` become those of the face.
  FaceOwner ownerOf(uint32_t geometry, uint32_t primitive, float& u, float& v) const {
    return ownerOf(*parts_[geometry], primitive, u, v);
  }

 private:
  enum class Kind : uint8_t { Triangles, Quads, Grids };
  struct Key {
    Kind kind;
    uint32_t visibility;
    bool oneSided;
    bool hasHoles;  ///< rays pass through parts of the surfaces
    auto operator<=>(const Key&) const = default;
  };
  struct Part {
    const EmbreeScene* scene = nullptr;
    bool oneSided = false, hasHoles = false;
    uint32_t traced = kNone;  ///< not kNone: primitive k is face faces[k] of it, and there are no owners
    std::span<const uint32_t> faces;
    std::vector<FaceOwner> owners;  ///< by Embree primitive
    std::vector<V3f> vertices;      ///< of flat faces, until they are attached
    std::vector<uint32_t> indices;
    std::vector<RTCGrid> grids;
    std::span<const V3f> shared;                  ///< of grids
    size_t stride = 0;                            ///< of `shared`: from a time step to the next
    std::vector<std::vector<V3f>> laterVertices;  ///< of flat faces, at time steps behind the first
    std::vector<const SurfaceRates*>
        rates;  ///< of grids: by Embree primitive, null where tiles are whole quads
    FaceOwner owner(uint32_t primitive) const {
      return traced == kNone ? owners[primitive] : FaceOwner{traced, faces[primitive]};
    }
  };
  Part& part(uint32_t traced, Kind kind);
  static FaceOwner ownerOf(const Part& part, uint32_t primitive, float& u, float& v);
  static void filterHits(const RTCFilterFunctionNArguments* args);

  RTCDevice device_;
  const Geometry& geometry_;
  RTCFilterFunctionN everyHit_;
  RTCScene scene_;
  uint32_t segments_;
  std::map<Key, std::unique_ptr<Part>> open_;
  std::vector<std::unique_ptr<Part>> parts_;  ///< by Embree geometry
};

}  // namespace patina
