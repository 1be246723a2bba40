// SPDX-License-Identifier: Apache-2.0
// The exceptions from "carried out", by request.
#include "renderer/scene/request_support.h"

#include <fmt/format.h>

#include <algorithm>

#include "rib/requests.h"

namespace patina {
namespace {

struct Entry {
  std::string_view request;
  RequestSupport support;
};

constexpr Support kMapped = Support::Mapped, kIgnored = Support::Ignored;

// In alphabetical order.
constexpr Entry kEntries[] = {
    {"AreaLightSource", {kMapped, "PxrStdAreaLight is an arealight, PxrStdEnvMapLight an envlight"}},
    {"Atmosphere", {Support::CarriedOut, "on camera rays"}},
    {"Blobby",
     {Support::CarriedOut,
      "opcode 4 divides, 5 subtracts; repelling planes read no depth file, plug-in fields are left out"}},
    {"Bound", {Support::CarriedOut, "a hint that is not needed: nothing to do"}},
    {"Bxdf", {kMapped, "drawn as matte, plastic, paintedplastic, conductor or dielectric"}},
    {"Camera", {kMapped, "names the coordinate system; its parameters are left out"}},
    {"ClippingPlane",
     {Support::CarriedOut,
      "the camera does not see what is on the side that the normal points to; other rays do"}},
    {"ConnectShaderLayers", {kIgnored, "layers are not joined"}},
    {"Curves",
     {Support::CarriedOut, "ribbons; tubes where Attribute \"dice\" \"roundcurve\" is 1 and no N is given"}},
    {"Deformation", {kIgnored, "no such request was ever defined in full"}},
    {"Detail",
     {Support::CarriedOut, "of an object's definition it is not known: the highest level is drawn"}},
    {"DetailRange", {kMapped, "levels change in the middle of a transition, they are not blended"}},
    {"Displace", {kIgnored, "surfaces are not displaced"}},
    {"Displacement", {Support::CarriedOut, "surfaces of objects are displaced once, in the object's space"}},
    {"DisplayChannel", {kIgnored, "displays have rgb, rgba and z"}},
    {"DisplayFilter", {kIgnored, "but for the background of Imager"}},
    {"EditAttributeBegin", {kIgnored, "renders are not edited; what is in the block is carried out"}},
    {"EditAttributeEnd", {kIgnored, ""}},
    {"EditBegin", {kIgnored, "renders are not edited; what is in the block is carried out"}},
    {"EditEnd", {kIgnored, ""}},
    {"EditWorldBegin", {kIgnored, "renders are not edited; what is in the block is carried out"}},
    {"EditWorldEnd", {kIgnored, ""}},
    {"EnableLightFilter", {kIgnored, "lights have no filters"}},
    {"Exterior", {kIgnored, "surfaces are seen through clear air"}},
    {"GeometricApproximation",
     {Support::CarriedOut, "flatness: surfaces are within an eightieth of a pixel; the others are named"}},
    {"Geometry", {kMapped, "teapot, and the shapes of area lights"}},
    {"Hider", {Support::CarriedOut, "of raytrace: minsamples, maxsamples, integrationmode, incremental"}},
    {"HierarchicalSubdivisionMesh", {kMapped, "a SubdivisionMesh without its hierarchical edits"}},
    {"Imager", {Support::CarriedOut, "background"}},
    {"Integrator", {kMapped, "PxrPathTracer, PxrUnified, PxrVCM: mode path; PxrDirectLighting: mode direct"}},
    {"Interior", {kIgnored, "solids are clear"}},
    {"Light",
     {kMapped,
      "rectangle, disk, sphere, cylinder, mesh: arealight; dome: envlight; day: sunsky; distant: "
      "distantlight"}},
    {"LightFilter", {kIgnored, "lights have no filters"}},
    {"MakeBrickMap", {kIgnored, "not made"}},
    {"MakeBump", {Support::CarriedOut, "heights, by OpenImageIO; filter widths are its own"}},
    {"MakeCubeFaceEnvironment", {Support::CarriedOut, "as a latitude-longitude picture"}},
    {"MakeLatLongEnvironment", {Support::CarriedOut, "filter widths are OpenImageIO's own"}},
    {"MakeShadow", {Support::CarriedOut, "a depth texture; Patina itself traces shadows"}},
    {"MakeTexture", {Support::CarriedOut, "by OpenImageIO; filter widths are its own"}},
    {"MotionBegin",
     {Support::CarriedOut,
      "keys of transformations and primitives (not Blobby); of other requests the first holds"}},
    {"Pattern", {kMapped, "PxrTexture where a colour is connected to it"}},
    {"PixelVariance",
     {Support::CarriedOut,
      "of the mean luminance after Exposure's gain, relative above 1; 0: all pixels have all samples"}},
    {"Points", {Support::CarriedOut, "as balls"}},
    {"Procedural",
     {Support::CarriedOut,
      "DelayedReadArchive, read when a ray meets its bound (at once in objects and solids, as an area light, "
      "and where a motion block moves it); RunProgram with --allow-programs"}},
    {"Procedural2",
     {Support::CarriedOut,
      "DelayedReadArchive2 with a SimpleBound, read when a ray meets it; others are named"}},
    {"Resource", {Support::CarriedOut, "attributes saved and restored"}},
    {"SampleFilter", {kIgnored, "samples are not changed"}},
    {"ShaderLayer", {kIgnored, "layers are not joined"}},
    {"Shutter",
     {Support::CarriedOut,
      "camera rays sample it; shading, lights and other rays are at its opening, but for samplemotion"}},
    {"SolidBegin",
     {Support::CarriedOut, "operands that are not closed, and ObjectInstance in one, are drawn whole"}},
    {"System", {kIgnored, "no command is run"}},
    {"Volume", {kIgnored, "not drawn"}},
};
static_assert(std::ranges::is_sorted(kEntries, {}, &Entry::request));

std::string_view name(Support support) {
  return support == Support::CarriedOut ? "carried out"
         : support == Support::Mapped   ? "mapped"
                                        : "ignored, with a warning";
}

}  // namespace

RequestSupport supportOf(std::string_view request) {
  const auto found = std::ranges::lower_bound(kEntries, request, {}, &Entry::request);
  return found != std::end(kEntries) && found->request == request ? found->support : RequestSupport{};
}

std::string requestTable() {
  std::string table = "| request | arguments | what becomes of it | |\n| --- | --- | --- | --- |\n";
  for (const RibRequest& request : ribRequests()) {
    const RequestSupport support = supportOf(request.name);
    table += fmt::format("| {} | {} | {} | {} |\n", request.name, request.usage, name(support.support),
                         support.note);
  }
  return table;
}

}  // namespace patina
