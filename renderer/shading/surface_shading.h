// SPDX-License-Identifier: Apache-2.0
// Runs surface shaders over points: gathers the channels that a shader asks for into batches, calls its entry
// points, and checks what comes back.
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "renderer/geometry/geometry.h"
#include "renderer/shading/shader_instance.h"
#include "renderer/shading/shading_point.h"
#include "renderer/shading/surface_batch.h"

namespace patina {

/// Which entry points to run. Opacity: `radiosity`, unless the opacity is known without it; of the terms only
/// the opacity is to be used.
enum class ShadingParts { Opacity, Radiosity, RadiosityAndView };

class SurfaceShading {
 public:
  /// `surfaces[k]` is the shader of Scene::shaders[k] (nullptr: not a surface), the last one the default
  /// surface. Everything must outlive this object. [main]
  SurfaceShading(const Geometry& geometry, std::vector<const ShaderInstance*> surfaces);
  ~SurfaceShading();

  // When a part of the geometry is read. [one thread at a time; others may shade what is known]
  void growTo(size_t shaders);
  /// A shader that no placement has been bound to, because it was not loaded. Must outlive this object.
  void setShader(uint32_t shader, const ShaderInstance* instance);
  void append(const GeometryPart& part);

  /// The point where a ray of unit direction `direction` met a surface; `footprint` is the ray's width there.
  ShadingPoint at(const Hit& hit, const V3f& direction, float footprint) const;
  /// A point of a side of a surface, for what is seen from no direction in particular.
  ShadingPoint at(uint32_t placement, uint32_t face, float u, float v, bool front, float footprint) const;

  /// Shades points in batches of one shader each. Emission, reflectance ... are those of RadiosityOut, lobes
  /// and viewEmission those of ViewOut. [any thread]
  void shade(std::span<const ShadingPoint> points, ShadingParts parts, ShadedPoints& out) const;

  const ShaderInstance& shaderOf(uint32_t placement) const { return *surfaces_[shaderIndex_[placement]]; }
  /// Nothing can be seen through the placement: no opacity need be asked for.
  bool isOpaque(uint32_t placement) const { return opacity_[placement] == OpacityKind::Opaque; }
  /// Only a call of the shader tells the opacity: it is neither one, nor zero, nor the channel Os everywhere.
  bool isOpacityShaded(uint32_t placement) const { return opacity_[placement] == OpacityKind::Shaded; }
  /// Nothing that rays have met so far can be seen through: it may become false when a delayed archive is
  /// read.
  bool allOpaque() const { return allOpaque_.load(std::memory_order_relaxed); }

 private:
  struct Statistics;
  enum class OpacityKind : uint8_t { Opaque, Transparent, IsOs, Shaded };
  void shadeBatch(uint32_t shader, std::span<const ShadingPoint> points, std::span<const uint32_t> which,
                  ShadingParts parts, ShadedPoints& out) const;
  std::string placeOnSurface(const ShadingPoint& p) const;
  std::string placeOf(const ShadingPoint& p) const;
  void orient(ShadingPoint& point) const;

  const Geometry& geometry_;
  // In the renderer's numbers: shaders of Scene::shaders, the default surface, those of delayed archives.
  StableVector<const ShaderInstance*> surfaces_;
  StableVector<std::unique_ptr<Statistics>> statistics_;  ///< by shader
  std::map<const ShaderInstance*, uint32_t> firstOf_;     ///< the first of surfaces_ that is the instance
  uint32_t fallback_;                                     ///< the default surface
  StableVector<SurfaceVariables> variables_;              ///< by traced surface
  StableVector<uint32_t> shaderIndex_;                    ///< by placement
  StableVector<OpacityKind> opacity_;                     ///< by placement
  std::atomic<bool> allOpaque_ = true;
};

}  // namespace patina
