// SPDX-License-Identifier: Apache-2.0
// Blocks, frames and worlds: what opens, what closes, and what is left when they do.
#include "renderer/scene/scene_builder.h"

#include <fmt/format.h>

#include <tuple>

#include "renderer/scene/camera.h"
#include "renderer/scene/matrices.h"
#include "renderer/scene/motion_block.h"
#include "renderer/scene/shape_motion.h"

namespace patina {
namespace {

/// What a scene held when a world or a frame began.
struct SceneMark {
  size_t shaders, lights, objects, attributes;
  std::map<std::string, M44d> coordinateSystems;
  std::unordered_map<std::string, uint32_t> lightHandles, objectHandles;
};

}  // namespace

struct SceneBuilder::WorldStart {
  SceneMark mark;
  std::vector<ShaderBinding> shaders;  // of lights and attributes before WorldBegin: in camera space
};

struct SceneBuilder::FrameStart {
  SceneMark mark;
  Options options;
  Camera camera;
  std::string patinaMode, riMode;
};

SceneBuilder::SceneBuilder(SceneBuilderSettings settings, ErrorHandler& errors, OnWorld onWorld)
    : settings_(std::move(settings)),
      errors_(errors),
      onWorld_(std::move(onWorld)),
      parser_(*this, errors),
      archives_(parser_, errors, settings_.archiveReads),
      programsRun_(std::make_shared<std::atomic<size_t>>(0)) {
  camera_.perspective = false;
  const M44f bezier(-1, 3, -3, 1, 3, -6, 3, 0, -3, 3, 0, 0, 1, 0, 0, 0);
  state_.basisU = state_.basisV = {bezier, 3};
}

/// Stands where the request for a delayed archive of `outer` stood.
SceneBuilder::SceneBuilder(const SceneBuilder& outer, const DelayedArchive& archive, ErrorHandler& errors)
    : settings_(outer.settings_),
      outer_(&outer),
      errors_(errors),
      parser_(*this, errors),
      archives_(parser_, errors, outer.archives_, archive.state->chain),
      options_(outer.options_),
      camera_(outer.camera_),
      patinaMode_(outer.patinaMode_),
      riMode_(outer.riMode_),
      state_(archive.state->state),
      programsRun_(outer.programsRun_) {
  parser_.dictionary() = outer.parser_.dictionary();
  scene_.frame = outer.scene_.frame;
  scene_.options = options_;
  scene_.camera = camera_;
  scene_.camera.worldToCamera = outer.scene_.camera.worldToCamera;
  resolveFrame(scene_.options, scene_.camera);
  scene_.firstShader = outer.scene_.firstShader + static_cast<uint32_t>(outer.scene_.shaders.size());
  scene_.firstObject = outer.scene_.firstObject + static_cast<uint32_t>(outer.scene_.objects.size());
  for (const auto& [name, toWorld] : archive.state->systems) scene_.coordinateSystems[name] = toWorld;
  state_.ctm = archive.objectToWorld;
  blocks_.push(BlockKind::World, archive.where);
}

SceneBuilder::~SceneBuilder() = default;

bool SceneBuilder::readFile(const std::string& path) {
  const bool read = archives_.readMain(path);
  finish();
  return read;
}

bool SceneBuilder::readText(std::string_view text, std::string_view name) {
  const bool read = parser_.parseMemory(text, name);
  finish();
  return read;
}

void SceneBuilder::finish() {
  while (!blocks_.empty()) {
    const BlockStack::Block block = blocks_.top();
    if (!errors_.aborted()) {
      error(RiError::Nesting, block.where, fmt::format("the file ends inside this {}Begin", name(block.kind)),
            "file ends inside a block");
    }
    closeTop(block.where);
  }
  blocksTooDeep_ = 0;
  reportNotices();
}

// ---- Messages ---------------------------------------------------------------------------------------------

void SceneBuilder::error(RiError code, const Location& at, std::string_view message, std::string_view key) {
  errors_.report(Severity::Error, code, at, message, key);
}

void SceneBuilder::warning(RiError code, const Location& at, std::string_view message, std::string_view key) {
  errors_.report(Severity::Warning, code, at, message, key);
}

void SceneBuilder::unhandled(std::string_view request, const Location& at) {
  countNotice(fmt::format("request {} is not carried out yet", request), at);
}

void SceneBuilder::noEffect(std::string_view request, std::string_view name, std::string_view token,
                            const Location& at) {
  const std::string what = token.empty() ? std::string() : fmt::format(" \"{}\"", token);
  countNotice(fmt::format("{} \"{}\"{} has no effect", request, name, what), at);
}

void SceneBuilder::countNotice(const std::string& message, const Location& at) {
  constexpr size_t kMostNotices = 200;
  const bool full = notices_.size() >= kMostNotices && !notices_.contains(message);
  ++notices_.try_emplace(full ? "more of the kinds named here" : message, Notice{at, 0}).first->second.count;
}

void SceneBuilder::reportNotices() {
  for (const auto& [message, notice] : notices_) {
    const std::string times = notice.count == 1 ? "once" : fmt::format("{} times", notice.count);
    errors_.reportOnce(Severity::Warning, RiError::Unimplemented, notice.first, message,
                       fmt::format("{} ({})", message, times));
  }
  notices_.clear();
}

std::optional<Declaration> SceneBuilder::declarationOf(std::string_view request, std::string_view name,
                                                       std::string_view parameter) {
  return settings_.declarationOf ? settings_.declarationOf(request, name, parameter) : std::nullopt;
}

void SceneBuilder::errorHandler(std::string_view style, const Location&) {
  errors_.setStyle(style == "ignore"  ? ErrorStyle::Ignore
                   : style == "abort" ? ErrorStyle::Abort
                                      : ErrorStyle::Print);
}

// ---- Blocks -----------------------------------------------------------------------------------------------

bool SceneBuilder::open(BlockKind kind, const Location& at) {
  if (blocks_.depth() >= settings_.blockDepth) {
    error(RiError::LimitCheck, at, fmt::format("more than {} blocks within each other", settings_.blockDepth),
          "deep");
    ++blocksTooDeep_;
    return false;
  }
  if (blocks_.isOpen(BlockKind::Motion)) {
    error(RiError::Nesting, at,
          fmt::format("{}Begin inside MotionBegin of {}", name(kind), toString(blocks_.top().where)),
          "in motion");
  }
  blocks_.push(kind, at);
  if (kind == BlockKind::Transform) {
    savedTransforms_.emplace_back(state_.ctm, state_.moving);
  } else if (kind != BlockKind::Motion && kind != BlockKind::Resource) {
    savedStates_.push_back(state_);
  }
  return true;
}

bool SceneBuilder::close(BlockKind kind, const Location& at) {
  if (blocksTooDeep_ > 0) {
    --blocksTooDeep_;
    return false;
  }
  if (!blocks_.mayClose(kind)) {
    std::string message = fmt::format("{0}End without {0}Begin", name(kind));
    if (!blocks_.empty()) {
      message += fmt::format("; the open block is {}Begin of {}", name(blocks_.top().kind),
                             toString(blocks_.top().where));
    }
    error(RiError::Nesting, at, message, fmt::format("stray {}End", name(kind)));
    return false;
  }
  while (blocks_.top().kind != kind) {
    error(RiError::Nesting, at,
          fmt::format("{}End closes {}Begin of {}, which is still open", name(kind), name(blocks_.top().kind),
                      toString(blocks_.top().where)),
          fmt::format("{}End closes {}Begin", name(kind), name(blocks_.top().kind)));
    closeTop(at);
  }
  closeTop(at);
  return true;
}

void SceneBuilder::closeTop(const Location&) {
  const BlockKind kind = blocks_.top().kind;
  if (kind == BlockKind::World) endWorld();
  blocks_.pop();
  switch (kind) {
    case BlockKind::Transform:
      std::tie(state_.ctm, state_.moving) = std::move(savedTransforms_.back());
      savedTransforms_.pop_back();
      break;
    case BlockKind::Motion:
      endMotion();
      break;
    case BlockKind::Resource:
      break;
    default:
      if (kind == BlockKind::Solid) endSolid();
      state_ = std::move(savedStates_.back());
      savedStates_.pop_back();
      if (kind == BlockKind::Object) objectBase_ = M44d();
  }
  while (!scopedSystems_.empty() && scopedSystems_.back().depth > blocks_.depth()) {
    scene_.coordinateSystems[scopedSystems_.back().name] = scopedSystems_.back().previous;
    scopedSystems_.pop_back();
  }

  const auto cutBack = [this](SceneMark& mark) {
    scene_.shaders.resize(mark.shaders);
    scene_.lights.resize(mark.lights);
    scene_.objects.resize(mark.objects);
    scene_.attributes.resize(mark.attributes);
    scene_.coordinateSystems = std::move(mark.coordinateSystems);
    lightHandles_ = std::move(mark.lightHandles);
    objectHandles_ = std::move(mark.objectHandles);
    shadersByHash_.clear();
    attributesByHash_.clear();
    resources_.clear();
  };
  if (kind == BlockKind::World) {
    scene_.primitives.clear();
    scene_.solids.clear();
    scene_.instances.clear();
    scene_.delayed.clear();
    scene_.readDelayed = nullptr;
    lastDelayed_.reset();
    scene_.shaders = std::move(world_->shaders);
    cutBack(world_->mark);
    world_.reset();
  } else if (kind == BlockKind::Frame) {
    FrameStart& start = *frames_.back();
    options_ = std::move(start.options);
    camera_ = start.camera;
    patinaMode_ = std::move(start.patinaMode);
    riMode_ = std::move(start.riMode);
    cutBack(start.mark);
    scene_.frame = 0;
    frames_.pop_back();
  }
}

// ---- Frames and worlds ------------------------------------------------------------------------------------

void SceneBuilder::frameBegin(int number, const Location& at) {
  if (inWorld() || inObject()) {
    return error(RiError::Nesting, at,
                 fmt::format("FrameBegin inside {}Begin", inWorld() ? "World" : "Object"));
  }
  if (blocks_.isOpen(BlockKind::Frame)) error(RiError::Nesting, at, "FrameBegin inside a frame");
  if (!open(BlockKind::Frame, at)) return;
  scene_.frame = number;
  frames_.push_back(std::make_unique<FrameStart>(
      FrameStart{{scene_.shaders.size(), scene_.lights.size(), scene_.objects.size(),
                  scene_.attributes.size(), scene_.coordinateSystems, lightHandles_, objectHandles_},
                 options_,
                 camera_,
                 patinaMode_,
                 riMode_}));
}

void SceneBuilder::frameEnd(const Location& at) { close(BlockKind::Frame, at); }

void SceneBuilder::worldBegin(const Location& at) {
  if (inWorld() || inObject()) {
    return error(RiError::Nesting, at,
                 fmt::format("WorldBegin inside {}Begin", inWorld() ? "World" : "Object"));
  }
  if (!open(BlockKind::World, at)) return;
  world_ = std::make_unique<WorldStart>(
      WorldStart{{scene_.shaders.size(), scene_.lights.size(), scene_.objects.size(),
                  scene_.attributes.size(), scene_.coordinateSystems, lightHandles_, objectHandles_},
                 scene_.shaders});
  firstWorldState_ = savedStates_.size();

  // World space is what is current now; what was placed before, relative to the camera, gets its place in it.
  camera_.worldToCamera = state_.ctm;
  camera_.motion = state_.moving.outer ? std::make_shared<Movement>(state_.moving) : nullptr;
  const M44d cameraToWorld = inverted(state_.ctm).value_or(M44d());
  for (ShaderBinding& shader : scene_.shaders) shader.shaderToWorld *= cameraToWorld;
  for (auto& [system, toWorld] : scene_.coordinateSystems) toWorld *= cameraToWorld;
  scene_.coordinateSystems["camera"] = cameraToWorld;
  scene_.coordinateSystems["world"] = M44d();
  shadersByHash_.clear();
  state_.ctm = M44d();
  state_.moving = {};
  scene_.camera = camera_;
  scene_.options = options_;
  resolveFrame(scene_.options, scene_.camera);
}

void SceneBuilder::worldEnd(const Location& at) {
  if (outer_) return error(RiError::Nesting, at, "WorldEnd in a delayed archive");
  close(BlockKind::World, at);
}

void SceneBuilder::endWorld() {
  scene_.options = options_;
  scene_.options.mode = patinaMode_.empty() ? riMode_ : patinaMode_;
  const M44d worldToCamera = scene_.camera.worldToCamera;
  scene_.camera = camera_;
  scene_.camera.worldToCamera = worldToCamera;
  resolveFrame(scene_.options, scene_.camera);
  settleMotion(scene_);
  reportNotices();
  scene_.readDelayed = [this](const DelayedArchive& archive, ErrorHandler& errors) {
    return readDelayed(archive, errors);
  };
  if (!errors_.aborted() && onWorld_) onWorld_(scene_);
}

}  // namespace patina
