// SPDX-License-Identifier: Apache-2.0
// Rays of plugins: counted, checked, traced.
#include "renderer/shading/ray_service.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "renderer/base/statistics.h"
#include "renderer/shading/shader_instance.h"

namespace patina {
namespace {

STAT_COUNTER("Shaders/rays traced", shaderRays);
STAT_COUNTER("Shaders/rays refused", refusedRays);

constexpr int32_t kRefused = -400, kStrange = -401;  // codes of messages

thread_local RayCall* presentCall = nullptr;

float at(const PatinaPlane& plane, uint32_t i) { return plane.data[size_t(i) * plane.stride]; }
V3f at(const PatinaPlane3& planes, uint32_t i) { return {at(planes.x, i), at(planes.y, i), at(planes.z, i)}; }
bool isThere(const PatinaPlane& plane) { return plane.data && plane.stride <= 1; }
bool isThere(const PatinaPlane3& planes) {
  return isThere(planes.x) && isThere(planes.y) && isThere(planes.z);
}

/// The rays of a call that are to be traced, and which of its rays they are.
struct Wanted {
  std::vector<Ray> rays;
  std::vector<uint32_t> which;
  std::vector<Hit> hits;
  std::vector<uint8_t> occluded;
};
thread_local Wanted wanted;

}  // namespace

RayCall::RayCall(const ShaderInstance& shader, PatinaEntry entry, uint32_t lanes, const Accel* accel,
                 const FacetOf& facetOf)
    : before_(presentCall),
      shader_(&shader),
      entry_(entry),
      accel_(accel),
      facetOf_(&facetOf),
      most_(shader.raysOf(entry)),
      used_(lanes, 0) {
  presentCall = this;
}

RayCall::RayCall(uint32_t lane) : before_(presentCall) {
  if (!before_) return;
  shader_ = before_->shader_, entry_ = before_->entry_, accel_ = before_->accel_;
  facetOf_ = before_->facetOf_, firstLane_ = before_->firstLane_ + lane, most_ = before_->most_;
  used_.assign(1, 0);
  presentCall = this;
}

RayCall::~RayCall() { presentCall = before_; }

/// Why the call gets no rays; nullptr: it does. Counts them if so.
const char* RayCall::refusal(const PatinaRayIn& in) {
  if (!in.lane || !isThere(in.direction) || !isThere(in.maximum) || (in.origin.x.data && !isThere(in.origin)))
    return "gives rays without lanes, directions or maxima";
  if (std::any_of(in.lane, in.lane + in.count, [&](uint32_t lane) { return lane >= used_.size(); }))
    return "asks for rays of a point that is not in the batch";
  for (uint32_t i = 0; i < in.count; ++i)
    if (at(in.maximum, i) > 0) ++used_[in.lane[i]];
  if (std::all_of(used_.begin(), used_.end(), [&](uint32_t n) { return n <= most_; })) return nullptr;
  for (uint32_t i = 0; i < in.count; ++i)
    if (at(in.maximum, i) > 0) --used_[in.lane[i]];
  return "asks for more rays per point than it has declared";
}

void RayCall::makeRays(const PatinaRayIn& in) {
  wanted.rays.clear(), wanted.which.clear();
  for (uint32_t i = 0; i < in.count; ++i) {
    const float maximum = at(in.maximum, i);
    if (!(maximum > 0)) {
      strange_ += std::isnan(maximum);
      continue;
    }
    const V3f direction = normalizedOr(at(in.direction, i), V3f(0, 0, 0));
    const bool isOwn = in.origin.x.data != nullptr;
    const V3f origin = isOwn                 ? at(in.origin, i)
                       : isFinite(direction) ? leave((*facetOf_)(firstLane_ + in.lane[i]), direction)
                                             : V3f(0, 0, 0);
    if (!isFinite(direction) || isBlack(direction) || !isFinite(origin)) {
      ++strange_;
      continue;
    }
    wanted.rays.push_back({origin, direction, 0, std::min(maximum, kInfinity), kDiffuseRay, 0});
    wanted.which.push_back(i);
  }
}

PatinaStatus RayCall::trace(const ShaderInstance& shader, const PatinaRayIn* in, PatinaRayOut* out) {
  const PatinaHost& host = shader.host();
  const auto refuse = [&](const char* why, const char* entry) {
    refusedRays += in ? in->count : 0;
    host.report(host.host, PATINA_REPORT_ERROR, kRefused, fmt::format("{} {}", entry, why).c_str());
    return PATINA_ERROR_PARAMETER;
  };
  RayCall* const call = presentCall;
  if (!call || call->shader_ != &shader) return refuse("traces rays where it has declared none", "it");
  const char* const entry = call->entry_ == PATINA_ENTRY_VIEW ? "view" : "radiosity";
  if (!in || !out || (!out->distance && !out->occluded)) return refuse("asks nothing of its rays", entry);
  if (const char* const why = call->refusal(*in)) return refuse(why, entry);

  call->strange_ = 0;
  call->makeRays(*in);
  const size_t n = wanted.rays.size();
  const bool any = call->accel_ && n > 0;
  // Displacement may run meanwhile, of what rays meet first: it has no rays.
  presentCall = nullptr;
  for (uint32_t i = 0; i < in->count; ++i) {
    if (out->distance) out->distance[i] = PATINA_INFINITE_DISTANCE;
    if (out->occluded) out->occluded[i] = 0;
  }
  if (any && out->distance) {
    wanted.hits.resize(n);
    call->accel_->intersect(wanted.rays, wanted.hits);
    for (size_t k = 0; k < n; ++k) {
      if (!wanted.hits[k].valid()) continue;
      out->distance[wanted.which[k]] = wanted.hits[k].t;
      if (out->occluded) out->occluded[wanted.which[k]] = 1;
    }
  } else if (any) {
    wanted.occluded.resize(n);
    call->accel_->occluded(wanted.rays, wanted.occluded);
    for (size_t k = 0; k < n; ++k) out->occluded[wanted.which[k]] = wanted.occluded[k];
  }
  presentCall = call;
  call->traced_ += static_cast<int64_t>(n);
  shaderRays += static_cast<int64_t>(n);
  if (call->strange_ > 0)
    host.report(
        host.host, PATINA_REPORT_WARNING, kStrange,
        fmt::format("{} asks for rays that are not finite or have no direction; they meet nothing", entry)
            .c_str());
  return PATINA_OK;
}

}  // namespace patina
