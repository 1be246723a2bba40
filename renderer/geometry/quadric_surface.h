// SPDX-License-Identifier: Apache-2.0
// The seven quadrics of RI: a profile swept about the z axis, each one quad face.
#pragma once

#include <memory>

#include "renderer/geometry/surface.h"

namespace patina {

/// Closed forms of RI 3.2, section 5.4, in double. Whole sweeps close bit for bit (angles are kept in degrees
/// and reduced exactly), and poles and apexes are single points. thetamax beyond +-360 is cut to that;
/// negative sweeps, descending z and negative radii follow the formulas, which turns dPdu x dPdv round.
///
/// Where dPdv is infinite (the tip of a paraboloid) it is cut to its value next to the tip.
class QuadricSurface final : public Surface {
 public:
  /// nullptr with an error when the quadric has no area or values that are not finite.
  static std::unique_ptr<QuadricSurface> make(const Quadric& quadric, const Primitive& primitive,
                                              ErrorHandler& errors);

  uint32_t faceCount() const override { return 1; }
  FaceShape faceShape(uint32_t) const override { return FaceShape::Quad; }
  bool isFlat() const override { return false; }
  void corners(uint32_t face, V3f out[4]) const override;
  SurfacePoint evaluate(uint32_t face, float u, float v) const override;
  void interpolate(const PrimVar& variable, uint32_t face, float u, float v, float* out) const override;
  uint32_t uniformIndex(uint32_t) const override { return 0; }
  V2f surfaceParameters(uint32_t, float u, float v) const override { return {u, v}; }
  V2f parameterScale(uint32_t) const override { return {1, 1}; }
  Box3f bound() const override { return bound_; }
  void evaluateGrid(uint32_t face, std::span<const double> u, std::span<const double> v,
                    std::span<V3f> out) const override;

 private:
  using Kind = Quadric::Kind;

  /// The curve that is swept, at theta = 0: (x, y, z), its derivative by v, and a normal before the sign of
  /// the sweep.
  struct Profile {
    V3d p, dv, n;
  };

  QuadricSurface() = default;
  Profile profile(double v) const;
  Box3f computeBound() const;

  Kind kind_ = Kind::Sphere;
  double theta_ = 360;  ///< degrees
  double a_[6] = {};    ///< by kind: radii, heights, points; angles in degrees (see make())
  Box3f bound_;
};

}  // namespace patina
