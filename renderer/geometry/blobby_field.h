// SPDX-License-Identifier: Apache-2.0
// The field of a Blobby: values, gradients and bounds, by programs that are cut down to the part of space
// they are asked about.
#pragma once

#include <span>
#include <vector>

#include "renderer/scene/scene.h"

namespace patina {

/// A range of values, or of positions along an axis.
struct Range {
  double low, high;
};
/// Object space; one range for each axis.
struct BlobbyBox {
  Range axis[3];
};

/// How much of a point belongs to a field of the Blobby (by its number among the fields, from 0).
struct LeafWeight {
  uint32_t leaf;
  float weight;
};

/// The program that is in force in some box: instructions in the order of evaluation, each naming earlier
/// ones. Cut from the program of a box around it by BlobbyField::restrict().
struct BlobbyTape {
  enum class Op : uint8_t { Zero, Field, Add, Subtract, Multiply, Divide, Maximum, Minimum, Negate };
  struct Item {
    Op op;
    uint32_t a, b;  ///< earlier items; Field: a is the index of the field's record
  };
  std::vector<Item> items;  ///< the last is the result; empty: the field is 0
};

/// Fields (Pixar Application Note 31; the segment's is the spherical bump integrated along the segment, so
/// that segments laid end to end add up to the long one):
///   ellipsoid  (1 - r^2)^3 in the unit sphere;
///   segment    35/32 times the integral of (1 - rho^2 - s^2)^3 ds, in units of its radius: 1 on the axis of
///   a
///              long one; a segment without length is a sphere;
///   plane      (D bump(z/C) - B/z) (1 - ease(z/A)) below z = A, with z at least 1e-6, bump(t) = t^3 (2 -
///   t)^3
///              and ease(t) = t^2 (3 - 2t).
/// Divisors nearer to 0 than 1e-6 count as that.
///
/// Inside means a field of at least Blobby::kThreshold. Immutable; any thread may use it with memory of its
/// own.
class BlobbyField {
 public:
  /// Fields that no number can come of (a matrix without an inverse, a radius that is not positive) are 0
  /// everywhere; `spoiled` counts them.
  BlobbyField(const Blobby& blobby, size_t& spoiled);

  struct Jet {
    double value;
    V3d gradient;
  };
  /// Memory for one thread's evaluations.
  struct Scratch {
    std::vector<double> values;
    std::vector<Jet> jets;
    std::vector<Range> ranges;
    std::vector<uint32_t> places;
  };

  const BlobbyTape& everywhere() const { return tape_; }
  /// Where fields but planes differ from 0; empty (low > high) if there is none.
  const BlobbyBox& support() const { return support_; }
  bool hasPlane() const { return hasPlane_; }
  /// Size of the finest detail of each field, and where: a ball in it that its surface would be, and about
  /// the area of that surface.
  struct Detail {
    V3d center{0, 0, 0};
    double radius;  ///< the smallest
    double reach;   ///< of the field from the center
    double area;
  };
  std::vector<Detail> details() const;

  double value(const BlobbyTape& tape, const V3d& p, Scratch& scratch) const;
  Jet jet(const BlobbyTape& tape, const V3d& p, Scratch& scratch) const;

  /// Bounds of the values that value() gives in a box, and the part of `tape` that matters there: it gives
  /// the same values there, bit for bit. (Interval arithmetic and pruning: T. Duff, "Interval Arithmetic and
  /// Recursive Subdivision for Implicit Functions and Constructive Solid Geometry", SIGGRAPH 1992.)
  Range restrict(const BlobbyTape& tape, const BlobbyBox& box, BlobbyTape& part, Scratch& scratch) const;

  /// Shares of the fields in a point, summing to one. A combination's share goes to its operands as their
  /// fields do: sums and products by positive values, maxima and minima to the one that holds, differences
  /// and quotients to the first.
  void weights(const BlobbyTape& tape, const V3d& p, Scratch& scratch, std::vector<LeafWeight>& out) const;

 private:
  enum class Kind : uint8_t { Constant, Ellipsoid, Segment, Plane };
  /// A point p of object space is at q = (p - origin) * toField in the field's own space, where radii are 1
  /// and a segment runs along x from 0 to its length.
  struct Leaf {
    Kind kind;
    uint32_t number;
    V3d origin{0, 0, 0};
    double toField[3][3];
    double length;
    double profile[4];  ///< of a plane: A to D; of a constant: its value
    Detail detail;
  };

  bool addLeaf(const Blobby& blobby, const Blobby::Instruction& instruction, uint32_t number);
  double value(const Leaf& leaf, const V3d& p) const;
  Jet jet(const Leaf& leaf, const V3d& p) const;
  Range range(const Leaf& leaf, const BlobbyBox& box) const;
  void forward(const BlobbyTape& tape, const V3d& p, std::vector<double>& values) const;

  std::vector<Leaf> leaves_;
  BlobbyTape tape_;
  BlobbyBox support_;
  bool hasPlane_ = false;
};

}  // namespace patina
