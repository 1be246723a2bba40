// SPDX-License-Identifier: Apache-2.0
// Subdivision meshes that several tests use.
#pragma once

#include "tests/unit/geometry_surface_fixtures.h"

namespace patina::test {

inline const std::vector<float> kCubePoints{-1, -1, -1, 1, -1, -1, -1, 1, -1, 1, 1, -1,
                                            -1, -1, 1,  1, -1, 1,  -1, 1, 1,  1, 1, 1};
inline const std::vector<int> kCubeFaces{0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4,
                                         2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};

inline SubdivisionMesh cube(std::vector<SubdivisionMesh::Tag> tags = {}) {
  return {"catmull-clark", {4, 4, 4, 4, 4, 4}, kCubeFaces, std::move(tags)};
}

/// A prism over an n-gon: two n-gons and n quads.
inline Primitive prism(int n, std::vector<SubdivisionMesh::Tag> tags = {}) {
  SubdivisionMesh mesh{"catmull-clark", {n, n}, {}, std::move(tags)};
  std::vector<float> P;
  for (int z = 0; z < 2; ++z)
    for (int i = 0; i < n; ++i) {
      const float a = 2 * kPi * static_cast<float>(i) / static_cast<float>(n);
      P.insert(P.end(), {std::cos(a), std::sin(a) * 1.3f, 2.0f * static_cast<float>(z)});
    }
  for (int i = 0; i < n; ++i) mesh.vertices.push_back(n - 1 - i);
  for (int i = 0; i < n; ++i) mesh.vertices.push_back(n + i);
  for (int i = 0; i < n; ++i) {
    mesh.vertsPerFace.push_back(4);
    const int j = (i + 1) % n;
    mesh.vertices.insert(mesh.vertices.end(), {i, j, n + j, n + i});
  }
  return primitive(std::move(mesh), std::move(P));
}

/// A grid of (nu-1) x (nv-1) quads over the plane with some height.
inline Primitive sheet(int nu, int nv, std::vector<SubdivisionMesh::Tag> tags) {
  SubdivisionMesh mesh{"catmull-clark", {}, {}, std::move(tags)};
  std::vector<float> P;
  for (int j = 0; j < nv; ++j)
    for (int i = 0; i < nu; ++i)
      P.insert(P.end(), {static_cast<float>(i), static_cast<float>(j),
                         static_cast<float>((i * 7 + j * 5) % 4) * 0.4f});
  for (int j = 0; j + 1 < nv; ++j)
    for (int i = 0; i + 1 < nu; ++i) {
      const int v = j * nu + i;
      mesh.vertsPerFace.push_back(4);
      mesh.vertices.insert(mesh.vertices.end(), {v, v + 1, v + nu + 1, v + nu});
    }
  return primitive(std::move(mesh), std::move(P));
}

// The limit of a vertex of valence n between quads is (n^2 v + 4 sum of edge neighbours + sum of face

}  // namespace patina::test
