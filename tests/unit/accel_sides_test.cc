// SPDX-License-Identifier: Apache-2.0
// Which side of a surface is its outside: every kind of primitive under RI's orientations, handedness and
// instances (RI 3.2, Orientation and Sides).
#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <sstream>

#include "renderer/accel/accel.h"
#include "scene_fixture.h"

namespace patina {
namespace {

struct Named {
  std::string name, requests;
};

/// The primitives of tests/scenes/st_gallery, each with its place.
std::vector<Named> gallery() {
  std::ifstream file(PATINA_SOURCE_DIR "/tests/scenes/st_gallery/scene.rib");
  std::stringstream stream;
  stream << file.rdbuf();
  const std::string all = stream.str();
  constexpr std::string_view kBegin = "AttributeBegin  # ", kEnd = "AttributeEnd";
  std::vector<Named> shapes;
  for (size_t at = all.find(kBegin); at != std::string::npos; at = all.find(kBegin, at + 1)) {
    const size_t line = all.find('\n', at), end = all.find(kEnd, at);
    const std::string requests = all.substr(line, end - line);
    if (requests.find("Surface") == std::string::npos)  // not the backdrop
      shapes.push_back({all.substr(at + kBegin.size(), line - at - kBegin.size()), requests});
  }
  return shapes;
}

struct Case {
  std::string_view before, after;  ///< of the shape
  bool reversed;                   ///< the outside is opposite to dPdu x dPdv of object space
};

// The camera's space is left-handed. Mirroring flips the handedness of the current space, and the current
// orientation with it.
constexpr Case kCases[] = {
    {"", "", false},
    {"Orientation \"outside\"", "", false},
    {"Orientation \"inside\"", "", true},
    {"Orientation \"lh\"", "", false},
    {"Orientation \"rh\"", "", true},
    {"ReverseOrientation", "", true},
    {"ReverseOrientation ReverseOrientation", "", false},
    {"Scale -1 1 1", "", false},
    {"Scale -1 1 1 Orientation \"lh\"", "", true},
    {"Scale -1 1 1 Orientation \"rh\"", "", false},
    {"Orientation \"rh\" Scale 1 -1 1", "", true},
    {"ObjectBegin \"o\"", "ObjectEnd ObjectInstance \"o\"", false},
    {"ObjectBegin \"o\"", "ObjectEnd Scale -1 1 1 ObjectInstance \"o\"", false},
    {"ObjectBegin \"o\" Scale 1 1 -1", "ObjectEnd Scale -1 1 1 ObjectInstance \"o\"", false},
    {"ObjectBegin \"o\" ReverseOrientation", "ObjectEnd Scale -1 1 1 ObjectInstance \"o\"", true},
    {"ObjectBegin \"o\"", "ObjectEnd ReverseOrientation ObjectInstance \"o\"", true},
    {"ObjectBegin \"o\" ReverseOrientation", "ObjectEnd ReverseOrientation ObjectInstance \"o\"", false},
};

struct World {
  Built built;
  std::vector<std::string> messages;
  ErrorHandler errors{[this](Severity, std::string_view text) { messages.emplace_back(text); }};
  std::unique_ptr<Geometry> geometry;
  std::unique_ptr<Accel> accel;

  explicit World(const std::string& requests) {
    built = build("ScreenWindow -5 5 -3.75 3.75 Translate 0 0 5 WorldBegin\n" + requests + "\nWorldEnd");
    messages = built.messages;
    geometry = std::make_unique<Geometry>(built.world(),
                                          RasterCamera(built.world().camera, built.world().options), errors);
    accel = std::make_unique<Accel>(*geometry);
  }
};

TEST(Sides, EveryPrimitiveShowsItsOutside) {
  const std::vector<Named> shapes = gallery();
  ASSERT_EQ(shapes.size(), 20u);
  for (const Named& shape : shapes)
    for (const Case& c : kCases) {
      SCOPED_TRACE(shape.name + ": " + std::string(c.before) + " ... " + std::string(c.after));
      const std::string requests = std::string(c.before) + "\nTransformBegin " + shape.requests +
                                   "\nTransformEnd\n" + std::string(c.after);
      const World two(requests);
      // Sides is the shape's own, or that of the instance.
      const World one("Sides 1 " + requests);
      ASSERT_TRUE(two.messages.empty()) << two.messages[0];
      const Box3f bound = two.geometry->bound();
      const V3f center = bound.center();
      const float radius = bound.size().length() / 2;
      std::mt19937 random(1);
      std::uniform_real_distribution<float> uniform(-1, 1);
      int hits = 0, fronts = 0, culled = 0;
      for (int k = 0; k < 400; ++k) {
        const auto point = [&] { return V3f(uniform(random), uniform(random), uniform(random)); };
        const V3f from = center + point().normalized() * (3 * radius),
                  to = center + point() * (0.5f * radius);
        const Ray ray{from, (to - from).normalized(), 0, kInfinity, kCameraRay};
        const Hit hit = two.accel->intersect(ray), outside = one.accel->intersect(ray);
        ASSERT_EQ(one.accel->occluded(ray), outside.valid());
        if (outside.valid()) {
          ASSERT_TRUE(outside.front);
        }
        if (!hit.valid()) continue;
        const Placement& placement = two.geometry->placements()[hit.placement];
        const V3f normal = transformNormal(
            two.geometry->surface(placement).evaluate(hit.face, hit.u, hit.v).N, placement.worldToObject);
        const float cosine = normal.normalized().dot(ray.direction);
        if (std::abs(cosine) < 0.25f) continue;  // facets may face the other way
        ++hits;
        fronts += hit.front;
        ASSERT_EQ(hit.front, (cosine < 0) != c.reversed);
        if (hit.front) {
          ASSERT_EQ(outside.t, hit.t) << "the outside is met first: Sides does not matter";
        } else {
          ++culled;
          ASSERT_TRUE(!outside.valid() || outside.t > hit.t);
        }
      }
      EXPECT_GT(hits, 20);
    }
}

TEST(Sides, ClosedShapesShowTheirOutsideToWhoIsOutside) {
  for (const Named& shape : gallery()) {
    if (shape.name != "sphere" && shape.name != "torus") continue;
    for (const std::string_view mirror : {"", "Scale -1 1 1 "}) {
      const World world(std::string(mirror) + shape.requests);
      const V3f center = world.geometry->bound().center();
      // Along the axes of the shape's box, towards its middle.
      for (int k = 0; k < 2; ++k)
        for (const float side : {-1.0f, 1.0f}) {
          V3f from = center;
          from[k] += 5 * side;
          const Hit hit =
              world.accel->intersect({from, (center - from).normalized(), 0, kInfinity, kCameraRay});
          if (hit.valid()) {
            EXPECT_TRUE(hit.front) << shape.name << from;
          }
        }
    }
  }
}

}  // namespace
}  // namespace patina
