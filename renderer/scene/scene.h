// SPDX-License-Identifier: Apache-2.0
// The scene as data: what a frame's requests come to. Knows nothing of patches, rays or shader plugins.
//
// Everything here is written by SceneBuilder on one thread and is read-only once rendering begins.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "renderer/base/math.h"
#include "renderer/scene/motion.h"
#include "rib/error.h"
#include "rib/params.h"

namespace patina {

inline constexpr uint32_t kNone = 0xffffffffu;

// ---- Shader bindings --------------------------------------------------------------------------------------

/// One argument of a shader as the RIB gives it; point-like values are in the binding's shader space.
struct ShaderArgument {
  std::string name;
  ValueType type = ValueType::Float;
  int arrayLength = 0;  ///< 0 = not an array
  std::vector<float> floats;
  std::vector<int> ints;
  std::vector<std::string> strings;
  Location where;
};

/// What Attribute "user" has said of what follows, by name. Copies share their values.
class UserAttributes {
 public:
  static constexpr size_t kMost = 256;

  bool empty() const { return !all_; }
  /// nullptr = there is none of this name.
  const ShaderArgument* find(std::string_view name) const;
  /// Adds an attribute, or replaces that of its name. False: there are kMost others.
  bool set(ShaderArgument attribute);
  size_t hash() const { return all_ ? all_->hash : 0; }  ///< of names and values
  /// The same names and values.
  bool operator==(const UserAttributes& other) const;

 private:
  struct All {
    std::vector<std::shared_ptr<const ShaderArgument>> byName;  ///< in alphabetical order
    size_t hash = 0;
  };
  std::shared_ptr<const All> all_;  ///< null = none
};

/// A Surface, Displacement, LightSource ... request. Shaders themselves are loaded by renderer/shading.
struct ShaderBinding {
  std::string name;
  std::vector<ShaderArgument> arguments;
  M44d shaderToWorld;  ///< the current transformation at the request
  Location where;
  UserAttributes user = {};  ///< at the request
  /// The first of Scene::shaders that differs from it by `user` alone, itself if there is none.
  uint32_t alike = kNone;
};

// ---- Attributes -------------------------------------------------------------------------------------------

/// Kinds of rays; the bits of a primitive's visibility.
enum RayMask : uint32_t {
  kCameraRay = 1,
  kDiffuseRay = 2,
  kSpecularRay = 4,
  kTransmissionRay = 8,
  kAnyRay = 15
};

/// The part of the graphics state that a primitive keeps. Equal states are stored once (Scene::attributes).
struct Attributes {
  Rgb color{1, 1, 1};
  Rgb opacity{1, 1, 1};
  std::array<float, 8> textureCoordinates{0, 0, 1, 0, 0, 1, 1, 1};
  uint32_t surface = kNone;        ///< index of Scene::shaders; kNone = the default surface
  uint32_t displacement = kNone;   ///< index of Scene::shaders
  uint32_t atmosphere = kNone;     ///< index of Scene::shaders: between the surface and who sees it
  uint32_t areaLight = kNone;      ///< index of Scene::lights: the geometry emits
  std::vector<uint32_t> lights;    ///< indices of Scene::lights that illuminate, ascending
  float shadingRate = 1;           ///< micropolygon area in pixels
  float diceLength = 0;            ///< edge of a micropolygon in units of space; 0: shadingRate counts
  bool diceInObjectSpace = false;  ///< diceLength is in object space, else in world space
  bool foreshorten = true;         ///< Attribute "dice" "rasterorient": lengths count as the camera sees them
  bool matte = false;
  bool oneSided = false;          ///< Sides 1: only the outside is met by rays
  bool smoothShading = false;     ///< ShadingInterpolation "smooth"
  bool castsShadows = true;       ///< Attribute "render" "casts_shadows", "visibility" "transmission"
  bool sampleMotion = false;      ///< Attribute "trace" "samplemotion": all rays see it blurred
  uint32_t visibility = kAnyRay;  ///< RayMask bits
  int maxDiffuseDepth = 1;
  int maxSpecularDepth = 2;
  float displacementBound = 0;  ///< object space
  std::string name;             ///< Attribute "identifier" "name"
  UserAttributes user;          ///< Attribute "user"
  bool operator==(const Attributes&) const = default;
};

// ---- Primitives -------------------------------------------------------------------------------------------

/// A primitive variable, checked: `floats` (or ints, strings) hold exactly as many values as its class asks
/// for on its primitive. Object space for points, vectors and normals.
struct PrimVar {
  std::string name;
  StorageClass storage = StorageClass::Uniform;
  ValueType type = ValueType::Float;
  int arrayLength = 1;
  int components = 1;  ///< floats per value: that of the type times arrayLength
  std::vector<float> floats;
  std::vector<int> ints;
  std::vector<std::string> strings;
};

/// Polygons with holes: face f has loopsPerFace[f] loops, loop l has vertsPerLoop[l] vertices; the first is
/// the outside. Dense meshes keep no number per face that is the same for all.
struct PolygonMesh {
  std::vector<int> loopsPerFace;  ///< empty: one loop each
  std::vector<int> vertsPerLoop;  ///< empty: `sides` each
  std::vector<int> vertices;      ///< indices into "P"
  int sides = 0;                  ///< 0 = vertsPerLoop says

  size_t loopCount() const {
    return sides > 0 ? vertices.size() / static_cast<size_t>(sides) : vertsPerLoop.size();
  }
  size_t faceCount() const { return loopsPerFace.empty() ? loopCount() : loopsPerFace.size(); }
};

struct Quadric {
  enum class Kind { Sphere, Cone, Cylinder, Hyperboloid, Paraboloid, Disk, Torus } kind = Kind::Sphere;
  /// In the request's order without thetamax: radius zmin zmax | height radius | radius zmin zmax | p1 p2 |
  /// rmax zmin zmax | height radius | major minor phimin phimax (degrees).
  std::array<float, 6> values{};
  float thetaMax = 360;  ///< degrees
};

struct CubicBasis {
  M44f matrix;  ///< rows as in RiBasis
  int step = 3;
  bool operator==(const CubicBasis&) const = default;
};

/// Patch and PatchMesh: nu x nv control points, row by row along u.
struct ParametricMesh {
  bool bicubic = false;
  int nu = 2, nv = 2;
  bool periodicU = false, periodicV = false;
  CubicBasis basisU, basisV;
};

struct SubdivisionMesh {
  std::string scheme;  ///< "catmull-clark", "loop" ...
  std::vector<int> vertsPerFace;
  std::vector<int> vertices;
  struct Tag {
    std::string name;
    std::vector<int> ints;
    std::vector<float> floats;
    std::vector<std::string> strings;
  };
  std::vector<Tag> tags;
};

/// Curves: vertexCounts[k] control points belong to curve k.
struct CurveSet {
  bool cubic = false;
  bool periodic = false;
  bool round = false;  ///< Attribute "dice" "roundcurve": tubes where no "N" makes them ribbons
  CubicBasis basis;    ///< of cubic curves
  std::vector<int> vertexCounts;
};

/// Splines along one direction: `count` control points, `order` = degree + 1.
struct SplineKnots {
  int count = 2, order = 2;
  std::vector<float> knots{0, 0, 1, 1};  ///< count + order, not falling
  float min = 0, max = 1;                ///< the part in use, of [knots[order-1], knots[count]]
};

class TrimRegion;

/// NuPatch: u.count x v.count control points, row by row along u.
struct NurbsPatch {
  SplineKnots u, v;
  std::shared_ptr<const TrimRegion> trim;  ///< of the TrimCurve in force, shared by its patches; null = none
  bool keepInside = false;  ///< Attribute "trimcurve" "sense" "outside": what the loops do not enclose is cut
};

/// Points: a ball around each of the points "P".
struct PointSet {
  size_t count = 0;
};

/// Blobby: a field over object space, whose surface is where it has the value of Blobby::kThreshold. A
/// program of instructions, each of which gives one result; the last one's is the field. Checked by the
/// builder: operands are earlier results, and fields find all their floats.
struct Blobby {
  /// The field of one unit ellipsoid at half its radius: (1 - 1/4)^3.
  static constexpr double kThreshold = 0.421875;

  enum class Op : uint8_t {
    Add,  ///< and the next three: one operand or more
    Multiply,
    Maximum,
    Minimum,
    Subtract,  ///< and Divide: the second operand from (into) the first
    Divide,
    Negate,
    Identity,
    Constant,   ///< the first of the fields: 1 float
    Ellipsoid,  ///< 16 floats: the matrix from the unit sphere to object space
    Segment,    ///< 23 floats: end points, radius, and the matrix from their space to object space
    Plane       ///< 4 floats: the profile of the repelling plane z = 0
  };
  struct Instruction {
    Op op;
    uint32_t first;  ///< index of `operands`; of a field: of `floats`
    uint32_t count;  ///< of the operands or floats

    bool isField() const { return op >= Op::Constant; }
  };

  std::vector<Instruction> instructions;
  std::vector<uint32_t> operands;  ///< indices of instructions
  std::vector<float> floats;
  size_t leaves = 0;  ///< values of a varying or vertex variable: one for each field, in their order
};

using Shape = std::variant<PolygonMesh, Quadric, ParametricMesh, SubdivisionMesh, CurveSet, NurbsPatch,
                           PointSet, Blobby>;

/// What of a primitive changes its shape, at one time of a motion block.
struct ShapeKey {
  double time;                     ///< as in MotionKey
  std::vector<float> dimensions;   ///< of a Quadric: values and thetaMax; else none
  std::vector<PrimVar> variables;  ///< those that may change: P, Pw, N, width, constantwidth
};

/// Where a primitive that moves is, and what it looks like.
struct PrimitiveMotion {
  Movement place;                ///< primitive space to the world, or to the object's space
  std::vector<ShapeKey> shapes;  ///< ascending times; empty: the shape keeps
};

struct Primitive {
  Shape shape;
  std::vector<PrimVar> variables;  ///< "P" among them where the shape has vertices (Pw and Pz are converted)
  M44d objectToWorld;              ///< inside an object definition: to the object's space
  uint32_t attributes = kNone;  ///< index of Scene::attributes; kNone inside an object: those of the instance
  bool reversed = false;        ///< the outside is opposite to dPdu x dPdv (orientation against handedness)
  Location where;
  uint32_t solid = kNone;  ///< index of the solids of its scene or object
  uint32_t operand = 0;    ///< the node of that solid which it bounds, a Primitive
  /// Of primitives that stood in a motion block or under a moving transformation: all else here is as it is
  /// at the opening of the shutter. Null: it stands still.
  std::shared_ptr<const PrimitiveMotion> motion;
};

/// SolidBegin ... SolidEnd (RI 3.2 section 5.7): set operations on what closed surfaces enclose, as a tree.
struct Solid {
  enum class Operation : uint8_t {
    Primitive,  ///< a leaf: what the primitives of this node enclose together
    Union,
    Intersection,
    Difference  ///< the first operand without the others
  };
  struct Node {
    Operation operation;
    uint32_t parent;  ///< index of nodes; kNone: the root, which is node 0
    Location where;
    bool absent = false;  ///< a leaf whose primitives are no part of the solid, but surfaces like any other
  };
  std::vector<Node> nodes;  ///< parents before their operands, operands in their order
};

struct ObjectDefinition {
  std::vector<Primitive> primitives;
  std::vector<Solid> solids;
};

struct Instance {
  uint32_t object = kNone;  ///< index of Scene::objects
  M44d objectToWorld;
  uint32_t attributes = kNone;
  bool reversed = false;  ///< RI's orientation disagreed with the handedness at the ObjectInstance
  Location where;
  std::shared_ptr<const Movement> motion;  ///< of objectToWorld, which is that of the opening; null: none
};

struct Light {
  uint32_t shader = kNone;   ///< index of Scene::shaders
  bool isArea = false;       ///< AreaLightSource: primitives whose attributes name it emit
  bool castsShadows = true;  ///< Attribute "light" "shadows" is not "off"
  std::string handle;
};

// ---- Options ----------------------------------------------------------------------------------------------

/// ClippingPlane: the camera does not see where p . normal > offset.
struct ClippingPlane {
  V3d normal;
  double offset;
};

struct Camera {
  bool perspective = true;
  float fov = 90;  ///< degrees, of the narrower side of the unit screen window
  std::array<float, 4> screenWindow{-1, 1, -1, 1};  ///< left right bottom top
  float nearPlane = 1e-10f, farPlane = 1e38f;       ///< camera space
  std::vector<ClippingPlane> clippingPlanes;        ///< camera space
  M44d worldToCamera;                               ///< left-handed camera space looking down +z
  float fStop = std::numeric_limits<float>::infinity(), focalLength = 1, focalDistance = 1;
  float shutterOpen = 0, shutterClose = 0;  ///< nothing moves unless the first is less
  std::shared_ptr<const Movement> motion;   ///< of worldToCamera, which is that of the opening; null: none
};

struct DisplayRequest {
  std::string name, type, mode;
  std::map<std::string, std::string> strings;  ///< display parameters
  std::map<std::string, std::vector<float>> numbers;
  Location where;
};

struct Quantization {
  int one = 255, minimum = 0, maximum = 255;
  float dither = 0.5f;
};

/// Of mode points, as far as they are said.
struct PointOptions {
  static constexpr float kLeastAngle = 1e-4f, kMostAngle = 1, kMostSurfelSize = 1e6f;
  static constexpr int kLeastResolution = 4, kMostResolution = 128, kMostBounces = 64;
  std::optional<float> maxSolidAngle;  ///< steradians above which a group of points is taken apart
  std::optional<int> resolution;       ///< pixels along an edge of a point's raster: even
  std::optional<int> bounces;          ///< of diffuse light, 1 or more
  std::optional<int> memoryKb;         ///< of the octree: 1 or more
  std::optional<float> surfelSize;     ///< pixels that a point covers at least: 0 or more
};

struct Options {
  int xResolution = 640, yResolution = 480;
  float pixelAspect = 1;
  std::optional<float> frameAspect;                  ///< FrameAspectRatio
  std::optional<std::array<float, 4>> screenWindow;  ///< as the RIB says it; Camera has the one in force
  std::array<float, 4> crop{0, 1, 0, 1};             ///< xmin xmax ymin ymax, fractions of the picture
  int pixelSamplesX = 2, pixelSamplesY = 2;
  float pixelVariance = 0;
  std::string filter = "gaussian";
  float filterWidthX = 2, filterWidthY = 2;
  float exposureGain = 1, exposureGamma = 1;
  std::optional<Quantization> colorQuantization;  ///< empty: the display's default
  std::optional<Quantization> depthQuantization;
  std::vector<DisplayRequest> displays;
  std::string mode;  ///< Option "patina" "mode" or Hider's integrationmode; "" = not said
  std::optional<int> minSamples, maxSamples;  ///< Hider "raytrace"
  std::optional<std::string> displayView;     ///< Option "patina" "display"
  std::string ocioConfig;  ///< Option "patina" "ocio": path, of texture files' colour spaces; "" = not said
  Location ocioWhere;
  int seed = 0;                   ///< Option "patina" "seed": of random numbers; not negative
  float levelScale = 0.35f;       ///< Option "patina" "levelscale": see RadiosityEngine::Settings
  float fineScale = 2;            ///< likewise, "finescale"
  PointOptions points;            ///< Option "points"
  std::optional<Rgb> background;  ///< Imager "background"
  int radiosityCacheKb = 262144;  ///< Option "limits" "radiositycachememory"
  int opacityCacheKb = 262144, geometryCacheKb = 262144, textureKb = 262144;
  std::array<int, 2> bucketSize{16, 16};
  std::map<std::string, std::string>
      madeTextures;  ///< of Make requests: texture name to the file that was made, or to its picture
  std::map<std::string, std::string> searchPaths;  ///< "shader", "texture", "archive", ... RI path syntax
  bool statistics = false;                         ///< Option "statistics" "endofframe"
  bool caustics = true;                            ///< Option "trace" "allowcaustics"; see requests.md
  bool incremental = false;                        ///< Hider "raytrace": a coarse picture first
  std::string statisticsFile;  ///< Option "statistics" "filename"; "" and "stdout" = standard output
  float relativeDetail = 1;    ///< RelativeDetail
};

// ---- Delayed archives -------------------------------------------------------------------------------------

struct DelayedState;

/// Procedural "DelayedReadArchive": a file that is read when a ray first meets its bound, as if it stood in
/// place of the request within an attribute block of its own. What is global in RI and not an attribute
/// (handles, coordinate systems, declarations, archives, options) has the meaning that it has at WorldEnd.
struct DelayedArchive {
  std::string file;
  Box3f bound;         ///< object space; finite, not empty
  M44d objectToWorld;  ///< the current transformation at the request; affine
  std::shared_ptr<const DelayedState> state;
  Location where;
  bool sampleMotion = false;  ///< Attributes::sampleMotion at the request
};

/// One frame: what lies between WorldBegin and WorldEnd, with the options in force.
struct Scene {
  Options options;
  Camera camera;
  std::deque<Attributes> attributes;
  std::vector<ShaderBinding> shaders;
  std::vector<Light> lights;
  std::vector<Primitive> primitives;  ///< in world space by their objectToWorld
  std::vector<Solid> solids;          ///< of `primitives`
  std::deque<ObjectDefinition> objects;
  std::vector<Instance> instances;
  std::map<std::string, M44d> coordinateSystems;  ///< named space to world
  int frame = 0;

  std::vector<DelayedArchive> delayed;
  /// What one of `delayed` holds: a scene of its own, without lights, whose numbers of shaders and objects
  /// continue those of this scene (smaller ones are this scene's). Null: it was not read, which has
  /// been reported. Lives no longer than this scene and its builder. [any thread, until OnWorld returns]
  std::function<std::shared_ptr<const Scene>(const DelayedArchive&, ErrorHandler&)> readDelayed;
  uint32_t firstShader = 0;  ///< number of shaders[0]; not 0 in delayed archives
  uint32_t firstObject = 0;  ///< number of objects[0]
};

/// Reads all delayed archives, and those within them, for what is wrong in them. [main]
void checkDelayed(const Scene& scene, ErrorHandler& errors);

}  // namespace patina
