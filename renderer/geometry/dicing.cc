// SPDX-License-Identifier: Apache-2.0
// Dicing: how many micropolygons a tile wants, and the cutting of faces into patches.
#include <array>

#include "renderer/geometry/patches.h"

namespace patina {
namespace {

constexpr float kOffScreenFactor = 0.25f;  // micropolygons outside the view are so much coarser (in length)
constexpr float kForeshorteningLimit =
    0.25f;                     // a length seen at a grazing angle counts at least so much of itself
constexpr float kMargin = 16;  // pixels around the frame that count as seen
constexpr int kMaxDepth = 44;  // binary splits of a face

/// Corners of a tile and the points half-way between them, in world space.
std::array<V3f, 9> lattice(const DiceInput& input, uint32_t face, float u0, float v0, float du, float dv) {
  std::array<V2f, 9> uv;
  for (size_t j = 0; j < 3; ++j)
    for (size_t i = 0; i < 3; ++i)
      uv[3 * j + i] = {u0 + du * 0.5f * static_cast<float>(i), v0 + dv * 0.5f * static_cast<float>(j)};
  if (input.surface->faceShape(face) == FaceShape::Triangle)  // the far half repeats the hypotenuse
    uv[5] = uv[7] = uv[8] = {u0 + du * 0.5f, v0 + dv * 0.5f};
  std::array<V3f, 9> points;
  if (input.surface->isFlat()) {
    V3f c[4];
    input.surface->corners(face, c);
    for (size_t k = 0; k < 9; ++k) {
      const float u = uv[k].x, v = uv[k].y;
      const bool first = input.surface->faceShape(face) == FaceShape::Triangle || u + v <= 1;
      points[k] = first ? c[0] + (c[1] - c[0]) * u + (c[2] - c[0]) * v
                        : c[3] + (c[2] - c[3]) * (1 - u) + (c[1] - c[3]) * (1 - v);
    }
  } else {
    std::array<SurfacePoint, 9> surface;
    input.surface->evaluateMany(face, uv, surface);
    for (size_t k = 0; k < 9; ++k) points[k] = surface[k].P;
  }
  for (V3f& p : points) p = transformPoint(p, input.objectToWorld);
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

PatchTable::Tile PatchTable::measure(const RasterCamera& camera, const DiceInput& input, uint32_t face,
                                     float u0, float v0, float du, float dv) const {
  const std::array<V3f, 9> p = lattice(input, face, u0, v0, du, dv);
  const auto [center, radius] = boundingSphere(p);
  const float distance = std::max(camera.nearestDistance(center, radius), 0.25f * radius);
  const bool visible = camera.mayBeVisible(center, radius, kMargin);
  const float perUnit = camera.pixelsPerUnit(std::max(distance, 1e-30f)) * (visible ? 1 : kOffScreenFactor);

  // On screen, lengths count as they are seen, unless the tile reaches behind the eye.
  std::array<V2f, 9> raster;
  bool projected = visible;
  for (size_t k = 0; k < 9 && projected; ++k) {
    const V3f c = camera.toCamera(p[k]);
    projected = !camera.perspective() || c.z > 0.05f * radius;
    if (projected) raster[k] = camera.toRaster(c);
  }
  const auto length = [&](size_t a, size_t b) {
    const float whole = (p[a] - p[b]).length() * perUnit;
    return projected ? std::max((raster[a] - raster[b]).length(), kForeshorteningLimit * whole) : whole;
  };
  const float edge = 1 / std::sqrt(input.shadingRate);
  Tile tile{u0, v0, du, dv, 0, 0, 0};
  if (input.surface->faceShape(face) == FaceShape::Triangle) {
    tile.cellsU =
        std::max({length(0, 1) + length(1, 2), length(0, 3) + length(3, 6), length(2, 4) + length(4, 6)}) *
        edge;
    tile.cellsV = tile.cellsU;
    tile.spacing = std::max({(p[0] - p[2]).length(), (p[0] - p[6]).length(), (p[2] - p[6]).length()});
    return tile;
  }
  float worldU = 0, worldV = 0;
  for (size_t k = 0; k < 3; ++k) {
    tile.cellsU = std::max(tile.cellsU, (length(3 * k, 3 * k + 1) + length(3 * k + 1, 3 * k + 2)) * edge);
    tile.cellsV = std::max(tile.cellsV, (length(k, k + 3) + length(k + 3, k + 6)) * edge);
    worldU = std::max(worldU, (p[3 * k] - p[3 * k + 1]).length() + (p[3 * k + 1] - p[3 * k + 2]).length());
    worldV = std::max(worldV, (p[k] - p[k + 3]).length() + (p[k + 3] - p[k + 6]).length());
  }
  tile.spacing = std::max(worldU / static_cast<float>(roundCells(tile.cellsU)),
                          worldV / static_cast<float>(roundCells(tile.cellsV)));
  return tile;
}

void PatchTable::addPatch(const DiceInput& input, uint32_t placement, uint32_t face, const Tile& tile) {
  Patch patch{placement,
              face,
              tile.u0,
              tile.v0,
              tile.du,
              tile.dv,
              tile.spacing,
              roundCells(tile.cellsU),
              roundCells(tile.cellsV),
              input.surface->faceShape(face)};
  if (tile.cellsU < 0.75f && tile.cellsV < 0.75f) patch.cellsU = patch.cellsV = 0;
  if (patch.shape == FaceShape::Triangle) patch.spacing /= static_cast<float>(std::max<int>(patch.cellsU, 1));
  patches_.push_back(patch);
}

void PatchTable::split(const RasterCamera& camera, const DiceInput& input, uint32_t placement, uint32_t face,
                       const Tile& tile, uint32_t node, int depth) {
  constexpr float kTooMany = kMaxCells * 1.41421356f;
  const bool wanted = tile.cellsU > kTooMany || tile.cellsV > kTooMany;
  if (wanted && patches_.size() >= limit_) limited_ = true;
  if (!wanted || depth >= kMaxDepth || limited_) {
    nodes_[node] = {static_cast<uint32_t>(patches_.size()), Node::Split::Leaf};
    addPatch(input, placement, face, tile);
    return;
  }
  const auto first = static_cast<uint32_t>(nodes_.size());
  if (input.surface->faceShape(face) == FaceShape::Triangle) {
    nodes_[node] = {first, Node::Split::Triangle};
    nodes_.resize(nodes_.size() + 4);
    const float h = tile.du / 2;
    const V2f corner[4] = {
        {tile.u0, tile.v0}, {tile.u0 + h, tile.v0}, {tile.u0, tile.v0 + h}, {tile.u0 + h, tile.v0 + h}};
    for (uint32_t k = 0; k < 4; ++k) {
      const float size = k == 3 ? -h : h;
      split(camera, input, placement, face,
            measure(camera, input, face, corner[k].x, corner[k].y, size, size), first + k, depth + 2);
    }
    return;
  }
  const bool alongU = tile.cellsU >= tile.cellsV;
  nodes_[node] = {first, alongU ? Node::Split::U : Node::Split::V};
  nodes_.resize(nodes_.size() + 2);
  const float du = alongU ? tile.du / 2 : tile.du, dv = alongU ? tile.dv : tile.dv / 2;
  for (uint32_t k = 0; k < 2; ++k) {
    const float u0 = tile.u0 + (alongU && k ? du : 0), v0 = tile.v0 + (!alongU && k ? dv : 0);
    split(camera, input, placement, face, measure(camera, input, face, u0, v0, du, dv), first + k, depth + 1);
  }
}

PatchTable::PatchTable(const RasterCamera& camera, std::span<const DiceInput> inputs, size_t limit)
    : limit_(limit) {
  placements_.reserve(inputs.size());
  std::vector<Tile> faces;
  for (uint32_t placement = 0; placement < inputs.size(); ++placement) {
    const DiceInput& input = inputs[placement];
    const uint32_t count = input.surface->faceCount();
    faces.resize(count);
    bool tiled = false;
    for (uint32_t face = 0; face < count; ++face) {
      faces[face] = measure(camera, input, face, 0, 0, 1, 1);
      tiled |= faces[face].cellsU > kMaxCells * 1.41421356f || faces[face].cellsV > kMaxCells * 1.41421356f;
    }
    if (!tiled) {
      placements_.push_back({static_cast<uint32_t>(patches_.size()), false});
      for (uint32_t face = 0; face < count; ++face) addPatch(input, placement, face, faces[face]);
      continue;
    }
    placements_.push_back({static_cast<uint32_t>(roots_.size()), true});
    for (uint32_t face = 0; face < count; ++face) {
      const auto root = static_cast<uint32_t>(nodes_.size());
      roots_.push_back(root);
      nodes_.emplace_back();
      split(camera, input, placement, face, faces[face], root, 0);
    }
  }
  patches_.shrink_to_fit();
  nodes_.shrink_to_fit();
}

uint32_t traceCells(const RasterCamera& camera, const DiceInput& input) {
  constexpr float kTolerance = 0.05f;                               // pixels between a facet and the surface
  constexpr float kTurn = 12.0f * std::numbers::pi_v<float> / 180;  // normals turn no more within a facet
  const uint32_t faces = input.surface->faceCount();
  // Sample a few faces densely, many sparsely; the deviation from the chord falls with the square of the
  // cells.
  const uint32_t samples = faces < 64 ? 16 : 2;
  float wanted = 1;
  std::vector<V2f> uv;
  std::vector<SurfacePoint> line(2 * samples + 1);
  for (uint32_t face = 0; face < faces; ++face) {
    for (int direction = 0; direction < 2; ++direction)
      for (uint32_t row = 0; row <= samples; row += samples / 2) {
        uv.clear();
        for (uint32_t k = 0; k <= 2 * samples; ++k) {
          const float a = static_cast<float>(k) / static_cast<float>(2 * samples),
                      b = static_cast<float>(row) / static_cast<float>(samples);
          uv.push_back(direction == 0 ? V2f(a, b) : V2f(b, a));
        }
        input.surface->evaluateMany(face, uv, line);
        for (SurfacePoint& p : line) p.P = transformPoint(p.P, input.objectToWorld);
        for (uint32_t k = 0; k + 2 <= 2 * samples; k += 2) {
          const V3f chord = line[k + 2].P - line[k].P;
          const float deviation = (line[k + 1].P - (line[k].P + line[k + 2].P) * 0.5f).length();
          const float radius = chord.length() * 0.5f + deviation;
          const V3f middle = line[k + 1].P;
          const float distance = std::max(camera.nearestDistance(middle, radius), 0.25f * radius);
          const float seen = camera.mayBeVisible(middle, radius, kMargin) ? 1 : kOffScreenFactor;
          const float pixels = deviation * seen * camera.pixelsPerUnit(std::max(distance, 1e-30f));
          if (std::isfinite(pixels))
            wanted = std::max(wanted, static_cast<float>(samples) * std::sqrt(pixels / kTolerance));
          if (radius > 0) {
            const float cosine = std::clamp(line[k].N.dot(line[k + 2].N), -1.0f, 1.0f);
            wanted = std::max(wanted, static_cast<float>(samples) * std::acos(cosine) / kTurn);
          }
        }
      }
  }
  uint32_t cells = 1;
  const uint32_t most = faces < 16 ? 512 : faces < 4096 ? 64 : 16;
  while (cells < most && static_cast<float>(cells) < wanted) cells *= 2;
  return cells;
}

}  // namespace patina
