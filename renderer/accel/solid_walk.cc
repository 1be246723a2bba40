// SPDX-License-Identifier: Apache-2.0
// Crossings of a ray with the operands of a solid, and the walk along them.
#include "renderer/accel/solid_walk.h"

#include <algorithm>
#include <tuple>

#include "renderer/accel/part_tracer.h"
#include "renderer/base/statistics.h"

namespace patina {
namespace {

STAT_COUNTER("Solids/rays", solidRays);
STAT_COUNTER("Solids/crossings", crossingCount);

struct Crossing {
  RTCHit hit;
  float t, tolerance;
  uint32_t traced, face;
  bool entering;  ///< the leaf
};

/// What a ray does to a leaf in one place.
struct Event {
  uint32_t place;     ///< index of the first crossing there
  uint32_t crossing;  ///< the first of the leaf there
  uint32_t leaf;
  int change;  ///< > 0: in
};

struct Walk {
  std::vector<Crossing> crossings;
  std::vector<Event> events;
  std::vector<int> windings;  ///< by node: see SolidTree::Rule; -1 = not known of a leaf by Facing
  SolidState state;

  /// Rays that met very much are rare: what they took is given back.
  void giveBack() {
    constexpr size_t kKept = 4096;
    if (crossings.capacity() > kKept) crossings = {};
    if (events.capacity() > kKept) events = {};
  }
};

struct CollectContext {
  RTCIntersectContext embree;
  std::vector<Crossing>* crossings;
};

/// The part of crossings [begin, end) that is one place. Distances are sorted.
size_t endOfPlace(const std::vector<Crossing>& crossings, size_t begin) {
  size_t end = begin + 1;
  while (end < crossings.size() &&
         crossings[end].t - crossings[begin].t <= crossings[end].tolerance + crossings[begin].tolerance)
    ++end;
  return end;
}

/// What the crossings of one place come to, leaf by leaf. They are put in order of leaf and surface.
void addEvents(Walk& walk, const EmbreeScene& scene, const SolidTree& tree, size_t begin, size_t end) {
  const auto& traced = scene.geometry().traced();
  const auto order = [&](const Crossing& c) {
    return std::make_tuple(traced[c.traced].leaf, c.traced, c.entering, c.face);
  };
  const auto from = walk.crossings.begin();
  if (end - begin > 1)
    std::sort(from + static_cast<ptrdiff_t>(begin), from + static_cast<ptrdiff_t>(end),
              [&](const Crossing& a, const Crossing& b) { return order(a) < order(b); });
  for (size_t first = begin; first < end;) {
    const uint32_t leaf = traced[walk.crossings[first].traced].leaf;
    // Facets of one surface that meet in an edge are crossed once, and ways in and out cancel.
    int in = 0, out = 0;
    size_t k = first;
    for (; k < end && traced[walk.crossings[k].traced].leaf == leaf; ++k) {
      const Crossing& c = walk.crossings[k];
      const bool again = k > first && walk.crossings[k - 1].traced == c.traced &&
                         walk.crossings[k - 1].entering == c.entering;
      if (!again) ++(c.entering ? in : out);
    }
    const bool counts = tree.nodes[leaf].rule == SolidTree::Rule::Winding;
    const int change = counts ? in - out : (in > 0) - (out > 0);
    if (change != 0)
      walk.events.push_back({static_cast<uint32_t>(begin), static_cast<uint32_t>(first), leaf, change});
    first = k;
  }
}

/// The leaves that the ray begins inside of.
void findOrigin(Walk& walk, const SolidTree& tree) {
  using Rule = SolidTree::Rule;
  walk.state.begin(tree);
  walk.windings.assign(tree.nodes.size(), 0);
  for (size_t k = walk.events.size(); k-- > 0;) {
    const Event& event = walk.events[k];
    int& winding = walk.windings[event.leaf];
    switch (tree.nodes[event.leaf].rule) {
      case Rule::Facing:
        winding = event.change < 0;
        break;
      case Rule::Winding:
        winding -= event.change;
        break;
      case Rule::Parity:
        winding ^= 1;
        break;
    }
  }
  for (const Event& event : walk.events) walk.state.setLeaf(event.leaf, walk.windings[event.leaf] != 0);
}

void pass(Walk& walk, const SolidTree& tree, const Event& event) {
  using Rule = SolidTree::Rule;
  int& winding = walk.windings[event.leaf];
  const Rule rule = tree.nodes[event.leaf].rule;
  winding = rule == Rule::Facing    ? event.change > 0
            : rule == Rule::Winding ? winding + event.change
                                    : winding ^ 1;
  walk.state.setLeaf(event.leaf, winding != 0);
}

/// The crossing that is met first; null: none.
const Crossing* walkAlong(const EmbreeScene& scene, uint32_t solid, const QueryContext& query,
                          const RTCRay& ray, Walk& walk) {
  const Geometry& geometry = scene.geometry();
  const SolidTree& tree = geometry.solids()[solid];
  walk.crossings.clear(), walk.events.clear();
  CollectContext context{{}, &walk.crossings};
  rtcInitIntersectContext(&context.embree);
  RTCRayHit all;
  all.ray = ray;
  all.ray.tfar = kInfinity;
  all.ray.mask = kAnyRay;
  all.hit.geomID = all.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene.scene(), &context.embree, &all);
  ++solidRays;
  crossingCount += static_cast<int64_t>(walk.crossings.size());

  std::sort(walk.crossings.begin(), walk.crossings.end(), [](const Crossing& a, const Crossing& b) {
    return std::tie(a.t, a.traced, a.face) < std::tie(b.t, b.traced, b.face);
  });
  for (size_t begin = 0; begin < walk.crossings.size();) {
    const size_t end = endOfPlace(walk.crossings, begin);
    addEvents(walk, scene, tree, begin, end);
    begin = end;
  }
  findOrigin(walk, tree);
  for (size_t k = 0; k < walk.events.size();) {
    const uint32_t place = walk.events[k].place;
    const bool before = walk.state.inside();
    const size_t first = k;
    for (; k < walk.events.size() && walk.events[k].place == place; ++k) pass(walk, tree, walk.events[k]);
    const bool entering = walk.state.inside();
    if (entering == before) continue;
    // The surface whose leaf changed in the sense of the result.
    const Crossing* met = nullptr;
    for (size_t e = first; e < k; ++e) {
      const Event& event = walk.events[e];
      const Crossing& c = walk.crossings[event.crossing];
      const bool grows = walk.state.insideLeaf(event.leaf) != tree.nodes[event.leaf].subtracted;
      if (grows == entering && (!met || c.traced < met->traced)) met = &c;
    }
    if (!met || met->t >= ray.tfar) return nullptr;
    // Instances have a visibility of their own beside that of their surfaces.
    const Attributes* own = geometry.attributes(geometry.traced()[met->traced]);
    const bool seen = !own || (own->visibility & ray.mask) != 0;
    if (seen && (entering || !geometry.attributes(scene.placement(met->traced, query.instance())).oneSided))
      return met;
  }
  return nullptr;
}

Walk& threadWalk() {
  thread_local Walk walk;
  return walk;
}

}  // namespace

void collectCrossings(const RTCFilterFunctionNArguments* args) {
  const auto& scene = *static_cast<const EmbreeScene*>(args->geometryUserPtr);
  auto& crossings = *reinterpret_cast<CollectContext*>(args->context)->crossings;
  const Geometry& geometry = scene.geometry();
  for (unsigned k = 0; k < args->N; ++k) {
    if (args->valid[k] == 0) continue;
    args->valid[k] = 0;
    Crossing c;
    c.hit = rtcGetHitFromHitN(args->hit, args->N, k);
    const FaceOwner owner = scene.ownerOf(c.hit.geomID, c.hit.primID, c.hit.u, c.hit.v);
    const Surface& surface = geometry.surface(owner.traced);
    if (surface.hasHoles() && surface.isHole(owner.face, c.hit.u, c.hit.v)) continue;
    const RTCRay ray = rtcGetRayFromRayN(args->ray, args->N, k);
    const V3f origin(ray.org_x, ray.org_y, ray.org_z), direction(ray.dir_x, ray.dir_y, ray.dir_z);
    const V3f normal(c.hit.Ng_x, c.hit.Ng_y, c.hit.Ng_z);
    const float along = normal.dot(direction), length = direction.length();
    // What the plane of a facet is off, seen along the ray; at grazing angles no more than a thousand times
    // that.
    const float cosine = std::abs(along) / std::max(normal.length() * length, 1e-30f);
    const float error = roundingBound(8) * (maxAbsComponent(origin) + std::abs(ray.tfar) * length);
    c.t = ray.tfar;
    c.tolerance = error / (std::max(length, 1e-30f) * std::max(cosine, 1e-3f));
    c.traced = owner.traced, c.face = owner.face;
    c.entering = along * geometry.traced()[owner.traced].leafSign < 0;
    crossings.push_back(c);
  }
}

bool intersectSolid(const EmbreeScene& scene, uint32_t solid, const QueryContext& query, RTCRayHit& ray,
                    FaceOwner& face) {
  Walk& walk = threadWalk();
  const Crossing* met = walkAlong(scene, solid, query, ray.ray, walk);
  if (met) {
    ray.ray.tfar = met->t;
    ray.hit = met->hit;
    ray.hit.instID[0] = query.embree.instID[0];
    face = {met->traced, met->face};
  }
  walk.giveBack();
  return met != nullptr;
}

void occludeBySolid(const EmbreeScene& scene, uint32_t solid, const QueryContext& query, RTCRay& ray) {
  Walk& walk = threadWalk();
  if (walkAlong(scene, solid, query, ray, walk)) ray.tfar = -kInfinity;
  walk.giveBack();
}

}  // namespace patina
