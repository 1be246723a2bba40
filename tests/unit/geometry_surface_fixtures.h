// SPDX-License-Identifier: Apache-2.0
// What the tests of surfaces share: primitives made in place, collected messages, numerical derivatives, edge
// counts.
#pragma once

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "renderer/geometry/facet_rates.h"
#include "renderer/geometry/surface.h"

namespace patina::test {

struct Messages {
  std::vector<std::string> lines;
  ErrorHandler handler{[this](Severity, std::string_view line) { lines.emplace_back(line); }};
  bool mention(std::string_view text) const {
    for (const std::string& line : lines)
      if (line.find(text) != std::string::npos) return true;
    return false;
  }
  std::string all() const {
    std::string out;
    for (const std::string& line : lines) out += line + "\n";
    return out;
  }
};

inline PrimVar variable(std::string name, StorageClass storage, ValueType type, int components,
                        std::vector<float> floats) {
  PrimVar v;
  v.name = std::move(name);
  v.storage = storage;
  v.type = type;
  v.components = components;
  v.floats = std::move(floats);
  return v;
}

inline Primitive primitive(Shape shape, std::vector<float> P = {}) {
  Primitive p;
  p.shape = std::move(shape);
  p.where = {internFileName("test.rib"), 7, 3};
  if (!P.empty())
    p.variables.push_back(variable("P", StorageClass::Vertex, ValueType::Point, 3, std::move(P)));
  return p;
}

/// One loop per face.
inline PolygonMesh polygons(std::vector<int> sizes, std::vector<int> vertices) {
  return {std::vector<int>(sizes.size(), 1), std::move(sizes), std::move(vertices)};
}

/// A surface with the primitive that it refers to; made without any message.
struct Made {
  std::unique_ptr<Primitive> primitive;
  std::unique_ptr<Surface> surface;
  const Surface* operator->() const { return surface.get(); }
  const Surface& operator*() const { return *surface; }
  explicit operator bool() const { return surface != nullptr; }
};
inline Made make(Primitive p) {
  Messages messages;
  Made made{std::make_unique<Primitive>(std::move(p)), nullptr};
  made.surface = makeSurface(*made.primitive, messages.handler);
  EXPECT_TRUE(messages.lines.empty()) << messages.all();
  return made;
}

inline void expectNear(const V3f& a, const V3f& b, float tolerance, const std::string& what = {}) {
  EXPECT_LE((a - b).length(), tolerance) << what << ": " << a << " against " << b;
}

/// dPdu and dPdv against central differences (one-sided at the edges of the domain), N against their cross
/// product.
inline void expectDerivatives(const Surface& s, uint32_t face, float u, float v, float tolerance) {
  constexpr float h = 1.0f / 512;
  const SurfacePoint p = s.evaluate(face, u, v);
  const auto difference = [&](float du, float dv) {
    const float t = du != 0 ? u : v;
    const auto at = [&](float k) { return s.evaluate(face, u + k * h * du, v + k * h * dv).P; };
    if (t < 2 * h) return (at(1) * 4.0f - at(2) - at(0) * 3.0f) / (2 * h);
    if (t > 1 - 2 * h) return (at(-1) * 4.0f - at(-2) - at(0) * 3.0f) / (-2 * h);
    return (at(1) - at(-1)) / (2 * h);
  };
  const std::string where =
      "face " + std::to_string(face) + " at " + std::to_string(u) + ", " + std::to_string(v);
  expectNear(p.dPdu, difference(1, 0), tolerance, where + " dPdu");
  expectNear(p.dPdv, difference(0, 1), tolerance, where + " dPdv");
  EXPECT_NEAR(p.N.length(), 1, 1e-6f) << where;
  const V3f n = p.dPdu.cross(p.dPdv);
  if (n.length() > 1e-3f * std::max(p.dPdu.length2(), p.dPdv.length2())) {
    EXPECT_GT(p.N.dot(n.normalized()), 0.99999f) << where;
  }
}

/// Vertices by their bits.
struct Bits {
  uint32_t x, y, z;
  explicit Bits(const V3f& p) { std::memcpy(this, &p, sizeof(Bits)); }
  auto operator<=>(const Bits&) const = default;
};

/// A tessellation: vertices by tile.
struct Facets {
  SurfaceRates rates;
  std::vector<uint32_t> first;
  std::vector<V3f> vertices;

  Facets() = default;
  Facets(const Surface& s, SurfaceRates wanted) : rates(std::move(wanted)) {
    tessellate(s, rates, first, vertices);
    thinSides(rates, std::span<const uint32_t>(first), std::span(vertices));
  }
  /// visit(00, 10, 01, 11) for each facet.
  template <class Visit>
  void forEach(Visit visit) const {
    for (size_t tile = 0; tile < rates.tiles.size(); ++tile) {
      const TileRates& r = rates.tiles[tile];
      const size_t side = r.cellsU() + 1;
      for (size_t j = 0; j < r.cellsV(); ++j)
        for (size_t i = 0; i < r.cellsU(); ++i) {
          const V3f* p = &vertices[first[tile] + j * side + i];
          visit(p[0], p[1], p[side], p[side + 1]);
        }
    }
  }
};

/// `cells` facets, a power of two, along u and v of every face.
inline Facets uniformFacets(const Surface& s, uint32_t cells) {
  EXPECT_TRUE(std::has_single_bit(cells));
  return {s, uniformRates(s, static_cast<uint8_t>(std::countr_zero(cells)))};
}

/// The vertices of such a tessellation, (cells + 1)^2 a face.
inline std::vector<V3f> tessellated(const Surface& s, uint32_t cells) {
  Facets facets = uniformFacets(s, cells);
  EXPECT_EQ(facets.vertices.size(), s.faceCount() * size_t{cells + 1} * (cells + 1));
  return std::move(facets.vertices);
}

/// The number of tessellation edges that have no partner running the other way. 0 = watertight. Edges without
/// a length do not count.
inline size_t openEdges(const Facets& facets) {
  std::map<std::pair<Bits, Bits>, int> balance;
  const auto edge = [&](const V3f& a, const V3f& b) {
    const Bits p(a), q(b);
    if (p == q) return;
    if (p < q)
      ++balance[{p, q}];
    else
      --balance[{q, p}];
  };
  facets.forEach([&](const V3f& a, const V3f& b, const V3f& c, const V3f& d) {
    edge(a, b), edge(b, d), edge(d, c), edge(c, a);
  });
  size_t open = 0;
  for (const auto& [key, count] : balance) open += count != 0;
  return open;
}
inline size_t openEdges(const Surface& s, uint32_t cells) { return openEdges(uniformFacets(s, cells)); }

/// Volume inside a tessellation by the divergence theorem; positive when N points outwards.
inline double volume(const Surface& s, uint32_t cells) {
  double sum = 0;
  const auto add = [&](const V3f& a, const V3f& b, const V3f& c) {
    sum += V3d(a).dot(V3d(b).cross(V3d(c))) / 6;
  };
  uniformFacets(s, cells).forEach(
      [&](const V3f& a, const V3f& b, const V3f& c, const V3f& d) { add(a, b, d), add(a, d, c); });
  return sum;
}

}  // namespace patina::test
