// SPDX-License-Identifier: Apache-2.0
// The surface of a Blobby's field as a closed mesh of triangles.
#pragma once

#include <array>
#include <vector>

#include "renderer/geometry/blobby_field.h"

namespace patina {

struct BlobbyMesh {
  struct Vertex {
    V3f P;
    V3f N;  ///< unit, to the outside, which is where the field is less; object space
  };
  std::vector<Vertex> vertices;
  std::vector<std::array<uint32_t, 3>> triangles;  ///< (P1-P0) x (P2-P0) points to the outside
  std::vector<LeafWeight> weights;    ///< shares of the fields: those of vertex v begin at weightStart[v]
  std::vector<uint32_t> weightStart;  ///< one more than vertices; empty: not asked for
  size_t cells = 0;                   ///< cubes that the surface passes through
};

struct BlobbyMeshLimits {
  size_t cells = size_t{1} << 20;  ///< cubes that the surface passes through
  size_t work = size_t{1} << 30;   ///< operations on fields
};

enum class BlobbyMeshStatus { Done, TooManyCells, TooMuchWork };

/// Meshes the surface by marching tetrahedra: a lattice of cubes with edges of length `cell` (object space),
/// each cut into six tetrahedra around its diagonal (H. Freudenthal 1942, H. W. Kuhn 1960). The cuts of
/// neighbouring cubes agree on their common face, and each tetrahedron parts its corners inside from those
/// outside by a triangle or by two, so that every edge has exactly two triangles. Vertices are where the
/// field has the threshold on the tetrahedra's edges, but for the thousandth of an edge at its ends.
///
/// Only cubes near the surface are visited: an octree leaves out the boxes in which the field cannot have the
/// threshold. What lies between the lattice's points may be missed if it is smaller than a cube. Where a
/// repelling plane makes an end of what has none, the mesh is closed at the bounds of the other fields.
BlobbyMeshStatus meshBlobby(const BlobbyField& field, double cell, bool wantWeights,
                            const BlobbyMeshLimits& limits, BlobbyMesh& mesh);

}  // namespace patina
