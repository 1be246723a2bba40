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

/// The faces of some surfaces: triangles, quads and grids of facets, those of one visibility and sidedness
/// together. Holds an Embree scene; views the vertices of tessellations.
class EmbreeScene {
 public:
  /// `firstInstance`: Embree's number of the first of Geometry::instances() that rays may come by.
  /// `compact`: triangles stay indices, which takes half the memory and somewhat more time per ray.
  /// `everyHit`: a filter that is called with every hit of all surfaces, whoever sees them; its user data is
  /// this scene.
  EmbreeScene(RTCDevice device, const Geometry& geometry, RTCBuildQuality quality, uint32_t firstInstance,
              bool compact = false, RTCFilterFunctionN everyHit = nullptr);
  ~EmbreeScene();
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  /// All faces of a surface, or those that `faces` names, which must outlive the scene.
  void addFlat(uint32_t traced, std::span<const uint32_t> faces = {});
  /// The facets of a member of a tessellation, which must outlive the scene.
  void addFacets(uint32_t traced, const Tessellation::Member& member, const Tessellation& tessellation);
  /// Makes the geometries of what was added. Once.
  void attach();

  RTCScene scene() const { return scene_; }
  const Geometry& geometry() const { return geometry_; }
  /// The placement of a traced surface; `instance`: Embree's number of the instance that the ray is in.
  const Placement& placement(uint32_t traced, unsigned instance) const {
    return geometry_.placements()[geometry_.placementOf(
        traced, instance == RTC_INVALID_GEOMETRY_ID ? kNone : instance - firstInstance_)];
  }
  uint32_t geometries() const { return static_cast<uint32_t>(parts_.size()); }
  /// Of flat faces.
  FaceOwner owner(uint32_t geometry, uint32_t primitive) const { return parts_[geometry]->owner(primitive); }
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
    std::span<const V3f> shared;  ///< of grids
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
  uint32_t firstInstance_;
  RTCFilterFunctionN everyHit_;
  RTCScene scene_;
  std::map<Key, std::unique_ptr<Part>> open_;
  std::vector<std::unique_ptr<Part>> parts_;  ///< by Embree geometry
};

}  // namespace patina
