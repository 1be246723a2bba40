// SPDX-License-Identifier: Apache-2.0
// The faces of a dense mesh in an order in which neighbours in space stand near each other.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "renderer/geometry/surface.h"

namespace patina {

/// Faces by the Morton code (Morton 1966) of their centroids in object space, equal codes by their numbers;
/// for surfaces with sharedPoints(), else as they are numbered. On all threads, with the same result for any
/// number of them.
std::vector<uint32_t> mortonOrder(const Surface& surface);

/// Bounds, in object space, of the faces order[k * size] ... order[(k + 1) * size - 1] for each k. The last
/// part may be shorter.
std::vector<Box3f> boundsOfParts(const Surface& surface, std::span<const uint32_t> order, size_t size);

/// run(begin, end) over the parts of [0, count), of `grain` each but the last, on threads that do nothing
/// else meanwhile: the caller may hold locks that tasks of others wait for.
void forEachPart(size_t count, size_t grain, const std::function<void(size_t, size_t)>& run);

}  // namespace patina
