// SPDX-License-Identifier: Apache-2.0
// Parts of the geometry that are there from the beginning, and those that are read when rays meet them.
#pragma once

#include <atomic>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "renderer/base/math.h"
#include "renderer/scene/scene.h"

namespace patina {

/// Where the content of one scene stands in the tables of Geometry: the frame's scene, or what a delayed
/// archive holds. Immutable when anybody but its maker sees it.
struct GeometryPart {
  /// The structure that rays are traced against; made and known by renderer/accel.
  struct Tracer {
    virtual ~Tracer() = default;
  };

  std::shared_ptr<const Scene> scene;    ///< null: nothing could be read
  const GeometryPart* around = nullptr;  ///< the part whose scene asks for this one; null = none
  uint64_t seed = 0;                     ///< of the random numbers of what is in it; 0 = the frame's scene
  uint32_t firstAttributes = 0;          ///< of scene->attributes in Geometry's numbers
  uint32_t firstShader = 0;              ///< of scene->shaders in the renderer's numbers
  /// Of a delayed archive's scene, with shaders in the renderer's numbers.
  std::deque<Attributes> attributes;
  uint32_t firstTraced = 0, endTraced = 0;        ///< the surfaces that are not in objects
  uint32_t firstPlacement = 0, endPlacement = 0;  ///< all
  uint32_t firstInstance = 0, endInstance = 0;
  uint32_t firstMovement = 0, endMovement = 0;
  uint32_t firstGroup = 0, endGroup = 0;      ///< of surfaces: of objects, then of what moves as one
  uint32_t firstDelayed = 0, endDelayed = 0;  ///< archives within it
  std::map<uint32_t, uint32_t> groups;        ///< object, as the scene numbers it, to group of Geometry
  std::unique_ptr<Tracer> tracer;             ///< of delayed archives; null: nothing to be met

  /// The part that defines a shader, or an object, which instances in this part may use; its number is
  /// brought to that of the part's own table.
  const GeometryPart& ofShader(uint32_t& shader) const {
    const GeometryPart* part = this;
    while (shader < part->scene->firstShader) part = part->around;
    shader -= part->scene->firstShader;
    return *part;
  }
  /// A shader of the scene in the renderer's numbers.
  uint32_t shader(uint32_t shader) const {
    const uint32_t first = ofShader(shader).firstShader;
    return first + shader;
  }
  const GeometryPart& ofObject(uint32_t& object) const {
    const GeometryPart* part = this;
    while (object < part->scene->firstObject) part = part->around;
    object -= part->scene->firstObject;
    return *part;
  }
};

/// Who must know of parts that are read, before rays meet them. Called by one thread at a time.
class GeometryListener {
 public:
  virtual ~GeometryListener() = default;
  /// Before the tables of Geometry grow: sets part.firstShader, and loads the shaders that part.attributes
  /// want, whose numbers are those of the part's scene still.
  virtual void begin(GeometryPart& part) = 0;
  /// When they have grown.
  virtual void end(const GeometryPart& part) = 0;
};

/// A delayed archive at its place.
struct DelayedPlace {
  const DelayedArchive* archive;
  const GeometryPart* around;  ///< the part that asks for it
  uint64_t seed;
  Box3f bound;  ///< object space, a little wider than asked for
  M44f worldToObject;
  Box3f worldBound;
  std::atomic<const GeometryPart*> loaded = nullptr;
  std::mutex mutex;  ///< held while it is being read
  std::unique_ptr<GeometryPart> made;
};

}  // namespace patina
