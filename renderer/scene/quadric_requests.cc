// SPDX-License-Identifier: Apache-2.0
// The seven quadrics, and the eighth.
#include <fmt/format.h>

#include <algorithm>

#include "renderer/scene/scene_builder.h"
#include "renderer/scene/teapot.h"

namespace patina {

void SceneBuilder::addQuadric(Quadric::Kind kind, std::initializer_list<float> values, float thetaMax,
                              const ParamList& params, const Location& at) {
  if (!mayDraw(at)) return;
  Quadric quadric;
  quadric.kind = kind;
  quadric.thetaMax = thetaMax;
  std::ranges::copy(values, quadric.values.begin());
  const auto finite = [](float value) { return std::isfinite(value); };
  if (!std::ranges::all_of(values, finite) || !finite(thetaMax)) {
    return error(RiError::Range, at, "a quadric's dimensions must be finite", "quadric range");
  }
  addPrimitive(quadric, params, at);
}

void SceneBuilder::sphere(float radius, float zMin, float zMax, float thetaMax, const ParamList& params,
                          const Location& at) {
  addQuadric(Quadric::Kind::Sphere, {radius, zMin, zMax}, thetaMax, params, at);
}

void SceneBuilder::cone(float height, float radius, float thetaMax, const ParamList& params,
                        const Location& at) {
  addQuadric(Quadric::Kind::Cone, {height, radius}, thetaMax, params, at);
}

void SceneBuilder::cylinder(float radius, float zMin, float zMax, float thetaMax, const ParamList& params,
                            const Location& at) {
  addQuadric(Quadric::Kind::Cylinder, {radius, zMin, zMax}, thetaMax, params, at);
}

void SceneBuilder::hyperboloid(const std::array<float, 3>& p1, const std::array<float, 3>& p2, float thetaMax,
                               const ParamList& params, const Location& at) {
  addQuadric(Quadric::Kind::Hyperboloid, {p1[0], p1[1], p1[2], p2[0], p2[1], p2[2]}, thetaMax, params, at);
}

void SceneBuilder::paraboloid(float rMax, float zMin, float zMax, float thetaMax, const ParamList& params,
                              const Location& at) {
  addQuadric(Quadric::Kind::Paraboloid, {rMax, zMin, zMax}, thetaMax, params, at);
}

void SceneBuilder::disk(float height, float radius, float thetaMax, const ParamList& params,
                        const Location& at) {
  addQuadric(Quadric::Kind::Disk, {height, radius}, thetaMax, params, at);
}

void SceneBuilder::torus(float majorRadius, float minorRadius, float phiMin, float phiMax, float thetaMax,
                         const ParamList& params, const Location& at) {
  addQuadric(Quadric::Kind::Torus, {majorRadius, minorRadius, phiMin, phiMax}, thetaMax, params, at);
}

void SceneBuilder::geometry(std::string_view type, const ParamList& params, const Location& at) {
  for (const Param& param : params) param.used = true;
  if (type == "rectlight" || type == "disklight" || type == "spherelight" || type == "cylinderlight") {
    // The shape of an area light that is bound; lights of later dialects bring their own.
    if (state_.attributes.areaLight != kNone) lightShape(type, at);
    return;
  }
  if (type == "envsphere" || type == "envcube" || type == "domelight") return;  // the sky has no shape
  if (type != "teapot") return unhandled(fmt::format("Geometry \"{}\"", type), at);
  if (!mayDraw(at)) return;
  for (const TeapotPart& part : teapot()) {
    Param points;
    points.declaration = {StorageClass::Vertex, ValueType::Point, 1, false, true, "P"};
    points.floats = part.points;
    points.location = at;
    addPrimitive(part.mesh, ParamList(std::span(&points, 1)), at);
  }
}

}  // namespace patina
