// SPDX-License-Identifier: Apache-2.0
// Rays against solids, judged by closed forms: operands are convex, so that a ray is inside each of them
// between two distances, and what it meets of the result follows from those.
#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <thread>

#include "renderer/accel/accel.h"
#include "renderer/base/statistics.h"
#include "scene_fixture.h"

namespace patina {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Two thousand pixels from 6 units away: facets of curved surfaces stay within 2e-4 of them.
constexpr std::string_view kHead =
    "Format 2000 2000 1 Projection \"perspective\" \"fov\" 45 Translate 0 0 6 WorldBegin\n";
constexpr std::string_view kBox =
    "PointsPolygons [4 4 4 4 4 4] [0 2 3 1 4 5 7 6 0 1 5 4 2 6 7 3 0 4 6 2 1 3 7 5] "
    "\"P\" [-1 -1 -1 1 -1 -1 -1 1 -1 1 1 -1 -1 -1 1 1 -1 1 -1 1 1 1 1 1]\n";
// Both caps face +z: that of the near end faces in.
constexpr std::string_view kCylinder = "Cylinder 1 -1 1 360 Disk -1 1 360 Disk 1 1 360\n";
constexpr std::string_view kSphere = "Sphere 1 -1 1 360\n";

struct Rendered {
  Built built;
  std::vector<std::string> messages;
  ErrorHandler errors{[this](Severity, std::string_view text) { messages.emplace_back(text); }};
  std::unique_ptr<Geometry> geometry;
  std::unique_ptr<Accel> accel;

  explicit Rendered(const std::string& world) : built(build(std::string(kHead) + world + "\nWorldEnd\n")) {
    const Scene& scene = built.worlds.at(0);
    geometry = std::make_unique<Geometry>(scene, RasterCamera(scene.camera, scene.options), errors);
    accel = std::make_unique<Accel>(*geometry);
  }
};

enum class Kind { Sphere, Box, Cylinder };

struct Operand {
  Kind kind;
  M44d toWorld;
};

struct Interval {
  double t[2];
  V3d normal[2];  // outward, of the operand, in world space, not unit
};

std::optional<Interval> cross(const Operand& operand, const V3d& origin, const V3d& direction) {
  const M44d toLocal = operand.toWorld.inverse();
  V3d o = origin * toLocal, d;
  toLocal.multDirMatrix(direction, d);
  Interval hit{{-1e300, 1e300}, {}};
  const auto clip = [&](double t0, double t1, const V3d& n0, const V3d& n1) {
    if (t0 > hit.t[0]) hit.t[0] = t0, hit.normal[0] = n0;
    if (t1 < hit.t[1]) hit.t[1] = t1, hit.normal[1] = n1;
  };
  const int round = operand.kind == Kind::Sphere ? 3 : operand.kind == Kind::Cylinder ? 2 : 0;
  if (round > 0) {
    double a = 0, b = 0, c = -1;
    for (int k = 0; k < round; ++k) a += d[k] * d[k], b += o[k] * d[k], c += o[k] * o[k];
    const double root = b * b - a * c;
    if (root <= 0) return std::nullopt;
    const double t0 = (-b - std::sqrt(root)) / a, t1 = (-b + std::sqrt(root)) / a;
    const auto at = [&](double t) {
      V3d n = o + d * t;
      for (int k = round; k < 3; ++k) n[k] = 0;
      return n;
    };
    clip(t0, t1, at(t0), at(t1));
  }
  for (int k = round; k < 3; ++k) {
    V3d n(0, 0, 0);
    n[k] = d[k] > 0 ? 1 : -1;
    clip((-1 - o[k] * n[k]) / (d[k] * n[k]), (1 - o[k] * n[k]) / (d[k] * n[k]), -n, n);
  }
  if (!(hit.t[0] < hit.t[1])) return std::nullopt;
  for (V3d& n : hit.normal) {  // as normals go: by the inverse, transposed
    V3d world;
    toLocal.transposed().multDirMatrix(n, world);
    n = world.normalized();
  }
  return hit;
}

using Result = std::function<bool(const std::vector<bool>&)>;

struct Expected {
  bool met = false, front = false;
  double t = 0;
  V3d normal;
};

/// Walks along the closed form. nullopt: too near an edge or a tangent for facets to agree.
std::optional<Expected> expect(const std::vector<Operand>& operands, const Result& result, const V3d& origin,
                               const V3d& direction, bool curved) {
  struct Event {
    double t;
    size_t operand;
    bool in;
    V3d normal;
  };
  std::vector<Event> events;
  for (size_t k = 0; k < operands.size(); ++k)
    if (const auto hit = cross(operands[k], origin, direction))
      for (int end = 0; end < 2; ++end) {
        events.push_back({hit->t[end], k, end == 0, hit->normal[end]});
        if (operands[k].kind != Kind::Box && std::abs(hit->normal[end].dot(direction)) < 0.15)
          return std::nullopt;
        if (hit->t[1] - hit->t[0] < 2e-2) return std::nullopt;
      }
  std::sort(events.begin(), events.end(), [](const Event& a, const Event& b) { return a.t < b.t; });
  const double apart = curved ? 5e-3 : 2e-5;
  std::vector<bool> inside(operands.size(), false);
  for (size_t k = 0; k < events.size();) {
    if (std::abs(events[k].t) < apart) return std::nullopt;
    const bool before = result(inside);
    const size_t first = k;
    for (; k < events.size() && events[k].t - events[first].t < 1e-9; ++k)
      inside[events[k].operand] = events[k].in;
    if (k < events.size() && events[k].t - events[k - 1].t < apart) return std::nullopt;
    const bool after = result(inside);
    if (after == before || events[first].t < 0) continue;
    const V3d& n = events[first].normal;  // coincident faces are parallel
    return Expected{true, after, events[first].t, (n.dot(direction) < 0) == after ? n : -n};
  }
  return Expected{};
}

/// Random rays from inside and outside of a solid.
void compare(const Rendered& world, const std::vector<Operand>& operands, const Result& result, int rays,
             bool curved) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int judged = 0, met = 0, fromInside = 0;
  for (int k = 0; k < rays; ++k) {
    const V3f origin(V3d(uniform(random), uniform(random), uniform(random)) * (k % 2 ? 1.2 : 3.0));
    V3d d;
    do {
      d = V3d(uniform(random), uniform(random), uniform(random));
    } while (d.length2() > 1 || d.length2() < 0.01);
    const V3f direction(d.normalized());
    const auto expected = expect(operands, result, V3d(origin), V3d(direction), curved);
    if (!expected) continue;
    ++judged;
    const Ray ray{origin, direction, 0, kInfinity, kDiffuseRay};
    const Hit hit = world.accel->intersect(ray);
    ASSERT_EQ(hit.valid(), expected->met) << origin << direction;
    ASSERT_EQ(world.accel->occluded(ray), expected->met);
    if (!expected->met) continue;
    ++met;
    fromInside += !expected->front;
    ASSERT_NEAR(hit.t, expected->t, curved ? 2.5e-3 : 2e-5) << origin << direction;
    ASSERT_EQ(hit.front, expected->front) << origin << direction;
    const Facet facet = world.geometry->facet(hit.placement, hit.face, hit.u, hit.v);
    // The outside of the result; curved surfaces turn by less than 6 degrees within a facet.
    ASSERT_GT(V3d(facet.N).dot(expected->normal), curved ? 0.98 : 1 - 1e-5) << origin << direction;
    // Up to it there is nothing, and rays that leave it do not meet it again.
    ASSERT_FALSE(world.accel->occluded({origin, direction, 0, hit.t * (1 - 1e-5f), kDiffuseRay}));
    ASSERT_TRUE(world.accel->occluded({origin, direction, 0, hit.t * (1 + 1e-5f), kDiffuseRay}));
  }
  EXPECT_GT(judged, rays / 3);
  EXPECT_GT(met, rays / 50);
  EXPECT_GT(fromInside, rays / 500);
}

M44d move(double x, double y, double z) { return M44d().setTranslation(V3d(x, y, z)); }
M44d scaled(double x, double y, double z) { return M44d().setScale(V3d(x, y, z)); }

std::string place(const M44d& m, std::string_view what) {
  std::string text = "TransformBegin ConcatTransform [";
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) text += std::to_string(static_cast<float>(m[i][j])) + " ";
  return text + "] SolidBegin \"primitive\" " + std::string(what) + " SolidEnd TransformEnd\n";
}

std::string text(const Operand& operand) {
  return place(operand.toWorld, operand.kind == Kind::Sphere ? kSphere
                                : operand.kind == Kind::Box  ? kBox
                                                             : kCylinder);
}

std::string solid(std::string_view operation, std::initializer_list<std::string> operands) {
  std::string all = "SolidBegin \"" + std::string(operation) + "\"\n";
  for (const std::string& operand : operands) all += operand;
  return all + "SolidEnd\n";
}

constexpr int kRays = 200'000;

TEST(Solids, TwoSpheres) {
  const std::vector<Operand> two{{Kind::Sphere, M44d()},
                                 {Kind::Sphere, scaled(0.8, 0.8, 0.8) * move(0.7, 0.1, 0)}};
  const auto check = [&](std::string_view operation, const Result& result) {
    SCOPED_TRACE(operation);
    const Rendered world(solid(operation, {text(two[0]), text(two[1])}));
    ASSERT_THAT(world.messages, IsEmpty());
    compare(world, two, result, kRays, true);
  };
  check("difference", [](const auto& in) { return in[0] && !in[1]; });
  check("intersection", [](const auto& in) { return in[0] && in[1]; });
  check("union", [](const auto& in) { return in[0] || in[1]; });
}

const std::vector<Operand> kDrilled{{Kind::Box, scaled(1, 0.8, 0.9)}, {Kind::Cylinder, scaled(0.5, 0.5, 2)}};

TEST(Solids, ABoxWithoutACylinder) {
  const Rendered world(solid("difference", {text(kDrilled[0]), text(kDrilled[1])}));
  ASSERT_THAT(world.messages, IsEmpty());
  compare(
      world, kDrilled, [](const auto& in) { return in[0] && !in[1]; }, kRays, true);
}

TEST(Solids, ThreeDeep) {
  const std::vector<Operand> all{
      {Kind::Sphere, scaled(1.3, 1.3, 1.3)},
      {Kind::Box, M44d()},
      {Kind::Cylinder, scaled(0.5, 0.5, 2)},
      {Kind::Cylinder, scaled(0.4, 0.4, 2) * M44d(0, 0, 1, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 0, 1)},
      {Kind::Sphere, scaled(0.3, 0.3, 0.3)}};
  // A sphere stands again where the bores meet.
  const Rendered world(solid(
      "difference", {solid("intersection", {text(all[0]), text(all[1])}),
                     solid("difference", {solid("union", {text(all[2]), text(all[3])}), text(all[4])})}));
  ASSERT_THAT(world.messages, IsEmpty());
  EXPECT_EQ(world.geometry->solids().size(), 1u);
  compare(
      world, all, [](const auto& in) { return (in[0] && in[1]) && !((in[2] || in[3]) && !in[4]); }, kRays,
      true);
}

TEST(Solids, InInstancesOfAllHandedness) {
  for (const double mirror : {1.0, -1.0})
    for (const std::string_view orientation : {"", "ReverseOrientation "}) {
      const M44d within = scaled(-1, 1, 1), placed = scaled(mirror, 1.1, 0.9) * move(0.3, 0.2, -0.1);
      std::vector<Operand> moved = kDrilled;
      std::string object = "ObjectBegin \"o\" " + std::string(orientation) + "Scale -1 1 1 ";
      object += solid("difference", {text(kDrilled[0]), text(kDrilled[1])}) + "ObjectEnd ";
      for (Operand& operand : moved) operand.toWorld = operand.toWorld * within * placed;
      object += "Translate 0.3 0.2 -0.1 Scale " + std::to_string(mirror) + " 1.1 0.9 ";
      const Rendered world(object + std::string(orientation) + "ObjectInstance \"o\"");
      ASSERT_THAT(world.messages, IsEmpty());
      compare(
          world, moved, [](const auto& in) { return in[0] && !in[1]; }, kRays / 4, true);
    }
}

TEST(Solids, FacesThatCoincide) {
  const Operand whole{Kind::Box, M44d()}, notch{Kind::Box, scaled(0.5, 0.5, 0.5) * move(0, 0, 0.5)},
      beside{Kind::Box, move(2, 0, 0)}, through{Kind::Box, scaled(0.25, 0.5, 1)};
  struct Case {
    std::string_view operation;
    std::vector<Operand> operands;
    Result result;
  };
  const Case cases[] = {
      // The notch opens in a face of the whole; the bore in two of them.
      {"difference", {whole, notch}, [](const auto& in) { return in[0] && !in[1]; }},
      {"difference", {whole, through}, [](const auto& in) { return in[0] && !in[1]; }},
      // The shared face is not there; nor are coincident faces there twice.
      {"union", {whole, beside}, [](const auto& in) { return in[0] || in[1]; }},
      {"union", {whole, through}, [](const auto& in) { return in[0] || in[1]; }},
      {"intersection", {whole, through}, [](const auto& in) { return in[0] && in[1]; }},
      {"union", {whole, whole}, [](const auto& in) { return in[0] || in[1]; }},
  };
  for (const Case& c : cases) {
    const Rendered world(solid(c.operation, {text(c.operands[0]), text(c.operands[1])}));
    ASSERT_THAT(world.messages, IsEmpty());
    compare(world, c.operands, c.result, kRays / 2, false);
  }
  // Nothing is left of a thing without itself.
  const Rendered nothing(solid("difference", {text(whole), text(whole)}));
  std::mt19937 random(9);
  std::uniform_real_distribution<float> uniform(-1.5f, 1.5f);
  for (int k = 0; k < 20000; ++k) {
    const V3f from(uniform(random), uniform(random), -3), to(uniform(random), uniform(random), 3);
    ASSERT_FALSE(nothing.accel->intersect({from, to - from, 0, kInfinity, kCameraRay}).valid()) << from << to;
  }
}

TEST(Solids, OverlappingPartsOfAPrimitiveAreOne) {
  const std::vector<Operand> all{
      {Kind::Sphere, move(-0.4, 0, 0)}, {Kind::Sphere, move(0.4, 0, 0)}, {Kind::Box, scaled(0.4, 2, 0.4)}};
  const Rendered world(solid(
      "difference", {place(M44d(), "Translate -.4 0 0 Sphere 1 -1 1 360 Translate .8 0 0 Sphere 1 -1 1 360"),
                     text(all[2])}));
  ASSERT_THAT(world.messages, IsEmpty());
  compare(
      world, all, [](const auto& in) { return (in[0] || in[1]) && !in[2]; }, kRays / 2, true);
}

TEST(Solids, NothingGetsOutOfTheInside) {
  const Rendered world(solid("difference", {text(kDrilled[0]), text(kDrilled[1])}));
  std::mt19937 random(2);
  std::uniform_real_distribution<float> uniform(-1, 1);
  // From points of the surface inwards, as light within would go, and then from where that ended.
  int64_t left = 0, count = 0;
  for (int k = 0; k < 20000; ++k) {
    const V3f from(4 * uniform(random), 4 * uniform(random), 4 * uniform(random));
    const V3f to(0.9f * uniform(random), 0.7f * uniform(random), 0.8f * uniform(random));
    Hit hit = world.accel->intersect({from, (to - from).normalized(), 0, kInfinity, kDiffuseRay});
    if (!hit.valid() || !hit.front) continue;
    for (int bounce = 0; bounce < 50; ++bounce) {
      const Facet facet = world.geometry->facet(hit.placement, hit.face, hit.u, hit.v);
      V3f d;
      do {
        d = V3f(uniform(random), uniform(random), uniform(random));
      } while (d.length2() > 1 || d.length2() < 0.01f);
      if (d.dot(facet.N) > 0) d = -d;
      d = d.normalized();
      hit = world.accel->intersect({leave(facet, d), d, 0, kInfinity, kDiffuseRay});
      ++count;
      left += !hit.valid() || hit.front;
      if (!hit.valid() || hit.front) break;
    }
  }
  EXPECT_GT(count, 200'000);
  // In a corner the origin of a ray, moved off one plane, may be beyond the other.
  EXPECT_LE(left, count / 100'000);
}

TEST(Solids, SidesAndVisibilityAreThoseOfTheResult) {
  const auto world = [](std::string_view sphere, std::string_view hole) {
    return Rendered("SolidBegin \"difference\" SolidBegin \"primitive\" " + std::string(sphere) +
                    " Sphere 1 -1 1 360 SolidEnd SolidBegin \"primitive\" " + std::string(hole) +
                    " Sphere 0.5 -0.5 0.5 360 SolidEnd SolidEnd");
  };
  const Ray in{V3f(0.01f, 0.02f, -3), V3f(0, 0, 1), 0, kInfinity, kCameraRay},
      within{V3f(0.01f, 0.02f, -0.75f), V3f(0, 0, 1), 0, kInfinity, kCameraRay},
      hollow{V3f(0.01f, 0.02f, 0), V3f(0, 0, 1), 0, kInfinity, kCameraRay};
  const auto distance = [](const Rendered& w, Ray ray, uint32_t mask = kCameraRay) {
    ray.mask = mask;
    const Hit hit = w.accel->intersect(ray);
    EXPECT_EQ(w.accel->occluded(ray), hit.valid());
    return hit.valid() ? hit.t : -1;
  };
  const Rendered both = world("", "");
  EXPECT_NEAR(distance(both, in), 2, 1e-2);
  EXPECT_NEAR(distance(both, within), 0.25, 1e-2);
  EXPECT_NEAR(distance(both, hollow), 0.5, 1e-2);
  // The outside of the wall around the hollow is the hollow.
  const Rendered sides = world("Sides 1", "Sides 1");
  EXPECT_NEAR(distance(sides, in), 2, 1e-2);
  EXPECT_NEAR(distance(sides, within), 1.25, 1e-2);
  EXPECT_NEAR(distance(sides, hollow), 0.5, 1e-2);
  const Rendered hidden = world("Attribute \"visibility\" \"int camera\" 0", "");
  EXPECT_NEAR(distance(hidden, in), 2.5, 1e-2) << "the back of the wall";
  EXPECT_NEAR(distance(hidden, in, kDiffuseRay), 2, 1e-2);
  const Rendered cutter =
      world("",
            "Attribute \"visibility\" \"int camera\" 0 \"int diffuse\" 0 \"int specular\" 0 "
            "\"int transmission\" 0");
  EXPECT_NEAR(distance(cutter, hollow), 1, 1e-2) << "what nothing sees cuts all the same";
}

TEST(Solids, PacketsAndThreadsMeetTheSame) {
  resetStatistics();
  const Rendered world(solid("difference", {text(kDrilled[0]), text(kDrilled[1])}));
  std::vector<Ray> rays;
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(-1, 1);
  for (int k = 0; k < 4000; ++k)
    rays.push_back({V3f(uniform(random), uniform(random), -5),
                    V3f(0.2f * uniform(random), 0.1f, 1).normalized(), 0, kInfinity, kCameraRay});
  std::vector<Hit> packets(rays.size()), threads(rays.size());
  world.accel->intersectMany(rays, packets);
  std::vector<std::thread> running;
  for (size_t t = 0; t < 4; ++t)
    running.emplace_back([&, t] {
      for (size_t k = t; k < rays.size(); k += 4) threads[k] = world.accel->intersect(rays[k]);
    });
  for (std::thread& thread : running) thread.join();
  for (size_t k = 0; k < rays.size(); ++k) {
    ASSERT_EQ(packets[k].placement, threads[k].placement);
    ASSERT_EQ(packets[k].t, threads[k].t);
    ASSERT_EQ(packets[k].front, threads[k].front);
  }
  int64_t crossed = 0;
  for (const StatEntry& entry : statistics())
    if (entry.name == "Solids/crossings") crossed = static_cast<int64_t>(entry.value);
  EXPECT_GT(crossed, 4000);
}

TEST(Solids, WhatIsNotClosedIsDrawnWhole) {
  const Rendered open(
      "SolidBegin \"difference\"\nSolidBegin \"primitive\" Sphere 1 -1 1 360 SolidEnd\n"
      "SolidBegin \"primitive\" Cylinder 0.5 -2 2 360 SolidEnd\nSolidEnd");
  EXPECT_THAT(open.messages,
              ElementsAre("t.rib:4:1: warning: badsolid: the surfaces of this operand of a solid are "
                          "not closed: they are drawn whole"));
  EXPECT_TRUE(open.geometry->solids().empty()) << "one operand is left, which is no solid";
  EXPECT_EQ(open.geometry->placements().size(), 2u);
  EXPECT_NEAR(open.accel->intersect({V3f(0.1f, 0, -5), V3f(0, 0, 1), 0, kInfinity, kCameraRay}).t, 4.005f,
              1e-2f);

  // Without a first operand there is nothing to take from.
  const Rendered first(
      "SolidBegin \"difference\"\nSolidBegin \"primitive\" SolidEnd\nSolidBegin \"primitive\" Sphere 1 -1 1 "
      "360 "
      "SolidEnd\nSolidBegin \"primitive\" Sphere 1 -1 1 360 SolidEnd\nSolidEnd");
  EXPECT_THAT(first.messages,
              ElementsAre(HasSubstr("t.rib:2:1: warning: badsolid: operands of this solid are left out")));
  EXPECT_TRUE(first.geometry->placements().empty());
}

TEST(Solids, WithoutThemNothingIsPaid) {
  resetStatistics();
  const Rendered world(
      "SolidBegin \"primitive\" Sphere 1 -1 1 360 SolidEnd SolidBegin \"union\" SolidBegin "
      "\"primitive\" Cylinder 1 0 1 360 SolidEnd SolidEnd");
  EXPECT_THAT(world.messages, IsEmpty());
  EXPECT_TRUE(world.geometry->solids().empty());
  world.accel->intersect({V3f(0.1f, 0, -5), V3f(0, 0, 1), 0, kInfinity, kCameraRay});
  for (const StatEntry& entry : statistics()) EXPECT_FALSE(entry.name.starts_with("Solids/")) << entry.name;
}

}  // namespace
}  // namespace patina
