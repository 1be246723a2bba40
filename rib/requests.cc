// SPDX-License-Identifier: Apache-2.0
// The requests of RI 3.2 and of later renderers: their names, their arguments, and the handler's method for
// each.
#include "rib/requests.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <tuple>
#include <vector>

#include <fmt/format.h>

#include "rib/arguments.h"

namespace patina {
namespace {

constexpr float kInfinity = 1e38f;  // RI_INFINITY

// The next argument, as the handler's method declares it.
template <typename T>
struct Take;

// clang-format off
template <> struct Take<float> { static float from(Arguments& a) { return a.number(); } };
template <> struct Take<int> { static int from(Arguments& a) { return a.integer(); } };
template <> struct Take<bool> { static bool from(Arguments& a) { return a.boolean(); } };
template <> struct Take<std::string_view> { static std::string_view from(Arguments& a) { return a.string(); } };
template <> struct Take<Floats> { static Floats from(Arguments& a) { return a.floats(); } };
template <> struct Take<Ints> { static Ints from(Arguments& a) { return a.ints(); } };
template <> struct Take<Strings> { static Strings from(Arguments& a) { return a.strings(); } };
template <> struct Take<Handle> { static Handle from(Arguments& a) { return a.handle(); } };
template <> struct Take<ParamList> { static const ParamList& from(Arguments& a) { return a.params(); } };
template <> struct Take<Location> { static const Location& from(Arguments& a) { return a.at(); } };
template <size_t N> struct Take<std::array<float, N>> { static auto from(Arguments& a) { return a.numbers<N>(); } };
template <size_t N> struct Take<std::array<std::string_view, N>> {
  static auto from(Arguments& a) {
    std::array<std::string_view, N> result;
    for (auto& text : result) text = a.string();
    return result;
  }
};
// clang-format on

template <typename T>
using Taken = decltype(Take<std::remove_cvref_t<T>>::from(std::declval<Arguments&>()));

template <typename... A>
void invoke(Arguments& arguments, void (RibHandler::*method)(A...)) {
  // Braces: the arguments are taken from left to right.
  const std::tuple<Taken<A>...> values{Take<std::remove_cvref_t<A>>::from(arguments)...};
  if (!arguments.finish()) return;
  std::apply([&](const auto&... value) { (arguments.handler().*method)(value...); }, values);
}

// A request whose arguments are those of its method.
template <auto Method>
void plain(Arguments& arguments) {
  invoke(arguments, Method);
}

// "name" [handle] parameters, the handle optional.
template <auto Method>
void node(Arguments& a) {
  const std::string_view name = a.string();
  const Handle handle = a.optionalHandle();
  const ParamList& params = a.params();
  if (a.finish()) (a.handler().*Method)(name, handle, params, a.at());
}

void declare(Arguments& a) {
  const std::string_view name = a.string(), declaration = a.string();
  if (!a.finish()) return;
  if (!a.session().dictionary().declare(name, declaration)) {
    a.warn(RiError::BadToken, a.at(),
           fmt::format("\"{}\" \"{}\" is not a declaration ([class] type[n]) and is ignored", name,
                       declaration));
    return;
  }
  a.handler().declare(name, declaration, a.at());
}

void errorHandler(Arguments& a) {
  const std::string_view style = a.string();
  if (!a.finish()) return;
  ErrorHandler& errors = a.session().errors();
  if (style == "ignore") {
    errors.setStyle(ErrorStyle::Ignore);
  } else if (style == "print") {
    errors.setStyle(ErrorStyle::Print);
  } else if (style == "abort") {
    errors.setStyle(ErrorStyle::Abort);
  } else {
    a.fail(RiError::BadArgument, fmt::format("unknown style \"{}\" (ignore, print or abort)", style));
    return;
  }
  a.handler().errorHandler(style, a.at());
}

// Without these, the blocks that they open would be left unbalanced: what is missing is reported and made up.
void frameBegin(Arguments& a) {
  const bool given = a.nextIsNumber();
  if (!given) a.warn(RiError::BadArgument, a.at(), "no frame number; 0 is used");
  const int number = given ? a.integer() : 0;
  if (a.finish()) a.handler().frameBegin(number, a.at());
}

template <auto Method>
void object(Arguments& a) {
  const bool given = a.more();
  if (!given) a.warn(RiError::BadHandle, a.at(), "no handle; the empty name is used");
  const Handle handle = given ? a.handle() : Handle();
  const ParamList& params = a.params();
  if (a.finish()) (a.handler().*Method)(handle, params, a.at());
}

// A missing pixel aspect is, as a negative one, the default.
void format(Arguments& a) {
  const int x = a.integer(), y = a.integer();
  const float aspect = a.more() ? a.number() : -1.0f;
  if (a.finish()) a.handler().format(x, y, aspect, a.at());
}

void depthOfField(Arguments& a) {
  const bool pinhole = !a.more();
  const float fStop = pinhole ? kInfinity : a.number();
  const float length = pinhole ? 0.0f : a.number(), distance = pinhole ? 0.0f : a.number();
  if (a.finish()) a.handler().depthOfField(fStop, length, distance, a.at());
}

// The matrices of RI 3.2: points of the curve are (t^3 t^2 t 1) times matrix times control points.
constexpr struct {
  std::string_view name;
  RibMatrix matrix;
} kBases[] = {
    {"bezier", {-1, 3, -3, 1, 3, -6, 3, 0, -3, 3, 0, 0, 1, 0, 0, 0}},
    {"b-spline",
     {-1.0f / 6, 3.0f / 6, -3.0f / 6, 1.0f / 6, 3.0f / 6, -1, 3.0f / 6, 0, -3.0f / 6, 0, 3.0f / 6, 0,
      1.0f / 6, 4.0f / 6, 1.0f / 6, 0}},
    {"catmull-rom", {-0.5f, 1.5f, -1.5f, 0.5f, 1, -2.5f, 2, -0.5f, -0.5f, 0, 0.5f, 0, 0, 1, 0, 0}},
    {"hermite", {2, 1, -2, 1, -3, -2, 3, -1, 0, 1, 0, 0, 1, 0, 0, 0}},
    {"power", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}},
};

RibBasis takeBasis(Arguments& a) {
  if (a.nextIsNumber()) return {{}, a.numbers<16>()};
  RibBasis result{a.string(), {}};
  for (const auto& [name, matrix] : kBases) {
    if (name == result.name) return {result.name, matrix};
  }
  a.fail(RiError::BadBasis,
         fmt::format("unknown basis \"{}\" (bezier, b-spline, catmull-rom, hermite, power)", result.name));
  return result;
}

void basis(Arguments& a) {
  const RibBasis u = takeBasis(a);
  const int uStep = a.integer();
  const RibBasis v = takeBasis(a);
  const int vStep = a.integer();
  if (a.finish()) a.handler().basis(u, uStep, v, vStep, a.at());
}

// The tag arrays, which many files leave out. Tags whose values do not add up are left out too.
SubdivisionTags takeTags(Arguments& a, int countsPerTag) {
  SubdivisionTags tags;
  tags.countsPerTag = countsPerTag;
  if (!a.nextIsArray()) return tags;
  tags.names = a.strings();
  tags.counts = a.ints();
  tags.ints = a.ints();
  tags.floats = a.floats();
  if (countsPerTag == 3) tags.strings = a.strings();
  if (!a.ok()) return tags;

  const auto perTag = static_cast<size_t>(countsPerTag);
  std::array<uint64_t, 3> sums{};
  bool fits = tags.counts.size() == tags.names.size() * perTag;
  for (size_t i = 0; i < tags.counts.size(); ++i) {
    fits = fits && tags.counts[i] >= 0;
    sums[i % perTag] += static_cast<uint64_t>(std::max(tags.counts[i], 0));
  }
  fits =
      fits && sums[0] == tags.ints.size() && sums[1] == tags.floats.size() && sums[2] == tags.strings.size();
  if (fits) return tags;
  a.warn(RiError::Consistency, a.at(), "the tags' values do not match their counts; the tags are ignored");
  SubdivisionTags none;
  none.countsPerTag = countsPerTag;
  return none;
}

template <auto Method, int CountsPerTag>
void subdivision(Arguments& a) {
  const std::string_view scheme = a.string();
  const Ints counts = a.ints(), vertices = a.ints();
  const SubdivisionTags tags = takeTags(a, CountsPerTag);
  const ParamList& params = a.params();
  if (a.finish()) (a.handler().*Method)(scheme, counts, vertices, tags, params, a.at());
}

void blobby(Arguments& a) {
  const int leaves = a.integer();
  const Ints codes = a.ints();
  const Floats floats = a.floats();
  const Strings strings = a.nextIsArray() ? a.strings() : Strings();
  const ParamList& params = a.params();
  if (a.finish()) a.handler().blobby(leaves, codes, floats, strings, params, a.at());
}

void archiveBegin(Arguments& a) {
  const std::string_view name = a.string();
  const ParamList& params = a.params();
  if (a.finish()) a.session().archiveBegin(name, params);
}

void ifBegin(Arguments& a) {
  const std::string_view test = a.string();
  const ParamList& params = a.params();
  const bool valid = a.finish();
  a.session().ifBegin(test, params, valid);
}

void elseIf(Arguments& a) {
  const std::string_view test = a.string();
  const ParamList& params = a.params();
  const bool valid = a.finish();
  a.session().elseIf(test, params, valid);
}

void otherwise(Arguments& a) { a.session().otherwise(); }
void ifEnd(Arguments& a) { a.session().ifEnd(); }

#define PATINA_PLAIN(method) plain<&RibHandler::method>
#define PATINA_NODE(method) node<&RibHandler::method>

// clang-format off
constexpr RibRequest kRequests[] = {
    {"ArchiveBegin", "name ...", archiveBegin},
    {"ArchiveEnd", "", PATINA_PLAIN(archiveEnd)},
    {"AreaLightSource", "name [handle] ...", PATINA_NODE(areaLightSource)},
    {"Atmosphere", "name ...", PATINA_PLAIN(atmosphere)},
    {"Attribute", "name ...", PATINA_PLAIN(attribute)},
    {"AttributeBegin", "", PATINA_PLAIN(attributeBegin)},
    {"AttributeEnd", "", PATINA_PLAIN(attributeEnd)},
    {"Basis", "ubasis ustep vbasis vstep", basis},
    {"Blobby", "leaves codes floats strings ...", blobby},
    {"Bound", "xmin xmax ymin ymax zmin zmax", PATINA_PLAIN(bound)},
    {"Bxdf", "name [handle] ...", PATINA_NODE(bxdf)},
    {"Camera", "name ...", PATINA_PLAIN(camera)},
    {"Clipping", "near far", PATINA_PLAIN(clipping)},
    {"ClippingPlane", "x y z nx ny nz", PATINA_PLAIN(clippingPlane)},
    {"Color", "color", PATINA_PLAIN(color)},
    {"ColorSamples", "nrgb rgbn", PATINA_PLAIN(colorSamples)},
    {"ConcatTransform", "matrix", PATINA_PLAIN(concatTransform)},
    {"Cone", "height radius thetamax ...", PATINA_PLAIN(cone)},
    {"ConnectShaderLayers", "type layer1 output layer2 input", PATINA_PLAIN(connectShaderLayers)},
    {"CoordSysTransform", "name", PATINA_PLAIN(coordSysTransform)},
    {"CoordinateSystem", "name", PATINA_PLAIN(coordinateSystem)},
    {"CropWindow", "xmin xmax ymin ymax", PATINA_PLAIN(cropWindow)},
    {"Curves", "type nvertices wrap ...", PATINA_PLAIN(curves)},
    {"Cylinder", "radius zmin zmax thetamax ...", PATINA_PLAIN(cylinder)},
    {"Declare", "name declaration", declare},
    {"Deformation", "name ...", PATINA_PLAIN(deformation)},
    {"DepthOfField", "[fstop focallength focaldistance]", depthOfField},
    {"Detail", "xmin xmax ymin ymax zmin zmax", PATINA_PLAIN(detail)},
    {"DetailRange", "minvisible lowertransition uppertransition maxvisible", PATINA_PLAIN(detailRange)},
    {"Disk", "height radius thetamax ...", PATINA_PLAIN(disk)},
    {"Displace", "name [handle] ...", PATINA_NODE(displace)},
    {"Displacement", "name ...", PATINA_PLAIN(displacement)},
    {"Display", "name type mode ...", PATINA_PLAIN(display)},
    {"DisplayChannel", "channel ...", PATINA_PLAIN(displayChannel)},
    {"DisplayFilter", "name [handle] ...", PATINA_NODE(displayFilter)},
    {"EditAttributeBegin", "name", PATINA_PLAIN(editAttributeBegin)},
    {"EditAttributeEnd", "", PATINA_PLAIN(editAttributeEnd)},
    {"EditBegin", "name ...", PATINA_PLAIN(editBegin)},
    {"EditEnd", "", PATINA_PLAIN(editEnd)},
    {"EditWorldBegin", "name ...", PATINA_PLAIN(editWorldBegin)},
    {"EditWorldEnd", "", PATINA_PLAIN(editWorldEnd)},
    {"Else", "", otherwise},
    {"ElseIf", "condition ...", elseIf},
    {"EnableLightFilter", "light filter onoff", PATINA_PLAIN(enableLightFilter)},
    {"ErrorHandler", "style", errorHandler},
    {"Exposure", "gain gamma", PATINA_PLAIN(exposure)},
    {"Exterior", "name ...", PATINA_PLAIN(exterior)},
    {"Format", "xresolution yresolution pixelaspect", format},
    {"FrameAspectRatio", "ratio", PATINA_PLAIN(frameAspectRatio)},
    {"FrameBegin", "number", frameBegin},
    {"FrameEnd", "", PATINA_PLAIN(frameEnd)},
    {"GeneralPolygon", "nvertices ...", PATINA_PLAIN(generalPolygon)},
    {"GeometricApproximation", "type value", PATINA_PLAIN(geometricApproximation)},
    {"GeometricRepresentation", "type", PATINA_PLAIN(geometricRepresentation)},
    {"Geometry", "type ...", PATINA_PLAIN(geometry)},
    {"Hider", "type ...", PATINA_PLAIN(hider)},
    {"HierarchicalSubdivisionMesh", "scheme nvertices vertices [tags nargs intargs floatargs stringargs] ...",
     subdivision<&RibHandler::hierarchicalSubdivisionMesh, 3>},
    {"Hyperboloid", "x1 y1 z1 x2 y2 z2 thetamax ...", PATINA_PLAIN(hyperboloid)},
    {"Identity", "", PATINA_PLAIN(identity)},
    {"IfBegin", "condition ...", ifBegin},
    {"IfEnd", "", ifEnd},
    {"Illuminate", "handle onoff", PATINA_PLAIN(illuminate)},
    {"Imager", "name ...", PATINA_PLAIN(imager)},
    {"Integrator", "name [handle] ...", PATINA_NODE(integrator)},
    {"Interior", "name ...", PATINA_PLAIN(interior)},
    {"Light", "name [handle] ...", PATINA_NODE(light)},
    {"LightFilter", "name [handle] ...", PATINA_NODE(lightFilter)},
    {"LightSource", "name [handle] ...", PATINA_NODE(lightSource)},
    {"MakeBrickMap", "pointclouds brickmap ...", PATINA_PLAIN(makeBrickMap)},
    {"MakeBump", "picture texture swrap twrap filter swidth twidth ...", PATINA_PLAIN(makeBump)},
    {"MakeCubeFaceEnvironment", "px nx py ny pz nz texture fov filter swidth twidth ...",
     PATINA_PLAIN(makeCubeFaceEnvironment)},
    {"MakeLatLongEnvironment", "picture texture filter swidth twidth ...", PATINA_PLAIN(makeLatLongEnvironment)},
    {"MakeShadow", "picture texture ...", PATINA_PLAIN(makeShadow)},
    {"MakeTexture", "picture texture swrap twrap filter swidth twidth ...", PATINA_PLAIN(makeTexture)},
    {"Matte", "onoff", PATINA_PLAIN(matte)},
    {"MotionBegin", "times", PATINA_PLAIN(motionBegin)},
    {"MotionEnd", "", PATINA_PLAIN(motionEnd)},
    {"NuPatch", "nu uorder uknot umin umax nv vorder vknot vmin vmax ...", PATINA_PLAIN(nuPatch)},
    {"ObjectBegin", "handle ...", object<&RibHandler::objectBegin>},
    {"ObjectEnd", "", PATINA_PLAIN(objectEnd)},
    {"ObjectInstance", "handle ...", object<&RibHandler::objectInstance>},
    {"Opacity", "color", PATINA_PLAIN(opacity)},
    {"Option", "name ...", PATINA_PLAIN(option)},
    {"Orientation", "orientation", PATINA_PLAIN(orientation)},
    {"Paraboloid", "rmax zmin zmax thetamax ...", PATINA_PLAIN(paraboloid)},
    {"Patch", "type ...", PATINA_PLAIN(patch)},
    {"PatchMesh", "type nu uwrap nv vwrap ...", PATINA_PLAIN(patchMesh)},
    {"Pattern", "name [handle] ...", PATINA_NODE(pattern)},
    {"Perspective", "fov", PATINA_PLAIN(perspective)},
    {"PixelFilter", "name xwidth ywidth", PATINA_PLAIN(pixelFilter)},
    {"PixelSamples", "x y", PATINA_PLAIN(pixelSamples)},
    {"PixelVariance", "variance", PATINA_PLAIN(pixelVariance)},
    {"Points", "...", PATINA_PLAIN(points)},
    {"PointsGeneralPolygons", "nloops nvertices vertices ...", PATINA_PLAIN(pointsGeneralPolygons)},
    {"PointsPolygons", "nvertices vertices ...", PATINA_PLAIN(pointsPolygons)},
    {"Polygon", "...", PATINA_PLAIN(polygon)},
    {"Procedural", "name arguments bound", PATINA_PLAIN(procedural)},
    {"Procedural2", "name boundname ...", PATINA_PLAIN(procedural2)},
    {"Projection", "name ...", PATINA_PLAIN(projection)},
    {"Quantize", "type one min max dither", PATINA_PLAIN(quantize)},
    {"ReadArchive", "name ...", PATINA_PLAIN(readArchive)},
    {"RelativeDetail", "scale", PATINA_PLAIN(relativeDetail)},
    {"Resource", "handle type ...", PATINA_PLAIN(resource)},
    {"ResourceBegin", "", PATINA_PLAIN(resourceBegin)},
    {"ResourceEnd", "", PATINA_PLAIN(resourceEnd)},
    {"ReverseOrientation", "", PATINA_PLAIN(reverseOrientation)},
    {"Rotate", "angle x y z", PATINA_PLAIN(rotate)},
    {"SampleFilter", "name [handle] ...", PATINA_NODE(sampleFilter)},
    {"Scale", "x y z", PATINA_PLAIN(scale)},
    {"ScopedCoordinateSystem", "name", PATINA_PLAIN(scopedCoordinateSystem)},
    {"ScreenWindow", "left right bottom top", PATINA_PLAIN(screenWindow)},
    {"ShaderLayer", "type name layer ...", PATINA_PLAIN(shaderLayer)},
    {"ShadingInterpolation", "type", PATINA_PLAIN(shadingInterpolation)},
    {"ShadingRate", "size", PATINA_PLAIN(shadingRate)},
    {"Shutter", "open close", PATINA_PLAIN(shutter)},
    {"Sides", "sides", PATINA_PLAIN(sides)},
    {"Skew", "angle x1 y1 z1 x2 y2 z2", PATINA_PLAIN(skew)},
    {"SolidBegin", "operation", PATINA_PLAIN(solidBegin)},
    {"SolidEnd", "", PATINA_PLAIN(solidEnd)},
    {"Sphere", "radius zmin zmax thetamax ...", PATINA_PLAIN(sphere)},
    {"SubdivisionMesh", "scheme nvertices vertices [tags nargs intargs floatargs] ...",
     subdivision<&RibHandler::subdivisionMesh, 2>},
    {"Surface", "name ...", PATINA_PLAIN(surface)},
    {"System", "command", PATINA_PLAIN(system)},
    {"TextureCoordinates", "s1 t1 s2 t2 s3 t3 s4 t4", PATINA_PLAIN(textureCoordinates)},
    {"Torus", "majorradius minorradius phimin phimax thetamax ...", PATINA_PLAIN(torus)},
    {"Transform", "matrix", PATINA_PLAIN(transform)},
    {"TransformBegin", "", PATINA_PLAIN(transformBegin)},
    {"TransformEnd", "", PATINA_PLAIN(transformEnd)},
    {"Translate", "dx dy dz", PATINA_PLAIN(translate)},
    {"TrimCurve", "ncurves order knot min max n u v w", PATINA_PLAIN(trimCurve)},
    {"Volume", "type bound dimensions ...", PATINA_PLAIN(volume)},
    {"WorldBegin", "", PATINA_PLAIN(worldBegin)},
    {"WorldEnd", "", PATINA_PLAIN(worldEnd)},
    {"version", "number", PATINA_PLAIN(version)},
};
// clang-format on

#undef PATINA_PLAIN
#undef PATINA_NODE

// Open addressing over kRequests, made by the compiler: a request is looked up for each few bytes of a file.
class Index {
 public:
  constexpr Index() {
    for (const RibRequest& request : kRequests) {
      size_t i = slot(request.name);
      while (slots_[i]) i = (i + 1) % kSlots;
      slots_[i] = &request;
    }
  }
  const RibRequest* find(std::string_view name) const {
    for (size_t i = slot(name); slots_[i]; i = (i + 1) % kSlots) {
      if (slots_[i]->name == name) return slots_[i];
    }
    return nullptr;
  }

 private:
  static constexpr size_t kSlots = 1024;
  static_assert(std::size(kRequests) * 4 < kSlots);
  // Of the length and five of the letters, which tell nearly all requests apart.
  static constexpr size_t slot(std::string_view name) {
    const size_t n = name.size();
    if (n == 0) return 0;
    uint32_t hash = static_cast<uint32_t>(n);
    for (const size_t i : {size_t{0}, n / 4, n / 2, n - 1 - n / 4, n - 1})
      hash = hash * 0x9e3779b1u + static_cast<unsigned char>(name[i]);
    return (hash * 0x9e3779b1u >> 16) % kSlots;
  }
  std::array<const RibRequest*, kSlots> slots_{};
};
constexpr Index kIndex;

}  // namespace

std::span<const RibRequest> ribRequests() { return kRequests; }

const RibRequest* findRibRequest(std::string_view name) { return kIndex.find(name); }

std::string_view nearestRibRequest(std::string_view name) {
  std::array<std::string_view, std::size(kRequests)> names;
  std::transform(std::begin(kRequests), std::end(kRequests), names.begin(),
                 [](const RibRequest& request) { return request.name; });
  return nearestName(name, names);
}

}  // namespace patina
