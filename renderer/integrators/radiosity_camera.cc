// SPDX-License-Identifier: Apache-2.0
// View-independent light where the camera's samples meet something: interpolated between micropolygon
// vertices, or made for parts of pixels where that would smear.
#include <algorithm>

#include "renderer/base/statistics.h"
#include "renderer/integrators/radiosity_integrator.h"

namespace patina {
namespace {

STAT_COUNTER("Camera/vertices asked for", vertexCount);
STAT_COUNTER("Camera/points shaded for parts of pixels", partCount);
STAT_COUNTER("Camera/points met by way of rough lobes", blurredCount);
STAT_COUNTER("Camera/points met by way of rough lobes, not in the cache", notCachedCount);
STAT_COUNTER("Camera/points shaded for groups of small faces", groupCount);

/// Roughness from which on a lobe's directions are many.
constexpr float kBlurs = 0.05f;

/// Where vertices of a micropolygon differ by more than this part of the brightest, points in it are shaded.
constexpr float kContrast = 0.1f;

}  // namespace

/// B at every point: interpolated between vertices, or sampled at the hit where a patch has none that are
/// near enough.
void RadiosityIntegrator::viewIndependent(Wave& wave) const {
  const size_t n = wave.points.size();
  wave.radiosity.assign(n, Rgb(0, 0, 0));
  wave.around.resize(n), wave.groupKeys.resize(n), wave.cellAt.assign(n, kNone);
  wave.known.clear(), wave.cellOf.clear(), wave.cells.clear(), wave.cellKeys.clear(), wave.inCells.clear(),
      wave.vertices.clear(), wave.byHit.clear(), wave.met.clear(), wave.sharing.clear();
  findBlurred(wave);
  findCells(wave);
  wave.separated.resize(wave.cells.size());
  engine_.separated(wave.cells, wave.separated);
  for (const auto& [i, at] : wave.inCells) {
    VertexWeights& around = wave.around[i];
    if (wave.separated[at]) {
      // Its vertices say nothing of what is between them.
      sharePart(wave, i, wave.cellKeys[at], Wave::Share::Whole);
      continue;
    }
    const uint32_t index = wave.cells[at].patch;
    const bool front = wave.cells[at].front;
    const uint8_t bounces = RadiosityEngine::keptBounces(wave.walks[wave.active[i]].bounces);
    for (int k = 0; k < around.count; ++k) {
      const RadiosityEngine::Vertex v{index, front, static_cast<uint16_t>(around.index[k]), bounces};
      const auto [found, isNew] =
          wave.known.try_emplace(keyOf(v), static_cast<uint32_t>(wave.vertices.size()));
      if (isNew) wave.vertices.push_back(v);
      around.index[k] = found->second;
    }
  }
  vertexCount += static_cast<int64_t>(wave.vertices.size());
  vertexValues(wave);
  // Where vertices differ much, the edge of a shadow or of a texture is not to be smeared over the cell.
  // And holes between vertices that are no holes, or the other way round, are nothing that these know of.
  for (const auto& [i, at] : wave.inCells) {
    const VertexWeights& around = wave.around[i];
    if (around.count == 0) continue;
    if (world_.shading().isOpacityShaded(wave.points[i].placement)) {
      sharePart(wave, i, wave.cellKeys[at], Wave::Share::Direct);
      continue;
    }
    Rgb least = wave.values[around.index[0]], most = least, sum(0, 0, 0);
    for (int k = 0; k < around.count; ++k) {
      const Rgb& value = wave.values[around.index[k]];
      for (int c = 0; c < 3; ++c)
        least[c] = std::min(least[c], value[c]), most[c] = std::max(most[c], value[c]);
      sum += value * around.weight[k];
    }
    if (maxComponent(most - least) > kContrast * maxComponent(most))
      sharePart(wave, i, wave.cellKeys[at], Wave::Share::Direct);
    else
      wave.radiosity[i] = sum;
  }
  makeRequests(wave, wave.byHit);
  shadeRequests(wave, wave.byHit, 0, world_.settings().unbiased ? Purpose::Sample : Purpose::Vertex, {});
  makeRequests(wave, wave.notCached);
  shadeRequests(wave, wave.notCached, 1, Purpose::HalfVertex, {});
  shadeShared(wave);
}

/// Points met by way of rough lobes. They lie far apart, as those of a pixel's other samples do: none is
/// worth more rays than what diffuse rays meet, and most can have just that.
void RadiosityIntegrator::findBlurred(Wave& wave) const {
  wave.blurred.clear(), wave.blurredPoints.clear(), wave.notCached.clear();
  wave.isBlurred.assign(wave.points.size(), 0);
  if (world_.settings().shadeAtHits) return;
  for (uint32_t i = 0; i < wave.points.size(); ++i) {
    const Walk& walk = wave.walks[wave.active[i]];
    const ShadingPoint& p = wave.points[i];
    if (walk.roughness < kBlurs || !world_.shading().shaderOf(p.placement).active(PATINA_ENTRY_RADIOSITY))
      continue;
    wave.isBlurred[i] = 1;
    wave.blurred.push_back({&wave.hits[wave.active[i]], walk.footprint, walk.bounces});
    wave.blurredPoints.push_back(i);
  }
  if (wave.blurred.empty()) return;
  blurredCount += static_cast<int64_t>(wave.blurred.size());
  engine_.blurred(wave.blurred);
  for (size_t k = 0; k < wave.blurred.size(); ++k) {
    if (wave.blurred[k].found)
      wave.radiosity[wave.blurredPoints[k]] = wave.blurred[k].radiance;
    else
      wave.notCached.push_back(wave.blurredPoints[k]);
  }
  notCachedCount += static_cast<int64_t>(wave.notCached.size());
}

/// Which points are in cells of vertices, and which are shaded otherwise.
void RadiosityIntegrator::findCells(Wave& wave) const {
  const PatchTable& patches = world_.geometry().patches();
  for (uint32_t i = 0; i < wave.points.size(); ++i) {
    const ShadingPoint& p = wave.points[i];
    const ShaderInstance& shader = world_.shading().shaderOf(p.placement);
    wave.around[i].count = 0;
    if (wave.isBlurred[i] || !shader.active(PATINA_ENTRY_RADIOSITY)) continue;
    const uint32_t index = patches.find(p.placement, p.face, p.u, p.v);
    const Patch& patch = patches[index];
    const Walk& walk = wave.walks[wave.active[i]];
    // Micropolygons that the camera sees are as long as they look: a floor's far part has long ones.
    constexpr float kLeastCosine = 1.0f / 32;
    const float seen = walk.receiver == kNone ? std::max(std::abs(p.I.dot(p.Ng)), kLeastCosine) : 1;
    if (world_.settings().shadeAtHits || shader.has(PATINA_TRAIT_NOT_CACHEABLE) ||
        patch.spacing * seen >
            4 * std::max(p.footprint, 1e-30f) * std::sqrt(world_.attributesOf(p.placement).shadingRate)) {
      wave.byHit.push_back(i);
      continue;
    }
    // What is seen of a group of small faces is not what it is on average: the hollows of a rough surface
    // hide, and slopes count by how they are turned. And a face that is one small micropolygon shares its
    // vertices with nobody.
    const bool isSmall = std::max(patch.cellsU, patch.cellsV) <= 1 && patch.spacing * seen < p.footprint;
    if (patch.group > 0 || isSmall) {
      const uint64_t key =
          hashOf(uint64_t{index} << 1 | uint64_t{p.front}, RadiosityEngine::keptBounces(walk.bounces));
      wave.groupKeys[i] = key;
      if (!wave.inGroup.contains(key)) share(wave, i, key, Wave::Share::Indirect);
      sharePart(wave, i, key, Wave::Share::Direct);
      continue;
    }
    const V2f local = patch.toLocal(p.u, p.v);
    VertexWeights& around = wave.around[i] = patch.locate(Level::Fine, local.x, local.y);
    // The upper triangle of one square begins at the vertex that the lower one of another begins at.
    const bool upper = around.index[1] < around.index[0];
    const uint64_t cell =
        uint64_t{index} << 17 | uint64_t{p.front} << 16 | uint64_t{upper} << 15 | around.index[0];
    const auto [at, isNewCell] = wave.cellOf.try_emplace(cell, static_cast<uint32_t>(wave.cells.size()));
    if (isNewCell) wave.cells.push_back({index, p.front, around, &p}), wave.cellKeys.push_back(cell);
    wave.inCells.emplace_back(i, at->second);
    wave.cellAt[i] = at->second;
  }
}

/// Of the points of one key that this wave meets, one by chance stands for the others.
void RadiosityIntegrator::share(Wave& wave, uint32_t i, uint64_t key, Wave::Share share) const {
  const Walk& walk = wave.walks[wave.active[i]];
  const uint64_t chance = hashOf(walk.seed(kPoint), walk.sample);
  const auto [found, isNew] = wave.met.try_emplace(key, chance, i);
  if (chance < found->second.first) found->second = {chance, i};
  wave.sharing.push_back({i, key, share});
}

/// Some points of a place, a cell or a group, are shaded in each pixel, and shared by all the pixel's
/// samples.
void RadiosityIntegrator::sharePart(Wave& wave, uint32_t i, uint64_t place, Wave::Share kind) const {
  const Walk& walk = wave.walks[wave.active[i]];
  const uint64_t key = hashOf(place, walk.x, walk.y, walk.sample % RayBudget::kParts,
                              RadiosityEngine::keptBounces(walk.bounces));
  wave.around[i].count = 0;
  if (const auto known = wave.inPart.find(key); known != wave.inPart.end())
    wave.radiosity[i] = known->second;
  else
    share(wave, i, key, kind);
}

/// Makes what is shared in `wave`.
void RadiosityIntegrator::shadeShared(Wave& wave) const {
  const auto chosenFor = [&](Wave::Share share) -> std::vector<uint32_t>& {
    return wave.chosen[static_cast<size_t>(share)];
  };
  for (auto& list : wave.chosen) list.clear();
  for (const auto& [i, key, share] : wave.sharing)
    if (wave.met.at(key).second == i) chosenFor(share).push_back(i);

  const std::vector<uint32_t>& ofGroups = chosenFor(Wave::Share::Indirect);
  groupCount += static_cast<int64_t>(ofGroups.size());
  partCount +=
      static_cast<int64_t>(chosenFor(Wave::Share::Whole).size() + chosenFor(Wave::Share::Direct).size());
  makeRequests(wave, ofGroups);
  wave.indirect.resize(ofGroups.size());
  engine_.indirect(wave.requests, Purpose::Part, wave.indirect);
  for (size_t k = 0; k < ofGroups.size(); ++k)
    wave.inGroup.emplace(wave.groupKeys[ofGroups[k]], wave.indirect[k]);

  makeRequests(wave, chosenFor(Wave::Share::Whole));
  shadeRequests(wave, chosenFor(Wave::Share::Whole), 0, Purpose::Part, {});
  shadeLit(wave);
  for (const auto& [i, key, share] : wave.sharing) {
    if (share == Wave::Share::Indirect) continue;
    wave.radiosity[i] = wave.radiosity[wave.met.at(key).second];
    wave.inPart.emplace(key, wave.radiosity[i]);
  }
}

/// B of the points that stand for parts of pixels and whose indirect light is known: that of their group, or
/// of the vertices around.
void RadiosityIntegrator::shadeLit(Wave& wave) const {
  std::vector<uint32_t>& which = wave.chosen[static_cast<size_t>(Wave::Share::Direct)];
  const auto isKnown = [&](uint32_t i) { return wave.cellAt[i] == kNone || wave.kept; };
  const auto known = std::partition(which.begin(), which.end(), isKnown) - which.begin();
  wave.indirect.clear(), wave.spots.clear();
  for (const uint32_t i : which) {
    const VertexWeights& around = wave.around[i];
    if (wave.cellAt[i] == kNone) {
      wave.indirect.push_back(wave.inGroup.at(wave.groupKeys[i]));
    } else if (wave.kept) {
      RadiosityEngine::Irradiance& sum = wave.indirect.emplace_back();
      for (int k = 0; k < wave.cells[wave.cellAt[i]].around.count; ++k) {
        const RadiosityEngine::Irradiance& at = wave.vertexIndirect[around.index[k]];
        sum.front += at.front * around.weight[k], sum.back += at.back * around.weight[k];
      }
    } else {
      const RadiosityEngine::Cell& cell = wave.cells[wave.cellAt[i]];
      RadiosityEngine::Spot& spot = wave.spots.emplace_back(RadiosityEngine::Spot{
          cell.patch, cell.front, RadiosityEngine::keptBounces(wave.walks[wave.active[i]].bounces),
          cell.around});
      std::copy_n(around.weight, std::size(spot.around.weight), spot.around.weight);
    }
  }
  const std::span<const uint32_t> all = which;
  makeRequests(wave, all.first(known));
  for (size_t k = 0; k < wave.requests.size(); ++k) wave.requests[k].indirect = &wave.indirect[k];
  shadeRequests(wave, all.first(known), 0, Purpose::Part, {});
  makeRequests(wave, all.subspan(known));
  shadeRequests(wave, all.subspan(known), 0, Purpose::Part, wave.spots);
}

void RadiosityIntegrator::makeRequests(Wave& wave, std::span<const uint32_t> which) const {
  wave.requests.clear();
  for (const uint32_t i : which) {
    const Walk& walk = wave.walks[wave.active[i]];
    const uint64_t seed = walk.seed(kPoint);
    const bool unbiased = world_.settings().unbiased;
    wave.requests.push_back({wave.points[i], unbiased ? seed : hashOf(seed, walk.sample), walk.bounces,
                             unbiased ? walk.sample : 0});
  }
}

/// B of `which` points, of which wave.requests are.
void RadiosityIntegrator::shadeRequests(Wave& wave, std::span<const uint32_t> which, int depth,
                                        Purpose purpose, std::span<const RadiosityEngine::Spot> spots) const {
  wave.made.resize(which.size());
  engine_.shade(wave.requests, depth, purpose, wave.made, spots);
  for (size_t k = 0; k < which.size(); ++k) wave.radiosity[which[k]] = wave.made[k];
}

/// B at the wave's vertices, and their indirect irradiance where no cache has it.
void RadiosityIntegrator::vertexValues(Wave& wave) const {
  wave.values.resize(wave.vertices.size());
  if (!wave.kept) return engine_.vertices(wave.vertices, wave.values);
  wave.vertexIndirect.resize(wave.vertices.size());
  thread_local std::vector<RadiosityEngine::Vertex> missing;
  thread_local std::vector<uint32_t> places;
  thread_local std::vector<Rgb> made;
  thread_local std::vector<RadiosityEngine::Irradiance> indirect;
  missing.clear(), places.clear();
  auto& kept = wave.kept->values;
  const auto put = [&](uint32_t k, const TileVertices::Value& value) {
    wave.values[k] = value.radiance, wave.vertexIndirect[k] = value.indirect;
  };
  for (uint32_t k = 0; k < wave.vertices.size(); ++k) {
    const auto found = kept.find(keyOf(wave.vertices[k]));
    if (found != kept.end())
      put(k, found->second);
    else
      missing.push_back(wave.vertices[k]), places.push_back(k);
  }
  made.resize(missing.size()), indirect.assign(missing.size(), {});
  engine_.vertices(missing, made, indirect);
  for (size_t i = 0; i < made.size(); ++i)
    put(places[i], kept.emplace(keyOf(missing[i]), TileVertices::Value{made[i], indirect[i]}).first->second);
}

}  // namespace patina
