// SPDX-License-Identifier: Apache-2.0
// Rays against solids: along a ray, from one crossing of the operands' surfaces to the next, until the ray
// gets into the result or out of it (S. D. Roth, "Ray Casting for Modeling Solids", 1982).
#pragma once

#include <embree3/rtcore.h>

#include "renderer/accel/embree_scene.h"

namespace patina {

struct QueryContext;

/// The filter of a solid's scene: notes every hit, and goes on.
void collectCrossings(const RTCFilterFunctionNArguments* args);

/// The first surface of a solid's result within the ray, by `scene`, which holds the surfaces of all operands
/// and was made with collectCrossings. If there is one, shortens the ray and sets its hit as Embree does, but
/// for u and v, which are those of `face`.
///
/// Where a ray begins is known from what it meets afterwards, so that rays may begin on a surface: a leaf
/// whose inside it meets first is one that it is inside of. Crossings whose distances agree within their
/// error are one place: what is there ahead of it and behind it counts, not what is between. So a face that
/// an operand shares with the one that it is taken from is not there, nor is one that two united operands
/// share from both sides, and an edge that is met on both its facets, or grazed, is no way in or out. Of
/// several surfaces that bound the result in one place the first in the order of the RIB is met.
bool intersectSolid(const EmbreeScene& scene, uint32_t solid, const QueryContext& query, RTCRayHit& ray,
                    FaceOwner& face);

/// Whether there is one: then ray.tfar is -infinity.
void occludeBySolid(const EmbreeScene& scene, uint32_t solid, const QueryContext& query, RTCRay& ray);

}  // namespace patina
