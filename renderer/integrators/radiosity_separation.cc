// SPDX-License-Identifier: Apache-2.0
// Whether values at vertices may be carried from one to the other.
#include <algorithm>
#include <functional>

#include "renderer/base/statistics.h"
#include "renderer/integrators/radiosity_workspace.h"

namespace patina {
namespace {

STAT_COUNTER("Radiosity cache/cells/known whether something stands there", standingHits);
STAT_COUNTER("Radiosity cache/cells/looked whether something stands there", standingMade);

/// Covers of a cell of the fine level count when they are as near as it is wide, which is seen: 1 / sqrt(2)
/// of its diagonal.
constexpr float kFineCover = 0.7f;

}  // namespace

/// How far above each point of the pairs something lies, within `reach` of the points' distance: a leaf on a
/// table crosses no chord, but what is under it is dark.
void RadiosityEngine::findCovers(std::span<const PointPair> pairs, float reach, Workspace& w) const {
  w.covers.clear();
  for (const auto& [a, b] : pairs) {
    const float far = reach * (b->P - a->P).length();
    w.covers.push_back({a, far}), w.covers.push_back({b, far});
  }
  // Each point once, with the farthest that is asked for.
  std::sort(w.covers.begin(), w.covers.end(), [](const auto& x, const auto& y) {
    return std::less<>()(x.point, y.point) || (x.point == y.point && x.distance > y.distance);
  });
  w.covers.erase(std::unique(w.covers.begin(), w.covers.end(),
                             [](const auto& x, const auto& y) { return x.point == y.point; }),
                 w.covers.end());
  w.probes.clear();
  for (const auto& [point, far] : w.covers)
    w.probes.push_back({leave(point->facet(), point->Ng), point->Ng, 0, far, kDiffuseRay});
  w.probeHits.resize(w.probes.size());
  world_.accel().intersect(w.probes, w.probeHits);
  for (size_t k = 0; k < w.probes.size(); ++k) {
    const Hit& hit = w.probeHits[k];
    const uint32_t own = w.covers[k].point->placement;
    const bool counts = hit.valid() && !(hit.placement == own && isDisplaced(own));
    w.covers[k].distance = counts ? hit.t : kInfinity;
  }
}

void RadiosityEngine::blocked(std::span<const PointPair> pairs, float reach, std::span<uint8_t> out,
                              Workspace& w) const {
  const Geometry& geometry = world_.geometry();
  // Just above the surface, and above the dust on it.
  constexpr float kLift = 0.02f;
  // A wall without thickness may stand exactly where a vertex is, which then sees both of its sides: chords
  // are longer at both ends.
  constexpr float kLonger = 0.001f;
  w.chords.clear();
  for (const auto& [a, b] : pairs) {
    const float lift = kLift * (b->P - a->P).length();
    const V3f from = a->P + a->Ng * (lift + a->error), to = b->P + b->Ng * (lift + b->error);
    w.chords.push_back({from - (to - from) * kLonger, (to - from) * (1 + 2 * kLonger), 0, 1, kDiffuseRay});
  }
  w.chordHits.resize(w.chords.size());
  world_.accel().intersect(w.chords, w.chordHits);
  findCovers(pairs, reach, w);
  w.hiddenPairs.clear(), w.pairOfHidden.clear();
  for (uint32_t k = 0; k < pairs.size(); ++k) {
    const Hit& hit = w.chordHits[k];
    const uint32_t placement = pairs[k][0]->placement;
    out[k] = 1;
    const float near = reach * (pairs[k][1]->P - pairs[k][0]->P).length();
    if ((w.coverOf(pairs[k][0]) < near) != (w.coverOf(pairs[k][1]) < near)) continue;
    if (hit.valid() && hit.placement != placement) continue;
    if (isDisplaced(placement)) {
      w.hiddenPairs.push_back(pairs[k]), w.pairOfHidden.push_back(k);
      continue;
    }
    // The chord of a curved surface runs inside of it.
    out[k] = hit.valid() && geometry.surface(geometry.placements()[placement]).isFlat();
  }
  if (w.hiddenPairs.empty()) return;
  w.hidden.resize(w.hiddenPairs.size());
  hidden(w.hiddenPairs, w.hidden, w);
  for (size_t k = 0; k < w.hidden.size(); ++k) out[w.pairOfHidden[k]] = w.hidden[k];
}

/// Whether a displaced surface comes between two of its points where it pushes through itself, as at the
/// edges of polygons: then one of them is on a part that is seen from nowhere. The chord between them may run
/// through bumps, but leaves as many as it enters.
void RadiosityEngine::hidden(std::span<const PointPair> pairs, std::span<uint8_t> out, Workspace& w) const {
  constexpr int kMostSheets = 16;  // of bumps finer than the distance of the points: nothing is known
  const Geometry& geometry = world_.geometry();
  w.chords.clear(), w.chordOf.clear();
  w.entered.assign(pairs.size(), 0);
  for (uint32_t k = 0; k < pairs.size(); ++k) {
    const auto& [a, b] = pairs[k];
    const V3f from = leave(a->facet(), a->Ng);
    w.chords.push_back({from, leave(b->facet(), b->Ng) - from, 0, 1, kDiffuseRay});
    w.chordOf.push_back(k);
    out[k] = 0;
  }
  for (int sheet = 0; sheet < kMostSheets && !w.chords.empty(); ++sheet) {
    w.chordHits.resize(w.chords.size());
    world_.accel().intersect(w.chords, w.chordHits);
    w.chordsMet.clear();
    for (uint32_t i = 0; i < w.chords.size(); ++i) {
      const uint32_t k = w.chordOf[i];
      const Hit& hit = w.chordHits[i];
      if (!hit.valid())
        out[k] = w.entered[k] != 0;
      else
        w.chordsMet.push_back(i);
      if (hit.valid() && hit.placement == pairs[k][0]->placement) w.entered[k] += hit.front ? 1 : -1;
    }
    geometry.orderByUnit(w.chordsMet, [&](uint32_t i) { return w.chordHits[i].placement; });
    for (const uint32_t i : w.chordsMet) {
      const Hit& hit = w.chordHits[i];
      const ShadingPoint& b = *pairs[w.chordOf[i]][1];
      Ray& ray = w.chords[i];
      ray.origin = goOn(ray, hit, geometry.facet(hit.placement, hit.face, hit.u, hit.v));
      ray.direction = leave(b.facet(), b.Ng) - ray.origin;
    }
    std::sort(w.chordsMet.begin(), w.chordsMet.end());
    for (uint32_t i = 0; i < w.chordsMet.size(); ++i) {
      w.chords[i] = w.chords[w.chordsMet[i]];
      w.chordOf[i] = w.chordOf[w.chordsMet[i]];
    }
    w.chords.resize(w.chordsMet.size()), w.chordOf.resize(w.chordsMet.size());
  }
}

/// Marks as missing the points on a part of a solid's operand that is not on the solid: where rays do not
/// meet it.
void RadiosityEngine::cutAway(std::span<const Request> points, std::span<uint64_t> codes,
                              Workspace& w) const {
  const Geometry& geometry = world_.geometry();
  if (geometry.solids().empty()) return;
  w.chords.clear(), w.chordOf.clear();
  for (uint32_t k = 0; k < points.size(); ++k) {
    const ShadingPoint& p = points[k].point;
    if (geometry.traced()[geometry.placements()[p.placement].traced].solid == kNone) continue;
    const float above = p.error + roundingBound(16) * maxAbsComponent(p.P);  // as walks through solids err
    w.chords.push_back({p.P + p.Ng * above, -p.Ng, 0, 4 * above, kAnyRay});
    w.chordOf.push_back(k);
  }
  w.chordHits.resize(w.chords.size());
  world_.accel().intersect(w.chords, w.chordHits);
  for (size_t i = 0; i < w.chords.size(); ++i)
    if (w.chordHits[i].placement != points[w.chordOf[i]].point.placement)
      codes[w.chordOf[i]] = PackedRgb::kMissing;
}

void RadiosityEngine::separated(std::span<const Cell> cells, std::span<uint8_t> out, int nesting) const {
  Workspace& w = workspace(nesting);
  std::fill(out.begin(), out.end(), uint8_t{0});
  w.fillRequests.clear(), w.pairOf.clear(), w.order.clear(), w.vertexOf.clear();
  for (uint32_t k = 0; k < cells.size(); ++k)
    if (cells[k].around.count >= 3) w.order.push_back(k);
  std::sort(w.order.begin(), w.order.end(), [&](uint32_t a, uint32_t b) {
    return std::pair(cells[a].patch, a) < std::pair(cells[b].patch, b);
  });
  for (const uint32_t k : w.order) {
    const auto& [patch, front, around, met] = cells[k];
    const auto first = static_cast<uint32_t>(w.fillRequests.size());
    for (int i = 0; i < around.count; ++i)
      w.fillRequests.push_back(vertexRequest(patch, front, Level::Fine, around.index[i], 0, 0));
    const auto add = [&](uint32_t a, uint32_t b) {
      w.pairOf.push_back({first + a, first + b});
      w.vertexOf.push_back(k);
    };
    if (around.count == 4)
      add(0, 3), add(1, 2);
    else
      add(0, 1), add(0, 2), add(1, 2);
  }
  w.fillCodes.assign(w.fillRequests.size(), 0);
  cutAway(w.fillRequests, w.fillCodes, w);
  uint32_t vertex = 0;
  for (const uint32_t k : w.order)
    for (int i = 0; i < cells[k].around.count; ++i)
      if (w.fillCodes[vertex++] == PackedRgb::kMissing) out[k] = 1;
  w.pairs.clear();
  for (const auto& [a, b] : w.pairOf) w.pairs.push_back({&w.fillRequests[a].point, &w.fillRequests[b].point});
  w.separated.resize(w.pairs.size());
  blocked(w.pairs, kFineCover, w.separated, w);
  for (size_t k = 0; k < w.pairs.size(); ++k) out[w.vertexOf[k]] |= w.separated[k];
  // Parts of displaced surfaces that are met may be next to such that are seen from nowhere.
  w.pairs.clear(), w.vertexOf.clear();
  vertex = 0;
  for (const uint32_t k : w.order)
    for (int i = 0; i < cells[k].around.count; ++i, ++vertex)
      if (cells[k].met && isDisplaced(cells[k].met->placement) && !out[k]) {
        w.pairs.push_back({cells[k].met, &w.fillRequests[vertex].point});
        w.vertexOf.push_back(k);
      }
  if (w.pairs.empty()) return;
  w.separated.resize(w.pairs.size());
  hidden(w.pairs, w.separated, w);
  for (size_t k = 0; k < w.pairs.size(); ++k) out[w.vertexOf[k]] |= w.separated[k];
}

/// Takes back what look-ups have found in cells of the fine level that something stands in. Whether it does
/// is kept in the cache, for all depths together.
void RadiosityEngine::leaveSeparated(std::span<Lookup> lookups, int nesting) const {
  Workspace& w = workspace(nesting);
  w.cells.clear(), w.cellPlaces.clear();
  for (const Workspace::FineCell& found : w.fineCells) {
    if (!lookups[found.lookup].found) continue;
    uint64_t code = found.code;
    if (code == PackedRgb::kMissing &&
        !cache_->find(standingKey(found), Level::Fine, {&found.index, 1}, &code))
      code = PackedRgb::kMissing;
    if (code != PackedRgb::kMissing) {
      ++standingHits;
      if (code != 0) lookups[found.lookup].found = false;
      continue;
    }
    w.cellPlaces.push_back(found);
  }
  if (w.cellPlaces.empty()) return;
  // Each cell once, those of one block together.
  std::sort(w.cellPlaces.begin(), w.cellPlaces.end());
  for (size_t k = 0; k < w.cellPlaces.size(); ++k)
    if (k == 0 || !w.cellPlaces[k].sameCell(w.cellPlaces[k - 1]))
      w.cells.push_back({w.cellPlaces[k].patch, w.cellPlaces[k].front, w.cellPlaces[k].around, nullptr});
  standingMade += static_cast<int64_t>(w.cells.size());
  w.cellSeparated.resize(w.cells.size());
  separated(w.cells, w.cellSeparated, nesting);
  std::array<uint64_t, kMaxBlockVertices> codes;
  for (size_t k = 0, cell = 0; k < w.cellPlaces.size(); ++k) {
    const Workspace::FineCell& at = w.cellPlaces[k];
    if (k > 0 && !at.sameCell(w.cellPlaces[k - 1])) ++cell;
    if (k == 0 || !at.sameBlock(w.cellPlaces[k - 1])) codes.fill(PackedRgb::kMissing);
    codes[at.index] = w.cellSeparated[cell];
    if (w.cellSeparated[cell]) lookups[at.lookup].found = false;
    if (k + 1 == w.cellPlaces.size() || !at.sameBlock(w.cellPlaces[k + 1]))
      cache_->store(standingKey(at), Level::Fine, codes);
  }
}

}  // namespace patina
