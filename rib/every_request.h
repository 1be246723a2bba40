// SPDX-License-Identifier: Apache-2.0
// A RibHandler for what treats all requests alike: writers, recorders, counters.
#pragma once

#include "rib/handler.h"

namespace patina {

/// Hands every request to one template method of `Derived`:
///   template <typename... A> void each(std::string_view request, const Location& at, const A&... arguments);
/// with the arguments as RibHandler's methods have them, in the order of the file. Archives are delivered
/// request by request, and so are all branches of IfBegin.
template <class Derived>
class EveryRequest : public RibHandler {
 public:
  // One override per request: M(method, name, (parameters), place, arguments...).
#define M(method, name, parameters, ...) \
  void method parameters override { derived().each(name, __VA_ARGS__); }
#define AT const Location& at
#define COMMA ,
#define S std::string_view
#define P const ParamList& p
  // clang-format off
  M(version, "version", (float n, AT), at, n)
  M(declare, "Declare", (S n, S d, AT), at, n, d)
  M(frameBegin, "FrameBegin", (int n, AT), at, n)
  M(frameEnd, "FrameEnd", (AT), at)
  M(worldBegin, "WorldBegin", (AT), at)
  M(worldEnd, "WorldEnd", (AT), at)
  M(errorHandler, "ErrorHandler", (S s, AT), at, s)
  M(format, "Format", (int x, int y, float a, AT), at, x, y, a)
  M(frameAspectRatio, "FrameAspectRatio", (float a, AT), at, a)
  M(screenWindow, "ScreenWindow", (float l, float r, float b, float t, AT), at, l, r, b, t)
  M(cropWindow, "CropWindow", (float l, float r, float b, float t, AT), at, l, r, b, t)
  M(projection, "Projection", (S n, P, AT), at, n, p)
  M(clipping, "Clipping", (float n, float f, AT), at, n, f)
  M(clippingPlane, "ClippingPlane", (const Bounds6& b, AT), at, b)
  M(depthOfField, "DepthOfField", (float a, float b, float c, AT), at, a, b, c)
  M(shutter, "Shutter", (float a, float b, AT), at, a, b)
  M(camera, "Camera", (S n, P, AT), at, n, p)
  M(pixelVariance, "PixelVariance", (float v, AT), at, v)
  M(pixelSamples, "PixelSamples", (float x, float y, AT), at, x, y)
  M(pixelFilter, "PixelFilter", (S n, float x, float y, AT), at, n, x, y)
  M(exposure, "Exposure", (float a, float b, AT), at, a, b)
  M(imager, "Imager", (S n, P, AT), at, n, p)
  M(quantize, "Quantize", (S n, int a, int b, int c, float d, AT), at, n, a, b, c, d)
  M(display, "Display", (S n, S t, S m, P, AT), at, n, t, m, p)
  M(displayChannel, "DisplayChannel", (S n, P, AT), at, n, p)
  M(hider, "Hider", (S n, P, AT), at, n, p)
  M(colorSamples, "ColorSamples", (Floats a, Floats b, AT), at, a, b)
  M(relativeDetail, "RelativeDetail", (float v, AT), at, v)
  M(option, "Option", (S n, P, AT), at, n, p)
  M(integrator, "Integrator", (S n, Handle h, P, AT), at, n, h, p)
  M(displayFilter, "DisplayFilter", (S n, Handle h, P, AT), at, n, h, p)
  M(sampleFilter, "SampleFilter", (S n, Handle h, P, AT), at, n, h, p)
  M(attributeBegin, "AttributeBegin", (AT), at)
  M(attributeEnd, "AttributeEnd", (AT), at)
  M(attribute, "Attribute", (S n, P, AT), at, n, p)
  M(color, "Color", (Floats v, AT), at, v)
  M(opacity, "Opacity", (Floats v, AT), at, v)
  M(textureCoordinates, "TextureCoordinates", (const std::array<float COMMA 8>& v, AT), at, v)
  M(lightSource, "LightSource", (S n, Handle h, P, AT), at, n, h, p)
  M(areaLightSource, "AreaLightSource", (S n, Handle h, P, AT), at, n, h, p)
  M(illuminate, "Illuminate", (Handle h, bool on, AT), at, h, on)
  M(surface, "Surface", (S n, P, AT), at, n, p)
  M(displacement, "Displacement", (S n, P, AT), at, n, p)
  M(atmosphere, "Atmosphere", (S n, P, AT), at, n, p)
  M(interior, "Interior", (S n, P, AT), at, n, p)
  M(exterior, "Exterior", (S n, P, AT), at, n, p)
  M(shaderLayer, "ShaderLayer", (S t, S n, S l, P, AT), at, t, n, l, p)
  M(connectShaderLayers, "ConnectShaderLayers", (S t, S a, S b, S c, S d, AT), at, t, a, b, c, d)
  M(bxdf, "Bxdf", (S n, Handle h, P, AT), at, n, h, p)
  M(pattern, "Pattern", (S n, Handle h, P, AT), at, n, h, p)
  M(displace, "Displace", (S n, Handle h, P, AT), at, n, h, p)
  M(light, "Light", (S n, Handle h, P, AT), at, n, h, p)
  M(lightFilter, "LightFilter", (S n, Handle h, P, AT), at, n, h, p)
  M(enableLightFilter, "EnableLightFilter", (Handle l, Handle f, bool on, AT), at, l, f, on)
  M(shadingRate, "ShadingRate", (float v, AT), at, v)
  M(shadingInterpolation, "ShadingInterpolation", (S n, AT), at, n)
  M(matte, "Matte", (bool on, AT), at, on)
  M(bound, "Bound", (const Bounds6& b, AT), at, b)
  M(detail, "Detail", (const Bounds6& b, AT), at, b)
  M(detailRange, "DetailRange", (float a, float b, float c, float d, AT), at, a, b, c, d)
  M(geometricApproximation, "GeometricApproximation", (S n, float v, AT), at, n, v)
  M(geometricRepresentation, "GeometricRepresentation", (S n, AT), at, n)
  M(orientation, "Orientation", (S n, AT), at, n)
  M(reverseOrientation, "ReverseOrientation", (AT), at)
  M(sides, "Sides", (int n, AT), at, n)
  M(identity, "Identity", (AT), at)
  M(transform, "Transform", (const RibMatrix& m, AT), at, m)
  M(concatTransform, "ConcatTransform", (const RibMatrix& m, AT), at, m)
  M(perspective, "Perspective", (float v, AT), at, v)
  M(translate, "Translate", (float x, float y, float z, AT), at, x, y, z)
  M(rotate, "Rotate", (float a, float x, float y, float z, AT), at, a, x, y, z)
  M(scale, "Scale", (float x, float y, float z, AT), at, x, y, z)
  M(skew, "Skew", (float a, const Bounds6& d, AT), at, a, d)
  M(deformation, "Deformation", (S n, P, AT), at, n, p)
  M(coordinateSystem, "CoordinateSystem", (S n, AT), at, n)
  M(scopedCoordinateSystem, "ScopedCoordinateSystem", (S n, AT), at, n)
  M(coordSysTransform, "CoordSysTransform", (S n, AT), at, n)
  M(transformBegin, "TransformBegin", (AT), at)
  M(transformEnd, "TransformEnd", (AT), at)
  M(polygon, "Polygon", (P, AT), at, p)
  M(generalPolygon, "GeneralPolygon", (Ints n, P, AT), at, n, p)
  M(pointsPolygons, "PointsPolygons", (Ints n, Ints v, P, AT), at, n, v, p)
  M(pointsGeneralPolygons, "PointsGeneralPolygons", (Ints l, Ints n, Ints v, P, AT), at, l, n, v, p)
  M(basis, "Basis", (const RibBasis& u, int us, const RibBasis& v, int vs, AT), at, u, us, v, vs)
  M(patch, "Patch", (S n, P, AT), at, n, p)
  M(patchMesh, "PatchMesh", (S t, int nu, S uw, int nv, S vw, P, AT), at, t, nu, uw, nv, vw, p)
  M(nuPatch, "NuPatch", (int nu, int uo, Floats uk, float u0, float u1, int nv, int vo, Floats vk, float v0, float v1, P, AT),
    at, nu, uo, uk, u0, u1, nv, vo, vk, v0, v1, p)
  M(trimCurve, "TrimCurve", (Ints c, Ints o, Floats k, Floats a, Floats b, Ints n, Floats u, Floats v, Floats w, AT),
    at, c, o, k, a, b, n, u, v, w)
  M(subdivisionMesh, "SubdivisionMesh", (S n, Ints c, Ints v, const SubdivisionTags& t, P, AT), at, n, c, v, t, p)
  M(hierarchicalSubdivisionMesh, "HierarchicalSubdivisionMesh", (S n, Ints c, Ints v, const SubdivisionTags& t, P, AT),
    at, n, c, v, t, p)
  M(sphere, "Sphere", (float a, float b, float c, float d, P, AT), at, a, b, c, d, p)
  M(cone, "Cone", (float a, float b, float c, P, AT), at, a, b, c, p)
  M(cylinder, "Cylinder", (float a, float b, float c, float d, P, AT), at, a, b, c, d, p)
  M(hyperboloid, "Hyperboloid", (const std::array<float COMMA 3>& a, const std::array<float COMMA 3>& b, float t, P, AT), at, a, b, t, p)
  M(paraboloid, "Paraboloid", (float a, float b, float c, float d, P, AT), at, a, b, c, d, p)
  M(disk, "Disk", (float a, float b, float c, P, AT), at, a, b, c, p)
  M(torus, "Torus", (float a, float b, float c, float d, float e, P, AT), at, a, b, c, d, e, p)
  M(points, "Points", (P, AT), at, p)
  M(curves, "Curves", (S t, Ints n, S w, P, AT), at, t, n, w, p)
  M(blobby, "Blobby", (int n, Ints c, Floats f, Strings s, P, AT), at, n, c, f, s, p)
  M(volume, "Volume", (S t, const Bounds6& b, Ints d, P, AT), at, t, b, d, p)
  M(procedural, "Procedural", (S k, Strings a, const Bounds6& b, AT), at, k, a, b)
  M(procedural2, "Procedural2", (S k, S b, P, AT), at, k, b, p)
  M(geometry, "Geometry", (S t, P, AT), at, t, p)
  M(solidBegin, "SolidBegin", (S o, AT), at, o)
  M(solidEnd, "SolidEnd", (AT), at)
  M(objectBegin, "ObjectBegin", (Handle h, P, AT), at, h, p)
  M(objectEnd, "ObjectEnd", (AT), at)
  M(objectInstance, "ObjectInstance", (Handle h, P, AT), at, h, p)
  M(motionBegin, "MotionBegin", (Floats t, AT), at, t)
  M(motionEnd, "MotionEnd", (AT), at)
  M(makeTexture, "MakeTexture", (S a, S b, S c, S d, S f, float x, float y, P, AT), at, a, b, c, d, f, x, y, p)
  M(makeBump, "MakeBump", (S a, S b, S c, S d, S f, float x, float y, P, AT), at, a, b, c, d, f, x, y, p)
  M(makeLatLongEnvironment, "MakeLatLongEnvironment", (S a, S b, S f, float x, float y, P, AT), at, a, b, f, x, y, p)
  M(makeCubeFaceEnvironment, "MakeCubeFaceEnvironment",
    (const std::array<S COMMA 6>& a, S t, float v, S f, float x, float y, P, AT), at, a, t, v, f, x, y, p)
  M(makeShadow, "MakeShadow", (S a, S b, P, AT), at, a, b, p)
  M(makeBrickMap, "MakeBrickMap", (Strings a, S b, P, AT), at, a, b, p)
  M(resource, "Resource", (Handle h, S t, P, AT), at, h, t, p)
  M(resourceBegin, "ResourceBegin", (AT), at)
  M(resourceEnd, "ResourceEnd", (AT), at)
  M(system, "System", (S c, AT), at, c)
  M(readArchive, "ReadArchive", (S n, P, AT), at, n, p)
  M(archiveEnd, "ArchiveEnd", (AT), at)
  M(editBegin, "EditBegin", (S n, P, AT), at, n, p)
  M(editEnd, "EditEnd", (AT), at)
  M(editAttributeBegin, "EditAttributeBegin", (S n, AT), at, n)
  M(editAttributeEnd, "EditAttributeEnd", (AT), at)
  M(editWorldBegin, "EditWorldBegin", (S n, P, AT), at, n, p)
  M(editWorldEnd, "EditWorldEnd", (AT), at)
  M(ifEnd, "IfEnd", (AT), at)
  // clang-format on
#undef M
#undef COMMA
#undef S
#undef P

  bool archiveBegin(std::string_view n, const ParamList& p, AT) override {
    derived().each("ArchiveBegin", at, n, p);
    return false;
  }
  Branch ifBegin(std::string_view c, const ParamList& p, AT) override {
    derived().each("IfBegin", at, c, p);
    return Branch::All;
  }
  Branch elseIf(std::string_view c, const ParamList& p, AT) override {
    derived().each("ElseIf", at, c, p);
    return Branch::All;
  }
  Branch else_(AT) override {
    derived().each("Else", at);
    return Branch::All;
  }
#undef AT

 private:
  Derived& derived() { return static_cast<Derived&>(*this); }
};

}  // namespace patina
