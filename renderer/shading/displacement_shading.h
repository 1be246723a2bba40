// SPDX-License-Identifier: Apache-2.0
// Runs displacement shaders over the vertices of tessellations.
#pragma once

#include <memory>
#include <vector>

#include "renderer/geometry/displacement.h"
#include "renderer/shading/shader_instance.h"

namespace patina {

class DisplacementShading final : public Displacer {
 public:
  /// `shaders[k]` is the shader of Scene::shaders[k] (nullptr: none). They must outlive this object. [main]
  explicit DisplacementShading(std::vector<const ShaderInstance*> shaders);
  ~DisplacementShading() override;

  /// Whether any of `attributes` displaces: else nothing needs this object.
  bool isNeeded(const Scene& scene) const;

  std::optional<Bound> boundOf(const Attributes& attributes) const override;
  bool displace(const Vertices& vertices) const override;

 private:
  struct Statistics;
  std::vector<const ShaderInstance*> shaders_;
  std::vector<std::unique_ptr<Statistics>> statistics_;  ///< by shader
};

}  // namespace patina
