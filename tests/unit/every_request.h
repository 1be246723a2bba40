// SPDX-License-Identifier: Apache-2.0
// A RIB in which every request stands.
#pragma once

#include <string_view>

namespace patina::test {

inline constexpr std::string_view kEveryRequest = R"(
version 3.04
Declare "radius" "varying float" Declare "odd" "uniform color[2]"
ErrorHandler "print"
FrameBegin 7
Format 640 480 1 FrameAspectRatio 1.5 ScreenWindow -1 1 -1 1 CropWindow 0 1 0 0.25
Projection "perspective" "fov" 35.5 Clipping 0.1 1e30 ClippingPlane 0 0 0 1 0 0
DepthOfField 22 1 3 DepthOfField Shutter 0 1 Camera "main" "float far" 3
PixelVariance 0.01 PixelSamples 3 2 PixelFilter "gaussian" 2 2 Exposure 1 2.2
Imager "background" "color background" [1 0 0] Quantize "rgba" 255 0 255 0.5
Display "a \"quoted\" \\ name\n.tif" "file" "rgba" "int[4] quantize" [0 255 0 255]
DisplayChannel "color Ci" "string source" "x" Hider "hidden" "int jitter" 0
ColorSamples [1 0 0 0 1 0 0 0 1] [1 0 0 0 1 0 0 0 1] RelativeDetail 0.6
Option "searchpath" "string archive" ["a:b"] Integrator "PxrPathTracer" "pt" "int maxPathLength" 4
DisplayFilter "f" "h" SampleFilter "s" "h2"
Translate 1 2 -0 Rotate 30 0 0 1 Scale 2 2 2 Skew 45 0 1 0 1 0 0 Perspective 40 Identity
Transform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1] ConcatTransform [1 0 0 0 0 1 0 0 0 0 1 0 1.1 2.25 3 1]
CoordinateSystem "cs"
WorldBegin
AttributeBegin
Attribute "user" "string s" ["a" "b"] "int n" [16777217 -3]
Color [1 0.1 0.3] Opacity 0.5 0.5 0.5 TextureCoordinates 0 0 1 0 0 1 1 1
LightSource "pointlight" 1 "intensity" 3.14159274 AreaLightSource "area" "lamp" Illuminate 1 0 Illuminate "lamp" 1
Surface "plastic" "Kd" 1e-7 "guessed" [1 2 3] Displacement "d" Atmosphere "fog" Interior "i" Exterior "e"
ShaderLayer "surface" "matte" "l1" ConnectShaderLayers "surface" "a" "b" "c" "d"
Bxdf "PxrDiffuse" "b1" "reference color diffuseColor" ["p:out"] Pattern "noise" "p" Displace "x" "y"
Light "PxrRectLight" "key" LightFilter "lf" "lfh" EnableLightFilter "key" "lfh" 1
ShadingRate 0.25 ShadingInterpolation "smooth" Matte 1 Bound -1 1 -1 1 -1 1 Detail 0 1 0 1 0 1
DetailRange 0 1 2 3 GeometricApproximation "flatness" 2 GeometricRepresentation "primitive"
Orientation "lh" ReverseOrientation Sides 1 Deformation "bend" ScopedCoordinateSystem "scs"
CoordSysTransform "cs" TransformBegin TransformEnd
Polygon "P" [0 0 0 1 0 0 1 1 0] "varying float radius" [1 2 3] "odd" [1 2 3 4 5 6]
GeneralPolygon [3] "P" [0 0 0 1 0 0 1 1 0]
PointsPolygons [3 3] [0 1 2 2 1 0] "P" [0 0 0 1 0 0 1 1 0] "facevarying float[2] uvs" [0 0 1 0 1 1 0 0 1 0 1 1]
PointsGeneralPolygons [1] [3] [0 1 2] "P" [0 0 0 1 0 0 1 1 0]
Basis "b-spline" 1 [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1] 3
Patch "bilinear" "P" [0 0 0 1 0 0 0 1 0 1 1 0]
PatchMesh "bilinear" 2 "nonperiodic" 2 "nonperiodic" "P" [0 0 0 1 0 0 0 1 0 1 1 0]
NuPatch 2 2 [0 0 1 1] 0 1 2 2 [0 0 1 1] 0 1 "Pw" [0 0 0 1 1 0 0 1 0 1 0 1 1 1 0 1]
TrimCurve [1] [2] [0 0 1 1] [0] [1] [2] [0 1] [0 1] [1 1]
SubdivisionMesh "catmull-clark" [4] [0 1 2 3] ["crease" "hole"] [2 1 1 0] [0 1 0] [2.5] "P" [0 0 0 1 0 0 1 1 0 0 1 0]
SubdivisionMesh "catmull-clark" [4] [0 1 2 3] "P" [0 0 0 1 0 0 1 1 0 0 1 0]
HierarchicalSubdivisionMesh "catmull-clark" [4] [0 1 2 3] ["t"] [1 0 1] [3] [] ["x"] "P" [0 0 0 1 0 0 1 1 0 0 1 0]
Sphere 1 -1 1 360 Cone 1 1 360 Cylinder 1 -1 1 360 Hyperboloid 0 0 0 1 1 1 360 Paraboloid 1 0 1 360
Disk 0 1 360 Torus 1 0.25 0 360 360
Points "P" [0 0 0] "constantwidth" 0.1 Curves "linear" [2] "nonperiodic" "P" [0 0 0 1 1 1]
Blobby 1 [1001 0] [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1] [""] Volume "box" [-1 1 -1 1 -1 1] [0 0 0]
Procedural "DelayedReadArchive" ["a.rib"] [-1 1 -1 1 -1 1] Procedural2 "p" "b" Geometry "teapot"
SolidBegin "primitive" SolidEnd ObjectBegin 3 ObjectEnd ObjectInstance 3 MotionBegin [0 0.5] MotionEnd
Resource "r" "type" ResourceBegin ResourceEnd System "ls" ReadArchive "b.rib"
EditBegin "e" EditAttributeBegin "x" EditAttributeEnd EditEnd EditWorldBegin "w" EditWorldEnd
ArchiveBegin "arch" Sphere 2 -2 2 360 ArchiveEnd
IfBegin "$user:x == 1" Sides 2 ElseIf "1" Sides 1 Else Sides 2 IfEnd
AttributeEnd
WorldEnd
MakeTexture "a" "b" "black" "clamp" "box" 1 1 MakeBump "a" "b" "black" "clamp" "box" 1 1
MakeLatLongEnvironment "a" "b" "box" 1 1
MakeCubeFaceEnvironment "a" "b" "c" "d" "e" "f" "t" 90 "box" 1 1 MakeShadow "a" "b" MakeBrickMap ["a" "b"] "c"
FrameEnd
)";

}  // namespace patina::test
