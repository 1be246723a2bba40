// SPDX-License-Identifier: Apache-2.0
// Vertex lattices of patches, and the cutting of faces into them.
#include "renderer/geometry/patches.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

namespace patina {
namespace {

using Imath::V2d;

/// A flat rectangle or triangle in the plane z = 0 with given edges.
class Plane final : public Surface {
 public:
  Plane(FaceShape shape, float width, float height) : shape_(shape), width_(width), height_(height) {}
  uint32_t faceCount() const override { return 1; }
  FaceShape faceShape(uint32_t) const override { return shape_; }
  bool isFlat() const override { return true; }
  void corners(uint32_t, V3f out[4]) const override {
    out[0] = {-width_ / 2, -height_ / 2, 0}, out[1] = {width_ / 2, -height_ / 2, 0};
    out[2] = {-width_ / 2, height_ / 2, 0}, out[3] = {width_ / 2, height_ / 2, 0};
  }
  SurfacePoint evaluate(uint32_t, float u, float v) const override {
    return {{(u - 0.5f) * width_, (v - 0.5f) * height_, 0}, {0, 0, 1}, {width_, 0, 0}, {0, height_, 0}};
  }
  void interpolate(const PrimVar&, uint32_t, float, float, float*) const override {}
  uint32_t uniformIndex(uint32_t) const override { return 0; }
  V2f surfaceParameters(uint32_t, float u, float v) const override { return {u, v}; }
  V2f parameterScale(uint32_t) const override { return {1, 1}; }
  Box3f bound() const override { return Box3f({-width_ / 2, -height_ / 2, 0}, {width_ / 2, height_ / 2, 0}); }

 private:
  FaceShape shape_;
  float width_, height_;
};

Patch makePatch(FaceShape shape, int cellsU, int cellsV) {
  return {0, 0, 0, 0, 1, 1, 1, static_cast<uint8_t>(cellsU), static_cast<uint8_t>(cellsV), shape};
}

/// A camera at distance 10 that looks down +z on the plane z = 0; 100 pixels per unit there.
RasterCamera lookingCamera() {
  Camera camera;
  camera.worldToCamera.setTranslation(V3d(0, 0, 10));
  camera.fov = 2 * std::atan(0.5f) * 180 / kPi;
  Options options;
  options.xResolution = options.yResolution = 1000;
  return {camera, options};
}

TEST(Patch, WeightsReproducePositionsAtEveryLevel) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (const FaceShape shape : {FaceShape::Quad, FaceShape::Triangle})
    for (const auto& [nu, nv] : {std::pair{1, 1}, {2, 2}, {4, 4}, {8, 8}, {16, 16}, {16, 2}, {1, 8}}) {
      if (shape == FaceShape::Triangle && nu != nv) continue;
      const Patch patch = makePatch(shape, nu, nv);
      for (const Level level : {Level::Coarse, Level::Medium, Level::Fine})
        for (int k = 0; k < 500; ++k) {
          V2f p(uniform(random), uniform(random));
          if (shape == FaceShape::Triangle && p.x + p.y > 1) p = V2f(1 - p.x, 1 - p.y);
          const VertexWeights around = patch.locate(level, p.x, p.y);
          V2f sum(0, 0);
          float total = 0;
          for (int i = 0; i < around.count; ++i) {
            ASSERT_LT(around.index[i], patch.vertexCount(level));
            ASSERT_GE(around.weight[i], 0);
            sum += patch.vertexPosition(level, around.index[i]) * around.weight[i];
            total += around.weight[i];
          }
          ASSERT_NEAR(total, 1, 1e-6f);
          ASSERT_NEAR(sum.x, p.x, 1e-6f);
          ASSERT_NEAR(sum.y, p.y, 1e-6f);
        }
    }
}

TEST(Patch, CentroidsAreThoseOfWeights) {
  constexpr int kGrid = 192;
  for (const FaceShape shape : {FaceShape::Quad, FaceShape::Triangle})
    for (const auto& [nu, nv] : {std::pair{1, 1}, {2, 2}, {4, 4}, {16, 16}, {16, 2}, {1, 8}}) {
      if (shape == FaceShape::Triangle && nu != nv) continue;
      const Patch patch = makePatch(shape, nu, nv);
      for (const Level level : {Level::Coarse, Level::Medium, Level::Fine}) {
        std::vector<double> weight(patch.vertexCount(level), 0);
        std::vector<V2d> moment(weight.size(), V2d(0, 0));
        const auto add = [&](double x, double y) {
          const VertexWeights around =
              patch.locate(level, static_cast<float>(x / kGrid), static_cast<float>(y / kGrid));
          for (int i = 0; i < around.count; ++i) {
            const auto w = static_cast<double>(around.weight[i]);
            weight[around.index[i]] += w, moment[around.index[i]] += V2d(x, y) * (w / kGrid);
          }
        };
        for (int j = 0; j < kGrid; ++j)
          for (int i = 0; i < kGrid; ++i)
            if (shape == FaceShape::Quad) {
              add(i + 0.5, j + 0.5);
            } else {
              if (i + j < kGrid) add(i + 1 / 3.0, j + 1 / 3.0);
              if (i + j < kGrid - 1) add(i + 2 / 3.0, j + 2 / 3.0);
            }
        for (uint32_t k = 0; k < weight.size(); ++k) {
          const V2d mean = moment[k] / weight[k];
          const V2f centroid = patch.vertexCentroid(level, k);
          // The sum's own error: a rest of the grid's squares against those of a cell.
          ASSERT_NEAR(static_cast<double>(centroid.x), mean.x, 1e-3) << "vertex " << k << " of " << nu;
          ASSERT_NEAR(static_cast<double>(centroid.y), mean.y, 1e-3) << "vertex " << k << " of " << nv;
        }
      }
    }
}

TEST(Patch, ABlockHoldsTheVerticesOfItsCells) {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (const FaceShape shape : {FaceShape::Quad, FaceShape::Triangle})
    for (const auto& [nu, nv] : {std::pair{1, 1}, {2, 16}, {8, 8}, {16, 16}, {16, 2}}) {
      if (shape == FaceShape::Triangle && nu != nv) continue;
      const Patch patch = makePatch(shape, nu, nv);
      std::map<std::pair<int, uint32_t>, uint32_t> vertexAt;  // by block and place
      const auto agrees = [&](int block, uint32_t place, uint32_t vertex) {
        EXPECT_LT(block, 16);
        EXPECT_LT(place, static_cast<uint32_t>(kMaxBlockVertices));
        return vertexAt.emplace(std::pair{block, place}, vertex).first->second == vertex;
      };
      for (uint32_t vertex = 0; vertex < patch.vertexCount(Level::Fine); ++vertex) {
        const BlockVertex at = patch.blockOf(vertex);
        ASSERT_TRUE(agrees(at.block, at.index, vertex));
      }
      for (int k = 0; k < 2000; ++k) {
        V2f p(uniform(random), uniform(random));
        if (shape == FaceShape::Triangle && p.x + p.y > 1) p = V2f(1 - p.x, 1 - p.y);
        const VertexWeights around = patch.locate(Level::Fine, p.x, p.y);
        uint32_t places[4];
        const int block = patch.blockOf(around, places);
        for (int i = 0; i < around.count; ++i) ASSERT_TRUE(agrees(block, places[i], around.index[i]));
      }
    }
}

TEST(Patch, CoarserVerticesAreASubsetOfFinerOnes) {
  for (const FaceShape shape : {FaceShape::Quad, FaceShape::Triangle})
    for (const int n : {1, 2, 4, 8, 16}) {
      const Patch patch = makePatch(shape, n, n);
      const auto positions = [&](Level level) {
        std::set<std::pair<float, float>> set;
        for (uint32_t k = 0; k < patch.vertexCount(level); ++k) {
          const V2f p = patch.vertexPosition(level, k);
          set.emplace(p.x, p.y);
        }
        EXPECT_EQ(set.size(), patch.vertexCount(level));
        return set;
      };
      const auto fine = positions(Level::Fine), medium = positions(Level::Medium),
                 coarse = positions(Level::Coarse);
      EXPECT_TRUE(std::includes(fine.begin(), fine.end(), medium.begin(), medium.end()));
      EXPECT_TRUE(std::includes(medium.begin(), medium.end(), coarse.begin(), coarse.end()));
      EXPECT_EQ(patch.vertexCount(Level::Coarse), shape == FaceShape::Quad ? 4u : 3u);
    }
}

TEST(Patch, LevelsWithTheSameVerticesAreOne) {
  EXPECT_EQ(makePatch(FaceShape::Quad, 1, 1).canonical(Level::Fine), Level::Coarse);
  EXPECT_EQ(makePatch(FaceShape::Quad, 4, 2).canonical(Level::Fine), Level::Medium);
  EXPECT_EQ(makePatch(FaceShape::Quad, 16, 1).canonical(Level::Fine), Level::Fine);
  EXPECT_EQ(makePatch(FaceShape::Quad, 0, 0).vertexCount(Level::Fine), 1u);
}

TEST(PatchTable, MicropolygonsCoverTheShadingRate) {
  // 8 x 4 units at 100 pixels per unit: 800 x 400 pixels, a power of two away at most.
  const Plane plane(FaceShape::Quad, 8, 4);
  for (const float rate : {1.0f, 4.0f, 16.0f}) {
    const DiceInput input{&plane, M44f(), rate};
    const PatchTable table(lookingCamera(), 1, [&](uint32_t) { return input; });
    table.find(0, 0, 0, 0);
    double cells = 0;
    for (size_t k = 0; k < table.size(); ++k)
      cells += double{1} * table[static_cast<uint32_t>(k)].cellsU * table[static_cast<uint32_t>(k)].cellsV;
    EXPECT_GT(cells, 320000 / rate / 2.01);
    EXPECT_LT(cells, 320000 / rate * 2.01);
    EXPECT_FALSE(table.limited());
  }
}

TEST(PatchTable, EveryPointHasThePatchThatHoldsIt) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (const FaceShape shape : {FaceShape::Quad, FaceShape::Triangle}) {
    const Plane plane(shape, 900, 300);  // most of it out of view: patches of all sizes
    const DiceInput input{&plane, M44f(), 1};
    const PatchTable table(lookingCamera(), 1, [&](uint32_t) { return input; });
    table.find(0, 0, 0, 0);
    EXPECT_GT(table.size(), 1000u);
    double area = 0;
    for (size_t k = 0; k < table.size(); ++k)
      area += std::abs(double{table[static_cast<uint32_t>(k)].du} * table[static_cast<uint32_t>(k)].dv);
    EXPECT_NEAR(area, 1, 1e-9);
    for (int k = 0; k < 20000; ++k) {
      V2f p(uniform(random), uniform(random));
      if (shape == FaceShape::Triangle && p.x + p.y > 1) p = V2f(1 - p.x, 1 - p.y);
      const V2f local = table[table.find(0, 0, p.x, p.y)].toLocal(p.x, p.y);
      ASSERT_GE(std::min(local.x, local.y), -1e-5f);
      ASSERT_LE(shape == FaceShape::Quad ? std::max(local.x, local.y) : local.x + local.y, 1 + 1e-4f);
    }
  }
}

TEST(PatchTable, PatchesHoldTheirNearCornersAndTheFaceItsFarOnes) {
  const Plane plane(FaceShape::Quad, 900, 300);
  const DiceInput input{&plane, M44f(), 1};
  const PatchTable table(lookingCamera(), 1, [&](uint32_t) { return input; });
  table.find(0, 0, 0, 0);
  for (uint32_t k = 0; k < table.size(); ++k) {
    const Patch& patch = table[k];
    ASSERT_EQ(table.find(0, 0, patch.u0, patch.v0), k);
    ASSERT_EQ(table.find(0, 0, std::nextafter(patch.u0 + patch.du, 0.0f),
                         std::nextafter(patch.v0 + patch.dv, 0.0f)),
              k);
  }
  // What rounding or a broken file may bring is taken to the rim.
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(table.find(0, 0, 1, 1), table.find(0, 0, std::nextafter(1.0f, 0.0f), std::nextafter(1.0f, 0.0f)));
  EXPECT_EQ(table.find(0, 0, -0.1f, 7), table.find(0, 0, 0, 1));
  EXPECT_EQ(table.find(0, 0, nan, nan), table.find(0, 0, 0, 0));
}

/// Micropolygons along u and v of a plane of 8 x 4 units.
V2d cellsOfPlane(DiceInput input) {
  const Plane plane(FaceShape::Quad, 8, 4);
  input.surface = &plane;
  const PatchTable table(lookingCamera(), 1, [&](uint32_t) { return input; });
  V2d cells(0, 0);
  table.find(0, 0, 0, 0);
  for (uint32_t k = 0; k < table.size(); ++k) {
    // Along the edges v = 0 and u = 0.
    if (table[k].v0 == 0) cells.x += table[k].cellsU;
    if (table[k].u0 == 0) cells.y += table[k].cellsV;
  }
  return cells;
}

TEST(PatchTable, LengthsInSpaceDoNotDependOnTheView) {
  // Edges of a quarter: 32 x 16 of them wherever it stands, twice as many where it is twice as large.
  for (const float distance : {0.0f, -5.0f, 500.0f, -3000.0f}) {
    M44f moved, grown;
    moved.setTranslation(V3f(0, 0, distance));
    grown.setScale(V3f(2));
    EXPECT_EQ(cellsOfPlane({nullptr, moved, 1, 0.25f}), V2d(32, 16)) << distance;
    EXPECT_EQ(cellsOfPlane({nullptr, grown * moved, 1, 0.25f}), V2d(64, 32)) << distance;
    EXPECT_EQ(cellsOfPlane({nullptr, grown * moved, 1, 0.25f, true}), V2d(32, 16))
        << "by lengths in object space";
  }
}

TEST(PatchTable, ForeshorteningCountsUnlessItIsSwitchedOff) {
  // Turned by 75 degrees about x: v is seen at 0.26 of its length, u at all of it, 800 pixels and more.
  M44f turned;
  turned.setAxisAngle(V3f(1, 0, 0), 75 * kPi / 180);
  const V2d seen = cellsOfPlane({nullptr, turned, 1}),
            whole = cellsOfPlane({nullptr, turned, 1, 0, false, false});
  EXPECT_LT(seen.y, 256);
  EXPECT_GE(whole.y, 256);
  EXPECT_LE(whole.y, 1024);
  EXPECT_GE(whole.x, 512);
}

TEST(PatchTable, APlaneThroughTheEyeStaysBounded) {
  Camera camera;  // the eye lies in the plane z = 0
  Options options;
  const Plane plane(FaceShape::Quad, 1e6f, 1e6f);
  const DiceInput input{&plane, M44f(), 1};
  const PatchTable table(
      RasterCamera(camera, options), 1, [&](uint32_t) { return input; }, 100000);
  table.find(0, 0, 0.5f, 0.5f);
  EXPECT_LE(table.size(), 100100u);
}

// A plane of ten kilometres before a camera that sees a centimetre of it: parameters of a face are floats,
// and no micropolygon is smaller than sixteen of their steps.
TEST(PatchTable, MicropolygonsAreWhatParametersTellApart) {
  for (const FaceShape shape : {FaceShape::Quad, FaceShape::Triangle}) {
    const Plane plane(shape, 1e4f, 1e4f);
    Camera camera;
    camera.worldToCamera.setTranslation(V3d(0, 0, 0.01));
    camera.fov = 60;
    Options options;
    options.xResolution = options.yResolution = 100;
    DiceInput input{&plane, M44f(), 1};
    const PatchTable patches(RasterCamera(camera, options), 1, [&](uint32_t) { return input; });
    const auto [first, count] = patches.patchesOf(0);
    float least = 1, spacing = 1e4f;
    for (uint32_t k = first; k < first + count; ++k) {
      const Patch& patch = patches[k];
      least = std::min({least, std::abs(patch.du) / static_cast<float>(std::max<int>(patch.cellsU, 1)),
                        std::abs(patch.dv) / static_cast<float>(std::max<int>(patch.cellsV, 1))});
      spacing = std::min(spacing, patch.spacing);
    }
    EXPECT_GE(least, 0x1p-20f);
    EXPECT_LT(least, 0x1p-18f) << "where the camera is, they are as small as may be";
    EXPECT_GT(spacing, 1e4f * 0x1p-21f) << "and say how far apart they are";
  }
}

TEST(PatchTable, TinyFacesAreOneValue) {
  const Plane plane(FaceShape::Quad, 0.004f, 0.004f);  // 0.4 pixels
  const DiceInput input{&plane, M44f(), 1};
  const PatchTable table(lookingCamera(), 1, [&](uint32_t) { return input; });
  table.find(0, 0, 0, 0);
  ASSERT_EQ(table.size(), 1u);
  EXPECT_EQ(table[0].vertexCount(Level::Fine), 1u);
}

}  // namespace
}  // namespace patina
