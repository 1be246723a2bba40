// SPDX-License-Identifier: Apache-2.0
// How many values a primitive variable has: RI 3.2's rule for each class on each kind of primitive.
#pragma once

#include <cstddef>
#include <vector>

#include "renderer/scene/scene.h"

namespace patina {

struct ValueCounts {
  size_t uniform = 1;
  size_t varying = 0;
  size_t vertex = 0;
  size_t faceVarying = 0;  ///< and facevertex

  size_t of(StorageClass storage) const;  ///< constant: 1
};

/// Counts for a shape whose numbers are consistent (see shapeProblem). `vertexCount`, the number of control
/// points, is used by shapes that do not define it themselves: PolygonMesh and SubdivisionMesh.
ValueCounts valueCounts(const Shape& shape, size_t vertexCount);

/// Patches of a mesh along one side that has `count` control points; 0 when there are too few, or some are
/// left over.
int patchCount(bool bicubic, int count, int step, bool periodic);

/// One more than the largest index; 0 for none.
size_t highestIndex(const std::vector<int>& vertices);

}  // namespace patina
