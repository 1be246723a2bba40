// SPDX-License-Identifier: Apache-2.0
// Pieces of small patches that share their irradiance while points are baked.

#include "renderer/base/parallel.h"
#include "renderer/base/statistics.h"
#include "renderer/integrators/baked_points.h"

namespace patina {
namespace {

STAT_COUNTER("Points/clusters that share irradiance", clusterCount);

/// Ward's estimate of the error that a cluster may have: its radius over the harmonic mean distance of what
/// its middle sees. What interpolates may have more.
constexpr float kShared = 0.15f;
/// Normals of a cluster are within 11 degrees of their mean.
constexpr float kAlike = 0.98f;
constexpr size_t kMostMembers = 256, kWorthATask = 2048;

}  // namespace

PointRaster::Estimate BakedPoints::lookFrom(const Piece& piece, bool front) const {
  const ShadingPoint point = pointOf(piece, front);
  const bool lit = world_.attributesOf(piece.placement).maxDiffuseDepth > 0;
  return irradiance(point, false, seedOf(piece, front), lit);
}

void BakedPoints::findClusters(std::vector<Piece>& pieces, uint32_t placements) {
  // Within one object: what stands between two of them does not part its own pieces.
  std::vector<uint32_t> members;
  std::vector<size_t> first(placements + 1, 0);
  for (const Piece& p : pieces)
    if (p.patch == kNone) ++first[p.placement + 1];
  for (uint32_t k = 0; k < placements; ++k) first[k + 1] += first[k];
  members.resize(first.back());
  std::vector<size_t> at(first.begin(), first.end() - 1);
  for (uint32_t k = 0; k < pieces.size(); ++k)
    if (pieces[k].patch == kNone) members[at[pieces[k].placement]++] = k;

  clusters_.clear();
  for (uint32_t k = 0; k < placements; ++k)
    findTangles(pieces, std::span(members).subspan(first[k], first[k + 1] - first[k]));

  struct Found {
    std::vector<uint32_t> members, counts;
    std::vector<Cluster> clusters;
  };
  std::vector<Found> found(size_t{placements} * 2);
  parallelFor(size_t{0}, found.size(), [&](size_t k) {
    const bool front = k % 2 == 0;
    Found& f = found[k];
    for (size_t i = first[k / 2]; i < first[k / 2 + 1]; ++i)
      if (pieces[members[i]].cluster[0] == kNone && (front || pieces[members[i]].hasBack))
        f.members.push_back(members[i]);
    addClusters(pieces, f.members, front, f.clusters, f.counts);
  });
  for (const Found& f : found) {
    size_t member = 0;
    clusterCount += static_cast<int64_t>(f.clusters.size());
    for (size_t c = 0; c < f.clusters.size(); ++c) {
      for (uint32_t k = 0; k < f.counts[c]; ++k)
        pieces[f.members[member++]].cluster[f.clusters[c].front ? 0 : 1] =
            static_cast<uint32_t>(clusters_.size());
      clusters_.push_back(f.clusters[c]);
    }
  }
}

/// Orders `members` by clusters, whose numbers of members go to `counts`.
void BakedPoints::addClusters(const std::vector<Piece>& pieces, std::span<uint32_t> members, bool front,
                              std::vector<Cluster>& clusters, std::vector<uint32_t>& counts) const {
  if (members.empty() || world_.interrupted()) return;
  V3d middle(0), normal(0);
  Box3f box;
  for (const uint32_t k : members) {
    middle += V3d(pieces[k].P), normal += V3d(pieces[k].N);
    box.extendBy(pieces[k].P);
  }
  const V3f center(middle / static_cast<double>(members.size())),
      N = normalizedOr(V3f(normal), pieces[members[0]].N);
  float radius = 0, least = 1, nearest = kInfinity;
  uint32_t chosen = members[0];
  for (const uint32_t k : members) {
    const float distance = (pieces[k].P - center).length();
    radius = std::max(radius, distance), least = std::min(least, pieces[k].N.dot(N));
    if (distance < nearest) nearest = distance, chosen = k;
  }
  const bool mayShare = members.size() == 1 || (members.size() <= kMostMembers && least >= kAlike);
  if (mayShare) {
    const PointRaster::Estimate seen = lookFrom(pieces[chosen], front);
    if (members.size() == 1 || (radius * seen.inverseDistance <= kShared && radius <= seen.nearest)) {
      Cluster& cluster = clusters.emplace_back();
      cluster.lookedFrom = {chosen}, cluster.front = front, cluster.isTangle = false;
      cluster.irradiance = seen.irradiance;
      counts.push_back(static_cast<uint32_t>(members.size()));
      return;
    }
  }
  const V3f size = box.size();
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const auto half = members.begin() + static_cast<std::ptrdiff_t>(members.size() / 2);
  std::nth_element(members.begin(), half, members.end(), [&](uint32_t a, uint32_t b) {
    return std::pair(pieces[a].P[axis], a) < std::pair(pieces[b].P[axis], b);
  });
  const std::span<uint32_t> low(members.begin(), half), high(half, members.end());
  if (members.size() < kWorthATask) {
    addClusters(pieces, low, front, clusters, counts);
    addClusters(pieces, high, front, clusters, counts);
    return;
  }
  std::vector<Cluster> others;
  std::vector<uint32_t> otherCounts;
  parallelInvoke([&] { addClusters(pieces, low, front, clusters, counts); },
                 [&] { addClusters(pieces, high, front, others, otherCounts); });
  clusters.insert(clusters.end(), others.begin(), others.end());
  counts.insert(counts.end(), otherCounts.begin(), otherCounts.end());
}

/// The irradiance of one more bounce.
void BakedPoints::gatherClusters(const std::vector<Piece>& pieces, const Bounce& bounce,
                                 const std::vector<Rgb>& front, const std::vector<Rgb>& back) {
  std::vector<uint8_t> wanted(clusters_.size(), 0);
  for (size_t k = 0; k < pieces.size(); ++k)
    for (const bool side : {true, false})
      if (const uint32_t c = pieces[k].cluster[side ? 0 : 1]; c != kNone)
        if (!bounce.onlyLit || !isBlack(front[k]) || !isBlack(back[k])) wanted[c] = 1;
  parallelFor(size_t{0}, clusters_.size(), [&](size_t k) {
    if (wanted[k] == 0 || world_.interrupted()) return;
    Cluster& c = clusters_[k];
    if (c.isTangle)
      lookAgain(c, pieces);
    else
      c.irradiance = lookFrom(pieces[c.lookedFrom[0]], c.front).irradiance;
  });
}

}  // namespace patina
