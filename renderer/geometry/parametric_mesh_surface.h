// SPDX-License-Identifier: Apache-2.0
// Patch and PatchMesh: bilinear and bicubic patches in any basis, plain or rational.
#pragma once

#include <array>
#include <memory>

#include "renderer/geometry/primvar.h"
#include "renderer/geometry/surface.h"

namespace patina {

/// The weights of the four control points along one direction of a patch, and their derivatives. (Bilinear:
/// two.)
class SplineBasis {
 public:
  using Weights = std::array<double, 4>;

  /// Linear interpolation between two points.
  SplineBasis();
  /// Entries that are sixths, halves or whole numbers to 1e-5 are taken as exactly that. If a patch ends
  /// where its neighbour `step` points on begins, the weights of the end are those of the neighbour's
  /// beginning, so that both evaluate to the same bits.
  explicit SplineBasis(const CubicBasis& basis);

  int points() const { return points_; }
  Weights at(double t) const;
  Weights derivative(double t) const;
  Weights secondDerivative(double t) const;
  /// A patch ends where its neighbour, `step` points on, begins: true of all bases of RI but "power".
  bool continuous() const { return continuous_; }
  /// Row k: the weights of Bezier point k, whose hull holds the patch. (Bilinear: the two points.)
  std::array<Weights, 4> bezier() const;

 private:
  int points_;
  std::array<Weights, 4> power_{};  ///< rows t^3 t^2 t 1
  Weights end_{};
  bool continuous_ = true;
};

/// One quad face per patch, row by row along u. Face (i, j) has the control points from (i * ustep, j *
/// vstep) on; varying values belong to patch corners, uniform ones to patches, vertex ones to control points
/// (RI 3.2, section 5.2); facevarying and facevertex ones are four per patch. Neighbouring patches agree bit
/// for bit on their common edge.
///
/// With "hpoint Pw" of positive weights the mesh is rational.
class ParametricMeshSurface final : public Surface {
 public:
  static std::unique_ptr<ParametricMeshSurface> make(const ParametricMesh& mesh, const Primitive& primitive,
                                                     ErrorHandler& errors);

  uint32_t faceCount() const override {
    return static_cast<uint32_t>(patchesU_) * static_cast<uint32_t>(patchesV_);
  }
  FaceShape faceShape(uint32_t) const override { return FaceShape::Quad; }
  bool isFlat() const override { return flat_; }
  void corners(uint32_t face, V3f out[4]) const override;
  SurfacePoint evaluate(uint32_t face, float u, float v) const override;
  void evaluateMany(uint32_t face, std::span<const V2f> uv, std::span<SurfacePoint> out) const override;
  void interpolate(const PrimVar& variable, uint32_t face, float u, float v, float* out) const override;
  uint32_t uniformIndex(uint32_t face) const override { return face; }
  V2f surfaceParameters(uint32_t face, float u, float v) const override;
  V2f parameterScale(uint32_t) const override {
    return {1 / static_cast<float>(patchesU_), 1 / static_cast<float>(patchesV_)};
  }
  Box3f bound() const override { return bound_; }
  void evaluateGrid(uint32_t face, std::span<const double> u, std::span<const double> v,
                    std::span<V3f> out) const override;

 private:
  using Weights = SplineBasis::Weights;
  struct Hpoint {
    double x, y, z, w;
  };
  /// Control points of one patch; rational ones with their weight multiplied in.
  struct Control {
    std::array<Hpoint, 16> point;
  };
  struct Jet {
    V3d P, du, dv;
  };

  ParametricMeshSurface() = default;
  uint32_t pointIndex(uint32_t face, int column, int row) const;
  Control gather(uint32_t face) const;
  using Rows = std::array<Hpoint, 4>;
  Rows alongU(const Control& control, const Weights& u) const;
  Hpoint alongV(const Rows& rows, const Weights& v) const;
  V3d project(const Hpoint& h) const {
    return rational_ ? V3d(h.x / h.w, h.y / h.w, h.z / h.w) : V3d(h.x, h.y, h.z);
  }
  Jet jet(const Control& control, double u, double v) const;
  SurfacePoint evaluate(const Control& control, double u, double v) const;
  Box3f computeBound() const;
  bool isParallelogram(uint32_t face) const;

  SplineBasis u_, v_;
  int nu_ = 0, nv_ = 0, stepU_ = 1, stepV_ = 1, patchesU_ = 0, patchesV_ = 0;
  bool periodicU_ = false, periodicV_ = false, rational_ = false, flat_ = false;
  const float* points_ = nullptr;  ///< 3 or, rational, 4 floats each
  Box3f bound_;
};

}  // namespace patina
