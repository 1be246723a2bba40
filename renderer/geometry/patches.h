// SPDX-License-Identifier: Apache-2.0
// Patches: the tiles of at most 16x16 micropolygons that primitives are cut into for shading and for the
// caches.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "renderer/base/stable_vector.h"
#include "renderer/geometry/raster_camera.h"
#include "renderer/geometry/surface.h"

namespace patina {

/// Resolutions of a patch. A level's vertices are a subset of the next finer level's.
enum class Level : uint8_t { Coarse = 0, Medium = 1, Fine = 2 };
inline constexpr int kLevels = 3;
inline constexpr int kMaxCells = 16;          ///< micropolygons along an edge of a patch
inline constexpr int kBlockCells = 4;         ///< micropolygons along an edge of a block of a patch
inline constexpr int kMaxBlockVertices = 25;  ///< of a block with its rim, and of the medium level

/// Up to four vertices around a point, with weights that sum to one.
struct VertexWeights {
  uint32_t index[4];
  float weight[4];
  int count;
};

/// Where a vertex of the fine level is kept: a block of 4x4 cells, of 16 in a patch, and the place in its 5x5
/// vertices. Vertices on the rim of a block are in the next one, too.
struct BlockVertex {
  uint8_t block, index;
};

/// A tile of a face: the part u0 + [0,1] du, v0 + [0,1] dv of its domain. In a triangle du = dv, negative for
/// the tiles that point the other way; the local domain is a triangle again. Or a group of faces that are
/// smaller than a micropolygon (face_groups.h): one of them, whose centre's value stands for all.
struct Patch {
  uint32_t placement;  ///< index of the placed primitive
  uint32_t face;
  float u0, v0, du, dv;
  float spacing;  ///< world distance of neighbouring vertices at the fine level (the larger direction)
  uint8_t cellsU, cellsV;  ///< powers of two up to 16; 0 = one value at the centre stands for the whole patch
  FaceShape shape;
  uint8_t group = 0;  ///< 1: a group of faces; 2: of groups, 3: of groups of groups; 0 = a tile

  int cellsAt(Level level, int cells) const {
    return level == Level::Fine ? cells : std::min(cells, level == Level::Medium ? 4 : 1);
  }
  /// The coarsest level with the same vertices: patches of few micropolygons have less than three
  /// resolutions.
  Level canonical(Level level) const;
  float spacingAt(Level level) const {
    const int fine = std::max<int>({cellsU, cellsV, 1});
    return spacing * static_cast<float>(fine) / static_cast<float>(std::max(cellsAt(level, fine), 1));
  }
  uint32_t vertexCount(Level level) const;
  /// Local (u, v) in the patch of a vertex: exact multiples of 1/16.
  V2f vertexPosition(Level level, uint32_t vertex) const;
  /// Where a linear function has the mean that the vertex's weight (see locate()) gives it: a third of a cell
  /// away from the patch's rim for what is on it. Values found there keep, interpolated, the mean of what is
  /// linear within the patch, which values on the rim, in the dark of creases, do not.
  V2f vertexCentroid(Level level, uint32_t vertex) const;
  /// The vertices around local (u, v) and their bilinear (triangle: linear) weights.
  VertexWeights locate(Level level, float u, float v) const;

  /// The fine vertices of `around` (of Fine's locate) in the block that holds their cell; returns the block.
  uint8_t blockOf(const VertexWeights& around, uint32_t index[4]) const;
  BlockVertex blockOf(uint32_t vertex) const;

  /// Pairs of vertices such that whatever parts the corners of a cell from each other lies between one of
  /// them: the diagonals of quads, the edges of triangles.
  template <class Visit>
  void forEachDiagonal(Level level, Visit visit) const;

  /// Column and row of a vertex of the fine lattice, and the vertex that is there.
  std::array<uint32_t, 2> latticePosition(uint32_t vertex) const;
  uint32_t latticeVertex(uint32_t i, uint32_t j) const;

  V2f toFace(const V2f& local) const { return {u0 + local.x * du, v0 + local.y * dv}; }
  V2f toLocal(float u, float v) const { return {(u - u0) / du, (v - v0) / dv}; }
};

template <class Visit>
void Patch::forEachDiagonal(Level level, Visit visit) const {
  const auto nu = static_cast<uint32_t>(cellsAt(level, cellsU)),
             nv = static_cast<uint32_t>(cellsAt(level, cellsV));
  if (shape == FaceShape::Quad) {
    for (uint32_t j = 0; j < nv; ++j)
      for (uint32_t i = 0; i < nu; ++i) {
        const uint32_t corner = j * (nu + 1) + i;
        visit(corner, corner + nu + 2);
        visit(corner + 1, corner + nu + 1);
      }
    return;
  }
  uint32_t row = 0;
  for (uint32_t j = 0; j < nu; row += nu + 1 - j, ++j)
    for (uint32_t i = 0; i < nu - j; ++i) {
      const uint32_t corner = row + i, above = row + nu + 1 - j + i;
      visit(corner, corner + 1);
      visit(corner, above);
      visit(corner + 1, above);
    }
}

/// A primitive at another time than the opening of the shutter.
struct DicePose {
  std::shared_ptr<const Surface> surface;  ///< with the same faces; null: that of the opening
  M44f objectToWorld;
};

/// What dicing needs to know of a placed primitive.
struct DiceInput {
  const Surface* surface;
  M44f objectToWorld;
  float shadingRate;                     ///< micropolygon area in pixels
  float length = 0;                      ///< edge of a micropolygon in units of space; 0: by the shading rate
  bool inObjectSpace = false;            ///< of `length`
  bool foreshorten = true;               ///< on screen lengths count as they are seen
  std::vector<DicePose> poses = {};      ///< of what moves: where it is seen largest says how fine it is
  std::span<const uint32_t> order = {};  ///< mortonOrder() of the surface's faces, if it is known already
};

/// The patches of a scene. Those of a placement are made when the first of them is asked for, and stay.
class PatchTable {
 public:
  /// Patches of one placement, beside one for each of its faces, that make it too many.
  static constexpr size_t kMostPatches = size_t{1} << 18;

  /// `input` describes a placement, `placements` is how many there are. Faces are cut into patches whose
  /// micropolygons cover about shadingRate pixels where they are seen, and are coarser outside of the view.
  /// A placement never has more than `limit` patches and one for each face: beyond, patches stay too large,
  /// and `limited()` says so.
  PatchTable(const RasterCamera& camera, size_t placements, std::function<DiceInput(uint32_t)> input,
             size_t limit = kMostPatches);
  ~PatchTable();

  /// To be called while there are no placements, when there will be more. [main]
  void makeRoom() { diced_.makeRoom(); }
  /// Makes it know placements up to a number. [one thread at a time; others may read meanwhile]
  void growTo(size_t placements) const { diced_.growTo(placements); }

  /// The patch of a placed primitive's face that holds (u, v). The number is the patch's for as long as the
  /// table lives, but another one in another run: nothing that reaches the picture may depend on it.
  /// [any thread]
  uint32_t find(uint32_t placement, uint32_t face, float u, float v) const {
    return diced(placement).find(face, u, v);
  }
  /// The next larger group that a group of faces is in; kNone: there is none. [any thread]
  uint32_t coarser(uint32_t index) const {
    const Diced& known = diced((*this)[index].placement);
    const uint32_t next = known.coarser[index - known.first - known.firstGroup];
    return next == kNone ? kNone : known.first + next;
  }
  const Patch& operator[](uint32_t index) const {  ///< [any thread]
    return chunks_[index / kChunk].load(std::memory_order_acquire)[index % kChunk];
  }
  /// First patch of a placement and how many it has. [any thread]
  std::pair<uint32_t, uint32_t> patchesOf(uint32_t placement) const {
    return {diced(placement).first, diced(placement).count};
  }
  size_t size() const { return size_; }  ///< patches made so far
  bool limited() const { return limited_; }
  size_t memory() const { return memory_; }

 private:
  struct Node {
    /// Of two (triangle: four) children; the patch when `split` is Leaf; the first of `cells` when it is
    /// Grid.
    uint32_t first;
    /// Grid: 2^logU by 2^logV cells of a face of many patches, for a look-up in one step. The next node is
    /// the face's tree, for cells that several patches share.
    enum class Split : uint8_t { Leaf, U, V, Triangle, Grid } split;
    uint8_t logU = 0, logV = 0;
  };
  /// A placement that is diced. Patches count from `first`; without roots, patch f is all of face f.
  struct Diced {
    static constexpr uint32_t kGroup = 0x80000000u;
    uint32_t first = 0, count = 0;
    std::vector<uint32_t> roots;  ///< node of each face; with kGroup: the group that the face is in, a patch
    std::vector<Node> nodes;
    std::vector<uint32_t> cells;    ///< of nodes that are Grid: the patch that holds all of a cell, or kNone
    uint32_t firstGroup = 0;        ///< groups are the last patches, the finest first
    std::vector<uint32_t> coarser;  ///< by group: the patch that coarser() gives, or kNone
    uint32_t find(uint32_t face, float u, float v) const;
  };
  class Dicer;

  const Diced& diced(uint32_t placement) const {
    const Diced* known = diced_[placement].load(std::memory_order_acquire);
    return known ? *known : dice(placement);
  }
  const Diced& dice(uint32_t placement) const;
  uint32_t store(std::span<const Patch> patches) const;

  static constexpr uint32_t kChunk = 1u << 16;
  static constexpr size_t kMostChunks = (size_t{1} << 32) / kChunk, kMutexes = 64;

  const RasterCamera camera_;
  const std::function<DiceInput(uint32_t)> input_;
  const size_t limit_;
  mutable StableVector<std::atomic<const Diced*>> diced_;  ///< by placement
  mutable std::unique_ptr<std::atomic<Patch*>[]> chunks_;  ///< kChunk patches each
  mutable std::array<std::mutex, kMutexes> diceMutex_;     ///< by placement: nothing is diced twice
  mutable std::mutex storeMutex_;
  mutable std::atomic<size_t> size_ = 0, memory_ = 0;
  mutable std::atomic<bool> limited_ = false;
};

}  // namespace patina
