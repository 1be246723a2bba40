// SPDX-License-Identifier: Apache-2.0
// Every request of the table, parsed once: the expected lines are RI 3.2's argument lists (and PRMan's later
// ones).
#include <gtest/gtest.h>

#include <set>

#include "rib/requests.h"
#include "rib_recorder.h"

namespace patina::test {
namespace {

struct Case {
  const char* rib;
  const char* line;
};

const Case kCases[] = {
    {"version 3.04", "version 3.04"},
    {"Declare \"x\" \"uniform float\"", "Declare \"x\" \"uniform float\""},
    {"FrameBegin 3", "FrameBegin 3"},
    {"FrameEnd", "FrameEnd"},
    {"WorldBegin", "WorldBegin"},
    {"WorldEnd", "WorldEnd"},
    {"ErrorHandler \"print\"", "ErrorHandler \"print\""},
    {"Format 640 480 -1", "Format 640 480 -1"},
    {"FrameAspectRatio 1.5", "FrameAspectRatio 1.5"},
    {"ScreenWindow -1 1 -2 2", "ScreenWindow -1 1 -2 2"},
    {"CropWindow 0 .5 0 1", "CropWindow 0 0.5 0 1"},
    {"Projection \"perspective\" \"fov\" [40]", "Projection \"perspective\" {uniform float fov=[40]}"},
    {"Clipping 0.1 1e4", "Clipping 0.1 10000"},
    {"ClippingPlane 1 2 3 0 0 1", "ClippingPlane [1 2 3 0 0 1]"},
    {"DepthOfField 22 45 1200", "DepthOfField 22 45 1200"},
    {"Shutter 0 0.5", "Shutter 0 0.5"},
    {"Camera \"left\" \"float fov\" 30", "Camera \"left\" {uniform float fov=[30]}"},
    {"PixelVariance .01", "PixelVariance 0.01"},
    {"PixelSamples 2 3", "PixelSamples 2 3"},
    {"PixelFilter \"gaussian\" 2 2", "PixelFilter \"gaussian\" 2 2"},
    {"Exposure 1 2.2", "Exposure 1 2.2"},
    {"Imager \"background\" \"bgcolor\" [1 1 1]", "Imager \"background\" {uniform color bgcolor=[1 1 1]}"},
    {"Quantize \"rgba\" 255 0 255 0.5", "Quantize \"rgba\" 255 0 255 0.5"},
    {"Display \"a.tif\" \"file\" \"rgb\" \"origin\" [0 0]",
     "Display \"a.tif\" \"file\" \"rgb\" {uniform int[2] origin=[0 0]}"},
    {"DisplayChannel \"color Ci\"", "DisplayChannel \"color Ci\" {}"},
    {"Hider \"raytrace\" \"int minsamples\" 4", "Hider \"raytrace\" {uniform int minsamples=[4]}"},
    {"ColorSamples [1 2 3] [4 5 6]", "ColorSamples [1 2 3] [4 5 6]"},
    {"RelativeDetail 0.7", "RelativeDetail 0.7"},
    {"Option \"limits\" \"gridsize\" [256]", "Option \"limits\" {uniform int gridsize=[256]}"},
    {"Integrator \"PxrPathTracer\" \"i\"", "Integrator \"PxrPathTracer\" <i> {}"},
    {"DisplayFilter \"PxrGrade\" \"g\" \"float gain\" [2]",
     "DisplayFilter \"PxrGrade\" <g> {uniform float gain=[2]}"},
    {"SampleFilter \"PxrCryptomatte\" \"c\"", "SampleFilter \"PxrCryptomatte\" <c> {}"},
    {"AttributeBegin", "AttributeBegin"},
    {"AttributeEnd", "AttributeEnd"},
    {"Attribute \"identifier\" \"name\" [\"a\"]", "Attribute \"identifier\" {uniform string name=[\"a\"]}"},
    {"Color [1 0 .5]", "Color [1 0 0.5]"},
    {"Opacity 1 1 1", "Opacity [1 1 1]"},
    {"TextureCoordinates 0 0 1 0 0 1 1 1", "TextureCoordinates [0 0 1 0 0 1 1 1]"},
    {"LightSource \"pointlight\" 7 \"intensity\" 3",
     "LightSource \"pointlight\" <7> {uniform float intensity=[3]}"},
    {"AreaLightSource \"arealight\" \"lamp\"", "AreaLightSource \"arealight\" <lamp> {}"},
    {"Illuminate 7 0", "Illuminate <7> false"},
    {"Surface \"matte\" \"Kd\" 1", "Surface \"matte\" {uniform float Kd=[1]}"},
    {"Displacement \"bumpy\" \"Km\" [.1]", "Displacement \"bumpy\" {uniform float Km=[0.1]}"},
    {"Atmosphere \"fog\"", "Atmosphere \"fog\" {}"},
    {"Interior \"a\"", "Interior \"a\" {}"},
    {"Exterior \"a\"", "Exterior \"a\" {}"},
    {"ShaderLayer \"surface\" \"plastic\" \"base\"", "ShaderLayer \"surface\" \"plastic\" \"base\" {}"},
    {"ConnectShaderLayers \"surface\" \"a\" \"Ci\" \"b\" \"in\"",
     "ConnectShaderLayers \"surface\" \"a\" \"Ci\" \"b\" \"in\""},
    {"Bxdf \"PxrDiffuse\" \"d\" \"reference color diffuseColor\" [\"t:rgb\"]",
     "Bxdf \"PxrDiffuse\" <d> {uniform reference color diffuseColor=[\"t:rgb\"]}"},
    {"Pattern \"PxrTexture\" \"t\" \"string filename\" \"a.tex\"",
     "Pattern \"PxrTexture\" <t> {uniform string filename=[\"a.tex\"]}"},
    {"Displace \"PxrDisplace\" \"d\"", "Displace \"PxrDisplace\" <d> {}"},
    {"Light \"PxrDomeLight\" \"dome\" \"float exposure\" [1]",
     "Light \"PxrDomeLight\" <dome> {uniform float exposure=[1]}"},
    {"LightFilter \"PxrRodLightFilter\" \"rod\"", "LightFilter \"PxrRodLightFilter\" <rod> {}"},
    {"EnableLightFilter \"dome\" \"rod\" 1", "EnableLightFilter <dome> <rod> true"},
    {"ShadingRate .25", "ShadingRate 0.25"},
    {"ShadingInterpolation \"smooth\"", "ShadingInterpolation \"smooth\""},
    {"Matte 1", "Matte true"},
    {"Bound 0 1 2 3 4 5", "Bound [0 1 2 3 4 5]"},
    {"Detail [0 1 2 3 4 5]", "Detail [0 1 2 3 4 5]"},
    {"DetailRange 0 1 2 3", "DetailRange 0 1 2 3"},
    {"GeometricApproximation \"flatness\" 2.5", "GeometricApproximation \"flatness\" 2.5"},
    {"GeometricRepresentation \"primitive\"", "GeometricRepresentation \"primitive\""},
    {"Orientation \"inside\"", "Orientation \"inside\""},
    {"ReverseOrientation", "ReverseOrientation"},
    {"Sides 1", "Sides 1"},
    {"Identity", "Identity"},
    {"Transform [1 0 0 0 0 1 0 0 0 0 1 0 2 3 4 1]", "Transform [1 0 0 0 0 1 0 0 0 0 1 0 2 3 4 1]"},
    {"ConcatTransform 1 0 0 0 0 1 0 0 0 0 1 0 2 3 4 1", "ConcatTransform [1 0 0 0 0 1 0 0 0 0 1 0 2 3 4 1]"},
    {"Perspective 90", "Perspective 90"},
    {"Translate 1 -2 3", "Translate 1 -2 3"},
    {"Rotate 90 0 0 1", "Rotate 90 0 0 1"},
    {"Scale 1 2 3", "Scale 1 2 3"},
    {"Skew 45 [0 1 0] [1 0 0]", "Skew 45 [0 1 0 1 0 0]"},
    {"Deformation \"bend\"", "Deformation \"bend\" {}"},
    {"CoordinateSystem \"lamp\"", "CoordinateSystem \"lamp\""},
    {"ScopedCoordinateSystem \"lamp\"", "ScopedCoordinateSystem \"lamp\""},
    {"CoordSysTransform \"lamp\"", "CoordSysTransform \"lamp\""},
    {"TransformBegin", "TransformBegin"},
    {"TransformEnd", "TransformEnd"},
    {"Polygon \"P\" [0 0 0 1 0 0 0 1 0]", "Polygon {vertex point P=[0 0 0 1 0 0 0 1 0]}"},
    {"GeneralPolygon [3 3] \"P\" [1 2 3]", "GeneralPolygon [3 3] {vertex point P=[1 2 3]}"},
    {"PointsPolygons [3] [0 1 2] \"P\" [1 2 3]", "PointsPolygons [3] [0 1 2] {vertex point P=[1 2 3]}"},
    {"PointsGeneralPolygons [1] [3] [0 1 2] \"P\" [1 2 3]",
     "PointsGeneralPolygons [1] [3] [0 1 2] {vertex point P=[1 2 3]}"},
    {"Basis \"bezier\" 3 \"b-spline\" 1", "Basis \"bezier\" 3 \"b-spline\" 1"},
    {"Patch \"bilinear\" \"P\" [1 2 3]", "Patch \"bilinear\" {vertex point P=[1 2 3]}"},
    {"PatchMesh \"bicubic\" 7 \"nonperiodic\" 4 \"periodic\" \"P\" [1 2 3]",
     "PatchMesh \"bicubic\" 7 \"nonperiodic\" 4 \"periodic\" {vertex point P=[1 2 3]}"},
    {"NuPatch 2 2 [0 0 1 1] 0 1 3 2 [0 0 1 2 2] 0 2 \"Pw\" [1 2 3 4]",
     "NuPatch 2 2 [0 0 1 1] 0 1 3 2 [0 0 1 2 2] 0 2 {vertex hpoint Pw=[1 2 3 4]}"},
    {"TrimCurve [1] [2] [0 0 1 1] [0] [1] [2] [0 1] [0 1] [1 1]",
     "TrimCurve [1] [2] [0 0 1 1] [0] [1] [2] [0 1] [0 1] [1 1]"},
    {"SubdivisionMesh \"catmull-clark\" [4] [0 1 2 3] [\"crease\"] [2 1] [0 1] [3] \"P\" [1 2 3]",
     "SubdivisionMesh \"catmull-clark\" [4] [0 1 2 3] tags([\"crease\"][2 1][0 1][3][]) {vertex point P=[1 2 "
     "3]}"},
    {"HierarchicalSubdivisionMesh \"catmull-clark\" [4] [0 1 2 3] [\"creasemethod\"] [0 0 1] [] [] "
     "[\"chaikin\"]",
     "HierarchicalSubdivisionMesh \"catmull-clark\" [4] [0 1 2 3] tags([\"creasemethod\"][0 0 "
     "1][][][\"chaikin\"]) {}"},
    {"Sphere 1 -1 1 360", "Sphere 1 -1 1 360 {}"},
    {"Cone 1 2 360", "Cone 1 2 360 {}"},
    {"Cylinder 1 0 2 180", "Cylinder 1 0 2 180 {}"},
    {"Hyperboloid 0 0 0 1 1 1 90", "Hyperboloid [0 0 0] [1 1 1] 90 {}"},
    {"Paraboloid 1 0 2 360", "Paraboloid 1 0 2 360 {}"},
    {"Disk 0 1 360", "Disk 0 1 360 {}"},
    {"Torus 2 1 0 360 360", "Torus 2 1 0 360 360 {}"},
    {"Points \"P\" [1 2 3] \"width\" [.1]", "Points {vertex point P=[1 2 3], varying float width=[0.1]}"},
    {"Curves \"cubic\" [4 4] \"nonperiodic\" \"constantwidth\" .1",
     "Curves \"cubic\" [4 4] \"nonperiodic\" {constant float constantwidth=[0.1]}"},
    {"Blobby 1 [1001 0] [1 0 0] [\"\"]", "Blobby 1 [1001 0] [1 0 0] [\"\"] {}"},
    {"Volume \"box\" [0 1 0 1 0 1] [2 2 2]", "Volume \"box\" [0 1 0 1 0 1] [2 2 2] {}"},
    {"Procedural \"DelayedReadArchive\" [\"a.rib\"] [0 1 0 1 0 1]",
     "Procedural \"DelayedReadArchive\" [\"a.rib\"] [0 1 0 1 0 1]"},
    {"Procedural2 \"DelayedReadArchive2\" \"SimpleBound\" \"string filename\" [\"a.rib\"] \"float[6] bound\" "
     "[0 1 0 1 0 1]",
     "Procedural2 \"DelayedReadArchive2\" \"SimpleBound\" {uniform string filename=[\"a.rib\"], uniform "
     "float[6] "
     "bound=[0 1 0 1 0 1]}"},
    {"Geometry \"teapot\"", "Geometry \"teapot\" {}"},
    {"SolidBegin \"difference\"", "SolidBegin \"difference\""},
    {"SolidEnd", "SolidEnd"},
    {"ObjectBegin 1", "ObjectBegin <1> {}"},
    {"ObjectEnd", "ObjectEnd"},
    {"ObjectInstance \"box\"", "ObjectInstance <box> {}"},
    {"MotionBegin [0 .5 1]", "MotionBegin [0 0.5 1]"},
    {"MotionEnd", "MotionEnd"},
    {"MakeTexture \"a.tif\" \"a.tex\" \"periodic\" \"clamp\" \"box\" 1 1",
     "MakeTexture \"a.tif\" \"a.tex\" \"periodic\" \"clamp\" \"box\" 1 1 {}"},
    {"MakeBump \"a.tif\" \"a.tex\" \"black\" \"black\" \"gaussian\" 2 2",
     "MakeBump \"a.tif\" \"a.tex\" \"black\" \"black\" \"gaussian\" 2 2 {}"},
    {"MakeLatLongEnvironment \"a.tif\" \"a.env\" \"box\" 1 1",
     "MakeLatLongEnvironment \"a.tif\" \"a.env\" \"box\" 1 1 {}"},
    {"MakeCubeFaceEnvironment \"a\" \"b\" \"c\" \"d\" \"e\" \"f\" \"a.env\" 90 \"box\" 1 1",
     "MakeCubeFaceEnvironment [\"a\" \"b\" \"c\" \"d\" \"e\" \"f\"] \"a.env\" 90 \"box\" 1 1 {}"},
    {"MakeShadow \"a.z\" \"a.shd\"", "MakeShadow \"a.z\" \"a.shd\" {}"},
    {"MakeBrickMap [\"a.ptc\" \"b.ptc\"] \"a.bkm\"", "MakeBrickMap [\"a.ptc\" \"b.ptc\"] \"a.bkm\" {}"},
    {"Resource \"r\" \"attributes\" \"string operation\" \"save\"",
     "Resource <r> \"attributes\" {uniform string operation=[\"save\"]}"},
    {"ResourceBegin", "ResourceBegin"},
    {"ResourceEnd", "ResourceEnd"},
    {"System \"ls\"", "System \"ls\""},
    {"ReadArchive \"a.rib\"", "ReadArchive \"a.rib\" {}"},
    {"ArchiveEnd", "ArchiveEnd"},
    {"EditBegin \"attribute\" \"string scopename\" \"a\"",
     "EditBegin \"attribute\" {uniform string scopename=[\"a\"]}"},
    {"EditEnd", "EditEnd"},
    {"EditAttributeBegin \"a\"", "EditAttributeBegin \"a\""},
    {"EditAttributeEnd", "EditAttributeEnd"},
    {"EditWorldBegin \"a\"", "EditWorldBegin \"a\" {}"},
    {"EditWorldEnd", "EditWorldEnd"},
};

TEST(RibRequests, EachReachesItsMethodWithItsArguments) {
  for (const Case& c : kCases) {
    const Parsed parsed(c.rib);
    EXPECT_EQ(parsed.recorder.lines, Lines{c.line}) << c.rib;
    EXPECT_EQ(parsed.messages, Lines{}) << c.rib;
  }
}

TEST(RibRequests, ControlRequestsReachTheirMethods) {
  EXPECT_EQ(requests("ArchiveBegin \"a\" Identity ArchiveEnd"),
            (Lines{"ArchiveBegin \"a\" {}", "Identity", "ArchiveEnd"}));
  EXPECT_EQ(
      requests("IfBegin \"x\" Identity ElseIf \"y\" Matte 1 Else Sides 1 IfEnd"),
      (Lines{"IfBegin \"x\" {}", "Identity", "ElseIf \"y\" {}", "Matte true", "Else", "Sides 1", "IfEnd"}));
}

TEST(RibRequests, EveryRequestOfTheTableIsTested) {
  std::set<std::string_view> tested{"ArchiveBegin", "IfBegin", "ElseIf", "Else", "IfEnd"};
  for (const Case& c : kCases)
    tested.insert(std::string_view(c.rib).substr(0, std::string_view(c.rib).find(' ')));
  for (const RibRequest& request : ribRequests()) EXPECT_TRUE(tested.contains(request.name)) << request.name;
}

TEST(RibRequests, DefaultMethodsNameTheRequest) {
  struct Names : RibHandler {
    Lines names;
    void unhandled(std::string_view request, const Location&) override { names.emplace_back(request); }
  };
  for (const Case& c : kCases) {
    Names handler;
    ErrorHandler errors([](Severity, std::string_view) {});
    RibParser(handler, errors).parseMemory(c.rib, "t.rib");
    const std::string_view rib(c.rib);
    EXPECT_EQ(handler.names, Lines{std::string(rib.substr(0, rib.find(' ')))});
  }
}

TEST(RibRequests, BracketedAndBareArgumentsAreTheSame) {
  const char* same[][2] = {{"Sphere [1 -1 1 360]", "Sphere 1 -1 1 360"},
                           {"Translate [1 2 3]", "Translate 1 2 3"},
                           {"Hyperboloid [0 0 0] [1 1 1] 90", "Hyperboloid 0 0 0 1 1 1 90"},
                           {"Hyperboloid [0 0 0 1 1 1 90]", "Hyperboloid 0 0 0 1 1 1 90"},
                           {"Color 1 0 0", "Color [1 0 0]"},
                           {"Format [640 480 1]", "Format 640 480 1"},
                           {"Bound [0 1 0 1 0 1]", "Bound 0 1 0 1 0 1"},
                           {"Basis [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1] [4] [\"bezier\"] 3",
                            "Basis 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 4 \"bezier\" 3"},
                           {"Surface [\"matte\"]", "Surface \"matte\""},
                           {"MotionBegin 0 1", "MotionBegin [0 1]"},
                           {"PointsPolygons 3 [0 1 2] \"P\" []", "PointsPolygons [3] [0 1 2] \"P\" []"}};
  for (const auto& [left, right] : same) {
    EXPECT_EQ(messages(left), Lines{}) << left;
    EXPECT_EQ(requests(left), requests(right)) << left;
  }
}

TEST(RibRequests, BasisNamesStandForTheMatricesOfRI) {
  struct Keep : RibHandler {
    RibBasis u;
    void basis(const RibBasis& uBasis, int, const RibBasis&, int, const Location&) override { u = uBasis; }
  } handler;
  ErrorHandler errors;
  RibParser parser(handler, errors);
  parser.parseMemory("Basis \"catmull-rom\" 1 \"power\" 4", "t.rib");
  EXPECT_EQ(handler.u.matrix,
            (RibMatrix{-0.5f, 1.5f, -1.5f, 0.5f, 1, -2.5f, 2, -0.5f, -0.5f, 0, 0.5f, 0, 0, 1, 0, 0}));
  parser.parseMemory("Basis \"b-spline\" 1 \"power\" 4", "t.rib");
  // At t = 0 the weights of a uniform cubic B-spline are 1/6 4/6 1/6 0: the last row.
  EXPECT_FLOAT_EQ(handler.u.matrix[12], 1 / 6.0f);
  EXPECT_FLOAT_EQ(handler.u.matrix[13], 4 / 6.0f);
  EXPECT_FLOAT_EQ(handler.u.matrix[14], 1 / 6.0f);
  EXPECT_EQ(handler.u.matrix[15], 0);
}

}  // namespace
}  // namespace patina::test
