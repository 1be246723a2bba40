// SPDX-License-Identifier: Apache-2.0
// The requests of RIB as virtual functions: what reads RIB calls a RibHandler, what uses RIB is one.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string_view>

#include "rib/error.h"
#include "rib/inline_archive.h"
#include "rib/params.h"

namespace patina {

using RibMatrix = std::array<float, 16>;  // rows as written in RIB; points are row vectors, p' = p M
using Bounds6 = std::array<float, 6>;     // xmin xmax ymin ymax zmin zmax
using Floats = std::span<const float>;
using Ints = std::span<const int>;
using Strings = std::span<const std::string_view>;

// Name of a light, object, resource or node. RIB writes an integer or a string; 1 and "1" are the same
// handle.
struct Handle {
  std::string_view text;                                    // decimal digits for an integer
  explicit operator bool() const { return !text.empty(); }  // false: none, or the empty name
  bool given() const { return text.data() != nullptr; }     // true for the empty name, too
  bool operator==(const Handle&) const = default;
};

struct RibBasis {
  std::string_view
      name;          // "bezier", "b-spline", "catmull-rom", "hermite", "power"; empty for an explicit matrix
  RibMatrix matrix;  // filled in either case
};

// Values of SubdivisionMesh tags. Tag i takes counts[2 i] ints and counts[2 i + 1] floats, and, when there
// are three counts per tag (countsPerTag), counts[3 i + 2] strings. The parser has checked that the sums fit.
struct SubdivisionTags {
  Strings names;
  int countsPerTag = 2;
  Ints counts;
  Ints ints;
  Floats floats;
  Strings strings;
};

// What is to be done with the requests of one branch of IfBegin / ElseIf / Else.
enum class Branch : uint8_t {
  Skip,  // not delivered
  Take,  // delivered; later branches of the same IfBegin are skipped without asking
  All    // delivered, and so are all other branches: for writers and validators
};

// The names of unused parameters document the interface.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter"

// One method per request. Arguments are as RI has them and checked for kind and number, not for range. Spans
// and views are valid during the call only. A method that is not overridden calls unhandled(). All methods
// are called from the thread that parses, in the order of the file.
class RibHandler {
 public:
  virtual ~RibHandler() = default;

  // Asked before each request is carried out. False: it is passed over, as if it did not stand there.
  virtual bool wants(std::string_view request, const Location& at) { return true; }

  // A request that the handler does not override.
  virtual void unhandled(std::string_view request, const Location& at) {}

  // Asked before the parser guesses (and warns about) an undeclared parameter; `name` is the request's first
  // string, such as a shader's name, or empty.
  virtual std::optional<Declaration> declarationOf(std::string_view request, std::string_view name,
                                                   std::string_view parameter) {
    return std::nullopt;
  }

  // Comments. `text` starts behind the '#' or '##'. Plain comments come only if wantsComments(); a comment
  // among a request's arguments comes behind that request.
  virtual bool wantsComments() const { return false; }
  virtual void comment(std::string_view text, const Location& at) {}
  virtual void structure(std::string_view text, const Location& at) {}

#define PATINA_RIB(method, request, ...) \
  virtual void method(__VA_ARGS__) { unhandled(request, at); }
#define PATINA_AT const Location& at
  // clang-format off

  // Frame structure
  PATINA_RIB(version, "version", float number, PATINA_AT)
  PATINA_RIB(declare, "Declare", std::string_view name, std::string_view declaration, PATINA_AT)
  PATINA_RIB(frameBegin, "FrameBegin", int number, PATINA_AT)
  PATINA_RIB(frameEnd, "FrameEnd", PATINA_AT)
  PATINA_RIB(worldBegin, "WorldBegin", PATINA_AT)
  PATINA_RIB(worldEnd, "WorldEnd", PATINA_AT)
  PATINA_RIB(errorHandler, "ErrorHandler", std::string_view style, PATINA_AT)

  // Options: camera
  PATINA_RIB(format, "Format", int xResolution, int yResolution, float pixelAspect, PATINA_AT)
  PATINA_RIB(frameAspectRatio, "FrameAspectRatio", float aspect, PATINA_AT)
  PATINA_RIB(screenWindow, "ScreenWindow", float left, float right, float bottom, float top, PATINA_AT)
  PATINA_RIB(cropWindow, "CropWindow", float xmin, float xmax, float ymin, float ymax, PATINA_AT)
  PATINA_RIB(projection, "Projection", std::string_view name, const ParamList& params, PATINA_AT)
  PATINA_RIB(clipping, "Clipping", float near, float far, PATINA_AT)
  PATINA_RIB(clippingPlane, "ClippingPlane", const std::array<float, 6>& pointAndNormal, PATINA_AT)
  // Without arguments in the file: a pinhole, fStop = infinity (RI_INFINITY, 1e38).
  PATINA_RIB(depthOfField, "DepthOfField", float fStop, float focalLength, float focalDistance, PATINA_AT)
  PATINA_RIB(shutter, "Shutter", float open, float close, PATINA_AT)
  PATINA_RIB(camera, "Camera", std::string_view name, const ParamList& params, PATINA_AT)

  // Options: image
  PATINA_RIB(pixelVariance, "PixelVariance", float variance, PATINA_AT)
  PATINA_RIB(pixelSamples, "PixelSamples", float x, float y, PATINA_AT)
  PATINA_RIB(pixelFilter, "PixelFilter", std::string_view name, float xWidth, float yWidth, PATINA_AT)
  PATINA_RIB(exposure, "Exposure", float gain, float gamma, PATINA_AT)
  PATINA_RIB(imager, "Imager", std::string_view name, const ParamList& params, PATINA_AT)
  PATINA_RIB(quantize, "Quantize", std::string_view type, int one, int min, int max, float dither, PATINA_AT)
  PATINA_RIB(display, "Display", std::string_view name, std::string_view type, std::string_view mode,
             const ParamList& params, PATINA_AT)
  PATINA_RIB(displayChannel, "DisplayChannel", std::string_view channel, const ParamList& params, PATINA_AT)

  // Options: renderer
  PATINA_RIB(hider, "Hider", std::string_view type, const ParamList& params, PATINA_AT)
  PATINA_RIB(colorSamples, "ColorSamples", Floats toRgb, Floats fromRgb, PATINA_AT)
  PATINA_RIB(relativeDetail, "RelativeDetail", float scale, PATINA_AT)
  PATINA_RIB(option, "Option", std::string_view name, const ParamList& params, PATINA_AT)
  PATINA_RIB(integrator, "Integrator", std::string_view name, Handle handle, const ParamList& params, PATINA_AT)
  PATINA_RIB(displayFilter, "DisplayFilter", std::string_view name, Handle handle, const ParamList& params, PATINA_AT)
  PATINA_RIB(sampleFilter, "SampleFilter", std::string_view name, Handle handle, const ParamList& params, PATINA_AT)

  // Attributes
  PATINA_RIB(attributeBegin, "AttributeBegin", PATINA_AT)
  PATINA_RIB(attributeEnd, "AttributeEnd", PATINA_AT)
  PATINA_RIB(attribute, "Attribute", std::string_view name, const ParamList& params, PATINA_AT)
  PATINA_RIB(color, "Color", Floats values, PATINA_AT)
  PATINA_RIB(opacity, "Opacity", Floats values, PATINA_AT)
  PATINA_RIB(textureCoordinates, "TextureCoordinates", const std::array<float, 8>& st, PATINA_AT)
  PATINA_RIB(lightSource, "LightSource", std::string_view name, Handle handle, const ParamList& params, PATINA_AT)
  PATINA_RIB(areaLightSource, "AreaLightSource", std::string_view name, Handle handle, const ParamList& params, PATINA_AT)
  PATINA_RIB(illuminate, "Illuminate", Handle light, bool on, PATINA_AT)
  PATINA_RIB(surface, "Surface", std::string_view name, const ParamList& params, PATINA_AT)
  PATINA_RIB(displacement, "Displacement", std::string_view name, const ParamList& params, PATINA_AT)
  PATINA_RIB(atmosphere, "Atmosphere", std::string_view name, const ParamList& params, PATINA_AT)
  PATINA_RIB(interior, "Interior", std::string_view name, const ParamList& params, PATINA_AT)
  PATINA_RIB(exterior, "Exterior", std::string_view name, const ParamList& params, PATINA_AT)
  PATINA_RIB(shaderLayer, "ShaderLayer", std::string_view type, std::string_view name, std::string_view layer,
             const ParamList& params, PATINA_AT)
  PATINA_RIB(connectShaderLayers, "ConnectShaderLayers", std::string_view type, std::string_view upstreamLayer,
             std::string_view upstreamOutput, std::string_view downstreamLayer, std::string_view downstreamInput, PATINA_AT)
  PATINA_RIB(bxdf, "Bxdf", std::string_view name, Handle handle, const ParamList& params, PATINA_AT)
  PATINA_RIB(pattern, "Pattern", std::string_view name, Handle handle, const ParamList& params, PATINA_AT)
  PATINA_RIB(displace, "Displace", std::string_view name, Handle handle, const ParamList& params, PATINA_AT)
  PATINA_RIB(light, "Light", std::string_view name, Handle handle, const ParamList& params, PATINA_AT)
  PATINA_RIB(lightFilter, "LightFilter", std::string_view name, Handle handle, const ParamList& params, PATINA_AT)
  PATINA_RIB(enableLightFilter, "EnableLightFilter", Handle light, Handle filter, bool on, PATINA_AT)
  PATINA_RIB(shadingRate, "ShadingRate", float size, PATINA_AT)
  PATINA_RIB(shadingInterpolation, "ShadingInterpolation", std::string_view type, PATINA_AT)
  PATINA_RIB(matte, "Matte", bool on, PATINA_AT)
  PATINA_RIB(bound, "Bound", const Bounds6& bound, PATINA_AT)
  PATINA_RIB(detail, "Detail", const Bounds6& bound, PATINA_AT)
  PATINA_RIB(detailRange, "DetailRange", float minVisible, float lowerTransition, float upperTransition,
             float maxVisible, PATINA_AT)
  PATINA_RIB(geometricApproximation, "GeometricApproximation", std::string_view type, float value, PATINA_AT)
  PATINA_RIB(geometricRepresentation, "GeometricRepresentation", std::string_view type, PATINA_AT)
  PATINA_RIB(orientation, "Orientation", std::string_view orientation, PATINA_AT)
  PATINA_RIB(reverseOrientation, "ReverseOrientation", PATINA_AT)
  PATINA_RIB(sides, "Sides", int sides, PATINA_AT)

  // Transformations (angles in degrees)
  PATINA_RIB(identity, "Identity", PATINA_AT)
  PATINA_RIB(transform, "Transform", const RibMatrix& matrix, PATINA_AT)
  PATINA_RIB(concatTransform, "ConcatTransform", const RibMatrix& matrix, PATINA_AT)
  PATINA_RIB(perspective, "Perspective", float fieldOfView, PATINA_AT)
  PATINA_RIB(translate, "Translate", float x, float y, float z, PATINA_AT)
  PATINA_RIB(rotate, "Rotate", float angle, float x, float y, float z, PATINA_AT)
  PATINA_RIB(scale, "Scale", float x, float y, float z, PATINA_AT)
  PATINA_RIB(skew, "Skew", float angle, const std::array<float, 6>& directions, PATINA_AT)
  PATINA_RIB(deformation, "Deformation", std::string_view name, const ParamList& params, PATINA_AT)
  PATINA_RIB(coordinateSystem, "CoordinateSystem", std::string_view name, PATINA_AT)
  PATINA_RIB(scopedCoordinateSystem, "ScopedCoordinateSystem", std::string_view name, PATINA_AT)
  PATINA_RIB(coordSysTransform, "CoordSysTransform", std::string_view name, PATINA_AT)
  PATINA_RIB(transformBegin, "TransformBegin", PATINA_AT)
  PATINA_RIB(transformEnd, "TransformEnd", PATINA_AT)

  // Primitives
  PATINA_RIB(polygon, "Polygon", const ParamList& params, PATINA_AT)
  PATINA_RIB(generalPolygon, "GeneralPolygon", Ints loopVertexCounts, const ParamList& params, PATINA_AT)
  PATINA_RIB(pointsPolygons, "PointsPolygons", Ints vertexCounts, Ints vertices, const ParamList& params, PATINA_AT)
  PATINA_RIB(pointsGeneralPolygons, "PointsGeneralPolygons", Ints loopCounts, Ints vertexCounts, Ints vertices,
             const ParamList& params, PATINA_AT)
  PATINA_RIB(basis, "Basis", const RibBasis& u, int uStep, const RibBasis& v, int vStep, PATINA_AT)
  PATINA_RIB(patch, "Patch", std::string_view type, const ParamList& params, PATINA_AT)
  PATINA_RIB(patchMesh, "PatchMesh", std::string_view type, int nu, std::string_view uWrap, int nv,
             std::string_view vWrap, const ParamList& params, PATINA_AT)
  PATINA_RIB(nuPatch, "NuPatch", int nu, int uOrder, Floats uKnots, float uMin, float uMax, int nv, int vOrder,
             Floats vKnots, float vMin, float vMax, const ParamList& params, PATINA_AT)
  PATINA_RIB(trimCurve, "TrimCurve", Ints curvesPerLoop, Ints orders, Floats knots, Floats mins, Floats maxs,
             Ints counts, Floats u, Floats v, Floats w, PATINA_AT)
  PATINA_RIB(subdivisionMesh, "SubdivisionMesh", std::string_view scheme, Ints vertexCounts, Ints vertices,
             const SubdivisionTags& tags, const ParamList& params, PATINA_AT)
  PATINA_RIB(hierarchicalSubdivisionMesh, "HierarchicalSubdivisionMesh", std::string_view scheme, Ints vertexCounts,
             Ints vertices, const SubdivisionTags& tags, const ParamList& params, PATINA_AT)
  PATINA_RIB(sphere, "Sphere", float radius, float zMin, float zMax, float thetaMax, const ParamList& params, PATINA_AT)
  PATINA_RIB(cone, "Cone", float height, float radius, float thetaMax, const ParamList& params, PATINA_AT)
  PATINA_RIB(cylinder, "Cylinder", float radius, float zMin, float zMax, float thetaMax, const ParamList& params, PATINA_AT)
  PATINA_RIB(hyperboloid, "Hyperboloid", const std::array<float, 3>& p1, const std::array<float, 3>& p2,
             float thetaMax, const ParamList& params, PATINA_AT)
  PATINA_RIB(paraboloid, "Paraboloid", float rMax, float zMin, float zMax, float thetaMax, const ParamList& params, PATINA_AT)
  PATINA_RIB(disk, "Disk", float height, float radius, float thetaMax, const ParamList& params, PATINA_AT)
  PATINA_RIB(torus, "Torus", float majorRadius, float minorRadius, float phiMin, float phiMax, float thetaMax,
             const ParamList& params, PATINA_AT)
  PATINA_RIB(points, "Points", const ParamList& params, PATINA_AT)
  PATINA_RIB(curves, "Curves", std::string_view type, Ints vertexCounts, std::string_view wrap,
             const ParamList& params, PATINA_AT)
  PATINA_RIB(blobby, "Blobby", int leaves, Ints codes, Floats floats, Strings strings, const ParamList& params, PATINA_AT)
  PATINA_RIB(volume, "Volume", std::string_view type, const Bounds6& bound, Ints dimensions, const ParamList& params, PATINA_AT)
  PATINA_RIB(procedural, "Procedural", std::string_view kind, Strings args, const Bounds6& bound, PATINA_AT)
  PATINA_RIB(procedural2, "Procedural2", std::string_view kind, std::string_view boundKind, const ParamList& params, PATINA_AT)
  PATINA_RIB(geometry, "Geometry", std::string_view type, const ParamList& params, PATINA_AT)

  // Solids, objects, motion
  PATINA_RIB(solidBegin, "SolidBegin", std::string_view operation, PATINA_AT)
  PATINA_RIB(solidEnd, "SolidEnd", PATINA_AT)
  PATINA_RIB(objectBegin, "ObjectBegin", Handle handle, const ParamList& params, PATINA_AT)
  PATINA_RIB(objectEnd, "ObjectEnd", PATINA_AT)
  PATINA_RIB(objectInstance, "ObjectInstance", Handle handle, const ParamList& params, PATINA_AT)
  PATINA_RIB(motionBegin, "MotionBegin", Floats times, PATINA_AT)
  PATINA_RIB(motionEnd, "MotionEnd", PATINA_AT)

  // External resources
  PATINA_RIB(makeTexture, "MakeTexture", std::string_view picture, std::string_view texture, std::string_view sWrap,
             std::string_view tWrap, std::string_view filter, float sWidth, float tWidth, const ParamList& params, PATINA_AT)
  PATINA_RIB(makeBump, "MakeBump", std::string_view picture, std::string_view texture, std::string_view sWrap,
             std::string_view tWrap, std::string_view filter, float sWidth, float tWidth, const ParamList& params, PATINA_AT)
  PATINA_RIB(makeLatLongEnvironment, "MakeLatLongEnvironment", std::string_view picture, std::string_view texture,
             std::string_view filter, float sWidth, float tWidth, const ParamList& params, PATINA_AT)
  // pictures: +x -x +y -y +z -z
  PATINA_RIB(makeCubeFaceEnvironment, "MakeCubeFaceEnvironment", const std::array<std::string_view, 6>& pictures,
             std::string_view texture, float fieldOfView, std::string_view filter, float sWidth, float tWidth,
             const ParamList& params, PATINA_AT)
  PATINA_RIB(makeShadow, "MakeShadow", std::string_view picture, std::string_view texture, const ParamList& params, PATINA_AT)
  PATINA_RIB(makeBrickMap, "MakeBrickMap", Strings pointClouds, std::string_view brickMap, const ParamList& params, PATINA_AT)
  PATINA_RIB(resource, "Resource", Handle handle, std::string_view type, const ParamList& params, PATINA_AT)
  PATINA_RIB(resourceBegin, "ResourceBegin", PATINA_AT)
  PATINA_RIB(resourceEnd, "ResourceEnd", PATINA_AT)
  PATINA_RIB(system, "System", std::string_view command, PATINA_AT)

  // Archives. The search path and the loop guard are the handler's; it calls RibParser::parseFile for what it finds.
  PATINA_RIB(readArchive, "ReadArchive", std::string_view name, const ParamList& params, PATINA_AT)
  PATINA_RIB(archiveEnd, "ArchiveEnd", PATINA_AT)

  // Edits of a running render
  PATINA_RIB(editBegin, "EditBegin", std::string_view name, const ParamList& params, PATINA_AT)
  PATINA_RIB(editEnd, "EditEnd", PATINA_AT)
  PATINA_RIB(editAttributeBegin, "EditAttributeBegin", std::string_view name, PATINA_AT)
  PATINA_RIB(editAttributeEnd, "EditAttributeEnd", PATINA_AT)
  PATINA_RIB(editWorldBegin, "EditWorldBegin", std::string_view name, const ParamList& params, PATINA_AT)
  PATINA_RIB(editWorldEnd, "EditWorldEnd", PATINA_AT)

  PATINA_RIB(ifEnd, "IfEnd", PATINA_AT)
  // clang-format on
#undef PATINA_AT
#undef PATINA_RIB

  // An inline archive begins. True: the parser does not deliver its requests but hands its text to archive()
  // in place of archiveEnd(); RibParser::parseArchive replays it. False: its requests follow, then
  // archiveEnd().
  virtual bool archiveBegin(std::string_view name, const ParamList& params, const Location& at) {
    return unhandled("ArchiveBegin", at), false;
  }
  virtual void archive(std::string_view name, InlineArchive archive, const Location& at) {
    unhandled("ArchiveEnd", at);
  }

  // Conditions are strings in the little language of PRMan ("$user:pass == 'beauty'"); the handler evaluates
  // them. elseIf and else_ are asked only while no branch of this IfBegin was taken. Inside a skipped branch
  // nothing is delivered and nothing but If nesting is checked.
  virtual Branch ifBegin(std::string_view condition, const ParamList& params, const Location& at) {
    return unhandled("IfBegin", at), Branch::All;
  }
  virtual Branch elseIf(std::string_view condition, const ParamList& params, const Location& at) {
    return unhandled("ElseIf", at), Branch::All;
  }
  virtual Branch else_(const Location& at) { return unhandled("Else", at), Branch::All; }
};

#pragma GCC diagnostic pop

}  // namespace patina
