// SPDX-License-Identifier: Apache-2.0
// Retained objects and their instances.
#include <fmt/format.h>

#include "renderer/scene/matrices.h"
#include "renderer/scene/scene_builder.h"

namespace patina {

void SceneBuilder::objectBegin(Handle handle, const ParamList& params, const Location& at) {
  for (const Param& param : params) param.used = true;
  if (inObject()) {
    error(RiError::Nesting, at, "ObjectBegin inside ObjectBegin");
    return;
  }
  if (!open(BlockKind::Object, at)) return;
  objectHandles_[std::string(handle.text)] = static_cast<uint32_t>(scene_.objects.size());
  scene_.objects.emplace_back();
  // The object's own space starts here; instances bring their place, orientation and attributes.
  objectBase_ = state_.ctm;
  state_.ctm = M44d();
  state_.inside = false;
  state_.touched = false;
}

void SceneBuilder::objectInstance(Handle handle, const ParamList& params, const Location& at) {
  for (const Param& param : params) param.used = true;
  const auto known = objectHandles_.find(std::string(handle.text));
  if (known == objectHandles_.end()) {
    return error(RiError::BadHandle, at,
                 fmt::format("ObjectInstance: no object has the handle \"{}\"", handle.text));
  }
  if (inObject()) return unhandled("ObjectInstance inside ObjectBegin", at);
  if (!mayDraw(at)) return;
  if (!isAffine(state_.ctm)) {
    return error(RiError::Math, at, "ObjectInstance under a perspective transformation cannot be drawn",
                 "projective");
  }
  Instance instance;
  instance.object = known->second;
  instance.objectToWorld = state_.ctm;
  instance.attributes = storeAttributes();
  instance.reversed = state_.inside;
  instance.where = at;
  scene_.instances.push_back(std::move(instance));
}

}  // namespace patina
