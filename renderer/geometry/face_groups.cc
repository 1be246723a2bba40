// SPDX-License-Identifier: Apache-2.0
// Grouping of faces by a walk along their order.
#include "renderer/geometry/face_groups.h"

#include <array>
#include <numbers>

#include "renderer/base/sampling.h"
#include "renderer/geometry/face_order.h"

namespace patina {
namespace {

constexpr size_t kBlock = size_t{1} << 16;  // items that are walked over as one: no group reaches beyond
constexpr size_t kOpen = 8;  // groups that the walk may still add to: sheets and folds interleave

/// What is put together: a face or a group.
struct Item {
  Box3f box;   // world space
  V3f normal;  // unit; of a group: of its first face
  float area = 0;
  float edge = 0;     // of a micropolygon there
  uint32_t face = 0;  // that stands for it
};

/// Walks over items and puts each into the group met last that it fits, of the kOpen groups met last, or into
/// a new one.
class Grouper {
 public:
  Grouper(float extent, uint32_t level) : extent_(extent), level_(level) {}
  std::vector<Item> groups;

  uint32_t add(const Item& item) {
    static const float kCosine = std::cos(kGroupNormals * std::numbers::pi_v<float> / 180);
    for (size_t k = 0; k < used_; ++k) {
      const uint32_t index = open_[k];
      Item& group = groups[index];
      if (group.normal.dot(item.normal) < kCosine) continue;
      Box3f box = group.box;
      box.extendBy(item.box);
      const float limit = extent_ * group.edge;
      if (!(box.size().length2() <= limit * limit)) continue;
      group.box = box;
      group.area += item.area;
      const uint64_t hash = hashOf(item.face, level_);
      if (toUnit(static_cast<uint32_t>(hash >> 32)) * group.area < item.area) group.face = item.face;
      toFront(k, index);
      return index;
    }
    const auto index = static_cast<uint32_t>(groups.size());
    groups.push_back(item);
    if (used_ < kOpen) ++used_;
    toFront(used_ - 1, index);
    return index;
  }

 private:
  void toFront(size_t from, uint32_t index) {
    for (size_t k = from; k > 0; --k) open_[k] = open_[k - 1];
    open_[0] = index;
  }
  float extent_;
  uint32_t level_;
  std::array<uint32_t, kOpen> open_{};
  size_t used_ = 0;
};

/// Groups of the items of [0, count), block by block: item(k, out) gives one or says that there is none
/// there; taken(k, group) hears where it went, counted within its block; behind the blocks, `firstOf` has the
/// number of each block's first group.
template <class ItemAt, class Taken>
std::vector<Item> walk(size_t count, float extent, uint32_t level, std::vector<uint32_t>& firstOf,
                       const ItemAt& itemAt, const Taken& taken) {
  std::vector<std::vector<Item>> blocks((count + kBlock - 1) / kBlock);
  forEachPart(count, kBlock, [&](size_t begin, size_t end) {
    Grouper grouper(extent, level);
    Item item;
    for (size_t k = begin; k < end; ++k)
      if (itemAt(k, item)) taken(k, grouper.add(item));
    blocks[begin / kBlock] = std::move(grouper.groups);
  });
  size_t total = 0;
  for (const std::vector<Item>& block : blocks) total += block.size();
  std::vector<Item> all;
  all.reserve(total);
  for (std::vector<Item>& block : blocks) {
    firstOf.push_back(static_cast<uint32_t>(all.size()));
    all.insert(all.end(), block.begin(), block.end());
    block = {};
  }
  return all;
}

}  // namespace

FaceGroups groupFaces(const Surface& surface, const M44f& objectToWorld, std::span<const uint32_t> order,
                      const std::function<bool(uint32_t)>& small, const std::function<float(uint32_t)>& edge,
                      std::span<uint32_t> groupOf) {
  const auto faceAt = [&](size_t k, Item& item) {
    const uint32_t face = order[k];
    if (!small(face)) return false;
    item.edge = edge(face);
    V3f c[4];
    surface.corners(face, c);
    const bool quad = surface.faceShape(face) == FaceShape::Quad;
    item.box = {};
    for (int i = 0; i < (quad ? 4 : 3); ++i) item.box.extendBy(c[i] = transformPoint(c[i], objectToWorld));
    // Twice the area vector. Which side is the outside does not matter here: it is the same side for all.
    const V3f n = quad ? (c[3] - c[0]).cross(c[2] - c[1]) : (c[1] - c[0]).cross(c[2] - c[0]);
    item.area = n.length();
    item.normal = normalizedOr(n, V3f(0, 0, 1));
    item.face = face;
    return true;
  };
  FaceGroups result;
  std::vector<uint32_t> firstOf;
  std::vector<Item> items = walk(order.size(), kGroupExtent, 0, firstOf, faceAt,
                                 [&](size_t k, uint32_t group) { groupOf[order[k]] = group; });
  // Groups count within their blocks so far.
  forEachPart(order.size(), kBlock, [&](size_t begin, size_t end) {
    if (const uint32_t first = firstOf[begin / kBlock]; first > 0)
      for (size_t k = begin; k < end; ++k)
        if (small(order[k])) groupOf[order[k]] += first;
  });
  for (uint32_t level = 0;; ++level) {
    std::vector<FaceGroup>& groups = result.levels[level];
    groups.reserve(items.size());
    for (const Item& item : items) groups.push_back({item.face, item.box.size().length(), kNone});
    if (level + 1 == kGroupLevels) break;
    firstOf.clear();
    std::vector<Item> next = walk(
        items.size(), kGroupExtent * static_cast<float>(4 << (2 * level)), level + 1, firstOf,
        [&](size_t k, Item& item) { return item = items[k], true; },
        [&](size_t k, uint32_t group) { groups[k].coarser = group; });
    for (size_t k = 0; k < groups.size(); ++k) groups[k].coarser += firstOf[k / kBlock];
    items = std::move(next);
  }
  return result;
}

}  // namespace patina
