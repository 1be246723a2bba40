// SPDX-License-Identifier: Apache-2.0
// Choosing and moving the origin.
#include "renderer/scene/origin.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "renderer/scene/graphics_state.h"

namespace patina {
namespace {

/// Distances from the origin, in half diagonals of what is there, from which on it is moved.
constexpr double kFar = 16;

/// Points of a primitive that say where it stands, in its own space.
template <class Visit>
void forPoints(const Primitive& primitive, const Visit& visit) {
  constexpr size_t kPoints = 8;
  for (const PrimVar& variable : primitive.variables) {
    if (variable.name != "P") continue;
    const size_t count = variable.floats.size() / 3, step = std::max<size_t>(count / kPoints, 1);
    for (size_t k = 0; k < count; k += step) {
      const float* p = &variable.floats[3 * k];
      visit(V3d(static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])));
    }
    return;
  }
  visit(V3d(0, 0, 0));
}

/// Whether a transformation moves, of anything but the camera.
bool hasMovement(const Scene& scene) {
  return std::ranges::any_of(scene.primitives,
                             [](const Primitive& p) { return p.motion && p.motion->place.outer; }) ||
         std::ranges::any_of(scene.instances, [](const Instance& i) { return i.motion != nullptr; });
}

}  // namespace

std::optional<V3d> betterOrigin(const Scene& scene) {
  if (hasMovement(scene)) return std::nullopt;
  Imath::Box3d box;
  const auto add = [&](const V3d& p) {
    if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) box.extendBy(p);
  };
  for (const Primitive& primitive : scene.primitives)
    forPoints(primitive, [&](const V3d& p) { add(p * primitive.objectToWorld); });
  for (const Instance& instance : scene.instances)
    if (instance.object >= scene.firstObject && instance.object - scene.firstObject < scene.objects.size())
      for (const Primitive& primitive : scene.objects[instance.object - scene.firstObject].primitives)
        forPoints(primitive,
                  [&](const V3d& p) { add(p * (primitive.objectToWorld * instance.objectToWorld)); });
  for (const DelayedArchive& archive : scene.delayed)
    for (int k = 0; k < 8; ++k)
      add(V3d(V3f((k & 1 ? archive.bound.max : archive.bound.min).x,
                  (k & 2 ? archive.bound.max : archive.bound.min).y,
                  (k & 4 ? archive.bound.max : archive.bound.min).z)) *
          archive.objectToWorld);
  if (box.isEmpty()) return std::nullopt;
  const V3d middle = box.center();
  if (!(middle.length() > kFar * box.size().length() / 2)) return std::nullopt;
  return middle;
}

void moveOrigin(Scene& scene, const V3d& origin) {
  M44d by, back;
  by.setTranslation(-origin), back.setTranslation(origin);
  scene.camera.worldToCamera = back * scene.camera.worldToCamera;
  if (scene.camera.motion) {
    Movement movement = *scene.camera.motion;
    movement.inner = back * movement.inner;
    scene.camera.motion = std::make_shared<const Movement>(movement);
  }
  for (ShaderBinding& shader : scene.shaders) shader.shaderToWorld *= by;
  for (auto& [name, toWorld] : scene.coordinateSystems) toWorld *= by;
  for (Primitive& primitive : scene.primitives) primitive.objectToWorld *= by;
  for (Instance& instance : scene.instances) instance.objectToWorld *= by;
  std::map<const DelayedState*, std::shared_ptr<const DelayedState>> states;
  for (DelayedArchive& archive : scene.delayed) {
    archive.objectToWorld *= by;
    std::shared_ptr<const DelayedState>& state = states[archive.state.get()];
    if (!state) {
      DelayedState changed = *archive.state;
      for (auto& [name, toWorld] : changed.systems) toWorld *= by;
      state = std::make_shared<const DelayedState>(std::move(changed));
    }
    archive.state = state;
  }
}

}  // namespace patina
