// SPDX-License-Identifier: Apache-2.0
// The geometry of an area light as something to sample: rectangles and spheres by solid angle, the rest by
// area.
#pragma once

#include <unordered_map>
#include <vector>

#include "renderer/geometry/geometry.h"
#include "renderer/shading/light_bounds.h"

namespace patina {

/// A point chosen on an area light. `pdf` is per solid angle seen from the point to be lit; 0 = nothing
/// chosen.
struct EmitterSample {
  V3f P{0, 0, 0}, N{0, 0, 1};  ///< N: unit, outside of the light
  float error = 0;             ///< see Facet
  float pdf = 0;
  float u = 0, v = 0;  ///< the light's surface parameters (RI's u, v)
};

/// All faces of one area light. Read-only after finish(). [any thread]
class Emitters {
 public:
  void add(const Geometry& geometry, uint32_t placement);
  void finish();
  bool empty() const { return shapes_.empty(); }
  float totalArea() const { return total_; }

  /// Where the faces are and look to. A mesh of many faces is one light, and its bounds are those of all:
  /// they say little where the mesh goes all around.
  LightBounds bounds() const;

  EmitterSample sample(const V3f& from, V2f random) const;

  /// The density, per solid angle, with which sample() picks the direction from `from` to a point of the
  /// light's surface with outside normal `normal`.
  float pdf(uint32_t placement, uint32_t face, const V3f& from, const V3f& point, const V3f& normal) const;

 private:
  struct Shape {
    enum class Kind : uint8_t { Triangle, Rectangle, Sphere } kind = Kind::Triangle;
    V3f corner{0, 0, 0}, edge1{0, 0, 0},
        edge2{0, 0, 0};                     ///< sphere: corner is the centre, edge1.x the radius
    V3f normal{0, 0, 1};                    ///< outside; unused for spheres
    V2f uv0{0, 0}, duv1{0, 0}, duv2{0, 0};  ///< surface parameters at the corner and along the edges
    float error = 0;
    float area = 0;
    float sign = 1;                                   ///< sphere: -1 when the outside is the inside
    V3f axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};  ///< sphere: unit, object space's in world space
  };
  struct Owner {
    uint32_t first,
        perFace;  ///< perFace 0: one shape stands for the whole placement; kNone: sampled by area alone
  };
  static void sampleRectangle(const Shape& s, const V3f& from, V2f random, EmitterSample& out);
  static float rectangleSolidAngle(const Shape& s, const V3f& from);
  static void sampleSphere(const Shape& s, const V3f& from, V2f random, EmitterSample& out);
  static float spherePdf(const Shape& s, const V3f& from);

  std::vector<Shape> shapes_;
  std::vector<float> cumulative_;  ///< of areas, normalised
  std::unordered_map<uint32_t, Owner> owners_;
  float total_ = 0;
};

}  // namespace patina
