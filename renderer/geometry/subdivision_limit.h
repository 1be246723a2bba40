// SPDX-License-Identifier: Apache-2.0
// The limit surface itself: Bfr surfaces of single faces, prepared once per thread and reused while the face
// stays the same.
#pragma once

#include <opensubdiv/bfr/refinerSurfaceFactory.h>

#include <array>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <vector>

#include "renderer/geometry/subdivision_topology.h"
#include "renderer/geometry/surface.h"

namespace patina {

/// One face of the surface: a base face, or the part of it around one vertex.
struct SubdivisionFace {
  static constexpr uint32_t kWhole = 0xffffffffu;
  uint32_t base;
  uint32_t part;  ///< number of the vertex; kWhole = a quad
};

/// Bfr's patches for irregular neighbourhoods, each made once for all faces that look alike: about 30 KB
/// each, at most kLimit of them. Faces beyond (a mesh with thousands of different sharpnesses) make theirs
/// again each time.
class PatchCache final : public OpenSubdiv::Bfr::SurfaceFactoryCache {
 protected:
  static constexpr size_t kLimit = 4096;

  DataType Find(const KeyType& key) const override {
    const std::shared_lock lock(mutex_);
    return find(key);
  }
  DataType Add(const KeyType& key, const DataType& data) override {
    const std::unique_lock lock(mutex_);
    return Size() < kLimit ? add(key, data) : data;
  }

 private:
  mutable std::shared_mutex mutex_;
};

class SubdivisionSurface final : public Surface {
 public:
  SubdivisionSurface(SubdivisionTopology topology, PointView points);

  uint32_t faceCount() const override;
  FaceShape faceShape(uint32_t) const override { return FaceShape::Quad; }
  bool isFlat() const override { return false; }
  void corners(uint32_t face, V3f out[4]) const override;
  SurfacePoint evaluate(uint32_t face, float u, float v) const override;
  void evaluateMany(uint32_t face, std::span<const V2f> uv, std::span<SurfacePoint> out) const override;
  void interpolate(const PrimVar& variable, uint32_t face, float u, float v, float* out) const override;
  uint32_t uniformIndex(uint32_t face) const override;
  V2f surfaceParameters(uint32_t, float u, float v) const override { return {u, v}; }
  V2f parameterScale(uint32_t) const override { return {1, 1}; }
  Box3f bound() const override { return bound_; }
  void evaluateGrid(uint32_t face, std::span<const double> u, std::span<const double> v,
                    std::span<V3f> out) const override;
  Side sideOf(uint32_t face, uint32_t side) const override;
  void weld(const SurfaceRates& rates, std::span<const uint32_t> first,
            std::span<V3f> vertices) const override;

 private:
  using BfrSurface = OpenSubdiv::Bfr::Surface<double>;
  using Factory = OpenSubdiv::Bfr::RefinerSurfaceFactory<PatchCache>;

  static constexpr uint32_t kPositions = 0xffffffffu;  ///< in place of a face-varying channel

  /// A base face ready to be evaluated.
  struct Prepared {
    uint64_t owner = 0;
    uint32_t base = 0, channel = 0;
    BfrSurface surface;
    std::vector<int> indices;     ///< of the control points
    bool cubic = false;           ///< positions are one bicubic polynomial
    std::array<V3d, 16> power;    ///< then: coefficient of u^i v^j at 4 j + i
    std::vector<double> points;   ///< else: patch points
    std::vector<double> stencil;  ///< at (u, v), for variables
    double u = -1, v = -1;
  };
  /// A place on a base face and how it moves with the face's u and v.
  struct Place {
    double uv[2], du[2], dv[2];
  };
  struct Jet {
    V3d P, du, dv;
  };

  SubdivisionFace faceAt(uint32_t face) const;
  int baseSize(uint32_t base) const {
    return refiner().GetLevel(0).GetFaceVertices(static_cast<int>(base)).size();
  }
  const OpenSubdiv::Far::TopologyRefiner& refiner() const { return *topology_.refiner; }
  Prepared& prepare(uint32_t base, uint32_t channel) const;
  void preparePositions(Prepared& prepared) const;
  Place place(const BfrSurface& surface, const SubdivisionFace& face, double u, double v) const;
  Jet jet(const Prepared& prepared, const SubdivisionFace& face, double u, double v) const;
  SurfacePoint evaluate(const Prepared& prepared, const SubdivisionFace& face, double u, double v) const;
  void interpolateLinear(const PrimVar& variable, const SubdivisionFace& face, double u, double v,
                         float* out) const;
  void interpolateLimit(const PrimVar& variable, uint32_t channel, const SubdivisionFace& face, double u,
                        double v, float* out) const;

  SubdivisionTopology topology_;
  PointView points_;
  Factory factory_;
  uint64_t id_;  ///< unlike a pointer never reused
  bool plain_;   ///< face i is base face i, a quad: faces_ is empty
  std::vector<SubdivisionFace> faces_;
  bool loop_;
  Box3f bound_;
};

}  // namespace patina
