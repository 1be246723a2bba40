// SPDX-License-Identifier: Apache-2.0
// Dicing: how many micropolygons a tile wants, and the cutting of faces into patches.
#include <array>

#include "renderer/base/statistics.h"
#include "renderer/geometry/face_groups.h"
#include "renderer/geometry/face_order.h"
#include "renderer/geometry/patches.h"

namespace patina {
namespace {

STAT_COUNTER("Geometry/patches", patchCount);
STAT_COUNTER("Geometry/placements diced", dicedPlacements);
STAT_COUNTER("Geometry/small faces in groups", groupedFaces);
STAT_COUNTER("Geometry/groups of small faces", fineGroups);

constexpr size_t kBlock = size_t{1} << 14;  // faces that a thread measures at a time

constexpr float kOffScreenFactor = 0.25f;  // micropolygons outside the view are so much coarser (in length)
constexpr float kForeshorteningLimit =
    0.25f;                     // a length seen at a grazing angle counts at least so much of itself
constexpr float kMargin = 16;  // pixels around the frame that count as seen
constexpr int kMaxDepth = 44;  // binary splits of a face
/// Tiles are no smaller part of a face along u or v: places in a face are floats, whose error, 2^-24, is then
/// a sixteenth of a micropolygon. What would want smaller ones is shaded where it is met, as their spacing
/// says that they are too far apart.
constexpr float kLeastPart = 0x1p-16f;
constexpr float kLessThanOne = 0.75f;  // micropolygons along a tile that needs one value only

/// Corners of a tile and the points half-way between them, in object space.
std::array<V3f, 9> objectLattice(const Surface& from, uint32_t face, float u0, float v0, float du, float dv) {
  std::array<V2f, 9> uv;
  for (size_t j = 0; j < 3; ++j)
    for (size_t i = 0; i < 3; ++i)
      uv[3 * j + i] = {u0 + du * 0.5f * static_cast<float>(i), v0 + dv * 0.5f * static_cast<float>(j)};
  if (from.faceShape(face) == FaceShape::Triangle)  // the far half repeats the hypotenuse
    uv[5] = uv[7] = uv[8] = {u0 + du * 0.5f, v0 + dv * 0.5f};
  std::array<V3f, 9> points;
  if (from.isFlat()) {
    V3f c[4];
    from.corners(face, c);
    for (size_t k = 0; k < 9; ++k) {
      const float u = uv[k].x, v = uv[k].y;
      const bool first = from.faceShape(face) == FaceShape::Triangle || u + v <= 1;
      points[k] = first ? c[0] + (c[1] - c[0]) * u + (c[2] - c[0]) * v
                        : c[3] + (c[2] - c[3]) * (1 - u) + (c[1] - c[3]) * (1 - v);
    }
  } else {
    std::array<SurfacePoint, 9> surface;
    from.evaluateMany(face, uv, surface);
    for (size_t k = 0; k < 9; ++k) points[k] = surface[k].P;
  }
  return points;
}

/// Power of two nearest in ratio to `cells`, within [1, 16]; 0 when one sample is enough.
uint8_t roundCells(float cells) {
  int n = 1;
  while (n < kMaxCells && cells > static_cast<float>(n) * 1.41421356f) n *= 2;
  return static_cast<uint8_t>(n);
}

struct Sphere {
  V3f center;
  float radius;
};
Sphere boundingSphere(std::span<const V3f> points) {
  Box3f box;
  for (const V3f& p : points) box.extendBy(p);
  const V3f center = (box.min + box.max) * 0.5f;
  float squared = 0;
  for (const V3f& p : points) squared = std::max(squared, (p - center).length2());
  return {center, std::sqrt(squared)};
}

}  // namespace

/// Cuts one placement into patches.
class PatchTable::Dicer {
 public:
  Dicer(const RasterCamera& camera, const DiceInput& input, uint32_t placement, size_t limit)
      : camera_(camera), input_(input), placement_(placement), limit_(limit) {}
  void run();

  std::vector<Patch> patches;
  Diced diced;
  bool limited = false;

 private:
  struct Tile {
    float u0, v0, du, dv;
    float cellsU, cellsV, spacing;  ///< wanted
    float worldU = 0, worldV = 0;   ///< lengths, of quads
    void setSpacing() {
      spacing = std::max(worldU / static_cast<float>(roundCells(cellsU)),
                         worldV / static_cast<float>(roundCells(cellsV)));
    }
    bool tooLarge() const {
      constexpr float kTooMany = kMaxCells * 1.41421356f;
      return cellsU > kTooMany || cellsV > kTooMany;
    }
  };
  /// What is wanted for a whole face.
  struct Wanted {
    float cellsU, cellsV, spacing;
    bool lessThanOne() const { return cellsU < kLessThanOne && cellsV < kLessThanOne; }
    Tile tile() const { return {0, 0, 1, 1, cellsU, cellsV, spacing}; }
  };
  Tile measure(uint32_t face, float u0, float v0, float du, float dv) const;
  Wanted want(uint32_t face) const;
  float micropolygonEdge(uint32_t face) const;
  void addGroups(std::span<const Wanted> faces);
  Tile measureAt(const Surface& surface, const M44f& objectToWorld, uint32_t face, float u0, float v0,
                 float du, float dv) const;
  void split(uint32_t face, const Tile& tile, uint32_t node, int depth);
  void addPatch(uint32_t face, const Tile& tile);
  bool addGrid(uint32_t node, size_t firstPatch);

  const RasterCamera& camera_;
  const DiceInput& input_;
  uint32_t placement_;
  size_t limit_;
};

PatchTable::Dicer::Tile PatchTable::Dicer::measure(uint32_t face, float u0, float v0, float du,
                                                   float dv) const {
  Tile tile = measureAt(*input_.surface, input_.objectToWorld, face, u0, v0, du, dv);
  for (const DicePose& pose : input_.poses) {
    const Tile other =
        measureAt(pose.surface ? *pose.surface : *input_.surface, pose.objectToWorld, face, u0, v0, du, dv);
    tile.cellsU = std::max(tile.cellsU, other.cellsU), tile.cellsV = std::max(tile.cellsV, other.cellsV);
  }
  if (!input_.poses.empty() && input_.surface->faceShape(face) == FaceShape::Quad) tile.setSpacing();
  return tile;
}

PatchTable::Dicer::Tile PatchTable::Dicer::measureAt(const Surface& surface, const M44f& objectToWorld,
                                                     uint32_t face, float u0, float v0, float du,
                                                     float dv) const {
  const std::array<V3f, 9> object = objectLattice(surface, face, u0, v0, du, dv);
  std::array<V3f, 9> p;
  for (size_t k = 0; k < 9; ++k) p[k] = transformPoint(object[k], objectToWorld);
  const auto [center, radius] = boundingSphere(p);
  const bool visible = camera_.mayBeVisible(center, radius, kMargin);
  // What reaches behind the eye is measured where it is nearest, which is seldom at the picture's corner,
  // too: of views up to 120 degrees that is more than enough.
  constexpr float kSlack = 0.25f;
  const float distance = std::max({camera_.nearestDistance(center, radius), 0.25f * radius, 1e-30f});
  const float perUnit =
      std::max(camera_.pixelsPerUnit(distance), kSlack * camera_.pixelsPerUnit(center, radius)) *
      (visible ? 1 : kOffScreenFactor);

  // On screen, lengths count as they are seen, unless the tile reaches behind the eye.
  std::array<V2f, 9> raster;
  // Nor while the camera moves: the direction of view is not one.
  bool projected = visible && input_.foreshorten && !camera_.moves();
  for (size_t k = 0; k < 9 && projected; ++k) {
    const V3f c = camera_.toCamera(p[k]);
    projected = !camera_.perspective() || c.z > 0.05f * radius;
    if (projected) raster[k] = camera_.toRaster(c);
  }
  const bool bySpace = input_.length > 0;
  const auto length = [&](size_t a, size_t b) {
    if (bySpace) return input_.inObjectSpace ? (object[a] - object[b]).length() : (p[a] - p[b]).length();
    const float whole = (p[a] - p[b]).length() * perUnit;
    return projected ? std::max((raster[a] - raster[b]).length(), kForeshorteningLimit * whole) : whole;
  };
  const float edge = 1 / (bySpace ? input_.length : std::sqrt(input_.shadingRate));
  Tile tile{u0, v0, du, dv, 0, 0, 0};
  if (surface.faceShape(face) == FaceShape::Triangle) {
    tile.cellsU =
        std::max({length(0, 1) + length(1, 2), length(0, 3) + length(3, 6), length(2, 4) + length(4, 6)}) *
        edge;
    tile.cellsV = tile.cellsU;
    tile.spacing = std::max({(p[0] - p[2]).length(), (p[0] - p[6]).length(), (p[2] - p[6]).length()});
    return tile;
  }
  for (size_t k = 0; k < 3; ++k) {
    tile.cellsU = std::max(tile.cellsU, (length(3 * k, 3 * k + 1) + length(3 * k + 1, 3 * k + 2)) * edge);
    tile.cellsV = std::max(tile.cellsV, (length(k, k + 3) + length(k + 3, k + 6)) * edge);
    tile.worldU =
        std::max(tile.worldU, (p[3 * k] - p[3 * k + 1]).length() + (p[3 * k + 1] - p[3 * k + 2]).length());
    tile.worldV = std::max(tile.worldV, (p[k] - p[k + 3]).length() + (p[k + 3] - p[k + 6]).length());
  }
  tile.setSpacing();
  return tile;
}

void PatchTable::Dicer::addPatch(uint32_t face, const Tile& tile) {
  Patch patch{placement_,
              face,
              tile.u0,
              tile.v0,
              tile.du,
              tile.dv,
              tile.spacing,
              roundCells(tile.cellsU),
              roundCells(tile.cellsV),
              input_.surface->faceShape(face)};
  if (tile.cellsU < kLessThanOne && tile.cellsV < kLessThanOne) patch.cellsU = patch.cellsV = 0;
  if (patch.shape == FaceShape::Triangle) patch.spacing /= static_cast<float>(std::max<int>(patch.cellsU, 1));
  patches.push_back(patch);
}

void PatchTable::Dicer::split(uint32_t face, const Tile& tile, uint32_t node, int depth) {
  std::vector<Node>& nodes = diced.nodes;
  if (tile.tooLarge() && patches.size() >= limit_) limited = true;
  const bool isTriangle = input_.surface->faceShape(face) == FaceShape::Triangle;
  const bool alongU = tile.cellsU >= tile.cellsV;
  const bool isLeast = std::abs(alongU || isTriangle ? tile.du : tile.dv) <= kLeastPart;
  if (!tile.tooLarge() || depth >= kMaxDepth || isLeast || limited) {
    nodes[node] = {static_cast<uint32_t>(patches.size()), Node::Split::Leaf};
    addPatch(face, tile);
    return;
  }
  const auto first = static_cast<uint32_t>(nodes.size());
  if (isTriangle) {
    nodes[node] = {first, Node::Split::Triangle};
    nodes.resize(nodes.size() + 4);
    const float h = tile.du / 2;
    const V2f corner[4] = {
        {tile.u0, tile.v0}, {tile.u0 + h, tile.v0}, {tile.u0, tile.v0 + h}, {tile.u0 + h, tile.v0 + h}};
    for (uint32_t k = 0; k < 4; ++k) {
      const float size = k == 3 ? -h : h;
      split(face, measure(face, corner[k].x, corner[k].y, size, size), first + k, depth + 2);
    }
    return;
  }
  nodes[node] = {first, alongU ? Node::Split::U : Node::Split::V};
  nodes.resize(nodes.size() + 2);
  const float du = alongU ? tile.du / 2 : tile.du, dv = alongU ? tile.dv : tile.dv / 2;
  for (uint32_t k = 0; k < 2; ++k) {
    const float u0 = tile.u0 + (alongU && k ? du : 0), v0 = tile.v0 + (!alongU && k ? dv : 0);
    split(face, measure(face, u0, v0, du, dv), first + k, depth + 1);
  }
}

void PatchTable::Dicer::run() {
  const uint32_t count = input_.surface->faceCount();
  limit_ += count;
  std::vector<Wanted> faces(count);
  forEachPart(count, kBlock, [&](size_t begin, size_t end) {
    for (size_t face = begin; face < end; ++face) {
      faces[face] = want(static_cast<uint32_t>(face));
    }
  });
  const auto small =
      std::count_if(faces.begin(), faces.end(), [](const Wanted& w) { return w.lessThanOne(); });
  const bool grouped = input_.surface->isFlat() && small > 1;
  if (!grouped &&
      std::none_of(faces.begin(), faces.end(), [](const Wanted& w) { return w.tile().tooLarge(); })) {
    patches.reserve(count);
    for (uint32_t face = 0; face < count; ++face) addPatch(face, faces[face].tile());
    return;
  }
  diced.roots.resize(count);
  for (uint32_t face = 0; face < count; ++face) {
    if (grouped && faces[face].lessThanOne()) continue;
    const Tile tile = faces[face].tile();
    const bool mayHaveGrid = tile.tooLarge() && input_.surface->faceShape(face) == FaceShape::Quad;
    const auto grid = static_cast<uint32_t>(diced.nodes.size()), root = grid + (mayHaveGrid ? 1 : 0);
    diced.nodes.resize(root + 1);
    const size_t firstPatch = patches.size();
    split(face, tile, root, 0);
    diced.roots[face] = mayHaveGrid && addGrid(grid, firstPatch) ? grid : root;
  }
  if (grouped) addGroups(faces);
  diced.nodes.shrink_to_fit(), diced.cells.shrink_to_fit();
}

/// Makes the cells of a quad face whose patches are the last ones, unless they are few. There are at most
/// four times as many cells as patches: smaller patches are left to the tree.
bool PatchTable::Dicer::addGrid(uint32_t node, size_t firstPatch) {
  constexpr size_t kFew = 4, kCellsOfPatch = 4;
  const auto ofFace = std::span(patches).subspan(firstPatch);
  if (ofFace.size() < kFew) return false;
  const auto splits = [](float part) { return static_cast<uint32_t>(-std::ilogb(part)); };
  uint32_t logU = 0, logV = 0;
  for (const Patch& patch : ofFace)
    logU = std::max(logU, splits(patch.du)), logV = std::max(logV, splits(patch.dv));
  while (logU + logV > 32 || uint64_t{1} << (logU + logV) > kCellsOfPatch * ofFace.size())
    --(logU > logV ? logU : logV);
  const auto first = static_cast<uint32_t>(diced.cells.size());
  diced.cells.resize(first + (size_t{1} << (logU + logV)), kNone);
  for (size_t k = 0; k < ofFace.size(); ++k) {
    const Patch& patch = ofFace[k];
    const uint32_t a = splits(patch.du), b = splits(patch.dv);
    if (a > logU || b > logV) continue;
    const auto i = static_cast<uint32_t>(std::ldexp(patch.u0, static_cast<int>(logU))),
               j = static_cast<uint32_t>(std::ldexp(patch.v0, static_cast<int>(logV)));
    for (uint32_t row = j; row < j + (1u << (logV - b)); ++row)
      std::fill_n(diced.cells.begin() + first + (row << logU) + i, 1u << (logU - a),
                  static_cast<uint32_t>(firstPatch + k));
  }
  diced.nodes[node] = {first, Node::Split::Grid, static_cast<uint8_t>(logU), static_cast<uint8_t>(logV)};
  return true;
}

PatchTable::Dicer::Wanted PatchTable::Dicer::want(uint32_t face) const {
  if (input_.surface->isFlat() && input_.surface->faceShape(face) == FaceShape::Triangle &&
      input_.poses.empty() && !(input_.length > 0)) {
    // What is much smaller than a micropolygon needs no closer look. Seen aslant it may be longer than the
    // mean of both directions.
    V3f p[4];
    input_.surface->corners(face, p);
    for (int k = 0; k < 3; ++k) p[k] = transformPoint(p[k], input_.objectToWorld);
    const float longest =
        std::sqrt(std::max({(p[1] - p[0]).length2(), (p[2] - p[0]).length2(), (p[2] - p[1]).length2()}));
    if (camera_.nearestDistance(p[0], longest) > 0 &&
        4 * longest * camera_.pixelsPerUnit(p[0], longest) < kLessThanOne * std::sqrt(input_.shadingRate))
      return {0, 0, longest};
  }
  const Tile tile = measure(face, 0, 0, 1, 1);
  return {tile.cellsU, tile.cellsV, tile.spacing};
}

/// Length of a micropolygon's edge near a face, world units.
float PatchTable::Dicer::micropolygonEdge(uint32_t face) const {
  V3f corner[4];
  input_.surface->corners(face, corner);
  const V3f p = transformPoint(corner[0], input_.objectToWorld);
  if (input_.length > 0 && !input_.inObjectSpace) return input_.length;
  if (input_.length > 0) {
    // The larger of how lengths along two of its edges grow.
    const auto growth = [&](const V3f& e) {
      const float length = e.length();
      return length > 0 ? transformVector(e, input_.objectToWorld).length() / length : 0;
    };
    return input_.length * std::max(growth(corner[1] - corner[0]), growth(corner[2] - corner[0]));
  }
  const float seen = camera_.mayBeVisible(p, 0, kMargin) ? 1 : kOffScreenFactor;
  const float pixels = seen * camera_.pixelsPerUnit(p, 0);
  return std::sqrt(input_.shadingRate) / pixels;
}

/// Patches for the faces that are smaller than a micropolygon: groups of them.
void PatchTable::Dicer::addGroups(std::span<const Wanted> faces) {
  std::vector<uint32_t> ownOrder;
  if (input_.order.empty()) ownOrder = mortonOrder(*input_.surface);
  const FaceGroups groups = groupFaces(
      *input_.surface, input_.objectToWorld, input_.order.empty() ? ownOrder : input_.order,
      [&](uint32_t face) { return faces[face].lessThanOne(); },
      [&](uint32_t face) { return micropolygonEdge(face); }, diced.roots);
  diced.firstGroup = static_cast<uint32_t>(patches.size());
  for (uint32_t face = 0; face < faces.size(); ++face)
    if (faces[face].lessThanOne()) diced.roots[face] = (diced.roots[face] + diced.firstGroup) | Diced::kGroup;
  size_t total = 0;
  for (const auto& level : groups.levels) total += level.size();
  patches.reserve(patches.size() + total);
  diced.coarser.reserve(total);
  for (uint8_t level = 0; level < kGroupLevels; ++level) {
    const auto next = static_cast<uint32_t>(patches.size() + groups.levels[level].size());
    for (const FaceGroup& g : groups.levels[level]) {
      patches.push_back({placement_, g.face, 0, 0, 1, 1, g.spacing, 0, 0, input_.surface->faceShape(g.face),
                         static_cast<uint8_t>(level + 1)});
      diced.coarser.push_back(g.coarser == kNone ? kNone : next + g.coarser);
    }
  }
  fineGroups += static_cast<int64_t>(groups.levels[0].size());
  groupedFaces += std::count_if(faces.begin(), faces.end(), [](const Wanted& w) { return w.lessThanOne(); });
}

const PatchTable::Diced& PatchTable::dice(uint32_t placement) const {
  const std::scoped_lock lock(diceMutex_[placement % kMutexes]);
  if (const Diced* known = diced_[placement].load(std::memory_order_acquire)) return *known;
  const DiceInput input = input_(placement);
  Dicer dicer(camera_, input, placement, limit_);
  dicer.run();
  if (dicer.limited) limited_ = true;
  auto diced = std::make_unique<Diced>(std::move(dicer.diced));
  diced->first = store(dicer.patches);
  diced->count = static_cast<uint32_t>(dicer.patches.size());
  ++dicedPlacements;
  patchCount += diced->count;
  memory_ +=
      dicer.patches.size() * sizeof(Patch) + diced->nodes.capacity() * sizeof(Node) +
      (diced->roots.capacity() + diced->coarser.capacity() + diced->cells.capacity()) * sizeof(uint32_t) +
      sizeof(Diced);
  diced_[placement].store(diced.get(), std::memory_order_release);
  return *diced.release();
}

}  // namespace patina
