// SPDX-License-Identifier: Apache-2.0
// Solids: set operations on what closed surfaces enclose (RI 3.2 section 5.7), as trees that say whether a
// point is inside when it is known which of the leaves it is inside of.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/geometry/surface.h"

namespace patina {

/// The tree of a solid, without what does not count. Every leaf stands in it once, so that the result grows
/// with a leaf or shrinks with it: a leaf that is `subtracted` shrinks it, and the outside of the result at
/// its surface is its own inside.
struct SolidTree {
  /// How crossings of a leaf's surface along a ray tell where it is inside; found by examineLeaf().
  enum class Rule : uint8_t {
    Facing,   ///< its outside was met: from there on inside. A crossing too many, or one missed, does no harm
    Winding,  ///< closed surfaces that overlap, all facing out: inside of any of them
    Parity    ///< the facets do not agree on an outside: inside behind every odd crossing
  };
  struct Node {
    uint32_t parent;           ///< kNone: the root, which is node 0
    uint32_t step;             ///< what it adds to the count of its parent where a point is inside of it
    uint32_t full;             ///< the count at which a point is inside of it; 0: any but 0
    Rule rule = Rule::Facing;  ///< of leaves
    bool subtracted = false;   ///< of leaves
  };
  std::vector<Node> nodes;  ///< parents before their operands

  static bool inside(const Node& node, uint32_t count) {
    return node.full == 0 ? count != 0 : count == node.full;
  }
};

/// Which leaves of a point's solid it is inside of, and so whether it is inside. Reusable.
class SolidState {
 public:
  /// Outside of all leaves. `tree` must outlive the use.
  void begin(const SolidTree& tree);
  bool inside() const { return inside_; }
  bool insideLeaf(uint32_t leaf) const { return counts_[leaf] != 0; }
  void setLeaf(uint32_t leaf, bool inside);

 private:
  const SolidTree* tree_ = nullptr;
  std::vector<uint32_t> counts_;
  bool inside_ = false;
};

/// What of a solid is kept.
struct PrunedSolid {
  enum class Fate : uint8_t {
    Kept,    ///< a leaf of the tree
    Absent,  ///< no operand: drawn as it is
    Removed  ///< a leaf no part of which belongs to the result
  };
  SolidTree tree;              ///< empty: nothing is left, or one leaf alone, which needs no tree
  std::vector<Fate> fates;     ///< by node of the solid; meaningless for operations
  std::vector<uint32_t> leaf;  ///< by node of the solid: the leaf's node in `tree`
  bool emptied = false;        ///< an operand without any surface leaves nothing of the others
};

enum class LeafContent : uint8_t { Empty, Open, Closed };

/// `content` of each leaf, by node. An empty leaf is the empty set. An open one encloses nothing: it is no
/// operand, as if it were not there, and a difference without its first operand has nothing to take from.
PrunedSolid pruneSolid(const Solid& solid, std::span<const LeafContent> content);

/// One of the surfaces that bound a leaf.
struct LeafSurface {
  const Surface* surface;
  M44f toMesh;
  bool reversed;  ///< the outside is opposite to the surface's normal
};

struct LeafReport {
  bool closed = true;
  SolidTree::Rule rule = SolidTree::Rule::Facing;
  std::vector<bool>
      turned;  ///< by surface: it faces the inside of the leaf, and has to be taken the other way
};

/// Sends lines through points of the surfaces, as coarse triangles: the surfaces are closed if (but for two
/// lines in a hundred, which may slip between parts that are cut up differently) every line crosses them an
/// even number of times. Holes of less than about one part in a hundred of a leaf's surface are passed over.
/// A surface that faces the inside on most lines is turned round: caps of cylinders are often given so.
LeafReport examineLeaf(std::span<const LeafSurface> surfaces);

}  // namespace patina
