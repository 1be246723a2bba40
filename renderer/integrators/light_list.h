// SPDX-License-Identifier: Apache-2.0
// The lights that illuminate some primitives (Illuminate), by what integrators do with them.
#pragma once

#include <vector>

#include "renderer/shading/light_tree.h"
#include "renderer/shading/lights.h"

namespace patina {

struct LightList {
  std::vector<uint32_t> sampled;  ///< area, delta and infinite lights that are sampled for next-event
                                  ///< estimation, ascending as all of these
  int deltas = 0;                 ///< of `sampled`: found by no ray
  std::vector<uint32_t> ambient;
  std::vector<uint32_t> infinite;  ///< found by rays that leave the scene, smooth or not
  std::vector<uint32_t> area;      ///< found by rays that meet their geometry
  bool smooth = false;             ///< some infinite light is left to the surface's own samples

  LightList() = default;
  /// `wanted`: ascending.
  LightList(const Lights& lights, std::span<const uint32_t> wanted);

  bool sees(uint32_t light) const;  ///< whether an area or infinite light is on the list

  /// One of `sampled`, which must not be empty, for u in [0, 1): by what it seems to give to the point.
  LightTree::Pick pick(const LightReceiver& at, float u) const;
  /// n picks: see LightTree.
  void pickMany(const LightReceiver& at, uint32_t n, float u, std::vector<LightTree::Picks>& out) const;
  /// That pick() gives the light: 0 for lights that are not sampled, or cannot reach the point.
  float chanceOf(const LightReceiver& at, uint32_t light) const;
  /// What a BSDF's sample that met a light counts beside the light's own samples: the MIS weight, or 1 when
  /// the light is not sampled. Densities over solid angle; `lightPdf` is that of the light once it is picked,
  /// times the number of picks.
  float weightOfMet(const LightReceiver& at, uint32_t light, float bsdfPdf, float lightPdf) const;

 private:
  LightTree tree_;  ///< of `sampled`
};

}  // namespace patina
