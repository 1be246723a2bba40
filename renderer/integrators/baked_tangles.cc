// SPDX-License-Identifier: Apache-2.0
// Pieces of tangles (hair, leaves, meshes finer than pixels), which share irradiance whatever way they face.

#include "renderer/base/parallel.h"
#include "renderer/base/statistics.h"
#include "renderer/integrators/baked_points.h"

namespace patina {
namespace {

STAT_COUNTER("Points/tangles that share irradiance", tangleCount);

/// Pieces of a tangle that are looked from: some along it, and the two that differ most from the first.
constexpr size_t kAlong = 3, kLooked = kAlong + 2;
/// Tangles are so small a part of an object, that what looks at it sees a mean over many; smaller objects
/// have none.
constexpr size_t kPartOfObject = 256;
constexpr size_t kUsual = 64;  ///< of an object, from which its mean is found
constexpr size_t kLeastMembers = 12, kMostMembers = 128, kWorthATask = 2048;
/// The slopes of irradiance by normals are held back by so much of a sample's weight, for normals that are
/// few or alike to give none.
constexpr double kRidge = 0.02;
/// The root of the mean square by which places may differ from what their tangle shares, over the mean. In
/// hair and rough meshes that is about the same for a dozen pieces as for a hundred (0.7), and what gathers
/// see of them is a mean over many. dense_mesh's picture differs by a relMSE of 3e-3 from that without
/// tangles.
constexpr float kDisagree = 0.8f;
/// Normals that are along one line (the sum of squared eigenvalues of their mean square) are those of sheets,
/// one or more: light of one side of a wall is not the other's. One sheet has a mean normal that is so long,
/// and no piece above another by more than the way there, and so much of its radius.
constexpr double kOneLine = 0.7, kOneSide = 0.8;
constexpr float kAbove = 0.4f;
/// Pieces so many times as long as wide are of hair, between which light passes: where they are most, there
/// is no wall.
constexpr float kSliver = 3;
/// Numbers in a fit: the mean and a slope.
constexpr double kFreedoms = 4;

}  // namespace

Rgb BakedPoints::Cluster::at(const V3f& N) const {
  Rgb e;
  const V3f d = N - normal;
  for (int c = 0; c < 3; ++c)
    e[c] = std::clamp(irradiance[c] + slope[static_cast<size_t>(c)].dot(d), least[c], most[c]);
  return e;
}

/// Least squares: a mean, and a linear function of the normal, which is what the first two bands of spherical
/// harmonics are, and most of irradiance is in them (Ramamoorthi and Hanrahan 2001, section 3.2). The root of
/// what is left of squares.
float BakedPoints::fit(Cluster& cluster, std::span<const V3f> normals, std::span<const Rgb> irradiance) {
  const auto count = static_cast<double>(normals.size());
  V3d mean(0), normal(0);
  cluster.least = Rgb(kInfinity), cluster.most = Rgb(0);
  for (size_t k = 0; k < normals.size(); ++k) {
    mean += V3d(irradiance[k]) / count, normal += V3d(normals[k]) / count;
    for (int c = 0; c < 3; ++c) {
      cluster.least[c] = std::min(cluster.least[c], irradiance[k][c]);
      cluster.most[c] = std::max(cluster.most[c], irradiance[k][c]);
    }
  }
  cluster.irradiance = V3f(mean), cluster.normal = V3f(normal);
  Imath::M33d squares(0.0);
  for (int i = 0; i < 3; ++i) squares[i][i] = kRidge * count;
  std::array<V3d, 3> products{V3d(0), V3d(0), V3d(0)};
  for (size_t k = 0; k < normals.size(); ++k) {
    const V3d d = V3d(normals[k]) - normal;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) squares[i][j] += d[i] * d[j];
      for (int c = 0; c < 3; ++c)
        products[static_cast<size_t>(c)][i] += d[i] * (static_cast<double>(irradiance[k][c]) - mean[c]);
    }
  }
  const Imath::M33d inverse = squares.inverse();
  for (size_t c = 0; c < 3; ++c) cluster.slope[c] = V3f(products[c] * inverse);
  double left = 0;
  for (size_t k = 0; k < normals.size(); ++k) {
    const V3d off = V3d(irradiance[k] - cluster.at(normals[k]));
    left += off.length2() / std::max(1.0, count - kFreedoms);
  }
  return static_cast<float>(std::sqrt(left));
}

/// Looks around from the cluster's pieces.
float BakedPoints::lookAgain(Cluster& cluster, const std::vector<Piece>& pieces) const {
  std::vector<V3f> normals;
  std::vector<Rgb> irradiance;
  for (const uint32_t k : cluster.lookedFrom)
    for (const bool front : {true, false}) {
      if (!front && !pieces[k].hasBack) continue;
      normals.push_back(front ? pieces[k].N : -pieces[k].N);
      irradiance.push_back(lookFrom(pieces[k], front).irradiance);
    }
  return fit(cluster, normals, irradiance);
}

/// Those of a tangle's members that say most of it.
std::vector<uint32_t> BakedPoints::chooseFrom(const std::vector<Piece>& pieces,
                                              std::span<const uint32_t> members, float radius) {
  std::vector<uint32_t> chosen;
  for (size_t k = 0; k < kAlong; ++k) chosen.push_back(members[(2 * k + 1) * members.size() / (2 * kAlong)]);
  while (chosen.size() < kLooked) {
    uint32_t best = members[0];
    float most = -1;
    for (const uint32_t k : members) {
      float least = kInfinity;
      for (const uint32_t other : chosen) {
        const Piece &a = pieces[k], &b = pieces[other];
        least = std::min(least, (a.P - b.P).length2() / (radius * radius) + (a.N - b.N).length2());
      }
      if (least > most) most = least, best = k;
    }
    chosen.push_back(best);
  }
  return chosen;
}

/// Whether pieces are of several sheets, as those of a wall, instead of one or of a tangle.
bool BakedPoints::areSheets(const std::vector<Piece>& pieces, std::span<const uint32_t> members) {
  const auto isSliver = [&](uint32_t k) {
    const auto [width, length] = std::minmax(pieces[k].halfU, pieces[k].halfV);
    return length > kSliver * width;
  };
  const auto slivers = static_cast<size_t>(std::count_if(members.begin(), members.end(), isSliver));
  if (2 * slivers > members.size()) return false;
  Imath::M33d squares(0.0);
  V3d mean(0);
  for (const uint32_t k : members) mean += V3d(pieces[k].N) / static_cast<double>(members.size());
  for (const uint32_t k : members)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        squares[i][j] +=
            static_cast<double>(pieces[k].N[i] * pieces[k].N[j]) / static_cast<double>(members.size());
  double sum = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) sum += squares[i][j] * squares[i][j];
  if (sum <= kOneLine) return false;
  if (mean.length() < kOneSide) return true;
  for (const uint32_t a : members)
    for (const uint32_t b : members) {
      const V3f d = pieces[b].P - pieces[a].P;
      const float height = std::abs(d.dot(pieces[a].N));
      const float along = std::sqrt(std::max(0.0f, d.length2() - height * height));
      if (height > along + kAbove * pieces[a].radius) return true;
    }
  return false;
}

/// Orders `members` along axes, and makes tangles of those that agree on their irradiance.
void BakedPoints::addTangles(std::vector<Piece>& pieces, std::span<uint32_t> members, size_t most,
                             float usual,
                             std::vector<std::pair<Cluster, std::vector<uint32_t>>>& tangles) const {
  if (members.size() < kLeastMembers || world_.interrupted()) return;
  Box3f box;
  for (const uint32_t k : members) box.extendBy(pieces[k].P);
  const V3f size = box.size();
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const auto comesFirst = [&](uint32_t a, uint32_t b) {
    return std::pair(pieces[a].P[axis], a) < std::pair(pieces[b].P[axis], b);
  };
  if (members.size() <= most && !areSheets(pieces, members)) {
    std::sort(members.begin(), members.end(), comesFirst);
    Cluster cluster;
    cluster.lookedFrom = chooseFrom(pieces, members, size.length() / 2);
    const float error = lookAgain(cluster, pieces);
    if (error <= kDisagree * std::max(usual, cluster.irradiance.length())) {
      tangles.emplace_back(cluster, std::vector<uint32_t>(members.begin(), members.end()));
      return;
    }
  }
  const auto half = members.begin() + static_cast<std::ptrdiff_t>(members.size() / 2);
  std::nth_element(members.begin(), half, members.end(), comesFirst);
  const std::span<uint32_t> low(members.begin(), half), high(half, members.end());
  if (members.size() < kWorthATask) {
    addTangles(pieces, low, most, usual, tangles), addTangles(pieces, high, most, usual, tangles);
    return;
  }
  std::vector<std::pair<Cluster, std::vector<uint32_t>>> others;
  parallelInvoke([&] { addTangles(pieces, low, most, usual, tangles); },
                 [&] { addTangles(pieces, high, most, usual, others); });
  tangles.insert(tangles.end(), others.begin(), others.end());
}

void BakedPoints::findTangles(std::vector<Piece>& pieces, std::span<uint32_t> members) {
  const size_t most = std::min(kMostMembers, members.size() / kPartOfObject);
  if (most < kLeastMembers) return;
  // What irradiance pieces of the object have: errors of dark tangles count for less.
  Cluster all;
  const size_t every = std::max<size_t>(1, members.size() / kUsual);
  for (size_t k = every / 2; k < members.size(); k += every) all.lookedFrom.push_back(members[k]);
  lookAgain(all, pieces);
  std::vector<std::pair<Cluster, std::vector<uint32_t>>> tangles;
  addTangles(pieces, members, most, all.irradiance.length(), tangles);
  for (auto& [cluster, of] : tangles) {
    const auto number = static_cast<uint32_t>(clusters_.size());
    clusters_.push_back(std::move(cluster));
    for (const uint32_t k : of) pieces[k].cluster = {number, pieces[k].hasBack ? number : kNone};
  }
  tangleCount += static_cast<int64_t>(tangles.size());
}

}  // namespace patina
