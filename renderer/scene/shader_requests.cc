// SPDX-License-Identifier: Apache-2.0
// Shader bindings, lights and light lists.
#include <fmt/format.h>

#include <algorithm>

#include "renderer/scene/hash.h"
#include "renderer/scene/scene_builder.h"

namespace patina {
namespace {

size_t hashOf(const ShaderBinding& binding) {
  Hasher hasher;
  hasher.add(binding.name);
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) hasher.add(binding.shaderToWorld[row][column]);
  }
  for (const ShaderArgument& argument : binding.arguments) {
    hasher.add(argument.name).add(argument.floats).add(argument.ints);
    for (const std::string& text : argument.strings) hasher.add(text);
  }
  return hasher.value();
}

bool sameArgument(const ShaderArgument& a, const ShaderArgument& b) {
  return a.name == b.name && a.type == b.type && a.arrayLength == b.arrayLength && a.floats == b.floats &&
         a.ints == b.ints && a.strings == b.strings;
}

bool sameBinding(const ShaderBinding& a, const ShaderBinding& b) {
  return a.name == b.name && a.shaderToWorld == b.shaderToWorld &&
         std::ranges::equal(a.arguments, b.arguments, sameArgument);
}

}  // namespace

/// The values of a parameter, of the request that `subject` names. False: it has none that make sense, which
/// has been said.
bool SceneBuilder::takeArgument(const Param& param, const std::string& subject, ShaderArgument& argument) {
  const Declaration& declaration = param.declaration;
  const size_t count = param.floats.size() + param.ints.size() + param.strings.size();
  if (declaration.reference) {
    countNotice(fmt::format("shader connections are not followed: \"{}\" of {} keeps its default",
                            param.name(), subject),
                param.location);
    return false;
  }
  if (count == 0) return false;  // an empty array: the shader's default
  const size_t components =
      param.floats.empty() ? declaration.arrayLength : static_cast<size_t>(declaration.components());
  if (declaration.declared && count != components) {
    warning(RiError::BadParamList, param.location,
            fmt::format("parameter \"{}\" of {} has {} values, expected {} ({}): left at its default",
                        param.name(), subject, count, components, toString(declaration)),
            fmt::format("shader values {} {}", subject, param.name()));
    return false;
  }
  if (!std::ranges::all_of(param.floats, [](float value) { return std::isfinite(value); })) {
    error(RiError::Range, param.location,
          fmt::format("parameter \"{}\" of {} is not finite", param.name(), subject));
    return false;
  }
  argument.name = param.name();
  argument.type = declaration.type;
  argument.arrayLength = declaration.arrayLength > 1 ? static_cast<int>(declaration.arrayLength) : 0;
  argument.floats.assign(param.floats.begin(), param.floats.end());
  argument.ints.assign(param.ints.begin(), param.ints.end());
  argument.strings.assign(param.strings.begin(), param.strings.end());
  argument.where = param.location;
  return true;
}

uint32_t SceneBuilder::addShader(std::string_view name, const ParamList& params, const Location& at) {
  ShaderBinding binding;
  binding.name = name;
  binding.shaderToWorld = state_.ctm * objectBase_;
  binding.where = at;
  binding.user = state_.attributes.user;
  const std::string subject = fmt::format("\"{}\"", name);
  for (const Param& param : params) {
    param.used = true;
    ShaderArgument argument;
    if (takeArgument(param, subject, argument)) binding.arguments.push_back(std::move(argument));
  }

  // Exporters repeat the same shader before each primitive.
  const auto find = [&](size_t hash, const auto& matches) {
    const auto [begin, end] = shadersByHash_.equal_range(hash);
    const auto found = std::find_if(begin, end, [&](const auto& e) {
      const ShaderBinding& known = scene_.shaders[e.second - scene_.firstShader];
      return sameBinding(known, binding) && matches(known, e.second);
    });
    return found == end ? kNone : found->second;
  };
  const size_t hash = hashOf(binding);
  const size_t withUser = binding.user.empty() ? hash : Hasher().add(hash).add(binding.user.hash()).value();
  const uint32_t same =
      find(withUser, [&](const ShaderBinding& known, uint32_t) { return known.user == binding.user; });
  if (same != kNone) return same;
  const auto index = scene_.firstShader + static_cast<uint32_t>(scene_.shaders.size());
  const uint32_t first = find(hash, [](const ShaderBinding& known, uint32_t k) { return known.alike == k; });
  binding.alike = first == kNone ? index : first;
  if (first == kNone && withUser != hash) shadersByHash_.emplace(hash, index);
  shadersByHash_.emplace(withUser, index);
  scene_.shaders.push_back(std::move(binding));
  return index;
}

void SceneBuilder::surface(std::string_view name, const ParamList& params, const Location& at) {
  const uint32_t shader = addShader(name, params, at);
  changeAttributes().surface = shader;
  state_.bxdfColor.reset();
}

void SceneBuilder::displacement(std::string_view name, const ParamList& params, const Location& at) {
  const bool none = name.empty() || name == "null";
  const uint32_t shader = none ? kNone : addShader(name, params, at);
  changeAttributes().displacement = shader;
}

void SceneBuilder::atmosphere(std::string_view name, const ParamList& params, const Location& at) {
  const bool none = name.empty() || name == "null";
  const uint32_t shader = none ? kNone : addShader(name, params, at);
  changeAttributes().atmosphere = shader;
}

// ---- Lights -----------------------------------------------------------------------------------------------

uint32_t SceneBuilder::addLight(std::string_view name, Handle handle, bool isArea, const ParamList& params,
                                const Location& at) {
  const Light light{addShader(name, params, at), isArea, state_.lightsCastShadows, std::string(handle.text)};
  std::vector<uint32_t>& on = changeAttributes().lights;
  if (!handle) {
    const auto index = static_cast<uint32_t>(scene_.lights.size());
    scene_.lights.push_back(light);
    on.push_back(index);
    return index;
  }
  // A handle that is used again names the new light, which takes the old one's place in the list.
  const auto [known, isNew] = lightHandles_.try_emplace(light.handle, kNone);
  if (!isNew) {
    const Light& old = scene_.lights[known->second];
    if (old.shader == light.shader && old.isArea == light.isArea && old.castsShadows == light.castsShadows) {
      if (std::ranges::find(on, known->second) == on.end())
        on.insert(std::ranges::upper_bound(on, known->second), known->second);
      return known->second;
    }
    std::erase(on, known->second);
  }
  const auto index = static_cast<uint32_t>(scene_.lights.size());
  scene_.lights.push_back(light);
  known->second = index;
  on.push_back(index);
  return index;
}

void SceneBuilder::lightSource(std::string_view name, Handle handle, const ParamList& params,
                               const Location& at) {
  if (!leaveOutLight(name, at)) addLight(name, handle, false, params, at);
}

void SceneBuilder::areaLightSource(std::string_view name, Handle handle, const ParamList& params,
                                   const Location& at) {
  const bool none = name.empty() || name == "null" || name == "none";
  if (!none && leaveOutLight(name, at)) return;
  if (name.starts_with("PxrStd")) return modernAreaLight(name, handle, params, at);
  const uint32_t light = none ? kNone : addLight(name, handle, true, params, at);
  changeAttributes().areaLight = light;
}

void SceneBuilder::illuminate(Handle light, bool on, const Location& at) {
  const uint32_t* const index = known(&SceneBuilder::lightHandles_, light.text);
  if (!index) {
    return error(RiError::BadHandle, at,
                 fmt::format("Illuminate: no light has the handle \"{}\"", light.text));
  }
  std::vector<uint32_t>& lights = changeAttributes().lights;
  std::erase(lights, *index);
  if (on) lights.insert(std::ranges::upper_bound(lights, *index), *index);
}

}  // namespace patina
