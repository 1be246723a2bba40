// SPDX-License-Identifier: Apache-2.0
// Blobby: fields against closed forms and differences, bounds, closed meshes on the surface, shares of
// values.
#include <gmock/gmock.h>

#include <random>

#include "geometry_surface_fixtures.h"
#include "renderer/geometry/blobby_surface.h"

namespace patina::test {
namespace {

using testing::HasSubstr;
using Op = Blobby::Op;

/// Programs made in place; the functions return the number of the instruction.
struct Program {
  Blobby blobby;
  uint32_t field(Op op, const std::vector<float>& values) {
    blobby.instructions.push_back(
        {op, static_cast<uint32_t>(blobby.floats.size()), static_cast<uint32_t>(values.size())});
    blobby.floats.insert(blobby.floats.end(), values.begin(), values.end());
    ++blobby.leaves;
    return static_cast<uint32_t>(blobby.instructions.size() - 1);
  }
  uint32_t sphere(float x, float y, float z, float r = 1) {
    return field(Op::Ellipsoid, {r, 0, 0, 0, 0, r, 0, 0, 0, 0, r, 0, x, y, z, 1});
  }
  uint32_t segment(const V3f& p, const V3f& q, float r) {
    return field(Op::Segment,
                 {p.x, p.y, p.z, q.x, q.y, q.z, r, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
  }
  uint32_t combine(Op op, std::initializer_list<uint32_t> operands) {
    blobby.instructions.push_back(
        {op, static_cast<uint32_t>(blobby.operands.size()), static_cast<uint32_t>(operands.size())});
    blobby.operands.insert(blobby.operands.end(), operands);
    return static_cast<uint32_t>(blobby.instructions.size() - 1);
  }
  BlobbyField made() const {
    size_t spoiled = 0;
    BlobbyField f(blobby, spoiled);
    EXPECT_EQ(spoiled, 0u);
    return f;
  }
  BlobbyMesh mesh(double cell, bool weights = false) const {
    BlobbyMesh m;
    EXPECT_EQ(meshBlobby(made(), cell, weights, {}, m), BlobbyMeshStatus::Done);
    return m;
  }
};

double valueAt(const BlobbyField& f, const V3d& p) {
  BlobbyField::Scratch scratch;
  return f.value(f.everywhere(), p, scratch);
}

/// Every edge has one triangle in each direction; returns vertices - edges + triangles (2 for a ball).
int expectClosed(const BlobbyMesh& m) {
  std::map<std::pair<uint32_t, uint32_t>, int> edges;
  for (const auto& t : m.triangles)
    for (size_t k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
  size_t bad = 0;
  for (const auto& [edge, count] : edges) {
    const auto back = edges.find({edge.second, edge.first});
    bad += count != 1 || back == edges.end() || back->second != 1;
  }
  EXPECT_EQ(bad, 0u) << "of " << edges.size();
  return static_cast<int>(m.vertices.size()) - static_cast<int>(edges.size() / 2) +
         static_cast<int>(m.triangles.size());
}

double volumeOf(const BlobbyMesh& m) {
  double sum = 0;
  for (const auto& t : m.triangles)
    sum += V3d(m.vertices[t[0]].P).dot(V3d(m.vertices[t[1]].P).cross(V3d(m.vertices[t[2]].P))) / 6;
  return sum;
}

/// One of everything, overlapping.
Program everything() {
  Program p;
  const uint32_t a = p.sphere(0, 0, 0.2f), b = p.sphere(0.5f, 0.1f, 0.3f, 0.8f);
  const uint32_t s = p.segment({-0.5f, -0.2f, 0.1f}, {0.6f, 0.5f, 0.6f}, 0.7f);
  const uint32_t e = p.field(
      Op::Ellipsoid, {0.9f, 0.2f, 0, 0, -0.1f, 0.5f, 0.3f, 0, 0.2f, 0, 1.1f, 0, -0.3f, 0.2f, 0.4f, 1});
  const uint32_t c = p.field(Op::Constant, {0.25f});
  const uint32_t plane = p.field(Op::Plane, {0.5f, 0.02f, 0.2f, 0.3f});
  const uint32_t sum = p.combine(Op::Add, {a, s, plane});
  const uint32_t product = p.combine(Op::Multiply, {b, e});
  const uint32_t most = p.combine(Op::Maximum, {sum, product, e});
  const uint32_t least = p.combine(Op::Minimum, {most, p.combine(Op::Add, {a, b, e, s})});
  const uint32_t quotient = p.combine(Op::Divide, {least, p.combine(Op::Add, {c, b})});
  p.combine(Op::Subtract,
            {p.combine(Op::Identity, {quotient}), p.combine(Op::Negate, {p.combine(Op::Multiply, {a, e})})});
  return p;
}

TEST(BlobbyField, EllipsoidsAreTheBump) {
  Program p;
  p.field(Op::Ellipsoid, {2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0.5f, 0, 1, 2, 3, 1});
  const BlobbyField f = p.made();
  const auto at = [&](double x, double y, double z) { return valueAt(f, {1 + 2 * x, 2 + y, 3 + z / 2}); };
  EXPECT_EQ(at(0, 0, 0), 1);
  EXPECT_NEAR(at(0.3, 0.4, 0), Blobby::kThreshold, 1e-15);  // at half the radius
  EXPECT_NEAR(at(0, 0.6, 0.6), std::pow(1 - 0.72, 3), 1e-15);
  EXPECT_EQ(at(0.6, 0.8, 0.1), 0);
}

TEST(BlobbyField, SegmentsAreTheBumpIntegrated) {
  // Against the integral by Simpson's rule, of which each piece of the line has its share.
  const V3d from(-0.3, 0.2, 0.1), to(0.9, 1.1, -0.4);
  constexpr double kRadius = 0.6;
  Program p;
  p.segment(V3f(from), V3f(to), static_cast<float>(kRadius));
  const BlobbyField f = p.made();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1.2, 1.8);
  for (int k = 0; k < 200; ++k) {
    const V3d x(uniform(random), uniform(random), uniform(random));
    constexpr int kSteps = 20000;
    double sum = 0;
    for (int i = 0; i <= kSteps; ++i) {
      const double squared =
          (x - (from + (to - from) * (static_cast<double>(i) / kSteps))).length2() / (kRadius * kRadius);
      if (squared < 1) sum += std::pow(1 - squared, 3) * (i == 0 || i == kSteps ? 1 : i % 2 == 1 ? 4 : 2);
    }
    sum *= (to - from).length() / kSteps / 3 / kRadius * 35 / 32;
    EXPECT_NEAR(valueAt(f, x), sum, 1e-6) << x;  // float's end points
  }
}

TEST(BlobbyField, SegmentsEndToEndAddUpToOne) {
  Program whole, parts;
  whole.segment({0, 0, 0}, {3, 0, 0}, 1);
  parts.combine(Op::Add, {parts.segment({0, 0, 0}, {1, 0, 0}, 1), parts.segment({1, 0, 0}, {1.25f, 0, 0}, 1),
                          parts.segment({3, 0, 0}, {1.25f, 0, 0}, 1)});
  const BlobbyField f = whole.made(), g = parts.made();
  EXPECT_NEAR(valueAt(f, {1.5, 0, 0}), 1, 1e-14);
  for (double x = -1; x < 4; x += 0.37)
    for (double y = -1; y < 1; y += 0.23)
      EXPECT_NEAR(valueAt(f, {x, y, 0.1}), valueAt(g, {x, y, 0.1}), 1e-13);
  Program dot;  // without a length: a ball
  dot.segment({1, 0, 0}, {1, 0, 0}, 2);
  EXPECT_NEAR(valueAt(dot.made(), {1, 0, 1}), Blobby::kThreshold, 1e-15);
}

TEST(BlobbyField, PlanesHaveTheProfileOfTheNote) {
  Program p;
  p.field(Op::Plane, {0.4f, 0.01f, 0.3f, 0.08f});  // RI 3.2's example
  const BlobbyField f = p.made();
  EXPECT_EQ(valueAt(f, {5, 6, 0.5}), 0);
  // z = C: the bump is 1; ease(3/4) = 27/32.
  EXPECT_NEAR(valueAt(f, {5, 6, 0.3}), (0.08 - 0.01 / 0.3) * (5.0 / 32), 1e-8);
  EXPECT_NEAR(valueAt(f, {5, 6, -2}), -0.01 / 1e-6, 1e-3);
}

TEST(BlobbyField, GradientsAreTheDifferences) {
  const BlobbyField f = everything().made();
  BlobbyField::Scratch scratch;
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(-0.8, 1);
  for (int k = 0; k < 500; ++k) {
    const V3d x(uniform(random), uniform(random), 0.55 + 0.4 * uniform(random));
    const BlobbyField::Jet jet = f.jet(f.everywhere(), x, scratch);
    EXPECT_EQ(jet.value, valueAt(f, x));
    constexpr double kStep = 1e-6;
    for (int c = 0; c < 3; ++c) {
      V3d d(0, 0, 0);
      d[c] = kStep;
      const double ahead = valueAt(f, x + d) - jet.value, behind = jet.value - valueAt(f, x - d);
      if (std::abs(ahead - behind) > 1e-9 * (1 + std::abs(jet.value))) continue;  // a crease of min or max
      EXPECT_NEAR(jet.gradient[c], (ahead + behind) / (2 * kStep), 1e-5 * (1 + jet.gradient.length())) << x;
    }
  }
}

TEST(BlobbyField, PartsGiveTheSameBitsWithinTheirBounds) {
  const BlobbyField f = everything().made();
  BlobbyField::Scratch scratch;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0, 1);
  size_t shorter = 0;
  for (int k = 0; k < 3000; ++k) {
    BlobbyBox box;
    const double size = std::pow(2.0, -6 * uniform(random));
    for (Range& axis : box.axis) {
      axis.low = 3 * uniform(random) - 1.5;
      axis.high = axis.low + size;
    }
    BlobbyTape part, inner;
    const Range range = f.restrict(f.everywhere(), box, part, scratch);
    shorter += part.items.size() < f.everywhere().items.size() / 2;
    BlobbyBox half = box;
    half.axis[0].high = (box.axis[0].low + box.axis[0].high) / 2;
    f.restrict(part, half, inner, scratch);
    for (int i = 0; i < 8; ++i) {
      V3d x;
      for (int c = 0; c < 3; ++c) {
        const double t = i < 4 ? static_cast<double>((i + c) % 2) : uniform(random);
        x[c] = t == 1 ? box.axis[c].high : box.axis[c].low + t * size;
      }
      const double value = valueAt(f, x);
      EXPECT_EQ(f.value(part, x, scratch), value);
      EXPECT_GE(value, range.low);
      EXPECT_LE(value, range.high);
      x.x = std::min(x.x, half.axis[0].high);
      EXPECT_EQ(f.value(inner, x, scratch), valueAt(f, x));
    }
  }
  EXPECT_GT(shorter, 1000u);
}

TEST(BlobbyMesh, OneFieldIsItsEllipsoidAtHalfTheRadius) {
  Program p;
  p.field(Op::Ellipsoid, {2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1.5f, 0, 1, 2, 3, 1});
  constexpr double kCell = 0.1;
  const BlobbyMesh m = p.mesh(kCell);
  EXPECT_EQ(expectClosed(m), 2);
  for (const BlobbyMesh::Vertex& v : m.vertices) {
    const V3d q((static_cast<double>(v.P.x) - 1) / 2, static_cast<double>(v.P.y) - 2,
                (static_cast<double>(v.P.z) - 3) / 1.5);
    EXPECT_NEAR(q.length(), 0.5, 2e-3 * kCell);  // vertices keep a thousandth of the edge from its ends
    const V3d n = V3d(q.x / 2, q.y, q.z / 1.5).normalized();
    EXPECT_GT(n.dot(V3d(v.N)), 1 - 1e-6);
  }
  EXPECT_NEAR(volumeOf(m), 4 * std::numbers::pi / 3 * 1 * 0.5 * 0.75, 0.02);
}

TEST(BlobbyMesh, OnTheThresholdAndClosed) {
  Program merging;
  merging.combine(Op::Add, {merging.sphere(-0.5f, 0, 0), merging.sphere(0.5f, 0, 0)});
  Program apart;
  apart.combine(Op::Add, {apart.sphere(-1, 0, 0), apart.sphere(1, 0, 0)});
  Program bored;  // a ball with a segment out of it: a ring
  bored.combine(Op::Subtract, {bored.sphere(0, 0, 0, 2), bored.segment({0, 0, -3}, {0, 0, 3}, 0.9f)});
  Program hollow;  // a shell: two spheres
  hollow.combine(Op::Subtract, {hollow.sphere(0, 0, 0, 2), hollow.sphere(0, 0, 0, 0.8f)});
  Program creased;
  creased.combine(Op::Maximum, {creased.sphere(-0.3f, 0, 0), creased.sphere(0.3f, 0, 0)});
  Program hole;  // inside all around: the surface of a bubble
  hole.combine(Op::Subtract, {hole.field(Op::Constant, {1}), hole.sphere(0, 0, 0)});
  struct Case {
    Program* program;
    int euler;
  };
  for (const auto& [program, euler] : {Case{&merging, 2}, Case{&apart, 4}, Case{&bored, 0}, Case{&hollow, 4},
                                       Case{&creased, 2}, Case{&hole, 2}}) {
    const BlobbyMesh m = program->mesh(0.07);
    EXPECT_EQ(expectClosed(m), euler);
    const BlobbyField f = program->made();
    for (const BlobbyMesh::Vertex& v : m.vertices)
      EXPECT_NEAR(valueAt(f, V3d(v.P)), Blobby::kThreshold, 1e-3);
    EXPECT_EQ(volumeOf(m) > 0, program != &hole);
  }
}

TEST(BlobbyMesh, OnTidyNumbersAndFarAway) {
  // Lattice points on the surface, and coordinates of which a float has few digits left.
  for (const float at : {0.0f, 100.0f, 30000.0f}) {
    Program p;
    p.combine(Op::Add, {p.sphere(at, 0, 0), p.sphere(at + 0.5f, 0, 0)});
    EXPECT_EQ(expectClosed(p.mesh(1.0 / 16)), 2);
  }
}

TEST(BlobbyMesh, AChainOfThousandsOfFields) {
  Program p;
  constexpr int kCount = 3000;
  std::vector<uint32_t> all;
  for (int k = 0; k < kCount; ++k) {
    const auto a = static_cast<float>(k) * 0.02f;
    all.push_back(p.sphere(10 * std::cos(a), 10 * std::sin(a), a, 0.9f));
  }
  p.blobby.instructions.push_back({Op::Add, 0, kCount});
  p.blobby.operands = all;
  BlobbyMesh m;
  ASSERT_EQ(meshBlobby(p.made(), 0.2, false, {}, m), BlobbyMeshStatus::Done);
  EXPECT_EQ(expectClosed(m), 2);  // one worm
}

TEST(BlobbyMesh, EndsAtTheBoundsOfTheOthersWhereAPlaneHasNone) {
  Program p;  // a field of the plane that is inside everywhere below it
  p.combine(Op::Add, {p.sphere(0, 0, 0), p.field(Op::Plane, {0.3f, -1, 0.1f, 0})});
  const BlobbyMesh m = p.mesh(0.1);
  expectClosed(m);
  EXPECT_GT(volumeOf(m), 4);  // the lower half of the box around the ball, about 2 x 2 x 1.1
  Program cut;                // as in RI 3.2: the plane keeps the ball off
  cut.combine(Op::Add, {cut.sphere(0, 0, -0.1f, 1.5f), cut.field(Op::Plane, {0.4f, 0.01f, 0.3f, 0.08f})});
  const BlobbyMesh dome = cut.mesh(0.05);
  EXPECT_EQ(expectClosed(dome), 2);
  for (const BlobbyMesh::Vertex& v : dome.vertices) EXPECT_GT(v.P.z, 0);
}

TEST(BlobbySurface, FacesPointsAndNormals) {
  Program p;
  p.sphere(0, 0, 0);
  const auto s = make(primitive(p.blobby));
  ASSERT_GT(s->faceCount(), 100u);
  EXPECT_TRUE(s->isFlat());
  EXPECT_TRUE(s->hasSmoothNormals());
  for (uint32_t face = 0; face < s->faceCount(); face += 7) {
    V3f c[4];
    s->corners(face, c);
    for (int k = 0; k < 3; ++k) {
      const SurfacePoint at = s->evaluate(face, static_cast<float>(k == 1), static_cast<float>(k == 2));
      EXPECT_EQ(at.P, c[k]);
      expectNear(at.N, c[k].normalized(), 1e-4f);
    }
    const SurfacePoint middle = s->evaluate(face, 0.3f, 0.3f);
    EXPECT_NEAR(middle.N.length(), 1, 1e-6f);
    EXPECT_GT(middle.N.dot(middle.P.normalized()), 0.999f);
    EXPECT_EQ(s->surfaceParameters(face, 0.3f, 0.3f), V2f(middle.P.x, middle.P.y));
    EXPECT_EQ(middle.dPdu, c[1] - c[0]);
    if (middle.dPdu.cross(middle.dPdv).length() > 1e-5f) {
      EXPECT_GT(middle.dPdu.cross(middle.dPdv).normalized().dot(middle.N), 0.9f);
    }
  }
  expectNear(s->bound().max, V3f(0.5f), 5e-3f);
}

TEST(BlobbySurface, FinerFromNear) {
  Program p;
  p.sphere(0, 0, 0);
  const Primitive made = primitive(p.blobby);
  Messages messages;
  size_t before = 0;
  for (const float distance : {1000.0f, 100.0f, 10.0f, 2.0f}) {
    Viewpoint view;
    view.eye = {0, 0, -distance};
    view.pixels = 500;
    const auto s = makeSurface(made, messages.handler, view);
    ASSERT_TRUE(s);
    EXPECT_GT(s->faceCount(), 2 * before) << distance;
    before = s->faceCount();
  }
  EXPECT_LT(before, 200000u);
  EXPECT_TRUE(messages.lines.empty()) << messages.all();
}

TEST(BlobbySurface, ValuesGoToFieldsByTheirShares) {
  const auto value = [](const Program& p, const V3d& x) {
    const BlobbyField f = p.made();
    BlobbyField::Scratch scratch;
    std::vector<LeafWeight> shares;
    f.weights(f.everywhere(), x, scratch, shares);
    std::map<uint32_t, double> result;
    for (const LeafWeight& w : shares) result[w.leaf] += static_cast<double>(w.weight);
    return result;
  };
  using Map = std::map<uint32_t, double>;
  const auto near = [](const Map& a, const Map& b) {
    for (uint32_t k = 0; k < 4; ++k) {
      const auto get = [&](const Map& m) { return m.contains(k) ? m.at(k) : 0.0; };
      EXPECT_NEAR(get(a), get(b), 1e-6) << k;
    }
  };
  const double half = std::pow(0.75, 3), far = std::pow(1 - 0.5625, 3);  // fields at 1/2 and 3/4
  const V3d x(0.5, 0, 0);
  const auto two = [](Op op) {
    Program p;
    const uint32_t a = p.sphere(0, 0, 0), b = p.sphere(1.25f, 0, 0);
    p.combine(op, {a, b});
    return p;
  };
  near(value(two(Op::Add), x), {{0, half / (half + far)}, {1, far / (half + far)}});
  near(value(two(Op::Multiply), x), {{0, half / (half + far)}, {1, far / (half + far)}});
  near(value(two(Op::Maximum), x), {{0, 1}});
  near(value(two(Op::Minimum), x), {{1, 1}});
  near(value(two(Op::Subtract), x), {{0, 1}});
  near(value(two(Op::Divide), x), {{0, 1}});

  Primitive made = primitive(two(Op::Add).blobby);
  made.variables.push_back(variable("Cs", StorageClass::Vertex, ValueType::Color, 3, {1, 0, 0, 0, 0, 1}));
  made.variables.push_back(variable("one", StorageClass::Varying, ValueType::Float, 1, {1, 1}));
  made.variables.push_back(variable("k", StorageClass::Uniform, ValueType::Float, 1, {7}));
  const auto s = make(std::move(made));
  for (uint32_t face = 0; face < s->faceCount(); ++face) {
    float color[3], one = 0, k = 0;
    s->interpolate(s.primitive->variables[0], face, 0.2f, 0.5f, color);
    s->interpolate(s.primitive->variables[1], face, 0.2f, 0.5f, &one);
    s->interpolate(s.primitive->variables[2], face, 0.2f, 0.5f, &k);
    EXPECT_NEAR(color[0] + color[2], 1, 1e-6f);
    EXPECT_NEAR(one, 1, 1e-6f);
    EXPECT_EQ(k, 7);
    const float px = s->evaluate(face, 0.2f, 0.5f).P.x;
    if (px < 0.2f) {
      EXPECT_GT(color[0], 0.999f);
    }
    if (px > 1.05f) {
      EXPECT_GT(color[2], 0.999f);
    }
  }
}

TEST(BlobbySurface, LimitsHold) {
  Program p;
  p.combine(Op::Add, {p.sphere(0, 0, 0), p.sphere(0.5f, 0, 0)});
  Primitive made = primitive(p.blobby);
  Messages messages;
  Viewpoint view;
  view.eye = {0, 0, -2};
  view.pixels = 5000;
  BlobbyMeshLimits limits;
  limits.cells = 3000;
  const auto s = BlobbySurface::make(p.blobby, made, view, messages.handler, limits);
  ASSERT_TRUE(s);
  EXPECT_TRUE(messages.mention("times as large as the picture asks for")) << messages.all();
  EXPECT_LE(s->mesh().cells, 3000u);
  EXPECT_GT(s->mesh().cells, 500u);
  EXPECT_EQ(expectClosed(s->mesh()), 2);
  limits.work = 100;
  EXPECT_FALSE(BlobbySurface::make(p.blobby, made, view, messages.handler, limits));
  EXPECT_TRUE(messages.mention("error: limitcheck: Blobby is left out: too many of its fields"))
      << messages.all();
}

TEST(BlobbySurface, ASmallPictureHasFewCells) {
  Program p;
  p.combine(Op::Add, {p.sphere(0, 0, 0), p.sphere(0.5f, 0, 0)});
  Primitive made = primitive(p.blobby);
  Messages messages;
  Viewpoint view;
  view.eye = {0, 0, -2};
  view.pixels = 3e4f;
  BlobbyMeshLimits limits;
  limits.cells = 100000;
  view.pixelCount = 640 * 480;
  const auto fine = BlobbySurface::make(p.blobby, made, view, messages.handler, limits);
  view.pixelCount = 16 * 16;
  const auto coarse = BlobbySurface::make(p.blobby, made, view, messages.handler, limits);
  ASSERT_TRUE(fine && coarse);
  EXPECT_GT(fine->mesh().cells, 70000u);
  EXPECT_LE(coarse->mesh().cells, 65536u);
  EXPECT_GT(coarse->mesh().cells, 40000u);
}

TEST(BlobbySurface, WhatIsTooThinToBeMetAsksForNoCells) {
  Viewpoint view;
  view.eye = {0, 0, -4};
  view.pixels = 1000;
  Messages messages;
  const auto cells = [&](const Program& p) {
    const Primitive made = primitive(p.blobby);
    const auto s = BlobbySurface::make(p.blobby, made, view, messages.handler);
    return s ? s->mesh().cells : 0;
  };
  Program one, two;
  one.sphere(0, 0, 0);
  two.combine(Op::Add, {two.sphere(0, 0, 0),
                        two.field(Op::Ellipsoid, {1, 0, 0, 0, 0, 1e-30f, 0, 0, 0, 0, 1, 0, 0, 0.6f, 0, 1})});
  EXPECT_GT(cells(one), 100u);
  EXPECT_LT(cells(two), 2 * cells(one));
  // A thousandth of a pixel, all of it: still a ball, and nothing to complain of.
  Program small;
  small.sphere(0, 0, 0, 1e-5f);
  EXPECT_GT(cells(small), 4u);
  EXPECT_TRUE(messages.lines.empty()) << messages.all();
}

TEST(BlobbyField, NeedlesAndDiscsTellTheirArea) {
  for (const float length : {1e-3f, 1e3f}) {
    Program p;
    p.field(Op::Ellipsoid, {1, 0, 0, 0, 0, length, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
    const double a = 0.5, b = 0.5 * static_cast<double>(length);
    // A disc's two sides; a needle's girth, narrower towards its ends: pi/4 of a cylinder's.
    const double area = b < a ? 2 * std::numbers::pi * a * a : std::numbers::pi * std::numbers::pi * a * b;
    EXPECT_NEAR(p.made().details()[0].area / area, 1, 0.02) << length;
  }
}

TEST(BlobbySurface, WithoutASurfaceOrANumberItSaysSo) {
  const auto report = [](const Program& p) {
    Messages messages;
    makeSurface(primitive(p.blobby), messages.handler);
    return messages.all();
  };
  Program constant;
  constant.field(Op::Constant, {1});
  EXPECT_THAT(report(constant), HasSubstr("warning: badargument: Blobby is left out: its field is nowhere"));
  Program faint;
  faint.combine(Op::Multiply, {faint.sphere(0, 0, 0), faint.field(Op::Constant, {0.1f})});
  EXPECT_THAT(report(faint), HasSubstr("its field is nowhere"));
  Program singular;
  singular.combine(Op::Add, {singular.sphere(0, 0, 0, 0), singular.segment({0, 0, 0}, {1, 0, 0}, -1),
                             singular.sphere(0, 0, 0, 1e20f), singular.sphere(0, 0, 0)});
  EXPECT_THAT(report(singular), HasSubstr("math: Blobby: 3 of its fields count as 0"));
  Program huge;  // overflow on the way is cut, not passed on
  const uint32_t most = huge.field(Op::Constant, {3e38f}), ball = huge.sphere(0, 0, 0);
  huge.combine(Op::Subtract, {huge.combine(Op::Multiply, {most, most, most, ball}),
                              huge.combine(Op::Multiply, {most, most, most})});
  for (const BlobbyMesh::Vertex& v : huge.mesh(0.1).vertices) EXPECT_TRUE(isFinite(v.P) && isFinite(v.N));
  for (const float size : {1e-12f, 1e12f}) {
    Program scaled;
    scaled.sphere(0, 0, 0, size);
    EXPECT_EQ(report(scaled), "") << size;
  }
}

}  // namespace
}  // namespace patina::test
