// SPDX-License-Identifier: Apache-2.0
// Meshes of polygons as the scene has them, for tests.
#pragma once

#include <numeric>
#include <utility>
#include <vector>

#include "renderer/scene/scene.h"

namespace patina {

/// PointsPolygons without holes.
inline Primitive meshPrimitive(std::vector<float> points, std::vector<int> counts,
                               std::vector<int> vertices) {
  Primitive p;
  p.shape = PolygonMesh{std::vector<int>(counts.size(), 1), std::move(counts), std::move(vertices)};
  PrimVar v;
  v.name = "P", v.storage = StorageClass::Vertex, v.type = ValueType::Point, v.components = 3;
  v.floats = std::move(points);
  p.variables.push_back(std::move(v));
  return p;
}

inline Primitive polygonPrimitive(std::vector<float> points) {
  std::vector<int> vertices(points.size() / 3);
  std::iota(vertices.begin(), vertices.end(), 0);
  const auto n = static_cast<int>(vertices.size());
  return meshPrimitive(std::move(points), {n}, std::move(vertices));
}

}  // namespace patina
