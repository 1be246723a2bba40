// SPDX-License-Identifier: Apache-2.0
// Keys of deformation.
#include "renderer/scene/shape_motion.h"

#include <fmt/format.h>

#include <algorithm>

namespace patina {
namespace {

template <class... Visitors>
struct Overloaded : Visitors... {
  using Visitors::operator()...;
};

bool mayChange(std::string_view name) {
  return name == "P" || name == "Pw" || name == "N" || name == "width" || name == "constantwidth";
}

PrimVar* find(std::vector<PrimVar>& variables, std::string_view name) {
  const auto found = std::ranges::find(variables, name, &PrimVar::name);
  return found == variables.end() ? nullptr : &*found;
}

/// Points with weights of 1, where there are none: they stand beside a key whose weights differ from 1.
void addWeights(ShapeKey& key, const PrimVar& like) {
  const PrimVar* points = find(key.variables, "P");
  if (!points || find(key.variables, "Pw")) return;
  PrimVar weighted = like;
  weighted.floats.clear();
  for (size_t k = 0; k + 2 < points->floats.size(); k += 3) {
    weighted.floats.insert(weighted.floats.end(), points->floats.begin() + static_cast<ptrdiff_t>(k),
                           points->floats.begin() + static_cast<ptrdiff_t>(k) + 3);
    weighted.floats.push_back(1);
  }
  key.variables.push_back(std::move(weighted));
}

bool sameSpline(const SplineKnots& a, const SplineKnots& b) {
  return a.count == b.count && a.order == b.order && a.knots == b.knots && a.min == b.min && a.max == b.max;
}

/// Why two shapes cannot be states of one: empty if they can.
std::string shapeProblem(const Shape& a, const Shape& b) {
  if (a.index() != b.index()) return "the requests make different kinds of primitives";
  return std::visit(
      Overloaded{[&](const PolygonMesh& p) -> std::string {
                   const auto& q = std::get<PolygonMesh>(b);
                   return p.loopsPerFace == q.loopsPerFace && p.vertsPerLoop == q.vertsPerLoop &&
                                  p.vertices == q.vertices
                              ? ""
                              : "the polygons are not the same";
                 },
                 [&](const Quadric& p) -> std::string {
                   return p.kind == std::get<Quadric>(b).kind ? "" : "the quadrics are not of one kind";
                 },
                 [&](const ParametricMesh& p) -> std::string {
                   const auto& q = std::get<ParametricMesh>(b);
                   return p.bicubic == q.bicubic && p.nu == q.nu && p.nv == q.nv &&
                                  p.periodicU == q.periodicU && p.periodicV == q.periodicV
                              ? ""
                              : "the patches are not the same";
                 },
                 [&](const SubdivisionMesh& p) -> std::string {
                   const auto& q = std::get<SubdivisionMesh>(b);
                   return p.scheme == q.scheme && p.vertsPerFace == q.vertsPerFace && p.vertices == q.vertices
                              ? ""
                              : "the meshes are not the same";
                 },
                 [&](const CurveSet& p) -> std::string {
                   const auto& q = std::get<CurveSet>(b);
                   return p.cubic == q.cubic && p.periodic == q.periodic && p.vertexCounts == q.vertexCounts
                              ? ""
                              : "the curves are not the same";
                 },
                 [&](const NurbsPatch& p) -> std::string {
                   const auto& q = std::get<NurbsPatch>(b);
                   return sameSpline(p.u, q.u) && sameSpline(p.v, q.v)
                              ? ""
                              : "orders, knots or ranges are not the same";
                 },
                 [&](const PointSet& p) -> std::string {
                   return p.count == std::get<PointSet>(b).count ? "" : "the numbers of points differ";
                 },
                 [&](const Blobby&) -> std::string { return "a Blobby cannot change its shape"; }},
      a);
}

}  // namespace

ShapeKey shapeKey(const Primitive& primitive, double time) {
  ShapeKey key{time, {}, {}};
  if (const auto* quadric = std::get_if<Quadric>(&primitive.shape)) {
    key.dimensions.assign(quadric->values.begin(), quadric->values.end());
    key.dimensions.push_back(quadric->thetaMax);
  }
  for (const PrimVar& variable : primitive.variables)
    if (mayChange(variable.name)) key.variables.push_back(variable);
  return key;
}

std::string addKey(const Primitive& first, const Primitive& later, double time, std::vector<ShapeKey>& keys) {
  if (std::string problem = shapeProblem(first.shape, later.shape); !problem.empty()) return problem;
  ShapeKey key = shapeKey(later, time);
  ShapeKey& firstKey = keys.front();
  if (const PrimVar* weighted = find(firstKey.variables, "Pw")) {
    addWeights(key, *weighted);
  } else if (const PrimVar* newlyWeighted = find(key.variables, "Pw")) {
    for (ShapeKey& earlier : keys) addWeights(earlier, *newlyWeighted);
  }
  for (const PrimVar& variable : firstKey.variables) {
    const PrimVar* other = find(key.variables, variable.name);
    if (!other || other->floats.size() != variable.floats.size() || other->storage != variable.storage)
      return fmt::format("\"{}\" has {} numbers at the first of the times, {} at another", variable.name,
                         variable.floats.size(), other ? other->floats.size() : 0);
  }
  if (key.variables.size() != firstKey.variables.size()) return "the requests have not the same variables";
  keys.push_back(std::move(key));
  return {};
}

bool deformsWithin(const PrimitiveMotion& motion, double open, double close) {
  if (!(open < close)) return false;
  const auto same = [](const ShapeKey& a, const ShapeKey& b) {
    return a.dimensions == b.dimensions && std::ranges::all_of(a.variables, [&](const PrimVar& variable) {
             const auto other = std::ranges::find(b.variables, variable.name, &PrimVar::name);
             return other != b.variables.end() && other->floats == variable.floats;
           });
  };
  for (size_t k = 1; k < motion.shapes.size(); ++k)
    if (motion.shapes[k - 1].time < close && motion.shapes[k].time > open &&
        !same(motion.shapes[k - 1], motion.shapes[k]))
      return true;
  return false;
}

void setShape(Primitive& primitive, const PrimitiveMotion& motion, double time) {
  const std::vector<ShapeKey>& keys = motion.shapes;
  if (keys.empty()) return;
  const auto later = std::ranges::upper_bound(keys, time, {}, &ShapeKey::time);
  const ShapeKey& b = later == keys.end() ? keys.back() : *later;
  const ShapeKey& a = later == keys.begin() ? b : *std::prev(later);
  const double s = &a == &b ? 0 : (time - a.time) / (b.time - a.time);
  const auto between = [&](const std::vector<float>& x, const std::vector<float>& y) {
    std::vector<float> result = x;
    for (size_t k = 0; k < x.size() && s != 0; ++k)
      result[k] = static_cast<float>(static_cast<double>(x[k]) * (1 - s) + static_cast<double>(y[k]) * s);
    return result;
  };
  if (auto* quadric = std::get_if<Quadric>(&primitive.shape)) {
    const std::vector<float> dimensions = between(a.dimensions, b.dimensions);
    std::copy_n(dimensions.begin(), quadric->values.size(), quadric->values.begin());
    quadric->thetaMax = dimensions.back();
  }
  for (const PrimVar& from : a.variables) {
    const auto to = std::ranges::find(b.variables, from.name, &PrimVar::name);
    if (to == b.variables.end()) continue;
    PrimVar* variable = find(primitive.variables, from.name);
    if (!variable) variable = &primitive.variables.emplace_back(from);
    variable->floats = between(from.floats, to->floats);
  }
  // Weighted points move along with their weights: P is what they stand for.
  const PrimVar* weighted = find(primitive.variables, "Pw");
  PrimVar* points = find(primitive.variables, "P");
  if (!weighted || !points || s == 0) return;
  for (size_t k = 0; 4 * k + 3 < weighted->floats.size() && 3 * k + 2 < points->floats.size(); ++k)
    if (const float w = weighted->floats[4 * k + 3]; w != 0)
      for (size_t c = 0; c < 3; ++c) points->floats[3 * k + c] = weighted->floats[4 * k + c] / w;
}

void settleMotion(Scene& scene) {
  const double open = static_cast<double>(scene.camera.shutterOpen);
  const auto settle = [&](Primitive& primitive) {
    if (!primitive.motion) return;
    if (primitive.motion->place.outer) primitive.objectToWorld = primitive.motion->place.at(open);
    setShape(primitive, *primitive.motion, open);
  };
  for (Primitive& primitive : scene.primitives) settle(primitive);
  for (ObjectDefinition& object : scene.objects)
    for (Primitive& primitive : object.primitives) settle(primitive);
  for (Instance& instance : scene.instances)
    if (instance.motion) instance.objectToWorld = instance.motion->at(open);
  if (scene.camera.motion) scene.camera.worldToCamera = scene.camera.motion->at(open);
}

}  // namespace patina
