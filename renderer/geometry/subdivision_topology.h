// SPDX-License-Identifier: Apache-2.0
// The topology of a subdivision mesh, checked and in OpenSubdiv's form.
#pragma once

#include <opensubdiv/far/topologyRefiner.h>

#include <memory>
#include <vector>

#include "renderer/geometry/primvar.h"

namespace patina {

/// Vertices and faces with more edges than this have no limit surface here: the cost of one grows with the
/// square.
inline constexpr int kMaxValence = 128;

struct SubdivisionTopology {
  /// A variable with values at face corners that are interpolated smoothly; equal values around a vertex are
  /// one value.
  struct Channel {
    const PrimVar* variable;
    /// For each value, a corner (index into SubdivisionMesh::vertices) that has it.
    std::vector<uint32_t> cornerOf;
  };

  std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> refiner;  ///< not refined: only the base level
  bool asPolygons = false;            ///< no refiner, but the faces can be rendered as they are
  std::vector<uint32_t> requestFace;  ///< number in the request of each base face; empty: the same
  std::vector<uint32_t> firstCorner;  ///< of each base face: index into SubdivisionMesh::vertices
  std::vector<Channel> channels;      ///< face-varying channels of the refiner

  size_t memory() const;
};

/// Reports what is wrong to `errors`; `refiner` is null when there is nothing that can be subdivided. Faces
/// that make no sense and tags that do not fit are left out with a warning.
SubdivisionTopology buildTopology(const SubdivisionMesh& mesh, const Primitive& primitive, size_t pointCount,
                                  ErrorHandler& errors);

}  // namespace patina
