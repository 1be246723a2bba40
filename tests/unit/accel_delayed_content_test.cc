// SPDX-License-Identifier: Apache-2.0
// What delayed archives may hold: things that move, solids, displaced surfaces and dense meshes, under rays
// of all kinds and times. Hits are those of the same archives read at once.
#include <algorithm>
#include <atomic>
#include <functional>
#include <random>
#include <thread>

#include "renderer/accel/accel.h"
#include "renderer/base/statistics.h"
#include "scene_fixture.h"

namespace patina {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

/// Moves points along their normals by a wave of x.
class Waves final : public Displacer {
 public:
  std::optional<Bound> boundOf(const Attributes& attributes) const override {
    if (attributes.displacement == kNone) return std::nullopt;
    return Bound{attributes.displacementBound, 0};
  }
  bool displace(const Vertices& v) const override {
    for (size_t k = 0; k < v.P.size(); ++k) v.P[k] += v.N[k] * (0.1f * std::sin(7 * v.P[k].x));
    vertices += v.P.size();
    return false;
  }
  mutable std::atomic<size_t> vertices = 0;
};

struct Traced {
  Waves waves;
  Geometry geometry;
  Accel accel;
  Traced(const Scene& scene, ErrorHandler& errors)
      : geometry(scene, RasterCamera(scene.camera, scene.options), errors, &waves), accel(geometry) {}
};

double counter(const std::string& name) {
  for (const StatEntry& entry : statistics())
    if (entry.name == name) return entry.value;
  return 0;
}

constexpr std::string_view kHead =
    "Format 200 200 1 Projection \"perspective\" \"fov\" 45 Shutter 0 1 Translate 0 0 12 Declare "
    "\"samplemotion\" "
    "\"int\"\n";

/// Four places for the archive, turned, mirrored and stretched.
std::string world(const std::string& archive, const std::string& request, const std::string& before = {}) {
  std::string text =
      std::string(kHead) + "ArchiveBegin \"a\"\n" + archive + "\nArchiveEnd\nWorldBegin\n" + before + "\n";
  for (const char* place : {"Translate -2 -2 0 Rotate 30 1 2 3", "Translate 2 -2 0 Scale -1 1.2 0.8",
                            "Translate -2 2 0 Scale .9 .9 .9 ReverseOrientation", "Translate 2 2 1"})
    text += std::string("AttributeBegin ") + place + " " + request + " AttributeEnd\n";
  return text + "WorldEnd\n";
}

const std::string kDelayed = "Procedural \"DelayedReadArchive\" [\"a\"] [-1.7 1.7 -1.7 1.7 -1.7 1.7]";
const std::string kAtOnce = "AttributeBegin ReadArchive \"a\" AttributeEnd";

/// Builds both scenes, and hands out what rays meet while they live.
void both(const std::string& archive, const std::function<void(Traced& delayed, Traced& atOnce)>& look,
          const std::string& before = {}) {
  std::vector<std::string> messages;
  ErrorHandler errors([&](Severity, std::string_view message) { messages.emplace_back(message); });
  int looks = 0;
  SceneBuilder outer({}, errors, [&](Scene& later) {
    EXPECT_EQ(later.delayed.size(), 4u);
    SceneBuilder inner({}, errors, [&](Scene& now) {
      EXPECT_TRUE(now.delayed.empty());
      Traced delayed(later, errors), atOnce(now, errors);
      look(delayed, atOnce);
      ++looks;
    });
    inner.readText(world(archive, kAtOnce, before), "now.rib");
  });
  outer.readText(world(archive, kDelayed, before), "later.rib");
  EXPECT_EQ(looks, 1);
  EXPECT_THAT(messages, IsEmpty());
}

Ray ray(uint32_t k, bool samplesMotion = false) {
  std::mt19937 random(k);
  std::uniform_real_distribution<float> uniform(-1, 1);
  const V3f origin(4 * uniform(random), 4 * uniform(random), -6),
      target(4 * uniform(random), 4 * uniform(random), 1);
  constexpr uint32_t kKinds[] = {kCameraRay, kDiffuseRay, kSpecularRay, kTransmissionRay};
  const uint32_t mask = kKinds[k % 4];
  const float time = k % 3 == 0 ? 0 : 0.5f + 0.5f * uniform(random);
  return {origin, (target - origin).normalized(),
          0,      kInfinity,
          mask,   mask == kCameraRay || samplesMotion ? time : 0};
}

void expectSamePlace(const Traced& a, const Hit& x, const Traced& b, const Hit& y, uint32_t k) {
  const Placement &p = a.geometry.placements()[x.placement], &q = b.geometry.placements()[y.placement];
  ASSERT_EQ(p.objectToWorld, q.objectToWorld) << k;
  ASSERT_EQ(p.moves, q.moves) << k;
  ASSERT_EQ(p.normalSign, q.normalSign) << k;
}

void expectSame(const Traced& a, const Hit& x, const Traced& b, const Hit& y, uint32_t k) {
  ASSERT_EQ(x.valid(), y.valid()) << k;
  ASSERT_TRUE(x.t == y.t && x.u == y.u && x.v == y.v && x.face == y.face && x.front == y.front &&
              x.beyond == y.beyond)
      << k << ": t " << x.t << " and " << y.t << ", u " << x.u << " and " << y.u << ", face " << x.face
      << " and " << y.face << ", beyond " << x.beyond << " and " << y.beyond;
  if (!x.valid()) return;
  expectSamePlace(a, x, b, y, k);
  const Facet f = a.geometry.facet(x.placement, x.face, x.u, x.v),
              g = b.geometry.facet(y.placement, y.face, y.u, y.v);
  ASSERT_TRUE(f.P == g.P && f.N == g.N && f.error == g.error) << k;
}

/// Of packets, which archives are met by one by one: Embree's kernels for one ray and for sixteen do not
/// round alike where instances move.
void expectAlike(const Traced& a, const Hit& x, const Traced& b, const Hit& y, uint32_t k) {
  ASSERT_EQ(x.valid(), y.valid()) << k;
  if (!x.valid()) return;
  ASSERT_NEAR(x.t, y.t, 1e-5f) << k;
  ASSERT_EQ(x.face, y.face) << k;
  ASSERT_EQ(x.front, y.front) << k;
  expectSamePlace(a, x, b, y, k);
}

constexpr uint32_t kRays = 6000;

/// Returns how many rays met something.
uint32_t expectSameHits(Traced& delayed, Traced& atOnce, bool samplesMotion = false) {
  uint32_t hits = 0;
  std::vector<Ray> rays;
  for (uint32_t k = 0; k < kRays; ++k) {
    rays.push_back(ray(k, samplesMotion));
    const Hit expected = atOnce.accel.intersect(rays[k]);
    hits += expected.valid();
    expectSame(delayed, delayed.accel.intersect(rays[k]), atOnce, expected, k);
    EXPECT_EQ(delayed.accel.occluded(rays[k]), expected.valid()) << k;
    if (testing::Test::HasFatalFailure()) return 0;
  }
  std::vector<Hit> packets(kRays);
  delayed.accel.intersectMany(rays, packets);
  for (uint32_t k = 0; k < kRays && !testing::Test::HasFatalFailure(); ++k)
    expectAlike(delayed, packets[k], atOnce, atOnce.accel.intersect(rays[k]), k);
  EXPECT_EQ(delayed.geometry.placements().size(), atOnce.geometry.placements().size());
  return hits;
}

const std::string kMoving =
    // A ball goes by itself, two squares as one; a ball swells; instances of a turning object.
    "AttributeBegin MotionBegin [0 1] Translate -1 0 0 Translate .3 .2 .1 MotionEnd Sphere .5 -.5 .5 360 "
    "AttributeEnd\n"
    "AttributeBegin MotionBegin [0 .5 1] Rotate 0 0 0 1 Rotate 40 0 0 1 Rotate 120 0 0 1 MotionEnd\n"
    "Polygon \"P\" [0 0 .3 1 0 .3 0 1 .3] Polygon \"P\" [0 0 .5 -1 0 .5 0 -1 .5] AttributeEnd\n"
    "AttributeBegin Translate 0 -.8 0 MotionBegin [0 1] Sphere .3 -.3 .3 360 Sphere .6 -.6 .6 360 MotionEnd "
    "AttributeEnd\n"
    "ObjectBegin \"o\" Torus .3 .1 0 360 360 Disk 0 .2 360 ObjectEnd\n"
    "AttributeBegin Sides 1 MotionBegin [0 1] Translate .8 .8 0 Translate .8 .2 .3 MotionEnd ObjectInstance "
    "\"o\" "
    "AttributeEnd\n"
    "Translate -.8 .9 0 ObjectInstance \"o\"\n";

TEST(DelayedContent, Moves) {
  both(kMoving, [](Traced& delayed, Traced& atOnce) {
    EXPECT_TRUE(delayed.geometry.moves());  // whether anybody read them or not
    EXPECT_FALSE(delayed.geometry.samplesMotion());
    EXPECT_EQ(delayed.geometry.placements().size(), 0u);
    EXPECT_GT(expectSameHits(delayed, atOnce), kRays / 6);
    EXPECT_EQ(delayed.geometry.movements().size(), atOnce.geometry.movements().size());
    EXPECT_EQ(delayed.geometry.movements().size(), 12u);
  });
}

TEST(DelayedContent, MovesForAllRays) {
  both(
      kMoving,
      [](Traced& delayed, Traced& atOnce) {
        EXPECT_TRUE(delayed.geometry.samplesMotion());
        EXPECT_GT(expectSameHits(delayed, atOnce, true), kRays / 6);
      },
      "Attribute \"trace\" \"samplemotion\" [1]");
}

TEST(DelayedContent, MovesAmongThingsThatMove) {
  // The scene's own instances and movements come first: numbers of the archive's are behind them.
  both(
      kMoving,
      [](Traced& delayed, Traced& atOnce) {
        EXPECT_EQ(delayed.geometry.instances().size(), 2u);
        EXPECT_GT(expectSameHits(delayed, atOnce), kRays / 6);
      },
      "ObjectBegin \"of all\" Sphere .4 -.4 .4 360 ObjectEnd AttributeBegin MotionBegin [0 1] Translate 0 0 "
      "-1 "
      "Translate 0 .5 -1 MotionEnd ObjectInstance \"of all\" Polygon \"P\" [0 0 -1 1 0 -1 0 1 -1] "
      "AttributeEnd");
}

TEST(DelayedContent, SolidsAndSides) {
  const std::string carved =
      "SolidBegin \"difference\" SolidBegin \"primitive\" Sphere 1 -1 1 360 SolidEnd "
      "SolidBegin \"primitive\" Translate .5 .3 -.6 Sphere .8 -.8 .8 360 SolidEnd SolidEnd\n";
  both("Sides 1 AttributeBegin Scale .8 .8 .8 " + carved + "AttributeEnd ObjectBegin \"s\" " + carved +
           "ObjectEnd AttributeBegin Translate .8 .8 .8 Scale .4 .4 -.4 ObjectInstance \"s\" AttributeEnd "
           "Sides 2 Translate -.9 .9 0 Scale .4 .4 .4 ObjectInstance \"s\"",
       [](Traced& delayed, Traced& atOnce) {
         EXPECT_GT(expectSameHits(delayed, atOnce), kRays / 6);
         EXPECT_EQ(delayed.geometry.solids().size(), 8u);
       });
}

TEST(DelayedContent, IsDisplaced) {
  const std::string things =
      "AttributeBegin Displacement \"waves\" Sphere .8 -.8 .8 360 Polygon \"P\" [-1 -1 .9 1 -1 .9 1 1 .9 -1 "
      "1 .9] "
      "AttributeEnd ObjectBegin \"d\" Sphere .3 -.3 .3 360 ObjectEnd "
      "AttributeBegin Translate .9 .9 -.5 Displacement \"waves\" ObjectInstance \"d\" AttributeEnd "
      "AttributeBegin Displacement \"waves\" MotionBegin [0 1] Translate -.9 0 -1 Translate -.9 .4 -1 "
      "MotionEnd "
      "Sphere .3 -.3 .3 360 AttributeEnd";
  resetStatistics();
  both("Attribute \"displacementbound\" \"sphere\" [.11]\n" + things, [](Traced& delayed, Traced& atOnce) {
    EXPECT_EQ(delayed.waves.vertices, 0u);
    EXPECT_EQ(counter("Displacement/surfaces"), 16);  // those of the scene read at once
    EXPECT_GT(expectSameHits(delayed, atOnce), kRays / 6);
    EXPECT_GT(delayed.waves.vertices, 0u);
    EXPECT_EQ(counter("Displacement/surfaces"), 32);
  });
}

TEST(DelayedContent, IsDisplacedAtOnceWithoutABoundAndSaysSo) {
  std::vector<std::string> messages;
  ErrorHandler errors([&](Severity, std::string_view message) { messages.emplace_back(message); });
  SceneBuilder builder({}, errors, [&](Scene& scene) {
    Traced delayed(scene, errors);
    EXPECT_EQ(delayed.waves.vertices, 0u);
    EXPECT_THAT(messages, IsEmpty());
    EXPECT_FALSE(delayed.accel.intersect({V3f(0, 0, -8), V3f(0, 0, -1), 0, kInfinity, kCameraRay}).valid());
    EXPECT_EQ(delayed.waves.vertices, 0u);
    EXPECT_TRUE(delayed.accel.intersect({V3f(2, 2, -8), V3f(0, 0, 1), 0, kInfinity, kCameraRay}).valid());
    EXPECT_GT(delayed.waves.vertices, 0u);
  });
  builder.readText(world("Displacement \"waves\" Sphere 1 -1 1 360", kDelayed), "t.rib");
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_THAT(messages[0],
              HasSubstr("displaced surfaces without Attribute \"displacementbound\", 1 from here on"));
}

TEST(DelayedContent, DenseMeshesAreTracedInChunks) {
  constexpr int kCells = 370;  // quads: 136900 faces, three chunks
  std::string faces, vertices, points;
  for (int j = 0; j <= kCells; ++j)
    for (int i = 0; i <= kCells; ++i) {
      const float x = 2 * static_cast<float>(i) / kCells - 1, y = 2 * static_cast<float>(j) / kCells - 1;
      points += std::to_string(x) + " " + std::to_string(y) + " " +
                std::to_string(0.2f * std::sin(9 * x) * y) + "\n";
      if (i == kCells || j == kCells) continue;
      const int a = j * (kCells + 1) + i;
      faces += "4 ";
      for (const int v : {a, a + 1, a + kCells + 2, a + kCells + 1}) vertices += std::to_string(v) + " ";
    }
  both("PointsPolygons [" + faces + "] [" + vertices + "] \"P\" [" + points + "]",
       [](Traced& delayed, Traced& atOnce) {
         resetStatistics();
         EXPECT_GT(expectSameHits(delayed, atOnce), kRays / 10);
         EXPECT_EQ(counter("Geometry/chunks of dense meshes"), 12);
         // Patches of neighbouring faces, too, whatever their numbers in the tables.
         const Ray down{V3f(2.3f, 2.2f, -8), V3f(0, 0, 1), 0, kInfinity, kCameraRay};
         const Hit a = delayed.accel.intersect(down), b = atOnce.accel.intersect(down);
         ASSERT_TRUE(a.valid() && b.valid());
         const auto patchOf = [](const Traced& t, const Hit& hit) {
           return t.geometry.patches()[t.geometry.patches().find(hit.placement, hit.face, hit.u, hit.v)];
         };
         EXPECT_EQ(patchOf(delayed, a).face, patchOf(atOnce, b).face);
         EXPECT_EQ(patchOf(delayed, a).group, patchOf(atOnce, b).group);
       });
}

TEST(DelayedContent, ManyThreadsMeetEverythingAtOnce) {
  const std::string all =
      kMoving +
      "AttributeBegin Displacement \"waves\" Attribute \"displacementbound\" \"sphere\" [.11] Translate .7 "
      "-.7 -.7 "
      "Sphere .4 -.4 .4 360 AttributeEnd SolidBegin \"intersection\" SolidBegin \"primitive\" Sphere .7 -.7 "
      ".7 360 "
      "SolidEnd SolidBegin \"primitive\" Translate .5 0 0 Sphere .7 -.7 .7 360 SolidEnd SolidEnd";
  both(all, [](Traced& delayed, Traced& atOnce) {
    std::vector<Hit> met(1200);
    std::vector<std::thread> threads;
    for (uint32_t t = 0; t < 4; ++t)
      threads.emplace_back([&, t] {  // the same rays in the same order, so that they meet at the bounds
        for (uint32_t k = 0; k < met.size(); ++k) {
          const Hit hit = delayed.accel.intersect(ray(k));
          if (hit.valid()) delayed.geometry.facet(hit.placement, hit.face, hit.u, hit.v);
          if (k % 4 == t) met[k] = hit;
        }
      });
    for (std::thread& thread : threads) thread.join();
    for (uint32_t k = 0; k < met.size(); ++k)
      expectSame(delayed, met[k], atOnce, atOnce.accel.intersect(ray(k)), k);
    EXPECT_EQ(delayed.geometry.placements().size(), atOnce.geometry.placements().size());
  });
}

/// A batch of rays against each ray by itself, while facets come and go.
void expectBatchesMeetTheSame(const Traced& delayed, const Traced& judge) {
  std::vector<Ray> rays;
  for (uint32_t k = 0; k < kRays; ++k) rays.push_back(ray(k));
  for (uint32_t k = 0; k < 200; ++k) delayed.accel.intersect(rays[k]);
  ASSERT_TRUE(delayed.geometry.tessellations().isTight());
  resetStatistics();
  std::vector<Hit> met(kRays), packets(kRays);
  std::vector<uint8_t> occluded(kRays);
  delayed.accel.intersect(rays, met);
  EXPECT_GT(counter("Rays/meetings that waited"), 0);
  delayed.accel.occluded(rays, occluded);
  delayed.accel.intersectMany(rays, packets);
  for (uint32_t k = 0; k < kRays; ++k) {
    const Hit expected = judge.accel.intersect(rays[k]);
    expectSame(delayed, met[k], judge, expected, k);
    expectAlike(delayed, packets[k], judge, expected, k);
    EXPECT_EQ(occluded[k] != 0, expected.valid()) << k;
    if (testing::Test::HasFatalFailure()) return;
  }
}

const std::string kLittleMemory = "Option \"limits\" \"int geocachememory\" [40]\n";

TEST(DelayedContent, WaitsForFacetsThatComeAndGo) {
  both(
      "Attribute \"displacementbound\" \"sphere\" [.11]\n" + kMoving +
          "AttributeBegin Displacement \"waves\" Translate .7 -.7 -.7 Sphere .4 -.4 .4 360 AttributeEnd "
          "SolidBegin \"intersection\" SolidBegin \"primitive\" Sphere .7 -.7 .7 360 SolidEnd "
          "SolidBegin \"primitive\" Translate .5 0 0 Sphere .7 -.7 .7 360 SolidEnd SolidEnd",
      [](Traced& delayed, Traced& atOnce) { expectBatchesMeetTheSame(delayed, atOnce); }, kLittleMemory);
}

TEST(DelayedContent, WaitingRaysAreCutToTheBoundAsOthersAre) {
  std::vector<std::string> messages;
  ErrorHandler errors([&](Severity, std::string_view message) { messages.emplace_back(message); });
  SceneBuilder builder({}, errors, [&](Scene& scene) {
    for (DelayedArchive& archive : scene.delayed) archive.bound = Box3f({-.6f, -1, -.2f}, {1, .3f, 1});
    Traced small(scene, errors);
    scene.options.geometryCacheKb = 1 << 18;
    const Traced large(scene, errors);
    expectBatchesMeetTheSame(small, large);
  });
  builder.readText(
      world(kMoving + "Sphere 1 -1 1 360 Translate .3 .2 0 Torus .9 .3 0 360 360", kDelayed, kLittleMemory),
      "t.rib");
  EXPECT_EQ(messages.size(), 1u);  // that it sticks out
}

TEST(DelayedContent, IsReadAtOnceUnderAMovingTransformation) {
  std::vector<std::string> messages;
  ErrorHandler errors([&](Severity, std::string_view message) { messages.emplace_back(message); });
  const std::string movement = "MotionBegin [0 1] Translate -2 0 0 Translate 2 0 0 MotionEnd ";
  SceneBuilder builder({}, errors, [&](Scene& scene) {
    EXPECT_TRUE(scene.delayed.empty());
    Traced traced(scene, errors);
    const auto sees = [&](float x, float time) {
      return traced.accel.occluded({V3f(x, 0, -8), V3f(0, 0, 1), 0, kInfinity, kCameraRay, time});
    };
    EXPECT_TRUE(sees(-2, 0) && sees(0, 0.5f) && sees(2, 1));
    EXPECT_FALSE(sees(2, 0) || sees(-2, 1));
  });
  builder.readText(std::string(kHead) + "ArchiveBegin \"a\" Sphere 1 -1 1 360 ArchiveEnd WorldBegin " +
                       movement + kDelayed + " WorldEnd",
                   "t.rib");
  EXPECT_THAT(messages, IsEmpty());
}

TEST(DelayedContent, SampleMotionComesTooLateWithin) {
  std::vector<std::string> messages;
  ErrorHandler errors([&](Severity, std::string_view message) { messages.emplace_back(message); });
  SceneBuilder builder({}, errors, [&](Scene& scene) {
    Traced delayed(scene, errors);
    for (uint32_t k = 0; k < 200; ++k) delayed.accel.intersect(ray(k));
    EXPECT_FALSE(delayed.geometry.samplesMotion());
  });
  builder.readText(world("Attribute \"trace\" \"samplemotion\" [1] " + kMoving, kDelayed), "t.rib");
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_THAT(messages[0],
              HasSubstr("warning: illstate: Attribute \"trace\" \"samplemotion\" within a delayed archive "
                        "has no effect: it is to be set before its request"));
}

TEST(DelayedContent, TurnedAndMovingContentKeepsToItsBound) {
  // A box of a box of a turned ball is larger than the ball's; and what moves out of the bound is named.
  for (const auto& [to, says] : {std::pair{"1", false}, std::pair{"3", true}}) {
    std::vector<std::string> messages;
    ErrorHandler errors([&](Severity, std::string_view message) { messages.emplace_back(message); });
    SceneBuilder builder({}, errors, [&](Scene& scene) {
      Traced delayed(scene, errors);
      for (uint32_t k = 0; k < 200; ++k) delayed.accel.intersect(ray(k));
    });
    builder.readText(
        world(std::string("Sphere 1.7 -1.7 1.7 360 MotionBegin [0 1] Translate 0 0 0 Translate ") + to +
                  " 0 0 MotionEnd Sphere .5 -.5 .5 360",
              kDelayed),
        "t.rib");
    EXPECT_EQ(messages.size(), says ? 1u : 0u);
    if (says) {
      EXPECT_THAT(messages.at(0),
                  HasSubstr("reaches out of its bound [-1.7 1.7 -1.7 1.7 -1.7 1.7]: it fills [-1.7 3.5 "));
    }
  }
}

}  // namespace
}  // namespace patina
