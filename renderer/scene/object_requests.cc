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
  objectHandles_[std::string(handle.text)] =
      scene_.firstObject + static_cast<uint32_t>(scene_.objects.size());
  scene_.objects.emplace_back();
  // The object's own space starts here; instances bring their place, orientation and attributes.
  objectBase_ = state_.ctm;
  state_.ctm = M44d();
  state_.moving = {};
  state_.inside = false;
  state_.touched = false;
  state_.solid = {};
}

void SceneBuilder::objectInstance(Handle handle, const ParamList& params, const Location& at) {
  for (const Param& param : params) param.used = true;
  const uint32_t* const object = known(&SceneBuilder::objectHandles_, handle.text);
  if (!object) {
    return error(RiError::BadHandle, at,
                 fmt::format("ObjectInstance: no object has the handle \"{}\"", handle.text));
  }
  if (inObject()) return unhandled("ObjectInstance inside ObjectBegin", at);
  if (!mayDraw(at)) return;
  if (state_.solid.solid != kNone)
    countNotice("ObjectInstance inside SolidBegin is drawn whole beside the solid", at);
  if (!isAffine(state_.ctm)) {
    return error(RiError::Math, at, "ObjectInstance under a perspective transformation cannot be drawn",
                 "projective");
  }
  if (outer_ && emits(*object) && leaveOutLight(fmt::format("object {}", handle.text), at)) return;
  Instance instance;
  instance.object = *object;
  instance.objectToWorld = state_.ctm;
  // Lights are sampled all over their surfaces, of which solids keep only a part.
  const uint32_t light = state_.attributes.areaLight;
  const bool dark = light != kNone && !scene_.objects[instance.object - scene_.firstObject].solids.empty();
  if (dark) {
    warning(RiError::Incapable, at, "an area light on solids of an ObjectInstance gives no light");
    changeAttributes().areaLight = kNone;
  }
  instance.attributes = storeAttributes();
  if (dark) changeAttributes().areaLight = light;
  instance.reversed = state_.inside;
  instance.where = at;
  if (state_.moving.outer) instance.motion = std::make_shared<Movement>(state_.moving);
  scene_.instances.push_back(std::move(instance));
}

}  // namespace patina
