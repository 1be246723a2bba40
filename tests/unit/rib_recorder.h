// SPDX-License-Identifier: Apache-2.0
// A RibHandler that writes each request down as one line of text, for tests to compare.
#pragma once

#include <string>
#include <vector>

#include <fmt/format.h>

#include "rib/parser.h"

namespace patina::test {

inline std::string text(float v) { return fmt::format("{}", v); }
inline std::string text(int v) { return fmt::format("{}", v); }
inline std::string text(bool v) { return v ? "true" : "false"; }
inline std::string text(std::string_view v) { return fmt::format("\"{}\"", v); }
inline std::string text(Handle v) { return fmt::format("<{}>", v.text); }
template <typename T>
std::string listText(const T& values) {
  std::string result = "[";
  for (const auto& v : values) result += (result.size() > 1 ? " " : "") + text(v);
  return result + "]";
}
inline std::string text(Floats v) { return listText(v); }
inline std::string text(Ints v) { return listText(v); }
inline std::string text(Strings v) { return listText(v); }
template <typename T, size_t N>
std::string text(const std::array<T, N>& v) {
  return listText(v);
}
inline std::string text(const RibBasis& v) { return v.name.empty() ? text(v.matrix) : text(v.name); }
inline std::string text(const SubdivisionTags& v) {
  return fmt::format("tags({}{}{}{}{})", text(v.names), text(v.counts), text(v.ints), text(v.floats),
                     text(v.strings));
}
inline std::string text(const Param& p) {
  std::string values = "[]";
  if (!p.floats.empty()) values = text(p.floats);
  if (!p.ints.empty()) values = text(p.ints);
  if (!p.strings.empty()) values = text(p.strings);
  return fmt::format("{}{}={}", toString(p.declaration), p.declaration.declared ? "" : "?", values);
}
inline std::string text(const ParamList& v) {
  std::string result = "{";
  for (const Param& p : v) result += (result.size() > 1 ? ", " : "") + text(p);
  return result + "}";
}

class Recorder : public RibHandler {
 public:
  std::vector<std::string> lines;
  std::vector<Location> places;
  bool comments = false;

  bool wantsComments() const override { return comments; }
  void comment(std::string_view t, const Location& at) override { log("#", t, at); }
  void structure(std::string_view t, const Location& at) override { log("##", t, at); }

  // One override per request: M(method, name, (parameters), arguments...).
#define M(method, name, parameters, ...) \
  void method parameters override { log(name, __VA_ARGS__); }
#define AT const Location& at
#define COMMA ,
#define S std::string_view
#define P const ParamList& p
  // clang-format off
  M(version, "version", (float n, AT), n, at)
  M(declare, "Declare", (S n, S d, AT), n, d, at)
  M(frameBegin, "FrameBegin", (int n, AT), n, at)
  M(frameEnd, "FrameEnd", (AT), at)
  M(worldBegin, "WorldBegin", (AT), at)
  M(worldEnd, "WorldEnd", (AT), at)
  M(errorHandler, "ErrorHandler", (S s, AT), s, at)
  M(format, "Format", (int x, int y, float a, AT), x, y, a, at)
  M(frameAspectRatio, "FrameAspectRatio", (float a, AT), a, at)
  M(screenWindow, "ScreenWindow", (float l, float r, float b, float t, AT), l, r, b, t, at)
  M(cropWindow, "CropWindow", (float l, float r, float b, float t, AT), l, r, b, t, at)
  M(projection, "Projection", (S n, P, AT), n, p, at)
  M(clipping, "Clipping", (float n, float f, AT), n, f, at)
  M(clippingPlane, "ClippingPlane", (const Bounds6& b, AT), b, at)
  M(depthOfField, "DepthOfField", (float a, float b, float c, AT), a, b, c, at)
  M(shutter, "Shutter", (float a, float b, AT), a, b, at)
  M(camera, "Camera", (S n, P, AT), n, p, at)
  M(pixelVariance, "PixelVariance", (float v, AT), v, at)
  M(pixelSamples, "PixelSamples", (float x, float y, AT), x, y, at)
  M(pixelFilter, "PixelFilter", (S n, float x, float y, AT), n, x, y, at)
  M(exposure, "Exposure", (float a, float b, AT), a, b, at)
  M(imager, "Imager", (S n, P, AT), n, p, at)
  M(quantize, "Quantize", (S n, int a, int b, int c, float d, AT), n, a, b, c, d, at)
  M(display, "Display", (S n, S t, S m, P, AT), n, t, m, p, at)
  M(displayChannel, "DisplayChannel", (S n, P, AT), n, p, at)
  M(hider, "Hider", (S n, P, AT), n, p, at)
  M(colorSamples, "ColorSamples", (Floats a, Floats b, AT), a, b, at)
  M(relativeDetail, "RelativeDetail", (float v, AT), v, at)
  M(option, "Option", (S n, P, AT), n, p, at)
  M(integrator, "Integrator", (S n, Handle h, P, AT), n, h, p, at)
  M(displayFilter, "DisplayFilter", (S n, Handle h, P, AT), n, h, p, at)
  M(sampleFilter, "SampleFilter", (S n, Handle h, P, AT), n, h, p, at)
  M(attributeBegin, "AttributeBegin", (AT), at)
  M(attributeEnd, "AttributeEnd", (AT), at)
  M(attribute, "Attribute", (S n, P, AT), n, p, at)
  M(color, "Color", (Floats v, AT), v, at)
  M(opacity, "Opacity", (Floats v, AT), v, at)
  M(textureCoordinates, "TextureCoordinates", (const std::array<float COMMA 8>& v, AT), v, at)
  M(lightSource, "LightSource", (S n, Handle h, P, AT), n, h, p, at)
  M(areaLightSource, "AreaLightSource", (S n, Handle h, P, AT), n, h, p, at)
  M(illuminate, "Illuminate", (Handle h, bool on, AT), h, on, at)
  M(surface, "Surface", (S n, P, AT), n, p, at)
  M(displacement, "Displacement", (S n, P, AT), n, p, at)
  M(atmosphere, "Atmosphere", (S n, P, AT), n, p, at)
  M(interior, "Interior", (S n, P, AT), n, p, at)
  M(exterior, "Exterior", (S n, P, AT), n, p, at)
  M(shaderLayer, "ShaderLayer", (S t, S n, S l, P, AT), t, n, l, p, at)
  M(connectShaderLayers, "ConnectShaderLayers", (S t, S a, S b, S c, S d, AT), t, a, b, c, d, at)
  M(bxdf, "Bxdf", (S n, Handle h, P, AT), n, h, p, at)
  M(pattern, "Pattern", (S n, Handle h, P, AT), n, h, p, at)
  M(displace, "Displace", (S n, Handle h, P, AT), n, h, p, at)
  M(light, "Light", (S n, Handle h, P, AT), n, h, p, at)
  M(lightFilter, "LightFilter", (S n, Handle h, P, AT), n, h, p, at)
  M(enableLightFilter, "EnableLightFilter", (Handle l, Handle f, bool on, AT), l, f, on, at)
  M(shadingRate, "ShadingRate", (float v, AT), v, at)
  M(shadingInterpolation, "ShadingInterpolation", (S n, AT), n, at)
  M(matte, "Matte", (bool on, AT), on, at)
  M(bound, "Bound", (const Bounds6& b, AT), b, at)
  M(detail, "Detail", (const Bounds6& b, AT), b, at)
  M(detailRange, "DetailRange", (float a, float b, float c, float d, AT), a, b, c, d, at)
  M(geometricApproximation, "GeometricApproximation", (S n, float v, AT), n, v, at)
  M(geometricRepresentation, "GeometricRepresentation", (S n, AT), n, at)
  M(orientation, "Orientation", (S n, AT), n, at)
  M(reverseOrientation, "ReverseOrientation", (AT), at)
  M(sides, "Sides", (int n, AT), n, at)
  M(identity, "Identity", (AT), at)
  M(transform, "Transform", (const RibMatrix& m, AT), m, at)
  M(concatTransform, "ConcatTransform", (const RibMatrix& m, AT), m, at)
  M(perspective, "Perspective", (float v, AT), v, at)
  M(translate, "Translate", (float x, float y, float z, AT), x, y, z, at)
  M(rotate, "Rotate", (float a, float x, float y, float z, AT), a, x, y, z, at)
  M(scale, "Scale", (float x, float y, float z, AT), x, y, z, at)
  M(skew, "Skew", (float a, const Bounds6& d, AT), a, d, at)
  M(deformation, "Deformation", (S n, P, AT), n, p, at)
  M(coordinateSystem, "CoordinateSystem", (S n, AT), n, at)
  M(scopedCoordinateSystem, "ScopedCoordinateSystem", (S n, AT), n, at)
  M(coordSysTransform, "CoordSysTransform", (S n, AT), n, at)
  M(transformBegin, "TransformBegin", (AT), at)
  M(transformEnd, "TransformEnd", (AT), at)
  M(polygon, "Polygon", (P, AT), p, at)
  M(generalPolygon, "GeneralPolygon", (Ints n, P, AT), n, p, at)
  M(pointsPolygons, "PointsPolygons", (Ints n, Ints v, P, AT), n, v, p, at)
  M(pointsGeneralPolygons, "PointsGeneralPolygons", (Ints l, Ints n, Ints v, P, AT), l, n, v, p, at)
  M(basis, "Basis", (const RibBasis& u, int us, const RibBasis& v, int vs, AT), u, us, v, vs, at)
  M(patch, "Patch", (S n, P, AT), n, p, at)
  M(patchMesh, "PatchMesh", (S t, int nu, S uw, int nv, S vw, P, AT), t, nu, uw, nv, vw, p, at)
  M(nuPatch, "NuPatch", (int nu, int uo, Floats uk, float u0, float u1, int nv, int vo, Floats vk, float v0, float v1, P, AT),
    nu, uo, uk, u0, u1, nv, vo, vk, v0, v1, p, at)
  M(trimCurve, "TrimCurve", (Ints c, Ints o, Floats k, Floats a, Floats b, Ints n, Floats u, Floats v, Floats w, AT),
    c, o, k, a, b, n, u, v, w, at)
  M(subdivisionMesh, "SubdivisionMesh", (S n, Ints c, Ints v, const SubdivisionTags& t, P, AT), n, c, v, t, p, at)
  M(hierarchicalSubdivisionMesh, "HierarchicalSubdivisionMesh", (S n, Ints c, Ints v, const SubdivisionTags& t, P, AT),
    n, c, v, t, p, at)
  M(sphere, "Sphere", (float a, float b, float c, float d, P, AT), a, b, c, d, p, at)
  M(cone, "Cone", (float a, float b, float c, P, AT), a, b, c, p, at)
  M(cylinder, "Cylinder", (float a, float b, float c, float d, P, AT), a, b, c, d, p, at)
  M(hyperboloid, "Hyperboloid", (const std::array<float COMMA 3>& a, const std::array<float COMMA 3>& b, float t, P, AT), a, b, t, p, at)
  M(paraboloid, "Paraboloid", (float a, float b, float c, float d, P, AT), a, b, c, d, p, at)
  M(disk, "Disk", (float a, float b, float c, P, AT), a, b, c, p, at)
  M(torus, "Torus", (float a, float b, float c, float d, float e, P, AT), a, b, c, d, e, p, at)
  M(points, "Points", (P, AT), p, at)
  M(curves, "Curves", (S t, Ints n, S w, P, AT), t, n, w, p, at)
  M(blobby, "Blobby", (int n, Ints c, Floats f, Strings s, P, AT), n, c, f, s, p, at)
  M(volume, "Volume", (S t, const Bounds6& b, Ints d, P, AT), t, b, d, p, at)
  M(procedural, "Procedural", (S k, Strings a, const Bounds6& b, AT), k, a, b, at)
  M(procedural2, "Procedural2", (S k, S b, P, AT), k, b, p, at)
  M(geometry, "Geometry", (S t, P, AT), t, p, at)
  M(solidBegin, "SolidBegin", (S o, AT), o, at)
  M(solidEnd, "SolidEnd", (AT), at)
  M(objectBegin, "ObjectBegin", (Handle h, P, AT), h, p, at)
  M(objectEnd, "ObjectEnd", (AT), at)
  M(objectInstance, "ObjectInstance", (Handle h, P, AT), h, p, at)
  M(motionBegin, "MotionBegin", (Floats t, AT), t, at)
  M(motionEnd, "MotionEnd", (AT), at)
  M(makeTexture, "MakeTexture", (S a, S b, S c, S d, S f, float x, float y, P, AT), a, b, c, d, f, x, y, p, at)
  M(makeBump, "MakeBump", (S a, S b, S c, S d, S f, float x, float y, P, AT), a, b, c, d, f, x, y, p, at)
  M(makeLatLongEnvironment, "MakeLatLongEnvironment", (S a, S b, S f, float x, float y, P, AT), a, b, f, x, y, p, at)
  M(makeCubeFaceEnvironment, "MakeCubeFaceEnvironment",
    (const std::array<S COMMA 6>& a, S t, float v, S f, float x, float y, P, AT), a, t, v, f, x, y, p, at)
  M(makeShadow, "MakeShadow", (S a, S b, P, AT), a, b, p, at)
  M(makeBrickMap, "MakeBrickMap", (Strings a, S b, P, AT), a, b, p, at)
  M(resource, "Resource", (Handle h, S t, P, AT), h, t, p, at)
  M(resourceBegin, "ResourceBegin", (AT), at)
  M(resourceEnd, "ResourceEnd", (AT), at)
  M(system, "System", (S c, AT), c, at)
  M(readArchive, "ReadArchive", (S n, P, AT), n, p, at)
  M(archiveEnd, "ArchiveEnd", (AT), at)
  M(editBegin, "EditBegin", (S n, P, AT), n, p, at)
  M(editEnd, "EditEnd", (AT), at)
  M(editAttributeBegin, "EditAttributeBegin", (S n, AT), n, at)
  M(editAttributeEnd, "EditAttributeEnd", (AT), at)
  M(editWorldBegin, "EditWorldBegin", (S n, P, AT), n, p, at)
  M(editWorldEnd, "EditWorldEnd", (AT), at)
  M(ifEnd, "IfEnd", (AT), at)
  // clang-format on
#undef M
#undef COMMA
#undef S
#undef P

  bool archiveBegin(std::string_view n, const ParamList& p, AT) override {
    log("ArchiveBegin", n, p, at);
    return false;
  }
  Branch ifBegin(std::string_view c, const ParamList& p, AT) override {
    log("IfBegin", c, p, at);
    return Branch::All;
  }
  Branch elseIf(std::string_view c, const ParamList& p, AT) override {
    log("ElseIf", c, p, at);
    return Branch::All;
  }
  Branch else_(AT) override {
    log("Else", at);
    return Branch::All;
  }
#undef AT

 protected:
  template <typename... A>
  void log(std::string_view name, const A&... arguments) {
    std::string line(name);
    (append(line, arguments), ...);
    lines.push_back(line);
  }

 private:
  void append(std::string&, const Location& at) { places.push_back(at); }
  template <typename T>
  void append(std::string& line, const T& value) {
    line += " " + text(value);
  }
};

// Parses `rib` as the file "t.rib" and keeps what came of it.
struct Parsed {
  Recorder recorder;
  std::vector<std::string> messages;
  ErrorHandler errors{[this](Severity, std::string_view m) { messages.emplace_back(m); }};
  bool complete = false;

  explicit Parsed(std::string_view rib, const ParserLimits& limits = {}) {
    complete = RibParser(recorder, errors, limits).parseMemory(rib, "t.rib");
  }
};

using Lines = std::vector<std::string>;
inline Lines requests(std::string_view rib) { return Parsed(rib).recorder.lines; }
inline Lines messages(std::string_view rib) { return Parsed(rib).messages; }

}  // namespace patina::test
