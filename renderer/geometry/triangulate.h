// SPDX-License-Identifier: Apache-2.0
// Triangulation of plane polygons with holes, for any input: convex, concave, degenerate, self-crossing.
#pragma once

#include <Imath/ImathVec.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace patina {

/// Cuts polygons into triangles by ear clipping (Meisters 1975), with holes joined to the outline by bridges
/// (Eberly, "Triangulation by Ear Clipping", 2008). A corner that is no ear sleeps until the vertex that
/// prevents it has gone, and vertices are found by a k-d tree, so that the time is near O(n log n); past a
/// fixed amount of work per vertex corners are clipped unseen, so that hostile input cannot make it
/// quadratic. Keeps its memory between polygons; one per thread.
class Triangulator {
 public:
  using Point = Imath::V2d;
  using Triangle = std::array<uint32_t, 3>;

  /// Appends triangles of indices into `points`, which holds the loops one after another: the outline, then
  /// holes (of either direction). Every triangle turns the way the outline turns and has a positive area.
  /// Vertices in the middle of a straight edge stay vertices, so that neighbouring polygons keep matching.
  /// False: a loop crosses itself or another, or a hole is not inside; the triangles are then a best effort.
  bool run(std::span<const Point> points, std::span<const uint32_t> loopSizes, std::vector<Triangle>& out);

 private:
  static constexpr uint32_t kNil = 0xffffffffu;

  /// A corner of what is left of the polygon; bridges make several of one point.
  struct Node {
    Point at;
    uint32_t point;
    uint32_t previous, next;
    uint32_t copy = kNil;      ///< the next node of the same point
    uint32_t watchers = kNil;  ///< corners that are no ears because of this one: index of watches_
    uint32_t leaf = 0;         ///< its place in the tree
    bool active = false;       ///< counted by the tree
    bool removed = false, queued = false;
  };
  struct Watch {
    uint32_t node, next;
  };
  struct TreeNode {
    Point min, max;
    uint32_t begin, end;  ///< of order_
    uint32_t active;
  };
  struct Hole {
    uint32_t leftmost;    ///< node
    uint32_t first, end;  ///< its nodes
  };

  uint32_t addLoop(std::span<const Point> points, uint32_t first, uint32_t size, bool mirror, bool forward);

  bool bridgeHoles(std::span<Hole> holes, uint32_t outlineEnd);
  uint32_t findVisible(uint32_t hole) const;
  uint32_t addBridge(uint32_t from, uint32_t hole);
  void addEdge(uint32_t a, uint32_t b);
  size_t strip(double y) const;

  void buildTree();
  void buildTree(size_t index, uint32_t begin, uint32_t end);
  void setActive(uint32_t node, bool active);
  template <typename Visit>
  bool visit(size_t index, const std::array<Point, 3>& triangle, const Visit& visitor) const;

  bool clip(uint32_t start, std::vector<Triangle>& out);
  bool clipStuck(uint32_t& cursor, std::vector<Triangle>& out);
  void remove(uint32_t node);
  void update(uint32_t node);
  void enqueue(uint32_t node);
  void wakeWatchers(uint32_t node);
  uint32_t findBlocker(uint32_t ear) const;
  double turn(uint32_t node) const;

  std::vector<Node> nodes_;
  std::vector<Watch> watches_;
  std::vector<uint32_t> queue_, order_;
  std::vector<TreeNode> tree_;
  std::vector<std::vector<std::array<uint32_t, 2>>> strips_;  ///< edges by the rows that they cross
  double stripOrigin_ = 0, stripScale_ = 0;
  mutable size_t work_ = 0;
  size_t workLimit_ = 0;
};

}  // namespace patina
