// SPDX-License-Identifier: Apache-2.0
// Runs displacement shaders over the vertices of tessellations.
#pragma once

#include <memory>
#include <span>

#include "renderer/base/stable_vector.h"
#include "renderer/geometry/displacement.h"
#include "renderer/shading/shader_instance.h"

namespace patina {

class DisplacementShading final : public Displacer {
 public:
  /// `shaders[k]` is the shader of Scene::shaders[k] (nullptr: none). They must outlive this object. [main]
  /// `grows`: others will come.
  DisplacementShading(std::span<const ShaderInstance* const> shaders, bool grows);
  ~DisplacementShading() override;

  // When shaders come with delayed archives. [one thread at a time; others may displace by those known]
  void growTo(size_t shaders);
  /// A shader that nothing has been bound to.
  void setShader(uint32_t shader, const ShaderInstance* instance);

  /// Whether any of `attributes` displaces: else nothing needs this object.
  bool isNeeded(const Scene& scene) const;

  std::optional<Bound> boundOf(const Attributes& attributes) const override;
  bool displace(const Vertices& vertices) const override;

 private:
  struct Statistics;
  StableVector<const ShaderInstance*> shaders_;
  StableVector<std::unique_ptr<Statistics>> statistics_;  ///< by shader
};

}  // namespace patina
