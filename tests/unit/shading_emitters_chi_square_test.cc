// SPDX-License-Identifier: Apache-2.0
// Chi-square tests of points drawn on area lights, against the density per solid angle that a ray which meets
// the light is weighted with.
#include "renderer/accel/accel.h"
#include "renderer/shading/emitters.h"
#include "tests/unit/chi_square.h"
#include "tests/unit/mesh_primitive.h"

namespace patina::test {
namespace {

class Light {
 public:
  explicit Light(std::vector<Primitive> primitives) {
    scene_.attributes.emplace_back();
    for (Primitive& p : primitives) {
      p.attributes = 0;
      scene_.primitives.push_back(std::move(p));
    }
    scene_.camera.worldToCamera.setTranslation(V3d(0, 0, 20));
    geometry_ = std::make_unique<Geometry>(scene_, RasterCamera(scene_.camera, scene_.options), errors_);
    accel_ = std::make_unique<Accel>(*geometry_);  // which makes micropolygons
    for (uint32_t k = 0; k < geometry_->placements().size(); ++k) emitters.add(*geometry_, k);
    emitters.finish();
  }
  const Geometry& geometry() const { return *geometry_; }
  Emitters emitters;

 private:
  Scene scene_;
  ErrorHandler errors_{[](Severity, std::string_view message) { ADD_FAILURE() << message; }};
  std::unique_ptr<Geometry> geometry_;
  std::unique_ptr<Accel> accel_;
};

Primitive quadric(Quadric::Kind kind, std::array<float, 6> values, const V3d& at, float thetaMax = 360) {
  Primitive p;
  p.shape = Quadric{kind, values, thetaMax};
  p.objectToWorld = M44d().setTranslation(at);
  return p;
}

/// A flat face of a light: corner and two edges; a triangle's third corner is at the ends of both.
struct Face {
  uint32_t placement, face;
  V3f corner, edge1, edge2;
  bool triangle = false;
  static constexpr size_t kSide = 12;

  V3f normal() const { return edge1.cross(edge2).normalized(); }
  double area() const { return static_cast<double>(edge1.cross(edge2).length()) / (triangle ? 2 : 1); }
  V3f at(double a, double b) const {
    return corner + edge1 * static_cast<float>(a) + edge2 * static_cast<float>(triangle ? b * (1 - a) : b);
  }
  /// The cell of a point with the normal N, if it is of this face.
  std::optional<size_t> cellOf(const V3f& P, const V3f& N) const {
    const V3f d = P - corner, n = edge1.cross(edge2);
    const float tolerance = 1e-4f;
    if (std::abs(d.dot(normal())) > tolerance * edge1.length() || std::abs(N.dot(normal())) < 1 - tolerance)
      return std::nullopt;
    const float a = d.cross(edge2).dot(n) / n.length2();
    float b = edge1.cross(d).dot(n) / n.length2();
    if (triangle) b /= std::max(1 - a, 1e-6f);
    if (std::min(a, b) < -tolerance || std::max(a, b) > 1 + tolerance) return std::nullopt;
    const auto step = [](float x) {
      return std::min(static_cast<size_t>(std::max(x, 0.0f) * kSide), kSide - 1);
    };
    return step(b) * kSide + step(a);
  }
};

/// The cells are on the faces, and their chances are integrals of pdf cos / d^2 over them.
void fitFaces(Fits& fits, const std::string& name, const Light& light, const std::vector<Face>& faces,
              const V3f& from) {
  constexpr size_t kCells = Face::kSide * Face::kSide;
  std::vector<double> counts(faces.size() * kCells), chances;
  Independent random(seedOf(name));
  for (uint32_t k = 0; k < kChiSquareSamples; ++k) {
    const EmitterSample s = light.emitters.sample(from, random.next2());
    if (s.pdf == 0) continue;
    std::optional<size_t> cell;
    size_t face = 0;
    while (face < faces.size() && !(cell = faces[face].cellOf(s.P, s.N))) ++face;
    ASSERT_TRUE(cell) << name << ": " << s.P << " is on no face";
    ++counts[face * kCells + *cell];
    const float met = light.emitters.pdf(faces[face].placement, faces[face].face, from, s.P, s.N);
    ASSERT_NEAR(s.pdf, met, 1e-3f * met) << name;
  }
  for (const Face& face : faces) {
    const V3f normal = face.normal();
    for (size_t j = 0; j < Face::kSide; ++j)
      for (size_t i = 0; i < Face::kSide; ++i) {
        const auto edge = [](size_t k) { return static_cast<double>(k) / static_cast<double>(Face::kSide); };
        chances.push_back(integrate(
            [&](double a, double b) {
              const V3f P = face.at(a, b), d = P - from;
              const double cosine = static_cast<double>(std::abs(d.dot(normal)) / d.length()),
                           pdf = static_cast<double>(
                               light.emitters.pdf(face.placement, face.face, from, P, normal));
              const double jacobian = face.area() * (face.triangle ? 2 * (1 - a) : 1);
              return pdf * cosine / static_cast<double>(d.length2()) * jacobian;
            },
            edge(i), edge(i + 1), edge(j), edge(j + 1), kCellTolerance));
      }
  }
  fits.add(name, std::move(counts), std::move(chances));
}

std::string named(const std::string& name, const V3f& from) {
  return name + " from " + std::to_string(from.x) + " " + std::to_string(from.y) + " " +
         std::to_string(from.z);
}

// By solid angle, except from far away. Near: a hundredth of its width off its middle, and off a corner.
TEST(EmittersChiSquare, Rectangle) {
  const Light light({meshPrimitive({-1, -0.5f, 2, 1, -0.5f, 2, 1, 0.5f, 2, -1, 0.5f, 2}, {4}, {0, 1, 2, 3})});
  const std::vector<Face> faces{{0, 0, {-1, -0.5f, 2}, {2, 0, 0}, {0, 1, 0}}};
  Fits fits;
  for (const V3f& from : {V3f(0, 0, 0), V3f(0.2f, 0.1f, 2.02f), V3f(0.98f, 0.48f, 1.99f), V3f(3, 2, 1.5f),
                          V3f(-4, 0.1f, 2.05f), V3f(20, 10, -80)})
    fitFaces(fits, named("rectangle", from), light, faces, from);
}

TEST(EmittersChiSquare, Triangle) {
  const Light light({meshPrimitive({0, 0, 2, 1, 0, 2.5f, 0, 1, 2}, {3}, {0, 1, 2})});
  const std::vector<Face> faces{{0, 0, {0, 0, 2}, {1, 0, 0.5f}, {0, 1, 0}, true}};
  Fits fits;
  for (const V3f& from : {V3f(0.3f, 0.3f, 0), V3f(0.3f, 0.2f, 2.2f), V3f(-30, 10, 50)})
    fitFaces(fits, named("triangle", from), light, faces, from);
}

// Faces of different sizes, chosen by area, each by its own solid angle; from within and without.
TEST(EmittersChiSquare, BoxOfRectangles) {
  const V3f low(-1, -0.5f, -0.2f), high(1, 0.5f, 0.4f), size = high - low;
  std::vector<float> points;
  for (int k = 0; k < 8; ++k)
    for (int axis = 0; axis < 3; ++axis) points.push_back(k >> axis & 1 ? high[axis] : low[axis]);
  const Light light({meshPrimitive(
      points, {4, 4, 4, 4, 4, 4}, {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5})});
  const V3f x(size.x, 0, 0), y(0, size.y, 0), z(0, 0, size.z);
  const std::vector<Face> faces{{0, 0, low, y, x},     {0, 1, low + z, x, y}, {0, 2, low, x, z},
                                {0, 3, low + y, z, x}, {0, 4, low, z, y},     {0, 5, low + x, y, z}};
  Fits fits;
  for (const V3f& from : {V3f(0.3f, 0.1f, 0.1f), V3f(0.9f, 0.4f, 0.45f), V3f(2, 3, 1)})
    fitFaces(fits, named("box", from), light, faces, from);
}

// A light of several shapes: two triangles and a rectangle.
TEST(EmittersChiSquare, LightOfSeveralShapes) {
  const Light light({meshPrimitive({0, 0, 2, 1, 0, 2.5f, 0, 1, 2, 1, 1, 4}, {3, 3}, {0, 1, 2, 3, 2, 1}),
                     meshPrimitive({3, 0, 0, 3, 2, 0, 3, 2, 1, 3, 0, 1}, {4}, {0, 1, 2, 3})});
  const std::vector<Face> faces{{0, 0, {0, 0, 2}, {1, 0, 0.5f}, {0, 1, 0}, true},
                                {0, 1, {1, 1, 4}, {-1, 0, -2}, {0, -1, -1.5f}, true},
                                {1, 0, {3, 0, 0}, {0, 2, 0}, {0, 0, 1}}};
  Fits fits;
  for (const V3f& from : {V3f(0.3f, 0.3f, 0), V3f(2.5f, 1, 0.5f)})
    fitFaces(fits, named("several", from), light, faces, from);
}

TEST(EmittersChiSquare, Sphere) {
  const V3f center(0.5f, -1, 5);
  const float radius = 1.5f;
  const Light light({quadric(Quadric::Kind::Sphere, {radius, -radius, radius}, V3d(center))});
  Fits fits;
  for (const V3f& from :
       {V3f(0, 0, 0), V3f(0.5f, -1, 3.45f), V3f(100, -50, 40), V3f(0.5f, -1, 5), V3f(1.5f, -1.2f, 5.9f)}) {
    const V3f toCenter = center - from;
    const double distance = static_cast<double>(toCenter.length()), r = static_cast<double>(radius);
    const V3f axis = normalizedOr(toCenter, V3f(0, 0, 1));
    // From outside, the cone that the sphere fills.
    const double sine = std::min(r / distance, 1.0), rim = sine * sine / (1 + std::sqrt(1 - sine * sine));
    const SphereGrid grid = distance > r ? SphereGrid::cone(axis, rim) : SphereGrid::even(axis);
    fitDirections(
        fits, named("sphere", from), grid,
        [&](Independent& random) -> std::optional<V3f> {
          const EmitterSample s = light.emitters.sample(from, random.next2());
          if (s.pdf == 0) return std::nullopt;
          EXPECT_NEAR((s.P - center).length(), radius, 1e-4f);
          return (s.P - from).normalized();
        },
        [&](const V3f& w) -> float {  // of the point that a ray meets, if it does
          const V3d d(w), c(toCenter);
          const double middle = c.dot(d), square = r * r - (c - d * middle).length2();
          if (square < 0 || (distance > r && middle < 0)) return 0;
          const double t = middle - (distance > r ? std::sqrt(square) : -std::sqrt(square));
          const V3f P(V3d(from) + d * t);
          return light.emitters.pdf(0, 0, from, P, (P - center).normalized());
        });
  }
}

/// Quadrics that are sampled by area, on the micropolygons that stand for them: cells by surface parameters.
void fitTessellated(Fits& fits, const std::string& name, const Light& light, const V3f& from) {
  constexpr size_t kSide = 12;
  const auto cell = [](float u, float v) {
    const auto step = [](float x) { return std::min(static_cast<size_t>(x * kSide), kSide - 1); };
    return step(v) * kSide + step(u);
  };
  std::vector<double> counts(kSide * kSide), chances(counts.size());
  Independent random(seedOf(name));
  for (uint32_t k = 0; k < kChiSquareSamples; ++k) {
    const EmitterSample s = light.emitters.sample(from, random.next2());
    if (s.pdf == 0) continue;
    ++counts[cell(s.u, s.v)];
    const float met = light.emitters.pdf(0, 0, from, s.P, s.N);
    ASSERT_NEAR(s.pdf, met, 1e-3f * met) << name;
  }
  light.geometry().forEachFacet(0, [&](const Geometry::FacetQuad& q) {
    const Surface& surface = light.geometry().surface(light.geometry().placements()[0]);
    const auto triangle = [&](int corner, int along1, int along2) {
      constexpr int kParts = 12;  // in each direction
      const V3f &p = q.P[corner], e1 = q.P[along1] - p, e2 = q.P[along2] - p, cross = e1.cross(e2);
      if (cross.length() == 0) return;
      const V3f normal = cross.normalized();
      for (int j = 0; j < kParts; ++j)
        for (int i = 0; i + j < 2 * kParts - 1 - j; ++i) {
          // Strip j holds 2 (kParts - j) - 1 triangles; this one's centroid.
          const bool flipped = i % 2;
          const float third = flipped ? 2 / 3.0f : 1 / 3.0f;
          const float b1 = (static_cast<float>(i / 2) + third) / kParts,
                      b2 = (static_cast<float>(j) + third) / kParts;
          const V3f P = p + e1 * b1 + e2 * b2, d = P - from;
          const V2f uv =
              q.uv[corner] + (q.uv[along1] - q.uv[corner]) * b1 + (q.uv[along2] - q.uv[corner]) * b2;
          const V2f parameters = surface.surfaceParameters(q.face, uv.x, uv.y);
          const float pdf = light.emitters.pdf(0, q.face, from, P, normal);
          chances[cell(parameters.x, parameters.y)] +=
              static_cast<double>(pdf * std::abs(d.dot(normal)) / (d.length2() * d.length()) *
                                  cross.length() / (2 * kParts * kParts));
        }
    };
    triangle(0, 1, 2);
    if (!q.isTriangle) triangle(3, 2, 1);
  });
  fits.add(name, std::move(counts), std::move(chances));
}

TEST(EmittersChiSquare, OtherQuadricsByArea) {
  using Kind = Quadric::Kind;
  const V3d at(0.5, -1, 5);
  const std::vector<std::pair<std::string, Primitive>> lights{
      {"disk", quadric(Kind::Disk, {0, 1}, at)},
      {"cylinder", quadric(Kind::Cylinder, {0.5f, -1, 1}, at)},
      {"cone", quadric(Kind::Cone, {1, 1}, at)},
      {"paraboloid", quadric(Kind::Paraboloid, {1, 0, 1}, at)},
      {"hyperboloid", quadric(Kind::Hyperboloid, {1, 0, -1, 0.5f, 0.8f, 1}, at)},
      {"torus", quadric(Kind::Torus, {1, 0.3f, 0, 360}, at)},
      {"part of a sphere", quadric(Kind::Sphere, {1, -0.5f, 0.8f}, at, 250)}};
  Fits fits;
  for (const auto& [name, primitive] : lights) {
    const Light light({primitive});
    for (const V3f& from : {V3f(0, 0, 0), V3f(0.6f, -0.8f, 5.1f)})
      fitTessellated(fits, named(name, from), light, from);
  }
}

}  // namespace
}  // namespace patina::test
