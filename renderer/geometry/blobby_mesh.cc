// SPDX-License-Identifier: Apache-2.0
// Marching tetrahedra in the leaves of an octree.
#include "renderer/geometry/blobby_mesh.h"

#include "renderer/base/sampling.h"

namespace patina {
namespace {

constexpr int kBlock = 4;  // cubes along an edge of an octree's leaf
constexpr int kSide = kBlock + 1;
constexpr int kMostPoints = 1 << 20;  // of the lattice along an axis
constexpr double kThreshold = Blobby::kThreshold;

/// The paths from corner 0 to corner 7 of a cube along its edges: bits of a corner are its x, y, z. Odd
/// permutations of the axes turn a tetrahedron inside out.
struct Tetrahedron {
  int corner[4];
  bool odd;
};
constexpr Tetrahedron kTetrahedra[6] = {{{0, 1, 3, 7}, false}, {{0, 2, 6, 7}, false}, {{0, 4, 5, 7}, false},
                                        {{0, 2, 3, 7}, true},  {{0, 1, 5, 7}, true},  {{0, 4, 6, 7}, true}};

struct Point {
  int x, y, z;
};
Point cornerOf(const Point& cube, int corner) {
  return {cube.x + (corner & 1), cube.y + (corner >> 1 & 1), cube.z + (corner >> 2 & 1)};
}

/// Numbers by key, in open addressing with linear probing: meshes have millions of vertices, each asked for
/// by several cubes.
class VertexTable {
 public:
  /// The number of a key; `fresh` if it has none yet.
  uint32_t insert(uint64_t key, uint32_t fresh) {
    if (2 * (count_ + 1) > slots_.size()) grow();
    Slot& slot = find(key);
    if (slot.key == kFree) slot = {key, fresh}, ++count_;
    return slot.number;
  }

 private:
  static constexpr uint64_t kFree = ~uint64_t{0};  // no key is as large
  struct Slot {
    uint64_t key = kFree;
    uint32_t number = 0;
  };
  Slot& find(uint64_t key) {
    size_t at = mixBits(key) & (slots_.size() - 1);
    while (slots_[at].key != key && slots_[at].key != kFree) at = (at + 1) & (slots_.size() - 1);
    return slots_[at];
  }
  void grow() {
    std::vector<Slot> old(std::max<size_t>(2 * slots_.size(), 1024));
    old.swap(slots_);
    for (const Slot& slot : old)
      if (slot.key != kFree) find(slot.key) = slot;
  }

  std::vector<Slot> slots_;  // a power of two
  size_t count_ = 0;
};

class Mesher {
 public:
  Mesher(const BlobbyField& field, double cell, bool wantWeights, const BlobbyMeshLimits& limits,
         BlobbyMesh& mesh)
      : field_(field), cell_(cell), wantWeights_(wantWeights), limits_(limits), mesh_(mesh) {}

  BlobbyMeshStatus run() {
    const BlobbyBox& support = field_.support();
    int most = 0;
    for (int c = 0; c < 3; ++c) {
      // Off the round numbers of which scenes are made: lattice points on the surface make thin triangles.
      constexpr double kOffset[3] = {0.414213562, 0.732050808, 0.236067978};
      const double extent = support.axis[c].high - support.axis[c].low;
      if (!(extent >= 0)) return BlobbyMeshStatus::Done;
      const double cubes = std::ceil(extent / cell_) + 3;
      if (!(cubes < kMostPoints)) return BlobbyMeshStatus::TooManyCells;
      cubes_[c] = static_cast<int>(cubes);
      origin_[c] = support.axis[c].low - (1 + kOffset[c]) * cell_;
      most = std::max(most, cubes_[c]);
    }
    int size = kBlock;
    while (size < most) size *= 2;
    tapes_.resize(32);
    visit(field_.everywhere(), {0, 0, 0}, size, 0);
    if (wantWeights_) mesh_.weightStart.push_back(static_cast<uint32_t>(mesh_.weights.size()));
    return status_;
  }

 private:
  double coordinate(int axis, int index) const { return origin_[axis] + index * cell_; }
  V3d position(const Point& p) const { return {coordinate(0, p.x), coordinate(1, p.y), coordinate(2, p.z)}; }

  /// Counts operations; false when there have been too many.
  bool spend(const BlobbyTape& tape, size_t times) {
    work_ += (tape.items.size() + 1) * times;
    if (work_ > limits_.work && status_ == BlobbyMeshStatus::Done) status_ = BlobbyMeshStatus::TooMuchWork;
    return status_ == BlobbyMeshStatus::Done;
  }

  bool atEnd(const Point& p) const {
    return p.x <= 0 || p.y <= 0 || p.z <= 0 || p.x >= cubes_[0] || p.y >= cubes_[1] || p.z >= cubes_[2];
  }

  void visit(const BlobbyTape& tape, const Point& first, int size, size_t depth) {
    if (first.x >= cubes_[0] || first.y >= cubes_[1] || first.z >= cubes_[2]) return;
    if (!spend(tape, 1)) return;
    const Point last{first.x + size, first.y + size, first.z + size};
    const BlobbyBox box{{{coordinate(0, first.x), coordinate(0, last.x)},
                         {coordinate(1, first.y), coordinate(1, last.y)},
                         {coordinate(2, first.z), coordinate(2, last.z)}}};
    BlobbyTape& part = tapes_[depth];
    const Range range = field_.restrict(tape, box, part, scratch_);
    const bool mayEnd = field_.hasPlane() && (atEnd(first) || atEnd(last));
    if (range.high < kThreshold || (range.low >= kThreshold && !mayEnd)) return;
    if (size == kBlock) return march(part, first);
    const int half = size / 2;
    for (int corner = 0; corner < 8 && status_ == BlobbyMeshStatus::Done; ++corner)
      visit(part,
            {first.x + (corner & 1) * half, first.y + (corner >> 1 & 1) * half,
             first.z + (corner >> 2 & 1) * half},
            half, depth + 1);
  }

  void march(const BlobbyTape& tape, const Point& first) {
    if (!spend(tape, kSide * kSide * kSide)) return;
    const auto index = [](int i, int j, int k) { return static_cast<size_t>((k * kSide + j) * kSide + i); };
    for (int k = 0; k < kSide; ++k)
      for (int j = 0; j < kSide; ++j)
        for (int i = 0; i < kSide; ++i) {
          const Point p{first.x + i, first.y + j, first.z + k};
          double& value = values_[index(i, j, k)];
          value = field_.value(tape, position(p), scratch_);
          if (field_.hasPlane() && atEnd(p)) value = std::min(value, 0.0);
        }
    for (int k = 0; k < kBlock; ++k)
      for (int j = 0; j < kBlock; ++j)
        for (int i = 0; i < kBlock; ++i) {
          const Point cube{first.x + i, first.y + j, first.z + k};
          if (cube.x >= cubes_[0] || cube.y >= cubes_[1] || cube.z >= cubes_[2]) continue;
          double corner[8];
          unsigned inside = 0;
          for (int c = 0; c < 8; ++c) {
            corner[c] = values_[index(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2 & 1))];
            inside |= static_cast<unsigned>(corner[c] >= kThreshold) << c;
          }
          if (inside == 0 || inside == 255) continue;
          if (++mesh_.cells > limits_.cells) {
            status_ = BlobbyMeshStatus::TooManyCells;
            return;
          }
          for (const Tetrahedron& t : kTetrahedra) cut(tape, cube, t, corner);
        }
  }

  /// The triangles that part the inside corners of a tetrahedron from the others. With (a, b, c, d)
  /// positively oriented, the triangle of the edges ab, ac, ad faces away from a.
  void cut(const BlobbyTape& tape, const Point& cube, const Tetrahedron& t, const double value[8]) {
    int in[4], out[4];
    int ins = 0, outs = 0;
    bool odd = t.odd;
    for (int k = 0; k < 4; ++k) {
      if (value[t.corner[k]] >= kThreshold) {
        odd ^= outs % 2 == 1;  // passes those outside before it: the order is (in..., out...)
        in[ins++] = t.corner[k];
      } else {
        out[outs++] = t.corner[k];
      }
    }
    if (ins == 0 || outs == 0) return;
    const auto vertex = [&](int a, int b) {
      return this->vertex(tape, cube, std::min(a, b), std::max(a, b), value);
    };
    const auto add = [&](uint32_t a, uint32_t b, uint32_t c) {
      if (odd) std::swap(b, c);
      mesh_.triangles.push_back({a, b, c});
    };
    if (ins == 1) return add(vertex(in[0], out[0]), vertex(in[0], out[1]), vertex(in[0], out[2]));
    if (ins == 3) return add(vertex(in[0], out[0]), vertex(in[1], out[0]), vertex(in[2], out[0]));
    const uint32_t q[4] = {vertex(in[0], out[0]), vertex(in[0], out[1]), vertex(in[1], out[1]),
                           vertex(in[1], out[0])};
    // The shorter diagonal makes the better triangles.
    const auto squared = [&](int a, int b) {
      return (mesh_.vertices[q[a]].P - mesh_.vertices[q[b]].P).length2();
    };
    if (squared(0, 2) <= squared(1, 3)) {
      add(q[0], q[1], q[2]);
      add(q[0], q[2], q[3]);
    } else {
      add(q[0], q[1], q[3]);
      add(q[1], q[2], q[3]);
    }
  }

  /// The vertex on the edge between two corners of a cube, of which the bits of `a` are among those of `b`.
  uint32_t vertex(const BlobbyTape& tape, const Point& cube, int a, int b, const double value[8]) {
    const Point pa = cornerOf(cube, a);
    const auto word = [](int x) { return static_cast<uint64_t>(static_cast<uint32_t>(x)); };
    const uint64_t key =
        ((word(pa.z) * kMostPoints + word(pa.y)) * kMostPoints + word(pa.x)) * 8 + word(a ^ b);
    const auto fresh = static_cast<uint32_t>(mesh_.vertices.size());
    if (const uint32_t known = vertices_.insert(key, fresh); known != fresh) return known;
    const V3d from = position(pa), edge = position(cornerOf(cube, b)) - from;
    const double at = crossing(tape, from, edge, value[a], value[b]);
    const V3d p = from + edge * at;
    spend(tape, 4);
    const V3d gradient = field_.jet(tape, p, scratch_).gradient;
    // Where the field is flat or has a step: from the corner inside to the one outside.
    V3d n = -gradient;
    double size = std::max({std::abs(n.x), std::abs(n.y), std::abs(n.z)});
    if (!(size > 0) || !std::isfinite(size)) {
      n = value[a] >= kThreshold ? edge : -edge;
      size = std::max({std::abs(n.x), std::abs(n.y), std::abs(n.z)});
    }
    n /= size;
    mesh_.vertices.push_back({V3f(p), V3f(n / n.length())});
    if (wantWeights_) {
      mesh_.weightStart.push_back(static_cast<uint32_t>(mesh_.weights.size()));
      field_.weights(tape, p, scratch_, shares_);
      mesh_.weights.insert(mesh_.weights.end(), shares_.begin(), shares_.end());
    }
    return fresh;
  }

  /// Where on an edge, from 0 to 1, the field has the threshold: regula falsi as in M. Dowell, P. Jarratt, "A
  /// modified regula falsi method" (BIT 11, 1971; the Illinois variant), which keeps the root between its
  /// ends. A thousandth of the edge stays free at either end, so that vertices are apart.
  double crossing(const BlobbyTape& tape, const V3d& from, const V3d& edge, double f0, double f1) {
    constexpr double kEnd = 1e-3, kEnough = 1e-9;
    double t0 = 0, t1 = 1;
    f0 -= kThreshold, f1 -= kThreshold;
    double t = 0.5;
    int side = 0;
    for (int step = 0; step < 40 && std::abs(t1 - t0) > kEnough; ++step) {
      t = (t0 * f1 - t1 * f0) / (f1 - f0);
      if (step % 8 == 7 || !(t > t0 && t < t1)) t = (t0 + t1) / 2;  // steps in the field make it slow
      const double f = field_.value(tape, from + edge * t, scratch_) - kThreshold;
      spend(tape, 1);
      if (std::abs(f) < 1e-12) break;
      if ((f < 0) == (f1 < 0)) {
        t1 = t, f1 = f;
        if (side == 1) f0 /= 2;
        side = 1;
      } else {
        t0 = t, f0 = f;
        if (side == -1) f1 /= 2;
        side = -1;
      }
    }
    return std::clamp(t, kEnd, 1 - kEnd);
  }

  const BlobbyField& field_;
  double cell_;
  bool wantWeights_;
  BlobbyMeshLimits limits_;
  BlobbyMesh& mesh_;
  BlobbyMeshStatus status_ = BlobbyMeshStatus::Done;
  double origin_[3] = {};
  int cubes_[3] = {};  // of the lattice along each axis
  size_t work_ = 0;
  std::vector<BlobbyTape> tapes_;  // by depth
  BlobbyField::Scratch scratch_;
  double values_[kSide * kSide * kSide] = {};
  VertexTable vertices_;  // by the lower end of their edge and its direction
  std::vector<LeafWeight> shares_;
};

}  // namespace

BlobbyMeshStatus meshBlobby(const BlobbyField& field, double cell, bool wantWeights,
                            const BlobbyMeshLimits& limits, BlobbyMesh& mesh) {
  mesh = {};
  return Mesher(field, cell, wantWeights, limits, mesh).run();
}

}  // namespace patina
