// SPDX-License-Identifier: Apache-2.0
// The origin of the space that is rendered in.
#pragma once

#include <optional>

#include "renderer/scene/scene.h"

namespace patina {

/// Where the origin had better be: the middle of what stands in the world, where all of that is far from the
/// world's origin in relation to its own extent. Positions are floats in world space, and so they are known
/// to 6e-8 of their distance from the origin. Nothing: it may stay. (PBR 4th ed. section 5.1.1 moves it
/// always, to the camera, which is far away itself where it has a long lens.) Nor is it moved where
/// transformations of primitives or instances move.
std::optional<V3d> betterOrigin(const Scene& scene);

/// Makes `origin`, a point of world space, the origin; nothing but the camera may be under a moving
/// transformation. What the scene calls the world is moved; the coordinate system "world" remembers where it
/// was. Before anything is made of the scene. Delayed archives follow when they are read.
void moveOrigin(Scene& scene, const V3d& origin);

}  // namespace patina
