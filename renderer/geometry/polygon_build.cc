// SPDX-License-Identifier: Apache-2.0
// From the polygons of a request to faces: checks, the choice of diagonals, triangulation and its messages.
#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <numeric>

#include "renderer/base/parallel.h"
#include "renderer/geometry/polygon_surface.h"
#include "renderer/geometry/triangulate.h"

namespace patina {
namespace {

/// Area vectors shorter than this times the squared longest edge count as zero.
constexpr double kNoArea = 1e-12;

/// Twice the area vector of a triangle; zero if the triangle is degenerate.
V3d areaVector(const V3f& a, const V3f& b, const V3f& c) {
  const V3d e(V3d(b) - V3d(a)), f(V3d(c) - V3d(a));
  const V3d n = e.cross(f);
  const double longest = std::max({e.length2(), f.length2(), (f - e).length2()});
  return n.length2() > kNoArea * kNoArea * longest * longest ? n : V3d(0);
}

/// Whether the quad 0123 can be cut along the diagonal 1-3 into triangles that face the same way.
bool cutsWell(const V3f& p0, const V3f& p1, const V3f& p2, const V3f& p3) {
  return areaVector(p0, p1, p3).dot(areaVector(p2, p3, p1)) > 0;
}

}  // namespace

struct PolygonSurface::Builder {
  const PolygonArrays& arrays;
  PointView points;
  std::vector<Face>& faces;

  /// What went wrong, how often, and with which polygon first.
  enum Trouble { BadIndex, BadPoint, TooFewVertices, NoArea, Crossing, kTroubles };
  std::array<size_t, kTroubles> count{};
  std::array<size_t, kTroubles> first{};
  Box3f bound;

  std::vector<Triangulator::Point> plane;
  std::vector<uint32_t> loops, corner;
  std::vector<Triangulator::Triangle> triangles;
  Triangulator triangulator;

  Builder(const PolygonArrays& a, PointView p, std::vector<Face>& f) : arrays(a), points(p), faces(f) {}

  void note(Trouble trouble, size_t polygon) {
    if (count[trouble]++ == 0) first[trouble] = polygon;
  }

  V3f point(uint32_t c) const { return points[static_cast<size_t>(arrays.vertices[c])]; }

  /// Checks a polygon's vertices; makes its part of the bound.
  bool check(size_t polygon, uint32_t begin, uint32_t end) {
    Box3f box;
    for (uint32_t c = begin; c < end; ++c) {
      const int vertex = arrays.vertices[c];
      if (vertex < 0 || static_cast<size_t>(vertex) >= points.size()) return note(BadIndex, polygon), false;
      const V3f p = points[static_cast<size_t>(vertex)];
      if (!usable(p)) return note(BadPoint, polygon), false;
      box.extendBy(p);
    }
    bound.extendBy(box);
    return true;
  }

  void addPolygon(uint32_t polygon, uint32_t begin, std::span<const int> loopSizes) {
    uint32_t end = begin;
    for (int n : loopSizes) end += static_cast<uint32_t>(n);
    if (loopSizes.empty() || loopSizes[0] < 3) return note(TooFewVertices, polygon);
    if (!check(polygon, begin, end)) return;
    const size_t before = faces.size();
    if (loopSizes.size() == 1 && loopSizes[0] == 3)
      addTriangle(polygon, begin, begin + 1, begin + 2);
    else if (loopSizes.size() > 1 || loopSizes[0] > 4 || !addQuad(polygon, begin))
      triangulate(polygon, begin, loopSizes);
    if (faces.size() == before) note(NoArea, polygon);
  }

  void addTriangle(uint32_t polygon, uint32_t a, uint32_t b, uint32_t c) {
    if (areaVector(point(a), point(b), point(c)) != V3d(0)) faces.push_back({{a, b, c}, polygon});
  }

  bool addQuad(uint32_t polygon, uint32_t c) {
    const V3f p[4] = {point(c), point(c + 1), point(c + 2), point(c + 3)};
    uint32_t turn = 0;
    if (!cutsWell(p[0], p[1], p[2], p[3])) {
      if (!cutsWell(p[1], p[2], p[3], p[0])) return false;
      turn = 1;
    }
    faces.push_back({{c, kQuad, turn}, polygon});
    return true;
  }

  void triangulate(uint32_t polygon, uint32_t begin, std::span<const int> loopSizes) {
    const auto size = static_cast<uint32_t>(loopSizes[0]);
    V3d normal(0);  // Newell's
    const V3d origin(point(begin));
    for (uint32_t i = 1; i + 1 < size; ++i)
      normal += (V3d(point(begin + i)) - origin).cross(V3d(point(begin + i + 1)) - origin);
    loops.assign(loopSizes.begin(), loopSizes.end());
    const uint32_t end = begin + std::accumulate(loops.begin(), loops.end(), 0u);

    // Dropping a coordinate keeps the floats exact. A polygon that is far from plane may cross itself that
    // way and yet be simple as seen along its normal.
    const double nx = std::abs(normal.x), ny = std::abs(normal.y), nz = std::abs(normal.z);
    const int drop = nx > ny && nx > nz ? 0 : ny > nz ? 1 : 2;
    plane.clear();
    for (uint32_t c = begin; c < end; ++c)
      plane.emplace_back(point(c)[(drop + 1) % 3], point(c)[(drop + 2) % 3]);
    triangles.clear();
    if (!triangulator.run(plane, loops, triangles) && normal != V3d(0)) {
      const Frame frame(V3f(normal.normalized()));
      const V3d x(frame.x), y(frame.y);
      plane.clear();
      for (uint32_t c = begin; c < end; ++c) {
        const V3d p = V3d(point(c)) - origin;
        plane.emplace_back(p.dot(x), p.dot(y));
      }
      const size_t before = triangles.size();
      const bool simple = triangulator.run(plane, loops, triangles);
      if (simple)
        triangles.erase(triangles.begin(), triangles.begin() + static_cast<ptrdiff_t>(before));
      else
        triangles.resize(before);
      if (!simple && before > 0) note(Crossing, polygon);
    } else if (normal == V3d(0) && !triangles.empty()) {
      note(Crossing, polygon);
    }
    for (const auto& t : triangles) addTriangle(polygon, begin + t[0], begin + t[1], begin + t[2]);
  }

  /// Whether every polygon has one loop of `sides` vertices.
  bool isUniform(uint32_t sides) const {
    const auto all = [](std::span<const int> counts, int value) {
      return std::all_of(counts.begin(), counts.end(), [value](int n) { return n == value; });
    };
    return all(arrays.loopsPerFace, 1) &&
           (arrays.sides == static_cast<int>(sides) ||
            (arrays.sides == 0 && all(arrays.vertsPerLoop, static_cast<int>(sides))));
  }

  /// Whether every polygon, of `sides` vertices, is one good face as it is; makes the bound then.
  bool allGood(uint32_t sides) {
    struct Part {
      Box3f bound;
      bool good = true;
    };
    const auto check = [&](const tbb::blocked_range<uint32_t>& range, Part part) {
      for (uint32_t polygon = range.begin(); polygon < range.end() && part.good; ++polygon) {
        V3f p[4];
        for (uint32_t k = 0; k < sides && part.good; ++k) {
          const int vertex = arrays.vertices[polygon * sides + k];
          part.good = vertex >= 0 && static_cast<size_t>(vertex) < points.size();
          if (!part.good) break;
          part.bound.extendBy(p[k] = points[static_cast<size_t>(vertex)]);
          part.good = usable(p[k]);
        }
        part.good = part.good &&
                    (sides == 3 ? areaVector(p[0], p[1], p[2]) != V3d(0) : cutsWell(p[0], p[1], p[2], p[3]));
      }
      return part;
    };
    const auto both = [](Part a, const Part& b) {
      a.bound.extendBy(b.bound);
      a.good = a.good && b.good;
      return a;
    };
    // The caller may hold locks that tasks of others wait for.
    constexpr uint32_t kGrain = 16384;
    const tbb::blocked_range<uint32_t> all(0, static_cast<uint32_t>(arrays.faceCount()), kGrain);
    const Part whole = all.size() < 2 * kGrain ? check(all, Part()) : tbb::this_task_arena::isolate([&] {
      return parallelReduce(all, Part(), check, both);
    });
    bound = whole.bound;
    return whole.good;
  }

  /// Triangles some of which are not good: those that are.
  void keepTriangles(std::vector<uint32_t>& kept) {
    for (uint32_t polygon = 0; polygon < arrays.faceCount(); ++polygon) {
      const uint32_t c = 3 * polygon;
      if (!check(polygon, c, c + 3)) continue;
      if (areaVector(point(c), point(c + 1), point(c + 2)) == V3d(0))
        note(NoArea, polygon);
      else
        kept.push_back(polygon);
    }
    kept.shrink_to_fit();
  }

  void addAll() {
    size_t faceEstimate = arrays.vertices.size() - std::min(arrays.vertices.size(), 2 * arrays.faceCount());
    faces.reserve(faceEstimate);
    size_t loop = 0;
    uint32_t begin = 0;
    std::vector<int> sizes;
    for (size_t polygon = 0; polygon < arrays.faceCount(); ++polygon) {
      const auto n =
          arrays.loopsPerFace.empty() ? size_t{1} : static_cast<size_t>(arrays.loopsPerFace[polygon]);
      sizes.clear();
      for (size_t k = 0; k < n; ++k) sizes.push_back(arrays.loopSize(loop + k));
      addPolygon(static_cast<uint32_t>(polygon), begin, sizes);
      for (int size : sizes) begin += static_cast<uint32_t>(size);
      loop += n;
    }
    if (faces.capacity() > faces.size() + faces.size() / 8) faces.shrink_to_fit();
  }

  void report(const Location& where, ErrorHandler& errors) const {
    static constexpr std::array<const char*, kTroubles> kText{
        "use a vertex that \"P\" does not have", "have a point that is not finite",
        "have fewer than 3 vertices", "have no area",
        "cross themselves or have a hole outside; their triangulation is a guess"};
    const size_t polygons = arrays.faceCount();
    for (size_t t = 0; t < kTroubles; ++t) {
      if (count[t] == 0) continue;
      const bool bad = t == BadIndex || t == BadPoint;
      errors.report(bad ? Severity::Error : Severity::Warning, bad ? RiError::Range : RiError::BadArgument,
                    where,
                    fmt::format("{} of {} polygons {} (first: number {}){}", count[t], polygons, kText[t],
                                first[t], t == Crossing ? "" : "; left out"),
                    kText[t]);
    }
  }
};

namespace {

/// The arrays' sums fit each other.
bool consistent(const PolygonArrays& arrays) {
  size_t loops = 0, vertices = 0;
  for (int n : arrays.loopsPerFace) {
    if (n < 0) return false;
    loops += static_cast<size_t>(n);
  }
  for (int n : arrays.vertsPerLoop) {
    if (n < 0) return false;
    vertices += static_cast<size_t>(n);
  }
  if (arrays.sides > 0) vertices = arrays.loopCount() * static_cast<size_t>(arrays.sides);
  return (arrays.loopsPerFace.empty() || loops == arrays.loopCount()) && vertices == arrays.vertices.size() &&
         vertices < size_t{1} << 31;
}

}  // namespace

std::unique_ptr<PolygonSurface> PolygonSurface::make(const PolygonArrays& arrays, const Primitive& primitive,
                                                     ErrorHandler& errors) {
  const auto points = findPoints(primitive);
  if (!points) {
    errors.report(Severity::Error, RiError::MissingData, primitive.where, "polygons need \"P\"");
    return nullptr;
  }
  if (!consistent(arrays)) {
    errors.report(Severity::Error, RiError::Consistency, primitive.where,
                  "the polygons' numbers of loops and vertices do not add up to the vertices given");
    return nullptr;
  }
  std::unique_ptr<PolygonSurface> surface(new PolygonSurface(arrays, *points));
  const uint32_t sides = arrays.loopCount() == 0 ? 0 : static_cast<uint32_t>(arrays.loopSize(0));
  Builder builder(arrays, *points, surface->faces_);
  const bool uniform = (sides == 3 || sides == 4) && builder.isUniform(sides);
  if (uniform && sides == 3) surface->sides_ = 3;
  if (uniform && builder.allGood(sides)) {
    surface->sides_ = sides;
  } else {
    builder.bound = {};
    if (surface->sides_ == 3)
      builder.keepTriangles(surface->kept_);
    else
      builder.addAll();
    if (surface->kept_.empty()) surface->sides_ = 0;
    builder.report(primitive.where, errors);
  }
  surface->bound_ = builder.bound;
  if (surface->faceCount() == 0) {
    errors.report(Severity::Error, RiError::BadArgument, primitive.where, "no polygon with an area is left");
    return nullptr;
  }
  surface->memory_ = sizeof(PolygonSurface) + surface->faces_.capacity() * sizeof(Face) +
                     surface->kept_.capacity() * sizeof(uint32_t);
  return surface;
}

}  // namespace patina
