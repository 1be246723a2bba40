// SPDX-License-Identifier: Apache-2.0
// Polygons, patches and subdivision meshes: consistent numbers in, primitives of the scene out.
#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "renderer/scene/matrices.h"
#include "renderer/scene/primvars.h"
#include "renderer/scene/scene_builder.h"
#include "renderer/scene/value_count.h"

namespace patina {
namespace {

std::string_view requestName(const Shape& shape) {
  static constexpr std::string_view kQuadrics[] = {"Sphere",     "Cone", "Cylinder", "Hyperboloid",
                                                   "Paraboloid", "Disk", "Torus"};
  if (const auto* quadric = std::get_if<Quadric>(&shape))
    return kQuadrics[static_cast<size_t>(quadric->kind)];
  static constexpr std::string_view kOthers[] = {"polygon", "Quadric", "Patch",  "SubdivisionMesh",
                                                 "Curves",  "NuPatch", "Points", "Blobby"};
  return kOthers[shape.index()];
}

std::vector<int> copied(Ints values) { return {values.begin(), values.end()}; }

std::vector<int> countedFromZero(size_t count) {
  std::vector<int> indices(count);
  std::iota(indices.begin(), indices.end(), 0);
  return indices;
}

/// What is wrong with counts that cut an array of `total` into pieces; empty if nothing is.
std::string countProblem(const std::vector<int>& counts, size_t total, std::string_view what) {
  size_t sum = 0;
  for (const int count : counts) {
    if (count < 0) return fmt::format("a negative number of {}", what);
    sum += static_cast<size_t>(count);
  }
  return sum == total ? "" : fmt::format("the counts ask for {} {}, there are {}", sum, what, total);
}

std::string indexProblem(const std::vector<int>& vertices) {
  return std::ranges::any_of(vertices, [](int v) { return v < 0; }) ? "a negative vertex index" : "";
}

/// Meshes of at least so many faces keep no counts that are all the same.
constexpr size_t kManyFaces = 1024;

/// Loops of faces that have one each.
std::vector<int> oneEach(size_t faces) { return std::vector<int>(faces < kManyFaces ? faces : 0, 1); }

void dropEqualCounts(PolygonMesh& mesh) {
  const auto allAre = [](const std::vector<int>& counts, int value) {
    return std::ranges::all_of(counts, [value](int n) { return n == value; });
  };
  if (mesh.loopsPerFace.size() >= kManyFaces && allAre(mesh.loopsPerFace, 1)) mesh.loopsPerFace = {};
  if (mesh.vertsPerLoop.size() >= kManyFaces && mesh.vertsPerLoop[0] > 0 &&
      allAre(mesh.vertsPerLoop, mesh.vertsPerLoop[0])) {
    mesh.sides = mesh.vertsPerLoop[0];
    mesh.vertsPerLoop = {};
  }
}

/// RI's and the corpus' words for the wrap of a PatchMesh; nullopt: none of them.
std::optional<bool> isPeriodic(std::string_view wrap) {
  if (wrap == "periodic") return true;
  if (wrap == "nonperiodic" || wrap == "nowrap" || wrap == "non-periodic") return false;
  return std::nullopt;
}

M44f toMatrix44f(const RibMatrix& values) { return M44f(toMatrix(values)); }

}  // namespace

// ---- Into the scene ---------------------------------------------------------------------------------------

bool SceneBuilder::mayDraw(const Location& at) {
  if (!inWorld() && !inObject()) {
    errors_.reportOnce(Severity::Error, RiError::IllState, at, "outside of world",
                       "primitives outside of WorldBegin and ObjectBegin are ignored");
    return false;
  }
  // A level of detail is drawn from the middle of its lower to the middle of its upper transition.
  const auto [minVisible, lower, upper, maxVisible] = state_.detailRange;
  return state_.detail >= (minVisible + lower) / 2 &&
         (maxVisible == kInfinity || state_.detail < (upper + maxVisible) / 2);
}

void SceneBuilder::addPrimitive(Shape shape, const ParamList& params, const Location& at) {
  auto variables = readVariables(shape, params, requestName(shape), at, errors_);
  if (!variables) return;
  Primitive primitive;
  primitive.objectToWorld = state_.ctm;
  if (!isAffine(state_.ctm)) {
    // What a projection makes of quadrics, fields and B-splines is not what it makes of their control points.
    if (std::holds_alternative<Quadric>(shape) || std::holds_alternative<NurbsPatch>(shape) ||
        std::holds_alternative<Blobby>(shape) || !projectVariables(state_.ctm, *variables)) {
      return error(RiError::Math, at,
                   fmt::format("{} under a perspective transformation cannot be drawn", requestName(shape)),
                   "projective");
    }
    primitive.objectToWorld = M44d();
  } else if (state_.moving.outer) {
    auto motion = std::make_shared<PrimitiveMotion>();
    motion->place = state_.moving;
    primitive.motion = std::move(motion);
  }
  primitive.shape = std::move(shape);
  primitive.variables = std::move(*variables);
  primitive.attributes = storeAttributes();
  primitive.reversed = state_.inside;
  primitive.where = at;
  if (state_.solid.solid != kNone) placeInSolid(primitive, requestName(primitive.shape));
  if (takesMotionKeys()) return addMotionKey(std::move(primitive), at);
  primitives().push_back(std::move(primitive));
}

// ---- Polygons ---------------------------------------------------------------------------------------------

void SceneBuilder::addPolygonMesh(PolygonMesh mesh, const ParamList& params, const Location& at) {
  std::string problem;
  if (!mesh.loopsPerFace.empty())
    problem = countProblem(mesh.loopsPerFace, mesh.vertsPerLoop.size(), "loops");
  if (problem.empty()) problem = countProblem(mesh.vertsPerLoop, mesh.vertices.size(), "vertices");
  if (problem.empty()) problem = indexProblem(mesh.vertices);
  if (problem.empty() && mesh.vertices.empty()) return;  // nothing to draw
  if (problem.empty() && std::ranges::find(mesh.loopsPerFace, 0) != mesh.loopsPerFace.end())
    problem = "a face without a loop";
  if (!problem.empty())
    return error(RiError::Consistency, at, "polygons are left out: " + problem, "polygon counts");
  dropEqualCounts(mesh);
  addPrimitive(std::move(mesh), params, at);
}

void SceneBuilder::polygon(const ParamList& params, const Location& at) {
  if (!mayDraw(at)) return;
  // The number of vertices is that of the points.
  size_t points = 0;
  for (const Param& param : params) {
    if (param.name() == "P")
      points = param.floats.size() / static_cast<size_t>(param.declaration.components());
    if (param.name() == "Pw" && points == 0) points = param.floats.size() / 4;
  }
  if (points == 0)
    return error(RiError::BadArgument, at, "Polygon is left out: it needs \"P\"", "polygon without P");
  addPolygonMesh({{1}, {static_cast<int>(points)}, countedFromZero(points)}, params, at);
}

void SceneBuilder::generalPolygon(Ints loopVertexCounts, const ParamList& params, const Location& at) {
  if (!mayDraw(at)) return;
  if (const std::string problem = indexProblem(copied(loopVertexCounts));
      !problem.empty() || loopVertexCounts.empty()) {
    return error(RiError::Consistency, at, "GeneralPolygon is left out: no or negative numbers of vertices");
  }
  const size_t total = std::accumulate(loopVertexCounts.begin(), loopVertexCounts.end(), size_t{0},
                                       [](size_t sum, int n) { return sum + static_cast<size_t>(n); });
  size_t most = 0;  // before memory is spent on what the file's counts claim
  for (const Param& param : params) most = std::max(most, param.floats.size());
  if (total > most)
    return error(
        RiError::BadArgument, at,
        fmt::format("GeneralPolygon is left out: \"P\" is missing or has not the {} points of its loops",
                    total));
  addPolygonMesh(
      {{static_cast<int>(loopVertexCounts.size())}, copied(loopVertexCounts), countedFromZero(total)}, params,
      at);
}

void SceneBuilder::pointsPolygons(Ints vertexCounts, Ints vertices, const ParamList& params,
                                  const Location& at) {
  if (!mayDraw(at)) return;
  addPolygonMesh({oneEach(vertexCounts.size()), copied(vertexCounts), copied(vertices)}, params, at);
}

void SceneBuilder::pointsGeneralPolygons(Ints loopCounts, Ints vertexCounts, Ints vertices,
                                         const ParamList& params, const Location& at) {
  if (!mayDraw(at)) return;
  if (loopCounts.empty() && !vertexCounts.empty())
    return error(RiError::Consistency, at,
                 "polygons are left out: " + countProblem({}, vertexCounts.size(), "loops"),
                 "polygon counts");
  addPolygonMesh({copied(loopCounts), copied(vertexCounts), copied(vertices)}, params, at);
}

// ---- Patches ----------------------------------------------------------------------------------------------

void SceneBuilder::basis(const RibBasis& u, int uStep, const RibBasis& v, int vStep, const Location& at) {
  if (uStep < 1 || vStep < 1)
    return error(RiError::BadBasis, at, fmt::format("Basis: steps {} {} are not positive", uStep, vStep));
  state_.basisU = {toMatrix44f(u.matrix), uStep};
  state_.basisV = {toMatrix44f(v.matrix), vStep};
}

void SceneBuilder::patch(std::string_view type, const ParamList& params, const Location& at) {
  if (!mayDraw(at)) return;
  ParametricMesh mesh;
  mesh.bicubic = type == "bicubic";
  if (!mesh.bicubic && type != "bilinear") {
    return error(RiError::BadToken, at, fmt::format("Patch \"{}\": expected bilinear or bicubic", type));
  }
  mesh.nu = mesh.nv = mesh.bicubic ? 4 : 2;
  mesh.basisU = state_.basisU;
  mesh.basisV = state_.basisV;
  addPrimitive(std::move(mesh), params, at);
}

void SceneBuilder::patchMesh(std::string_view type, int nu, std::string_view uWrap, int nv,
                             std::string_view vWrap, const ParamList& params, const Location& at) {
  if (!mayDraw(at)) return;
  const auto periodicU = isPeriodic(uWrap), periodicV = isPeriodic(vWrap);
  if (!periodicU || !periodicV) {
    return error(RiError::BadToken, at,
                 fmt::format("PatchMesh \"{}\" \"{}\": expected periodic or nonperiodic", uWrap, vWrap));
  }
  ParametricMesh mesh{type == "bicubic", nu, nv, *periodicU, *periodicV, state_.basisU, state_.basisV};
  if (!mesh.bicubic && type != "bilinear") {
    return error(RiError::BadToken, at, fmt::format("PatchMesh \"{}\": expected bilinear or bicubic", type));
  }
  const auto check = [&](char side, int count, int step, bool periodic) {
    if (patchCount(mesh.bicubic, count, step, periodic) > 0) return true;
    error(RiError::Consistency, at,
          fmt::format("PatchMesh is left out: {} points along {} make no whole number of {} patches{}", count,
                      side, type, mesh.bicubic ? fmt::format(" at the basis' step of {}", step) : ""));
    return false;
  };
  if (!check('u', nu, mesh.basisU.step, mesh.periodicU) || !check('v', nv, mesh.basisV.step, mesh.periodicV))
    return;
  addPrimitive(std::move(mesh), params, at);
}

// ---- Subdivision meshes -----------------------------------------------------------------------------------

void SceneBuilder::subdivisionMesh(std::string_view scheme, Ints vertexCounts, Ints vertices,
                                   const SubdivisionTags& tags, const ParamList& params, const Location& at) {
  if (!mayDraw(at)) return;
  if (scheme == "none") {
    return addPolygonMesh({oneEach(vertexCounts.size()), copied(vertexCounts), copied(vertices)}, params, at);
  }
  SubdivisionMesh mesh;
  mesh.scheme = scheme;
  if (scheme != "catmull-clark" && scheme != "loop" && scheme != "bilinear") {
    warning(
        RiError::BadToken, at,
        fmt::format(
            "SubdivisionMesh \"{}\": expected catmull-clark, loop or bilinear; catmull-clark takes its place",
            scheme));
    mesh.scheme = "catmull-clark";
  }
  mesh.vertsPerFace = copied(vertexCounts);
  mesh.vertices = copied(vertices);
  std::string problem = countProblem(mesh.vertsPerFace, mesh.vertices.size(), "vertices");
  if (problem.empty()) problem = indexProblem(mesh.vertices);
  if (problem.empty() && mesh.vertices.empty()) return;
  if (!problem.empty()) {
    return error(RiError::Consistency, at, "SubdivisionMesh is left out: " + problem, "subdivision counts");
  }

  // Each tag takes its share of the value arrays, whose sums the parser has checked.
  size_t ints = 0, floats = 0, strings = 0;
  const auto perTag = static_cast<size_t>(tags.countsPerTag);
  for (size_t i = 0; i < tags.names.size() && (i + 1) * perTag <= tags.counts.size(); ++i) {
    const auto share = [&](size_t which) {
      return which < perTag ? static_cast<size_t>(std::max(0, tags.counts[i * perTag + which])) : 0;
    };
    const size_t intCount = share(0), floatCount = share(1), stringCount = share(2);
    if (ints + intCount > tags.ints.size() || floats + floatCount > tags.floats.size() ||
        strings + stringCount > tags.strings.size()) {
      return error(RiError::Consistency, at,
                   "SubdivisionMesh is left out: its tags ask for more values than there are");
    }
    SubdivisionMesh::Tag& tag = mesh.tags.emplace_back();
    tag.name = tags.names[i];
    tag.ints = copied(tags.ints.subspan(ints, intCount));
    const Floats floatShare = tags.floats.subspan(floats, floatCount);
    tag.floats.assign(floatShare.begin(), floatShare.end());
    for (const std::string_view text : tags.strings.subspan(strings, stringCount))
      tag.strings.emplace_back(text);
    ints += intCount;
    floats += floatCount;
    strings += stringCount;
  }
  addPrimitive(std::move(mesh), params, at);
}

}  // namespace patina
