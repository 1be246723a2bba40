// SPDX-License-Identifier: Apache-2.0
// Delayed archives among the geometry: their bounds, and what happens when a ray has met one.
#include "renderer/geometry/delayed_geometry.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <chrono>
#include <stdexcept>

#include "renderer/base/sampling.h"
#include "renderer/geometry/geometry.h"

namespace patina {
namespace {

/// Room around a bound, in parts of its size: what it is given with was rounded, too.
constexpr float kRoom = 1e-4f;
/// Content may reach so far out of a bound, in parts of its diagonal, before that is worth a warning: some of
/// it is only known by the hull of its control points.
constexpr float kStickOut = 0.01f;

}  // namespace

void Geometry::addDelayed(GeometryPart& part) const {
  part.firstDelayed = static_cast<uint32_t>(delayed_.size());
  for (const DelayedArchive& archive : part.scene->delayed) {
    const size_t index = delayed_.size() - part.firstDelayed;
    const M44d inverse = archive.objectToWorld.inverse();
    const Box3f& box = archive.bound;
    const float room =
        kRoom * box.size().length() + 4e-6f * std::max(maxAbsComponent(box.min), maxAbsComponent(box.max));
    const Box3f bound(box.min - V3f(room), box.max + V3f(room));
    Box3f world;
    for (int corner = 0; corner < 8; ++corner)
      world.extendBy(V3f(V3d(corner & 1 ? bound.max.x : bound.min.x, corner & 2 ? bound.max.y : bound.min.y,
                             corner & 4 ? bound.max.z : bound.min.z) *
                         archive.objectToWorld));
    if (!isFinite(world.min) || !isFinite(world.max) || !isFinite(V3f(V3d(0, 0, 0) * inverse))) {
      errors_.report(Severity::Error, RiError::Math, archive.where,
                     fmt::format("delayed archive \"{}\" is left out: its bound is not finite in the world",
                                 archive.file));
      continue;
    }
    const float pad = 4e-6f * std::max(maxAbsComponent(world.min), maxAbsComponent(world.max));
    DelayedPlace& place = delayed_.emplace_back();
    place.archive = &archive, place.around = &part;
    place.seed = hashOf(part.seed, index) | 1;  // not 0, which is the frame's scene
    place.bound = bound;
    place.worldToObject = M44f(inverse);
    place.worldBound = Box3f(world.min - V3f(pad), world.max + V3f(pad));
    if (part.seed == 0) bound_.extendBy(place.worldBound);
  }
  part.endDelayed = static_cast<uint32_t>(delayed_.size());
}

bool Geometry::clipToBound(uint32_t index, const V3f& origin, const V3f& direction, float& tNear,
                           float& tFar) const {
  const DelayedPlace& place = delayed_[index];
  const V3f o = transformPoint(origin, place.worldToObject),
            d = transformVector(direction, place.worldToObject);
  // What the transformation of a distant origin may have lost.
  const M44f& m = place.worldToObject;
  const float lost =
      roundingBound(16) * (maxAbsComponent(o) + maxAbsComponent({m[3][0], m[3][1], m[3][2]}) +
                           std::max(maxAbsComponent(place.bound.min), maxAbsComponent(place.bound.max)));
  for (int k = 0; k < 3; ++k) {
    const float low = place.bound.min[k] - lost - o[k], high = place.bound.max[k] + lost - o[k];
    if (d[k] == 0) {
      if (low > 0 || high < 0) return false;
      continue;
    }
    const float a = low / d[k], b = high / d[k];
    const float enter = std::min(a, b), leave = std::max(a, b);
    tNear = std::max(tNear, enter - roundingBound(16) * std::abs(enter));
    tFar = std::min(tFar, leave + roundingBound(16) * std::abs(leave));
  }
  return tNear <= tFar;
}

const GeometryPart& Geometry::load(uint32_t index) const {
  DelayedPlace& place = delayed_[index];
  const std::scoped_lock lock(place.mutex);
  if (const GeometryPart* known = place.loaded.load(std::memory_order_acquire)) return *known;
  const auto start = std::chrono::steady_clock::now();
  place.made = std::make_unique<GeometryPart>();
  GeometryPart& part = *place.made;
  part.around = place.around;
  part.seed = place.seed;
  // Tasks of others must not run here meanwhile: their rays might meet this very archive.
  tbb::this_task_arena::isolate([&] {
    try {
      part.scene = place.around->scene->readDelayed(*place.archive, errors_);
      if (!part.scene) return;
      grow(part);
      warnOfBound(place, part);
      if (makeTracer_) part.tracer = makeTracer_(part);
    } catch (const std::exception& error) {
      errors_.report(
          Severity::Error, RiError::OutOfMemory, place.archive->where,
          fmt::format("delayed archive \"{}\" is left out: {}", place.archive->file, error.what()));
    }
  });
  loadingTime_ += std::chrono::nanoseconds(std::chrono::steady_clock::now() - start).count();
  place.loaded.store(place.made.get(), std::memory_order_release);
  return *place.made;
}

/// Puts a part that was read into the tables. Where that breaks off they no longer fit each other: nothing
/// can be put there any more, but what is there stays good.
void Geometry::grow(GeometryPart& part) const {
  const std::scoped_lock lock(growMutex_);
  if (full_) throw std::length_error("there is no room for more geometry");
  full_ = true;
  part.attributes = part.scene->attributes;
  if (listener_) listener_->begin(part);
  for (Attributes& attributes : part.attributes)
    for (uint32_t* shader : {&attributes.surface, &attributes.displacement, &attributes.atmosphere})
      if (*shader != kNone) *shader = part.shader(*shader);
  append(part);
  if (listener_) listener_->end(part);
  full_ = false;
}

void Geometry::dropTracers() const {
  listener_ = nullptr;
  makeTracer_ = nullptr;
  for (size_t k = 0; k < delayed_.size(); ++k)
    if (delayed_[k].made) delayed_[k].made->tracer.reset();
}

void Geometry::warnOfBound(const DelayedPlace& place, const GeometryPart& part) const {
  Box3f content;  // in the space of the bound, all the time that the shutter is open
  const auto extend = [&](const TracedSurface& traced, const Box3f& box, const M44f& toMesh,
                          const M44f& meshToObject) {
    Box3f here;
    const M44f toObject = toMesh * meshToObject;
    for (int corner = 0; corner < 8; ++corner)
      here.extendBy(transformPoint({corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                                    corner & 4 ? box.max.z : box.min.z},
                                   toObject));
    // Displacement reaches as far as a ball in mesh space.
    const auto stretch = [&](int k) {
      return V3f(meshToObject[0][k], meshToObject[1][k], meshToObject[2][k]).length();
    };
    const V3f reach = traced.reach * V3f(stretch(0), stretch(1), stretch(2));
    content.extendBy(here.min - reach), content.extendBy(here.max + reach);
  };
  for (uint32_t k = part.firstPlacement; k < part.endPlacement; ++k) {
    const Placement& p = placements_[k];
    const TracedSurface& traced = traced_[p.traced];
    for (uint32_t step = 0; step <= traced.segments; ++step) {
      const Box3f box = boundAt(p.traced, step);
      const M44f toMesh = toMeshAt(p.traced, step);
      if (p.instance == kNone) {
        extend(traced, box, toMesh, place.worldToObject);
        continue;
      }
      const PlacedInstance& instance = instances_[p.instance];
      extend(traced, box, toMesh, instance.meshToWorld * place.worldToObject);
      if (instance.movement == kNone) continue;
      for (const TransformParts& at : movements_[instance.movement].steps)
        extend(traced, box, toMesh, M44f(at.matrix()) * place.worldToObject);
    }
  }
  const Box3f& bound = place.archive->bound;
  const float allowed = kStickOut * bound.size().length();
  bool out = false;
  for (int k = 0; k < 3; ++k)
    out |= content.min[k] < bound.min[k] - allowed || content.max[k] > bound.max[k] + allowed;
  if (content.isEmpty() || !out) return;
  const auto text = [](const Box3f& b) {
    return fmt::format("[{:.4g} {:.4g} {:.4g} {:.4g} {:.4g} {:.4g}]", b.min.x, b.max.x, b.min.y, b.max.y,
                       b.min.z, b.max.z);
  };
  errors_.reportOnce(Severity::Warning, RiError::Range, place.archive->where,
                     fmt::format("bound of {}", place.archive->file),
                     fmt::format("delayed archive \"{}\" reaches out of its bound {}: it fills {}, and what "
                                 "sticks out is not seen",
                                 place.archive->file, text(bound), text(content)));
}

}  // namespace patina
