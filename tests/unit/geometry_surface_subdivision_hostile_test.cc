// SPDX-License-Identifier: Apache-2.0
// Subdivision meshes that make no sense.
#include <gmock/gmock.h>

#include "tests/unit/geometry_subdivision_fixtures.h"

namespace patina {
namespace {

using namespace test;

TEST(SubdivisionSurface, HostileInput) {
  const auto report = [](const Primitive& p, int faces) {
    Messages messages;
    const auto s = makeSurface(p, messages.handler);
    EXPECT_EQ(s ? static_cast<int>(s->faceCount()) : 0, faces) << messages.all();
    if (s && !s->isFlat()) {
      for (const V3f& q : uniformFacets(*s, 2).vertices) EXPECT_TRUE(isFinite(q));
      for (uint32_t face = 0; face < s->faceCount(); ++face)
        for (float u : {0.0f, 1.0f}) {
          const SurfacePoint q = s->evaluate(face, u, 1);
          EXPECT_NEAR(q.N.length(), 1, 1e-5f);
        }
    }
    return messages.all();
  };
  using ::testing::HasSubstr;
  const auto with = [](std::vector<int> sizes, std::vector<int> vertices,
                       std::vector<SubdivisionMesh::Tag> tags = {}, const char* scheme = "catmull-clark") {
    return primitive(SubdivisionMesh{scheme, std::move(sizes), std::move(vertices), std::move(tags)},
                     kCubePoints);
  };
  std::vector<int> faces = kCubeFaces;
  EXPECT_THAT(report(primitive(cube()), 0),
              HasSubstr("test.rib:7:3: error: missingdata: SubdivisionMesh: needs \"P\""));
  EXPECT_THAT(report(with({4, 4}, faces), 0), HasSubstr("the faces have 8 vertices, but 24 are given"));
  EXPECT_THAT(report(with({-4}, {}), 0), HasSubstr("negative"));
  EXPECT_THAT(report(with({4}, {0, 1, 3, 2}), 0), HasSubstr("\"interpolateboundary\""));
  EXPECT_THAT(report(with({}, {}), 0), HasSubstr("no face is left"));
  faces[3] = 99;
  EXPECT_THAT(report(with({4, 4, 4, 4, 4, 4}, faces, {{"interpolateboundary", {1}, {}, {}}}), 5),
              HasSubstr("1 of 6 faces left out: number 0 uses a vertex that \"P\" does not have"));
  faces[3] = faces[2];
  EXPECT_THAT(report(with({4, 4, 4, 4, 4, 4}, faces, {{"interpolateboundary", {1}, {}, {}}}), 5),
              HasSubstr("uses a vertex twice"));
  EXPECT_THAT(report(with({4, 4, 4, 4, 4, 4}, kCubeFaces, {}, "doo-sabin"), 6),
              HasSubstr("scheme \"doo-sabin\" is not known"));
  EXPECT_THAT(report(with({4, 4, 4, 4, 4, 4}, kCubeFaces, {}, "loop"), 6), HasSubstr("needs triangles"));
  const auto tagged = [&](SubdivisionMesh::Tag tag) {
    return report(with({4, 4, 4, 4, 4, 4}, kCubeFaces, {std::move(tag)}), 6);
  };
  EXPECT_THAT(tagged({"crease", {1}, {1}, {}}),
              HasSubstr("tag \"crease\" needs at least two vertices; ignored"));
  EXPECT_THAT(tagged({"crease", {0, 1, 3}, {1, 2, 3}, {}}), HasSubstr("one sharpness"));
  EXPECT_THAT(tagged({"crease", {0, 1}, {NAN}, {}}), HasSubstr("one sharpness"));
  EXPECT_THAT(tagged({"crease", {0, 800}, {1}, {}}), HasSubstr("does not exist"));
  EXPECT_THAT(tagged({"crease", {0, 7}, {1}, {}}), HasSubstr("SubdivisionMesh: "));  // no edge
  EXPECT_THAT(tagged({"corner", {-1}, {1}, {}}), HasSubstr("does not exist"));
  EXPECT_THAT(tagged({"hole", {6}, {}, {}}), HasSubstr("does not exist"));
  EXPECT_THAT(tagged({"interpolateboundary", {9}, {}, {}}), HasSubstr("takes 0, 1 or 2"));
  EXPECT_THAT(tagged({"vertexedit", {0}, {1}, {"x"}}), HasSubstr("tag \"vertexedit\" is not known; ignored"));
  EXPECT_EQ(tagged({"corner", {0}, {-5}, {}}), "");
  // Topology that is no manifold: the same face twice, three faces at an edge, a face turned round, two cubes
  // at one vertex.
  std::vector<int> twice = kCubeFaces;
  twice.insert(twice.end(), kCubeFaces.begin(), kCubeFaces.end());
  report(with(std::vector<int>(12, 4), twice), 12);
  report(with({4, 4, 4}, {0, 1, 3, 2, 0, 1, 5, 4, 0, 1, 7, 6}, {{"interpolateboundary", {1}, {}, {}}}), 3);
  std::vector<int> turned = kCubeFaces;
  std::swap(turned[1], turned[3]);
  report(with({4, 4, 4, 4, 4, 4}, turned), 6);
  report(with({3, 3}, {0, 1, 2, 2, 3, 4}, {{"interpolateboundary", {1}, {}, {}}}), 6);
  // Two faces back to back at vertex 2 beside creases and a boundary: OpenSubdiv 3.5.0 would read what it has
  // not written.
  EXPECT_THAT(
      report(with({4, 4, 4}, {0, 1, 2, 3, 1, 4, 3, 2, 4, 5, 6, 3},
                  {{"interpolateboundary", {1}, {}, {}}, {"crease", {1, 2, 3}, {2}, {}}}),
             3),
      HasSubstr("two faces share two edges at vertex 2, in a mesh with creases; rendered as polygons"));
  // A fan of 500 faces, a face of 500 sides: too many for a limit surface, so polygons.
  std::vector<float> P{0, 0, 1};
  std::vector<int> fan, sizes;
  for (int i = 0; i < 500; ++i) {
    const float a = 2 * kPi * static_cast<float>(i) / 500;
    P.insert(P.end(), {std::cos(a), std::sin(a), 0});
    fan.insert(fan.end(), {0, 1 + i, 1 + (i + 1) % 500});
    sizes.push_back(3);
  }
  EXPECT_THAT(report(primitive(SubdivisionMesh{"catmull-clark", sizes, fan, {}}, P), 500),
              HasSubstr("more than 128 faces meet at vertex 0; rendered as polygons"));
  std::vector<int> ring;
  for (int i = 1; i <= 500; ++i) ring.push_back(i);
  EXPECT_THAT(report(primitive(SubdivisionMesh{"catmull-clark", {500}, ring, {}}, P), 498),
              HasSubstr("face 0 has 500 vertices, more than 128"));
  P[4] = kInfinity;
  EXPECT_THAT(report(primitive(SubdivisionMesh{"catmull-clark", {500}, ring, {}}, P), 0),
              HasSubstr("point 1 is not finite"));
}

TEST(SubdivisionSurface, RandomTopologyNeverCrashes) {
  uint32_t state = 3;
  const auto next = [&](uint32_t n) {
    state = state * 1664525u + 1013904223u;
    return static_cast<int>((state >> 10) % n);
  };
  for (int round = 0; round < 400; ++round) {
    SubdivisionMesh mesh{
        round % 3 ? "catmull-clark" : "loop", {}, {}, {{"interpolateboundary", {next(3)}, {}, {}}}};
    for (int f = 0; f < 1 + round % 12; ++f) {
      const int n = round % 3 ? 3 + next(3) : 3;
      mesh.vertsPerFace.push_back(n);
      for (int k = 0; k < n; ++k) mesh.vertices.push_back(next(8));
    }
    for (int c = 0; c < 3; ++c)
      mesh.tags.push_back({"crease", {next(8), next(8)}, {static_cast<float>(next(12))}, {}});
    Messages messages;
    const Primitive p = primitive(std::move(mesh), kCubePoints);
    const auto s = makeSurface(p, messages.handler);
    if (!s || s->isFlat()) continue;
    for (const V3f& q : uniformFacets(*s, 4).vertices) ASSERT_TRUE(isFinite(q));
    ASSERT_TRUE(isFinite(s->evaluate(0, 0, 1).N));
  }
}

}  // namespace
}  // namespace patina
