// SPDX-License-Identifier: Apache-2.0
// Groups of faces that are smaller than a micropolygon, and the order of faces that they are made along.
#include "renderer/geometry/face_groups.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <random>

#include "renderer/geometry/face_order.h"
#include "renderer/geometry/patches.h"
#include "renderer/geometry/polygon_surface.h"

namespace patina {
namespace {

/// A mesh of triangles over [-1, 1]^2, z = height(x, y); faces in random order where asked.
struct Mesh {
  Primitive primitive;
  std::vector<std::string> messages;
  ErrorHandler errors{[this](Severity, std::string_view text) { messages.emplace_back(text); }};
  std::unique_ptr<Surface> surface;

  Mesh(int cells, const std::function<float(float, float)>& height, bool shuffled = true) {
    PolygonMesh mesh;
    mesh.sides = 3;
    PrimVar points;
    points.name = "P", points.storage = StorageClass::Vertex, points.type = ValueType::Point;
    points.components = 3;
    for (int j = 0; j <= cells; ++j)
      for (int i = 0; i <= cells; ++i) {
        const float x = 2 * static_cast<float>(i) / static_cast<float>(cells) - 1,
                    y = 2 * static_cast<float>(j) / static_cast<float>(cells) - 1;
        points.floats.insert(points.floats.end(), {x, y, height(x, y)});
      }
    std::vector<std::array<int, 3>> faces;
    for (int j = 0; j < cells; ++j)
      for (int i = 0; i < cells; ++i) {
        const int a = j * (cells + 1) + i;
        faces.push_back({a, a + 1, a + cells + 1});
        faces.push_back({a + cells + 2, a + cells + 1, a + 1});
      }
    if (shuffled) std::shuffle(faces.begin(), faces.end(), std::mt19937(7));
    for (const auto& f : faces) mesh.vertices.insert(mesh.vertices.end(), f.begin(), f.end());
    primitive.shape = std::move(mesh);
    primitive.variables = {points};
    surface = makeSurface(primitive, errors);
  }
  V3f normal(uint32_t face) const { return surface->evaluate(face, 0.3f, 0.3f).N; }
};

float plane(float, float) { return 0; }
float rough(float x, float y) {
  return 0.1f * std::sin(9 * x) * std::sin(11 * y) + 0.01f * std::sin(70 * x * y);
}

/// A camera that looks down +z on [-1, 1]^2 at z = 0, orthographic, with so many pixels along it.
RasterCamera above(int pixels) {
  Camera camera;
  camera.perspective = false;
  camera.worldToCamera.setTranslation(V3d(0, 0, 10));
  Options options;
  options.xResolution = options.yResolution = pixels;
  return {camera, options};
}

/// The patches of one mesh, seen by a camera.
struct Diced {
  DiceInput input;
  PatchTable table;
  Diced(const Mesh& mesh, int pixels, const M44f& objectToWorld = M44f())
      : input{mesh.surface.get(), objectToWorld, 1, {}},
        table(above(pixels), 1, [this](uint32_t) { return input; }) {}
  /// Fine groups by face.
  std::vector<uint32_t> groups() const {
    std::vector<uint32_t> result;
    for (uint32_t face = 0; face < input.surface->faceCount(); ++face)
      result.push_back(table.find(0, face, 0.2f, 0.2f));
    return result;
  }
};

TEST(FaceOrder, HoldsEveryFaceOnceAndNeighboursTogether) {
  const Mesh mesh(128, rough);
  const std::vector<uint32_t> order = mortonOrder(*mesh.surface);
  std::vector<uint32_t> sorted = order;
  std::sort(sorted.begin(), sorted.end());
  ASSERT_EQ(sorted.size(), 32768u);
  for (uint32_t k = 0; k < sorted.size(); ++k) ASSERT_EQ(sorted[k], k);
  // 64 consecutive faces of 32768 fill an eighth by an eighth of the square, or lie across a seam of the
  // curve.
  const std::vector<Box3f> bounds = boundsOfParts(*mesh.surface, order, 64);
  ASSERT_EQ(bounds.size(), 512u);
  double area = 0;
  Box3f whole;
  for (const Box3f& box : bounds) {
    area += double{box.size().x} * box.size().y;
    whole.extendBy(box);
  }
  EXPECT_LT(area, 3 * 4.0);  // in the shuffled order they are as the numbers of the faces: 4 each
  EXPECT_EQ(whole.min, mesh.surface->bound().min);
  EXPECT_EQ(whole.max, mesh.surface->bound().max);
}

TEST(FaceGroups, CoverEachSmallFaceOnceWithinTheirLimits) {
  const Mesh mesh(256, rough);   // 131072 faces: two blocks
  const Diced diced(mesh, 128);  // a face is half a pixel wide
  const std::vector<uint32_t> groupOf = diced.groups();
  std::vector<Box3f> box(diced.table.size());
  std::vector<uint32_t> count(diced.table.size());
  const float cosine = std::cos(2 * kGroupNormals * kPi / 180);  // all lie around the first
  for (uint32_t face = 0; face < groupOf.size(); ++face) {
    const Patch& patch = diced.table[groupOf[face]];
    ASSERT_EQ(patch.group, 1);
    V3f p[4];
    mesh.surface->corners(face, p);
    for (int k = 0; k < 3; ++k) box[groupOf[face]].extendBy(p[k]);
    ++count[groupOf[face]];
    ASSERT_GE(mesh.normal(face).dot(mesh.normal(patch.face)), cosine - 1e-4f);
  }
  const float edge = 2.0f / 128;
  size_t fine = 0, faces = 0;
  for (uint32_t k = 0; k < diced.table.size(); ++k) {
    const Patch& patch = diced.table[k];
    if (patch.group != 1) continue;
    ++fine, faces += count[k];
    ASSERT_GT(count[k], 0u);
    ASSERT_EQ(groupOf[patch.face], k);  // the face that stands for it is one of it
    ASSERT_FLOAT_EQ(patch.spacing, box[k].size().length());
    ASSERT_LE(patch.spacing, kGroupExtent * edge * 1.001f);
  }
  EXPECT_EQ(faces, groupOf.size());
  // About one to a micropolygon: 128 x 128 pixels, and the mesh is some 1.2 times as large as they.
  EXPECT_GT(fine, 128u * 128 / 2);
  EXPECT_LT(fine, 128u * 128 * 2.5);
}

TEST(FaceGroups, LevelsAreGroupsOfGroups) {
  const Mesh mesh(256, plane);
  const Diced diced(mesh, 128);
  const std::vector<uint32_t> groupOf = diced.groups();
  std::array<std::vector<uint32_t>, 4> levels;
  for (uint32_t k = 0; k < diced.table.size(); ++k) levels[diced.table[k].group].push_back(k);
  EXPECT_TRUE(levels[0].empty());
  // Four times the extent is sixteen times the area; greedy walks leave some of it out.
  for (size_t level = 2; level < 4; ++level) {
    EXPECT_LT(levels[level].size(), levels[level - 1].size() / 6);
    EXPECT_GT(levels[level].size(), levels[level - 1].size() / 32);
  }
  const float edge = 2.0f / 128;
  for (uint32_t face = 0; face < groupOf.size(); face += 97) {
    V3f p[4];
    mesh.surface->corners(face, p);
    float extent = 1;
    uint32_t k = groupOf[face];
    for (uint8_t level = 1; level < 4; ++level, extent *= 4) {
      const Patch& patch = diced.table[k];
      ASSERT_EQ(patch.group, level);
      ASSERT_LE(patch.spacing, extent * kGroupExtent * edge * 1.001f);
      V3f q[4];
      mesh.surface->corners(patch.face, q);
      ASSERT_LE((p[0] - q[0]).length(), patch.spacing * 1.001f);
      k = diced.table.coarser(k);
      ASSERT_EQ(k == kNone, level == 3);
    }
  }
}

TEST(FaceGroups, SheetsThatFaceApartStayApart) {
  // Two sheets a tenth of a pixel apart: neighbours in space, normals along +z and -z.
  Mesh mesh(64, plane, false);
  auto& polygons = std::get<PolygonMesh>(mesh.primitive.shape);
  std::vector<float>& points = mesh.primitive.variables[0].floats;
  const size_t n = polygons.vertices.size(), vertices = points.size() / 3;
  for (size_t k = 0; k < n; k += 3)
    for (const size_t corner : {k, k + 2, k + 1})
      polygons.vertices.push_back(polygons.vertices[corner] + static_cast<int>(vertices));
  points.insert(points.end(), points.begin(), points.begin() + static_cast<ptrdiff_t>(3 * vertices));
  for (size_t k = vertices; k < 2 * vertices; ++k) points[3 * k + 2] = 0.001f;
  mesh.surface = makeSurface(mesh.primitive, mesh.errors);
  const Diced diced(mesh, 32);
  const std::vector<uint32_t> groupOf = diced.groups();
  std::vector<int> side(diced.table.size());
  size_t fine = 0;
  for (uint32_t face = 0; face < groupOf.size(); ++face) {
    const int sign = mesh.normal(face).z > 0 ? 1 : -1;
    fine += side[groupOf[face]] == 0;
    ASSERT_NE(side[groupOf[face]], -sign);
    side[groupOf[face]] = sign;
  }
  EXPECT_LT(fine, 2u * 32 * 32 * 3);  // they do interleave: without care there would be one for each face
}

TEST(FaceGroups, FacesStandForTheirGroupsInProportionToArea) {
  // Columns of cells in turn 0.2 and 1.8 wide: a tenth of the area is narrow.
  Mesh mesh(256, plane);
  std::vector<float>& points = mesh.primitive.variables[0].floats;
  for (size_t k = 0; k < points.size(); k += 3) {
    const int i = static_cast<int>(std::lround((points[k] + 1) * 128));
    if (i % 2 == 1) points[k] -= 0.8f / 128;
  }
  mesh.surface = makeSurface(mesh.primitive, mesh.errors);
  const Diced diced(mesh, 50);
  ASSERT_EQ(diced.groups().size(), 131072u);
  double narrow = 0, all = 0;
  for (uint32_t k = 0; k < diced.table.size(); ++k) {
    const Patch& patch = diced.table[k];
    if (patch.group != 2) continue;
    V3f p[4];
    mesh.surface->corners(patch.face, p);
    const float width = std::max({p[0].x, p[1].x, p[2].x}) - std::min({p[0].x, p[1].x, p[2].x});
    ++all, narrow += width < 0.5f / 128;
  }
  ASSERT_GT(all, 100);
  EXPECT_NEAR(narrow / all, 0.1, 4 * std::sqrt(0.09 / all));  // four standard deviations
}

TEST(FaceGroups, FollowLengthsThatAreGiven) {
  // Attribute "dice": micropolygons of a length, whatever the camera sees of them.
  const Mesh mesh(128, plane);
  M44f twice;
  twice.setScale(2);
  const auto fineGroups = [&](float length, bool inObjectSpace, int pixels) {
    Diced diced(mesh, pixels, twice);
    diced.input.length = length, diced.input.inObjectSpace = inObjectSpace;
    diced.groups();
    size_t fine = 0;
    for (uint32_t k = 0; k < diced.table.size(); ++k) fine += diced.table[k].group == 1;
    return fine;
  };
  const size_t world = fineGroups(0.1f, false, 20);
  EXPECT_EQ(world, fineGroups(0.05f, true, 20));
  EXPECT_EQ(world, fineGroups(0.1f, false, 2000));
  EXPECT_GT(world, 40u * 40 / 2);  // micropolygons on the square of 4 by 4
  EXPECT_LT(world, 40u * 40 * 2.5);
}

TEST(FaceGroups, LargeFacesKeepPatchesOfTheirOwn) {
  // One half of the mesh is made ten thousand times as large as the other.
  Mesh mesh(64, rough);
  std::vector<float>& points = mesh.primitive.variables[0].floats;
  for (size_t k = 0; k < points.size(); k += 3)
    if (points[k] < 0) points[k] *= 10, points[k + 1] *= 10;
  mesh.surface = makeSurface(mesh.primitive, mesh.errors);
  const Diced diced(mesh, 20);
  size_t small = 0, large = 0;
  for (uint32_t face = 0; face < mesh.surface->faceCount(); ++face) {
    V3f p[4];
    mesh.surface->corners(face, p);
    const Patch& patch = diced.table[diced.table.find(0, face, 0.4f, 0.3f)];
    if (patch.group > 0) {
      ++small;
      continue;
    }
    ++large;
    ASSERT_EQ(patch.face, face);
    const V2f local = patch.toLocal(0.4f, 0.3f);
    ASSERT_GE(std::min(local.x, local.y), -1e-5f);
    ASSERT_LE(local.x + local.y, 1 + 1e-4f);
  }
  EXPECT_GT(small, 3000u);
  EXPECT_GT(large, 3000u);
}

TEST(FaceGroups, ThreadsDoNotChangeThem) {
  const Mesh mesh(400, rough);  // 320000 faces: five blocks
  const auto describe = [&](size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const Diced diced(mesh, 100);
    std::vector<float> all;
    for (const uint32_t group : diced.groups()) all.push_back(static_cast<float>(group));
    for (uint32_t k = 0; k < diced.table.size(); ++k) {
      all.push_back(static_cast<float>(diced.table[k].face));
      all.push_back(diced.table[k].spacing);
      all.push_back(static_cast<float>(diced.table.coarser(k)));
    }
    return all;
  };
  EXPECT_EQ(describe(1), describe(3));
}

}  // namespace
}  // namespace patina
