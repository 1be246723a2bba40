// SPDX-License-Identifier: Apache-2.0
// What rasters saw, kept while surfels get the light of one bounce after another: what is seen from a place
// stays, its radiance changes.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "renderer/points/point_tree.h"

namespace patina {

/// What a raster saw: parts of a tree, and how much of each.
struct SurfelView {
  enum class Kind : uint8_t {
    NodeFront,
    NodeBack,
    NodeBoth,
    SurfelFront,
    SurfelBack,
    PlaneFront,
    PlaneBack,
    NodeGap
  };
  static constexpr uint32_t kMostIndex = (1u << 29) - 1;
  struct Part {
    Kind kind : 3;
    uint32_t index : 29;  ///< in nodes(), surfels() or planes()
    float weight;         ///< projected solid angle, steradians
  };
  static_assert(sizeof(Part) == 8);
  V3f P{0, 0, 0};           ///< from where: world space
  std::vector<Part> parts;  ///< none twice
  std::vector<V3f> along;  ///< of each plane among the parts: the mean place that is seen, relative to its P,
                           ///< times the weight
  Rgb sky{0, 0, 0};        ///< irradiance
  float covered = 0, inverseDistance = 0, nearest = kInfinity;  ///< as PointRaster::Estimate's

  /// Irradiance with the radiances that `tree` has now: of what was seen, and of the sky.
  Rgb irradiance(const PointTree& tree) const;
  size_t memory() const;  ///< bytes
};

/// Views by keys, up to a number of bytes: more are not kept. [any thread]
class SurfelViews {
 public:
  explicit SurfelViews(size_t bytes) : bytes_(bytes) {}
  const SurfelView* find(uint64_t key) const;  ///< nullptr: none is kept; stays where it is
  void keep(uint64_t key, const SurfelView& view);
  size_t memory() const { return used_; }

 private:
  struct Shard {
    mutable std::mutex mutex;
    std::unordered_map<uint64_t, SurfelView> views;
  };
  Shard& shard(uint64_t key) const { return shards_[key >> 58]; }
  const size_t bytes_;
  std::atomic<size_t> used_ = 0;
  mutable std::array<Shard, 64> shards_;
};

}  // namespace patina
