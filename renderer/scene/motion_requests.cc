// SPDX-License-Identifier: Apache-2.0
// Motion blocks: the same request once for each time. Transformations and primitives become keys; of all
// else the first request holds.
#include <fmt/format.h>

#include <algorithm>

#include "renderer/scene/matrices.h"
#include "renderer/scene/motion_block.h"
#include "renderer/scene/shape_motion.h"

namespace patina {
namespace {

constexpr std::string_view kTransforms[] = {
    "ConcatTransform", "CoordSysTransform", "Identity", "Rotate", "Scale", "Skew", "Transform", "Translate"};
constexpr std::string_view kPrimitives[] = {"Cone",
                                            "Curves",
                                            "Cylinder",
                                            "Disk",
                                            "GeneralPolygon",
                                            "HierarchicalSubdivisionMesh",
                                            "Hyperboloid",
                                            "NuPatch",
                                            "Paraboloid",
                                            "Patch",
                                            "PatchMesh",
                                            "Points",
                                            "PointsGeneralPolygons",
                                            "PointsPolygons",
                                            "Polygon",
                                            "Sphere",
                                            "SubdivisionMesh",
                                            "Torus"};
/// What stands in a motion block without being one of its samples, beside the Begin and End of blocks.
constexpr std::string_view kNoSamples[] = {"Declare",      "Else",        "ElseIf",
                                           "ErrorHandler", "ReadArchive", "version"};

bool isOneOf(std::string_view request, std::span<const std::string_view> names) {
  return std::ranges::find(names, request) != names.end();
}

}  // namespace

void SceneBuilder::motionBegin(Floats times, const Location& at) {
  if (motion_) {
    ++motion_->ignored;
    motion_->sound = false;
    return error(RiError::Nesting, at,
                 fmt::format("MotionBegin inside MotionBegin of {}", toString(motion_->where)));
  }
  if (!open(BlockKind::Motion, at)) return;
  motion_ = std::make_unique<MotionBlock>();
  motion_->where = at;
  motion_->times.assign(times.begin(), times.end());
  const auto falls = [](float a, float b) { return !(a < b); };
  const bool finite = std::ranges::all_of(times, [](float t) { return std::isfinite(t); });
  if (!finite || std::ranges::adjacent_find(times, falls) != times.end()) {
    motion_->sound = false;
    error(RiError::BadMotion, at,
          "MotionBegin: expected finite times, each greater than the one before; the first of the requests "
          "holds throughout",
          "motion times");
  }
}

void SceneBuilder::motionEnd(const Location& at) {
  if (motion_ && motion_->ignored > 0) {
    --motion_->ignored;
    return;
  }
  close(BlockKind::Motion, at);
}

bool SceneBuilder::wants(std::string_view request, const Location& at) {
  if (outer_ && request != "Option") nameLateOption(request, at);  // that one says itself what it is about
  if (!motion_ || blocks_.top().kind != BlockKind::Motion || request.ends_with("Begin") ||
      request.ends_with("End") || isOneOf(request, kNoSamples))
    return true;
  MotionBlock& block = *motion_;
  if (request == "Perspective") {
    error(RiError::BadMotion, at, "Perspective in a motion block: projections do not move; request ignored");
    return false;
  }
  if (++block.count == 1) {
    block.request = request;
    block.kind = isOneOf(request, kTransforms)   ? MotionBlock::Kind::Transforms
                 : isOneOf(request, kPrimitives) ? MotionBlock::Kind::Primitives
                                                 : MotionBlock::Kind::Others;
    if (block.kind == MotionBlock::Kind::Others)
      countNotice(fmt::format("{} does not change over a motion block: its first values hold", request), at);
    return true;
  }
  if (request != block.request && block.sound) {
    block.sound = false;
    error(RiError::BadMotion, at,
          fmt::format("{0} among the {1} of MotionBegin of {2}: expected {1} once for each of the {3} times; "
                      "the first holds throughout",
                      request, block.request, toString(block.where), block.times.size()),
          "motion request");
  }
  return block.sound && block.kind != MotionBlock::Kind::Others && block.count <= block.times.size();
}

bool SceneBuilder::takesMotionKeys() const {
  return motion_ && motion_->kind != MotionBlock::Kind::Others && motion_->count > 0 &&
         blocks_.top().kind == BlockKind::Motion;
}

void SceneBuilder::addMotionKey(const TransformKey& key, bool absolute) {
  motion_->transforms.push_back(key);
  motion_->absolute = absolute;
}

void SceneBuilder::addMotionKey(Primitive primitive, const Location& at) {
  MotionBlock& block = *motion_;
  std::vector<Primitive>& list = inObject() ? scene_.objects.back().primitives : scene_.primitives;
  // A block without times has no keys.
  const double time = block.times.empty() ? 0 : block.times[std::min(block.count, block.times.size()) - 1];
  if (block.shapes.empty()) {
    block.primitive = list.size();
    block.shapes.push_back(shapeKey(primitive, time));
    list.push_back(std::move(primitive));
    return;
  }
  const std::string problem = addKey(list[block.primitive], primitive, time, block.shapes);
  if (problem.empty()) return;
  block.sound = false;
  error(RiError::Consistency, at,
        fmt::format("{} does not go with the first of its motion block, which holds throughout: {}",
                    block.request, problem),
        "motion shapes");
}

void SceneBuilder::endMotion() {
  const std::unique_ptr<MotionBlock> ended = std::move(motion_);
  if (!ended) return;
  MotionBlock& block = *ended;
  if (block.sound && block.count > 0 && block.count != block.times.size()) {
    block.sound = false;
    error(RiError::BadMotion, block.where,
          fmt::format("MotionBegin: {} requests for {} times; the first holds throughout", block.count,
                      block.times.size()),
          "motion count");
  }
  if (block.kind == MotionBlock::Kind::Transforms) {
    if (!block.transforms.empty()) endTransforms(block, block.sound);
    return;
  }
  // A request that could not be carried out has been reported, and leaves a gap.
  if (!block.sound || block.shapes.size() != block.times.size() || block.shapes.size() < 2) return;
  std::vector<Primitive>& list = inObject() ? scene_.objects.back().primitives : scene_.primitives;
  Primitive& primitive = list[block.primitive];
  auto motion = std::make_shared<PrimitiveMotion>();
  if (primitive.motion) motion->place = primitive.motion->place;
  motion->shapes = std::move(block.shapes);
  primitive.motion = std::move(motion);
}

void SceneBuilder::endTransforms(const MotionBlock& block, bool complete) {
  const std::vector<TransformKey>& given = block.transforms;
  const auto holdFirst = [&] {
    if (block.absolute)
      setTransform(given[0].matrix, block.where);
    else
      concat(given[0].matrix, block.where);
  };
  const auto refuse = [&](RiError code, const std::string& why) {
    error(code, block.where,
          fmt::format("MotionBegin: {}; the first {} holds throughout", why, block.request),
          fmt::format("motion {}", name(code)));
    holdFirst();
  };
  if (!complete || given.size() != block.times.size()) return holdFirst();
  if (std::ranges::all_of(given, [&](const TransformKey& key) { return key.matrix == given[0].matrix; }) &&
      !given[0].turn)
    return holdFirst();
  for (const TransformKey& key : given) {
    if (!isAffine(key.matrix)) return refuse(RiError::Math, "projections do not move");
    if (determinant3(key.matrix) * determinant3(given[0].matrix) < 0)
      return refuse(RiError::Math, "a movement into the mirror image passes through nothing");
  }
  std::vector<MotionKey> keys;
  std::vector<Turn> turns;
  for (size_t k = 0; k < given.size(); ++k) {
    keys.push_back({block.times[k], given[k].matrix});
    if (given[k].turn) turns.push_back({block.times[k], given[k].turn->degrees, given[k].turn->axis});
  }
  if (turns.size() == keys.size()) {
    keys = keysOfTurns(turns);
    if (keys.empty())
      return refuse(RiError::LimitCheck,
                    fmt::format("more than {} turns from one of its times to the next", kMostTurns));
  }
  const std::shared_ptr<const Motion> outer = block.absolute ? nullptr : state_.moving.outer;
  if (outer && outer->nested() >= Motion::kMostNested)
    return refuse(RiError::LimitCheck, fmt::format("more than {} moving transformations on top of each other",
                                                   Motion::kMostNested));
  const M44d inner = block.absolute ? M44d() : outer ? state_.moving.inner : state_.ctm;
  state_.moving = {M44d(), std::make_shared<Motion>(std::move(keys), inner, outer)};
  state_.ctm = state_.moving.at(static_cast<double>(camera_.shutterOpen));
}

}  // namespace patina
