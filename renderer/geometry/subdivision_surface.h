// SPDX-License-Identifier: Apache-2.0
// Subdivision meshes: Catmull-Clark, Loop and bilinear limit surfaces by OpenSubdiv's Bfr.
#pragma once

#include <memory>

#include "renderer/geometry/surface.h"

namespace patina {

/// The limit surface of a subdivision mesh, all faces quads:
/// * Catmull-Clark and bilinear: a base face of four sides is one face, (0,0) its first vertex and u towards
/// its second. A base
///   face of n sides is n faces, one for each vertex: (0,0) the vertex, u towards the next vertex and v
///   towards the previous one, (1,1) the middle of the base face (Bfr's QUAD_SUBFACES, normalised).
/// * Loop: a triangle is three such faces.
/// Holes, and boundary faces without interpolateboundary, have no surface.
///
/// Variables: vertex ones by the limit rule; varying ones bilinear over the base face; facevarying ones as
/// well, unless the tag facevaryinginterpolateboundary asks for less (0 bilinear, 1 corners and edges, 2
/// edges only, 3 boundaries sharp); facevertex ones by that rule (default 1). u, v of RI are those of the
/// face.
///
/// A mesh that has no limit surface (loop with faces that are no triangles, vertices or faces of more than
/// kMaxValence edges, topology that OpenSubdiv refuses) becomes polygons, with a warning; single faces that
/// make no sense are left out.
std::unique_ptr<Surface> makeSubdivisionSurface(const SubdivisionMesh& mesh, const Primitive& primitive,
                                                ErrorHandler& errors);

}  // namespace patina
