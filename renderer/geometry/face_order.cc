// SPDX-License-Identifier: Apache-2.0
// Morton order of faces.
#include "renderer/geometry/face_order.h"

#include <tbb/parallel_sort.h>
#include <tbb/task_arena.h>

#include <bit>
#include <numeric>

#include "renderer/base/parallel.h"

namespace patina {
namespace {

constexpr size_t kGrain = size_t{1} << 14;

/// The lowest 21 bits of v, with two zeros behind each.
uint64_t spread(uint64_t v) {
  v &= 0x1fffff;
  v = (v | v << 32) & 0x1f00000000ffffu;
  v = (v | v << 16) & 0x1f0000ff0000ffu;
  v = (v | v << 8) & 0x100f00f00f00f00fu;
  v = (v | v << 4) & 0x10c30c30c30c30c3u;
  return (v | v << 2) & 0x1249249249249249u;
}

}  // namespace

void forEachPart(size_t count, size_t grain, const std::function<void(size_t, size_t)>& run) {
  const size_t parts = (count + grain - 1) / grain;
  const auto part = [&](size_t k) { run(k * grain, std::min(count, (k + 1) * grain)); };
  if (parts == 1) part(0);
  if (parts > 1) tbb::this_task_arena::isolate([&] { parallelFor(size_t{0}, parts, part); });
}

std::vector<uint32_t> mortonOrder(const Surface& surface) {
  const size_t count = surface.faceCount();
  const PointView points = surface.sharedPoints();
  std::vector<uint32_t> order(count);
  if (count < 2 || points.size() == 0) {
    std::iota(order.begin(), order.end(), 0u);
    return order;
  }
  // A key is the code with the face's number below it; the codes have as many bits as there is room for.
  const auto faceBits = static_cast<uint32_t>(std::bit_width(count - 1));
  const uint32_t bits = std::min((64 - faceBits) / 3, 21u);
  const Box3f box = surface.bound();
  const V3f size = box.size();
  const float cells = static_cast<float>(uint64_t{1} << bits) / std::max(maxComponent(size), 1e-30f);
  const float last = static_cast<float>((uint64_t{1} << bits) - 1);
  std::vector<uint64_t> keys(count);
  forEachPart(count, kGrain, [&](size_t begin, size_t end) {
    for (size_t face = begin; face < end; ++face) {
      uint32_t corner[4];
      surface.cornerPoints(static_cast<uint32_t>(face), corner);
      const bool quad = surface.faceShape(static_cast<uint32_t>(face)) == FaceShape::Quad;
      V3f sum = points[corner[0]] - box.min;
      for (int k = 1; k < (quad ? 4 : 3); ++k) sum += points[corner[k]] - box.min;
      const V3f p = sum * (cells / (quad ? 4.0f : 3.0f));
      uint64_t code = 0;
      for (int k = 0; k < 3; ++k) code |= spread(static_cast<uint64_t>(std::clamp(p[k], 0.0f, last))) << k;
      keys[face] = code << faceBits | face;
    }
  });
  tbb::this_task_arena::isolate([&] {
    const LoopHandover loop;
    tbb::parallel_sort(keys.begin(), keys.end());
  });
  const uint64_t mask = (uint64_t{1} << faceBits) - 1;
  forEachPart(count, kGrain, [&](size_t begin, size_t end) {
    for (size_t k = begin; k < end; ++k) order[k] = static_cast<uint32_t>(keys[k] & mask);
  });
  return order;
}

std::vector<Box3f> boundsOfParts(const Surface& surface, std::span<const uint32_t> order, size_t size) {
  std::vector<Box3f> bounds((order.size() + size - 1) / size);
  forEachPart(order.size(), size, [&](size_t begin, size_t end) {
    Box3f& box = bounds[begin / size];
    for (size_t k = begin; k < end; ++k) {
      V3f p[4];
      surface.corners(order[k], p);
      const bool quad = surface.faceShape(order[k]) == FaceShape::Quad;
      for (int c = 0; c < (quad ? 4 : 3); ++c) box.extendBy(p[c]);
    }
  });
  return bounds;
}

}  // namespace patina
