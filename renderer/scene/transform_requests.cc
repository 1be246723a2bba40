// SPDX-License-Identifier: Apache-2.0
// Transformations: each request makes a new current transformation, or is refused when that could not be
// inverted.
#include <fmt/format.h>

#include "renderer/scene/matrices.h"
#include "renderer/scene/scene_builder.h"

namespace patina {

bool SceneBuilder::setTransform(const M44d& ctm, const Location& at) {
  if (!inverted(ctm)) {
    error(RiError::Math, at, "the current transformation would be singular: request ignored", "singular");
    return false;
  }
  if (takesMotionKeys()) return addMotionKey({ctm, std::nullopt}, true), true;
  state_.ctm = ctm;
  state_.moving = {};
  return true;
}

bool SceneBuilder::concat(const M44d& matrix, const Location& at, const std::optional<Turn>& turn) {
  if (!inverted(matrix * state_.ctm) || (motion_ && !inverted(matrix))) {
    error(RiError::Math, at, "the current transformation would be singular: request ignored", "singular");
    return false;
  }
  if (takesMotionKeys()) return addMotionKey({matrix, turn}, false), true;
  state_.ctm = matrix * state_.ctm;
  if (state_.moving.outer) state_.moving.inner = matrix * state_.moving.inner;
  return true;
}

// In a delayed archive the world's origin may have been moved: see origin.h.
void SceneBuilder::identity(const Location& at) {
  setTransform(outer_ && !inObject() ? namedTransform("world").value_or(M44d()) : M44d(), at);
}

void SceneBuilder::transform(const RibMatrix& matrix, const Location& at) {
  const M44d m = toMatrix(matrix);
  setTransform(outer_ && !inObject() ? m * namedTransform("world").value_or(M44d()) : m, at);
}

void SceneBuilder::concatTransform(const RibMatrix& matrix, const Location& at) {
  concat(toMatrix(matrix), at);
}

void SceneBuilder::perspective(float fieldOfView, const Location& at) {
  if (!(fieldOfView > 0 && fieldOfView < 180)) {
    return error(RiError::Range, at, fmt::format("Perspective {}: expected 0 to 180 degrees", fieldOfView));
  }
  if (!inWorld()) return unhandled("Perspective before WorldBegin", at);
  concat(perspectiveMatrix(fieldOfView), at);
}

void SceneBuilder::translate(float x, float y, float z, const Location& at) {
  concat(translation(x, y, z), at);
}

void SceneBuilder::rotate(float angle, float x, float y, float z, const Location& at) {
  if (x == 0 && y == 0 && z == 0)
    return error(RiError::Math, at, "Rotate about an axis of no length", "rotate axis");
  concat(rotation(angle, V3d(x, y, z)), at, Turn{0, angle, V3d(x, y, z)});
}

void SceneBuilder::scale(float x, float y, float z, const Location& at) {
  if (x == 0 || y == 0 || z == 0) {
    return error(RiError::Math, at, fmt::format("Scale {} {} {}: no factor may be 0", x, y, z), "scale 0");
  }
  concat(scaling(x, y, z), at);
}

void SceneBuilder::skew(float angle, const std::array<float, 6>& d, const Location& at) {
  const auto matrix = patina::skew(angle, V3d(d[0], d[1], d[2]), V3d(d[3], d[4], d[5]));
  if (!matrix) {
    return error(RiError::Math, at,
                 fmt::format("Skew: {} degrees reach or pass the angle between the two axes", angle), "skew");
  }
  concat(*matrix, at);
}

void SceneBuilder::coordinateSystem(std::string_view name, const Location&) {
  scene_.coordinateSystems[std::string(name)] = state_.ctm * objectBase_;
}

void SceneBuilder::scopedCoordinateSystem(std::string_view name, const Location& at) {
  // A name that meant nothing before keeps its meaning behind the block: shaders inside ask for it after
  // parsing.
  const auto previous = scene_.coordinateSystems.find(std::string(name));
  if (previous != scene_.coordinateSystems.end()) {
    scopedSystems_.push_back({blocks_.depth(), previous->first, previous->second});
  } else if (const auto around = outer_ ? outer_->namedTransform(name) : std::nullopt) {
    scopedSystems_.push_back({blocks_.depth(), std::string(name), *around});
  }
  coordinateSystem(name, at);
}

std::optional<M44d> SceneBuilder::namedTransform(std::string_view name) const {
  const auto system = scene_.coordinateSystems.find(std::string(name));
  if (system != scene_.coordinateSystems.end()) return system->second;
  if (outer_) return outer_->namedTransform(name);
  if (name == "world" || name == "camera") return M44d();  // outside of a world block both are the same
  return std::nullopt;
}

void SceneBuilder::coordSysTransform(std::string_view name, const Location& at) {
  const std::optional<M44d> system = namedTransform(name);
  if (!system) {
    return error(RiError::BadToken, at,
                 fmt::format("CoordSysTransform: no coordinate system is named \"{}\"", name));
  }
  setTransform(*system * inverted(objectBase_).value_or(M44d()), at);
}

}  // namespace patina
