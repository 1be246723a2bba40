// SPDX-License-Identifier: Apache-2.0
// Runs surface shaders over points: gathers the channels that a shader asks for into batches, calls its entry
// points, and checks what comes back.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "renderer/geometry/geometry.h"
#include "renderer/shading/shader_instance.h"
#include "renderer/shading/shading_point.h"
#include "renderer/shading/surface_batch.h"

namespace patina {

/// Which entry points to run.
enum class ShadingParts { Radiosity, RadiosityAndView };

class SurfaceShading {
 public:
  /// `surfaces[k]` is the shader of Scene::shaders[k] (nullptr: not a surface), the last one the default
  /// surface. Everything must outlive this object. [main]
  SurfaceShading(const Geometry& geometry, std::vector<const ShaderInstance*> surfaces);
  ~SurfaceShading();

  /// The point where a ray of unit direction `direction` met a surface; `footprint` is the ray's width there.
  ShadingPoint at(const Hit& hit, const V3f& direction, float footprint) const;
  /// A point of a side of a surface, for what is seen from no direction in particular.
  ShadingPoint at(uint32_t placement, uint32_t face, float u, float v, bool front, float footprint) const;

  /// Shades points in batches of one shader each. Emission, reflectance ... are those of RadiosityOut, lobes
  /// and viewEmission those of ViewOut. [any thread]
  void shade(std::span<const ShadingPoint> points, ShadingParts parts, ShadedPoints& out) const;

  const ShaderInstance& shaderOf(uint32_t placement) const { return *surfaces_[shaderIndex_[placement]]; }
  /// Nothing can be seen through the placement: no opacity need be asked for.
  bool isOpaque(uint32_t placement) const { return opaque_[placement]; }
  bool allOpaque() const { return allOpaque_; }

 private:
  struct Statistics;
  void shadeBatch(uint32_t shader, std::span<const ShadingPoint> points, std::span<const uint32_t> which,
                  ShadingParts parts, ShadedPoints& out) const;
  void orient(ShadingPoint& point) const;

  const Geometry& geometry_;
  std::vector<const ShaderInstance*> surfaces_;
  std::vector<std::unique_ptr<Statistics>> statistics_;  ///< by shader
  std::vector<SurfaceVariables> variables_;              ///< by traced surface
  std::vector<uint32_t> shaderIndex_;                    ///< by placement
  std::vector<bool> opaque_;                             ///< by placement
  bool allOpaque_ = true;
};

}  // namespace patina
