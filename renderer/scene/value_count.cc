// SPDX-License-Identifier: Apache-2.0
// Counts of primitive variables' values.
#include "renderer/scene/value_count.h"

#include <numeric>

namespace patina {
namespace {

size_t sum(const std::vector<int>& counts) {
  return std::accumulate(counts.begin(), counts.end(), size_t{0},
                         [](size_t total, int n) { return total + static_cast<size_t>(n); });
}

ValueCounts countsOf(const PolygonMesh& mesh, size_t vertexCount) {
  return {mesh.faceCount(), vertexCount, vertexCount,
          mesh.sides > 0 ? mesh.vertices.size() : sum(mesh.vertsPerLoop)};
}

ValueCounts countsOf(const SubdivisionMesh& mesh, size_t vertexCount) {
  return {mesh.vertsPerFace.size(), vertexCount, vertexCount, mesh.vertices.size()};
}

ValueCounts countsOf(const Quadric&, size_t) { return {1, 4, 4, 4}; }

ValueCounts countsOf(const ParametricMesh& mesh, size_t) {
  const auto along = [&](int count, int step, bool periodic) {
    const auto patches = static_cast<size_t>(patchCount(mesh.bicubic, count, step, periodic));
    return std::pair(patches, patches + (periodic ? 0 : 1));
  };
  const auto [patchesU, cornersU] = along(mesh.nu, mesh.basisU.step, mesh.periodicU);
  const auto [patchesV, cornersV] = along(mesh.nv, mesh.basisV.step, mesh.periodicV);
  return {patchesU * patchesV, cornersU * cornersV,
          static_cast<size_t>(mesh.nu) * static_cast<size_t>(mesh.nv), 4 * patchesU * patchesV};
}

ValueCounts countsOf(const CurveSet& curves, size_t) {
  ValueCounts counts{curves.vertexCounts.size(), 0, 0, 0};
  for (const int points : curves.vertexCounts) {
    const auto segments =
        static_cast<size_t>(patchCount(curves.cubic, points, curves.basis.step, curves.periodic));
    counts.varying += segments + (curves.periodic ? 0 : 1);
    counts.vertex += static_cast<size_t>(std::max(points, 0));
  }
  counts.faceVarying = counts.varying;
  return counts;
}

// RI 3.2, NuPatch: 1 + n - order segments along a side, those without a length among them.
ValueCounts countsOf(const NurbsPatch& patch, size_t) {
  const auto segments = [](const SplineKnots& s) {
    return static_cast<size_t>(std::max(int64_t{1} + s.count - s.order, int64_t{0}));
  };
  const size_t u = segments(patch.u), v = segments(patch.v);
  return {u * v, (u + 1) * (v + 1),
          static_cast<size_t>(std::max(patch.u.count, 0)) * static_cast<size_t>(std::max(patch.v.count, 0)),
          4 * u * v};
}

ValueCounts countsOf(const PointSet& points, size_t) { return {1, points.count, points.count, points.count}; }

ValueCounts countsOf(const Blobby& blobby, size_t) {
  return {1, blobby.leaves, blobby.leaves, blobby.leaves};
}

}  // namespace

size_t ValueCounts::of(StorageClass storage) const {
  switch (storage) {
    case StorageClass::Constant:
      return 1;
    case StorageClass::Uniform:
      return uniform;
    case StorageClass::Varying:
      return varying;
    case StorageClass::Vertex:
      return vertex;
    case StorageClass::FaceVarying:
    case StorageClass::FaceVertex:
      return faceVarying;
  }
  return 1;
}

ValueCounts valueCounts(const Shape& shape, size_t vertexCount) {
  return std::visit([&](const auto& kind) { return countsOf(kind, vertexCount); }, shape);
}

int patchCount(bool bicubic, int count, int step, bool periodic) {
  if (count < 2) return 0;
  if (!bicubic) return periodic ? count : count - 1;
  const int span = periodic ? count : count - 4;
  if (count < 4 || step < 1 || span % step != 0) return 0;
  return periodic ? span / step : span / step + 1;
}

size_t highestIndex(const std::vector<int>& vertices) {
  const auto highest = std::max_element(vertices.begin(), vertices.end());
  return highest == vertices.end() ? 0 : static_cast<size_t>(*highest) + 1;
}

}  // namespace patina
