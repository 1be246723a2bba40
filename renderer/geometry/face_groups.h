// SPDX-License-Identifier: Apache-2.0
// Groups of neighbouring faces that are smaller than a micropolygon: what patches are made of where faces are
// too small to be patches of their own.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "renderer/geometry/surface.h"

namespace patina {

/// Faces side by side whose normals lie within kGroupNormals of one another's first, in a box of about a
/// micropolygon; or groups of such groups, of 4 and of 16 times that extent. One value stands for all of it:
/// that of a face chosen by chance, in proportion to area, so that the mean over many groups is right.
struct FaceGroup {
  uint32_t face = kNone;     ///< that stands for all
  float spacing = 0;         ///< diagonal of the group's box, world units
  uint32_t coarser = kNone;  ///< index of the group on the next level that this one is in
};

inline constexpr int kGroupLevels = 3;
inline constexpr float kGroupNormals = 30;  ///< degrees
/// Diagonal of a group's box in edges of a micropolygon: at 1.75, groups on a smooth surface cover about one
/// micropolygon each.
inline constexpr float kGroupExtent = 1.75f;

struct FaceGroups {
  std::vector<FaceGroup> levels[kGroupLevels];  ///< finest first
  bool empty() const { return levels[0].empty(); }
};

/// The groups of the faces that are `small`; `edge` is the length of a micropolygon's edge near a face, world
/// units. Both are asked from many threads. `order` holds every face once, neighbours near each other.
/// `groupOf`, by face, gets the index of each such face's group among levels[0], and is left alone elsewhere.
/// Random choices are hashed from face numbers; the result does not depend on threads. `objectToWorld` may be
/// any affine matrix.
FaceGroups groupFaces(const Surface& surface, const M44f& objectToWorld, std::span<const uint32_t> order,
                      const std::function<bool(uint32_t)>& small, const std::function<float(uint32_t)>& edge,
                      std::span<uint32_t> groupOf);

}  // namespace patina
