// SPDX-License-Identifier: Apache-2.0
// Boxes around geometry.
#pragma once

#include "renderer/base/math.h"
#include "renderer/scene/scene.h"

namespace patina {

/// Faces of a flat surface that is traced from the beginning: nothing would be saved.
inline constexpr uint32_t kFewFaces = 64;

Box3f transformed(const Box3f& box, const M44f& m);

/// Widened by what the rounding of points and of their transformation may add.
Box3f padded(const Box3f& box);

/// The hull of the points of a mesh, which holds its faces and its limit surface, without making them. Empty:
/// not a mesh, or so small that it is made at once.
Box3f meshBound(const Primitive& primitive);

}  // namespace patina
