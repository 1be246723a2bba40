// SPDX-License-Identifier: Apache-2.0
// A primitive as parametric faces: what tessellation, dicing and shading ask of every kind of geometry.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "renderer/base/math.h"
#include "renderer/geometry/primvar.h"
#include "renderer/scene/scene.h"

namespace patina {

/// The domain of a face. Quad: (u, v) in the unit square. Triangle: u, v >= 0, u + v <= 1; the corners are
/// (0,0), (1,0) and (0,1), so that (1-u-v, u, v) are the barycentric weights.
enum class FaceShape : uint8_t { Quad, Triangle };

/// A point of the smooth surface, in object space. N is unit length and follows dPdu x dPdv of the face's own
/// parameters, not the primitive's orientation. At poles and collapsed edges N is the limit, never zero.
///
/// Outside: while RI's current orientation agrees with the handedness of the object's coordinate system
/// (which is so until Orientation or ReverseOrientation says otherwise, as both flip with a negative
/// determinant), the outside is the side that N points to: dPdu x dPdv on parametric surfaces, (P1-P0) x
/// (P2-P0) in the order of a polygon's vertices. Primitive::reversed is true exactly while the two disagree,
/// and then the outside is the side of -N. The rule holds in object space: N goes to world space as a normal
/// (by the inverse of the matrix that moves points) whatever the determinant, and is not to be recomputed
/// from transformed dPdu and dPdv, whose cross product a mirroring matrix turns round. So no matrix makes a
/// primitive or an instance reversed by itself.
struct SurfacePoint {
  V3f P, N, dPdu, dPdv;
};

struct SurfaceRates;

/// One primitive. Immutable after construction; every function may be called from any thread.
class Surface {
 public:
  virtual ~Surface() = default;

  virtual uint32_t faceCount() const = 0;
  virtual FaceShape faceShape(uint32_t face) const = 0;

  /// True when every face is exactly what its corners span: a triangle, or a quad made of the two triangles
  /// (00, 10, 01) and (11, 01, 10). Such faces are traced as they are, however finely they are shaded.
  virtual bool isFlat() const = 0;

  /// Whether N changes within a face: flat faces, too, may stand for a smooth surface.
  virtual bool hasSmoothNormals() const { return !isFlat(); }

  /// Corners of a face: (0,0) (1,0) (0,1) [(1,1)].
  virtual void corners(uint32_t face, V3f out[4]) const = 0;

  /// Points that corners share, where the surface keeps them, and which of them are those of a face, in the
  /// order of corners(). Empty: there are none such, and cornerPoints() must not be asked.
  virtual PointView sharedPoints() const { return {}; }
  virtual void cornerPoints(uint32_t /*face*/, uint32_t /*out*/[4]) const {}

  virtual SurfacePoint evaluate(uint32_t face, float u, float v) const = 0;

  /// Many points of one face; the default calls evaluate() for each.
  virtual void evaluateMany(uint32_t face, std::span<const V2f> uv, std::span<SurfacePoint> out) const {
    for (size_t i = 0; i < uv.size(); ++i) out[i] = evaluate(face, uv[i].x, uv[i].y);
  }

  /// The value of a primitive variable by the rule of its class on this kind of primitive: `out` gets
  /// variable.components floats. (For string and integer variables see uniformIndex.)
  virtual void interpolate(const PrimVar& variable, uint32_t face, float u, float v, float* out) const = 0;

  /// Which uniform value belongs to a face (the polygon, patch or base face that it is a part of).
  virtual uint32_t uniformIndex(uint32_t face) const = 0;

  /// The primitive's own u, v of RI at a face's (u, v): 0 to 1 over a whole patch mesh or quadric; object x,
  /// y on polygons; umin to umax and vmin to vmax of NuPatch.
  virtual V2f surfaceParameters(uint32_t face, float u, float v) const = 0;

  /// The texture coordinates before TextureCoordinates, where no s, t or st is given: the parameters, but 0
  /// to 1 over a whole NuPatch.
  virtual V2f textureParameters(uint32_t face, float u, float v) const {
    return surfaceParameters(face, u, v);
  }

  /// How fast textureParameters change, for texture footprints: the lengths of their derivatives by the
  /// face's u and by its v.
  virtual V2f parameterScale(uint32_t face) const = 0;

  virtual Box3f bound() const = 0;  ///< object space

  /// Whether parts of faces are cut out, and whether a point lies in such a part: rays pass there. All else
  /// is answered for holes as if there were none.
  virtual bool hasHoles() const { return false; }
  virtual bool isHole(uint32_t /*face*/, float /*u*/, float /*v*/) const { return false; }

  /// Positions at a grid of parameters, row by row: out[j * u.size() + i] at (u[i], v[j]), multiples of a
  /// power of two. Of surfaces that are not flat; their faces are quads. Unless weld() sees to it, points on
  /// a side that faces share have the same bits in each of them.
  virtual void evaluateGrid(uint32_t face, std::span<const double> u, std::span<const double> v,
                            std::span<V3f> out) const;

  /// A side of a face (of v = 0, v = 1, u = 0, u = 1) as an edge of a mesh. Without a number the side's
  /// points tell where it belongs; with one faces may have other bits there until weld() makes them equal.
  struct Side {
    uint32_t edge = kNone;
    bool isHalf = false;  ///< half of the edge, where the other side of it may be whole
  };
  virtual Side sideOf(uint32_t /*face*/, uint32_t /*side*/) const { return {}; }
  /// Gives vertices that several faces share the same bits. `vertices` are those of evaluateGrid() at the
  /// rates of facets, face f's from first[f] on.
  virtual void weld(const SurfaceRates&, std::span<const uint32_t> /*first*/,
                    std::span<V3f> /*vertices*/) const {}

  size_t memory() const { return memory_; }  ///< bytes held, for statistics

 protected:
  size_t memory_ = 0;
};

/// Where a primitive is seen from, in object space: primitives that turn to the eye (curves without normals)
/// and those that choose their own facets (blobbies) need it.
struct Viewpoint {
  bool perspective = true;
  V3f eye{0, 0, 0};        ///< perspective
  V3f direction{0, 0, 1};  ///< of view, orthographic
  float pixels = 0;        ///< that a unit across the view covers, perspective: at distance 1; 0 = not known
  float pixelCount = 0;    ///< of the whole picture; 0 = not known

  /// Pixels per unit of object space for a ball, where it is nearest to the eye.
  float pixelsPerUnit(const V3f& center, float radius) const {
    return perspective ? pixels / std::max((center - eye).length() - radius, 0.25f * radius) : pixels;
  }
};

/// Builds the surface of a primitive. Geometry that cannot be made sense of (no area, bad counts) is reported
/// to `errors` with the primitive's location and gives nullptr; what can be mended is mended with a warning.
/// The surface keeps references into `primitive`, which must outlive it.
std::unique_ptr<Surface> makeSurface(const Primitive& primitive, ErrorHandler& errors,
                                     const Viewpoint& view = {});

/// Finds a primitive variable by name; nullptr when there is none.
const PrimVar* findVariable(const Primitive& primitive, std::string_view name);

/// How many values a variable of a class has on this shape (RI 3.2, section 5): used by the scene to check
/// counts.
size_t valueCount(const Shape& shape, size_t vertexCount, StorageClass storage);

}  // namespace patina
