// SPDX-License-Identifier: Apache-2.0
// Surfels in an octree whose nodes stand for all that is in them when they are far away (P. Christensen,
// "Point-Based Approximate Color Bleeding", Pixar Technical Memo 08-01, 2008, section 5).
#pragma once

#include <array>
#include <span>
#include <vector>

#include "renderer/base/math.h"

namespace patina {

/// A piece of a surface: a disc that light leaves on both sides, alike in all directions.
struct Surfel {
  V3f P{0, 0, 0};                     ///< world space
  V3f N{0, 0, 1};                     ///< unit, world space: towards the front
  float area = 0;                     ///< of the piece, world units squared: what it covers from afar
  float radius = 0;                   ///< of a disc that covers the piece: what a ray meets from near
  float thickness = 0;                ///< of a rough piece: how far it is from the disc at most
  Rgb front{0, 0, 0}, back{0, 0, 0};  ///< radiance that leaves
  /// The piece is within a rectangle around P, too, one of whose sides is along U (unit, at right angles to
  /// N).
  V3f U{1, 0, 0};
  float halfU = kInfinity, halfV = kInfinity;  ///< half of the sizes along U and along N x U
  /// A triangle whose corners' mean is P, with a side along U: where that side begins and ends along U, and
  /// where it is along N x U, all of it from P. 0: the piece is none.
  V3f triangle{0, 0, 0};
  bool isTriangle() const { return triangle.z != 0; }
  /// Along U and N x U, from P: counter-clockwise seen from the side that N points to, or all the way round.
  std::array<V2f, 3> corners() const {
    const auto [u0, u1, v] = std::array{triangle.x, triangle.y, triangle.z};
    return {V2f(u0, v), {u1, v}, {-u0 - u1, -2 * v}};
  }
  /// Half of the size of a box around the piece.
  V3f bound() const;
  /// Part of a closed surface (a ball, not a wall): which side is inside of it.
  enum class Inner : uint8_t { None, Back, Front } inner = Inner::None;
  bool hasBack = true;  ///< false: nobody sees the back, as that of a closed surface; it covers nothing
  static constexpr uint32_t kNobody = ~0u;
  uint32_t owner = kNobody;  ///< of what is closed: the same number for all of one surface
};

/// Real spherical harmonics of the first three bands (R. Ramamoorthi, P. Hanrahan 2001, "An Efficient
/// Representation for Irradiance Environment Maps", equation 3).
using ShBasis = std::array<float, 9>;
ShBasis shBasis(const V3f& direction);

/// An octree of cubes over surfels. Immutable but for the radiances. [any thread may read]
class PointTree {
 public:
  static constexpr uint32_t kLeafSize = 8;
  static constexpr int kMaxDepth = 24;

  /// Surfels whose place, normal or size are not finite, and those without area, are left out: see refused().
  explicit PointTree(std::vector<Surfel> surfels);

  /// What a node looks like from one direction.
  struct Seen {
    float area = 0;         ///< projected, world units squared
    Rgb radiance{0, 0, 0};  ///< mean over that area
    bool isInner = false;   ///< of closed surfaces: it is their inside
  };
  struct Node {
    V3f center{0, 0, 0};            ///< of a box around all the pieces
    V3f half{0, 0, 0};              ///< half of that box's size
    float radius = 0;               ///< of a sphere around the center that holds them, too
    uint32_t first = 0, count = 0;  ///< surfels()
    uint32_t children = 0;          ///< the first of childCount in nodes(); 0: a leaf
    uint8_t childCount = 0;
    /// All that is in it lies about in one plane: a disc of the mean normal, in place of the harmonics, which
    /// would show it from its edge and from behind.
    bool isFlat = false;
    Surfel::Inner inner = Surfel::Inner::None;  ///< all surfels'
    uint32_t owner = Surfel::kNobody;           ///< all surfels'
    /// All that is in it lies in few planes: a wall, or where walls meet. planes() from `firstPlane` on; 0:
    /// it does not.
    uint32_t firstPlane = 0;
    uint8_t planeCount = 0;
    bool isCovered = false;  ///< ... and they fill their planes, so that rays may be traced against those
    /// Several planes meet in it, and the radiance of one of them jumps: likely where another goes through
    /// it, as a wall that stands on a floor does, and who is on one side must not see the light of the other.
    /// Of the radiances that surfels are handed in with: as the tree is, it stays.
    bool isParted = false;
    V3f N{0, 0, 1};                     ///< isFlat
    float frontArea = 0, backArea = 0;  ///< sums of areas, by sides that are seen
    Rgb front{0, 0, 0}, back{0, 0, 0};  ///< isFlat: mean radiance of each side
    bool isLeaf() const { return children == 0; }
  };
  /// Surfels of a node that lie in one plane. It is met where both a box around them and a rectangle in the
  /// plane are: as pieces cover their surface, what is beside each other leaves no gap.
  struct Plane {
    V3f P{0, 0, 0}, N{0, 0, 1};  ///< the middle of the areas
    V3f U{1, 0, 0}, V{0, 1, 0};  ///< unit: along the sides of the rectangle
    V3f center{0, 0, 0};         ///< of the rectangle
    float halfU = 0, halfV = 0;
    Box3f box;
    float slack = 0;  ///< by which rays may be outside of both, and still meet the plane
    float piece = 0;  ///< size of the largest surfel
    bool hasTriangles = false;
    float frontArea = 0, backArea = 0;
    Rgb front{0, 0, 0}, back{0, 0, 0};  ///< mean radiance of each side: at P
    /// How radiance changes along the plane, by channels: the linear function nearest to the surfels', made
    /// flatter where it would be negative.
    std::array<V3f, 3> frontSlope{V3f(0), V3f(0), V3f(0)}, backSlope = frontSlope;
    float spread = 0, height = 0;  ///< most angle between normals and N, distance from the plane
  };
  const std::vector<Plane>& planes() const { return planes_; }
  static constexpr int kMostPlanes = 3;
  /// Fronts, or backs, of node `index`, seen along `direction`, which is unit and points away from it.
  Seen look(uint32_t index, const V3f& direction, bool back) const;
  /// The same of an inner side, which looks as the mean of the outer one does.
  Seen lookAtGap(uint32_t index, const V3f& direction, bool back) const;
  /// Radiance of its inner side there.
  const Rgb& inGap(uint32_t index) const {
    const Node& node = nodes_[index];
    return node.inner == Surfel::Inner::Back ? node.front : node.back;
  }
  /// Both sides, of which neither is before the other: of a tangle some pieces show this and some that.
  Seen lookAtBoth(uint32_t index, const V3f& direction) const;

  bool empty() const { return surfels_.empty(); }
  const std::vector<Node>& nodes() const { return nodes_; }        ///< the root is first
  const std::vector<Surfel>& surfels() const { return surfels_; }  ///< those of a node stand together
  /// Where a surfel that was handed in stands now: its index in surfels(), or kRefused.
  static constexpr uint32_t kRefused = ~0u;
  const std::vector<uint32_t>& places() const { return places_; }
  size_t refused() const { return refused_; }
  /// New radiances of surfels(), by their index: those of another bounce. [one thread, nobody reads]
  void setRadiance(std::span<const Rgb> front, std::span<const Rgb> back);
  size_t memory() const;  ///< bytes

 private:
  /// Sums over the surfels of a node: of area times clamped cosine, and of that times radiance.
  struct Harmonics {
    struct Side {
      ShBasis area{};
      std::array<ShBasis, 3> power{};
    } front, back;
  };
  void split(uint32_t node, const V3f& corner, float size, int depth);
  void summarize(bool isFirst);
  void findPlanes(Node& node, bool isFirst);
  void fitSlopes(const Node& node, std::span<Plane> planes) const;
  bool jumps(const Node& node, std::span<const Plane> planes) const;
  static size_t planeWith(const Node& node, std::span<const Plane> planes, const Surfel& surfel);

  std::vector<Surfel> surfels_;
  std::vector<Plane> planes_;
  std::vector<uint32_t> order_, places_;
  std::vector<Node> nodes_;
  std::vector<Harmonics> harmonics_;  ///< by node; of flat nodes not used
  size_t refused_ = 0;
};

}  // namespace patina
