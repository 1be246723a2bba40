// SPDX-License-Identifier: Apache-2.0
// Writing down what a raster sees, and irradiance from that.
#include "renderer/points/surfel_view.h"

#include "renderer/points/point_raster.h"

namespace patina {

Rgb SurfelView::irradiance(const PointTree& tree) const {
  Rgb sum = sky;
  size_t plane = 0;
  for (const auto& [kind, index, weight] : parts) {
    const auto toHere = [&] { return normalizedOr(P - tree.nodes()[index].center, V3f(0, 0, 1)); };
    switch (kind) {
      case Kind::NodeFront:
      case Kind::NodeBack:
        sum += tree.look(index, toHere(), kind == Kind::NodeBack).radiance * weight;
        break;
      case Kind::NodeBoth:
        sum += tree.lookAtBoth(index, toHere()).radiance * weight;
        break;
      case Kind::NodeGap:
        sum += tree.inGap(index) * weight;
        break;
      case Kind::SurfelFront:
        sum += tree.surfels()[index].front * weight;
        break;
      case Kind::SurfelBack:
        sum += tree.surfels()[index].back * weight;
        break;
      case Kind::PlaneFront:
      case Kind::PlaneBack: {
        const PointTree::Plane& p = tree.planes()[index];
        const bool front = kind == Kind::PlaneFront;
        const Rgb& radiance = front ? p.front : p.back;
        const auto& slope = front ? p.frontSlope : p.backSlope;
        const V3f& at = along[plane++];
        for (int c = 0; c < 3; ++c)
          sum[c] += std::max(0.0f, radiance[c] * weight + slope[static_cast<size_t>(c)].dot(at));
        break;
      }
    }
  }
  return sum;
}

size_t SurfelView::memory() const {
  return sizeof(*this) + parts.capacity() * sizeof(Part) + along.capacity() * sizeof(V3f);
}

/// Of what was drawn last.
void PointRaster::write(SurfelView& view) {
  const auto isPlane = [](SurfelView::Kind kind) {
    return kind == SurfelView::Kind::PlaneFront || kind == SurfelView::Kind::PlaneBack;
  };
  for (const auto& [part, pixel, share] : drawn_) {
    Part& to = parts_[part];
    const float weight = share * scale_[pixel];
    to.weight += weight;
    if (isPlane(to.kind))
      to.along += (V3f(dx_[pixel], dy_[pixel], dz_[pixel]) * t_[pixel] -
                   traced_[static_cast<size_t>(met_[pixel])].P) *
                  weight;
  }
  view.parts.clear(), view.along.clear();
  for (const Part& part : parts_) {
    if (!(part.weight > 0)) continue;
    SurfelView::Part& kept = view.parts.emplace_back();
    kept.kind = part.kind, kept.index = part.index & SurfelView::kMostIndex, kept.weight = part.weight;
    if (isPlane(part.kind)) view.along.push_back(part.along);
  }
}

const SurfelView* SurfelViews::find(uint64_t key) const {
  const Shard& of = shard(key);
  const std::lock_guard lock(of.mutex);
  const auto found = of.views.find(key);
  return found == of.views.end() ? nullptr : &found->second;
}

void SurfelViews::keep(uint64_t key, const SurfelView& view) {
  constexpr size_t kOfMap = 64;  // about: a node of it, and what the allocator adds
  const size_t size = sizeof(SurfelView) + view.parts.size() * sizeof(SurfelView::Part) +
                      view.along.size() * sizeof(V3f) + kOfMap;
  if (used_.fetch_add(size) + size > bytes_) {
    used_ -= size;
    return;
  }
  Shard& of = shard(key);
  const std::lock_guard lock(of.mutex);
  if (!of.views.try_emplace(key, view).second) used_ -= size;
}

}  // namespace patina
