// SPDX-License-Identifier: Apache-2.0
// Displacement of tessellated surfaces: shaders move vertices, once each; shared vertices stay together.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "renderer/geometry/facet_rates.h"

namespace patina {

/// What displaces surfaces: renderer/shading, which geometry does not know.
class Displacer {
 public:
  virtual ~Displacer() = default;

  /// How far a surface with these attributes is moved at most, as far as is known: the attributes' bound (in
  /// its object's space) and the shader's own (in world space); 0 = not known. Empty: it is not displaced.
  struct Bound {
    float object = 0, world = 0;
  };
  virtual std::optional<Bound> boundOf(const Attributes& attributes) const = 0;

  /// Vertices of a tile of a face, in world space; of surfaces in objects, which instances share, in the
  /// object's space.
  struct Vertices {
    const Surface& surface;
    const Primitive& primitive;
    const Attributes& attributes;
    const M44f& toWorld;
    uint32_t face;
    std::span<const V2f> uv;           ///< of the face
    std::span<const V3f> Ng;           ///< unit, of the undisplaced surface, on the outside
    std::span<const V3f> dPdu, dPdv;   ///< by the face's u and v
    std::span<const float> footprint;  ///< width of the facets around
    std::span<V3f> P;                  ///< undisplaced; becomes displaced
    std::span<V3f> N;                  ///< unit, as interpolated, on the outside; see displace()
  };
  /// Returns whether N became the shader's normals; else they are to be found from P. [any thread]
  virtual bool displace(const Vertices& vertices) const = 0;
};

/// A unit vector in 32 bits, exact to 7e-5 (octahedral: Cigolle et al., "A Survey of Efficient
/// Representations for Independent Unit Vectors", JCGT 3(2), 2014).
uint32_t packNormal(const V3f& n);
V3f unpackNormal(uint32_t packed);

/// What came of a displacement.
struct DisplacementResult {
  float moved = 0;                ///< the farthest that a vertex was moved, world units
  std::vector<uint32_t> normals;  ///< packed, by vertex: of the displaced surface, world space, either side
};

/// Displaces the vertices of a surface's tiles (those from allFirst[0] on), which are in object space and not
/// thinned out (see tessellate()), and brings them to world space by `toWorld`. `isReversed`: its outside is
/// opposite to dPdu x dPdv. Vertices that tiles share get the mean of their positions there, so that nothing
/// gapes, also where normals or texture coordinates differ; normals are shared where those of the undisplaced
/// surface agree, so that creases stay. [any thread]
DisplacementResult displaceFacets(const Surface& surface, const Primitive& primitive,
                                  const Attributes& attributes, const M44f& toWorld, bool isReversed,
                                  const Displacer& displacer, const SurfaceRates& rates,
                                  std::span<const uint32_t> allFirst, std::span<V3f> vertices);

}  // namespace patina
