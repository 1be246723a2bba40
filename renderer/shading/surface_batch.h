// SPDX-License-Identifier: Apache-2.0
// A batch of surface points as a plugin's entry points get it: the channels and parameters that it reads.
#pragma once

#include <functional>
#include <vector>

#include "renderer/geometry/surface.h"
#include "renderer/shading/planes.h"
#include "renderer/shading/shader_instance.h"
#include "renderer/shading/shader_validation.h"

namespace patina {

/// The primitive variables of a surface that channels and parameters come from.
struct SurfaceVariables {
  const PrimVar *N = nullptr, *Cs = nullptr, *Os = nullptr, *s = nullptr, *t = nullptr, *st = nullptr;
  bool others = false;  ///< has variables that may be shader parameters

  explicit SurfaceVariables(const Primitive& primitive);
};

/// A lane of a batch. World space.
struct BatchPoint {
  const Primitive* primitive;
  const SurfaceVariables* variables;
  const Surface* surface;
  const Attributes* attributes;
  uint32_t face;
  float u, v;  ///< of the face
  V3f P, N, Ng;
  float footprint;
};

/// Scratch memory for one batch at a time, to be kept by each thread.
class SurfaceBatch {
 public:
  /// Derivatives of P by the face's u and v at a lane, world space. Asked for when a shader reads them.
  using Derivatives = std::function<void(size_t lane, V3f& dPdu, V3f& dPdv)>;

  /// Begins a batch of n points, to be filled by the caller.
  std::vector<BatchPoint>& begin(size_t n) {
    points_.resize(n);
    planes_.begin(n, validatesShaders());
    return points_;
  }
  /// What entry points of `shader` that read the channels `reads` get of the points. `I` is left out. Valid
  /// until the next begin().
  PatinaPoints fill(const ShaderInstance& shader, uint64_t reads, const Derivatives& derivatives);
  /// For outputs, and channels added by the caller.
  Planes& planes() { return planes_; }

 private:
  void fillTextureCoordinates(PatinaPoints& in);
  void fillDerivatives(uint64_t reads, const Derivatives& derivatives, PatinaPoints& in);
  std::span<const PatinaValue> fillParameters(const ShaderInstance& shader);
  bool replaceParameter(const ShaderInstance::VaryingParameter& parameter, const PatinaValue& constant,
                        PatinaValue& varying);

  Planes planes_;
  std::vector<BatchPoint> points_;
  std::vector<V3f> du_, dv_, ds_, dt_;  // du_, dv_: by the surface's parameters
  std::vector<V2f> uv_, st_;
  std::vector<PatinaValue> changed_;
};

}  // namespace patina
