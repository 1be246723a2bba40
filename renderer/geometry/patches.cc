// SPDX-License-Identifier: Apache-2.0
// The vertex lattices of a patch, and the look-up from a face's (u, v) to its patch.
#include "renderer/geometry/patches.h"

namespace patina {
namespace {

/// First vertex of row j in a triangular lattice of n cells: rows have n+1, n, ..., 1 vertices.
constexpr uint32_t triangleRow(uint32_t n, uint32_t j) { return j * (n + 1) - j * (j - 1) / 2; }

}  // namespace

Level Patch::canonical(Level level) const {
  while (level != Level::Coarse) {
    const Level coarser = static_cast<Level>(static_cast<int>(level) - 1);
    if (cellsAt(coarser, cellsU) != cellsAt(level, cellsU) ||
        cellsAt(coarser, cellsV) != cellsAt(level, cellsV))
      break;
    level = coarser;
  }
  return level;
}

uint32_t Patch::vertexCount(Level level) const {
  const auto nu = static_cast<uint32_t>(cellsAt(level, cellsU)),
             nv = static_cast<uint32_t>(cellsAt(level, cellsV));
  if (cellsU == 0) return 1;
  return shape == FaceShape::Quad ? (nu + 1) * (nv + 1) : (nu + 1) * (nu + 2) / 2;
}

V2f Patch::vertexPosition(Level level, uint32_t vertex) const {
  if (cellsU == 0) return shape == FaceShape::Quad ? V2f(0.5f, 0.5f) : V2f(1.0f / 3, 1.0f / 3);
  const auto nu = static_cast<uint32_t>(cellsAt(level, cellsU)),
             nv = static_cast<uint32_t>(cellsAt(level, cellsV));
  if (shape == FaceShape::Quad)
    return {static_cast<float>(vertex % (nu + 1)) / static_cast<float>(nu),
            static_cast<float>(vertex / (nu + 1)) / static_cast<float>(nv)};
  uint32_t row = 0;
  while (triangleRow(nu, row + 1) <= vertex) ++row;
  return {static_cast<float>(vertex - triangleRow(nu, row)) / static_cast<float>(nu),
          static_cast<float>(row) / static_cast<float>(nu)};
}

V2f Patch::vertexCentroid(Level level, uint32_t vertex) const {
  const V2f at = vertexPosition(level, vertex);
  if (cellsU == 0) return at;
  const auto nu = static_cast<float>(cellsAt(level, cellsU)), nv = static_cast<float>(cellsAt(level, cellsV));
  if (shape == FaceShape::Quad) {
    const float marginU = 1 / (3 * nu), marginV = 1 / (3 * nv);
    return {std::clamp(at.x, marginU, 1 - marginU), std::clamp(at.y, marginV, 1 - marginV)};
  }
  // Each triangle around it draws by a quarter of its edges: one in a corner, three at an edge, all six
  // elsewhere.
  const V3f where(1 - at.x - at.y, at.x, at.y);
  V3f moved = where;
  const float near = 0.5f / nu;
  for (int k = 0; k < 3; ++k) {
    if (where[k] > 1 - near) {
      moved = V3f(0.25f / nu);
      moved[k] = 1 - 0.5f / nu;
      break;
    }
    if (where[k] < near) {
      moved -= V3f(1 / (6 * nu));
      moved[k] += 1 / (2 * nu);
    }
  }
  return {moved.y, moved.z};
}

VertexWeights Patch::locate(Level level, float u, float v) const {
  if (cellsU == 0) return {{0, 0, 0, 0}, {1, 0, 0, 0}, 1};
  const int nu = cellsAt(level, cellsU), nv = cellsAt(level, cellsV);
  const float x = std::clamp(u, 0.0f, 1.0f) * static_cast<float>(nu);
  const float y = std::clamp(v, 0.0f, 1.0f) * static_cast<float>(nv);
  if (shape == FaceShape::Quad) {
    const int i = std::min(static_cast<int>(x), nu - 1), j = std::min(static_cast<int>(y), nv - 1);
    const float a = x - static_cast<float>(i), b = y - static_cast<float>(j);
    const auto k = static_cast<uint32_t>(j * (nu + 1) + i), row = static_cast<uint32_t>(nu + 1);
    return {{k, k + 1, k + row, k + row + 1}, {(1 - a) * (1 - b), a * (1 - b), (1 - a) * b, a * b}, 4};
  }
  const auto n = static_cast<uint32_t>(nu);
  uint32_t j = std::min(static_cast<uint32_t>(y), n - 1);
  uint32_t i = std::min(static_cast<uint32_t>(x), n - 1 - j);
  const float a = std::clamp(x - static_cast<float>(i), 0.0f, 1.0f);
  const float b = std::clamp(y - static_cast<float>(j), 0.0f, 1.0f);
  const uint32_t below = triangleRow(n, j) + i, above = triangleRow(n, j + 1) + i;
  if (a + b <= 1 || i + j == n - 1) {
    const float rest = std::max(0.0f, 1 - a - b), sum = rest + a + b;
    return {{below, below + 1, above, 0}, {rest / sum, a / sum, b / sum, 0}, 3};
  }
  return {{above + 1, above, below + 1, 0}, {a + b - 1, 1 - a, 1 - b, 0}, 3};
}

std::array<uint32_t, 2> Patch::latticePosition(uint32_t vertex) const {
  if (cellsU == 0) return {0, 0};
  if (shape == FaceShape::Quad) return {vertex % (cellsU + 1u), vertex / (cellsU + 1u)};
  uint32_t row = 0;
  while (triangleRow(cellsU, row + 1) <= vertex) ++row;
  return {vertex - triangleRow(cellsU, row), row};
}

uint32_t Patch::latticeVertex(uint32_t i, uint32_t j) const {
  if (cellsU == 0) return 0;
  return shape == FaceShape::Quad ? j * (cellsU + 1u) + i : triangleRow(cellsU, j) + i;
}

uint8_t Patch::blockOf(const VertexWeights& around, uint32_t index[4]) const {
  std::array<uint32_t, 2> at[4], corner{kMaxCells, kMaxCells};
  for (int k = 0; k < around.count; ++k) {
    at[k] = latticePosition(around.index[k]);
    for (size_t c = 0; c < 2; ++c) corner[c] = std::min(corner[c], at[k][c]);
  }
  const uint32_t i = corner[0] / kBlockCells, j = corner[1] / kBlockCells;
  for (int k = 0; k < around.count; ++k)
    index[k] = (at[k][1] - j * kBlockCells) * (kBlockCells + 1) + at[k][0] - i * kBlockCells;
  return static_cast<uint8_t>(j * (kMaxCells / kBlockCells) + i);
}

BlockVertex Patch::blockOf(uint32_t vertex) const {
  const auto [i, j] = latticePosition(vertex);
  constexpr uint32_t kLast = kMaxCells / kBlockCells - 1;
  const uint32_t bi = std::min(i / kBlockCells, kLast), bj = std::min(j / kBlockCells, kLast);
  return {static_cast<uint8_t>(bj * (kLast + 1) + bi),
          static_cast<uint8_t>((j - bj * kBlockCells) * (kBlockCells + 1) + i - bi * kBlockCells)};
}

uint32_t PatchTable::Diced::find(uint32_t face, float u, float v) const {
  if (roots.empty()) return first + face;
  if (roots[face] & kGroup) return first + (roots[face] & ~kGroup);
  const Node* node = &nodes[roots[face]];
  if (node->split == Node::Split::Grid) {
    // Cells of powers of two: they end exactly where the tree's tiles do.
    const auto along = [](float x, uint8_t log) {
      const auto n = static_cast<float>(1u << log);
      return static_cast<uint32_t>(std::min(std::max(0.0f, x * n), n - 1));  // 0 for NaN
    };
    const uint32_t patch = cells[node->first + (along(v, node->logV) << node->logU) + along(u, node->logU)];
    if (patch != kNone) return first + patch;
    ++node;
  }
  // Walk down, keeping (u, v) relative to the tile at hand.
  while (node->split != Node::Split::Leaf) {
    uint32_t child = 0;
    switch (node->split) {
      case Node::Split::U:
        child = u >= 0.5f;
        u = 2 * u - static_cast<float>(child);
        break;
      case Node::Split::V:
        child = v >= 0.5f;
        v = 2 * v - static_cast<float>(child);
        break;
      default:
        if (u >= 0.5f) {
          child = 1;
          u = 2 * u - 1, v = 2 * v;
        } else if (v >= 0.5f) {
          child = 2;
          u = 2 * u, v = 2 * v - 1;
        } else if (u + v <= 0.5f) {
          u = 2 * u, v = 2 * v;
        } else {
          child = 3;
          u = 1 - 2 * u, v = 1 - 2 * v;
        }
    }
    node = &nodes[node->first + child];
  }
  return first + node->first;
}

PatchTable::PatchTable(const RasterCamera& camera, size_t placements,
                       std::function<DiceInput(uint32_t)> input, size_t limit)
    : camera_(camera),
      input_(std::move(input)),
      limit_(limit),
      chunks_(new std::atomic<Patch*>[kMostChunks]()) {
  growTo(placements);
}

PatchTable::~PatchTable() {
  for (const auto& diced : diced_) delete diced.load();
  for (size_t k = 0; k * kChunk < size_; ++k) delete[] chunks_[k].load();
}

uint32_t PatchTable::store(std::span<const Patch> patches) const {
  const std::scoped_lock lock(storeMutex_);
  const size_t first = size_, end = first + patches.size();
  if (end > kMostChunks * size_t{kChunk}) throw std::bad_alloc();
  for (size_t chunk = (first + kChunk - 1) / kChunk; chunk * kChunk < end; ++chunk)
    chunks_[chunk].store(new Patch[kChunk], std::memory_order_release);
  for (size_t k = 0; k < patches.size(); ++k)
    chunks_[(first + k) / kChunk].load(std::memory_order_relaxed)[(first + k) % kChunk] = patches[k];
  size_ = end;
  return static_cast<uint32_t>(first);
}

}  // namespace patina
