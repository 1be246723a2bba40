// SPDX-License-Identifier: Apache-2.0
// Sorting lights by kind; picking one.
#include "renderer/integrators/light_list.h"

#include <algorithm>

#include "renderer/base/sampling.h"
#include "renderer/base/statistics.h"

namespace patina {
namespace {

STAT_COUNTER("Lights/lists", listCount);
STAT_COUNTER("Lights/lights in hierarchies", lightCount);
STAT_COUNTER("Lights/nodes of hierarchies", nodeCount);

}  // namespace

LightList::LightList(const Lights& lights, std::span<const uint32_t> wanted) {
  for (const uint32_t light : wanted) {
    switch (lights.kind(light)) {
      case PATINA_LIGHT_AMBIENT:
        ambient.push_back(light);
        break;
      case PATINA_LIGHT_AREA:
        area.push_back(light), sampled.push_back(light);
        break;
      case PATINA_LIGHT_DELTA:
        sampled.push_back(light), ++deltas;
        break;
      case PATINA_LIGHT_INFINITE:
        infinite.push_back(light);
        if (lights.isSmooth(light))
          smooth = true;
        else
          sampled.push_back(light);
        break;
      default:
        break;
    }
  }
  std::vector<LightBounds> bounds;
  for (const uint32_t light : sampled) bounds.push_back(lights.bounds(light));
  tree_ = LightTree(bounds);
  ++listCount;
  lightCount += static_cast<int64_t>(tree_.lights());
  nodeCount += static_cast<int64_t>(tree_.nodes());
}

bool LightList::sees(uint32_t light) const {
  return std::binary_search(area.begin(), area.end(), light) ||
         std::binary_search(infinite.begin(), infinite.end(), light);
}

LightTree::Pick LightList::pick(const LightReceiver& at, float u) const {
  const LightTree::Pick picked = tree_.pick(at, u);
  return {sampled[picked.light], picked.chance};
}

void LightList::pickMany(const LightReceiver& at, uint32_t n, float u,
                         std::vector<LightTree::Picks>& out) const {
  tree_.pickMany(at, n, u, out);
  for (LightTree::Picks& picks : out) picks.light = sampled[picks.light];
}

float LightList::chanceOf(const LightReceiver& at, uint32_t light) const {
  const auto found = std::lower_bound(sampled.begin(), sampled.end(), light);
  if (found == sampled.end() || *found != light) return 0;
  return tree_.chanceOf(at, static_cast<uint32_t>(found - sampled.begin()));
}

float LightList::weightOfMet(const LightReceiver& at, uint32_t light, float bsdfPdf, float lightPdf) const {
  const float chance = chanceOf(at, light);
  return chance > 0 ? misWeight(bsdfPdf, chance * lightPdf) : 1;
}

}  // namespace patina
