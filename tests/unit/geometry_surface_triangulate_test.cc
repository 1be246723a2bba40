// SPDX-License-Identifier: Apache-2.0
// Triangulation: area preserved, every edge matched, on polygons of all shapes; time on large ones; hostile
// input.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "renderer/geometry/triangulate.h"

namespace patina {
namespace {

using Point = Triangulator::Point;
using Triangle = Triangulator::Triangle;
using Loops = std::vector<std::vector<Point>>;

double cross(const Point& a, const Point& b, const Point& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

double area(const std::vector<Point>& loop) {
  double sum = 0;
  for (size_t i = 1; i + 1 < loop.size(); ++i) sum += cross(loop[0], loop[i], loop[i + 1]) / 2;
  return sum;
}

struct Result {
  std::vector<Point> points;
  std::vector<Triangle> triangles;
  bool simple;
};

Result run(const Loops& loops) {
  Result r;
  std::vector<uint32_t> sizes;
  for (const auto& loop : loops) {
    r.points.insert(r.points.end(), loop.begin(), loop.end());
    sizes.push_back(static_cast<uint32_t>(loop.size()));
  }
  Triangulator triangulator;
  r.simple = triangulator.run(r.points, sizes, r.triangles);
  return r;
}

/// A triangulation of a simple polygon: the areas add up to the polygon's, all triangles turn like the
/// outline, and every triangle edge is either an edge of a loop, once, or met by another triangle the other
/// way round. (Closed chains of edges with the right area and no overlap by orientation: that is the
/// definition.)
void expectTriangulates(const Loops& loops) {
  const Result r = run(loops);
  EXPECT_TRUE(r.simple);
  double expected = std::abs(area(loops[0]));
  for (size_t l = 1; l < loops.size(); ++l) expected -= std::abs(area(loops[l]));
  const double sign = area(loops[0]) < 0 ? -1 : 1;
  double sum = 0;
  std::map<std::pair<uint32_t, uint32_t>, int> edges;
  for (const Triangle& t : r.triangles) {
    const double a = sign * cross(r.points[t[0]], r.points[t[1]], r.points[t[2]]) / 2;
    EXPECT_GT(a, 0);
    sum += a;
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t p = t[k], q = t[(k + 1) % 3];
      if (p < q)
        ++edges[{p, q}];
      else
        --edges[{q, p}];
    }
  }
  EXPECT_NEAR(sum, expected, 1e-9 * std::abs(area(loops[0])));
  uint32_t first = 0;
  for (size_t l = 0; l < loops.size(); ++l) {
    const auto n = static_cast<uint32_t>(loops[l].size());
    const bool forward = l == 0 || (area(loops[l]) < 0) == (sign > 0);
    for (uint32_t i = 0; i < n; ++i) {
      uint32_t p = first + i, q = first + (i + 1) % n;
      if (!forward) std::swap(p, q);
      if (p < q)
        --edges[{p, q}];
      else
        ++edges[{q, p}];
    }
    first += n;
  }
  for (const auto& [edge, count] : edges) EXPECT_EQ(count, 0) << edge.first << "-" << edge.second;
}

std::vector<Point> circle(int n, double radius, Point centre = {0, 0}, bool clockwise = false) {
  std::vector<Point> loop;
  for (int i = 0; i < n; ++i) {
    const double a = (clockwise ? -2 : 2) * std::numbers::pi * i / n;
    loop.push_back(centre + Point(std::cos(a), std::sin(a)) * radius);
  }
  return loop;
}

std::vector<Point> star(int n, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> radius(0.05, 1);
  std::vector<Point> loop = circle(n, 1);
  for (Point& p : loop) p *= radius(random);
  return loop;
}

std::vector<Point> comb(int teeth) {
  std::vector<Point> loop{{0, -1}, {2.0 * teeth, -1}};
  for (int i = teeth; i-- > 0;) {
    loop.push_back({2.0 * i + 2, 0});
    loop.push_back({2.0 * i + 1.5, 40});
    loop.push_back({2.0 * i + 1, 0});
  }
  return loop;
}

std::vector<Point> spiral(int n, double turns) {
  std::vector<Point> loop;
  const auto at = [&](double t, double width) {
    const double a = turns * 2 * std::numbers::pi * t, r = 0.1 + t + width / turns;
    return Point(r * std::cos(a), r * std::sin(a));
  };
  for (int i = 0; i <= n; ++i) loop.push_back(at(static_cast<double>(i) / n, 0.4));
  for (int i = n; i >= 0; --i) loop.push_back(at(static_cast<double>(i) / n, 0));
  return loop;
}

TEST(Triangulate, Simple) {
  expectTriangulates({{{0, 0}, {1, 0}, {0, 1}}});
  expectTriangulates({{{0, 0}, {4, 0}, {4, 4}, {2, 1}, {0, 4}}});
  expectTriangulates({circle(5, 1)});
  expectTriangulates({circle(1000, 1, {0, 0}, true)});
}

TEST(Triangulate, VerticesOnStraightEdgesAreKept) {
  expectTriangulates({{{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}});
  expectTriangulates({{{0, 0}, {1, 0}, {2, 0}, {1, 1}}});
}

TEST(Triangulate, Stars) {
  for (uint32_t seed = 0; seed < 200; ++seed)
    expectTriangulates({star(5 + static_cast<int>(seed) * 3, seed)});
}

TEST(Triangulate, CombsAndSpirals) {
  for (int n : {1, 2, 7, 100, 1000}) expectTriangulates({comb(n)});
  for (double turns : {1.0, 5.0, 40.0}) expectTriangulates({spiral(static_cast<int>(60 * turns), turns)});
}

TEST(Triangulate, Holes) {
  expectTriangulates({{{0, 0}, {3, 0}, {3, 3}, {0, 3}}, {{1, 1}, {1, 2}, {2, 2}, {2, 1}}});
  expectTriangulates(
      {{{0, 0}, {3, 0}, {3, 3}, {0, 3}}, {{1, 1}, {2, 1}, {2, 2}, {1, 2}}});  // either direction
  expectTriangulates({circle(60, 10, {0, 0}, true), circle(30, 3, {-4, 0}), circle(31, 3, {4, 0}, true),
                      circle(9, 2, {0, 6})});
  // A grid of holes, whose leftmost points share rows and columns.
  Loops grid{{{0, 0}, {40, 0}, {40, 40}, {0, 40}}};
  for (int j = 0; j < 20; ++j)
    for (int i = 0; i < 20; ++i)
      grid.push_back({{2.0 * i + 1, 2.0 * j + 0.5},
                      {2.0 * i + 1.5, 2.0 * j + 1},
                      {2.0 * i + 1, 2.0 * j + 1.5},
                      {2.0 * i + 0.5, 2.0 * j + 1}});
  expectTriangulates(grid);
  // Holes at random places of a random star, where they fit.
  std::mt19937 random(7);
  std::uniform_real_distribution<double> x(-0.3, 0.3);
  for (uint32_t seed = 0; seed < 50; ++seed) {
    std::vector<Point> outline = star(40, seed);
    for (Point& p : outline) p = p.normalized() * (0.5 + p.length());
    Loops loops{outline};
    std::vector<Point> centres;
    for (int k = 0; k < 12; ++k) {
      const Point c(x(random), x(random));
      bool fits = true;
      for (const Point& other : centres) fits = fits && (other - c).length() > 0.2;
      if (!fits) continue;
      centres.push_back(c);
      loops.push_back(circle(3 + k, 0.09, c, k % 2 == 1));
    }
    expectTriangulates(loops);
  }
}

TEST(Triangulate, HoleThatTouchesTheOutline) {
  // A vertex of the hole is a vertex of the outline.
  const Result r = run({{{0, 0}, {4, 0}, {4, 4}, {0, 4}}, {{0, 0}, {2, 1}, {1, 2}}});
  double sum = 0;
  for (const Triangle& t : r.triangles) sum += cross(r.points[t[0]], r.points[t[1]], r.points[t[2]]) / 2;
  EXPECT_NEAR(sum, 16 - 1.5, 1e-12);
}

TEST(Triangulate, CrossingAndDegenerateInputEnds) {
  EXPECT_FALSE(run({{{0, 0}, {1, 1}, {1, 0}, {0, 1}}}).simple);                            // a bow tie
  EXPECT_FALSE(run({{{0, 0}, {4, 0}, {4, 4}, {0, 4}}, {{5, 5}, {6, 5}, {6, 6}}}).simple);  // a hole outside
  EXPECT_TRUE(run({{{0, 0}, {1, 1}, {2, 2}, {3, 3}}}).triangles.empty());                  // no area
  EXPECT_TRUE(run({{{1, 1}, {1, 1}, {1, 1}}}).triangles.empty());
  const Result repeated = run({{{0, 0}, {0, 0}, {1, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}}});
  EXPECT_EQ(repeated.triangles.size(), 2u);
  EXPECT_TRUE(repeated.simple);
  std::mt19937 random(1);
  std::uniform_int_distribution<int> coordinate(0, 9);
  for (int n = 3; n < 300; ++n) {  // everything crosses and coincides
    std::vector<Point> loop, hole;
    for (int i = 0; i < n; ++i) loop.push_back({double(coordinate(random)), double(coordinate(random))});
    for (int i = 0; i < n % 7; ++i) hole.push_back({double(coordinate(random)), double(coordinate(random))});
    const Result r = run({loop, hole});
    EXPECT_LE(r.triangles.size(), loop.size() + hole.size() + 2);
  }
}

TEST(Triangulate, LargePolygonsTakeNoQuadraticTime) {
  // Seconds in all; a quadratic method takes minutes for any of these, and runs into the test's time limit.
  expectTriangulates({star(100000, 3)});
  expectTriangulates({comb(33000)});
  expectTriangulates({spiral(50000, 50)});
  std::mt19937 random(5);
  std::vector<Point> noise;
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 100000; ++i) noise.push_back({unit(random), unit(random)});
  EXPECT_FALSE(run({noise}).simple);
}

}  // namespace
}  // namespace patina
